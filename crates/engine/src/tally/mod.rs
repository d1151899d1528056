//! Tallies: blocks of trials, shares of a study, identities, and statistics of exact sums.

pub(crate) mod binomial;
pub mod block;
pub mod id;
pub mod share;
pub mod stats;
