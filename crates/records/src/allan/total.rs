//! Total and modified total deviations, which extend a record by its reflections, so that long averaging times keep most of their
//! certainty.
//!
//! Definitions, biases and degrees of freedom: NIST SP 1065 (5.2.11, 5.2.12 and tables 4, 7 and 8).

use std::ops::Range;

use rayon::prelude::*;

use crate::allan::angles::Solid;
use crate::allan::sums::{Sum, in_lanes, second_differences, third_differences};

/// Most terms at one averaging factor, which take about a second; if there are more, they start at every n-th sample only. Records of
/// up to 32,000 samples keep every term.
const MAX_TERMS: u64 = 1 << 29;

/// The longest factor at which degrees of freedom of the modified total variance are those of the modified Allan variance, as in
/// Stable32; those that are published hold above it.
pub(crate) const MAX_OF_ALLAN: usize = 8;

/// Starts for which prefix sums are counted from one place, so that they stay small.
const TILE: usize = 1024;

/// Relation of the expected total variance to the Allan variance at the averaging factor `m` of a record of `samples` samples.
pub(crate) fn bias(alpha: i32, samples: usize, m: usize) -> f64 {
    let a = match alpha {
        0.. => 0.0,
        -1 => 1.0 / (3.0 * std::f64::consts::LN_2),
        _ => 0.75,
    };
    1.0 - a * m as f64 / samples as f64
}

/// Relation of the expected modified total variance to the modified Allan variance.
pub(crate) fn modified_bias(alpha: i32) -> f64 {
    [0.94, 0.83, 0.73, 0.70, 0.69][row(alpha)]
}

/// Equivalent degrees of freedom of the total variance; `None` for noise of the angle, for which they are those of the overlapping
/// Allan variance.
pub(crate) fn edf(alpha: i32, samples: usize, m: usize) -> Option<f64> {
    let [b, c] = match alpha {
        1.. => return None,
        0 => [1.50, 0.0],
        -1 => [1.17, 0.22],
        _ => [0.93, 0.36],
    };
    Some(b * samples as f64 / m as f64 - c)
}

/// Equivalent degrees of freedom of the modified total variance, for m above [`MAX_OF_ALLAN`]. Compared with simulated records, they are
/// within 6 % where the record is 16 τ or longer, and about 20 % too many at 8 τ.
pub(crate) fn modified_edf(alpha: i32, samples: usize, m: usize) -> f64 {
    let [b, c] = [[1.90, 2.10], [1.20, 1.40], [1.10, 1.20], [0.85, 0.50], [0.75, 0.31]][row(alpha)];
    b * samples as f64 / m as f64 - c
}

fn row(alpha: i32) -> usize {
    (2 - alpha).clamp(0, 4) as usize
}

/// The sum over the second differences of angles of each stretch, which its reflections about both ends extend. Work is of the order of
/// the record.
pub(crate) fn total(Solid { values, runs, .. }: Solid, m: usize) -> Sum {
    let mut sum = Sum::default();
    for run in runs.iter().filter(|run| run.len() > 2 * m) {
        let x = &values[run.clone()];
        let last = x.len() - 1;
        let before = |k: usize| x[k + m] - 2.0 * x[k] + 2.0 * x[0] - x[m - k];
        let after = |k: usize| x[k - m] - 2.0 * x[k] + 2.0 * x[last] - x[2 * last - k - m];
        // A difference about an angle k ≥ m starts at k − m.
        sum.add(second_differences(x, m, 0..x.len() - 2 * m));
        sum.add(in_lanes(m - 1, |i| before(1 + i)));
        sum.add(in_lanes(m - 1, |i| after(last + 1 - m + i)));
    }
    sum
}

/// The sum over stretches of 3m angles of the mean square of 6m modified second differences. A stretch loses its slope and is extended
/// to three times its length by reflection.
///
/// Work is of the order of the record times `m`, up to [`MAX_TERMS`].
pub(crate) fn modified_total(Solid { values, runs, .. }: Solid, m: usize) -> Sum {
    let starts = |run: &Range<usize>| (run.len() + 1).saturating_sub(3 * m);
    let all: usize = runs.iter().map(starts).sum();
    let stride = stride(all, 6 * m, MAX_TERMS);
    let tile = TILE.max(m);
    let tiles: Vec<Range<usize>> = runs
        .iter()
        .flat_map(|run| {
            let end = run.start + starts(run);
            (run.start..end).step_by(tile).map(move |from| from..end.min(from + tile))
        })
        .collect();
    let parts: Vec<Sum> = tiles.par_iter().map(|tile| of_tile(values, tile, m, stride)).collect();
    let mut sum = Sum::default();
    parts.into_iter().for_each(|part| sum.add(part));
    sum
}

/// Distance of starts, each with this number of terms, for which there are at most so many terms.
pub(crate) fn stride(starts: usize, terms: usize, most: u64) -> usize {
    (starts as u64).saturating_mul(terms as u64).div_ceil(most).max(1) as usize
}

fn of_tile(values: &[f64], starts: &Range<usize>, m: usize, stride: usize) -> Sum {
    let length = 3 * m;
    let origin = values[starts.start];
    let mut prefix = Vec::with_capacity(starts.len() + length);
    prefix.push(0.0);
    let mut total = 0.0;
    for x in &values[starts.start..starts.end - 1 + length] {
        total += x - origin;
        prefix.push(total);
    }
    let half = length / 2;
    // Up to the last angle of the terms that are needed.
    let mut integral = vec![0.0; 3 * length + 1];
    let mut sum = Sum::default();
    let first = starts.start.next_multiple_of(stride);
    for start in (first..starts.end).step_by(stride) {
        let p = &prefix[start - starts.start..=start - starts.start + length];
        // The line through the means of both halves, without the middle of an odd number of angles.
        let [early, late] = [p[half] - p[0], p[length] - p[length - half]].map(|sum| sum / half as f64);
        let slope = (late - early) / (length - half) as f64;
        // The sums of the angles without the slope, from the start of the stretch.
        let z = |k: usize| p[k] - p[0] - slope * 0.5 * k as f64 * (k as f64 - 1.0);
        for k in 0..=length {
            let z = z(k);
            integral[length + k] = z;
            integral[length - k] = -z;
        }
        let whole = 2.0 * integral[2 * length];
        for k in length.div_ceil(2)..=length {
            integral[3 * length - k] = whole - integral[length + k];
        }
        let squares = of_period(&integral, m);
        sum.terms += 1;
        sum.squares += squares / (6.0 * m as f64 * m as f64 * m as f64);
    }
    sum
}

/// The sum over 6m terms, a period of the extended stretch with these sums of its angles. Terms at the same distance from the middle of
/// a reflection are equal.
fn of_period(integral: &[f64], m: usize) -> f64 {
    let length = 3 * m;
    let squares = |starts: Range<usize>| third_differences(integral, m, starts).squares;
    let half = |start: usize| {
        let middle =
            if length.is_multiple_of(2) { squares(start + length / 2..start + length / 2 + 1) } else { 0.0 };
        2.0 * squares(start..start + length.div_ceil(2)) + middle
    };
    // Both halves have the terms at their ends, of which all are equal.
    half(0) + half(length) - 2.0 * squares(0..1)
}
