//! The entry of Allan-curve studies in the list of kinds.

use crate::chart::Source;
use crate::chart::ground::{Ground, Number, Text};
use crate::chart::supplied::at_first;
use crate::chart::{Chart, Named};
use crate::fit::term::Term;
use crate::kernel::allan::VERSION;
use crate::key::scale::Scale;
use crate::key::sweep::Sweep;
use crate::kinds::allan::columns;
use crate::kinds::allan::run::Plan as Planned;
use crate::kinds::allan::{Allan, keys, read, sweepable};
use crate::quantity::units::Dimension;
use crate::sampling::plan::Plan;
use crate::source::diagnose::StudyError;
use crate::study::Study;
use crate::study::kind::{Kind, Look, Subject};
use crate::table::Unit;
use crate::table::column::abouts;

/// Allan curves of simulated records.
pub static ALLAN: Kind = Kind {
    name: "allan",
    subject: "The Allan curve of a gyro at rest, and the coefficients fitted to it.",
    about: "Makes records of a gyro at rest with the noise of [noise], takes the Allan curve of each and fits its coefficients. \
            points.csv has the mean curve, `adev` over `tau`, with the band of single records, `adev_lo` to `adev_hi`; \
            coefficients.csv how well each coefficient is found again: `mean`, `rmse`, `coverage95`.",
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
    look: Look {
        estimate: "adev",
        answer: ("adev", &[]),
        along: Some(TAU),
        points: "mean of records",
        bands: "95 % of records",
    },
    read: |reading| Ok(Box::new(read(reading)?)),
};

/// The column of averaging times.
const TAU: &str = "tau";

impl Subject for Allan {
    fn plan<'a>(&'a self, study: &'a Study) -> Result<Box<dyn Plan + 'a>, StudyError> {
        Ok(Box::new(Planned::new(study, self)?))
    }

    fn grounds(&self) -> Vec<Ground> {
        const NUMBERS: &[Number] = &[Number { name: TAU, unit: Unit::S, follows: None, chooses: true }];
        let shapes = ["markov_time", "sine_frequency"];
        let coefficients = Term::ALL.map(Term::symbol).into_iter().chain(shapes);
        let not_fitted =
            ("the chart is of coefficients, and none are fitted", "add them as in\n[allan]\nfit = \"auto\"");
        vec![
            Ground { numbers: NUMBERS, ..Ground::of(Source::Points, &[Dimension::DriftRate]) },
            Ground {
                texts: vec![Text::new("coefficient", coefficients)],
                absent: self.terms.is_none().then_some(not_fitted),
                ..Ground::of(Source::Coefficients, &[])
            },
        ]
    }

    /// The Allan deviation over τ, with a curve for each value of the first two swept keys.
    fn default_chart(&self, sweeps: &[Sweep]) -> Option<Chart> {
        let series = sweeps.iter().take(2).map(|sweep| Named::default(sweep.key.name)).collect();
        Some(Chart {
            rows: sweeps.iter().skip(2).filter_map(at_first).collect(),
            x_scale: Scale::Log,
            y_scale: Scale::Log,
            ..Chart::curves(TAU, ALLAN.look.estimate, series)
        })
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn boxed(&self) -> Box<dyn Subject> {
        Box::new(self.clone())
    }
}
