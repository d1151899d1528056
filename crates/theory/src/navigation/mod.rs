//! From the errors of gyros to the errors of a navigator: linear functionals of their records.
//!
//! For small errors the error of a navigator is e(T) = ∫ h(t) ε(t) dt for each gyro with the rate error ε. For a record of
//! angle increments this is Σ w_k Δθ_k, where w_k is the mean of h over sample k. [`equations`] has the error equations of
//! a strapdown in local-level axes, [`weights()`] solves their adjoint for the w_k, [`covariance`] gives wᵀCw for each noise
//! of a record, and [`radial`] the levels of the resulting errors. [`filter`] has the weights of a Kalman filter.

pub mod covariance;
pub mod equations;
pub mod filter;
pub mod radial;
pub mod weights;

pub use crate::navigation::equations::{GRAVITY, Leg, RADIUS};
pub use crate::navigation::weights::{Error, Gyro, Task, Weights, weights};
