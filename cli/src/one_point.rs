//! Output for a study of one point: its fillers side by side.

use sagnac::quantity::number::significant;
use sagnac::table::text::{aligned, distinct};
use sagnac::table::{Cell, Column, Role, Table};

use crate::look;

/// A line for each filler with the estimates of a summary for each error.
pub fn one_point(table: &Table) -> String {
    let keys: Vec<&Column> = table.columns.iter().filter(|column| column.role == Role::Key).collect();
    let estimates: Vec<&Column> = table.columns.iter().filter(|column| column.brief).collect();
    let [fillers, errors] = keys[..] else { return String::new() };
    // The word that all labels share is omitted.
    let name = |column: &Column| column.label.trim_end_matches(" error").to_owned();
    let different = |column: &Column| -> Vec<String> {
        let texts: Vec<String> = column.cells.iter().map(Cell::text).collect();
        distinct(texts.iter()).1.into_iter().map(|first| texts[first].clone()).collect()
    };
    let (names, kinds) = (different(fillers), different(errors));
    let row_of = |filler: &str, error: &str| {
        (0..table.rows())
            .find(|&row| fillers.cells[row].text() == filler && errors.cells[row].text() == error)
    };
    let mut lines = vec![vec![fillers.label.clone()]];
    lines.extend(names.iter().map(|name| vec![name.clone()]));
    for (kind, column) in kinds.iter().flat_map(|kind| estimates.iter().map(move |column| (kind, column))) {
        let values: Vec<Option<f64>> =
            names.iter().map(|name| column.cells[row_of(name, kind)?].number()).collect();
        // What is sampled has a band, and is shown even where it is blank.
        if column.band.is_none() && values.iter().all(Option::is_none) {
            continue;
        }
        lines[0].push(format!("{kind} {}, {}", name(column), column.unit.symbol));
        for (line, value) in lines[1..].iter_mut().zip(values) {
            line.push(value.map_or_else(String::new, |value| significant(value, 4)));
        }
    }
    aligned(&lines, look::columns())
}
