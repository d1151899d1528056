//! The columns of a relock study, with a row for each point, compensation and tick, and one for all ticks together.

use crate::chart::Law;
use crate::kinds::relock::inputs::Compensation;
use crate::kinds::relock::lower::RelockEstimate;
use crate::kinds::relock::{RelockInputs, RelockPoint};
use crate::sampling::{self, Found};
use sagnac_base::table::column::abouts;
use sagnac_base::table::{About, Cell, ColumnOf, Role, Unit, Usual};
use sagnac_theory::published::{RELOCK_TABLES, RELOCK_TICK_S, RelockRow};
use sagnac_theory::relock::{Relock, detuning_signal};

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    pub(crate) point: &'a RelockPoint,
    pub(crate) estimate: &'a RelockEstimate,
    /// Size of a unit of the tally, ″.
    pub(crate) unit_arcsec: f64,
    pub(crate) found: Found,
}

impl Row<'_> {
    /// A value of the row's tick, from the nominal initial detuning and the start of the tick, s.
    fn of_tick(&self, value: impl Fn(&Relock, u32, f64) -> f64) -> Cell {
        let RelockInputs { tick_s, relock } = &self.point.inputs;
        let nominal = Relock {
            tick_s: *tick_s,
            loop_s: relock.loop_s,
            bias: relock.bias_frequency_hz,
            curvature: relock.curvature,
            miss: relock.miss,
        };
        self.estimate.tick.map(|tick| value(&nominal, tick, f64::from(tick - 1) * tick_s)).into()
    }

    fn drift(&self) -> Cell {
        let relock = &self.point.inputs.relock;
        let weight = relock.sign() * relock.pulse_weight_arcsec;
        self.of_tick(|nominal, tick, _| weight * nominal.apparent_drift(tick))
    }

    fn signal(&self) -> Cell {
        let gain = self.point.inputs.relock.signal_gain;
        gain.map_or(Cell::Blank, |gain| {
            self.of_tick(|nominal, _, s| detuning_signal(gain, nominal.detuning(s)))
        })
    }

    /// The law of the paper's tables 1 and 2: the angle measured in a tick, or the part of it that the compensation
    /// leaves, ″, without sign; `None` for ticks of another length.
    pub(crate) fn published(&self) -> Option<f64> {
        let inputs = &self.point.inputs;
        let left = |row: RelockRow| match self.estimate.compensation {
            Compensation::None => row.measured,
            Compensation::Frequency => row.measured - row.by_frequency.unwrap_or(0.0),
            Compensation::Detuning => row.measured - row.by_detuning,
        };
        // 1 °/h is 1 ″/s.
        let angle = match self.estimate.tick {
            Some(tick) => left(*RELOCK_TABLES.get(tick as usize - 1)?),
            None if inputs.relock.ticks as usize == RELOCK_TABLES.len() => {
                RELOCK_TABLES.into_iter().map(left).sum()
            }
            None => return None,
        };
        (inputs.tick_s == RELOCK_TICK_S).then_some((angle * RELOCK_TICK_S).abs())
    }

    fn z(&self) -> Cell {
        self.found.z(self.estimate.theory.map(|theory| theory.1), self.estimate.rounding).into()
    }
}

/// Entry in the column of ticks for all of them together.
pub(crate) const ALL_TICKS: &str = "all";

/// The columns except the swept keys, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("compensation", Unit::NONE, "compensation", |row| row.estimate.compensation.name().into())
            .is(Role::Key, "The compensation of the paper that is applied: `none`, `frequency` or `detuning`."),
        Of::new("tick", Unit::NONE, "tick", |row| {
            row.estimate.tick.map_or(ALL_TICKS.into(), |tick| Cell::Text(tick.to_string()))
        })
        .is(Role::Key, "The tick after the switch, `1`, `2`, …, or `all` for their sum.")
        .usual(Usual::Places),
        Of::new("tick_number", Unit::NONE, "tick", |row| row.estimate.tick.map_or(Cell::Blank, |tick| u64::from(tick).into()))
            .is(Role::Coordinate, "The tick as a number, for charts over ticks; blank for the sum of all ticks.")
            .usual(Usual::Abscissa),
        Of::new("trials", Unit::NONE, "trials", |row| row.found.trials.into())
            .is(Role::Trials, "Number of switches behind the estimates of the row."),
        Of::new("mean", Unit::ARCSEC, "mean angle left", |row| row.found.cell(|found| found.mean))
            .is(Role::Estimate, "Mean of the apparent angle minus its compensation, ″, with its sign.")
            .within(|row| row.found.mean_band()),
        Of::new("rms", Unit::ARCSEC, "rms angle left", |row| row.found.cell(|found| found.rms))
            .is(Role::Error, "Root mean square of the apparent angle minus its compensation, ″.")
            .usual(Usual::Estimate)
            .within(|row| row.found.rms_band()),
        Of::new("rms_se", Unit::ARCSEC, "standard error of the rms", |row| row.found.rms_se().into())
            .is_of("rms", Role::StandardError, sampling::RMS_SE),
        Of::new("max", Unit::ARCSEC, "largest angle left", |row| row.found.cell(|found| found.max))
            .is(Role::Error, "The largest magnitude of a remaining angle among the trials, ″."),
        Of::new("p99_73", Unit::ARCSEC, "99.73 % angle left", |row| row.found.level(|q| Some(q.value)).into())
            .is(Role::Error, "The level, ″, below which 99.73 % of the remaining angles stay in magnitude.")
            .within(|row| row.found.level_band()),
        Of::new("p99_73_lo", Unit::ARCSEC, "99.73 % angle left (lower)", |row| row.found.level(|q| q.low).into())
            .is_of("p99_73", Role::Lower, sampling::LEVEL_LOWER),
        Of::new("p99_73_hi", Unit::ARCSEC, "99.73 % angle left (upper)", |row| row.found.level(|q| q.high).into())
            .is_of("p99_73", Role::Upper, sampling::LEVEL_UPPER),
        Of::new("theory_mean", Unit::ARCSEC, "mean angle left (closed form)", |row| row.estimate.theory.map(|theory| theory.0).into())
            .is_of("mean", Role::Theory, "`mean` in closed form, ″. It exists without compensation, for the first tick with frequency compensation, and with \
                detuning compensation if there is neither noise nor a step."),
        Of::new("theory_rms", Unit::ARCSEC, "rms angle left (closed form)", |row| row.estimate.theory.map(|theory| theory.1).into())
            .is_of("rms", Role::Theory, "`rms` in closed form, ″, where there is one."),
        Of::new("z", Unit::NONE, "deviation from the closed form, standard errors", Row::z)
            .is_of("rms", Role::Z, sampling::Z),
        Of::new("drift", Unit::ARCSEC_PER_S, "apparent rate for the nominal initial detuning", Row::drift)
            .is(Role::Estimate, "ΔΩ_i, the apparent rate of the loop in this tick for the nominal initial detuning, ″/s, Z(11)."),
        Of::new("bias", Unit::HZ, "bias frequency at the start of the tick", |row| row.of_tick(|nominal, _, s| nominal.bias_at(s)))
            .is(Role::Estimate, "f, the bias frequency at the start of the tick for the nominal initial detuning, Hz, Z(2)."),
        Of::new("bias_error", Unit::HZ, "error of the bias frequency", |row| row.of_tick(|nominal, tick, _| nominal.bias_error(tick)))
            .is(Role::Estimate, "y_i = f_i − f0, the error of the bias frequency in the tick for the nominal initial detuning, Hz."),
        Of::new("detuning", Unit::NONE, "detuning at the start of the tick", |row| row.of_tick(|nominal, _, s| nominal.detuning(s)))
            .is(Role::Estimate, "Δλ, the detuning at the start of the tick for the nominal initial detuning, in fractions of the wavelength, Z(10)."),
        Of::new("detuning_plus", Unit::NONE, "mean detuning of the first half", |row| {
            row.of_tick(|nominal, tick, _| nominal.detuning_means(tick)[0])
        })
            .is(Role::Estimate, "h_i⁺, the mean detuning of the first half of the tick, in fractions of the wavelength, Z(12)."),
        Of::new("detuning_minus", Unit::NONE, "mean detuning of the second half", |row| {
            row.of_tick(|nominal, tick, _| nominal.detuning_means(tick)[1])
        })
            .is(Role::Estimate, "h_i⁻, the mean detuning of the second half of the tick, in fractions of the wavelength, Z(12)."),
        Of::new("signal", Unit::NONE, "signal of the detuning at the start of the tick", Row::signal)
            .is(Role::Estimate, "A_I, the signal of the detuning at the start of the tick, in the unit of `relock.signal_gain`, Z(1)."),
        Of::new("representation", Unit::NONE, "representation", |row| row.estimate.representation.into())
            .is_of("rms", Role::Representation, sampling::REPRESENTATION),
    ]
}

/// All possible columns of such a study except the swept keys.
pub(crate) fn described() -> Vec<About> {
    abouts(&columns()).into_iter().chain([Law::ZeemanTables.about()]).collect()
}
