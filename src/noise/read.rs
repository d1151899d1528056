//! Reading `[noise]` and the files that it names.

use std::sync::Arc;

use miette::NamedSource;
use serde::Deserialize;
use toml::Spanned;

use crate::key::file::allan::NoiseTable;
use crate::key::scalar::Scalar;
use crate::key::setting::{Key, Setting};
use crate::noise::{Noise, Switching};
use crate::quantity::units::{Dimension, Quantity};
use crate::source::diagnose::{Fault, StudyError, Text, Wrong};
use crate::source::place::Places;
use crate::source::text_file::{Files, MOST_TOML};

/// The noise of a table, and what is written in it besides a file.
pub(crate) struct WrittenNoise {
    pub(crate) noise: Noise,
    pub(crate) written: Vec<(&'static Setting<Noise>, Quantity)>,
}

/// Declares the setting of a coefficient.
macro_rules! setting {
    ($name:ident, $key:literal, $label:literal, $dimension:ident, $limits:expr, $applies:expr, $set:expr) => {
        static $name: Setting<Noise> = Setting {
            key: Key { name: $key, label: $label, accepts: &[Dimension::$dimension], limits: $limits },
            applies: $applies,
            set: $set,
        };
    };
}

/// Limits of angles and of rates, and of times.
const ANGLES: (f64, f64, &str) = (0.0, 1e6, "0 to 1e6 arcsec");
const RATES: (f64, f64, &str) = (0.0, 1e6, "0 to 1e6 deg/h");
const SIGNED_RATES: (f64, f64, &str) = (-1e6, 1e6, "-1e6 to 1e6 deg/h");
const TIMES: (f64, f64, &str) = (1e-6, 1e9, "1e-6 s to 1e9 s");

setting!(QUANTISATION, "noise.quantisation", "quantisation noise Q", Angle, ANGLES, |_| true, |noise, q| {
    noise.quantisation = q.value
});
setting!(READOUT_LSB, "noise.readout_lsb", "pulse weight", Angle, ANGLES, |_| true, |noise, lsb| noise
    .readout_lsb =
    lsb.value);
setting!(
    ANGLE_RANDOM_WALK,
    "noise.angle_random_walk",
    "angle random walk N",
    AngleRandomWalk,
    (0.0, 1e9, "0 to 1e9 arcsec/sqrt(s)"),
    |_| true,
    |noise, n| noise.angle_random_walk = n.value
);
setting!(
    BIAS_INSTABILITY,
    "noise.bias_instability",
    "bias instability B",
    DriftRate,
    RATES,
    |_| true,
    |noise, b| {
        noise.bias_instability = b.value;
    }
);
setting!(
    RATE_RANDOM_WALK,
    "noise.rate_random_walk",
    "rate random walk K",
    RateRandomWalk,
    (0.0, 1e9, "0 to 6e10 deg/h/sqrt(h)"),
    |_| true,
    |noise, k| noise.rate_random_walk = k.value
);
setting!(
    RATE_RAMP,
    "noise.rate_ramp",
    "rate ramp R",
    AngularAcceleration,
    (-1e9, 1e9, "-3.6e12 to 3.6e12 deg/h/h"),
    |_| true,
    |noise, r| noise.rate_ramp = r.value
);
setting!(
    MARKOV_AMPLITUDE,
    "noise.markov.amplitude",
    "rms of the Markov noise",
    DriftRate,
    RATES,
    |noise| noise.markov.is_some(),
    |noise, rms| noise.markov.get_or_insert_default().amplitude = rms.value
);
setting!(
    MARKOV_TIME,
    "noise.markov.time",
    "correlation time",
    Time,
    TIMES,
    |noise| noise.markov.is_some(),
    |noise, time| noise.markov.get_or_insert_default().time_s = time.value
);
setting!(
    SINE_AMPLITUDE,
    "noise.sine.amplitude",
    "peak of the sine",
    DriftRate,
    RATES,
    |noise| noise.sine.is_some(),
    |noise, peak| noise.sine.get_or_insert_default().amplitude = peak.value
);
setting!(
    SINE_FREQUENCY,
    "noise.sine.frequency",
    "frequency of the sine",
    Frequency,
    (1e-9, 1e6, "1e-9 Hz to 1e6 Hz, and at most half the sampling rate"),
    |noise| noise.sine.is_some(),
    |noise, frequency| noise.sine.get_or_insert_default().frequency_hz = frequency.value
);
setting!(
    WARM_UP_AMPLITUDE,
    "noise.warm_up.amplitude",
    "warm-up",
    DriftRate,
    SIGNED_RATES,
    |noise| noise.warm_up.is_some(),
    |noise, rate| noise.warm_up.get_or_insert_default().amplitude = rate.value
);
setting!(
    WARM_UP_TIME,
    "noise.warm_up.time",
    "time of the warm-up",
    Time,
    TIMES,
    |noise| noise.warm_up.is_some(),
    |noise, time| noise.warm_up.get_or_insert_default().time_s = time.value
);

/// Declares the setting of a key of `[noise.switching]`.
macro_rules! switching {
    ($name:ident, $key:literal, $label:literal, $dimension:ident, $limits:expr, $set:expr) => {
        setting!(
            $name,
            $key,
            $label,
            $dimension,
            $limits,
            |noise| noise.switching.is_some(),
            |noise, value| {
                let set: fn(&mut Switching, f64) = $set;
                set(noise.switching.get_or_insert_default(), value.value);
            }
        );
    };
}

switching!(INTERVAL, "noise.switching.interval", "interval between switches", Time, TIMES, |all, time| {
    all.interval_s = time
});
switching!(MAGNETIC, "noise.switching.magnetic", "magnetic drift A", DriftRate, SIGNED_RATES, |all, rate| {
    all.magnetic = rate
});
switching!(
    SWITCHING_WARM_UP,
    "noise.switching.warm_up_time",
    "time of the magnetic warm-up",
    Time,
    TIMES,
    |all, time| all.warm_up_s = Some(time)
);
switching!(
    INITIAL_MAGNETIC,
    "noise.switching.initial_magnetic",
    "magnetic drift Ω_m0 at the start",
    DriftRate,
    SIGNED_RATES,
    |all, rate| all.initial_magnetic = rate
);
switching!(RESIDUAL, "noise.switching.residual", "amplitude of fill residuals D", Angle, ANGLES, |all, d| {
    all.residual = d
});
switching!(
    RESIDUAL_NOISE,
    "noise.switching.residual_noise",
    "noise of fill residuals",
    Angle,
    ANGLES,
    |all, sigma| all.residual_noise = sigma
);

/// Every coefficient.
pub(crate) static SETTINGS: [&Setting<Noise>; 18] = [
    &QUANTISATION,
    &READOUT_LSB,
    &ANGLE_RANDOM_WALK,
    &BIAS_INSTABILITY,
    &RATE_RANDOM_WALK,
    &RATE_RAMP,
    &MARKOV_AMPLITUDE,
    &MARKOV_TIME,
    &SINE_AMPLITUDE,
    &SINE_FREQUENCY,
    &WARM_UP_AMPLITUDE,
    &WARM_UP_TIME,
    &INTERVAL,
    &MAGNETIC,
    &SWITCHING_WARM_UP,
    &INITIAL_MAGNETIC,
    &RESIDUAL,
    &RESIDUAL_NOISE,
];

/// The key of the file itself, which a sweep over gyros varies.
pub(crate) static FILE: Key =
    Key { name: "noise.file", label: "noise file", accepts: &[], limits: (0.0, 0.0, "") };

/// The noise of a table, with what the file that it names has besides; `files` have that. Notes the
/// place of each key.
pub(crate) fn read(
    table: &Spanned<NoiseTable>,
    files: &Files,
    places: &mut Places,
) -> Result<WrittenNoise, Wrong> {
    places.add("noise", table.span());
    let mut noise = match &table.get_ref().file {
        Some(file) => {
            places.add(FILE.name, file.span());
            read_file(file, files)?
        }
        None => Noise::default(),
    };
    if let Some(switching) = &table.get_ref().switching {
        places.add("noise.switching", switching.span());
    }
    let mut written = Vec::new();
    for (setting, value) in values(table.get_ref()) {
        let quantity = setting.read(value)?;
        places.add(setting.name, value.span());
        (setting.set)(&mut noise, quantity);
        written.push((setting, quantity));
    }
    Ok(WrittenNoise { noise, written })
}

/// The noise of a file, which is a `[noise]` by itself; `file` is its name where a study has it.
pub(crate) fn read_file(file: &Spanned<String>, files: &Files) -> Result<Noise, Wrong> {
    let path = files.path(file.get_ref());
    let text = files.text(file.get_ref(), MOST_TOML).map_err(|error| {
        let message = format!("cannot read the noise {}: {error}", path.display());
        let help = "name a noise.toml, from the folder of the study; `sagnac allan` writes them from records";
        Fault::new(file.span(), message, "named here", help)
    })?;
    let text: Text = Arc::new(NamedSource::new(path.display().to_string(), text.to_string()));
    parse(&text).map_err(Wrong::Elsewhere)
}

fn parse(text: &Text) -> Result<Noise, StudyError> {
    let of_text = |fault: Fault| fault.within(text);
    let toml = toml::Deserializer::parse(text.inner())
        .map_err(|error| of_text(Fault::from_syntax("the noise", &error)))?;
    let table =
        NoiseTable::deserialize(toml).map_err(|error| of_text(Fault::from_serde(&error, text.inner())))?;
    if let Some(file) = &table.file {
        let fault =
            Fault::new(file.span(), "a file of noise names another one", "here", "copy its keys instead");
        return Err(of_text(fault));
    }
    let mut noise = Noise::default();
    for (setting, value) in values(&table) {
        (setting.set)(&mut noise, setting.read(value).map_err(of_text)?);
    }
    Ok(noise)
}

/// What is written in a table.
fn values(table: &NoiseTable) -> Vec<(&'static Setting<Noise>, &Spanned<Scalar>)> {
    let markov = table.markov.as_ref().map(Spanned::get_ref);
    let sine = table.sine.as_ref().map(Spanned::get_ref);
    let warm_up = table.warm_up.as_ref().map(Spanned::get_ref);
    let switching = table.switching.as_ref().map(Spanned::get_ref);
    let all: [(&'static Setting<Noise>, Option<&Spanned<Scalar>>); 18] = [
        (&QUANTISATION, table.quantisation.as_ref()),
        (&READOUT_LSB, table.readout_lsb.as_ref()),
        (&ANGLE_RANDOM_WALK, table.angle_random_walk.as_ref()),
        (&BIAS_INSTABILITY, table.bias_instability.as_ref()),
        (&RATE_RANDOM_WALK, table.rate_random_walk.as_ref()),
        (&RATE_RAMP, table.rate_ramp.as_ref()),
        (&MARKOV_AMPLITUDE, markov.map(|markov| &markov.amplitude)),
        (&MARKOV_TIME, markov.map(|markov| &markov.time)),
        (&SINE_AMPLITUDE, sine.map(|sine| &sine.amplitude)),
        (&SINE_FREQUENCY, sine.map(|sine| &sine.frequency)),
        (&WARM_UP_AMPLITUDE, warm_up.map(|warm_up| &warm_up.amplitude)),
        (&WARM_UP_TIME, warm_up.map(|warm_up| &warm_up.time)),
        (&INTERVAL, switching.map(|switching| &switching.interval)),
        (&MAGNETIC, switching.and_then(|switching| switching.magnetic.as_ref())),
        (&SWITCHING_WARM_UP, switching.and_then(|switching| switching.warm_up_time.as_ref())),
        (&INITIAL_MAGNETIC, switching.and_then(|switching| switching.initial_magnetic.as_ref())),
        (&RESIDUAL, switching.and_then(|switching| switching.residual.as_ref())),
        (&RESIDUAL_NOISE, switching.and_then(|switching| switching.residual_noise.as_ref())),
    ];
    all.into_iter().filter_map(|(setting, value)| Some((setting, value?))).collect()
}
