//! Reading of `[motion]`, which reports every fault with its place.

use std::sync::Arc;

use crate::key::given::Given;
use crate::key::reading::Reading;
use crate::key::row::Key;
use crate::key::table::Table;
use crate::motion::keys::{
    ACCELERATION, AMPLITUDE, DESIGN, Design, FREQUENCY, GAUSSIAN, GAUSSIAN_BAND, GAUSSIAN_PSD, GAUSSIAN_RMS,
    INTERPOLATION, Interpolation, MOTION, OF_SEVERAL, ONE, PHASE, POSITION, PROFILE, PROFILE_FILE, Phase,
    Position, RATE, RATE_DENSITIES, TONES, ToneKeys,
};
use crate::motion::read_psd::read_psd;
use crate::motion::vibration::{self, Acceleration, Vibration};
use crate::motion::{Amplitude, Frequency, Gaussian, Motion, Profile, Tone, Value};
use sagnac_base::quantity::units::{Dimension, Quantity};
use sagnac_base::source::diagnose::{Fault, Wrong};
use sagnac_base::source::text_file::MAX_RECORD;
use sagnac_kernel::gap_fill::shape::MAX_TONES;
use sagnac_records::record::Record;
use sagnac_theory::minimum_variance::Band;

/// The accepted forms of a motion, for messages.
const FORMS: &str = "accepted: amplitude and frequency; tones = [{ amplitude = …, frequency = … }, …]; gaussian = { rms \
                     = …, band = […] }; profile = { file = … }; suspension = { gyro = …, sine = … }; rate or acceleration";

/// Reads the motion and records the place of each key.
pub(crate) fn read(reading: &mut Reading) -> Result<Motion, Wrong> {
    let mut motion = Motion { tones: tones(reading)?, ..Motion::default() };
    reading.note(&[&TONES, &AMPLITUDE, &FREQUENCY, &GAUSSIAN, &PROFILE, &RATE, &ACCELERATION]);
    motion.gaussian = reading.get(&GAUSSIAN).map(|table| gaussian(table, reading)).transpose()?;
    motion.vibration = vibration::read(reading)?;
    if let Some(vibration) = &motion.vibration {
        check_beside(&motion, vibration, reading)?;
    }
    if let Some(profile) = reading.get(&PROFILE) {
        if !motion.tones.is_empty() || motion.gaussian.is_some() || motion.vibration.is_some() {
            let message = "motion.profile excludes other vibration, as the record is the whole motion";
            return Err(profile.fault(message, "besides another motion", "leave one of them out").into());
        }
        motion.profile = Some(read_profile(reading)?);
    }
    for (key, to) in [(&RATE, &mut motion.rate), (&ACCELERATION, &mut motion.acceleration)] {
        if let Some(written) = reading.get(key) {
            *to = written.quantity()?.value;
        }
    }
    let written = [&RATE, &ACCELERATION].into_iter().any(|key| reading.get(key).is_some());
    if motion == Motion::default() && !written {
        let message = "[motion] is empty: there is no motion";
        let span = reading.table.span_of(&MOTION).unwrap_or_default();
        let help = format!("{FORMS}; rate = \"0 deg/s\" for none");
        return Err(Fault::new(span, message, "nothing here", help).into());
    }
    Ok(motion)
}

/// Refuses a vibration that conflicts with another part of the motion.
fn check_beside(motion: &Motion, vibration: &Vibration, reading: &Reading) -> Result<(), Fault> {
    let message = match vibration.acceleration {
        Acceleration::Random { .. } if motion.gaussian.is_some() => {
            "motion.suspension.random conflicts with motion.gaussian".to_owned()
        }
        Acceleration::Sine { .. } if motion.tones.len() >= MAX_TONES => {
            format!("motion.suspension.sine is one tone more than the {MAX_TONES} that a motion may have")
        }
        _ => return Ok(()),
    };
    let span = reading.table.span_of(vibration::KEYS.table).unwrap_or_default();
    Err(Fault::new(span, message, "besides another motion", "leave one of them out"))
}

fn tones(reading: &Reading) -> Result<Vec<Tone>, Fault> {
    let single = [&AMPLITUDE, &FREQUENCY, &PHASE].map(|key| reading.get(key));
    if let Some(tones) = reading.get(&TONES) {
        if let Some(single) = single.into_iter().flatten().next() {
            let message = "motion.tones conflicts with the amplitude, frequency or phase of a single tone";
            return Err(single.fault(message, "besides tones", "put it into tones, or leave tones out"));
        }
        let list = tones.items();
        let (message, label) = match list.len() {
            0 => ("motion.tones is empty".to_owned(), "no tones"),
            count if count > MAX_TONES => {
                (format!("motion.tones has {count} tones, more than {MAX_TONES}"), "too many tones")
            }
            _ => {
                let tables = list.iter().filter_map(Given::table);
                return tables.map(|table| read_tone(&table, &OF_SEVERAL)).collect();
            }
        };
        return Err(tones.fault(message, label, format!("accepted: 1 to {MAX_TONES} tones")));
    }
    match single {
        [Some(_), Some(_), _] => Ok(vec![read_tone(&reading.table, &ONE)?]),
        [Some(only), None, _] => Err(lacking(only, &FREQUENCY)),
        [None, Some(only), _] | [None, None, Some(only)] => Err(lacking(only, &AMPLITUDE)),
        [None, None, None] => Ok(vec![]),
    }
}

fn lacking(only: Given, key: &Key) -> Fault {
    let message = format!("{} is missing: a tone has an amplitude and a frequency", key.name);
    only.fault(message, "only this one", format!("add for example {}", key.example))
}

fn read_tone(table: &Table, keys: &ToneKeys) -> Result<Tone, Fault> {
    let frequency = table.needed(keys.frequency)?;
    let frequency = match frequency.is_list() {
        true => Frequency::Band(band(frequency)?),
        false => Frequency::Fixed(frequency.quantity()?.value),
    };
    let (quantity, value) = if let Some(ends) = table.get(keys.uniform) {
        let [low, high] = pair(ends)?;
        (low, Value::Uniform([low.value, high.value]))
    } else if let Some(scale) = table.get(keys.rayleigh) {
        let scale = scale.quantity()?;
        (scale, Value::Rayleigh(scale.value))
    } else {
        let amplitude = table.needed(keys.amplitude)?.quantity()?;
        (amplitude, Value::Fixed(amplitude.value))
    };
    let written = table.get(keys.phase);
    let phase = Phase::of(written);
    if let (Value::Rayleigh(_), Some(written), true) = (value, written, phase != Phase::Uniform) {
        let message =
            "a Rayleigh-distributed amplitude goes with a random phase: it is narrow-band Gaussian motion";
        let help = "leave the phase out, or draw the amplitude uniformly";
        return Err(written.fault(message, "a fixed phase", help));
    }
    let amplitude = Amplitude { of_angle: quantity.dimension == Dimension::Angle, value };
    Ok(Tone { amplitude, frequency, phase })
}

/// Reads two values, the lower one first.
fn pair(ends: Given) -> Result<[Quantity; 2], Fault> {
    let name = ends.key.name;
    let items = ends.items().iter().map(Given::quantity).collect::<Result<Vec<_>, _>>()?;
    let [low, high] = items[..] else {
        return Err(ends.fault(format!("{name} needs two ends"), "not two values", ends.key.example));
    };
    if low.dimension != high.dimension {
        let message = format!("{name} mixes a rate and an angle");
        return Err(ends.fault(message, "two kinds", "write both as rates, or both as angles"));
    }
    if low.value > high.value {
        let message = format!("{name} runs from {low} down to {high}");
        return Err(ends.fault(message, "backwards", "write the lower end first"));
    }
    Ok([low, high])
}

/// Reads a band of frequencies.
pub(crate) fn band(ends: Given) -> Result<Band, Fault> {
    let [low, high] = pair(ends)?;
    Ok(Band { low_hz: low.value, high_hz: high.value })
}

fn gaussian(table: Given, reading: &Reading) -> Result<Gaussian, Fault> {
    match [&GAUSSIAN_RMS, &GAUSSIAN_BAND, &GAUSSIAN_PSD].map(|key| reading.get(key)) {
        [Some(rms), Some(ends), None] => Ok(Gaussian::Band { rms: rms.quantity()?.value, band: band(ends)? }),
        [None, None, Some(psd)] => Ok(Gaussian::Psd(Arc::new(read_psd(psd, &RATE_DENSITIES)?))),
        _ => {
            let message = "motion.gaussian needs rms and band, or psd";
            let help =
                format!("accepted: {}, or gaussian = {{ {} }}", GAUSSIAN.example, GAUSSIAN_PSD.example);
            Err(table.fault(message, "neither of the two", help))
        }
    }
}

fn read_profile(reading: &Reading) -> Result<Profile, Wrong> {
    let file = reading.table.needed(&PROFILE_FILE)?;
    let path = reading.files.path(file.text());
    let text = reading.files.text(file.text(), MAX_RECORD).map_err(|error| {
        let message = format!("cannot read the record {}: {error}", path.display());
        let help = "give the path, from the folder of the study, of a record (CSV, UTF-8) with the columns \
                    `time [s]` and `rate [deg/s]`";
        file.fault(message, "not readable", help)
    })?;
    let record = Record::parse(&path.display().to_string(), &text)?;
    let position = Position::of(reading.get(&POSITION));
    let interpolation = Interpolation::of(reading.get(&INTERPOLATION));
    let design = Design::of(reading.get(&DESIGN));
    Ok(Profile { file: file.text().to_owned(), record: Arc::new(record), position, interpolation, design })
}
