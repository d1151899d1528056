//! A map as shapes: its cells, drawn into the frame of its axes, and the scale of the colours next to it.

use crate::chart::axis::{Range, Scale, edges, extent};
use crate::chart::canvas::{Canvas, Colour, Lettering, Stroke};
use crate::chart::layout::{
    self, Area, Frame, HEIGHT, MARGIN, MAX_LABELS, TICK_SIZE, Titles, draw_axis_title, draw_nothing, widest,
};
use crate::chart::legend::{Legend, Sample, remark, wrapped_entry};
use crate::chart::map::{Axis, Cells, Map, Won, contour};
use crate::chart::palette::{self, INK, LIMIT, PALE_MUTED, Shades};
use crate::chart::ticks::Ticks;

impl Map {
    /// The shapes of the map.
    pub fn canvas(&self) -> Canvas {
        let range = |scale: Scale, values| Range::between(scale, &edges(scale, values));
        let (x, y) = (range(self.x.scale, &self.columns), range(self.y.scale, &self.rows));
        let (x_ticks, y_ticks) = (ticks(&self.x, x, &self.columns), ticks(&self.y, y, &self.rows));
        let (shades, colours) = self.colours();
        let colour_ticks = self.z.ticks(colours);
        let (z_title, limit) = (self.z.title(), self.limit.as_ref().map(|limit| limit.value));
        let has_bar = matches!(self.cells, Cells::Values(_)) && !self.is_yes_or_no();
        let bar = has_bar.then_some(ColourBar {
            range: colours,
            shades,
            ticks: &colour_ticks,
            title: &z_title,
            limit: limit.filter(|limit| (colours.low..=colours.high).contains(limit)),
        });
        let legend = self.legend();
        let (title, subtitle) = (&self.title, self.subtitle.as_deref());
        let titles = Titles { title, subtitle, x: &self.x, y: &self.y };
        let frame = titles.frame(&y_ticks, legend.width().max(bar.as_ref().map_or(0.0, ColourBar::width)));
        let area = Area { x, y, frame };
        let edges = Edges::new(self, &area);

        let mut canvas = Canvas::new(&self.title);
        titles.draw(&mut canvas, frame);
        draw_cells(&mut canvas, self, &edges, (shades, colours));
        self.draw_over(&mut canvas, &area, &edges);
        draw_frame(&mut canvas, frame);
        canvas.group("axes", |canvas| layout::draw_axes(canvas, &area, &x_ticks, &y_ticks));
        if self.known() == 0 {
            draw_nothing(&mut canvas, "value", 0, frame);
        }
        let Frame { top, right, bottom, .. } = frame;
        let (left, mut legend_top) = (right + MARGIN, top);
        if let Some(bar) = bar {
            let under = if legend.height() > 0.0 { legend.height() + 0.7 * MARGIN } else { 0.0 };
            legend_top = (bottom - under).max(top + 0.4 * (bottom - top)) + 0.7 * MARGIN;
            bar.draw(&mut canvas, left, (top, legend_top - 0.7 * MARGIN));
        }
        canvas.group("legend", |canvas| legend.draw(canvas, (left, legend_top), HEIGHT - 0.5 * MARGIN));
        canvas
    }

    /// The scale of the colours. Around a limit it reaches as far on either side as the values on one; else it is exactly the range of
    /// the values shown, or a range around a single one.
    fn colours(&self) -> (Shades, Range) {
        let (scale, values) = (self.z.scale, self.values());
        let values = || values.iter().copied().flatten();
        let limit = self.limit.as_ref().map(|limit| limit.value).filter(|limit| scale.shows(*limit));
        match (extent(values()), limit) {
            (Some((low, high)), Some(limit)) if low < limit || limit < high => {
                let [low, limit, high] = [low, limit, high].map(|value| scale.coordinate(value));
                let reach = (high - limit).max(limit - low);
                let [low, high] = [limit - reach, limit + reach].map(|coordinate| scale.value(coordinate));
                (Shades::AboutLimit, Range { scale, low, high })
            }
            (Some((low, high)), _) if low < high => (Shades::Rising, Range { scale, low, high }),
            _ => (Shades::Rising, Range::around(scale, values())),
        }
    }

    /// Draws the parts that lie over the cells.
    fn draw_over(&self, canvas: &mut Canvas, area: &Area, edges: &Edges) {
        match (&self.cells, &self.limit) {
            (Cells::Values(_), Some(limit)) => contour::draw_limit(canvas, self, area, limit),
            (Cells::Values(_), None) => {}
            (Cells::Winners { won, .. }, limit) => {
                if let Some(limit) = limit {
                    draw_hatching(canvas, edges, won, limit.value);
                }
                draw_boundaries(canvas, edges, won);
            }
        }
    }

    fn legend(&self) -> Legend {
        let mut legend = Legend::default();
        let words = self.words();
        let title = match &self.cells {
            Cells::Winners { of, .. } => Some(&of.title),
            Cells::Values(_) => self.is_yes_or_no().then_some(&self.z.label),
        };
        if let Some(title) = title {
            let entry = |(style, text): &(usize, String)| {
                wrapped_entry(Sample::Area(palette::area_colour(*style), false), text)
            };
            let judged = words.judged.iter().flat_map(|text| remark(text));
            legend.part(Some(title), judged.chain(words.entries.iter().flat_map(entry)).collect());
        }
        let close = words.close.iter().flat_map(|text| wrapped_entry(Sample::Area(PALE_MUTED, false), text));
        legend.part(None, words.unjudged.iter().flat_map(|text| remark(text)).chain(close).collect());
        let limit = words.limit.iter().flat_map(|text| {
            let line = Stroke { colour: LIMIT, width: 2.2, dash: "" };
            let sample = match self.cells {
                Cells::Values(_) => Sample::Line(line),
                Cells::Winners { .. } => Sample::Area("#ffffff", true),
            };
            wrapped_entry(sample, text)
        });
        legend.part(None, limit.collect());
        legend.part(None, words.blank.iter().flat_map(|text| remark(text)).collect());
        legend.shown(&self.chosen);
        legend
    }
}

/// The ticks of an axis: those of its scale, or one at each of a few well-separated counts.
fn ticks(axis: &Axis, range: Range, cells: &[f64]) -> Ticks {
    /// Least distance of two labels, relative to the length of the axis.
    const APART: f64 = 0.045;
    let apart = cells.windows(2).all(|pair| range.fraction(pair[1]) - range.fraction(pair[0]) >= APART);
    if cells.is_empty() || cells.len() > MAX_LABELS || !axis.whole || !apart {
        return axis.ticks(range);
    }
    Ticks { major: cells.iter().map(|value| (*value, format!("{value:.0}"))).collect(), minor: vec![] }
}

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
fn draw_cells(canvas: &mut Canvas, map: &Map, edges: &Edges, (shades, range): (Shades, Range)) {
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
fn draw_hatching(canvas: &mut Canvas, edges: &Edges, won: &[Option<Won>], limit: f64) {
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
fn draw_boundaries(canvas: &mut Canvas, edges: &Edges, won: &[Option<Won>]) {
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
fn draw_frame(canvas: &mut Canvas, frame: Frame) {
    let Frame { left, top, right, bottom } = frame;
    let line = Stroke { colour: INK, width: 1.1, dash: "" };
    canvas.line(&[(left, top), (right, top), (right, bottom)], line);
}

const WIDTH: f64 = 22.0;
/// Distance from the bar to the labels of its ticks.
const TO_LABELS: f64 = 9.0;
/// Distance from the labels to the baseline of the title.
const TO_TITLE: f64 = 22.0;
/// Number of pieces of one colour, more than can be distinguished.
const PIECES: usize = 160;

/// A bar with its ticks and title.
#[derive(Debug)]
pub struct ColourBar<'a> {
    pub range: Range,
    pub shades: Shades,
    pub ticks: &'a Ticks,
    pub title: &'a str,
    /// Place of the limit, if it is on the scale.
    pub limit: Option<f64>,
}

impl ColourBar<'_> {
    /// The total width.
    pub fn width(&self) -> f64 {
        WIDTH + TO_LABELS + widest(self.ticks) + TO_TITLE
    }

    /// Draws it to the right of `left`.
    pub fn draw(&self, canvas: &mut Canvas, left: f64, (top, bottom): (f64, f64)) {
        let right = left + WIDTH;
        let height = |fraction: f64| bottom - fraction * (bottom - top);
        canvas.crisp_group("colour scale", |canvas| {
            for piece in 0..PIECES {
                let [low, high] = [piece, piece + 1].map(|piece| piece as f64 / PIECES as f64);
                canvas.block(
                    (left, height(high)),
                    (right, height(low)),
                    self.shades.colour(0.5 * (low + high)),
                );
            }
        });
        let line = Stroke { colour: INK, width: 1.1, dash: "" };
        canvas.line(&[(left, top), (right, top), (right, bottom), (left, bottom), (left, top)], line);
        for value in &self.ticks.minor {
            let y = height(self.range.fraction(*value));
            canvas.line(&[(right, y), (right + 3.0, y)], line);
        }
        let lettering = Lettering { size: TICK_SIZE, bold: false, colour: INK, anchor: "start" };
        for (value, label) in &self.ticks.major {
            let y = height(self.range.fraction(*value));
            canvas.line(&[(right, y), (right + 6.0, y)], line);
            canvas.text((right + TO_LABELS, y + 0.36 * TICK_SIZE), label, lettering);
        }
        if let Some(limit) = self.limit {
            let y = height(self.range.fraction(limit));
            contour::draw_line(canvas, &[(left - 4.0, y), (right + 4.0, y)]);
        }
        draw_axis_title(
            canvas,
            right + TO_LABELS + widest(self.ticks) + TO_TITLE - 3.0,
            (top, bottom),
            self.title,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_counts_have_a_tick_each_and_other_values_those_of_their_scale() {
        let labels_of = |whole: bool, values: &[f64]| -> Vec<String> {
            let axis = Axis {
                label: String::new(),
                defined: String::new(),
                unit: String::new(),
                scale: Scale::Linear,
                whole,
                ..Axis::default()
            };
            let range = Range::between(axis.scale, &edges(axis.scale, values));
            ticks(&axis, range, values).major.into_iter().map(|(_, label)| label).collect()
        };
        let labels = |values: &[f64]| labels_of(true, values);
        assert_eq!(labels(&[1.0, 2.0, 3.0]), ["1", "2", "3"]);
        assert_eq!(labels(&[3.0, 8.0, 13.0, 64.0]), ["3", "8", "13", "64"]);
        assert_eq!(labels_of(false, &[1.0, 2.0, 3.0])[..2], ["0.5", "1.0"]);
        assert_eq!(labels(&[1.0, 2.0, 100.0]), ["20", "40", "60", "80", "100", "120", "140"]);
    }

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
