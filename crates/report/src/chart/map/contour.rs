//! Lines along which values on a grid cross a level.

use std::collections::{BTreeMap, BTreeSet};

/// A side of a square of the grid, from the point (column, row) to the right or upwards.
type Side = (usize, usize, Towards);

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Towards {
    Right,
    Up,
}

/// The lines through a grid of points at `xs` and `ys` along which `value` of (column, row) crosses `level`.
///
/// The method is marching squares. A side is crossed where linear interpolation puts the level; a square with two
/// opposite corners above and two below is divided according to the mean of its corners. Squares with an unknown corner
/// have no line.
pub fn contour(
    xs: &[f64],
    ys: &[f64],
    value: impl Fn(usize, usize) -> Option<f64>,
    level: f64,
) -> Vec<Vec<(f64, f64)>> {
    let mut neighbours: BTreeMap<Side, Vec<Side>> = BTreeMap::new();
    for row in 1..ys.len() {
        for column in 1..xs.len() {
            for (a, b) in crossings(column - 1, row - 1, &value, level) {
                neighbours.entry(a).or_default().push(b);
                neighbours.entry(b).or_default().push(a);
            }
        }
    }
    let place = |(column, row, towards): Side| {
        let (next_column, next_row) = beyond((column, row, towards));
        let ends = [value(column, row), value(next_column, next_row)].map(|value| value.unwrap_or(level));
        let part = (level - ends[0]) / (ends[1] - ends[0]);
        let between = |a: f64, b: f64| a + (b - a) * part;
        (between(xs[column], xs[next_column]), between(ys[row], ys[next_row]))
    };
    // Lines with ends come first; the rest are rings.
    let ends = neighbours.iter().filter(|(_, others)| others.len() == 1);
    let starts: Vec<Side> = ends.chain(neighbours.iter()).map(|(side, _)| *side).collect();
    let mut seen = BTreeSet::new();
    let mut lines = vec![];
    for start in starts {
        let (mut line, mut next) = (vec![], (!seen.contains(&start)).then_some(start));
        while let Some(side) = next {
            seen.insert(side);
            line.push(side);
            next = neighbours[&side].iter().copied().find(|other| !seen.contains(other));
        }
        let ring = line.len() > 2 && line.last().is_some_and(|last| neighbours[last].contains(&start));
        line.extend(ring.then_some(start));
        if line.len() > 1 {
            lines.push(line.into_iter().map(place).collect());
        }
    }
    lines
}

/// The point at the other end of a side.
fn beyond((column, row, towards): Side) -> (usize, usize) {
    match towards {
        Towards::Right => (column + 1, row),
        Towards::Up => (column, row + 1),
    }
}

/// The sides connected by the level in the square above and to the right of a point.
fn crossings(
    column: usize,
    row: usize,
    value: &impl Fn(usize, usize) -> Option<f64>,
    level: f64,
) -> Vec<(Side, Side)> {
    let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(right, up)| value(column + right, row + up));
    let [Some(a), Some(b), Some(c), Some(d)] = corners else {
        return vec![];
    };
    let above = [a, b, c, d].map(|corner| corner > level);
    let bottom = (column, row, Towards::Right);
    let right = (column + 1, row, Towards::Up);
    let top = (column, row + 1, Towards::Right);
    let left = (column, row, Towards::Up);
    let crossed: Vec<Side> = [bottom, right, top, left]
        .into_iter()
        .enumerate()
        .filter(|(side, _)| above[*side] != above[(side + 1) % 4])
        .map(|(_, side)| side)
        .collect();
    match crossed[..] {
        [one, other] => vec![(one, other)],
        // The corners a and c, or b and d, are isolated on their sides.
        [_, _, _, _] if above[0] == ((a + b + c + d) / 4.0 > level) => vec![(bottom, right), (top, left)],
        [_, _, _, _] => vec![(left, bottom), (right, top)],
        _ => vec![],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(rows: &[&[f64]], level: f64) -> Vec<Vec<(f64, f64)>> {
        let xs: Vec<f64> = (0..rows[0].len()).map(|x| x as f64).collect();
        let ys: Vec<f64> = (0..rows.len()).map(|y| y as f64).collect();
        contour(&xs, &ys, |column, row| Some(rows[row][column]).filter(|value| value.is_finite()), level)
    }

    #[test]
    fn a_slope_is_crossed_by_one_line_where_it_reaches_the_level() {
        let lines = grid(&[&[0.0, 1.0, 4.0], &[0.0, 1.0, 4.0], &[0.0, 1.0, 4.0]], 2.5);
        assert_eq!(lines, [[(1.5, 0.0), (1.5, 1.0), (1.5, 2.0)]]);
    }

    #[test]
    fn a_peak_has_a_closed_ring() {
        let lines = grid(&[&[0.0; 3], &[0.0, 1.0, 0.0], &[0.0; 3]], 0.5);
        assert_eq!((lines.len(), lines[0].len()), (1, 5));
        assert_eq!(lines[0].first(), lines[0].last());
    }

    #[test]
    fn a_saddle_is_divided_by_its_mean_and_lines_never_branch() {
        let apart = grid(&[&[1.0, 0.0], &[0.0, 1.0]], 0.6);
        let joined = grid(&[&[1.0, 0.0], &[0.0, 1.0]], 0.4);
        let round = |lines: &[Vec<(f64, f64)>]| -> Vec<Vec<(f64, f64)>> {
            let tenths = |x: f64| (x * 10.0).round() / 10.0;
            lines.iter().map(|line| line.iter().map(|(x, y)| (tenths(*x), tenths(*y))).collect()).collect()
        };
        assert_eq!(round(&apart), [[(0.4, 0.0), (0.0, 0.4)], [(0.6, 1.0), (1.0, 0.6)]]);
        assert_eq!(round(&joined), [[(0.6, 0.0), (1.0, 0.4)], [(0.0, 0.6), (0.4, 1.0)]]);
    }

    #[test]
    fn unknown_values_break_a_line_and_a_level_that_is_not_reached_has_none() {
        let lines = grid(&[&[0.0, 1.0], &[0.0, f64::NAN], &[0.0, 1.0], &[0.0, 1.0]], 0.5);
        assert_eq!(lines, [[(0.5, 2.0), (0.5, 3.0)]]);
        assert!(grid(&[&[0.0, 1.0], &[0.0, 1.0]], 2.0).is_empty());
        assert!(grid(&[&[1.0]], 0.5).is_empty());
    }
}
