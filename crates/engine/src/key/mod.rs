//! Keys of study files. One row declares everything known of a key.

pub mod common;
pub mod explained;
pub(crate) mod given;
pub mod holds;
pub(crate) mod places;
pub mod precision;
pub(crate) mod reading;
pub mod refusal;
pub mod renamed;
pub mod row;
pub mod scale;
pub(crate) mod schema;
pub mod sensitivity;
pub mod setting;
pub mod sweep;
pub(crate) mod table;
