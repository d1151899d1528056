//! The page of a batch.

use crate::analysis::batch::random_effects::Pooled;
use crate::analysis::batch::report::notes;
use crate::analysis::batch::{Batch, Coefficient, Found, report};
use crate::analysis::page::log::cell;
use crate::analysis::page::{chart, interval};
use crate::analysis::requirement::Decision;
use sagnac_base::quantity::number::{probability, significant};
use sagnac_base::table::titled;
use sagnac_report::answer::reading::capitalized;
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Cell, Grid, Page, Section};

/// The page of a batch of units with the decision to which it leads.
pub fn of_batch(batch: &Batch, decision: &Decision) -> Page {
    let curves = [chart("chart-1", Picture::Curves(report::curves(batch)))];
    let coefficients = report::coefficients(batch).map(|figure| chart("chart-2", Picture::Curves(figure)));
    let tables = [units(batch), values(batch)].map(Block::Grid);
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
            ("batch.csv", report::batch(batch)),
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
        let Cell { text, below } = cell(&found.row);
        Cell { text: if found.outlier.is_some() { format!("*{text}") } else { text }, below }
    };
    let row = |(unit, label): (usize, &String)| {
        let cells = shown(batch).map(|one| one.found[unit].as_ref().map_or_else(Cell::default, of));
        std::iter::once(label.as_str().into()).chain(cells).collect::<Vec<_>>()
    };
    let titles = shown(batch).map(|one| titled(&one.title(), one.symbol));
    Grid::new(std::iter::once("unit".to_owned()).chain(titles), batch.labels.iter().enumerate().map(row))
}

/// The values of the batch, a row for each coefficient.
fn values(batch: &Batch) -> Grid {
    let head = ["batch", "units", "median", "unit-to-unit SD, %", "95 % prediction interval", "equal units"];
    let row = |(one, name, pooled): (&Coefficient, String, Pooled)| -> Vec<Cell> {
        vec![
            titled(&name, one.symbol).into(),
            format!("{} of {}", pooled.units, one.found.len()).into(),
            Cell { text: significant(pooled.value, 4), below: interval(pooled.interval) },
            Cell {
                text: significant(100.0 * pooled.spread, 3),
                below: interval(pooled.spread_interval.map(|end| 100.0 * end)),
            },
            interval(pooled.next).into(),
            probability(pooled.p_equal).into(),
        ]
    };
    let rows = shown(batch).flat_map(|one| {
        let all = one.pooled.map(|pooled| (one, one.title(), pooled));
        let without = format!("{} without outliers", one.title());
        all.into_iter().chain(one.without_outliers.map(|pooled| (one, without, pooled)))
    });
    Grid::new(head, rows.map(row))
}
