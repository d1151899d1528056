//! The fractions of a pulse at two angles, as a readout in whole pulses leaves them.

use core::f64::consts::{PI, SQRT_2};
use core::hash::Hash;
use std::collections::HashMap;
use std::rc::Rc;

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
}
