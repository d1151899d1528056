//! The words of a noise model, and the proof that they fit.
//!
//! Each word is within half its unit of what it stands for. A part whose standard deviation is off by a fraction ε adds at
//! most var[(1 + ε)² − 1]; what moves the angle itself by a deviation of rms d adds 2·rms·d + d².

use core::f64::consts::{FRAC_1_SQRT_2, PI};
use std::sync::Arc;

use crate::key::{Unrepresentable, shown};
use crate::kinds::allan::lower::theory::{PhysicalTheory, Theory, check_decay};
use crate::kinds::allan::lower::{
    DEVIATIONS, Markov, Model, Noise, Records, Sine, WarmUp, impossible, reach,
};
use crate::sampling;
use sagnac_base::quantity::number::significant;
use sagnac_kernel::moments::LIMIT;
use sagnac_kernel::recipe::{FOUR_STREAMS, STREAMS};
use sagnac_theory::allan::Difference;
use sagnac_theory::allan::markov::settling;
use sagnac_theory::drift::Jumps;
use sagnac_theory::pulse;

/// Units per LSB or per unit of the rate: of standard deviations, of those of Markov noise, and of the amplitude of a
/// sine.
pub(crate) const SIGMA_UNITS: f64 = 16.0;
const MARKOV_UNITS: f64 = 4.0;
const SINE_UNITS: f64 = 4.0;

/// log2 of the fewest and the most LSB in a pulse.
const PULSE_BITS: [f64; 2] = [4.0, 28.0];

/// Bound of the total rounding of the holds of all octaves and streams, which are rounded down, in units of the rate.
const HOLDS_ROUNDED: f64 = 128.0;

/// A noise model in fixed point: the words of the kernel, except for the angles common to all records.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fixed {
    pub(crate) lsb_arcsec: f64,
    pub(crate) white: u32,
    pub(crate) rate_scale: u32,
    pub(crate) walk: u32,
    pub(crate) flicker: Vec<u32>,
    pub(crate) markov: Option<[u32; 3]>,
    pub(crate) sine: Option<[u32; 2]>,
    pub(crate) quantization: u32,
    pub(crate) pulse: Option<u32>,
    pub(crate) switching: Option<[u32; 3]>,
    /// Constant rate as seen by a readout, 2^−32 LSB per sample, modulo whole turns of the word.
    pub(crate) rate: u64,
}

impl Fixed {
    /// The words in the finest unit of angle in which everything fits.
    ///
    /// # Errors
    /// A part has too few of these units.
    pub(crate) fn new(model: &Model) -> Result<Fixed, Unrepresentable> {
        check_decay(model.noise.markov)?;
        let whole = libm::fmax(model.whole(Difference::Second), model.whole(Difference::Third));
        if !whole.is_finite() {
            let what = "differences of the angle of";
            return Err(impossible("noise", what, whole));
        }
        if whole == 0.0 {
            let help = "give at least one noise that is not 0";
            return Err(Unrepresentable::new("noise", "all of it is 0, and there is no readout", help));
        }
        let finest = libm::floor(libm::log2(whole / LIMIT as f64));
        let fixed = match model.readout_lsb > 0.0 {
            false => coarser(libm::exp2(finest))
                .map(|lsb| Fixed::at(model, lsb, None))
                .find(|fixed| fixed.has_room(model)),
            true => {
                let [least, most] = PULSE_BITS;
                let bits = libm::floor(libm::log2(model.readout_lsb) - finest).min(most);
                let all = core::iter::successors(Some(bits), |bits| Some(bits - 1.0));
                all.take_while(|&bits| bits >= least)
                    .map(|bits| Fixed::at(model, model.readout_lsb / libm::exp2(bits), Some(bits as u32)))
                    .find(|fixed| fixed.has_room(model))
            }
        };
        let fixed = fixed.ok_or_else(|| {
            if model.readout_lsb == 0.0 {
                return impossible("noise", "differences of the angle of", whole);
            }
            let has_room = |lsb: &f64| Fixed::at(model, *lsb, None).has_room(model);
            let unit_arcsec = coarser(libm::exp2(finest)).find(has_room).unwrap_or(f64::INFINITY);
            let found = format!(
                "a pulse of {}″ is less than 16 units of {}″ of the 32-bit arithmetic that the angles of the record leave",
                shown(model.readout_lsb),
                significant(unit_arcsec, 3)
            );
            let help = "leave readout_lsb out if pulses as fine as this change nothing; or take a shorter record";
            Unrepresentable::new("noise.readout_lsb", found, help)
        })?;
        fixed.check(model, whole)?;
        Ok(fixed)
    }

    /// The words in a given unit of angle.
    fn at(model: &Model, lsb_arcsec: f64, pulse: Option<u32>) -> Fixed {
        let noise = &model.noise;
        let largest = DEVIATIONS * noise.rate(model.samples) / lsb_arcsec;
        let room =
            |bits: &i32| 1.02 * largest * libm::exp2(f64::from(32 - bits)) + HOLDS_ROUNDED < RATE_LIMIT;
        let rate_bits = (0..=30).find(room).unwrap_or(30);
        let rate_unit = lsb_arcsec * libm::exp2(f64::from(rate_bits - 32));
        let word = |sigma: f64, unit: f64| libm::round(sigma / unit * SIGMA_UNITS) as u32;
        let octave_0 = noise.octaves.first().copied().unwrap_or(0.0);
        let flicker = |(octave, sigma): (usize, &f64)| {
            let streams = streams(octave);
            word(sigma / libm::sqrt(streams), rate_unit)
        };
        let markov = noise.markov.map(|Markov { sigma, decay }| {
            // For a correlation shorter than a sample, one last unit remains.
            let loss = loss(decay).min(LOSS_UNIT - 1.0);
            let spread = libm::sqrt(spread(loss));
            let step = libm::round(sigma * spread / rate_unit * MARKOV_UNITS);
            // Stationary with the rounded step and loss.
            let start = libm::round(step / spread);
            [loss as u32, step as u32, start as u32]
        });
        let sine = model.sine.map(|Sine { amplitude, turns }| {
            let turns = (turns - libm::floor(turns)) * TURN;
            [libm::round(turns) as u64 as u32, libm::round(amplitude / lsb_arcsec * SINE_UNITS) as u32]
        });
        let switching = model.switching.filter(|switching| switching.jumps().is_some()).map(|switching| {
            let amplitude = libm::round(switching.residual / lsb_arcsec * SINE_UNITS);
            [switching.interval as u32, amplitude as u32, word(switching.residual_noise, lsb_arcsec)]
        });
        let rate = match pulse {
            Some(_) => model.mean_rate + model.unfinished().map(WarmUp::rate).sum::<f64>(),
            None => 0.0,
        };
        Fixed {
            lsb_arcsec,
            white: word(libm::hypot(noise.white, octave_0), lsb_arcsec),
            rate_scale: 1 << rate_bits,
            walk: word(noise.walk, rate_unit),
            flicker: noise.octaves.iter().enumerate().skip(1).map(flicker).collect(),
            markov,
            sine,
            quantization: word(noise.quantization, lsb_arcsec),
            pulse,
            switching,
            rate: libm::round(rate / lsb_arcsec * TURN) as i128 as u64,
        }
    }

    /// Size of a unit of the rate, LSB.
    pub(crate) fn rate_unit(&self) -> f64 {
        f64::from(self.rate_scale) / TURN
    }

    /// Size of a pulse, LSB.
    pub(crate) fn pulse_lsb(&self) -> Option<f64> {
        self.pulse.map(|bits| libm::exp2(f64::from(bits)))
    }

    /// The random parts as given by the words, in LSB and samples. Numbers that are rounded down on the way have an
    /// additional variance of 1/12 of a unit.
    pub(crate) fn noise(&self) -> Noise {
        self.noise_of(0.0, 1.0 / 12.0)
    }

    /// The standard deviations whose squares bound how far the variance of each random part may be off that of the
    /// inputs, in LSB and samples: by half a unit of its word, and by what numbers that are rounded down add. The decay
    /// is that of the words.
    pub(crate) fn deviation(&self) -> Noise {
        let [more, plain] = [self.noise_of(0.5, 1.0 / 12.0), self.noise_of(0.0, 0.0)];
        let apart = |more: f64, plain: f64| libm::sqrt(more * more - plain * plain);
        let octaves = more.octaves.iter().zip(&plain.octaves);
        let markov = more.markov.zip(plain.markov);
        Noise {
            quantization: apart(more.quantization, plain.quantization),
            white: apart(more.white, plain.white),
            octaves: octaves.map(|(more, plain)| apart(*more, *plain)).collect(),
            walk: apart(more.walk, plain.walk),
            markov: markov
                .map(|(more, plain)| Markov { sigma: apart(more.sigma, plain.sigma), decay: plain.decay }),
        }
    }

    /// The random parts of words that are half a unit smaller.
    pub(crate) fn less(&self) -> Noise {
        self.noise_of(-0.5, 0.0)
    }

    /// The decays of Markov noise whose loss has half a unit less and more than the word.
    pub(crate) fn decays(&self) -> Option<[f64; 2]> {
        let decay = |loss: f64| -libm::log1p(-loss / LOSS_UNIT);
        self.markov.map(|[loss, ..]| [-0.5, 0.5].map(|more| decay(f64::from(loss) + more)))
    }

    /// The random parts of words that are `more` units larger, where they are not 0, with the variance `rounded` of
    /// numbers that are rounded down.
    fn noise_of(&self, more: f64, rounded: f64) -> Noise {
        let unit = self.rate_unit();
        let sigma = |word: u32| if word > 0 { (f64::from(word) + more) / SIGMA_UNITS } else { 0.0 };
        let square = |word: u32| sigma(word) * sigma(word) + rounded;
        let octave = |(octave, &word): (usize, &u32)| unit * libm::sqrt(streams(octave) * square(word));
        let octaves = (1..).zip(&self.flicker).map(octave);
        let rounded_rates = f64::from(u8::from(self.walk > 0) + u8::from(self.markov.is_some())) * rounded;
        let white = sigma(self.white);
        Noise {
            quantization: if self.quantization > 0 { libm::sqrt(square(self.quantization)) } else { 0.0 },
            white: libm::sqrt(white * white + rounded_rates * unit * unit),
            octaves: if self.flicker.is_empty() {
                vec![]
            } else {
                core::iter::once(0.0).chain(octaves).collect()
            },
            walk: unit * sigma(self.walk),
            markov: self.markov.map(|[loss, step, _]| Markov {
                sigma: unit * (f64::from(step) + more) / MARKOV_UNITS / libm::sqrt(spread(f64::from(loss))),
                decay: -libm::log1p(-f64::from(loss) / LOSS_UNIT),
            }),
        }
    }

    /// Standard deviation of the new random part of the angle from one sample to the next, LSB.
    pub(crate) fn fresh(&self) -> f64 {
        let unit = self.rate_unit();
        let steps = [
            f64::from(self.white) / SIGMA_UNITS,
            unit * f64::from(self.walk) / SIGMA_UNITS,
            unit * f64::from(self.markov.map_or(0, |[_, step, _]| step)) / MARKOV_UNITS,
        ];
        libm::sqrt(steps.iter().map(|step| step * step).sum())
    }

    /// Whether there is an angle to be rounded down, apart from drift, sine and quantization noise.
    pub(crate) fn has_angle(&self) -> bool {
        self.white > 0 || self.walk > 0 || !self.flicker.is_empty() || self.markov.is_some()
    }

    /// The sine as given by the words, LSB and samples.
    pub(crate) fn wave(&self) -> Option<Sine> {
        self.sine.map(|[step, amplitude]| Sine {
            amplitude: f64::from(amplitude) / SINE_UNITS,
            turns: f64::from(step) / TURN,
        })
    }

    /// The fill residuals as given by the words, LSB.
    pub(crate) fn jumps(&self) -> Option<Jumps> {
        self.switching.map(|[interval, amplitude, sigma]| {
            let [amplitude, sigma] = [f64::from(amplitude) / SINE_UNITS, f64::from(sigma) / SIGMA_UNITS];
            Jumps { interval: interval.into(), variance: 0.5 * amplitude * amplitude + sigma * sigma }
        })
    }

    /// Bound of the deviation of the mean square of the fill residuals from that of the inputs, relative.
    pub(crate) fn jumps_deviation(&self) -> f64 {
        let words = self.switching.into_iter().flat_map(|[_, amplitude, sigma]| [amplitude, sigma]);
        let half = words.filter(|word| *word > 0).map(|word| 0.5 / f64::from(word)).fold(0.0, libm::fmax);
        half * (2.0 + half)
    }

    /// Bounds of the deviations of the sine from that of the inputs: of its amplitude, LSB, and of its turns per sample.
    pub(crate) fn wave_deviation(&self) -> [f64; 2] {
        [0.5 / SINE_UNITS, 0.5 / TURN]
    }

    /// Largest relative deviation of a standard deviation of [`Noise::simple`] from that of the inputs.
    fn simple_deviation(&self) -> f64 {
        let [loss, step] = self.markov.map_or([0; 2], |[loss, step, _]| [loss, step]);
        let words = [self.quantization, self.white, step, loss];
        let half = words.into_iter().filter(|word| *word > 0).map(|word| 0.5 / f64::from(word));
        half.fold(0.0, libm::fmax) + if loss > 0 { 0.5 / f64::from(loss) } else { 0.0 }
    }

    /// Relative deviation of the initial variance of the Markov noise from its stationary one.
    pub(crate) fn start_error(&self) -> f64 {
        self.markov.map_or(0.0, |[loss, step, start]| {
            let (step, start) = (f64::from(step), f64::from(start));
            libm::fabs(start * start * spread(f64::from(loss)) / (step * step) - 1.0)
        })
    }

    /// Bound of all differences of the record, LSB.
    fn reach(&self, model: &Model, difference: Difference) -> f64 {
        let m = model.longest(difference);
        if m == 0 {
            return 0.0;
        }
        let jumps = self.jumps().map_or(0.0, |jumps| jumps.largest_variance(difference, m));
        let noise = DEVIATIONS * libm::sqrt(self.noise().variance(difference, m) + jumps);
        let sine = self.wave().map_or(0.0, |sine| sine.largest(difference, m));
        let trend = model.trend(difference) / self.lsb_arcsec;
        let pulses = 0.5 * self.pulse_lsb().unwrap_or(0.0);
        // Angle, sine, quantization noise, drift and fill residuals are each rounded by less than one LSB.
        let rounded = if self.switching.is_some() { 5.0 } else { 4.0 };
        noise + sine + trend + reach(difference) * (pulses + rounded)
    }

    /// The proof: differences fit 2^29 and rates 2^31, and factors of products leave room for a sign.
    fn has_room(&self, model: &Model) -> bool {
        let fits = |difference| self.reach(model, difference) < LIMIT as f64;
        let rate = DEVIATIONS * self.noise().rate(model.samples) / self.rate_unit() + HOLDS_ROUNDED;
        let mut words = vec![self.white, self.walk, self.quantization];
        words.extend(&self.flicker);
        words.extend(self.markov.iter().flatten());
        words.extend(self.sine.iter().map(|[_, amplitude]| amplitude));
        words.extend(self.switching.iter().flatten());
        fits(Difference::Second)
            && fits(Difference::Third)
            && rate < RATE_LIMIT
            && words.iter().all(|&word| word < 1 << 31)
    }
}

impl Model {
    /// Warm-ups that outlast the record: apart from a constant rate, which affects no difference, they are small.
    pub(crate) fn unfinished(&self) -> impl Iterator<Item = &WarmUp> {
        self.warm_ups.iter().filter(|warm_up| warm_up.decay * (self.samples as f64) < 1.0)
    }
}

impl WarmUp {
    /// Rate at the start, ″ per sample.
    pub(crate) fn rate(&self) -> f64 {
        self.reach * self.decay
    }
}

/// Units of the sine's phase per turn; also units of the angle per LSB.
pub(crate) const TURN: f64 = 4_294_967_296.0;
/// Units of the loss of Markov noise.
const LOSS_UNIT: f64 = 1_073_741_824.0;
/// Bound of the rate in its units.
const RATE_LIMIT: f64 = 2_147_483_648.0;

/// The word of a decay: what a rate loses in a sample.
pub(crate) fn loss(decay: f64) -> f64 {
    libm::round(-libm::expm1(-decay) * LOSS_UNIT)
}

/// 1 − a² for a = 1 − loss.
fn spread(loss: f64) -> f64 {
    let part = loss / LOSS_UNIT;
    part * (2.0 - part)
}

/// Number of streams of an octave.
fn streams(octave: usize) -> f64 {
    if octave < FOUR_STREAMS { 1.0 } else { STREAMS as f64 }
}

/// A unit of angle, followed by all coarser ones.
fn coarser(lsb: f64) -> impl Iterator<Item = f64> {
    core::iter::successors(Some(lsb), |lsb| Some(2.0 * lsb)).take_while(|lsb| lsb.is_finite())
}

/// Largest rounding of an angle of the table of drift, LSB: half a unit, and that of the sums in floating point.
const DRIFT_ROUNDING: f64 = 0.51;

impl Records {
    /// Relative difference of a theoretical value at `ms()[at]` from the closed form of the inputs, where there is one.
    ///
    /// # Errors
    /// The difference exceeds what the rounding of words explains.
    pub(crate) fn representation(
        &self,
        at: usize,
        theory: &Theory,
        physical: &PhysicalTheory,
    ) -> Result<Option<f64>, Unrepresentable> {
        let m = self.ms()[at];
        let Some((words, inputs)) = theory.value.zip(physical.variance(m)) else { return Ok(None) };
        let most = theory.representation + inputs.error;
        let off = (words - inputs.value).abs();
        if off > most || off.is_nan() {
            let found = format!(
                "the variance at an averaging time of {} s is {} (arcsec/s)^2 for the integers that would be sampled and {} \
                 (arcsec/s)^2 for the inputs, which rounding to {} does not explain",
                significant(self.sample_s * m as f64, 6),
                shown(words),
                shown(inputs.value),
                shown(most)
            );
            let help = "this is a fault of the program: please report the study";
            return Err(Unrepresentable::new("noise", found, help));
        }
        Ok(sampling::representation(Some(words), Some(inputs.value), most))
    }

    /// Bound of the deviation of the mean square at `m` except that of the readout, where the mean square of what all
    /// records share is `trend`, LSB².
    pub(crate) fn representation_bound(&self, m: u64, trend: f64) -> f64 {
        let (fixed, difference) = (&self.fixed, self.estimator.difference);
        let off = |mean_square: f64, d: f64| 2.0 * libm::sqrt(mean_square) * d + d * d;
        let deviation = fixed.deviation();
        let mut sum = deviation.variance(difference, m);
        if let Some((markov, decays)) = fixed.noise().markov.zip(fixed.decays()) {
            let alone = |decay: f64| {
                let markov = Some(Markov { decay, ..markov });
                Noise { quantization: 0.0, white: 0.0, octaves: vec![], walk: 0.0, markov }
                    .variance(difference, m)
            };
            let own = alone(markov.decay);
            // Half a unit is so little that the variance is a line, but for the higher orders in 1/loss.
            sum += 2.0 * decays.map(|decay| libm::fabs(alone(decay) - own)).into_iter().fold(0.0, libm::fmax);
        }
        if let Some(jumps) = fixed.jumps() {
            let variance = jumps.mean_square(self.estimator, self.recipe.samples.into(), m);
            sum += fixed.jumps_deviation() * variance;
        }
        if let Some(sine) = fixed.wave() {
            let spans = difference.spans() as f64;
            let variance = sine.part().map_or(0.0, |part| part.variance(difference, 1.0, m));
            let [amplitude, turns] = fixed.wave_deviation();
            // The difference of a unit amplitude is |2 sin πfm|^spans.
            let d = FRAC_1_SQRT_2
                * (amplitude * Sine { amplitude: 1.0, ..sine }.largest(difference, m)
                    + (sine.amplitude + amplitude)
                        * spans
                        * libm::exp2(spans - 1.0)
                        * 2.0
                        * PI
                        * m as f64
                        * turns);
            sum += off(variance, d);
        }
        if !self.recipe.drift.is_empty() {
            sum += off(trend, DRIFT_ROUNDING * reach(difference));
        }
        sum
    }

    /// Bound of the deviation of the contribution of reading whole pulses, LSB², where the products of the coefficients of
    /// a difference add up to `pairs` in magnitude.
    pub(crate) fn readout_bound(&self, pulse: f64, pairs: f64, m: u64) -> f64 {
        let (fixed, difference) = (&self.fixed, self.estimator.difference);
        let samples = (difference.spans() * m) as f64;
        let of_noise = |noise: &Noise| pulse::noise_variance(&noise.simple(), difference.spans() * m);
        let noise = fixed.noise();
        let [amplitude, turns] = fixed.wave_deviation();
        let of_sine = fixed
            .wave()
            .map_or(0.0, |sine| 2.0 * amplitude + (sine.amplitude + amplitude) * 2.0 * PI * samples * turns);
        // The covariance of two errors changes by at most half a pulse per LSB of the angle between them.
        let between = fixed.simple_deviation() * libm::sqrt(of_noise(&noise))
            + libm::sqrt(of_noise(&fixed.deviation()))
            + of_sine
            + 0.5 * samples / TURN
            // Both sides take the angle between two readings in f64.
            + 32.0 * f64::EPSILON * libm::fabs(fixed.rate.cast_signed() as f64 / TURN) * samples;
        // Both are that near to white noise.
        let white = 2.0 * pulse::white_error(pulse, &fixed.less().simple(), difference, m);
        libm::fmin(0.5 * pairs * pulse * between, white)
    }
}

/// The angles at all samples, wrapped; empty where nothing drifts.
///
/// From a warm-up that outlasts the record, its initial rate is subtracted; it affects a readout only, and
/// [`Fixed::rate`] contains it. The rest is not much larger than its differences, and keeps its digits.
pub(crate) fn angles(model: &Model, fixed: &Fixed) -> Arc<[u32]> {
    if !model.is_curved() && fixed.rate == 0 {
        return Arc::new([]);
    }
    let end = model.samples as f64;
    let angle = |sample: u64| {
        let k = sample as f64;
        let mut curved = 0.5 * model.ramp * k * k;
        for warm_up in &model.warm_ups {
            let passed = warm_up.decay * k;
            curved += warm_up.reach
                * match warm_up.decay * end < 1.0 {
                    true => -settling(passed),
                    false => -libm::expm1(-passed),
                };
        }
        if let Some(switching) = &model.switching {
            curved += switching.magnetic.signed_integral(switching.interval as f64, k);
        }
        let curved = libm::round(curved / fixed.lsb_arcsec * TURN) as i128 as u64;
        let angle = fixed.rate.wrapping_mul(sample).wrapping_add(curved);
        (angle.wrapping_add(1 << 31) >> 32) as u32
    };
    (0..=model.samples).map(angle).collect()
}

/// Mean square of the differences of the angles at `m`, `stride` apart, and the first of the differences, LSB.
pub(crate) fn differences(
    angles: &[u32],
    difference: Difference,
    stride: usize,
    m: usize,
    terms: u64,
) -> [f64; 2] {
    let at = |start: usize| -> i32 {
        let angle = |n: usize| angles[start + n * m];
        let second = |n: usize| {
            angle(n + 2).wrapping_sub(angle(n + 1)).wrapping_sub(angle(n + 1).wrapping_sub(angle(n)))
        };
        match difference {
            Difference::Second => second(0) as i32,
            Difference::Third => second(1).wrapping_sub(second(0)) as i32,
        }
    };
    if angles.is_empty() {
        return [0.0; 2];
    }
    let square = |k: u64| u128::from(at(k as usize * stride).unsigned_abs()).pow(2);
    let sum: u128 = (0..terms).map(square).sum();
    [sum as f64 / terms as f64, f64::from(at(0))]
}
