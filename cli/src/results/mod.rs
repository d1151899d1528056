//! The results of a study as files of its folder, as text and as JSON.

pub mod summary;

use std::panic::resume_unwind;
use std::path::Path;
use std::thread;

use sagnac::analysis::page::Results;
use sagnac::chart::Source;
use sagnac::report::page::FILE as REPORT;
use sagnac::report::page::document::{Provenance, json};
use sagnac::run::{Plan, RESOLVED, RunStats, Tables};
use sagnac::store::folder::Folder;
use sagnac::store::{self, Store};
use sagnac::study::Study;
use sagnac::table::{Cell, Role, Table};
use sagnac::tally::Share;
use sagnac::view::picture::chart_stem;

use crate::failure::Failure;
use crate::outcome::Outcome;
use crate::output::{Printed, write_table};
use crate::progress::Shown;
use crate::results::summary::summary;

/// Whether a run of a study may write the files that it always writes into its folder.
///
/// # Errors
/// The folder has a file of somebody else in the place of one of them.
pub fn check_places(study: &Study, plan: &Plan, folder: &Folder) -> Result<(), Failure> {
    let resolved = study.resolved(study.trials);
    let inputs = study.inputs();
    let kept = inputs.iter().map(|input| (input.name.as_str(), input.text.as_bytes()));
    let kept = kept.chain([(RESOLVED, resolved.as_bytes())]);
    let names = names(study);
    let written = names.iter().filter(|name| *name != RESOLVED).map(|name| (name.as_str(), None));
    let is_kept = |name: &str| inputs.iter().any(|input| input.name == name);
    let written = written.filter(|(name, _)| !is_kept(name));
    let tables = plan.blank_tables();
    let tables = tables.all().map(|(source, _)| (source.file(), None));
    Ok(folder.check(kept.map(|(name, text)| (name, Some(text))).chain(written).chain(tables))?)
}

/// The names of the files that a run of a study always writes into its folder.
pub fn names(study: &Study) -> Vec<String> {
    let inputs = study.inputs().into_iter().map(|input| input.name.clone());
    let charts = (0..study.charts.len()).map(|index| chart_stem(index, study.charts.len()));
    let pictures = charts.flat_map(|stem| ["svg", "png"].map(|ending| format!("{stem}.{ending}")));
    let fixed = [RESOLVED, REPORT, Source::Points.file()].map(str::to_owned);
    fixed.into_iter().chain(inputs).chain(pictures).collect()
}

/// The store of existing results; an empty one for closed forms.
///
/// # Errors
/// The folder is in use, belongs to another study or kernel, or is damaged.
pub fn held(folder: &Folder, plan: &Plan) -> Result<Store, Failure> {
    Ok(store::Source::open_in(folder)?.into_store(&plan.identity())?)
}

/// Number of trials that existing results lack. If rows of all requested trials exist, this is known to be 0 without
/// another look into the store.
///
/// # Errors
/// A row of the store is damaged, or the disk fails.
pub fn lacking(study: &Study, plan: &Plan, store: &Store, tables: &Tables) -> Result<u64, Failure> {
    let trials = tables.points.of_role(Role::Trials);
    let has_all = |cell: &Cell| cell.number().is_some_and(|trials| trials >= study.trials as f64);
    match trials {
        Some(trials) if study.precision.is_none() && trials.cells.iter().all(has_all) => Ok(0),
        _ => Ok(plan.lacks(store, Share::WHOLE)?),
    }
}

/// Whether [`chart_stem`] gives this name to a chart.
pub fn is_chart_stem(stem: &str) -> bool {
    let number = stem.strip_prefix("chart-").and_then(|number| number.parse().ok());
    stem == "chart" || number.is_some_and(|number: usize| number >= 1 && stem == format!("chart-{number}"))
}

/// Writes the tables of a study, and returns the SHA-256 of the first, that of its points.
fn write_tables(folder: &Folder, tables: &Tables) -> Result<String, Failure> {
    let write = |(source, table): (Source, &Table)| write_table(folder, source.file(), table);
    let digests = tables.all().map(write).collect::<Result<Vec<_>, _>>()?;
    Ok(digests.into_iter().next().unwrap_or_default())
}

/// A study with results to show.
pub struct Ran<'a> {
    pub study: &'a Study,
    pub plan: &'a Plan<'a>,
    pub folder: &'a Folder,
    /// The path of the folder.
    pub path: &'a Path,
    /// The work done, and the device, if anything can be sampled.
    pub done: Option<(&'a RunStats, String)>,
    /// Number of missing trials.
    pub lacking: u64,
    /// Whether results are returned as JSON instead of printed.
    pub json: bool,
    /// The parts of the results that are printed.
    pub shown: Printed,
}

impl Ran<'_> {
    /// Writes the files of all results in the store, and prints them with the line `place` below them, or returns them as JSON if
    /// requested. `progress` receives the progress of fits, and is cleared.
    ///
    /// # Errors
    /// A row of the store is damaged, or a file cannot be written.
    pub fn show(
        &self,
        store: &Store,
        progress: &Shown,
        place: Option<String>,
    ) -> Result<Option<String>, Failure> {
        let Ran { study, plan, folder, done, lacking, shown, .. } = self;
        let tables = plan.tables(store, progress)?;
        let degraded = done.as_ref().map_or(&[][..], |(done, _)| &done.degraded);
        // Long tables take as long to write as everything else that is made of them. They have a thread of their own, because the
        // others wait for what they share among threads.
        let mut outcome = thread::scope(|scope| {
            let written = scope.spawn(|| write_tables(folder, &tables));
            let results = Results::new(plan, store, &tables, *lacking, degraded, progress)?;
            let resolved = (RESOLVED.to_owned(), results.resolved().into_bytes());
            let details = if shown.table { summary(study, &tables, &results.curves)? } else { String::new() };
            let page = results.page(&written.join().unwrap_or_else(|panic| resume_unwind(panic))?);
            let outcome = Outcome::new(format!("{} · {}", page.title, page.scope), page);
            let (files, places) = (vec![resolved], place.into_iter().collect());
            Ok::<_, Failure>(Outcome { details, provenance: self.provenance(), files, places, ..outcome })
        })?;
        outcome.page.tables = tables.into_files(&study.charts);
        let mut pictures = folder.listed();
        let stem = |name: &String| {
            name.strip_suffix(".svg").or(name.strip_suffix(".png")).is_some_and(is_chart_stem)
        };
        pictures.retain(stem);
        outcome.save_page(folder, &pictures.iter().map(String::as_str).collect::<Vec<_>>())?;
        progress.clear();
        if self.json || shown.quiet && *lacking > 0 {
            shown.open_page(self.path);
        } else {
            outcome.show(shown, self.path)?;
        }
        Ok(self.json.then(|| json(&outcome.document())))
    }

    /// How the results were sampled, if they were.
    fn provenance(&self) -> Option<Provenance> {
        let done = self.done.as_ref();
        self.plan.is_sampled().then(|| Provenance {
            device: done.map(|(_, device)| device.clone()),
            sampled_trials: done.map(|(done, _)| done.trials),
            seconds: done.map(|(done, _)| done.seconds),
            missing_trials: self.lacking,
            ..Provenance::new(self.study.seed, self.study.trials)
        })
    }
}
