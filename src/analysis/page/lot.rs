//! The page of a batch.

use crate::analysis::lot::answer::notes;
use crate::analysis::lot::{Lot, figures, tables};
use crate::analysis::page::chart;
use crate::analysis::requirement::Decision;
use crate::view::chart::picture::Picture;
use crate::view::report::sections::{Page, Section};

/// The page of a batch of units with the decision to which it leads.
pub fn of_lot(lot: &Lot, decision: &Decision) -> Page {
    let section = |id, heading, stem, figure| Section {
        id,
        heading,
        blocks: Option::into_iter(figure).map(|figure| chart(stem, Picture::Curves(figure))).collect(),
    };
    Page {
        title: format!("A batch of {} units", lot.labels.len()),
        subtitle: figures::subtitle(lot),
        answer: decision.answer.clone(),
        notes: notes(lot),
        sections: vec![
            section("coefficients", "Coefficients", "chart-2", figures::coefficients(lot)),
            section("deviations", "Deviations", "chart-1", Some(figures::curves(lot))),
        ],
        tables: vec![("batch.csv", tables::lot(lot)), ("units.csv", tables::units(lot))],
    }
}
