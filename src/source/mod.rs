//! Texts with places in them, and faults reported with their place.

pub mod diagnose;
pub(crate) mod place;
pub mod setting;
pub(crate) mod text_file;
