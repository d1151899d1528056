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
use sagnac_kernel::gap_fill::shape::MARGIN;
use sagnac_records::record::Record;
use sagnac_theory::double::Double;
use sagnac_theory::lines::{self, Line};
use sagnac_theory::memo::Memo;
use sagnac_theory::minimum_variance::Band;
use sagnac_theory::psd::Psd;
use sagnac_theory::quadrature::Rule;
use sagnac_theory::rows::TickRows;
use sagnac_theory::suspension::Suspension;

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

/// Caches of Gaussian motion of unit size: its rows by tick, gap and ticks on either side, for sampling, and its
/// structure by tick and number of lags, for theoretical values. The two come from quadratures of their own, so that the theory
/// checks the rows.
static ROWS: Memo<(Gaussian, f64, u32, usize), Arc<TickRows>> = Memo::new(64);
static STRUCTURES: Memo<(Gaussian, f64, usize), Arc<[Double]>> = Memo::new(128);

/// The largest distance of two ticks round a gap that fillers can read, s.
fn longest_s(tick_s: f64, gap_ticks: u32) -> f64 {
    (2 * MARGIN + gap_ticks as usize) as f64 * tick_s
}

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
        // As many as are replayed, so that there is a place for the gap: of an odd number both halves have the middle one.
        let (replayed, _) = self.replayed(tick_s);
        ticks.truncate(replayed);
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

    /// The ticks of its random part as rows, ″, with `sides` ticks on either side of a gap: all of it but a constant rate
    /// and acceleration, with phases that count as uniformly drawn. Those of a profile are of the part from which
    /// fillers are designed.
    pub fn tick_rows(&self, tick_s: f64, gap_ticks: u32, sides: usize) -> TickRows {
        let mut rows = TickRows::default();
        for tone in &self.tones {
            let lines = lines::of_ticks(&tone.lines(longest_s(tick_s, gap_ticks), Rule::Sparse), tick_s);
            let own = TickRows::of_lines(&lines, gap_ticks, sides);
            rows = rows.beside(if lines.len() > 1 { own.triangular() } else { own });
        }
        if let Some(gaussian) = &self.gaussian {
            rows = rows.beside(gaussian.tick_rows(tick_s, gap_ticks, sides));
        }
        if let Some(profile) = &self.profile {
            rows = rows.beside(profile.tick_rows(tick_s, gap_ticks, sides));
        }
        rows
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

    /// Its highest frequency, Hz; `None` for that of a vibration, which has limits of its own.
    pub(crate) fn highest_hz(&self) -> Option<f64> {
        match self {
            Gaussian::Band { band, .. } => Some(band.high_hz),
            Gaussian::Psd(psd) => psd.points().last().map(|point| point[0]),
            Gaussian::Vibration { .. } => None,
        }
    }

    /// Its ticks as rows, ″, with `sides` ticks on either side of a gap.
    pub fn tick_rows(&self, tick_s: f64, gap_ticks: u32, sides: usize) -> TickRows {
        let (unit, size) = self.unit();
        // The unit is made again only where it is not known yet: a copy for each point would cost more.
        let rows = ROWS.get((unit, tick_s, gap_ticks, sides), || {
            let lines =
                lines::of_ticks(&self.unit().0.lines(longest_s(tick_s, gap_ticks), Rule::Sparse), tick_s);
            TickRows::of_lines(&lines, gap_ticks, sides).triangular().into()
        });
        rows.as_ref().clone().scaled(size)
    }

    /// The [structure](lines::structure) of the angles at the ends of ticks, ″², at distances of 0 … `lags` − 1 ticks, and
    /// the factor that remains to be applied to it.
    pub(crate) fn structure(&self, tick_s: f64, lags: usize) -> (Arc<[Double]>, f64) {
        let (unit, size) = self.unit();
        let structure = STRUCTURES.get((unit, tick_s, lags), || {
            let lines = self.unit().0.lines(lags as f64 * tick_s, Rule::Panels);
            lines::structure(&lines::of_angles(&lines, tick_s), lags).into()
        });
        (structure, size * size)
    }

    /// This motion without its size, and the factor of its angles: what a sweep of its size leaves as it is.
    fn unit(&self) -> (Gaussian, f64) {
        match self {
            Gaussian::Band { rms, band } => (Gaussian::Band { rms: 1.0, band: *band }, *rms),
            Gaussian::Psd(_) => (self.clone(), 1.0),
            Gaussian::Vibration { suspension, acceleration, scale } => {
                let (suspension, acceleration) = (suspension.clone(), acceleration.clone());
                (Gaussian::Vibration { suspension, acceleration, scale: 1.0 }, libm::sqrt(*scale))
            }
        }
    }

    /// The lines of a motion of unit size.
    fn lines(&self, longest_s: f64, rule: Rule) -> Vec<Line> {
        match self {
            Gaussian::Band { band, .. } => band.lines(longest_s, rule),
            Gaussian::Psd(psd) => psd.lines(longest_s, rule),
            Gaussian::Vibration { suspension, acceleration, .. } => {
                suspension.lines(acceleration, longest_s, rule)
            }
        }
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

    /// Its lines, with which covariances are right to rounding up to a distance of `longest_s`.
    pub(crate) fn lines(&self, longest_s: f64, rule: Rule) -> Vec<Line> {
        let mut lines = self.band().lines(longest_s, rule);
        let square = 0.5 * self.amplitude.value.mean_square();
        for line in &mut lines {
            let factor = self.rate_factor(line.frequency_hz);
            line.power *= square * factor * factor;
        }
        lines
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
