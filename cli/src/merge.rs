//! `sagnac merge`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::run::{RESOLVED, keep};
use sagnac::store::Store;
use sagnac::store::folder::Folder;
use sagnac::store::source::{Merged, Source};
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac::use_cases::Sampled;
use sagnac_base::text_file::{MAX_RECORD, MAX_TOML, read_bytes, read_text};

use crate::failure::Failure;
use crate::folders;
use crate::output::print_documents;
use crate::program::Sampling;
use crate::progress::Shown;
use crate::results::{Ran, check_places};
use crate::run::checked;

const EXAMPLES: &str = "\
Examples:
  sagnac merge results/my/shard-* --out results/my
  sagnac merge results/my --out results/copy --study my.toml
  sagnac merge --salvage results/my --out results/rescued";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Results folders of one study: of its shares, from other machines, or of interrupted runs
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Folder of the combined results; it may already contain some, which are kept
    #[arg(help_heading = "Output", long, value_name = "DIR")]
    out: PathBuf,
    /// Study file for the tables and charts [default: the resolved_study.toml that the folders share]
    #[arg(long, value_name = "STUDY")]
    study: Option<PathBuf>,
    /// Omit damaged rows instead of refusing their folder
    #[arg(long)]
    salvage: bool,
    #[command(flatten)]
    sampling: Sampling,
}

/// Merges results, and writes tables and charts of the whole.
pub fn merge(options: &Options) -> Result<(), Failure> {
    let mut study = study(options)?;
    options.sampling.apply(&mut study);
    let plan = checked(&study, options.sampling.how(), None)?;
    // All folders are checked before anything is merged, so a mistyped name or another study has no effect. They are
    // opened one at a time, as there may be thousands.
    let mut shares = BTreeSet::new();
    for folder in distinct(options) {
        let source = Source::open(folder)?;
        if !options.salvage {
            source.is_of(&plan.identity())?;
            shares.extend(source.shares()?.iter().map(|share| (share.of(), share.number())));
        }
    }
    let results = Folder::open(&options.out)?;
    check_places(&study, &plan, &results)?;
    let mut store = Store::open_in(&results, &plan.identity())?;
    keep(&study, &results)?;
    store.note_share(Share::WHOLE)?;
    for folder in distinct(options) {
        let source = Source::open(folder)?;
        let Merged { added, held, damaged } = store.merge(&source, options.salvage)?;
        if !options.sampling.printed.quiet {
            let known = if held > 0 { format!(", {held} already present") } else { String::new() };
            say!("{}: {added} rows added{known}", folder.display());
        }
        if damaged > 0 {
            note!("{}: omitted {damaged} damaged rows or pages", folder.display());
        }
    }
    let lacking = plan.lacks(&store, Share::WHOLE)?;
    let (path, json, shown) = (&*options.out, options.sampling.json, options.sampling.printed);
    let ran =
        Ran { plan: &plan, folder: &results, path, sampled: Sampled { run: None, lacking }, json, shown };
    let progress = Shown::new(options.sampling.how());
    let complete = (lacking == 0).then(|| format!("complete; results are in {}", path.display()));
    print_documents(ran.show(&store, &progress, complete)?.as_slice(), 1)?;
    match lacking {
        0 => Ok(()),
        lacking => Err(Failure::Incomplete { lacking, folder: options.out.clone(), absent: absent(&shares) }),
    }
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

/// The folders to be merged, each once, without the destination.
fn distinct(options: &Options) -> impl Iterator<Item = &PathBuf> {
    let mut is_new = folders::once(&[&options.out]);
    options.folders.iter().filter(move |folder| is_new(folder))
}

/// The study that the folders share.
fn study(options: &Options) -> Result<Study, Failure> {
    if let Some(path) = &options.study {
        return Ok(Study::read(path)?);
    }
    let mut found: Option<(PathBuf, String)> = None;
    for folder in &options.folders {
        let path = folder.join(RESOLVED);
        let text = read_text(&path, MAX_TOML).map_err(|error| {
            let why = if folder.is_dir() { error.to_string() } else { "there is no such folder".to_owned() };
            Failure::Usage(format!(
                "cannot read {}: {why}\ngive folders of results; the study itself can be given with --study FILE",
                path.display()
            ))
        })?;
        match &found {
            Some((_, first)) if *first == text => {}
            None => found = Some((path, text)),
            Some((first, first_text)) => {
                let lines = first_text.lines().zip(text.lines()).enumerate();
                let differ = lines.map(|(at, lines)| (at + 1, lines)).find(|(_, (a, b))| a != b);
                let at = differ.map_or(String::new(), |(at, (a, b))| format!(": line {at}, `{a}` and `{b}`"));
                return Err(Failure::Usage(format!(
                    "{} and {} are not the same{at}\ngive the study for the tables and charts with --study FILE, and its --trials",
                    first.display(),
                    path.display()
                )));
            }
        }
    }
    let Some((path, _)) = found else { return Err(Failure::Usage("there is nothing to merge".to_owned())) };
    let study = Study::read(&path)?;
    have_the_same_inputs(options, &study, &path)?;
    Ok(study)
}

/// Refuses folders whose input files differ from those of the study at `path`.
fn have_the_same_inputs(options: &Options, study: &Study, path: &Path) -> Result<(), Failure> {
    for input in study.inputs() {
        for folder in &options.folders {
            let other = folder.join(&input.name);
            // Folders of earlier versions do not contain them.
            if read_bytes(&other, MAX_RECORD).is_ok_and(|found| found != input.text.as_bytes()) {
                return Err(Failure::Usage(format!(
                    "{} is not what {} was run with\nmerge shards of the same {}",
                    other.display(),
                    path.display(),
                    input.name
                )));
            }
        }
    }
    Ok(())
}
