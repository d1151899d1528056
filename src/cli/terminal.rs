//! Tables for people, in aligned columns.

use std::collections::HashMap;

use sagnac::table::{Column, ColumnError, Table, significant};

/// Rows of a table that are shown; of longer ones every second, third, … is.
const MOST_ROWS: usize = 48;

/// Significant digits of a number: as few as tell it from the others beside it.
const DIGITS: std::ops::RangeInclusive<usize> = 4..=17;

/// One column of a table over the sweeps: a line for each combination of their values, a column for each curve.
///
/// `sweeps` are the columns that name lines, but for those in `series`; the first of them always is. What else differs
/// between rows, filler or error, names columns too, so that no cell has two values.
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
) -> Result<String, ColumnError> {
    let columns = |names: &[&str]| names.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>();
    let (sweeps, y, mut series) = (columns(sweeps)?, table.column(y)?, columns(series)?);
    series.retain(|column| sweeps.first().is_none_or(|first| column.name != first.name));
    let rows = table.rows_where(filter)?;
    let unnamed = |column: &&Column| series.iter().all(|named| named.name != column.name);
    let mut across: Vec<Names> = sweeps.into_iter().filter(unnamed).map(|c| Names::new(c, &rows)).collect();
    let others = columns(texts)?.into_iter().filter(unnamed).map(|c| Names::new(c, &rows));
    let mut curves: Vec<Names> = series.iter().map(|column| Names::new(column, &rows)).collect();
    curves.extend(others.filter(Names::differ));
    // The first sweep stands for the lines even where it has one value.
    let mut first = true;
    across.retain(|names| std::mem::take(&mut first) || names.differ());
    let (line_of, lines) = combinations(&across, rows.len());
    let (curve_of, columns) = combinations(&curves, rows.len());
    let least = lines.len().div_ceil(MOST_ROWS).max(1);
    // A step that shares no factor with a faster sweep does not show the same of its values again and again.
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
        let cell = &y.cells[row];
        let text = cell.number().map_or_else(|| cell.text(), |x| significant(x, *DIGITS.start()));
        grid[line_of[at] + 1][across.len() + curve_of[at]] = text;
    }
    let shown: Vec<Vec<String>> = grid
        .into_iter()
        .enumerate()
        .filter(|(i, _)| *i == 0 || (i - 1) % step == 0)
        .map(|(_, row)| row)
        .collect();
    let note = if step > 1 { format!(" (one line in {step})") } else { String::new() };
    let names: Vec<String> = curves.iter().map(|names| names.column.title()).collect();
    let by = if names.is_empty() { String::new() } else { format!(", by {}", names.join(" and ")) };
    Ok(format!("{}{by}{note}\n{}", y.title(), aligned(&shown)))
}

/// The different values of a column in the rows shown.
struct Names<'t> {
    column: &'t Column,
    /// For each row shown, the place of its value in `texts`.
    values: Vec<usize>,
    texts: Vec<String>,
}

impl<'t> Names<'t> {
    fn new(column: &'t Column, rows: &[usize]) -> Names<'t> {
        // Debug writes a number with as many digits as it has.
        let (values, firsts) = distinct(rows.iter().map(|&row| format!("{:?}", column.cells[row])));
        let text = |digits: usize| {
            let cells = firsts.iter().map(|&at| &column.cells[rows[at]]);
            cells
                .map(|cell| cell.number().map_or_else(|| cell.text(), |x| significant(x, digits)))
                .collect::<Vec<String>>()
        };
        let tells_apart = |texts: &Vec<String>| distinct(texts.iter()).1.len() == texts.len();
        let texts = DIGITS.map(text).find(tells_apart).unwrap_or_else(|| text(*DIGITS.end()));
        Names { column, values, texts }
    }

    fn differ(&self) -> bool {
        self.texts.len() > 1
    }

    /// The value in a row shown.
    fn at(&self, at: usize) -> &str {
        &self.texts[self.values[at]]
    }
}

/// The place of each item among the different ones, and where each of these first stands.
fn distinct<T: std::hash::Hash + Eq>(items: impl Iterator<Item = T>) -> (Vec<usize>, Vec<usize>) {
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

/// The same of the combinations of several columns, over `count` rows.
fn combinations(columns: &[Names], count: usize) -> (Vec<usize>, Vec<usize>) {
    distinct((0..count).map(|at| columns.iter().map(|names| names.values[at]).collect::<Vec<_>>()))
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Rows of cells with every column as wide as its widest cell, flush right.
pub(super) fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    rows.iter()
        .map(|row| {
            let cells: Vec<String> =
                row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:>width$}")).collect();
            format!("  {}\n", cells.join("  "))
        })
        .collect()
}
