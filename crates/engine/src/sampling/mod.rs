//! Sampling of the trials that a store lacks, batch by batch, on a device whose failures do not end a run.

pub(crate) mod batches;
pub(crate) mod found;
pub(crate) mod plan;
pub(crate) mod records;
pub(crate) mod tables;
pub mod worker;
pub(crate) mod writer;
