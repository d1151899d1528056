//! Sampling what a store lacks, batch by batch, on a device whose failures end no run.

pub(crate) mod found;
pub mod plan;
pub mod sampling;
pub mod worker;
