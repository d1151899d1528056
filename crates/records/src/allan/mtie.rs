//! MTIE, the greatest range of the angle within a time: ITU-T G.810, NIST SP 1065 (5.2.18).

use std::collections::VecDeque;
use std::ops::Range;

use rayon::prelude::*;

use crate::allan::angles::Solid;
use crate::allan::sums::Sum;

/// The square of the greatest range over all windows of m + 1 angles, with their number. Work is of the order of the record for each
/// `m`.
pub(crate) fn mtie(Solid { values, runs, .. }: Solid, factors: &[usize]) -> Vec<Sum> {
    let of_factor = |&m: &usize| {
        let windows = |run: &Range<usize>| run.len().saturating_sub(m);
        let ranges = runs.iter().filter(|run| windows(run) > 0).map(|run| range(&values[run.clone()], m + 1));
        let greatest = ranges.fold(0.0, f64::max);
        let terms = runs.iter().map(windows).sum::<usize>() as u64;
        Sum { terms, squares: greatest * greatest, added: 0.0 }
    };
    factors.par_iter().map(of_factor).collect()
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
