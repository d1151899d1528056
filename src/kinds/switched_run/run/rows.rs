//! The table of whole runs: a row for each point, filler and angle.

use crate::kinds::switched_run::Angle as RunAngle;
use crate::kinds::switched_run::lower::{FilledRun, RunEstimate};
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::kinds::switched_run::run::{NORMAL_95, Plan};
use crate::run::{column, swept_columns};
use crate::sampling::sampling::estimates;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::table::{Cell, Column, Table, Unit};
use crate::tally::stats::{Estimates, Quantile, z_score};
use crate::theory::drift::magnetic::switches;

/// A row of the table before it is filled.
struct Row<'a> {
    point: &'a RunPoint,
    filler: Option<&'a str>,
    filled: &'a FilledRun,
    estimate: &'a RunEstimate,
}

impl Plan<'_> {
    /// The table before anything is sampled: all rows, without estimates.
    pub(crate) fn blank_table(&self) -> Table {
        let mut table = self.empty_table();
        self.rows(|row| push(&mut table, &row, 0, None));
        table
    }

    /// All estimates held.
    pub(crate) fn table(&self, store: &Store) -> Result<Table, StoreError> {
        let mut rows = Vec::new();
        self.rows(|row| rows.push(row));
        let found = estimates(store, &rows, |row| {
            (row.estimate.address, row.estimate.bin_base, row.estimate.unit_arcsec)
        })?;
        let mut table = self.empty_table();
        for (row, (trials, found)) in rows.iter().zip(found) {
            push(&mut table, row, trials, found);
        }
        Ok(table)
    }

    /// Every point, filler and angle, in the order of the table.
    fn rows<'a>(&'a self, mut each: impl FnMut(Row<'a>)) {
        for (point, lowered) in self.runs.points.iter().zip(&self.points) {
            for (place, filled) in lowered.fillers.iter().enumerate() {
                let filler = self.runs.fillers().get(place).map(|filler| filler.name.as_str());
                for estimate in &filled.estimates {
                    each(Row { point, filler, filled, estimate });
                }
            }
        }
    }

    fn empty_table(&self) -> Table {
        let arcsec = |name: &str, label: &str| column(name, label, Unit::ARCSEC);
        let drift = |name: &str, label: &str| column(name, label, Unit::DEG_PER_H);
        let banded = |column: Column| Column { band: Some(vec![]), ..column };
        let mut columns = swept_columns(self.study);
        if !self.runs.fillers().is_empty() {
            columns.push(column("filler", "filler", Unit::NONE));
        }
        columns.extend([
            column("angle", "angle", Unit::NONE),
            column("time", "time in the run", Unit::S),
            column("switches", "switches", Unit::NONE),
            arcsec("residual_rms", "rms residual of a switch"),
            column("trials", "trials", Unit::NONE),
            arcsec("mean", "mean error of the angle"),
            banded(arcsec("rms", "rms error of the angle")),
            arcsec("rms_se", "standard error of the rms"),
            arcsec("max", "largest error seen"),
            banded(arcsec("q9973", "99.73 % error of the angle")),
            arcsec("q9973_lo", "99.73 % error of the angle (lower)"),
            arcsec("q9973_hi", "99.73 % error of the angle (upper)"),
            drift("drift_mean", "mean drift"),
            banded(drift("drift_rms", "rms drift")),
            banded(drift("drift_q9973", "99.73 % drift")),
            drift("drift_q9973_lo", "99.73 % drift (lower)"),
            drift("drift_q9973_hi", "99.73 % drift (upper)"),
            arcsec("oracle_mean", "mean error of the angle (closed form)"),
            arcsec("oracle_rms", "rms error of the angle (closed form)"),
            drift("oracle_drift_mean", "mean drift (closed form)"),
            drift("oracle_drift_rms", "rms drift (closed form)"),
            column("z_mean", "deviation of the mean from the closed form, standard errors", Unit::NONE),
            column("z", "deviation of the rms from the closed form, standard errors", Unit::NONE),
        ]);
        Table { columns }
    }
}

fn push(table: &mut Table, row: &Row, trials: u64, found: Option<Estimates>) {
    let Row { point, filler, filled, estimate } = row;
    let time_s = match estimate.angle {
        RunAngle::End => Some(point.schedule.duration_s),
        RunAngle::At(time_s) => Some(time_s),
        // It comes at another time in each run.
        RunAngle::Largest => None,
    };
    let q = found.and_then(|found| found.q9973);
    let oracle = estimate.oracle;
    let rate = |angle: Option<f64>| Some(angle? / time_s?);
    let of = |value: fn(&Estimates) -> f64| found.as_ref().map(value);
    let of_q = |value: fn(Quantile) -> Option<f64>| q.and_then(value);
    let rms_se = found.and_then(|found| found.rms_se);
    let z = found
        .zip(rms_se)
        .zip(oracle)
        .and_then(|((found, se), oracle)| z_score(found.rms, oracle.rms(), se, oracle.rounding));
    let z_mean = found.zip(oracle).filter(|_| trials > 1).and_then(|(found, oracle)| {
        let se = oracle.deviation / libm::sqrt(trials as f64);
        z_score(found.mean, oracle.mean, se, oracle.rounding)
    });
    // Before a time, or in all.
    let before = match estimate.angle {
        RunAngle::At(time_s) => switches(point.schedule.interval_s, time_s),
        RunAngle::End | RunAngle::Largest => point.switches() as f64,
    };
    let rms_band = found.zip(rms_se).map(|(found, se)| {
        let half = NORMAL_95 * se;
        (found.rms - half, found.rms + half)
    });
    let q_band = q.and_then(|q| q.low.zip(q.high));
    let cells = point
        .swept
        .iter()
        .map(|(_, value)| value.cell())
        .chain(filler.map(|name| Cell::Text(name.to_owned())))
        .chain([
            Cell::Text(estimate.angle.name()),
            time_s.into(),
            Cell::Integer(before as i64),
            Some(filled.residual_rms()).into(),
            Cell::Integer(trials as i64),
            of(|found| found.mean).into(),
            of(|found| found.rms).into(),
            rms_se.into(),
            of(|found| found.max).into(),
            q.map(|q| q.value).into(),
            of_q(|q| q.low).into(),
            of_q(|q| q.high).into(),
            rate(of(|found| found.mean)).into(),
            rate(of(|found| found.rms)).into(),
            rate(q.map(|q| q.value)).into(),
            rate(of_q(|q| q.low)).into(),
            rate(of_q(|q| q.high)).into(),
            oracle.map(|oracle| oracle.mean).into(),
            oracle.map(|oracle| oracle.rms()).into(),
            rate(oracle.map(|oracle| oracle.mean)).into(),
            rate(oracle.map(|oracle| oracle.rms())).into(),
            z_mean.into(),
            z.into(),
        ]);
    let of_time = |band: (f64, f64)| time_s.map(|time| (band.0 / time, band.1 / time));
    for (column, cell) in table.columns.iter_mut().zip(cells) {
        column.cells.push(cell);
        if let Some(band) = &mut column.band {
            band.push(match column.name.as_str() {
                "rms" => rms_band,
                "drift_rms" => rms_band.and_then(of_time),
                "drift_q9973" => q_band.and_then(of_time),
                _ => q_band,
            });
        }
    }
}
