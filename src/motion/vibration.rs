//! Vibration of the base through the suspension of the gyro: what it comes to as a motion, its keys, and its limits.

use std::sync::Arc;

use toml::Spanned;

use crate::key::file::suspension::VibrationTable;
use crate::key::setting::{Key, Setting};
use crate::key::sweep::Sweep;
use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::suspension::read::{GYROS, read as read_suspension};
use crate::motion::read_psd::read_psd;
use crate::motion::{Gaussian, Motion, Tone};
use crate::quantity::number::significant;
use crate::quantity::units::{Dimension, round_12};
use crate::source::diagnose::Fault;
use crate::source::place::Places;
use crate::theory::psd::Psd;
use crate::theory::suspension::Suspension;

/// A linear vibration, in g, of a base on which the gyro stands by its suspension.
#[derive(Debug, Clone, PartialEq)]
pub struct Vibration {
    /// The modes of the mount.
    pub suspension: Arc<Suspension>,
    /// A sine or a spectrum.
    pub acceleration: Acceleration,
    /// Whether what is above half the tick rate may show at lower frequencies.
    pub alias: bool,
}

/// How the base is accelerated.
#[derive(Debug, Clone, PartialEq)]
pub enum Acceleration {
    /// A sine of random phase.
    Sine {
        /// Peak, g.
        amplitude_g: f64,
        /// Hz.
        frequency_hz: f64,
    },
    /// Stationary and Gaussian, of this density in g²/Hz, scaled to a standard deviation where there is one.
    Random {
        /// One-sided, g²/Hz.
        psd: Arc<Psd>,
        /// Standard deviation to scale it to, g.
        rms_g: Option<f64>,
    },
}

pub(crate) static GYRO: Key =
    Key { name: "motion.suspension.gyro", label: "gyro", accepts: &[], limits: (0.0, 0.0, GYROS) };

pub(crate) static SINE_ACCELERATION: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.suspension.sine.acceleration",
        label: "amplitude of the acceleration",
        accepts: &[Dimension::Acceleration],
        limits: (0.0, 1e6, "0 to 1e6 g"),
    },
    applies: is_sine,
    set: |inputs, acceleration| {
        if let Some(Acceleration::Sine { amplitude_g, .. }) = acceleration_of(inputs) {
            *amplitude_g = acceleration.value;
        }
    },
};

pub(crate) static SINE_FREQUENCY: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.suspension.sine.frequency",
        label: "vibration frequency",
        accepts: &[Dimension::Frequency],
        limits: (1e-9, 1e7, "1e-9 Hz to 1e7 Hz, and at most 10 times the tick rate"),
    },
    applies: is_sine,
    set: |inputs, frequency| {
        if let Some(Acceleration::Sine { frequency_hz, .. }) = acceleration_of(inputs) {
            *frequency_hz = frequency.value;
        }
    },
};

pub(crate) static RANDOM_RMS: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.suspension.random.rms",
        label: "rms acceleration",
        accepts: &[Dimension::Acceleration],
        limits: (0.0, 1e6, "0 to 1e6 g"),
    },
    applies: |inputs| {
        let vibration = inputs.motion.vibration.as_ref();
        vibration.is_some_and(|vibration| matches!(vibration.acceleration, Acceleration::Random { .. }))
    },
    set: |inputs, rms| {
        if let Some(Acceleration::Random { rms_g, .. }) = acceleration_of(inputs) {
            *rms_g = Some(rms.value);
        }
    },
};

fn is_sine(inputs: &Inputs) -> bool {
    let vibration = inputs.motion.vibration.as_ref();
    vibration.is_some_and(|vibration| matches!(vibration.acceleration, Acceleration::Sine { .. }))
}

fn acceleration_of(inputs: &mut Inputs) -> Option<&mut Acceleration> {
    inputs.motion.vibration.as_mut().map(|vibration| &mut vibration.acceleration)
}

/// The vibration that is written.
pub(crate) fn read(
    table: &Spanned<VibrationTable>,
    sweeps: &[Sweep],
    places: &mut Places,
) -> Result<Vibration, Fault> {
    let VibrationTable { gyro, modes, sine, random, alias } = table.get_ref();
    let suspension = read_suspension(GYRO.name, gyro, modes, table.span(), sweeps)?;
    for (key, span) in [
        (GYRO.name, gyro.as_ref().map(Spanned::span)),
        ("motion.suspension.modes", modes.as_ref().map(Spanned::span)),
    ] {
        span.into_iter().for_each(|span| places.add(key, span));
    }
    let acceleration = match (sine, random) {
        (Some(sine), None) => {
            let (amplitude, frequency) = (&sine.get_ref().acceleration, &sine.get_ref().frequency);
            places.add(SINE_ACCELERATION.name, amplitude.span());
            places.add(SINE_FREQUENCY.name, frequency.span());
            Acceleration::Sine {
                amplitude_g: SINE_ACCELERATION.read(amplitude)?.value,
                frequency_hz: SINE_FREQUENCY.read(frequency)?.value,
            }
        }
        (None, Some(random)) => {
            let (psd, rms) = (&random.get_ref().psd, &random.get_ref().rms);
            places.add("motion.suspension.random.psd", psd.span());
            let key = "motion.suspension.random.psd";
            let psd = read_psd(key, psd, Dimension::AccelerationDensity)?;
            Acceleration::Random {
                psd: Arc::new(psd),
                rms_g: rms.as_ref().map(|rms| RANDOM_RMS.read(rms)).transpose()?.map(|rms| rms.value),
            }
        }
        _ => {
            let message = "motion.suspension needs exactly one of sine, random";
            let help = "accepted: sine = { acceleration = \"1 g\", frequency = \"700 Hz\" }, or random = { psd = \
                        [[\"20 Hz\", \"0.01 g^2/Hz\"], [\"2000 Hz\", \"0.01 g^2/Hz\"]] }";
            return Err(Fault::new(table.span(), message, "not exactly one", help));
        }
    };
    // Behind its parts: for an error about the whole of it the first that is written is pointed at.
    places.add("motion.suspension", table.span());
    Ok(Vibration { suspension, acceleration, alias: alias.as_ref().is_some_and(|alias| *alias.get_ref()) })
}

impl Vibration {
    /// Adds what the gyro turns to a motion: |H|·a of a sine is a tone, a random acceleration is Gaussian motion of the
    /// density |H|²·S.
    pub(crate) fn add_to(&self, motion: &mut Motion) {
        match &self.acceleration {
            Acceleration::Sine { amplitude_g, frequency_hz } => {
                let amplitude = self.suspension.response(*frequency_hz).amplitude() * amplitude_g;
                motion.tones.push(Tone::of_rate(round_12(amplitude), *frequency_hz));
            }
            Acceleration::Random { psd, rms_g } => {
                let scale = rms_g.map_or(1.0, |rms_g| round_12(rms_g * rms_g / psd.variance()));
                let (suspension, acceleration) = (self.suspension.clone(), psd.clone());
                motion.gaussian = Some(Gaussian::Vibration { suspension, acceleration, scale });
            }
        }
    }

    /// The highest frequency of the acceleration, Hz.
    fn highest_hz(&self) -> f64 {
        match &self.acceleration {
            Acceleration::Sine { frequency_hz, .. } => *frequency_hz,
            Acceleration::Random { psd, .. } => psd.points().last().map_or(0.0, |point| point[0]),
        }
    }

    /// What of it lies above half the tick rate without that being allowed, or so far above it that nothing could be said
    /// of it.
    pub(crate) fn check(
        &self,
        tick_s: f64,
        most_tick_rates: f64,
        places: &Places,
        sweeps: &[Sweep],
    ) -> Result<(), Fault> {
        const VIBRATION: [&str; 4] = [
            "motion.suspension.sine.frequency",
            "motion.suspension.random.psd",
            "motion.suspension",
            "gyro.tick",
        ];
        let number = |x: f64| significant(x, 6);
        let nyquist = 0.5 / tick_s;
        let highest = self.highest_hz();
        if highest * tick_s > most_tick_rates {
            let message = format!(
                "motion.suspension: a vibration of {} Hz is absurd at a tick rate of {} Hz (gyro.tick = {} s)",
                number(highest),
                number(1.0 / tick_s),
                number(tick_s)
            );
            let most = number(most_tick_rates / tick_s);
            let help = format!("accepted: up to {most_tick_rates} times the tick rate, {most} Hz here");
            return Err(Fault::new(
                places.blame(sweeps, &VIBRATION),
                message,
                "too fast for the ticks",
                help,
            ));
        }
        if self.alias {
            return Ok(());
        }
        let modes = self.suspension.modes().iter().map(|mode| mode.frequency_hz);
        let mode = modes.filter(|frequency_hz| *frequency_hz > nyquist).min_by(f64::total_cmp);
        let (what, place) = match mode {
            Some(mode) => {
                let names = ["motion.suspension.gyro", "motion.suspension.modes", "motion.suspension"];
                (format!("the mode of {} Hz", number(mode)), places.blame(sweeps, &names))
            }
            None if highest > nyquist => {
                (format!("a vibration of {} Hz", number(highest)), places.blame(sweeps, &VIBRATION))
            }
            None => return Ok(()),
        };
        let (nyquist, tick) = (number(nyquist), number(tick_s));
        let message = format!(
            "motion.suspension: {what} is above {nyquist} Hz, the Nyquist frequency of ticks of {tick} s"
        );
        let help = format!(
            "add alias = true to motion.suspension: what is above {nyquist} Hz then shows in the ticks at a lower frequency, \
             as it does in those of a gyro; or take a shorter gyro.tick"
        );
        Err(Fault::new(place, message, "would be aliased", help))
    }
}
