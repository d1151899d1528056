//! Sampling of the trials that a store lacks, batch by batch, on a device whose failures do not end a run.

pub mod batches;
pub(crate) mod found;
pub mod plan;
pub mod tables;
pub(crate) mod trials;
pub mod worker;
