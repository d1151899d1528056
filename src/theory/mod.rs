//! Closed forms in f64, from which the Monte Carlo studies are lowered and with which they are compared.

pub mod allan;
pub mod cholesky;
pub mod double;
pub mod drift;
pub mod gap;
pub(crate) mod lattice;
pub mod level;
pub mod lines;
pub mod lock_in;
pub(crate) mod memo;
pub mod minimum_variance;
pub mod navigation;
pub mod psd;
pub mod published;
pub(crate) mod pulse;
pub mod quadrature;
pub mod relock;
pub mod rows;
pub mod suspension;
