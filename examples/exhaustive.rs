//! The Gaussian for all its 2^31 magnitudes and the sine for all its 2^32 phases, compared with the exact functions.
//!
//! `cargo run --release --example exhaustive` prints the figures of `docs/dev/numerics.md`.

use core::f64::consts::{PI, SQRT_2};
use std::time::Instant;

use rayon::prelude::*;
use sagnac_kernel::normal::{REACH, SIGMA};
use sagnac_kernel::sine::ONE;
use sagnac_kernel::width::Width;
use sagnac_kernel::{Form, normal, sine};

/// Number of words in the piece of a thread.
const PIECE: u64 = 1 << 16;

/// The results of a building block for some items.
fn evaluated(form: Form, width: Width, items: &[u32]) -> Vec<u32> {
    match form {
        Form::Map(map) => (map.cpu)(width, items),
        _ => vec![],
    }
}

fn main() {
    let width = Width::widest();
    println!("{}, {} threads", width.name(), rayon::current_num_threads());
    let started = Instant::now();
    gaussian(width);
    println!("  {:.1} s", started.elapsed().as_secs_f64());
    let started = Instant::now();
    sine(width);
    println!("  {:.1} s", started.elapsed().as_secs_f64());
}

/// The words of a piece.
fn words(piece: u64) -> Vec<u32> {
    (piece * PIECE..(piece + 1) * PIECE).map(|word| word as u32).collect()
}

/// Exact sums over the magnitudes of some words, which are in descending order if the generator is monotone.
#[derive(Clone, Copy, Default)]
struct Magnitudes {
    square: u128,
    /// Σ (z² / 2^12)², rounded down, with an error below 2^−40 of the sum.
    fourth: u128,
    beyond: [u64; 6],
    largest: u32,
    smallest_is_negative: bool,
    rises: u64,
    largest_rise: u32,
}

impl Magnitudes {
    fn new(z: &[u32]) -> Magnitudes {
        let mut sums = Magnitudes::default();
        for &z in z {
            sums.square += u128::from(u64::from(z) * u64::from(z));
            let coarse = u128::from((u64::from(z) * u64::from(z)) >> 12);
            sums.fourth += coarse * coarse;
            for (k, beyond) in sums.beyond.iter_mut().enumerate() {
                *beyond += u64::from(z > (k as u32 + 1) * SIGMA);
            }
            sums.largest = sums.largest.max(z);
            sums.smallest_is_negative |= (z as i32) < 0;
        }
        sums.add_rises(z);
        sums
    }

    fn add_rises(&mut self, z: &[u32]) {
        for pair in z.windows(2) {
            let rise = pair[1].saturating_sub(pair[0]);
            self.rises += u64::from(rise > 0);
            self.largest_rise = self.largest_rise.max(rise);
        }
    }

    fn join(mut self, other: Magnitudes) -> Magnitudes {
        self.square += other.square;
        self.fourth += other.fourth;
        self.beyond.iter_mut().zip(other.beyond).for_each(|(beyond, more)| *beyond += more);
        self.largest = self.largest.max(other.largest);
        self.smallest_is_negative |= other.smallest_is_negative;
        self.rises += other.rises;
        self.largest_rise = self.largest_rise.max(other.largest_rise);
        self
    }
}

fn gaussian(width: Width) {
    let sums = (0..(1_u64 << 31) / PIECE)
        .into_par_iter()
        .map(|piece| {
            let mut words = words(piece);
            let mut z = evaluated(normal::FORM, width, &words);
            let mut sums = Magnitudes::new(&z);
            // Includes the step to the next piece, except after the last word.
            let next = (piece + 1) * PIECE;
            if next < 1 << 31 {
                sums.add_rises(&[z[z.len() - 1], evaluated(normal::FORM, width, &[next as u32])[0]]);
            }
            // The same words with the sign bit: each number must be the opposite.
            words.iter_mut().for_each(|word| *word |= 1 << 31);
            let opposite = evaluated(normal::FORM, width, &words);
            z.iter_mut().for_each(|z| *z = z.wrapping_neg());
            assert_eq!(z, opposite, "the two signs differ in piece {piece}");
            sums
        })
        .reduce(Magnitudes::default, Magnitudes::join);
    assert!(!sums.smallest_is_negative, "a magnitude is negative");

    let count = libm::exp2(31.0);
    let unit = f64::from(SIGMA);
    let variance = sums.square as f64 / count / (unit * unit);
    let fourth = sums.fourth as f64 / count / libm::pow(unit / 64.0, 4.0);
    println!(
        "normal(): 2^31 magnitudes, both signs opposite everywhere, so the mean and all odd moments are 0"
    );
    println!(
        "  variance 1 {:+.3e}, kurtosis 3 {:+.3e}",
        variance - 1.0,
        fourth / (variance * variance) - 3.0
    );
    for (k, &beyond) in sums.beyond.iter().enumerate() {
        let sigmas = k as f64 + 1.0;
        let (found, exact) = (beyond as f64 / count, libm::erfc(sigmas / SQRT_2));
        println!(
            "  beyond {sigmas:.0} σ: {found:.9e}, exact {exact:.9e}, ratio 1 {:+.2e}",
            found / exact - 1.0
        );
    }
    println!("  reach {:.6} σ (REACH = {REACH})", f64::from(sums.largest) / unit);
    println!(
        "  monotone but for {} of 2^31 steps, the largest {:.2e} σ",
        sums.rises,
        f64::from(sums.largest_rise) / unit
    );
    assert!(f64::from(sums.largest) <= REACH * unit, "a draw lies beyond REACH");
}

fn sine(width: Width) {
    let pieces = (1_u64 << 32) / PIECE;
    let turn = 2.0 * PI / libm::exp2(32.0);
    // Exact sines of a piece by rotation from its start, which takes two library calls per piece instead of per phase.
    let rotation: Vec<(f64, f64)> = (0..PIECE).map(|k| (k as f64 * turn).sin_cos()).collect();
    let (largest, sum, square) = (0..pieces)
        .into_par_iter()
        .map(|piece| {
            let found = evaluated(sine::FORM, width, &words(piece));
            let (sin, cos) = ((piece * PIECE) as f64 * turn).sin_cos();
            let (mut largest, mut sum, mut square) = (0.0_f64, 0.0, 0.0);
            for (&found, &(step_sin, step_cos)) in found.iter().zip(&rotation) {
                let exact = sin * step_cos + cos * step_sin;
                let error = f64::from(found as i32) / f64::from(ONE) - exact;
                largest = largest.max(error.abs());
                sum += error;
                square += error * error;
            }
            (largest, sum, square)
        })
        .reduce(|| (0.0, 0.0, 0.0), |a, b| (a.0.max(b.0), a.1 + b.1, a.2 + b.2));
    let count = libm::exp2(32.0);
    println!("sine(): 2^32 phases");
    println!("  largest error 2^{:.3} = {largest:.3e}", largest.log2());
    println!("  rms error 2^{:.3}, mean error {:.1e}", 0.5 * (square / count).log2(), sum / count);
    let quarters = evaluated(sine::FORM, width, &[0, 1 << 30, 1 << 31, 3 << 30]);
    let exact = [0, ONE, 0, ONE.wrapping_neg()];
    println!("  quarter turns {}", if quarters == exact { "exact" } else { "NOT exact" });
    let below = quarters_around(width);
    println!("  |sine| ≤ 1 within ±2^16 of the quarter turns: {below}");
}

/// Whether no sine near its largest values exceeds them.
fn quarters_around(width: Width) -> bool {
    let near: Vec<u32> = [1_u32 << 30, 3 << 30]
        .into_iter()
        .flat_map(|quarter| (0..1 << 17).map(move |k| quarter.wrapping_sub(1 << 16).wrapping_add(k)))
        .collect();
    evaluated(sine::FORM, width, &near).iter().all(|&sine| (sine as i32).unsigned_abs() <= ONE)
}
