//! The page of a sensitivity.

use crate::analysis::page::grid;
use crate::analysis::page::{chart, study_file};
use crate::analysis::sensitivity::{Sensitivity, report};
use sagnac_engine::study::Study;
use sagnac_report::chart::picture::Picture;
use sagnac_report::page::sections::{Block, Page, Section};

/// The page of a sensitivity.
pub fn of_sensitivity(study: &Study, found: &Sensitivity) -> Page {
    let picture = Picture::Curves(report::figure(study, found));
    let table = report::table(found);
    let made = Block::Facts(vec![
        ("Evaluations", vec![report::effort(found)]),
        ("Seed", vec![study.seed.to_string()]),
    ]);
    Page {
        title: study.title.clone(),
        scope: String::new(),
        subtitle: format!("Which uncertain input drives the {}?", found.answer.label),
        answer: found.answer(),
        notes: found.notes.clone(),
        sections: vec![
            Section::new("tornado", "The answer as one input varies", [chart("sensitivity", picture)]),
            Section::new("inputs", "Uncertain inputs", [Block::Grid(grid(&table, &["at_from", "at_to"]))]),
            Section::new("source", "How it was made", [made, study_file(study, study.trials)]),
        ],
        tables: vec![("sensitivity.csv", table), ("distribution.csv", report::distribution(found))],
    }
}
