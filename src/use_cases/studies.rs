//! The use case of studies: what a store holds of a study, after a run or a merge, as an outcome.

use crate::analysis::answer::facts;
use crate::analysis::decision::{DecisionError, decide};
use crate::analysis::page::Results;
use crate::use_cases::Outcome;
use sagnac_base::progress::Progress;
use sagnac_engine::run::{Plan, RESOLVED, RunStats, Tables};
use sagnac_engine::store::Store;
use sagnac_report::page::Provenance;

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
