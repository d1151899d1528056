//! The noise of a gyro by its coefficients, as `[noise]` and noise.toml have it.

pub(crate) mod keys;
pub(crate) mod read;

use crate::theory::allan::part::Part;
use crate::theory::allan::process::Process;
use crate::theory::allan::{holds, switching};
use crate::theory::drift::magnetic::Magnetic;

/// Coefficients in ″ and s; 0 is absent.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Noise {
    /// Q, ″.
    pub quantisation: f64,
    /// Angle of a pulse where whole pulses are read, ″.
    pub readout_lsb: f64,
    /// N, ″/√s.
    pub angle_random_walk: f64,
    /// B, ″/s.
    pub bias_instability: f64,
    /// K, ″/s^1.5.
    pub rate_random_walk: f64,
    /// R, ″/s².
    pub rate_ramp: f64,
    /// Exponentially correlated.
    pub markov: Option<Markov>,
    /// Of a random phase.
    pub sine: Option<Sine>,
    /// The same in all records.
    pub warm_up: Option<WarmUp>,
    /// Of a gyro that switches modes.
    pub switching: Option<Switching>,
}

/// Exponentially correlated noise of the rate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Markov {
    /// Its rms, ″/s.
    pub amplitude: f64,
    /// T_c, s.
    pub time_s: f64,
}

/// A sine of the rate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sine {
    /// Its peak, ″/s.
    pub amplitude: f64,
    /// Hz.
    pub frequency_hz: f64,
}

/// A decay of the rate from the start of the record on.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WarmUp {
    /// The rate at the start, ″/s.
    pub amplitude: f64,
    /// In which it falls to 1/e, s.
    pub time_s: f64,
}

/// A gyro that switches modes from the start of the record on; 0 is absent.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Switching {
    /// As it is asked for, s; records switch after the nearest whole number of samples.
    pub interval_s: f64,
    /// A, ″/s.
    pub magnetic: f64,
    /// τ, s; the magnetic drift is A + Ω_m0 from the start on where there is none.
    pub warm_up_s: Option<f64>,
    /// Ω_m0, ″/s.
    pub initial_magnetic: f64,
    /// D, ″.
    pub residual: f64,
    /// Standard deviation of the part of fill residuals that is noise, ″.
    pub residual_noise: f64,
}

impl Switching {
    /// Whether a switch changes nothing.
    pub(crate) fn is_nothing(&self) -> bool {
        [self.magnetic, self.initial_magnetic, self.residual, self.residual_noise].iter().all(|x| *x == 0.0)
    }

    /// From one switch to the next, samples of `sample_s`.
    pub fn interval(&self, sample_s: f64) -> u64 {
        libm::round(self.interval_s / sample_s) as u64
    }

    /// Bound of |Ω_m|, which goes from Ω_m0 to A + Ω_m0, ″/s.
    fn largest_rate(&self) -> f64 {
        self.initial_magnetic.abs().max((self.magnetic + self.initial_magnetic).abs())
    }

    /// Of what a switch leaves, D sin φ and the noise beside it, ″.
    fn residual_rms(&self) -> f64 {
        libm::sqrt(0.5 * self.residual * self.residual + self.residual_noise * self.residual_noise)
    }

    /// A, τ and Ω_m0, without warm-up all of it in Ω_m0.
    fn drift(&self) -> Magnetic {
        match self.warm_up_s {
            Some(time_s) => Magnetic { amplitude: self.magnetic, time_s, initial: self.initial_magnetic },
            None => Magnetic { amplitude: 0.0, time_s: 1.0, initial: self.magnetic + self.initial_magnetic },
        }
    }
}

impl Noise {
    /// The switches of records of samples of `sample_s`; `None` where they change nothing.
    pub fn switched(&self, sample_s: f64) -> Option<switching::Switching> {
        let switching = self.switching.filter(|switching| !switching.is_nothing())?;
        Some(switching::Switching {
            interval: switching.interval(sample_s),
            magnetic: switching.drift(),
            residual: switching.residual,
            residual_noise: switching.residual_noise,
        })
    }

    /// What the records of `samples` rates are made of, each `sample_s` long; but for readout and switches, which no [`Part`] is.
    ///
    /// Records too long for the octaves of flicker have the most there are; they are refused elsewhere.
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

    /// What determines the draws, key by key in base units; what is absent has no line.
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

    /// The angle, ″, that each part of the rate but the angle random walk can turn through in a time, with one switch at the
    /// most; rms of noise and residuals.
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
