//! The noise of a gyro by its coefficients, as given by `[noise]` and noise.toml.

pub(crate) mod keys;
pub(crate) mod read;

use crate::theory::allan::part::Part;
use crate::theory::allan::process::Process;
use crate::theory::allan::{holds, switching};
use crate::theory::drift::magnetic::Magnetic;

/// Noise coefficients in ″ and s; 0 means absent.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Noise {
    /// Quantisation noise Q, ″.
    pub quantisation: f64,
    /// Angle of a pulse where whole pulses are read, ″.
    pub readout_lsb: f64,
    /// Angle random walk N, ″/√s.
    pub angle_random_walk: f64,
    /// Bias instability B, ″/s.
    pub bias_instability: f64,
    /// Rate random walk K, ″/s^1.5.
    pub rate_random_walk: f64,
    /// Rate ramp R, ″/s².
    pub rate_ramp: f64,
    /// Exponentially correlated noise of the rate.
    pub markov: Option<Markov>,
    /// Sine of the rate with a random phase.
    pub sine: Option<Sine>,
    /// Warm-up, the same in all records.
    pub warm_up: Option<WarmUp>,
    /// Switching, of a gyro that switches modes.
    pub switching: Option<Switching>,
}

/// Exponentially correlated noise of the rate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Markov {
    /// Rms of the rate, ″/s.
    pub amplitude: f64,
    /// Correlation time T_c, s.
    pub time_s: f64,
}

/// A sine of the rate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sine {
    /// Peak of the rate, ″/s.
    pub amplitude: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

/// A decay of the rate from the start of the record.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WarmUp {
    /// Rate at the start, ″/s.
    pub amplitude: f64,
    /// Time in which the rate falls to 1/e, s.
    pub time_s: f64,
}

/// A gyro that switches modes from the start of the record; 0 means absent.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Switching {
    /// Requested interval, s; records switch after the nearest whole number of samples.
    pub interval_s: f64,
    /// Magnetic drift A, ″/s.
    pub magnetic: f64,
    /// Time constant of the warm-up τ, s; without it, the magnetic drift is A + Ω_m0 from the start.
    pub warm_up_s: Option<f64>,
    /// Initial magnetic drift Ω_m0, ″/s.
    pub initial_magnetic: f64,
    /// Amplitude of the fill residuals D, ″.
    pub residual: f64,
    /// Standard deviation of the noise in fill residuals, ″.
    pub residual_noise: f64,
}

impl Switching {
    /// Whether a switch has no effect.
    pub(crate) fn is_nothing(&self) -> bool {
        [self.magnetic, self.initial_magnetic, self.residual, self.residual_noise].iter().all(|x| *x == 0.0)
    }

    /// Samples of `sample_s` from one switch to the next.
    pub fn interval(&self, sample_s: f64) -> u64 {
        libm::round(self.interval_s / sample_s) as u64
    }

    /// Bound of |Ω_m|, which goes from Ω_m0 to A + Ω_m0, ″/s.
    fn largest_rate(&self) -> f64 {
        self.initial_magnetic.abs().max((self.magnetic + self.initial_magnetic).abs())
    }

    /// Rms of the fill residual of a switch, D sin φ plus noise, ″.
    fn residual_rms(&self) -> f64 {
        libm::sqrt(0.5 * self.residual * self.residual + self.residual_noise * self.residual_noise)
    }

    /// A, τ and Ω_m0; without a warm-up all of it is in Ω_m0.
    fn drift(&self) -> Magnetic {
        match self.warm_up_s {
            Some(time_s) => Magnetic { amplitude: self.magnetic, time_s, initial: self.initial_magnetic },
            None => Magnetic { amplitude: 0.0, time_s: 1.0, initial: self.magnetic + self.initial_magnetic },
        }
    }
}

impl Noise {
    /// The switches of records with samples of `sample_s`; `None` where they have no effect.
    pub fn switched(&self, sample_s: f64) -> Option<switching::Switching> {
        let switching = self.switching.filter(|switching| !switching.is_nothing())?;
        Some(switching::Switching {
            interval: switching.interval(sample_s),
            magnetic: switching.drift(),
            residual: switching.residual,
            residual_noise: switching.residual_noise,
        })
    }

    /// The process of records of `samples` rates, each `sample_s` long, without readout and switches, for which there
    /// is no [`Part`].
    ///
    /// Records too long for the octaves of flicker get the largest number; they are refused elsewhere.
    pub fn process(&self, sample_s: f64, samples: u64) -> Process {
        let octaves = holds::octaves(samples).unwrap_or(holds::MOST_OCTAVES);
        let some = |value: f64, part: Part| (value != 0.0).then_some(part);
        let parts = [
            some(self.quantisation, Part::Quantisation { q: self.quantisation }),
            some(self.angle_random_walk, Part::AngleRandomWalk { n: self.angle_random_walk }),
            some(self.bias_instability, Part::BiasInstability { b: self.bias_instability, octaves }),
            some(self.rate_random_walk, Part::RateRandomWalk { k: self.rate_random_walk }),
            self.markov.and_then(|Markov { amplitude, time_s }| {
                some(amplitude, Part::Markov { q_c: amplitude * libm::sqrt(2.0 / time_s), time_s })
            }),
            self.sine.and_then(|Sine { amplitude, frequency_hz }| {
                some(amplitude, Part::Sine { amplitude, frequency_hz })
            }),
            some(self.rate_ramp, Part::RateRamp { r: self.rate_ramp }),
            self.warm_up
                .and_then(|WarmUp { amplitude, time_s }| some(amplitude, Part::WarmUp { amplitude, time_s })),
        ];
        Process { sample_s, parts: parts.into_iter().flatten().collect() }
    }

    /// The inputs that determine the draws, key by key in base units; absent parts have no line.
    pub(crate) fn canonical(&self) -> String {
        let with = |is: bool, value: f64| if is { value } else { 0.0 };
        let [markov, sine, warm_up] = [
            self.markov.map_or([0.0; 2], |m| [m.amplitude, with(m.amplitude != 0.0, m.time_s)]),
            self.sine.map_or([0.0; 2], |s| [s.amplitude, with(s.amplitude != 0.0, s.frequency_hz)]),
            self.warm_up.map_or([0.0; 2], |w| [w.amplitude, with(w.amplitude != 0.0, w.time_s)]),
        ];
        let switching = self.switching.filter(|switching| !switching.is_nothing()).unwrap_or_default();
        let all = [
            ("angle_random_walk", self.angle_random_walk),
            ("bias_instability", self.bias_instability),
            ("markov.amplitude", markov[0]),
            ("markov.time", markov[1]),
            ("quantisation", self.quantisation),
            ("rate_ramp", self.rate_ramp),
            ("rate_random_walk", self.rate_random_walk),
            ("readout_lsb", self.readout_lsb),
            ("sine.amplitude", sine[0]),
            ("sine.frequency", sine[1]),
            ("switching.initial_magnetic", switching.initial_magnetic),
            ("switching.interval", switching.interval_s),
            ("switching.magnetic", switching.magnetic),
            ("switching.residual", switching.residual),
            ("switching.residual_noise", switching.residual_noise),
            ("switching.warm_up_time", with(switching.magnetic != 0.0, switching.warm_up_s.unwrap_or(0.0))),
            ("warm_up.amplitude", warm_up[0]),
            ("warm_up.time", warm_up[1]),
        ];
        let given = all.into_iter().filter(|(_, value)| *value != 0.0);
        given.map(|(name, value)| format!("{name}={value:.11e}\n")).collect()
    }

    /// The angle, ″, that each part of the rate except the angle random walk can accumulate in a time, with at most one
    /// switch; rms for noise and residuals.
    pub(crate) fn over(&self, time_s: f64) -> Vec<(&'static str, f64)> {
        let t = time_s;
        let all = [
            ("bias instability", self.bias_instability * t),
            ("rate random walk", self.rate_random_walk * t * libm::sqrt(t)),
            ("rate ramp", 0.5 * self.rate_ramp.abs() * t * t),
            ("Markov noise", self.markov.map_or(0.0, |markov| markov.amplitude * t)),
            ("sine", self.sine.map_or(0.0, |sine| sine.amplitude * t)),
            ("warm-up", self.warm_up.map_or(0.0, |warm_up| warm_up.amplitude.abs() * t)),
            ("alternating drift", self.switching.map_or(0.0, |switching| switching.largest_rate() * t)),
            ("fill residuals", self.switching.map_or(0.0, |switching| switching.residual_rms())),
        ];
        all.into_iter().filter(|(_, angle)| *angle != 0.0).collect()
    }
}
