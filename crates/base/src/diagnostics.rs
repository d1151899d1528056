//! Faults of a study, or of a file that it names: the finding, its place and a remedy.
//!
//! A [`Place`] is the part of a text that an error shows. Messages name settings as `name = value` in backticks, which a front
//! end replaces by its own options ([`spelled`]). [`visible`] escapes the control characters in text of others, such as that of
//! files, databases and names, which could command a terminal.

use std::borrow::Cow;
use std::fmt::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, MietteError, MietteSpanContents, NamedSource,
    SourceCode, SourceSpan, SpanContents,
};

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

    /// Replaces the advice of the error.
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

    /// Makes the control characters in all texts of the error [`visible`].
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

/// Characters of a line that an error shows on each side of its cell, where it shows only a piece of the line.
const SHOWN: usize = 60;

/// Length in bytes from which on only a piece of a line is shown. Longer lines are unreadable in a report, and miette
/// panics for a caret beyond column 65535.
const LONG: usize = 1000;

/// Text in UTF-8, or else in Latin-1, in which spreadsheets write `°` and `µ`.
pub fn decoded(bytes: &[u8]) -> String {
    let text = std::str::from_utf8(bytes).map(str::to_owned);
    text.unwrap_or_else(|_| bytes.iter().copied().map(char::from).collect())
}

/// A text, or a piece of one of its lines, with the bytes under the caret.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    text: Text,
    /// Line number of the start of the text in its file, from 1.
    line: usize,
    /// Bytes of that line before the text.
    before: usize,
    /// The bytes under the caret, within the text.
    pub span: Range<usize>,
}

impl Place {
    /// The piece around the bytes `span` of line number `line`, which reads `text`.
    pub fn new(file: &str, line: usize, text: &[u8], span: Range<usize>) -> Place {
        let span = span.start.min(text.len())..span.end.min(text.len());
        // A piece must not begin within a character, which would then be shown and counted as another.
        let is_midst = |at: &usize| text[*at] & 0xc0 == 0x80;
        let from =
            (span.start.saturating_sub(SHOWN)..span.start).find(|at| !is_midst(at)).unwrap_or(span.start);
        let to = text.len().min(span.end.min(span.start + SHOWN) + SHOWN);
        let is_utf_8 = std::str::from_utf8(text).is_ok();
        let shown =
            |part: &[u8]| if is_utf_8 { String::from_utf8_lossy(part).into_owned() } else { decoded(part) };
        // Converted text may be longer than its bytes, so each part is converted by itself.
        let [head, cell, tail] = [from..span.start, span.start..span.end.min(to), span.end.min(to)..to]
            .map(|part| shown(&text[part]));
        let span = head.len()..head.len() + cell.len();
        Place { text: Arc::new(NamedSource::new(file, head + &cell + &tail)), line, before: from, span }
    }

    /// The bytes `span` of a whole `text`; of a long line only a piece.
    pub fn within(text: &Text, span: Range<usize>) -> Place {
        let whole = text.inner();
        let is_end = |c: char| matches!(c, '\n' | '\r');
        let everything = |span| Place { text: text.clone(), line: 1, before: 0, span };
        let (Some(before), Some(after)) = (whole.get(..span.start), whole.get(span.end..)) else {
            return everything(span);
        };
        let start = before.rfind(is_end).map_or(0, |end| end + 1);
        let end = after.find(is_end).map_or(whole.len(), |length| span.end + length);
        let neighbours = [
            whole[..start].trim_end_matches(is_end).rsplit(is_end).next(),
            whole[end..].trim_start_matches(is_end).split(is_end).next(),
        ];
        if end - start <= LONG && neighbours.iter().flatten().all(|line| line.len() <= LONG) {
            return everything(span);
        }
        // \r\n counts as one line end.
        let ends = before[..start].bytes().zip(before[..start].bytes().skip(1).chain([0]));
        let line = 1 + ends.filter(|&(byte, next)| byte == b'\n' || (byte == b'\r' && next != b'\n')).count();
        Place::new(text.name(), line, &whole.as_bytes()[start..end], span.start - start..span.end - start)
    }
}

impl Place {
    /// Returns the place in a copy of the text whose control characters are visible.
    pub fn visible(&self) -> Place {
        // A carriage return alone ends a line too, and would take a terminal back to its start.
        let whole = &self.text.inner().replace("\r\n", " \n").replace('\r', "\n");
        let [start, end] = [self.span.start, self.span.end].map(|at| match whole.get(..at) {
            Some(before) => visible(before).len(),
            None => at,
        });
        let text = NamedSource::new(visible(self.text.name()), visible(whole).into_owned());
        Place { text: Arc::new(text), span: start..end, ..*self }
    }
}

impl SourceCode for Place {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = self.text.inner().read_span(span, before, after)?;
        let (line, column) = (self.line - 1 + inner.line(), self.before + inner.column());
        let (file, span, lines) = (self.text.name().to_owned(), *inner.span(), inner.line_count());
        Ok(Box::new(MietteSpanContents::new_named(file, inner.data(), span, line, column, lines)))
    }
}

/// A message with its settings written by `spell` from name and value; settings that `spell` does not know stay
/// unchanged.
///
/// ```
/// # use sagnac_base::diagnostics::spelled;
/// let option = |name: &str, value: &str| (name == "tau").then(|| format!("--{name} {value}"));
/// assert_eq!(spelled("give `tau = octave` for `gx`", &option), "give --tau octave for `gx`");
/// ```
pub fn spelled(message: &str, spell: &dyn Fn(&str, &str) -> Option<String>) -> String {
    let part = |(place, part): (usize, &str)| {
        let setting = part.split_once(" = ").filter(|_| place % 2 == 1);
        match setting.and_then(|(name, value)| spell(name, value)) {
            Some(spelled) => spelled,
            None if place % 2 == 1 => format!("`{part}`"),
            None => part.to_owned(),
        }
    };
    message.split('`').enumerate().map(part).collect()
}

/// A text in which every control character but line ends and tabs is a visible one: `ESC` is shown as `␛`. Marks that
/// reverse the direction of writing, which make a text read as another one, are shown as `�`. The number of characters
/// stays, so tables and carets stay aligned.
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut signs = text.chars().peekable();
    let mut shown = String::with_capacity(text.len());
    while let Some(sign) = signs.next() {
        // A line end of Windows stays.
        let stays = sign == '\r' && signs.peek() == Some(&'\n');
        shown.push(if stays { sign } else { shown_as(sign) });
    }
    Cow::Owned(shown)
}

/// A JSON text in which the same characters are escapes. JSON itself escapes only those below U+0020.
pub fn visible_json(text: &str) -> Cow<'_, str> {
    let must = |sign: char| is_hidden(sign) && sign >= ' ';
    if !text.contains(must) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for sign in text.chars() {
        // Outside of texts, JSON has none of these characters. All of them have four digits.
        if must(sign) {
            let _ = write!(shown, "\\u{:04x}", u32::from(sign));
        } else {
            shown.push(sign);
        }
    }
    Cow::Owned(shown)
}

/// Whether a character commands a terminal or turns the direction of writing.
fn is_hidden(sign: char) -> bool {
    let is_mark = matches!(sign, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    (sign.is_control() && !matches!(sign, '\n' | '\t')) || is_mark
}

fn shown_as(sign: char) -> char {
    match sign {
        // The pictures of the control characters follow one another as they do.
        '\0'..='\u{1f}' if is_hidden(sign) => char::from_u32(0x2400 + u32::from(sign)).unwrap_or('\u{fffd}'),
        '\u{7f}' => '\u{2421}',
        _ if is_hidden(sign) => '\u{fffd}',
        _ => sign,
    }
}

/// Most characters of a cell of a table on a terminal.
const MAX_CELL: usize = 200;

/// The beginning of a text that is too long for a cell; no terminal shows more, and Rust pads to at most 65,535 characters.
pub fn in_cell(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(MAX_CELL) {
        None => Cow::Borrowed(text),
        Some(_) => Cow::Owned(text.chars().take(MAX_CELL - 1).chain(['…']).collect()),
    }
}

/// Some texts as a list, such as `a, b and c`.
pub fn listed<T: AsRef<str>>(texts: &[T]) -> String {
    let texts: Vec<&str> = texts.iter().map(AsRef::as_ref).collect();
    match &texts[..] {
        [others @ .., last] if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => texts.concat(),
    }
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

    #[test]
    fn of_a_long_line_a_piece_is_shown_at_its_true_place() {
        for filling in [10, LONG, 70_000, 1_000_000] {
            let long = "é".repeat(filling);
            for (text, place) in [
                (format!("x = 1\r\ny = {long} bad\nz = 2\n"), format!("a.toml:2:{}", 6 + 2 * filling)),
                (format!("x = 1\n\nbad = {long}\n"), "a.toml:3:1".to_owned()),
                (format!("{long}\n bad\n"), "a.toml:2:2".to_owned()),
                (format!("\rbad\n\n{long}"), "a.toml:2:1".to_owned()),
            ] {
                let at = text.find("bad").unwrap();
                let text: Text = Arc::new(NamedSource::new("a.toml", text));
                let shown =
                    Fault::new(at..at + 3, "bad y", "this one", "mend it").within(&text).render(false, 100);
                for piece in [place.as_str(), "bad", "this one", "mend it"] {
                    assert!(shown.contains(piece), "{piece} is missing in\n{shown}");
                }
                assert!(shown.len() < 4 * LONG, "{} bytes with {filling}", shown.len());
            }
        }
    }

    #[test]
    fn what_commands_a_terminal_is_shown_in_as_many_characters() {
        let hostile = "a\u{1b}]0;pwned\u{7}\u{9b}2J\u{7f}\u{202e}\rb\r\nc\td";
        let shown = visible(hostile);
        assert_eq!(shown, "a␛]0;pwned␇\u{fffd}2J␡\u{fffd}␍b\r\nc\td");
        assert_eq!(shown.chars().count(), hostile.chars().count());
        for plain in ["", "Δt·ν, 5 ″ of μ\n\tÄ", "x\r\ny"] {
            assert_eq!(visible(plain), plain);
        }
    }

    #[test]
    fn json_reads_back_the_same_text() {
        let hostile = "\u{1b}[31m \u{9b} \u{7f} \u{202e} \u{2028} é";
        let written = serde_json::to_string(hostile).unwrap();
        let shown = visible_json(&written);
        assert!(!shown.chars().any(is_hidden), "{shown:?}");
        assert_eq!(serde_json::from_str::<String>(&shown).unwrap(), hostile);
        assert_eq!(visible_json("{\"a\": \"é\"}"), "{\"a\": \"é\"}");
    }
}
