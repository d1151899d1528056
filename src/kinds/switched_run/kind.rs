//! The entry of studies of whole runs in the list of kinds.

use crate::chart::Source;
use crate::chart::ground::{Ground, Number, Text};
use crate::chart::rows::FILLER;
use crate::chart::supplied::{at_first, side_by_side};
use crate::chart::{Chart, Named, scale_over, usual_rows};
use crate::kernel::switched_run::VERSION;
use crate::key::sweep::Sweep;
use crate::kinds::relock;
use crate::kinds::switched_run::columns;
use crate::kinds::switched_run::run::Plan as Planned;
use crate::kinds::switched_run::{Angle, SwitchedRun, keys, read, sweepable};
use crate::quantity::units::Dimension;
use crate::sampling::plan::Plan;
use crate::source::diagnose::StudyError;
use crate::study::Study;
use crate::study::kind::{Kind, Look, Subject};
use crate::table::Unit;

/// Angles of whole runs.
pub static SWITCHED_RUN: Kind = Kind {
    name: "switched-run",
    subject: "The angle that a gyro which switches modes has wrong after a whole run.",
    about: "Samples whole runs of a gyro that switches modes: the magnetic drift, which turns its sign with every switch, and what \
            the switches leave. points.csv has how wrong the angle is at the end and before, `rms` and `q9973` in ″, and the same \
            over the time, `drift_rms` and `drift_q9973` in °/h. `sagnac design` finds the best interval of such a study.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 100_000,
    needs: &["switching", "run"],
    keys,
    sweepable,
    columns: &[(Source::Points, columns::described), (Source::Trajectories, columns::trajectories_described)],
    kernels: || format!("switched_run {VERSION}, {}", relock::kind::kernels()),
    loads: crate::kinds::switched_run::verify::loads,
    look: Look {
        estimate: "drift_q9973",
        answer: ("drift_q9973", &[(ANGLE, "end")]),
        along: None,
        points: "Monte Carlo",
        bands: "95 % band",
    },
    read: |reading| Ok(Box::new(read(reading)?)),
};

/// The column of angles.
const ANGLE: &str = "angle";

impl SwitchedRun {
    fn ground(&self, source: Source, text: Text) -> Ground {
        const NUMBERS: &[Number] = &[Number { name: "time", unit: Unit::S, follows: None, chooses: false }];
        let names = self.fillers().iter().map(|filler| &filler.name);
        let fillers = (!self.fillers().is_empty()).then(|| Text::new(FILLER, names));
        Ground {
            texts: fillers.into_iter().chain([text]).collect(),
            numbers: NUMBERS,
            ..Ground::of(source, &[Dimension::DriftRate, Dimension::Angle])
        }
    }

    fn points_ground(&self) -> Ground {
        let angles = Text::new(ANGLE, self.angles().iter().map(Angle::name));
        self.ground(Source::Points, Text { usual: Some(Angle::End.name()), ..angles })
    }
}

impl Subject for SwitchedRun {
    fn plan<'a>(&'a self, study: &'a Study) -> Result<Box<dyn Plan + 'a>, StudyError> {
        Ok(Box::new(Planned::new(study, self)?))
    }

    fn grounds(&self) -> Vec<Ground> {
        let runs = Text::new("run", (1..=self.trajectories).map(|number| number.to_string()));
        let none_kept =
            ("the chart is of trajectories, and none are kept", "add them as in\n[run]\ntrajectories = 20");
        let trajectories = Ground {
            // They start at 0, and their angles have both signs.
            is_linear: true,
            absent: (self.trajectories == 0).then_some(none_kept),
            ..self.ground(Source::Trajectories, runs)
        };
        vec![self.points_ground(), trajectories]
    }

    /// The drift that 99.73 % of runs stay below over the first swept key that is no name, a curve for each filler and value
    /// of the next.
    fn default_chart(&self, sweeps: &[Sweep]) -> Option<Chart> {
        let ground = self.points_ground();
        let has_fillers = !self.fillers().is_empty();
        let Some(x) = sweeps.iter().find(|sweep| !sweep.key.is_name()) else {
            return has_fillers.then(|| side_by_side(sweeps, &ground, ["drift_rms", "drift_q9973"]));
        };
        let others = || sweeps.iter().filter(|sweep| sweep.key.name != x.key.name);
        let filler = has_fillers.then(|| Named::default(FILLER));
        let keys = others().map(|sweep| Named::default(sweep.key.name));
        let series: Vec<Named> = filler.into_iter().chain(keys).take(2).collect();
        let fixed = others().filter(|sweep| series.iter().all(|named| named.name != sweep.key.name));
        Some(Chart {
            rows: fixed.filter_map(at_first).chain(usual_rows(&ground)).collect(),
            x_scale: scale_over(x.key.name, sweeps, &ground),
            ..Chart::curves(x.key.name, SWITCHED_RUN.look.estimate, series)
        })
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn boxed(&self) -> Box<dyn Subject> {
        Box::new(self.clone())
    }
}
