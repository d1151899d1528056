//! The minimum-variance gap filler: the best linear unbiased estimate of the gap for a known motion and noise.
//!
//! Its weights solve `[K + R, 1; 1ᵀ, 0] [w; λ] = [k; n]`, where K is the covariance of the motion between the ticks that
//! it reads, k that of each tick with the sum over the gap, and R that of the noise. The constraint Σw = n keeps a
//! constant rate exact. K of a narrow band is singular in 53 bits, so the same weights are computed as those of least
//! squares from the rows of the ticks, which keeps twice the digits. Everything is computed in a fixed order with `libm`,
//! so the weights are the same on every machine.
//!
//! ```
//! use sagnac_theory::lines::of_ticks;
//! use sagnac_theory::minimum_variance::{Band, TickRows, minimum_variance_weights};
//! use sagnac_theory::quadrature::Rule;
//!
//! // 12000 ″/s at 18 to 22 Hz, σ = 1.6/3 ″ a tick, n = 3, the default ticks.
//! let (ticks, sigma) = ([-1, 0, 4, 5], 1.6 / 3.0);
//! let lines = Band { low_hz: 18.0, high_hz: 22.0 }.lines(7.0 * 0.005, Rule::Sparse);
//! let motion = TickRows::of_lines(&of_ticks(&lines, 0.005), 3, 2).scaled(12000.0 / 2_f64.sqrt());
//! let weights = minimum_variance_weights(&ticks, 3, &motion, &[sigma * sigma]).unwrap();
//! assert!((weights.iter().sum::<f64>() - 3.0).abs() < 1e-12);
//! let noise: f64 = weights.iter().map(|w| w * w * sigma * sigma).sum();
//! assert!(((motion.error_variance(&ticks, &weights, 3) + noise).sqrt() - 3.79).abs() < 0.005);
//! ```
//!
//! # Rows
//!
//! [`TickRows`] are the ticks of a random motion as rows of numbers whose products are the covariances of the ticks: the angle of a
//! tick is its row times independent numbers of variance 1.
//!
//! The covariance matrix of many ticks of a narrow band is singular in 53 bits, and a factor computed from it is wrong by
//! orders of magnitude in the differences that matter: the errors of fillers. So that of a spectrum is never formed. Its
//! rows consist of its lines, and orthogonal transformations, which lose nothing, shorten them to a triangle.

use crate::cholesky::{definite, solve_transposed, whiten};
use crate::gap::tick_phase;
use crate::lines::{Line, TickLine};
use crate::quadrature::Rule;

/// A vibration of random phase whose frequency is uniformly distributed over a band; for a single frequency both ends
/// are equal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Lower end, Hz.
    pub low_hz: f64,
    /// Upper end, Hz.
    pub high_hz: f64,
}

impl Band {
    /// A power of 1, spread over the band, as lines with which covariances are right to rounding up to a distance of
    /// `longest_s`.
    pub fn lines(&self, longest_s: f64, rule: Rule) -> Vec<Line> {
        let Band { low_hz, high_hz } = *self;
        let width = high_hz - low_hz;
        if width == 0.0 {
            return vec![Line { frequency_hz: low_hz, power: 1.0 }];
        }
        let mut lines = Vec::new();
        rule.integrate(low_hz, high_hz, width * longest_s, |frequency_hz, weight| {
            lines.push(Line { frequency_hz, power: weight / width });
        });
        lines
    }
}

/// Smallest part of a tick, relative to its rms, that is not determined by other ticks; anything below is rounding.
const MIN_PART: f64 = 1e-12;

/// Weights on `ticks` with the least error over the gap 1 … n, for this motion and for `noise` on the readings, given as
/// its covariance by lag: `[σ²]` for independent noise. Lags that are not given have no noise.
///
/// `None` where the ticks determine each other to working precision, because the noise is too small relative to the
/// motion to determine the weights.
pub fn minimum_variance_weights(
    ticks: &[i32],
    gap_ticks: u32,
    motion: &TickRows,
    noise: &[f64],
) -> Option<Vec<f64>> {
    let count = ticks.len();
    let gap = motion.gap(gap_ticks);
    let width = ticks.iter().map(|&tick| motion.tick(tick).len()).fold(gap.len(), usize::max);
    let own = if noise.iter().any(|x| *x != 0.0) {
        let between = |i: usize, j: usize| noise.get(ticks[i].abs_diff(ticks[j]) as usize).copied();
        definite(count, |i, j| between(i, j).unwrap_or(0.0))?
    } else {
        vec![]
    };
    // The row of a reading: that of the motion, then that of its noise. The last row is that of the gap.
    let mut rows = Rows::with_capacity(count + 1, width + count);
    for (k, &tick) in ticks.iter().enumerate() {
        rows.push(motion.tick(tick), width, own.get(k).map_or(&[], |own| own));
    }
    rows.push(&gap, width, &[]);
    let triangle = triangular(&rows);
    let is_determined =
        |(k, row): (usize, &[f64])| row.len() == k + 1 && row[k] > MIN_PART * libm::sqrt(dot(row, row));
    if !triangle.iter().take(count).enumerate().all(is_determined) {
        return None;
    }
    let factor: Vec<&[f64]> = triangle.iter().take(count).collect();
    let best = solve_transposed(&factor, triangle.row(count)[..count].to_vec());
    let ones = solve_transposed(&factor, whiten(&factor, vec![1.0; count]));
    let short = f64::from(gap_ticks) - best.iter().sum::<f64>();
    let share = short / ones.iter().sum::<f64>();
    Some(best.iter().zip(&ones).map(|(best, one)| best + share * one).collect())
}

/// The rows of the ticks of a gap and of those beside it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TickRows {
    gap_ticks: u32,
    /// The rows in the order of [`place`]. Numbers beyond the end of a row are 0.
    rows: Rows,
}

/// Rows of numbers, one after the other.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rows {
    numbers: Vec<f64>,
    /// Where each row ends.
    ends: Vec<usize>,
}

impl Rows {
    /// No rows yet, with room for some of at most `width` numbers.
    pub fn with_capacity(count: usize, width: usize) -> Rows {
        Rows { numbers: Vec::with_capacity(count * width), ends: Vec::with_capacity(count) }
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// A row; empty beyond the last.
    pub fn row(&self, index: usize) -> &[f64] {
        let start = if index == 0 { 0 } else { self.ends.get(index - 1).copied().unwrap_or(0) };
        self.ends.get(index).map_or(&[], |&end| &self.numbers[start..end])
    }

    /// All rows in order.
    pub fn iter(&self) -> impl Iterator<Item = &[f64]> {
        (0..self.count()).map(|index| self.row(index))
    }

    /// Appends a row, whose numbers are given in two parts with zeros between them where the first is shorter than
    /// `width`.
    pub fn push(&mut self, first: &[f64], width: usize, more: &[f64]) {
        self.numbers.extend_from_slice(first);
        self.numbers.resize(self.numbers.len() + width.saturating_sub(first.len()), 0.0);
        self.numbers.extend_from_slice(more);
        self.ends.push(self.numbers.len());
    }
}

/// The place of a tick among the rows: the gap first, then outward, alternately after and before it. A tick farther out
/// comes later, so that its presence changes no nearer one.
pub fn place(tick: i32, gap_ticks: u32) -> usize {
    let n = gap_ticks as i32;
    (match tick {
        1.. if tick <= n => tick - 1,
        1.. => n + 2 * (tick - n - 1),
        _ => n + 2 * -tick + 1,
    }) as usize
}

/// Most ticks on a side of the gap that some ticks reach.
pub fn sides(ticks: &[i32], gap_ticks: u32) -> usize {
    let reach = |&tick: &i32| if tick > 0 { tick - gap_ticks as i32 } else { 1 - tick };
    ticks.iter().map(reach).max().unwrap_or(0).max(0) as usize
}

/// The ticks of a gap and of `sides` ticks on either side, in the order of their places.
pub fn ticks(gap_ticks: u32, sides: usize) -> impl Iterator<Item = i32> {
    let n = gap_ticks as i32;
    (1..=n).chain((0..sides as i32).flat_map(move |k| [n + 1 + k, -k]))
}

impl TickRows {
    /// Rows of a gap and its sides in the order of their places.
    pub fn new(gap_ticks: u32, rows: Rows) -> TickRows {
        TickRows { gap_ticks, rows }
    }

    /// The rows of a motion of some lines, with `sides` ticks on either side of the gap: two numbers for each line.
    pub fn of_lines(lines: &[TickLine], gap_ticks: u32, sides: usize) -> TickRows {
        let mut rows = Rows::with_capacity(gap_ticks as usize + 2 * sides, 2 * lines.len());
        for tick in ticks(gap_ticks, sides) {
            for line in lines {
                let phase = tick_phase(f64::from(tick), gap_ticks, line.nu_t);
                rows.numbers.extend([line.rms * libm::cos(phase), line.rms * libm::sin(phase)]);
            }
            rows.ends.push(rows.numbers.len());
        }
        TickRows::new(gap_ticks, rows)
    }

    /// Rows with the same products that are a lower triangle, with no negative number on its diagonal.
    ///
    /// The rows of nearer ticks do not depend on farther ones. Products of rows are right to 1e-15 of the rms of each
    /// tick.
    pub fn triangular(self) -> TickRows {
        TickRows::new(self.gap_ticks, triangular(&self.rows))
    }

    /// The row of a tick.
    pub fn tick(&self, tick: i32) -> &[f64] {
        self.rows.row(place(tick, self.gap_ticks))
    }

    /// The sum of the rows of the first `ticks` of the gap.
    pub fn gap(&self, ticks: u32) -> Vec<f64> {
        self.sum((1..=ticks as i32).map(|tick| (tick, 1.0)))
    }

    /// Variance of the error that some weights leave of the motion over the first `length` ticks of the gap, ″².
    pub fn error_variance(&self, ticks: &[i32], weights: &[f64], length: u32) -> f64 {
        let filled = ticks.iter().copied().zip(weights.iter().copied());
        let error = self.sum(filled.chain((1..=length as i32).map(|tick| (tick, -1.0))));
        dot(&error, &error)
    }

    /// These rows with all numbers multiplied.
    pub fn scaled(mut self, factor: f64) -> TickRows {
        self.rows.numbers.iter_mut().for_each(|x| *x *= factor);
        self
    }

    /// The rows of two independent motions together.
    pub fn beside(self, other: TickRows) -> TickRows {
        if self.rows.count() == 0 {
            return other;
        }
        let width = self.rows.iter().map(<[f64]>::len).max().unwrap_or(0);
        let mut rows = Rows::default();
        self.rows.iter().zip(other.rows.iter()).for_each(|(row, more)| rows.push(row, width, more));
        TickRows::new(self.gap_ticks, rows)
    }

    fn sum(&self, terms: impl Iterator<Item = (i32, f64)>) -> Vec<f64> {
        let mut sum = Vec::new();
        for (tick, factor) in terms {
            let row = self.tick(tick);
            if sum.len() < row.len() {
                sum.resize(row.len(), 0.0);
            }
            sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += factor * x);
        }
        sum
    }
}

/// The sum of products, in a fixed order of four partial sums; `b` has at least as many numbers as `a`.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (fours, rest) = a.as_chunks::<4>();
    let (others, other_rest) = b[..a.len()].as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (x, y) in fours.iter().zip(others) {
        for lane in 0..4 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    let rest: f64 = rest.iter().zip(other_rest).map(|(x, y)| x * y).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Lower triangular rows with the same products as the given ones, by Householder's reflections.
///
/// Each row depends on itself and those before it only. The result is exact for rows that differ from the given ones by
/// 1e-15 of their length, however nearly they depend on each other. Where there are more rows than numbers in them, later
/// ones are as long as the given ones.
pub fn triangular(rows: &Rows) -> Rows {
    let width = rows.iter().map(<[f64]>::len).max().unwrap_or(0);
    let mut triangle = Rows::with_capacity(rows.count(), width);
    // The mirror of each row turns what the mirrors before leave of it onto one axis: x − v(v·x), with v·v = 2.
    let mut normals = Rows::with_capacity(rows.count(), width);
    let mut negated = Vec::with_capacity(rows.count());
    let mut x = vec![0.0; width];
    for row in rows.iter() {
        x[..row.len()].copy_from_slice(row);
        x[row.len()..].fill(0.0);
        for (k, &negates) in negated.iter().enumerate() {
            let (normal, rest) = (normals.row(k), &mut x[k..]);
            let along = dot(normal, rest);
            rest.iter_mut().zip(normal).for_each(|(x, normal)| *x -= along * normal);
            if negates {
                x[k] = -x[k];
            }
        }
        let k = negated.len();
        if k == width {
            triangle.push(&x, width, &[]);
            continue;
        }
        let rest = &mut x[k..];
        let length = libm::sqrt(dot(rest, rest));
        // Onto the side that is farther away, so that nothing cancels; then the axis is negated.
        let negates = rest[0] >= 0.0;
        rest[0] += if negates { length } else { -length };
        let size = libm::sqrt(0.5 * dot(rest, rest));
        if size > 0.0 {
            rest.iter_mut().for_each(|x| *x /= size);
        }
        normals.push(rest, 0, &[]);
        negated.push(negates);
        triangle.push(&x[..k], k, &[length]);
    }
    triangle
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    use crate::lines::{covariance, of_ticks};

    const TICK_S: f64 = 0.005;
    const RATE: f64 = 12000.0;
    const SIGMA: f64 = 1.6 / 3.0;

    fn fit_ticks(name: &str, n: i32) -> Vec<i32> {
        match name {
            "4" => vec![-1, 0, n + 1, n + 2],
            "8+2" => (-7..=0).chain(n + 1..=n + 2).collect(),
            "8+8" => (-7..=0).chain(n + 1..=n + 8).collect(),
            "20+20" => (-19..=0).chain(n + 1..=n + 20).collect(),
            _ => panic!("no ticks are called {name}"),
        }
    }

    fn motion(band: Band, n: u32) -> TickRows {
        let lines = of_ticks(&band.lines(TICK_S * 64.0, Rule::Sparse), TICK_S);
        TickRows::of_lines(&lines, n, 20).triangular().scaled(RATE * core::f64::consts::FRAC_1_SQRT_2)
    }

    fn rms_of(ticks: &[i32], weights: &[f64], n: u32, motion: &TickRows) -> f64 {
        let noise: f64 = weights.iter().map(|w| w * w * SIGMA * SIGMA).sum();
        libm::sqrt(motion.error_variance(ticks, weights, n) + noise)
    }

    fn design(band: Band, n: u32, name: &str) -> (Vec<f64>, f64) {
        let (ticks, motion) = (fit_ticks(name, n as i32), motion(band, n));
        let weights = minimum_variance_weights(&ticks, n, &motion, &[SIGMA * SIGMA]).unwrap();
        let rms = rms_of(&ticks, &weights, n, &motion);
        (weights, rms)
    }

    #[test]
    fn errors_gains_and_largest_weights_are_those_of_the_reference() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/gap_minimum_variance.csv");
        let mut rows = 0;
        for record in csv::Reader::from_path(path).unwrap().records().map(Result::unwrap) {
            let number = |field: usize| record[field].parse::<f64>().unwrap();
            let band = Band { low_hz: number(0), high_hz: number(1) };
            let (weights, rms) = design(band, number(2) as u32, &record[3]);
            let gain = libm::sqrt(weights.iter().map(|w| w * w).sum());
            let largest = weights.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
            // The reference integrates its bands by the trapezoidal rule in 4000 steps, which moves weights by 3e-6.
            for (found, expected) in [(rms, number(4)), (gain, number(5)), (largest, number(6))] {
                assert!((found / expected - 1.0).abs() < 5e-6, "{record:?}: {found}, not {expected}");
            }
            rows += 1;
        }
        assert_eq!(rows, 36);
    }

    #[test]
    fn many_ticks_on_both_sides_bridge_a_wide_band_at_the_price_of_large_weights() {
        let (_, rms) = design(Band { low_hz: 1.0, high_hz: 60.0 }, 3, "20+20");
        assert!((rms - 9.3).abs() < 0.05, "{rms}");
    }

    #[test]
    fn a_filler_tuned_to_one_frequency_is_fragile() {
        let at_19 = motion(Band { low_hz: 19.0, high_hz: 19.0 }, 3);
        for (name, expected) in [("8+2", 21.6), ("4", 3.3)] {
            let (weights, _) = design(Band { low_hz: 20.0, high_hz: 20.0 }, 3, name);
            let rms = rms_of(&fit_ticks(name, 3), &weights, 3, &at_19);
            assert!((rms - expected).abs() < 0.05, "{name}: {rms}");
        }
    }

    #[test]
    fn no_weights_near_by_are_better() {
        let band = Band { low_hz: 18.0, high_hz: 22.0 };
        for name in ["8+2", "20+20"] {
            let (ticks, motion) = (fit_ticks(name, 3), motion(band, 3));
            let (weights, rms) = design(band, 3, name);
            assert!((weights.iter().sum::<f64>() - 3.0).abs() < 1e-12);
            for i in 1..weights.len() {
                for step in [-1e-3, 1e-3] {
                    let mut other = weights.clone();
                    other[0] -= step;
                    other[i] += step;
                    assert!(rms_of(&ticks, &other, 3, &motion) > rms, "{name}: weight {i}, {step}");
                }
            }
        }
    }

    /// The variance is a quadratic form of the weights: where both ways along a line rise, its lowest point is between them.
    #[test]
    fn for_random_motions_ticks_and_gaps_no_weights_with_their_sum_are_better() {
        let mut rng = StdRng::seed_from_u64(44);
        for case in 0..100 {
            let n = rng.random_range(1..=20_u32);
            let after = n.cast_signed() + 1..=n.cast_signed() + 12;
            let ticks: Vec<i32> =
                (-12..=0).chain(after).filter(|tick| *tick == 0 || rng.random::<f64>() < 0.5).collect();
            let low_hz = rng.random_range(0.1..90.0);
            let band = Band { low_hz, high_hz: low_hz + rng.random_range(0.0..10.0) };
            let rate = libm::exp10(rng.random_range(0.0..5.0));
            let lines = of_ticks(&band.lines(TICK_S * 64.0, Rule::Sparse), TICK_S);
            let motion = TickRows::of_lines(&lines, n, 13).triangular().scaled(rate);
            let sigma = libm::exp10(rng.random_range(-3.0..1.0));
            let weights = minimum_variance_weights(&ticks, n, &motion, &[sigma * sigma]).unwrap();
            let sum: f64 = weights.iter().sum();
            assert!((sum / f64::from(n) - 1.0).abs() < 1e-9, "case {case}: a sum of {sum} for {n} ticks");
            let variance = |weights: &[f64]| {
                let noise: f64 = weights.iter().map(|w| w * w * sigma * sigma).sum();
                motion.error_variance(&ticks, weights, n) + noise
            };
            let least = variance(&weights);
            for _ in 0..20 {
                let step: Vec<f64> = ticks.iter().map(|_| rng.random_range(-1.0..1.0)).collect();
                let mean = step.iter().sum::<f64>() / step.len() as f64;
                let moved = [-0.1, 0.1].map(|size| {
                    let other: Vec<f64> =
                        weights.iter().zip(&step).map(|(w, step)| w + size * (step - mean)).collect();
                    variance(&other)
                });
                // The rises are equal up to rounding of weights and variances, which motion far above the noise enlarges.
                let [down, up] = moved.map(|moved| moved - least);
                assert!(
                    ticks.len() == 1 || (down > 0.0 && (up / down - 1.0).abs() < 0.04),
                    "case {case}, {band:?}, {ticks:?}: {least} ″² rises by {down} and {up}"
                );
            }
        }
    }

    #[test]
    fn a_band_is_the_mean_of_its_frequencies() {
        let band = Band { low_hz: 1.0, high_hz: 60.0 };
        let of = |band: Band, lag: usize| {
            let lines = of_ticks(&band.lines(TICK_S * 40.0, Rule::Sparse), TICK_S);
            covariance(&lines, 40)[lag]
        };
        let steps = 20_000;
        for lag in [0, 1, 7, 39] {
            let at = |k: usize| {
                let nu = 1.0 + 59.0 * (k as f64 + 0.5) / steps as f64;
                of(Band { low_hz: nu, high_hz: nu }, lag)
            };
            let mean = (0..steps).map(at).sum::<f64>() / steps as f64;
            let found = of(band, lag);
            assert!((found - mean).abs() < 1e-6 * of(band, 0), "lag {lag}: {found}, not {mean}");
        }
    }

    #[test]
    fn motion_without_noise_on_more_ticks_than_it_has_freedoms_is_singular() {
        let tone = motion(Band { low_hz: 20.0, high_hz: 20.0 }, 3);
        assert_eq!(minimum_variance_weights(&fit_ticks("4", 3), 3, &tone, &[]), None);
        assert!(minimum_variance_weights(&[0, 4], 3, &tone, &[]).is_some());
        assert_eq!(minimum_variance_weights(&[0, 4], 3, &TickRows::default(), &[]), None);
    }

    fn band(low: f64, high: f64) -> Vec<TickLine> {
        (0..200)
            .map(|k| TickLine { nu_t: low + (high - low) * (f64::from(k) + 0.5) / 200.0, rms: 0.07 })
            .collect()
    }

    #[test]
    fn products_of_rows_are_the_covariance_by_lag() {
        for (low, high) in [(0.1, 0.1001), (0.06, 0.16), (0.0, 0.5), (0.49, 1.3)] {
            let lines = band(low, high);
            let (n, sides) = (3, 40);
            let expected = covariance(&lines, 2 * sides + 3);
            let rows = TickRows::of_lines(&lines, n, sides).triangular();
            let all: Vec<i32> = ticks(n, sides).collect();
            for (i, &a) in all.iter().enumerate() {
                assert_eq!(place(a, n), i);
                assert!(rows.tick(a).len() == i + 1 && rows.tick(a)[i] >= 0.0, "{a}: {:?}", rows.tick(a));
                for &b in &all[..=i] {
                    let (row, own) = (rows.tick(b), rows.tick(a));
                    let found = dot(row, own);
                    let lag = a.abs_diff(b) as usize;
                    let error = found - expected[lag];
                    assert!(error.abs() < 1e-14, "{low}, {a}, {b}: {found}, {error:e}");
                }
            }
        }
    }

    #[test]
    fn rows_of_nearer_ticks_do_not_depend_on_farther_ones() {
        let lines = band(0.05, 0.1);
        let [few, many] = [5, 30].map(|sides| TickRows::of_lines(&lines, 4, sides).triangular());
        assert!((0..few.rows.count()).all(|index| few.rows.row(index) == many.rows.row(index)));
    }

    #[test]
    fn errors_that_cancel_to_a_millionth_of_the_motion_keep_their_digits() {
        // A sum over sines and cosines, each with its own phase, is what the variance of the error is.
        let (lines, n) = (band(0.06, 0.16), 3);
        let ticks: Vec<i32> = (-31..=0).chain(4..=11).collect();
        let rows = TickRows::of_lines(&lines, n, 32).triangular();
        let noise = [1e-12];
        let weights = crate::minimum_variance::minimum_variance_weights(&ticks, n, &rows, &noise).unwrap();
        let direct: f64 = lines
            .iter()
            .map(|line| {
                let response = |part: fn(f64) -> f64| {
                    let at = |tick: i32| part(tick_phase(f64::from(tick), n, line.nu_t));
                    let filled: f64 = ticks.iter().zip(&weights).map(|(&tick, w)| w * at(tick)).sum();
                    filled - (1..=3).map(at).sum::<f64>()
                };
                let (a, b) = (response(libm::cos), response(libm::sin));
                line.rms * line.rms * (a * a + b * b)
            })
            .sum();
        let found = rows.error_variance(&ticks, &weights, n);
        assert!(libm::sqrt(direct) < 1e-5, "{direct:e} is no hard case");
        assert!((found / direct - 1.0).abs() < 1e-6, "{found:e}, not {direct:e}");
    }

    #[test]
    fn rows_that_depend_on_others_end_in_zeros() {
        let mut rows = Rows::default();
        [[3.0, 4.0], [6.0, 8.0], [0.0, 1.0], [1.0, 1.0]].iter().for_each(|row| rows.push(row, 2, &[]));
        let found = triangular(&rows);
        assert_eq!(found.row(0), [5.0]);
        for (i, j) in (0..4).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let product: f64 = found.row(i).iter().zip(found.row(j)).map(|(a, b)| a * b).sum();
            assert!((product - dot(rows.row(i), rows.row(j))).abs() < 1e-14, "{i}, {j}: {product}");
        }
    }
}
