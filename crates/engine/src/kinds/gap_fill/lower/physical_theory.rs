//! The rms of an error from the physical inputs: theory that shares no computation with the kernel.
//!
//! The error of a filler is a sum E = Σ g_b θ_b over the angles at the ends of the ticks, with g_b = w_b − w_{b+1} for
//! weights w on the ticks and −1 on those of the gap. What the kernel takes, angles of ticks in units, rows of Gaussian
//! motion, phases at the middles of ticks, does not occur: sines are integrated to the ends of the ticks, and the
//! variance of random motion is −Σ r_l D(l), where r is the autocorrelation of g in exact integers and D the variance of
//! the angle less its covariance, in twice the precision of `f64` because nearly all of it cancels. Shared with the
//! kernel are the weights, which are the filler, and the angles of the ticks of a record before they are rounded.

use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};
use std::collections::{BTreeMap, HashMap};

use crate::filler::read::Error;
use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::lower::fixed::Rows;
use crate::kinds::gap_fill::lower::readout::class;
use crate::motion::keys::Phase;
use crate::motion::{Frequency, Tone, Value, WindowMeans};
use sagnac_kernel::gap_fill::shape::MARGIN;
use sagnac_theory::lines::Double;
use sagnac_theory::minimum_variance::Band;
use sagnac_theory::pulse::mean_variance;
use sagnac_theory::quadrature::{Memo, Rule};
use sagnac_theory::{lines, quadrature};

/// The physical theory of a point.
pub(crate) struct PhysicalTheory<'a> {
    inputs: &'a Inputs,
    /// [Structure](lines::structure) of the angles of sines of random phase by distance in ticks, ″²; empty without any.
    sines: Vec<Double>,
    /// That of other motion of no mean.
    others: Vec<Double>,
    /// Most ticks on a side that an error reaches.
    sides: usize,
}

/// The error at a switch, ″: its mean, its variance without that of sines of random phase, and their amplitudes by the
/// place of the tone.
pub(crate) struct Switch {
    pub(crate) mean: f64,
    pub(crate) variance: f64,
    pub(crate) sines: Vec<(usize, f64)>,
}

/// The factors of an error, multiplied by the denominator of its weights.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Boundaries {
    /// The first boundary: the end of tick b is at bT, where the gap begins at 0.
    first: i32,
    /// The factors g_b of the angles at the boundaries.
    factors: Vec<i64>,
    /// The autocorrelation Σ g_b g_{b+l}, twice for l > 0.
    products: Vec<Double>,
    denominator: f64,
}

impl Boundaries {
    fn new(rows: &Rows, gap_ticks: i32) -> Boundaries {
        let weights = rows.numerators.last().map_or(&[][..], |row| row);
        let first = rows.ticks.iter().copied().fold(1, i32::min) - 1;
        let last = rows.ticks.iter().copied().fold(gap_ticks, i32::max);
        let mut factors = vec![0_i64; (last - first + 1) as usize];
        let mut add = |tick: i32, weight: i64| {
            factors[(tick - first) as usize] += weight;
            factors[(tick - first) as usize - 1] -= weight;
        };
        rows.ticks.iter().zip(weights).for_each(|(&tick, &weight)| add(tick, weight));
        (1..=gap_ticks).for_each(|tick| add(tick, -rows.denominator));
        let others = || factors.iter().enumerate().filter(|(_, g)| **g != 0);
        let mut products = vec![0_i128; factors.len()];
        for (at, (i, &a)) in others().enumerate() {
            products[0] += i128::from(a) * i128::from(a);
            others().skip(at + 1).for_each(|(j, &b)| products[j - i] += 2 * i128::from(a) * i128::from(b));
        }
        let products = products.into_iter().map(Double::from).collect();
        Boundaries { first, factors, products, denominator: rows.denominator as f64 }
    }

    /// Σ g_b x(t) over the times t of the boundaries after the middle of the gap, in ticks.
    fn sum(&self, gap_ticks: u32, x: impl Fn(f64) -> f64) -> f64 {
        let middle = 0.5 * f64::from(gap_ticks);
        let at = |(k, &g): (usize, &i64)| g as f64 * x(f64::from(self.first) + k as f64 - middle);
        self.factors.iter().enumerate().map(at).sum::<f64>() / self.denominator
    }

    /// −Σ r_l D(l) with r the autocorrelation of g, whose sum is 0.
    fn variance(&self, structure: &[Double]) -> f64 {
        assert!(structure.is_empty() || structure.len() >= self.products.len());
        let terms = self.products.iter().zip(structure);
        let sum = terms.fold(Double::default(), |sum, (product, d)| sum - *product * *d);
        sum.value() / (self.denominator * self.denominator)
    }
}

/// The angle of a tone of unit rate at phase `phase` at the middle of the gap, `t_s` later: ∫ sin(2πνt + φ) dt.
fn turned(frequency_hz: f64, phase: f64, t_s: f64) -> f64 {
    let half = 0.5 * TAU * frequency_hz * t_s;
    let length = if half == 0.0 { t_s } else { t_s * libm::sin(half) / half };
    length * libm::sin(half + phase)
}

impl PhysicalTheory<'_> {
    /// The theory of a point for errors that reach at most `sides` ticks on a side.
    pub(crate) fn new(inputs: &Inputs, sides: usize) -> PhysicalTheory<'_> {
        let Inputs { tick_s, motion, .. } = inputs;
        let span = 2 * sides + inputs.gap_ticks as usize;
        let (mut sines, mut others) = (vec![], vec![]);
        for tone in motion.tones.iter().filter(|tone| is_random(tone)) {
            let of_angles = lines::of_angles(&tone.lines(span as f64 * tick_s, Rule::Panels), *tick_s);
            add(
                if is_sine(tone) { &mut sines } else { &mut others },
                &lines::structure(&of_angles, span + 1),
                1.0,
            );
        }
        if let Some(gaussian) = &motion.gaussian {
            let (part, factor) = gaussian.structure(*tick_s, span + 1);
            add(&mut others, &part, factor);
        }
        PhysicalTheory { inputs, sines, others, sides }
    }

    /// The rms of an error, ″; `None` where it has no closed form.
    pub(crate) fn rms(&self, rows: &Rows, error: Error) -> Option<f64> {
        if error == Error::InGap && self.inputs.gap_ticks > 1 || self.has_averaged_pulses() {
            return None;
        }
        let boundaries = self.boundaries(rows);
        let [mean, variance] = self.moments(rows, boundaries);
        let square = mean * mean + variance + boundaries.variance(&self.sines).max(0.0);
        Some(libm::sqrt(square.max(0.0)))
    }

    /// The error at a switch.
    pub(crate) fn switch(&self, rows: &Rows) -> Switch {
        let Inputs { tick_s, motion, gap_ticks, .. } = self.inputs;
        let boundaries = self.boundaries(rows);
        let [mean, variance] = self.moments(rows, boundaries);
        let amplitude = |tone: &Tone| {
            let nu = tone.band().low_hz;
            let parts = [0.0, FRAC_PI_2]
                .map(|phase| boundaries.sum(*gap_ticks, |ticks| turned(nu, phase, ticks * tick_s)));
            tone.amplitude.value.scale() * tone.rate_factor(nu) * libm::hypot(parts[0], parts[1])
        };
        let tones = motion.tones.iter().enumerate().filter(|(_, tone)| is_sine(tone));
        Switch { mean, variance, sines: tones.map(|(place, tone)| (place, amplitude(tone))).collect() }
    }

    fn boundaries<'b>(&self, rows: &'b Rows) -> &'b Boundaries {
        rows.boundaries.get_or_init(|| Boundaries::new(rows, self.inputs.gap_ticks as i32))
    }

    /// Mean, ″, and variance, ″², without sines of random phase.
    fn moments(&self, rows: &Rows, boundaries: &Boundaries) -> [f64; 2] {
        let Inputs { tick_s, motion, gap_ticks, relock, .. } = self.inputs;
        let weight = |tick: i32| {
            let place = rows.ticks.iter().position(|&own| own == tick)?;
            Some(rows.numerators.last()?[place] as f64 / boundaries.denominator)
        };
        let after = |(k, angle): (usize, &f64)| Some(weight(*gap_ticks as i32 + 1 + k as i32)? * angle);
        let relocked: f64 = relock.iter().enumerate().filter_map(after).sum();
        let mut mean = relocked + boundaries.sum(*gap_ticks, |ticks| self.steady(ticks));
        let mut variance = boundaries.variance(&self.others).max(0.0);
        for tone in motion.tones.iter().filter(|tone| !is_random(tone)) {
            let [first, second] = self.at_fixed_phase(tone, boundaries);
            mean += first;
            variance += second - first * first;
        }
        if let Some(profile) = &motion.profile {
            let means = profile.window_means(*tick_s, *gap_ticks, self.sides);
            let [first, second] = replayed(rows, *gap_ticks as i32, &means, self.sides);
            mean += first;
            variance += second - first * first;
        }
        let sigma = self.inputs.sigma_arcsec();
        let squares: f64 = rows.ticks.iter().filter_map(|&tick| weight(tick)).map(|w| w * w).sum();
        // What pulses add may come out below 0 where it vanishes.
        [mean, (variance.max(0.0) + sigma * sigma * squares + self.pulses(rows)).max(0.0)]
    }

    /// The angle of the constant rate and acceleration so many ticks after the middle of the gap, ″.
    fn steady(&self, ticks: f64) -> f64 {
        let Inputs { tick_s, motion, .. } = self.inputs;
        let t_s = ticks * tick_s;
        motion.rate * t_s + 0.5 * motion.acceleration * t_s * t_s
    }

    /// The angle at a boundary that all trials have in common, but for vibration: that of rate, acceleration and relock, ″.
    fn common(&self, boundary: i32) -> f64 {
        let Inputs { gap_ticks, relock, .. } = self.inputs;
        let after = (boundary - *gap_ticks as i32).max(0) as usize;
        let added: f64 = relock.iter().take(after).sum();
        self.steady(f64::from(boundary) - 0.5 * f64::from(*gap_ticks)) + added
    }

    /// Whether there are pulses whose variance is a mean over the motion, without a closed form.
    fn has_averaged_pulses(&self) -> bool {
        let Inputs { motion, readout_lsb, .. } = self.inputs;
        let has_form = |tone: &Tone| matches!(tone.frequency, Frequency::Fixed(_)) && !is_uniform(tone);
        *readout_lsb > 0.0 && (motion.profile.is_some() || !motion.tones.iter().all(has_form))
    }

    /// The variance that whole pulses add, ″².
    fn pulses(&self, rows: &Rows) -> f64 {
        let Inputs { tick_s, motion, gap_ticks, readout_lsb: pulse, .. } = self.inputs;
        if *pulse == 0.0 {
            return 0.0;
        }
        let tones = &motion.tones;
        // Each reading takes the fraction at its end less that at its beginning; nothing is read within the gap.
        let mut factors: BTreeMap<i32, f64> = BTreeMap::new();
        for (&tick, &weight) in rows.ticks.iter().zip(rows.numerators.last().into_iter().flatten()) {
            let weight = weight as f64 / rows.denominator as f64;
            *factors.entry(tick).or_default() += weight;
            *factors.entry(tick - 1).or_default() -= weight;
        }
        let factors: Vec<(i32, f64)> = factors.into_iter().filter(|(_, factor)| *factor != 0.0).collect();
        if self.has_averaged_pulses() {
            return self.averaged_pulses(factors);
        }
        let n = *gap_ticks as i32;
        let place = |b: i32| f64::from(b) - 0.5 * f64::from(n);
        // The angle of everything without a random phase at a boundary.
        let fixed = |b: i32| {
            let of_tone = |tone: &Tone| {
                let nu = tone.band().low_hz;
                let phase = if tone.phase == Phase::Extremum { FRAC_PI_2 } else { 0.0 };
                tone.amplitude.value.scale() * tone.rate_factor(nu) * turned(nu, phase, place(b) * tick_s)
            };
            let tones: f64 = tones.iter().filter(|tone| !is_random(tone)).map(of_tone).sum();
            self.common(b) + tones
        };
        let angles: Vec<f64> = factors.iter().map(|&(b, _)| fixed(b)).collect();
        let sigma = self.inputs.sigma_arcsec();
        let (mut sum, mut known) = (0.0, HashMap::new());
        for (i, &(from, g)) in factors.iter().enumerate() {
            sum += g * g * pulse * pulse / 12.0;
            for (j, &(to, h)) in factors.iter().enumerate().skip(i + 1) {
                let (lag, constant) = ((to - from) as usize, angles[j] - angles[i]);
                let compute = || {
                    let moved = 2.0 * if self.others.is_empty() { 0.0 } else { self.others[lag].value() };
                    let swing = |tone: &Tone| {
                        let nu = tone.band().low_hz;
                        let length = turned(nu, FRAC_PI_2, 0.5 * lag as f64 * tick_s) * 2.0;
                        tone.amplitude.value.scale() * tone.rate_factor(nu) * length
                    };
                    let swings: Vec<f64> = tones.iter().filter(|tone| is_sine(tone)).map(swing).collect();
                    fractions(*pulse, constant, moved + sigma * sigma * lag as f64, &swings)
                };
                let covariance = *known.entry((lag, constant.to_bits())).or_insert_with(compute);
                sum += 2.0 * g * h * covariance;
            }
        }
        sum
    }

    /// Returns the same variance as a mean over the places of a record or over drawn values. `factors` are those of the
    /// fractions at some boundaries.
    fn averaged_pulses(&self, factors: Vec<(i32, f64)>) -> f64 {
        let Inputs { tick_s, motion, gap_ticks, relock, readout_lsb: pulse, .. } = self.inputs;
        let replay = motion.profile.as_ref().map(|profile| profile.replay(*tick_s));
        let mut known = self.inputs.clone();
        known.motion.profile = None;
        let content = replay.as_ref().map(|replay| replay.content);
        AVERAGES.get(format!("{known:?} {content:?} {factors:?}"), || {
            let n = *gap_ticks as i32;
            let (ticks, factors): (Vec<i32>, Vec<f64>) = factors.into_iter().unzip();
            let time = |b: i32| f64::from(b) - 0.5 * f64::from(n);
            let constants: Vec<f64> = ticks.iter().map(|&b| self.common(b)).collect();
            let is_stationary = replay.is_none()
                && motion.tones.iter().all(is_random)
                && motion.acceleration == 0.0
                && relock.is_empty();
            let span = 2 * self.sides + *gap_ticks as usize;
            let structure = motion.gaussian.as_ref().map(|gaussian| gaussian.structure(*tick_s, span + 1));
            let sigma = self.inputs.sigma_arcsec();
            let deviation = |i: usize, j: usize| {
                let lag = (ticks[j] - ticks[i]) as usize;
                let moved = structure.as_ref().map_or(0.0, |(part, factor)| 2.0 * part[lag].value() * factor);
                libm::sqrt(moved + sigma * sigma * lag as f64) / pulse
            };
            let class = |i: usize, j: usize| is_stationary.then(|| class([ticks[i], ticks[j]], n));
            let mut ends = vec![0.0];
            for angle in replay.iter().flat_map(|replay| &replay.angles) {
                ends.push(ends[ends.len() - 1] + angle);
            }
            let places =
                replay.as_ref().map(|replay| replay.angles.len() + 1 - 2 * MARGIN - *gap_ticks as usize);
            let angles = |draw: usize, angles: &mut [f64]| {
                angles.copy_from_slice(&constants);
                if replay.is_some() {
                    let end = |b: i32| ends[(draw + MARGIN).wrapping_add_signed(b as isize)];
                    angles.iter_mut().zip(&ticks).for_each(|(angle, &b)| *angle += end(b));
                }
                let mut coordinates = quadrature::lattice_point(draw as u32);
                for tone in &motion.tones {
                    let [amplitude, nu, phase] = drawn(tone, &mut coordinates);
                    for (angle, &b) in angles.iter_mut().zip(&ticks) {
                        *angle += amplitude * tone.rate_factor(nu) * turned(nu, phase, time(b) * tick_s);
                    }
                }
                angles.iter_mut().for_each(|angle| *angle /= pulse);
            };
            let draws = places.unwrap_or(quadrature::LATTICE_POINTS as usize);
            mean_variance(&factors, deviation, class, draws, angles) * pulse * pulse / 12.0
        })
    }

    /// Mean and mean square of the error that a tone of fixed phase leaves, over its amplitudes and frequencies.
    fn at_fixed_phase(&self, tone: &Tone, boundaries: &Boundaries) -> [f64; 2] {
        let Inputs { tick_s, gap_ticks, .. } = self.inputs;
        let phase = if tone.phase == Phase::Extremum { FRAC_PI_2 } else { 0.0 };
        let error = |nu: f64| {
            let turned = boundaries.sum(*gap_ticks, |ticks| turned(nu, phase, ticks * tick_s));
            tone.rate_factor(nu) * turned
        };
        let band = tone.band();
        let (mut first, mut second) = (0.0, 0.0);
        let mut add = |nu: f64, part: f64| {
            let e = error(nu);
            first += part * e;
            second += part * e * e;
        };
        let width = band.high_hz - band.low_hz;
        if width == 0.0 {
            add(band.low_hz, 1.0);
        } else {
            let turns = 2.0 * width * tick_s * boundaries.factors.len() as f64;
            Rule::Panels.integrate(band.low_hz, band.high_hz, turns, |nu, weight| add(nu, weight / width));
        }
        let (mean, square) = match tone.amplitude.value {
            Value::Uniform([low, high]) => (0.5 * (low + high), tone.amplitude.value.mean_square()),
            Value::Fixed(x) | Value::Rayleigh(x) => (x, x * x),
        };
        [mean * first, square * second]
    }
}

/// Amplitude, frequency in Hz and phase at the middle of the gap of a tone with as many coordinates between 0 and 1 as it takes.
fn drawn(tone: &Tone, coordinates: &mut impl Iterator<Item = f64>) -> [f64; 3] {
    let mut next = || coordinates.next().unwrap_or(0.5);
    let phase = match tone.phase {
        _ if is_random(tone) => TAU * next(),
        Phase::Extremum => FRAC_PI_2,
        Phase::Uniform | Phase::ZeroCrossing => 0.0,
    };
    let amplitude = match tone.amplitude.value {
        Value::Uniform([low, high]) if low < high => low + (high - low) * next(),
        Value::Uniform([x, _]) | Value::Fixed(x) => x,
        Value::Rayleigh(x) => x * libm::sqrt(-2.0 * libm::log(next())),
    };
    let Band { low_hz, high_hz } = tone.band();
    let part = if low_hz < high_hz { next() } else { 0.0 };
    [amplitude, low_hz + (high_hz - low_hz) * part, phase]
}

/// The averages of the last few motions and fillers.
static AVERAGES: Memo<String, f64> = Memo::new(256);

/// Terms of the sum over the harmonics of a pulse, and most of them where swings are so small that more are needed.
const TERMS: f64 = 4096.0;
const MANY_TERMS: u32 = 1 << 16;

/// Covariance of the fractions of a pulse at two ends of an angle that is a constant, a normal number of this variance and
/// sines of random phase of these amplitudes: q²/2π² Σ E cos(2πm d/q)/m².
fn fractions(pulse: f64, constant: f64, variance: f64, swings: &[f64]) -> f64 {
    let y = (constant - pulse * libm::floor(constant / pulse + 0.5)).abs();
    // Of an angle d far below half a pulse: q²/12 − ½ q E|d| + ½ E d².
    let about = |magnitude: f64, square: f64| pulse * (pulse / 12.0 - 0.5 * magnitude) + 0.5 * square;
    let deviation = libm::sqrt(variance);
    if swings.is_empty() && deviation < 0.05 * pulse {
        let z = if deviation > 0.0 { y / deviation } else { f64::INFINITY };
        let folded =
            y * libm::erf(z * FRAC_1_SQRT_2) + deviation * libm::sqrt(4.0 / TAU) * libm::exp(-0.5 * z * z);
        return about(folded, y * y + variance);
    }
    let unit = 2.0 * pulse * pulse / (TAU * TAU);
    let (mut sum, mut lost) = (0.0, 0.0);
    for m in (1..=MANY_TERMS).map(f64::from) {
        let k = TAU * m / pulse;
        let damped = libm::exp(-0.5 * k * k * variance);
        let left = damped * swings.iter().map(|swing| libm::j0(k * swing)).product::<f64>();
        let term = libm::cos(k * constant) / (m * m);
        sum += left * term;
        lost += (1.0 - left) * term;
        if damped < 1e-16 || m >= TERMS && left < 0.5 {
            return unit * sum;
        }
    }
    // Of hardly any motion the omitted terms are those of the angle at rest.
    about(y, y * y) - unit * lost
}

fn add(sums: &mut Vec<Double>, part: &[Double], factor: f64) {
    sums.resize(part.len(), Double::default());
    sums.iter_mut().zip(part).for_each(|(sum, part)| *sum = *sum + *part * Double::from(factor));
}

/// Mean and mean square of the error over the places of a record.
fn replayed(rows: &Rows, gap_ticks: i32, means: &WindowMeans, sides: usize) -> [f64; 2] {
    let weights = rows.ticks.iter().copied().zip(rows.numerators.last().into_iter().flatten().copied());
    let gap = (1..=gap_ticks).map(|tick| (tick, -rows.denominator));
    let factors: Vec<(usize, Double)> = weights
        .chain(gap)
        .map(|(tick, factor)| ((tick - 1 + sides as i32) as usize, Double::from(i128::from(factor))))
        .collect();
    let mut sums = [Double::default(); 2];
    for &(i, a) in &factors {
        sums[0] = sums[0] + a * means.ticks[i];
        let row = factors.iter().fold(Double::default(), |sum, &(j, b)| sum + b * means.products[i][j]);
        sums[1] = sums[1] + a * row;
    }
    let denominator = rows.denominator as f64;
    [sums[0].value() / denominator, sums[1].value() / (denominator * denominator)]
}

/// Whether the error that a tone leaves has no mean: its phase is random, or its sine and cosine are normal.
fn is_random(tone: &Tone) -> bool {
    tone.phase == Phase::Uniform || matches!(tone.amplitude.value, Value::Rayleigh(_))
}

/// Whether the error that a tone leaves is a sine of a random phase.
fn is_sine(tone: &Tone) -> bool {
    let is_fixed = matches!((tone.frequency, tone.amplitude.value), (Frequency::Fixed(_), Value::Fixed(_)));
    tone.phase == Phase::Uniform && is_fixed
}

fn is_uniform(tone: &Tone) -> bool {
    matches!(tone.amplitude.value, Value::Uniform(_))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    use crate::kinds::gap_fill::inputs::TickNoise;
    use crate::kinds::gap_fill::verify::{Configuration, configurations, minimum_variance};
    use crate::motion::{Gaussian, Motion};
    use sagnac_theory::minimum_variance::Band;

    #[test]
    fn every_closed_form_of_the_words_is_that_of_the_inputs_within_their_rounding() {
        // Pulses not much larger than noise and motion, so that fractions at both ends of the gap depend on each other.
        let pulses = Configuration::new("pulses at rest", |own| {
            own.inputs.motion = Motion::of_tone(Tone::of_rate(20.0, 20.0));
            own.inputs.tick_noise = TickNoise::Std(0.15);
            own.inputs.readout_lsb = 1.0;
        });
        let (mut compared, mut largest) = (0, 0.0_f64);
        let exact = [0.0, 100.0, 200.0, 333.0].map(|rate| {
            Configuration::new("pulses without noise", |own| {
                own.inputs.motion = Motion { rate, ..Motion::default() };
                own.inputs.tick_noise = TickNoise::Std(0.0);
                own.inputs.readout_lsb = 1.0;
            })
        });
        // No motion, and whole turns in each tick.
        let still = [(0.0, 20.0, 3), (200.0, 200.0, 3), (200.0, 200.0, 10)].map(|(rate, frequency_hz, n)| {
            Configuration::new("pulses of ticks without motion", |own| {
                own.inputs.motion = Motion::of_tone(Tone::of_rate(rate, frequency_hz));
                own.inputs.tick_noise = TickNoise::Std(0.0);
                own.inputs.readout_lsb = 1.0;
                own.inputs.gap_ticks = n;
            })
        });
        // Whole turns in the gap, nearly whole ones, and an amplitude that makes the motion normal.
        let nearly = [(20.0, false), (20.0, true), (20.0 + 1e-7, false), (20.0 + 1e-7, true)].map(
            |(frequency_hz, rayleigh)| {
                Configuration::new("pulses of nearly whole turns", |own| {
                    let mut tone = Tone::of_rate(20.0, frequency_hz);
                    if rayleigh {
                        tone.amplitude.value = Value::Rayleigh(20.0);
                    }
                    own.inputs.motion = Motion::of_tone(tone);
                    own.inputs.tick_noise = TickNoise::Std(0.0);
                    own.inputs.readout_lsb = 1.0;
                    own.inputs.gap_ticks = 10;
                })
            },
        );
        for configuration in &still {
            let lowered = configuration.lowered();
            assert!(lowered.fillers.iter().flatten().all(|estimate| estimate.theory.rms.unwrap() < 1e-6));
        }
        let slow = [1e-9, 1e-6, 1e-3].map(|frequency_hz| {
            Configuration::new("slow", |own| {
                own.inputs.motion = Motion::of_tone(Tone::of_rate(12000.0, frequency_hz));
                own.inputs.tick_noise = TickNoise::Std(0.001);
            })
        });
        for configuration in
            configurations().into_iter().chain([pulses]).chain(exact).chain(still).chain(nearly).chain(slow)
        {
            let point = configuration.point();
            let lowered = configuration.lowered();
            let physical = PhysicalTheory::new(&point.inputs, point.sides());
            for estimate in lowered.fillers.iter().flatten() {
                let found = physical.rms(&estimate.rows, estimate.error);
                let words = estimate.theory.rms;
                let name = configuration.name;
                assert_eq!(found.is_some(), words.is_some(), "{name}, {:?}", estimate.error);
                let Some((found, words)) = found.zip(words) else { continue };
                let most = estimate.representation;
                assert!((found - words).abs() <= most, "{name}: {found}, {words}, rounding {most}");
                compared += 1;
                largest = largest.max((found / words - 1.0).abs());
            }
        }
        assert!(compared > 100 && largest > 1e-9, "{compared}, {largest:e}");
    }

    /// The rms that weights leave of motion in a band and of noise: the squared response, integrated by
    /// Simpson's rule.
    fn integrated(inputs: &Inputs, band: Band, rms: f64, rows: &Rows) -> f64 {
        let (weights, n) = (rows.values().pop().unwrap(), inputs.gap_ticks as i32);
        let steps = 4000;
        let square = |step: i32| {
            let nu = band.low_hz + (band.high_hz - band.low_hz) * f64::from(step) / f64::from(steps);
            let turn = TAU * nu * inputs.tick_s;
            let part = |of: fn(f64) -> f64| {
                let at = |tick: i32| of(turn * (f64::from(tick) - 0.5 * f64::from(n + 1)));
                let filled: f64 = rows.ticks.iter().zip(&weights).map(|(&tick, w)| w * at(tick)).sum();
                filled - (1..=n).map(at).sum::<f64>()
            };
            let tick = rms * inputs.tick_s * libm::sin(0.5 * turn) / (0.5 * turn);
            tick * tick * (part(libm::cos) * part(libm::cos) + part(libm::sin) * part(libm::sin))
        };
        let weight = |step: i32| match step {
            _ if step == 0 || step == steps => 1.0,
            _ if step % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let sum: f64 = (0..=steps).map(|step| weight(step) * square(step)).sum();
        let motion = sum / (3.0 * f64::from(steps));
        let sigma = inputs.sigma_arcsec();
        libm::sqrt(motion + weights.iter().map(|w| w * w * sigma * sigma).sum::<f64>())
    }

    fn in_a_band(band: Band, rms: f64, change: impl FnOnce(&mut Configuration)) -> Configuration {
        Configuration::new("motion in a band", |own| {
            let gaussian = Some(Gaussian::Band { rms, band });
            own.inputs.motion = Motion { gaussian, ..Motion::default() };
            own.fillers = vec![minimum_variance()];
            own.errors = vec![Error::Residual];
            change(own);
        })
    }

    /// The words and the inputs of the only estimate of a point, and the integral over the spectrum.
    fn three(configuration: &Configuration, band: Band, rms: f64) -> [f64; 3] {
        let (point, lowered) = (configuration.point(), configuration.lowered());
        let estimate = &lowered.fillers[0][0];
        let physical = PhysicalTheory::new(&point.inputs, point.sides());
        let inputs = physical.rms(&estimate.rows, estimate.error).unwrap();
        [estimate.theory.rms.unwrap(), inputs, integrated(&point.inputs, band, rms, &estimate.rows)]
    }

    /// Their rows were wrong by up to 440 times while z did not see it.
    #[test]
    fn long_fillers_of_gaussian_motion_leave_what_the_spectrum_says() {
        let (band, rms) = (Band { low_hz: 30.0, high_hz: 80.0 }, 7200.0);
        for (before, after, expected) in
            [(16, 8, 0.03879), (16, 16, 0.03204), (24, 8, 0.03615), (32, 3, 0.04868), (32, 8, 0.03484)]
        {
            let configuration = in_a_band(band, rms, |own| {
                own.inputs.tick_s = 0.002;
                own.inputs.tick_noise = TickNoise::AngleRandomWalk(0.15);
                own.fit_ticks = (1 - before..=0).chain(4..=3 + after).collect();
            });
            for found in three(&configuration, band, rms) {
                assert!((found / expected - 1.0).abs() < 5e-4, "{before} + {after}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn random_bands_ticks_and_noise_give_the_integral_over_the_spectrum() {
        let mut rng = StdRng::seed_from_u64(40);
        for case in 0..100 {
            let tick_s = libm::exp(rng.random_range(libm::log(0.001)..libm::log(0.01)));
            let low_hz = 0.5 / tick_s * libm::exp(rng.random_range(-6.0..-0.1));
            let width = libm::exp(rng.random_range(-7.0..0.0));
            let band = Band { low_hz, high_hz: low_hz + width * (0.5 / tick_s - low_hz) };
            let rms = libm::exp(rng.random_range(6.0..10.0));
            let configuration = in_a_band(band, rms, |own| {
                let n = rng.random_range(1..=10);
                own.inputs.tick_s = tick_s;
                own.inputs.gap_ticks = n;
                own.inputs.tick_noise =
                    TickNoise::Std(rms * tick_s * libm::exp(rng.random_range(-11.0..-2.0)));
                let first = n as i32 + 1;
                let after = first..first + rng.random_range(1..=48);
                own.fit_ticks = (1 - rng.random_range(1..=48)..=0).chain(after).collect();
            });
            let [words, inputs, integral] = three(&configuration, band, rms);
            assert!((inputs / integral - 1.0).abs() < 1e-5, "case {case}: {inputs}, integral {integral}");
            assert!((words / inputs - 1.0).abs() < 3e-3, "case {case}: {words}, inputs {inputs}");
        }
    }
}
