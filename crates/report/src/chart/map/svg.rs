//! A map as shapes: its cells, drawn into the frame of its axes, the scale of the colours next to it, and the lines along which values
//! on a grid cross a level, of which the limit on a heat map is one.

use std::collections::{BTreeMap, BTreeSet};

use crate::chart::axis::{Range, Scale, edges, extent};
use crate::chart::canvas::{Canvas, Colour, Lettering, Set, Stroke};
use crate::chart::figure::Limit;
use crate::chart::layout::{
    self, Area, Frame, HEIGHT, MARGIN, MAX_LABELS, TICK_SIZE, Titles, draw_axis_title, draw_nothing, widest,
};
use crate::chart::legend::{Legend, Sample, remark, wrapped_entry};
use crate::chart::map::{Axis, Cells, Map, Won};
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
            (Cells::Values(_), Some(limit)) => draw_limit(canvas, self, area, limit),
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
            draw_line(canvas, &[(left - 4.0, y), (right + 4.0, y)]);
        }
        draw_axis_title(
            canvas,
            right + TO_LABELS + widest(self.ticks) + TO_TITLE - 3.0,
            (top, bottom),
            self.title,
        );
    }
}

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
fn contour(
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
fn draw_limit(canvas: &mut Canvas, map: &Map, area: &Area, limit: &Limit) {
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
fn draw_line(canvas: &mut Canvas, places: &[(f64, f64)]) {
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
