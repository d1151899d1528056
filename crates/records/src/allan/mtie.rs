//! MTIE, the greatest range of the angle within a time: ITU-T G.810, NIST SP 1065 (5.2.18).

use std::collections::VecDeque;
use std::ops::Range;

use rayon::prelude::*;

use crate::allan::angles::Solid;
use crate::allan::sums::Sum;

/// Times that a step from all windows to those that are longer by one takes less work than the windows of one length from the start.
const DENSE: usize = 8;

/// Windows that are made longer together: their greatest and least values stay in the nearest memory of the processor.
const TOGETHER: usize = 1024;

/// Windows whose ranges are compared at once.
const LANES: usize = 8;

/// The square of the greatest range over all windows of m + 1 angles, with their number. Work is of the order of the record for each
/// `m`; where most `m` are asked for, all windows grow by one angle at a time, which is faster by an order of magnitude.
pub(crate) fn mtie(Solid { values, runs, .. }: Solid, factors: &[usize]) -> Vec<Sum> {
    let largest = factors.iter().copied().max().unwrap_or(0);
    let ranges: Vec<f64> = match DENSE * factors.len() > largest {
        true => {
            let all = ranges(values, runs, largest);
            factors.iter().map(|&m| all[m]).collect()
        }
        false => factors.par_iter().map(|&m| greatest(values, runs, m)).collect(),
    };
    let of_factor = |(&m, greatest): (&usize, f64)| {
        let terms = runs.iter().map(|run| run.len().saturating_sub(m)).sum::<usize>() as u64;
        Sum { terms, squares: greatest * greatest, added: 0.0 }
    };
    factors.iter().zip(ranges).map(of_factor).collect()
}

/// The greatest range in any window of m + 1 angles within a run.
fn greatest(values: &[f64], runs: &[Range<usize>], m: usize) -> f64 {
    let long = runs.iter().filter(|run| run.len() > m);
    long.map(|run| range(&values[run.clone()], m + 1)).fold(0.0, f64::max)
}

/// The greatest ranges in all windows of m + 1 angles within a run, for each m up to the largest.
fn ranges(values: &[f64], runs: &[Range<usize>], largest: usize) -> Vec<f64> {
    let starts = runs.iter().flat_map(|run| run.clone().step_by(TOGETHER).map(|start| (start, run.end)));
    let none = || vec![0.0; largest + 1];
    let grown = |mut all: Vec<f64>, (start, end): (usize, usize)| {
        grow(&values[start..end], &mut all);
        all
    };
    let larger = |a: Vec<f64>, b: Vec<f64>| a.into_iter().zip(b).map(|(a, b)| f64::max(a, b)).collect();
    starts.collect::<Vec<_>>().into_par_iter().fold(none, grown).reduce(none, larger)
}

/// Raises each of `ranges` to the greatest range in the windows of that many further values whose first value is among the first
/// [`TOGETHER`] of `x`.
fn grow(x: &[f64], ranges: &mut [f64]) {
    let first = &x[..TOGETHER.min(x.len())];
    let (mut above, mut below) = (first.to_vec(), first.to_vec());
    for m in 1..ranges.len().min(x.len()) {
        let count = first.len().min(x.len() - m);
        // Comparisons as the processor has them; there is no NaN in a run.
        let max = |a: f64, b: f64| if a > b { a } else { b };
        let min = |a: f64, b: f64| if a < b { a } else { b };
        let (above, below, added) = (&mut above[..count], &mut below[..count], &x[m..m + count]);
        let mut found = [ranges[m]; LANES];
        let whole = count - count % LANES;
        for at in (0..whole).step_by(LANES) {
            let (above, below) = (&mut above[at..at + LANES], &mut below[at..at + LANES]);
            let added = &added[at..at + LANES];
            for lane in 0..LANES {
                above[lane] = max(above[lane], added[lane]);
                below[lane] = min(below[lane], added[lane]);
                found[lane] = max(found[lane], above[lane] - below[lane]);
            }
        }
        for at in whole..count {
            above[at] = max(above[at], added[at]);
            below[at] = min(below[at], added[at]);
            found[0] = max(found[0], above[at] - below[at]);
        }
        ranges[m] = found.into_iter().fold(0.0, max);
    }
}

/// The greatest range of `x` in any window of `length` values.
fn range(x: &[f64], length: usize) -> f64 {
    // The places of values that no later one in the window exceeds, in falling order; the first is that of the maximum.
    let (mut above, mut below): (VecDeque<usize>, VecDeque<usize>) = Default::default();
    let mut greatest = 0.0;
    for (i, value) in x.iter().enumerate() {
        push(&mut above, i, length, |place| x[place] <= *value);
        push(&mut below, i, length, |place| x[place] >= *value);
        greatest = f64::max(greatest, x[above[0]] - x[below[0]]);
    }
    greatest
}

/// Adds place `i` behind those that it does not supersede, and drops that which leaves the window.
fn push(places: &mut VecDeque<usize>, i: usize, length: usize, is_superseded: impl Fn(usize) -> bool) {
    while places.back().is_some_and(|place| is_superseded(*place)) {
        places.pop_back();
    }
    places.push_back(i);
    if places[0] + length <= i {
        places.pop_front();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_that_grow_have_the_ranges_of_those_of_each_length() {
        let mut angle = 0.0;
        let step = |i: u32| {
            angle += libm::sin(f64::from(i * i % 7919)) + 0.3 * libm::sin(0.01 * f64::from(i));
            angle
        };
        let values: Vec<f64> = (0..3000).map(step).collect();
        let runs = [3..1800, 1805..1806, 1810..3000];
        let solid = || Solid { values: &values, runs: &runs, share: 1.0 };
        let all: Vec<usize> = (1..2000).collect();
        for (found, m) in mtie(solid(), &all).into_iter().zip(all) {
            let alone = greatest(&values, &runs, m);
            assert_eq!((found.squares, m), (alone * alone, m));
        }
    }
}
