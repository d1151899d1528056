//! The entry of relock studies in the list of kinds.

use std::sync::Arc;

use crate::chart::{Ground, Law, Source, Text};
use crate::kinds::plan::PointsPlan;
use crate::kinds::relock::columns::{self, ALL_TICKS};
use crate::kinds::relock::inputs::Compensation;
use crate::kinds::relock::lower::LoweredRelock;
use crate::kinds::relock::parts::PARTS;
use crate::kinds::relock::{RelockInputs, RelockPoint, RelockStudy, keys, read, sweepable};
use crate::sampling::Planned;
use crate::study::{self, Dissected, Kind, ROW, Study, Subject};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::units::Dimension;
use sagnac_base::table::column::abouts;
use sagnac_kernel::relock_ticks::VERSION;

/// Studies of the ticks after a switch.
pub static RELOCK: Kind = Kind {
    name: "relock",
    subject: "The apparent rotation caused by the path-length control loop after a mode switch, and its remainder after compensation.",
    about: "Samples mode switches with their errors, the path-length control loop that settles after each, and the apparent rotation in \
            the first ticks. points.csv has the remainder for each `compensation` and `tick`: `mean`, `rms`, `max` and \
            `p99_73`, arcsec.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 1_000_000,
    needs: &["gyro", "relock"],
    keys,
    sweepable,
    columns: &[(Source::Points, columns::described)],
    kernels,
    loads: crate::kinds::relock::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

/// The kernel, with its version.
pub(crate) fn kernels() -> String {
    format!("relock {VERSION}")
}

impl Subject for RelockStudy {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let lower = |point: &_| LoweredRelock::new(point, study.seed, study.streams);
        let plan = PointsPlan::new(study, self, &self.points, |point| &point.swept, lower, progress)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Dissected> {
        let RelockPoint { swept, inputs } = self.points.get(point)?;
        let (parts, relocks) = study::points(&inputs.relock, &PARTS);
        let of =
            |relock| RelockPoint { swept: swept.clone(), inputs: RelockInputs { relock, ..inputs.clone() } };
        let points = relocks.into_iter().map(of).collect();
        Some(Dissected { parts, subject: Arc::new(RelockStudy { points, ..self.clone() }) })
    }

    fn bytes(&self) -> u64 {
        let ticks = self.inputs.relock.ticks as u64 + 1;
        ROW * (self.points.len() * Compensation::ALL.len()) as u64 * ticks
    }

    fn grounds(&self) -> Vec<Ground> {
        let compensations = Text::of(Compensation::ALL.map(Compensation::name));
        let ticks = (1..=self.inputs.relock.ticks).map(|tick| tick.to_string()).chain([ALL_TICKS.to_owned()]);
        let ticks = Text { whole: Some(ALL_TICKS), ..Text::of(ticks) };
        let columns = abouts(&columns::columns());
        vec![Ground {
            laws: &[Law::ZeemanTables],
            ..Ground::of(Source::Points, columns, [compensations, ticks], &[Dimension::Angle])
        }]
    }
}
