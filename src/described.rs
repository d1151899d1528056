//! The columns of every file of results, from which `sagnac explain`, reports and the schema of documents take their meanings.

use crate::analysis::{
    batch, compare, design, dynamic, firmware, hat, log, model, navigators, requirement, sensitivity,
    spectrum, temperature,
};
use sagnac_base::quantity::bare;
use sagnac_base::table::About;
use sagnac_base::table::column::abouts;
use sagnac_engine::chart::Source;
use sagnac_engine::key::Key;
use sagnac_engine::kinds::{KINDS, switched_run};
use sagnac_engine::study::Kind;

/// A file of results with columns.
#[derive(Debug, Clone)]
pub struct File {
    /// Name, such as `points.csv`.
    pub name: &'static str,
    /// Its writer.
    pub by: By,
    /// Its columns except the swept keys, in the order of the file.
    pub columns: Vec<About>,
    /// The keys whose sweeps have columns before these.
    sweepable: Vec<&'static Key>,
}

/// The writer of a file of results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// A study of this kind, for this one of its tables.
    Study(&'static Kind, Source),
    /// A command, such as `sagnac allan`.
    Command(&'static str),
}

/// All files with columns.
pub fn files() -> Vec<File> {
    let command =
        |name, command, columns| File { name, by: By::Command(command), columns, sweepable: vec![] };
    let of_designs = |name, columns| File {
        sweepable: switched_run::sweepable(),
        ..command(name, "sagnac design", columns)
    };
    let of_kinds = KINDS.iter().flat_map(|kind| {
        let columns = kind.columns.iter();
        columns.map(|(source, columns)| File {
            name: source.file(),
            by: By::Study(kind, *source),
            columns: columns(),
            sweepable: (kind.sweepable)(),
        })
    });
    of_kinds
        .chain([
            of_designs("design.csv", abouts(&design::report::columns(&design::Measure::ALL))),
            of_designs("fillers.csv", abouts(&design::report::filler_columns())),
            of_designs("pareto.csv", abouts(&design::report::pareto_columns())),
            command("sensitivity.csv", "sagnac sensitivity", abouts(&sensitivity::report::columns())),
            command(
                "distribution.csv",
                "sagnac sensitivity",
                abouts(&sensitivity::report::distribution_columns()),
            ),
            command("events.csv", "sagnac allan", abouts(&log::events::columns())),
            command("records.csv", "sagnac allan", abouts(&log::report::record_columns())),
            command("limits.csv", "sagnac allan", abouts(&requirement::columns())),
            command("navigation.csv", "sagnac allan", abouts(&navigators::columns())),
            command("curve.csv", "sagnac allan", abouts(&log::report::curve_columns())),
            command("coefficients.csv", "sagnac allan", abouts(&log::report::coefficient_columns())),
            command("ranking.csv", "sagnac allan", abouts(&log::report::ranking_columns())),
            command("temperature.csv", "sagnac allan", abouts(&temperature::report::coefficient_columns())),
            command("compensation.csv", "sagnac allan", abouts(&temperature::report::compensation_columns())),
            command("dynamic.csv", "sagnac allan", abouts(&dynamic::report::point_columns())),
            command("stationarity.csv", "sagnac allan", abouts(&dynamic::report::octave_columns())),
            command("psd.csv", "sagnac allan", abouts(&spectrum::report::density_columns())),
            command("lines.csv", "sagnac allan", abouts(&spectrum::report::line_columns())),
            command("white_noise.csv", "sagnac allan", abouts(&spectrum::report::white_columns())),
            command("compare.csv", "sagnac compare", abouts(&compare::report::ratio_columns())),
            command("coefficients.csv", "sagnac compare", abouts(&compare::report::coefficient_columns())),
            command("units.csv", "sagnac compare", abouts(&batch::report::unit_columns())),
            command("batch.csv", "sagnac compare", abouts(&batch::report::batch_columns())),
            command("hat.csv", "sagnac compare", abouts(&hat::columns())),
            command("model.csv", "sagnac model", abouts(&model::tables::columns())),
            command("fillers.csv", "sagnac filler", abouts(&firmware::report::filler_columns())),
            command("weights.csv", "sagnac filler", abouts(&firmware::report::columns())),
            command("trade.csv", "sagnac filler", abouts(&firmware::search::columns())),
            command("test_vectors.csv", "sagnac filler", firmware::export::COLUMNS.to_vec()),
        ])
        .collect()
}

impl File {
    /// The file of one of the tables of a study; `None` where studies of the kind have no such table.
    pub fn of_study(kind: &'static Kind, source: Source) -> Option<File> {
        files().into_iter().find(|file| file.by == By::Study(kind, source))
    }

    /// Title for the user, such as `points.csv of kind = "gap-fill"`.
    pub fn title(&self) -> String {
        match self.by {
            By::Study(kind, _) => format!("{} of kind = \"{}\"", self.name, kind.name),
            By::Command(command) => format!("{} of `{command}`", self.name),
        }
    }

    /// The meaning of the column `name` in this file, by its header or its name without unit; for a swept key its
    /// label. `None` for a column that the file cannot have.
    ///
    /// # Example
    /// ```
    /// # use sagnac::described::File;
    /// # use sagnac_engine::{chart::Source, kinds::gap_fill::GAP_FILL};
    /// let points = File::of_study(&GAP_FILL, Source::Points).unwrap();
    /// assert!(points.column("rms_arcsec").unwrap().starts_with("Root mean square"));
    /// assert_eq!(points.column("motion.frequency_hz"), Some("vibration frequency"));
    /// assert_eq!(points.column("adev"), None);
    /// ```
    pub fn column(&self, name: &str) -> Option<&'static str> {
        let own = self.columns.iter().find(|column| column.is_called(name));
        own.map(|column| column.meaning).or_else(|| self.swept(name))
    }

    /// The label of a swept key that heads a column of this file.
    fn swept(&self, name: &str) -> Option<&'static str> {
        let of = |name: &str| self.sweepable.iter().find(|key| key.name == name).map(|key| key.label);
        of(name).or_else(|| bare(name).find_map(of))
    }
}

/// The meanings of a column in all files that have it: each text once, with its files.
pub fn meanings(name: &str) -> Vec<(&'static str, Vec<File>)> {
    let mut found: Vec<(&'static str, Vec<File>)> = Vec::new();
    for file in files() {
        let Some(text) = file.column(name) else { continue };
        match found.iter_mut().find(|(known, _)| *known == text) {
            Some((_, files)) => files.push(file),
            None => found.push((text, vec![file])),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde_json::{Map, Value, json};

    use super::*;
    use crate::analysis::model::tables::ModelDocument;
    use sagnac_base::table::Cells;

    #[test]
    fn the_columns_that_kinds_are_explained_by_are_there() {
        let files = files();
        for kind in KINDS {
            for name in kind.about.split('`').skip(1).step_by(2).filter(|name| !name.contains(' ')) {
                let mut own = files.iter().filter(|file| matches!(file.by, By::Study(of, _) if of == kind));
                assert!(own.any(|file| file.column(name).is_some()), "{kind:?}: {name}");
            }
        }
    }

    /// The rows of a file as a schema. Those of studies have columns that `sagnac explain` describes.
    fn rows(file: &File) -> Value {
        let title = file.title();
        let By::Command(_) = file.by else { return json!({ "title": title, "type": "array" }) };
        let column = |about: &About| {
            let cell = json!({ "description": about.meaning, "$ref": "#/$defs/Cell" });
            (about.with(Cells::default()).header(), cell)
        };
        let columns: Map<String, Value> = file.columns.iter().map(column).collect();
        // Before the columns are those of swept keys, and some of a sensitivity have the unit of its answer in their headers.
        let is_open = !file.sweepable.is_empty() || file.name == "sensitivity.csv";
        let row = json!({ "type": "object", "properties": columns, "additionalProperties": is_open });
        json!({ "title": title, "type": "array", "items": row })
    }

    #[test]
    fn the_schema_of_documents_follows_from_their_type_and_the_columns_of_files() {
        let mut document = schemars::schema_for!(ModelDocument).to_value();
        document["title"] = "Document".into();
        document["description"] = "The results of a command with `--json`.".into();
        document["additionalProperties"] = false.into();
        // Only `sagnac model` has models and files.
        document["required"].as_array_mut().unwrap().retain(|key| key != "model" && key != "files");
        let mut tables: BTreeMap<&str, Vec<Value>> = BTreeMap::new();
        for file in files() {
            tables.entry(file.name.trim_end_matches(".csv")).or_default().push(rows(&file));
        }
        let tables = tables.into_iter().map(|(stem, files)| (stem.to_owned(), json!({ "anyOf": files })));
        document["properties"]["tables"]["properties"] = tables.collect::<Map<_, _>>().into();
        let mut definitions = document["$defs"].take();
        let keys = document.as_object_mut().unwrap();
        keys.retain(|key, _| !key.starts_with('$'));
        definitions["Document"] = document;
        let of_one = json!({ "$ref": "#/$defs/Document" });
        let present = json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": "Output of a command of sagnac with --json",
            "description": "A document, or of several inputs an array of them.",
            "anyOf": [of_one, { "type": "array", "items": of_one }],
            "$defs": definitions,
        });
        let name = "schema/document.schema.json";
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
        let shipped = std::fs::read(&path).unwrap_or_default();
        if serde_json::from_slice(&shipped).ok() != Some(present.clone()) {
            let text = serde_json::to_string_pretty(&present).unwrap() + "\n";
            std::fs::write(path.with_extension("new.json"), text).unwrap();
            panic!("{name} is out of date; the present one is beside it: compare, then rename it");
        }
    }
}
