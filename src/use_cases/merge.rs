//! The use case of merging: the results of shares, of other machines or of interrupted runs become one folder.

use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};

use crate::view::file_names;
use sagnac_base::diagnostics::StudyError;
use sagnac_base::text_file::{MAX_RECORD, MAX_TOML, read_bytes, read_text};
use sagnac_engine::run::{Plan, RESOLVED, RunError, keep};
use sagnac_engine::store::Store;
use sagnac_engine::store::error::StoreError;
use sagnac_engine::store::folder::{Folder, FolderError};
use sagnac_engine::store::source::{Merged, Source};
use sagnac_engine::study::Study;
use sagnac_engine::tally::Share;

/// The request for a merge.
#[derive(Debug, Clone)]
pub struct MergeRequest {
    /// Folders of results of one study.
    pub folders: Vec<PathBuf>,
    /// Folder of the combined results; those that it already contains are kept.
    pub out: PathBuf,
    /// Whether damaged rows are omitted instead of refused.
    pub salvage: bool,
}

/// The result of a merge.
#[derive(Debug)]
pub struct MergeOutcome {
    /// The folder of the combined results.
    pub folder: Folder,
    /// The store of the combined results.
    pub store: Store,
    /// Number of trials that the store lacks.
    pub lacking: u64,
    /// The shares that no folder contained, if all shares belong to one split.
    pub absent: Vec<Share>,
}

/// Why folders cannot be merged.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A folder has no study.
    #[error("cannot read {}: {why}", path.display())]
    NoStudy {
        /// The study that a folder of results contains.
        path: PathBuf,
        /// The reason why it cannot be read.
        why: String,
    },
    /// Two folders have different studies.
    #[error("{} and {} are not the same{line}", paths[0].display(), paths[1].display())]
    DifferentStudies {
        /// The two studies.
        paths: [PathBuf; 2],
        /// The first line that differs.
        line: String,
    },
    /// Two folders have different input files.
    #[error("{} is not what {} was run with\nmerge shards of the same {name}", path.display(), study.display())]
    DifferentInputs {
        /// The input file.
        path: PathBuf,
        /// The study of another folder.
        study: PathBuf,
        /// The name of the input file.
        name: String,
    },
    /// A study cannot be read.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A database cannot be read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The folder of the combined results cannot be written, or has files of somebody else.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The study cannot be kept in the folder.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl MergeRequest {
    /// The study that all folders have, for a merge whose study is not given.
    ///
    /// # Errors
    /// A folder has no study, or two folders differ in their study or its input files.
    pub fn study(&self) -> Result<Study, MergeError> {
        let mut first: Option<(PathBuf, String)> = None;
        for folder in &self.folders {
            let path = folder.join(RESOLVED);
            let text = match read_text(&path, MAX_TOML) {
                Ok(text) => text,
                Err(error) if folder.is_dir() => {
                    return Err(MergeError::NoStudy { path, why: error.to_string() });
                }
                Err(_) => {
                    return Err(MergeError::NoStudy { path, why: "there is no such folder".to_owned() });
                }
            };
            match &first {
                Some((_, known)) if *known == text => {}
                None => first = Some((path, text)),
                Some((other, known)) => {
                    let mut lines = known.lines().zip(text.lines()).enumerate();
                    let line = lines
                        .find(|(_, (a, b))| a != b)
                        .map_or(String::new(), |(at, (a, b))| format!(": line {}, `{a}` and `{b}`", at + 1));
                    return Err(MergeError::DifferentStudies { paths: [other.clone(), path], line });
                }
            }
        }
        let nothing =
            || MergeError::NoStudy { path: RESOLVED.into(), why: "there are no folders".to_owned() };
        let (path, _) = first.ok_or_else(nothing)?;
        let study = Study::read(&path)?;
        self.have_the_same_inputs(&study, &path)?;
        Ok(study)
    }

    /// Refuses folders whose input files differ from those of the study at `path`.
    fn have_the_same_inputs(&self, study: &Study, path: &Path) -> Result<(), MergeError> {
        for input in study.inputs() {
            for folder in &self.folders {
                let other = folder.join(&input.name);
                // Folders of earlier versions do not contain them.
                if read_bytes(&other, MAX_RECORD).is_ok_and(|found| found != input.text.as_bytes()) {
                    let (study, name) = (path.to_owned(), input.name.clone());
                    return Err(MergeError::DifferentInputs { path: other, study, name });
                }
            }
        }
        Ok(())
    }

    /// The folders to be merged, each once, without the destination.
    fn distinct(&self) -> impl Iterator<Item = &PathBuf> {
        let mut is_new = once(&[&self.out]);
        self.folders.iter().filter(move |folder| is_new(folder))
    }
}

/// Merges folders of results of the plan's study. `merged` gets each folder when it is done.
///
/// # Errors
/// A folder is of another study or is damaged, which is found before anything is merged; or the destination cannot be written.
pub fn merge(
    plan: &Plan,
    request: &MergeRequest,
    mut merged: impl FnMut(&Path, Merged),
) -> Result<MergeOutcome, MergeError> {
    let study = plan.study();
    // All folders are checked before anything is merged, so a mistyped name or another study has no effect. They are
    // opened one at a time, as there may be thousands.
    let mut shares = BTreeSet::new();
    for folder in request.distinct() {
        let source = Source::open(folder)?;
        if !request.salvage {
            source.is_of(&plan.identity())?;
            shares.extend(source.shares()?.iter().map(|share| (share.of(), share.number())));
        }
    }
    let folder = Folder::open(&request.out)?;
    check_places(plan, &folder)?;
    let mut store = Store::open_in(&folder, &plan.identity())?;
    keep(study, &folder)?;
    store.note_share(Share::WHOLE)?;
    for folder in request.distinct() {
        merged(folder, store.merge(&Source::open(folder)?, request.salvage)?);
    }
    let lacking = plan.lacks(&store, Share::WHOLE)?;
    Ok(MergeOutcome { folder, store, lacking, absent: absent(&shares) })
}

/// The shares that no folder contained, if all shares belong to one split.
fn absent(shares: &BTreeSet<(u64, u64)>) -> Vec<Share> {
    match shares.first().zip(shares.last()) {
        Some((&(first, _), &(of, _))) if first == of => (1..=of)
            .filter(|&number| !shares.contains(&(of, number)))
            .filter_map(|i| Share::new(i, of))
            .collect(),
        _ => vec![],
    }
}

/// A filter that passes each folder once, whatever its paths, and those of `taken` never.
pub fn once(taken: &[&Path]) -> impl FnMut(&Path) -> bool + use<> {
    let mut taken: HashSet<PathBuf> = taken.iter().map(|path| absolute(path)).collect();
    move |folder| taken.insert(absolute(folder))
}

/// The absolute path without links; the given one if the file system cannot resolve it.
pub fn absolute(path: &Path) -> PathBuf {
    let path = if path == Path::new("") { Path::new(".") } else { path };
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Whether a run of a study, or a merge, may write the files that it always writes into its folder.
///
/// # Errors
/// The folder has a file of somebody else in the place of one of them.
pub fn check_places(plan: &Plan, folder: &Folder) -> Result<(), FolderError> {
    let study = plan.study();
    let resolved = study.resolved(study.trials);
    let inputs = study.inputs();
    let kept = inputs.iter().map(|input| (input.name.as_str(), input.text.as_bytes()));
    let kept = kept.chain([(RESOLVED, resolved.as_bytes())]);
    let names = file_names(study);
    let written = names.iter().filter(|name| *name != RESOLVED).map(|name| (name.as_str(), None));
    let is_kept = |name: &str| inputs.iter().any(|input| input.name == name);
    let written = written.filter(|(name, _)| !is_kept(name));
    let tables = plan.blank_tables();
    let tables = tables.all().map(|(source, _)| (source.file(), None));
    folder.check(kept.map(|(name, text)| (name, Some(text))).chain(written).chain(tables))
}
