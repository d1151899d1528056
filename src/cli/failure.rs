//! What can go wrong, and with which exit code.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;

use sagnac::backend::SelectError;
use sagnac::backend::gpu::GpuError;
use sagnac::run::RunError;
use sagnac::store::StoreError;
use sagnac::study::StudyError;

/// The end of a command that did not do what it was asked for.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error("{0}")]
    Usage(String),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Select(#[from] SelectError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error("{0}")]
    Picture(String),
    #[error("cannot write {path}: {source}")]
    Write { path: PathBuf, source: std::io::Error },
    #[error("a kernel gives different bits: do not trust results of that device")]
    Different,
    /// Whoever read our output went away: there is nobody to tell.
    #[error("the output was closed")]
    OutputClosed,
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Failure {
        match error {
            RunError::Store(error) => Failure::Store(error),
            RunError::Gpu(error) => Failure::Gpu(error),
        }
    }
}

impl Failure {
    /// Says what went wrong on the standard error stream.
    pub fn report(&self) -> ExitCode {
        match self {
            Failure::Study(error) => eprintln!("{}", error.render(colored(), 110)),
            Failure::OutputClosed => {}
            Failure::Gpu(_) => {
                eprintln!(
                    "error: {self}\nwhat was computed is kept: run again to go on, or use --device cpu"
                );
            }
            other => eprintln!("error: {other}"),
        }
        ExitCode::from(self.code())
    }

    fn code(&self) -> u8 {
        match self {
            Failure::Gpu(_) | Failure::Picture(_) => 1,
            Failure::Usage(_) => 2,
            Failure::Study(_) | Failure::Store(StoreError::OtherStudy { .. }) => 3,
            Failure::Select(error) => {
                if error.is_usage() {
                    2
                } else {
                    1
                }
            }
            Failure::Different => 5,
            Failure::Store(_) | Failure::Write { .. } => 6,
            Failure::OutputClosed => 0,
        }
    }
}

/// Whether messages may be coloured.
fn colored() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}
