//! The frame of a chart in text.

use crate::chart::axes::in_lines;
use crate::chart::console::Look;
use crate::chart::console::page::Page;
use crate::chart::figure::Axis;
use crate::chart::scale::Range;

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
