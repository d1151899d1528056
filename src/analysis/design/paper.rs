//! The choice of the paper's rule: the interval at which the bound Z(7) is least.

use crate::analysis::design::Tried;
use sagnac_engine::kinds::switched_run::lower::FilledRun;
use sagnac_engine::kinds::switched_run::point::Point as RunPoint;
use sagnac_theory::drift::budget::{Budget, Optimum};

/// The paper's choice.
#[derive(Debug, Clone, PartialEq)]
pub struct PapersRule {
    /// The interval at which the bound has its minimum, s.
    pub interval_s: f64,
    /// Z(7) at that interval, ″/s.
    pub bound: f64,
    /// The result at that interval.
    pub tried: Tried,
}

/// The minimum of the bound for a filler; `None` where switching costs nothing.
pub(crate) fn optimum(point: &RunPoint, filled: &FilledRun) -> Option<Optimum> {
    let residual_max = filled.residual_max();
    let drift = &point.drift;
    let budget = Budget { magnetic: drift.magnetic_drift(), non_magnetic: drift.non_magnetic, residual_max };
    budget.optimum(point.schedule.duration_s)
}
