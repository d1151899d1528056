//! The whole model as JSON, the same as `--json` prints.

use crate::analysis::model::tables::document;
use crate::analysis::model::writers::{Takes, Writer};

pub(super) static JSON: Writer = Writer {
    name: "json",
    file: "model.json",
    tool: "programs of your own",
    convention: "units are part of the names of keys; matrices are in SI units, white noise and random walk are square roots of two-sided densities",
    takes: Takes::ALL,
    text: |sheet| {
        let mut document = document(sheet.analysis);
        document["heading"] = sheet.heading.clone().into();
        format!("{document:#}\n")
    },
};
