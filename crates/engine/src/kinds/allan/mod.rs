//! Studies of Allan curves: the points with their records and noise, the keys, and the entry in the list of kinds.

pub mod columns;
pub mod lower;
pub mod run;
pub mod verify;

use std::sync::Arc;

use crate::chart::{Source, TableSchema, Text};
use crate::key::document::SpanMap;
use crate::key::sweep::{SweepTarget, Sweep, Sweepable, SweepValue, of_name};
use crate::key::{Key, ParseContext, ValueType, keys, measure, words};
use crate::kinds::allan::columns::Estimate;
use crate::kinds::allan::lower::MAX_SAMPLES;
use crate::noise::{self, FILE, Noise, NoiseFiles, READOUT_LSB, WrittenNoise, swept_files, values};
use crate::sampling::Planned;
use crate::study::{self, Ablation, Kind, Part, ROW, Study, Subject};
use sagnac_base::diagnostics::{Fault, Wrong};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, Quantity};
use sagnac_base::table::column::abouts;
use sagnac_kernel::allan::VERSION;
use sagnac_records::allan::deviation::{Deviation, TauError, Taus};
use sagnac_records::fit::selection::Terms;
use sagnac_theory::allan::terms::Term;
use sagnac_theory::allan::{Difference, Estimator, Stride};

/// The part of a study that is specific to Allan curves.
#[derive(Debug, Clone)]
pub struct Allan {
    /// Order and spacing of the differences.
    pub estimator: Estimator,
    /// The terms fitted to each record, if any.
    pub terms: Option<Terms>,
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<Point>,
    /// The inputs that all points have in common.
    base: Base,
}

/// Every key of this kind.
fn keys() -> Vec<&'static Key> {
    [KEYS, CURVE_KEYS, noise::KEYS].concat()
}

/// The keys that can be swept.
fn sweepable() -> Sweepable<Base> {
    Sweepable::new()
        .part(&SETTINGS, |base: &mut Base| Some(&mut base.inputs))
        .part(&noise::SETTINGS, |base| Some(&mut base.inputs.noise))
        .name(&FILE, |base: &mut Base, name| {
            base.inputs.noise = of_name(&base.files, name).unwrap_or_default();
        })
}

/// Reads the part of a study that belongs to this kind.
fn read(reading: &mut ParseContext) -> Result<Allan, Wrong> {
    let mut inputs = Inputs { sample_s: 0.0, length_s: 0.0, rate: 0.0, noise: Noise::default() };
    reading.set(&mut inputs, &SETTINGS)?;
    let WrittenNoise { noise, written } = noise::read(reading)?;
    reading.note(&[&ALLAN_TABLE, &TAU]);
    let estimate = columns::read(&reading.table)?;
    let files = swept_files(reading, &written)?;
    let base = Base { inputs: Inputs { noise, ..inputs }, files, estimate };
    let allan = base.with_points(reading.sweeps, &reading.places)?;
    reading.notes.extend(columns::of(allan.terms.as_ref(), &allan.points));
    Ok(allan)
}

/// Lets a fit that chooses its terms choose Markov noise and a sine where the noise has them.
fn with_shapes(terms: Terms, points: &[Point]) -> Terms {
    let Terms::Auto(mut terms) = terms else { return terms };
    let is_there = |term: &Term| points.iter().any(|point| point.inputs.noise.has(*term));
    terms.extend(Term::ALL.into_iter().filter(|term| term.has_shape() && is_there(term)));
    Terms::Auto(terms)
}

words! {
    /// The estimated variance.
    pub(crate) enum EstimatorName {
        /// Allan variance of all second differences.
        Overlapping = "overlapping",
        /// Allan variance of adjacent groups.
        NonOverlapping = "non-overlapping",
        /// Overlapping Hadamard variance, which is insensitive to a ramp.
        Hadamard = "hadamard",
    }
}

words! {
    /// The fraction of the overlapping differences that is used.
    pub(crate) enum Overlap {
        /// 64 differences in each averaging time, which increases the scatter by less than 0.2 %.
        Part64 = "m/64",
        /// All differences.
        Full = "full",
    }
}

const SAMPLES: ValueType = measure(&[Dimension::Time], 1e-6, 1e6, "1 µs to 1e6 s");
const LENGTHS: ValueType = measure(&[Dimension::Time], 1e-6, 1e12, "1 µs to 1e12 s");
const RATES: ValueType = measure(&[Dimension::DriftRate], -1e9, 1e9, "-1e9 to 1e9 deg/h");
const TEXTS: ValueType = ValueType::Either(&[ValueType::Any, ValueType::List(&ValueType::Any)]);

keys! {
    /// The keys of the record.
    pub(crate) static KEYS;
    /// The record of a gyro at rest.
    RECORD = "record", "", Fixed, ValueType::Table, "[record]\nsample = \"1 s\"\nlength = \"9 h\"";
    /// Time from one sample to the next: "1 s".
    SAMPLE = "record.sample", "sampling time", Choice, SAMPLES, r#"sample = "1 s""#, required;
    /// Time from the first sample to the last: "9 h". It is rounded to a whole number of samples.
    pub LENGTH = "record.length", "length of the record", Choice, LENGTHS, r#"length = "9 h""#, required;
    /// Constant rate, such as the Earth's on the input axis: "10 deg/h". It affects only a readout in whole pulses.
    pub RATE = "record.rate", "constant rate", Condition, RATES, r#"rate = "10 deg/h""#;
}

keys! {
    /// The keys of the curve and its fit, for every kind of study that has one.
    pub(crate) static CURVE_KEYS;
    /// Estimates made from each record.
    pub(crate) ALLAN_TABLE = "allan", "", Fixed, ValueType::Table, "[allan]\ntau = \"octave\"\nfit = [\"Q\", \"N\", \"B\"]";
    /// Averaging times: "octave", "decade10", "decade20", or ["1 s", "10 s"]; octave if absent.
    pub TAU = "allan.tau", "", Fixed, TEXTS, r#"tau = "octave""#;
    /// Estimated variance; "overlapping" if absent.
    pub(crate) ESTIMATOR = "allan.estimator", "", Fixed, ValueType::Word(EstimatorName::WORDS), r#"estimator = "overlapping""#;
    /// Fraction of the overlapping differences that is used; "m/64" if absent.
    pub(crate) OVERLAP = "allan.overlap", "", Fixed, ValueType::Word(Overlap::WORDS), r#"overlap = "full""#;
    /// Coefficients fitted to each record: "auto" for those of Q, N, B, K, R that it supports, or some of "Q", "N",
    /// "B", "K", "R", "markov", "sine"; none if absent.
    pub(crate) FIT = "allan.fit", "", Fixed, TEXTS, r#"fit = ["Q", "N", "B"]"#;
}

/// The settings of these keys, except the noise.
static SETTINGS: [SweepTarget<Inputs>; 3] = [
    SweepTarget::new(&SAMPLE, |inputs, sample| inputs.sample_s = sample.value),
    SweepTarget::new(&LENGTH, |inputs, length| inputs.length_s = length.value),
    SweepTarget::new(&RATE, |inputs, rate| inputs.rate = rate.value),
];

/// Allan curves of simulated records.
pub(crate) static ALLAN: Kind = Kind {
    name: "allan",
    subject: "The Allan curve of a gyro at rest, and the coefficients fitted to it.",
    about: "Simulates records of a gyro at rest with the noise of [noise], computes the Allan curve of each and fits the coefficients. \
            points.csv has the mean curve, `adev` over `tau`, with the band of single records, `adev_lo` to `adev_hi`; \
            coefficients.csv has the accuracy with which each coefficient is recovered: `mean`, `rmse`, `coverage95`.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 1000,
    needs: &["record", "noise"],
    keys,
    sweepable: || sweepable().keys(),
    columns: &[
        (Source::Points, || abouts(&columns::columns())),
        (Source::Coefficients, || abouts(&columns::coefficient_columns())),
    ],
    kernels: || format!("allan {VERSION}"),
    loads: crate::kinds::allan::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

/// Description of the bands of charts.
const BANDS: &str = "95 % of records";

impl Subject for Allan {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let plan = run::plan(study, self, progress)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Ablation> {
        let (parts, points) = dissected(self.points.get(point)?);
        Some(Ablation { parts, subject: Arc::new(Allan { points, ..self.clone() }) })
    }

    fn with_points(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<Arc<dyn Subject>, Fault> {
        Ok(Arc::new(self.base.with_points(sweeps, places)?))
    }

    fn values(&self, point: usize) -> Vec<(&'static Key, Quantity)> {
        self.points.get(point).map(|point| values(&point.inputs.noise)).unwrap_or_default()
    }

    fn bytes(&self) -> u64 {
        ROW * self.points.iter().map(|point| point.ms.len() as u64).sum::<u64>()
    }

    fn grounds(&self) -> Vec<TableSchema> {
        vec![
            TableSchema {
                legend: ["mean of records", BANDS],
                ..TableSchema::new(Source::Points, abouts(&columns::columns()), [], &[Dimension::DriftRate])
            },
            coefficients(self.terms.as_ref()),
        ]
    }
}

/// The table of coefficients, for every kind of study that fits them.
pub(crate) fn coefficients(terms: Option<&Terms>) -> TableSchema {
    let shapes = Term::ALL.into_iter().filter_map(|term| Some(term.shape()?.symbol));
    let coefficients = Term::ALL.map(Term::symbol).into_iter().chain(shapes);
    let not_fitted =
        ("the chart is of coefficients, and none are fitted", "add them as in\n[allan]\nfit = \"auto\"");
    TableSchema {
        legend: ["Monte Carlo", BANDS],
        absent: terms.is_none().then_some(not_fitted),
        ..TableSchema::new(
            Source::Coefficients,
            abouts(&columns::coefficient_columns()),
            [Text::new(coefficients)],
            &[],
        )
    }
}

/// The parts besides the terms of the noise.
static OTHERS: [Part<Noise>; 3] = [
    Part { name: "lock-in", off: |noise| noise.lock_in = None },
    Part { name: "whole pulses of the readout", off: |noise| noise.readout_lsb = 0.0 },
    Part { name: "mode switches", off: |noise| noise.switching = None },
];

/// A point as it is, and without each term of its noise and each other part in turn.
fn dissected(point: &Point) -> (Vec<&'static str>, Vec<Point>) {
    let noise = &point.inputs.noise;
    let (mut names, mut noises) = study::points(noise, &OTHERS);
    for term in Term::EVERY.into_iter().filter(|term| noise.has(*term)) {
        let without = noise.without(term);
        // An angle random walk by lock-in alone is the part above.
        if without != *noise {
            names.push(term.row().name[1]);
            noises.push(without);
        }
    }
    let with = |noise| Point { inputs: Inputs { noise, ..point.inputs.clone() }, ..point.clone() };
    (names, noises.into_iter().map(with).collect())
}

/// Fewest samples of a record.
const MIN_SAMPLES: u64 = 16;
/// Relative deviation of a listed time from a whole number of samples that counts as rounding, since not all decimal
/// fractions are exact.
const WHOLE: f64 = 1e-9;

/// The inputs of a record, in ″ and s. Every number has 12 significant digits.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Time from one sample to the next, s.
    pub sample_s: f64,
    /// Requested length, s; a record has the nearest whole number of samples.
    pub length_s: f64,
    /// Constant rate, ″/s, which affects a readout in whole pulses.
    pub rate: f64,
    /// Noise coefficients.
    pub noise: Noise,
}

impl Inputs {
    /// Number of rate samples of a record.
    pub fn samples(&self) -> u64 {
        libm::round(self.length_s / self.sample_s) as u64
    }
}

/// One combination of swept values, with everything derived from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, SweepValue)>,
    /// Inputs that determine the draws.
    pub inputs: Inputs,
    /// Averaging factors, ascending.
    pub ms: Vec<u64>,
}

/// The inputs common to all points.
#[derive(Debug, Clone)]
struct Base {
    inputs: Inputs,
    /// The noise of each file of a sweep over files, combined with the keys of the study.
    files: NoiseFiles,
    estimate: Estimate,
}

impl Base {
    /// The study at all points of some sweeps, in order.
    ///
    /// # Errors
    /// A sweep over an absent part of the noise, or over a rate without effect, or the first point that is invalid.
    fn with_points(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<Allan, Fault> {
        let noises = noise::all(&self.inputs.noise, &self.files);
        let pulses = sweeps.iter().any(|sweep| sweep.key.name == READOUT_LSB.name)
            || noises.iter().any(|noise| noise.readout_lsb > 0.0);
        if let Some(sweep) = sweeps.iter().find(|sweep| sweep.key.name == RATE.name && !pulses) {
            let message = "record.rate is swept, but a constant rate affects only a readout in whole pulses";
            return Err(sweep.fault(message, "no effect", "give noise.readout_lsb, or leave the sweep out"));
        }
        noise::check_sweeps(&noises, places, sweeps)?;
        let point = |(swept, Base { inputs, .. }): (Vec<_>, Base)| {
            check(&inputs, places)?;
            let ms = self.factors(&inputs, &swept, places)?;
            Ok(Point { swept, inputs, ms })
        };
        let points = sweepable().points(self, sweeps).map(point).collect::<Result<Vec<Point>, Fault>>()?;
        let terms = self.estimate.terms.clone().map(|terms| with_shapes(terms, &points));
        Ok(Allan { estimator: self.estimate.estimator, terms, points, base: self.clone() })
    }

    /// The averaging factors of the point's records.
    fn factors(
        &self,
        inputs: &Inputs,
        swept: &[(&'static str, SweepValue)],
        places: &SpanMap,
    ) -> Result<Vec<u64>, Fault> {
        let Estimate { taus, estimator, .. } = &self.estimate;
        let place = || places.blame(&["allan.tau"]);
        if let Taus::Seconds(times) = taus {
            for tau_s in times {
                let m = tau_s / inputs.sample_s;
                if (m - libm::round(m)).abs() > WHOLE * m {
                    let message =
                        format!("τ = {tau_s} s is not a whole number of samples of {} s", inputs.sample_s);
                    let help = "give multiples of record.sample, or tau = \"octave\"";
                    return Err(Fault::new(place(), message, "between two samples", help));
                }
            }
        }
        let deviation = match estimator.difference {
            Difference::Second => Deviation::Oadev,
            Difference::Third => Deviation::Ohdev,
        };
        let angles = inputs.samples() as usize + 1;
        let factors = taus.factors(angles, inputs.sample_s, deviation).map_err(|error| {
            let message = error.to_string();
            let message = message.lines().next().unwrap_or_default();
            let help = match error {
                TauError::Long { .. } => "leave it out, lengthen the record, or write tau = \"octave\"",
                _ => "give multiples of record.sample, or tau = \"octave\"",
            };
            let at: String = swept.iter().map(|(key, value)| format!(", at {key} = {value}")).collect();
            Fault::new(place(), format!("allan.tau: {message}{at}"), "not for this record", help)
        })?;
        let mut ms: Vec<u64> = factors.into_iter().map(|m| m as u64).collect();
        if let (Taus::Decade(_), Stride::Part(parts)) = (taus, estimator.stride) {
            // Differences are whole strides apart, and a factor without divisors would force a stride of one sample.
            let rounded = |m: &mut u64| *m -= *m % (1 << (*m / parts).max(1).ilog2());
            ms.iter_mut().for_each(rounded);
            ms.dedup();
        }
        Ok(ms)
    }
}

/// Checks limits that involve more than one value.
fn check(inputs: &Inputs, places: &SpanMap) -> Result<(), Fault> {
    let Inputs { sample_s, length_s, noise, .. } = inputs;
    let samples = inputs.samples();
    if !(MIN_SAMPLES..=MAX_SAMPLES).contains(&samples) {
        let label = if samples < MIN_SAMPLES { "too short" } else { "too long" };
        let message = format!("record.length = {length_s} s is {samples} samples of {sample_s} s");
        let [shortest, longest] =
            [MIN_SAMPLES, MAX_SAMPLES].map(|samples| significant(samples as f64 * sample_s, 6));
        let help =
            format!("accepted: {MIN_SAMPLES} to {MAX_SAMPLES} samples, {shortest} s to {longest} s here");
        return places.refuse(&["record.length", "record.sample"], message, label, help);
    }
    noise.lock_in.map_or(Ok(()), |lock_in| lock_in.check(places))?;
    let [_, sine_hz] = noise.of(Term::Sine);
    if sine_hz * sample_s > 0.5 {
        let nyquist = significant(0.5 / sample_s, 6);
        let message = format!(
            "noise.sine.frequency = {} Hz is above the Nyquist frequency of samples of {sample_s} s",
            significant(sine_hz, 6)
        );
        let help = format!("accepted: up to {nyquist} Hz, or a shorter record.sample");
        let names = ["noise.sine.frequency", "noise.sine", "record.sample"];
        return places.refuse(&names, message, "too high for the samples", help);
    }
    if let Some(switching) = noise.switching
        && !(1..samples).contains(&switching.interval(*sample_s))
    {
        let interval = switching.interval(*sample_s);
        let interval_s = significant(switching.interval_s, 6);
        let message = match interval {
            0 => format!(
                "noise.switching.interval = {interval_s} s is less than half a sample of {sample_s} s"
            ),
            _ => format!(
                "noise.switching.interval = {interval_s} s: there is no switch in a record of {length_s} s"
            ),
        };
        let label = if interval == 0 { "too short" } else { "too long" };
        let longest = significant((samples - 1) as f64 * sample_s, 6);
        let help = format!("accepted: {sample_s} s to {longest} s here, or leave [noise.switching] out");
        let names = ["noise.switching.interval", "noise.file", "record.length", "record.sample"];
        return places.refuse(&names, message, label, help);
    }
    let is_silent = noise.process(*sample_s, samples).parts.is_empty() && noise.readout_lsb == 0.0;
    if is_silent && noise.switched(*sample_s).is_none() {
        let message = "[noise] is empty: all records would be constant";
        let help =
            "add a coefficient as in angle_random_walk = \"0.00048 deg/sqrt(h)\", or file = \"noise.toml\"";
        return places.refuse(&["noise"], message, "no noise", help);
    }
    Ok(())
}
