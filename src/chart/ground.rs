//! What is known of a table of results before anything is sampled: the ground that charts are checked on.

use crate::chart::Source;
use crate::chart::law::Law;
use crate::quantity::units::Dimension;
use crate::table::Unit;

/// One of the tables of a study, by its columns besides those of swept keys and estimates.
#[derive(Debug, Clone)]
pub(crate) struct Ground {
    /// Which table.
    pub(crate) source: Source,
    /// Columns of text, by which rows are told apart.
    pub(crate) texts: Vec<Text>,
    /// Columns of numbers.
    pub(crate) numbers: &'static [Number],
    /// The laws that can be drawn beside its estimates.
    pub(crate) laws: &'static [Law],
    /// The dimensions of a limit; none where it is a part in percent.
    pub(crate) limits: &'static [Dimension],
    /// Whether its axes are linear unless a chart says otherwise.
    pub(crate) is_linear: bool,
    /// Why this study has no such table, and what to add.
    pub(crate) absent: Option<(&'static str, &'static str)>,
}

/// A column of text.
#[derive(Debug, Clone)]
pub(crate) struct Text {
    pub(crate) name: &'static str,
    /// All that it takes.
    pub(crate) values: Vec<String>,
    /// What is meant where a chart says nothing.
    pub(crate) usual: Option<String>,
    /// What stands for all other values together.
    pub(crate) whole: Option<&'static str>,
}

/// A column of numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Number {
    pub(crate) name: &'static str,
    pub(crate) unit: Unit,
    /// The key that it is in proportion to.
    pub(crate) follows: Option<&'static str>,
    /// Whether it tells rows apart.
    pub(crate) chooses: bool,
}

impl Ground {
    /// A table with nothing but swept keys and estimates of some dimensions.
    pub(crate) fn of(source: Source, limits: &'static [Dimension]) -> Ground {
        Ground { source, texts: vec![], numbers: &[], laws: &[], limits, is_linear: false, absent: None }
    }

    /// The names of the columns of text.
    pub(crate) fn text_names(&self) -> Vec<&'static str> {
        self.texts.iter().map(|text| text.name).collect()
    }

    /// The values of a column of text.
    pub(crate) fn values(&self, name: &str) -> Option<&[String]> {
        self.texts.iter().find(|text| text.name == name).map(|text| &text.values[..])
    }
}

impl Text {
    /// A column of text without usual value.
    pub(crate) fn new(name: &'static str, values: impl IntoIterator<Item = impl Into<String>>) -> Text {
        Text { name, values: values.into_iter().map(Into::into).collect(), usual: None, whole: None }
    }
}
