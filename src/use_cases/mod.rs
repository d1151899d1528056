//! The use cases: each is a function from a request to an [`Outcome`], a page with its tables and further files, for any front end.
//!
//! The outcome of a study is what a store holds of it, after a run or a merge.

mod added;
mod convert;
mod logs;
#[cfg(feature = "store")]
mod merge;
mod simulate;
mod switched;

use std::collections::BTreeMap;

use crate::analysis::answer::facts;
use crate::analysis::decision::{DecisionError, decide};
use crate::analysis::model::tables::{ModelDocument, Models};
use crate::analysis::page::Results;
use sagnac_base::progress::Progress;
use sagnac_base::table::Table;
use sagnac_engine::run::{Plan, RESOLVED, RunStats, Tables};
use sagnac_engine::store::Store;
use sagnac_report::page::Page;
use sagnac_report::page::{Document, Provenance, json};

pub use added::{MotionText, Sensitivity, Warming};
pub use convert::{Conversion, Converted, convert};
pub use logs::{
    AllanRequest, BatchRequest, CompareRequest, LogError, ModelSource, Segments, allan, compare_logs,
    compare_units, fit_curve, model_noise, three_cornered_hat,
};
#[cfg(feature = "store")]
pub use merge::{MergeError, MergeOutcome, MergeRequest, absolute, check_places, merge, once};
pub use simulate::{Numbers, SimulateError, SimulateRequest, Simulation};

/// The result of a use case, with the contents of its files by their names.
#[derive(Debug)]
pub struct Outcome {
    /// Name of a folder for it among the results of a study; empty where it is of none.
    pub name: String,
    /// A line above the answer.
    pub heading: String,
    /// The page, whose charts and tables are files too.
    pub page: Page,
    /// Tables as text that are printed before the sections of the page, where tables are asked for.
    pub details: String,
    /// Tables that the page has no room for, by the names of their files.
    pub tables: Vec<(&'static str, Table)>,
    /// Further files by their names.
    pub files: Vec<(String, Vec<u8>)>,
    /// The names of all files that the use case may write besides its page, in which a star stands for any text, and the stems of
    /// charts. Those that it did not write this time belong to an earlier outcome.
    pub names: Vec<String>,
    /// How the results were sampled, if anything was.
    pub provenance: Option<Provenance>,
    /// The models for filters, of a use case that finds some.
    pub models: Option<Models>,
}

impl Outcome {
    /// A page alone, of a use case that writes its charts and tables always.
    pub fn new(heading: String, page: Page) -> Outcome {
        let (details, tables, files, names) = (String::new(), vec![], vec![], vec![]);
        let name = String::new();
        Outcome { name, heading, page, details, tables, files, names, provenance: None, models: None }
    }

    /// Names the files and charts that the use case may write; see [`Outcome::names`].
    #[must_use]
    pub fn among<'n>(self, names: impl IntoIterator<Item = &'n str>) -> Outcome {
        Outcome { names: names.into_iter().map(str::to_owned).collect(), ..self }
    }

    /// The tables of the page, and those that it has no room for.
    pub fn all_tables(&self) -> impl Iterator<Item = &(&'static str, Table)> {
        self.page.tables.iter().chain(&self.tables)
    }

    /// The document for programs as JSON, with settings in the words of `spell`.
    pub fn json(&self, spell: &dyn Fn(&str) -> String) -> String {
        let document = self.page.document(&self.tables);
        let notes = document.notes.iter().map(|note| spell(note)).collect();
        let document = Document { provenance: self.provenance.clone(), notes, ..document };
        let Some(model) = &self.models else { return json(&document) };
        let text = |(name, contents): &(String, Vec<u8>)| {
            (name.clone(), String::from_utf8_lossy(contents).into_owned())
        };
        let files: BTreeMap<String, String> = self.files.iter().map(text).collect();
        json(&ModelDocument { document, model, files })
    }

    /// Adds the document for programs as a file.
    pub fn add_json(&mut self, name: &str, spell: &dyn Fn(&str) -> String) {
        let text = self.json(spell);
        self.files.push((name.to_owned(), text.into_bytes()));
    }
}

/// The state of the sampling of a study.
#[derive(Debug, Clone, Default)]
pub struct Sampled {
    /// The work of the run that has ended, and the name of its device; `None` where nothing ran.
    pub run: Option<(RunStats, String)>,
    /// Number of trials that the store lacks.
    pub lacking: u64,
}

/// The outcome of a study. Its page has everything but the facts that have to be sampled.
#[derive(Debug)]
pub struct StudyOutcome<'a> {
    plan: &'a Plan<'a>,
    /// The outcome.
    pub outcome: Outcome,
    /// Whether [`complete`](StudyOutcome::complete) adds facts: the error budget, and the change of an input that helps most.
    pub is_partial: bool,
}

/// Reports what `store` holds of a study. `write` gets the tables as soon as they are there, while the page is made, and returns the
/// SHA-256 of the points that [`Table::write_csv`](sagnac_base::table::Table::write_csv) gives. `progress` receives numbers of
/// fits.
///
/// # Errors
/// A row of the store is damaged, the table lacks what a chart requires, or `write` fails.
pub fn study_outcome<'a, E: From<DecisionError> + Send>(
    plan: &'a Plan<'a>,
    store: &Store,
    sampled: &Sampled,
    write: impl FnOnce(&Tables) -> Result<String, E> + Send,
    progress: &dyn Progress,
) -> Result<StudyOutcome<'a>, E> {
    let tables = plan.tables(store, progress).map_err(DecisionError::from)?;
    let (study, run) = (plan.study(), sampled.run.as_ref());
    let mut digest = None;
    let results = rayon::in_place_scope(|scope| {
        scope.spawn(|_| digest = Some(write(&tables)));
        Results::new(plan, store, &tables, sampled.lacking, run.map_or(&[], |(stats, _)| &stats.degraded))
    })?;
    let digest = digest.unwrap_or_else(|| unreachable!("a scope waits for what it spawned"))?;
    let (resolved, is_partial) = (results.resolved(), results.is_partial);
    let mut page = results.page(&digest);
    page.tables = tables.into_files(&study.charts);
    let provenance = plan.is_sampled().then(|| Provenance {
        device: run.map(|(_, device)| device.clone()),
        sampled_trials: run.map(|(stats, _)| stats.trials),
        seconds: run.map(|(stats, _)| stats.seconds),
        missing_trials: sampled.lacking,
        ..Provenance::new(study.seed, study.trials)
    });
    let outcome = Outcome::new(format!("{} · {}", page.title, page.scope), page);
    let files = vec![(RESOLVED.to_owned(), resolved.into_bytes())];
    Ok(StudyOutcome { plan, outcome: Outcome { provenance, files, ..outcome }, is_partial })
}

impl StudyOutcome<'_> {
    /// Adds the facts that have to be sampled, if there are any. `progress` receives the evaluations.
    ///
    /// # Errors
    /// A point cannot be evaluated again, or no threads can be started.
    pub fn complete(&mut self, progress: &dyn Progress) -> Result<(), DecisionError> {
        if self.is_partial {
            let (study, page) = (self.plan.study(), &mut self.outcome.page);
            let tables = Tables::from_files(std::mem::take(&mut page.tables));
            let sheet = decide(study, &tables, progress)?;
            page.answer.facts = facts(study, &tables, sheet.as_ref(), &page.answer);
            page.tables = tables.into_files(&study.charts);
            self.is_partial = false;
        }
        Ok(())
    }
}
