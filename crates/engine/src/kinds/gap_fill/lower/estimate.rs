//! One estimate of a point: the proof that it fits, and its exact value.

use std::sync::Arc;

use crate::filler::read::Error;
use crate::filler::{Filler, Method};
use crate::key::row::Refusal;
use crate::kinds::gap_fill::lower::fixed::{
    ANGLE_UNITS, CONSTANT_UNITS, Fixed, FixedTone, PEAK_UNITS, RAYLEIGH_UNIT, SIGMA_UNITS, ToneMotion,
};
use crate::kinds::gap_fill::lower::readout::Fractions;
use crate::kinds::gap_fill::lower::response::{Functional, Response};
use crate::kinds::gap_fill::lower::weights::{Rows, singular_covariance};
use crate::kinds::gap_fill::lower::{definition, words_of};
use crate::kinds::gap_fill::point::Designed;
use crate::store::Address;
use crate::tally::Id;
use sagnac_kernel::gap_fill;
use sagnac_kernel::moments::{LIMIT, level};
use sagnac_kernel::normal::REACH;

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
    ) -> Result<Estimate, Refusal> {
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
            return Err(Refusal::new("switching.fillers", found, help));
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
        let estimate = Id::of(&format!("estimate\nfiller={definition}\nerror={name}\nticks={ticks:?}\n"));
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
