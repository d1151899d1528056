//! The noise model of a filter, read from a document of `sagnac model --json`.

use std::ops::Range;
use std::sync::Arc;

use miette::NamedSource;
use serde::de::{Deserialize, Deserializer, Error};
use serde_json::value::RawValue;

use crate::key::row::Reading;
use crate::kinds::navigation::keys::FILTER;
use sagnac_base::source::diagnose::{Fault, Text, Wrong};
use sagnac_base::source::text_file::{Files, MAX_TOML};
use sagnac_theory::navigation::filter::Model;

/// Most Markov states of a filter.
const MAX_STATES: usize = 16;

const HELP: &str = "accepted: a document with one gyro, as of `sagnac model noise.toml --from \"1 s\" --to \"10000 s\" --overbound --json`";

/// The parts of the document that a filter needs.
#[derive(serde::Deserialize)]
struct Document {
    #[serde(deserialize_with = "size")]
    white_deg_per_rt_h: f64,
    #[serde(deserialize_with = "size")]
    random_walk_deg_per_h_per_rt_h: f64,
    #[serde(default, alias = "quantisation_arcsec", deserialize_with = "size")]
    quantization_arcsec: f64,
    markov: Vec<State>,
}

#[derive(serde::Deserialize)]
struct State {
    #[serde(deserialize_with = "size")]
    sigma_deg_per_h: f64,
    #[serde(deserialize_with = "time")]
    correlation_time_s: f64,
}

fn within<'de, D: Deserializer<'de>>(from: D, [least, most]: [f64; 2]) -> Result<f64, D::Error> {
    let value = f64::deserialize(from)?;
    match (least..=most).contains(&value) {
        true => Ok(value),
        false => Err(Error::custom(format!("{value} is not from {least} to {most}"))),
    }
}

fn size<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    within(from, [0.0, 1e9])
}

fn time<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    within(from, [1e-6, 1e9])
}

/// The model that the study writes.
pub(crate) fn written(reading: &Reading) -> Result<Option<Model>, Wrong> {
    reading.get(&FILTER).map(|file| read(file.text(), file.span(), reading.files)).transpose()
}

/// The model of each file of a sweep.
pub(crate) fn swept(reading: &Reading) -> Result<Vec<Model>, Wrong> {
    let files = reading.sweep(&FILTER).into_iter().flat_map(|sweep| &sweep.files);
    files.map(|file| read(file.get_ref(), file.span(), reading.files)).collect()
}

/// Reads the file of this name, which is at `span` of the study.
fn read(name: &str, span: Range<usize>, files: &Files) -> Result<Model, Wrong> {
    let path = files.path(name);
    let text = files.text(name, MAX_TOML).map_err(|error| {
        let message = format!("cannot read the model of a filter {}: {error}", path.display());
        let help =
            "give the path of a document of `sagnac model --json`, relative to the folder of the study";
        Fault::new(span, message, "named here", help)
    })?;
    let text: Text = Arc::new(NamedSource::new(path.display().to_string(), text.to_string()));
    parse(text.inner()).map_err(|fault| Wrong::Elsewhere(fault.within(&text)))
}

/// A document of `sagnac model --json`.
#[derive(serde::Deserialize)]
struct Printed<'a> {
    #[serde(borrow)]
    model: Columns<'a>,
}

#[derive(serde::Deserialize)]
struct Columns<'a> {
    #[serde(borrow)]
    columns: Vec<&'a RawValue>,
}

/// The part of a document that has the model: of `model.json` the whole, of what `--json` prints that of its only column.
fn of_column(text: &str) -> &str {
    match serde_json::from_str(text) {
        Ok(Printed { model: Columns { columns } }) if columns.len() == 1 => columns[0].get(),
        _ => text,
    }
}

fn parse(whole: &str) -> Result<Model, Fault> {
    let text = of_column(whole);
    let start = whole.find(text).unwrap_or(0);
    let document: Document = serde_json::from_str(text).map_err(|error| {
        let message = error.to_string();
        let found = message.rsplit_once(" at line").map_or(message.as_str(), |(found, _)| found);
        let message = format!("the model of a filter cannot be read: {found}");
        let at = place(text, error.line(), error.column());
        Fault::new(start + at.start..start + at.end, message, "here", HELP)
    })?;
    if document.markov.len() > MAX_STATES {
        let message = format!("the model of a filter has {} Markov states", document.markov.len());
        return Err(Fault::new(
            0..whole.len(),
            message,
            "in this document",
            format!("accepted: up to {MAX_STATES}"),
        ));
    }
    let state = |state: &State| [state.sigma_deg_per_h, state.correlation_time_s];
    let model = Model {
        // 1 °/√h is 60 ″/√s, and 1 °/h/√h is 1/60 ″/s^1.5.
        white: document.white_deg_per_rt_h * 60.0,
        walk: document.random_walk_deg_per_h_per_rt_h / 60.0,
        markov: document.markov.iter().map(state).collect(),
        quantization: document.quantization_arcsec,
    };
    if model.is_nothing() {
        return Err(Fault::new(
            0..whole.len(),
            "the model of a filter has no noise",
            "in this document",
            HELP,
        ));
    }
    Ok(model)
}

/// The character before a line and a column from 1 on; of the end of the text, the last one.
fn place(text: &str, line: usize, column: usize) -> Range<usize> {
    let before: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let mut at = (before + column.saturating_sub(1)).min(text.len().saturating_sub(1));
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at..text[at..].chars().next().map_or(at, |c| at + c.len_utf8())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_of_a_document_are_in_arcseconds_and_seconds() {
        let model = parse(
            r#"{"white_deg_per_rt_h": 2.0, "random_walk_deg_per_h_per_rt_h": 3.0, "quantization_arcsec": 0.5,
                "markov": [{"sigma_deg_per_h": 4.0, "correlation_time_s": 7.0}]}"#,
        );
        let model = model.unwrap_or_else(|_| panic!("the document is not read"));
        // Over an hour the angle has 2°, and the rate has walked 3°/h.
        let (hour, degree) = (3600.0, 3600.0);
        assert!((model.white * f64::sqrt(hour) / (2.0 * degree) - 1.0).abs() < 1e-14, "{model:?}");
        assert!((model.walk * f64::sqrt(hour) / (3.0 * degree / hour) - 1.0).abs() < 1e-14, "{model:?}");
        // 4°/h turn 4° in an hour.
        let [sigma, time_s] = model.markov[0];
        assert!((sigma * hour / (4.0 * degree) - 1.0).abs() < 1e-14, "{model:?}");
        assert_eq!((time_s, model.quantization, model.markov.len()), (7.0, 0.5, 1));
    }
}
