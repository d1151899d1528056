//! What a record shows of that which can be limited.

use crate::analysis::data_sheet::{DataSheet, Row};
use crate::analysis::log::report::least_or_bound;
use crate::analysis::log::{self, Column};
use crate::analysis::requirement::limit::Limited;
use sagnac_records::allan::{Spread, Unit};
use sagnac_records::fit::Fit;

/// A record that is checked against limits: a column of a log, or a unit of a batch.
#[derive(Debug, Clone)]
pub struct Subject<'a> {
    /// What it is called.
    pub label: &'a str,
    /// Unit of its curves.
    pub unit: Unit,
    /// Its coefficients; absent where none were requested, or why there are none.
    pub noise: Result<Option<&'a DataSheet>, &'a str>,
    /// The minimum of its curve up to an eighth of the record; without a value where the curve still falls there.
    pub stability: Option<Row>,
    /// Averaging time of that minimum, s.
    pub stability_tau_s: Option<f64>,
    /// N of the flat part of its density.
    pub floor: Option<&'a Row>,
    /// Number of samples.
    pub samples: usize,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Deviations of its estimates beyond those of Gaussian noise.
    pub spread: &'a Spread,
}

/// Why a record says nothing about a limit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Gap {
    /// Coefficients could not be determined.
    Failed(String),
    /// No coefficients were requested.
    NotAsked,
    /// The fit describes the curve over no range of τ.
    NotDescribed,
    /// The term is not among those of the fit.
    NotFitted,
    /// The coefficient has neither value nor bound.
    NoBound,
    /// No curve of rates has a minimum with an interval.
    NoMinimum,
    /// No octave of the density is flat, or there is no density.
    NoFloor,
}

impl Gap {
    /// The reason, for a limit on this.
    pub(crate) fn told(&self, of: Limited) -> String {
        let name = of.told();
        match self {
            Gap::Failed(why) => format!("there are no coefficients: {why}"),
            Gap::NotAsked => "no coefficients were fitted".to_owned(),
            Gap::NotDescribed => format!("the fit describes no range of τ and says nothing about {name}"),
            Gap::NotFitted => format!("the fit does not contain {name}"),
            Gap::NoBound => format!("the record gives neither a value nor a bound of {name}"),
            Gap::NoMinimum => "no curve has a minimum with an interval".to_owned(),
            Gap::NoFloor => "no octave of the density is flat".to_owned(),
        }
    }
}

impl<'a> Subject<'a> {
    /// A column of a log, with N of its density where that is flat.
    pub(crate) fn of_column(log: &log::Analysis, column: &'a Column, floor: Option<&'a Row>) -> Subject<'a> {
        let curve = column.curves.iter().find(|curve| !curve.deviation.is_of_angle());
        let stability =
            curve.and_then(|curve| least_or_bound(column.unit, curve.deviation, &curve.points, log.samples));
        let minimum = curve.and_then(|curve| curve.minimum).map(|minimum| minimum.point);
        // That of the whole curve may lie beyond an eighth of the record.
        let minimum = minimum.filter(|point| stability.as_ref().is_some_and(|row| row.value == point.value));
        Subject {
            label: &column.name,
            unit: column.unit,
            noise: column.noise.as_ref().map(Option::as_ref).map_err(String::as_str),
            stability,
            stability_tau_s: minimum.map(|point| point.tau_s),
            floor,
            samples: log.samples,
            step_s: log.step_s,
            spread: &column.spread,
        }
    }

    /// Length of the record, s.
    pub(crate) fn length_s(&self) -> f64 {
        self.samples as f64 * self.step_s
    }

    /// The fit, where it describes a range of the curve.
    pub(crate) fn fit(&self) -> Result<&'a Fit, Gap> {
        let sheet = self.noise.map_err(|why| Gap::Failed(why.to_owned()))?.ok_or(Gap::NotAsked)?;
        if sheet.fit.is_described() { Ok(&sheet.fit) } else { Err(Gap::NotDescribed) }
    }

    /// What the record shows of this: a row with an interval.
    pub(crate) fn shown(&self, of: Limited) -> Result<&Row, Gap> {
        let (row, without) = match of {
            Limited::Coefficient(term) => {
                self.fit()?;
                let rows = self.noise.ok().flatten().map_or(&[][..], |sheet| &sheet.rows);
                let row = rows.iter().find(|row| row.name == term.symbol()).ok_or(Gap::NotFitted)?;
                (Some(row), Gap::NoBound)
            }
            Limited::Stability => (self.stability.as_ref(), Gap::NoMinimum),
            Limited::Floor => (self.floor, Gap::NoFloor),
        };
        row.filter(|row| row.interval.is_some()).ok_or(without)
    }
}
