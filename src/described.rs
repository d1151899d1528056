//! The columns of every file of results, from which `sagnac explain`, reports and documents take their meanings.

use crate::analysis::{
    compare, design, dynamic, firmware, log, lot, model, sensitivity, spectrum, temperature,
};
use crate::chart::file::Source;
use crate::key::row::Key;
use crate::kinds::{KINDS, switched_run};
use crate::quantity::unit::bare;
use crate::study::kind::Kind;
use crate::table::About;
use crate::table::column::abouts;

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
            of_designs("pareto.csv", abouts(&design::report::pareto_columns())),
            command("sensitivity.csv", "sagnac sensitivity", abouts(&sensitivity::report::columns())),
            command("events.csv", "sagnac allan", abouts(&log::events::columns())),
            command("curve.csv", "sagnac allan", abouts(&log::tables::curve_columns())),
            command("coefficients.csv", "sagnac allan", abouts(&log::tables::coefficient_columns())),
            command("temperature.csv", "sagnac allan", abouts(&temperature::tables::coefficient_columns())),
            command("compensation.csv", "sagnac allan", abouts(&temperature::tables::compensation_columns())),
            command("dynamic.csv", "sagnac allan", abouts(&dynamic::tables::point_columns())),
            command("stationarity.csv", "sagnac allan", abouts(&dynamic::tables::octave_columns())),
            command("psd.csv", "sagnac allan", abouts(&spectrum::tables::density_columns())),
            command("lines.csv", "sagnac allan", abouts(&spectrum::tables::line_columns())),
            command("white_noise.csv", "sagnac allan", abouts(&spectrum::tables::white_columns())),
            command("compare.csv", "sagnac compare", abouts(&compare::tables::ratio_columns())),
            command("coefficients.csv", "sagnac compare", abouts(&compare::tables::coefficient_columns())),
            command("units.csv", "sagnac lot", abouts(&lot::tables::unit_columns())),
            command("batch.csv", "sagnac lot", abouts(&lot::tables::lot_columns())),
            command("model.csv", "sagnac model", abouts(&model::tables::columns())),
            command("weights.csv", "sagnac filler", abouts(&firmware::tables::columns())),
            command("trade.csv", "sagnac filler", abouts(&firmware::search::columns())),
            command("test_vectors.csv", "sagnac filler", firmware::vectors::COLUMNS.to_vec()),
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
    /// # use sagnac::{chart::file::Source, described::File, kinds::gap_fill::kind::GAP_FILL};
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
    use super::*;

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
}
