//! The page of a batch.

use crate::analysis::batch::report::notes;
use crate::analysis::batch::{Batch, Coefficient, Found, report};
use crate::analysis::page::{chart, grid};
use crate::analysis::requirement::Decision;
use sagnac_report::answer::reading::capitalized;
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Cell, Grid, Page, Section};

/// The page of a batch of units with the decision to which it leads.
pub fn of_batch(batch: &Batch, decision: &Decision) -> Page {
    let curves = [chart("chart-1", Picture::Curves(report::curves(batch)))];
    let coefficients = report::coefficients(batch).map(|figure| chart("chart-2", Picture::Curves(figure)));
    let values = report::batch(batch);
    let tables = [units(batch), grid(&values, &["bounded", "missing"])].map(Block::Grid);
    Page {
        title: format!("A batch of {} units", batch.labels.len()),
        scope: String::new(),
        subtitle: format!("How even are these units? {}", capitalized(&report::subtitle(batch))),
        answer: decision.answer.clone(),
        notes: notes(batch),
        sections: vec![
            Section::new("coefficients", "Coefficients", coefficients.into_iter().chain(tables)),
            Section::new("deviations", "Deviations", curves),
        ],
        tables: [
            ("batch.csv", values),
            ("units.csv", report::units(batch)),
            ("records.csv", report::records(batch)),
        ]
        .into_iter()
        .chain(decision.file())
        .collect(),
    }
}

/// The coefficients that a unit shows.
fn shown(batch: &Batch) -> impl Iterator<Item = &Coefficient> {
    batch.coefficients.iter().filter(|one| !one.estimates().is_empty())
}

/// The coefficients of all units, a row for each unit; outliers have a star.
fn units(batch: &Batch) -> Grid {
    let of = |found: &Found| {
        let star = if found.outlier.is_some() { "*" } else { "" };
        let ends = found.row.reading().and_then(|reading| reading.ends_text());
        Cell { text: format!("{star}{}", found.row.cell().text), below: ends.unwrap_or_default() }
    };
    let row = |(unit, label): (usize, &String)| {
        let cells = shown(batch).map(|one| one.found[unit].as_ref().map_or_else(Cell::default, of));
        std::iter::once(label.as_str().into()).chain(cells).collect::<Vec<_>>()
    };
    let titles = shown(batch).map(Coefficient::title);
    Grid::new(std::iter::once("unit".to_owned()).chain(titles), batch.labels.iter().enumerate().map(row))
}
