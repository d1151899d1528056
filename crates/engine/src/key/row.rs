//! The row of a key, from which reading, checking, help and the schema are derived.

use crate::key::holds::{Holds, Measure};

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
    pub(crate) holds: Holds,
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
            $vis static $name: $crate::key::row::Key = $crate::key::row::Key {
                name: $key,
                label: $label,
                role: $crate::key::row::Role::$role,
                doc: concat!($($doc, "\n"),*),
                holds: $holds,
                example: $example,
                required: $crate::key::row::keys!(@ $($required)?),
            };
        )+
        $(#[doc = $about])*
        #[allow(dead_code, reason = "keys that only sweeps name are in no kind's list")]
        $list_vis static $list: &[&$crate::key::row::Key] = &[$(&$name),+];
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
        matches!(self.holds, Holds::Whole(..))
    }

    /// Whether it holds the name of a file.
    pub(crate) fn is_file(&self) -> bool {
        matches!(self.holds, Holds::File)
    }

    /// Whether a quantity is within its limits.
    pub(crate) fn admits(&self, value: f64) -> bool {
        match self.holds {
            Holds::Whole(low, high) => value.fract() == 0.0 && (low as f64..=high as f64).contains(&value),
            _ => self
                .holds
                .measured()
                .is_some_and(|Measure { limits: (low, high), .. }| (low..=high).contains(&value)),
        }
    }

    /// The names that it accepts, where it holds one of several.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        match self.holds {
            Holds::Name(names) => names.to_vec(),
            Holds::Word(words) => words.iter().map(|word| word.word).collect(),
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
            Holds::Whole(low, high) => format!("{low} to {high}"),
            _ if self.is_name() => self.names().join(", "),
            _ => self.holds.measured().map_or("", |measure| measure.range).to_owned(),
        }
    }

    /// Why it cannot be swept, where that is the case.
    pub(crate) fn fixed(&self) -> &'static str {
        match self.holds {
            Holds::Text | Holds::Word(_) | Holds::Name(_) | Holds::File => "is text",
            Holds::List(_) | Holds::Pair(_) => "is a list",
            Holds::Table | Holds::OneOf | Holds::Free => "is a table",
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
