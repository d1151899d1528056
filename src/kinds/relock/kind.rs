//! The entry of relock studies in the list of kinds.

use crate::chart::Source;
use crate::chart::ground::{Ground, Number, Text};
use crate::chart::law::Law;
use crate::chart::supplied::at_first;
use crate::chart::{Chart, Named, scale_over};
use crate::kernel::relock_ticks::VERSION;
use crate::key::scale::Scale;
use crate::key::sweep::Sweep;
use crate::kinds::relock::columns::{self, ALL_TICKS};
use crate::kinds::relock::inputs::Compensation;
use crate::kinds::relock::run::Plan as Planned;
use crate::kinds::relock::{RelockStudy, keys, read, sweepable};
use crate::quantity::units::Dimension;
use crate::sampling::plan::Plan;
use crate::source::diagnose::StudyError;
use crate::study::Study;
use crate::study::kind::{Kind, Look, Subject};
use crate::table::{Cell, Unit};

/// Ticks after a switch.
pub static RELOCK: Kind = Kind {
    name: "relock",
    subject: "The rotation faked by the perimeter loop after a mode switch, and what compensations leave of it.",
    about: "Samples mode switches with their errors, the perimeter loop that settles after each, and the rotation that it fakes in \
            the first ticks. points.csv has for each `compensation` and `tick` what is left of that: `mean`, `rms`, `max` and \
            `q9973`, ″.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 1_000_000,
    needs: &["gyro", "relock"],
    keys,
    sweepable,
    columns: &[(Source::Points, columns::described)],
    kernels,
    loads: crate::kinds::relock::verify::loads,
    look: Look {
        estimate: "rms",
        answer: ("rms", &[]),
        along: Some(TICK_NUMBER),
        points: "Monte Carlo",
        bands: "95 % band",
    },
    read: |reading| Ok(Box::new(read(reading)?)),
};

/// The kernel, with its version.
pub(crate) fn kernels() -> String {
    format!("relock {VERSION}")
}

const COMPENSATION: &str = "compensation";
const TICK: &str = "tick";

/// The tick as a number: blank for all together.
const TICK_NUMBER: &str = "tick_number";

impl RelockStudy {
    fn ground(&self) -> Ground {
        const NUMBERS: &[Number] =
            &[Number { name: TICK_NUMBER, unit: Unit::NONE, follows: None, chooses: false }];
        let ticks = (1..=self.inputs.relock.ticks).map(|tick| tick.to_string()).chain([ALL_TICKS.to_owned()]);
        Ground {
            texts: vec![
                Text::new(COMPENSATION, Compensation::ALL.map(Compensation::name)),
                Text { whole: Some(ALL_TICKS), ..Text::new(TICK, ticks) },
            ],
            numbers: NUMBERS,
            laws: &[Law::ZeemanTables],
            ..Ground::of(Source::Points, &[Dimension::Angle])
        }
    }
}

impl Subject for RelockStudy {
    fn plan<'a>(&'a self, study: &'a Study) -> Result<Box<dyn Plan + 'a>, StudyError> {
        Ok(Box::new(Planned::new(study, self)?))
    }

    fn grounds(&self) -> Vec<Ground> {
        vec![self.ground()]
    }

    /// The error that each compensation leaves of all ticks over the first swept key; tick by tick where nothing is swept.
    fn default_chart(&self, sweeps: &[Sweep]) -> Option<Chart> {
        let x = sweeps.first().map_or(TICK_NUMBER, |sweep| sweep.key.name);
        let series = std::iter::once(COMPENSATION).chain(sweeps.get(1).map(|sweep| sweep.key.name));
        let series = series.map(Named::default).collect();
        let all = (Named::default(TICK), Cell::Text(ALL_TICKS.to_owned()));
        let fixed = sweeps.iter().skip(2).filter_map(at_first);
        let x_scale = if sweeps.is_empty() { Scale::Linear } else { scale_over(x, sweeps, &self.ground()) };
        Some(Chart {
            rows: (!sweeps.is_empty()).then_some(all).into_iter().chain(fixed).collect(),
            x_scale,
            y_scale: Scale::Log,
            ..Chart::curves(x, RELOCK.look.estimate, series)
        })
    }

    fn boxed(&self) -> Box<dyn Subject> {
        Box::new(self.clone())
    }
}
