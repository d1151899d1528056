//! The properties of a table of results that are known before anything is sampled; charts are checked against them.

use crate::chart::law::Law;
use crate::chart::{Limit, Named, Source};
use sagnac_base::quantity::units::Dimension;
use sagnac_base::table::{About, Cell, Role, Usual};

/// One of the tables of a study, described by its columns except the swept keys.
#[derive(Debug, Clone)]
pub struct Ground {
    /// Source of the table.
    pub(crate) source: Source,
    /// Columns in the order of the table.
    pub(crate) columns: Vec<About>,
    /// Text columns, which distinguish rows.
    pub texts: Vec<Text>,
    /// Laws that can be drawn with its estimates.
    pub(crate) laws: &'static [Law],
    /// Dimensions of a limit; none where it is a percentage.
    pub(crate) limits: &'static [Dimension],
    /// Names of the points and the bands of a chart for legends; empty for closed forms.
    pub(crate) legend: [&'static str; 2],
    /// Whether its axes are linear by default.
    pub(crate) is_linear: bool,
    /// Whether a specification is what is judged: the default estimates alone, in closed form, whatever charts show.
    pub(crate) is_specified: bool,
    /// Why this study has no such table, and how to get one.
    pub(crate) absent: Option<(&'static str, &'static str)>,
}

/// A text column.
#[derive(Debug, Clone)]
pub struct Text {
    pub name: &'static str,
    /// The key that lists its values; empty for none.
    pub(crate) listed_by: &'static str,
    /// All possible values.
    pub(crate) values: Vec<String>,
    /// The default value where a chart selects none.
    pub usual: Option<String>,
    /// The value that stands for all others together.
    pub whole: Option<&'static str>,
}

impl Ground {
    /// A table with these columns; `texts` are the values of those that distinguish rows, in order.
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
        let [is_linear, is_specified] = [false; 2];
        Ground { source, columns, texts, laws: &[], limits, legend, is_linear, is_specified, absent: None }
    }

    /// Whether the estimate of this name is judged where a chart shows it.
    pub(crate) fn judges(&self, name: &str) -> bool {
        let is_usual = |column: &About| column.usual.is_some() && column.is_called(name);
        !self.is_specified || self.columns.iter().any(is_usual)
    }

    /// Names of the points and the bands of a chart of the estimate of this name.
    pub(crate) fn legend_of(&self, name: &str) -> [&'static str; 2] {
        if self.is_specified && self.judges(name) { ["closed form", ""] } else { self.legend }
    }

    /// The names of the text columns.
    pub(crate) fn text_names(&self) -> Vec<&'static str> {
        self.texts.iter().map(|text| text.name).collect()
    }

    /// The numeric columns that are known before anything is sampled.
    pub(crate) fn coordinates(&self) -> impl Iterator<Item = &About> {
        self.columns.iter().filter(|column| column.role == Role::Coordinate)
    }

    /// The default column for a purpose.
    pub(crate) fn usual(&self, usual: Usual) -> Option<&About> {
        self.columns.iter().find(|column| column.usual == Some(usual))
    }

    /// The estimate to which a limit of the study applies: of those in its unit for which less is better, the default one,
    /// else the last. Without any, it is the default estimate in that unit.
    pub(crate) fn judged(&self, limit: Limit) -> Option<&About> {
        let fits = |column: &&About| column.role.less_is_better() && column.unit == limit.unit;
        let usual = || [Usual::Answer, Usual::Estimate].into_iter().filter_map(|usual| self.usual(usual));
        let error = usual().find(fits).or_else(|| self.columns.iter().rfind(fits));
        error.or_else(|| usual().find(|column| column.unit == limit.unit))
    }

    /// The abscissa that distinguishes rows, where a curve has a row for each of its values.
    pub(crate) fn along(&self) -> Option<&About> {
        self.usual(Usual::Abscissa).filter(|_| self.usual(Usual::Places).is_none())
    }

    /// The column whose values compete in a winner map by default, which the study lists for comparison.
    pub(crate) fn rivals(&self) -> Option<&'static str> {
        self.texts.iter().find(|text| !text.listed_by.is_empty()).map(|text| text.name)
    }

    /// The rows shown by default.
    pub(crate) fn usual_rows(&self) -> impl Iterator<Item = (Named, Cell)> {
        let usual = |text: &Text| Some((text.name.into(), Cell::Text(text.usual.clone()?)));
        self.texts.iter().filter_map(usual)
    }
}

impl Text {
    /// A text column with these values.
    pub(crate) fn of(values: impl IntoIterator<Item = impl Into<String>>) -> Text {
        let values = values.into_iter().map(Into::into).collect();
        Text { name: "", listed_by: "", values, usual: None, whole: None }
    }

    /// Sets the default value.
    pub(crate) fn usual(self, value: impl Into<String>) -> Text {
        Text { usual: Some(value.into()), ..self }
    }
}
