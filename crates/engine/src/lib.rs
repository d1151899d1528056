//! Studies of laser gyroscopes from their text to their tables: keys and kinds, lowering to integers, sampling on processors and GPUs,
//! and the store of results.
//!
//! ```text
//! text ─ kinds ─▶ Study ─ lower ─▶ integers ─ sampling on a device ─▶ tallies ─ store ─▶ tables
//! ```

#![deny(missing_docs)]

pub use sagnac_base::{diagnostics, progress, quantity, table, text_file};
pub use sagnac_kernel as kernel;

pub mod chart;
pub mod device;
pub mod drift;
pub mod filler;
pub mod key;
pub mod kinds;
pub mod motion;
pub mod noise;
pub mod run;
pub mod sampling;
pub mod store;
pub mod study;
pub mod tally;
pub mod verify;
