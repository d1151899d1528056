//! What can go wrong, and with which exit code.

use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::ExitCode;

use sagnac::allan::tau::TauError;
use sagnac::analysis::firmware::choice::ChoiceError;
use sagnac::analysis::log::kalibr::KalibrError;
use sagnac::device::error::GpuError;
use sagnac::device::select::SelectError;
use sagnac::record::error::RecordError;
use sagnac::run::keep::KeepError;
use sagnac::run::{RESOLVED, RunError};
use sagnac::source::diagnose::StudyError;
use sagnac::source::setting::spelled;
use sagnac::store::error::StoreError;
use sagnac::tally::share::Share;

use crate::look;
use crate::run::stop::Cause;
use sagnac::quantity::number::short;

/// What the program returns, and what that means.
pub const EXIT_CODES: [(&str, &str); 8] = [
    ("0", "done"),
    ("1", "runtime error"),
    ("2", "usage, unknown device"),
    ("3", "invalid study or log, folder of another study or version"),
    ("4", "stopped or incomplete, run again to go on"),
    ("5", "a check failed"),
    ("6", "storage or output (full, read-only, locked)"),
    ("130, 143", "signals: Ctrl-C (SIGINT), SIGTERM; what was sampled is kept, run again to go on"),
];

/// The end of a command that did not do what it was asked for.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error("{0}")]
    Usage(String),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Log(RecordError),
    /// A log that does not have what it is asked for.
    #[error("{0}")]
    Record(String),
    #[error("{}", in_options(.0))]
    Select(#[from] SelectError),
    #[error("{}", in_options(.0))]
    Store(#[from] StoreError),
    #[error("{0}\nchoose another device with --device; `sagnac devices` lists what is there")]
    Gpu(#[from] GpuError),
    /// The same in the middle of a run.
    #[error("{0}\nwhat was computed is kept: run again to go on, or use --device cpu")]
    Interrupted(GpuError),
    #[error("{0}")]
    Picture(String),
    #[error("cannot write {path}: {source}")]
    Write { path: PathBuf, source: std::io::Error },
    #[error("cannot write to the standard output: {0}\nsend it where there is room and run again")]
    Output(std::io::Error),
    #[error("cannot listen for signals: {0}")]
    Signals(std::io::Error),
    #[error(
        "stopped by {cause}: {} of {} {} are kept in {folder}\nresumable: run the same command again and it goes on from there; `sagnac report {folder}` makes the page of what there is",
        short(reached.0 as f64), short(reached.1 as f64), reached.2
    )]
    Stopped { cause: Cause, reached: (u64, u64, &'static str), folder: PathBuf },
    #[error(
        "{folder} is incomplete: {} trials are missing{}\nmerge the shares that have them, or sample them with `sagnac run {folder}/{RESOLVED}`",
        short(*lacking as f64), of_shares(absent)
    )]
    Incomplete { lacking: u64, folder: PathBuf, absent: Vec<Share> },
    #[error("not complete: {}\nrun each again as it was begun, or merge what there is", named(.0))]
    Unfinished(Vec<PathBuf>),
    #[error("{} found", faults(*.0))]
    Unsound(usize),
    #[error("a kernel gives different bits: do not trust results of that device")]
    Different,
    /// Whoever read our output went away: there is nobody to tell.
    #[error("the output was closed")]
    OutputClosed,
}

/// Whether a file stands where a folder should be.
fn is_no_folder(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::AlreadyExists | ErrorKind::NotADirectory)
}

/// Which shares are not there.
fn of_shares(absent: &[Share]) -> String {
    match absent {
        [] => String::new(),
        [share] => format!("; {share} is not there"),
        [first, ..] => {
            let numbers: Vec<String> = absent.iter().map(|share| share.number().to_string()).collect();
            format!("; shares {} of {} are not there", numbers.join(", "), first.of())
        }
    }
}

fn named(folders: &[PathBuf]) -> String {
    folders.iter().map(|folder| folder.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// So many faults, in words.
pub fn faults(count: usize) -> String {
    if count == 1 { "1 fault".to_owned() } else { format!("{count} faults") }
}

/// Settings that the library names and the program has options for.
const OPTIONS: [&str; 14] = [
    "at",
    "bootstrap",
    "column",
    "data",
    "device",
    "filler",
    "out",
    "rate",
    "salvage",
    "scale",
    "tau",
    "time_unit",
    "unit",
    "unit_check",
];

/// A setting as an option.
fn option(name: &str, value: &str) -> Option<String> {
    let name = OPTIONS.contains(&name).then(|| name.replace('_', "-"))?;
    Some(if value == "true" { format!("--{name}") } else { format!("--{name} {value}") })
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

impl From<TauError> for Failure {
    fn from(error: TauError) -> Failure {
        match error {
            TauError::NoTime { .. } => Failure::Usage(in_options(&error)),
            _ => Failure::Record(in_options(&error)),
        }
    }
}

impl From<KalibrError> for Failure {
    fn from(error: KalibrError) -> Failure {
        match error {
            KalibrError::Plain { .. } => Failure::Usage(in_options(&error)),
            KalibrError::NoCoefficients { .. } => Failure::Record(error.to_string()),
        }
    }
}

impl From<KeepError> for Failure {
    fn from(error: KeepError) -> Failure {
        let KeepError { path, source } = error;
        Failure::Write { path, source }
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
    /// Says what went wrong on the standard error stream.
    pub fn report(&self) -> ExitCode {
        match self {
            Failure::Study(error) => say!("{}", error.render(look::colours_messages(), 110)),
            Failure::Log(error) => say!("{}", error.render(look::colours_messages(), 110)),
            Failure::OutputClosed => {}
            Failure::Store(StoreError::Folder { path, source }) if is_no_folder(source.kind()) => {
                let (path, part) =
                    (path.display(), if path.is_file() { "it is" } else { "a part of its path is" });
                say!(
                    "error: cannot use the results folder {path}: {part} a file\nname a folder with --out DIR"
                );
            }
            // No error: as it was asked for.
            Failure::Stopped { .. } => say!("{self}"),
            other => say!("error: {other}"),
        }
        ExitCode::from(self.code())
    }

    fn code(&self) -> u8 {
        match self {
            Failure::Gpu(_) | Failure::Interrupted(_) | Failure::Picture(_) | Failure::Signals(_) => 1,
            Failure::Usage(_) | Failure::Store(StoreError::NoResults { .. }) => 2,
            Failure::Study(_)
            | Failure::Log(_)
            | Failure::Record(_)
            | Failure::Store(
                StoreError::OtherStudy { .. } | StoreError::Schema { .. } | StoreError::Kernels { .. },
            ) => 3,
            Failure::Select(error) => {
                if error.is_usage() {
                    2
                } else {
                    1
                }
            }
            Failure::Stopped { cause, .. } => cause.code(),
            Failure::Incomplete { .. } | Failure::Unfinished(_) => 4,
            Failure::Different | Failure::Unsound(_) | Failure::Store(StoreError::Disagrees { .. }) => 5,
            Failure::Store(_) | Failure::Write { .. } | Failure::Output(_) => 6,
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
