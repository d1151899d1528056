//! Errors of commands, with their exit codes.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use sagnac::analysis::decision::DecisionError;
use sagnac::analysis::firmware::ChoiceError;
use sagnac::analysis::model::ModelError;
use sagnac::device::GpuError;
use sagnac::device::select::SelectError;
use sagnac::record::RecordError;
use sagnac::run::{RESOLVED, RunError};
use sagnac::store::error::StoreError;
use sagnac::store::folder::FolderError;
use sagnac::tally::Share;
use sagnac::use_cases::{LogError, MergeError};
use sagnac_base::diagnostics::{StudyError, spelled};

use crate::look;
use crate::output::say;
use crate::run::Cause;
use sagnac_base::quantity::number::short;

/// Exit codes with their meanings.
pub const EXIT_CODES: [(&str, &str); 8] = [
    ("0", "done"),
    ("1", "runtime error"),
    ("2", "wrong usage, unknown device"),
    ("3", "invalid study or log, folder of another study or version"),
    ("4", "stopped or incomplete; run again to continue"),
    ("5", "a check failed"),
    ("6", "storage or output (full, read-only, locked)"),
    ("130, 143", "signals: Ctrl-C (SIGINT), SIGTERM; completed work is kept, run again to continue"),
];

/// Why a command did not complete its task.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error("{0}")]
    Usage(String),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Log(RecordError),
    /// A log lacks something that an option requires.
    #[error("{0}")]
    Record(String),
    #[error("{}", in_options(.0))]
    Select(#[from] SelectError),
    #[error("{}", in_options(.0))]
    Store(#[from] StoreError),
    #[error("{0}\nchoose another device with --device; `sagnac device list` lists the available ones")]
    Gpu(#[from] GpuError),
    /// A device error during a run.
    #[error("{0}\ncompleted work is kept: run again to continue, or use --device cpu")]
    Interrupted(GpuError),
    #[error("{0}")]
    Picture(String),
    #[error("cannot write {path}: {source}")]
    Write { path: PathBuf, source: std::io::Error },
    #[error("{}", in_options(.0))]
    Folder(#[from] FolderError),
    #[error("cannot write to the standard output: {0}\nredirect it to a place with free space and run again")]
    Output(std::io::Error),
    #[error("cannot listen for signals: {0}")]
    Signals(std::io::Error),
    #[error(
        "stopped by {cause}: {} of {} {} are kept in {folder}\nresumable: run the same command again to continue; `sagnac report {folder}` builds a report from the partial results",
        short(reached.0 as f64), short(reached.1 as f64), reached.2
    )]
    Stopped { cause: Cause, reached: (u64, u64, &'static str), folder: PathBuf },
    #[error(
        "stopped by {cause} after planning {} of {} points: nothing was sampled\nrun the same command with more time; a run samples only after all points are planned",
        short(reached.0 as f64), short(reached.1 as f64)
    )]
    Unplanned { cause: Cause, reached: (u64, u64) },
    #[error(
        "{folder} is incomplete: {} trials are missing{}\nmerge the shares that contain them, or sample them with `sagnac run {folder}/{RESOLVED}`",
        short(*lacking as f64), of_shares(absent)
    )]
    Incomplete { lacking: u64, folder: PathBuf, absent: Vec<Share> },
    #[error("not complete: {}\nrepeat the command of each, or merge the existing results", named(.0))]
    Unfinished(Vec<PathBuf>),
    #[error("{} found", faults(*.0))]
    Unsound(usize),
    #[error("a kernel gives different bits: do not trust results of that device")]
    Different,
    /// The reader of the output has closed it, so no message is printed.
    #[error("the output was closed")]
    OutputClosed,
}

/// Whether a file is in the place of a folder.
fn is_no_folder(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::AlreadyExists | ErrorKind::NotADirectory)
}

/// The missing shards.
fn of_shares(absent: &[Share]) -> String {
    match absent {
        [] => String::new(),
        [share] => format!("; {share} is missing"),
        [first, ..] => {
            let numbers: Vec<String> = absent.iter().map(|share| share.number().to_string()).collect();
            format!("; shares {} of {} are missing", numbers.join(", "), first.of())
        }
    }
}

fn named(folders: &[PathBuf]) -> String {
    folders.iter().map(|folder| folder.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// A number of faults in words.
pub fn faults(count: usize) -> String {
    if count == 1 { "1 fault".to_owned() } else { format!("{count} faults") }
}

/// Settings of the library for which the program has options.
const OPTIONS: [&str; 42] = [
    "at",
    "axes",
    "band",
    "binary",
    "bootstrap",
    "by",
    "column",
    "curve_interval",
    "data",
    "decimal",
    "device",
    "duplicates",
    "dynamic",
    "filler",
    "fit",
    "fit_from",
    "fit_to",
    "force",
    "from",
    "length",
    "motion",
    "noise",
    "out",
    "overbound",
    "quantization",
    "rate",
    "remove_outliers",
    "salvage",
    "scale",
    "segment",
    "skip",
    "states",
    "switch_every",
    "tau",
    "temperature",
    "temperature_unit",
    "time",
    "time_unit",
    "to",
    "unit",
    "unit_check",
    "where",
];

/// A setting as an option.
fn option(name: &str, value: &str) -> Option<String> {
    let name = OPTIONS.contains(&name).then(|| name.replace('_', "-"))?;
    Some(match value {
        "true" => format!("--{name}"),
        _ if value.contains(' ') && !value.contains('"') => format!("--{name} \"{value}\""),
        _ => format!("--{name} {value}"),
    })
}

/// A message of the library in terms of options.
pub fn in_options(message: &dyn std::fmt::Display) -> String {
    spelled(&message.to_string(), &option)
}

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Failure {
        Failure::Log(error.spelled(&option))
    }
}

impl From<ChoiceError> for Failure {
    fn from(error: ChoiceError) -> Failure {
        match error {
            ChoiceError::Asked(message) => Failure::Usage(in_options(&message)),
            ChoiceError::Study(error) => Failure::Study(error),
        }
    }
}

impl From<MergeError> for Failure {
    fn from(error: MergeError) -> Failure {
        match error {
            MergeError::Study(error) => error.into(),
            MergeError::Store(error) => error.into(),
            MergeError::Folder(error) => error.into(),
            MergeError::Run(error) => error.into(),
            error @ MergeError::NoStudy { .. } => Failure::Usage(format!(
                "{error}\ngive folders of results; the study itself can be given with --study FILE"
            )),
            error @ MergeError::DifferentStudies { .. } => Failure::Usage(format!(
                "{error}\ngive the study for the tables and charts with --study FILE, and its --trials"
            )),
            error @ MergeError::DifferentInputs { .. } => Failure::Usage(error.to_string()),
        }
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Failure {
        match error {
            LogError::Limit(error) => Failure::Usage(format!("--limit: {error}")),
            LogError::RatioLimit(error) => Failure::Usage(format!("--max-ratio: {error}")),
            LogError::NoFit => {
                Failure::Usage("--navigate needs coefficients\nleave out --fit none".to_owned())
            }
            LogError::Model(ModelError::Noise(error)) => Failure::Study(error),
            error if error.is_usage() => Failure::Usage(in_options(&error)),
            error => Failure::Record(in_options(&error)),
        }
    }
}

impl From<DecisionError> for Failure {
    fn from(error: DecisionError) -> Failure {
        match error {
            DecisionError::Study(error) => Failure::Study(error),
            DecisionError::Run(error) => error.into(),
            DecisionError::Column(error) => Failure::Picture(error.to_string()),
            DecisionError::Threads(error) => Failure::Output(std::io::Error::other(error)),
        }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Failure {
        match error {
            RunError::Store(error) => Failure::Store(error),
            RunError::Gpu(error) => Failure::Interrupted(error),
            RunError::Refused(error) => Failure::Record(error.to_string()),
        }
    }
}

impl Failure {
    /// Prints the error on the standard error stream, and returns its exit code.
    pub fn report(&self) -> u8 {
        match self {
            Failure::Study(error) => say(&error.render(look::colours_messages(), 110)),
            Failure::Log(error) => say(&error.render(look::colours_messages(), 110)),
            Failure::OutputClosed => {}
            Failure::Store(StoreError::Folder { path, source })
            | Failure::Folder(FolderError::Folder { path, source })
                if is_no_folder(source.kind()) =>
            {
                let part = |part: &Path| if part == path { "it is" } else { "a part of its path is" };
                let is_dangling = |part: &&Path| part.is_symlink() && !part.exists();
                let why = match path.ancestors().find(is_dangling) {
                    Some(link) => format!("{} a link that leads nowhere", part(link)),
                    None => format!(
                        "{} a file",
                        part(path.ancestors().find(|part| part.is_file()).unwrap_or(path))
                    ),
                };
                say!(
                    "error: cannot use the results folder {}: {why}\nname a folder with --out DIR",
                    path.display()
                );
            }
            // Not an error: it was requested.
            Failure::Stopped { .. } | Failure::Unplanned { .. } => say!("{self}"),
            other => say!("error: {other}"),
        }
        self.code()
    }

    fn code(&self) -> u8 {
        match self {
            Failure::Gpu(_) | Failure::Interrupted(_) | Failure::Picture(_) | Failure::Signals(_) => 1,
            Failure::Usage(_) | Failure::Store(StoreError::NoResults(_)) => 2,
            Failure::Select(error) if error.is_usage() => 2,
            Failure::Select(_) => 1,
            Failure::Study(_)
            | Failure::Log(_)
            | Failure::Record(_)
            | Failure::Store(
                StoreError::OtherStudy { .. } | StoreError::Schema { .. } | StoreError::Kernels { .. },
            ) => 3,
            Failure::Stopped { cause, .. } | Failure::Unplanned { cause, .. } => cause.code(),
            Failure::Incomplete { .. } | Failure::Unfinished(_) => 4,
            Failure::Different | Failure::Unsound(_) | Failure::Store(StoreError::Disagrees { .. }) => 5,
            Failure::Store(_) | Failure::Write { .. } | Failure::Folder(_) | Failure::Output(_) => 6,
            Failure::OutputClosed => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_run_says_that_results_are_kept_and_says_it_once() {
        let lost = || GpuError::Lost("unplugged".to_owned());
        let of_a_run = Failure::from(RunError::Gpu(lost())).to_string();
        assert_eq!(of_a_run.matches("kept").count(), 1, "{of_a_run}");
        let of_another_command = Failure::from(lost()).to_string();
        assert!(!of_another_command.contains("kept"), "{of_another_command}");
        assert!(of_another_command.contains("--device"), "{of_another_command}");
    }
}
