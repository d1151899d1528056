//! TODO-DOC view

pub mod chart;
pub mod picture;
pub mod report;
pub mod verdict;
