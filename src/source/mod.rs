//! TODO-DOC source

pub mod diagnose;
pub mod setting;
pub mod shown;
pub mod text_file;
