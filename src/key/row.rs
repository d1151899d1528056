//! The row of a key: all that reading, checking, help and the schema know of it.

use crate::key::holds::Holds;

/// A key of study files.
#[derive(Debug)]
pub struct Key {
    /// From the root, as in study files and column names: `motion.frequency`.
    pub name: &'static str,
    /// For axes and reports: `vibration frequency`; empty where it cannot be swept.
    pub label: &'static str,
    /// What it means.
    pub(crate) doc: &'static str,
    pub(crate) holds: Holds,
    /// As a study file has it.
    pub(crate) example: &'static str,
    /// Whether the table that it is in needs it.
    pub(crate) required: bool,
}

/// Declares keys and the list of them. A row has the key, its label, what it holds and an example; its doc is what it means.
macro_rules! keys {
    ($(#[doc = $about:literal])* $list_vis:vis static $list:ident;
     $($(#[doc = $doc:literal])* $vis:vis $name:ident = $key:literal, $label:literal, $holds:expr, $example:literal $(, $required:ident)?;)+) => {
        $(
            $(#[doc = $doc])*
            $vis static $name: $crate::key::row::Key = $crate::key::row::Key {
                name: $key,
                label: $label,
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
    /// The name of the table that it is in; empty for the root.
    pub(crate) fn table(&self) -> &'static str {
        self.name.rsplit_once('.').map_or("", |(table, _)| table)
    }

    /// Its name within the table that it is in.
    pub(crate) fn last(&self) -> &'static str {
        self.name.rsplit_once('.').map_or(self.name, |(_, last)| last)
    }

    /// What it means, in one line.
    pub(crate) fn meaning(&self) -> String {
        one_line(self.doc)
    }

    /// Whether it holds whole numbers.
    pub(crate) fn is_whole(&self) -> bool {
        matches!(self.holds, Holds::Whole(..))
    }

    /// Whether it holds the name of a file.
    pub(crate) fn is_file(&self) -> bool {
        matches!(self.holds, Holds::File)
    }

    /// The names that it accepts, where it holds one of some.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        match self.holds {
            Holds::Name(names) => names.to_vec(),
            Holds::Word(words) => words.iter().map(|word| word.word).collect(),
            _ => vec![],
        }
    }

    /// Whether it holds a name, of a file or of other things.
    pub(crate) fn is_name(&self) -> bool {
        self.is_file() || !self.names().is_empty()
    }

    /// The range of its values for people, or the names that there are.
    pub(crate) fn range(&self) -> String {
        match self.holds {
            Holds::Whole(low, high) => format!("{low} to {high}"),
            _ if self.is_name() => self.names().join(", "),
            _ => self.holds.measured().map_or("", |measure| measure.range).to_owned(),
        }
    }

    /// Why no sweep varies it, where none does.
    pub(crate) fn fixed(&self) -> &'static str {
        match self.holds {
            Holds::Text | Holds::Word(_) | Holds::Name(_) | Holds::File => "is text",
            Holds::List(_) | Holds::Pair(_) => "is a list",
            Holds::Table | Holds::OneOf | Holds::Free => "is a table",
            _ => "holds for the whole study",
        }
    }
}

/// The words of a text, a space between them.
pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The name of `key` in the table `table`, whose name is empty for the root.
pub(crate) fn joined(table: &str, key: &str) -> String {
    if table.is_empty() { key.to_owned() } else { format!("{table}.{key}") }
}
