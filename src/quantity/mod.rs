//! TODO-DOC quantity

pub mod expression;
pub mod number;
pub mod units;
