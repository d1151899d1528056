//! Charts as text, for a quick look in a terminal.
//!
//! The axes, their ticks and their ranges are those of the pictures. Lines consist of Braille dots, four rows of two in
//! a cell, or in plain ASCII of two rows of one; points are letters and characters explained in the legend.

pub(crate) mod grid;
#[cfg(test)]
mod tests;

use crate::chart::axis::{Range, edges, extent};
use crate::chart::console::grid::{Frame, Page, painted};
use crate::chart::figure::{Figure, Grouping, Series};
use crate::chart::map::{Cells, Map};
use crate::chart::plot::{x_range, y_range};
use sagnac_base::diagnostics::visible;
use sagnac_base::quantity::number::significant;

/// The capabilities of a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Number of columns, at least [`Look::MIN_WIDTH`]; with fewer the text is wider than the terminal.
    pub width: usize,
    /// Whether it shows characters beyond ASCII.
    pub unicode: bool,
    /// Whether escape codes colour the curves.
    pub color: bool,
}

impl Look {
    /// Least width with room for axes and curves.
    pub const MIN_WIDTH: usize = 40;

    /// The text in characters that the terminal can show, none of which commands it.
    fn spelled(self, text: &str) -> String {
        let text = visible(text);
        if self.unicode { text.into_owned() } else { crate::chart::console::grid::spelled(&text) }
    }

    /// The one of two items that the terminal can show.
    fn either<T>(self, unicode: T, ascii: T) -> T {
        if self.unicode { unicode } else { ascii }
    }

    fn wide(self) -> usize {
        self.width.max(Look::MIN_WIDTH)
    }
}

/// The characters of a few curves, and those of many.
const FEW: [char; 6] = ['●', '■', '▲', '◆', '▼', '○'];
const FEW_ASCII: [char; 6] = ['o', 'x', '*', '#', '@', '%'];

/// Number of cells for each point that is marked in a curve with more points.
const CELLS_PER_SIGN: usize = 3;

/// The figure as text. Bands and parts are left out.
pub(crate) fn figure_text(figure: &Figure, look: Look) -> String {
    let frame = Frame::new((&figure.x, x_range(figure)), (&figure.y, y_range(figure)), look);
    let mut page = frame.page();
    for law in &figure.laws {
        law.lines.iter().for_each(|line| joined(&mut page, &frame, &line.points, 4, None));
    }
    for limit in figure.limits() {
        let (_, height) = frame.place((0.0, limit));
        let columns = page.columns;
        let places = (0..columns).map(|column| (column as f64 + 0.5) / columns as f64);
        places.for_each(|across| page.sign((across, height), look.either('─', '-'), None));
    }
    for series in &figure.series {
        let points: Vec<(f64, f64)> = series.points.iter().map(|point| (point.x, point.y)).collect();
        let line = if figure.has_laws() { &series.law } else { &points };
        if figure.x.names.is_empty() {
            joined(&mut page, &frame, line, 1, Some(series.colour));
        }
    }
    for (at, series) in figure.series.iter().enumerate() {
        let step = (series.points.len() * CELLS_PER_SIGN).div_ceil(page.columns).max(1);
        let shown = series.points.iter().filter(|point| figure.shows((point.x, point.y))).step_by(step);
        shown.for_each(|point| {
            page.sign(frame.place((point.x, point.y)), curve_sign(figure, at, look), Some(series.colour))
        });
    }
    frame.text(&figure.title, &page, entries(figure, look), &figure.chosen)
}

/// Draws a line through those places that the axes can show.
fn joined(page: &mut Page, frame: &Frame, places: &[(f64, f64)], step: usize, colour: Option<usize>) {
    let places: Vec<(f64, f64)> = places.iter().map(|place| frame.place(*place)).collect();
    places.windows(2).for_each(|pair| page.line(pair[0], pair[1], step, colour));
}

/// The character of a curve: a shape of its own if there are few curves, else a letter.
fn curve_sign(figure: &Figure, at: usize, look: Look) -> char {
    let signs = look.either(FEW, FEW_ASCII);
    if figure.series.len() <= signs.len() {
        return signs[at];
    }
    let letters = ('a'..='z').chain('A'..='Z').collect::<Vec<char>>();
    letters[at % letters.len()]
}

/// The meaning of each character and line.
fn entries(figure: &Figure, look: Look) -> Vec<String> {
    let series = figure.series.iter().enumerate().map(|(at, series): (usize, &Series)| {
        let sign = painted(curve_sign(figure, at, look), Some(series.colour).filter(|_| look.color));
        let name = figure.name(series);
        format!("{sign} {}", look.spelled(if name.is_empty() { &figure.y.label } else { &name }))
    });
    let mut entries: Vec<String> = series.collect();
    let line = |sign: &str, plain: &str, label: &str| {
        format!("{} {}", look.either(sign, plain), look.spelled(label))
    };
    if figure.has_laws() && figure.x.names.is_empty() {
        entries.push(line("⠒⠒", "..", &figure.lines));
    }
    entries.extend(figure.laws.iter().map(|law| line("⠐ ⠐", ". .", &law.label)));
    entries.extend(figure.limit.iter().map(|limit| line("──", "--", &limit.label)));
    entries
}

/// Shades from the least to the largest value.
const SHADES: [char; 5] = ['·', '░', '▒', '▓', '█'];
const SHADES_ASCII: [char; 5] = ['.', ':', '+', '*', '#'];

/// The map as text.
pub(crate) fn map_text(map: &Map, look: Look) -> String {
    let (columns, rows) = (edges(map.x.scale, &map.columns), edges(map.y.scale, &map.rows));
    let (x, y) = (Range::between(map.x.scale, &columns), Range::between(map.y.scale, &rows));
    let frame = Frame::new((&map.x, x), (&map.y, y), look);
    let mut page = frame.page();
    let ends = ends(map);
    for row in 0..page.rows {
        for column in 0..page.columns {
            let across = (column as f64 + 0.5) / page.columns as f64;
            let up = 1.0 - (row as f64 + 0.5) / page.rows as f64;
            let cell = at(&x, &columns, across).zip(at(&y, &rows, up));
            let found = cell.and_then(|(i, j)| cell_sign(map, &ends, j * map.columns.len() + i, look));
            if let Some((sign, colour)) = found {
                page.sign((across, up), sign, colour);
            }
        }
    }
    let entries = match &map.cells {
        Cells::Values(_) => of_values(map, &ends, look),
        Cells::Winners { of, banded, .. } => of_winners(map, of, *banded, look),
    };
    frame.text(&map.title, &page, entries, &map.chosen)
}

/// The cell between `edges` that lies at a fraction of the length of an axis.
fn at(range: &Range, edges: &[f64], part: f64) -> Option<usize> {
    let place = edges.iter().position(|&edge| range.fraction(edge) > part)?;
    place.checked_sub(1)
}

/// The character of a cell with its colour. A winner has a capital if it is certain, else a small letter, and a dot
/// where no competitor is within the limit.
fn cell_sign(map: &Map, ends: &[f64], cell: usize, look: Look) -> Option<(char, Option<usize>)> {
    match &map.cells {
        Cells::Values(values) => {
            let value = values[cell]?;
            Some((look.either(SHADES, SHADES_ASCII)[ends.iter().filter(|&&end| value > end).count()], None))
        }
        Cells::Winners { won, .. } => {
            let won = won[cell]?;
            let over = map.limit.as_ref().is_some_and(|limit| won.value > limit.value);
            let sign = match (over, won.certain) {
                (true, _) => '.',
                (false, true) => letter(won.style),
                (false, false) => letter(won.style).to_ascii_lowercase(),
            };
            Some((sign, Some(won.style)))
        }
    }
}

fn letter(style: usize) -> char {
    (b'A' + (style % 26) as u8) as char
}

/// The boundaries between shades, ascending; a limit is one of them.
fn ends(map: &Map) -> Vec<f64> {
    let Cells::Values(values) = &map.cells else { return vec![] };
    let known = values.iter().flatten().copied();
    let (low, high) = extent(known).unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
    let scale = map.z.scale;
    let part = |low: f64, high: f64, part: f64| {
        let [low, high] = [low, high].map(|end| scale.coordinate(end));
        scale.value(low + part * (high - low))
    };
    let limit = map.limit.as_ref().map(|limit| limit.value).filter(|limit| (low..high).contains(limit));
    match limit {
        // Two shades within the limit, three beyond it.
        Some(limit) => {
            vec![part(low, limit, 0.5), limit, part(limit, high, 1.0 / 3.0), part(limit, high, 2.0 / 3.0)]
        }
        None => (1..5).map(|end| part(low, high, f64::from(end) / 5.0)).collect(),
    }
}

fn of_values(map: &Map, ends: &[f64], look: Look) -> Vec<String> {
    let mut entries = vec![look.spelled(&map.z.title())];
    for (at, sign) in look.either(SHADES, SHADES_ASCII).iter().enumerate() {
        let end = |at: usize| ends.get(at).map(|end| significant(*end, 3));
        let stretch = match (at.checked_sub(1).and_then(end), end(at)) {
            (Some(low), Some(high)) => format!("{low} to {high}"),
            (None, Some(high)) => format!("up to {high}"),
            (Some(low), None) => format!("above {low}"),
            (None, None) => continue,
        };
        entries.push(format!("{sign} {stretch}"));
    }
    entries.extend(map.limit.iter().map(|limit| look.spelled(&limit.label)));
    entries
}

fn of_winners(map: &Map, of: &Grouping, banded: bool, look: Look) -> Vec<String> {
    let mut entries = vec![look.spelled(&format!("least {}", map.z.title()))];
    entries.extend(
        of.entries.iter().map(|entry| format!("{} {}", letter(entry.style), look.spelled(&entry.name))),
    );
    if banded {
        entries.push("small letters: bands overlap".to_owned());
    }
    entries.extend(map.limit.iter().map(|limit| look.spelled(&format!(". over the {}", limit.label))));
    entries
}
