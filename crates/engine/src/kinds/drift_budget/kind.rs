//! The entry of drift-budget studies in the list of kinds.

use std::sync::Arc;

use crate::chart::{Ground, Source};
use crate::kinds::drift_budget::columns::{self, Row};
use crate::kinds::drift_budget::parts::PARTS;
use crate::kinds::drift_budget::{DriftBudget, Point, keys, read, sweepable};
use crate::kinds::plan::{Exact, table};
use crate::sampling::Planned;
use crate::study::{self, Dissected, Kind, Study, Subject};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::units::Dimension;
use sagnac_base::table::column::abouts;

/// The bound of the drift of a gyro that switches modes, and the switching interval at which it is least.
pub(crate) static DRIFT_BUDGET: Kind = Kind {
    name: "drift-budget",
    subject: "The bound of the drift of a gyro that switches modes, and the switching interval at which it is least, in closed form.",
    about: "Samples nothing: formulas of the drift of a gyro that switches modes. points.csv has the paper's `bound`, Z(7), the \
            true drift of a run, `mean_drift` and `rms_drift`, and the intervals at which these are least, `optimum` and \
            `optimum_true`.",
    template: include_str!("template.toml"),
    is_exact: true,
    trials: 1_000_000,
    needs: &["drift", "switching", "run"],
    keys,
    sweepable,
    columns: &[(Source::Points, || abouts(&columns::columns()))],
    kernels: || "none".to_owned(),
    loads: Vec::new,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

impl Subject for DriftBudget {
    fn plan<'a>(&'a self, study: &'a Study, _: &dyn Progress) -> Planned<'a> {
        let rows: Vec<Row> = self.points.iter().map(Row::of).collect();
        Ok(Some(Box::new(Exact(table(&study.sweeps, &columns::columns(), &rows, |row| &row.point.swept)))))
    }

    fn dissected(&self, point: usize) -> Option<Dissected> {
        let point = self.points.get(point)?;
        let (parts, drifts) = study::points(&point.drift, &PARTS);
        let points = drifts.into_iter().map(|drift| Point { drift, ..point.clone() }).collect();
        Some(Dissected { parts, subject: Arc::new(DriftBudget { points }) })
    }

    fn grounds(&self) -> Vec<Ground> {
        vec![Ground {
            legend: ["", ""],
            ..Ground::of(Source::Points, abouts(&columns::columns()), [], &[Dimension::Rate, Dimension::Time])
        }]
    }
}
