//! What a study of one point says to people: its fillers side by side, and the best of them for each error.

use sagnac::table::{ColumnError, Table, significant};

use super::terminal::aligned;

/// A line for each filler and a pair of columns, rms and 99.73 % level, for each error; then the filler of the least 99.73 %
/// level, and how far the next one is.
///
/// # Errors
/// The table has not the columns of a gap-fill study.
pub fn one_point(table: &Table) -> Result<String, ColumnError> {
    let (fillers, errors) = (table.column("filler")?, table.column("error")?);
    let (rms, level) = (table.column("rms")?, table.column("q9973")?);
    let distinct = |cells: &[sagnac::table::Cell]| {
        let mut texts: Vec<String> = Vec::new();
        for text in cells.iter().map(sagnac::table::Cell::text) {
            if !texts.contains(&text) {
                texts.push(text);
            }
        }
        texts
    };
    let (names, kinds) = (distinct(&fillers.cells), distinct(&errors.cells));
    let row_of = |filler: &str, error: &str| {
        (0..table.rows())
            .find(|&row| fillers.cells[row].text() == filler && errors.cells[row].text() == error)
    };
    let mut header = vec!["filler".to_owned()];
    for kind in &kinds {
        header.extend([format!("{kind} rms, ″"), format!("{kind} 99.73 %, ″")]);
    }
    let mut lines = vec![header];
    for name in &names {
        let mut line = vec![name.clone()];
        for kind in &kinds {
            let cell = |column: &sagnac::table::Column| {
                let number = row_of(name, kind).and_then(|row| column.cells[row].number());
                number.map_or_else(String::new, |x| significant(x, 4))
            };
            line.extend([cell(rms), cell(level)]);
        }
        lines.push(line);
    }
    let mut text = aligned(&lines);
    for kind in &kinds {
        let value = |name: &String| row_of(name, kind).and_then(|row| level.cells[row].number());
        let mut ranked: Vec<(f64, &String)> =
            names.iter().filter_map(|name| Some((value(name)?, name))).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let [(least, best), (second, next), ..] = ranked[..] {
            let (least_text, ratio) = (significant(least, 4), significant(second / least, 3));
            text +=
                &format!("\nleast 99.73 % {kind}: {best}, {least_text} ″; next {next}, {ratio} times that");
        }
    }
    Ok(text + "\n")
}
