//! The rows of keys, from which reading, checking, help and the schema are derived; and the keys at the top of every study.

pub mod docs;
pub(crate) mod document;
pub mod sensitivity;
pub mod sweep;

use crate::key::document::{SpanMap, SpannedValue, Table};
use crate::key::sweep::{Sweep, SweepTarget};
pub(crate) use sagnac_base::Word;
use sagnac_base::diagnostics::Fault;
pub use sagnac_base::names;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, Quantity};
use sagnac_base::text_file::InputFiles;
use sagnac_kernel::moments::BIN_BITS;

/// The part that a key plays in the question of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// A designer chooses it, and may change it to meet a limit.
    Choice,
    /// A designer chooses it with the question.
    Fixed,
    /// It is given; a change of it is told all the same, as that of an amplitude.
    Condition,
    /// It is given with the question, such as the time of a run.
    Question,
}

impl Role {
    /// Whether its values are conditions instead of options.
    pub fn is_given(self) -> bool {
        matches!(self, Role::Condition | Role::Question)
    }

    /// Whether it may change to meet a limit.
    pub fn may_change(self) -> bool {
        matches!(self, Role::Choice | Role::Condition)
    }
}

/// A key of study files.
#[derive(Debug)]
pub struct Key {
    /// Path from the root, as in study files and column names, such as `motion.frequency`.
    pub name: &'static str,
    /// Label for axes and reports, such as `vibration frequency`; empty where the key cannot be swept.
    pub label: &'static str,
    /// The part that it plays in the question of a study.
    pub role: Role,
    /// Its meaning.
    pub(crate) doc: &'static str,
    pub(crate) holds: ValueType,
    /// An example as written in a study file.
    pub example: &'static str,
    /// Whether its table requires it.
    pub(crate) required: bool,
}

/// Declares keys and a list of them. A row has the key, its label, its role, the values that it holds and an example; its doc
/// comment is its meaning.
macro_rules! keys {
    ($(#[doc = $about:literal])* $list_vis:vis static $list:ident;
     $($(#[doc = $doc:literal])* $vis:vis $name:ident = $key:literal, $label:literal, $role:ident, $holds:expr, $example:literal $(, $required:ident)?;)+) => {
        $(
            $(#[doc = $doc])*
            // The words are those of help, in which brackets are tables of a study.
            #[allow(rustdoc::broken_intra_doc_links)]
            $vis static $name: $crate::key::Key = $crate::key::Key {
                name: $key,
                label: $label,
                role: $crate::key::Role::$role,
                doc: concat!($($doc, "\n"),*),
                holds: $holds,
                example: $example,
                required: $crate::key::keys!(@ $($required)?),
            };
        )+
        $(#[doc = $about])*
        #[allow(dead_code, reason = "keys that only sweeps name are in no kind's list")]
        $list_vis static $list: &[&$crate::key::Key] = &[$(&$name),+];
    };
    (@) => { false };
    (@ required) => { true };
}
pub(crate) use keys;

impl Key {
    /// The name of its table; empty for the root.
    pub(crate) fn table(&self) -> &'static str {
        self.name.rsplit_once('.').map_or("", |(table, _)| table)
    }

    /// Its name within that table.
    pub(crate) fn last(&self) -> &'static str {
        self.name.rsplit_once('.').map_or(self.name, |(_, last)| last)
    }

    /// Its meaning, in one line.
    pub(crate) fn meaning(&self) -> String {
        one_line(self.doc)
    }

    /// Whether it holds whole numbers.
    pub fn is_whole(&self) -> bool {
        matches!(self.holds, ValueType::Whole(..))
    }

    /// The lowest and the highest value, in base units; `None` for what is no number.
    pub fn limits(&self) -> Option<[f64; 2]> {
        match self.holds {
            ValueType::Whole(low, high) => Some([low as f64, high as f64]),
            _ => self.holds.measured().map(|measure| [measure.limits.0, measure.limits.1]),
        }
    }

    /// Whether it holds the name of a file.
    pub(crate) fn is_file(&self) -> bool {
        matches!(self.holds, ValueType::File)
    }

    /// Whether a quantity is within its limits.
    pub(crate) fn admits(&self, value: f64) -> bool {
        match self.holds {
            ValueType::Whole(..) if value.fract() != 0.0 => false,
            _ => self.limits().is_some_and(|[low, high]| (low..=high).contains(&value)),
        }
    }

    /// The names that it accepts, where it holds one of several.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        match self.holds {
            ValueType::Name(names) => names.to_vec(),
            ValueType::Word(words) => words.iter().map(|word| word.word).collect(),
            _ => vec![],
        }
    }

    /// Whether it holds a name, of a file or otherwise.
    pub(crate) fn is_name(&self) -> bool {
        self.is_file() || !self.names().is_empty()
    }

    /// The range of its values for the user, or the available names.
    pub(crate) fn range(&self) -> String {
        match self.holds {
            ValueType::Whole(low, high) => format!("{low} to {high}"),
            _ if self.is_name() => self.names().join(", "),
            _ => self.holds.measured().map_or("", |measure| measure.range).to_owned(),
        }
    }

    /// Why it cannot be swept, where that is the case.
    pub(crate) fn fixed(&self) -> &'static str {
        match self.holds {
            ValueType::Text | ValueType::Word(_) | ValueType::Name(_) | ValueType::File => "is text",
            ValueType::List(_) | ValueType::Pair(_) => "is a list",
            ValueType::Table | ValueType::OneOf | ValueType::Free => "is a table",
            _ => "holds for the whole study",
        }
    }
}

/// The words of a text, separated by single spaces.
pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The full name of `key` in the table `table`, which is empty for the root.
pub(crate) fn joined(table: &str, key: &str) -> String {
    if table.is_empty() { key.to_owned() } else { format!("{table}.{key}") }
}

/// The shape of a key's value, with its limits.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ValueType {
    Text,
    /// One of several words.
    Word(&'static [Word]),
    /// One of several names, which a sweep may vary.
    Name(&'static [&'static str]),
    /// The path of a file, relative to the folder of the study.
    File,
    Flag,
    /// A whole number between the two limits, both included.
    Whole(i64, i64),
    Measure(Measure),
    /// A percentage.
    Percent,
    /// One value whose meaning depends on others.
    Any,
    List(&'static ValueType),
    /// A list of two values.
    Pair(&'static ValueType),
    /// One of several shapes.
    Either(&'static [ValueType]),
    /// A table of the keys whose names continue this one's.
    Table,
    /// A table with exactly one of its keys.
    OneOf,
    /// A table with arbitrary keys, each with one value.
    Free,
}

/// The dimensions and limits of a quantity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measure {
    /// The accepted dimensions.
    pub(crate) accepts: &'static [Dimension],
    /// Lowest and highest value in base units.
    pub(crate) limits: (f64, f64),
    /// The limits for the user; empty where there are none.
    pub(crate) range: &'static str,
}

/// A quantity of one of some dimensions, within limits.
pub(crate) const fn measure(
    accepts: &'static [Dimension],
    low: f64,
    high: f64,
    range: &'static str,
) -> ValueType {
    ValueType::Measure(Measure { accepts, limits: (low, high), range })
}

/// A quantity without limits.
pub(crate) const fn unlimited(accepts: &'static [Dimension]) -> ValueType {
    measure(accepts, f64::NEG_INFINITY, f64::INFINITY, "")
}

impl ValueType {
    /// The quantity that is held, also within lists or alternatives.
    pub(crate) fn measured(&self) -> Option<Measure> {
        match self {
            ValueType::Measure(measure) => Some(*measure),
            ValueType::List(inner) | ValueType::Pair(inner) => inner.measured(),
            ValueType::Either(shapes) => shapes.iter().find_map(ValueType::measured),
            _ => None,
        }
    }

    /// The words that are held; empty for other shapes.
    pub(crate) fn words(&self) -> &'static [Word] {
        match self {
            ValueType::Word(words) => words,
            ValueType::List(inner) => inner.words(),
            ValueType::Either(shapes) => {
                shapes.iter().map(ValueType::words).find(|words| !words.is_empty()).unwrap_or_default()
            }
            _ => &[],
        }
    }

    /// Whether the value may be a table with keys of its own.
    pub(crate) fn is_table(&self) -> bool {
        match self {
            ValueType::Table | ValueType::OneOf => true,
            ValueType::List(inner) => inner.is_table(),
            ValueType::Either(shapes) => shapes.iter().any(ValueType::is_table),
            _ => false,
        }
    }

    /// Description for sentences, such as `a text in quotes`.
    pub(crate) fn described(&self) -> String {
        match self {
            ValueType::Text | ValueType::Word(_) | ValueType::Name(_) | ValueType::File => {
                "a text in quotes".to_owned()
            }
            ValueType::Flag => "true or false".to_owned(),
            ValueType::Whole(..) => "a whole number".to_owned(),
            ValueType::Measure(Measure { accepts: [Dimension::Ratio], .. }) => {
                "a number, or percent in quotes".to_owned()
            }
            ValueType::Measure(_) => "a number with its unit, in quotes".to_owned(),
            ValueType::Percent => "a percentage in quotes".to_owned(),
            ValueType::Any => "one value".to_owned(),
            ValueType::List(ValueType::Table) => "a list of tables in brackets".to_owned(),
            ValueType::List(ValueType::Pair(_)) => "a list of pairs in brackets".to_owned(),
            ValueType::List(ValueType::Text | ValueType::Word(_)) => "a list of texts in brackets".to_owned(),
            ValueType::List(ValueType::Measure(_)) => "a list of quantities in brackets".to_owned(),
            ValueType::List(_) => "a list in brackets".to_owned(),
            ValueType::Pair(_) => "a list of two ends".to_owned(),
            ValueType::Either(shapes) => {
                shapes.iter().map(ValueType::described).collect::<Vec<_>>().join(", or ")
            }
            ValueType::Table => "a table".to_owned(),
            ValueType::OneOf => "a table of one key".to_owned(),
            ValueType::Free => "a table of columns and values".to_owned(),
        }
    }
}

/// Declares an enum as [`names`] does, whose values are the words of a key. The first one is the default.
macro_rules! words {
    ($(#[doc = $doc:literal])+ $vis:vis enum $name:ident { $($values:tt)+ }) => {
        $crate::key::names! { $(#[doc = $doc])+ $vis enum $name { $($values)+ } }

        #[allow(dead_code, reason = "some words are read from lists")]
        impl $name {
            /// The value as written, or the default.
            pub(crate) fn from_value(given: Option<$crate::key::document::SpannedValue>) -> $name {
                let named = |given: $crate::key::document::SpannedValue| {
                    $name::ALL.into_iter().find(|known| known.name() == given.text())
                };
                given.and_then(named).unwrap_or_default()
            }
        }

        impl Default for $name {
            fn default() -> $name {
                $name::ALL[0]
            }
        }
    };
}
pub(crate) use words;

/// Why a point cannot be sampled, and what to change.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Unrepresentable {
    /// The key of the study that has to change.
    pub key: &'static str,
    /// The finding; it names the key.
    pub message: String,
    /// Advice on the change.
    pub help: &'static str,
}

impl Unrepresentable {
    /// A refusal whose message names the key and the finding.
    pub(crate) fn new(
        key: &'static str,
        found: impl std::fmt::Display,
        help: &'static str,
    ) -> Unrepresentable {
        Unrepresentable { key, message: format!("{key}: {found}"), help }
    }
}

/// A number formatted for messages.
pub(crate) fn shown(x: f64) -> String {
    significant(x, 6)
}

words! {
    /// Whether the points of a study share their random numbers.
    pub enum Streams {
        /// Every point draws its own random numbers.
        Independent = "independent",
        /// A trial has the same random numbers at every point, which gives smooth curves and paired differences.
        Common = "common",
    }
}

/// Most trials at one point, 2^40.
pub const MAX_TRIALS: u64 = 1 << 40;

keys! {
    /// The keys at the top of every study.
    pub(crate) static KEYS;
    /// Title shown above charts and reports.
    pub(crate) TITLE = "title", "", Fixed, ValueType::Text, r#"title = "Error of the gap fillers""#, required;
    /// The question that the study answers, in one sentence.
    pub(crate) QUESTION = "question", "", Fixed, ValueType::Text, r#"question = "Which filler is good enough?""#;
    /// Kind of the study.
    pub KIND = "kind", "", Fixed, ValueType::Text, r#"kind = "gap-fill""#, required;
    /// Seed of all random numbers; 1 if absent.
    pub(crate) SEED = "seed", "", Fixed, ValueType::Whole(0, i64::MAX), "seed = 1";
    /// Monte Carlo trials at each point. If absent, 1 000 000; for kind = "switched-run" 100 000 runs, for kind =
    /// "allan" 1000 records, and for kind = "navigation" 1000 navigators. Kinds in closed form do not use it.
    pub TRIALS = "trials", "", Fixed, ValueType::Whole(1, MAX_TRIALS as i64), "trials = 1_000_000";
    /// Requirement of the study, above 0, which its answer must stay within: an error as an angle, "10 arcsec", of a
    /// position as a distance, "1 nmi"; a drift or an Allan deviation as a rate, "0.01 deg/h"; the error of a coefficient as
    /// a percentage, "10 %". Charts of that estimate that have no limit of their own take it, and a chart that the study
    /// leaves to the program shows that estimate.
    pub LIMIT = "limit", "", Fixed, ValueType::Any, r#"limit = "10 arcsec""#;
    /// Whether the points share their random numbers.
    pub STREAMS = "streams", "", Fixed, ValueType::Word(Streams::WORDS), r#"streams = "independent""#;
}

keys! {
    /// The keys of the stop rule.
    pub(crate) static PRECISION_KEYS;
    /// Precision at which a point stops before it has all `trials`. "0.5 %" is half the width of the 95 % interval of
    /// the rms, relative to the rms. A table gives a precision for each of several estimates. "none" samples all
    /// trials.
    pub PRECISION = "precision", "", Fixed, ValueType::Either(&[ValueType::Percent, ValueType::Table]), r#"precision = "0.5 %""#;
    /// Precision of the rms: "0.5 %".
    PRECISION_RMS = "precision.rms", "", Fixed, ValueType::Percent, r#"rms = "0.5 %""#;
    /// Precision of the 99.73 % level: "2 %".
    PRECISION_P99_73 = "precision.p99_73", "", Fixed, ValueType::Percent, r#"p99_73 = "2 %""#;
}

/// Half the 95 % interval of each estimate, relative to the estimate, at which sampling may stop. A filler at a point
/// stops when all its errors are this precise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precision {
    /// Precision of the rms.
    pub rms: Option<f64>,
    /// Precision of the 99.73 % level, whose interval ends at edges of histogram bins.
    pub p99_73: Option<f64>,
}

const HELP: &str = "accepted: a percentage such as \"0.5 %\", of the rms; or { rms = \"0.5 %\", p99_73 = \"2 %\" }, one or both; or \"none\"";

/// The word for no precision, with which all trials are sampled.
pub(crate) const NONE: &str = "none";

/// Reads the precision; a bare percentage is that of the rms.
pub(crate) fn read(study: &Table) -> Result<Option<Precision>, Fault> {
    let Some(written) = study.get(&PRECISION) else { return Ok(None) };
    if written.text() == NONE {
        return Ok(None);
    }
    if written.table().is_none() {
        return Ok(Some(Precision { rms: Some(written.percent(HELP)?), p99_73: None }));
    }
    let part = |key| study.get(key).map(|part| part.percent(HELP)).transpose();
    match (part(&PRECISION_RMS)?, part(&PRECISION_P99_73)?) {
        (None, None) => Err(written.fault("precision names no estimate", "empty", HELP)),
        (rms, p99_73) => Ok(Some(Precision { rms, p99_73 })),
    }
}

/// The widest bin of the histogram relative to the level.
const BIN: f64 = 1.0 / (1 << BIN_BITS) as f64;

/// A note that a level may not reach its precision with any number of trials, because its interval has at least one
/// bin, and two where it lies close to an edge.
pub(crate) fn finer_than_bins(precision: &Precision) -> Option<String> {
    let part = precision.p99_73.filter(|part| *part < BIN)?;
    let how = if part < 0.25 * BIN { "none reaches" } else { "some may not reach" };
    Some(format!(
        "99.73 % levels are only known to a bin of their histogram, ±0.2 to ±0.8 %: {how} the {} % requested, and take all trials",
        significant(100.0 * part, 3)
    ))
}

/// Source from which a kind reads its inputs.
pub(crate) struct ParseContext<'a> {
    /// The whole study, in which all keys belong to its kind and have the right shape.
    pub(crate) table: Table<'a>,
    pub(crate) sweeps: &'a [Sweep],
    /// The files that the study names.
    pub(crate) files: &'a InputFiles<'a>,
    /// Places of the values read, for errors that are found later.
    pub(crate) places: SpanMap,
    /// Notes on inputs that are ignored, rounded or assumed, each a sentence.
    pub(crate) notes: Vec<String>,
    /// Precision at which points stop; none for a kind without a stop rule.
    pub(crate) precision: Option<Precision>,
}

impl<'a> ParseContext<'a> {
    pub(crate) fn get(&self, key: &'static Key) -> Option<SpannedValue<'a>> {
        self.table.get(key)
    }

    /// Records the places of some keys.
    pub(crate) fn note(&mut self, keys: &[&'static Key]) {
        for key in keys {
            if let Some(span) = self.table.span_of(key) {
                self.places.add(key.name, span);
            }
        }
    }

    /// Sets the written values of some settings in `inputs`, records their places, and returns them.
    pub(crate) fn set<I>(
        &mut self,
        inputs: &mut I,
        settings: &'static [SweepTarget<I>],
    ) -> Result<Vec<(&'static SweepTarget<I>, Quantity)>, Fault> {
        let mut written = Vec::new();
        for setting in settings {
            let Some(given) = self.table.get(setting.key) else { continue };
            let quantity = given.quantity()?;
            (setting.set)(inputs, quantity);
            self.places.add(setting.key.name, given.span());
            written.push((setting, quantity));
        }
        Ok(written)
    }

    /// The sweep over a key.
    pub(crate) fn sweep(&self, key: &Key) -> Option<&'a Sweep> {
        self.sweeps.iter().find(|sweep| std::ptr::eq(sweep.key, key))
    }
}
