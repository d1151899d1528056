//! A readout in whole pulses: the fractions of a pulse that it leaves at two angles, and the Allan variance of its error.
//!
//! The readout is q⌊(θ + u)/q⌋ of the total angle, whose start u is uniform over one pulse q.
//! The error of such a readout is uniform over one pulse at every sample, so it is uncorrelated with the angle, and its
//! variance is q²/12, that of the quantization noise Q = q/√12. It is *not* white: it stays constant while the angle
//! moves by much less than a pulse, and it is a beat where the pulses come at an even rate. The covariance of two
//! errors whose angles differ by Δ is q²·B(Δ/q)/2 with the Bernoulli polynomial B = d² − d + 1/6 of the fractional part
//! d, a series of cosines; its mean over Δ follows from the characteristic function of Δ.

use core::f64::consts::{PI, SQRT_2};
use core::hash::Hash;
use std::collections::HashMap;
use std::rc::Rc;

use crate::allan::{Difference, Part, Process, sine_of_turns, terms};

/// Covariance of the fractions at two angles whose distance is known but for a normal part, relative to their variance
/// q²/12. Lengths are in pulses.
///
/// Without the normal part it is 1 − 6y + 6y² at the distance y to the nearest whole pulse. Its mean over the normal
/// part is tabulated where that rounds the kink at 0, and interpolated linearly, which is right to 1e-4 of the distance
/// from 1.
#[derive(Debug)]
pub struct Covariance {
    deviation: f64,
    step: f64,
    values: Vec<f64>,
}

const STEPS: usize = 512;

/// A standard deviation below which the kinks at neighbouring whole pulses are not felt.
const SHARP: f64 = 0.05;

/// A standard deviation that stands for none.
const NONE: f64 = 1e-9;

/// A standard deviation beyond which no covariance of more than 1e-8 remains.
const MAX_SIGMA: f64 = 1.0;

impl Covariance {
    /// The covariance with this standard deviation of the normal part; `None` where it vanishes.
    pub fn new(deviation: f64) -> Option<Covariance> {
        let deviation = deviation.max(NONE);
        // A little more than half a pulse, so that every distance lies within the table.
        let reach = if deviation < SHARP { 8.0 * deviation } else { 0.501 };
        let step = reach / STEPS as f64;
        let value = |place: usize| covariance(step * place as f64, deviation);
        (deviation < MAX_SIGMA).then(|| Covariance {
            deviation,
            step,
            values: (0..=STEPS).map(value).collect(),
        })
    }

    /// The covariance at a distance.
    pub fn at(&self, distance: f64) -> f64 {
        let y = (distance - libm::floor(distance + 0.5)).abs();
        let place = y / self.step;
        let from = place as usize;
        if from < STEPS {
            let [low, high] = [self.values[from], self.values[from + 1]];
            low + (place - from as f64) * (high - low)
        } else {
            1.0 - 6.0 * y + 6.0 * (y * y + self.deviation * self.deviation)
        }
    }
}

/// The covariance of the fractions at two angles at this distance but for a normal part, as [`Covariance`] tabulates it, to
/// rounding.
pub fn covariance(distance: f64, deviation: f64) -> f64 {
    let y = (distance - libm::floor(distance + 0.5)).abs();
    if deviation < SHARP { rounded(y, deviation) } else { series(y, deviation) }
}

/// Pairs of boundaries whose fractions have the same covariance in the mean over the motion. `places` has the first few, over
/// which that mean is taken.
struct Pairs {
    places: Vec<[usize; 2]>,
    /// The sum over all of them of twice the product of their factors.
    factor: f64,
    /// The covariance at a given angle between them; absent where it vanishes.
    covariance: Option<Rc<Covariance>>,
}

/// Most pairs over which a mean is taken for all that are equally far apart. One alone would leave up to 2e-4 of the variance
/// to the lattice of drawn values, and each more costs time.
const MAX_PAIRS: usize = 4;

/// Variance of the sum of the fractions of a pulse at some boundaries with these factors, relative to q²/12: the mean over
/// `draws` of the motion.
///
/// `angles` writes the angles at the boundaries for a draw, and `deviation` is that of the normal part of the angle between two
/// boundaries, in pulses. Pairs of the same `class` have the same mean.
pub fn mean_variance<C: Eq + Hash>(
    factors: &[f64],
    deviation: impl Fn(usize, usize) -> f64,
    class: impl Fn(usize, usize) -> Option<C>,
    draws: usize,
    angles: impl Fn(usize, &mut [f64]),
) -> f64 {
    // Most pairs have one of few deviations.
    let mut covariances: HashMap<u64, Option<Rc<Covariance>>> = HashMap::new();
    let (mut pairs, mut places) = (Vec::<Pairs>::new(), HashMap::new());
    for (i, g) in factors.iter().enumerate() {
        for (j, h) in factors.iter().enumerate().skip(i + 1) {
            let next = pairs.len();
            let place = class(i, j).map_or(next, |class| *places.entry(class).or_insert(next));
            if place == next {
                let deviation = deviation(i, j);
                let compute = || Covariance::new(deviation).map(Rc::new);
                let covariance = covariances.entry(deviation.to_bits()).or_insert_with(compute).clone();
                pairs.push(Pairs { places: vec![], factor: 0.0, covariance });
            }
            let pairs = &mut pairs[place];
            pairs.factor += 2.0 * g * h;
            if pairs.places.len() < MAX_PAIRS {
                pairs.places.push([i, j]);
            }
        }
    }
    let (mut at, mut sum) = (vec![0.0; factors.len()], 0.0);
    for draw in 0..draws {
        angles(draw, &mut at);
        for Pairs { places, factor, covariance } in &pairs {
            if let Some(covariance) = covariance {
                let all: f64 = places.iter().map(|&[i, j]| covariance.at(at[j] - at[i])).sum();
                sum += factor * all / places.len() as f64;
            }
        }
    }
    factors.iter().map(|g| g * g).sum::<f64>() + sum / draws as f64
}

/// The mean of 1 − 6|y + sz| + 6(y + sz)² over a normal z.
fn rounded(y: f64, s: f64) -> f64 {
    let z = if s > 0.0 { y / s } else { f64::INFINITY };
    let magnitude = y * libm::erf(z / SQRT_2) + s * libm::sqrt(2.0 / PI) * libm::exp(-0.5 * z * z);
    1.0 - 6.0 * magnitude + 6.0 * (y * y + s * s)
}

/// Returns the periodic mean as a Fourier series; omitted terms are below 1e-15 from [`SHARP`] on.
fn series(y: f64, s: f64) -> f64 {
    let term = |m: f64| libm::cos(2.0 * PI * m * y) * libm::exp(-2.0 * (PI * m * s) * (PI * m * s)) / (m * m);
    6.0 / (PI * PI) * (1..=27).map(f64::from).map(term).sum::<f64>()
}

/// Variance, in pulses², of the angle between two samples from which on the series is summed, with fewer than 4e4
/// terms.
const MIN_VARIANCE: f64 = 1e-9;
/// Exponent above which a term is below rounding.
const NEGLIGIBLE: f64 = 40.0;

/// Mean square of a difference of the readout's error at `m`, ″², which is added to that of the angle.
///
/// `lsb` is q, ″; `mean_rate` is the constant rate of the gyro, ″/s, which determines the beat with the pulses. The
/// result is exact for quantization noise before the readout, angle random walk, Markov noise and sines. It is `None`
/// for any other part, whose increments are not those of one Gaussian (the octave holds) or change along the record,
/// and for a sine with less noise than √1e-9 pulses. Then take the white 6q²/12 (20q²/12), with [`white_error`] as its
/// bound.
pub fn mean_square(
    lsb: f64,
    mean_rate: f64,
    process: &Process,
    difference: Difference,
    m: u64,
) -> Option<f64> {
    let pairs = pairs(difference);
    let mut sum = difference.coefficients().iter().map(|c| c * c).sum::<f64>() / 12.0;
    for (apart, weight) in (1..).zip(pairs) {
        let increment = Increment::new(process, apart * m, lsb)?;
        let turns = mean_rate * process.sample_s * (apart * m) as f64 / lsb;
        sum += weight * increment.covariance(turns)?;
    }
    Some(lsb * lsb * sum)
}

/// Bound of the deviation of [`mean_square`] from that of white noise of Q = q/√12, ″², whatever other parts the angle
/// has.
///
/// It follows from the angle random walk, the Markov noise and the white noise before the readout. Other parts are
/// independent of them and can only reduce the correlation of the errors.
pub fn white_error(lsb: f64, process: &Process, difference: Difference, m: u64) -> f64 {
    let bound = |apart: u64| {
        let variance = noise_variance(process, apart * m) / (lsb * lsb);
        // Σ e^{−2π²j²v}/2π²j² is at most its first factor times 1/12.
        libm::exp(-2.0 * PI * PI * variance) / 12.0
    };
    lsb * lsb * (1..).zip(pairs(difference)).map(|(apart, weight)| weight.abs() * bound(apart)).sum::<f64>()
}

/// Twice the sums of the products of coefficients m, 2m, … apart.
fn pairs(difference: Difference) -> Vec<f64> {
    let c = difference.coefficients();
    let at = |apart: usize| 2.0 * c.iter().zip(&c[apart..]).map(|(a, b)| a * b).sum::<f64>();
    (1..c.len()).map(at).collect()
}

/// Variance of the Gaussian part of the angle over n samples, ″².
pub fn noise_variance(process: &Process, n: u64) -> f64 {
    let one = |part: &Part| match part.increment(process.sample_s, n) {
        terms::Increment::Normal(variance) => variance,
        _ => 0.0,
    };
    process.parts.iter().map(one).sum()
}

/// The angle over n samples without its mean, in pulses.
struct Increment {
    variance: f64,
    sines: Vec<f64>,
}

impl Increment {
    fn new(process: &Process, n: u64, lsb: f64) -> Option<Increment> {
        let mut sines = Vec::new();
        for part in &process.parts {
            match part.increment(process.sample_s, n) {
                terms::Increment::Sine(peak) => sines.push(peak / lsb),
                terms::Increment::Normal(_) => (),
                terms::Increment::Other => return None,
            }
        }
        Some(Increment { variance: noise_variance(process, n) / (lsb * lsb), sines })
    }

    /// Mean of B/2 for a mean of `turns` pulses: Σ cos(2πj·turns)·φ(2πj)/(2π²j²).
    fn covariance(&self, turns: f64) -> Option<f64> {
        if self.variance == 0.0 && self.sines.is_empty() {
            let d = turns - libm::floor(turns);
            return Some(0.5 * (d * d - d + 1.0 / 6.0));
        }
        if self.variance < MIN_VARIANCE {
            return None;
        }
        let exponent = |j: f64| 2.0 * PI * PI * j * j * self.variance;
        let terms = (1..).map(f64::from).take_while(|&j| exponent(j) < NEGLIGIBLE);
        let sum = terms.map(|j| {
            let beat = sine_of_turns(0.25 + j * (turns - libm::round(turns)));
            let sines: f64 = self.sines.iter().map(|peak| libm::j0(2.0 * PI * j * peak)).product();
            beat * sines * libm::exp(-exponent(j)) / (2.0 * PI * PI * j * j)
        });
        Some(sum.sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral over the fractions themselves: the second is the first plus the distance, less whole pulses.
    #[test]
    fn the_covariance_is_that_of_fractions_counted_over_a_pulse_and_over_the_noise() {
        for s in [0.0, 1e-3, 0.02, 0.049, 0.051, 0.2, 0.7] {
            let covariance = Covariance::new(s).unwrap();
            for distance in [0.0, 1e-4, 0.003, 0.1, 0.25, 0.4999, 0.7, -3.02, 12.5] {
                let (mut sum, mut whole) = (0.0, 0.0);
                for i in -3000..=3000 {
                    let z = 0.0025 * f64::from(i);
                    let weight = libm::exp(-0.5 * z * z);
                    let mean = 12.0 * counted(distance + s * z);
                    whole += weight;
                    sum += weight * mean;
                }
                let (found, expected) = (covariance.at(distance), sum / whole);
                assert!((found - expected).abs() < 5e-5, "{s}, {distance}: {found}, not {expected}");
            }
        }
    }

    /// Covariance of u and the fraction of u + d over a uniform u, which is linear on either side of one jump.
    fn counted(d: f64) -> f64 {
        let d = d - libm::floor(d);
        // ∫ (u − ½)(u + d − ½) du up to the jump at 1 − d, and with one less beyond it.
        let part = |from: f64, to: f64, shift: f64| {
            let third = |u: f64| (u - 0.5) * (u - 0.5) * (u - 0.5) / 3.0;
            let square = |u: f64| (u - 0.5) * (u - 0.5) / 2.0;
            third(to) - third(from) + shift * (square(to) - square(from))
        };
        part(0.0, 1.0 - d, d) + part(1.0 - d, 1.0, d - 1.0)
    }

    #[test]
    fn series_and_rounded_kink_are_the_same_where_they_meet() {
        for y in [0.0, 0.05, 0.2, 0.4, 0.5] {
            let [a, b] = [rounded(y, SHARP), series(y, SHARP)];
            assert!((a - b).abs() < 1e-13, "{y}: {a} and {b}");
        }
    }

    fn process(parts: Vec<Part>) -> Process {
        Process { sample_s: 1.0, parts }
    }

    #[test]
    fn without_noise_it_is_the_mean_over_the_start() {
        let (q, rate) = (0.38, 15.041);
        for m in [1, 2, 7, 50] {
            for difference in [Difference::Second, Difference::Third] {
                let starts = 100_000;
                let error = |start: f64, k: u64| {
                    let angle = rate * (k * m) as f64 + start;
                    q * libm::floor(angle / q) - angle
                };
                let square = |i: u32| {
                    let start = q * (f64::from(i) + 0.5) / f64::from(starts);
                    let terms = difference.coefficients().iter().enumerate();
                    let value: f64 = terms.map(|(k, c)| c * error(start, k as u64)).sum();
                    value * value
                };
                let mean = (0..starts).map(square).sum::<f64>() / f64::from(starts);
                let found = mean_square(q, rate, &process(vec![]), difference, m).unwrap();
                // With 1e5 starts, a jump is off by up to half a start.
                assert!((found - mean).abs() < 1e-4 * q * q, "{difference:?}, m = {m}: {found}, not {mean}");
            }
        }
    }

    #[test]
    fn a_frozen_readout_has_no_error_and_a_lively_one_is_white() {
        let (q, white) = (1.0, 6.0 / 12.0);
        let still = process(vec![Part::angle_random_walk(1e-4)]);
        let found = mean_square(q, 0.0, &still, Difference::Second, 1).unwrap();
        // Σ|c·c|·E|Δ|: errors differ only where a pulse comes, which has the probability E|Δ|/q.
        assert!(found > 0.0 && found < 5e-4, "{found}");
        assert!(white_error(q, &still, Difference::Second, 1) > white - found);
        let lively = process(vec![Part::angle_random_walk(2.0)]);
        let found = mean_square(q, 0.3, &lively, Difference::Second, 1).unwrap();
        assert!((found - white).abs() < 1e-15, "{found}");
        assert!(white_error(q, &lively, Difference::Second, 1) < 1e-15);
        let found = mean_square(q, 0.3, &lively, Difference::Third, 1).unwrap();
        assert!((found - 20.0 / 12.0).abs() < 1e-15, "{found}");
    }

    #[test]
    fn what_has_no_closed_form_is_said() {
        let flicker = process(vec![Part::angle_random_walk(1.0), Part::bias_instability(1.0, 24)]);
        assert_eq!(mean_square(1.0, 0.0, &flicker, Difference::Second, 1), None);
        let sine = process(vec![Part::sine(1.0, 0.1)]);
        assert_eq!(mean_square(1.0, 0.0, &sine, Difference::Second, 1), None);
    }
}
