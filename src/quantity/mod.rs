//! Dimensions, units and quantities, and how numbers are written.

pub mod error;
pub(crate) mod expression;
pub mod list;
pub mod number;
pub(crate) mod unit;
pub mod units;
pub mod visible;
