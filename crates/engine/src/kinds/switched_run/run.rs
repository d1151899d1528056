//! The columns of a study of whole runs, with a row for each point, filler and angle, and its run with the table of
//! trajectories.
//!
//! Trajectories are few and made on the processor, whatever the device, because the bits are the same.

use crate::drift::End;
use crate::filler::{FILLERS, LISTED};
use crate::kinds;
use crate::kinds::gap_fill::columns::FILLER;
use crate::kinds::plan::{Lacking, Launched, PointsPlan, Tabulated, table};
use crate::kinds::switched_run::lower::{FilledRun, LoweredRun, RunEstimate};
use crate::kinds::switched_run::point::{Point, Point as RunPoint};
use crate::kinds::switched_run::{Angle, SwitchedRun};
use crate::sampling::batches::{Work, estimates};
use crate::sampling::{self, RowEstimates, RunError, Tables};
use crate::store::error::StoreError;
use crate::store::{Address, Row as StoredRow, Store};
use crate::tally::{Block, Id, Share, missing, z_score};
use sagnac_base::table::column::Band;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit, Usual};
use sagnac_kernel::moments::MAX_ESTIMATES;
use sagnac_kernel::rows::Rows;
use sagnac_kernel::switched_run::trajectory;
use sagnac_theory::drift::switches;

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    pub(crate) point: &'a Point,
    pub(crate) filler: Option<&'a str>,
    pub(crate) filled: &'a FilledRun,
    pub(crate) estimate: &'a RunEstimate,
    pub(crate) found: RowEstimates,
}

impl Row<'_> {
    /// Time at which the angle is read, s; the largest angle comes at a different time in each run.
    fn time_s(&self) -> Option<f64> {
        match self.estimate.angle {
            Angle::End => Some(self.point.schedule.duration_s),
            Angle::At(time_s) => Some(time_s),
            Angle::Largest => None,
        }
    }

    /// Number of switches before the time of the row, or of all switches.
    fn switches(&self) -> i64 {
        match self.estimate.angle {
            Angle::At(time_s) => switches(self.point.schedule.interval_s, time_s) as i64,
            Angle::End | Angle::Largest => self.point.switches() as i64,
        }
    }

    /// An angle divided by the time.
    fn drift(&self, angle: Option<f64>) -> Cell {
        angle.zip(self.time_s()).map(|(angle, time)| angle / time).into()
    }

    fn drift_band(&self, angles: Band) -> Band {
        angles.zip(self.time_s()).map(|(band, time)| (band.0 / time, band.1 / time))
    }

    fn theory_mean(&self) -> Option<f64> {
        Some(self.estimate.theory?.mean)
    }

    fn theory_rms(&self) -> Option<f64> {
        Some(self.estimate.theory?.rms())
    }

    fn z(&self) -> Option<f64> {
        self.found.z(self.theory_rms(), self.estimate.theory?.rounding)
    }

    fn z_mean(&self) -> Option<f64> {
        let (found, theory) =
            self.found.estimates.zip(self.estimate.theory).filter(|_| self.found.trials > 1)?;
        let se = theory.deviation / libm::sqrt(self.found.trials as f64);
        z_score(found.mean, theory.mean, se, theory.rounding)
    }
}

/// The column of fillers.
const fn filler<R>(cell: fn(&R) -> Cell) -> ColumnOf<R> {
    ColumnOf::new("filler", Unit::NONE, "filler", cell).is_of(FILLERS, Role::Key, FILLER).styled(LISTED)
}

/// The columns except the swept keys, in the order of the file, with that of fillers where the runs have any.
#[rustfmt::skip]
pub(crate) fn columns<'a>(has_fillers: bool) -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    let filler = has_fillers.then(|| filler(|row: &Row| row.filler.map_or(Cell::Blank, Cell::from)).brief());
    filler.into_iter().chain([
        Of::new("angle", Unit::NONE, "angle", |row| Cell::Text(row.estimate.angle.name()))
            .is(Role::Key, "The angle: `end` of the run, averaged over the phase of switching unless `run.end` is `exact`; `largest` (just before \
                             or after a switch or at the end), `at 600 s`.")
            .brief(),
        Of::new("time", Unit::S, "time in the run", |row| row.time_s().into())
            .is(Role::Coordinate, "Time at which the angle is read, s: for the end the run time; blank for the largest angle."),
        Of::new("switches", Unit::NONE, "switches", |row| Cell::Integer(row.switches()))
            .is(Role::Count, "Switches before the time of the row, which may be one more or less in a run that ends at any phase of switching.")
            .brief(),
        Of::new("residual_rms", Unit::ARCSEC, "rms residual of a switch", |row| row.filled.residual_rms().into())
            .is(Role::Error, "Rms residual of one switch, with its relock, ″."),
        Of::new("trials", Unit::NONE, "trials", |row| row.found.trials.into())
            .is(Role::Trials, "Number of runs behind the estimates of the row."),
        Of::new("mean", Unit::ARCSEC, "mean error of the angle", |row| row.found.cell(|found| found.mean))
            .is(Role::Estimate, "Mean error of the angle, ″, with its sign.")
            .brief()
            .within(|row| row.found.mean_band()),
        Of::new("rms", Unit::ARCSEC, "rms error of the angle", |row| row.found.cell(|found| found.rms))
            .is(Role::Error, "Root mean square error of the angle, ″.")
            .within(|row| row.found.rms_band()),
        Of::new("rms_se", Unit::ARCSEC, "standard error of the rms", |row| row.found.rms_se().into())
            .is_of("rms", Role::StandardError, sampling::RMS_SE),
        Of::new("max", Unit::ARCSEC, "largest error seen", |row| row.found.cell(|found| found.max))
            .is(Role::Error, "The largest magnitude of an error of the angle among the runs, ″."),
        Of::new("p99_73", Unit::ARCSEC, "99.73 % error of the angle", |row| row.found.level(|q| Some(q.value)).into())
            .is(Role::Error, "The level, ″, below which the error of the angle stays in magnitude in 99.73 % of runs.")
            .within(|row| row.found.level_band()),
        Of::new("p99_73_lo", Unit::ARCSEC, "99.73 % error of the angle (lower)", |row| row.found.level(|q| q.low).into())
            .is_of("p99_73", Role::Lower, sampling::LEVEL_LOWER),
        Of::new("p99_73_hi", Unit::ARCSEC, "99.73 % error of the angle (upper)", |row| row.found.level(|q| q.high).into())
            .is_of("p99_73", Role::Upper, sampling::LEVEL_UPPER),
        Of::new("drift_mean", Unit::DEG_PER_H, "mean drift", |row| row.drift(row.found.value(|found| found.mean)))
            .is(Role::Estimate, "`mean` divided by the time, °/h; blank for the largest angle.")
            .brief()
            .within(|row| row.drift_band(row.found.mean_band())),
        Of::new("drift_rms", Unit::DEG_PER_H, "rms drift", |row| row.drift(row.found.value(|found| found.rms)))
            .is(Role::Error, "`rms` divided by the time, °/h; blank for the largest angle.")
            .brief()
            .within(|row| row.drift_band(row.found.rms_band())),
        Of::new("drift_p99_73", Unit::DEG_PER_H, "99.73 % drift", |row| row.drift(row.found.level(|q| Some(q.value))))
            .is(Role::Error, "`p99_73` divided by the time, °/h: 99.73 % of runs drift by less. Blank for the largest angle.")
            .brief()
            .usual(Usual::Estimate)
            .within(|row| row.drift_band(row.found.level_band())),
        Of::new("drift_p99_73_lo", Unit::DEG_PER_H, "99.73 % drift (lower)", |row| row.drift(row.found.level(|q| q.low)))
            .is_of("drift_p99_73", Role::Lower, "Lower end of the 95 % interval of `drift_p99_73`, °/h."),
        Of::new("drift_p99_73_hi", Unit::DEG_PER_H, "99.73 % drift (upper)", |row| row.drift(row.found.level(|q| q.high)))
            .is_of("drift_p99_73", Role::Upper, "Upper end of the 95 % interval of `drift_p99_73`, °/h."),
        Of::new("theory_mean", Unit::ARCSEC, "mean error of the angle (closed form)", |row| row.theory_mean().into())
            .is_of("mean", Role::Theory, "`mean` in closed form, ″; blank for the largest angle."),
        Of::new("theory_rms", Unit::ARCSEC, "rms error of the angle (closed form)", |row| row.theory_rms().into())
            .is_of("rms", Role::Theory, "`rms` in closed form, ″; blank for the largest angle."),
        Of::new("theory_drift_mean", Unit::DEG_PER_H, "mean drift (closed form)", |row| row.drift(row.theory_mean()))
            .is_of("drift_mean", Role::Theory, "`drift_mean` in closed form, °/h."),
        Of::new("theory_drift_rms", Unit::DEG_PER_H, "rms drift (closed form)", |row| row.drift(row.theory_rms()))
            .is_of("drift_rms", Role::Theory, "`drift_rms` in closed form, °/h."),
        Of::new("z_mean", Unit::NONE, "deviation of the mean from the closed form, standard errors", |row| row.z_mean().into())
            .is_of("mean", Role::Z, "Deviation of `mean` from `theory_mean` in standard errors; beyond ±5 something is wrong."),
        Of::new("z", Unit::NONE, "deviation of the rms from the closed form, standard errors", |row| row.z().into())
            .is_of("rms", Role::Z, sampling::Z),
        Of::new("representation", Unit::NONE, "representation", |row| row.estimate.representation.into())
            .is_of("rms", Role::Representation, sampling::REPRESENTATION),
    ])
    .collect()
}

/// A row of the trajectories before it becomes cells.
pub(crate) struct Moment<'a> {
    pub(crate) point: &'a Point,
    pub(crate) filler: Option<&'a str>,
    pub(crate) run: u64,
    pub(crate) time_s: f64,
    /// Angle, ″; absent before anything is computed.
    pub(crate) angle: Option<f64>,
}

/// The columns of trajectories besides swept keys; that of fillers where the runs have any.
#[rustfmt::skip]
pub(crate) fn trajectory_columns<'a>(has_fillers: bool) -> Vec<ColumnOf<Moment<'a>>> {
    type Of<'a> = ColumnOf<Moment<'a>>;
    let filler = has_fillers.then(|| filler(|row: &Moment| row.filler.map_or(Cell::Blank, Cell::from)));
    filler.into_iter().chain([
        Of::new("run", Unit::NONE, "run", |row| Cell::Text(row.run.to_string()))
            .is(Role::Key, "Number of the run, from 1; the first runs sampled are kept."),
        Of::new("time", Unit::S, "time in the run", |row| row.time_s.into())
            .is(Role::Coordinate, "Time in the run, s."),
        Of::new("error", Unit::ARCSEC, "error of the angle", |row| row.angle.into())
            .is(Role::Estimate, "Error of the angle at that time, ″."),
    ])
    .collect()
}

/// The plan of a study of whole runs.
pub(crate) type Plan<'a> = PointsPlan<'a, SwitchedRun, LoweredRun>;

impl Launched for LoweredRun {
    fn id(&self) -> Id {
        self.id
    }

    fn addresses(&self) -> Vec<Address> {
        let estimates = self.fillers.iter().flat_map(|filled| &filled.estimates);
        estimates.map(|estimate| estimate.address).collect()
    }

    fn launches(&self) -> usize {
        self.fillers.iter().map(|filled| filled.estimates.len().div_ceil(MAX_ESTIMATES)).sum()
    }

    fn work(&self, lacking: Lacking) -> Result<Vec<Work<'_>>, StoreError> {
        let mut all = Vec::new();
        for filled in &self.fillers {
            for (launch, places) in filled.launches() {
                let addresses: Vec<_> = places.iter().map(|&place| filled.estimates[place].address).collect();
                let steps = launch.steps();
                let blocks = lacking(&addresses, steps)?;
                all.push(Work::new(steps, move || Ok((launch.clone(), addresses.clone())), blocks));
            }
        }
        Ok(all)
    }
}

impl Plan<'_> {
    /// A note that some runs of a sweep over the interval end exactly with an interval that no other cancels.
    fn uneven(&self) -> Option<String> {
        let is_even = |point: &&RunPoint| {
            let pairs = 0.5 * point.schedule.duration_s / point.schedule.interval_s;
            point.schedule.end != End::Exact || (pairs - libm::round(pairs)).abs() <= 1e-9 * pairs
        };
        let points = &self.subject.points;
        let uneven = points.len() - points.iter().filter(is_even).count();
        let swept = self.study.sweeps.iter().any(|sweep| sweep.key.name == "switching.interval");
        (swept && uneven > 0).then(|| {
            format!(
                "{uneven} of {} points have an odd or fractional number of intervals: nothing cancels the magnetic drift of the last, which \
                 can count for more than the interval; run.end = \"any\" averages over the end",
                points.len()
            )
        })
    }

    /// The runs of every point and filler, with the name of the filler, in the order of the tables.
    fn filled(&self) -> impl Iterator<Item = (&RunPoint, Option<&str>, &FilledRun)> {
        let points = self.subject.points.iter().zip(&self.points);
        points.flat_map(|(point, lowered)| {
            let names = self.subject.fillers().iter().map(|filler| Some(filler.name.as_str()));
            let fillers = names.chain(std::iter::repeat(None)).zip(&lowered.fillers);
            fillers.map(move |(filler, filled)| (point, filler, filled))
        })
    }
}

impl Tabulated for Plan<'_> {
    fn tables(&self, store: Option<&Store>) -> Result<Tables, RunError> {
        let keeps = self.subject.trajectories > 0;
        let trajectories = keeps.then(|| trajectory_table(self, store)).transpose()?;
        let mut rows = Vec::new();
        for (point, filler, filled) in self.filled() {
            let row = |estimate| Row { point, filler, filled, estimate, found: RowEstimates::default() };
            rows.extend(filled.estimates.iter().map(row));
        }
        let found = estimates(store, &rows, |Row { estimate, .. }| {
            (estimate.address, estimate.bin_base, estimate.unit_arcsec)
        })?;
        rows.iter_mut().zip(found).for_each(|(row, found)| row.found = found);
        let columns = columns(!self.subject.fillers().is_empty());
        let points = table(&self.study.sweeps, &columns, &rows, |row| &row.point.swept);
        Ok(Tables { trajectories, ..Tables::of_points(points) })
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        Ok(late(self.subject).into_iter().chain(thinned(self)).chain(self.uneven()).collect())
    }

    fn keep(&self, store: &mut Store, share: Share) -> Result<(), RunError> {
        if makes_trajectories(share) {
            keep(self, store)?;
        }
        Ok(())
    }

    fn lacks_kept(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        if makes_trajectories(share) { lacks(self, store) } else { Ok(0) }
    }
}

/// Whether a share makes the trajectories. They are few, so the first share makes them all.
fn makes_trajectories(share: Share) -> bool {
    share.number() == 1
}

/// A note that ticks of the relock after the last one followed would still count.
pub fn late(runs: &SwitchedRun) -> Option<String> {
    let relocks = runs.points.iter().filter_map(|point| {
        let (relocking, fill) = point.relock.as_ref().zip(point.fill.as_ref())?;
        Some((&relocking.relock, fill.inputs.tick_s))
    });
    crate::kinds::relock::late(relocks)
}

/// Most switches that a trajectory shows; of more of them every second, third, … is shown.
pub(crate) const MAX_SHOWN: u64 = 500;

/// Offset of the angles in the store, which holds non-negative numbers.
const OFFSET: i64 = 1 << 31;

/// Number of trajectories that the store lacks.
fn lacks(plan: &Plan, store: &Store) -> Result<u64, StoreError> {
    let wanted = plan.subject.trajectories.min(plan.study.trials);
    let (index, mut lacking) = (store.index()?, 0);
    for (.., filled) in plan.filled() {
        let gaps = missing(index.blocks(&filled.trajectory)?, 0..wanted);
        lacking += gaps.iter().map(|gap| gap.end - gap.start).sum::<u64>();
    }
    Ok(lacking)
}

/// Makes the trajectories that the store lacks.
fn keep(plan: &Plan, store: &mut Store) -> Result<(), StoreError> {
    let wanted = plan.subject.trajectories.min(plan.study.trials);
    let index = store.index()?;
    for (point, _, filled) in plan.filled() {
        let held = index.blocks(&filled.trajectory)?;
        let (launch, shape) = filled.trajectories();
        let mut rows = Vec::new();
        for trial in missing(held, 0..wanted).into_iter().flatten() {
            let angles = trajectory(&launch, shape, trial);
            let shown = shown(point);
            let values: Vec<u128> =
                places(&shown).map(|place| (i64::from(angles[place]) + OFFSET) as u128).collect();
            let tally = Rows { width: values.len(), values };
            rows.push(StoredRow {
                address: filled.trajectory,
                block: Block { first: trial, log2: 0 },
                tally,
            });
        }
        if !rows.is_empty() {
            store.insert(&rows, None)?;
        }
    }
    Ok(())
}

/// The table of the requested trajectories in the store; without a store, a row for each point, filler and run.
fn trajectory_table(plan: &Plan, store: Option<&Store>) -> Result<Table, StoreError> {
    let mut moments = Vec::new();
    for (point, filler, filled) in plan.filled() {
        let runs = 1..=plan.subject.trajectories;
        let start = |run, angle| Moment { point, filler, run, time_s: 0.0, angle };
        let Some(store) = store else {
            moments.extend(runs.map(|run| start(run, None)));
            continue;
        };
        let shown = shown(point);
        let width = places(&shown).count();
        let held = store.rows(&filled.trajectory, width)?;
        let rows = held.iter().flat_map(|rows| rows.values.chunks_exact(width));
        for (run, values) in runs.zip(rows) {
            let lsb = filled.trajectory_unit_arcsec();
            moments.push(start(run, Some(0.0)));
            moments.extend(places(&shown).zip(values).map(|(place, value)| {
                let interval = (place / 2 + 1) as f64 * point.schedule.interval_s;
                let angle = (*value as i64 - OFFSET) as f64 * lsb;
                let time_s = interval.min(point.schedule.duration_s);
                Moment { point, filler, run, time_s, angle: Some(angle) }
            }));
        }
    }
    let columns = trajectory_columns(!plan.subject.fillers().is_empty());
    Ok(kinds::plan::table(&plan.study.sweeps, &columns, &moments, |moment| &moment.point.swept))
}

/// A note that not every switch is in the table.
fn thinned(plan: &Plan) -> Option<String> {
    let most = plan.subject.points.iter().map(RunPoint::switches).max()?;
    (plan.subject.trajectories > 0 && most > MAX_SHOWN).then(|| {
        format!(
            "trajectories of runs with more than {MAX_SHOWN} switches show only some of them, evenly spaced"
        )
    })
}

/// The switches shown, and then the end, as numbers of intervals from 0.
fn shown(point: &RunPoint) -> Vec<u64> {
    let switches = point.switches();
    let stride = switches.div_ceil(MAX_SHOWN).max(1);
    (0..switches).step_by(stride as usize).chain([switches]).collect()
}

/// The indices of those switches and of the end among the angles of a run, which has two for each switch and one for
/// the end.
fn places(shown: &[u64]) -> impl Iterator<Item = usize> {
    let last = shown.last().copied().unwrap_or(0);
    shown.iter().flat_map(move |&k| {
        let first = 2 * k as usize;
        first..if k == last { first + 1 } else { first + 2 }
    })
}
