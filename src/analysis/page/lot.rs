//! The page of a batch.

use crate::analysis::lot::answer::notes;
use crate::analysis::lot::pool::Pooled;
use crate::analysis::lot::{Coefficient, Found, Lot, figures, tables};
use crate::analysis::page::chart;
use crate::analysis::page::interval;
use crate::analysis::requirement::Decision;
use crate::answer::reading::capitalized;
use crate::quantity::number::probability;
use crate::quantity::number::significant;
use crate::table::titled;
use crate::view::chart::picture::Picture;
use crate::view::report::sections::{Block, Cell, Grid, Page, Section};

/// The page of a batch of units with the decision to which it leads.
pub fn of_lot(lot: &Lot, decision: &Decision) -> Page {
    let curves = [chart("chart-1", Picture::Curves(figures::curves(lot)))];
    let coefficients = figures::coefficients(lot).map(|figure| chart("chart-2", Picture::Curves(figure)));
    let tables = [of_units(lot), of_batch(lot)].map(Block::Grid);
    Page {
        title: format!("A batch of {} units", lot.labels.len()),
        scope: String::new(),
        subtitle: format!("How even are these units? {}", capitalized(&figures::subtitle(lot))),
        answer: decision.answer.clone(),
        notes: notes(lot),
        sections: vec![
            Section::new("coefficients", "Coefficients", coefficients.into_iter().chain(tables)),
            Section::new("deviations", "Deviations", curves),
        ],
        tables: [
            ("batch.csv", tables::lot(lot)),
            ("units.csv", tables::units(lot)),
            ("records.csv", tables::records(lot)),
        ]
        .into_iter()
        .chain(decision.file())
        .collect(),
    }
}

/// The coefficients that a unit shows.
fn shown(lot: &Lot) -> impl Iterator<Item = &Coefficient> {
    let is_shown = |one: &&Coefficient| one.found.iter().flatten().any(|found| found.estimate().is_some());
    lot.coefficients.iter().filter(is_shown)
}

/// The coefficients of all units, a row for each unit; outliers have a star, and bounds a sign before them.
fn of_units(lot: &Lot) -> Grid {
    let titles = shown(lot).map(|one| titled(&one.title(), one.symbol));
    let cell = |found: &Found| {
        let mark = if found.odd.is_some() { "*" } else { "" };
        match (found.row.value, found.row.interval) {
            (Some(value), ends) => Cell {
                text: format!("{mark}{}", significant(value, 4)),
                below: ends.map(interval).unwrap_or_default(),
            },
            (None, Some([_, most])) => format!("≤ {}", significant(most, 3)).into(),
            (None, None) => found.row.verdict.into(),
        }
    };
    let row = |(unit, label): (usize, &String)| {
        let cells = shown(lot).map(|one| one.found[unit].as_ref().map_or_else(Cell::default, cell));
        std::iter::once(label.as_str().into()).chain(cells).collect::<Vec<_>>()
    };
    let head = std::iter::once("unit".to_owned()).chain(titles);
    Grid::new(head, lot.labels.iter().enumerate().map(row))
}

/// The values of the batch, a row for each coefficient.
fn of_batch(lot: &Lot) -> Grid {
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
    let rows = shown(lot).flat_map(|one| {
        let all = one.pooled.map(|pooled| (one, one.title(), pooled));
        let without = format!("{} without outliers", one.title());
        all.into_iter().chain(one.without_odd.map(|pooled| (one, without, pooled)))
    });
    Grid::new(head, rows.map(row))
}
