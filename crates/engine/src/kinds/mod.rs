//! The kinds of study, each in a folder with everything specific to it.
//!
//! The rest of the library knows them only as entries of [`KINDS`].

pub mod allan;
pub(crate) mod drift_budget;
pub(crate) mod elsewhere;
pub(crate) mod exact;
pub mod gap_fill;
pub(crate) mod gyro;
pub mod keys;
pub mod lock_in;
pub mod navigation;
pub(crate) mod plan;
mod read;
pub mod relock;
pub(crate) mod suspension;
pub mod switched_run;
pub mod table;
#[cfg(test)]
mod tests;

use crate::study::kind::Kind;

/// Every kind of study.
pub static KINDS: [&Kind; 8] = [
    &gap_fill::kind::GAP_FILL,
    &allan::kind::ALLAN,
    &switched_run::kind::SWITCHED_RUN,
    &relock::kind::RELOCK,
    &lock_in::kind::LOCK_IN,
    &drift_budget::kind::DRIFT_BUDGET,
    &suspension::kind::SUSPENSION,
    &navigation::kind::NAVIGATION,
];
