//! Closed forms in f64, from which the Monte Carlo studies are lowered and with which they are compared.

#![deny(missing_docs)]
#![warn(unreachable_pub)]

pub mod allan;
pub mod cholesky;
pub mod drift;
pub mod gap;
pub mod lines;
pub mod lock_in;
pub mod minimum_variance;
pub mod navigation;
pub mod pulse;
pub mod quadrature;
pub mod quantile;
pub mod relock;
pub mod vibration;
