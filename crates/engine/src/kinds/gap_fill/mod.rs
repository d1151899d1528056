//! Gap-fill studies: the motion, the mode switch and the fillers to compare.

pub(crate) mod between;
pub mod columns;
pub mod inputs;
pub mod judged;
pub mod keys;
pub mod kind;
pub(crate) mod law;
pub mod lower;
pub(crate) mod notes;
pub(crate) mod of_noise;
pub(crate) mod parts;
pub(crate) mod played;
pub mod point;
pub(crate) mod run;
pub mod tuning;
pub mod verify;

use std::sync::Arc;

use crate::filler::read::{
    ERRORS, EXTRAPOLATION_TICKS, Error, FILLERS, FIT_TICKS, GAP_TICKS, OF_ONE_SWITCH, Written,
};
use crate::filler::{self, Filler, Method, Purpose, Target, TickList};
use crate::key::document::Given;
use crate::key::row::{self, Key, PRECISION, Reading};
use crate::key::sweep;
use crate::kinds::gap_fill::inputs::{Inputs, TickNoise};
use crate::kinds::gap_fill::keys::{RELOCK, SETTINGS, TICK_NOISE};
use crate::kinds::gap_fill::point::Point;
use crate::kinds::{self, gap_fill};
use crate::motion::keys::{Design, GYRO as SUSPENDED_GYRO, Position, SUSPENSION};
use crate::motion::{self, Profile};
use crate::noise;
use sagnac_base::source::diagnose::{Fault, Wrong};
use sagnac_kernel::gap_fill::shape::MAX_SIDE;

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
}

impl GapFill {
    /// Whether the fillers are judged on a specification, which has a residual only.
    pub(crate) fn is_specified(&self) -> bool {
        self.inputs.specification.is_some() && self.errors.contains(&Error::Residual)
    }
}

/// Every key of a switch and its fillers, which whole runs share.
pub(crate) fn keys_of_fill() -> Vec<&'static Key> {
    [gap_fill::keys::KEYS, kinds::KEYS, motion::keys::KEYS, filler::KEYS, filler::read::KEYS, noise::KEYS]
        .concat()
}

/// Every key of this kind.
pub(crate) fn keys() -> Vec<&'static Key> {
    [row::PRECISION_KEYS, &keys_of_fill()[..], OF_ONE_SWITCH].concat()
}

/// The keys that can be swept.
pub(crate) fn sweepable() -> Vec<&'static Key> {
    // The gap comes last, as it does in a study.
    let [gyro @ .., gap] = &SETTINGS;
    let gyro = gyro.iter().map(|setting| setting.key);
    gyro.chain(sweep::keys(&motion::keys::SETTINGS)).chain([gap.key, &SUSPENDED_GYRO]).collect()
}

/// Reads the part of a study that belongs to this kind.
pub(crate) fn read(reading: &mut Reading) -> Result<GapFill, Wrong> {
    let fillers = reading.table.needed(&FILLERS)?;
    let mut inputs = read_inputs(reading)?;
    let written_fillers = filler::read::read(fillers, inputs.specification.as_ref())?;
    let is_designed = |written: &Written| written.filler.method == Method::MinimumVariance(Target::Own);
    if let (Some(profile), false) = (&mut inputs.motion.profile, written_fillers.iter().any(is_designed)) {
        profile.design = Design::Whole;
    }
    let errors = read_errors(reading.get(&ERRORS))?;
    for sweep in reading.sweeps {
        if reading.get(&noise::NOISE).is_some() && sweep.key.table() == TICK_NOISE.name {
            let message = format!("{} is swept, but [noise] gives the noise", sweep.key.name);
            return Err(sweep.fault(message, "a second noise", "leave one of them out").into());
        }
        sweep::check_applies(sweep, &inputs.motion, &motion::keys::SETTINGS, "the motion")?;
        if sweep.key.name == SUSPENDED_GYRO.name && inputs.motion.vibration.is_none() {
            let message = "motion.suspension.gyro is swept, but the motion has no suspension";
            let help = format!("add one as in\n[motion]\n{}", SUSPENSION.example);
            return Err(sweep.fault(message, "not in this study", help).into());
        }
    }
    let base = point::Base {
        inputs: inputs.clone(),
        places: &reading.places,
        sweeps: reading.sweeps,
        fillers: &written_fillers,
        fit_ticks: TickList::read(Purpose::Residual, reading.get(&FIT_TICKS))?,
        extrapolation_ticks: TickList::read(Purpose::Extrapolation, reading.get(&EXTRAPOLATION_TICKS))?,
    };
    let points = base.points()?;
    let fillers: Vec<Filler> = written_fillers.into_iter().map(|written| written.filler).collect();
    reading.notes.extend(notes::of_motion(&inputs, &points));
    reading.notes.extend(judged::note(&points, &fillers));
    reading.notes.extend(between::note(&points, &fillers));
    reading.precision = row::read(&reading.table)?;
    reading.notes.extend(reading.precision.as_ref().and_then(row::finer_than_bins));
    if let (Some(_), Some(written), Some(Profile { position: Position::Every, .. })) =
        (&reading.precision, reading.get(&PRECISION), &inputs.motion.profile)
    {
        let message = "precision conflicts with position = \"every\", which is exact in whole replays only";
        let help = "leave precision out, or take position = \"random\"";
        return Err(written.fault(message, "cannot stop early", help).into());
    }
    Ok(GapFill { inputs, fillers, errors, points })
}

/// Reads the inputs, and notes what they leave out or assume.
fn read_inputs(reading: &mut Reading) -> Result<Inputs, Wrong> {
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
    let noise = of_noise::read(reading)?;
    if let Some(noise) = &noise {
        of_noise::set(&mut inputs, noise);
    }
    reading.set(&mut inputs, &SETTINGS)?;
    reading.note(&[&RELOCK, &FILLERS, &FIT_TICKS, &EXTRAPOLATION_TICKS]);
    let lock_in = noise.as_ref().and_then(|noise| noise.lock_in);
    reading.notes.extend(noise::note(lock_in.map(|lock_in| (lock_in, inputs.motion.rate)).into_iter()));
    reading.notes.extend(noise.and_then(|noise| of_noise::left_out(&noise, &inputs, reading.sweeps)));
    let assumed = reading.get(&SUSPENSION).and_then(|_| motion::KEYS.assumed(reading));
    reading.notes.extend(assumed);
    Ok(inputs)
}

/// Reads the angles that the relock adds to ticks.
fn read_relock(list: Option<Given>) -> Result<Vec<f64>, Fault> {
    let Some(list) = list else { return Ok(vec![]) };
    let items = list.items();
    if items.len() > MAX_SIDE {
        let message = format!("gyro.relock lists {} ticks", items.len());
        return Err(list.fault(message, "too many", format!("accepted: up to {MAX_SIDE} ticks")));
    }
    items.iter().map(|angle| Ok(angle.quantity()?.value)).collect()
}

fn read_errors(list: Option<Given>) -> Result<Vec<Error>, Fault> {
    let Some(list) = list else { return Ok(vec![Error::Residual, Error::Extrapolation]) };
    let help = "accepted: one or more of \"residual\", \"extrapolation\", \"in-gap\", each once";
    let errors = list.distinct(|item| Ok((item.to_string(), Error::of(Some(item)))), help)?;
    if errors.is_empty() {
        return Err(list.fault("switching.errors is empty", "no errors", help));
    }
    // The order of the kernel, so that tables do not depend on the order in the list.
    Ok(Error::ALL.into_iter().filter(|error| errors.contains(error)).collect())
}
