//! The study: the user's text, read, checked and expanded into points.
//!
//! ```text
//! text ─ toml ─▶ table ─ keys, units ─▶ inputs, sweeps ─ expand, check ─▶ points
//! ```
//!
//! Every fault of a study is found here, before any work, and is reported with its place in the file.
//!
//! [`KINDS`]: crate::kinds::KINDS

use std::any::Any;
use std::cmp::Reverse;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use miette::NamedSource;
use toml::de::DeTable;
use toml::{Spanned, Table as TomlTable, Value};

use crate::chart::read::{read_all as read_charts, read_requirement};
use crate::chart::{Chart, Law, Requirement, Source, TableSchema};
use crate::device::Workload;
pub use crate::key::Precision;
use crate::key::document::{SpanMap, Table};
use crate::key::sensitivity::{self, Uncertain};
use crate::key::sweep::{self, Scale, Sweep, SweepValue, read_all as read_sweeps};
use crate::key::{
    KIND, Key, LIMIT, NONE as NO_PRECISION, PRECISION, ParseContext, QUESTION, SEED, STREAMS, Streams, TITLE,
    TRIALS, Unrepresentable, docs,
};
use crate::kinds::checked;
use crate::sampling::Planned;
use sagnac_base::diagnostics::{Fault, StudyError, Text, Wrong};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::Quantity;
use sagnac_base::table::About;
use sagnac_base::text_file::{Files, FolderFiles, InputFiles, MAX_RECORD, MAX_TOML, ReadFiles, read_text};

/// A valid study: every value is within its limits at every point.
#[derive(Debug, Clone)]
pub struct Study {
    /// Title as written, in one line.
    pub title: String,
    /// Question that the study answers; empty if the file has none.
    pub question: String,
    /// Seed of all random draws.
    pub seed: u64,
    /// Trials at each point.
    pub trials: u64,
    /// Whether points share their random numbers.
    pub streams: Streams,
    /// Sweeps in the order written; the first changes slowest.
    pub sweeps: Vec<Sweep>,
    /// Charts as written, or those supplied by the kind.
    pub charts: Vec<Chart>,
    /// The limit that its answer must meet.
    pub requirement: Option<Requirement>,
    /// Its kind.
    pub kind: &'static Kind,
    /// Notes on inputs that are ignored, rounded or assumed, each a sentence.
    pub notes: Vec<String>,
    /// Precision at which points stop instead of after a number of trials.
    pub precision: Option<Precision>,
    /// The part that belongs to its kind.
    pub subject: Arc<dyn Subject>,
    /// Its text, for messages with places.
    pub text: Text,
    /// Places of its keys in the text.
    pub places: SpanMap,
    /// What of the text a resolved study keeps.
    pub written: Written,
    /// The files that the study names.
    pub(crate) files: Arc<ReadFiles>,
    /// Inputs whose values are known only by a range or a distribution.
    pub uncertain: Vec<Uncertain>,
    /// The written quantities of the keys that a sweep may vary.
    pub values: Vec<(&'static Key, Quantity)>,
}

/// Most bytes of memory that the points and the tables of a study may take, and so may the trials of one of its points.
const MAX_BYTES: u64 = 1 << 30;

impl Study {
    /// The kind of the study.
    pub fn kind(&self) -> &'static Kind {
        self.kind
    }

    /// The part of the study that belongs to its kind, where that has the type `T`, such as `GapFill`; otherwise
    /// `None`.
    pub fn asked<T: 'static>(&self) -> Option<&T> {
        (self.subject.as_ref() as &dyn Any).downcast_ref()
    }

    /// The properties of one of its tables, as far as they are known before anything is sampled.
    pub fn ground(&self, source: Source) -> Option<TableSchema> {
        self.subject.grounds().into_iter().find(|ground| ground.source == source)
    }

    /// Number of points of its sweeps.
    pub fn points(&self) -> usize {
        sweep::count(&self.sweeps)
    }

    /// Whether a chart shows what the study may be judged by.
    pub fn is_judged_by(&self, chart: &Chart) -> bool {
        self.ground(chart.source).is_none_or(|ground| ground.judges(&chart.estimate().name))
    }

    /// The text columns of one of its tables, which distinguish rows in addition to the swept keys.
    pub fn text_columns(&self, source: Source) -> Vec<&'static str> {
        self.ground(source).map(|ground| ground.text_names()).unwrap_or_default()
    }

    /// The default rows of its points, as pairs of a column and its value as files show it.
    pub fn usual_rows(&self) -> Vec<(String, String)> {
        let ground = self.ground(Source::Points);
        let rows = ground.iter().flat_map(TableSchema::usual_rows);
        rows.map(|(column, value)| (column.name, value.text())).collect()
    }

    /// Drops the precision of the study, so that every point takes all trials.
    ///
    /// # Errors
    /// The precision is a table of its own, which cannot be replaced in a [resolved](Study::resolved) study.
    pub fn fix_trials(&mut self) -> Result<(), StudyError> {
        let Some(span) = self.written.precision.clone() else { return Ok(()) };
        if !self.text.inner()[span.clone()].starts_with(['"', '\'', '{']) {
            let message = "this precision cannot be left out to sample all trials";
            return Err(self.error_at(
                span,
                message,
                "write it as a value, precision = { rms = \"0.5 %\" }, or remove it",
            ));
        }
        self.precision = None;
        Ok(())
    }

    /// The laws drawn by any chart, each once.
    pub fn laws(&self) -> Vec<Law> {
        let mut laws: Vec<Law> = Vec::new();
        for law in self.charts.iter().flat_map(Chart::references) {
            if !laws.contains(law) {
                laws.push(*law);
            }
        }
        laws
    }

    /// An error at the bytes `span` of this study, for faults that are only found later, such as a chart's unknown
    /// column.
    ///
    /// `message` states the fault, `help` the accepted values.
    pub fn error_at(
        &self,
        span: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> StudyError {
        Fault::new(span, message, "here", help).within(&self.text)
    }

    /// Refuses trials of a point that do not fit into [`MAX_BYTES`] where each has these `numbers` in memory, with 32 bytes for
    /// each of them: its sum and what is made of it. `what` names what a trial of this kind is.
    pub(crate) fn check_trials(&self, numbers: usize, what: &str) -> Result<(), StudyError> {
        let most = MAX_BYTES / (32 * numbers.max(1) as u64);
        if self.trials <= most {
            return Ok(());
        }
        let message = format!("{} {what} of a point", self.trials);
        let help = format!("accepted: up to {most} trials, which are {what} here and take 1 GiB of memory");
        Err(self.error_at(self.place_of("trials"), message, help))
    }

    /// The error for a point at these swept values that cannot be sampled, at the key that has to change.
    pub fn refused(&self, swept: &[(&'static str, SweepValue)], refusal: &Unrepresentable) -> StudyError {
        let at: Vec<String> = swept.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        let place = if at.is_empty() { String::new() } else { format!(", at {}", at.join(", ")) };
        let Unrepresentable { key, message, help } = refusal;
        self.error_at(self.place_of(key), format!("{message}{place}"), *help)
    }

    /// The place of the values of `key`, for an error about them: those of a sweep over it, else its own value. A table
    /// such as `gyro.tick_noise` stands for the keys in it; the place is empty at 0 where nothing is written.
    pub fn place_of(&self, key: &str) -> Range<usize> {
        self.places.blame(&[key])
    }
}

/// A table of results, with its columns except the swept keys.
pub(crate) type TableColumns = (Source, fn() -> Vec<About>);

/// An entry of the list of kinds. Help, schema, documents, verification and tests iterate that list.
pub struct Kind {
    /// The name in study files, such as `gap-fill`.
    pub name: &'static str,
    /// The subject of such a study, in one sentence.
    pub subject: &'static str,
    /// A description of the simulation and of the columns of its results that hold the answer.
    pub about: &'static str,
    /// A study of this kind with every key explained.
    pub template: &'static str,
    /// Whether every value is a closed form, so that nothing is sampled.
    pub is_exact: bool,
    /// The number of trials at each point if the study gives none.
    pub(crate) trials: u64,
    /// The tables that it requires.
    pub(crate) needs: &'static [&'static str],
    /// Its keys, except those that every study has.
    pub keys: fn() -> Vec<&'static Key>,
    /// The keys that can be swept.
    pub sweepable: fn() -> Vec<&'static Key>,
    /// The columns of each of its tables except the swept keys.
    pub columns: &'static [TableColumns],
    /// The kernels that sample it, with their versions.
    pub kernels: fn() -> String,
    /// The loads on which its kernels are checked; none for closed forms.
    pub(crate) loads: fn() -> Vec<Workload>,
    /// Reads the part of a study that belongs to this kind.
    pub(crate) read: fn(&mut ParseContext) -> Result<Arc<dyn Subject>, Wrong>,
}

impl PartialEq for Kind {
    fn eq(&self, other: &Kind) -> bool {
        self.name == other.name
    }
}

impl Eq for Kind {}

impl fmt::Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// Bytes of memory that a row of a table takes, with the charts and pages that show it.
pub(crate) const ROW: u64 = 1150;

/// The part of a study that belongs to its kind.
pub trait Subject: Any + fmt::Debug + Send + Sync {
    /// Lowers every point. `progress` receives their number, and each as it is lowered.
    ///
    /// # Errors
    /// A point cannot be represented; the error points at the key to change.
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a>;

    /// The subject with a single one of its points: as it is, and without each part of its error in turn, everything
    /// else unchanged; fillers keep the weights that they have at the point. `None` where an error has no parts.
    fn dissected(&self, _point: usize) -> Option<Ablation> {
        None
    }

    /// The subject with only what one row of each point needs, by the place of the row among those of its point, and the
    /// place of the row then. `None` where a single row costs as much as all.
    fn only(&self, _row: usize) -> Option<(Arc<dyn Subject>, usize)> {
        None
    }

    /// The subject at the points of these sweeps instead of its own, everything else unchanged. `places` are those of the keys
    /// of the study.
    ///
    /// # Errors
    /// A point is not a valid one, or a sweep does not apply to the study.
    fn with_points(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<Arc<dyn Subject>, Fault>;

    /// Quantities at a point that the study does not contain itself, such as those in a file that it names, by the keys
    /// that set them.
    fn values(&self, _point: usize) -> Vec<(&'static Key, Quantity)> {
        vec![]
    }

    /// Bytes of memory that its points and their rows in tables take, about, where that may be more than the bounds of sweeps
    /// allow.
    fn bytes(&self) -> u64 {
        0
    }

    /// The tables of its results, as far as they are known before anything is sampled, with that of the points first.
    fn grounds(&self) -> Vec<TableSchema>;
}

/// A part of the error of points `P`.
pub(crate) struct Part<P: 'static> {
    /// Its name in sentences and tables, such as `motion`.
    pub(crate) name: &'static str,
    /// Switches it off. A point that does not have the part stays as it is.
    pub(crate) off: fn(&mut P),
}

/// A subject with a point as it is, and without each of its parts.
pub struct Ablation {
    /// The names of the parts that the point has.
    pub(crate) parts: Vec<&'static str>,
    pub(crate) subject: Arc<dyn Subject>,
}

/// A point as it is, and without each of its parts in turn, with the names of those that it has.
pub(crate) fn points<P: Clone + PartialEq>(point: &P, parts: &[Part<P>]) -> (Vec<&'static str>, Vec<P>) {
    let without = |part: &Part<P>| {
        let mut without = point.clone();
        (part.off)(&mut without);
        (without != *point).then_some((part.name, without))
    };
    let (names, others): (Vec<&'static str>, Vec<P>) = parts.iter().filter_map(without).unzip();
    (names, std::iter::once(point.clone()).chain(others).collect())
}

impl Study {
    /// The study of a single one of its points, which comes first, followed by that point without each of its parts in
    /// turn; with the names of these parts. All share their random numbers. `None` where its kind has no parts.
    pub fn dissected(&self, point: usize) -> Option<(Vec<&'static str>, Study)> {
        let Ablation { parts, subject } = self.subject.dissected(point)?;
        let (streams, precision) = (Streams::Common, None);
        Some((parts, Study { subject, streams, precision, charts: vec![], ..self.clone() }))
    }
}

/// The folder, beside a stored study, of the files that it names.
pub(crate) const INPUTS: &str = "inputs";

/// The parts of a study's text that may have to be replaced when it is stored.
#[derive(Debug, Clone)]
pub struct Written {
    pub(crate) seed: Option<Spanned<u64>>,
    pub(crate) trials: Option<Spanned<u64>>,
    /// The named files, with the places of their names.
    pub(crate) inputs: Vec<Spanned<Input>>,
    /// The end of the value of `kind`, which every study has at its top level.
    kind_end: usize,
    /// The place of the precision.
    pub(crate) precision: Option<Range<usize>>,
}

/// A file that a study names: a record, or noise.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// Its name in a stored study, relative to that study, such as `inputs/LGK-400.toml`.
    pub name: String,
    /// Its contents when the study was read.
    pub text: Arc<str>,
    /// Its path when the study was read.
    pub path: PathBuf,
}

/// The files that a study names. A file that could not be read is missing; it has been reported, or is not needed.
fn inputs(study: &Table, keys: &[&'static Key], sweeps: &[Sweep], files: &InputFiles) -> Vec<Spanned<Input>> {
    let written = keys.iter().filter(|key| key.is_file()).filter_map(|key| study.get(key));
    let written = written.map(|given| Spanned::new(given.span(), given.text().to_owned()));
    let named = written.chain(sweeps.iter().flat_map(|sweep| sweep.files.clone()));
    let mut inputs: Vec<Spanned<Input>> = Vec::new();
    for file in named {
        let Ok(text) = files.text(file.get_ref(), MAX_RECORD) else { continue };
        let path = files.path(file.get_ref());
        let known = inputs.iter().map(Spanned::get_ref).find(|input| input.path == path);
        let input = known.cloned().unwrap_or_else(|| Input { name: name(&path, &inputs), text, path });
        inputs.push(Spanned::new(file.span(), input));
    }
    inputs
}

/// A name that no other file has, even where names are not case-sensitive. It ends like the path, because tables name
/// gyros by it.
fn name(path: &Path, taken: &[Spanned<Input>]) -> String {
    let last = path.file_name().unwrap_or_default().to_string_lossy();
    let numbered = (2_u32..).map(|number| format!("{INPUTS}/{number}/{last}"));
    let mut names = std::iter::once(format!("{INPUTS}/{last}")).chain(numbered);
    let is_free =
        |name: &String| taken.iter().all(|input| input.get_ref().name.to_lowercase() != name.to_lowercase());
    names.find(is_free).unwrap_or_default()
}

impl Study {
    /// The study as read, but with its current seed, `trials` trials, its files in `inputs` beside it, and without a
    /// precision that was [left out](Study::fix_trials). Together with [its files](Study::inputs) it repeats this study
    /// without further options, wherever it is stored. Comments and layout are preserved. Seed and trials are left out
    /// where nothing is sampled.
    pub fn resolved(&self, trials: u64) -> String {
        let Written { seed, trials: written_trials, inputs, kind_end, precision } = &self.written;
        let mut text = self.text.inner().clone();
        let next_line = text[*kind_end..].find('\n').map(|length| kind_end + length + 1);
        // A key right after the kind is at the top level, before any table.
        let after_kind = next_line.unwrap_or(text.len());
        let line_end = if next_line.is_some() { "" } else { "\n" };
        let mut edits = Vec::new();
        for (key, value, written) in [("trials", trials, written_trials), ("seed", self.seed, seed)] {
            match written {
                _ if self.kind.is_exact => {}
                None => edits.push((after_kind..after_kind, format!("{line_end}{key} = {value}\n"))),
                Some(written) if *written.get_ref() != value => {
                    edits.push((written.span(), value.to_string()))
                }
                // An unchanged value keeps its notation, such as 1_000_000 or 0xff.
                Some(_) => {}
            }
        }
        if let Some(span) = precision.clone().filter(|_| self.precision.is_none()) {
            edits.push((span, format!("\"{NO_PRECISION}\"")));
        }
        for input in inputs {
            edits.push((input.span(), toml::Value::String(input.get_ref().name.clone()).to_string()));
        }
        // Edits go from the end, so that the places of the others remain valid.
        edits.sort_by_key(|(place, _)| Reverse(place.start));
        for (place, new) in edits {
            text.replace_range(place, &new);
        }
        text
    }

    /// The text from which it was read.
    pub fn text(&self) -> &str {
        self.text.inner()
    }

    /// The files that it names, each once.
    pub fn inputs(&self) -> Vec<&Input> {
        let mut inputs: Vec<&Input> = Vec::new();
        for input in self.written.inputs.iter().map(Spanned::get_ref) {
            if !inputs.contains(&input) {
                inputs.push(input);
            }
        }
        inputs
    }
}

impl Study {
    /// Reads the study file at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or [`Study::parse`] fails.
    pub fn read(path: &Path) -> Result<Study, StudyError> {
        let text = read_text(path, MAX_TOML).map_err(|error| {
            if path.is_dir() {
                return StudyError::of_folder(path);
            }
            StudyError::unreadable("the study", path, &error, "give the path of a study file (TOML, UTF-8)")
        })?;
        Study::parse(&path.display().to_string(), &text)
    }

    /// Reads a study from its `text`; `name` is the name of the file in messages.
    ///
    /// # Errors
    /// The first fault found, with its place in the text.
    ///
    /// # Example
    /// ```
    /// # use sagnac_engine::study::Study;
    /// let error = Study::parse("my.toml", "title = 5 ms").unwrap_err();
    /// assert!(error.render(false, 100).contains("my.toml:1"));
    /// ```
    pub fn parse(name: &str, text: &str) -> Result<Study, StudyError> {
        let folder = FolderFiles(Path::new(name).parent().unwrap_or(Path::new("")).to_owned());
        Study::parse_with(name, text, &folder)
    }

    /// Reads a study from its `text` as [`Study::parse`] does; the files that it names are `files`, of which nothing is on a disk
    /// unless they are.
    ///
    /// # Errors
    /// The first fault found, with its place in the text.
    ///
    /// # Example
    /// ```
    /// # use sagnac_engine::study::Study;
    /// # use std::collections::BTreeMap;
    /// let text = r#"
    ///     title = "A gyro of which only the noise is known"
    ///     kind = "allan"
    ///     [record]
    ///     sample = "1 s"
    ///     length = "1 h"
    ///     [noise]
    ///     file = "gyro.toml"
    /// "#;
    /// let noise = br#"angle_random_walk = "0.003 deg/sqrt(h)""#;
    /// let files = BTreeMap::from([("gyro.toml".to_owned(), noise.to_vec())]);
    /// let study = Study::parse_with("my.toml", text, &files)?;
    /// assert_eq!(study.inputs()[0].name, "inputs/gyro.toml");
    /// # Ok::<(), sagnac_base::diagnostics::StudyError>(())
    /// ```
    pub fn parse_with(name: &str, text: &str, files: &dyn Files) -> Result<Study, StudyError> {
        let text: Text = Arc::new(NamedSource::new(name, text.to_owned()));
        Study::check(&text, files).map_err(|wrong| wrong.within(&text))
    }

    fn check(text: &Text, files: &dyn Files) -> Result<Study, Wrong> {
        if let Some(at) = text.inner().find('\0') {
            let message = "the study is not text in UTF-8: it contains a zero byte, as UTF-16 does";
            return Err(Fault::new(at..at + 1, message, "here", "save it as UTF-8").into());
        }
        let mut root =
            DeTable::parse(text.inner()).map_err(|error| Fault::from_syntax("the study", &error))?;
        let notes = docs::replace("", root.get_mut());
        let table = Table::root("", &root);
        let (kind, keys) = checked(&table)?;
        let files = InputFiles::new(files);
        let sweeps = read_sweeps(&table, &keys.keys, &keys.sweepable)?;
        let uncertain = sensitivity::read_all(&table, &keys.keys, &keys.sweepable, &sweeps)?;
        let count = |key: &'static Key| -> Result<Option<Spanned<u64>>, Fault> {
            let Some(given) = table.get(key) else { return Ok(None) };
            Ok(Some(Spanned::new(given.span(), given.whole()?.cast_unsigned())))
        };
        let (seed, trials) = (count(&SEED)?, count(&TRIALS)?);
        let places = SpanMap::new(&sweeps);
        let precision = None;
        let mut reading =
            ParseContext { table: table.clone(), sweeps: &sweeps, files: &files, places, notes, precision };
        reading.note(&[&KIND, &TRIALS, &PRECISION]);
        let subject = (kind.read)(&mut reading)?;
        let ParseContext { mut places, notes, precision, .. } = reading;
        check_bytes(&*subject, &sweeps, table.span_of(&KIND).unwrap_or_default())?;
        // After the values that are read, which come first where both are written.
        uncertain.iter().for_each(|input| places.add(input.key.name, input.span.clone()));
        let written_text = |key| table.get(key).map_or(String::new(), |given| given.text().to_owned());
        let grounds = subject.grounds();
        let mut charts = read_charts(&table, &sweeps, &grounds)?;
        let requirement = table.get(&LIMIT).map(|given| read_requirement(given, &grounds, &mut charts));
        let requirement = requirement.transpose()?;
        for chart in &mut charts {
            if chart.title.is_empty() {
                chart.title = written_text(&TITLE);
            }
            chart.subtitle = written_text(&QUESTION);
            let ground = grounds.iter().find(|ground| ground.source == chart.source);
            let texts = ground.map(TableSchema::text_names).unwrap_or_default();
            let apart = sweeps.iter().map(|sweep| sweep.key.name).chain(texts);
            chart.apart = apart.map(str::to_owned).collect();
            let [points, bands] = ground.map_or([""; 2], |ground| ground.legend_of(&chart.estimate().name));
            (chart.points, chart.bands) = (points.to_owned(), bands.to_owned());
        }
        Ok(Study {
            title: written_text(&TITLE),
            question: written_text(&QUESTION),
            seed: seed.as_ref().map_or(1, |seed| *seed.get_ref()),
            trials: trials.as_ref().map_or(kind.trials, |trials| *trials.get_ref()),
            streams: Streams::from_value(table.get(&STREAMS)),
            charts,
            requirement,
            kind,
            notes,
            precision,
            subject,
            text: text.clone(),
            places,
            written: Written {
                seed,
                trials,
                inputs: inputs(&table, &keys.keys, &sweeps, &files),
                kind_end: table.span_of(&KIND).unwrap_or_default().end,
                precision: table.span_of(&PRECISION),
            },
            uncertain,
            values: values(&table, &keys.sweepable),
            sweeps,
            files: Arc::new(files.into_read()),
        })
    }
}

/// Refuses a study whose points take too much memory, at the place of its first sweep, or of its `kind`.
fn check_bytes(subject: &dyn Subject, sweeps: &[Sweep], kind: Range<usize>) -> Result<(), Fault> {
    let bytes = subject.bytes();
    if bytes <= MAX_BYTES {
        return Ok(());
    }
    let span = sweeps.first().map_or(kind, |sweep| sweep.span.clone());
    let message = format!("the points of this study and their tables take {} MiB of memory", bytes >> 20);
    let help = "accepted: up to 1024 MiB; sweep fewer values, or take fewer fillers, times or trajectories";
    Err(Fault::new(span, message, "too many points", help))
}

/// The quantities of the keys that a sweep may vary, as far as they are written.
fn values(table: &Table, sweepable: &[&'static Key]) -> Vec<(&'static Key, Quantity)> {
    let written = sweepable.iter().filter_map(|key| Some((*key, table.get(key)?.quantity().ok()?)));
    written.collect()
}

impl Study {
    /// Returns the study with other points than its own: each has a value for each of the `keys`, which a sweep may
    /// vary, and all other inputs are as written. All points share their random numbers, so that their differences are
    /// those of the inputs. There are no charts, and no precision at which points stop.
    ///
    /// # Errors
    /// A value is outside the limits of its key, or a point is not a valid one; the error points at the key.
    pub fn at_points(&self, keys: &[&'static Key], points: &[Vec<SweepValue>]) -> Result<Study, StudyError> {
        let sweeps = keys.iter().enumerate().map(|(at, key)| self.joined(key, points, at));
        let sweeps = sweeps.collect::<Result<Vec<Sweep>, StudyError>>()?;
        let subject = self.subject.with_points(&sweeps, &self.places).and_then(|subject| {
            check_bytes(&*subject, &sweeps, self.place_of(KIND.name))?;
            Ok(subject)
        });
        let subject = subject.map_err(|fault| fault.within(&self.text))?;
        let (streams, precision) = (Streams::Common, None);
        Ok(Study { subject, sweeps, streams, precision, charts: vec![], ..self.clone() })
    }

    /// The study with other fillers: `edit` changes the entries of `switching.fillers`. Its text is written anew, without
    /// comments.
    ///
    /// # Errors
    /// A filler is not a valid one.
    pub fn with_fillers(&self, edit: impl FnOnce(&mut Vec<Value>)) -> Result<Study, StudyError> {
        // The text is that of a valid study.
        let mut root: TomlTable = self.text.inner().parse().unwrap_or_default();
        let fillers = root.get_mut("switching").and_then(|table| table.get_mut("fillers"));
        if let Some(Value::Array(fillers)) = fillers {
            edit(fillers);
        }
        let text = toml::to_string(&root).unwrap_or_default();
        let study = Study::parse_with(self.text.name(), &text, &*self.files)?;
        let (seed, trials, streams) = (self.seed, self.trials, self.streams);
        Ok(Study { seed, trials, streams, precision: self.precision, ..study })
    }

    /// The values of one key at some points as a sweep.
    fn joined(&self, key: &'static Key, points: &[Vec<SweepValue>], at: usize) -> Result<Sweep, StudyError> {
        let span = self.place_of(key.name);
        let values: Vec<SweepValue> = points.iter().map(|point| point[at].clone()).collect();
        let outside = values.iter().filter_map(SweepValue::quantity).find(|value| !key.admits(value.value));
        if let Some(value) = outside {
            let message = format!("{} = {value} is out of range", key.name);
            return Err(self.error_at(span, message, format!("accepted: {}", key.range())));
        }
        let own = self.sweeps.iter().find(|sweep| std::ptr::eq(sweep.key, key));
        let file = |value: &SweepValue| {
            own.and_then(|own| {
                Some(own.files.get(own.values.iter().position(|known| known == value)?)?.clone())
            })
        };
        let files: Vec<Spanned<String>> = values.iter().filter_map(file).collect();
        let key_span = span.clone();
        Ok(Sweep { key, values, files, scale: Scale::Linear, key_span, span, is_joined: true })
    }
}

#[cfg(test)]
mod tests {
    use super::Study;
    use crate::key::sweep::SweepValue;
    use crate::kinds::gap_fill::GapFill;
    use sagnac_base::quantity::{Dimension, Quantity};

    #[test]
    fn points_have_the_values_given_and_all_others_as_written() {
        let study = Study::parse("s.toml", include_str!("../../../studies/error_vs_dtnu.toml")).unwrap();
        let keys = [study.sweeps[0].key, study.sweeps[1].key];
        let frequency = |hz: f64| SweepValue::Quantity(Quantity::new(hz, Dimension::Frequency));
        let gap = |n: f64| SweepValue::Quantity(Quantity::new(n, Dimension::Count));
        let value =
            |key: usize, at: f64| if study.sweeps[key].key.is_whole() { gap(at) } else { frequency(at) };
        let points = [vec![value(0, 3.0), value(1, 5.0)], vec![value(0, 2.0), value(1, 4.0)]];
        let there = study.at_points(&keys, &points).unwrap();
        let asked = there.asked::<GapFill>().unwrap();
        assert_eq!((asked.points.len(), there.charts.len()), (2, 0));
        assert_eq!(asked.points[1].swept[0].1, points[1][0]);
        assert_eq!(asked.points[1].inputs.tick_s, study.asked::<GapFill>().unwrap().points[0].inputs.tick_s);
        let error = study.at_points(&keys, &[vec![value(0, -1.0), value(1, -1.0)]]).unwrap_err();
        assert!(error.render(false, 100).contains("is out of range"), "{error:?}");
    }
}
