//! TODO-DOC sampling

pub mod sampling;
pub mod worker;
