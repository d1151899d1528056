//! Lines along which values on a grid cross a level, and the limit on a heat map, which is such a line.

use std::collections::{BTreeMap, BTreeSet};

use crate::chart::canvas::{Canvas, Lettering, Set, Stroke};
use crate::chart::figure::Limit;
use crate::chart::layout::{self, Area, Frame};
use crate::chart::map::Map;
use crate::chart::palette::LIMIT;

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

const LABEL_SIZE: f64 = 13.0;
/// Strokes of the line: red on white, visible over dark and light colours.
const LIMIT_LINES: [Stroke; 2] =
    [Stroke { colour: "#ffffff", width: 5.0, dash: "" }, Stroke { colour: LIMIT, width: 2.2, dash: "" }];

/// Draws the line with its label. It runs between the centres of the cells, on the scale of the values; from the
/// outermost centres to the frame the values are extrapolated.
pub fn draw_limit(canvas: &mut Canvas, map: &Map, area: &Area, limit: &Limit) {
    if !map.z.scale.shows(limit.value) {
        return;
    }
    let Frame { left, top, right, bottom } = area.frame;
    let columns = map.columns.iter().map(|x| area.across(*x));
    let across: Vec<f64> = std::iter::once(left).chain(columns).chain([right]).collect();
    let rows = map.rows.iter().map(|y| area.down(*y));
    let down: Vec<f64> = std::iter::once(bottom).chain(rows).chain([top]).collect();
    let values = map.values();
    let known = |column: usize, row: usize| -> Option<f64> {
        let value = values.get(row * map.columns.len() + column).copied().flatten();
        value.map(|value| map.z.scale.coordinate(value))
    };
    let level = map.z.scale.coordinate(limit.value);
    let value = |column: usize, row: usize| {
        let across_in = |row: usize| value_at(&across, column, level, |column| known(column, row));
        value_at(&down, row, level, across_in)
    };
    let lines = contour(&across, &down, value, level);
    canvas.group(&limit.label, |canvas| lines.iter().for_each(|line| draw_line(canvas, line)));
    draw_label(canvas, &lines, area.frame, &limit.label);
}

/// The value at one of the `places` along an axis: the centres of cells, of which `of` gives the values, between the
/// two ends of the frame. At the ends it is extrapolated along the straight line through the two outermost cells, but
/// not across the `level`, because noise would then create additional lines.
fn value_at(places: &[f64], point: usize, level: f64, of: impl Fn(usize) -> Option<f64>) -> Option<f64> {
    let cells = places.len() - 2;
    let (outer, inner) = match point {
        0 => (0, 1),
        _ if point > cells => (cells.checked_sub(1)?, cells.saturating_sub(2)),
        _ => return of(point - 1),
    };
    let outermost = of(outer)?;
    let Some(next) = of(inner).filter(|_| outer != inner && inner < cells) else {
        return Some(outermost);
    };
    let at = |cell: usize| places[cell + 1];
    let continued = outermost + (outermost - next) * (places[point] - at(outer)) / (at(outer) - at(inner));
    Some(if (continued > level) == (outermost > level) { continued } else { outermost })
}

/// Draws a stretch of the limit.
pub fn draw_line(canvas: &mut Canvas, places: &[(f64, f64)]) {
    LIMIT_LINES.into_iter().for_each(|stroke| canvas.line(places, stroke));
}

/// Writes the label next to the longest line, within the frame, where it covers the fewest lines.
fn draw_label(canvas: &mut Canvas, lines: &[Vec<(f64, f64)>], frame: Frame, label: &str) {
    let Frame { left, top, right, bottom } = frame;
    let label = layout::fitted_text(label, LABEL_SIZE, true, right - left - 16.0);
    let width = layout::text_width(&label, LABEL_SIZE, true);
    let dense: Vec<Vec<(f64, f64)>> = lines.iter().map(|line| densely(line)).collect();
    let Some(longest) = dense.iter().max_by_key(|line| line.len()) else {
        return;
    };
    let covered = |(x, y): (f64, f64)| {
        let near = |&&(px, py): &&(f64, f64)| {
            (x - 5.0..x + width + 5.0).contains(&px) && (y - LABEL_SIZE - 1.0..y + 7.0).contains(&py)
        };
        dense.iter().flatten().filter(near).count()
    };
    let within = |(x, y): &(f64, f64)| {
        *x > left + 6.0 && x + width < right - 6.0 && *y > top + LABEL_SIZE + 6.0 && *y < bottom - 8.0
    };
    // Places near the middle of the line come first, on either side of it.
    let middle = longest.len() / 2;
    let mut beside: Vec<usize> = (0..longest.len()).collect();
    beside.sort_by_key(|place| place.abs_diff(middle));
    let places = beside.into_iter().flat_map(|place| {
        let (x, y) = longest[place];
        [(x + 9.0, y - 7.0), (x - width - 9.0, y - 7.0), (x + 9.0, y + 17.0), (x - width - 9.0, y + 17.0)]
    });
    if let Some(place) = places.filter(within).min_by_key(|place| covered(*place)) {
        let lettering = Lettering { size: LABEL_SIZE, bold: true, colour: LIMIT, anchor: "start" };
        canvas.set_text(Set::OnWhite, place, &label, lettering);
    }
}

/// Places along a line at intervals of a few px.
fn densely(line: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut places = vec![];
    for pair in line.windows(2) {
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        let steps = libm::ceil(libm::hypot(x1 - x0, y1 - y0) / 3.0).max(1.0);
        let at = |step: usize| step as f64 / steps;
        places.extend((0..steps as usize).map(|step| (x0 + (x1 - x0) * at(step), y0 + (y1 - y0) * at(step))));
    }
    places
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

    #[test]
    fn values_go_on_to_the_frame_along_a_straight_line_where_two_are_known() {
        let points = [0.0, 1.0, 3.0, 7.0, 9.0];
        let all = |cell: usize| Some([10.0, 14.0, 22.0][cell]);
        let found: Vec<Option<f64>> = (0..5).map(|point| value_at(&points, point, 12.0, all)).collect();
        assert_eq!(found, [8.0, 10.0, 14.0, 22.0, 26.0].map(Some));
        assert_eq!(
            [0, 4].map(|end| value_at(&points, end, 9.0, all)),
            [Some(10.0), Some(26.0)],
            "not across 9"
        );
        let without = |cell: usize| all(cell).filter(|_| cell != 1);
        let found: Vec<Option<f64>> = (0..5).map(|point| value_at(&points, point, 12.0, without)).collect();
        assert_eq!(found, [Some(10.0), Some(10.0), None, Some(22.0), Some(22.0)]);
        let one = [0.0, 1.0, 2.0];
        assert_eq!([0, 1, 2].map(|point| value_at(&one, point, 12.0, |_| Some(5.0))), [Some(5.0); 3]);
        let none = [0.0, 2.0];
        assert_eq!([0, 1].map(|point| value_at(&none, point, 12.0, |_| None)), [None; 2]);
    }
}
