//! A noise model as tables, and as a document for other programs.

use std::collections::BTreeMap;

use crate::analysis::log::report::{key, text};
use crate::analysis::model::search::Tried;
use crate::analysis::model::target::Point;
use crate::analysis::model::{Aim, Analysis, Column, Discrete, Markov, ModelError, discrete, si};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_records::allan::{self, Deviation, Unit as Curves};
use sagnac_records::fit::Term;
use sagnac_report::page::Document;
use sagnac_theory::allan::{Part, continuous_variance};
use serde::Serialize;

/// A row of `model.csv`.
pub(crate) struct Row<'a> {
    column: &'a Column,
    point: &'a Point,
    bound: Option<f64>,
    model: f64,
}

/// The columns of `model.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        key(|row| text(&row.column.target.name)),
        Of::new("tau", Unit::S, "tau", |row| Cell::Number(row.point.tau_s))
            .is(Role::Coordinate, "Averaging time τ, s."),
        Of::new("record", Unit::NONE, "record", |row| Cell::Number(row.point.value))
            .is(Role::Error, "Allan deviation of the record, or of the coefficients of a noise.toml, in `unit`."),
        Of::new("lower", Unit::NONE, "lower", |row| Cell::Number(row.point.lower))
            .is_of("record", Role::Lower, "Lower end of the band of `record`."),
        Of::new("upper", Unit::NONE, "upper", |row| Cell::Number(row.point.upper))
            .is_of("record", Role::Upper, "Upper end of the band of `record`."),
        Of::new("bound", Unit::NONE, "bound", |row| row.bound.into())
            .is(Role::Estimate, "What the model lies nowhere below, in `unit`: the upper end of the band, or that of another record; blank without `--overbound`."),
        Of::new("model", Unit::NONE, "model", |row| Cell::Number(row.model))
            .is(Role::Estimate, "Allan deviation of the model, quantization included, in `unit`."),
        Of::new("excess", Unit::NONE, "excess", |row| Cell::Number(row.model / row.point.value - 1.0))
            .is(Role::Estimate, "How far the model lies above `record`, as a part of it."),
        Of::new("excess_over_bound", Unit::NONE, "excess_over_bound", |row| row.bound.map(|bound| row.model / bound - 1.0).into())
            .is(Role::Estimate, "How far the model lies above `bound`, as a part of it."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.column.target.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of the deviations."),
    ]
}

/// The curves of all columns beside their models: `model.csv`.
pub fn table(analysis: &Analysis) -> Table {
    let rows: Vec<Row> = analysis.columns.iter().flat_map(|column| rows(analysis, column)).collect();
    Table { columns: columns_of(&columns(), &rows) }
}

fn rows<'a>(analysis: &Analysis, column: &'a Column) -> Vec<Row<'a>> {
    let bounds = |i: usize| (analysis.request.aim != Aim::Describe).then(|| column.found.bounds[i]);
    let points = column.target.points.iter().enumerate();
    points
        .map(|(i, point)| Row {
            column,
            point,
            bound: bounds(i),
            model: column.found.model.deviation(point.tau_s),
        })
        .collect()
}

/// A number of a model with its names: for the user, in documents, and its unit.
pub struct Figure {
    /// What it is.
    pub name: String,
    /// Key in documents; empty of those that only people read.
    pub key: String,
    /// Value.
    pub value: f64,
    /// Unit for the user.
    pub unit: &'static str,
}

/// White noise, random walk and quantization in the units that people use; the first of each is that of documents.
pub fn figures(column: &Column) -> Vec<Figure> {
    let (model, unit) = (&column.found.model, column.target.unit);
    let size = si(unit);
    let figure = |name: &str, key: &str, value: f64, unit: &'static str| Figure {
        name: name.to_owned(),
        key: key.to_owned(),
        value,
        unit,
    };
    let (white, walk, quantization) = ("white noise N", "random walk K", "quantization Q");
    let all = match unit {
        Curves::Acceleration => [
            figure(white, "white_m_per_s_per_rt_h", 60.0 * size * model.white, "m/s/√h"),
            figure("", "", model.white, "µg/√Hz"),
            figure("", "", size * model.white, "m/s²/√Hz"),
            figure(walk, "random_walk_ug_per_rt_h", 60.0 * model.walk, "µg/√h"),
            figure("", "", size * model.walk, "m/s³/√Hz"),
            figure(quantization, "quantization_m_per_s", size * model.quantization, "m/s"),
        ],
        Curves::Angular | Curves::Plain => [
            figure(white, "white_deg_per_rt_h", model.white / 60.0, "°/√h"),
            figure("", "", model.white, "°/h/√Hz"),
            figure("", "", size * model.white, "rad/s/√Hz"),
            figure(walk, "random_walk_deg_per_h_per_rt_h", 60.0 * model.walk, "°/h/√h"),
            figure("", "", size * model.walk, "rad/s²/√Hz"),
            figure(quantization, "quantization_arcsec", model.quantization, "″"),
        ],
    };
    all.into()
}

/// Each part of a model with its label and its deviation over τ, for charts.
pub(crate) fn lines(column: &Column, taus: &[f64]) -> Vec<(String, Vec<(f64, f64)>)> {
    let symbol = column.target.unit.symbol(Deviation::Oadev);
    let line = |part: &Part| {
        let label = match part.term {
            Term::Markov => {
                let sigma = part.size * libm::sqrt(0.5 * part.shape);
                let shown = |x: f64| sagnac_base::quantity::number::significant(x, 3);
                format!("σ = {} {symbol}, T = {} s", shown(sigma), shown(part.shape))
                    .replace(' ', "\u{a0}")
                    .replace(",\u{a0}", ", ")
            }
            term => term.row().title.to_owned(),
        };
        let at = |&tau_s: &f64| Some((tau_s, libm::sqrt(continuous_variance(part, tau_s)?)));
        (label, taus.iter().filter_map(at).collect())
    };
    column.found.model.parts().iter().map(line).collect()
}

/// The results of `sagnac model` with their answer, as `--json` prints them.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct ModelDocument<'a> {
    /// What all documents have.
    #[serde(flatten)]
    pub document: Document<'a>,
    /// The models.
    pub model: &'a Models,
    /// The texts of the files for tools that were asked for, by their names.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
}

/// The models of all columns with what was asked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct Models {
    /// `describe`, `bound` or `bound repeat`.
    pub aim: &'static str,
    /// Probability of the band.
    pub confidence: f64,
    /// How far a bound may lie above before a state is added, as a part.
    pub margin: f64,
    /// Rate of the filter, Hz.
    pub filter_hz: Option<f64>,
    /// The model of each column that has one.
    pub columns: Vec<ColumnModel>,
    /// The columns without a model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(test, schemars(default))]
    pub without_model: Vec<NoModel>,
}

/// A column without a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct NoModel {
    /// Name of the column.
    pub column: String,
    /// Why no model was found.
    pub why: String,
}

/// The model of a column.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ColumnModel {
    /// Name of the column.
    pub column: String,
    /// Unit of its deviations in tables.
    pub unit: &'static str,
    /// Shortest averaging time that the model covers, s.
    pub from_s: f64,
    /// Longest averaging time that the model covers, s.
    pub to_s: f64,
    /// White noise, random walk and quantization: of gyros `white_deg_per_rt_h`, `random_walk_deg_per_h_per_rt_h` and
    /// `quantization_arcsec`, of accelerometers `white_m_per_s_per_rt_h`, `random_walk_ug_per_rt_h` and `quantization_m_per_s`.
    #[serde(flatten)]
    pub numbers: BTreeMap<String, f64>,
    /// The Gauss–Markov states with their `correlation_time_s` and their `sigma_deg_per_h`, or `sigma_ug` of accelerometers.
    pub markov: Vec<BTreeMap<&'static str, f64>>,
    /// How far the model lies at most above the record, as a part.
    pub largest_excess: f64,
    /// Averaging time of that excess, s.
    pub largest_excess_tau_s: f64,
    /// How far the model lies at most below the record, as a part; negative where it is above at every averaging time.
    pub largest_shortfall: f64,
    /// Averaging time of that shortfall, s.
    pub largest_shortfall_tau_s: f64,
    /// How far a bound lies at most above what it bounds, as a part.
    pub largest_excess_over_bound: Option<f64>,
    /// What each number of states reaches.
    pub tried: Vec<Tried>,
    /// The model at the rate of the filter.
    pub discrete: Option<Discrete>,
}

impl ColumnModel {
    fn new(analysis: &Analysis, column: &Column) -> ColumnModel {
        let Column { target, found } = column;
        let [from_s, to_s] = target.taus();
        let [largest_excess, largest_excess_tau_s] = found.over_record(target);
        let [largest_shortfall, largest_shortfall_tau_s] = found.below_record(target);
        let sigma = if target.unit == allan::Unit::Acceleration { "sigma_ug" } else { "sigma_deg_per_h" };
        let state = |state: &Markov| [(sigma, state.sigma), ("correlation_time_s", state.time_s)].into();
        let named = figures(column).into_iter().filter(|figure| !figure.key.is_empty());
        let is_bound = analysis.request.aim != Aim::Describe;
        let at_rate = |filter_hz: f64| discrete(&found.model, target.unit, 1.0 / filter_hz, to_s);
        ColumnModel {
            column: target.name.clone(),
            unit: target.unit.in_files(Deviation::Oadev),
            from_s,
            to_s,
            numbers: named.map(|figure| (figure.key, figure.value)).collect(),
            markov: found.model.markov.iter().map(state).collect(),
            largest_excess,
            largest_excess_tau_s,
            largest_shortfall,
            largest_shortfall_tau_s,
            largest_excess_over_bound: is_bound.then(|| found.over_bound(target)[0]),
            tried: found.tried.clone(),
            discrete: analysis.filter_hz().map(at_rate),
        }
    }
}

impl Models {
    /// The models of an analysis.
    pub fn new(analysis: &Analysis) -> Models {
        let request = &analysis.request;
        let without =
            |(column, why): &(String, ModelError)| NoModel { column: column.clone(), why: why.to_string() };
        Models {
            aim: request.aim.name(),
            confidence: request.confidence,
            margin: request.margin,
            filter_hz: analysis.filter_hz(),
            columns: analysis.columns.iter().map(|column| ColumnModel::new(analysis, column)).collect(),
            without_model: analysis.without.iter().map(without).collect(),
        }
    }
}
