//! Sums of squared differences over a record with gaps, and MTIE, the greatest range of the angle within a time: ITU-T G.810, NIST
//! SP 1065 (5.2.18).
//!
//! The result is the same to the last bit for any number of threads: terms are added in a fixed number of lanes, lanes
//! in tiles of a fixed length, and tiles in groups of a fixed number, all in the order of the record.

use std::cell::OnceCell;
use std::collections::VecDeque;
use std::ops::Range;

use rayon::prelude::*;

use crate::allan::angles::Solid;
use crate::allan::{Angles, Deviation, Trend, theo, total};

/// The sum of the squares of all terms of one deviation at one averaging factor.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sum {
    /// Number of terms.
    pub terms: u64,
    /// Sum of their squares.
    pub squares: f64,
    /// What missing samples add to the squares, as they leave the means of the others less certain; it is not in `squares`.
    pub added: f64,
}

impl Sum {
    pub(crate) fn add(&mut self, other: Sum) {
        self.terms += other.terms;
        self.squares += other.squares;
        self.added += other.added;
    }

    /// The sum less what missing samples add.
    fn without(self, added: f64) -> Sum {
        Sum { squares: self.squares - added, added, ..self }
    }

    /// The part of the estimate that missing samples leave of its degrees of freedom, where it has this part of the terms.
    pub(crate) fn left(&self, terms: usize) -> f64 {
        let part = if self.added > 0.0 { self.squares / (self.squares + self.added) } else { 1.0 };
        self.terms as f64 / terms.max(1) as f64 * part * part
    }
}

/// Independent chains of additions, enough to hide their latency and to fill whole vectors.
const LANES: usize = 8;

/// Terms in a tile, whose angles at all averaging factors stay in the cache.
const TILE: usize = 4096;

/// Tiles whose sums one thread adds up.
const GROUP: usize = 16;

/// Terms of a modified deviation after which its running sum is restarted, so that rounding does not accumulate.
const RESTART: usize = 1 << 16;

/// Places at which terms may start, and the end of the stretch that contains them.
struct Tile {
    starts: Range<usize>,
    run_end: usize,
}

/// The sums of a deviation at each of `factors`, all ≥ 1, over all terms that touch no gap.
///
/// Where missing increments leave few of these terms, means over the increments that are known, at least half of each, take the
/// place of whole ones. A missing increment makes such a mean less certain as white noise does. What that adds to the squares
/// follows from the scatter of the increments about their neighbourhood, and is taken off. Modified deviations bridge short
/// gaps instead.
///
/// Deviations that are not of differences bridge all short gaps, and are freed of what bridges add to white noise, except MTIE.
pub fn sums(angles: &Angles, deviation: Deviation, factors: &[usize]) -> Vec<Sum> {
    let each = |sum: fn(Solid, usize) -> Sum| {
        let of_factor = |&m: &usize| sum(angles.bridged(), m);
        let sums: Vec<Sum> = factors.iter().map(of_factor).collect();
        let Some(known) = angles.known() else { return sums };
        let (scatter, white) = (angles.scatter(), white(known));
        let freed = |(found, &m): (Sum, &usize)| found.without(scatter * added_to_white(&white, m, sum));
        sums.into_iter().zip(factors).map(freed).collect()
    };
    match deviation {
        Deviation::Totdev => each(total::total),
        Deviation::Mtotdev => each(total::modified_total),
        Deviation::Theo1 => each(theo::theo1),
        Deviation::Theoh => factors
            .iter()
            .map(|&m| {
                let (deviation, m) = deviation.at(m, angles.len());
                sums(angles, deviation, &[m])[0]
            })
            .collect(),
        Deviation::Pdev => each(parabolic),
        Deviation::Mtie => mtie(angles.bridged(), factors),
        _ => of_differences(angles, deviation, factors),
    }
}

fn of_differences(angles: &Angles, deviation: Deviation, factors: &[usize]) -> Vec<Sum> {
    let whole = match deviation.is_modified() {
        true => {
            let solid = Solid { values: angles.values(), runs: &angles.solid_runs(), share: 1.0 };
            factors.iter().map(|&m| modified(solid, m)).collect()
        }
        false => plain(angles, deviation, factors),
    };
    if angles.missing() == 0 {
        return whole;
    }
    let (scatter, share) = (angles.scatter(), angles.share());
    let simulated = OnceCell::new();
    let of_factor = |(sum, &m): (Sum, &usize)| {
        let has_few = sum.left(deviation.terms(angles.len(), m)) < FEW.min(share * share);
        match (has_few, deviation.is_modified(), angles.known()) {
            (true, false, Some(known)) => partly_known(angles, known, deviation, m, scatter),
            (true, true, Some(known)) => {
                let sum = modified(angles.bridged(), m);
                sum.without(scatter * added_to_white(simulated.get_or_init(|| white(known)), m, modified))
            }
            (true, true, None) => modified(angles.bridged(), m),
            _ => sum,
        }
    };
    whole.into_iter().zip(factors).map(of_factor).collect()
}

/// Part of the terms that gaps must leave for the others to be left out.
const FEW: f64 = 0.25;

/// The sum over the terms whose means have at least half of their increments.
fn partly_known(angles: &Angles, known: &[u32], deviation: Deviation, m: usize, scatter: f64) -> Sum {
    let x = angles.values();
    let weights: &[f64] = if deviation.differences() == 2 { &[-1.0, 1.0] } else { &[1.0, -2.0, 1.0] };
    let stride = if deviation.overlaps() { 1 } else { m };
    let term = |k: usize| {
        let (mut d, mut added) = (0.0, 0.0);
        for (i, weight) in weights.iter().enumerate() {
            let (from, to) = (k + i * m, k + (i + 1) * m);
            let count = known[to] - known[from];
            if 2 * u64::from(count) < m as u64 || count == 0 {
                return None;
            }
            let times = m as f64 / f64::from(count);
            d += weight * times * (x[to] - x[from]);
            added += weight * weight * (times - 1.0) * m as f64 * scatter;
        }
        Some((d * d, added))
    };
    let terms = deviation.terms(angles.len(), m);
    let of_tile = |tile: usize| {
        let mut sum = Sum::default();
        for (square, added) in (tile * TILE..((tile + 1) * TILE).min(terms)).filter_map(|j| term(j * stride))
        {
            sum.add(Sum { terms: 1, squares: square - added, added });
        }
        sum
    };
    let parts: Vec<Sum> = (0..terms.div_ceil(TILE)).into_par_iter().map(of_tile).collect();
    let mut sum = Sum::default();
    parts.into_iter().for_each(|part| sum.add(part));
    sum
}

/// White noise of variance 1, whole and with the gaps of a record.
fn white(known: &[u32]) -> [Angles; 2] {
    // The minimal generator of Park and Miller; uniform numbers have a variance of 1/12.
    let states = std::iter::successors(Some(987_654_321_u64), |n| Some(16_807 * n % 2_147_483_647));
    let whole: Vec<f64> =
        states.take(known.len() - 1).map(|n| libm::sqrt(12.0) * (n as f64 / 2_147_483_647.0 - 0.5)).collect();
    let is_known = |i: usize| known[i + 1] > known[i];
    let gapped: Vec<f64> =
        whole.iter().enumerate().map(|(i, x)| if is_known(i) { *x } else { f64::NAN }).collect();
    [whole, gapped].map(|x| Angles::from_increments(&x, 1.0, 1.0, Trend::None))
}

/// What bridges add to the `sum` of white noise of variance 1.
fn added_to_white([whole, gapped]: &[Angles; 2], m: usize, sum: fn(Solid, usize) -> Sum) -> f64 {
    let bridged = gapped.bridged();
    let whole = Solid { values: whole.values(), ..bridged };
    sum(bridged, m).squares - sum(whole, m).squares
}

/// The sums of an unmodified deviation, computed tile by tile at all factors, since these share most of their angles.
fn plain(angles: &Angles, deviation: Deviation, factors: &[usize]) -> Vec<Sum> {
    let tiles = tiles(angles.runs(), TILE);
    let (x, unknown) = (angles.values(), angles.has_unknown());
    let of_tile = |tile: &Tile, m: usize| {
        let end = (tile.run_end + 1).saturating_sub(deviation.span(m)).min(tile.starts.end);
        let starts = tile.starts.start..end;
        match (deviation.differences(), deviation.overlaps(), unknown) {
            (2, true, false) => second_differences(x, m, starts),
            (_, true, false) => third_differences(x, m, starts),
            (2, overlaps, _) => each(starts, if overlaps { 1 } else { m }, |k| second(x, m, k)),
            (_, overlaps, _) => each(starts, if overlaps { 1 } else { m }, |k| third(x, m, k)),
        }
    };
    let groups: Vec<Vec<Sum>> = tiles
        .par_chunks(GROUP)
        .map(|group| {
            let mut sums = vec![Sum::default(); factors.len()];
            for tile in group {
                for (sum, &m) in sums.iter_mut().zip(factors) {
                    sum.add(of_tile(tile, m));
                }
            }
            sums
        })
        .collect();
    let mut sums = vec![Sum::default(); factors.len()];
    for group in groups {
        sums.iter_mut().zip(group).for_each(|(sum, part)| sum.add(part));
    }
    sums
}

fn tiles(runs: &[Range<usize>], length: usize) -> Vec<Tile> {
    let of_run = |run: &Range<usize>| {
        let (start, run_end) = (run.start, run.end);
        (start..run_end)
            .step_by(length)
            .map(move |from| Tile { starts: from..(from + length).min(run_end), run_end })
    };
    runs.iter().flat_map(of_run).collect()
}

fn second(x: &[f64], m: usize, k: usize) -> f64 {
    x[k + 2 * m] - 2.0 * x[k + m] + x[k]
}

fn third(x: &[f64], m: usize, k: usize) -> f64 {
    x[k + 3 * m] - 3.0 * x[k + 2 * m] + 3.0 * x[k + m] - x[k]
}

/// Sum over the terms at the multiples of `stride` among `starts`, without those that need an unknown angle.
fn each(starts: Range<usize>, stride: usize, term: impl Fn(usize) -> f64) -> Sum {
    let first = starts.start.next_multiple_of(stride);
    let mut sum = Sum::default();
    for k in (first..starts.end).step_by(stride) {
        let d = term(k);
        if !d.is_nan() {
            sum.terms += 1;
            sum.squares += d * d;
        }
    }
    sum
}

/// Overlapping terms x(k + 2m) − 2x(k + m) + x(k), all angles known.
pub(crate) fn second_differences(x: &[f64], m: usize, starts: Range<usize>) -> Sum {
    if starts.is_empty() {
        return Sum::default();
    }
    let at = |shift: usize| &x[starts.start + shift..starts.end + shift];
    let (a, b, c) = (at(0), at(m), at(2 * m));
    in_lanes(starts.len(), |k| c[k] - 2.0 * b[k] + a[k])
}

/// Overlapping terms x(k + 3m) − 3x(k + 2m) + 3x(k + m) − x(k), all angles known.
pub(crate) fn third_differences(x: &[f64], m: usize, starts: Range<usize>) -> Sum {
    if starts.is_empty() {
        return Sum::default();
    }
    let at = |shift: usize| &x[starts.start + shift..starts.end + shift];
    let (a, b, c, d) = (at(0), at(m), at(2 * m), at(3 * m));
    in_lanes(starts.len(), |k| d[k] - 3.0 * c[k] + 3.0 * b[k] - a[k])
}

#[inline(always)]
pub(crate) fn in_lanes(count: usize, term: impl Fn(usize) -> f64) -> Sum {
    let mut lanes = [0.0; LANES];
    let whole = count - count % LANES;
    for start in (0..whole).step_by(LANES) {
        for (lane, sum) in lanes.iter_mut().enumerate() {
            let d = term(start + lane);
            *sum += d * d;
        }
    }
    for (lane, k) in (whole..count).enumerate() {
        let d = term(k);
        lanes[lane] += d * d;
    }
    Sum { terms: count as u64, squares: lanes.iter().sum(), added: 0.0 }
}

/// Sum over the terms of the modified deviation, the second differences of means over m angles, by running sums.
fn modified(Solid { values: x, runs, .. }: Solid, m: usize) -> Sum {
    // A tile shorter than m would spend most of its time on its first sum.
    let parts: Vec<Sum> = tiles(runs, RESTART.max(m))
        .par_iter()
        .map(|tile| {
            let end = (tile.run_end + 1).saturating_sub(3 * m).min(tile.starts.end);
            running(x, m, tile.starts.start..end)
        })
        .collect();
    let mut sum = Sum::default();
    parts.into_iter().for_each(|part| sum.add(part));
    sum
}

/// Sum over the squares of s(j) = Σ over i of x(j + 2m + i) − 2x(j + m + i) + x(j + i), i = 0 … m − 1.
fn running(x: &[f64], m: usize, starts: Range<usize>) -> Sum {
    if starts.is_empty() {
        return Sum::default();
    }
    let mut s: f64 = (starts.start..starts.start + m).map(|i| second(x, m, i)).sum();
    let scale = 1.0 / m as f64;
    let mut squares = (s * scale) * (s * scale);
    for j in starts.start..starts.end - 1 {
        s += x[j + 3 * m] - 3.0 * x[j + 2 * m] + 3.0 * x[j + m] - x[j];
        squares += (s * scale) * (s * scale);
    }
    Sum { terms: starts.len() as u64, squares, added: 0.0 }
}

/// Starts after which the running sums of a parabolic deviation are restarted, as their rounding grows with the power 3/2.
const RESTART_OF_LINES: usize = 1024;

/// Sum over the terms of the parabolic deviation, scaled to second differences: each is the difference of the slopes of the
/// least-squares lines through the angles of two neighbouring groups.
///
/// F. Vernotte, M. Lenczner, P.-Y. Bourgeois, E. Rubiola, "The parabolic variance (PVAR), a wavelet variance based on the least-square
/// fit", IEEE Trans. UFFC 63 (2016), with the number of terms of Vernotte et al., "Response and uncertainty of the parabolic variance
/// PVAR to noninteger exponents of the power law", IEEE Trans. UFFC 67 (2020). At m = 1 it is the Allan variance.
fn parabolic(Solid { values: x, runs, .. }: Solid, m: usize) -> Sum {
    let parts: Vec<Sum> = tiles(runs, RESTART_OF_LINES.max(m))
        .par_iter()
        .map(|tile| {
            let end = tile.run_end.saturating_sub(2 * m).min(tile.starts.end);
            let starts = tile.starts.start..end;
            if m == 1 { second_differences(x, 1, starts) } else { of_lines(x, m, starts, |_| {}) }
        })
        .collect();
    let mut sum = Sum::default();
    parts.into_iter().for_each(|part| sum.add(part));
    sum
}

/// Sum over the squares of s(j) = 12/m² Σ over i of ((m − 1)/2 − i)(x(j + i) − x(j + m + i)), i = 0 … m − 1, each of which `take` sees.
pub(crate) fn of_lines(x: &[f64], m: usize, starts: Range<usize>, mut take: impl FnMut(f64)) -> Sum {
    if starts.is_empty() {
        return Sum::default();
    }
    // A common offset of the differences cancels, and would cost digits.
    let offset = x[starts.start + m] - x[starts.start];
    let difference = |k: usize| x[k + m] - x[k] - offset;
    let of_first = |i: usize| difference(starts.start + i);
    let mut plain: f64 = (0..m).map(of_first).sum();
    let mut weighted: f64 = (0..m).map(|i| i as f64 * of_first(i)).sum();
    let (middle, scale) = (0.5 * (m as f64 - 1.0), 12.0 / (m as f64 * m as f64));
    let mut squares = 0.0;
    for j in starts.clone() {
        let s = scale * (weighted - middle * plain);
        squares += s * s;
        take(s);
        if j + 1 < starts.end {
            plain += difference(j + m) - difference(j);
            weighted += m as f64 * difference(j + m) - plain;
        }
    }
    Sum { terms: starts.len() as u64, squares, added: 0.0 }
}

/// Times that a step from all windows to those that are longer by one takes less work than the windows of one length from the start.
const DENSE: usize = 8;

/// Windows that are made longer together: their greatest and least values stay in the nearest memory of the processor.
const TOGETHER: usize = 1024;

/// Windows whose ranges are compared at once.
const WINDOWS: usize = 8;

/// The square of the greatest range over all windows of m + 1 angles, with their number. Work is of the order of the record for each
/// `m`; where most `m` are asked for, all windows grow by one angle at a time, which is faster by an order of magnitude.
pub(super) fn mtie(Solid { values, runs, .. }: Solid, factors: &[usize]) -> Vec<Sum> {
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
        let mut found = [ranges[m]; WINDOWS];
        let whole = count - count % WINDOWS;
        for at in (0..whole).step_by(WINDOWS) {
            let (above, below) = (&mut above[at..at + WINDOWS], &mut below[at..at + WINDOWS]);
            let added = &added[at..at + WINDOWS];
            for lane in 0..WINDOWS {
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

    /// White noise from the generator of the NBS sets.
    pub(super) fn noise(count: usize) -> Vec<f64> {
        let mut n: u64 = 1_234_567_890;
        let mut next = || {
            n = 16807 * n % 2_147_483_647;
            n as f64 / 2_147_483_647.0 - 0.5
        };
        (0..count).map(|_| next()).collect()
    }

    /// Sums every term by its definition, without those for which any increment (or angle) is missing; these are all terms at
    /// averaging factors that gaps hardly affect.
    fn by_definition(increments: &[f64], deviation: Deviation, m: usize) -> (u64, f64) {
        let d = deviation.differences();
        let (mut terms, mut squares) = (0, 0.0);
        let stride = if deviation.overlaps() { 1 } else { m };
        let span = if deviation.is_modified() { 3 * m - 1 } else { d * m };
        for k in (0..).step_by(stride).take_while(|k| k + span <= increments.len()) {
            if increments[k..k + span].iter().any(|y| y.is_nan()) {
                continue;
            }
            let angle = |i: usize| increments[k..k + i].iter().sum::<f64>();
            let difference = |i: usize| match d {
                2 => angle(i + 2 * m) - 2.0 * angle(i + m) + angle(i),
                _ => angle(i + 3 * m) - 3.0 * angle(i + 2 * m) + 3.0 * angle(i + m) - angle(i),
            };
            let means = if deviation.is_modified() { m } else { 1 };
            let term = (0..means).map(difference).sum::<f64>() / means as f64;
            terms += 1;
            squares += term * term;
        }
        (terms, squares)
    }

    #[test]
    fn sums_are_those_of_the_definition_with_and_without_gaps() {
        let whole = noise(200);
        let mut gapped = whole.clone();
        for gap in [0, 17, 90, 91, 92, 199] {
            gapped[gap] = f64::NAN;
        }
        for increments in [whole, gapped] {
            let angles = Angles::from_increments(&increments, 1.0, 1.0, Trend::None);
            for deviation in Deviation::ALL.into_iter().filter(|deviation| deviation.is_of_differences()) {
                let factors: Vec<usize> = (1..=deviation.largest_factor(angles.len())).collect();
                for (sum, &m) in sums(&angles, deviation, &factors).iter().zip(&factors) {
                    let (terms, squares) = by_definition(&increments, deviation, m);
                    if (terms as f64) < FEW * deviation.terms(angles.len(), m) as f64 {
                        continue;
                    }
                    assert_eq!(sum.terms, terms, "{deviation}, m = {m}");
                    assert!(
                        (sum.squares - squares).abs() <= 1e-10 * squares,
                        "{deviation}, m = {m}: {} not {squares}",
                        sum.squares
                    );
                }
            }
        }
    }

    #[test]
    fn a_missing_angle_leaves_out_only_the_terms_that_need_it() {
        let mut angles: Vec<f64> = noise(50);
        let whole = Angles::from_angles(&angles, 1.0, 1.0, Trend::None);
        angles[20] = f64::NAN;
        let gapped = Angles::from_angles(&angles, 1.0, 1.0, Trend::None);
        let terms = |angles: &Angles, deviation, m| sums(angles, deviation, &[m])[0].terms;
        for (deviation, fewer) in [(Deviation::Oadev, 3), (Deviation::Ohdev, 4), (Deviation::Mdev, 9)] {
            assert_eq!(
                terms(&gapped, deviation, 3) + fewer,
                terms(&whole, deviation, 3),
                "{deviation} at m = 3"
            );
        }
    }

    #[test]
    fn records_longer_than_a_tile_give_the_sums_of_short_ones() {
        // The record has a period of 5 samples, so each term's square repeats and the sum over whole periods is known.
        let increments: Vec<f64> = (0..5 * 40_000).map(|i| [3.0, -1.0, 2.0, -4.0, 0.0][i % 5]).collect();
        let angles = Angles::from_increments(&increments, 1.0, 1.0, Trend::None);
        for deviation in [Deviation::Oadev, Deviation::Mdev, Deviation::Ohdev] {
            for m in [1, 2, 7, 30_001] {
                let sum = sums(&angles, deviation, &[m])[0];
                // Shifts by whole periods change nothing.
                let short = if m > 10 { m % 5 } else { m };
                if deviation.is_modified() && m > 10 {
                    continue;
                }
                let one = sums(&angles, deviation, &[short])[0];
                let [per_term, expected] = [sum, one].map(|s| s.squares / s.terms as f64);
                assert!((per_term / expected - 1.0).abs() < 1e-4, "{deviation}, m = {m}: {per_term}");
            }
        }
    }

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
