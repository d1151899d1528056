//! Gaussian motion of a record: white numbers through a filter whose output has the spectrum that is asked for.
//!
//! The taps are rounded to whole numbers and convolved with whole normal numbers modulo a prime, by transforms in which nothing is
//! rounded. A sample is therefore the same to the last bit wherever it is computed, and costs the same for any number of taps.
//!
//! The filter has the phase 0 and the gain √S at as many frequencies as it has taps, each of which takes the power of lines
//! in proportion to their nearness. A window of sin⁶ between the ends of the taps removes the ripples between these frequencies and, far
//! from the motion, what would act as a drift.

use core::f64::consts::{PI, TAU};

use crate::key::Unrepresentable;
use crate::motion::Gaussian;
use sagnac_base::quantity::number::significant;
use sagnac_kernel::normal::{SIGMA, normal};
use sagnac_kernel::philox::{Address, Purpose, WORDS};
use sagnac_kernel::word::Scalar;
use sagnac_theory::lines::{self, TickLine};
use sagnac_theory::quadrature::Rule;

/// Fewest and most taps.
const TAPS: [usize; 2] = [1 << 8, 1 << 18];
/// Least number of frequencies of the filter below the lowest one of the motion, so that none of it is a drift.
const BELOW: f64 = 16.0;
/// Most of the power that the filter may have at other frequencies than the motion.
const MAX_MISPLACED: f64 = 0.01;
/// Fractional bits of the white numbers.
const WHITE_BITS: i32 = 16;
/// log2 of the largest sum of the magnitudes of the taps: with white numbers below 2^19, products stay below half of the prime.
const SUM_BITS: i32 = 43;

/// A filter of white numbers, in whole numbers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Filter {
    /// The transform of the taps, divided by its length.
    taps: Vec<u64>,
    ring: Ring,
    /// log2 of the unit of the sums of products, in that of the motion.
    shift: i32,
}

impl Filter {
    /// The filter for the angles of samples of `sample_s` in whole numbers of `unit` ″; `None` for a motion of size 0.
    ///
    /// # Errors
    /// The spectrum has features that are too narrow, or frequencies that are too low, for such samples.
    pub(crate) fn new(
        gaussian: &Gaussian,
        sample_s: f64,
        unit: f64,
    ) -> Result<Option<Filter>, Unrepresentable> {
        let (shape, size) = gaussian.unit();
        let lowest_hz = shape.frequencies_hz()[0];
        let least = TAPS[0].max((BELOW / (lowest_hz * sample_s)).min(2.0 * TAPS[1] as f64) as usize);
        let mut count = least.next_power_of_two();
        while count <= TAPS[1] {
            let lines = shape.lines(2.0 * count as f64 * sample_s, Rule::Sparse);
            let lines = lines::of_ticks(&lines, sample_s);
            let wanted = powers(&lines, 2 * count);
            let total: f64 = wanted.iter().sum();
            if total * size == 0.0 {
                return Ok(None);
            }
            let taps = taps(&powers(&lines, count), total);
            if misplaced(&taps, &wanted) <= MAX_MISPLACED * total {
                let scaled: Vec<f64> = taps.iter().map(|tap| tap * (size / unit)).collect();
                return Ok(Some(Filter::of_taps(&scaled)));
            }
            count *= 2;
        }
        let found = format!(
            "its spectrum from {} Hz is too narrow, or too low, for samples of {} s",
            significant(lowest_hz, 6),
            significant(sample_s, 6)
        );
        let help = "take a tone with a Rayleigh-distributed amplitude for a narrow band, a higher lower end, or a lower rate";
        Err(Unrepresentable::new(gaussian.key(), found, help))
    }

    /// The taps as whole numbers.
    fn of_taps(taps: &[f64]) -> Filter {
        let sum: f64 = taps.iter().map(|tap| tap.abs()).sum();
        let exponent = (libm::ceil(libm::log2(sum)) as i32 - SUM_BITS).max(-100);
        let ring = Ring::new(2 * taps.len());
        let inverse = power(ring.length() as u64, PRIME - 2);
        let scale = libm::exp2(f64::from(-exponent));
        let mut words: Vec<u64> =
            taps.iter().map(|tap| multiply(residue(libm::round(tap * scale) as i64), inverse)).collect();
        words.resize(ring.length(), 0);
        ring.forward(&mut words);
        Filter { taps: words, ring, shift: exponent - WHITE_BITS }
    }

    /// Number of samples that are computed at a time.
    pub(crate) fn block(&self) -> usize {
        self.taps.len() / 2
    }

    /// The angles of the samples of block `number` of the record at `address`, in the order of the samples.
    pub(crate) fn angles(&self, address: &Address<Scalar>, number: u64) -> Vec<i128> {
        let first = number as usize * (self.block() / WORDS);
        let blocks = first..first + self.ring.length() / WORDS;
        let white = |block| address.draw(Purpose::GaussianAfter, block).map(|word| residue(white(word)));
        let mut words: Vec<u64> = blocks.flat_map(white).collect();
        self.ring.forward(&mut words);
        words.iter_mut().zip(&self.taps).for_each(|(word, tap)| *word = multiply(*word, *tap));
        self.ring.inverse(&mut words);
        let angle = |word: u64| {
            let sum = i128::from(signed(word));
            match self.shift {
                0.. => sum << self.shift,
                _ => (sum + (1 << (-self.shift - 1))) >> -self.shift,
            }
        };
        words.drain(..self.block());
        words.into_iter().map(angle).collect()
    }
}

/// A normal number with `WHITE_BITS` fractional bits.
fn white(word: Scalar) -> i64 {
    const DROPPED: u32 = SIGMA.ilog2() - WHITE_BITS as u32;
    (i64::from(normal(word).0 as i32) + (1 << (DROPPED - 1))) >> DROPPED
}

/// The power at each of `count` frequencies, which are the multiples of 1/`count` of the sampling rate, ″².
fn powers(lines: &[TickLine], count: usize) -> Vec<f64> {
    let mut powers = vec![0.0; count];
    for line in lines {
        let place = (line.nu_t - libm::round(line.nu_t)).abs() * count as f64;
        let (at, part) = (place as usize, place - libm::floor(place));
        let half = 0.5 * line.rms * line.rms;
        for (at, power) in [(at, half * (1.0 - part)), (at + 1, half * part)] {
            powers[at % count] += power;
            powers[(count - at % count) % count] += power;
        }
    }
    powers
}

/// The taps of a filter with such powers at its frequencies, whose output has the variance `variance`.
fn taps(powers: &[f64], variance: f64) -> Vec<f64> {
    let count = powers.len();
    let response = powers.iter().map(|power| libm::sqrt(power * count as f64)).collect();
    let mut taps = cosine_sums(response);
    taps.rotate_right(count / 2);
    for (place, tap) in taps.iter_mut().enumerate() {
        let sine = libm::sin(PI * place as f64 / count as f64);
        let square = sine * sine;
        *tap *= square * square * square;
    }
    let square: f64 = taps.iter().map(|tap| tap * tap).sum();
    let scale = libm::sqrt(variance / square);
    taps.iter().map(|tap| tap * scale).collect()
}

/// The power that the output has at other frequencies than `wanted`, ″².
fn misplaced(taps: &[f64], wanted: &[f64]) -> f64 {
    let (count, half) = (wanted.len(), taps.len() / 2);
    let mut placed = vec![0.0; count];
    for (place, tap) in taps.iter().enumerate() {
        placed[(place + count - half) % count] = *tap;
    }
    let response = cosine_sums(placed);
    let found = response.iter().map(|gain| gain * gain / count as f64);
    0.5 * found.zip(wanted).map(|(found, wanted)| (found - wanted).abs()).sum::<f64>()
}

/// Σ_j x_j cos(2πjk/n) for each k of n, a power of two.
fn cosine_sums(x: Vec<f64>) -> Vec<f64> {
    let count = x.len();
    let bits = count.ilog2();
    let reversed = |k: usize| k.reverse_bits() >> (usize::BITS - bits);
    let mut sums: Vec<[f64; 2]> = (0..count).map(|k| [x[reversed(k)], 0.0]).collect();
    let turns: Vec<[f64; 2]> = (0..count / 2)
        .map(|k| {
            let angle = TAU * k as f64 / count as f64;
            [libm::cos(angle), libm::sin(angle)]
        })
        .collect();
    let mut half = 1;
    while half < count {
        for start in (0..count).step_by(2 * half) {
            for k in 0..half {
                let [cos, sin] = turns[k * (count / (2 * half))];
                let ([a, b], [c, d]) = (sums[start + k], sums[start + half + k]);
                let [c, d] = [c * cos - d * sin, c * sin + d * cos];
                sums[start + k] = [a + c, b + d];
                sums[start + half + k] = [a - c, b - d];
            }
        }
        half *= 2;
    }
    sums.into_iter().map(|[re, _]| re).collect()
}

/// The prime 2^64 − 2^32 + 1, whose residues have roots of unity of every power of two up to 2^32.
const PRIME: u64 = 0xffff_ffff_0000_0001;
/// 2^64 modulo the prime.
const WRAP: u64 = 0xffff_ffff;
/// A generator of the residues.
const GENERATOR: u64 = 7;

/// Transforms of residues of the prime, whose products are cyclic convolutions.
#[derive(Debug, Clone, PartialEq)]
struct Ring {
    /// Powers of a root of unity, and of its inverse, half as many as residues are transformed.
    roots: [Vec<u64>; 2],
}

impl Ring {
    /// Transforms of `length` residues, a power of two.
    fn new(length: usize) -> Ring {
        let root = power(GENERATOR, (PRIME - 1) / length as u64);
        let powers = |root: u64| {
            core::iter::successors(Some(1), |last| Some(multiply(*last, root))).take(length / 2).collect()
        };
        Ring { roots: [powers(root), powers(power(root, PRIME - 2))] }
    }

    fn length(&self) -> usize {
        2 * self.roots[0].len()
    }

    /// The transform, in the order of reversed bits.
    fn forward(&self, x: &mut [u64]) {
        let mut half = x.len() / 2;
        while half > 0 {
            let stride = x.len() / (2 * half);
            for pair in x.chunks_exact_mut(2 * half) {
                let (low, high) = pair.split_at_mut(half);
                let roots = self.roots[0].iter().step_by(stride);
                for ((a, b), root) in low.iter_mut().zip(high).zip(roots) {
                    (*a, *b) = (add(*a, *b), multiply(subtract(*a, *b), *root));
                }
            }
            half /= 2;
        }
    }

    /// The residues of a transform in the order of reversed bits, times their number.
    fn inverse(&self, x: &mut [u64]) {
        let mut half = 1;
        while half < x.len() {
            let stride = x.len() / (2 * half);
            for pair in x.chunks_exact_mut(2 * half) {
                let (low, high) = pair.split_at_mut(half);
                let roots = self.roots[1].iter().step_by(stride);
                for ((a, b), root) in low.iter_mut().zip(high).zip(roots) {
                    let turned = multiply(*b, *root);
                    (*a, *b) = (add(*a, turned), subtract(*a, turned));
                }
            }
            half *= 2;
        }
    }
}

fn add(a: u64, b: u64) -> u64 {
    let (sum, has_wrapped) = a.overflowing_add(b);
    let sum = if has_wrapped { sum + WRAP } else { sum };
    if sum >= PRIME { sum - PRIME } else { sum }
}

fn subtract(a: u64, b: u64) -> u64 {
    if a >= b { a - b } else { a + (PRIME - b) }
}

fn multiply(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    let (low, high) = (product as u64, (product >> 64) as u64);
    // 2^64 is 2^32 − 1, and 2^96 is −1.
    let (rest, has_wrapped) = low.overflowing_sub(high >> 32);
    let rest = if has_wrapped { rest - WRAP } else { rest };
    add(if rest >= PRIME { rest - PRIME } else { rest }, (high & WRAP) * WRAP)
}

fn power(base: u64, mut exponent: u64) -> u64 {
    let (mut result, mut square) = (1, base);
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = multiply(result, square);
        }
        square = multiply(square, square);
        exponent >>= 1;
    }
    result
}

fn residue(x: i64) -> u64 {
    if x < 0 { PRIME - x.unsigned_abs() } else { x.unsigned_abs() }
}

/// The number of least magnitude with this residue.
fn signed(x: u64) -> i64 {
    if x > PRIME / 2 { -((PRIME - x) as i64) } else { x as i64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_transforms_are_exact_convolutions() {
        let ring = Ring::new(64);
        let number = |k: i64| k.wrapping_mul(0x9e37_79b9_7f4a_7c15_u64.cast_signed()) >> 36;
        let [a, b]: [Vec<i64>; 2] = [0, 64].map(|from| (from..from + 64).map(number).collect());
        let inverse = power(64, PRIME - 2);
        let [mut x, mut y] = [&a, &b].map(|x| x.iter().map(|x| residue(*x)).collect::<Vec<u64>>());
        ring.forward(&mut x);
        ring.forward(&mut y);
        x.iter_mut().zip(&y).for_each(|(x, y)| *x = multiply(multiply(*x, *y), inverse));
        ring.inverse(&mut x);
        for (k, found) in x.into_iter().enumerate() {
            let expected: i64 = (0..64).map(|j| a[j] * b[(k + 64 - j) % 64]).sum();
            assert_eq!(signed(found), expected, "{k}");
        }
    }

    #[test]
    fn a_filter_has_the_gain_of_its_band_and_none_near_0() {
        let band: Vec<TickLine> =
            (0..1000).map(|k| TickLine { nu_t: 0.1 + 1e-4 * (f64::from(k) + 0.5), rms: 0.1 }).collect();
        let taps = taps(&powers(&band, 1024), 10.0);
        let gain = |nu_t: f64| {
            let turned = |(place, tap): (usize, &f64)| tap * libm::cos(TAU * nu_t * (place as f64 - 512.0));
            taps.iter().enumerate().map(turned).sum::<f64>().abs()
        };
        // The power of 10 in a band of 0.1 on both sides of 0.
        let inside = libm::sqrt(50.0);
        for nu_t in [0.12, 0.1503, 0.18] {
            assert!((gain(nu_t) / inside - 1.0).abs() < 0.01, "{nu_t}: {}", gain(nu_t));
        }
        for nu_t in [0.0, 1e-4, 5e-4, 0.0123, 0.04, 0.0804, 0.23, 0.5] {
            assert!(gain(nu_t) < 1e-6 * inside, "{nu_t}: {}", gain(nu_t));
        }
    }

    #[test]
    fn a_filter_gives_what_the_sums_of_its_products_are() {
        let taps: Vec<f64> = (0..256).map(|k| 1e7 * libm::sin(f64::from(k * k))).collect();
        let filter = Filter::of_taps(&taps);
        let address = Address::new([5, 6], 7);
        let white = |k: usize| white(address.draw(Purpose::GaussianAfter, k / WORDS)[k % WORDS]) as f64;
        let found: Vec<i128> = (0..3).flat_map(|block| filter.angles(&address, block)).collect();
        for (sample, found) in found.into_iter().enumerate() {
            let expected: f64 =
                (0..256).map(|j| taps[j] * white(256 + sample - j)).sum::<f64>() / libm::exp2(16.0);
            assert!((found as f64 - expected).abs() < 1.0, "{sample}: {found}, not {expected}");
        }
    }
}
