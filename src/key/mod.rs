//! TODO-DOC key

pub mod expected;
pub mod explained;
pub mod file;
pub mod scalar;
pub mod setting;
pub mod sweep;
