//! The keys of charts.

use crate::chart::law::Law;
use crate::key::holds::{Holds, words};
use crate::key::row::keys;
use crate::key::scale::Scale;

words! {
    /// What a chart is.
    pub(crate) enum ChartKind {
        /// y over x, a curve for each value of series.
        Curves = "curves",
        /// z over x and y, by colour.
        HeatMap = "heat-map",
        /// Over x and y, whose z is the least.
        WinnerMap = "winner-map",
    }
}

words! {
    /// A table of a study's results.
    pub enum Source {
        /// points.csv.
        Points = "points",
        /// coefficients.csv, of kind = "allan".
        Coefficients = "coefficients",
        /// trajectories.csv, of kind = "switched-run".
        Trajectories = "trajectories",
    }
}

impl Source {
    /// The name of the file of results.
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
    /// A chart of the estimates, or several: curves, or a map over two columns; absent, a chart that suits the kind of study.
    /// Columns are named without prefix and unit: "frequency", "rms".
    pub(crate) CHART = "chart", "", Holds::Either(&[Holds::Table, Holds::List(&Holds::Table)]), "[chart]\nx = \"dt_nu\"\ny = \"rms\"";
    /// What the chart is; "curves" if absent.
    pub(crate) KIND = "chart.kind", "", Holds::Word(ChartKind::WORDS), r#"kind = "heat-map""#;
    /// Which table is drawn; "points" if absent.
    pub(crate) TABLE = "chart.table", "", Holds::Word(Source::WORDS), r#"table = "coefficients""#;
    /// Above the chart; the study's title if absent.
    pub(crate) TITLE = "chart.title", "", Holds::Text, r#"title = "Largest error""#;
    /// Column of the abscissa, one of text with its values side by side; of a map a swept key, dt_nu or amplitude_noise.
    pub(crate) X = "chart.x", "", Holds::Text, r#"x = "dt_nu""#;
    /// Column of the ordinate: of curves the estimate, or several of one unit, ["bound", "mean_drift"], each a curve of its
    /// own colour; of a map another swept key or dt_nu.
    pub(crate) Y = "chart.y", "", Holds::Either(&[Holds::Text, TEXTS]), r#"y = "rms""#;
    /// Column that a map shows, and only a map: the least wins in a winner map.
    pub(crate) Z = "chart.z", "", Holds::Text, r#"z = "q9973""#;
    /// Column whose values compete in a winner map: a swept key, filler or error; "filler" if absent.
    pub(crate) OF = "chart.of", "", Holds::Text, r#"of = "filler""#;
    /// Columns whose values make the curves: first the colour, second the dash; beside several columns y one, the dash. If
    /// absent the fillers, the coefficients, or the swept keys.
    pub(crate) SERIES = "chart.series", "", TEXTS, r#"series = ["filler", "gap_ticks"]"#;
    /// Laws to draw beside curves over a swept key or dt_nu, where y is an error in ″; each once.
    pub(crate) LAWS = "chart.laws", "", Holds::List(&Holds::Word(Law::WORDS)), r#"laws = ["taylor-extremum", "noise"]"#;
    /// Rows to show: a swept key, filler, error, coefficient or tau = one of its values. With error = "residual" unless
    /// series, of or this names error.
    pub(crate) WHERE = "chart.where", "", Holds::Free, r#"where = { error = "residual" }"#;
    /// What is allowed, above 0: an angle where the estimate is an error in ″, "10 arcsec"; a rate where it is a deviation,
    /// "0.005 deg/h"; a part where it is relative, "10 %". A line of curves, a contour of a heat map; a winner map is hatched
    /// where even the least is above.
    pub(crate) LIMIT = "chart.limit", "", Holds::Any, r#"limit = "10 arcsec""#;
    /// Linear if absent over a sweep that is linear or not above 0, else "log".
    pub(crate) X_SCALE = "chart.x_scale", "", SCALE, r#"x_scale = "log""#;
    /// As x_scale.
    pub(crate) Y_SCALE = "chart.y_scale", "", SCALE, r#"y_scale = "linear""#;
    /// The scale of the colours of a heat map; "log" if absent.
    pub(crate) Z_SCALE = "chart.z_scale", "", SCALE, r#"z_scale = "log""#;
}
