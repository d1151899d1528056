//! What is known of a table of results before anything is sampled: the ground that charts are checked on.

use crate::chart::law::Law;
use crate::chart::rows::coordinate;
use crate::chart::{Named, Source};
use crate::key::scale::Scale;
use crate::key::sweep::Sweep;
use crate::quantity::units::Dimension;
use crate::table::{About, Cell, Role, Usual};

/// One of the tables of a study, by its columns besides those of swept keys.
#[derive(Debug, Clone)]
pub(crate) struct Ground {
    /// Which table.
    pub(crate) source: Source,
    /// In the order of the table.
    pub(crate) columns: Vec<About>,
    /// Columns of text, by which rows are told apart.
    pub(crate) texts: Vec<Text>,
    /// The laws that can be drawn beside its estimates.
    pub(crate) laws: &'static [Law],
    /// The dimensions of a limit; none where it is a part in percent.
    pub(crate) limits: &'static [Dimension],
    /// What the points of a chart are, and what its bands are, for legends; empty of closed forms.
    pub(crate) legend: [&'static str; 2],
    /// Whether its axes are linear unless a chart says otherwise.
    pub(crate) is_linear: bool,
    /// Why this study has no such table, and what to add.
    pub(crate) absent: Option<(&'static str, &'static str)>,
}

/// A column of text.
#[derive(Debug, Clone)]
pub(crate) struct Text {
    pub(crate) name: &'static str,
    /// The key that lists its values; empty of none.
    pub(crate) listed_by: &'static str,
    /// All that it takes.
    pub(crate) values: Vec<String>,
    /// What is meant where a chart says nothing.
    pub(crate) usual: Option<String>,
    /// What stands for all other values together.
    pub(crate) whole: Option<&'static str>,
}

impl Ground {
    /// A table with these columns; `texts` are the values of those that tell rows apart, in their order.
    pub(crate) fn of(
        source: Source,
        columns: Vec<About>,
        texts: impl IntoIterator<Item = Text>,
        limits: &'static [Dimension],
    ) -> Ground {
        let keys = columns.iter().filter(|column| column.role == Role::Key);
        let texts = keys.zip(texts).map(|(key, text)| Text { name: key.name, listed_by: key.of, ..text });
        let texts = texts.collect();
        let legend = ["Monte Carlo", "95 % band"];
        Ground { source, columns, texts, laws: &[], limits, legend, is_linear: false, absent: None }
    }

    /// The names of the columns of text.
    pub(crate) fn text_names(&self) -> Vec<&'static str> {
        self.texts.iter().map(|text| text.name).collect()
    }

    /// The values of a column of text.
    pub(crate) fn values(&self, name: &str) -> Option<&[String]> {
        self.texts.iter().find(|text| text.name == name).map(|text| &text.values[..])
    }

    /// Columns of numbers that are known before anything is sampled.
    pub(crate) fn coordinates(&self) -> impl Iterator<Item = &About> {
        self.columns.iter().filter(|column| column.role == Role::Coordinate)
    }

    /// The column that stands for this one where none is named.
    pub(crate) fn usual(&self, usual: Usual) -> Option<&About> {
        self.columns.iter().find(|column| column.usual == Some(usual))
    }

    /// The abscissa by which rows are told apart, as curves along it are a row for each of its values.
    pub(crate) fn along(&self) -> Option<&About> {
        self.usual(Usual::Abscissa).filter(|_| self.usual(Usual::Places).is_none())
    }

    /// The column whose values compete in a winner map that names none: what the study lists to be compared.
    pub(crate) fn rivals(&self) -> Option<&'static str> {
        self.texts.iter().find(|text| !text.listed_by.is_empty()).map(|text| text.name)
    }

    /// The rows that are meant where nothing is said.
    pub(crate) fn usual_rows(&self) -> impl Iterator<Item = (Named, Cell)> {
        let usual = |text: &Text| Some((text.name.into(), Cell::Text(text.usual.clone()?)));
        self.texts.iter().filter_map(usual)
    }

    /// The scale of an axis over this column where none is written: that of its sweep, or of the sweep that it follows.
    pub(crate) fn scale_over(&self, name: &str, sweeps: &[Sweep]) -> Scale {
        let Ok(column) = coordinate(sweeps, self, name, 0..0, "no axis over") else {
            return Scale::default();
        };
        let followed = self.coordinates().find(|known| known.name == column).map(|known| known.of);
        let key = followed.filter(|of| !of.is_empty()).unwrap_or(&column);
        sweeps.iter().find(|sweep| sweep.key.name == key).map_or(Scale::default(), |sweep| sweep.scale)
    }
}

impl Text {
    /// A column of text that takes these values.
    pub(crate) fn of(values: impl IntoIterator<Item = impl Into<String>>) -> Text {
        let values = values.into_iter().map(Into::into).collect();
        Text { name: "", listed_by: "", values, usual: None, whole: None }
    }

    /// The same with the value that is meant where a chart says nothing.
    pub(crate) fn usual(self, value: impl Into<String>) -> Text {
        Text { usual: Some(value.into()), ..self }
    }
}
