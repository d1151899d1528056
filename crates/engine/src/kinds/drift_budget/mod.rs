//! Studies of the drift budget: the paper's bound, its optimum, and the true drift of a run, in closed form.

use core::convert::identity;
use core::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

use crate::chart::{Source, TableSchema};
use crate::drift::{self, Drift, END, End, RESIDUAL_MAX, SCHEDULE_SETTINGS, Schedule};
use crate::key::document::SpanMap;
use crate::key::sweep::{Sweep, Sweepable, SweepValue};
use crate::key::{Key, ParseContext};
use crate::kinds::plan::{ClosedFormPlan, table};
use crate::sampling::Planned;
use crate::study::{self, Ablation, Kind, Part, Study, Subject};
use sagnac_base::diagnostics::{Fault, Wrong};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::Dimension;
use sagnac_base::table::column::abouts;
use sagnac_base::table::{Cell, ColumnOf, Role, Unit, Usual};
use sagnac_theory::drift::budget::{Bound, Budget, Optimum, limit_as_published};
use sagnac_theory::drift::{Ending, Magnetic, Spread, switches};

/// The part of a study that is specific to the drift budget.
#[derive(Debug, Clone)]
pub(crate) struct DriftBudget {
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<Point>,
    /// The inputs that all points have in common.
    base: Point,
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Point {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, SweepValue)>,
    /// The parts of the drift.
    pub drift: Drift,
    /// Interval and duration.
    pub schedule: Schedule,
}

/// Every key of this kind; a budget has no spreads.
fn keys() -> Vec<&'static Key> {
    [drift::KEYS, drift::SCHEDULE_KEYS].concat()
}

/// The keys that can be swept.
fn sweepable() -> Sweepable<Point> {
    Sweepable::new()
        .part(&drift::SETTINGS, |point: &mut Point| Some(&mut point.drift))
        .part(&SCHEDULE_SETTINGS, |point| Some(&mut point.schedule))
}

/// Reads the part of a study that belongs to this kind.
fn read(reading: &mut ParseContext) -> Result<DriftBudget, Wrong> {
    reading.table.needed(&RESIDUAL_MAX)?;
    let (mut drift, mut schedule) = (Drift::default(), Schedule::default());
    reading.set(&mut drift, &drift::SETTINGS)?;
    reading.set(&mut schedule, &SCHEDULE_SETTINGS)?;
    schedule.end = End::from_value(reading.get(&END));
    Ok(Point { swept: vec![], drift, schedule }.with_points(reading.sweeps, &reading.places)?)
}

impl Point {
    /// The study whose points have these inputs, but for some sweeps.
    ///
    /// # Errors
    /// The first point that is invalid.
    fn with_points(self, sweeps: &[Sweep], places: &SpanMap) -> Result<DriftBudget, Fault> {
        let point = |(swept, point): (Vec<_>, Point)| {
            point.schedule.check(places)?;
            Ok(Point { swept, ..point })
        };
        let points = sweepable().points(&self, sweeps).map(point).collect::<Result<_, Fault>>()?;
        Ok(DriftBudget { points, base: self })
    }
}

/// The bound of the drift of a gyro that switches modes, and the switching interval at which it is least.
pub(crate) static DRIFT_BUDGET: Kind = Kind {
    name: "drift-budget",
    subject: "The bound of the drift of a gyro that switches modes, and the switching interval at which it is least, in closed form.",
    about: "Samples nothing: formulas of the drift of a gyro that switches modes. points.csv has the paper's `bound`, Z(7), the \
            true drift of a run, `mean_drift` and `rms_drift`, and the intervals at which these are least, `optimum` and \
            `optimum_true`.",
    template: include_str!("template.toml"),
    is_exact: true,
    trials: 1_000_000,
    needs: &["drift", "switching", "run"],
    keys,
    sweepable: || {
        let swept = sweepable().keys().into_iter();
        swept.filter(|key| keys().iter().any(|known| known.name == key.name)).collect()
    },
    columns: &[(Source::Points, || abouts(&columns()))],
    kernels: || "none".to_owned(),
    loads: Vec::new,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

impl Subject for DriftBudget {
    fn plan<'a>(&'a self, study: &'a Study, _: &dyn Progress) -> Planned<'a> {
        let rows: Vec<Row> = self.points.iter().map(Row::new).collect();
        Ok(Some(Box::new(ClosedFormPlan(table(&study.sweeps, &columns(), &rows, |row| &row.point.swept)))))
    }

    fn dissected(&self, point: usize) -> Option<Ablation> {
        let point = self.points.get(point)?;
        let (parts, drifts) = study::points(&point.drift, &PARTS);
        let points = drifts.into_iter().map(|drift| Point { drift, ..point.clone() }).collect();
        Some(Ablation { parts, subject: Arc::new(DriftBudget { points, ..self.clone() }) })
    }

    fn with_points(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<Arc<dyn Subject>, Fault> {
        Ok(Arc::new(self.base.clone().with_points(sweeps, places)?))
    }

    fn grounds(&self) -> Vec<TableSchema> {
        vec![TableSchema {
            legend: ["", ""],
            ..TableSchema::new(Source::Points, abouts(&columns()), [], &[Dimension::Rate, Dimension::Time])
        }]
    }
}

/// All parts.
static PARTS: [Part<Drift>; 3] = [
    Part { name: "magnetic drift", off: |drift| (drift.magnetic, drift.initial_magnetic) = (0.0, 0.0) },
    Part { name: "non-magnetic drift", off: |drift| drift.non_magnetic = 0.0 },
    Part { name: "residuals of the switches", off: |drift| drift.residual_max = 0.0 },
];

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    pub(crate) point: &'a Point,
    budget: Budget,
    spread: Spread,
    bound: Bound,
    optimum: Option<Optimum>,
    interval_s: f64,
    t_s: f64,
    /// The equally likely times at which the run ends, s.
    ends: Vec<f64>,
}

impl<'a> Row<'a> {
    pub(crate) fn new(point: &'a Point) -> Row<'a> {
        let (interval_s, t_s) = (point.schedule.interval_s, point.schedule.duration_s);
        let (magnetic, non_magnetic) = (point.drift.magnetic_drift(), point.drift.non_magnetic);
        let residual_max = point.drift.residual_max;
        let budget = Budget { magnetic, non_magnetic, residual_max };
        // The rms of a sine of the phase at which the switch comes.
        let spread = Spread { magnetic, non_magnetic, residual_rms: residual_max * FRAC_1_SQRT_2 };
        let (bound, optimum) = (budget.bound(interval_s, t_s), budget.optimum(t_s));
        Row { point, budget, spread, bound, optimum, interval_s, t_s, ends: point.schedule.ends() }
    }

    /// Mean and rms drift of a gyro whose residuals add up to `times` that of one switch.
    fn over(&self, spread: Spread, times: fn(f64) -> f64) -> [f64; 2] {
        spread.over(self.interval_s, self.t_s, &self.ends, times)
    }

    /// The gyro with the first mode negative.
    fn negative(&self) -> Spread {
        let Magnetic { amplitude, time_s, initial } = self.spread.magnetic;
        let magnetic = Magnetic { amplitude: -amplitude, time_s, initial: -initial };
        Spread { magnetic, ..self.spread }
    }

    /// The gyro without its non-magnetic drift.
    fn switched(&self) -> Spread {
        Spread { non_magnetic: 0.0, ..self.spread }
    }

    fn ending(&self) -> Ending {
        match self.point.schedule.end {
            End::Any => Ending::Any,
            End::Exact => Ending::Even,
        }
    }
}

/// The columns except the swept keys, in the order of the file.
#[rustfmt::skip]
fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    const RATE: Unit = Unit::ARCSEC_PER_S;
    vec![
        Of::new("bound", RATE, "drift: bound, Z(7)", |row| row.bound.total().into())
            .is(Role::Error, "The paper's bound on the drift of the run, ″/s, Z(7): the sum of its four parts.")
            .usual(Usual::Estimate),
        Of::new("bound_non_magnetic", RATE, "drift: bound, non-magnetic", |row| row.bound.non_magnetic.into())
            .is(Role::Error, "The non-magnetic part of `bound`, ″/s."),
        Of::new("bound_quasi_non_magnetic", RATE, "drift: bound, quasi-non-magnetic", |row| row.bound.quasi_non_magnetic.into())
            .is(Role::Error, "The quasi-non-magnetic part of `bound`, ″/s: the remainder of the warm-up over a pair of modes, Z(6)."),
        Of::new("bound_magnetic", RATE, "drift: bound, magnetic", |row| row.bound.magnetic.into())
            .is(Role::Error, "The magnetic part of `bound`, ″/s: an odd interval without its partner."),
        Of::new("bound_residual", RATE, "drift: bound, residuals", |row| row.bound.residual.into())
            .is(Role::Error, "The part of `bound` from residuals of switches, ″/s."),
        Of::new("switches", Unit::NONE, "switches", |row| Cell::Integer(switches(row.interval_s, row.t_s) as i64))
            .is(Role::Count, "Switches within the run."),
        Of::new("mean_drift", RATE, "drift: mean, first mode positive", |row| row.over(row.spread, libm::sqrt)[0].into())
            .is(Role::Estimate, "True drift of a run, ″/s, with the magnetic drift positive in the first mode, averaged over the phase of \
                                 switching at the end unless `run.end` is `exact`."),
        Of::new("mean_drift_negative", RATE, "drift: mean, first mode negative", |row| row.over(row.negative(), libm::sqrt)[0].into())
            .is(Role::Estimate, "The same with the magnetic drift negative in the first mode, ″/s."),
        Of::new("magnetic_angle", Unit::ARCSEC, "angle: magnetic, first mode positive", |row| {
            (row.over(row.switched(), libm::sqrt)[0] * row.t_s).into()
        })
        .is(Role::Estimate, "Mean angle of the magnetic drift at the end of the run, ″, signed, with the first mode positive."),
        Of::new("switching_drift", RATE, "drift: left by switching", |row| {
            row.over(Spread { residual_rms: 0.0, ..row.switched() }, libm::sqrt)[1].into()
        })
        .is(Role::Error, "Root mean square over the ends of what switching leaves of the magnetic drift, ″/s."),
        Of::new("rms_drift", RATE, "drift: rms, random phases", |row| row.over(row.spread, libm::sqrt)[1].into())
            .is(Role::Error, "Root mean square drift, ″/s, with residuals of δP_max/√2 at switches of random phase, which add up as √n."),
        Of::new("rms_drift_in_phase", RATE, "drift: rms, one phase", |row| row.over(row.spread, identity)[1].into())
            .is(Role::Error, "The same with residuals of one phase, which add up as n, ″/s."),
        Of::new("rms_switching", RATE, "drift: left by switching, rms", |row| row.over(row.switched(), libm::sqrt)[1].into())
            .is(Role::Error, "`rms_drift` without the non-magnetic drift, ″/s: the part that depends on the choice of the interval."),
        Of::new("optimum", Unit::S, "best interval: bound, Z(8)", |row| row.optimum.map(|best| best.interval_s).into())
            .is(Role::Estimate, "The interval with the least bound, s: the root of Z(8).")
            .usual(Usual::Answer),
        Of::new("optimum_bound", RATE, "drift: least bound, Z(7)", |row| row.optimum.map(|best| best.bound).into())
            .is_of("optimum", Role::Least, "The bound at that interval, ″/s."),
        Of::new("optimum_as_published", Unit::S, "best interval: Z(9) as published", |row| row.budget.optimum_as_published(row.t_s).into())
            .is(Role::Estimate, "The smaller root of Z(9) as printed, s; blank where Z(9) has no root."),
        Of::new("optimum_expanded", Unit::S, "best interval: Z(9) corrected", |row| row.budget.optimum_expanded(row.t_s).into())
            .is(Role::Estimate, "The root of the corrected Z(9), s."),
        Of::new("optimum_limit", Unit::S, "best interval: limit as published", |row| limit_as_published(&row.budget, row.t_s).into())
            .is(Role::Estimate, "√(δP_max t/Ω_m) as printed, s; blank without residuals."),
        Of::new("optimum_limit_small", Unit::S, "best interval: limit corrected", |row| row.budget.limit(row.t_s).into())
            .is(Role::Estimate, "The corrected limit for a small A or a large τ, s; blank without residuals."),
        Of::new("optimum_true", Unit::S, "best interval: rms drift", |row| row.spread.best_interval(row.t_s, row.ending()).into())
            .is(Role::Estimate, "The interval with the least `rms_switching`, s; if `run.end` is `exact`, among those of which an even \
                                 number makes the run. Blank where it would be longer than half the run, or not far below τ."),
        Of::new("optimum_true_rms", RATE, "drift: least rms left by switching", |row| row.spread.least_rms(row.t_s, row.ending()).into())
            .is_of("optimum_true", Role::Least, "`rms_switching` at that interval, ″/s."),
    ]
}
