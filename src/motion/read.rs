//! Reading `[motion]`: from what is written to the motion, with every fault at its place.

use std::sync::Arc;

use toml::Spanned;

use crate::kernel::gap_fill::shape::MAX_TONES;
use crate::key::file::either::Either;
use crate::key::file::motion::{
    AmplitudeTable, Ends, GaussianTable, MotionTable, Phase, ProfileTable, ToneTable,
};
use crate::key::file::suspension::VibrationTable;
use crate::key::scalar::Scalar;
use crate::key::setting::Key;
use crate::key::sweep::Sweep;
use crate::kinds::gap_fill::keys::{ACCELERATION, AMPLITUDE, FREQUENCY, GAUSSIAN_RMS, RATE};
use crate::motion::read_psd::read_psd;
use crate::motion::vibration::{self, Acceleration, Vibration};
use crate::motion::{Amplitude, Frequency, Gaussian, Motion, Profile, Tone, Value};
use crate::quantity::units::Dimension;
use crate::record::Record;
use crate::source::diagnose::{Fault, Wrong};
use crate::source::place::Places;
use crate::source::text_file::{Files, MOST_RECORD};
use crate::theory::minimum_variance::Band;

/// What a motion may be, for messages.
const FORMS: &str = "accepted: amplitude and frequency; tones = [{ amplitude = …, frequency = … }, …]; gaussian = { rms \
                     = …, band = […] }; profile = { file = … }; suspension = { gyro = …, sine = … }; rate or acceleration";

/// The motion that is written; `files` have its record. Notes the place of each key.
pub(crate) fn read(
    written: &Spanned<MotionTable>,
    sweeps: &[Sweep],
    places: &mut Places,
    files: &Files,
) -> Result<Motion, Wrong> {
    let table = written.get_ref();
    let mut motion = Motion { tones: tones(table, places)?, ..Motion::default() };
    if let Some(gaussian) = &table.gaussian {
        places.add("motion.gaussian", gaussian.span());
        motion.gaussian = Some(read_gaussian(gaussian)?);
    }
    if let Some(suspension) = &table.suspension {
        let vibration = vibration::read(suspension, sweeps, places)?;
        check_beside(&motion, &vibration, suspension)?;
        motion.vibration = Some(vibration);
    }
    if let Some(profile) = &table.profile {
        places.add("motion.profile", profile.span());
        if !motion.tones.is_empty() || motion.gaussian.is_some() || motion.vibration.is_some() {
            let message = "motion.profile stands beside other vibration, a record is all of it";
            return Err(Fault::new(
                profile.span(),
                message,
                "besides another motion",
                "leave one of them out",
            )
            .into());
        }
        motion.profile = Some(read_profile(profile, files)?);
    }
    for (key, written, to) in [
        (&RATE, &table.rate, &mut motion.rate),
        (&ACCELERATION, &table.acceleration, &mut motion.acceleration),
    ] {
        if let Some(written) = written {
            places.add(key.name, written.span());
            *to = key.read(written)?.value;
        }
    }
    let nothing = motion == Motion::default() && table.rate.is_none() && table.acceleration.is_none();
    if nothing {
        let message = "[motion] is empty, there is no motion to fill in";
        let help = format!("{FORMS}; rate = \"0 deg/s\" for none");
        return Err(Fault::new(written.span(), message, "nothing here", help).into());
    }
    Ok(motion)
}

/// Refuses a vibration whose part of the motion is taken.
fn check_beside(
    motion: &Motion,
    vibration: &Vibration,
    written: &Spanned<VibrationTable>,
) -> Result<(), Fault> {
    let message = match vibration.acceleration {
        Acceleration::Random { .. } if motion.gaussian.is_some() => {
            "motion.suspension.random stands beside motion.gaussian".to_owned()
        }
        Acceleration::Sine { .. } if motion.tones.len() >= MAX_TONES => {
            format!("motion.suspension.sine is one tone more than the {MAX_TONES} that a motion may have")
        }
        _ => return Ok(()),
    };
    Err(Fault::new(written.span(), message, "besides another motion", "leave one of them out"))
}

fn tones(table: &MotionTable, places: &mut Places) -> Result<Vec<Tone>, Fault> {
    let MotionTable { amplitude, frequency, phase, tones, .. } = table;
    if let Some(tones) = tones {
        places.add("motion.tones", tones.span());
        let alone = [
            amplitude.as_ref().map(Spanned::span),
            frequency.as_ref().map(Spanned::span),
            phase.as_ref().map(Spanned::span),
        ];
        if let Some(span) = alone.into_iter().flatten().next() {
            let message = "motion.tones stands beside the amplitude, frequency or phase of a single tone";
            return Err(Fault::new(span, message, "besides tones", "put it into tones, or leave tones out"));
        }
        let list = tones.get_ref();
        let refuse = |message: String, label| {
            Err(Fault::new(tones.span(), message, label, format!("accepted: 1 to {MAX_TONES} tones")))
        };
        match list.len() {
            0 => return refuse("motion.tones is empty".to_owned(), "no tone"),
            count if count > MAX_TONES => {
                return refuse(
                    format!("motion.tones has {count} tones, more than {MAX_TONES}"),
                    "too many tones",
                );
            }
            _ => {}
        }
        return list
            .iter()
            .map(|tone| {
                let ToneTable { amplitude, frequency, phase } = tone.get_ref();
                read_tone("motion.tones", amplitude, frequency, phase.as_ref())
            })
            .collect();
    }
    match (amplitude, frequency) {
        (Some(amplitude), Some(frequency)) => {
            places.add(AMPLITUDE.name, amplitude.span());
            places.add(FREQUENCY.name, frequency.span());
            Ok(vec![read_tone("motion", amplitude, frequency, phase.as_ref())?])
        }
        (Some(only), None) => Err(lacking(only.span(), "motion.frequency", "frequency = \"20 Hz\"")),
        (None, Some(only)) => Err(lacking(only.span(), "motion.amplitude", "amplitude = \"12000 arcsec/s\"")),
        (None, None) => match phase {
            Some(phase) => Err(lacking(phase.span(), "motion.amplitude", "amplitude = \"12000 arcsec/s\"")),
            None => Ok(vec![]),
        },
    }
}

fn lacking(span: std::ops::Range<usize>, key: &str, example: &str) -> Fault {
    let message = format!("{key} is missing: a tone has an amplitude and a frequency");
    Fault::new(span, message, "only this one", format!("add for example {example}"))
}

fn read_tone(
    table: &str,
    amplitude: &Spanned<Either<AmplitudeTable>>,
    frequency: &Spanned<Either<Ends>>,
    phase: Option<&Spanned<Phase>>,
) -> Result<Tone, Fault> {
    let name = |key: &str| format!("{table}.{key}");
    let frequency = match frequency.get_ref() {
        Either::One(scalar) => {
            let given = Spanned::new(frequency.span(), scalar.clone());
            Frequency::Fixed(FREQUENCY.read_as(&name("frequency"), &given)?.value)
        }
        Either::Other(ends) => Frequency::Band(band(&name("frequency"), ends, frequency.span())?),
    };
    let amplitude_ = read_amplitude(&name("amplitude"), amplitude)?;
    let fixed = phase.filter(|phase| *phase.get_ref() != Phase::Uniform);
    if let (Value::Rayleigh(_), Some(phase)) = (amplitude_.value, fixed) {
        let message =
            "a Rayleigh-distributed amplitude goes with a random phase: it is narrow-band Gaussian motion";
        return Err(Fault::new(
            phase.span(),
            message,
            "a fixed phase",
            "leave the phase out, or draw the amplitude uniformly",
        ));
    }
    Ok(Tone {
        amplitude: amplitude_,
        frequency,
        phase: phase.map_or(Phase::Uniform, |phase| *phase.get_ref()),
    })
}

fn read_amplitude(name: &str, written: &Spanned<Either<AmplitudeTable>>) -> Result<Amplitude, Fault> {
    let of = |quantity: crate::quantity::units::Quantity| quantity.dimension == Dimension::Angle;
    match written.get_ref() {
        Either::One(scalar) => {
            let quantity = AMPLITUDE.read_as(name, &Spanned::new(written.span(), scalar.clone()))?;
            Ok(Amplitude { of_angle: of(quantity), value: Value::Fixed(quantity.value) })
        }
        Either::Other(AmplitudeTable { uniform: Some(ends), rayleigh: None }) => {
            let [low, high] = pair(name, &AMPLITUDE, ends.get_ref(), ends.span())?;
            Ok(Amplitude { of_angle: of(low), value: Value::Uniform([low.value, high.value]) })
        }
        Either::Other(AmplitudeTable { uniform: None, rayleigh: Some(scale) }) => {
            let quantity = AMPLITUDE.read_as(&format!("{name}.rayleigh"), scale)?;
            Ok(Amplitude { of_angle: of(quantity), value: Value::Rayleigh(quantity.value) })
        }
        Either::Other(_) => {
            let message = format!("{name} needs exactly one of uniform, rayleigh");
            let help = "accepted: \"12000 arcsec/s\", { uniform = [\"8000 arcsec/s\", \"12000 arcsec/s\"] }, \
                        { rayleigh = \"8000 arcsec/s\" }";
            Err(Fault::new(written.span(), message, "not exactly one", help))
        }
    }
}

/// Two values of a key's kind, the lower one first.
fn pair(
    name: &str,
    key: &Key,
    ends: &[Spanned<Scalar>],
    span: std::ops::Range<usize>,
) -> Result<[crate::quantity::units::Quantity; 2], Fault> {
    let [low, high] = ends else {
        let message = format!("{name} needs two ends, not {}", ends.len());
        return Err(Fault::new(span, message, "not two values", "write the lower end and the upper end"));
    };
    let [low, high] = [key.read_as(name, low)?, key.read_as(name, high)?];
    if low.dimension != high.dimension {
        let message = format!("{name} mixes a rate and an angle");
        return Err(Fault::new(span, message, "two kinds", "write both as rates, or both as angles"));
    }
    if low.value > high.value {
        let message = format!("{name} runs from {low} down to {high}");
        return Err(Fault::new(span, message, "backwards", "write the lower end first"));
    }
    Ok([low, high])
}

/// A band of frequencies.
pub(crate) fn band(name: &str, ends: &Ends, span: std::ops::Range<usize>) -> Result<Band, Fault> {
    let [low, high] = pair(name, &FREQUENCY, ends, span)?;
    Ok(Band { low_hz: low.value, high_hz: high.value })
}

fn read_gaussian(written: &Spanned<GaussianTable>) -> Result<Gaussian, Fault> {
    match written.get_ref() {
        GaussianTable { rms: Some(rms), band: Some(ends), psd: None } => Ok(Gaussian::Band {
            rms: GAUSSIAN_RMS.read(rms)?.value,
            band: band("motion.gaussian.band", ends.get_ref(), ends.span())?,
        }),
        GaussianTable { rms: None, band: None, psd: Some(psd) } => {
            Ok(Gaussian::Psd(Arc::new(read_psd("motion.gaussian.psd", psd, Dimension::RateDensity)?)))
        }
        _ => {
            let message = "motion.gaussian needs rms and band, or psd";
            let help = "accepted: { rms = \"8485 arcsec/s\", band = [\"18 Hz\", \"22 Hz\"] } or { psd = [[\"1 Hz\", \
                        \"10 (deg/s)^2/Hz\"], …] }";
            Err(Fault::new(written.span(), message, "neither of the two", help))
        }
    }
}

fn read_profile(written: &Spanned<ProfileTable>, files: &Files) -> Result<Profile, Wrong> {
    let ProfileTable { file, position } = written.get_ref();
    let path = files.path(file.get_ref());
    let text = files.text(file.get_ref(), MOST_RECORD).map_err(|error| {
        let message = format!("cannot read the record {}: {error}", path.display());
        let help = "give the path, from the folder of the study, of a record (CSV, UTF-8) with the columns \
                    `time [s]` and `rate [deg/s]`";
        Fault::new(file.span(), message, "not readable", help)
    })?;
    let record = Record::parse(&path.display().to_string(), &text)?;
    Ok(Profile { file: file.get_ref().clone(), record: Arc::new(record), position: *position })
}
