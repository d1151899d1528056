//! Ticks of a random motion as rows of numbers whose products are the covariances of the ticks: the angle of a tick is its
//! row times independent numbers of variance 1.
//!
//! The covariance matrix of many ticks of a narrow band is singular in 53 bits, and a factor computed from it is wrong by
//! orders of magnitude in the differences that matter: the errors of fillers. So that of a spectrum is never formed. Its
//! rows consist of its lines, and orthogonal transformations, which lose nothing, shorten them to a triangle.

use crate::gap::tick_phase;
use crate::lines::TickLine;

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
    use crate::lines::covariance;

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
