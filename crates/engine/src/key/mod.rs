//! Keys of study files. One row declares everything known of a key.

pub mod docs;
pub(crate) mod document;
pub mod row;
pub mod sensitivity;
pub mod sweep;
