//! The specification of a chart, as given in a study and as drawn; its reference curves, and what is known of its table before
//! anything is sampled. Columns are given by name and not yet looked up in a table.

pub(crate) mod read;

use std::ops::Range;

use crate::key::document::SpannedValue;
use crate::key::sweep::Scale;
use crate::key::{ValueType, keys, words};
use sagnac_base::quantity::Dimension;
use sagnac_base::quantity::number::{joined, significant};
use sagnac_base::table::{About, Cell, Role, Unit, Usual};

/// The name of a column, with its place in the study for messages about an unknown one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Named {
    /// Name as written, such as `p99_73` or `motion.frequency`.
    pub name: String,
    /// Bytes in the text; empty at 0 for a default that is not written.
    pub span: Range<usize>,
}

impl From<&str> for Named {
    fn from(name: &str) -> Named {
        Named { name: name.to_owned(), span: 0..0 }
    }
}

impl From<SpannedValue<'_>> for Named {
    fn from(given: SpannedValue) -> Named {
        Named { span: given.span(), name: given.text().to_owned() }
    }
}

/// One chart of a table: curves, or a map. By default it has curves without columns, over logarithmic axes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chart {
    /// Title, in bold above the chart.
    pub title: String,
    /// A second, smaller line, which may be empty.
    pub subtitle: String,
    /// Source of the table.
    pub source: Source,
    /// Column of the abscissa.
    pub x: Named,
    /// Column of the ordinate: of curves the estimate, of a map an axis like x. Bands are drawn, and the closed form
    /// where the table has one.
    pub y: Named,
    /// Further columns like y, each drawn in its own colour.
    pub beside: Vec<Named>,
    /// Content: curves or a map.
    pub shows: Shows,
    /// Only rows in which each column, a swept key, `filler` or `error`, has the given value. A supplied chart selects
    /// values of the keys that it cannot show.
    pub rows: Vec<(Named, Cell)>,
    /// A limit in a unit of the estimate, which is drawn as a line and determines the verdict.
    pub limit: Option<Limit>,
    /// Scale of the abscissa.
    pub x_scale: Scale,
    /// Scale of the ordinate.
    pub y_scale: Scale,
    /// The columns that distinguish the rows of the table, such as swept keys; only one of them may vary along a curve.
    /// If empty, this is not checked.
    pub apart: Vec<String>,
    /// Name of the points in the legend, such as `Monte Carlo` or `measured`; empty for none.
    pub points: String,
    /// Name of the bands, such as `95 % band`.
    pub bands: String,
}

/// A limit of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Value, above 0.
    pub value: f64,
    /// Unit of the column to which it applies.
    pub unit: Unit,
}

impl Limit {
    /// Text for sentences, such as `10 ″` or `5 %`.
    pub fn text(&self) -> String {
        match self.unit {
            Unit::NONE => format!("{} %", significant(100.0 * self.value, 6)),
            // As axes have it.
            Unit::ARCSEC_PER_RT_S => joined(&significant(self.value / 60.0, 6), Unit::DEG_PER_SQRT_H.symbol),
            unit => joined(&significant(self.value, 6), unit.symbol),
        }
    }
}

/// A limit that a study as a whole must meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Requirement {
    /// Table of the limited estimate.
    pub source: Source,
    /// Column of the limited estimate.
    pub column: &'static str,
    /// The limit.
    pub limit: Limit,
}

/// The content of a chart.
#[derive(Debug, Clone, PartialEq)]
pub enum Shows {
    /// Curves of y over x.
    Curves {
        /// At most two columns whose values make the curves: the first sets the colour, the second the dash. With
        /// several columns y at most one, which sets the dash.
        series: Vec<Named>,
        /// Laws, each once, for angles in ″; with laws, x of a study is a swept key or `dt_nu`.
        laws: Vec<Law>,
    },
    /// A map of z by colour, over x and y.
    HeatMap {
        /// The column shown by colour.
        z: Named,
        /// Scale of the colours.
        z_scale: Scale,
    },
    /// A map over x and y of the value of the column `of`, a swept key, `filler` or `error`, that has the least z.
    WinnerMap {
        /// The compared column; the least value wins.
        z: Named,
        /// The column whose values compete.
        of: Named,
    },
}

impl Default for Shows {
    fn default() -> Shows {
        Shows::Curves { series: vec![], laws: vec![] }
    }
}

impl Chart {
    /// Column of the estimates.
    pub fn estimate(&self) -> &Named {
        match &self.shows {
            Shows::Curves { .. } => &self.y,
            Shows::HeatMap { z, .. } | Shows::WinnerMap { z, .. } => z,
        }
    }

    /// The columns that curves show: y and the further ones.
    pub fn columns(&self) -> impl Iterator<Item = &Named> {
        std::iter::once(&self.y).chain(&self.beside)
    }

    /// The columns whose values distinguish curves.
    pub fn series(&self) -> &[Named] {
        match &self.shows {
            Shows::Curves { series, .. } => series,
            Shows::HeatMap { .. } => &[],
            Shows::WinnerMap { of, .. } => std::slice::from_ref(of),
        }
    }

    /// The second line, if it has one.
    pub fn subtitle(&self) -> Option<String> {
        Some(self.subtitle.clone()).filter(|text| !text.is_empty())
    }

    /// The rows that are drawn, as pairs of a column and its value as files show it.
    pub fn filter(&self) -> Vec<(String, String)> {
        self.rows.iter().map(|(column, value)| (column.name.clone(), value.text())).collect()
    }

    /// The laws drawn with curves.
    pub fn references(&self) -> &[Law] {
        match &self.shows {
            Shows::Curves { laws, .. } => laws,
            Shows::HeatMap { .. } | Shows::WinnerMap { .. } => &[],
        }
    }
}

words! {
    /// The kind of a chart.
    pub(crate) enum ChartKind {
        /// Curves of y over x, one for each value of series.
        Curves = "curves",
        /// A map of z over x and y, by colour.
        HeatMap = "heat-map",
        /// A map over x and y of the value whose z is the least.
        WinnerMap = "winner-map",
    }
}

words! {
    /// A table of a study's results.
    pub enum Source {
        /// Table of the points, `points.csv`.
        Points = "points",
        /// Table of coefficients, `coefficients.csv`, of kind = "allan".
        Coefficients = "coefficients",
        /// Table of trajectories, `trajectories.csv`, of kind = "switched-run".
        Trajectories = "trajectories",
    }
}

impl Source {
    /// The name of the file with this table.
    pub fn file(self) -> &'static str {
        match self {
            Source::Points => "points.csv",
            Source::Coefficients => "coefficients.csv",
            Source::Trajectories => "trajectories.csv",
        }
    }
}

const TEXTS: ValueType = ValueType::List(&ValueType::Text);
const SCALE: ValueType = ValueType::Word(Scale::WORDS);

keys! {
    /// The keys of charts.
    pub(crate) static KEYS;
    /// One or several charts of the estimates: curves, or a map over two columns. If absent, the study has a chart that
    /// suits its kind. Columns are named without prefix and unit: "frequency", "rms".
    pub(crate) CHART = "chart", "", Fixed, ValueType::Either(&[ValueType::Table, ValueType::List(&ValueType::Table)]), "[chart]\nx = \"dt_nu\"\ny = \"rms\"";
    /// Kind of the chart; "curves" if absent.
    pub KIND = "chart.kind", "", Fixed, ValueType::Word(ChartKind::WORDS), r#"kind = "heat-map""#;
    /// Table to draw; "points" if absent.
    pub TABLE = "chart.table", "", Fixed, ValueType::Word(Source::WORDS), r#"table = "coefficients""#;
    /// Title above the chart; the study's title if absent.
    pub(crate) TITLE = "chart.title", "", Fixed, ValueType::Text, r#"title = "Largest error""#;
    /// Column of the abscissa; the values of a text column stand side by side. For a map it is a swept key, dt_nu or
    /// amplitude_noise.
    pub X = "chart.x", "", Fixed, ValueType::Text, r#"x = "dt_nu""#;
    /// Column of the ordinate. For curves it is the estimate, or a list of several with one unit, ["bound",
    /// "mean_drift"], each drawn in its own colour; for a map it is another swept key or dt_nu.
    pub(crate) Y = "chart.y", "", Fixed, ValueType::Either(&[ValueType::Text, TEXTS]), r#"y = "rms""#;
    /// Column that a map shows; in a winner map the least value wins.
    pub Z = "chart.z", "", Fixed, ValueType::Text, r#"z = "p99_73""#;
    /// Column whose values compete in a winner map: a swept key, filler or error; "filler" if absent.
    pub OF = "chart.of", "", Fixed, ValueType::Text, r#"of = "filler""#;
    /// Columns whose values make the curves: the first sets the colour, the second the dash. If y has several columns,
    /// series has only one, which sets the dash. If absent, the curves are those of the fillers, the coefficients, or
    /// the swept keys.
    pub(crate) SERIES = "chart.series", "", Fixed, TEXTS, r#"series = ["filler", "gap_ticks"]"#;
    /// Reference curves to draw over a swept key or dt_nu, where y is an error in ″; each once.
    pub LAWS = "chart.references", "", Fixed, ValueType::List(&ValueType::Word(Law::WORDS)), r#"references = ["taylor-extremum", "noise"]"#;
    /// Rows to show: each entry names a swept key, filler, error, coefficient or tau, and one of its values. Rows with
    /// error = "residual" are shown unless error is named here, in series or in of.
    pub WHERE = "chart.where", "", Fixed, ValueType::Free, r#"where = { error = "residual" }"#;
    /// Allowed value, above 0: an angle where the estimate is an error in ″, "10 arcsec"; a rate where it is a
    /// deviation, "0.005 deg/h"; a percentage where it is relative, "10 %". Curves show it as a line and a heat map as
    /// a contour; a winner map is hatched where even the least value is above it.
    pub LIMIT = "chart.limit", "", Fixed, ValueType::Any, r#"limit = "10 arcsec""#;
    /// Scale of the abscissa; if absent, "linear" over a sweep that is linear or not above 0, else "log".
    pub(crate) X_SCALE = "chart.x_scale", "", Fixed, SCALE, r#"x_scale = "log""#;
    /// Scale of the ordinate, like x_scale.
    pub(crate) Y_SCALE = "chart.y_scale", "", Fixed, SCALE, r#"y_scale = "linear""#;
    /// Scale of the colours of a heat map; "log" if absent.
    pub(crate) Z_SCALE = "chart.z_scale", "", Fixed, SCALE, r#"z_scale = "log""#;
}

words! {
    /// A law of error, as published or corrected, drawn with curves.
    pub enum Law {
        /// Z(20): the first dropped Taylor term at an extremum of the rate, which is the error of one tick instead of
        /// the whole gap.
        TaylorExtremum = "taylor-extremum",
        /// Z(20): the same near a zero crossing of the rate, for linear and quadratic.
        TaylorZeroCrossing = "taylor-zero-crossing",
        /// Noise of const over the gap as published: A_n √n / 2, A_n = 3σ of one tick.
        NoiseAsPublished = "noise-as-published",
        /// Noise of const over the gap by Z(18): A_n n / 2 for a fit to four ticks.
        Noise = "noise",
        /// The paper's tables 1 and 2: the drift measured after a switch, and its remainder after the paper's
        /// compensations. Only for kind = "relock".
        ZeemanTables = "zeeman-tables",
        /// The class of strategic navigators, 0.02 nmi/h. Only for kind = "navigation".
        StrategicGrade = "strategic-grade",
        /// The class of navigators of aircraft, 1 nmi/h. Only for kind = "navigation".
        NavigationGrade = "navigation-grade",
        /// The class of tactical navigators, 10 nmi/h. Only for kind = "navigation".
        TacticalGrade = "tactical-grade",
        /// The mean squared error over the claimed variance (NEES) of a consistent filter, 1. Only for kind = "navigation" with
        /// a filter.
        ConsistentFilter = "consistent-filter",
    }
}

impl Law {
    /// The estimates to which it applies.
    pub(crate) fn subject(self) -> &'static str {
        match self {
            Law::ZeemanTables => "relock",
            Law::StrategicGrade | Law::NavigationGrade | Law::TacticalGrade => "navigation",
            Law::ConsistentFilter => "filters in navigation",
            _ => "gap fillers",
        }
    }

    /// Its column in the table. Z(20) holds for one tick while charts show the whole gap, and the noise is 3σ; each
    /// label says so.
    pub fn about(self) -> About {
        let unit = match self {
            Law::StrategicGrade | Law::NavigationGrade | Law::TacticalGrade => Unit::NMI,
            Law::ConsistentFilter => Unit::NONE,
            _ => Unit::ARCSEC,
        };
        let (name, label, meaning) = match self {
            Law::TaylorExtremum => (
                "reference_taylor_extremum",
                "Taylor term of one tick at an extremum, as published, Z(20)",
                "A reference curve of the chart, ″: the first Taylor term that the filler drops at an extremum of the rate, of a single tick as \
                 published in Z(20).",
            ),
            Law::TaylorZeroCrossing => (
                "reference_taylor_zero_crossing",
                "Taylor term of one tick at a zero crossing, as published, Z(20)",
                "A reference curve of the chart, ″: the first Taylor term that the filler drops near a zero crossing of the rate, of a single \
                 tick as published in Z(20).",
            ),
            Law::NoiseAsPublished => (
                "reference_noise_as_published",
                "3σ noise of const as published, growing as √n",
                "A reference curve of the chart, ″: 3 σ of the constant filler as published, which grows as √n with the lost ticks.",
            ),
            Law::Noise => (
                "reference_noise",
                "3σ noise of const by Z(18), growing as n",
                "A reference curve of the chart, ″: 3 σ of the constant filler by Z(18), which grows as n with the lost ticks.",
            ),
            Law::ZeemanTables => (
                "reference_zeeman_tables",
                "the paper's tables 1 and 2",
                "A reference curve of the chart, ″: tables 1 and 2 of the paper, measured and compensated.",
            ),
            Law::StrategicGrade => (
                "reference_strategic_grade",
                "strategic grade, 0.02 nmi/h",
                "A reference curve of the chart, nmi: 0.02 nmi for each hour, the class of strategic navigators.",
            ),
            Law::NavigationGrade => (
                "reference_navigation_grade",
                "navigation grade, 1 nmi/h",
                "A reference curve of the chart, nmi: 1 nmi for each hour, the class of navigators of aircraft.",
            ),
            Law::TacticalGrade => (
                "reference_tactical_grade",
                "tactical grade, 10 nmi/h",
                "A reference curve of the chart, nmi: 10 nmi for each hour, the class of tactical navigators.",
            ),
            Law::ConsistentFilter => (
                "reference_consistent_filter",
                "a consistent filter, 1",
                "A reference curve of the chart: 1, the mean squared error over the claimed variance of a consistent filter.",
            ),
        };
        About { unit, label, role: Role::Law, meaning, ..About::named(name) }
    }

    /// The name of its column in the table.
    pub fn column(self) -> &'static str {
        self.about().name
    }
}

/// One of the tables of a study, described by its columns except the swept keys.
#[derive(Debug, Clone)]
pub struct TableSchema {
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
    /// Name of the column.
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

impl TableSchema {
    /// A table with these columns; `texts` are the values of those that distinguish rows, in order.
    pub(crate) fn new(
        source: Source,
        columns: Vec<About>,
        texts: impl IntoIterator<Item = Text>,
        limits: &'static [Dimension],
    ) -> TableSchema {
        let keys = columns.iter().filter(|column| column.role == Role::Key);
        let texts = keys.zip(texts).map(|(key, text)| Text { name: key.name, listed_by: key.of, ..text });
        let texts = texts.collect();
        let legend = ["Monte Carlo", "95 % band"];
        let [is_linear, is_specified] = [false; 2];
        TableSchema {
            source,
            columns,
            texts,
            laws: &[],
            limits,
            legend,
            is_linear,
            is_specified,
            absent: None,
        }
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
    pub(crate) fn new(values: impl IntoIterator<Item = impl Into<String>>) -> Text {
        let values = values.into_iter().map(Into::into).collect();
        Text { name: "", listed_by: "", values, usual: None, whole: None }
    }

    /// Sets the default value.
    pub(crate) fn usual(self, value: impl Into<String>) -> Text {
        Text { usual: Some(value.into()), ..self }
    }
}
