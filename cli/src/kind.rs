//! Files that are of another kind than a command takes.

use std::path::Path;

use sagnac::source::diagnose::StudyError;
use sagnac::study::Study;

use crate::failure::Failure;

/// Endings of the names of recorded logs, in lower case.
const LOGS: [&str; 15] =
    ["csv", "tsv", "dat", "log", "npy", "npz", "mat", "h5", "hdf5", "nc", "mcap", "bag", "bin", "lvm", "raw"];

/// The ending of the name of a file, in lower case.
fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// Reads a study.
///
/// # Errors
/// The file is a recorded log by its name, cannot be read, or is no valid study.
pub fn study(path: &Path) -> Result<Study, Failure> {
    if LOGS.contains(&ending(path).as_str()) {
        let path = path.display();
        let message = format!("{path} is a log, not a study\nanalyze it with `sagnac allan {path}`");
        return Err(Failure::Usage(message));
    }
    Study::read(path).map_err(|error: StudyError| error.into())
}

/// Checks that a file is not a study by its name.
///
/// # Errors
/// It is one.
pub fn log(path: &Path) -> Result<(), Failure> {
    if ending(path) == "toml" {
        let path = path.display();
        let message = format!("{path} is a study, not a log\nrun it with `sagnac run {path}`");
        return Err(Failure::Usage(message));
    }
    Ok(())
}
