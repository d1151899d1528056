//! The drift budget at a point: bound, true drift, and all that is said of the best interval.

use core::f64::consts::FRAC_1_SQRT_2;

use crate::kinds::drift_budget::Point as BudgetPoint;
use crate::run::column;
use crate::table::{Cell, Column, Unit};
use crate::theory::drift::approximation::limit_as_published;
use crate::theory::drift::budget::Budget;
use crate::theory::drift::magnetic::switches;
use crate::theory::drift::spread::Spread;

pub(crate) fn columns() -> Vec<Column> {
    let drift = |name: &str, label: &str| column(name, &format!("drift: {label}"), Unit::ARCSEC_PER_S);
    let optimum = |name: &str, label: &str| column(name, &format!("best interval: {label}"), Unit::S);
    vec![
        drift("bound", "bound, Z(7)"),
        drift("bound_non_magnetic", "bound, non-magnetic"),
        drift("bound_quasi_non_magnetic", "bound, quasi-non-magnetic"),
        drift("bound_magnetic", "bound, magnetic"),
        drift("bound_residual", "bound, residuals"),
        column("switches", "switches", Unit::NONE),
        drift("mean_drift", "mean, first mode positive"),
        drift("mean_drift_negative", "mean, first mode negative"),
        column("magnetic_angle", "angle: magnetic, first mode positive", Unit::ARCSEC),
        drift("switching_drift", "left by switching"),
        drift("rms_drift", "rms, random phases"),
        drift("rms_drift_in_phase", "rms, one phase"),
        drift("rms_switching", "left by switching, rms"),
        optimum("optimum", "of the bound, Z(8)"),
        drift("optimum_bound", "least bound, Z(7)"),
        optimum("optimum_as_published", "Z(9) as published"),
        optimum("optimum_expanded", "Z(9) put right"),
        optimum("optimum_limit", "limit as published"),
        optimum("optimum_limit_small", "limit put right"),
        optimum("optimum_true", "of the rms drift"),
        drift("optimum_true_rms", "least rms left by switching"),
    ]
}

pub(crate) fn row(point: &BudgetPoint) -> Vec<Cell> {
    let (interval_s, t_s) = (point.schedule.interval_s, point.schedule.duration_s);
    let (magnetic, non_magnetic) = (point.drift.magnetic_drift(), point.drift.non_magnetic);
    let residual_max = point.drift.residual_max;
    let budget = Budget { magnetic, non_magnetic, residual_max };
    // A sine of the phase at which the switch comes.
    let spread = Spread { magnetic, non_magnetic, residual_rms: residual_max * FRAC_1_SQRT_2 };
    let bound = budget.bound(interval_s, t_s);
    let mean = spread.mean(interval_s, t_s, true);
    let left = mean - non_magnetic;
    let deviation = spread.deviation(interval_s, t_s);
    let in_phase = spread.deviation_in_phase(interval_s, t_s);
    let optimum = budget.optimum(t_s);
    let drift = [bound.total(), bound.non_magnetic, bound.quasi_non_magnetic, bound.magnetic, bound.residual];
    let of_run = [
        mean,
        spread.mean(interval_s, t_s, false),
        magnetic.signed_integral(interval_s, t_s),
        left.abs(),
        libm::hypot(mean, deviation),
        libm::hypot(mean, in_phase),
        libm::hypot(left, deviation),
    ];
    let best = [
        optimum.map(|optimum| optimum.interval_s),
        optimum.map(|optimum| optimum.bound),
        budget.optimum_as_published(t_s),
        budget.optimum_expanded(t_s),
        limit_as_published(&budget, t_s),
        budget.limit(t_s),
        spread.best_interval(t_s),
        spread.least_rms(t_s),
    ];
    let mut cells: Vec<Cell> = drift.map(|x| Some(x).into()).to_vec();
    cells.push(Cell::Integer(switches(interval_s, t_s) as i64));
    cells.extend(of_run.map(|x| Cell::from(Some(x))));
    cells.extend(best.map(Cell::from));
    cells
}
