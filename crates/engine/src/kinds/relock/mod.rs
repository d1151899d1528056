//! Relock studies: the apparent rotation of the closing path-length control loop after a mode switch, and its remainder after
//! compensation.

pub mod lower;
pub mod verify;

use std::sync::Arc;

use crate::chart::{Law, Source, TableSchema, Text};
use crate::key::document::SpanMap;
use crate::key::sweep::{SweepTarget, Sweep, Sweepable, SweepValue};
use crate::key::{Key, ParseContext, ValueType, keys, measure, unlimited, words};
use crate::kinds::plan::{Lacking, Launched, PointsPlan, Tabulated, table};
use crate::kinds::relock::lower::{LoweredRelock, RelockEstimate};
use crate::kinds::{self, TICK};
use crate::sampling::batches::{Work, estimates};
use crate::sampling::{self, RowEstimates, Planned, RunError, Tables};
use crate::store::error::StoreError;
use crate::store::{Address, Store};
use crate::study::{self, Ablation, Kind, Part, ROW, Study, Subject};
use crate::tally::Id;
use sagnac_base::diagnostics::{Fault, Wrong};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::Dimension;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::abouts;
use sagnac_base::table::{About, Cell, ColumnOf, Role, Unit, Usual};
use sagnac_kernel::moments::MAX_ESTIMATES;
use sagnac_kernel::normal::REACH;
use sagnac_kernel::relock_ticks::{MAX_TICKS, VERSION};
use sagnac_theory::relock::{
    RELOCK_TABLES, RELOCK_TICK_S, Relock as RelockTheory, RelockRow, detuning_signal,
};

/// The part of a study that is specific to relocking.
#[derive(Debug, Clone)]
pub(crate) struct RelockStudy {
    /// Inputs before any sweep.
    pub inputs: RelockInputs,
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<RelockPoint>,
}

/// The inputs of a relock.
#[derive(Debug, Clone, PartialEq)]
pub struct RelockInputs {
    /// Tick T, s.
    pub tick_s: f64,
    /// Perimeter loop and its measurements.
    pub relock: Relock,
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub struct RelockPoint {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, SweepValue)>,
    /// Inputs that determine the draws.
    pub inputs: RelockInputs,
}

keys! {
    /// The table of the tick, the only property of the gyro that a relock uses.
    static GYRO_KEYS;
    /// The gyro.
    GYRO = "gyro", "", Fixed, ValueType::Table, "[gyro]\ntick = \"5 ms\"";
}

static SETTINGS: [SweepTarget<RelockInputs>; 1] =
    [SweepTarget::new(&TICK, |inputs, tick| inputs.tick_s = tick.value)];

/// Every key of this kind.
fn keys() -> Vec<&'static Key> {
    [GYRO_KEYS, kinds::KEYS, KEYS, SIGNAL_KEYS].concat()
}

/// The keys that can be swept.
fn sweepable() -> Sweepable<RelockInputs> {
    Sweepable::new().own(&SETTINGS).part(&LOOP_SETTINGS, |inputs| Some(&mut inputs.relock))
}

/// Reads the part of a study that belongs to this kind.
fn read(reading: &mut ParseContext) -> Result<RelockStudy, Wrong> {
    let mut inputs = RelockInputs { tick_s: 0.0, relock: read_loop(reading)? };
    reading.set(&mut inputs, &SETTINGS)?;
    Ok(RelockStudy { points: points(&inputs, reading.sweeps), inputs })
}

/// All points of some sweeps, in order.
fn points(inputs: &RelockInputs, sweeps: &[Sweep]) -> Vec<RelockPoint> {
    let point = |(swept, inputs)| RelockPoint { swept, inputs };
    sweepable().points(inputs, sweeps).map(point).collect()
}

words! {
    /// The half-period of the bias at the beginning of a tick.
    pub enum FirstHalf {
        /// The sign of Z(11).
        Negative = "negative",
        /// The opposite sign.
        Positive = "positive",
    }
}

words! {
    /// The compensation of the ticks after a switch.
    pub enum Compensation {
        /// No compensation.
        None = "none",
        /// Compensation by the frequency of the bias, from the second tick on: Z(11).
        Frequency = "frequency",
        /// Compensation by the detuning: Z(13).
        Detuning = "detuning",
    }
}

/// Relock after a mode switch; 0 means absent. Detunings are fractions of the wavelength. Every number has 12
/// significant digits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Relock {
    /// Nominal miss Δλ0.
    pub miss: f64,
    /// Standard deviation of the initial detuning due to the half-wave voltage.
    pub half_wave_error: f64,
    /// Step of the DAC; the initial detuning is off by up to half of it to either side.
    pub dac_step: f64,
    /// Hysteresis to either side.
    pub hysteresis: f64,
    /// Time constant of the loop τ_L, s.
    pub loop_s: f64,
    /// Bias frequency f0, Hz.
    pub bias_frequency_hz: f64,
    /// Pulse weight, ″.
    pub pulse_weight_arcsec: f64,
    /// Curvature χ.
    pub curvature: f64,
    /// Standard deviation of the relative error of f0.
    pub temperature_error: f64,
    /// Standard deviation of the noise of the detuning.
    pub adc_noise: f64,
    /// Step of the ADC; 0 means exact.
    pub adc_step: f64,
    /// Step of the count, in periods.
    pub count_step: f64,
    /// Number of ticks followed after the loop closes.
    pub ticks: u32,
    /// Half-period of the bias that comes first, which determines the sign of the apparent rotation.
    pub first_half: FirstHalf,
    /// Gain of the detuning signal A_I/Δλ.
    pub signal_gain: Option<f64>,
}

impl Relock {
    /// The fraction q^2m of the angle of infinitely many ticks that comes after the last one followed.
    pub fn late(&self, tick_s: f64) -> f64 {
        libm::exp(-2.0 * f64::from(self.ticks) * tick_s / self.loop_s)
    }

    /// The angle of infinitely many ticks for the nominal initial detuning, ″: χ f0 Δλ0² (τ_L/2)(1 − q)/(1 + q).
    pub fn whole_angle(&self, tick_s: f64) -> f64 {
        let bias = self.bias_frequency_hz * self.pulse_weight_arcsec;
        0.5 * self.curvature
            * bias
            * self.miss
            * self.miss
            * self.loop_s
            * libm::tanh(0.5 * tick_s / self.loop_s)
    }

    /// Bound of the drawn |Δλ0|.
    pub fn largest_miss(&self) -> f64 {
        self.miss.abs() + REACH * self.half_wave_error + 0.5 * self.dac_step + self.hysteresis
    }

    /// The sign of the apparent rotation.
    pub fn sign(&self) -> f64 {
        match self.first_half {
            FirstHalf::Negative => 1.0,
            FirstHalf::Positive => -1.0,
        }
    }

    /// Everything that determines draws and truth, as lines of text, without the number of ticks followed and the gain.
    pub fn identity(&self) -> String {
        // Every field, so that a new one cannot be left out by mistake.
        let Relock {
            miss,
            half_wave_error,
            dac_step,
            hysteresis,
            loop_s,
            bias_frequency_hz,
            pulse_weight_arcsec,
            curvature,
            temperature_error,
            adc_noise,
            adc_step,
            count_step,
            first_half,
            ticks: _,
            signal_gain: _,
        } = self;
        format!(
            "miss={miss:.11e}\nhalf_wave_error={half_wave_error:.11e}\ndac_step={dac_step:.11e}\n\
             hysteresis={hysteresis:.11e}\nloop_s={loop_s:.11e}\nbias_frequency_hz={bias_frequency_hz:.11e}\n\
             pulse_weight_arcsec={pulse_weight_arcsec:.11e}\ncurvature={curvature:.11e}\n\
             temperature_error={temperature_error:.11e}\nadc_noise={adc_noise:.11e}\nadc_step={adc_step:.11e}\n\
             count_step={count_step:.11e}\nfirst_half={first_half:?}\n"
        )
    }
}

const MISSES: ValueType = measure(&[Dimension::Ratio], -1.0, 1.0, "-1 to 1, in fractions of the wavelength");
const DETUNINGS: ValueType = measure(&[Dimension::Ratio], 0.0, 1.0, "0 to 1, in fractions of the wavelength");
const TIMES: ValueType = measure(&[Dimension::Time], 1e-6, 1e3, "1 µs to 1000 s");
const BIASES: ValueType = measure(&[Dimension::Frequency], 1e-3, 1e9, "0.001 Hz to 1e9 Hz");
const PULSES: ValueType = measure(&[Dimension::Angle], 1e-6, 1e6, "1e-6 to 1e6 arcsec");
const CURVATURES: ValueType = measure(&[Dimension::Ratio], 1e-6, 1e9, "1e-6 to 1e9");
const RATIOS: ValueType = measure(&[Dimension::Ratio], 0.0, 0.05, "0 to 0.05, or 0 % to 5 %");
const COUNTS: ValueType = measure(&[Dimension::Ratio], 0.0, 1e6, "0 to 1e6 periods");

keys! {
    /// The keys of the loop.
    pub(crate) static KEYS;
    /// The path-length control loop after a mode switch: its initial detuning, and the measurements made while it settles.
    /// Detunings are fractions of the wavelength, without unit; absent values are 0.
    pub(crate) RELOCK_TABLE = "relock", "", Fixed, ValueType::Table, "[relock]\nmiss = 0.05\nloop_time = \"12 ms\"\nbias_frequency = \"80 kHz\"\npulse_weight = \"2.6 arcsec\"\ncurvature = 40";
    /// Detuning Δλ0 left by a switch: 0.05.
    MISS = "relock.initial_detuning", "initial detuning Δλ0", Choice, MISSES, "initial_detuning = 0.05", required;
    /// Error of the half-wave voltage U_λ/2: standard deviation of the initial detuning, normally distributed.
    HALF_WAVE = "relock.half_wave_error", "error of U_λ/2", Choice, DETUNINGS, "half_wave_error = 0.005";
    /// Step of the DAC: the initial detuning is uniformly distributed over half a step to either side.
    DAC_STEP = "relock.dac_step", "step of the DAC", Choice, DETUNINGS, "dac_step = 0.002";
    /// Hysteresis of the piezo: the initial detuning is uniformly distributed over this value to either side.
    HYSTERESIS = "relock.hysteresis", "hysteresis of the piezo", Choice, DETUNINGS, "hysteresis = 0.005";
    /// Time constant τ_L of the closed loop: "12 ms".
    LOOP_TIME = "relock.loop_time", "time constant of the loop", Choice, TIMES, r#"loop_time = "12 ms""#, required;
    /// Frequency f0 of the bias at zero detuning: "80 kHz".
    pub(crate) BIAS = "relock.bias_frequency", "frequency of the bias", Fixed, BIASES, r#"bias_frequency = "80 kHz""#, required;
    /// Angle of a period of the beat: "2.6 arcsec".
    PULSE = "relock.pulse_weight", "pulse weight", Choice, PULSES, r#"pulse_weight = "2.6 arcsec""#, required;
    /// Curvature χ in f = f0 (1 − χΔλ²), Z(2): 40.
    CURVATURE = "relock.curvature", "curvature χ", Choice, CURVATURES, "curvature = 40", required;
    /// Standard deviation of the error of f0 from its temperature curve, relative to f0: "0.1 %".
    TEMPERATURE = "relock.temperature_error", "error of f0", Choice, RATIOS, r#"temperature_error = "0.1 %""#;
    /// Standard deviation of the noise of the mean detuning over half a tick.
    ADC_NOISE = "relock.adc_noise", "noise of the detuning", Condition, DETUNINGS, "adc_noise = 0.0001";
    /// Step of the ADC, to which the mean detuning is rounded.
    ADC_STEP = "relock.adc_step", "step of the ADC", Choice, DETUNINGS, "adc_step = 0.0002";
    /// Step in which the periods of the beat in half a tick are counted. 1 counts whole periods, and 0 does not round;
    /// 1 if absent.
    COUNT_STEP = "relock.count_step", "step of the count", Choice, COUNTS, "count_step = 1";
    /// Number of ticks followed after the loop closes, 1 to 8; 4 if absent.
    TICKS = "relock.ticks", "", Fixed, ValueType::Whole(1, MAX_TICKS as i64), "ticks = 4";
    /// Half-period of the bias with which a tick begins; the negative one if absent.
    FIRST_HALF = "relock.first_half", "", Fixed, ValueType::Word(FirstHalf::WORDS), r#"first_half = "negative""#;
}

keys! {
    /// The keys that only studies of kind = "relock" have.
    static SIGNAL_KEYS;
    /// Gain A_I/Δλ of Z(1), 4·a_I·c/Δν, in any unit; adds a column with the signal.
    SIGNAL_GAIN = "relock.signal_gain", "", Fixed, unlimited(&[Dimension::Ratio]), "signal_gain = 20";
}

/// The settings of these keys.
pub(crate) static LOOP_SETTINGS: [SweepTarget<Relock>; 12] = [
    SweepTarget::new(&MISS, |relock, miss| relock.miss = miss.value),
    SweepTarget::new(&HALF_WAVE, |relock, error| relock.half_wave_error = error.value),
    SweepTarget::new(&DAC_STEP, |relock, step| relock.dac_step = step.value),
    SweepTarget::new(&HYSTERESIS, |relock, hysteresis| relock.hysteresis = hysteresis.value),
    SweepTarget::new(&LOOP_TIME, |relock, time| relock.loop_s = time.value),
    SweepTarget::new(&BIAS, |relock, frequency| relock.bias_frequency_hz = frequency.value),
    SweepTarget::new(&PULSE, |relock, weight| relock.pulse_weight_arcsec = weight.value),
    SweepTarget::new(&CURVATURE, |relock, curvature| relock.curvature = curvature.value),
    SweepTarget::new(&TEMPERATURE, |relock, error| relock.temperature_error = error.value),
    SweepTarget::new(&ADC_NOISE, |relock, noise| relock.adc_noise = noise.value),
    SweepTarget::new(&ADC_STEP, |relock, step| relock.adc_step = step.value),
    SweepTarget::new(&COUNT_STEP, |relock, step| relock.count_step = step.value),
];

/// Default number of ticks, as in the paper.
const PAPER_TICKS: u32 = 4;

/// Reads the relock.
pub(crate) fn read_loop(reading: &mut ParseContext) -> Result<Relock, Fault> {
    let first_half = FirstHalf::from_value(reading.get(&FIRST_HALF));
    let mut relock = Relock { count_step: 1.0, ticks: PAPER_TICKS, first_half, ..Relock::default() };
    reading.set(&mut relock, &LOOP_SETTINGS)?;
    reading.note(&[&TICKS]);
    if let Some(ticks) = reading.get(&TICKS) {
        relock.ticks = ticks.whole()? as u32;
    }
    if let Some(gain) = reading.get(&SIGNAL_GAIN) {
        relock.signal_gain = Some(gain.quantity()?.value);
    }
    Ok(relock)
}

/// All parts. Without its nominal initial detuning, a loop starts from the errors of the initial detuning alone; without these there is nothing to
/// relock, and the initial detuning stays.
static PARTS: [Part<Relock>; 8] = [
    Part {
        name: "initial detuning",
        off: |relock| {
            if [relock.half_wave_error, relock.dac_step, relock.hysteresis].iter().any(|error| *error != 0.0)
            {
                relock.miss = 0.0;
            }
        },
    },
    Part { name: "error of U_λ/2", off: |relock| relock.half_wave_error = 0.0 },
    Part { name: "step of the DAC", off: |relock| relock.dac_step = 0.0 },
    Part { name: "hysteresis", off: |relock| relock.hysteresis = 0.0 },
    Part { name: "error of f0", off: |relock| relock.temperature_error = 0.0 },
    Part { name: "noise of the detuning", off: |relock| relock.adc_noise = 0.0 },
    Part { name: "step of the ADC", off: |relock| relock.adc_step = 0.0 },
    Part { name: "step of the count", off: |relock| relock.count_step = 0.0 },
];

/// Studies of the ticks after a switch.
pub static RELOCK: Kind = Kind {
    name: "relock",
    subject: "The apparent rotation caused by the path-length control loop after a mode switch, and its remainder after compensation.",
    about: "Samples mode switches with their errors, the path-length control loop that settles after each, and the apparent rotation in \
            the first ticks. points.csv has the remainder for each `compensation` and `tick`: `mean`, `rms`, `max` and \
            `p99_73`, arcsec.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 1_000_000,
    needs: &["gyro", "relock"],
    keys,
    sweepable: || sweepable().keys(),
    columns: &[(Source::Points, described)],
    kernels,
    loads: crate::kinds::relock::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

/// The kernel, with its version.
pub(crate) fn kernels() -> String {
    format!("relock {VERSION}")
}

impl Subject for RelockStudy {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let lower = |point: &_| LoweredRelock::new(point, study.seed, study.streams);
        let plan = PointsPlan::new(study, self, &self.points, |point| &point.swept, lower, progress)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Ablation> {
        let RelockPoint { swept, inputs } = self.points.get(point)?;
        let (parts, relocks) = study::points(&inputs.relock, &PARTS);
        let of =
            |relock| RelockPoint { swept: swept.clone(), inputs: RelockInputs { relock, ..inputs.clone() } };
        let points = relocks.into_iter().map(of).collect();
        Some(Ablation { parts, subject: Arc::new(RelockStudy { points, ..self.clone() }) })
    }

    fn bytes(&self) -> u64 {
        let ticks = self.inputs.relock.ticks as u64 + 1;
        ROW * (self.points.len() * Compensation::ALL.len()) as u64 * ticks
    }

    fn with_points(&self, sweeps: &[Sweep], _: &SpanMap) -> Result<Arc<dyn Subject>, Fault> {
        Ok(Arc::new(RelockStudy { points: points(&self.inputs, sweeps), inputs: self.inputs.clone() }))
    }

    fn grounds(&self) -> Vec<TableSchema> {
        let compensations = Text::new(Compensation::ALL.map(Compensation::name));
        let ticks = (1..=self.inputs.relock.ticks).map(|tick| tick.to_string()).chain([ALL_TICKS.to_owned()]);
        let ticks = Text { whole: Some(ALL_TICKS), ..Text::new(ticks) };
        let columns = abouts(&columns());
        vec![TableSchema {
            laws: &[Law::ZeemanTables],
            ..TableSchema::new(Source::Points, columns, [compensations, ticks], &[Dimension::Angle])
        }]
    }
}

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    pub(crate) point: &'a RelockPoint,
    pub(crate) estimate: &'a RelockEstimate,
    /// Size of a unit of the tally, ″.
    pub(crate) unit_arcsec: f64,
    pub(crate) found: RowEstimates,
}

impl Row<'_> {
    /// A value of the row's tick, from the nominal initial detuning and the start of the tick, s.
    fn of_tick(&self, value: impl Fn(&RelockTheory, u32, f64) -> f64) -> Cell {
        let RelockInputs { tick_s, relock } = &self.point.inputs;
        let nominal = RelockTheory {
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
const ALL_TICKS: &str = "all";

/// The columns except the swept keys, in the order of the file.
#[rustfmt::skip]
fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
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
fn described() -> Vec<About> {
    abouts(&columns()).into_iter().chain([Law::ZeemanTables.about()]).collect()
}

impl Launched for LoweredRelock {
    fn id(&self) -> Id {
        self.id
    }

    fn addresses(&self) -> Vec<Address> {
        self.estimates.iter().map(|estimate| estimate.address).collect()
    }

    fn launches(&self) -> usize {
        Compensation::ALL.into_iter().flat_map(|compensation| self.launched(compensation)).count()
    }

    fn work(&self, lacking: Lacking) -> Result<Vec<Work<'_>>, StoreError> {
        let work = |estimates: Vec<&RelockEstimate>| {
            let launch = self.launch(&estimates);
            let addresses: Vec<Address> = estimates.iter().map(|estimate| estimate.address).collect();
            let steps = launch.steps();
            let blocks = lacking(&addresses, steps)?;
            Ok(Work::new(steps, move || Ok((launch.clone(), addresses.clone())), blocks))
        };
        Compensation::ALL.into_iter().flat_map(|compensation| self.launched(compensation)).map(work).collect()
    }
}

impl LoweredRelock {
    /// The estimates of each launch of a compensation, as many as a launch can have.
    pub(crate) fn launched(&self, compensation: Compensation) -> Vec<Vec<&RelockEstimate>> {
        let of = self.estimates.iter().filter(|estimate| estimate.compensation == compensation);
        of.collect::<Vec<_>>().chunks(MAX_ESTIMATES).map(<[_]>::to_vec).collect()
    }
}

impl Tabulated for PointsPlan<'_, RelockStudy, LoweredRelock> {
    /// The table has a column for each law that a chart draws.
    fn tables(&self, store: Option<&Store>) -> Result<Tables, RunError> {
        let mut rows = Vec::new();
        for (point, lowered) in self.subject.points.iter().zip(&self.points) {
            let unit_arcsec = lowered.fixed.lsb_arcsec;
            let row = |estimate| Row { point, estimate, unit_arcsec, found: RowEstimates::default() };
            rows.extend(lowered.estimates.iter().map(row));
        }
        let found = estimates(store, &rows, |Row { estimate, unit_arcsec, .. }| {
            (estimate.address, estimate.bin_base, *unit_arcsec)
        })?;
        rows.iter_mut().zip(found).for_each(|(row, found)| row.found = found);
        let mut table = table(&self.study.sweeps, &columns(), &rows, |row| &row.point.swept);
        let law = || rows.iter().map(|row| row.published().into()).collect();
        table.columns.extend(self.study.laws().into_iter().map(|drawn| drawn.about().with(law())));
        Ok(Tables::of_points(table))
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        let relocks = self.subject.points.iter().map(|point| (&point.inputs.relock, point.inputs.tick_s));
        Ok(late(relocks).into_iter().collect())
    }
}

/// A note that ticks after the last one followed would still count, for some relocks with their ticks in s.
pub(crate) fn late<'a>(relocks: impl Iterator<Item = (&'a Relock, f64)>) -> Option<String> {
    let slow = |(relock, tick_s): &(&Relock, f64)| relock.loop_s / tick_s;
    let (relock, tick_s) = relocks.max_by(|a, b| slow(a).total_cmp(&slow(b)))?;
    let (late, ticks) = (relock.late(tick_s), relock.ticks);
    let (percent, arcsec) = (libm::round(100.0 * late), significant(late * relock.whole_angle(tick_s), 2));
    (late >= LATE).then(|| {
        format!(
            "up to {percent} % of the apparent angle, {arcsec}″ per switch, comes after tick {ticks}: it is in \
             none of the errors and adds to them, unless more ticks are followed (relock.ticks)"
        )
    })
}

/// Fraction of the angle after the last tick from which on a note is given.
const LATE: f64 = 0.01;
