//! The entry of suspension studies in the list of kinds.

use std::sync::Arc;

use crate::chart::{Ground, Source};
use crate::kinds::plan::{Exact, table};
use crate::kinds::suspension::{SuspensionStudy, columns, keys, read, sweepable};
use crate::sampling::Planned;
use crate::study::{Kind, Study, Subject};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::units::Dimension;
use sagnac_base::table::column::abouts;

/// The rotation of a gyro on its suspension under vibration.
pub(crate) static SUSPENSION: Kind = Kind {
    name: "suspension",
    subject: "The rotation of a gyro on its suspension under vibration, in closed form.",
    about: "Samples nothing: the response of an elastic suspension to a vibration of its base. points.csv has `response`, the rate \
            divided by the acceleration, and its `phase` at each swept frequency.",
    template: include_str!("template.toml"),
    is_exact: true,
    trials: 1_000_000,
    needs: &["suspension"],
    keys,
    sweepable,
    columns: &[(Source::Points, || abouts(&columns::columns()))],
    kernels: || "none".to_owned(),
    loads: Vec::new,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

impl Subject for SuspensionStudy {
    fn plan<'a>(&'a self, study: &'a Study, _: &dyn Progress) -> Planned<'a> {
        let table = table(&study.sweeps, &columns::columns(), &self.points, |point| &point.swept);
        Ok(Some(Box::new(Exact(table))))
    }

    fn grounds(&self) -> Vec<Ground> {
        vec![Ground {
            legend: ["", ""],
            ..Ground::of(Source::Points, abouts(&columns::columns()), [], &[Dimension::RatePerAcceleration])
        }]
    }
}
