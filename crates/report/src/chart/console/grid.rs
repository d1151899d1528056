//! A grid of characters with dots between them, the frame of a chart on it, and the replacement of characters by plain ASCII.

use crate::chart::axis::Range;
use crate::chart::console::Look;
use crate::chart::figure::Axis;
use crate::chart::layout::in_lines;
use crate::chart::ticks::raised_signs;

/// Rows of the inner part of a chart.
const ROWS: usize = 20;

/// The ranges of two axes, with their labels.
pub struct Frame<'a> {
    x: (&'a Axis, Range),
    y: (&'a Axis, Range),
    look: Look,
    /// Label of each row of cells, where it has one.
    labels: Vec<Option<String>>,
    margin: usize,
}

impl<'a> Frame<'a> {
    pub fn new(x: (&'a Axis, Range), y: (&'a Axis, Range), look: Look) -> Frame<'a> {
        let mut labels = vec![None; ROWS];
        for (value, label) in y.0.ticks(y.1).major {
            let row = ((1.0 - y.1.fraction(value)) * ROWS as f64) as usize;
            // Of two labels in a row either one is suitable.
            labels[row.min(ROWS - 1)].get_or_insert(look.spelled(&label));
        }
        let margin = labels.iter().flatten().map(|label| label.chars().count()).max().unwrap_or(0);
        Frame { x, y, look, labels, margin }
    }

    /// Cells for the contents of the axes.
    pub fn page(&self) -> Page {
        Page::new(self.look.wide().saturating_sub(self.margin + 3).max(1), ROWS, self.look.unicode)
    }

    /// The place of a point of the data, as fractions of the lengths of the axes.
    pub fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x.1.fraction(x), self.y.1.fraction(y))
    }

    /// A chart as lines of text, each with its line end: the title, the page with its axes, and the legend with the
    /// rows `chosen` last.
    pub fn text(&self, title: &str, page: &Page, mut entries: Vec<String>, chosen: &[String]) -> String {
        entries.extend(chosen.iter().map(|chosen| self.look.spelled(chosen)));
        format!("{}\n{}{}", self.look.spelled(title), self.drawn(page), legend(&entries, self.look))
    }

    /// The page with its axes: the title of y, the rows, the labels and the title of x.
    fn drawn(&self, page: &Page) -> String {
        let Frame { look, margin, .. } = *self;
        let [side, tick, corner, base, mark] =
            look.either(['│', '┤', '└', '─', '┬'], ['|', '+', '+', '-', '+']);
        let mut text = format!("{}\n", look.spelled(&self.y.0.title()));
        for (row, label) in self.labels.iter().enumerate() {
            let (label, side) = label.as_ref().map_or(("", side), |label| (label.as_str(), tick));
            let cells = page.row(row, look.color);
            text += &format!("{}\n", format!(" {label:>margin$} {side}{cells}").trim_end());
        }
        let mut line = vec![base; page.columns];
        // A label may extend beyond the last cell.
        let mut rows = [vec![' '; margin + 3 + page.columns], vec![' '; margin + 3 + page.columns]];
        let mut free = [0; 2];
        for (value, label) in self.x.0.ticks(self.x.1).major {
            let label = look.spelled(&label);
            let at = ((self.x.1.fraction(value) * page.columns as f64) as usize).min(page.columns - 1);
            let most = match self.x.0.names.len() {
                0 => usize::MAX,
                names => (page.columns / names).saturating_sub(1).max(1),
            };
            for ((label, row), free) in in_rows(&label, most).into_iter().zip(&mut rows).zip(&mut free) {
                let length = label.chars().count();
                let start = (margin + 3 + at).saturating_sub(length / 2);
                if start < *free || start + length > row.len() {
                    continue;
                }
                line[at] = mark;
                row[start..].iter_mut().zip(label.chars()).for_each(|(cell, sign)| *cell = sign);
                *free = start + length + 1;
            }
        }
        let line: String = line.into_iter().collect();
        let rows = rows.map(|row| row.into_iter().collect::<String>().trim_end().to_owned());
        text += &format!(" {:margin$} {corner}{line}\n{}\n", "", rows[0]);
        if !rows[1].is_empty() {
            text += &format!("{}\n", rows[1]);
        }
        let title = look.spelled(&self.x.0.title());
        let indent = (margin + 3 + page.columns / 2).saturating_sub(title.chars().count() / 2);
        text + &format!("{:indent$}{title}\n", "")
    }
}

/// A label in one row of at most `most` characters if it fits, else in two of about equal length; longer ones are
/// truncated.
fn in_rows(label: &str, most: usize) -> Vec<String> {
    let length = |text: &str| text.chars().count();
    let cut = |row: &str| match length(row) > most {
        true => row.chars().take(most.saturating_sub(1)).chain(['…']).collect(),
        false => row.to_owned(),
    };
    in_lines(label, most as f64, |text| length(text) as f64).into_iter().map(cut).collect()
}

/// Entries of a legend in lines as wide as the terminal; widths are those of visible characters.
fn legend(entries: &[String], look: Look) -> String {
    let (mut text, mut used) = (String::new(), 0);
    for entry in entries {
        let length = seen(entry);
        if used > 0 && used + 3 + length > look.wide() {
            text.push('\n');
            used = 0;
        }
        text += &format!("{}{entry}", if used > 0 { "   " } else { "  " });
        used += length + if used > 0 { 3 } else { 2 };
    }
    if used > 0 { text + "\n" } else { text }
}

/// Number of visible characters of a text, without escape codes.
fn seen(text: &str) -> usize {
    let mut hidden = false;
    let shown = text.chars().filter(|&sign| {
        let counts = !hidden && sign != '\u{1b}';
        hidden = sign == '\u{1b}' || (hidden && sign != 'm');
        counts
    });
    shown.count()
}

/// A rectangle of cells with a finer grid of dots in which lines are drawn; characters take precedence over dots.
pub struct Page {
    pub columns: usize,
    pub rows: usize,
    unicode: bool,
    cells: Vec<Cell>,
}

/// The contents of a cell, with their terminal colour.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    sign: Option<char>,
    /// Bits of the dots, as of [`BRAILLE`].
    dots: u8,
    colour: Option<usize>,
}

/// Codes of the colours, similar to those of the pictures as far as a terminal has them.
const COLOURS: [&str; 8] = ["34", "31", "36", "35", "33", "94", "90", "32"];

/// The bits of Braille by column and row.
const BRAILLE: [[u8; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

impl Page {
    pub fn new(columns: usize, rows: usize, unicode: bool) -> Page {
        Page { columns, rows, unicode, cells: vec![Cell::default(); columns * rows] }
    }

    /// Dots across and down in a cell.
    fn fine(&self) -> (usize, usize) {
        if self.unicode { (2, 4) } else { (1, 2) }
    }

    /// Puts a sign where a place is, (0, 0) being the lower left corner and (1, 1) the upper right one; outside there is nothing.
    pub fn sign(&mut self, (x, y): (f64, f64), sign: char, colour: Option<usize>) {
        let place = cell_of(x, self.columns).zip(cell_of(1.0 - y, self.rows));
        if let Some((column, row)) = place {
            self.cells[row * self.columns + column] = Cell { sign: Some(sign), dots: 0, colour };
        }
    }

    /// A straight line between two places, of every `step`-th dot.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), step: usize, colour: Option<usize>) {
        let (fine_x, fine_y) = self.fine();
        let size = [(self.columns * fine_x) as f64, (self.rows * fine_y) as f64];
        let length = ((to.0 - from.0) * size[0]).abs().max(((to.1 - from.1) * size[1]).abs());
        // Places far outside have no separate dots.
        let steps = length.ceil().clamp(1.0, 1e5) as usize;
        for at in (0..=steps).step_by(step.max(1)) {
            let part = at as f64 / steps as f64;
            self.dot((from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1)), colour);
        }
    }

    fn dot(&mut self, (x, y): (f64, f64), colour: Option<usize>) {
        let (fine_x, fine_y) = self.fine();
        let place = cell_of(x, self.columns * fine_x).zip(cell_of(1.0 - y, self.rows * fine_y));
        if let Some((across, down)) = place {
            let cell = &mut self.cells[down / fine_y * self.columns + across / fine_x];
            cell.dots |= BRAILLE[across % fine_x][down % fine_y];
            cell.colour = if cell.sign.is_some() { cell.colour } else { colour };
        }
    }

    /// A row of cells, in colour where that is wanted.
    pub fn row(&self, row: usize, color: bool) -> String {
        let cells = &self.cells[row * self.columns..(row + 1) * self.columns];
        let shown = |cell: &Cell| {
            let sign = match (cell.sign, cell.dots) {
                (Some(sign), _) => sign,
                (None, 0) => ' ',
                (None, dots) if self.unicode => char::from_u32(0x2800 + u32::from(dots)).unwrap_or(' '),
                (None, 1) => '\'',
                (None, 2) => '.',
                (None, _) => ':',
            };
            painted(sign, cell.colour.filter(|_| color))
        };
        cells.iter().map(shown).collect()
    }
}

/// A sign in a colour, or as it is.
pub fn painted(sign: char, colour: Option<usize>) -> String {
    match colour {
        Some(colour) if sign != ' ' => format!("\u{1b}[{}m{sign}\u{1b}[0m", COLOURS[colour % COLOURS.len()]),
        _ => sign.to_string(),
    }
}

/// The one of `count` cells in which a part of their length lies, the ends with the outer ones.
fn cell_of(part: f64, count: usize) -> Option<usize> {
    let inside = (-1e-9..=1.0 + 1e-9).contains(&part);
    inside.then(|| ((part * count as f64) as usize).min(count.saturating_sub(1)))
}

/// Other characters, replaced by words where there is no similar one.
const OTHERS: [(char, &str); 20] = [
    ('″', "arcsec"),
    ('′', "arcmin"),
    ('°', "deg"),
    ('√', "sqrt "),
    ('·', "*"),
    ('−', "-"),
    ('–', "-"),
    ('…', "..."),
    ('×', "x"),
    ('Δ', "d"),
    ('δ', "d"),
    ('σ', "sigma"),
    ('τ', "tau"),
    ('ν', "nu"),
    ('χ', "chi"),
    ('φ', "phi"),
    ('α', "alpha"),
    ('λ', "lambda"),
    ('µ', "u"),
    ('Ω', "Omega"),
];

/// The text in ASCII: `10⁻²` becomes `1e-2`, `(°/h)²` becomes `(deg/h)^2`; a character without a replacement becomes
/// `?`.
pub fn spelled(text: &str) -> String {
    let mut out = String::new();
    let mut raised = false;
    for sign in text.chars() {
        if let Some((_, plain)) = raised_signs().find(|(known, _)| *known == sign) {
            if !raised {
                begin_exponent(&mut out);
            }
            raised = true;
            out.push(plain);
            continue;
        }
        raised = false;
        match OTHERS.iter().find(|(known, _)| *known == sign) {
            Some((_, word)) => out += word,
            None if sign.is_ascii() => out.push(sign),
            None => out.push('?'),
        }
    }
    out
}

/// Powers of ten are written as numbers, other powers with `^`.
fn begin_exponent(out: &mut String) {
    if let Some(number) = out.strip_suffix("*10") {
        *out = format!("{number}e");
    } else if out.ends_with("10") && !out[..out.len() - 2].ends_with(|c: char| c.is_ascii_digit()) {
        out.truncate(out.len() - 2);
        *out += "1e";
    } else {
        out.push('^');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_units_and_letters_have_a_spelling() {
        assert_eq!(spelled("10⁻²"), "1e-2");
        assert_eq!(spelled("2·10¹²"), "2e12");
        assert_eq!(spelled("Allan variance, (°/h)²"), "Allan variance, (deg/h)^2");
        assert_eq!(spelled("−0.5 °/√h …"), "-0.5 deg/sqrt h ...");
        assert_eq!(spelled("Яu"), "?u");
        assert!(spelled("rms error, ″").is_ascii());
    }
}
