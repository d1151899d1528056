//! TODO-DOC analysis

pub mod compare;
pub mod design;
pub mod firmware;
