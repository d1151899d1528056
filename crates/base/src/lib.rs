//! What every part of sagnac is built on: quantities with units, tables of results, texts with places in them, enums of words,
//! progress and time.
//!
//! ```
//! use sagnac_base::quantity::units::{Dimension, parse};
//!
//! let frequency = parse("20 Hz", &[Dimension::Frequency])?;
//! assert_eq!(frequency.value, 20.0);
//! # Ok::<(), sagnac_base::quantity::error::UnitError>(())
//! ```

#![deny(missing_docs)]

pub mod progress;
pub mod quantity;
pub mod scale;
pub mod source;
pub mod stopwatch;
pub mod table;
pub mod words;
