//! The keys of charts.

use crate::chart::law::Law;
use crate::key::holds::{Holds, words};
use crate::key::row::keys;
use crate::key::scale::Scale;

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

const TEXTS: Holds = Holds::List(&Holds::Text);
const SCALE: Holds = Holds::Word(Scale::WORDS);

keys! {
    /// The keys of charts.
    pub(crate) static KEYS;
    /// One or several charts of the estimates: curves, or a map over two columns. If absent, the study has a chart that
    /// suits its kind. Columns are named without prefix and unit: "frequency", "rms".
    pub CHART = "chart", "", Fixed, Holds::Either(&[Holds::Table, Holds::List(&Holds::Table)]), "[chart]\nx = \"dt_nu\"\ny = \"rms\"";
    /// Kind of the chart; "curves" if absent.
    pub KIND = "chart.kind", "", Fixed, Holds::Word(ChartKind::WORDS), r#"kind = "heat-map""#;
    /// Table to draw; "points" if absent.
    pub TABLE = "chart.table", "", Fixed, Holds::Word(Source::WORDS), r#"table = "coefficients""#;
    /// Title above the chart; the study's title if absent.
    pub TITLE = "chart.title", "", Fixed, Holds::Text, r#"title = "Largest error""#;
    /// Column of the abscissa; the values of a text column stand side by side. For a map it is a swept key, dt_nu or
    /// amplitude_noise.
    pub X = "chart.x", "", Fixed, Holds::Text, r#"x = "dt_nu""#;
    /// Column of the ordinate. For curves it is the estimate, or a list of several with one unit, ["bound",
    /// "mean_drift"], each drawn in its own colour; for a map it is another swept key or dt_nu.
    pub Y = "chart.y", "", Fixed, Holds::Either(&[Holds::Text, TEXTS]), r#"y = "rms""#;
    /// Column that a map shows; in a winner map the least value wins.
    pub Z = "chart.z", "", Fixed, Holds::Text, r#"z = "p99_73""#;
    /// Column whose values compete in a winner map: a swept key, filler or error; "filler" if absent.
    pub OF = "chart.of", "", Fixed, Holds::Text, r#"of = "filler""#;
    /// Columns whose values make the curves: the first sets the colour, the second the dash. If y has several columns,
    /// series has only one, which sets the dash. If absent, the curves are those of the fillers, the coefficients, or
    /// the swept keys.
    pub SERIES = "chart.series", "", Fixed, TEXTS, r#"series = ["filler", "gap_ticks"]"#;
    /// Reference curves to draw over a swept key or dt_nu, where y is an error in ″; each once.
    pub LAWS = "chart.references", "", Fixed, Holds::List(&Holds::Word(Law::WORDS)), r#"references = ["taylor-extremum", "noise"]"#;
    /// Rows to show: each entry names a swept key, filler, error, coefficient or tau, and one of its values. Rows with
    /// error = "residual" are shown unless error is named here, in series or in of.
    pub WHERE = "chart.where", "", Fixed, Holds::Free, r#"where = { error = "residual" }"#;
    /// Allowed value, above 0: an angle where the estimate is an error in ″, "10 arcsec"; a rate where it is a
    /// deviation, "0.005 deg/h"; a percentage where it is relative, "10 %". Curves show it as a line and a heat map as
    /// a contour; a winner map is hatched where even the least value is above it.
    pub LIMIT = "chart.limit", "", Fixed, Holds::Any, r#"limit = "10 arcsec""#;
    /// Scale of the abscissa; if absent, "linear" over a sweep that is linear or not above 0, else "log".
    pub X_SCALE = "chart.x_scale", "", Fixed, SCALE, r#"x_scale = "log""#;
    /// Scale of the ordinate, like x_scale.
    pub Y_SCALE = "chart.y_scale", "", Fixed, SCALE, r#"y_scale = "linear""#;
    /// Scale of the colours of a heat map; "log" if absent.
    pub Z_SCALE = "chart.z_scale", "", Fixed, SCALE, r#"z_scale = "log""#;
}
