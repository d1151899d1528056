//! `[switching]` as users write it.

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use crate::key::file::TickSchema;
use crate::key::file::either::Either;
use crate::key::file::motion::Ends;
use crate::key::scalar::Scalar;

/// The mode switch, and how the ticks it loses are filled in.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SwitchingTable {
    /// MT, from one switch to the next, of kind = "drift-budget" and "switched-run": "40 s".
    #[serde(default)]
    #[schemars(with = "String", extend("examples" = ["40 s"]))]
    pub(crate) interval: Option<Spanned<Scalar>>,
    /// Of kind = "switched-run"; positive if absent.
    #[serde(default)]
    #[schemars(with = "FirstMode")]
    pub(crate) first_mode: Option<Spanned<FirstMode>>,
    /// Of kind = "switched-run"; random if absent.
    #[serde(default)]
    #[schemars(with = "Timing")]
    pub(crate) timing: Option<Spanned<Timing>>,
    /// Number n of lost ticks; they are numbered 1 … n.
    #[serde(default)]
    #[schemars(with = "i64", range(min = 1, max = 64))]
    pub(crate) gap_ticks: Option<Spanned<Scalar>>,
    /// Ticks that the residual is fitted to; -1, 0, n+1, n+2 if absent. Numbers, "n+1", ranges "-7..0".
    #[serde(default)]
    #[schemars(with = "Vec<TickSchema>")]
    pub(crate) fit_ticks: Option<Spanned<Vec<Spanned<Scalar>>>>,
    /// Ticks that the extrapolation is fitted to, none after 0; -3, -2, -1, 0 if absent.
    #[serde(default)]
    #[schemars(with = "Vec<TickSchema>")]
    pub(crate) extrapolation_ticks: Option<Spanned<Vec<Spanned<Scalar>>>>,
    /// Fillers to compare, each once: a polynomial by its name, fitted to switching.fit_ticks, or a table of kind, name and ticks of
    /// its own, as of a minimum-variance filler.
    #[serde(default)]
    #[schemars(with = "Vec<FillerSchema>", length(min = 1), extend("uniqueItems" = true))]
    pub(crate) fillers: Option<Spanned<Vec<Spanned<Either<FillerTable>>>>>,
    /// Errors to find; ["residual", "extrapolation"] if absent.
    #[serde(default)]
    #[schemars(with = "Vec<Error>", length(min = 1), extend("uniqueItems" = true))]
    pub(crate) errors: Option<Spanned<Vec<Spanned<Error>>>>,
}

/// Sign of the magnetic drift in the first interval of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FirstMode {
    /// Its own: a magnetic drift above 0 adds to the angle.
    #[default]
    Positive,
    /// The opposite.
    Negative,
    /// Another in each run.
    Random,
}

/// Where in the motion the switches of a run fall; where the motion has a fixed phase, always there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Timing {
    /// At random, each by itself.
    #[default]
    Random,
    /// Exactly an interval apart, so that the phase goes on by as much from switch to switch; that of the first is random.
    Periodic,
}

/// A filler with ticks of its own.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FillerTable {
    #[schemars(with = "FillerKind")]
    pub(crate) kind: Spanned<FillerKind>,
    /// In tables and charts; the kind if absent.
    // Else the schema would give null, which TOML does not have, as the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "String")]
    pub(crate) name: Option<Spanned<String>>,
    /// Ticks that the residual is fitted to; switching.fit_ticks if absent.
    #[serde(default)]
    #[schemars(with = "Vec<TickSchema>")]
    pub(crate) fit_ticks: Option<Spanned<Vec<Spanned<Scalar>>>>,
    /// Ticks that the extrapolation is fitted to. If absent the fit ticks up to 0 of a minimum-variance filler that has
    /// fit_ticks of its own, else switching.extrapolation_ticks.
    #[serde(default)]
    #[schemars(with = "Vec<TickSchema>")]
    pub(crate) extrapolation_ticks: Option<Spanned<Vec<Spanned<Scalar>>>>,
    /// Vibration band that a minimum-variance filler is designed for, ["18 Hz", "22 Hz"]; the study's own motion if absent.
    #[serde(default)]
    #[schemars(with = "Vec<String>")]
    pub(crate) band: Option<Spanned<Ends>>,
    /// Weights of the residual in the order of its ticks; they sum to n. Numbers, or fractions "5/2".
    #[serde(default)]
    #[schemars(with = "Vec<WeightSchema>")]
    pub(crate) weights: Option<Spanned<Vec<Spanned<Scalar>>>>,
    /// Weights of the extrapolation; without them the filler has none.
    #[serde(default)]
    #[schemars(with = "Vec<WeightSchema>")]
    pub(crate) extrapolation_weights: Option<Spanned<Vec<Spanned<Scalar>>>>,
}

/// How a filler weighs its ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum FillerKind {
    /// Least-squares polynomial of order 0: the mean of the ticks.
    Const,
    /// Least-squares polynomial of order 1: a straight line.
    Linear,
    /// Least-squares polynomial of order 2: a parabola.
    Quadratic,
    /// The weights of the least error variance, for the vibration in its band, or without one for the motion of each point, and for
    /// the study's noise.
    MinimumVariance,
    /// The weights that are given.
    Weights,
}

/// Which error of a filler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Error {
    /// What is left in the angle for good, after the gap is closed and corrected.
    Residual,
    /// The error of the angle at the end of the gap, before it is corrected.
    Extrapolation,
    /// The largest error of the angle while the gap is open.
    InGap,
}

impl Error {
    /// Every error, in the order of the kernel.
    pub const ALL: [Error; 3] = [Error::Residual, Error::Extrapolation, Error::InGap];

    /// As study files and tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Error::Residual => "residual",
            Error::Extrapolation => "extrapolation",
            Error::InGap => "in-gap",
        }
    }
}

#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
enum FillerSchema {
    Name(PolynomialSchema),
    Table(Box<FillerTable>),
}

#[derive(JsonSchema)]
#[schemars(rename_all = "kebab-case")]
#[expect(dead_code, reason = "only its schema is used")]
enum PolynomialSchema {
    /// The mean of the ticks.
    Const,
    /// A straight line.
    Linear,
    /// A parabola.
    Quadratic,
}

/// A weight: a number, or a fraction as text.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
enum WeightSchema {
    Number(f64),
    Text(String),
}
