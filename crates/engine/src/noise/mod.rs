//! The noise of a gyro by its coefficients, as given by `[noise]` and noise.toml.

pub(crate) mod files;
pub(crate) mod keys;
pub(crate) mod lock_in;
pub(crate) mod read;
pub(crate) mod switches;

use crate::noise::lock_in::LockIn;
use sagnac_base::quantity::units::round_12;
use sagnac_theory::allan::{Difference, Part, Process, Term};
use sagnac_theory::allan::{holds, switching};
use sagnac_theory::drift::magnetic::Magnetic;

/// Coefficients of terms, with readout and switching; 0 means absent.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Noise {
    /// Coefficient and shape of each term in ″ and s, in the order of [`Term::EVERY`]; `None` for an absent term.
    terms: [Option<[f64; 2]>; Term::EVERY.len()],
    /// Lock-in of a dithered gyro, which adds to the angle random walk.
    pub lock_in: Option<LockIn>,
    /// Angle of a pulse where whole pulses are read, ″.
    pub readout_lsb: f64,
    /// Switching, of a gyro that switches modes.
    pub switching: Option<Switching>,
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

    /// N² of the residuals of all switches, ″²/s.
    pub fn residual_density(&self) -> f64 {
        let rms = self.residual_rms();
        if self.interval_s > 0.0 { rms * rms / self.interval_s } else { 0.0 }
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
    /// Coefficient and shape of a term; 0 where the term is absent. The angle random walk includes that of lock-in, from
    /// which it is independent, in quadrature.
    pub fn of(&self, term: Term) -> [f64; 2] {
        let [size, shape] = self.given(term);
        match self.lock_in {
            Some(lock_in) if term == Term::AngleRandomWalk => {
                [round_12(libm::hypot(size, lock_in.gyro().angle_random_walk())), shape]
            }
            _ => [size, shape],
        }
    }

    /// Coefficient and shape of a term as its own keys give them; 0 where they are absent.
    pub(crate) fn given(&self, term: Term) -> [f64; 2] {
        self.terms[term as usize].unwrap_or_default()
    }

    /// Whether the term is present: a term with a shape by its table, another one by a coefficient other than 0.
    pub fn has(&self, term: Term) -> bool {
        match term.has_shape() {
            true => self.terms[term as usize].is_some(),
            false => self.of(term)[0] != 0.0,
        }
    }

    /// The noise without one of its terms as its own keys give them.
    pub(crate) fn without(&self, term: Term) -> Noise {
        let mut without = self.clone();
        without.terms[term as usize] = None;
        without
    }

    /// Sets the coefficient (0) or the shape (1) of a term, which creates an absent term.
    pub(crate) fn set(&mut self, term: Term, place: usize, value: f64) {
        self.terms[term as usize].get_or_insert_default()[place] = value;
    }

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
        let octaves = holds::octaves(samples).unwrap_or(holds::MAX_OCTAVES);
        let there = Term::EVERY.into_iter().filter_map(|term| {
            let [size, shape] = self.of(term);
            let shape = if term.has_shape() { shape } else { 1.0 };
            (size != 0.0).then(|| term.of_coefficient(size, shape, octaves))
        });
        // Parts common to all records come last.
        let is_trend = |part: &Part| part.trend(Difference::Second, sample_s, 1).is_some();
        let (trends, random): (Vec<Part>, Vec<Part>) = there.partition(is_trend);
        Process { sample_s, parts: [random, trends].concat() }
    }

    /// The inputs that determine the draws, key by key in base units; absent parts have no line.
    pub(crate) fn canonical(&self) -> String {
        let terms = Term::EVERY.into_iter().filter(|term| self.of(*term)[0] != 0.0).flat_map(|term| {
            // Identities keep the first name of a key, so that earlier results stay.
            let key = match term {
                Term::Quantization => "quantisation",
                _ => term.row().key.trim_start_matches("noise."),
            };
            let [size, of_shape] = self.of(term);
            match term.shape() {
                None => vec![(key.to_owned(), size)],
                Some(shape) => {
                    vec![(format!("{key}.amplitude"), size), (format!("{key}.{}", shape.key), of_shape)]
                }
            }
        });
        let switching = self.switching.filter(|switching| !switching.is_nothing()).unwrap_or_default();
        let warm_up_s = switching.warm_up_s.filter(|_| switching.magnetic != 0.0).unwrap_or(0.0);
        let others = [
            ("readout_lsb", self.readout_lsb),
            ("switching.initial_magnetic", switching.initial_magnetic),
            ("switching.interval", switching.interval_s),
            ("switching.magnetic", switching.magnetic),
            ("switching.residual", switching.residual),
            ("switching.residual_noise", switching.residual_noise),
            ("switching.warm_up_time", warm_up_s),
        ];
        let others = others.map(|(key, value)| (key.to_owned(), value));
        let given = terms.chain(others).filter(|(_, value)| *value != 0.0);
        let mut lines: Vec<String> = given.map(|(key, value)| format!("{key}={value:.11e}\n")).collect();
        lines.sort();
        lines.concat()
    }

    /// The angle, ″, that each part of the rate except the angle random walk can accumulate in a time, with at most one
    /// switch; rms for noise and residuals.
    pub(crate) fn over(&self, time_s: f64) -> Vec<(&'static str, f64)> {
        let turned = |term: Term| (term.row().name[1], (term.row().turned)(self.of(term)[0], time_s));
        let switching = [
            ("alternating drift", self.switching.map_or(0.0, |switching| switching.largest_rate() * time_s)),
            ("fill residuals", self.switching.map_or(0.0, |switching| switching.residual_rms())),
        ];
        let all = Term::EVERY.into_iter().map(turned).chain(switching);
        all.filter(|(_, angle)| *angle != 0.0).collect()
    }
}
