//! The pages of two logs that are compared, of a batch, and of three units that ran together.

use crate::analysis::batch::{self, Batch, Coefficient, Found};
use crate::analysis::compare::answer::notes;
use crate::analysis::compare::logs::{Analysis, Side, Subject};
use crate::analysis::compare::report;
use crate::analysis::hat;
use crate::analysis::log::events;
use crate::analysis::page::record::{self, Source};
use crate::analysis::page::{chart, grid, grid_where, shown, texts};
use crate::analysis::requirement::Decision;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::titled;
use sagnac_records::allan::Deviation;
use sagnac_records::record::log::Log;
use sagnac_report::answer::reading::capitalized;
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Cell, Grid, Page, Section};

/// The page of two logs, curves or stated coefficients from their comparison and the decision to which it leads; `logs` are those
/// sides that are logs.
pub fn of_comparison(logs: [Option<&Log>; 2], analysis: &Analysis, decision: &Decision) -> Page {
    let [a, b] = analysis.labels();
    let ratios = report::ratios(analysis);
    let ratio = (ratios.rows() > 0).then(|| ("chart-2", report::ratio(analysis)));
    let figures = std::iter::once(("chart-1", report::curves(analysis))).chain(ratio);
    let charts = figures.map(|(stem, figure)| chart(stem, Picture::Curves(figure)));
    let kind = if analysis.is_of_logs() { "overlapping Allan deviations" } else { "Allan deviations" };
    let title = titled(kind, analysis.unit.symbol(Deviation::Oadev));
    let of_ratios = (ratios.rows() > 0)
        .then(|| Block::More(title, grid(&ratios, &["m_a", "m_b", "unit", "log_a", "log_b"])));
    let deviations = charts.chain(of_ratios);
    let coefficients = report::coefficients(analysis);
    let omitted = ["length_beyond", "described", "log_a", "log_b"];
    let of_fits = (coefficients.rows() > 0).then(|| Block::Grid(grid(&coefficients, &omitted)));
    let shows = analysis.events();
    let treatment = analysis.treatment();
    let source = analysis.sides.iter().zip(logs).filter_map(|(side, log)| {
        let (analysis, log) = (side.log()?, log?);
        let (channel, column) = (log.channels.first()?, analysis.columns.first()?);
        Some(Source { name: &side.label, log, channel, analysis, column })
    });
    let sources: Vec<Source> = source.collect();
    let records = treatment.map(|treatment| {
        record::section("Records", &sources, "records", treatment.lines(analysis.shorter_s()))
    });
    let summary = treatment.map(|treatment| format!(" {}", capitalized(&treatment.summary())));
    let tables = [
        analysis.rows.is_ok().then_some(("coefficients.csv", coefficients)),
        (analysis.is_of_logs() || ratios.rows() > 0).then_some(("compare.csv", ratios)),
        treatment.map(|_| ("events.csv", events::table_of(&shows))),
        treatment.map(|_| ("records.csv", report::records(analysis))),
    ];
    Page {
        title: format!("{a} and {b} compared"),
        scope: String::new(),
        subtitle: format!("Is {b} noisier than {a}?{}", summary.unwrap_or_default()),
        answer: decision.answer.clone(),
        notes: notes(analysis),
        sections: [
            Section::new("deviations", "Deviations", deviations),
            Section::new("coefficients", "Coefficients", of_fits),
            shown("What these records show", &shows),
        ]
        .into_iter()
        .chain(records)
        .chain(others(analysis))
        .collect(),
        tables: tables.into_iter().flatten().chain(decision.file()).collect(),
    }
}

/// The section on the sides that are no logs; `None` without such.
fn others(analysis: &Analysis) -> Option<Section> {
    let curves = analysis.sides.iter().filter_map(|side| Some((side, side.curve()?)));
    let curves: Vec<String> =
        curves.map(|(side, curve)| format!("{}; errors: {}", side.heading(), curve.file.errors)).collect();
    let is_stated = |side: &&Side| matches!(side.subject, Subject::Stated(_));
    let stated: Vec<String> = analysis.sides.iter().filter(is_stated).map(Side::heading).collect();
    let facts: Vec<_> = [("Curve", curves), ("Noise file", stated)]
        .into_iter()
        .filter(|(_, lines)| !lines.is_empty())
        .collect();
    (!facts.is_empty()).then(|| Section::new("given", "Curves and noise files", [Block::Facts(facts)]))
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

/// The page of three units that ran together.
pub fn of_hat(hat: &hat::Analysis) -> Page {
    let table = hat.table();
    let title = titled("Allan deviation of each unit", hat.unit.symbol(Deviation::Oadev));
    let deviations = [
        chart("chart-1", Picture::Curves(hat.figure())),
        Block::More(title, grid(&table, &["unit", "variance"])),
    ];
    let files: Vec<String> = hat
        .labels
        .iter()
        .zip(&hat.paths)
        .map(|(label, path)| format!("{label}: {}", path.display()))
        .collect();
    let samples = format!("{}, one every {} s", hat.samples, significant(hat.step_s, 9));
    let facts =
        vec![("File", files), ("Samples", vec![samples]), ("Treatment", vec![hat.treatment.summary()])];
    Page {
        title: "Three units that ran together".to_owned(),
        scope: String::new(),
        subtitle: format!("How noisy is each of {}?", hat.labels.join(", ")),
        answer: hat.answer(),
        notes: hat.notes(),
        sections: vec![
            Section::new("deviations", "Deviations", deviations),
            Section::new("record", "Records", [Block::Facts(facts)]),
        ],
        tables: vec![("hat.csv", table)],
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
