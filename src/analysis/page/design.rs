//! The page of a design.

use crate::analysis::decision::Sheet;
use crate::analysis::design::{Design, report};
use crate::analysis::page::grid;
use crate::analysis::page::{chart, study_file};
use sagnac_base::quantity::number::significant;
use sagnac_report::chart::picture::Picture;
use sagnac_report::page::sections::{Block, Page, Section};

/// The page of a design from its chart.
pub fn of_design(found: &Design, sheet: Option<&Sheet>, picture: Picture) -> Page {
    let study = &found.study;
    let duration = report::duration(found.variant().duration_s);
    let runs = format!("{} of {duration}", significant(found.trials as f64, 9));
    let made = Block::Facts(vec![
        ("Runs at each interval", vec![runs]),
        ("Seed", vec![study.seed.to_string()]),
        ("Chosen by", vec![format!("the {} without the non-magnetic drift", found.measure.label())]),
    ]);
    let trade = report::pareto_figure(found).map(|figure| chart("pareto", Picture::Curves(figure)));
    let (pareto, fillers) = (report::pareto_table(found), report::filler_table(found));
    let front = pareto.as_ref().map(|table| Block::Grid(grid(table, &["constants"])));
    let trade = trade.into_iter().chain(front);
    let at_best = Block::Grid(grid(&fillers, &["constants", "duration", "residual_max", "rule_bound"]));
    Page {
        title: study.title.clone(),
        scope: String::new(),
        subtitle: "How often should the gyro switch, and with which filler?".to_owned(),
        answer: found.answer(sheet),
        notes: found.notes.clone(),
        sections: vec![
            Section::new("drift", "Drift over the switching interval", [chart("design", picture)]),
            Section::new("trade", "What latency and memory cost", trade),
            Section::new("fillers", "Fillers at their best intervals", [at_best]),
            Section::new("source", "How it was made", [made, study_file(study, found.trials)]),
        ],
        tables: [("design.csv", report::table(found)), ("fillers.csv", fillers)]
            .into_iter()
            .chain(pareto.map(|table| ("pareto.csv", table)))
            .collect(),
    }
}
