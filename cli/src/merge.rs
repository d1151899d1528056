//! `sagnac merge`.

use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::store::source::Merged;
use sagnac::study::Study;
use sagnac::use_cases::{self, MergeOutcome, MergeRequest, Sampled};

use crate::failure::Failure;
use crate::output::print_documents;
use crate::program::Sampling;
use crate::progress::Shown;
use crate::results::Ran;
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
    let request =
        MergeRequest { folders: options.folders.clone(), out: options.out.clone(), salvage: options.salvage };
    let mut study = match &options.study {
        Some(path) => Study::read(path)?,
        None => request.study()?,
    };
    options.sampling.apply(&mut study);
    let plan = checked(&study, options.sampling.how(), None)?;
    let quiet = options.sampling.printed.quiet;
    let merged = |folder: &Path, Merged { added, held, damaged }| {
        if !quiet {
            let known = if held > 0 { format!(", {held} already present") } else { String::new() };
            say!("{}: {added} rows added{known}", folder.display());
        }
        if damaged > 0 {
            note!("{}: omitted {damaged} damaged rows or pages", folder.display());
        }
    };
    let MergeOutcome { folder, store, lacking, absent } = use_cases::merge(&plan, &request, merged)?;
    let (path, json, shown) = (&*options.out, options.sampling.json, options.sampling.printed);
    let ran =
        Ran { plan: &plan, folder: &folder, path, sampled: Sampled { run: None, lacking }, json, shown };
    let progress = Shown::new(options.sampling.how());
    let complete = (lacking == 0).then(|| format!("complete; results are in {}", path.display()));
    print_documents(ran.show(&store, &progress, complete)?.as_slice(), 1)?;
    match lacking {
        0 => Ok(()),
        lacking => Err(Failure::Incomplete { lacking, folder: options.out.clone(), absent }),
    }
}
