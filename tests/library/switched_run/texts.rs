//! Studies of runs as text.

use std::collections::BTreeMap;

use sagnac::study::Study;

use crate::studies::{parsed, run_afresh};

/// The drift of the paper's gyro.
pub const DRIFT: &str =
    "magnetic = \"14 arcsec/s\"\nwarm_up_time = \"3000 s\"\nnon_magnetic = \"0.05 arcsec/s\"\n";

/// A study of runs with these lines in its tables.
pub fn study(trials: u64, drift: &str, switching: &str, run: &str, more: &str) -> Study {
    let text = format!(
        "title = \"runs\"\nkind = \"switched-run\"\ntrials = {trials}\n[drift]\n{drift}[switching]\n{switching}[run]\n{run}{more}"
    );
    parsed("runs.toml", &text)
}

/// A row of a points table by column; texts are left out.
pub type Numbers = BTreeMap<String, f64>;

/// The rows of its points table.
pub fn numbers(study: &Study) -> Vec<Numbers> {
    let table = run_afresh(study);
    let row = |row: usize| {
        let cells = table.columns.iter().map(|column| (column.name.clone(), column.cells[row].number()));
        cells.filter_map(|(name, cell)| Some((name, cell?))).collect()
    };
    (0..table.rows()).map(row).collect()
}
