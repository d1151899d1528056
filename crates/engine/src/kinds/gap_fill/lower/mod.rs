//! Lowering: converts a point of a study into the fixed-point parameters of its kernel, with a proof that they fit.
//!
//! All computations are in f64 through `libm`, in a fixed order, so that the words are the same on every machine. The
//! theory of each estimate is computed from the *lowered* parameters, so it is exact for what is sampled.
//!
//! ```text
//! Inputs ─ physical ─▶ Physical ─ unit ─▶ Fixed ─┬─ weights, response, readout ─▶ Estimates
//!                                               └─ launch ─▶ Launch
//! ```
//!
//! A point of a sweep with its closed forms, without sampling:
//!
//! ```
//! use sagnac_engine::kinds::gap_fill::lower::Lowered;
//! use sagnac_engine::study::Study;
//!
//! let study = Study::parse("error_vs_dtnu.toml", include_str!("../../../../../../studies/error_vs_dtnu.toml"))?;
//! let asked = study.asked::<sagnac_engine::kinds::gap_fill::GapFill>().unwrap();
//! let point = asked.points.iter().find(|point| point.inputs.gap_ticks == 3).unwrap();
//! let lowered = Lowered::new(point, &asked.fillers, &asked.errors, study.seed, study.streams)?;
//! let residual = &lowered.fillers[0][0];
//! // 12000 ″/s at 2 Hz, by the constant: 2.067 ″/√2 of motion and 0.8 ″ of noise.
//! assert!((residual.theory.rms.unwrap() - 1.666).abs() < 5e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod fixed;
pub(crate) mod physical;
pub(crate) mod physical_theory;
pub(crate) mod readout;

use std::sync::Arc;

use crate::filler::read::Error;
use crate::filler::{Fill, Filler, Method, Target};
use crate::key::{Streams, Unrepresentable};
use crate::kinds::gap_fill::inputs::{Designed, Point};
use crate::kinds::gap_fill::lower::fixed::{
    ANGLE_UNITS, CONSTANT_UNITS, DEFAULT_SIDES, Fixed, FixedTone, PEAK_UNITS, RAYLEIGH_UNIT, SIGMA_UNITS,
    ToneMotion, gaussian_place, long_words, mask, singular_covariance,
};
pub use crate::kinds::gap_fill::lower::fixed::{Rows, Statistics};
use crate::kinds::gap_fill::lower::physical::Physical;
pub use crate::kinds::gap_fill::lower::physical::{Residual, ResidualTone};
use crate::kinds::gap_fill::lower::readout::{Fractions, Functional, Response};
use crate::kinds::plan::identity;
use crate::store::Address;
use crate::tally::Id;
use sagnac_kernel::gap_fill;
use sagnac_kernel::gap_fill::shape::{Parameters, Shape};
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::{LIMIT, MAX_ESTIMATES, level};
use sagnac_kernel::normal::REACH;
use sagnac_theory::minimum_variance::Band;

/// A point, ready to be sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct Lowered {
    /// Id of the point, under which its draws and tallies are found.
    pub id: Id,
    key: [u32; 2],
    fixed: Fixed,
    /// The estimates of each filler, one for each error in the order of the kernel.
    pub fillers: Vec<Vec<Estimate>>,
}

impl Lowered {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The point cannot be represented; see [`Unrepresentable`].
    pub fn new(
        point: &Point,
        fillers: &[Filler],
        errors: &[Error],
        seed: u64,
        streams: Streams,
    ) -> Result<Lowered, Unrepresentable> {
        Lowered::of(point, fillers.iter().zip(point.fills.iter()), errors, seed, streams)
    }

    /// Lowers a point with some of its fillers.
    pub(crate) fn of<'a>(
        point: &Point,
        fillers: impl Iterator<Item = (&'a Filler, &'a Fill)>,
        errors: &[Error],
        seed: u64,
        streams: Streams,
    ) -> Result<Lowered, Unrepresentable> {
        let sides = point.sides();
        let physical = Physical::new(&point.inputs, sides.max(DEFAULT_SIDES))?;
        let (id, key) = identity("gap-fill", seed, streams, &physical.canonical(&point.inputs));
        let fixed = Fixed::new(&physical, fixed::lsb(&physical)?, sides);
        let statistics = Statistics::new(point.design.as_deref().unwrap_or(&point.inputs));
        let fractions = Fractions::new(&fixed);
        let estimates = |(filler, fill): (&Filler, &Fill)| {
            let mut estimates = Vec::new();
            for &error in errors {
                let ticks = match error {
                    Error::Residual => Some(&fill.fit_ticks),
                    Error::Extrapolation | Error::InGap => fill.extrapolation_ticks.as_ref(),
                };
                let Some(ticks) = ticks else { continue };
                let Some(rows) = Rows::shared(filler, error, ticks, &statistics)? else { continue };
                estimates.push(Estimate::new(id, key, filler, error, &fractions, rows, point.designed())?);
            }
            Ok(estimates)
        };
        let fillers = fillers.map(estimates).collect::<Result<Vec<_>, Unrepresentable>>()?;
        Ok(Lowered { id, key, fixed, fillers })
    }

    /// Most fillers with as many errors as `filler` that fit into a launch.
    pub fn most_fillers(&self, filler: usize) -> usize {
        MAX_ESTIMATES / self.fillers[filler].len().max(1)
    }

    /// The least possible number of trials of the point that is at least `asked`: whole replays for a profile that is
    /// taken in turn.
    pub fn whole_replays(&self, asked: u64) -> u64 {
        match &self.fixed.profile {
            Some(profile) if profile.every => asked.next_multiple_of(profile.positions as u64),
            _ => asked,
        }
    }
}

/// Definition of a filler with these weights regardless of its name, part of the identity of its estimates.
pub(crate) fn definition(filler: &Filler, rows: Option<&Rows>, designed: Designed) -> String {
    let weights = || rows.map(|rows| (&rows.numerators, rows.denominator));
    match &filler.method {
        Method::Closed(closed) => closed.identity.to_owned(),
        // The part of the record from which they follow does not enter the identity of the point.
        Method::MinimumVariance(Target::Own) if designed == Designed::OtherPart => {
            format!("minimum-variance weights={:?}", weights())
        }
        Method::MinimumVariance(Target::Own) => "minimum-variance".to_owned(),
        Method::MinimumVariance(Target::Specification(_)) => {
            format!("minimum-variance specification weights={:?}", weights())
        }
        // Its weights depend on the rate of the motion. Whole periods in each tick leave no angle, so points that differ only in
        // the rate of such a motion are the same.
        Method::MinimumVariance(Target::Band(Band { low_hz, high_hz })) => {
            format!("minimum-variance band_hz={low_hz:.11e} {high_hz:.11e} weights={:?}", weights())
        }
        Method::Weights { residual, extrapolation } => format!("weights {residual:?} {extrapolation:?}"),
    }
}

/// The bits of a number.
pub(crate) fn words_of(x: f64) -> [u32; 2] {
    long_words(x.to_bits().cast_signed())
}

impl Lowered {
    /// The launch that samples some of the fillers, which must have the same errors. Its estimates are all residuals,
    /// then all extrapolations, then all errors in the gap.
    pub fn launch(&self, fillers: &[usize]) -> Launch {
        let estimates: Vec<&Estimate> = self.launched(fillers).collect();
        assert!(estimates.len() <= MAX_ESTIMATES);
        let shape = shape(&self.fixed, &estimates, fillers.len());
        let fixed = &self.fixed;
        let n = fixed.gap_ticks;
        let before: Vec<i32> = (0..shape.before as i32).map(|k| -k).collect();
        let after: Vec<i32> = (1..=shape.after as i32).map(|k| n + k).collect();
        let sides: Vec<i32> = (1..=shape.sides() as i32).map(|k| n + k).collect();
        let lengths: Vec<i32> = lengths(shape, n).collect();
        let of = |error: Error| estimates.iter().filter(move |estimate| estimate.error == error);
        let scales = |error: Error| list(of(error).map(|e| e.rows.denominator as u32));
        let weights = |error: Error, ticks: &[i32]| {
            list(of(error).flat_map(|e| ticks.iter().map(|&tick| e.weight(0, tick))))
        };
        let extrapolation_ticks = &before[..shape.extrapolation_before];
        let residual_ticks = [&before[..shape.residual_before], &after[..]].concat();
        let tones =
            |has: bool, word: fn(&FixedTone) -> u32| list(fixed.tones.iter().filter(|_| has).map(word));
        // The angles of tones of fixed frequency, at sine 1 or at cosine 1.
        let angles = |has: bool, ticks: &[i32], word: fn(&FixedTone, i32, i32) -> i32| {
            let ticks = ticks.iter().filter(|_| has && !shape.frequencies);
            list(ticks.flat_map(|&tick| fixed.tones.iter().map(move |tone| word(tone, tick, n) as u32)))
        };
        let constants = |ticks: &[i32], constant: fn(&Fixed, i32) -> i64| {
            let ticks = ticks.iter().filter(|_| shape.constants);
            list(ticks.flat_map(|&tick| long_words(constant(fixed, tick))))
        };
        let positions = list(fixed.profile.iter().map(|profile| profile.positions as u32));
        let words = Parameters {
            key: &self.key,
            phase: &tones(true, |tone| tone.phase),
            phase_spread: &tones(true, |tone| tone.phase_spread),
            sigma: &[fixed.sigma],
            gap_sin: &angles(true, &lengths, |tone, length, n| tone.gap_words(length, n)[0]),
            gap_cos: &angles(shape.in_gap, &lengths, |tone, length, n| tone.gap_words(length, n)[1]),
            side_sin: &angles(true, &sides, |tone, tick, n| tone.tick_words(tick, n)[0]),
            side_cos: &angles(true, &sides, |tone, tick, n| tone.tick_words(tick, n)[1]),
            amplitude_low: &tones(shape.amplitudes, |tone| tone.part[0]),
            amplitude_width: &tones(shape.amplitudes, |tone| tone.part[1]),
            rayleigh: &tones(shape.amplitudes, |tone| mask(tone.rayleigh)),
            peak: &tones(shape.frequencies, |tone| tone.drawn_words()[0]),
            frequency_low: &tones(shape.frequencies, |tone| tone.drawn_words()[1]),
            frequency_width: &tones(shape.frequencies, |tone| tone.drawn_words()[2]),
            frequency_scale: &tones(shape.frequencies, |tone| tone.drawn_words()[4]),
            of_angle: &tones(shape.frequencies, |tone| mask(tone.drawn_words()[3] != 0)),
            gap_length: &[n as u32],
            gap_constant: &constants(&lengths, Fixed::gap_constant),
            before_constant: &constants(&before, Fixed::tick_constant),
            after_constant: &constants(&after, Fixed::tick_constant),
            positions: &positions,
            positions_inverse: &list(positions.iter().map(|&count| u32::MAX / count)),
            readout_mask: &list(fixed.readout.iter().map(|readout| !((1 << readout.bits) - 1))),
            gap_sigma: &list(fixed.readout.iter().map(|readout| readout.gap_sigma)),
            residual_weight: &weights(Error::Residual, &residual_ticks),
            residual_scale: &scales(Error::Residual),
            extrapolation_weight: &weights(Error::Extrapolation, extrapolation_ticks),
            extrapolation_scale: &scales(Error::Extrapolation),
            in_gap_scale: &scales(Error::InGap),
            shift: &list(estimates.iter().filter(|_| shape.wide).map(|e| e.shift)),
            bin_base: &list(estimates.iter().map(|e| e.bin_base)),
        }
        .words();
        let in_gap: Vec<u32> = of(Error::InGap)
            .flat_map(|e| (0..n as usize).map(move |row| (e, row)))
            .flat_map(|(e, row)| extrapolation_ticks.iter().map(move |&tick| e.weight(row, tick)))
            .collect();
        let table = match (&fixed.profile, in_gap.is_empty()) {
            // The table is shared by all launches of the point.
            (Some(profile), true) => profile.rounded.angles.clone(),
            _ => [in_gap, motion_table(fixed, shape)].concat().into(),
        };
        Launch::new(shape, words, table).expect("lowered words and tables are those of the shape")
    }

    /// The estimates of a launch in order.
    pub fn launched<'a>(&'a self, fillers: &'a [usize]) -> impl Iterator<Item = &'a Estimate> {
        Error::ALL.into_iter().flat_map(move |error| {
            let all = fillers.iter().flat_map(|&filler| &self.fillers[filler]);
            all.filter(move |estimate| estimate.error == error)
        })
    }
}

fn shape(fixed: &Fixed, estimates: &[&Estimate], fillers: usize) -> Shape {
    let n = fixed.gap_ticks;
    let has = |error: Error| estimates.iter().any(|estimate| estimate.error == error);
    let farthest = |residual: bool, distance: &dyn Fn(i32) -> i32| {
        let own = estimates.iter().filter(|estimate| (estimate.error == Error::Residual) == residual);
        own.flat_map(|e| &e.rows.ticks).map(|&tick| distance(tick)).max().unwrap_or(0).max(0) as usize
    };
    let residual_before = farthest(true, &|tick| 1 - tick);
    let extrapolation_before = farthest(false, &|tick| 1 - tick);
    let in_gap = has(Error::InGap);
    let gaussian = fixed.gaussian.is_some();
    Shape {
        before: residual_before.max(extrapolation_before),
        after: farthest(true, &|tick| tick - n),
        residual_before,
        extrapolation_before,
        fillers,
        residual: has(Error::Residual),
        extrapolation: has(Error::Extrapolation),
        in_gap,
        wide: estimates.iter().any(|estimate| estimate.shift > 0),
        gap_ticks: if in_gap || gaussian { n as usize } else { 0 },
        tones: fixed.tones.len(),
        amplitudes: fixed.has_amplitudes(),
        frequencies: fixed.has_frequencies(),
        gaussian,
        profile: fixed.profile.is_some(),
        every: fixed.profile.as_ref().is_some_and(|profile| profile.every),
        constants: fixed.has_constants(),
        readout: fixed.readout.is_some(),
    }
}

/// Collects words into the list that a parameter takes.
fn list(words: impl Iterator<Item = u32>) -> Vec<u32> {
    words.collect()
}

/// The lengths of the gap, counted from its start, that have a row.
fn lengths(shape: Shape, n: i32) -> core::ops::RangeInclusive<i32> {
    if shape.in_gap { 1..=n } else { n..=n }
}

/// The table of the motion: rows of the Gaussian factor over the gap, then those of the ticks outward; or a profile.
fn motion_table(fixed: &Fixed, shape: Shape) -> Vec<u32> {
    if let Some(profile) = &fixed.profile {
        return profile.rounded.angles.to_vec();
    }
    let Some(factor) = &fixed.gaussian else { return vec![] };
    let n = fixed.gap_ticks;
    let mut table = Vec::new();
    for length in lengths(shape, n) {
        let word = |tick: i32, i: usize| factor[gaussian_place(tick, n)].get(i).copied().unwrap_or(0);
        table.extend((0..n as usize).map(|i| (1..=length).map(|tick| word(tick, i)).sum::<i32>() as u32));
    }
    let rows = &factor[n as usize..shape.gaussians()];
    table.extend(rows.iter().flatten().map(|&word| word as u32));
    table
}

/// The exact values of an estimate for the lowered parameters, in ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Theory {
    /// Rms error; absent where there is no closed form.
    pub rms: Option<f64>,
    /// The rms, or where it has no closed form an approximation: fractions of a pulse are taken as independent, and for the
    /// largest error in a gap it is that at the end of the gap.
    pub size: f64,
    /// Largest error of the motion alone; absent where it is unknown.
    pub max: Option<f64>,
    /// Standard deviation of E² in a trial whose place in the record is given, ″². Where every place comes equally
    /// often, only the noise scatters.
    pub noise_of_square: Option<f64>,
    /// Bound of the deviation of a sampled rms from `rms` due to rounding in the kernel and to `omitted`.
    pub rounding: f64,
    /// Bound of what the series for whole pulses omits of `rms`.
    pub omitted: f64,
    /// Rms of the rounding in the kernel: its standard deviation where noise makes it random, else its bound.
    pub resolution: f64,
}

impl Theory {
    /// Whether the error is smaller than the rounding of the arithmetic, so that the rms `sampled` is that of the rounding.
    pub fn is_below_resolution(&self, sampled: f64) -> bool {
        sampled > 0.0 && self.size < self.resolution && self.rms.unwrap_or(sampled) < self.resolution
    }
}

/// One estimate of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The error of the filler.
    pub error: Error,
    /// Address of its tallies.
    pub address: Address,
    /// Its closed form for the lowered words.
    pub theory: Theory,
    /// Bound of the deviation of the closed form from that of the physical inputs due to the rounding of words, ″.
    pub representation: f64,
    /// Size of a unit of the tally, ″.
    pub unit_arcsec: f64,
    /// Level at which its histogram starts.
    pub bin_base: u32,
    /// Weights as integers.
    pub rows: Arc<Rows>,
    /// Number of bits by which its sum is shifted, with rounding.
    pub(crate) shift: u32,
}

/// Largest ratio of the resolution to the rms for a filler designed for the least error. Beyond it, the weights cancel the
/// motion to below what the arithmetic resolves.
const MAX_ROUNDING: f64 = 0.1;

/// Bound of the relative rounding of inputs to 12 digits and of computations in `f64`, for phases by turn.
const TWELVE_DIGITS: f64 = 1e-11;

impl Estimate {
    /// Lowers an error of a filler, of the point `point` with the key `key`.
    ///
    /// `designed` says what its weights are for if they are those of least error for the motion.
    pub(crate) fn new(
        point: Id,
        key: [u32; 2],
        filler: &Filler,
        error: Error,
        fractions: &Fractions,
        rows: Arc<Rows>,
        designed: Designed,
    ) -> Result<Estimate, Unrepresentable> {
        let fixed = fractions.fixed;
        let scale = rows.denominator as f64;
        let sigma = fixed.sigma_lsb();
        // Reading whole pulses changes each tick by less than one pulse.
        let pulse = fixed.readout.map_or(0.0, |readout| libm::exp2(f64::from(readout.bits)));
        let drawn = fixed.has_amplitudes() || fixed.has_frequencies();
        let functionals = functionals(&rows, error, fixed.gap_ticks);
        let (mut bound, mut terms, mut rounding) = (0.0_f64, 0.0_f64, 0.0_f64);
        // The whole gap is the last row. Errors in a gap of one tick equal those of the extrapolation without their
        // sign.
        let whole = &functionals[functionals.len() - 1];
        let mut response = Response::default();
        for f in &functionals {
            response = fixed.response(f);
            let gain = f.gain();
            // Each tick and the gap are rounded once, by at most half an LSB, and the sine is wrong by 2^−29.5. A drawn
            // amplitude or frequency also has factors that are rounded to an eighth of an LSB.
            let factors = if drawn { 0.25 * (gain + scale * f64::from(f.gap)) } else { 0.0 };
            let own = 0.5 * (gain + scale)
                + libm::exp2(if drawn { -28.0 } else { -29.5 }) * response.terms
                + response.rounding
                + factors;
            rounding = rounding.max(own);
            bound = bound.max(response.bound + (REACH * sigma + pulse) * gain + own);
            terms = terms.max(response.terms + (REACH * sigma + pulse + 1.0) * gain + scale);
        }
        // Below 2^59 the shift stays below 32, as `bits_from` requires.
        if terms >= libm::exp2(59.0) {
            let (filler, error, bits) = (&filler.name, error.name(), libm::log2(terms));
            let found = format!(
                "the weighted sum of the {error} of `{filler}` reaches 2^{bits:.0}, more than its 64-bit sum can hold"
            );
            let help = "leave the filler out, move its ticks nearer to the gap, or shorten the gap";
            return Err(Unrepresentable::new("switching.fillers", found, help));
        }
        let shift = libm::ceil(libm::log2((bound + 1.0) / (LIMIT as f64 - 1.0))).max(0.0);
        let (shift, unit) = (shift as u32, libm::exp2(shift));
        let unit_arcsec = fixed.lsb_arcsec / scale * unit;
        let rounding = (rounding / unit + if shift > 0 { 0.5 } else { 0.0 }) * unit_arcsec;
        // Noise of several units makes the rounding of each reading independent and uniform. The angle over the gap has no
        // noise, so its rounding counts in full.
        let resolution = if sigma > 1.0 {
            let readings = whole.noise_gain() / libm::sqrt(12.0);
            libm::hypot(readings / unit, 0.5 * scale / unit + if shift > 0 { 0.5 } else { 0.0 }) * unit_arcsec
        } else {
            rounding
        };

        let noise = sigma * whole.noise_gain();
        let known = error != Error::InGap || fixed.gap_ticks == 1;
        let quantized = fractions.variance(whole);
        let rms_with = |more: f64| {
            let square = response.mean * response.mean + response.variance + noise * noise + more;
            // A variance of pulses that vanishes may come out below 0.
            libm::sqrt(square.max(0.0)) / unit
        };
        // The root of a variance that is wrong by `error` is wrong by at most √error, and by at most error/rms.
        let of_variance = |error: f64, rms: f64| libm::sqrt(error).min(error / rms.max(f64::MIN_POSITIVE));
        let omitted = quantized.map_or(0.0, |(variance, tail)| {
            of_variance(tail, rms_with(variance) * unit) / unit * unit_arcsec
        });
        // Where the variance of the readout is unknown, it is approximated by that of independent fractions.
        let about =
            quantized.map_or(pulse * pulse / 6.0 * whole.noise_gain() * whole.noise_gain(), |(x, _)| x);
        let theory = Theory {
            rms: quantized.filter(|_| known).map(|(variance, _)| rms_with(variance) * unit_arcsec),
            size: rms_with(about) * unit_arcsec,
            noise_of_square: fixed
                .profile
                .as_ref()
                .filter(|profile| profile.every && known && fixed.readout.is_none())
                .map(|_| {
                    let square = response.mean * response.mean + response.variance;
                    let (n, unit) = (noise * noise, unit_arcsec / unit);
                    libm::sqrt(4.0 * square * n + 2.0 * n * n) * unit * unit
                }),
            max: response.largest.filter(|_| known).map(|largest| largest / unit * unit_arcsec),
            resolution,
            omitted,
            rounding: rounding + omitted,
        };
        // If a record has most of its motion in few places, its own level determines where bins are needed.
        let tail = response.level.map_or(0.0, |motion| 0.125 * libm::hypot(motion, 3.0 * noise) / unit);
        let bin_base = level(libm::floor((0.25 * rms_with(about)).max(tail)) as u32);
        let lost = theory.rms.is_some_and(|rms| theory.resolution > MAX_ROUNDING * rms);
        // Without motion nothing is cancelled, and a theoretical error of 0 is possible.
        let is_least = designed != Designed::Elsewhere && matches!(filler.method, Method::MinimumVariance(_));
        if is_least && lost && response.terms > whole.gain() {
            return Err(singular_covariance(&filler.name, sigma * fixed.lsb_arcsec));
        }
        let words = [gap_fill::VERSION, key[0], key[1]]
            .into_iter()
            .chain(fixed.words(&rows.ticks))
            .chain(rows.ticks.iter().map(|&tick| tick as u32))
            .chain(rows.numerators.iter().flatten().map(|&w| w as u32))
            .chain([rows.denominator as u32, shift, bin_base])
            .chain(words_of(unit_arcsec));
        let (definition, name, ticks) =
            (definition(filler, Some(&rows), designed), error.name(), &rows.ticks);
        let estimate = Id::from_text(&format!("estimate\nfiller={definition}\nerror={name}\nticks={ticks:?}\n"));
        let address = Address { point, estimate, digest: Id::of_words(words) };
        let pulses = fixed.representation_of_pulses(whole) + quantized.map_or(0.0, |(_, tail)| tail);
        let of_pulses = of_variance(pulses, rms_with(about) * unit);
        let representation = (fixed.representation(whole, &response) + of_pulses) / unit * unit_arcsec;
        Ok(Estimate { error, address, theory, representation, unit_arcsec, bin_base, rows, shift })
    }

    pub(crate) fn weight(&self, row: usize, tick: i32) -> u32 {
        let place = self.rows.ticks.iter().position(|&own| own == tick);
        place.map_or(0, |k| self.rows.numerators[row][k] as u32)
    }
}

impl Fixed {
    /// Bound of the rms of the difference between an error of the lowered motion and noise and that of the physical ones,
    /// LSB: each word is within half its unit of what it stands for, and deviations add up at most as their rms.
    fn representation(&self, f: &Functional, response: &Response) -> f64 {
        let scale = f.scale as f64;
        // A tick, and each tick of the gap.
        let ticks = f.gain() + scale * f64::from(f.gap);
        let span = f.ticks.iter().map(|tick| tick.abs()).fold(f.gap, i32::max);
        let mut sum = 0.5 / SIGMA_UNITS * f.noise_gain();
        let mut turns = 0.0_f64;
        for tone in &self.tones {
            match tone.motion {
                ToneMotion::Fixed { nu_t, .. } => {
                    // A sine and a cosine, each rounded.
                    sum += core::f64::consts::FRAC_1_SQRT_2 / ANGLE_UNITS * ticks;
                    turns = turns.max(nu_t);
                }
                ToneMotion::Drawn { low, width, scale, .. } => {
                    let unit = f64::from(scale) * libm::exp2(-32.0);
                    let high = 2.0 * unit * f64::from(low + width);
                    let phase = core::f64::consts::TAU * unit * f64::from(2 * span + 1);
                    sum += 2.0 * (0.5 / PEAK_UNITS * ticks + phase * response.terms);
                    turns = turns.max(high);
                }
            }
        }
        if let Some(factor) = &self.gaussian {
            // As many words as rows at most, with independent numbers.
            sum += 0.5 / SIGMA_UNITS * libm::sqrt(factor.len() as f64) * ticks;
        }
        if self.profile.is_some() {
            // Each end of a tick is rounded.
            sum += f.gain() + scale;
        }
        let digits = TWELVE_DIGITS * (1.0 + core::f64::consts::TAU * turns * f64::from(span + 1));
        sum + ticks / CONSTANT_UNITS + digits * (response.terms + self.sigma_lsb() * f.noise_gain())
    }
}

impl Fixed {
    /// Bound of the same difference of the variance that whole pulses add, LSB².
    ///
    /// The covariance q²/12 (1 − 6y + 6y²) of two fractions, with y in pulses of q, changes by at most q/2 per unit of
    /// the angle between them, and by at most 1.4 q per unit of the standard deviation of noise.
    fn representation_of_pulses(&self, f: &Functional) -> f64 {
        let Some(readout) = self.readout else { return 0.0 };
        let pulse = libm::exp2(f64::from(readout.bits));
        let ends = f.ticks.iter().fold([0, f.gap], |[first, last], &tick| [first.min(tick), last.max(tick)]);
        let span = f64::from(ends[1] - ends[0] + 1);
        let of_tone = |tone: &FixedTone| match tone.motion {
            ToneMotion::Fixed { .. } => core::f64::consts::FRAC_1_SQRT_2 / ANGLE_UNITS,
            ToneMotion::Drawn { peak, scale, .. } => {
                let phase =
                    core::f64::consts::TAU * f64::from(scale) * libm::exp2(-32.0) * (2.0 * span + 1.0);
                // A Rayleigh-distributed amplitude has up to twice its unit in the mean.
                (0.5 + phase * f64::from(peak)) / PEAK_UNITS
                    * if tone.rayleigh { 2.0 * RAYLEIGH_UNIT } else { 1.0 }
            }
        };
        let tones: f64 = self.tones.iter().map(of_tone).sum();
        let rows = self.gaussian.as_ref().map_or(0, Vec::len) as f64;
        let tick = tones + 0.5 / SIGMA_UNITS * libm::sqrt(rows) + 1.0 / CONSTANT_UNITS;
        let noise = 0.5 / SIGMA_UNITS * libm::sqrt(span);
        // Each end of an angle of a record is rounded.
        let record = if self.profile.is_some() { 1.0 } else { 0.0 };
        // Each tick has a fraction at either end.
        let factors = 2.0 * f.gain();
        factors * factors * pulse * (0.5 * (span * tick + record) + 1.4 * noise)
    }
}

/// The sums of an estimate: a single one, or for errors in the gap one for each number of its first ticks.
pub(crate) fn functionals(rows: &Rows, error: Error, gap_ticks: i32) -> Vec<Functional<'_>> {
    let first = if error == Error::InGap { 1 } else { gap_ticks };
    (first..)
        .zip(&rows.numerators)
        .map(|(gap, weights)| Functional { ticks: &rows.ticks, weights, scale: rows.denominator, gap })
        .collect()
}
