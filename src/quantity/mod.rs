//! Dimensions, units and quantities, and how numbers are written.

pub mod expression;
pub mod number;
pub mod units;
