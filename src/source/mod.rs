//! Texts with places in them, faults reported with their place, and the files from which texts are read.

pub mod text_file;

pub use sagnac_base::source::{diagnose, place, setting};
