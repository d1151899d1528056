//! The values that keys hold, and words as values of a key.

use sagnac_base::quantity::units::Dimension;

/// The shape of a key's value, with its limits.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Holds {
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
    List(&'static Holds),
    /// A list of two values.
    Pair(&'static Holds),
    /// One of several shapes.
    Either(&'static [Holds]),
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
) -> Holds {
    Holds::Measure(Measure { accepts, limits: (low, high), range })
}

/// A quantity without limits.
pub(crate) const fn unlimited(accepts: &'static [Dimension]) -> Holds {
    measure(accepts, f64::NEG_INFINITY, f64::INFINITY, "")
}

impl Holds {
    /// The quantity that is held, also within lists or alternatives.
    pub(crate) fn measured(&self) -> Option<Measure> {
        match self {
            Holds::Measure(measure) => Some(*measure),
            Holds::List(inner) | Holds::Pair(inner) => inner.measured(),
            Holds::Either(shapes) => shapes.iter().find_map(Holds::measured),
            _ => None,
        }
    }

    /// The words that are held; empty for other shapes.
    pub(crate) fn words(&self) -> &'static [Word] {
        match self {
            Holds::Word(words) => words,
            Holds::List(inner) => inner.words(),
            Holds::Either(shapes) => {
                shapes.iter().map(Holds::words).find(|words| !words.is_empty()).unwrap_or_default()
            }
            _ => &[],
        }
    }

    /// Whether the value may be a table with keys of its own.
    pub(crate) fn is_table(&self) -> bool {
        match self {
            Holds::Table | Holds::OneOf => true,
            Holds::List(inner) => inner.is_table(),
            Holds::Either(shapes) => shapes.iter().any(Holds::is_table),
            _ => false,
        }
    }

    /// Description for sentences, such as `a text in quotes`.
    pub(crate) fn described(&self) -> String {
        match self {
            Holds::Text | Holds::Word(_) | Holds::Name(_) | Holds::File => "a text in quotes".to_owned(),
            Holds::Flag => "true or false".to_owned(),
            Holds::Whole(..) => "a whole number".to_owned(),
            Holds::Measure(Measure { accepts: [Dimension::Ratio], .. }) => {
                "a number, or percent in quotes".to_owned()
            }
            Holds::Measure(_) => "a number with its unit, in quotes".to_owned(),
            Holds::Percent => "a percentage in quotes".to_owned(),
            Holds::Any => "one value".to_owned(),
            Holds::List(Holds::Table) => "a list of tables in brackets".to_owned(),
            Holds::List(Holds::Pair(_)) => "a list of pairs in brackets".to_owned(),
            Holds::List(Holds::Text | Holds::Word(_)) => "a list of texts in brackets".to_owned(),
            Holds::List(Holds::Measure(_)) => "a list of quantities in brackets".to_owned(),
            Holds::List(_) => "a list in brackets".to_owned(),
            Holds::Pair(_) => "a list of two ends".to_owned(),
            Holds::Either(shapes) => shapes.iter().map(Holds::described).collect::<Vec<_>>().join(", or "),
            Holds::Table => "a table".to_owned(),
            Holds::OneOf => "a table of one key".to_owned(),
            Holds::Free => "a table of columns and values".to_owned(),
        }
    }
}

pub use sagnac_base::names;
pub(crate) use sagnac_base::words::Word;

/// Declares an enum as [`names`] does, whose values are the words of a key. The first one is the default.
macro_rules! words {
    ($(#[doc = $doc:literal])+ $vis:vis enum $name:ident { $($values:tt)+ }) => {
        $crate::key::holds::names! { $(#[doc = $doc])+ $vis enum $name { $($values)+ } }

        #[allow(dead_code, reason = "some words are read from lists")]
        impl $name {
            /// The value as written, or the default.
            pub(crate) fn of(given: Option<$crate::key::given::Given>) -> $name {
                let named = |given: $crate::key::given::Given| {
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
