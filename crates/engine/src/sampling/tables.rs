//! The tables of a study's results.

use crate::chart::{Chart, Source};
use sagnac_base::table::Table;

/// The results of a study, as tables.
#[derive(Debug, Clone, PartialEq)]
pub struct Tables {
    /// Table of the points, `points.csv`.
    pub points: Table,
    /// Table of the coefficients, `coefficients.csv`, where coefficients are fitted.
    pub coefficients: Option<Table>,
    /// Table of trajectories, `trajectories.csv`, where some are kept.
    pub trajectories: Option<Table>,
}

impl Tables {
    /// All tables, each with its source.
    pub fn all(&self) -> impl Iterator<Item = (Source, &Table)> {
        let coefficients = self.coefficients.as_ref().map(|table| (Source::Coefficients, table));
        let trajectories = self.trajectories.as_ref().map(|table| (Source::Trajectories, table));
        std::iter::once((Source::Points, &self.points)).chain(coefficients).chain(trajectories)
    }

    /// All tables with the names of their files, that of the first of these charts before the others.
    pub fn into_files(self, charts: &[Chart]) -> Vec<(&'static str, Table)> {
        let first = charts.first().map_or(Source::Points, |chart| chart.source);
        let all = [
            (Source::Points, Some(self.points)),
            (Source::Coefficients, self.coefficients),
            (Source::Trajectories, self.trajectories),
        ];
        let mut all: Vec<_> =
            all.into_iter().filter_map(|(source, table)| Some((source.file(), table?))).collect();
        all.sort_by_key(|(file, _)| *file != first.file());
        all
    }

    /// Tables that consist of the points only.
    pub(crate) fn of_points(points: Table) -> Tables {
        Tables { points, coefficients: None, trajectories: None }
    }

    /// The table for a source.
    pub fn of(&self, source: Source) -> &Table {
        self.all().find(|(known, _)| *known == source).map_or(&self.points, |(_, table)| table)
    }
}
