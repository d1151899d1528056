//! What records show besides noise, for people.

use sagnac::analysis::log::events::{HEADING, Row, list};

use crate::terminal::headed;

/// The title of the list of a log.
pub const THIS: &str = "what this record shows";
/// The title of the list of several logs.
pub const THESE: &str = "what these records show";

/// The list of events under a title; empty without events.
pub fn shown(title: &str, rows: &[Row]) -> String {
    match rows {
        [] => String::new(),
        rows => format!("\n{title}\n{}", headed(HEADING, list(rows).into_iter())),
    }
}
