//! The page of a lot.

use crate::analysis::lot::words::{notes, sentences};
use crate::analysis::lot::{Lot, figures, tables};
use crate::analysis::page::chart;
use crate::analysis::requirement::Decision;
use crate::view::chart::picture::Picture;
use crate::view::report::sections::{Page, Section};

/// The page of a lot of units with the decision to which it leads.
pub fn of_lot(lot: &Lot, decision: &Decision) -> Page {
    let mut sentences = sentences(lot).into_iter();
    let section = |id, heading, stem, figure| Section {
        id,
        heading,
        blocks: Option::into_iter(figure).map(|figure| chart(stem, Picture::Curves(figure))).collect(),
    };
    Page {
        title: format!("A lot of {} units", lot.labels.len()),
        subtitle: figures::subtitle(lot),
        headline: sentences.next().unwrap_or_default(),
        sheet: decision.lines.headed(),
        sentences: sentences.collect(),
        notes: notes(lot),
        sections: vec![
            section("coefficients", "Coefficients", "chart-2", figures::coefficients(lot)),
            section("deviations", "Deviations", "chart-1", Some(figures::curves(lot))),
        ],
        tables: vec![("lot.csv", tables::lot(lot)), ("units.csv", tables::units(lot))],
    }
}
