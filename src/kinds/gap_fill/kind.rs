//! The entry of gap-fill studies in the list of kinds.

use crate::chart::Source;
use crate::chart::ground::{Ground, Number, Text};
use crate::chart::rows::FILLER;
use crate::chart::supplied::{at_first, side_by_side};
use crate::chart::{Chart, Named, scale_over, usual_rows};
use crate::filler::keys::Error;
use crate::kernel::gap_fill::VERSION;
use crate::key::sweep::Sweep;
use crate::kinds::gap_fill::columns;
use crate::kinds::gap_fill::run::Plan as Planned;
use crate::kinds::gap_fill::{GapFill, keys, read, sweepable};
use crate::motion::keys::FREQUENCY;
use crate::quantity::units::Dimension;
use crate::sampling::plan::Plan;
use crate::source::diagnose::StudyError;
use crate::study::Study;
use crate::study::kind::{Kind, Look, Subject};
use crate::table::Unit;

/// Errors of gap fillers at a mode switch.
pub static GAP_FILL: Kind = Kind {
    name: "gap-fill",
    subject: "The angle lost or won when the ticks missing at a mode switch are filled in.",
    about: "Samples mode switches: the motion, the noise and the readout of the ticks around each, of which those that are lost are \
            filled in by every filler. points.csv has for each point, filler and error the `rms`, the level `q9973` that 99.73 % \
            of errors stay below and the `max`, with their uncertainty, and the closed form `oracle_rms` where there is one.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 1_000_000,
    needs: &["gyro", "motion", "switching"],
    keys,
    sweepable,
    columns: &[(Source::Points, columns::described)],
    kernels: || format!("gap_fill {VERSION}"),
    loads: crate::kinds::gap_fill::verify::loads,
    look: Look {
        estimate: "rms",
        answer: ("q9973", &[(ERROR, "residual")]),
        along: None,
        points: "Monte Carlo",
        bands: "95 % band",
    },
    read: |reading| Ok(Box::new(read(reading)?)),
};

/// The column of errors.
const ERROR: &str = "error";

/// The column of Δt·ν.
const DT_NU: &str = "dt_nu";

const NUMBERS: &[Number] = &[
    Number { name: DT_NU, unit: Unit::NONE, follows: Some(FREQUENCY.name), chooses: false },
    Number { name: "amplitude_noise", unit: Unit::NONE, follows: None, chooses: false },
];

impl GapFill {
    fn ground(&self) -> Ground {
        let errors = Text {
            usual: Some(Error::Residual.name().to_owned()),
            ..Text::new(ERROR, Error::ALL.map(Error::name))
        };
        Ground {
            texts: vec![Text::new(FILLER, self.fillers.iter().map(|filler| &filler.name)), errors],
            numbers: NUMBERS,
            laws: columns::LAWS,
            ..Ground::of(Source::Points, &[Dimension::Angle])
        }
    }
}

impl Subject for GapFill {
    fn plan<'a>(&'a self, study: &'a Study) -> Result<Box<dyn Plan + 'a>, StudyError> {
        Ok(Box::new(Planned::new(study, self)?))
    }

    fn grounds(&self) -> Vec<Ground> {
        vec![self.ground()]
    }

    /// Over Δt·ν if the frequency is swept, else over the first swept key that is no name, else side by side.
    fn default_chart(&self, sweeps: &[Sweep]) -> Option<Chart> {
        let ground = self.ground();
        let mut names: Vec<&str> = sweeps.iter().map(|sweep| sweep.key.name).collect();
        let frequency = names.iter().position(|name| *name == FREQUENCY.name);
        let Some(swept) = frequency.or_else(|| sweeps.iter().position(|sweep| !sweep.key.is_name())) else {
            return Some(side_by_side(sweeps, &ground, ["rms", "q9973"]));
        };
        let name = names.remove(swept);
        let x = if frequency.is_some() { DT_NU } else { name };
        let series = std::iter::once(FILLER).chain(names.first().copied()).map(Named::default).collect();
        let fixed = names.iter().skip(1);
        let fixed = fixed.filter_map(|name| at_first(sweeps.iter().find(|sweep| sweep.key.name == *name)?));
        Some(Chart {
            rows: fixed.chain(usual_rows(&ground)).collect(),
            x_scale: scale_over(x, sweeps, &ground),
            ..Chart::curves(x, GAP_FILL.look.estimate, series)
        })
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn has_stop_rule(&self) -> bool {
        self.precision.is_some()
    }

    fn drop_stop_rule(&mut self) {
        self.precision = None;
    }

    fn boxed(&self) -> Box<dyn Subject> {
        Box::new(self.clone())
    }
}
