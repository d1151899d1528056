//! A text with places in it, and faults that are told with their place.

pub mod diagnose;
pub mod place;
pub mod setting;
pub mod shown;
pub mod text_file;
