//! The table of a gap-fill study: a row for each point, filler and error.

use crate::filler::Filler;
use crate::kinds::gap_fill::lower::estimate::Estimate;
use crate::kinds::gap_fill::point::Point;
use crate::kinds::gap_fill::run::{NORMAL_95, Plan};
use crate::run::{column, swept_columns};
use crate::sampling::sampling::estimates;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::study::Study;
use crate::table::{Cell, Column, Table, Unit};
use crate::tally::stats::{Estimates, z_score};

impl Plan<'_> {
    /// The table before anything is sampled: all rows, without estimates.
    pub(crate) fn blank_table(&self) -> Table {
        let mut columns = Columns::new(self.study);
        self.rows(|point, filler, estimate| columns.push(point, &filler.name, estimate, 0, None));
        self.with_laws(columns.table)
    }

    /// All estimates held, a row for each point, filler and error.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub(crate) fn table(&self, store: &Store) -> Result<Table, StoreError> {
        let mut rows = Vec::new();
        self.rows(|point, filler, estimate| rows.push((point, filler, estimate)));
        let found = estimates(store, &rows, |(_, _, estimate)| {
            (estimate.address, estimate.bin_base, estimate.unit_arcsec)
        })?;
        let mut columns = Columns::new(self.study);
        for ((point, filler, estimate), (trials, found)) in rows.iter().zip(found) {
            columns.push(point, &filler.name, estimate, trials, found);
        }
        Ok(self.with_laws(columns.table))
    }

    /// Whether a record is replayed over all its places, which gives whole replays only.
    pub(crate) fn replays(&self) -> bool {
        self.points.iter().any(|point| point.trials(1) > 1)
    }

    /// The table with a column for each law that a chart draws.
    fn with_laws(&self, mut table: Table) -> Table {
        for law in self.study.laws() {
            let mut cells = vec![];
            self.rows(|point, filler, estimate| {
                cells.push(
                    law.arcsec(&point.inputs, filler, estimate.error, estimate.rows.ticks.len()).into(),
                );
            });
            let (name, label) = (law.column().to_owned(), law.label().to_owned());
            table.columns.push(Column { name, label, unit: Unit::ARCSEC, cells, band: None });
        }
        table
    }

    /// Every point, filler and error, in the order of the table.
    fn rows<'a>(&'a self, mut row: impl FnMut(&'a Point, &'a Filler, &'a Estimate)) {
        for (point, lowered) in self.gap_fill.points.iter().zip(&self.points) {
            for (filler, estimates) in self.gap_fill.fillers.iter().zip(&lowered.fillers) {
                for estimate in estimates {
                    row(point, filler, estimate);
                }
            }
        }
    }
}

/// The columns of a gap-fill table, row by row.
struct Columns {
    table: Table,
}

impl Columns {
    fn new(study: &Study) -> Columns {
        let banded =
            |name: &str, label: &str| Column { band: Some(vec![]), ..column(name, label, Unit::ARCSEC) };
        let mut columns = swept_columns(study);
        columns.extend([
            column("dt_nu", "Δt·ν", Unit::NONE),
            column("amplitude_noise", "rate amplitude · T / σ", Unit::NONE),
            column("filler", "filler", Unit::NONE),
            column("error", "error", Unit::NONE),
            column("trials", "trials", Unit::NONE),
            column("mean", "mean error", Unit::ARCSEC),
            banded("rms", "rms error"),
            column("rms_se", "standard error of the rms", Unit::ARCSEC),
            column("max", "largest error seen", Unit::ARCSEC),
            banded("q9973", "99.73 % error"),
            column("q9973_lo", "99.73 % error (lower)", Unit::ARCSEC),
            column("q9973_hi", "99.73 % error (upper)", Unit::ARCSEC),
            column("oracle_rms", "rms error (closed form)", Unit::ARCSEC),
            column("oracle_max", "largest error of the motion (closed form)", Unit::ARCSEC),
            column("z", "deviation from the closed form, standard errors", Unit::NONE),
        ]);
        Columns { table: Table { columns } }
    }

    fn push(
        &mut self,
        point: &Point,
        filler: &str,
        estimate: &Estimate,
        trials: u64,
        found: Option<Estimates>,
    ) {
        let q = found.and_then(|found| found.q9973);
        let rms_se = found.and_then(|found| match estimate.oracle.noise_of_square {
            Some(noise) if trials > 0 && found.rms > 0.0 => {
                Some(noise / libm::sqrt(trials as f64) / (2.0 * found.rms))
            }
            _ => found.rms_se,
        });
        let z = found
            .zip(rms_se)
            .zip(estimate.oracle.rms)
            .and_then(|((found, se), rms)| z_score(found.rms, rms, se, estimate.oracle.rounding));
        let cells = point.swept.iter().map(|(_, value)| value.cell()).chain([
            Cell::from(point.inputs.dt_nu()),
            point.inputs.amplitude_noise().into(),
            Cell::Text(filler.to_owned()),
            Cell::Text(estimate.error.name().to_owned()),
            Cell::Integer(trials as i64),
            found.map(|found| found.mean).into(),
            found.map(|found| found.rms).into(),
            rms_se.into(),
            found.map(|found| found.max).into(),
            q.map(|q| q.value).into(),
            q.and_then(|q| q.low).into(),
            q.and_then(|q| q.high).into(),
            estimate.oracle.rms.into(),
            estimate.oracle.max.into(),
            z.into(),
        ]);
        let rms_band =
            found.zip(rms_se).map(|(found, se)| (found.rms - NORMAL_95 * se, found.rms + NORMAL_95 * se));
        let q_band = q.and_then(|q| q.low.zip(q.high));
        for (column, cell) in self.table.columns.iter_mut().zip(cells) {
            column.cells.push(cell);
            if let Some(band) = &mut column.band {
                band.push(if column.name == "rms" { rms_band } else { q_band });
            }
        }
    }
}
