//! The page of a design.

use std::iter::once;

use crate::analysis::decision::Sheet;
use crate::analysis::design::{Design, report};
use crate::analysis::page::{chart, study_file};
use crate::quantity::number::significant;
use crate::view::chart::picture::Picture;
use crate::view::report::sections::{Block, Cell, Grid, Page, Section};

/// The page of a design from its chart.
pub fn of_design(found: &Design, sheet: Option<&Sheet>, picture: Picture) -> Page {
    let study = &found.study;
    let grid = |(head, lines): (Vec<String>, Vec<Vec<String>>)| {
        let rows = lines.into_iter().map(|line| line.into_iter().map(Cell::from).collect()).collect();
        Block::Grid(Grid { head, rows })
    };
    let duration = report::duration(found.variant().duration_s);
    let runs = format!("{} of {duration}", significant(found.trials as f64, 9));
    let variants = report::by_variant(found).map(grid).into_iter().collect();
    let made = Block::Facts(vec![
        ("Runs at each interval", vec![runs]),
        ("Seed", vec![study.seed.to_string()]),
        ("Chosen by", vec![format!("the {} without the non-magnetic drift", found.measure.label())]),
    ]);
    let trade = report::pareto_figure(found).map(|figure| chart("pareto", Picture::Curves(figure)));
    let trade = trade.into_iter().chain(report::by_choice(found).map(grid)).collect();
    let pareto = report::pareto_table(found).map(|table| ("pareto.csv", table));
    let section = |id, heading, blocks| Section { id, heading, blocks };
    Page {
        title: study.title.clone(),
        scope: String::new(),
        subtitle: "How often should the gyro switch, and with which filler?".to_owned(),
        answer: found.answer(sheet),
        notes: found.notes.clone(),
        sections: vec![
            section("drift", "Drift over the switching interval", vec![chart("design", picture)]),
            section("trade", "What latency and memory cost", trade),
            section("variants", "Values of swept keys at their best intervals", variants),
            section("fillers", "Fillers at their best intervals", vec![grid(report::by_filler(found))]),
            section("source", "How it was made", vec![made, study_file(study, found.trials)]),
        ],
        tables: once(("design.csv", report::table(found))).chain(pareto).collect(),
    }
}
