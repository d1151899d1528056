//! `sagnac check`.

use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::check::{CheckError, CheckOutcome, CheckRequest, FilesOutcome, check as find, check_files};
use sagnac::store::FILE as DATABASE;
use sagnac::store::error::StoreError;
use sagnac::store::folder::Folder;

use crate::failure::{self, Failure};
use crate::output::print;
use crate::progress::{How, Shown};
use crate::results;

const EXAMPLES: &str = "\
Examples:
  sagnac check results/my
  sagnac check results/my results/copy --quiet";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Results folders
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Take over the files of folders of earlier versions, which kept no list of them, so that later commands replace them;
    /// nothing is checked
    #[arg(long)]
    adopt: bool,
    /// Print only errors
    #[arg(help_heading = "Output", long, short)]
    quiet: bool,
}

/// State of a folder.
enum State {
    Sound,
    /// Trials are missing.
    Incomplete,
    /// This number of faults was found.
    Faulty(usize),
}

/// Most faults of a folder that are listed individually.
const MAX_TOLD: usize = 10;

/// Reads everything in the folders and reports whether it is intact, complete and matches its tables; of other commands than `run`,
/// whether their files are as they were written. All folders are read, whatever is found in the first ones.
pub fn check(options: &Options) -> Result<(), Failure> {
    if options.adopt {
        return options.folders.iter().try_for_each(|folder| adopt(folder, options.quiet));
    }
    let (mut faulty, mut incomplete, mut unread) = (0, vec![], None);
    for folder in &options.folders {
        match check_folder(folder, options.quiet) {
            Ok(State::Sound) => {}
            Ok(State::Incomplete) => incomplete.push(folder.clone()),
            Ok(State::Faulty(faults)) => faulty += faults,
            Err(failure @ Failure::OutputClosed) => return Err(failure),
            Err(failure) => {
                if let Some(before) = unread.replace(failure) {
                    before.report();
                }
            }
        }
    }
    match unread {
        Some(failure) => Err(failure),
        None if faulty > 0 => Err(Failure::Unsound(faulty)),
        None if !incomplete.is_empty() => Err(Failure::Unfinished(incomplete)),
        None => Ok(()),
    }
}

/// Enters the files of results into the list of their folder.
fn adopt(folder: &Path, quiet: bool) -> Result<(), Failure> {
    if !folder.join(DATABASE).is_file() && !results::is_carded(folder) {
        let shown = folder.display();
        return Err(Failure::Usage(format!(
            "{shown} holds no results\ngive a folder that sagnac wrote results to"
        )));
    }
    let adopted = Folder::open(folder)?.adopt(results::is_ours)?;
    let names = if adopted.is_empty() { "nothing".to_owned() } else { adopted.join(", ") };
    if quiet { Ok(()) } else { print(&format!("{}: took over {names}", folder.display())) }
}

fn say_faults(faults: &[String]) {
    for fault in faults.iter().take(MAX_TOLD) {
        say!("error: {}", failure::in_options(fault));
    }
}

fn say_unfinished(folder: &Path, unfinished: &[String]) {
    if !unfinished.is_empty() {
        say!(
            "{}: a command was interrupted, and what it was to write or to remove is not complete: {}",
            folder.display(),
            unfinished.join(", ")
        );
    }
}

/// Checks the files of a command other than `run`, whose numbers no study can give again.
fn files(folder: &Path, command: &str, quiet: bool) -> Result<State, Failure> {
    let shown = folder.display();
    let FilesOutcome { listed, faults, unfinished } = check_files(folder)?;
    let Some(listed) = listed else {
        return Err(Failure::Usage(format!(
            "{shown} holds output of `sagnac {command}` of an earlier version, which kept no list of its files: nothing can be checked\n\
             `sagnac check {shown} --adopt` makes the list"
        )));
    };
    say_faults(&faults);
    if !quiet {
        print(&match faults.len() {
            0 => format!("{shown}: {listed} files of `sagnac {command}` are as they were written"),
            count => {
                format!("{shown}: {} among {listed} files of `sagnac {command}`", failure::faults(count))
            }
        })?;
    }
    say_unfinished(folder, &unfinished);
    Ok(match faults.len() {
        0 if unfinished.is_empty() => State::Sound,
        0 => State::Incomplete,
        faults => State::Faulty(faults),
    })
}

fn check_folder(folder: &Path, quiet: bool) -> Result<State, Failure> {
    if folder.is_file() {
        // Reports whether it is a results folder.
        results::study(folder)?;
    }
    let is_other = !results::is_study(folder) && !folder.join(DATABASE).is_file();
    if let Some(command) = results::writer(folder).filter(|_| is_other) {
        return files(folder, command, quiet);
    }
    let progress = Shown::new(if quiet { How::None } else { How::Auto });
    let found = find(&CheckRequest { folder: folder.to_owned() }, &progress);
    let found = found.map_err(|error| match (error, results::several(folder)) {
        (CheckError::Store(StoreError::NoResults(_)), Some(message)) => Failure::Usage(message),
        (CheckError::Study(error), _) => error.into(),
        (CheckError::Store(error), _) => error.into(),
        (CheckError::Run(error), _) => error.into(),
        (CheckError::Folder(error), _) => error.into(),
    })?;
    let CheckOutcome { intact: [rows, points], about, missing_trials, faults, notes, unfinished } = found;
    notes.iter().for_each(|note| note!("{note}"));
    say_faults(&faults);
    if !quiet {
        let about = if faults.is_empty() { about } else { failure::faults(faults.len()) };
        print(&format!("{}: {rows} rows of {points} points are intact; {about}", folder.display()))?;
    }
    say_unfinished(folder, &unfinished);
    Ok(match (faults.len(), missing_trials) {
        (0, 0) if unfinished.is_empty() => State::Sound,
        (0, _) => State::Incomplete,
        (faults, _) => State::Faulty(faults),
    })
}
