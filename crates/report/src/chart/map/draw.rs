//! The cells of a map, drawn into the frame of its axes.

use crate::chart::canvas::{Canvas, Colour, Stroke};
use crate::chart::layout::{Area, Frame};
use crate::chart::map::{Cells, Map, Won};
use crate::chart::palette::{self, INK, Shades};
use crate::chart::scale::Range;
use crate::chart::scale::edges;

/// Distance between hatching lines, measured horizontally.
const HATCHING: f64 = 9.0;
/// Style of the hatching of cells beyond the limit.
pub const HATCH: Stroke = Stroke { colour: INK, width: 0.8, dash: "" };
const BOUNDARY: Stroke = Stroke { colour: INK, width: 1.8, dash: "" };

/// The edges of the cells in the picture, from the left and from below; one more than there are columns and rows.
pub struct Edges {
    xs: Vec<f64>,
    ys: Vec<f64>,
}

impl Edges {
    pub fn new(map: &Map, area: &Area) -> Edges {
        let xs = edges(map.x.scale, &map.columns).into_iter().map(|x| area.across(x));
        let ys = edges(map.y.scale, &map.rows).into_iter().map(|y| area.down(y));
        Edges { xs: xs.collect(), ys: ys.collect() }
    }

    /// The upper left and the lower right corner of a cell.
    fn corners(&self, cell: usize) -> ((f64, f64), (f64, f64)) {
        let columns = self.xs.len().saturating_sub(1).max(1);
        let (column, row) = (cell % columns, cell / columns);
        ((self.xs[column], self.ys[row + 1]), (self.xs[column + 1], self.ys[row]))
    }
}

/// Draws the cells: values in the colour of their place on the `range`, winners in their own colour.
pub fn draw_cells(canvas: &mut Canvas, map: &Map, edges: &Edges, (shades, range): (Shades, Range)) {
    let colours: Vec<Option<Colour>> = match &map.cells {
        Cells::Values(values) if map.is_yes_or_no() => {
            let style = |value: f64| if value == 1.0 { 1 } else { 2 };
            values.iter().map(|value| Some(palette::area_colour(style((*value)?)).into())).collect()
        }
        Cells::Values(values) => values
            .iter()
            .map(|value| value.map(|value| shades.colour(range.fraction(value)).into()))
            .collect(),
        Cells::Winners { won, .. } => {
            won.iter().map(|won| Some(winner_colour(won.as_ref()?).into())).collect()
        }
    };
    canvas.crisp_group("cells", |canvas| {
        for (cell, colour) in colours.into_iter().enumerate() {
            let Some(colour) = colour else { continue };
            let (from, to) = edges.corners(cell);
            canvas.block(from, to, colour);
        }
    });
}

/// The colour of a winner, fainter where the next one may be as good.
fn winner_colour(won: &Won) -> &'static str {
    if won.certain { palette::area_colour(won.style) } else { palette::pale(won.style) }
}

/// Hatches the cells whose winner is beyond the limit.
pub fn draw_hatching(canvas: &mut Canvas, edges: &Edges, won: &[Option<Won>], limit: f64) {
    let beyond = |cell: &usize| won[*cell].is_some_and(|won| won.value > limit);
    let cells = (0..won.len()).filter(beyond);
    let lines = cells.flat_map(|cell| {
        let (from, to) = edges.corners(cell);
        hatching(from, to)
    });
    canvas.group("beyond the limit", |canvas| canvas.lines(lines, HATCH));
}

/// Lines at 45° across a rectangle, which continue those of neighbouring rectangles.
pub fn hatching((left, top): (f64, f64), (right, bottom): (f64, f64)) -> Vec<[(f64, f64); 2]> {
    // Each line has a constant sum of x and y.
    let first = libm::ceil((left + top) / HATCHING) as i64;
    let last = libm::floor((right + bottom) / HATCHING) as i64;
    (first..=last)
        .map(|line| line as f64 * HATCHING)
        .map(|sum| {
            let from = left.max(sum - bottom);
            let to = right.min(sum - top);
            [(from, sum - from), (to, sum - to)]
        })
        // Excludes a corner that is only touched.
        .filter(|[from, to]| from.0 < to.0)
        .collect()
}

/// Draws lines between cells of different winners.
pub fn draw_boundaries(canvas: &mut Canvas, edges: &Edges, won: &[Option<Won>]) {
    let columns = edges.xs.len().saturating_sub(1);
    let rows = edges.ys.len().saturating_sub(1);
    let style = |column: usize, row: usize| won[row * columns + column].map(|won| won.style);
    let differ = |a: Option<usize>, b: Option<usize>| a.zip(b).is_some_and(|(a, b)| a != b);
    let mut lines: Vec<[(f64, f64); 2]> = vec![];
    for column in 1..columns {
        let x = edges.xs[column];
        let divided = runs(rows, |row| differ(style(column - 1, row), style(column, row)));
        lines.extend(divided.into_iter().map(|(from, to)| [(x, edges.ys[from]), (x, edges.ys[to])]));
    }
    for row in 1..rows {
        let y = edges.ys[row];
        let divided = runs(columns, |column| differ(style(column, row - 1), style(column, row)));
        lines.extend(divided.into_iter().map(|(from, to)| [(edges.xs[from], y), (edges.xs[to], y)]));
    }
    canvas.group("boundaries", |canvas| canvas.lines(lines, BOUNDARY));
}

/// The stretches of 0 … `count` in which a condition holds, each by its first index and one after the last.
fn runs(count: usize, holds: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = vec![];
    for place in (0..count).filter(|place| holds(*place)) {
        match runs.last_mut().filter(|run| run.1 == place) {
            Some(run) => run.1 = place + 1,
            None => runs.push((place, place + 1)),
        }
    }
    runs
}

/// Draws a closed frame.
pub fn draw_frame(canvas: &mut Canvas, frame: Frame) {
    let Frame { left, top, right, bottom } = frame;
    let line = Stroke { colour: INK, width: 1.1, dash: "" };
    canvas.line(&[(left, top), (right, top), (right, bottom)], line);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hatching_stays_in_its_rectangle_and_goes_on_in_the_next() {
        let [one, next] = [hatching((3.0, 5.5), (31.25, 22.25)), hatching((31.25, 5.5), (50.0, 22.25))];
        for [(x0, y0), (x1, y1)] in &one {
            assert!((3.0..=31.25).contains(x0) && (3.0..=31.25).contains(x1), "{x0} to {x1}");
            assert!((5.5..=22.25).contains(y0) && (5.5..=22.25).contains(y1), "{y0} to {y1}");
            assert!((x0 + y0 - x1 - y1).abs() < 1e-9);
        }
        let on_edge = |lines: &[[(f64, f64); 2]]| -> Vec<f64> {
            let ends = lines.iter().flatten();
            let mut heights: Vec<f64> = ends.filter(|end| end.0 == 31.25).map(|end| end.1).collect();
            heights.sort_by(f64::total_cmp);
            heights
        };
        assert!(!on_edge(&one).is_empty());
        assert_eq!(on_edge(&one), on_edge(&next));
    }

    #[test]
    fn runs_are_the_stretches_that_hold() {
        assert_eq!(runs(7, |place| [0, 1, 4, 6].contains(&place)), [(0, 2), (4, 5), (6, 7)]);
        assert!(runs(0, |_| true).is_empty());
    }
}
