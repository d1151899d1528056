//! `sagnac check`.

use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::run::Plan;
use sagnac::store::Source;
use sagnac::study::Study;

use super::Failure;
use super::output::print;
use super::progress::Shown;
use super::results::{RESOLVED, csv, files};

#[derive(Debug, Args)]
pub struct Options {
    /// Results folders
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Print only errors
    #[arg(long, short)]
    quiet: bool,
}

/// How a folder is.
enum State {
    Sound,
    /// So many trials are missing.
    Incomplete(u64),
    /// So many things are wrong.
    Faulty(usize),
}

/// Most faults of a folder that are told one by one.
const MOST_TOLD: usize = 10;

/// Reads everything in the folders and says whether it is sound, complete, and what the tables say.
pub fn check(options: &Options) -> Result<(), Failure> {
    let (mut faulty, mut incomplete) = (0, None);
    for folder in &options.folders {
        match check_folder(folder, options.quiet)? {
            State::Sound => {}
            State::Incomplete(lacking) => incomplete = Some((lacking, folder.clone())),
            State::Faulty(faults) => faulty += faults,
        }
    }
    match incomplete {
        _ if faulty > 0 => Err(Failure::Unsound(faulty)),
        Some((lacking, folder)) => Err(Failure::Incomplete { lacking, folder }),
        None => Ok(()),
    }
}

fn check_folder(folder: &Path, quiet: bool) -> Result<State, Failure> {
    let source = Source::open(folder)?;
    let report = source.check()?;
    let mut faults: Vec<String> = report.faults.iter().map(ToString::to_string).collect();
    let mut lacking = 0;
    let mut about = "no study is beside them".to_owned();
    let resolved = folder.join(RESOLVED);
    if faults.is_empty() && resolved.is_file() {
        let study = Study::read(&resolved)?;
        let plan = Plan::new(&study)?;
        let store = source.into_store(&plan.identity())?;
        lacking = plan.lacks(&store)?;
        about = if lacking == 0 { "complete".to_owned() } else { format!("{lacking} trials are missing") };
        let tables = plan.tables(&store, &Shown::new(quiet))?;
        for (name, table) in files(&tables) {
            let path = folder.join(name);
            match std::fs::read(&path) {
                Ok(found) if found == csv(table, &path)? => about += &format!(", {name} is what they give"),
                // A run that was stopped has not made it yet, or not of all.
                Ok(_) if lacking > 0 => about += &format!(", {name} is of an earlier state"),
                Err(_) if lacking > 0 => {}
                Ok(_) => faults.push(format!(
                    "{} is not what the tallies give\nrun {} again to make it anew",
                    path.display(),
                    resolved.display()
                )),
                Err(error) => faults.push(format!("cannot read {}: {error}", path.display())),
            }
        }
    }
    for fault in faults.iter().take(MOST_TOLD) {
        eprintln!("error: {fault}");
    }
    if !quiet {
        let rows =
            format!("{}: {} rows of {} points are sound", folder.display(), report.sound, report.points);
        match faults.len() {
            0 => print(&format!("{rows}; {about}"))?,
            n => print(&format!("{rows}; {n} faults"))?,
        }
    }
    Ok(match (faults.len(), lacking) {
        (0, 0) => State::Sound,
        (0, lacking) => State::Incomplete(lacking),
        (faults, _) => State::Faulty(faults),
    })
}
