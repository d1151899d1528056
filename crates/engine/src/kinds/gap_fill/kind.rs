//! The entry of gap-fill studies in the list of kinds.

use std::sync::Arc;

use crate::chart::{Ground, Source, Text};
use crate::filler::read::Error;
use crate::kinds::gap_fill::run::proven::Proven;
use crate::kinds::gap_fill::{GapFill, columns, keys, parts, read, run, sweepable};
use crate::kinds::plan::PointsPlan;
use crate::sampling::Planned;
use crate::study::{Dissected, Kind, ROW, Study, Subject};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::units::Dimension;
use sagnac_base::table::column::abouts;
use sagnac_kernel::gap_fill::VERSION;

/// Errors of gap fillers at a mode switch.
pub static GAP_FILL: Kind = Kind {
    name: "gap-fill",
    subject: "The angle lost or won when the ticks missing at a mode switch are filled in.",
    about: "Samples mode switches: the motion, the noise and the readout of the ticks around each. Every filler fills in the lost \
            ticks. points.csv has for each point, filler and error the `rms`, the level `p99_73`, which \
            99.73 % of errors stay below, and the `max`, with their uncertainty, and the closed form `theory_rms` where there is one.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 1_000_000,
    needs: &["gyro", "motion", "switching"],
    keys,
    sweepable,
    columns: &[(Source::Points, columns::described)],
    kernels: || format!("gap_fill {VERSION}"),
    loads: crate::kinds::gap_fill::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

impl Subject for GapFill {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let prove = |point| Proven::new(study, self, point);
        let plan = PointsPlan::new(study, self, &self.points, |point| &point.swept, prove, progress)?;
        plan.iter().try_for_each(run::check_replays)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Dissected> {
        let (parts, points) = parts::dissected(self.points.get(point)?);
        Some(Dissected { parts, subject: Arc::new(GapFill { points, ..self.clone() }) })
    }

    fn bytes(&self) -> u64 {
        ROW * (self.points.len() * self.fillers.len() * self.errors.len()) as u64
    }

    fn grounds(&self) -> Vec<Ground> {
        let fillers = Text::of(self.fillers.iter().map(|filler| &filler.name));
        let errors = Text::of(Error::ALL.map(Error::name)).usual(Error::Residual.name());
        let columns = abouts(&columns::columns(self.is_specified()));
        vec![Ground {
            laws: columns::LAWS,
            is_specified: self.is_specified(),
            ..Ground::of(Source::Points, columns, [fillers, errors], &[Dimension::Angle])
        }]
    }
}
