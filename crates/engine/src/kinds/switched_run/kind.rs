//! The entry of studies of whole runs in the list of kinds.

use std::sync::Arc;

use crate::chart::{Ground, Source, Text};
use crate::kinds::plan::PointsPlan;
use crate::kinds::relock;
use crate::kinds::switched_run::lower::LoweredRun;
use crate::kinds::switched_run::point::Point;
use crate::kinds::switched_run::run::trajectories::MAX_SHOWN;
use crate::kinds::switched_run::{Angle, SwitchedRun, columns, keys, parts, read, sweepable};
use crate::sampling::Planned;
use crate::study::{Dissected, Kind, ROW, Study, Subject};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::units::Dimension;
use sagnac_base::table::column::abouts;
use sagnac_kernel::switched_run::VERSION;

/// Studies of the angles of whole runs.
pub(crate) static SWITCHED_RUN: Kind = Kind {
    name: "switched-run",
    subject: "The error of the angle after a whole run of a gyro that switches modes.",
    about: "Samples whole runs of a gyro that switches modes: the magnetic drift, whose sign every switch reverses, and the \
            residuals of the switches. points.csv has the error of the angle at the end and at earlier times, `rms` and `p99_73` in arcsec, and \
            the same divided by the time, `drift_rms` and `drift_p99_73` in °/h. `sagnac design` finds the best interval of such a study.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 100_000,
    needs: &["switching", "run"],
    keys,
    sweepable,
    columns: &[
        (Source::Points, || abouts(&columns::columns(true))),
        (Source::Trajectories, || abouts(&columns::trajectory_columns(true))),
    ],
    kernels: || format!("switched_run {VERSION}, {}", relock::kind::kernels()),
    loads: crate::kinds::switched_run::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

/// Bytes of memory of a lowered point, and of it for each switch; of a row of trajectories.
const POINT: u64 = 5000;
const SWITCH: u64 = 110;
const MOMENT: u64 = 120;

impl Subject for SwitchedRun {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let lower = |point: &_| LoweredRun::new(point, self, study.seed, study.streams);
        let plan = PointsPlan::new(study, self, &self.points, |point| &point.swept, lower, progress)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Dissected> {
        let (parts, points) = parts::dissected(self.points.get(point)?);
        Some(Dissected { parts, subject: Arc::new(SwitchedRun { points, trajectories: 0, ..self.clone() }) })
    }

    fn only(&self, row: usize) -> Option<(Arc<dyn Subject>, usize)> {
        let angles = self.angles().len();
        let (filler, angle) = (row / angles, row % angles);
        let mut only = self.clone();
        let fill = only.fill.as_mut()?;
        fill.fillers = vec![fill.fillers.get(filler)?.clone()];
        for of_point in only.points.iter_mut().filter_map(|point| point.fill.as_mut()) {
            of_point.fills = [of_point.fills.get(filler)?.clone()].into();
        }
        Some((Arc::new(only), angle))
    }

    fn bytes(&self) -> u64 {
        let (fillers, angles) = (self.fillers().len().max(1) as u64, self.angles().len() as u64);
        let of_point = |point: &Point| {
            let shown = 2 * point.switches().min(MAX_SHOWN) + 1;
            POINT + ROW * angles + SWITCH * point.switches() + MOMENT * shown * self.trajectories
        };
        fillers * self.points.iter().map(of_point).sum::<u64>()
    }

    fn grounds(&self) -> Vec<Ground> {
        let fillers = self.fillers();
        let has_fillers = !fillers.is_empty();
        let fillers = || has_fillers.then(|| Text::of(fillers.iter().map(|filler| &filler.name))).into_iter();
        let angles = Text::of(self.angles().iter().map(Angle::name)).usual(Angle::End.name());
        let runs = Text::of((1..=self.trajectories).map(|number| number.to_string()));
        let none_kept =
            ("the chart is of trajectories, and none are kept", "add them as in\n[run]\ntrajectories = 20");
        let limits = &[Dimension::DriftRate, Dimension::Angle];
        let (points, trajectories) =
            (abouts(&columns::columns(has_fillers)), abouts(&columns::trajectory_columns(has_fillers)));
        let points = Ground::of(Source::Points, points, fillers().chain([angles]), limits);
        let trajectories = Ground {
            // Trajectories start at 0, and their angles have both signs.
            is_linear: true,
            absent: (self.trajectories == 0).then_some(none_kept),
            legend: ["single runs", points.legend[1]],
            ..Ground::of(Source::Trajectories, trajectories, fillers().chain([runs]), limits)
        };
        vec![points, trajectories]
    }
}
