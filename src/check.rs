//! The check of a results folder: whether it is intact, complete and matches its tables.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::view::file_names;
use sagnac_base::diagnostics::StudyError;
use sagnac_base::progress::Progress;
use sagnac_base::text_file::read_bytes;
use sagnac_engine::run::{Plan, RESOLVED, RunError};
use sagnac_engine::store::error::StoreError;
use sagnac_engine::store::folder::{Difference, Folder, FolderError};
use sagnac_engine::store::source::Source;
use sagnac_engine::study::Study;
use sagnac_engine::tally::Share;

/// The request for a check.
#[derive(Debug, Clone)]
pub struct CheckRequest {
    /// The folder with results of a study.
    pub folder: PathBuf,
}

/// The result of a check.
#[derive(Debug, Clone, Default)]
pub struct CheckOutcome {
    /// Number of intact rows, and of their points.
    pub intact: [u64; 2],
    /// The state of complete or incomplete results in words.
    pub about: String,
    /// Number of missing trials.
    pub missing_trials: u64,
    /// A message for each thing that is damaged, missing or changed.
    pub faults: Vec<String>,
    /// A sentence for each thing that cannot be checked.
    pub notes: Vec<String>,
    /// Files that an interrupted command was to write or to remove.
    pub unfinished: Vec<String>,
}

/// Why a folder cannot be checked.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// The study cannot be read.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The database cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The tables cannot be made.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The folder cannot be read.
    #[error(transparent)]
    Folder(#[from] FolderError),
}

/// Most files that a message lists.
const MAX_LISTED: usize = 10;

/// Reads everything in a folder and finds whether it is intact, complete and matches its tables.
///
/// # Errors
/// The folder holds no results of a study, or they cannot be read.
pub fn check(request: &CheckRequest, progress: &dyn Progress) -> Result<CheckOutcome, CheckError> {
    let folder = &request.folder;
    let source = Source::open(folder)?;
    let report = source.check()?;
    let mut found = CheckOutcome {
        intact: [report.sound, report.points],
        faults: report.faults.iter().map(ToString::to_string).collect(),
        ..CheckOutcome::default()
    };
    let shown = folder.display();
    let resolved = folder.join(RESOLVED);
    let listed = Folder::read(folder)?;
    let changed = listed.changed();
    let difference = |name: &str| changed.as_ref().and_then(|changed| changed.get(name)).copied();
    let is_unfinished = |name: &str| difference(name) == Some(Difference::Unfinished);
    if !resolved.is_file() && !is_unfinished(RESOLVED) {
        let message = format!(
            "{} is missing: whether trials are complete and tables match cannot be checked",
            resolved.display()
        );
        found.faults.push(message);
    }
    let mut compared = vec![];
    if changed.is_none() {
        found.notes.push(format!(
            "{shown}: an earlier version wrote it without a list of its files, so only tallies and tables are checked; `sagnac check \
             {shown} --adopt` makes the list"
        ));
    }
    if found.faults.is_empty() && resolved.is_file() {
        let study = Study::read(&resolved)?;
        found.notes.extend(unlisted(&listed, &study));
        let plan = Plan::new(&study)?;
        let store = source.into_store(&plan.identity())?;
        let lacking = plan.lacks(&store, Share::WHOLE)?;
        found.missing_trials = lacking;
        found.about = match lacking {
            0 => "complete".to_owned(),
            lacking => format!("{lacking} trials are missing"),
        };
        let shares = store.shares()?;
        if shares.is_empty() {
            found.notes.push(format!(
                "{shown}: it does not say which share of the trials is sampled there; all are expected"
            ));
        }
        if lacking > 0 && !shares.is_empty() && !shares.iter().any(Share::is_whole) {
            let missing =
                shares.iter().map(|share| plan.lacks(&store, *share)).collect::<Result<Vec<_>, _>>()?;
            let state = |trials: u64| if trials == 0 { "complete" } else { "not complete" };
            let named =
                shares.iter().zip(&missing).map(|(share, trials)| format!("{share} {}", state(*trials)));
            found.about = named.collect::<Vec<_>>().join(", ");
            let is_as_written = changed.as_ref().is_none_or(BTreeMap::is_empty);
            if missing.iter().all(|trials| *trials == 0) && is_as_written {
                return Ok(CheckOutcome { missing_trials: 0, ..found });
            }
        }
        let tables = plan.tables(&store, progress)?;
        for (source, table) in tables.all() {
            let name = source.file();
            compared.push(name);
            let path = folder.join(name);
            let earlier = format!(", {name} is from an earlier state");
            let mut wanted = Vec::new();
            // Writing to memory cannot fail.
            let _ = table.write_csv(&mut wanted);
            // An interrupted run has not written the table yet, or not for all trials.
            let may_differ = match difference(name) {
                None => lacking > 0 || is_unfinished(RESOLVED),
                Some(difference) => difference == Difference::Unfinished,
            };
            // A table that is longer cannot match, so no more of it is read.
            match read_bytes(&path, wanted.len() as u64 + 1) {
                Ok(own) if own == wanted => found.about += &format!(", {name} matches them"),
                Err(error) if error.kind() == ErrorKind::FileTooLarge && may_differ => {
                    found.about += &earlier
                }
                Ok(_) if may_differ => found.about += &earlier,
                Err(_) if may_differ => {}
                Err(error) if error.kind() != ErrorKind::FileTooLarge => {
                    found.faults.push(format!("cannot read {}: {error}", path.display()));
                }
                _ => {
                    // A run does not replace what it cannot know as its own.
                    let is_own = changed.is_some() && difference(name).is_none();
                    let first = if is_own { "" } else { "move it away, and " };
                    found.faults.push(format!(
                        "{} does not match the tallies\n{first}run {} again to rebuild it",
                        path.display(),
                        resolved.display()
                    ));
                }
            }
        }
    }
    let changed = changed.unwrap_or_default();
    found.unfinished = unfinished(&changed);
    // Tables are compared with the tallies, and that the study is missing was said above.
    let is_left =
        |name: &str| !compared.contains(&name) && (name != RESOLVED || changed[name] != Difference::Missing);
    let left = changed.iter().filter(|(name, _)| is_left(name));
    found.faults.extend(left.filter_map(|(name, difference)| fault(folder, name, *difference)));
    Ok(found)
}

/// The files of a folder to which commands other than `run` wrote.
#[derive(Debug, Clone, Default)]
pub struct FilesOutcome {
    /// Number of files in the list of the folder; `None` if an earlier version wrote it without one, so that nothing can be checked.
    pub listed: Option<usize>,
    /// A message for each file that was changed or removed.
    pub faults: Vec<String>,
    /// Files that an interrupted command was to write or to remove.
    pub unfinished: Vec<String>,
}

/// Finds whether all files in the list of a folder are as they were written, by their sizes and digests.
///
/// # Errors
/// The folder cannot be read.
pub fn check_files(folder: &Path) -> Result<FilesOutcome, FolderError> {
    let open = Folder::read(folder)?;
    let Some(changed) = open.changed() else { return Ok(FilesOutcome::default()) };
    let faults = changed.iter().filter_map(|(name, difference)| fault(folder, name, *difference));
    Ok(FilesOutcome {
        listed: Some(open.listed().len()),
        faults: faults.collect(),
        unfinished: unfinished(&changed),
    })
}

/// The first of the files that an interrupted command was to write or to remove.
fn unfinished(changed: &BTreeMap<String, Difference>) -> Vec<String> {
    let unfinished = changed.iter().filter(|(_, found)| **found == Difference::Unfinished);
    unfinished.map(|(name, _)| name.clone()).take(MAX_LISTED).collect()
}

/// The message for a listed file that is not as it was written; `None` for one that an interrupted command has not written yet.
fn fault(folder: &Path, name: &str, difference: Difference) -> Option<String> {
    let path = folder.join(name);
    let path = path.display();
    match difference {
        Difference::Changed => Some(format!("{path} was changed since it was written")),
        Difference::Unfinished => None,
        Difference::Unreadable => Some(format!("cannot read {path}, which is listed")),
        Difference::Missing => Some(format!("{path} was removed since it was written")),
    }
}

/// A note on files of a run that the list of its folder does not have, as where a command of this version began the list of an earlier
/// one.
fn unlisted(folder: &Folder, study: &Study) -> Option<String> {
    let listed = folder.listed();
    let is_unlisted = |name: &String| !listed.contains(name) && folder.path().join(name).is_file();
    let unlisted: Vec<String> = file_names(study).into_iter().filter(is_unlisted).take(MAX_LISTED).collect();
    (!listed.is_empty() && !unlisted.is_empty()).then(|| {
        let (shown, names) = (folder.path().display(), unlisted.join(", "));
        format!("{shown}: its list lacks {names}, so that changes of them are not found")
    })
}
