//! Texts with places in them, and faults reported with their place.

pub mod diagnose;
pub mod place;
pub mod setting;
pub mod text_file;
