//! The expected estimates of records, from the words of the kernel.
//!
//! Independent parts add in the mean square of a difference, each by its closed form, and the drift by its table. The
//! kernel rounds the angle, the sine, fill residuals and quantization noise down to whole LSB. Where the angle moves by
//! a normal number of one LSB or more from sample to sample, its rounding is uniform, white and independent of
//! everything else, up to a factor e^{−2π²} and except for the first angle, which is 0. Otherwise, and for the sine and
//! fill residuals, rounding is bounded by |E(D + d)² − ED²| ≤ 2·rms D·d + d², where d is the largest difference that it
//! can make.
//!
//! Random parts add by the closed forms of their terms. The differences of what all records share are a sum of
//! G(k)·e^{−λk} over ramp, warm-ups and the alternating drift, where G has the period of two intervals between switches:
//! the mean of their square is a geometric sum for each residue of k.

use crate::key::{Streams, Unrepresentable, shown};
use crate::kinds::allan::lower::fixed::{self, Fixed, SIGMA_UNITS, TURN, loss};
use crate::kinds::allan::lower::{Asked, Markov, Model, Noise, Records, Sine, reach};
use crate::kinds::allan::{Inputs as RecordInputs, Point, Point as RecordPoint};
use crate::kinds::plan::identity;
use crate::store::Address;
use crate::tally::Id;
use sagnac_base::quantity::number::significant;
use sagnac_theory::allan::markov::mean_of_decay;
use sagnac_theory::allan::{Difference, Estimator, Process, Stride};
use sagnac_theory::drift::{Jumps, Switching};
use sagnac_theory::pulse;

/// The expected estimate for the lowered words, (″/s)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Theory {
    /// Expected value; absent where it is not known to 1 %.
    pub value: Option<f64>,
    /// Bound of the deviation of the expected estimate from `value`, due to rounding in the kernel and to readouts
    /// without a closed form.
    pub rounding: f64,
    /// Bound of the deviation of `value` from that of the inputs, due to the rounding of words.
    pub representation: f64,
}

/// Largest ratio of the bound to the value.
const MAX_ROUNDING: f64 = 0.01;

/// Error of the variance of the kernel's normal numbers, with a margin.
const NORMAL_ERROR: f64 = 1e-8;
/// Error of the kernel's sine.
const SINE_ERROR: f64 = 1.0 / 759_250_125.0; // 2^−29.5
/// Error of sums in floating point.
const SUM_ERROR: f64 = 1e-12;

/// Error of both closed forms in floating point, relative.
const REPRESENTATION_ERROR: f64 = 1e-10;

/// A mean square with its bound of error, and that of its deviation from the mean square of the inputs, LSB².
#[derive(Clone, Copy)]
struct Square {
    value: f64,
    error: f64,
    representation: f64,
}

impl Square {
    fn add(&mut self, value: f64, error: f64) {
        self.value += value;
        self.error += error;
    }
}

impl Records {
    /// The expected estimate at `ms()[at]`. For records with drift it takes as long as summing their differences.
    pub fn theory(&self, at: usize) -> Theory {
        let unit = self.variance_of_square(at);
        let Square { value, error, representation } = self.mean_square(at);
        let error = error + SUM_ERROR * value;
        Theory {
            value: (error <= MAX_ROUNDING * value).then_some(value * unit),
            rounding: error * unit,
            representation: (representation + REPRESENTATION_ERROR * value) * unit,
        }
    }

    /// Expected square of the differences at `ms[at]`.
    fn mean_square(&self, at: usize) -> Square {
        let (m, terms) = (self.ms[at], self.terms[at]);
        let (fixed, difference) = (&self.fixed, self.estimator.difference);
        let noise = fixed.noise();
        let stride = self.estimator.stride(m) as usize;
        let [trend, first] = fixed::differences(&self.recipe.drift, difference, stride, m as usize, terms);
        let squares: f64 = difference.coefficients().iter().map(|c| c * c).sum();
        // Σ|c| of the difference.
        let reach = reach(difference);

        let mut sum =
            Square { value: trend, error: 0.0, representation: self.representation_bound(m, trend) };
        let random = noise.variance(difference, m);
        sum.add(random, NORMAL_ERROR * random);
        // Numbers that are off by up to ½ from the middle: 2·rms·d + d².
        let off = |sum: &mut Square, mean_square: f64, d: f64| {
            sum.add(0.0, 2.0 * libm::sqrt(mean_square) * d + d * d);
        };
        if fixed.has_angle() {
            if fixed.fresh() >= 1.0 {
                let first = 2.0 * libm::fabs(first) / terms as f64;
                sum.add(squares / 12.0, 1.0 + 1e-7 * libm::sqrt(random) + first);
                sum.representation += squares / 12.0;
            } else {
                let angle = Noise { quantization: 0.0, ..noise.clone() }.variance(difference, m);
                off(&mut sum, libm::pow(libm::sqrt(angle) + libm::sqrt(trend), 2.0), 0.5 * reach);
            }
        }
        if let Some(markov) = noise.markov {
            let alone = Noise { quantization: 0.0, white: 0.0, octaves: vec![], walk: 0.0, ..noise.clone() };
            let variance = alone.variance(difference, m);
            sum.add(0.0, fixed.start_error() * variance);
            // The loss acts on whole units: it is off by up to one unit, and changes by up to that fraction of one in a
            // sample.
            let m = m as f64;
            let changed = fixed.rate_unit() * m * libm::fmin(1.0, -m * libm::expm1(-markov.decay));
            let d = changed * (0.25 * reach);
            off(&mut sum, libm::pow(libm::sqrt(variance) + libm::sqrt(trend), 2.0), d);
        }
        if let Some(jumps) = fixed.jumps() {
            let variance = jumps.mean_square(self.estimator, self.recipe.samples.into(), m);
            sum.add(variance, NORMAL_ERROR * variance);
            off(&mut sum, libm::pow(libm::sqrt(variance) + libm::sqrt(trend), 2.0), 0.5 * reach);
        }
        let mut wave_error = 0.0;
        if let Some(sine) = fixed.wave() {
            let variance = sine.part().map_or(0.0, |part| part.variance(difference, 1.0, m));
            wave_error = 0.5 + SINE_ERROR * sine.amplitude;
            sum.add(variance, 0.0);
            off(&mut sum, variance, reach * wave_error);
        }
        if let Some(pulse) = fixed.pulse_lsb() {
            let readout = self.readout(&noise, pulse, m);
            // The covariance of two errors changes by at most half a pulse per LSB of the rounding between them.
            let angle = if fixed.has_angle() { 1.0 } else { 0.0 };
            let quantization = if fixed.quantization > 0 { 1.0 } else { 0.0 };
            let drift = if self.recipe.drift.is_empty() { 0.0 } else { 1.0 };
            let jumps = if fixed.switching.is_some() { 1.0 } else { 0.0 };
            let between = angle + quantization + drift + jumps + 2.0 * wave_error;
            let pairs = reach * reach - squares;
            sum.add(readout.value, readout.error + 0.5 * pairs * pulse * between);
            sum.representation += self.readout_bound(pulse, pairs, m);
        }
        sum
    }

    /// The contribution of reading whole pulses.
    fn readout(&self, noise: &Noise, pulse: f64, m: u64) -> Square {
        let (fixed, difference) = (&self.fixed, self.estimator.difference);
        let mut process = noise.simple();
        let white = pulse * pulse / 12.0 * difference.coefficients().iter().map(|c| c * c).sum::<f64>();
        let bound = pulse::white_error(pulse, &process, difference, m);
        process.parts.extend(fixed.wave().and_then(|sine| sine.part()));
        let switches = fixed.switching.is_some();
        let drifts = self.curved || switches || noise.walk > 0.0 || !noise.octaves.is_empty();
        // Whole pulses in the rate per sample do not affect the fractions.
        let rate = (fixed.rate % (pulse * TURN) as u64) as f64 / TURN;
        match pulse::mean_square(pulse, rate, &process, difference, m).filter(|_| !drifts) {
            Some(value) => Square { value, error: 0.0, representation: 0.0 },
            None => Square { value: white, error: bound, representation: 0.0 },
        }
    }
}

/// Most residues that are summed; beyond them there is no closed form.
const MAX_RESIDUES: u64 = 1 << 20;
/// Error of the sum over what all records share, in floating point, of the sum of the squares of its parts.
const SHARED_SUM_ERROR: f64 = 1e-12;

/// The physical theory of records.
#[derive(Debug, Clone)]
pub(crate) struct PhysicalTheory {
    pub(crate) process: Process,
    /// Angle of a pulse, ″; 0 where the readout is not quantized.
    pub(crate) readout_lsb: f64,
    /// Constant rate, ″/s.
    pub(crate) mean_rate: f64,
    pub(crate) switching: Option<Switching>,
    /// Samples of a record.
    pub(crate) samples: u64,
    pub(crate) estimator: Estimator,
}

/// A variance with its bound of error, (″/s)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Variance {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// A part of the differences of what all records share, G(k)·e^{−λk}, ″.
struct Shared<'a> {
    /// λ, per sample.
    decay: f64,
    /// G of a residue.
    periodic: Box<dyn Fn(u64) -> f64 + 'a>,
}

impl PhysicalTheory {
    /// The theory of the records of a point.
    pub(crate) fn new(point: &Point, estimator: Estimator) -> PhysicalTheory {
        let inputs = &point.inputs;
        PhysicalTheory {
            process: inputs.noise.process(inputs.sample_s, inputs.samples()),
            readout_lsb: inputs.noise.readout_lsb,
            mean_rate: inputs.rate,
            switching: inputs.noise.switched(inputs.sample_s),
            samples: inputs.samples(),
            estimator,
        }
    }

    /// The expected estimate at an averaging factor; `None` where it has no closed form: of whole pulses under flicker,
    /// random walk, drift or switches.
    pub(crate) fn variance(&self, m: u64) -> Option<Variance> {
        let PhysicalTheory { process, samples, estimator, .. } = self;
        let difference = estimator.difference;
        let [shared, error] = self.shared(m)?;
        let mut sum = process.variance(difference, m) + shared;
        if let Some(Switching { interval, residual, residual_noise, .. }) = self.switching {
            let variance = 0.5 * residual * residual + residual_noise * residual_noise;
            sum += Jumps { interval, variance }.mean_square(*estimator, *samples, m);
        }
        if self.readout_lsb > 0.0 {
            if self.switching.is_some() {
                return None;
            }
            sum += pulse::mean_square(self.readout_lsb, self.mean_rate, process, difference, m)?;
        }
        let tau = process.sample_s * m as f64;
        let unit = 1.0 / (difference.divisor() * tau * tau);
        Some(Variance { value: sum * unit, error: error * unit })
    }

    /// Mean square of the differences of what all records share, and its error, ″².
    fn shared(&self, m: u64) -> Option<[f64; 2]> {
        let (terms, stride) = (self.estimator.terms(self.samples, m), self.estimator.stride(m));
        if terms == 0 {
            return None;
        }
        let trends = self.process.parts.iter().filter_map(|part| {
            let trend = part.trend(self.estimator.difference, self.process.sample_s, m)?;
            Some(Shared { decay: trend.decay, periodic: Box::new(move |_| trend.first) })
        });
        let mut parts: Vec<Shared> = trends.collect();
        let mut period = 1;
        if let Some(switching) = self.switching.filter(Switching::drifts) {
            period = 2 * switching.interval;
            parts.extend(self.alternating(switching, m));
        }
        if parts.is_empty() {
            return Some([0.0; 2]);
        }
        let residues = period / common_divisor(period, stride);
        let summed = residues.min(terms);
        if summed > MAX_RESIDUES {
            return None;
        }
        // The residues of as many differences, and the rest of one less.
        let counts = [terms.div_ceil(residues), terms / residues];
        let step = (stride * residues) as f64;
        let sum_of_decay = |a: &Shared, b: &Shared| {
            counts.map(|count| match count {
                0 => 0.0,
                count => count as f64 * mean_of_decay(a.decay + b.decay, step, count),
            })
        };
        let sums: Vec<Vec<[f64; 2]>> =
            parts.iter().map(|a| parts.iter().map(|b| sum_of_decay(a, b)).collect()).collect();
        let [mut mean, mut squares] = [0.0; 2];
        for place in 0..summed {
            let k = place * stride;
            let which = usize::from(place >= terms - counts[1] * residues);
            let value = |part: &Shared| (part.periodic)(k % period) * libm::exp(-part.decay * k as f64);
            let values: Vec<f64> = parts.iter().map(value).collect();
            for (a, row) in values.iter().zip(&sums) {
                for (b, sum) in values.iter().zip(row) {
                    mean += a * b * sum[which];
                    squares += (a * b * sum[which]).abs();
                }
            }
        }
        Some([mean / terms as f64, SHARED_SUM_ERROR * squares / terms as f64])
    }

    /// The differences of the alternating drift: with w whole intervals before k and r samples since then, its angle is
    /// (A + Ω_m0) times the distance in time from the nearest even switch, minus, up to a constant,
    /// Aτ(−1)^w e^{−λk}(2e^{−λ(M − r)}/(1 + e^{−λM}) − 1).
    fn alternating(&self, switching: Switching, m: u64) -> [Shared<'_>; 2] {
        let Switching { interval, magnetic, .. } = switching;
        let (t0, coefficients) = (self.process.sample_s, self.estimator.difference.coefficients());
        let decay = t0 / magnetic.time_s;
        let difference = move |angle: &dyn Fn(u64, f64) -> f64, k: u64| -> f64 {
            let places = (0..).map(|span| span * m).zip(coefficients);
            places.map(|(after, c)| c * angle((k + after) % (2 * interval), after as f64)).sum()
        };
        let linear = move |place: u64, _: f64| {
            (magnetic.amplitude + magnetic.initial) * t0 * place.min(2 * interval - place) as f64
        };
        let decaying = move |place: u64, after: f64| {
            let (sign, rest) = if place < interval { (1.0, place) } else { (-1.0, place - interval) };
            let ahead = libm::exp(-decay * (interval - rest) as f64);
            let shape = 2.0 * ahead / (1.0 + libm::exp(-decay * interval as f64)) - 1.0;
            -magnetic.amplitude * magnetic.time_s * sign * libm::exp(-decay * after) * shape
        };
        [
            Shared { decay: 0.0, periodic: Box::new(move |k| difference(&linear, k)) },
            Shared { decay, periodic: Box::new(move |k| difference(&decaying, k)) },
        ]
    }
}

fn common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

/// Records of one point, with the address of their sums.
#[derive(Debug, Clone, PartialEq)]
pub struct LoweredCurve {
    /// The noise in fixed point, with its closed forms.
    pub records: Records,
    /// Address of the sums of the records in the store.
    pub address: Address,
}

impl LoweredCurve {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The point cannot be represented; see [`Unrepresentable`].
    pub fn new(
        point: &RecordPoint,
        estimator: Estimator,
        seed: u64,
        streams: Streams,
    ) -> Result<LoweredCurve, Unrepresentable> {
        let (id, records) = lower(point, estimator, seed, streams, Records::new)?;
        let estimate = Id::from_text(&format!("estimate\n{}ms={:?}\n", named(estimator), point.ms));
        let address = Address { point: id, estimate, digest: records.digest() };
        Ok(LoweredCurve { records, address })
    }
}

/// The records of a point that are made sample by sample, which may be longer than those of a study.
///
/// # Errors
/// The point cannot be represented; see [`Records::of_any_length`].
pub fn made_records(
    point: &RecordPoint,
    estimator: Estimator,
    seed: u64,
    streams: Streams,
) -> Result<Records, Unrepresentable> {
    Ok(lower(point, estimator, seed, streams, Records::of_any_length)?.1)
}

/// The identity of a point with its records.
fn lower(
    point: &RecordPoint,
    estimator: Estimator,
    seed: u64,
    streams: Streams,
    records: fn(&Asked) -> Result<Records, Unrepresentable>,
) -> Result<(Id, Records), Unrepresentable> {
    let inputs = &point.inputs;
    let (id, key) = identity("allan", seed, streams, &canonical(inputs));
    let samples = inputs.samples();
    let process = inputs.noise.process(inputs.sample_s, samples);
    let asked = Asked {
        process: &process,
        readout_lsb: inputs.noise.readout_lsb,
        mean_rate: inputs.rate,
        switching: inputs.noise.switched(inputs.sample_s),
        samples,
        estimator,
        ms: &point.ms,
        key,
    };
    Ok((id, records(&asked)?))
}

/// An estimator in identities.
fn named(estimator: Estimator) -> String {
    let difference = match estimator.difference {
        Difference::Second => "second",
        Difference::Third => "third",
    };
    let stride = match estimator.stride {
        Stride::Sample => "1".to_owned(),
        Stride::Cluster => "m".to_owned(),
        Stride::Part(parts) => format!("m/{parts}"),
    };
    format!("difference={difference}\nstride={stride}\n")
}

/// The inputs that determine the draws.
fn canonical(inputs: &RecordInputs) -> String {
    let RecordInputs { sample_s, length_s: _, rate, noise } = inputs;
    // A constant rate affects whole pulses only.
    let rate = if noise.readout_lsb > 0.0 { *rate } else { 0.0 };
    let (samples, noise) = (inputs.samples(), noise.canonical());
    format!("sample_s={sample_s:.11e}\nsamples={samples}\nrate={rate:.11e}\n{noise}")
}

/// Fewest units of a standard deviation or an amplitude, which is then rounded by at most 1 %.
const MIN_UNITS: f64 = 50.0;
/// Fewest LSB of the largest difference of a ramp or a warm-up, and of the range of an alternating drift.
const MIN_TREND: f64 = 128.0;
/// Fewest units of 2^−32 turns by which the phase of a sine advances in a sample.
const MIN_TURN: f64 = 64.0;

/// Refuses a correlation so long that what the rate loses in a sample has too few units, whatever the unit of angle.
pub(crate) fn check_decay(markov: Option<Markov>) -> Result<(), Unrepresentable> {
    let Some(Markov { decay, .. }) = markov.filter(|markov| loss(markov.decay) < MIN_UNITS) else {
        return Ok(());
    };
    let found = format!(
        "a correlation time of {} samples is too long for 32-bit arithmetic, which takes 2 * 10^7",
        shown(1.0 / decay)
    );
    Err(Unrepresentable::new("noise.markov", found, "take a rate random walk in its place"))
}

impl Fixed {
    /// Refuses the first part that is too small next to `whole`, the largest difference of the angle, ″. The message states their
    /// ratio, without a unit, because the record of an accelerometer is simulated in µg·s instead.
    pub(crate) fn check(&self, model: &Model, whole: f64) -> Result<(), Unrepresentable> {
        let Model { noise, .. } = model;
        let check = |key, what: &str, found: f64, units: f64, least: f64| {
            if found == 0.0 || units >= least {
                return Ok(());
            }
            let lost = format!(
                "{what} is lost in 32-bit arithmetic: over {} samples the record has differences up to {} times as large",
                model.samples,
                significant(whole / libm::fabs(found), 3)
            );
            let help = "make it larger, or 0; or what is large beside it smaller, or the record shorter";
            Err(Unrepresentable::new(key, lost, help))
        };
        let sigma = |key, what, found, word: u32| check(key, what, found, word.into(), MIN_UNITS);
        let (key, what) = ("noise.quantization", "quantization noise");
        sigma(key, what, noise.quantization, self.quantization)?;
        let (key, what) = ("noise.angle_random_walk", "white noise");
        check(key, what, noise.white, noise.white / self.lsb_arcsec * SIGMA_UNITS, MIN_UNITS)?;
        let (key, what) = ("noise.bias_instability", "flicker noise");
        for (&found, &word) in noise.octaves.iter().zip(core::iter::once(&self.white).chain(&self.flicker)) {
            sigma(key, what, found, word)?;
        }
        sigma("noise.rate_random_walk", "a step of the rate", noise.walk, self.walk)?;
        if let (Some(Markov { sigma: found, .. }), Some([_, step, _])) = (noise.markov, self.markov) {
            sigma("noise.markov", "Markov noise", found, step)?;
        }
        if let (Some(Sine { amplitude, turns }), Some([_, word])) = (model.sine, self.sine) {
            if libm::fabs(turns - libm::round(turns)) * TURN < MIN_TURN {
                let found = format!(
                    "{} periods a sample are too near a whole number: from sample to sample the phase must turn by more than \
                     2^-26",
                    significant(turns, 12)
                );
                let help = "take another frequency, or a rate ramp in its place";
                return Err(Unrepresentable::new("noise.sine", found, help));
            }
            sigma("noise.sine", "a sine", amplitude, word)?;
        }
        let m = model.longest(Difference::Second) as f64;
        let ramp = libm::fabs(model.ramp) * m * m / self.lsb_arcsec;
        check("noise.rate_ramp", "a ramp", model.ramp, ramp, MIN_TREND)?;
        for warm_up in &model.warm_ups {
            let part = libm::expm1(-warm_up.decay * m);
            let largest = libm::fabs(warm_up.reach) * part * part / self.lsb_arcsec;
            check("noise.warm_up", "a warm-up", warm_up.rate(), largest, MIN_TREND)?;
        }
        if let Some(switching) = model.switching {
            let (key, what) = ("noise.switching.magnetic", "an alternating angle");
            check(key, what, model.sawtooth, model.sawtooth / self.lsb_arcsec, MIN_TREND)?;
            let [_, amplitude, noise] = self.switching.unwrap_or_default();
            sigma("noise.switching.residual", "an amplitude", switching.residual, amplitude)?;
            sigma("noise.switching.residual_noise", "a noise", switching.residual_noise, noise)?;
        }
        Ok(())
    }
}
