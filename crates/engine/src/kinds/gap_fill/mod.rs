//! Gap-fill studies: the motion, the mode switch and the fillers to compare; their entry in the list of kinds.

pub mod columns;
pub mod inputs;
pub mod lower;
pub(crate) mod run;
pub mod verify;

use std::sync::Arc;

use crate::chart::{Law, Source, TableSchema, Text};
use crate::filler::read::{
    ERRORS, EXTRAPOLATION_TICKS, Error, FILLERS, FIT_TICKS, GAP_TICKS, OF_ONE_SWITCH, Written,
};
use crate::filler::{self, Closed, Filler, Method, Purpose, Target, TickList};
use crate::key::document::{SpanMap, SpannedValue};
use crate::key::sweep::{self, Sweep, Sweepable};
use crate::key::{self, Key, PRECISION, ParseContext};
use crate::kinds::gap_fill::inputs::{Inputs, Point, RELOCK, SETTINGS, Switch, TICK_NOISE, TickNoise};
use crate::kinds::gap_fill::run::Proven;
use crate::kinds::plan::PointsPlan;
use crate::motion::keys::{Design, GYRO as SUSPENDED_GYRO, Position, SUSPENSION, SuspensionKeys};
use crate::motion::{self, Motion, Profile};
use crate::sampling::Planned;
use crate::study::{self, Ablation, Kind, Part, ROW, Study, Subject};
use crate::{kinds, noise};
use sagnac_base::diagnostics::{Fault, Wrong};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::Dimension;
use sagnac_base::table::column::abouts;
use sagnac_kernel::gap_fill::VERSION;
use sagnac_kernel::gap_fill::shape::MAX_SIDE;
use sagnac_theory::gap::{
    noise_of_const, noise_of_const_as_published, taylor_extremum_as_published,
    taylor_zero_crossing_as_published,
};

/// The part of a study that is specific to gap filling.
#[derive(Debug, Clone)]
pub struct GapFill {
    /// Inputs before any sweep.
    pub inputs: Inputs,
    /// Fillers, one or more, each once.
    pub fillers: Vec<Filler>,
    /// Errors of the fillers to sample, each once.
    pub errors: Vec<Error>,
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<Point>,
    /// The ticks of its fillers, and where they are written.
    switch: Arc<Switch>,
}

impl GapFill {
    /// This switch at the points of other sweeps.
    ///
    /// # Errors
    /// A sweep does not apply, or the first point that is invalid.
    pub(crate) fn at_points(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<GapFill, Fault> {
        check_sweeps(&self.inputs, self.switch.has_noise, sweeps)?;
        let points = self.switch.points(&self.inputs, sweeps, places)?;
        Ok(GapFill { points, ..self.clone() })
    }

    /// Whether the fillers are judged on a specification, which has a residual only.
    pub(crate) fn is_specified(&self) -> bool {
        self.inputs.specification.is_some() && self.errors.contains(&Error::Residual)
    }
}

/// Every key of a switch and its fillers, which whole runs share.
pub(crate) fn keys_of_fill() -> Vec<&'static Key> {
    [inputs::KEYS, kinds::KEYS, motion::keys::KEYS, filler::KEYS, filler::read::KEYS, noise::KEYS].concat()
}

/// Every key of this kind.
pub(crate) fn keys() -> Vec<&'static Key> {
    [key::PRECISION_KEYS, &keys_of_fill()[..], OF_ONE_SWITCH].concat()
}

/// The keys that can be swept.
pub(crate) fn sweepable() -> Sweepable<Inputs> {
    // The gap comes last, as it does in a study.
    let (gyro, gap) = SETTINGS.split_at(SETTINGS.len() - 1);
    Sweepable::new()
        .own(gyro)
        .part(&motion::keys::SETTINGS, |inputs: &mut Inputs| Some(&mut inputs.motion))
        .own(gap)
        .name(&SUSPENDED_GYRO, |inputs: &mut Inputs, name| {
            let suspensions = inputs.motion.vibration.iter_mut().map(|vibration| &mut vibration.suspension);
            suspensions.for_each(|suspension| SuspensionKeys::set(suspension, name));
        })
}

/// Reads the part of a study that belongs to this kind.
pub(crate) fn read(reading: &mut ParseContext) -> Result<GapFill, Wrong> {
    let fillers = reading.table.needed(&FILLERS)?;
    let mut inputs = read_inputs(reading)?;
    let written_fillers = filler::read::read(fillers, inputs.specification.as_ref())?;
    let is_designed = |written: &Written| written.filler.method == Method::MinimumVariance(Target::Own);
    if let (Some(profile), false) = (&mut inputs.motion.profile, written_fillers.iter().any(is_designed)) {
        profile.design = Design::Whole;
    }
    let errors = read_errors(reading.get(&ERRORS))?;
    check_sweeps(&inputs, reading.get(&noise::NOISE).is_some(), reading.sweeps)?;
    let fillers: Vec<Filler> = written_fillers.iter().map(|written| written.filler.clone()).collect();
    let switch = Switch {
        has_noise: reading.get(&noise::NOISE).is_some(),
        fillers: written_fillers,
        fit_ticks: TickList::read(Purpose::Residual, reading.get(&FIT_TICKS))?,
        extrapolation_ticks: TickList::read(Purpose::Extrapolation, reading.get(&EXTRAPOLATION_TICKS))?,
    };
    let points = switch.points(&inputs, reading.sweeps, &reading.places)?;
    reading.notes.extend(columns::of_motion(&inputs, &points));
    reading.notes.extend(columns::mismatch_note(&points, &fillers));
    reading.notes.extend(columns::interpolation_note(&points, &fillers));
    reading.precision = key::read(&reading.table)?;
    reading.notes.extend(reading.precision.as_ref().and_then(key::finer_than_bins));
    if let (Some(_), Some(written), Some(Profile { position: Position::Every, .. })) =
        (&reading.precision, reading.get(&PRECISION), &inputs.motion.profile)
    {
        let message = "precision conflicts with position = \"every\", which is exact in whole replays only";
        let help = "leave precision out, or take position = \"random\"";
        return Err(written.fault(message, "cannot stop early", help).into());
    }
    Ok(GapFill { inputs, fillers, errors, points, switch: Arc::new(switch) })
}

/// Refuses sweeps that do not apply to the inputs; with `has_noise`, `[noise]` gives the noise.
fn check_sweeps(inputs: &Inputs, has_noise: bool, sweeps: &[Sweep]) -> Result<(), Fault> {
    for sweep in sweeps {
        if has_noise && sweep.key.table() == TICK_NOISE.name {
            let message = format!("{} is swept, but [noise] gives the noise", sweep.key.name);
            return Err(sweep.fault(message, "a second noise", "leave one of them out"));
        }
        sweep::check_applies(sweep, &inputs.motion, &motion::keys::SETTINGS, "the motion")?;
        if sweep.key.name == SUSPENDED_GYRO.name && inputs.motion.vibration.is_none() {
            let message = "motion.suspension.gyro is swept, but the motion has no suspension";
            let help = format!("add one as in\n[motion]\n{}", SUSPENSION.example);
            return Err(sweep.fault(message, "not in this study", help));
        }
    }
    Ok(())
}

/// Reads the inputs, and notes what they leave out or assume.
fn read_inputs(reading: &mut ParseContext) -> Result<Inputs, Wrong> {
    reading.table.needed(&GAP_TICKS)?;
    let motion = motion::keys::read(reading)?;
    // Each number is overwritten by its key.
    let mut inputs = Inputs {
        tick_s: 0.0,
        tick_noise: TickNoise::Std(0.0),
        readout_lsb: 0.0,
        relock: read_relock(reading.get(&RELOCK))?,
        motion,
        specification: filler::read(reading)?.map(Arc::new),
        gap_ticks: 0,
    };
    let noise = inputs::read(reading)?;
    if let Some(noise) = &noise {
        inputs::set(&mut inputs, noise);
    }
    reading.set(&mut inputs, &SETTINGS)?;
    reading.note(&[&RELOCK, &FILLERS, &FIT_TICKS, &EXTRAPOLATION_TICKS]);
    let lock_in = noise.as_ref().and_then(|noise| noise.lock_in);
    reading.notes.extend(noise::note(lock_in.map(|lock_in| (lock_in, inputs.motion.rate)).into_iter()));
    reading.notes.extend(noise.and_then(|noise| inputs::left_out(&noise, &inputs, reading.sweeps)));
    let assumed = reading.get(&SUSPENSION).and_then(|_| motion::KEYS.assumed(reading));
    reading.notes.extend(assumed);
    Ok(inputs)
}

/// Reads the angles that the relock adds to ticks.
fn read_relock(list: Option<SpannedValue>) -> Result<Vec<f64>, Fault> {
    let Some(list) = list else { return Ok(vec![]) };
    let items = list.items();
    if items.len() > MAX_SIDE {
        let message = format!("gyro.relock lists {} ticks", items.len());
        return Err(list.fault(message, "too many", format!("accepted: up to {MAX_SIDE} ticks")));
    }
    items.iter().map(|angle| Ok(angle.quantity()?.value)).collect()
}

fn read_errors(list: Option<SpannedValue>) -> Result<Vec<Error>, Fault> {
    let Some(list) = list else { return Ok(vec![Error::Residual, Error::Extrapolation]) };
    let help = "accepted: one or more of \"residual\", \"extrapolation\", \"in-gap\", each once";
    let errors = list.distinct(|item| Ok((item.to_string(), Error::from_value(Some(item)))), help)?;
    if errors.is_empty() {
        return Err(list.fault("switching.errors is empty", "no errors", help));
    }
    // The order of the kernel, so that tables do not depend on the order in the list.
    Ok(Error::ALL.into_iter().filter(|error| errors.contains(error)).collect())
}

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
    sweepable: || sweepable().keys(),
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

    fn dissected(&self, point: usize) -> Option<Ablation> {
        let (parts, points) = dissected(self.points.get(point)?);
        Some(Ablation { parts, subject: Arc::new(GapFill { points, ..self.clone() }) })
    }

    fn with_points(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<Arc<dyn Subject>, Fault> {
        Ok(Arc::new(self.at_points(sweeps, places)?))
    }

    fn bytes(&self) -> u64 {
        ROW * (self.points.len() * self.fillers.len() * self.errors.len()) as u64
    }

    fn grounds(&self) -> Vec<TableSchema> {
        let fillers = Text::new(self.fillers.iter().map(|filler| &filler.name));
        let errors = Text::new(Error::ALL.map(Error::name)).usual(Error::Residual.name());
        let columns = abouts(&columns::columns(self.is_specified()));
        vec![TableSchema {
            laws: columns::LAWS,
            is_specified: self.is_specified(),
            ..TableSchema::new(Source::Points, columns, [fillers, errors], &[Dimension::Angle])
        }]
    }
}

/// All parts, each of which adds to the ticks.
static PARTS: [Part<Inputs>; 4] = [
    Part { name: "motion", off: rest },
    Part { name: "noise of the ticks", off: |inputs| inputs.tick_noise = TickNoise::Std(0.0) },
    Part { name: "whole pulses of the readout", off: |inputs| inputs.readout_lsb = 0.0 },
    Part { name: "angles of the relock", off: |inputs| inputs.relock.clear() },
];

/// Takes away the motion, and that of the specification.
fn rest(inputs: &mut Inputs) {
    inputs.motion = Motion::default();
    inputs.specification = inputs.specification.take().map(|_| Arc::default());
}

/// A point as it is, and without each of its parts in turn; its fillers keep their weights.
pub(crate) fn dissected(point: &Point) -> (Vec<&'static str>, Vec<Point>) {
    let (names, inputs) = study::points(&point.inputs, &PARTS);
    let design = point.design.clone().or_else(|| Some(Box::new(point.inputs.clone())));
    let of = |inputs: Inputs| Point { inputs, design: design.clone(), ..point.clone() };
    (names, inputs.into_iter().map(of).collect())
}

/// Number of ticks for which the published noise law holds.
const PUBLISHED_TICKS: usize = 4;

impl Law {
    /// The value of the law for one of the errors of a filler that reads `ticks` ticks, ″; `None` where the law does
    /// not apply.
    pub fn arcsec(self, inputs: &Inputs, filler: &Filler, error: Error, ticks: usize) -> Option<f64> {
        let Method::Closed(&Closed { order: Some(order), .. }) = filler.method else { return None };
        let three_sigma = 3.0 * inputs.sigma_arcsec();
        let of_const = order == 0 && error != Error::InGap;
        let taylor = |share: fn(usize, f64) -> Option<f64>| {
            let (rate, _) = inputs.motion.single_tone()?;
            share(order, inputs.dt_nu()?).map(|share| share * rate * inputs.tick_s)
        };
        match self {
            Law::TaylorExtremum => taylor(taylor_extremum_as_published),
            Law::TaylorZeroCrossing => taylor(taylor_zero_crossing_as_published),
            Law::NoiseAsPublished => (of_const && ticks == PUBLISHED_TICKS)
                .then(|| noise_of_const_as_published(three_sigma, inputs.gap_ticks)),
            Law::ZeemanTables
            | Law::StrategicGrade
            | Law::NavigationGrade
            | Law::TacticalGrade
            | Law::ConsistentFilter => None,
            Law::Noise => of_const.then(|| noise_of_const(three_sigma, inputs.gap_ticks, ticks)),
        }
    }
}
