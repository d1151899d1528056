//! The page of two logs that are compared.

use crate::analysis::compare::answer::{interval, length, notes, times};
use crate::analysis::compare::logs::{Analysis, Row, Side};
use crate::analysis::compare::{Ratio, report};
use crate::analysis::log::events;
use crate::analysis::page::record::{Recorded, by_name, charts, gaps, outliers, removed, sampling};
use crate::analysis::page::{chart, shown};
use crate::analysis::requirement::Decision;
use sagnac_base::quantity::number::{probability, significant};
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
    let deviations = charts.into_iter().chain([ratios(analysis)]);
    let of_fits = analysis.rows.is_ok().then(|| ("coefficients.csv", report::coefficients(analysis)));
    let shows = analysis.events().concat();
    Page {
        title: format!("{a} and {b} compared"),
        scope: String::new(),
        subtitle: format!("Is {b} noisier than {a}? {}", capitalized(&analysis.treatment().summary())),
        answer: decision.answer.clone(),
        notes: notes(analysis),
        sections: vec![
            Section::new("deviations", "Deviations", deviations),
            Section::new("coefficients", "Coefficients", coefficients(analysis)),
            shown("What these records show", &shows),
            Section::new("record", "Records", records(logs, analysis)),
        ],
        tables: of_fits
            .into_iter()
            .chain([
                ("compare.csv", report::ratios(analysis)),
                ("events.csv", events::table_of(&shows)),
                ("records.csv", report::records(analysis)),
            ])
            .chain(decision.file())
            .collect(),
    }
}

/// A row for each averaging time.
fn ratios(analysis: &Analysis) -> Block {
    let labels = analysis.labels();
    let row = |ratio: &Ratio| {
        let values = [0, 1].map(|k| ratio.points[k].value.map_or_else(String::new, |x| significant(x, 4)));
        let [a, b] = values;
        let shown = ratio.value.map_or_else(String::new, |ratio| times(ratio, 4));
        let ends = interval(ratio.interval.map_or([None; 2], |ends| ends.map(Some)), &|x| times(x, 4));
        let verdict = ratio.verdict().map_or_else(String::new, |verdict| verdict.text(labels[1]));
        [significant(ratio.tau_s(), 7), a, b, shown, ends, verdict]
    };
    let head = ["τ, s", labels[0], labels[1], "ratio", "95 % interval", "status"];
    let title = titled("overlapping Allan deviations", analysis.unit.symbol(Deviation::Oadev));
    Block::More(title, Grid::new(head, analysis.comparison.ratios.iter().map(row)))
}

fn records(logs: [&Log; 2], analysis: &Analysis) -> Vec<Block> {
    let missing = logs.map(|log| log.channels[0].view(log.data, log.step_s).gaps());
    let sides = || analysis.sides.iter();
    let recorded = sides().zip(logs).zip(&missing);
    let recorded: Vec<Recorded> = recorded
        .map(|((side, log), gaps)| {
            let removed = removed(&side.outliers, analysis.treatment().outliers_removed, &side.events.list);
            Recorded::of(&side.label, log, &log.channels[0], &side.outliers, gaps, removed)
        })
        .collect();
    let mut blocks = charts(&recorded, "records");
    let of = |said: &dyn Fn(&Side, &Recorded) -> String| {
        by_name(sides().zip(&recorded).map(|(side, record)| (record.name, said(side, record))).collect())
    };
    blocks.push(Block::Facts(vec![
        ("Files", of(&|side, _| format!("{}, column {}", side.path.display(), side.column))),
        ("Samples", of(&|side, _| sampling(side.samples, side.step_s))),
        ("Treatment", analysis.treatment().lines(analysis.shorter_s())),
        ("Gaps", of(&|_, record| gaps(record.gaps, record.log.step_s, |sample| record.time(sample as f64)))),
        ("Outliers", of(&|_, record| outliers(record.outliers, |sample| record.time(sample as f64)))),
    ]));
    blocks
}

/// A row for each coefficient; `None` without any.
fn coefficients(analysis: &Analysis) -> Option<Block> {
    let rows = analysis.rows.as_ref().ok().filter(|rows| !rows.is_empty())?;
    let labels = analysis.labels();
    let found = ["ratio", "difference", "if equal", "status", "length needed"];
    let head = ["coefficient", "unit"].iter().chain(&labels).chain(&found).copied();
    let row = |row: &Row| {
        let found = &row.found;
        let value = |k: usize| match (found.values[k], found.at_most[k]) {
            (Some(value), _) => significant(value, 4),
            (None, Some(most)) => format!("≤ {}", significant(most, 3)),
            (None, None) => "–".to_owned(),
        };
        let within = |value: Option<f64>, ends: [Option<f64>; 2], shown: &dyn Fn(f64) -> String| Cell {
            text: value.map_or_else(|| "–".to_owned(), shown),
            below: interval(ends, shown),
        };
        [
            Cell::from(row.name),
            row.symbol.into(),
            value(0).into(),
            value(1).into(),
            within(found.ratio, found.ratio_interval, &|ratio| times(ratio, 4)),
            within(found.difference, found.interval, &|difference| significant(difference, 4)),
            found.p.map(probability).unwrap_or_default().into(),
            row.verdict().text(labels[1]).into(),
            length(row.length).into(),
        ]
    };
    Some(Block::Grid(Grid::new(head, rows.iter().map(row))))
}
