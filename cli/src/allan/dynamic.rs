//! The noise of a log over time, with `--dynamic`.

use sagnac::analysis::dynamic::{Column, Dynamic, figures, tables, words};
use sagnac::store::folder::Folder;
use sagnac::view::chart::picture::Picture;
use serde_json::Value;

use crate::charts::{remove_undrawn, write_pictures};
use crate::failure::Failure;
use crate::output::write_or_remove;

/// Writes the tables and the maps, and removes those of an earlier run that this one lacks.
pub fn save(dynamic: Option<&Dynamic>, folder: &Folder) -> Result<(), Failure> {
    write_or_remove(folder, "dynamic.csv", dynamic.map(tables::windows))?;
    write_or_remove(folder, "stationarity.csv", dynamic.map(tables::octaves))?;
    let mut drawn = Vec::new();
    for (stem, map) in dynamic.map_or(vec![], figures::figures).into_iter().flatten() {
        write_pictures(folder, &stem, &Picture::Map(map))?;
        drawn.push(stem);
    }
    remove_undrawn(folder, &drawn, |stem| stem.starts_with(figures::STEM))
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
