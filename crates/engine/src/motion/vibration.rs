//! Vibration of the base through the suspension of the gyro: its keys, its limits, and the motion that it causes.

use std::sync::Arc;

use crate::key::places::Places;
use crate::key::reading::Reading;
use crate::motion::keys::{
    ACCELERATION_DENSITIES, ALIAS, GYRO, MODE_FREQUENCY, MODE_Q, MODE_RESPONSE, MODES, RANDOM, RANDOM_PSD,
    RANDOM_RMS, SINE, SINE_ACCELERATION, SINE_FREQUENCY, SUSPENSION,
};
use crate::motion::read_psd::read_psd;
use crate::motion::suspension::SuspensionKeys;
use crate::motion::{Gaussian, Motion, Tone};
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::units::round_12;
use sagnac_base::source::diagnose::Fault;
use sagnac_theory::psd::Psd;
use sagnac_theory::suspension::Suspension;

/// A linear vibration of the base, in g, which acts on the gyro through its suspension.
#[derive(Debug, Clone, PartialEq)]
pub struct Vibration {
    /// The modes of the mount.
    pub suspension: Arc<Suspension>,
    /// Acceleration: a sine or a spectrum.
    pub acceleration: Acceleration,
    /// Whether vibration above half the tick rate may appear at lower frequencies.
    pub alias: bool,
}

/// The acceleration of the base.
#[derive(Debug, Clone, PartialEq)]
pub enum Acceleration {
    /// A sine of random phase.
    Sine {
        /// Peak acceleration, g.
        amplitude_g: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
    },
    /// Stationary Gaussian acceleration with a density, which can be scaled to a standard deviation.
    Random {
        /// One-sided density, g²/Hz.
        psd: Arc<Psd>,
        /// Standard deviation to which it is scaled, g.
        rms_g: Option<f64>,
    },
}

/// The keys of the suspension of a vibration.
pub(crate) const KEYS: SuspensionKeys = SuspensionKeys {
    table: &SUSPENSION,
    gyro: &GYRO,
    modes: &MODES,
    mode: [&MODE_FREQUENCY, &MODE_Q, &MODE_RESPONSE],
};

/// Reads the vibration, if there is one.
pub(crate) fn read(reading: &mut Reading) -> Result<Option<Vibration>, Fault> {
    let Some(table) = reading.get(&SUSPENSION) else { return Ok(None) };
    let suspension = KEYS.read(reading)?;
    let acceleration = match (reading.get(&SINE), reading.get(&RANDOM)) {
        (Some(_), None) => Acceleration::Sine {
            amplitude_g: reading.table.needed(&SINE_ACCELERATION)?.quantity()?.value,
            frequency_hz: reading.table.needed(&SINE_FREQUENCY)?.quantity()?.value,
        },
        (None, Some(_)) => Acceleration::Random {
            psd: Arc::new(read_psd(reading.table.needed(&RANDOM_PSD)?, &ACCELERATION_DENSITIES)?),
            rms_g: reading.get(&RANDOM_RMS).map(|rms| rms.quantity()).transpose()?.map(|rms| rms.value),
        },
        _ => {
            let message = "motion.suspension needs exactly one of sine, random";
            let help = format!("accepted: {}, or {}", SINE.example, RANDOM.example);
            return Err(table.fault(message, "not exactly one", help));
        }
    };
    // The table comes last, so that an error about the whole points at the first part that is written.
    reading.note(&[&GYRO, &MODES, &SINE_ACCELERATION, &SINE_FREQUENCY, &RANDOM_PSD, &SUSPENSION]);
    let alias = reading.get(&ALIAS).is_some_and(|alias| alias.flag());
    Ok(Some(Vibration { suspension, acceleration, alias }))
}

impl Vibration {
    /// Adds the resulting rotation to a motion: a sine of amplitude a gives a tone of amplitude |H|·a, and a random
    /// acceleration gives Gaussian motion with the density |H|²·S.
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

    /// Refuses vibration above half the tick rate where aliasing is not allowed, and vibration so far above it that the
    /// result would be meaningless.
    pub(crate) fn check(&self, tick_s: f64, most_tick_rates: f64, places: &Places) -> Result<(), Fault> {
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
                "motion.suspension: a vibration of {} Hz is too fast for a tick rate of {} Hz (gyro.tick = {} s)",
                number(highest),
                number(1.0 / tick_s),
                number(tick_s)
            );
            let most = number(most_tick_rates / tick_s);
            let help = format!("accepted: up to {most_tick_rates} times the tick rate, {most} Hz here");
            return places.refuse(&VIBRATION, message, "too fast for the ticks", help);
        }
        if self.alias {
            return Ok(());
        }
        let modes = self.suspension.modes().iter().map(|mode| mode.frequency_hz);
        let mode = modes.filter(|frequency_hz| *frequency_hz > nyquist).min_by(f64::total_cmp);
        let (what, place) = match mode {
            Some(mode) => {
                let names = ["motion.suspension.gyro", "motion.suspension.modes", "motion.suspension"];
                (format!("the mode of {} Hz", number(mode)), places.blame(&names))
            }
            None if highest > nyquist => {
                (format!("a vibration of {} Hz", number(highest)), places.blame(&VIBRATION))
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
