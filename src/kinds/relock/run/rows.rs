//! The table of a relock study: a row for each point, compensation and tick, and one for all ticks together.

use crate::chart::law::Law;
use crate::kinds::relock::inputs::Compensation;
use crate::kinds::relock::lower::RelockEstimate;
use crate::kinds::relock::run::{NORMAL_95, Plan};
use crate::kinds::relock::{RelockInputs, RelockPoint};
use crate::run::{column, swept_columns};
use crate::sampling::sampling::estimates;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::table::{Cell, Column, Table, Unit};
use crate::tally::stats::{Estimates, z_score};
use crate::theory::published::{RELOCK_TABLES, RELOCK_TICK_S, RelockRow};
use crate::theory::relock::{Relock, detuning_signal};

impl Plan<'_> {
    /// The table before anything is sampled: all rows, without estimates.
    pub(crate) fn blank_table(&self) -> Table {
        let mut table = self.columns();
        for (point, estimate) in self.rows() {
            push(&mut table, point, estimate, 0, None);
        }
        self.with_laws(table)
    }

    /// All estimates held.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub(crate) fn table(&self, store: &Store) -> Result<Table, StoreError> {
        let rows: Vec<_> = self.rows().zip(self.units()).collect();
        let found =
            estimates(store, &rows, |((_, estimate), unit)| (estimate.address, estimate.bin_base, *unit))?;
        let mut table = self.columns();
        for (((point, estimate), _), (trials, found)) in rows.into_iter().zip(found) {
            push(&mut table, point, estimate, trials, found);
        }
        Ok(self.with_laws(table))
    }

    fn rows(&self) -> impl Iterator<Item = (&RelockPoint, &RelockEstimate)> {
        let points = self.relock.points.iter().zip(&self.points);
        points.flat_map(|(point, lowered)| lowered.estimates.iter().map(move |estimate| (point, estimate)))
    }

    /// The unit of each row's tally, ″.
    fn units(&self) -> impl Iterator<Item = f64> {
        self.points.iter().flat_map(|point| point.estimates.iter().map(|_| point.fixed.lsb_arcsec))
    }

    fn columns(&self) -> Table {
        let angle = |name: &str, label: &str| column(name, label, Unit::ARCSEC);
        let banded = |name: &str, label: &str| Column { band: Some(vec![]), ..angle(name, label) };
        let plain = |name: &str, label: &str| column(name, label, Unit::NONE);
        let mut columns = swept_columns(self.study);
        columns.extend([
            plain("compensation", "compensation"),
            plain("tick", "tick"),
            plain("tick_number", "tick"),
            plain("trials", "trials"),
            angle("mean", "mean angle left"),
            banded("rms", "rms angle left"),
            angle("rms_se", "standard error of the rms"),
            angle("max", "largest angle left"),
            banded("q9973", "99.73 % angle left"),
            angle("q9973_lo", "99.73 % angle left (lower)"),
            angle("q9973_hi", "99.73 % angle left (upper)"),
            angle("oracle_mean", "mean angle left (closed form)"),
            angle("oracle_rms", "rms angle left (closed form)"),
            plain("z", "deviation from the closed form, standard errors"),
            column("drift", "faked rate of the miss as asked", Unit::ARCSEC_PER_S),
            column("bias", "bias frequency at the start of the tick", Unit::HZ),
            column("bias_error", "error of the bias frequency", Unit::HZ),
            plain("detuning", "detuning at the start of the tick"),
            plain("detuning_plus", "mean detuning of the first half"),
            plain("detuning_minus", "mean detuning of the second half"),
            plain("signal", "signal of the detuning at the start of the tick"),
        ]);
        Table { columns }
    }

    /// The table with a column for each law that a chart draws.
    fn with_laws(&self, mut table: Table) -> Table {
        for law in self.study.laws() {
            let of = |(point, estimate): (&RelockPoint, &RelockEstimate)| match law {
                Law::ZeemanTables => published(&point.inputs, estimate.compensation, estimate.tick).into(),
                _ => Cell::from(None),
            };
            let (name, label) = (law.column().to_owned(), law.label().to_owned());
            let cells = self.rows().map(of).collect();
            table.columns.push(Column { name, label, unit: Unit::ARCSEC, cells, band: None });
        }
        table
    }
}

fn push(
    table: &mut Table,
    point: &RelockPoint,
    estimate: &RelockEstimate,
    trials: u64,
    found: Option<Estimates>,
) {
    let RelockInputs { tick_s, relock } = &point.inputs;
    let q = found.and_then(|found| found.q9973);
    let rms_se = found.and_then(|found| found.rms_se);
    let rms = estimate.oracle.map(|oracle| oracle.1);
    let z = found
        .zip(rms_se)
        .zip(rms)
        .and_then(|((found, se), rms)| z_score(found.rms, rms, se, estimate.rounding));
    let nominal = Relock {
        tick_s: *tick_s,
        loop_s: relock.loop_s,
        bias: relock.bias_frequency_hz,
        curvature: relock.curvature,
        miss: relock.miss,
    };
    let of_tick = |value: &dyn Fn(u32) -> f64| Cell::from(estimate.tick.map(value));
    let start = |tick: u32| f64::from(tick - 1) * tick_s;
    let sign = relock.sign();
    let cells = point.swept.iter().map(|(_, value)| value.cell()).chain([
        Cell::Text(estimate.compensation.name().to_owned()),
        Cell::Text(estimate.tick.map_or_else(|| "all".to_owned(), |tick| tick.to_string())),
        estimate.tick.map_or(Cell::from(None), |tick| Cell::Integer(i64::from(tick))),
        Cell::Integer(trials as i64),
        found.map(|found| found.mean).into(),
        found.map(|found| found.rms).into(),
        rms_se.into(),
        found.map(|found| found.max).into(),
        q.map(|q| q.value).into(),
        q.and_then(|q| q.low).into(),
        q.and_then(|q| q.high).into(),
        estimate.oracle.map(|oracle| oracle.0).into(),
        rms.into(),
        z.into(),
        of_tick(&|tick| sign * relock.pulse_weight_arcsec * nominal.apparent_drift(tick)),
        of_tick(&|tick| nominal.bias_at(start(tick))),
        of_tick(&|tick| nominal.bias_error(tick)),
        of_tick(&|tick| nominal.detuning(start(tick))),
        of_tick(&|tick| nominal.detuning_means(tick)[0]),
        of_tick(&|tick| nominal.detuning_means(tick)[1]),
        Cell::from(
            estimate
                .tick
                .zip(relock.signal_gain)
                .map(|(tick, gain)| detuning_signal(gain, nominal.detuning(start(tick)))),
        ),
    ]);
    let rms_band =
        found.zip(rms_se).map(|(found, se)| (found.rms - NORMAL_95 * se, found.rms + NORMAL_95 * se));
    let q_band = q.and_then(|q| q.low.zip(q.high));
    for (column, cell) in table.columns.iter_mut().zip(cells) {
        column.cells.push(cell);
        if let Some(band) = &mut column.band {
            band.push(if column.name == "rms" { rms_band } else { q_band });
        }
    }
}

/// What the paper measured in a tick, or what its compensation leaves of that, ″, without sign; of ticks as long as its own.
fn published(inputs: &RelockInputs, compensation: Compensation, tick: Option<u32>) -> Option<f64> {
    let left = |row: RelockRow| match compensation {
        Compensation::None => row.measured,
        Compensation::Frequency => row.measured - row.by_frequency.unwrap_or(0.0),
        Compensation::Detuning => row.measured - row.by_detuning,
    };
    // 1 °/h is 1 ″/s.
    let angle = match tick {
        Some(tick) => left(*RELOCK_TABLES.get(tick as usize - 1)?),
        None if inputs.relock.ticks as usize == RELOCK_TABLES.len() => {
            RELOCK_TABLES.into_iter().map(left).sum()
        }
        None => return None,
    };
    (inputs.tick_s == RELOCK_TICK_S).then_some((angle * RELOCK_TICK_S).abs())
}
