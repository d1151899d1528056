//! The motion of the base at one point, in ″ and s.

pub mod keys;
pub(crate) mod read;
pub(crate) mod read_psd;
pub(crate) mod replay;
pub(crate) mod suspension;
pub(crate) mod vibration;

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::motion::keys::{Design, Interpolation, Phase, Position};
use crate::motion::vibration::Vibration;
use crate::record::Record;
use crate::theory::lags::Lags;
use crate::theory::memo::Memo;
use crate::theory::minimum_variance::Band;
use crate::theory::psd::Psd;
use crate::theory::suspension::Suspension;

/// The motion of the base, the sum of all its parts. The rate is that at the middle of the gap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// Tones, at most 8.
    pub tones: Vec<Tone>,
    /// Gaussian motion in addition to the tones.
    pub gaussian: Option<Gaussian>,
    /// A recorded profile, which excludes tones and Gaussian motion.
    pub profile: Option<Profile>,
    /// Vibration of the base. At a point, its tone or Gaussian motion is among the others.
    pub vibration: Option<Vibration>,
    /// Constant rate, ″/s.
    pub rate: f64,
    /// Angular acceleration, ″/s².
    pub acceleration: f64,
}

/// One sinusoidal rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Peak of the sine.
    pub amplitude: Amplitude,
    /// Frequency, fixed or drawn.
    pub frequency: Frequency,
    /// Phase at the middle of the gap.
    pub phase: Phase,
}

/// Amplitude of a tone: of its rate, ″/s, or of its angle, ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplitude {
    /// Whether it is that of the angle, ″, instead of the rate, ″/s.
    pub of_angle: bool,
    /// Value, fixed or drawn.
    pub value: Value,
}

/// A value that is fixed or drawn for each trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// One value for all trials.
    Fixed(f64),
    /// Uniformly distributed between two ends.
    Uniform([f64; 2]),
    /// Rayleigh-distributed with this scale; with a uniform phase the rate is then normal with this standard deviation.
    Rayleigh(f64),
}

/// Frequency of a tone, Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Frequency {
    /// One value for all trials.
    Fixed(f64),
    /// Drawn uniformly from a band for each trial.
    Band(Band),
}

/// Stationary Gaussian motion.
#[derive(Debug, Clone, PartialEq)]
pub enum Gaussian {
    /// Motion of a given standard deviation, spread evenly over a band.
    Band {
        /// Standard deviation of the rate, ″/s.
        rms: f64,
        /// Band, Hz.
        band: Band,
    },
    /// Motion with this one-sided power spectral density of the rate.
    Psd(Arc<Psd>),
    /// Motion through a suspension of a base whose acceleration has `scale` times this density.
    Vibration {
        /// The suspension that turns acceleration into rotation.
        suspension: Arc<Suspension>,
        /// One-sided density of the acceleration, g²/Hz.
        acceleration: Arc<Psd>,
        /// Factor by which that density is multiplied.
        scale: f64,
    },
}

/// Covariances of Gaussian motion, of which a quadrature takes as long as the rest of a point.
static COVARIANCES: Memo<(Gaussian, f64, Lags), Vec<f64>> = Memo::new(128);

/// A recorded motion to be replayed.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// File name in the study.
    pub file: String,
    /// Its samples.
    pub record: Arc<Record>,
    /// Place of the gap.
    pub position: Position,
    /// Its rate between samples.
    pub interpolation: Interpolation,
    /// Its part from which fillers are designed: the whole record where none is.
    pub design: Design,
}

impl Profile {
    /// The angle of each whole tick, ″.
    pub fn tick_angles(&self, tick_s: f64) -> Vec<f64> {
        match self.interpolation {
            Interpolation::BandLimited => self.record.band_limited_tick_angles(tick_s),
            Interpolation::Linear => self.record.tick_angles(tick_s),
        }
    }

    /// The angles of the ticks from which fillers are designed, ″.
    pub fn design_ticks(&self, tick_s: f64) -> Vec<f64> {
        let mut ticks = self.tick_angles(tick_s);
        if let (_, before @ 1..) = self.replayed(tick_s) {
            ticks.truncate(before);
        }
        ticks
    }

    /// The number of ticks that are replayed, and the number of those before them.
    pub fn replayed(&self, tick_s: f64) -> (usize, usize) {
        let count = self.record.whole_ticks(tick_s);
        let before = match self.design {
            Design::FirstHalf => count / 2,
            Design::Whole => 0,
        };
        (count - before, before)
    }
}

impl Tone {
    /// Whether the residual that a filler leaves of the tone is a sine of its phase, or normal.
    pub(crate) fn is_plain(&self) -> bool {
        let drawn = matches!(self.amplitude.value, Value::Uniform(_));
        matches!(self.frequency, Frequency::Fixed(_)) && !drawn
    }
}

impl Motion {
    /// One tone and nothing else.
    pub fn of_tone(tone: Tone) -> Motion {
        Motion { tones: vec![tone], ..Motion::default() }
    }

    /// Rate amplitude, ″/s, and frequency, Hz, where the motion has exactly one tone, of fixed amplitude and frequency,
    /// and no other random part.
    pub fn single_tone(&self) -> Option<(f64, f64)> {
        let [tone] = self.tones[..] else { return None };
        let (Value::Fixed(amplitude), Frequency::Fixed(frequency_hz)) =
            (tone.amplitude.value, tone.frequency)
        else {
            return None;
        };
        let alone = self.gaussian.is_none() && self.profile.is_none();
        alone.then(|| (amplitude * tone.rate_factor(frequency_hz), frequency_hz))
    }

    /// Standard deviation of the rate, ″/s; for a tone drawn from a band at its middle, for a profile over its ticks.
    pub fn rate_rms(&self, tick_s: f64) -> f64 {
        let mut square = 0.0;
        for tone in &self.tones {
            let band = tone.band();
            let factor = tone.rate_factor(0.5 * (band.low_hz + band.high_hz));
            square += 0.5 * tone.amplitude.value.mean_square() * factor * factor;
        }
        square += self.gaussian.as_ref().map_or(0.0, Gaussian::variance);
        if let Some(profile) = &self.profile {
            square += profile.variance(tick_s) / (tick_s * tick_s);
        }
        libm::sqrt(square)
    }

    /// Covariance of the angles of two ticks, ″², at distances 0 … `lags` − 1. A constant rate and acceleration are not
    /// part of it, and a phase counts as uniformly drawn. That of a profile is of the part from which fillers are designed.
    pub fn covariance(&self, tick_s: f64, lags: impl Into<Lags>) -> Vec<f64> {
        let lags = lags.into();
        let mut sum = vec![0.0; lags.computed];
        let mut add = |part: &[f64]| sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        for tone in &self.tones {
            add(&tone.covariance(tick_s, lags));
        }
        if let Some(gaussian) = &self.gaussian {
            add(&gaussian.covariance(tick_s, lags));
        }
        if let Some(profile) = &self.profile {
            add(&profile.covariance(tick_s, lags.computed));
        }
        sum
    }
}

impl Gaussian {
    /// Variance of the rate, (″/s)².
    pub fn variance(&self) -> f64 {
        match self {
            Gaussian::Band { rms, .. } => rms * rms,
            Gaussian::Psd(psd) => psd.variance(),
            Gaussian::Vibration { suspension, acceleration, scale } => {
                scale * suspension.variance(acceleration)
            }
        }
    }

    /// Covariance of the angles of two ticks, ″², at distances 0 … `lags` − 1.
    pub fn covariance(&self, tick_s: f64, lags: impl Into<Lags>) -> Vec<f64> {
        let lags = lags.into();
        // That of a vibration is known for all its scales together.
        let (unscaled, scale) = match self {
            Gaussian::Vibration { suspension, acceleration, scale } => {
                let (suspension, acceleration) = (suspension.clone(), acceleration.clone());
                (Gaussian::Vibration { suspension, acceleration, scale: 1.0 }, Some(scale))
            }
            other => (other.clone(), None),
        };
        let compute = || match self {
            // A sine of this rms at every frequency of the band.
            Gaussian::Band { rms, band } => band.covariance(rms * core::f64::consts::SQRT_2, tick_s, lags),
            Gaussian::Psd(psd) => psd.covariance(tick_s, lags),
            Gaussian::Vibration { suspension, acceleration, .. } => {
                suspension.covariance(acceleration, tick_s, lags)
            }
        };
        let mut covariance = COVARIANCES.get((unscaled, tick_s, lags), compute);
        if let Some(scale) = scale {
            covariance.iter_mut().for_each(|value| *value *= scale);
        }
        covariance
    }
}

impl Tone {
    /// A tone with a fixed rate amplitude, ″/s, a fixed frequency, Hz, and a random phase.
    pub fn of_rate(amplitude: f64, frequency_hz: f64) -> Tone {
        let amplitude = Amplitude { of_angle: false, value: Value::Fixed(amplitude) };
        Tone { amplitude, frequency: Frequency::Fixed(frequency_hz), phase: Phase::Uniform }
    }

    /// A tone with a fixed amplitude of the angle, ″, a fixed frequency, Hz, and a random phase.
    pub fn of_angle(amplitude: f64, frequency_hz: f64) -> Tone {
        let amplitude = Amplitude { of_angle: true, value: Value::Fixed(amplitude) };
        Tone { amplitude, frequency: Frequency::Fixed(frequency_hz), phase: Phase::Uniform }
    }

    /// The factor that converts the amplitude to that of the rate.
    pub fn rate_factor(&self, frequency_hz: f64) -> f64 {
        if self.amplitude.of_angle { TAU * frequency_hz } else { 1.0 }
    }

    /// The range of its frequencies.
    pub fn band(&self) -> Band {
        match self.frequency {
            Frequency::Fixed(nu) => Band { low_hz: nu, high_hz: nu },
            Frequency::Band(band) => band,
        }
    }

    fn covariance(&self, tick_s: f64, lags: Lags) -> Vec<f64> {
        let amplitude = libm::sqrt(self.amplitude.value.mean_square());
        let band = self.band();
        if self.amplitude.of_angle {
            band.covariance_of_angle(amplitude, tick_s, lags)
        } else {
            band.covariance(amplitude, tick_s, lags)
        }
    }
}

impl Value {
    /// The mean square over trials.
    pub fn mean_square(self) -> f64 {
        match self {
            Value::Fixed(x) => x * x,
            Value::Uniform([a, b]) => (a * a + a * b + b * b) / 3.0,
            Value::Rayleigh(scale) => 2.0 * scale * scale,
        }
    }

    /// The largest value, or the scale of a Rayleigh distribution.
    pub fn scale(self) -> f64 {
        match self {
            Value::Fixed(x) | Value::Uniform([_, x]) | Value::Rayleigh(x) => x,
        }
    }
}
