//! The entry of Allan-curve studies in the list of kinds.

use std::sync::Arc;

use crate::chart::{Ground, Source, Text};
use crate::key::row::Key;
use crate::kinds::allan::{Allan, columns, keys, parts, read, run, sweepable};
use crate::noise::values;
use crate::sampling::Planned;
use crate::study::{Dissected, Kind, ROW, Study, Subject};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::units::{Dimension, Quantity};
use sagnac_base::table::column::abouts;
use sagnac_kernel::allan::VERSION;
use sagnac_records::fit::choose::Terms;
use sagnac_theory::allan::terms::Term;

/// Allan curves of simulated records.
pub(crate) static ALLAN: Kind = Kind {
    name: "allan",
    subject: "The Allan curve of a gyro at rest, and the coefficients fitted to it.",
    about: "Simulates records of a gyro at rest with the noise of [noise], computes the Allan curve of each and fits the coefficients. \
            points.csv has the mean curve, `adev` over `tau`, with the band of single records, `adev_lo` to `adev_hi`; \
            coefficients.csv has the accuracy with which each coefficient is recovered: `mean`, `rmse`, `coverage95`.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 1000,
    needs: &["record", "noise"],
    keys,
    sweepable,
    columns: &[
        (Source::Points, || abouts(&columns::columns())),
        (Source::Coefficients, || abouts(&columns::coefficient_columns())),
    ],
    kernels: || format!("allan {VERSION}"),
    loads: crate::kinds::allan::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

/// Description of the bands of charts.
const BANDS: &str = "95 % of records";

impl Subject for Allan {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let plan = run::Plan::new(study, self, progress)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Dissected> {
        let (parts, points) = parts::dissected(self.points.get(point)?);
        Some(Dissected { parts, subject: Arc::new(Allan { points, ..self.clone() }) })
    }

    fn values(&self, point: usize) -> Vec<(&'static Key, Quantity)> {
        self.points.get(point).map(|point| values(&point.inputs.noise)).unwrap_or_default()
    }

    fn bytes(&self) -> u64 {
        ROW * self.points.iter().map(|point| point.ms.len() as u64).sum::<u64>()
    }

    fn grounds(&self) -> Vec<Ground> {
        vec![
            Ground {
                legend: ["mean of records", BANDS],
                ..Ground::of(Source::Points, abouts(&columns::columns()), [], &[Dimension::DriftRate])
            },
            coefficients(self.terms.as_ref()),
        ]
    }
}

/// The table of coefficients, for every kind of study that fits them.
pub(crate) fn coefficients(terms: Option<&Terms>) -> Ground {
    let shapes = Term::ALL.into_iter().filter_map(|term| Some(term.shape()?.symbol));
    let coefficients = Term::ALL.map(Term::symbol).into_iter().chain(shapes);
    let not_fitted =
        ("the chart is of coefficients, and none are fitted", "add them as in\n[allan]\nfit = \"auto\"");
    Ground {
        legend: ["Monte Carlo", BANDS],
        absent: terms.is_none().then_some(not_fitted),
        ..Ground::of(
            Source::Coefficients,
            abouts(&columns::coefficient_columns()),
            [Text::of(coefficients)],
            &[],
        )
    }
}
