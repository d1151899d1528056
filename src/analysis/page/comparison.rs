//! The pages of two logs that are compared, and of a batch.

use crate::analysis::batch::{self, Batch, Coefficient, Found};
use crate::analysis::compare::answer::notes;
use crate::analysis::compare::logs::{Analysis, Side};
use crate::analysis::compare::report;
use crate::analysis::log::events;
use crate::analysis::page::record::{self, Source};
use crate::analysis::page::{chart, grid, grid_where, shown, texts};
use crate::analysis::requirement::Decision;
use sagnac_base::table::titled;
use sagnac_records::allan::Deviation;
use sagnac_records::record::log::Log;
use sagnac_report::answer::reading::capitalized;
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Cell, Grid, Page, Section};

/// The page of two logs from their comparison and the decision to which it leads.
pub fn of_comparison(logs: [&Log; 2], analysis: &Analysis, decision: &Decision) -> Page {
    let [a, b] = analysis.labels();
    let figures = [("chart-1", report::curves(analysis)), ("chart-2", report::ratio(analysis))];
    let charts = figures.map(|(stem, figure)| chart(stem, Picture::Curves(figure)));
    let ratios = report::ratios(analysis);
    let title = titled("overlapping Allan deviations", analysis.unit.symbol(Deviation::Oadev));
    let of_ratios = Block::More(title, grid(&ratios, &["m_a", "m_b", "unit", "log_a", "log_b"]));
    let deviations = charts.into_iter().chain([of_ratios]);
    let coefficients = report::coefficients(analysis);
    let omitted = ["length_beyond", "described", "log_a", "log_b"];
    let of_fits = (coefficients.rows() > 0).then(|| Block::Grid(grid(&coefficients, &omitted)));
    let shows = analysis.events();
    let treatment = analysis.treatment();
    let sources = [0, 1].map(|i| {
        let (Side { log: analysis, label }, log) = (&analysis.sides[i], logs[i]);
        Source { name: label, log, channel: &log.channels[0], analysis, column: &analysis.columns[0] }
    });
    Page {
        title: format!("{a} and {b} compared"),
        scope: String::new(),
        subtitle: format!("Is {b} noisier than {a}? {}", capitalized(&treatment.summary())),
        answer: decision.answer.clone(),
        notes: notes(analysis),
        sections: vec![
            Section::new("deviations", "Deviations", deviations),
            Section::new("coefficients", "Coefficients", of_fits),
            shown("What these records show", &shows),
            record::section("Records", &sources, "records", treatment.lines(analysis.shorter_s())),
        ],
        tables: analysis
            .rows
            .is_ok()
            .then_some(("coefficients.csv", coefficients))
            .into_iter()
            .chain([
                ("compare.csv", ratios),
                ("events.csv", events::table_of(&shows)),
                ("records.csv", report::records(analysis)),
            ])
            .chain(decision.file())
            .collect(),
    }
}

/// The page of a batch of units with the decision to which it leads.
pub fn of_batch(batch: &Batch, decision: &Decision) -> Page {
    let curves = [chart("chart-1", Picture::Curves(batch::report::curves(batch)))];
    let coefficients =
        batch::report::coefficients(batch).map(|figure| chart("chart-2", Picture::Curves(figure)));
    let values = batch::report::batch(batch);
    let medians = texts(&values, "value");
    let tables = [units(batch), grid_where(&values, &["bounded", "missing"], |row| !medians[row].is_empty())]
        .map(Block::Grid);
    Page {
        title: format!("A batch of {} units", batch.labels.len()),
        scope: String::new(),
        subtitle: format!("How even are these units? {}", capitalized(&batch::report::subtitle(batch))),
        answer: decision.answer.clone(),
        notes: batch::report::notes(batch),
        sections: vec![
            Section::new("coefficients", "Coefficients", coefficients.into_iter().chain(tables)),
            Section::new("deviations", "Deviations", curves),
        ],
        tables: [
            ("batch.csv", values),
            ("units.csv", batch::report::units(batch)),
            ("records.csv", batch::report::records(batch)),
        ]
        .into_iter()
        .chain(decision.file())
        .collect(),
    }
}

/// The coefficients that a unit shows.
fn estimated(batch: &Batch) -> impl Iterator<Item = &Coefficient> {
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
        let cells = estimated(batch).map(|one| one.found[unit].as_ref().map_or_else(Cell::default, of));
        std::iter::once(label.as_str().into()).chain(cells).collect::<Vec<_>>()
    };
    let titles = estimated(batch).map(Coefficient::title);
    Grid::new(std::iter::once("unit".to_owned()).chain(titles), batch.labels.iter().enumerate().map(row))
}
