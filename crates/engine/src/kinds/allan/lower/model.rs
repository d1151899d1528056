//! A noise model by its parts, per sample of the record instead of per second.

use core::f64::consts::PI;

use crate::key::row::Refusal;
use crate::kinds::allan::lower::{Asked, MAX_SAMPLES};
use sagnac_theory::allan::estimator::Difference;
use sagnac_theory::allan::holds;
use sagnac_theory::allan::part::Part;
use sagnac_theory::allan::process::Process;
use sagnac_theory::allan::switching::Switching;
use sagnac_theory::allan::terms::{Row, Source};

/// Number of standard deviations for which differences and rates have room.
pub(crate) const DEVIATIONS: f64 = 16.0;

/// The requested model, with angles in ″ and times in samples.
pub(crate) struct Model {
    pub(crate) samples: u64,
    pub(crate) noise: Noise,
    pub(crate) sine: Option<Sine>,
    /// Acceleration, ″ per sample².
    pub(crate) ramp: f64,
    pub(crate) warm_ups: Vec<WarmUp>,
    pub(crate) switching: Option<Switching>,
    /// Range of the angle of its alternating drift, ″.
    pub(crate) sawtooth: f64,
    pub(crate) readout_lsb: f64,
    /// Constant rate, ″ per sample; 0 where no readout is affected by it.
    pub(crate) mean_rate: f64,
}

/// The random parts, as standard deviations in some unit of angle.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Noise {
    /// Noise of every angle.
    pub(crate) quantization: f64,
    /// Noise of every increment.
    pub(crate) white: f64,
    /// Noise of the rate in each octave of holds, from octave 0 on; empty without flicker.
    pub(crate) octaves: Vec<f64>,
    /// Step of the rate random walk.
    pub(crate) walk: f64,
    pub(crate) markov: Option<Markov>,
}

/// Markov noise of the rate: r_k = e^{−decay}·r_{k−1} + …, with the stationary standard deviation `sigma`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Markov {
    pub(crate) sigma: f64,
    pub(crate) decay: f64,
}

/// A sine of the angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sine {
    pub(crate) amplitude: f64,
    /// Turns per sample.
    pub(crate) turns: f64,
}

/// A warm-up angle, reach·(1 − e^{−decay·k}), ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WarmUp {
    pub(crate) reach: f64,
    pub(crate) decay: f64,
}

impl Model {
    pub(crate) fn new(asked: &Asked) -> Result<Model, Refusal> {
        let t0 = at_least("record.sample", "a sample of", asked.process.sample_s, f64::MIN_POSITIVE)?;
        let readout_lsb = at_least("noise.readout_lsb", "a pulse of", asked.readout_lsb, 0.0)?;
        let mean_rate = at_least("record.rate", "a rate of", asked.mean_rate, f64::MIN)?;
        let mut model = Model {
            samples: asked.samples,
            noise: Noise { quantization: 0.0, white: 0.0, octaves: vec![], walk: 0.0, markov: None },
            sine: None,
            ramp: 0.0,
            warm_ups: vec![],
            switching: None,
            sawtooth: 0.0,
            readout_lsb,
            mean_rate: if readout_lsb > 0.0 { mean_rate * t0 } else { 0.0 },
        };
        for part in &asked.process.parts {
            let Row { key, size: (what, least), ref shape, sources, .. } = *part.term.row();
            at_least(key, what, part.size, least)?;
            if let Some(shape) = shape {
                at_least(key, shape.what, part.shape, f64::MIN_POSITIVE)?;
            }
            for source in sources(part, t0, asked.samples) {
                model.add(key, source)?;
            }
        }
        if let Some(switching) = asked.switching {
            let switching = checked(switching, asked.samples)?.per_sample(t0);
            model.sawtooth = switching.sawtooth_range(asked.samples);
            model.switching = Some(switching);
        }
        Ok(model)
    }

    /// Adds the source of noise given by the key `key`.
    fn add(&mut self, key: &'static str, source: Source) -> Result<(), Refusal> {
        let noise = &mut self.noise;
        let join = |into: &mut f64, sigma: f64| *into = libm::hypot(*into, sigma);
        let only = |is_second: bool| match is_second {
            true => Err(Refusal::new(key, "a record has at most one of them", "leave one of them out")),
            false => Ok(()),
        };
        match source {
            Source::Errors(sigma) => join(&mut noise.quantization, sigma),
            Source::White(sigma) => join(&mut noise.white, sigma),
            Source::Walk(sigma) => join(&mut noise.walk, sigma),
            Source::Holds(sigmas) if sigmas.iter().any(|sigma| *sigma != 0.0) => {
                noise.octaves.resize(noise.octaves.len().max(sigmas.len()), 0.0);
                noise.octaves.iter_mut().zip(sigmas).for_each(|(octave, sigma)| join(octave, sigma));
            }
            Source::Markov { sigma, decay } if sigma > 0.0 => {
                only(noise.markov.replace(Markov { sigma, decay }).is_some())?;
            }
            Source::Sine { amplitude, turns } if amplitude > 0.0 => {
                only(self.sine.replace(Sine { amplitude, turns }).is_some())?;
            }
            Source::Ramp(ramp) => self.ramp += ramp,
            Source::Decay { reach, decay } if reach != 0.0 => self.warm_ups.push(WarmUp { reach, decay }),
            Source::Holds(_) | Source::Markov { .. } | Source::Sine { .. } | Source::Decay { .. } => {}
        }
        Ok(())
    }

    /// The longest averaging factor for which the record has a difference; 0 if there is none.
    pub(crate) fn longest(&self, difference: Difference) -> u64 {
        self.samples / difference.spans()
    }

    /// Whether all records share more than a constant rate.
    pub(crate) fn is_curved(&self) -> bool {
        self.ramp != 0.0 || !self.warm_ups.is_empty() || self.sawtooth != 0.0
    }

    /// Bound of all differences of ramp, warm-up and alternating drift, ″. Those of the first two grow with m, and fall
    /// along the record.
    pub(crate) fn trend(&self, difference: Difference) -> f64 {
        let m = self.longest(difference) as f64;
        let power = f64::from(difference.spans() as u32);
        let ramp = if difference == Difference::Second { libm::fabs(self.ramp) * m * m } else { 0.0 };
        let warm_up =
            |one: &WarmUp| libm::fabs(one.reach) * libm::pow(libm::fabs(libm::expm1(-one.decay * m)), power);
        // As many angles are added as subtracted.
        let sawtooth = self.sawtooth * 0.5 * reach(difference);
        ramp + self.warm_ups.iter().map(warm_up).sum::<f64>() + sawtooth
    }

    /// Bound of all differences of the record, ″.
    pub(crate) fn whole(&self, difference: Difference) -> f64 {
        let m = self.longest(difference);
        if m == 0 {
            return 0.0;
        }
        let jumps = self.switching.and_then(|switching| switching.jumps());
        let jumps = jumps.map_or(0.0, |jumps| jumps.largest_variance(difference, m));
        let noise = DEVIATIONS * libm::sqrt(self.noise.variance(difference, m) + jumps);
        let sine = self.sine.map_or(0.0, |sine| sine.largest(difference, m));
        // Some of the readings are too low by up to a pulse.
        let pulses = 0.5 * self.readout_lsb * reach(difference);
        noise + sine + self.trend(difference) + pulses
    }
}

/// Σ|c| of a difference.
pub(crate) fn reach(difference: Difference) -> f64 {
    libm::exp2(difference.spans() as f64)
}

/// Checks that the switching is possible in a record.
fn checked(switching: Switching, samples: u64) -> Result<Switching, Refusal> {
    let Switching { interval, magnetic, residual, residual_noise } = switching;
    if !(1..samples).contains(&interval) {
        let found = format_args!("switches {interval} samples apart in a record of {samples}");
        let help = "switch at least once in the record, after one sample or more";
        return Err(Refusal::new("noise.switching.interval", found, help));
    }
    at_least("noise.switching.magnetic", "a drift of", magnetic.amplitude, f64::MIN)?;
    at_least("noise.switching.initial_magnetic", "a drift of", magnetic.initial, f64::MIN)?;
    at_least("noise.switching.warm_up_time", "a time of", magnetic.time_s, f64::MIN_POSITIVE)?;
    at_least("noise.switching.residual", "an amplitude of", residual, 0.0)?;
    at_least("noise.switching.residual_noise", "a noise of", residual_noise, 0.0)?;
    Ok(switching)
}

/// The refusal of a meaningless value: negative, or not finite.
pub(crate) fn impossible(key: &'static str, what: &str, found: f64) -> Refusal {
    let help = "give a finite number that is not negative, and times, frequencies and samples above 0";
    Refusal::new(key, format_args!("{what} {found} is not possible"), help)
}

/// The refusal of a record of one sample, or of more than 2^26.
pub(crate) fn too_long(samples: u64) -> Refusal {
    let found = format_args!("{samples} samples; a record has 2 to {MAX_SAMPLES}");
    Refusal::new("record.length", found, "take a shorter record, or a longer sample")
}

/// A finite number that is at least `least`.
fn at_least(key: &'static str, what: &'static str, found: f64, least: f64) -> Result<f64, Refusal> {
    match found.is_finite() && found >= least {
        true => Ok(found),
        false => Err(impossible(key, what, found)),
    }
}

impl Noise {
    /// The parts for which a closed form gives the distribution of every increment: all except holds and random walk.
    pub(crate) fn simple(&self) -> Process {
        let mut parts = vec![Part::quantization(self.quantization), Part::angle_random_walk(self.white)];
        parts.extend(self.markov.map(Markov::part));
        Process { sample_s: 1.0, parts }
    }

    /// Variance of a difference at `m`, which grows with m.
    pub(crate) fn variance(&self, difference: Difference, m: u64) -> f64 {
        let octave = |(o, sigma): (usize, &f64)| sigma * sigma * holds::mean_square(difference, 1 << o, m);
        self.simple().variance(difference, m)
            + Part::rate_random_walk(self.walk).variance(difference, 1.0, m)
            + self.octaves.iter().enumerate().map(octave).sum::<f64>()
    }

    /// Standard deviation of the rate at the end of a record, without octave 0.
    pub(crate) fn rate(&self, samples: u64) -> f64 {
        let held: f64 = self.octaves.iter().skip(1).map(|sigma| sigma * sigma).sum();
        let markov = self.markov.map_or(0.0, |markov| markov.sigma * markov.sigma);
        libm::sqrt(held + self.walk * self.walk * samples as f64 + markov)
    }
}

impl Markov {
    /// The part in the notation of `theory`, with t0 = 1.
    pub(crate) fn part(self) -> Part {
        Part::markov(self.sigma * libm::sqrt(2.0 * self.decay), 1.0 / self.decay)
    }
}

impl Sine {
    /// The part in the notation of `theory`, with t0 = 1; `None` for a sine that never moves.
    pub(crate) fn part(self) -> Option<Part> {
        let rate = 2.0 * PI * self.turns;
        (rate > 0.0).then_some(Part::sine(self.amplitude * rate, self.turns))
    }

    /// Bound of the differences at all averaging factors up to `m`; |2 sin x| is at most 2 and at most 2x.
    pub(crate) fn largest(self, difference: Difference, m: u64) -> f64 {
        let factor = (2.0 * PI * self.turns * m as f64).min(2.0);
        self.amplitude * libm::pow(factor, difference.spans() as f64)
    }
}
