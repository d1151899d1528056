//! Flicker as a sum of octave holds, and the closed form of its differences.
//!
//! Octave o holds one Gaussian rate for L = 2^o samples. The grid of its holds has a random position, uniformly
//! distributed over the L possible ones, so the rate is stationary with the covariance v·max(0, 1 − |lag|/L). Several
//! independent streams, each with a fraction of the variance, have the same second moments. With [`variances`] the
//! Allan variance is flat.
//!
//! # Generalized covariance
//!
//! It gives the covariance of any two differences of a sampled angle.
//!
//! An angle with a random walk has no covariance, but its differences have: Σ c_i c_j G(k_i − k_j) with G = −V/2, where
//! V(n) is the variance of its increment over n samples. G may differ by a parabola, which second differences cancel.
//! The quantity needed is the second difference of G over the shorter of two differences, written so that nothing
//! cancels for lags much longer than it.

use crate::allan::Difference;

/// Octaves of the committed table, which is flat up to m = 2^20.
pub const OCTAVES: usize = 24;
/// Largest number of octaves for which there are variances.
pub const MAX_OCTAVES: usize = 30;

/// Variance of the rate of each octave, o = 0 …, for an Allan variance of 1.
///
/// They are a copy of `tests/data/flicker_weights.csv`, obtained by non-negative least squares over m = 1 … 2^20.
const VARIANCES: [f64; OCTAVES] = [
    0.420864908298,
    0.628540620188,
    0.558864672398,
    0.498026482931,
    0.506881043276,
    0.498052113797,
    0.501338661709,
    0.499424637027,
    0.500309499407,
    0.499850277598,
    0.500079060391,
    0.499954784445,
    0.500035091647,
    0.499957491488,
    0.500071528432,
    0.499863237512,
    0.500271522689,
    0.499454120192,
    0.501115159363,
    0.497587204386,
    0.506748311278,
    0.588716428472,
    0.544565410589,
    0.522489901647,
];

/// Octave after which further octaves are inserted, far from both ends, where the variance is that of an infinite sum.
const MIDDLE: usize = 12;
/// Variance of an octave far from both ends.
const ENDLESS: f64 = 0.5;

/// The variance of each of `octaves` octaves for an Allan variance of 1 up to m = 2^(`octaves` − 4).
///
/// Longer tables have octaves of ½ inserted between the two halves of the committed one. `None` outside 24 … 30.
pub fn variances(octaves: usize) -> Option<Vec<f64>> {
    let more = octaves.checked_sub(OCTAVES).filter(|_| octaves <= MAX_OCTAVES)?;
    let (start, end) = VARIANCES.split_at(MIDDLE);
    Some([start, &vec![ENDLESS; more], end].concat())
}

/// Number of octaves that a record of `samples` samples needs to be flat up to its longest τ, m = `samples`/2; at least
/// 24.
///
/// `None` for more than 2^27 samples, for which there are no variances; their flicker is refused.
pub fn octaves(samples: u64) -> Option<usize> {
    let needed = (samples.max(2).div_ceil(2).next_power_of_two().ilog2() + 4) as usize;
    (needed <= MAX_OCTAVES).then_some(needed.max(OCTAVES))
}

/// Variance of a difference at `m` of the angle of one octave of holds of `length` samples, with a rate of variance 1
/// and t0 = 1, in units of (rate · sample)².
///
/// It is 4V(m) − V(2m) or 15V(m) − 6V(2m) + V(3m), where V(n) is the variance of n summed rates: n² − n(n² − 1)/3L for
/// n ≤ L, and nL − (L² − 1)/3 beyond. Where no hold ends twice in a difference, only the cubes remain, so that nothing
/// cancels.
pub fn mean_square(difference: Difference, length: u64, m: u64) -> f64 {
    let (l, n) = (length as f64, m as f64);
    let inside = difference.spans() * m <= length;
    let v = |times: f64| summed(l, times * n);
    match difference {
        Difference::Second if inside => 2.0 * (2.0 * n * n * n + n) / (3.0 * l),
        Difference::Third if inside => 2.0 * (n * n * n + n) / l,
        Difference::Second => 4.0 * v(1.0) - v(2.0),
        Difference::Third => 15.0 * v(1.0) - 6.0 * v(2.0) + v(3.0),
    }
}

/// V(n): variance of the sum of n rates.
fn summed(l: f64, n: f64) -> f64 {
    match n <= l {
        true => n * n - n * (n * n - 1.0) / (3.0 * l),
        false => n * l - (l * l - 1.0) / 3.0,
    }
}

/// Octave holds. A hold is a random walk of the rate that is undone after its length.
pub struct Holds {
    /// Variance of the rate of each octave times t0², ″²; the sum over all octaves before it; and the sum of variance
    /// over length from it on.
    octaves: Vec<f64>,
    before: Vec<f64>,
    from: Vec<f64>,
}

impl Holds {
    /// Holds with these variances of the rate of each octave times t0², ″².
    pub fn new(octaves: Vec<f64>) -> Holds {
        let (mut before, mut from) = (vec![0.0; octaves.len() + 1], vec![0.0; octaves.len() + 1]);
        for o in 0..octaves.len() {
            before[o + 1] = before[o] + octaves[o];
        }
        for o in (0..octaves.len()).rev() {
            from[o] = from[o + 1] + octaves[o] / length(o);
        }
        Holds { octaves, before, from }
    }

    /// The second difference of the generalized covariance, `m` apart around the lag `n`, both in units of t0, ″².
    pub fn at(&self, m: f64, n: f64) -> f64 {
        let within = |lag: f64| match lag < 1.0 {
            true => 0,
            false => self.octaves.len().min(1 + libm::ilogb(lag) as usize),
        };
        // Holds that end before all three lags contribute the same at every lag, and those that end after them are not
        // reversed.
        let (short, reached) = (within(n - m), within(n + m));
        let hold = |o: usize| {
            let taken_back = one_sided_cubic(m, n - length(o)) + one_sided_cubic(m, -n - length(o));
            2.0 * self.octaves[o] / length(o) * (cubic(m, n) - taken_back)
        };
        self.before[short] * m * m
            + (short..reached).map(hold).sum::<f64>()
            + 2.0 * self.from[reached] * cubic(m, n)
    }
}

/// Length in samples of a hold of an octave.
fn length(octave: usize) -> f64 {
    (1_u64 << octave) as f64
}

/// Second difference, m apart, of (|n|³ − |n|)/12, n ≥ 0.
pub fn cubic(m: f64, n: f64) -> f64 {
    match n >= m {
        true => 0.5 * n * m * m,
        false => g(n + m) - 2.0 * g(n) + g(m - n),
    }
}

/// The second difference of (u³ − u)/12 for u > 0, else 0.
fn one_sided_cubic(m: f64, u: f64) -> f64 {
    match u {
        u if u >= m => 0.5 * u * m * m,
        u if u <= -m => 0.0,
        u => g(u + m) - 2.0 * g(u.max(0.0)),
    }
}

fn g(n: f64) -> f64 {
    (n * n * n - n) / 12.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The variance by definition: ΣΣ over the rates of both sides.
    fn by_definition(difference: Difference, length: u64, m: u64) -> f64 {
        let signs: &[f64] = match difference {
            Difference::Second => &[-1.0, 1.0],
            Difference::Third => &[1.0, -2.0, 1.0],
        };
        let weights: Vec<f64> = signs.iter().flat_map(|&sign| vec![sign; m as usize]).collect();
        let covariance = |a: usize, b: usize| (1.0 - a.abs_diff(b) as f64 / length as f64).max(0.0);
        let row = |i: usize| weights.iter().enumerate().map(|(j, w)| w * covariance(i, j)).sum::<f64>();
        weights.iter().enumerate().map(|(i, w)| w * row(i)).sum()
    }

    #[test]
    fn the_closed_form_is_the_double_sum() {
        for length in [1, 2, 3, 4, 8, 16, 32, 64, 128] {
            for m in (1..=40).chain([63, 64, 65, 100]) {
                for difference in [Difference::Second, Difference::Third] {
                    let (found, expected) =
                        (mean_square(difference, length, m), by_definition(difference, length, m));
                    assert!(
                        (found / expected - 1.0).abs() < 1e-10,
                        "{difference:?}, L = {length}, m = {m}: {found}, not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_table_is_that_of_the_file() {
        let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/flicker_weights.csv"));
        let rows: Vec<(u64, f64)> = text
            .lines()
            .skip(1)
            .map(|line| {
                let cells: Vec<&str> = line.split(',').collect();
                (cells[1].parse().unwrap(), cells[2].parse().unwrap())
            })
            .collect();
        let table: Vec<(u64, f64)> = VARIANCES.iter().enumerate().map(|(o, &w)| (1 << o, w)).collect();
        assert_eq!(table, rows);
    }

    #[test]
    fn the_allan_variance_is_flat_to_half_a_percent() {
        for octaves in OCTAVES..=MAX_OCTAVES {
            let variances = variances(octaves).unwrap();
            let at = |m: u64| {
                let sum: f64 =
                    (0..octaves).map(|o| variances[o] * mean_square(Difference::Second, 1 << o, m)).sum();
                sum / (2.0 * m as f64 * m as f64)
            };
            // Eight steps per octave.
            for step in 0..=8 * (octaves as u32 - 4) {
                let m = libm::exp2(f64::from(step) / 8.0).round() as u64;
                assert!((at(m) - 1.0).abs() < 0.005, "{octaves} octaves, m = {m}: {}", at(m));
            }
            let beyond = at(1 << (octaves - 3));
            assert!((beyond - 0.98).abs() < 0.002, "{octaves} octaves, twice too far: {beyond}");
        }
    }

    #[test]
    fn longer_records_take_more_octaves_and_the_longest_are_refused() {
        let table = [
            (1000, Some(24)),
            (1 << 21, Some(24)),
            ((1 << 21) + 1, Some(25)),
            (1 << 27, Some(30)),
            ((1 << 27) + 1, None),
        ];
        for (samples, expected) in table {
            assert_eq!(octaves(samples), expected, "{samples}");
        }
        assert_eq!((variances(23), variances(31)), (None, None));
    }
}
