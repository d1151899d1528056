//! Tables for people, in aligned columns.

use sagnac::table::{Column, ColumnError, Table, significant};

/// Rows of a table that are shown; of longer ones every second, third, … is.
const MOST_ROWS: usize = 48;

/// One column of a table over the first sweep: a line for each of its values, a column for each curve.
///
/// # Errors
/// A name selects no single column, or the filter leaves no row.
pub fn pivot(
    table: &Table,
    across: &str,
    y: &str,
    series: &[&str],
    filter: &[(&str, String)],
) -> Result<String, ColumnError> {
    let (across, y) = (table.column(across)?, table.column(y)?);
    let series = series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    let series: Vec<&Column> = series.into_iter().filter(|column| column.name != across.name).collect();
    let (mut lines, mut curves, mut cells) = (Vec::new(), Vec::new(), Vec::new());
    for row in table.rows_where(filter)? {
        let line = place_of(&mut lines, short(across, row));
        let name: Vec<String> = series.iter().map(|column| column.cells[row].text()).collect();
        let curve = place_of(&mut curves, name.join(" "));
        cells.push((line, curve, short(y, row)));
    }
    let step = lines.len().div_ceil(MOST_ROWS).max(1);
    let mut grid = vec![vec![String::new(); curves.len() + 1]; lines.len() + 1];
    grid[0][0] = across.header();
    for (curve, name) in curves.iter().enumerate() {
        grid[0][curve + 1] = name.clone();
    }
    for (line, name) in lines.iter().enumerate() {
        grid[line + 1][0] = name.clone();
    }
    for (line, curve, text) in cells {
        grid[line + 1][curve + 1] = text;
    }
    let shown: Vec<Vec<String>> = grid
        .into_iter()
        .enumerate()
        .filter(|(i, _)| *i == 0 || (i - 1) % step == 0)
        .map(|(_, row)| row)
        .collect();
    let note = if step > 1 { format!(" (one line in {step})") } else { String::new() };
    let names: Vec<String> = series.iter().map(|column| column.name.clone()).collect();
    Ok(format!("{} by {}{note}\n{}", y.header(), names.join(", "), aligned(&shown)))
}

fn short(column: &Column, row: usize) -> String {
    column.cells[row].number().map_or_else(|| column.cells[row].text(), |x| significant(x, 4))
}

/// The place of `name` in a list, which it is added to where it is new.
fn place_of(names: &mut Vec<String>, name: String) -> usize {
    names.iter().position(|known| *known == name).unwrap_or_else(|| {
        names.push(name);
        names.len() - 1
    })
}

/// Rows of cells with every column as wide as its widest cell, flush right.
fn aligned(rows: &[Vec<String>]) -> String {
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
