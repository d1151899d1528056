//! The page of a design.

use crate::analysis::decision::Sheet;
use crate::analysis::design::{Design, report};
use crate::analysis::page::{chart, study_file};
use crate::quantity::number::significant;
use crate::study::Study;
use crate::table::Table;
use crate::view::chart::picture::Picture;
use crate::view::report::sections::{Block, Cell, Grid, Page, Section};

/// The page of a design from its table and its chart.
pub fn of_design(
    study: &Study,
    found: &Design,
    sheet: Option<&Sheet>,
    table: &Table,
    picture: Picture,
) -> Page {
    let mut sentences = report::recommendation(found).into_iter();
    let (head, lines) = report::by_filler(found);
    let rows = lines.into_iter().map(|line| line.into_iter().map(Cell::from).collect()).collect();
    let runs = format!("{} of {}", significant(found.trials as f64, 9), report::duration(found.duration_s));
    let made = Block::Facts(vec![
        ("Runs at each interval", vec![runs]),
        ("Seed", vec![study.seed.to_string()]),
        ("Chosen by", vec![format!("the {} without the non-magnetic drift", found.measure.label())]),
    ]);
    let section = |id, heading, blocks| Section { id, heading, blocks };
    Page {
        title: study.title.clone(),
        subtitle: "How often should the gyro switch, and with which filler?".to_owned(),
        sheet: sheet.map(Sheet::lines).unwrap_or_default(),
        headline: sentences.next().unwrap_or_default(),
        sentences: sentences.collect(),
        notes: found.notes.clone(),
        sections: vec![
            section("drift", "Drift over the switching interval", vec![chart("design", picture)]),
            section("fillers", "Fillers at their best intervals", vec![Block::Grid(Grid { head, rows })]),
            section("source", "How it was made", vec![made, study_file(study, found.trials)]),
        ],
        tables: vec![("design.csv", table.clone())],
    }
}
