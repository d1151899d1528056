//! Tables as text in aligned columns, and as CSV files.

use std::collections::HashMap;
use std::io;

use sha2::{Digest, Sha256};

use crate::diagnostics::in_cell;
use crate::table::{Cell, Column, ColumnError, Table};

/// Most rows of a table that are shown; of longer ones every second, third, … row, and those that are the best of a curve.
const MAX_ROWS: usize = 48;

/// Significant digits of a number: as few as distinguish it from its neighbours.
const DIGITS: std::ops::RangeInclusive<usize> = 4..=17;

/// One column of a table over the sweeps: a line for each combination of their values, and a column for each curve.
///
/// `sweeps` are the columns that label lines, except those in `series`; the first of them always does. Other columns in
/// `texts` that differ between rows, filler or error, label columns too, so that no cell has two values. Lines are at most
/// `limit` columns wide.
///
/// # Errors
/// A name selects no single column, or the filter leaves no row.
pub fn pivot(
    table: &Table,
    sweeps: &[&str],
    y: &str,
    series: &[&str],
    texts: &[&str],
    filter: &[(String, String)],
    limit: Option<usize>,
) -> Result<String, ColumnError> {
    let rows = table.rows_where(filter)?;
    let table: &Table = &table.read();
    let columns = |names: &[&str]| names.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>();
    let (sweeps, y, mut series) = (columns(sweeps)?, table.column(y)?, columns(series)?);
    series.retain(|column| sweeps.first().is_none_or(|first| column.name != first.name));
    let unnamed = |column: &&Column| series.iter().all(|named| named.name != column.name);
    let texts: Vec<&Column> = columns(texts)?
        .into_iter()
        .filter(|text| sweeps.iter().all(|sweep| sweep.name != text.name))
        .collect();
    let mut across: Vec<Names> = sweeps.into_iter().filter(unnamed).map(|c| Names::new(c, &rows)).collect();
    let others = texts.into_iter().filter(unnamed).map(|c| Names::new(c, &rows));
    let mut curves: Vec<Names> = series.iter().map(|column| Names::new(column, &rows)).collect();
    curves.extend(others.filter(Names::differ));
    // The first sweep labels the lines even if it has one value.
    let mut first = true;
    across.retain(|names| std::mem::take(&mut first) || names.differ());
    let (line_of, lines) = combinations(&across, rows.len());
    let (curve_of, columns) = combinations(&curves, rows.len());
    let least = lines.len().div_ceil(MAX_ROWS).max(1);
    // A step that shares no factor with a faster sweep does not show the same of its values repeatedly.
    let inner = || across.iter().skip(1).map(|names| names.texts.len());
    let step = (least..).find(|&step| step == 1 || inner().all(|n| gcd(step, n) == 1)).unwrap_or(least);
    let mut grid = vec![vec![String::new(); across.len() + columns.len()]; lines.len() + 1];
    for (place, names) in across.iter().enumerate() {
        grid[0][place] = names.column.title();
        for (line, &at) in lines.iter().enumerate() {
            grid[line + 1][place] = names.at(at).to_owned();
        }
    }
    for (place, &at) in columns.iter().enumerate() {
        let words: Vec<&str> = curves.iter().map(|names| names.at(at)).collect();
        grid[0][across.len() + place] = if words.is_empty() { y.title() } else { words.join(" ") };
    }
    for (at, &row) in rows.iter().enumerate() {
        grid[line_of[at] + 1][across.len() + curve_of[at]] = y.cells[row].rounded(*DIGITS.start());
    }
    let best: Vec<usize> = match y.role.less_is_better() {
        true => (0..columns.len())
            .filter_map(|curve| {
                let of_curve = (0..rows.len()).filter(|&at| curve_of[at] == curve);
                let known = of_curve.filter_map(|at| Some((at, y.cells[rows[at]].number()?)));
                known.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| line_of[at])
            })
            .collect(),
        false => vec![],
    };
    let is_shown = |line: usize| line.is_multiple_of(step) || best.contains(&line);
    let shown: Vec<Vec<String>> = grid
        .into_iter()
        .enumerate()
        .filter(|(i, _)| *i == 0 || is_shown(i - 1))
        .map(|(_, row)| row)
        .collect();
    let note = match (step > 1, best.is_empty()) {
        (false, _) => String::new(),
        (true, true) => format!(" (one line in {step})"),
        (true, false) => format!(" (one line in {step}, and those with the least of a column)"),
    };
    let names: Vec<String> = curves.iter().map(|names| names.column.title()).collect();
    let by = if names.is_empty() { String::new() } else { format!(", by {}", names.join(" and ")) };
    Ok(format!("{}{by}{note}\n{}", y.title(), fitted(&shown, across.len(), limit)))
}

/// The different values of a column in the shown rows.
struct Names<'t> {
    column: &'t Column,
    /// For each shown row, the index of its value in `texts`.
    values: Vec<usize>,
    texts: Vec<String>,
}

impl<'t> Names<'t> {
    fn new(column: &'t Column, rows: &[usize]) -> Names<'t> {
        // Debug writes a number with all its digits.
        let (values, firsts) = distinct(rows.iter().map(|&row| format!("{:?}", column.cells[row])));
        let text = |digits: usize| {
            let cells = firsts.iter().map(|&at| &column.cells[rows[at]]);
            cells.map(|cell| cell.rounded(digits)).collect::<Vec<String>>()
        };
        let tells_apart = |texts: &Vec<String>| distinct(texts.iter()).1.len() == texts.len();
        let texts = DIGITS.map(text).find(tells_apart).unwrap_or_else(|| text(*DIGITS.end()));
        Names { column, values, texts }
    }

    fn differ(&self) -> bool {
        self.texts.len() > 1
    }

    /// The value in a shown row.
    fn at(&self, at: usize) -> &str {
        &self.texts[self.values[at]]
    }
}

/// The index of each item among the different ones, and the first place of each of these.
pub fn distinct<T: std::hash::Hash + Eq>(items: impl Iterator<Item = T>) -> (Vec<usize>, Vec<usize>) {
    let (mut known, mut firsts) = (HashMap::new(), Vec::new());
    let places = items
        .enumerate()
        .map(|(at, item)| {
            *known.entry(item).or_insert_with(|| {
                firsts.push(at);
                firsts.len() - 1
            })
        })
        .collect();
    (places, firsts)
}

/// The places of the distinct combinations of several columns, over `count` rows, as [`distinct`] gives them.
fn combinations(columns: &[Names], count: usize) -> (Vec<usize>, Vec<usize>) {
    distinct((0..count).map(|at| columns.iter().map(|names| names.values[at]).collect::<Vec<_>>()))
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Width beyond which headings are broken if no terminal has a known width.
const USUAL_MAX: usize = 100;

/// Rows of cells, flush right, with every column as wide as its widest cell. Beyond `limit` columns, headings are broken into
/// lines, and columns that do not fit continue below the others, with the first column repeated. Without a limit, headings of wide
/// tables are broken, and nothing continues below.
pub fn aligned(rows: &[Vec<String>], limit: Option<usize>) -> String {
    fitted(rows, 1, limit)
}

/// Rows of cells as in [`aligned`], with the first `keys` columns repeated.
fn fitted(rows: &[Vec<String>], keys: usize, limit: Option<usize>) -> String {
    let short = |row: &Vec<String>| row.iter().map(|cell| in_cell(cell).into_owned()).collect();
    let rows: &[Vec<String>] = &rows.iter().map(short).collect::<Vec<_>>();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widest = |rows: &[Vec<String>], column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(|column| widest(rows, column)).collect();
    let all: Vec<usize> = (0..columns).collect();
    let Some((heading, body)) = rows.split_first() else {
        return String::new();
    };
    if width_of(&widths, &all) <= limit.unwrap_or(USUAL_MAX) {
        return part(rows, &all, &widths);
    }
    let word = |cell: &String| words(cell).iter().map(|word| word.chars().count()).max().unwrap_or(0);
    let narrow: Vec<usize> =
        all.iter().map(|&column| widest(body, column).max(heading.get(column).map_or(0, word))).collect();
    let mut lines = heading_lines(heading, &narrow);
    lines.extend(body.iter().cloned());
    let limit = limit.unwrap_or(usize::MAX);
    let keys: Vec<usize> = all.iter().copied().take(keys).collect();
    let mut parts: Vec<Vec<usize>> = Vec::new();
    let mut shown = keys.clone();
    for &column in &all[keys.len()..] {
        shown.push(column);
        if width_of(&narrow, &shown) > limit && shown.len() > keys.len() + 1 {
            shown.pop();
            parts.push(std::mem::replace(&mut shown, [&keys[..], &[column]].concat()));
        }
    }
    parts.push(shown);
    let trimmed = |shown: &Vec<usize>| -> String {
        part(&lines, shown, &narrow).lines().map(|line| format!("{}\n", line.trim_end())).collect()
    };
    parts.iter().map(trimmed).collect::<Vec<_>>().join("\n")
}

/// Number of terminal columns for some columns of a table.
fn width_of(widths: &[usize], shown: &[usize]) -> usize {
    shown.iter().map(|&column| widths[column] + 2).sum()
}

/// A heading in as many lines as its longest cell needs; the last words of each cell are on the last line.
fn heading_lines(heading: &[String], widths: &[usize]) -> Vec<Vec<String>> {
    let broken: Vec<Vec<String>> =
        heading.iter().zip(widths).map(|(cell, &width)| broken(cell, width)).collect();
    let height = broken.iter().map(Vec::len).max().unwrap_or(0);
    let line = |at: usize| {
        let of = |cell: &Vec<String>| {
            (at + cell.len()).checked_sub(height).map_or_else(String::new, |at| cell[at].clone())
        };
        broken.iter().map(of).collect()
    };
    (0..height).map(line).collect()
}

/// The words of a heading; a sign, or a unit after a comma, stays with the previous word.
fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for word in text.split(' ') {
        let is_sign = !word.starts_with(char::is_alphanumeric);
        match words.last_mut() {
            Some(last) if is_sign || last.ends_with(',') => *last += &format!(" {word}"),
            _ => words.push(word.to_owned()),
        }
    }
    words
}

/// A text in lines of at most `width`, except for longer words.
fn broken(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words(text) {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                *line += &format!(" {word}")
            }
            _ => lines.push(word),
        }
    }
    lines
}

fn part(rows: &[Vec<String>], shown: &[usize], widths: &[usize]) -> String {
    let line = |row: &Vec<String>| {
        let cells = shown.iter().filter_map(|&column| Some((row.get(column)?, widths[column])));
        let cells: Vec<String> = cells.map(|(cell, width)| format!("{cell:>width$}")).collect();
        format!("  {}\n", cells.join("  "))
    };
    rows.iter().map(line).collect()
}

impl Table {
    /// Writes the table as CSV: a header, then the rows; blanks stay empty. A text that a spreadsheet would take for a
    /// formula, because it begins with `=`, `+`, `-`, `@`, a tab or a carriage return and is no number, has an apostrophe
    /// before it (OWASP, "CSV Injection"). Returns the SHA-256 of what was written, in hexadecimal digits.
    ///
    /// # Errors
    /// The errors of the writer.
    pub fn write_csv(&self, to: impl io::Write) -> io::Result<String> {
        let mut hashed = Hashed { to, hash: Sha256::new() };
        let mut writer = csv::Writer::from_writer(&mut hashed);
        writer.write_record(self.columns.iter().map(|column| guarded(column.header()))).map_err(csv_error)?;
        let text = |cell: &Cell| match cell {
            Cell::Text(text) => guarded(text.clone()),
            cell => cell.text(),
        };
        let columns: Vec<_> = self.columns.iter().map(|column| column.cells.texts(text)).collect();
        for row in 0..self.rows() {
            for column in &columns {
                writer.write_field(&*column.at(row)).map_err(csv_error)?;
            }
            writer.write_record(None::<&[u8]>).map_err(csv_error)?;
        }
        writer.flush()?;
        drop(writer);
        Ok(hexadecimal(&hashed.hash.finalize()))
    }
}

/// A writer that hashes what it passes on.
struct Hashed<W> {
    to: W,
    hash: Sha256,
}

impl<W: io::Write> io::Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.to.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// The error of the file behind one of the CSV writer, which names a full disk.
pub fn csv_error(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// A text of a file that no spreadsheet takes for a formula.
fn guarded(text: String) -> String {
    let is_formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']) && text.parse::<f64>().is_err();
    if is_formula { format!("'{text}") } else { text }
}

/// Bytes, in hexadecimal.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Vec<Vec<String>> {
        let row = |cells: &str| cells.split('|').map(str::to_owned).collect::<Vec<String>>();
        vec![
            row("vibration frequency, Hz|const 1|linear 1|least of all"),
            row("2|0.9672|0.967|1"),
            row("40|104|96.7|23.5"),
        ]
    }

    #[test]
    fn a_table_that_fits_or_has_no_limit_stays_in_one_piece_with_headings_in_a_line() {
        let heading = "  vibration frequency, Hz  const 1  linear 1  least of all\n";
        assert!(fitted(&table(), 1, None).starts_with(heading), "{}", fitted(&table(), 1, None));
        assert_eq!(fitted(&table(), 1, Some(heading.len() - 1)), fitted(&table(), 1, None));
    }

    #[test]
    fn headings_are_broken_where_the_terminal_is_narrow() {
        let text = fitted(&table(), 1, Some(57));
        assert_eq!(text.lines().count(), 5, "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 57), "{text}");
        assert!(
            text.lines().nth(2).is_some_and(|line| line.contains("Hz") && line.contains("all")),
            "{text}"
        );
        for word in ["vibration", "frequency,", "const", "linear"] {
            assert!(text.contains(word), "{word} is missing in\n{text}");
        }
    }

    #[test]
    fn what_is_still_too_wide_goes_on_below_beside_its_keys() {
        let text = fitted(&table(), 1, Some(30));
        assert!(text.lines().all(|line| line.chars().count() <= 30), "{text}");
        let parts: Vec<&str> = text.split("\n\n").collect();
        assert_eq!(parts.len(), 2, "{text}");
        assert!(parts.iter().all(|part| part.contains("frequency,") && part.contains("40")), "{text}");
        assert!(parts[0].contains("104") && parts[1].contains("23.5") && !parts[1].contains("104"), "{text}");
    }

    #[test]
    fn a_wide_table_for_no_terminal_has_broken_headings_and_stays_in_one_piece() {
        let mut wide = table();
        wide[0][3] = "least of all that there are, and of some that are not ".repeat(2);
        let text = fitted(&wide, 1, None);
        assert!(text.lines().all(|line| line.chars().count() <= 60) && !text.contains("\n\n"), "{text}");
    }

    #[test]
    fn a_terminal_too_narrow_for_anything_has_a_column_at_a_time() {
        assert_eq!(fitted(&table(), 1, Some(1)).split("\n\n").count(), 3);
        assert_eq!(fitted(&[], 1, Some(1)), "");
    }

    #[test]
    fn a_name_of_any_length_is_shown_by_its_beginning() {
        let long = vec![vec!["n".repeat(70_000), "rms".to_owned()], vec!["7".to_owned(), "8".repeat(70_000)]];
        for limit in [None, Some(80)] {
            let text = fitted(&long, 1, limit);
            assert!(text.contains("nn…") && text.contains("88…") && text.len() < 10_000, "{}", text.len());
        }
    }
}
