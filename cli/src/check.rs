//! `sagnac check`.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::run::{Plan, RESOLVED};
use sagnac::store::FILE as DATABASE;
use sagnac::store::error::StoreError;
use sagnac::store::folder::{Difference, Folder};
use sagnac::store::source::{Report, Source};
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac::text_file::read_bytes;

use crate::failure::{self, Failure};
use crate::folders;
use crate::output::{csv, print};
use crate::progress::{How, Shown};
use crate::results::names;

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

/// Reads everything in the folders and reports whether it is intact, complete and matches its tables. All folders are
/// read, whatever is found in the first ones.
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
    if !folder.join(DATABASE).is_file() && !folders::is_carded(folder) {
        let shown = folder.display();
        return Err(Failure::Usage(format!(
            "{shown} holds no results\ngive a folder that sagnac wrote results to"
        )));
    }
    let adopted = Folder::open(folder)?.adopt(folders::is_ours)?;
    let names = if adopted.is_empty() { "nothing".to_owned() } else { adopted.join(", ") };
    if quiet { Ok(()) } else { print(&format!("{}: took over {names}", folder.display())) }
}

fn check_folder(folder: &Path, quiet: bool) -> Result<State, Failure> {
    if folder.is_file() {
        // Reports whether it is a results folder.
        folders::study(folder)?;
    }
    let source = Source::open(folder).map_err(|error| match (error, folders::several(folder)) {
        (StoreError::NoResults(_), Some(message)) => Failure::Usage(message),
        (error, _) => error.into(),
    })?;
    let report = source.check()?;
    let mut faults: Vec<String> = report.faults.iter().map(ToString::to_string).collect();
    let mut lacking = 0;
    let mut about = String::new();
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
        faults.push(message);
    }
    let mut compared = vec![];
    if changed.is_none() {
        note!(
            "{}: an earlier version wrote it without a list of its files, so only tallies and tables are checked; `sagnac check {} \
             --adopt` makes the list",
            folder.display(),
            folder.display()
        );
    }
    if faults.is_empty() && resolved.is_file() {
        let study = Study::read(&resolved)?;
        note_unlisted(&listed, &study);
        let plan = Plan::new(&study)?;
        let store = source.into_store(&plan.identity())?;
        lacking = plan.lacks(&store, Share::WHOLE)?;
        about = match lacking {
            0 => "complete".to_owned(),
            lacking => format!("{lacking} trials are missing"),
        };
        let shares = store.shares()?;
        if shares.is_empty() {
            note!(
                "{}: it does not say which share of the trials is sampled there; all are expected",
                folder.display()
            );
        }
        if lacking > 0 && !shares.is_empty() && !shares.iter().any(Share::is_whole) {
            let missing =
                shares.iter().map(|share| plan.lacks(&store, *share)).collect::<Result<Vec<_>, _>>()?;
            let state = |trials: u64| if trials == 0 { "complete" } else { "not complete" };
            let named =
                shares.iter().zip(&missing).map(|(share, trials)| format!("{share} {}", state(*trials)));
            about = named.collect::<Vec<_>>().join(", ");
            let is_as_written = changed.as_ref().is_none_or(BTreeMap::is_empty);
            if missing.iter().all(|trials| *trials == 0) && is_as_written {
                return say_sound(folder, &report, &about, quiet).map(|()| State::Sound);
            }
        }
        let tables = plan.tables(&store, &Shown::new(if quiet { How::None } else { How::Auto }))?;
        for (source, table) in tables.all() {
            let name = source.file();
            compared.push(name);
            let path = folder.join(name);
            let earlier = format!(", {name} is from an earlier state");
            let wanted = csv(table, &path)?;
            // An interrupted run has not written the table yet, or not for all trials.
            let may_differ = match difference(name) {
                None => lacking > 0 || is_unfinished(RESOLVED),
                Some(difference) => difference == Difference::Unfinished,
            };
            // A table that is longer cannot match, so no more of it is read.
            match read_bytes(&path, wanted.len() as u64 + 1) {
                Ok(found) if found == wanted => about += &format!(", {name} matches them"),
                Err(error) if error.kind() == ErrorKind::FileTooLarge && may_differ => about += &earlier,
                Ok(_) if may_differ => about += &earlier,
                Err(_) if may_differ => {}
                Err(error) if error.kind() != ErrorKind::FileTooLarge => {
                    faults.push(format!("cannot read {}: {error}", path.display()));
                }
                _ => {
                    // A run does not replace what it cannot know as its own.
                    let is_own = changed.is_some() && difference(name).is_none();
                    let first = if is_own { "" } else { "move it away, and " };
                    faults.push(format!(
                        "{} does not match the tallies\n{first}run {} again to rebuild it",
                        path.display(),
                        resolved.display()
                    ));
                }
            }
        }
    }
    let unfinished = changed.iter().flatten().filter(|(_, found)| **found == Difference::Unfinished);
    let unfinished: Vec<&str> = unfinished.map(|(name, _)| name.as_str()).take(MAX_TOLD).collect();
    // Tables are compared with the tallies.
    for (name, difference) in changed.iter().flatten().filter(|(name, _)| !compared.contains(&name.as_str()))
    {
        let path = folder.join(name);
        match difference {
            Difference::Changed => {
                faults.push(format!("{} was changed since it was written", path.display()))
            }
            Difference::Unfinished => {}
            Difference::Unreadable => faults.push(format!("cannot read {}, which is listed", path.display())),
            // Without a study, this was said above.
            Difference::Missing if name == RESOLVED => {}
            Difference::Missing => {
                faults.push(format!("{} was removed since it was written", path.display()))
            }
        }
    }
    for fault in faults.iter().take(MAX_TOLD) {
        say!("error: {}", failure::in_options(fault));
    }
    if !faults.is_empty() {
        about = failure::faults(faults.len());
    }
    say_sound(folder, &report, &about, quiet)?;
    if !unfinished.is_empty() {
        say!(
            "{}: a command was interrupted, and what it was to write or to remove is not complete: {}",
            folder.display(),
            unfinished.join(", ")
        );
    }
    Ok(match (faults.len(), lacking) {
        (0, 0) if unfinished.is_empty() => State::Sound,
        (0, _) => State::Incomplete,
        (faults, _) => State::Faulty(faults),
    })
}

/// Notes files of a run that its list does not have, as where a command of this version began the list of an earlier one.
fn note_unlisted(folder: &Folder, study: &Study) {
    let listed = folder.listed();
    let is_unlisted = |name: &String| !listed.contains(name) && folder.path().join(name).is_file();
    let unlisted: Vec<String> = names(study).into_iter().filter(is_unlisted).take(MAX_TOLD).collect();
    if !listed.is_empty() && !unlisted.is_empty() {
        note!(
            "{}: its list lacks {}, so that changes of them are not found",
            folder.path().display(),
            unlisted.join(", ")
        );
    }
}

/// Reports intact rows and the state of the results.
fn say_sound(folder: &Path, report: &Report, about: &str, quiet: bool) -> Result<(), Failure> {
    let Report { sound, points, .. } = report;
    if !quiet {
        print(&format!("{}: {sound} rows of {points} points are intact; {about}", folder.display()))?;
    }
    Ok(())
}
