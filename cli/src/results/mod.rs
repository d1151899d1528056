//! The results of a study as files of its folder, as text and as JSON.

pub mod summary;

use std::panic::resume_unwind;
use std::sync::mpsc::{self, Receiver};
use std::thread;

use sagnac::analysis::answer::of_study;
use sagnac::analysis::decision::{Sheet, decide};
use sagnac::answer::Answer;
use sagnac::chart::Source;
use sagnac::progress::Progress;
use sagnac::quantity::number::short;
use sagnac::run::{Done, Plan, RESOLVED, Tables};
use sagnac::store::folder::Folder;
use sagnac::store::{self, Store};
use sagnac::study::Study;
use sagnac::table::{Cell, Role, Table};
use sagnac::tally::share::Share;
use sagnac::view::picture::chart_stem;
use sagnac::view::report::FILE as REPORT;
use sagnac::view::report::document::{Document, Provenance, json};
use sagnac::view::results::Results;

use crate::charts::draw;
use crate::failure::Failure;
use crate::look;
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

/// The decision sheet of complete results. `progress` receives the evaluations.
///
/// # Errors
/// A point cannot be evaluated again, or no threads can be started.
pub fn decision(
    study: &Study,
    tables: &Tables,
    lacking: u64,
    progress: &dyn Progress,
) -> Result<Option<Sheet>, Failure> {
    if lacking > 0 { Ok(None) } else { Ok(decide(study, tables, progress)?) }
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
    /// The work done, and the device, if anything can be sampled.
    pub done: Option<(&'a Done, String)>,
    /// Number of missing trials.
    pub lacking: u64,
    /// Whether results are returned as JSON instead of printed.
    pub json: bool,
    /// The parts of the results that are printed.
    pub shown: Printed,
}

impl Ran<'_> {
    /// Writes the files of all results in the store, prints what the options select, and returns the results as JSON if
    /// requested. `progress` receives the progress of fits, and is cleared.
    ///
    /// # Errors
    /// A row of the store is damaged, or a file cannot be written.
    pub fn show(&self, store: &Store, progress: &Shown) -> Result<Option<String>, Failure> {
        let Ran { plan, folder, .. } = self;
        let tables = plan.tables(store, progress)?;
        // Long tables take as long to write as everything else that is made of them. It has a thread of its own, because the
        // others wait for what they share among threads.
        let (sender, written) = mpsc::channel();
        thread::scope(|scope| {
            scope.spawn(|| {
                // Nobody listens any more where something else failed.
                let _ = sender.send(write_tables(folder, &tables));
            });
            self.show_tables(store, &tables, &written, progress)
        })
    }

    /// Writes the charts and, once the tables are `written`, the page, prints, and returns the results as JSON if requested.
    fn show_tables(
        &self,
        store: &Store,
        tables: &Tables,
        written: &Receiver<Result<String, Failure>>,
        progress: &Shown,
    ) -> Result<Option<String>, Failure> {
        let Ran { study, plan, folder, done, lacking, .. } = self;
        let degraded = done.as_ref().map_or(&[][..], |(done, _)| &done.degraded);
        let mut results = Results::of::<Failure>(study, plan, store, tables, *lacking, degraded)?;
        folder.write(RESOLVED, results.resolved().as_bytes())?;
        let sheet = decision(study, tables, *lacking, progress)?;
        let answer = of_study(study, tables, &mut results, sheet.as_ref())?;
        let page = || {
            // Without a word from the task that writes, it has panicked, and so does the scope that waits for it.
            let digest = written.recv().unwrap_or_else(|_| Ok(String::new()))?;
            folder.write(REPORT, results.page(&answer, &digest).as_bytes())?;
            Ok::<_, Failure>(())
        };
        // The picture of a chart of 10,000 points takes as long as the page.
        let (drawn, made) = thread::scope(|scope| {
            let drawn = scope.spawn(|| draw(&results.charts, folder));
            let made = page();
            (drawn.join().unwrap_or_else(|panic| resume_unwind(panic)), made)
        });
        drawn?;
        made?;
        folder.commit()?;
        progress.clear();
        if self.json {
            return Ok(Some(json(&self.document(tables, &answer, &results.notes()))));
        }
        let shown = self.shown;
        if shown.quiet && *lacking > 0 {
            return Ok(None);
        }
        let plot = || {
            let first = results.charts.first();
            first.map_or_else(String::new, |first| first.picture.text(look::of_output()))
        };
        let details = || {
            let table = if shown.table { summary(study, tables, &results.curves)? } else { String::new() };
            Ok(table)
        };
        shown.show(&self.heading(), &answer, &results.notes(), plot, details).map(|()| None)
    }

    /// The title with the number of points and trials.
    fn heading(&self) -> String {
        let points = self.study.points();
        let points = format!("{points} point{}", if points == 1 { "" } else { "s" });
        let trials = self.plan.is_sampled().then(|| format!(" × {} trials", short(self.study.trials as f64)));
        format!("{} · {points}{}", self.study.title, trials.unwrap_or_default())
    }

    fn document<'a>(&'a self, tables: &'a Tables, answer: &'a Answer, notes: &'a [String]) -> Document<'a> {
        let study = self.study;
        let provenance = self.plan.is_sampled().then(|| Provenance {
            device: self.done.as_ref().map(|(_, device)| device.clone()),
            sampled_trials: self.done.as_ref().map(|(done, _)| done.trials),
            seconds: self.done.as_ref().map(|(done, _)| done.seconds),
            missing_trials: self.lacking,
            ..Provenance::new(study.seed, study.trials)
        });
        let tables = tables.all().map(|(source, table)| (source.file(), table));
        Document { provenance, ..Document::new([&study.title, &study.question], answer, notes, tables) }
    }
}
