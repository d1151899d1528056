//! Dimensions, units and quantities, and how numbers are written.

pub mod error;
pub mod expression;
pub mod list;
pub mod number;
pub mod unit;
pub mod units;
pub mod visible;
