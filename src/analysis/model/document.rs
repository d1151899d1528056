//! Models for programs: what `--json` adds to the page, and `model.json`.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::analysis::model::search::Tried;
use crate::analysis::model::states::{Discrete, discrete};
use crate::analysis::model::tables::figures;
use crate::analysis::model::writers::{Writer, texts};
use crate::analysis::model::{Aim, Analysis, Column, Markov};
use sagnac_records::allan::{Deviation, Unit};
use sagnac_report::page::document::Document;
use sagnac_report::page::sections::Page;

/// The results of `sagnac model` with their answer, as `--json` prints them.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ModelDocument<'a> {
    /// What all documents have.
    #[serde(flatten)]
    pub document: Document<'a>,
    /// The models.
    pub model: Models,
    /// The texts of the files for tools that were asked for, by their names.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<&'static str, String>,
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
    /// The model of each column.
    pub columns: Vec<ColumnModel>,
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
        let sigma = if target.unit == Unit::Acceleration { "sigma_ug" } else { "sigma_deg_per_h" };
        let state = |state: &Markov| [(sigma, state.sigma), ("correlation_time_s", state.time_s)].into();
        let named = figures(column).into_iter().filter(|figure| !figure.key.is_empty());
        let is_bound = analysis.asked.aim != Aim::Describe;
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
            largest_excess_over_bound: is_bound.then(|| found.over_bound(target)[0]),
            tried: found.tried.clone(),
            discrete: analysis.filter_hz().map(at_rate),
        }
    }
}

impl Models {
    /// The models of an analysis.
    pub fn new(analysis: &Analysis) -> Models {
        let asked = &analysis.asked;
        Models {
            aim: asked.aim.name(),
            confidence: asked.confidence,
            margin: asked.margin,
            filter_hz: analysis.filter_hz(),
            columns: analysis.columns.iter().map(|column| ColumnModel::new(analysis, column)).collect(),
        }
    }
}

/// The document of models from their page, with the files that were asked for.
pub fn document<'a>(analysis: &Analysis, page: &'a Page, writers: &[&'static Writer]) -> ModelDocument<'a> {
    let files = texts(analysis, writers).into_iter().collect();
    ModelDocument { document: page.document(&[]), model: Models::new(analysis), files }
}
