//! Errors of recorded data, with the line at fault.

use std::io;

use sagnac_base::source::diagnose::{StudyError, Wrong};
use sagnac_base::source::place::Place;

/// Why a record or a log was refused: the finding with its place, the accepted values and a remedy.
///
/// A [`miette::Diagnostic`]; [`RecordError::render`] gives the text for a terminal. It converts to a [`StudyError`] for
/// the study that names the record.
#[derive(Debug, Clone, thiserror::Error, miette::Diagnostic)]
#[error(transparent)]
#[diagnostic(transparent)]
pub struct RecordError(StudyError);

impl RecordError {
    /// An error with the complete finding as `message`, a `label` for the text at `place`, and advice as `help`.
    pub(crate) fn new(
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
        place: impl Into<Option<Place>>,
    ) -> RecordError {
        RecordError(StudyError::new(message, label, help, place.into()))
    }

    /// The error for a file that cannot be read.
    pub(crate) fn unreadable(file: &str, error: &io::Error) -> RecordError {
        RecordError::new(format!("cannot read {file}: {error}"), "", "give the path of a log", None)
    }

    /// The same error with other advice.
    pub(crate) fn with_help(self, help: &str) -> RecordError {
        RecordError(self.0.with_help(help))
    }

    /// Returns the error with its settings spelled as a front end spells them; see [`spelled`](sagnac_base::source::setting::spelled).
    pub fn spelled(self, spell: &dyn Fn(&str, &str) -> Option<String>) -> RecordError {
        RecordError(self.0.spelled(spell))
    }

    /// The report for the user, with file, line, caret and help, `width` columns wide; it has escape codes only if
    /// `color`.
    pub fn render(&self, color: bool, width: usize) -> String {
        self.0.render(color, width)
    }
}

/// The error of bytes without the structure of their format.
pub(crate) fn malformed<T>(why: &str) -> io::Result<T> {
    Err(io::Error::other(why))
}

/// Why bytes cannot be read, in words.
pub(crate) fn told(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "it ends too early".to_owned(),
        _ => error.to_string(),
    }
}

/// The faults found in a file so far.
#[derive(Default)]
pub(crate) struct Faults(Vec<RecordError>);

impl Faults {
    pub(crate) fn add(&mut self, fault: RecordError) {
        self.0.push(fault);
    }

    /// The value, or none after its fault was added.
    pub(crate) fn take<T>(&mut self, result: Result<T, RecordError>) -> Option<T> {
        result.map_err(|fault| self.add(fault)).ok()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The only fault, or one that lists all; there is at least one.
    pub(crate) fn into_error(self, file: &str) -> RecordError {
        let message = format!("{file} has {} problems, each with what settles it", self.0.len());
        self.listed(message)
    }

    /// The only fault, or all below a `message`.
    pub(crate) fn listed(mut self, message: String) -> RecordError {
        match self.0.len() {
            1 => self.0.remove(0),
            _ => RecordError(StudyError::of_several(message, self.0.into_iter().map(|fault| fault.0))),
        }
    }
}

impl From<RecordError> for StudyError {
    fn from(error: RecordError) -> StudyError {
        error.0
    }
}

impl From<RecordError> for Wrong {
    fn from(error: RecordError) -> Wrong {
        Wrong::Elsewhere(error.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_shows_the_true_line_and_column_even_of_a_line_that_is_cut() {
        let line = format!("{}oops,{}", "1,".repeat(5000), "2,".repeat(5000));
        let place = Place::new("g.csv", 1_000_001, line.as_bytes(), 10_000..10_004);
        let shown = RecordError::new("bad cell", "not a number", "mend it", place).render(false, 100);
        for piece in ["g.csv:1000001:10001", "oops", "not a number", "mend it"] {
            assert!(shown.contains(piece), "{piece} is missing in\n{shown}");
        }
        assert!(shown.len() < 1500, "{shown}");
    }

    #[test]
    fn a_line_that_is_no_utf_8_is_shown_all_the_same() {
        let place = Place::new("g.csv", 1, b"rate [\xb0/s],x", 6..8);
        let shown = RecordError::new("bad unit", "here", "write deg/s", place).render(false, 100);
        assert!(shown.contains("g.csv:1:7"), "{shown}");
        let beyond = Place::new("g.csv", 1, b"1,2", 40..50);
        assert!(RecordError::new("short", "here", "", beyond).render(false, 80).contains("g.csv:1:"));
    }
}
