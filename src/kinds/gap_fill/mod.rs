//! Gap-fill studies: the motion, the mode switch and the fillers to compare.

pub mod inputs;
pub mod keys;
pub mod kind;
pub mod law;
pub mod lower;
pub mod notes;
pub mod of_noise;
pub mod point;
pub mod precision;
pub mod run;

use toml::Spanned;

pub use crate::chart::law::Law;
pub use crate::filler::{Fill, Filler, Method, POLYNOMIALS};
pub use crate::kinds::gap_fill::inputs::{Inputs, TickNoise};
pub use crate::kinds::gap_fill::point::Point;
pub use crate::kinds::gap_fill::precision::Precision;
pub use crate::motion::vibration::{Acceleration, Vibration};
pub use crate::motion::{Amplitude, Frequency, Gaussian, Motion, Profile, Tone, Value};

use crate::filler::ticks::{Purpose, TickList};
use crate::kernel::gap_fill::shape::MAX_SIDE;
use crate::key::file::motion::Position;
use crate::key::file::switching::{Error, SwitchingTable};
use crate::key::file::{StudyFile, TickNoiseTable};
use crate::key::scalar::{self, Scalar};
use crate::key::setting::{Key, Setting};
use crate::key::sweep::Sweep;
use crate::kinds::gap_fill::keys::SETTINGS;
use crate::kinds::suspension::read::assumed;
use crate::quantity::units::Dimension;
use crate::source::diagnose::{Fault, Wrong};
use crate::source::place::Places;
use crate::source::text_file::Files;
use crate::study::{needed, needed_key};

/// What a gap-fill study asks.
#[derive(Debug, Clone)]
pub struct GapFill {
    /// Before any sweep.
    pub inputs: Inputs,
    /// One or more, each once.
    pub fillers: Vec<Filler>,
    /// Which errors of them are found, each once.
    pub errors: Vec<Error>,
    /// Where sampling stops before all trials are done.
    pub precision: Option<Precision>,
    /// All points, in order; without a sweep the one that is written.
    pub points: Vec<Point>,
    /// What of the noise is left out, what of a suspension is assumed, and what motion is hardly meant, each in a sentence.
    pub notes: Vec<String>,
}

/// Every key that a sweep may vary.
pub(crate) fn keys() -> Vec<&'static Key> {
    SETTINGS.iter().map(|setting| &setting.key).chain([&crate::motion::vibration::GYRO]).collect()
}

/// Reads what is of this kind in a file, and notes where it stands.
pub(crate) fn read(
    file: &StudyFile,
    sweeps: &[Sweep],
    files: &Files,
    places: &mut Places,
) -> Result<GapFill, Wrong> {
    let table = needed(file.switching.as_ref(), "switching", file)?;
    let switching = table.get_ref();
    let fillers = needed_key(switching.fillers.as_ref(), "switching.fillers", table)?;
    if file.kind.get_ref() == "gap-fill" {
        refuse_keys_of_runs(switching)?;
    }
    let (inputs, mut notes) = read_inputs(file, sweeps, files, places)?;
    let written_fillers = crate::filler::read::read(fillers)?;
    let errors = read_errors(switching.errors.as_ref())?;
    for (sweep, table) in sweeps.iter().zip(&file.sweep) {
        if file.noise.is_some() && sweep.key.target() == "gyro.tick_noise" {
            let message = format!("{} is swept beside [noise]", sweep.key.name);
            let help = "leave one of them out";
            return Err(Fault::new(table.key.span(), message, "a second noise", help).into());
        }
        if let Some(setting) = SETTINGS.iter().find(|setting| setting.name == sweep.key.name) {
            setting.check_applies(&inputs, &SETTINGS, "the motion", table.key.span())?;
        }
        if sweep.key.name == crate::motion::vibration::GYRO.name && inputs.motion.vibration.is_none() {
            let message = "motion.suspension.gyro is swept, but the motion has no suspension";
            let help = "add one as in\n[motion.suspension]\nsine = { acceleration = \"1 g\", frequency = \"700 Hz\" }";
            return Err(Fault::new(table.key.span(), message, "not in this study", help).into());
        }
    }
    let base = crate::kinds::gap_fill::point::Base {
        inputs: inputs.clone(),
        places,
        sweeps,
        fillers: &written_fillers,
        fit_ticks: TickList::read(Purpose::Residual, switching.fit_ticks.as_ref())?,
        extrapolation_ticks: TickList::read(Purpose::Extrapolation, switching.extrapolation_ticks.as_ref())?,
    };
    let points = base.points()?;
    notes.extend(crate::kinds::gap_fill::notes::of_motion(&inputs, &points));
    let precision =
        file.precision.as_ref().map(crate::kinds::gap_fill::precision::read).transpose()?.flatten();
    notes.extend(precision.as_ref().and_then(crate::kinds::gap_fill::precision::finer_than_bins));
    if let (Some(written), Some(Profile { position: Position::Every, .. })) =
        (file.precision.as_ref().filter(|_| precision.is_some()), &inputs.motion.profile)
    {
        let message = "precision stands beside position = \"every\", which is exact in whole replays only";
        let help = "leave precision out, or take position = \"random\"";
        return Err(Fault::new(written.span(), message, "cannot stop early", help).into());
    }
    let fillers = written_fillers.into_iter().map(|written| written.filler).collect();
    Ok(GapFill { inputs, fillers, errors, precision, points, notes })
}

/// Refuses what only runs of many switches have.
fn refuse_keys_of_runs(switching: &SwitchingTable) -> Result<(), Fault> {
    let of_runs = [
        ("switching.interval", switching.interval.as_ref().map(Spanned::span)),
        ("switching.first_mode", switching.first_mode.as_ref().map(Spanned::span)),
        ("switching.timing", switching.timing.as_ref().map(Spanned::span)),
    ];
    let written = of_runs.into_iter().find_map(|(key, span)| Some((key, span?)));
    written.map_or(Ok(()), |(key, span)| {
        let message = format!("{key} is no key of a study of kind = \"gap-fill\", which is about one switch");
        Err(Fault::new(span, message, "not of this kind", "leave it out"))
    })
}

/// The inputs as written, and what they leave out or assume.
fn read_inputs(
    file: &StudyFile,
    sweeps: &[Sweep],
    files: &Files,
    places: &mut Places,
) -> Result<(Inputs, Vec<String>), Wrong> {
    let gyro = needed(file.gyro.as_ref(), "gyro", file)?.get_ref();
    let motion = needed(file.motion.as_ref(), "motion", file)?;
    let suspension = motion.get_ref().suspension.as_ref().map(Spanned::get_ref);
    let table = needed(file.switching.as_ref(), "switching", file)?;
    let switching = table.get_ref();
    let motion = crate::motion::read::read(motion, sweeps, places, files)?;
    // Each number is overwritten by its key.
    let mut inputs = Inputs {
        tick_s: 0.0,
        tick_noise: TickNoise::Std(0.0),
        readout_lsb: 0.0,
        relock: read_relock(gyro.relock.as_ref())?,
        motion,
        gap_ticks: 0,
    };
    let noise = crate::kinds::gap_fill::of_noise::read(file, gyro, files, places)?;
    if let Some(noise) = &noise {
        crate::kinds::gap_fill::of_noise::set(&mut inputs, noise);
    }
    let written = [
        Some((&crate::kinds::gap_fill::keys::TICK, &gyro.tick)),
        gyro.tick_noise.as_ref().map(noise_form).transpose()?,
        gyro.readout_lsb.as_ref().map(|lsb| (&crate::kinds::gap_fill::keys::READOUT_LSB, lsb)),
        Some((
            &crate::kinds::gap_fill::keys::GAP_TICKS,
            needed_key(switching.gap_ticks.as_ref(), "switching.gap_ticks", table)?,
        )),
    ];
    for (setting, value) in written.into_iter().flatten() {
        (setting.set)(&mut inputs, setting.read(value)?);
        places.add(setting.name, value.span());
    }
    if let Some(relock) = &gyro.relock {
        places.add("gyro.relock", relock.span());
    }
    if let Some(fillers) = &switching.fillers {
        places.add("switching.fillers", fillers.span());
    }
    for (key, list) in [
        ("switching.fit_ticks", &switching.fit_ticks),
        ("switching.extrapolation_ticks", &switching.extrapolation_ticks),
    ] {
        if let Some(list) = list {
            places.add(key, list.span());
        }
    }
    let left_out =
        noise.and_then(|noise| crate::kinds::gap_fill::of_noise::left_out(&noise, &inputs, sweeps));
    let assumed =
        suspension.and_then(|table| assumed(crate::motion::vibration::GYRO.name, &table.gyro, sweeps));
    Ok((inputs, left_out.into_iter().chain(assumed).collect()))
}

type Written<'a> = (&'static Setting<Inputs>, &'a Spanned<Scalar>);

fn noise_form(table: &Spanned<TickNoiseTable>) -> Result<Written<'_>, Fault> {
    let TickNoiseTable { std, three_sigma, angle_random_walk } = table.get_ref();
    match (std, three_sigma, angle_random_walk) {
        (Some(std), None, None) => Ok((&crate::kinds::gap_fill::keys::NOISE_STD, std)),
        (None, Some(three_sigma), None) => {
            Ok((&crate::kinds::gap_fill::keys::NOISE_THREE_SIGMA, three_sigma))
        }
        (None, None, Some(random_walk)) => {
            Ok((&crate::kinds::gap_fill::keys::NOISE_RANDOM_WALK, random_walk))
        }
        _ => {
            let help = "accepted: { std = \"0.53 arcsec\" }, \"0 arcsec\" where there is none, { three_sigma = \"1.6 arcsec\" } or \
                        { angle_random_walk = \"0.003 deg/sqrt(h)\" }";
            let message = "gyro.tick_noise needs exactly one of std, three_sigma, angle_random_walk";
            Err(Fault::new(table.span(), message, "not exactly one", help))
        }
    }
}

/// Angles that the relock adds to ticks.
fn read_relock(list: Option<&Spanned<Vec<Spanned<Scalar>>>>) -> Result<Vec<f64>, Fault> {
    let Some(list) = list else { return Ok(vec![]) };
    if list.get_ref().len() > MAX_SIDE {
        let message = format!("gyro.relock lists {} ticks", list.get_ref().len());
        return Err(Fault::new(
            list.span(),
            message,
            "too many",
            format!("accepted: up to {MAX_SIDE} ticks"),
        ));
    }
    let angle = |item: &Spanned<Scalar>| {
        let quantity = scalar::quantity("gyro.relock", item, &[Dimension::Angle])?;
        if quantity.value.abs() <= MOST_RELOCK {
            return Ok(quantity.value);
        }
        let message = format!("gyro.relock = {quantity} is out of range");
        Err(Fault::new(item.span(), message, "too large", "accepted: -1e6 to 1e6 arcsec"))
    };
    list.get_ref().iter().map(angle).collect()
}

/// Largest angle of the relock in one tick, ″.
const MOST_RELOCK: f64 = 1e6;

fn read_errors(list: Option<&Spanned<Vec<Spanned<Error>>>>) -> Result<Vec<Error>, Fault> {
    let Some(list) = list else { return Ok(vec![Error::Residual, Error::Extrapolation]) };
    let help = "accepted: one or more of \"residual\", \"extrapolation\", \"in-gap\", each once";
    if list.get_ref().is_empty() {
        return Err(Fault::new(list.span(), "switching.errors is empty", "no error", help));
    }
    let mut errors = Vec::new();
    for error in list.get_ref() {
        if errors.contains(error.get_ref()) {
            let message = format!("switching.errors lists \"{}\" twice", error.get_ref().name());
            return Err(Fault::new(error.span(), message, "listed before", help));
        }
        errors.push(*error.get_ref());
    }
    // In the order of the kernel, so that tables do not depend on how they are listed.
    Ok(Error::ALL.into_iter().filter(|error| errors.contains(error)).collect())
}
