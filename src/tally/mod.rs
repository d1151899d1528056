//! TODO-DOC tally

pub mod block;
pub mod id;
pub mod share;
pub mod stats;
