//! The charts of a study file exactly as users write them.
//!
//! The doc comments here are the descriptions in the schema.

use std::collections::BTreeMap;
use std::fmt;

use schemars::JsonSchema;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use toml::Spanned;

use crate::chart::law::Law;
use crate::key::file::ValueSchema;
use crate::key::file::either::Either;
use crate::key::scalar::Scalar;

/// A chart of the estimates: curves, or a map over two columns. Columns are named without prefix and unit: "frequency",
/// "rms".
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChartTable {
    #[serde(default)]
    #[schemars(with = "ChartKind")]
    pub(crate) kind: Option<Spanned<ChartKind>>,
    /// Which table is drawn; "points" if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Source")]
    pub(crate) table: Option<Spanned<Source>>,
    /// Above the chart; the study's title if absent.
    // Else the schema would give null, which TOML does not have, as the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "String")]
    pub(crate) title: Option<String>,
    /// Column of the abscissa, one of text with its values side by side; of a map a swept key, dt_nu or amplitude_noise.
    #[schemars(with = "String", extend("examples" = ["dt_nu", "frequency"]))]
    pub(crate) x: Spanned<String>,
    /// Column of the ordinate: of curves the estimate, or several of one unit, ["bound", "mean_drift"], each a curve of its
    /// own colour; of a map another swept key or dt_nu.
    #[schemars(with = "Either<Vec<String>>", extend("examples" = ["rms", "q9973", "max"]))]
    pub(crate) y: Spanned<Either<Vec<Spanned<String>>>>,
    /// Column that a map shows, and only a map: the least wins in a winner map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "String", extend("examples" = ["rms", "q9973", "max"]))]
    pub(crate) z: Option<Spanned<String>>,
    /// Column whose values compete in a winner map: a swept key, filler or error; "filler" if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "String")]
    pub(crate) of: Option<Spanned<String>>,
    /// Columns whose values make the curves: first the colour, second the dash; beside several columns y one, the dash. If
    /// absent the fillers, the coefficients, or the swept keys.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Vec<String>", length(min = 1, max = 2))]
    pub(crate) series: Option<Spanned<Vec<Spanned<String>>>>,
    /// Laws to draw beside curves over a swept key or dt_nu, where y is an error in ″.
    #[serde(default)]
    #[schemars(with = "Vec<Law>", extend("uniqueItems" = true))]
    pub(crate) laws: Option<Spanned<Vec<Spanned<Law>>>>,
    /// Rows to show: a swept key, filler, error, coefficient or tau = one of its values. With error = "residual" unless
    /// series, of or this names error.
    #[serde(default, rename = "where")]
    #[schemars(with = "BTreeMap<String, ValueSchema>")]
    pub(crate) rows: Option<BTreeMap<Spanned<String>, Spanned<Scalar>>>,
    /// What is allowed, above 0: an angle where the estimate is an error in ″, "10 arcsec"; a rate where it is a deviation,
    /// "0.005 deg/h"; a part where it is relative, "10 %". A line of curves, a contour of a heat map; a winner map is hatched
    /// where even the least is above.
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) limit: Option<Spanned<Scalar>>,
    /// Linear if absent over a sweep that is linear or not above 0, else "log".
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Scale")]
    pub(crate) x_scale: Option<Scale>,
    /// As x_scale.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Scale")]
    pub(crate) y_scale: Option<Scale>,
    /// The scale of the colours of a heat map; "log" if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Scale")]
    pub(crate) z_scale: Option<Spanned<Scale>>,
}

/// What a chart is; "curves" if absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ChartKind {
    /// y over x, a curve for each value of series.
    Curves,
    /// z over x and y, by colour.
    HeatMap,
    /// Over x and y, whose z is the least.
    WinnerMap,
}

/// A table of a study's results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// points.csv.
    Points,
    /// coefficients.csv, of kind = "allan".
    Coefficients,
    /// trajectories.csv, of kind = "switched-run".
    Trajectories,
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

impl ChartKind {
    /// As study files call it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            ChartKind::Curves => "curves",
            ChartKind::HeatMap => "heat-map",
            ChartKind::WinnerMap => "winner-map",
        }
    }
}

/// The scale of an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// Equal ratios are equally long.
    #[default]
    Log,
    /// Equal differences are equally long.
    Linear,
}

/// `[chart]` or `[[chart]]`.
#[derive(Debug, Default, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum Charts {
    #[default]
    #[schemars(skip)]
    Default,
    One(Box<ChartTable>),
    Several(Vec<ChartTable>),
}

impl<'de> Deserialize<'de> for Charts {
    /// By hand, as serde's untagged enums lose the places of values.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Charts, D::Error> {
        struct OneOrSeveral;

        impl<'de> Visitor<'de> for OneOrSeveral {
            type Value = Charts;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("one table [chart] or several [[chart]]")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Charts, A::Error> {
                Deserialize::deserialize(MapAccessDeserializer::new(map)).map(Charts::One)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Charts, A::Error> {
                Deserialize::deserialize(SeqAccessDeserializer::new(seq)).map(Charts::Several)
            }
        }

        deserializer.deserialize_any(OneOrSeveral)
    }
}
