//! Recorded data of gyroscopes and accelerometers: readers of logs, Allan deviations, spectra, fits of noise coefficients, and
//! what a record holds besides noise.
//!
//! ```text
//! file ─ record ─▶ values, rate, gaps ─┬─ allan ─▶ deviations ─ fit ─▶ noise coefficients
//!                                      ├─ spectrum ─▶ density, lines
//!                                      └─ events ─▶ steps, bursts, slow changes
//! ```

#![deny(missing_docs)]
#![warn(unreachable_pub)]

pub mod allan;
pub mod events;
pub mod fit;
pub mod record;
pub mod spectrum;
