//! The entry of lock-in studies in the list of kinds.

use std::sync::Arc;

use crate::chart::{Ground, Source};
use crate::kinds::allan::columns::coefficient_columns;
use crate::kinds::allan::kind::coefficients;
use crate::kinds::lock_in::parts::PARTS;
use crate::kinds::lock_in::{LockInStudy, Point, columns, keys, read, run, sweepable};
use crate::sampling::Planned;
use crate::study::{self, Dissected, Kind, ROW, Study, Subject};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::units::Dimension;
use sagnac_base::table::column::abouts;
use sagnac_kernel::lock_in::VERSION;

/// The output of a gyro with lock-in and dither.
pub(crate) static LOCK_IN: Kind = Kind {
    name: "lock-in",
    subject: "The output of a ring laser gyro with lock-in and dither: scale factor, lock-in zones and angle random walk.",
    about: "Integrates the beat phase of many gyros with lock-in, with or without dither. points.csv has the mean output rate, \
            `mean_rate`, and the angle random walk that lock-in leaves, `angle_random_walk`, beside their closed forms where there \
            are any; with [allan], a row for each averaging time, and coefficients.csv where coefficients are fitted.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 256,
    needs: &["gyro", "lock_in", "record"],
    keys,
    sweepable,
    columns: &[
        (Source::Points, || abouts(&columns::columns())),
        (Source::Coefficients, || abouts(&coefficient_columns())),
    ],
    kernels: || format!("lock_in {VERSION}"),
    loads: crate::kinds::lock_in::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

impl Subject for LockInStudy {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let plan = run::Plan::new(study, self, progress)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Dissected> {
        let Point { swept, inputs, times } = self.points.get(point)?;
        let (parts, inputs) = study::points(inputs, &PARTS);
        let of = |inputs| Point { swept: swept.clone(), inputs, times: times.clone() };
        let points = inputs.into_iter().map(of).collect();
        Some(Dissected { parts, subject: Arc::new(LockInStudy { points, ..self.clone() }) })
    }

    fn bytes(&self) -> u64 {
        ROW * self.points.iter().map(|point| point.times.ms.len() as u64).sum::<u64>()
    }

    fn grounds(&self) -> Vec<Ground> {
        let limits = &[Dimension::ShortAngleRandomWalk, Dimension::Rate];
        vec![
            Ground::of(Source::Points, abouts(&columns::columns()), [], limits),
            coefficients(self.terms.as_ref()),
        ]
    }
}
