//! Running a study.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sagnac::device::select::Selection;
use sagnac::report::answer::Answer;
use sagnac::report::page::{FILE as REPORT, Page};
use sagnac::run::{Plan, RunStats, Tables, keep};
use sagnac::store::Store;
use sagnac::store::folder::Folder;
use sagnac::study::Study;
use sagnac::table::Table;
use sagnac::tally::Share;
use sagnac::use_cases::Outcome;
use sagnac::use_cases::{Sampled, study_outcome};
use sagnac::verify::select;
use sagnac::view::pictures;
use sagnac_engine::chart::Source;

use super::analysis::chart;
use super::compute::compute;
use super::failure::{Failure, in_python};
use super::progress::Listener;
use super::table::columns;

/// Width of the answer as text.
const WIDTH: usize = 80;

/// The request.
struct Asked {
    /// Path of the study; `None` for a study given as text.
    path: Option<PathBuf>,
    text: String,
    trials: Option<u64>,
    seed: Option<u64>,
    device: String,
    threads: usize,
    /// The results folder, and whether tables are written to it.
    folder: PathBuf,
    is_kept: bool,
}

/// The study in a file, or that of a text if there is no `path`.
///
/// # Errors
/// It cannot be read, or is invalid.
pub fn study_of(path: Option<&Path>, text: &str) -> Result<Study, Failure> {
    Ok(match path {
        Some(path) => Study::read(path)?,
        None => Study::parse("study", text)?,
    })
}

/// An answer as Python takes it: its headline, and the whole as text, as HTML and as JSON.
pub fn shown(answer: &Answer) -> [String; 4] {
    let document = serde_json::to_string(answer).unwrap_or_default();
    [answer.headline.clone(), answer.text(WIDTH), answer.card("", &[]).into_string(), document]
}

/// A study that was run.
struct Ran {
    study: Study,
    is_sampled: bool,
    page: Page,
    done: Option<(RunStats, String)>,
}

/// Runs a study from a file, or from its text if there is no `path`, and returns its tables and report.
#[pyfunction]
#[pyo3(signature = (path, text, trials, seed, device, threads, folder, is_kept, progress))]
#[expect(clippy::too_many_arguments, reason = "each is one of the function in Python")]
pub fn run<'py>(
    py: Python<'py>,
    path: Option<PathBuf>,
    text: String,
    trials: Option<u64>,
    seed: Option<u64>,
    device: String,
    threads: usize,
    folder: PathBuf,
    is_kept: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let asked = Asked { path, text, trials, seed, device, threads, folder, is_kept };
    let listener = Listener::new(progress);
    let ran = compute(py, || asked.run(&listener))?;
    let document = PyDict::new(py);
    let sampled = ran.is_sampled.then_some(());
    let done = ran.done.as_ref().map(|(done, _)| done);
    document.set_item("title", &ran.study.title)?;
    document.set_item("question", &ran.study.question)?;
    document.set_item("kind", ran.study.kind().name)?;
    document.set_item("seed", sampled.map(|()| ran.study.seed))?;
    document.set_item("trials", sampled.map(|()| ran.study.trials))?;
    document.set_item("device", ran.done.as_ref().map(|(_, device)| device))?;
    document.set_item("sampled_trials", done.map(|done| done.trials))?;
    document.set_item("seconds", done.map(|done| done.seconds))?;
    document
        .set_item("notes", ran.page.all_notes().iter().map(|note| in_python(note)).collect::<Vec<_>>())?;
    let charts = ran.page.charts().map(|drawn| chart(&drawn.stem, &drawn.picture));
    document.set_item("charts", charts.collect::<Vec<_>>())?;
    document.set_item("answer", shown(&ran.page.answer))?;
    document.set_item("report", ran.page.html(&|text: &str| in_python(text)))?;
    for source in [Source::Points, Source::Coefficients, Source::Trajectories] {
        let table = ran.page.tables.iter().find(|(file, _)| *file == source.file());
        let name = source.file().trim_end_matches(".csv");
        document.set_item(name, table.map(|(_, table)| columns(py, table)).transpose()?)?;
    }
    Ok(document)
}

impl Asked {
    fn run(&self, listener: &Listener) -> Result<Ran, Failure> {
        let mut study = study_of(self.path.as_deref(), &self.text)?;
        study.trials = self.trials.unwrap_or(study.trials);
        study.seed = self.seed.unwrap_or(study.seed);
        let plan = Plan::new(&study)?;
        // Checks for errors that would otherwise occur after sampling.
        pictures(&study, &plan.blank_tables(), 0)?;
        let kept = self.is_kept.then(|| Folder::open(&self.folder)).transpose()?;
        let mut store = match &kept {
            Some(folder) => Store::open_in(folder, &plan.identity())?,
            None => Store::open(&self.folder, &plan.identity())?,
        };
        if let Some(folder) = &kept {
            // Kept from the start, as the run may be killed.
            keep(&study, folder)?;
            store.note_share(Share::WHOLE)?;
        }
        let mut done = None;
        if plan.is_sampled() {
            let Selection { mut device, .. } = select(&self.device, self.threads)?;
            let name = device.name();
            done = Some((plan.run(&mut store, &mut device, Share::WHOLE, listener)?, name));
        }
        let raised = || listener.raised().map_or(Ok(()), |error| Err(Failure::Python(error)));
        raised()?;
        let write = |tables: &Tables| {
            let Some(folder) = &kept else {
                return Ok(tables.points.write_csv(std::io::sink()).unwrap_or_default());
            };
            let write = |(source, table): (Source, &Table)| {
                folder.write_by(source.file(), |file| table.write_csv(file).map(drop))
            };
            let digests = tables.all().map(write).collect::<Result<Vec<_>, _>>()?;
            Ok::<_, Failure>(digests.into_iter().next().unwrap_or_default())
        };
        // A run that ended early has raised an exception before.
        let mut results =
            study_outcome(&plan, &store, &Sampled { run: done.clone(), lacking: 0 }, write, listener)?;
        raised()?;
        results.complete(listener)?;
        raised()?;
        let Outcome { page, files, .. } = results.outcome;
        if let Some(folder) = &kept {
            for (name, contents) in &files {
                folder.write(name, contents)?;
            }
            folder.write(REPORT, page.html(&|text: &str| in_python(text)).as_bytes())?;
            folder.commit()?;
        }
        let is_sampled = plan.is_sampled();
        drop(plan);
        Ok(Ran { is_sampled, page, done, study })
    }
}
