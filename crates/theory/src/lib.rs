//! Closed forms in f64, from which the Monte Carlo studies are lowered and with which they are compared.

#![deny(missing_docs)]
#![warn(unreachable_pub)]

pub mod allan;
pub mod cholesky;
pub mod double;
pub mod drift;
pub mod gap;
pub mod lattice;
pub mod level;
pub mod lines;
pub mod lock_in;
pub mod memo;
pub mod minimum_variance;
pub mod navigation;
pub mod psd;
pub mod published;
pub mod pulse;
pub mod quadrature;
pub mod relock;
pub mod rows;
pub mod suspension;
