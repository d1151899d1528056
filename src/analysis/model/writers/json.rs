//! The whole model as JSON, with the numbers that `--json` prints.

use serde::Serialize;

use crate::analysis::model::tables::{ColumnModel, Models};
use crate::analysis::model::writers::{Takes, Writer};
use sagnac_report::page::document::json;

/// The file: the models, of which a single one stands at the top too, where `navigation.filter` reads it.
#[derive(Serialize)]
struct File<'a> {
    heading: &'a [String],
    #[serde(flatten)]
    only: Option<&'a ColumnModel>,
    #[serde(flatten)]
    models: &'a Models,
}

pub(super) static JSON: Writer = Writer {
    name: "json",
    file: "model.json",
    tool: "programs of your own",
    convention: "units are part of the names of keys; matrices are in SI units, white noise and random walk are square roots of two-sided densities",
    takes: Takes::ALL,
    text: |sheet| {
        let models = Models::new(sheet.analysis);
        let only = if let [only] = &models.columns[..] { Some(only) } else { None };
        json(&File { heading: &sheet.heading, only, models: &models }) + "\n"
    },
};
