//! The noise of a log over time, with `--dynamic`.

use std::path::Path;

use sagnac::analysis::dynamic::{Column, Dynamic, figures, tables, words};
use sagnac::view::chart::picture::Picture;
use serde_json::Value;

use crate::charts::write_pictures;
use crate::failure::Failure;
use crate::output::{remove, write_table};

/// Names of the tables.
const TABLES: [&str; 2] = ["dynamic.csv", "stationarity.csv"];

/// Writes the tables and two maps for each column.
pub fn save(dynamic: &Dynamic, folder: &Path) -> Result<(), Failure> {
    let [windows, octaves] = TABLES.map(|name| folder.join(name));
    write_table(&windows, &tables::windows(dynamic))?;
    write_table(&octaves, &tables::octaves(dynamic))?;
    for (place, column) in dynamic.columns.iter().enumerate() {
        let stem = stem(place, dynamic.columns.len());
        write_pictures(folder, &stem, &Picture::Map(figures::deviations(dynamic, column)))?;
        write_pictures(folder, &format!("{stem}-ratio"), &Picture::Map(figures::ratios(dynamic, column)))?;
    }
    Ok(())
}

/// Stem of the first map of a column.
fn stem(place: usize, columns: usize) -> String {
    if columns == 1 { "chart-dynamic".to_owned() } else { format!("chart-dynamic-{}", place + 1) }
}

/// Removes what an earlier run with `--dynamic` wrote for so many columns.
pub fn remove_all(columns: usize, folder: &Path) -> Result<(), Failure> {
    let stems =
        (0..columns).map(|place| stem(place, columns)).flat_map(|stem| [format!("{stem}-ratio"), stem]);
    let pictures = stems.flat_map(|stem| ["svg", "png"].map(|ending| format!("{stem}.{ending}")));
    let mut names = TABLES.map(str::to_owned).into_iter().chain(pictures);
    names.try_for_each(|name| remove(&folder.join(name)).map(|_| ()))
}

/// Adds the noise over time to the columns of a document.
pub fn add(dynamic: &Dynamic, document: &mut Value) {
    for (place, column) in dynamic.columns.iter().enumerate() {
        document["columns"][place]["dynamic"] = tables::document(dynamic, column);
    }
}

/// A line for each column.
pub fn report(dynamic: &Dynamic) -> String {
    let line = |column: &Column| format!("{}: {}\n", column.name, words::sentence(column));
    dynamic.columns.iter().map(line).collect()
}
