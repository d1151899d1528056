//! The Allan variance of each of three units that were sampled together: the three-cornered hat.
//!
//! What the units measure in common cancels in their differences. The Groslambert covariance of a − b and a − c, the mean product of
//! their second differences, is that of a alone if the noises of the units are independent. It equals the three-cornered hat
//! (σ²_ab + σ²_ac − σ²_bc)/2 here, because the three differences are of the same samples.
//!
//! F. Vernotte, É. Lantz, "Three-cornered hat and Groslambert covariance: a first attempt to assess the uncertainty domains", IEEE Trans.
//! UFFC 66 (2019). Intervals: a product of Gaussian numbers is a difference of two independent squares; those of both χ² are combined by
//! G. Y. Zou, A. Donner, "Construction of confidence limits about effect measures", Stat. Med. 27 (2008).

use crate::allan::edf::edf;
use crate::allan::noise::noise;
use crate::allan::{Angles, Deviation, Trend, distributions};

/// The variances of three units at one averaging time.
#[derive(Debug, Clone, PartialEq)]
pub struct Hat {
    /// Averaging factor m, τ in samples.
    pub m: usize,
    /// Averaging time τ, s.
    pub tau_s: f64,
    /// Number of differences averaged.
    pub terms: u64,
    /// The variances of the units, in the order of the records.
    pub units: [UnitVariance; 3],
}

/// The Allan variance of one of three units, in the square of the unit of the rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitVariance {
    /// The estimate. It may be negative, where the unit is quieter than the scatter of the others, or noises are not independent.
    pub variance: f64,
    /// Equivalent degrees of freedom of the differences from the other units, the fewer of both.
    pub edf: Option<f64>,
    /// Lower and upper end of the interval of the variance. Its lower end is negative where nothing of the unit is resolved; where both
    /// are, noises are not independent.
    pub interval: Option<(f64, f64)>,
}

impl UnitVariance {
    /// The deviation; `None` where the variance is negative.
    pub fn deviation(self) -> Option<f64> {
        (self.variance >= 0.0).then(|| libm::sqrt(self.variance))
    }

    /// The interval of the deviation, from 0 where that of the variance begins below; `None` where all of that is negative.
    pub fn deviation_interval(self) -> Option<(f64, f64)> {
        let (lower, upper) = self.interval.filter(|ends| ends.1 > 0.0)?;
        Some((libm::sqrt(lower.max(0.0)), libm::sqrt(upper)))
    }
}

/// The overlapping Allan variances of three units from `records` of their increments, each times `scale`, that were sampled together,
/// with intervals of this `confidence` p, 0 < p < 1. A sample that one record misses is left out of all. Intervals suppose the noise
/// identified at each τ: of
/// simulated records 91 to 95 % contain the truth with a probability of 0.95, and 87 % where a record has only 8 τ.
///
/// `None` where the records have different lengths.
///
/// ```
/// # use sagnac_records::allan::hat::hat;
/// let noise = |seed: usize| (0..4096).map(move |i| ((i + seed) * (i + 3 * seed) * 7919 % 1009) as f64).collect();
/// let records: [Vec<f64>; 3] = [noise(1), noise(77), noise(353)];
/// let hats = hat([&records[0], &records[1], &records[2]], 1.0, 1.0, &[1, 2, 4], 0.95).unwrap();
/// assert_eq!((hats[2].tau_s, hats[2].terms), (4.0, 4089));
/// ```
pub fn hat(
    records: [&[f64]; 3],
    scale: f64,
    step_s: f64,
    factors: &[usize],
    confidence: f64,
) -> Option<Vec<Hat>> {
    let [a, b, c] = records;
    if a.len() != b.len() || a.len() != c.len() {
        return None;
    }
    let difference = |first: usize, second: usize| {
        let of = |i: usize| {
            let is_known = records.iter().all(|record| record[i].is_finite());
            if is_known { records[first][i] - records[second][i] } else { f64::NAN }
        };
        let increments: Vec<f64> = (0..a.len()).map(of).collect();
        Angles::from_increments(&increments, scale, step_s, Trend::None)
    };
    // a − b, b − c and c − a; the differences of a unit from both others are its own and the one before, with opposite signs.
    let differences = [difference(0, 1), difference(1, 2), difference(2, 0)];
    let of_factor = |&m: &usize| {
        let edf = differences.each_ref().map(|angles| {
            let alpha = noise(angles, Deviation::Oadev, m)?.alpha;
            edf(Deviation::Oadev, alpha, angles.len(), m)
        });
        let tau_s = m as f64 * step_s;
        let mut terms = 0;
        let units = [0, 1, 2].map(|unit| {
            let before = (unit + 2) % 3;
            let [own, other] = [unit, before].map(|i| &differences[i]);
            let moments = Moments::new(own, other, m, tau_s);
            terms = moments.terms;
            let all = Deviation::Oadev.terms(own.len(), m).max(1);
            let edf = edf[unit].zip(edf[before]).map(|(a, b)| a.min(b) * moments.terms as f64 / all as f64);
            let interval = edf.and_then(|edf| moments.interval(edf, confidence));
            UnitVariance { variance: -moments.product, edf, interval }
        });
        Hat { m, tau_s, terms, units }
    };
    Some(factors.iter().map(of_factor).filter(|hat| hat.terms > 0).collect())
}

/// Mean squares and product of the second differences of two records, as variances.
struct Moments {
    terms: u64,
    squares: [f64; 2],
    product: f64,
}

impl Moments {
    fn new(own: &Angles, other: &Angles, m: usize, tau_s: f64) -> Moments {
        let mut moments = Moments { terms: 0, squares: [0.0; 2], product: 0.0 };
        let second = |x: &[f64], k: usize| x[k + 2 * m] - 2.0 * x[k + m] + x[k];
        for k in own.runs().iter().flat_map(|run| run.start..run.end.saturating_sub(2 * m)) {
            let [a, b] = [own, other].map(|angles| second(angles.values(), k));
            moments.terms += 1;
            moments.squares[0] += a * a;
            moments.squares[1] += b * b;
            moments.product += a * b;
        }
        let divisor = 2.0 * moments.terms as f64 * tau_s * tau_s;
        moments.squares.iter_mut().for_each(|square| *square /= divisor);
        moments.product /= divisor;
        moments
    }

    /// The interval of the negative product with so many degrees of freedom.
    fn interval(&self, edf: f64, confidence: f64) -> Option<(f64, f64)> {
        // With both scaled to the same variance v, −a b is (a − b)²/4 − (a + b)²/4, whose parts are independent.
        let v = libm::sqrt(self.squares[0] * self.squares[1]);
        let parts = [0.5 * (v - self.product), 0.5 * (v + self.product)].map(|part| part.max(0.0));
        let tail = 0.5 * (1.0 - confidence);
        let low = edf / distributions::chi_squared_quantile(1.0 - tail, edf)?;
        let high = edf / distributions::chi_squared_quantile(tail, edf)?;
        let distance = |down: f64, up: f64| libm::sqrt(down * down + up * up);
        let lower = -self.product - distance(parts[0] * (1.0 - low), parts[1] * (high - 1.0));
        let upper = -self.product + distance(parts[0] * (high - 1.0), parts[1] * (1.0 - low));
        (lower.is_finite() && upper.is_finite()).then_some((lower, upper))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::curve;

    /// Nearly Gaussian numbers of variance 1.
    fn white() -> impl Iterator<Item = f64> {
        let numbers = std::iter::successors(Some(1_234_567_890_u64), |n| Some(16_807 * n % 2_147_483_647));
        let mut uniform = numbers.map(|n| n as f64 / 2_147_483_647.0 - 0.5);
        std::iter::from_fn(move || Some(uniform.by_ref().take(12).sum()))
    }

    /// Records of units that turn together.
    fn units(noise: &mut impl Iterator<Item = f64>, count: usize, sizes: [f64; 3]) -> [Vec<f64>; 3] {
        let turned = |i: usize| 30.0 * libm::sin(0.01 * i as f64);
        sizes.map(|size| noise.take(count).enumerate().map(|(i, x)| size * x + turned(i)).collect())
    }

    #[test]
    fn the_variances_are_those_of_the_three_cornered_hat() {
        let records = units(&mut white(), 2000, [1.0, 2.0, 0.5]);
        let difference = |i: usize, j: usize| -> Vec<f64> {
            records[i].iter().zip(&records[j]).map(|(a, b)| a - b).collect()
        };
        let hats = hat(records.each_ref().map(Vec::as_slice), 0.1, 0.1, &[1, 10, 100], 0.95).unwrap();
        for found in hats {
            let square = |i: usize, j: usize| {
                let angles = Angles::from_increments(&difference(i, j), 0.1, 0.1, Trend::None);
                let value = curve(&angles, Deviation::Oadev, &[found.m], 0.95)[0].value.unwrap();
                value * value
            };
            let [ab, bc, ca] = [square(0, 1), square(1, 2), square(2, 0)];
            for (unit, expected) in found.units.iter().zip([ab + ca - bc, ab + bc - ca, ca + bc - ab]) {
                assert!((unit.variance - 0.5 * expected).abs() < 1e-12 * ab, "{unit:?}, not {expected}");
            }
        }
    }

    /// 95 % of 300 records are 285, and 4 standard errors are 15. With 8 τ in a record the noise is often identified wrongly.
    #[test]
    fn intervals_contain_the_variances_of_units_as_often_as_they_say() {
        let sizes = [1.0, 1.0, 3.0];
        let mut noise = white();
        for (m, fewest) in [(1, 270), (16, 270), (64, 250)] {
            let mut hits = [0; 3];
            for _ in 0..300 {
                let records = units(&mut noise, 512, sizes);
                let records = records.each_ref().map(Vec::as_slice);
                let found = &hat(records, 1.0, 1.0, &[m], 0.95).unwrap()[0];
                for ((unit, size), hits) in found.units.iter().zip(sizes).zip(&mut hits) {
                    let (lower, upper) = unit.interval.unwrap();
                    let expected = size * size / m as f64;
                    *hits += i32::from(lower < expected && expected < upper);
                }
            }
            assert!(hits.iter().all(|hits| *hits >= fewest), "m = {m}: {hits:?}");
        }
    }

    #[test]
    fn a_sample_that_one_record_misses_is_left_out_of_all() {
        let mut records = units(&mut white(), 1000, [1.0; 3]);
        records[1][400] = f64::NAN;
        let found = &hat(records.each_ref().map(Vec::as_slice), 1.0, 1.0, &[2], 0.95).unwrap()[0];
        assert_eq!(found.terms, 997 - 4);
        assert_eq!(hat([&[1.0], &[1.0], &[]], 1.0, 1.0, &[1], 0.95), None);
    }
}
