//! Faults of a study, or of a file that it names: the finding, its place and a remedy.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, NamedSource, SourceSpan};

use crate::quantity::visible::visible;
use crate::source::place::Place;
use crate::source::setting::spelled;

/// Most files of a folder that a help lists.
const MAX_FILES: usize = 4;

/// The text of a study, or of a file that it names, with the name of that file.
pub type Text = Arc<NamedSource<String>>;

/// A fault at a place of a text, as found by code that does not have the name of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    span: Range<usize>,
    message: String,
    label: String,
    help: String,
}

/// A fault of a study, or of a file that it names.
pub enum Wrong {
    /// A fault of the study itself.
    Study(Fault),
    /// A fault of another file, with its place there.
    Elsewhere(StudyError),
}

impl From<Fault> for Wrong {
    fn from(fault: Fault) -> Wrong {
        Wrong::Study(fault)
    }
}

impl Wrong {
    /// Combines the fault with the text of the study; a fault of another file has its own text.
    pub fn within(self, text: &Text) -> StudyError {
        match self {
            Wrong::Study(fault) => fault.within(text),
            Wrong::Elsewhere(error) => error,
        }
    }
}

impl Fault {
    /// A fault with the complete finding as `message`, a `label` for the text at `span`, and the accepted values as
    /// `help`.
    pub fn new(
        span: Range<usize>,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> Fault {
        Fault { span, message: message.into(), label: label.into(), help: help.into() }
    }

    /// An error of the TOML text itself.
    pub fn from_syntax(what: &str, error: &toml::de::Error) -> Fault {
        let help = "a study is a TOML file; values with units stand in quotes, as in frequency = \"20 Hz\"";
        let message = format!("{what} is not valid TOML: {}", error.message().replace('\n', "; "));
        Fault::new(error.span().unwrap_or_default(), message, "here", help)
    }

    /// The table at `span` lacks a key.
    pub fn missing_key(key: &str, example: &str, span: Range<usize>) -> Fault {
        let label = if key.contains('.') { "in this table" } else { "in this file" };
        Fault::new(span, format!("the key `{key}` is missing"), label, format!("add it as in\n{example}"))
    }

    /// A study of this kind lacks a table.
    pub fn missing_table(table: &str, example: &str, kind: &str, kind_span: Range<usize>) -> Fault {
        let message = format!("a study of kind = \"{kind}\" needs the table [{table}]");
        Fault::new(kind_span, message, "of this kind", format!("add it as in\n{example}"))
    }

    /// Combines the fault with its text.
    pub fn within(self, text: &Text) -> StudyError {
        let end = first_line_end(text.inner(), &self.span);
        let shown = Place::within(text, self.span.start..end);
        StudyError::new(self.message, self.label, self.help, Some(shown))
    }
}

/// The end of `span`, or of its first line, because a caret under a whole table points at nothing.
fn first_line_end(text: &str, span: &Range<usize>) -> usize {
    let marked = text.get(span.clone()).unwrap_or_default();
    marked.find(['\r', '\n']).map_or(span.end, |length| span.start + length)
}

/// Why a study was refused: the finding with its place, the accepted values and a remedy.
///
/// A [`miette::Diagnostic`]; [`StudyError::render`] gives the text for a terminal.
#[derive(Debug, Clone, thiserror::Error, Diagnostic)]
#[error("{message}")]
pub struct StudyError {
    message: String,
    label: String,
    #[help]
    help: String,
    /// Lines to show; absent where the file could not be read.
    #[source_code]
    shown: Option<Arc<Place>>,
    #[label("{label}")]
    span: Option<SourceSpan>,
    /// The faults, where there are several.
    #[related]
    several: Box<[StudyError]>,
}

/// Most characters of a text of an error, and of its end where it is longer: names may have any length.
const MAX_TEXT: usize = 2000;
const LAST: usize = 200;

/// A text without its middle, where it is longer than an error may be.
fn bounded(text: String) -> String {
    let count = text.chars().count();
    if count <= MAX_TEXT {
        return text;
    }
    let first: String = text.chars().take(MAX_TEXT - LAST).collect();
    let last: String = text.chars().skip(count - LAST).collect();
    format!("{first} … {last}")
}

impl StudyError {
    /// `message`: the whole finding; `label`: what stands at what is `shown`; `help`: what to do.
    pub fn new(
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
        shown: Option<Place>,
    ) -> StudyError {
        let span = shown.as_ref().map(|place| place.span.clone().into());
        let shown = shown.map(Arc::new);
        StudyError {
            message: bounded(message.into()),
            label: bounded(label.into()),
            help: bounded(help.into()),
            shown,
            span,
            several: Box::default(),
        }
    }

    /// An error that lists several.
    pub fn of_several(message: String, several: impl Iterator<Item = StudyError>) -> StudyError {
        let help = "settle all of them at once";
        StudyError { several: several.collect(), ..StudyError::new(message, "", help, None) }
    }

    /// The error for a file that could not be read; `what` names its purpose, such as `the study`, and `help` an
    /// alternative.
    pub fn unreadable(what: &str, path: &Path, error: &std::io::Error, help: &str) -> StudyError {
        StudyError::new(format!("cannot read {what} {}: {error}", path.display()), "", help, None)
    }

    /// The error for a folder in place of a study file, which names the study files in it.
    pub fn of_folder(path: &Path) -> StudyError {
        let entries = std::fs::read_dir(path).into_iter().flatten().filter_map(Result::ok);
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        files.retain(|file| file.extension().is_some_and(|end| end == "toml") && file.is_file());
        files.sort();
        let named: Vec<String> =
            files.iter().take(MAX_FILES).map(|file| file.display().to_string()).collect();
        let help = match files.len() {
            0 => "give the path of a study file; `sagnac new gap-fill mine.toml` writes one".to_owned(),
            count if count > MAX_FILES => {
                format!("give one of its {count} files, such as {}", named.join(", "))
            }
            _ => format!("give one of its files: {}", named.join(", ")),
        };
        StudyError::new(format!("{} is a folder, not a study file", path.display()), "", help, None)
    }

    /// The same error with other advice.
    pub fn with_help(self, help: &str) -> StudyError {
        StudyError { help: help.to_owned(), ..self }
    }

    /// Returns the error with its settings spelled as a front end spells them; see [`spelled`].
    pub fn spelled(mut self, spell: &dyn Fn(&str, &str) -> Option<String>) -> StudyError {
        for text in [&mut self.message, &mut self.label, &mut self.help] {
            *text = spelled(text, spell);
        }
        self.several = self.several.into_iter().map(|error| error.spelled(spell)).collect();
        self
    }

    /// The same error with every text in it [`visible`].
    fn visible(&self) -> StudyError {
        let [message, label, help] =
            [&self.message, &self.label, &self.help].map(|text| visible(text).into_owned());
        let shown = self.shown.as_ref().map(|place| place.visible());
        let several = self.several.iter().map(StudyError::visible).collect();
        StudyError { several, ..StudyError::new(message, label, help, shown) }
    }

    /// The report for the user, with file, line, caret and help, `width` columns wide; it has escape codes only if
    /// `color`.
    pub fn render(&self, color: bool, width: usize) -> String {
        let theme = if color { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
        let handler = GraphicalReportHandler::new_themed(theme).with_links(color).with_width(width);
        let mut report = String::new();
        match handler.render_report(&mut report, &self.visible()) {
            Ok(()) => report,
            // The text does not contain the place.
            Err(_) => format!("{self}\nhelp: {}\n", self.help),
        }
    }
}

/// Most names that a help lists: more than the number of keys, but fewer than the columns that a file may have.
const MAX_CHOICES: usize = 200;

/// Help for a wrong name, with the nearest of `known` if one is near, and all of them.
pub fn choices(found: &str, known: &[&str]) -> String {
    let more = if known.len() > MAX_CHOICES { ", …" } else { "" };
    let accepted = format!("accepted: {}{more}", known[..known.len().min(MAX_CHOICES)].join(", "));
    match nearest(found, known) {
        Some(name) => format!("did you mean `{name}`? {accepted}"),
        None => accepted,
    }
}

/// Longest name whose nearest match is computed, which takes time and memory in proportion to the product of two
/// lengths.
const MAX_SLIP: usize = 100;

/// Fewest letters that count as the beginning of a name.
const MIN_BEGINNING: usize = 3;

/// The most similar name to `found`, if one is close enough: one with a typing error, without its prefix, or cut short.
pub fn nearest<'a>(found: &str, known: &[&'a str]) -> Option<&'a str> {
    if found.len() > MAX_SLIP {
        return None;
    }
    let likeness = |name: &str| {
        let bare = name.rsplit('.').next().unwrap_or(name);
        let whole = strsim::normalized_damerau_levenshtein(found, name);
        let begun = found.len() >= MIN_BEGINNING && (bare.starts_with(found) || name.starts_with(found));
        whole.max(strsim::normalized_damerau_levenshtein(found, bare)).max(if begun { 0.5 } else { 0.0 })
    };
    // Of several equally near names, the first.
    let best = known.iter().rev().copied().max_by(|a, b| likeness(a).total_cmp(&likeness(b)))?;
    (likeness(best) >= 0.5).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_offered_only_when_it_is_near() {
        let known = ["motion.frequency", "motion.amplitude", "gyro.tick"];
        assert_eq!(nearest("motion.freqency", &known), Some("motion.frequency"));
        assert_eq!(nearest("frequency", &known), Some("motion.frequency"));
        assert_eq!(nearest("freq", &known), Some("motion.frequency"));
        assert_eq!((nearest("fr", &known), nearest("temperature", &known)), (None, None));
        assert_eq!(nearest("x", &[]), None);
        assert_eq!(nearest(&"gyro.tick".repeat(1_000_000), &known), None);
        assert!(choices("gx", &["g"; 1000]).ends_with("g, g, …"));
    }

    #[test]
    fn an_error_renders_through_every_handler_of_miette() {
        let text: Text = Arc::new(NamedSource::new("a.toml", "x = 1\ny = 2 µ\n".to_owned()));
        let error = Fault::new(10..14, "bad y", "this one", "write 3").within(&text);
        let plain = error.render(false, 80);
        for piece in ["bad y", "a.toml:2:5", "this one", "write 3"] {
            assert!(plain.contains(piece), "{piece} is missing in\n{plain}");
        }
        assert!(!plain.contains('\u{1b}') && error.render(true, 80).contains('\u{1b}'));
        let mut narrated = String::new();
        miette::NarratableReportHandler::new().render_report(&mut narrated, &error).unwrap();
        assert!(narrated.contains("this one") && narrated.contains("line 2"), "{narrated}");
        let mut ascii = String::new();
        let handler = GraphicalReportHandler::new_themed(GraphicalTheme::none());
        handler.render_report(&mut ascii, &error).unwrap();
        assert!(ascii.contains("a.toml:2:5"), "{ascii}");
        assert!(format!("{:?}", miette::Report::new(error)).contains("this one"));
    }

    #[test]
    fn an_unreadable_file_has_no_caret_but_help() {
        let error = std::io::Error::from(std::io::ErrorKind::NotFound);
        let path = Path::new("no.toml");
        let shown = StudyError::unreadable("the study", path, &error, "give another").render(false, 80);
        assert!(shown.contains("the study no.toml") && shown.contains("give another"), "{shown}");
    }
}
