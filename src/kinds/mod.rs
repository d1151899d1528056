//! TODO-DOC kinds

pub mod allan;
pub mod drift_budget;
pub mod exact;
pub mod gap_fill;
pub mod relock;
pub mod suspension;
pub mod switched_run;
