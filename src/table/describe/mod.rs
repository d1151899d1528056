//! What the columns of every file of results mean, in words.
//!
//! The one place where a column is explained: `sagnac explain`, reports and documents read it from here. A column that a study
//! writes and that is not described here fails a test.

pub mod columns;

use crate::chart::file::Source;
use crate::kinds::KINDS;
use crate::kinds::allan::kind::ALLAN;
use crate::kinds::switched_run::kind::SWITCHED_RUN;
use crate::study::kind::Kind;
use crate::table::Unit;

/// A file of results with columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum File {
    /// `points.csv` of a study of this kind.
    Points(&'static Kind),
    /// `coefficients.csv` of a study of Allan curves.
    Coefficients,
    /// `trajectories.csv` of a study of whole runs.
    Trajectories,
    /// `design.csv`, all that `sagnac design` tried.
    Design,
    /// `curve.csv` of a recorded log.
    LogCurve,
    /// `coefficients.csv` of a recorded log.
    LogCoefficients,
    /// `compare.csv` of two recorded logs.
    Compare,
    /// `coefficients.csv` of two recorded logs.
    CompareCoefficients,
    /// `weights.csv` of gap fillers.
    Weights,
    /// `test_vectors.csv` of gap fillers.
    TestVectors,
}

impl File {
    /// All files that have columns.
    pub fn all() -> Vec<File> {
        let points = KINDS.into_iter().map(File::Points);
        let others = [
            File::Coefficients,
            File::Trajectories,
            File::Design,
            File::LogCurve,
            File::LogCoefficients,
            File::Compare,
            File::CompareCoefficients,
            File::Weights,
            File::TestVectors,
        ];
        points.chain(others).collect()
    }

    /// The file of one of the tables of a study.
    pub fn of_study(kind: &'static Kind, source: Source) -> File {
        match source {
            Source::Points => File::Points(kind),
            Source::Coefficients => File::Coefficients,
            Source::Trajectories => File::Trajectories,
        }
    }

    /// For people: `points.csv of a gap-fill study`.
    pub fn title(self) -> String {
        match self {
            File::Points(kind) => format!("points.csv of kind = \"{}\"", kind.name),
            File::Coefficients => "coefficients.csv of kind = \"allan\"".to_owned(),
            File::Trajectories => "trajectories.csv of kind = \"switched-run\"".to_owned(),
            File::Design => "design.csv of `sagnac design`".to_owned(),
            File::LogCurve => "curve.csv of `sagnac allan`".to_owned(),
            File::LogCoefficients => "coefficients.csv of `sagnac allan`".to_owned(),
            File::Compare => "compare.csv of `sagnac compare`".to_owned(),
            File::CompareCoefficients => "coefficients.csv of `sagnac compare`".to_owned(),
            File::Weights => "weights.csv of `sagnac filler`".to_owned(),
            File::TestVectors => "test_vectors.csv of `sagnac filler`".to_owned(),
        }
    }

    /// Its columns besides swept keys, by name without unit, in the order of the file, each with its meaning. A name that ends in `[…]`
    /// stands for one column of each tick.
    pub fn columns(self) -> &'static [(&'static str, &'static str)] {
        crate::table::describe::columns::of(self)
    }

    /// What the column called `name` means in this file, by its header or its name without unit; of a swept key its label.
    /// `None` of a column that the file cannot have.
    ///
    /// # Example
    /// ```
    /// # use sagnac::kinds::gap_fill::kind::GAP_FILL;
    /// # use sagnac::table::describe::File;
    /// let points = File::Points(&GAP_FILL);
    /// assert!(points.column("rms_arcsec").unwrap().starts_with("Root mean square"));
    /// assert_eq!(points.column("motion.frequency_hz"), Some("vibration frequency"));
    /// assert_eq!(points.column("adev"), None);
    /// ```
    pub fn column(self, name: &str) -> Option<&'static str> {
        let own = |name: &str| {
            let of_tick = |known: &str| known.strip_suffix("…]").is_some_and(|start| name.starts_with(start));
            self.columns().iter().find(|(known, _)| *known == name || of_tick(known)).map(|(_, text)| *text)
        };
        own(name).or_else(|| bare(name).find_map(own)).or_else(|| self.swept(name))
    }

    /// What a swept key is that heads a column of this file.
    fn swept(self, name: &str) -> Option<&'static str> {
        let kind = match self {
            File::Points(kind) => kind,
            File::Coefficients => &ALLAN,
            File::Trajectories => &SWITCHED_RUN,
            _ => return None,
        };
        let keys = (kind.keys)();
        let of = |name: &str| keys.iter().find(|key| key.name == name).map(|key| key.label);
        of(name).or_else(|| bare(name).find_map(of))
    }
}

/// The names that a header may be without its unit; one unit may be the end of another.
pub(crate) fn bare(header: &str) -> impl Iterator<Item = &str> {
    Unit::ALL.iter().filter_map(move |unit| header.strip_suffix(unit.suffix)?.strip_suffix('_'))
}

/// The meanings of a column in all files that have one called so: each text once, with the files.
pub fn meanings(name: &str) -> Vec<(&'static str, Vec<File>)> {
    let mut found: Vec<(&'static str, Vec<File>)> = Vec::new();
    for file in File::all() {
        let Some(text) = file.column(name) else { continue };
        match found.iter_mut().find(|(known, _)| *known == text) {
            Some((_, files)) => files.push(file),
            None => found.push((text, vec![file])),
        }
    }
    found
}
