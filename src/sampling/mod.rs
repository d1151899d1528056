//! Sampling what a store lacks, batch by batch, on a device whose failures end no run.

pub mod batches;
pub(crate) mod found;
pub mod plan;
pub mod tables;
pub mod worker;
