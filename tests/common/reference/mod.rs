//! A gyro of its own in floating point, from the plain formulas: motion integrated over ticks analytically, noise by Box
//! and Müller, weights by Gram and Schmidt or by elimination. None of the program's arithmetic, but the text of its studies.
#![allow(dead_code, reason = "each test binary uses a part")]

use std::f64::consts::TAU;
use std::fmt::Write as _;

use rand::RngExt;
use rand::rngs::StdRng;

pub mod polynomial;
mod vibration;
pub mod weights;

pub use vibration::band_covariance;
use vibration::{
    mean_over, over_psd, peak, power_quantiles, recorded_angle, square_response, sums, whole_ticks,
};

/// T, s.
pub const TICK_S: f64 = 0.005;

/// Ticks of a record that stay free on either side of the gap.
const MARGIN: usize = 64;

/// Strata of the power of Gaussian motion, each with one frequency.
const STRATA: usize = 48;

/// A value of a trial.
#[derive(Debug, Clone, Copy)]
pub enum Draw {
    Fixed(f64),
    Uniform(f64, f64),
    Rayleigh(f64),
}

#[derive(Debug, Clone, Copy)]
pub struct Tone {
    /// Whether the amplitude is one of the angle, ″, and not of the rate, ″/s.
    pub of_angle: bool,
    pub amplitude: Draw,
    /// Hz, two ends of a band.
    pub frequency: [f64; 2],
    /// At the middle of the gap; drawn evenly where there is none.
    pub phase: Option<f64>,
}

/// Motion beside the tones.
#[derive(Debug, Clone)]
pub enum Beside {
    Nothing,
    /// rms rate, ″/s, and band, Hz.
    Band(f64, [f64; 2]),
    /// Hz and (″/s)²/Hz, straight lines in log–log.
    Psd(Vec<[f64; 2]>),
    /// Through a suspension: modes of frequency, Hz, Q factor and response at resonance, ″/s/g; the acceleration is a sine of
    /// g and Hz, or has a density, g²/Hz.
    Vibration {
        modes: Vec<[f64; 3]>,
        sine: Option<[f64; 2]>,
        psd: Vec<[f64; 2]>,
    },
    /// Rates, ″/s, every so many s, and the name of their file.
    Profile {
        file: &'static str,
        step_s: f64,
        rates: Vec<f64>,
        every: bool,
    },
}

#[derive(Debug, Clone)]
pub struct Gyro {
    pub n: i32,
    pub sigma: f64,
    pub readout: f64,
    pub relock: Vec<f64>,
    pub tones: Vec<Tone>,
    pub beside: Beside,
    pub rate: f64,
    pub acceleration: f64,
}

/// What a trial gives: readings and truth.
pub struct Trial {
    /// Of the ticks from `first` on, without those of the gap.
    first: i32,
    readings: Vec<f64>,
    /// Angle from the start of the gap to the end of each of its ticks.
    pub truth: Vec<f64>,
}

impl Trial {
    pub fn reading(&self, tick: i32) -> f64 {
        self.readings[(tick - self.first) as usize]
    }
}

impl Draw {
    fn draw(self, rng: &mut StdRng) -> f64 {
        match self {
            Draw::Fixed(x) => x,
            Draw::Uniform(a, b) => a + (b - a) * rng.random::<f64>(),
            Draw::Rayleigh(scale) => scale * (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt(),
        }
    }

    fn mean_square(self) -> f64 {
        match self {
            Draw::Fixed(x) => x * x,
            Draw::Uniform(a, b) => (b * b * b - a * a * a) / (3.0 * (b - a)),
            Draw::Rayleigh(scale) => 2.0 * scale * scale,
        }
    }

    fn toml(self, unit: &str) -> String {
        match self {
            Draw::Fixed(x) => format!("\"{x} {unit}\""),
            Draw::Uniform(a, b) => format!("{{ uniform = [\"{a} {unit}\", \"{b} {unit}\"] }}"),
            Draw::Rayleigh(scale) => format!("{{ rayleigh = \"{scale} {unit}\" }}"),
        }
    }
}

impl Tone {
    /// Of a rate amplitude and a frequency, with random phase.
    pub fn of_rate(amplitude: Draw, low_hz: f64, high_hz: f64) -> Tone {
        Tone { of_angle: false, amplitude, frequency: [low_hz, high_hz], phase: None }
    }

    fn rate_amplitude(&self, amplitude: f64, nu: f64) -> f64 {
        if self.of_angle { amplitude * TAU * nu } else { amplitude }
    }

    fn toml(&self) -> String {
        let unit = if self.of_angle { "arcsec" } else { "arcsec/s" };
        let [low, high] = self.frequency;
        let frequency =
            if low == high { format!("\"{low} Hz\"") } else { format!("[\"{low} Hz\", \"{high} Hz\"]") };
        let phase = match self.phase {
            None => "uniform",
            Some(0.0) => "zero-crossing",
            Some(_) => "extremum",
        };
        format!("amplitude = {}, frequency = {frequency}, phase = \"{phase}\"", self.amplitude.toml(unit))
    }
}

/// A normal number.
pub fn normal(rng: &mut StdRng) -> f64 {
    (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt() * (TAU * rng.random::<f64>()).cos()
}

/// What does not change from trial to trial.
pub struct Prepared<'a> {
    gyro: &'a Gyro,
    first: i32,
    last: i32,
    variance: f64,
    quantiles: Vec<f64>,
    sums: Vec<f64>,
}

impl Gyro {
    /// The paper's noise, a gap of three ticks and no motion.
    pub fn still() -> Gyro {
        Gyro {
            n: 3,
            sigma: 0.533_333,
            readout: 0.0,
            relock: vec![],
            tones: vec![],
            beside: Beside::Nothing,
            rate: 0.0,
            acceleration: 0.0,
        }
    }

    /// Ready for trials in which ticks from `first` to `last` are read.
    pub fn prepared(&self, first: i32, last: i32) -> Prepared<'_> {
        let (variance, quantiles) = power_quantiles(&self.beside);
        let sums = match &self.beside {
            Beside::Profile { rates, step_s, .. } => sums(rates, *step_s),
            _ => vec![],
        };
        Prepared { gyro: self, first, last, variance, quantiles, sums }
    }

    /// Deviations of the ticks of a record from their mean, ″; empty without a record.
    pub fn deviations(&self) -> Vec<f64> {
        let Beside::Profile { rates, step_s, .. } = &self.beside else { return vec![] };
        let sums = sums(rates, *step_s);
        let angle = |k: usize| recorded_angle(rates, &sums, *step_s, k as f64 * TICK_S);
        let ticks: Vec<f64> = (0..whole_ticks(rates, *step_s)).map(|k| angle(k + 1) - angle(k)).collect();
        let mean = ticks.iter().sum::<f64>() / ticks.len() as f64;
        ticks.iter().map(|tick| tick - mean).collect()
    }

    /// Covariance of the ticks by lag, ″², without a record; every phase counts as random.
    pub fn covariance(&self, lags: usize) -> Vec<f64> {
        let tones = |lag: f64| -> f64 {
            let of = |tone: &Tone| {
                let square = |nu: f64| {
                    let peak = tone.rate_amplitude(peak(nu), nu);
                    0.5 * peak * peak * (TAU * nu * TICK_S * lag).cos()
                };
                tone.amplitude.mean_square() * mean_over(tone.frequency, square)
            };
            self.tones.iter().map(of).sum()
        };
        let beside = |lag: usize| match &self.beside {
            Beside::Nothing => 0.0,
            Beside::Band(rms, band) => 2.0 * rms * rms * band_covariance(*band, lag as f64),
            Beside::Psd(points) => {
                over_psd(points, |nu| peak(nu) * peak(nu) * (TAU * nu * TICK_S * lag as f64).cos())
            }
            Beside::Vibration { modes, sine, psd } => {
                let term = |nu: f64| {
                    square_response(modes, nu) * peak(nu) * peak(nu) * (TAU * nu * TICK_S * lag as f64).cos()
                };
                over_psd(psd, term) + sine.map_or(0.0, |[a, nu]| 0.5 * a * a * term(nu))
            }
            Beside::Profile { .. } => unreachable!("a record has no covariance by lag"),
        };
        (0..lags).map(|lag| tones(lag as f64) + beside(lag)).collect()
    }

    /// Covariance of noise and pulses by lag, ″².
    pub fn noise_covariance(&self) -> [f64; 2] {
        let fraction = self.readout * self.readout / 12.0;
        [self.sigma * self.sigma + 2.0 * fraction, -fraction]
    }

    /// The tables `[gyro]` and `[motion]` of a study.
    pub fn toml(&self) -> String {
        let mut text =
            format!("[gyro]\ntick = \"5 ms\"\ntick_noise = {{ std = \"{} arcsec\" }}\n", self.sigma);
        if self.readout > 0.0 {
            writeln!(text, "readout_lsb = \"{} arcsec\"", self.readout).unwrap();
        }
        if !self.relock.is_empty() {
            let angles: Vec<String> = self.relock.iter().map(|angle| format!("\"{angle} arcsec\"")).collect();
            writeln!(text, "relock = [{}]", angles.join(", ")).unwrap();
        }
        text += "[motion]\n";
        match &self.tones[..] {
            [] => {}
            [tone] => {
                text +=
                    &(tone.toml().replace(", frequency", "\nfrequency").replace(", phase", "\nphase") + "\n")
            }
            tones => {
                let tones: Vec<String> =
                    tones.iter().map(|tone| format!("  {{ {} }},\n", tone.toml())).collect();
                writeln!(text, "tones = [\n{}]", tones.concat()).unwrap();
            }
        }
        match &self.beside {
            Beside::Nothing => {}
            Beside::Band(rms, [low, high]) => {
                let band = format!("[\"{low} Hz\", \"{high} Hz\"]");
                writeln!(text, "gaussian = {{ rms = \"{rms} arcsec/s\", band = {band} }}").unwrap();
            }
            Beside::Psd(points) => {
                let row = |[nu, s]: &[f64; 2]| format!("[\"{nu} Hz\", \"{s} (arcsec/s)^2/Hz\"]");
                let rows: Vec<String> = points.iter().map(row).collect();
                writeln!(text, "gaussian = {{ psd = [{}] }}", rows.join(", ")).unwrap();
            }
            Beside::Vibration { modes, sine, psd } => {
                let mode = |[nu, q, response]: &[f64; 3]| {
                    format!("{{ frequency = \"{nu} Hz\", q = {q}, response = \"{response} arcsec/s/g\" }}")
                };
                let modes: Vec<String> = modes.iter().map(mode).collect();
                let row = |[nu, s]: &[f64; 2]| format!("[\"{nu} Hz\", \"{s} g^2/Hz\"]");
                let rows: Vec<String> = psd.iter().map(row).collect();
                let acceleration = match sine {
                    Some([a, nu]) => {
                        format!("sine = {{ acceleration = \"{a} g\", frequency = \"{nu} Hz\" }}")
                    }
                    None => format!("random = {{ psd = [{}] }}", rows.join(", ")),
                };
                let modes = modes.join(", ");
                writeln!(text, "suspension = {{ modes = [{modes}], {acceleration}, alias = true }}").unwrap();
            }
            Beside::Profile { file, every, .. } => {
                let position = if *every { "every" } else { "random" };
                let rest =
                    format!("position = \"{position}\", interpolation = \"linear\", design = \"whole\"");
                writeln!(text, "profile = {{ file = \"{file}\", {rest} }}").unwrap();
            }
        }
        writeln!(text, "rate = \"{} arcsec/s\"", self.rate).unwrap();
        writeln!(text, "acceleration = \"{} arcsec/s^2\"", self.acceleration).unwrap();
        text
    }

    /// The record that a study of this gyro names, as a file of its own.
    pub fn write_record(&self, folder: &std::path::Path) {
        if let Beside::Profile { file, step_s, rates, .. } = &self.beside {
            let mut text = "time [s],rate [arcsec/s]\n".to_owned();
            for (i, rate) in rates.iter().enumerate() {
                writeln!(text, "{:.6},{rate}", i as f64 * step_s).unwrap();
            }
            std::fs::write(folder.join(file), text).unwrap();
        }
    }
}

impl Prepared<'_> {
    /// One trial; a gap in a record lies at its place `position`, where that is given.
    pub fn trial(&self, position: Option<usize>, rng: &mut StdRng) -> Trial {
        let Gyro { n, sigma, readout, relock, rate, acceleration, .. } = self.gyro;
        let angles = self.angles(position, rng);
        let middle = 0.5 * f64::from(*n) * TICK_S;
        let angle = |boundary: i32| {
            let t = f64::from(boundary) * TICK_S - middle;
            angles[(boundary - self.first + 1) as usize] + rate * t + 0.5 * acceleration * t * t
        };
        // Where the readout stands at each boundary, from an even start: the true angle with the noise and the relock.
        let mut stands = readout * rng.random::<f64>();
        let mut readings = Vec::new();
        for tick in self.first..=self.last {
            let relocked = usize::try_from(tick - n - 1).ok().and_then(|i| relock.get(i)).unwrap_or(&0.0);
            let increment = angle(tick) - angle(tick - 1) + relocked + sigma * normal(rng);
            let pulses = |x: f64| (x / readout).floor();
            readings.push(if *readout > 0.0 {
                readout * (pulses(stands + increment) - pulses(stands))
            } else {
                increment
            });
            stands += increment;
        }
        let truth = (1..=*n).map(|tick| angle(tick) - angle(0)).collect();
        Trial { first: self.first, readings, truth }
    }

    /// Places that a gap can have in the record.
    pub fn positions(&self) -> usize {
        match &self.gyro.beside {
            Beside::Profile { rates, step_s, .. } => {
                whole_ticks(rates, *step_s) - 2 * MARGIN - self.gyro.n as usize + 1
            }
            _ => 0,
        }
    }

    /// The angle of the vibration at the boundaries from the start of the first tick on.
    fn angles(&self, position: Option<usize>, rng: &mut StdRng) -> Vec<f64> {
        let boundaries = self.first - 1..=self.last;
        let mut angles = vec![0.0; boundaries.clone().count()];
        let middle = 0.5 * f64::from(self.gyro.n) * TICK_S;
        let mut add = |rate: f64, nu: f64, phase: f64| {
            for (angle, boundary) in angles.iter_mut().zip(boundaries.clone()) {
                let t = f64::from(boundary) * TICK_S - middle;
                *angle -= rate / (TAU * nu) * (TAU * nu * t + phase).cos();
            }
        };
        for tone in &self.gyro.tones {
            let [low, high] = tone.frequency;
            let nu = low + (high - low) * rng.random::<f64>();
            let phase = tone.phase.unwrap_or_else(|| TAU * rng.random::<f64>());
            add(tone.rate_amplitude(tone.amplitude.draw(rng), nu), nu, phase);
        }
        if !self.quantiles.is_empty() {
            let scale = (self.variance / STRATA as f64).sqrt();
            for stratum in 0..STRATA {
                let place = (stratum as f64 + rng.random::<f64>()) / STRATA as f64;
                let along = place * (self.quantiles.len() - 1) as f64;
                let i = (along as usize).min(self.quantiles.len() - 2);
                let nu = self.quantiles[i] + (along - i as f64) * (self.quantiles[i + 1] - self.quantiles[i]);
                let radius = Draw::Rayleigh(scale).draw(rng);
                let rate = match self.gyro.beside {
                    Beside::Vibration { .. } => radius / peak(nu).abs(),
                    _ => radius,
                };
                add(rate, nu, TAU * rng.random::<f64>());
            }
        }
        if let Beside::Vibration { modes, sine: Some([a, nu]), .. } = &self.gyro.beside {
            add(a * square_response(modes, *nu).sqrt(), *nu, TAU * rng.random::<f64>());
        }
        if let Beside::Profile { rates, step_s, .. } = &self.gyro.beside {
            let position = position.unwrap_or_else(|| rng.random_range(0..self.positions()));
            for (angle, boundary) in angles.iter_mut().zip(boundaries.clone()) {
                let tick = (position + MARGIN).checked_add_signed(boundary as isize).unwrap();
                *angle += recorded_angle(rates, &self.sums, *step_s, tick as f64 * TICK_S);
            }
        }
        angles
    }
}
