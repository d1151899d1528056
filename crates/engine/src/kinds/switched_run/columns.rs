//! The columns of a study of whole runs, with a row for each point, filler and angle, and of their trajectories.

use crate::filler::{FILLERS, LISTED};
use crate::kinds::gap_fill::columns::FILLER;
use crate::kinds::switched_run::Angle;
use crate::kinds::switched_run::lower::{FilledRun, RunEstimate};
use crate::kinds::switched_run::point::Point;
use crate::sampling::{self, Found};
use crate::tally::z_score;
use sagnac_base::table::column::Band;
use sagnac_base::table::{Cell, ColumnOf, Role, Unit, Usual};
use sagnac_theory::drift::magnetic::switches;

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    pub(crate) point: &'a Point,
    pub(crate) filler: Option<&'a str>,
    pub(crate) filled: &'a FilledRun,
    pub(crate) estimate: &'a RunEstimate,
    pub(crate) found: Found,
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
