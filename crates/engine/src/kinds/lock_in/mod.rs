//! Studies of lock-in and dither: what a ring laser gyro puts out near its reversals, from its physics. Inputs, points, and
//! the entry in the list of kinds.

pub mod lower;
pub(crate) mod run;
pub mod verify;

use std::sync::Arc;

use crate::chart::{Source, TableSchema};
use crate::key::document::SpanMap;
use crate::key::sweep::{self, SweepTarget, Sweep, Sweepable, SweepValue};
use crate::key::{Key, ParseContext, ValueType, keys, measure, words};
use crate::kinds::allan::columns::coefficient_columns;
use crate::kinds::allan::lower::MAX_SAMPLES;
use crate::kinds::allan::{self, coefficients};
use crate::kinds::lock_in::run::columns;
use crate::motion::Motion;
use crate::motion::keys::Phase;
use crate::sampling::Planned;
use crate::study::{self, Ablation, Kind, Part, ROW, Study, Subject};
use sagnac_base::diagnostics::{Fault, Wrong};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::Dimension;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::abouts;
use sagnac_kernel::lock_in::VERSION;
use sagnac_records::allan::deviation::{Deviation, TauError, Taus};
use sagnac_records::fit::selection::Terms;
use sagnac_theory::allan::{Difference, Estimator, Stride};
use sagnac_theory::lock_in::LockIn;

/// The part of a study that is specific to lock-in.
#[derive(Debug, Clone)]
pub struct LockInStudy {
    /// Order and spacing of the differences of the angle.
    pub estimator: Estimator,
    /// The terms fitted to the curve of each gyro, if any.
    pub terms: Option<Terms>,
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<Point>,
    /// The inputs that all points have in common.
    inputs: Inputs,
    /// The averaging times, where the study needs some.
    taus: Option<Taus>,
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, SweepValue)>,
    /// Inputs that determine the draws.
    pub inputs: Inputs,
    /// Samples of the record and averaging times.
    pub times: Times,
}

/// Every key of this kind.
pub(crate) fn keys() -> Vec<&'static Key> {
    [KEYS, &lower::keys(), allan::CURVE_KEYS].concat()
}

/// The keys that can be swept.
fn sweepable() -> Sweepable<Inputs> {
    Sweepable::new().own(&SETTINGS).own(&lower::SETTINGS)
}

/// Reads the part of a study that belongs to this kind.
pub(crate) fn read(reading: &mut ParseContext) -> Result<LockInStudy, Wrong> {
    let dither = reading
        .get(&DITHER)
        .map(|_| Dither { readout: Readout::from_value(reading.get(&READOUT)), ..Dither::default() });
    let mut inputs = Inputs {
        scale_factor: 0.0,
        threshold: 0.0,
        beam_noise: 0.0,
        refinement: 1.0,
        dither,
        rate: 0.0,
        ramp: 0.0,
        motion: lower::read_motion(reading)?,
        sample_s: None,
        length_s: 0.0,
    };
    reading.set(&mut inputs, &SETTINGS)?;
    reading.note(&[&READOUT, &allan::TAU]);
    let keys = [&allan::TAU, &allan::FIT];
    let taus = keys.iter().any(|key| reading.get(key).is_some());
    let estimate = allan::columns::read(&reading.table)?;
    if let Some(fit) = reading.get(&allan::FIT)
        && estimate.estimator.stride == Stride::Cluster
    {
        let message = "allan.fit conflicts with estimator = \"non-overlapping\" in a study of lock-in";
        return Err(fit.fault(message, "adjacent groups are not fitted", "leave one of them out").into());
    }
    let taus = taus.then_some(estimate.taus);
    let mut study =
        LockInStudy { estimator: estimate.estimator, terms: estimate.terms, points: vec![], inputs, taus };
    study.points = study.points_of(reading.sweeps, &reading.places)?;
    reading.notes.extend(run::of(&study.points));
    Ok(study)
}

impl LockInStudy {
    /// All points of some sweeps, in order.
    ///
    /// # Errors
    /// A sweep does not apply, or the first point that is invalid.
    fn points_of(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<Vec<Point>, Fault> {
        for sweep in sweeps {
            sweep::check_applies(sweep, &self.inputs, &SETTINGS, "the study without [dither]")?;
            sweep::check_applies(sweep, &self.inputs, &lower::SETTINGS, "the motion")?;
        }
        let point = |(swept, inputs): (Vec<_>, Inputs)| {
            let times = check(&inputs, self.taus.as_ref(), self.estimator, places)?;
            Ok(Point { swept, inputs, times })
        };
        sweepable().points(&self.inputs, sweeps).map(point).collect()
    }
}

words! {
    /// The angle that is put out.
    pub enum Readout {
        /// Read at whole periods of the dither, whose angle is zero there.
        Stripped = "stripped",
        /// Read at any time, with the angle of the dither.
        Dithered = "dithered",
        /// Read at any time, less the nominal angle of the dither: what its noise adds remains.
        Demodulated = "demodulated",
    }
}

/// A gyro with lock-in, in ″ and s. Every number has 12 significant digits.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Angle q of a pulse, ″.
    pub scale_factor: f64,
    /// Lock-in threshold Ω_L, ″/s.
    pub threshold: f64,
    /// Angle random walk of the beam's phase, ″/√s.
    pub beam_noise: f64,
    /// Factor on the number of steps.
    pub refinement: f64,
    /// The dither, if there is one.
    pub dither: Option<Dither>,
    /// Input rate at the start, ″/s.
    pub rate: f64,
    /// Its change, ″/s².
    pub ramp: f64,
    /// Motion in addition, the same in every gyro.
    pub motion: Option<Motion>,
    /// Time from one sample to the next, s; chosen where absent.
    pub sample_s: Option<f64>,
    /// Requested length, s; a record has the nearest whole number of samples.
    pub length_s: f64,
}

/// A torsional oscillation of the block. Noise is that of each half-cycle.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Dither {
    /// Frequency f_d, Hz.
    pub frequency_hz: f64,
    /// Amplitude Ω_D of the rate, ″/s.
    pub rate: f64,
    /// Standard deviation of the amplitude, as a part of it.
    pub amplitude_noise: f64,
    /// Standard deviation of the step of the amplitude's random walk, as a part of the amplitude.
    pub amplitude_walk: f64,
    /// Standard deviation of the phase at the reversal, ″.
    pub phase_noise: f64,
    /// The angle that is put out.
    pub readout: Readout,
}

impl Dither {
    /// Standard deviation of the amplitude in the middle of a record, as a part of it.
    pub fn spread(&self, length_s: f64) -> f64 {
        let walked = self.amplitude_walk * libm::sqrt(self.frequency_hz * length_s);
        libm::hypot(self.amplitude_noise, walked)
    }
}

impl Inputs {
    /// The gyro of the closed forms; absent without dither.
    pub fn gyro(&self) -> Option<LockIn> {
        let dither = self.dither.as_ref()?;
        Some(LockIn {
            threshold: self.threshold,
            scale_factor: self.scale_factor,
            dither_rate: dither.rate,
            dither_frequency: dither.frequency_hz,
        })
    }

    /// The angle that is put out.
    pub fn readout(&self) -> Readout {
        self.dither.as_ref().map_or(Readout::Stripped, |dither| dither.readout)
    }

    /// All of its input as a motion, which begins with the record.
    pub fn input(&self) -> Motion {
        let mut input = self.motion.clone().unwrap_or_default();
        input.tones.iter_mut().filter(|tone| tone.phase == Phase::Uniform).for_each(|tone| {
            tone.phase = Phase::ZeroCrossing;
        });
        Motion { rate: self.rate, acceleration: self.ramp, ..input }
    }

    /// Everything that determines the draws and the truth, as lines of text, without the samples. Other steps take the same draws.
    pub(crate) fn canonical(&self) -> String {
        // Every field, so that a new one cannot be left out by mistake; motion, refinement and times are with the point.
        let Inputs {
            scale_factor,
            threshold,
            beam_noise,
            dither,
            rate,
            ramp,
            refinement: _,
            motion: _,
            sample_s: _,
            length_s: _,
        } = self;
        let of_dither = dither.as_ref().map_or(String::new(), |dither| {
            let Dither { frequency_hz, rate, amplitude_noise, amplitude_walk, phase_noise, readout } = dither;
            format!(
                "dither={frequency_hz:.11e}\ndither_rate={rate:.11e}\namplitude_noise={amplitude_noise:.11e}\n\
                 amplitude_walk={amplitude_walk:.11e}\nphase_noise={phase_noise:.11e}\nreadout={}\n",
                readout.name()
            )
        });
        format!(
            "scale_factor={scale_factor:.11e}\nthreshold={threshold:.11e}\nbeam_noise={beam_noise:.11e}\n\
             rate={rate:.11e}\nramp={ramp:.11e}\n{of_dither}"
        )
    }
}

const SCALES: ValueType = measure(&[Dimension::ScaleFactor], 1e-6, 1e6, "1e-6 to 1e6 arcsec/pulse");
const THRESHOLDS: ValueType = measure(&[Dimension::Rate], 1e-9, 1e6, "1e-9 to 1e6 arcsec/s");
const WALKS: ValueType = measure(&[Dimension::AngleRandomWalk], 0.0, 1e3, "0 to 1e3 deg/sqrt(h)");
const FACTORS: ValueType = measure(&[Dimension::Ratio], 0.25, 16.0, "0.25 to 16");
const FREQUENCIES: ValueType = measure(&[Dimension::Frequency], 1e-3, 1e6, "0.001 Hz to 1e6 Hz");
const AMPLITUDES: ValueType = measure(&[Dimension::Rate], 1e-6, 1e9, "1e-6 to 1e9 arcsec/s");
const RATIOS: ValueType = measure(&[Dimension::Ratio], 0.0, 0.1, "0 to 0.1, or 0 % to 10 %");
const PHASES: ValueType = measure(&[Dimension::Angle], 0.0, 36_000.0, "0 to 10 deg");
const RATES: ValueType = measure(&[Dimension::Rate], -1e9, 1e9, "-1e9 to 1e9 arcsec/s");
const RAMPS: ValueType = measure(&[Dimension::AngularAcceleration], -1e9, 1e9, "-1e9 to 1e9 arcsec/s^2");
const TIMES: ValueType = measure(&[Dimension::Time], 1e-6, 1e6, "1 µs to 1e6 s");

keys! {
    /// The keys of the gyro, its dither and its input.
    pub(crate) static KEYS;
    /// The gyro.
    GYRO = "gyro", "", Fixed, ValueType::Table, "[gyro]\nscale_factor = \"2 arcsec/pulse\"";
    /// Scale factor q, the input angle of one period of the beat: "2 arcsec/pulse".
    pub SCALE_FACTOR = "gyro.scale_factor", "scale factor", Choice, SCALES, r#"scale_factor = "2 arcsec/pulse""#, required;
    /// Lock-in of the two beams.
    LOCK_IN_TABLE = "lock_in", "", Fixed, ValueType::Table, "[lock_in]\nthreshold = \"180 arcsec/s\"";
    /// Lock-in threshold Ω_L, the largest rate that a gyro without dither does not see: "180 arcsec/s".
    pub THRESHOLD = "lock_in.threshold", "lock-in threshold", Condition, THRESHOLDS, r#"threshold = "180 arcsec/s""#, required;
    /// White phase noise of the beam, as the angle random walk that it causes without lock-in; 0 if absent.
    BEAM_NOISE = "lock_in.beam_noise", "phase noise of the beam", Choice, WALKS, r#"beam_noise = "0.0002 deg/sqrt(h)""#;
    /// Factor on the number of steps of the integration, to see that the results do not depend on it; 1 if absent.
    pub(crate) REFINEMENT = "lock_in.refinement", "factor on the steps", Choice, FACTORS, "refinement = 2";
    /// Dither, a torsional oscillation of the block, which keeps the gyro out of lock-in; none if absent. Its noise is that of each
    /// half-cycle, from one zero crossing of its angle to the next.
    pub DITHER = "dither", "", Fixed, ValueType::Table, "[dither]\nfrequency = \"400 Hz\"\nrate = \"100 deg/s\"\namplitude_noise = \"2 %\"";
    /// Dither frequency f_d: "400 Hz".
    pub FREQUENCY = "dither.frequency", "dither frequency", Choice, FREQUENCIES, r#"frequency = "400 Hz""#, required;
    /// Amplitude Ω_D of the dither rate: "100 deg/s".
    pub(crate) DITHER_RATE = "dither.rate", "amplitude of the dither rate", Choice, AMPLITUDES, r#"rate = "100 deg/s""#, required;
    /// Randomization: standard deviation of the amplitude, independent in each half-cycle, as a part of the amplitude; 0 if absent.
    pub AMPLITUDE_NOISE = "dither.amplitude_noise", "amplitude noise of the dither", Choice, RATIOS, r#"amplitude_noise = "2 %""#;
    /// Standard deviation of the step of the amplitude's random walk from half-cycle to half-cycle, as a part of the amplitude; 0 if
    /// absent.
    AMPLITUDE_WALK = "dither.amplitude_walk", "amplitude walk of the dither", Choice, RATIOS, r#"amplitude_walk = "0.01 %""#;
    /// Standard deviation of the dither's phase at each reversal, which leaves the zero crossings where they are; 0 if absent.
    PHASE_NOISE = "dither.phase_noise", "phase noise of the dither", Choice, PHASES, r#"phase_noise = "0.5 deg""#;
    /// The angle that is put out; "stripped" if absent.
    pub READOUT = "dither.readout", "", Fixed, ValueType::Word(Readout::WORDS), r#"readout = "stripped""#;
    /// Input rate of the gyro; none if absent.
    INPUT = "input", "", Fixed, ValueType::Table, "[input]\nrate = \"37 arcsec/s\"";
    /// Input rate Ω at the start: "37 arcsec/s"; 0 if absent.
    pub RATE = "input.rate", "input rate", Condition, RATES, r#"rate = "37 arcsec/s""#;
    /// Change of the input rate, for a slow passage through a dead band: "1 arcsec/s^2"; 0 if absent.
    pub(crate) RAMP = "input.ramp", "ramp of the input rate", Choice, RAMPS, r#"ramp = "1 arcsec/s^2""#;
    /// The record of the angle.
    RECORD = "record", "", Fixed, ValueType::Table, "[record]\nlength = \"10 s\"";
    /// Time from one sample of the angle to the next, rounded to whole periods of the dither unless it is left in; one period, or 10 ms
    /// without dither, if absent.
    pub SAMPLE = "record.sample", "sampling time", Choice, TIMES, r#"sample = "5 ms""#;
    /// Length of the record, rounded to whole samples: "10 s".
    pub LENGTH = "record.length", "length of the record", Choice, TIMES, r#"length = "10 s""#, required;
}

/// The settings of these keys. Those of the dither apply where there is one.
pub(crate) static SETTINGS: [SweepTarget<Inputs>; 13] = [
    SweepTarget::new(&SCALE_FACTOR, |inputs, scale| inputs.scale_factor = scale.value),
    SweepTarget::new(&THRESHOLD, |inputs, threshold| inputs.threshold = threshold.value),
    SweepTarget::new(&BEAM_NOISE, |inputs, noise| inputs.beam_noise = noise.value),
    SweepTarget::new(&REFINEMENT, |inputs, factor| inputs.refinement = factor.value),
    SweepTarget::where_it_applies(&FREQUENCY, is_dithered, |inputs, frequency| {
        with_dither(inputs, |dither| dither.frequency_hz = frequency.value);
    }),
    SweepTarget::where_it_applies(&DITHER_RATE, is_dithered, |inputs, rate| {
        with_dither(inputs, |dither| dither.rate = rate.value)
    }),
    SweepTarget::where_it_applies(&AMPLITUDE_NOISE, is_dithered, |inputs, noise| {
        with_dither(inputs, |dither| dither.amplitude_noise = noise.value);
    }),
    SweepTarget::where_it_applies(&AMPLITUDE_WALK, is_dithered, |inputs, step| {
        with_dither(inputs, |dither| dither.amplitude_walk = step.value);
    }),
    SweepTarget::where_it_applies(&PHASE_NOISE, is_dithered, |inputs, noise| {
        with_dither(inputs, |dither| dither.phase_noise = noise.value);
    }),
    SweepTarget::new(&RATE, |inputs, rate| inputs.rate = rate.value),
    SweepTarget::new(&RAMP, |inputs, ramp| inputs.ramp = ramp.value),
    SweepTarget::new(&SAMPLE, |inputs, sample| inputs.sample_s = Some(sample.value)),
    SweepTarget::new(&LENGTH, |inputs, length| inputs.length_s = length.value),
];

fn is_dithered(inputs: &Inputs) -> bool {
    inputs.dither.is_some()
}

fn with_dither(inputs: &mut Inputs, set: impl FnOnce(&mut Dither)) {
    if let Some(dither) = &mut inputs.dither {
        set(dither);
    }
}

/// Fewest samples of a record.
const MIN_SAMPLES: u64 = 16;

/// Sampling time without dither, s.
const USUAL_SAMPLE_S: f64 = 0.01;

/// Inverse of the averaging time relative to the record, where none is given: most of the record's reversals then count in each
/// estimate of N, and each averaging time has many of them.
const USUAL_PART: u64 = 64;

/// Relative deviation of an averaging time from a whole number of samples that counts as rounding.
const WHOLE: f64 = 1e-9;

/// The times of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Times {
    /// Time from one sample to the next, s.
    pub sample_s: f64,
    /// Periods of the dither in it; 0 where samples are not tied to them.
    pub periods: u64,
    /// Number of samples N; there are N + 1 angles.
    pub samples: u64,
    /// Averaging factors, ascending.
    pub ms: Vec<u64>,
}

impl Times {
    /// Length of the record, s.
    pub fn length_s(&self) -> f64 {
        self.sample_s * self.samples as f64
    }
}

/// Checks limits that involve more than one value, and chooses the times that are not given.
pub(crate) fn check(
    inputs: &Inputs,
    taus: Option<&Taus>,
    estimator: Estimator,
    places: &SpanMap,
) -> Result<Times, Fault> {
    if let Some(dither) = &inputs.dither
        && dither.rate <= inputs.threshold
    {
        let message = format!(
            "lock_in.threshold = {} ″/s is not below the amplitude of the dither rate, {} ″/s: the gyro is locked",
            significant(inputs.threshold, 6),
            significant(dither.rate, 6)
        );
        let help = "accepted: a threshold below dither.rate, or leave [dither] out for a gyro without dither";
        return places.refuse(&[THRESHOLD.name, DITHER_RATE.name], message, "locked", help);
    }
    let (sample_s, periods) = sampled(inputs);
    let samples = libm::round(inputs.length_s / sample_s);
    if !(MIN_SAMPLES as f64..=MAX_SAMPLES as f64).contains(&samples) {
        let label = if samples < MIN_SAMPLES as f64 { "too short" } else { "too long" };
        let [length, sample] = [inputs.length_s, sample_s].map(|s| significant(s, 6));
        let message =
            format!("record.length = {length} s is {} samples of {sample} s", significant(samples, 6));
        let [shortest, longest] =
            [MIN_SAMPLES, MAX_SAMPLES].map(|samples| significant(samples as f64 * sample_s, 6));
        let help =
            format!("accepted: {MIN_SAMPLES} to {MAX_SAMPLES} samples, {shortest} s to {longest} s here");
        return places.refuse(&[LENGTH.name, SAMPLE.name, FREQUENCY.name], message, label, help);
    }
    let samples = samples as u64;
    let ms = factors(sample_s, samples, taus, estimator, places)?;
    Ok(Times { sample_s, periods, samples, ms })
}

/// Time from one sample to the next, s, and the periods of the dither in it.
fn sampled(inputs: &Inputs) -> (f64, u64) {
    match &inputs.dither {
        None => (inputs.sample_s.unwrap_or(USUAL_SAMPLE_S), 0),
        Some(dither) => {
            let asked = inputs.sample_s.map_or(1.0, |sample_s| sample_s * dither.frequency_hz);
            if dither.readout == Readout::Stripped {
                let periods = libm::fmax(libm::round(asked), 1.0);
                return (periods / dither.frequency_hz, periods as u64);
            }
            (asked / dither.frequency_hz, 0)
        }
    }
}

/// The averaging factors of the record's angles.
fn factors(
    sample_s: f64,
    samples: u64,
    taus: Option<&Taus>,
    estimator: Estimator,
    places: &SpanMap,
) -> Result<Vec<u64>, Fault> {
    let Some(taus) = taus else { return Ok(vec![1 << (samples / USUAL_PART).max(1).ilog2()]) };
    let fault = |message: String, label| {
        let help = "give multiples of the sampling time, a longer record, or tau = \"octave\"";
        Err(Fault::new(places.blame(&["allan.tau"]), message, label, help))
    };
    if let Taus::Seconds(times) = taus {
        for tau_s in times {
            let m = tau_s / sample_s;
            if libm::fabs(m - libm::round(m)) > WHOLE * m {
                let [tau, sample] = [*tau_s, sample_s].map(|s| significant(s, 9));
                return fault(
                    format!("allan.tau = {tau} s is no multiple of {sample} s"),
                    "between two samples",
                );
            }
        }
    }
    let deviation = match estimator.difference {
        Difference::Second => Deviation::Oadev,
        Difference::Third => Deviation::Ohdev,
    };
    let found = taus.factors(samples as usize + 1, sample_s, deviation);
    let mut ms: Vec<u64> = match found {
        Ok(found) => found.into_iter().map(|m| m as u64).collect(),
        Err(error) => {
            let text = error.to_string();
            let label =
                if matches!(error, TauError::Long { .. }) { "too long" } else { "not for this record" };
            return fault(format!("allan.tau: {}", text.lines().next().unwrap_or_default()), label);
        }
    };
    if let (Taus::Decade(_), Stride::Part(parts)) = (taus, estimator.stride) {
        // Differences are whole strides apart, and a factor without divisors would force a stride of one sample.
        ms.iter_mut().for_each(|m| *m -= *m % (1 << (*m / parts).max(1).ilog2()));
        ms.dedup();
    }
    Ok(ms)
}

/// The output of a gyro with lock-in and dither.
pub(crate) static LOCK_IN: Kind = Kind {
    name: "lock-in",
    subject: "The output of a ring laser gyro with lock-in and dither: scale factor, lock-in zones and angle random walk.",
    about: "Integrates the beat phase of many gyros with lock-in, with or without dither. points.csv has the mean output rate, \
            `mean_rate`, and the angle random walk that lock-in leaves, `angle_random_walk`, beside their closed forms where there \
            are any; with [allan], a row for each averaging time, and coefficients.csv where coefficients are fitted.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 256,
    needs: &["gyro", "lock_in", "record"],
    keys,
    sweepable: || sweepable().keys(),
    columns: &[
        (Source::Points, || abouts(&columns())),
        (Source::Coefficients, || abouts(&coefficient_columns())),
    ],
    kernels: || format!("lock_in {VERSION}"),
    loads: crate::kinds::lock_in::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

impl Subject for LockInStudy {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let plan = run::plan(study, self, progress)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Ablation> {
        let Point { swept, inputs, times } = self.points.get(point)?;
        let (parts, inputs) = study::points(inputs, &PARTS);
        let of = |inputs| Point { swept: swept.clone(), inputs, times: times.clone() };
        let points = inputs.into_iter().map(of).collect();
        Some(Ablation { parts, subject: Arc::new(LockInStudy { points, ..self.clone() }) })
    }

    fn with_points(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<Arc<dyn Subject>, Fault> {
        let points = self.points_of(sweeps, places)?;
        Ok(Arc::new(LockInStudy { points, ..self.clone() }))
    }

    fn bytes(&self) -> u64 {
        ROW * self.points.iter().map(|point| point.times.ms.len() as u64).sum::<u64>()
    }

    fn grounds(&self) -> Vec<TableSchema> {
        let limits = &[Dimension::ShortAngleRandomWalk, Dimension::Rate];
        vec![
            TableSchema::new(Source::Points, abouts(&columns()), [], limits),
            coefficients(self.terms.as_ref()),
        ]
    }
}

/// All parts. The threshold has no value without lock-in, so a negligible one takes its place.
static PARTS: [Part<Inputs>; 5] = [
    Part { name: "lock-in", off: |inputs| inputs.threshold *= NEGLIGIBLE },
    Part { name: "noise of the beam", off: |inputs| inputs.beam_noise = 0.0 },
    Part {
        name: "amplitude noise of the dither",
        off: |inputs| with_dither(inputs, |dither| dither.amplitude_noise = 0.0),
    },
    Part {
        name: "amplitude walk of the dither",
        off: |inputs| with_dither(inputs, |dither| dither.amplitude_walk = 0.0),
    },
    Part {
        name: "phase noise of the dither",
        off: |inputs| with_dither(inputs, |dither| dither.phase_noise = 0.0),
    },
];

/// Part of the threshold that has no effect.
const NEGLIGIBLE: f64 = 1e-6;
