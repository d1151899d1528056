//! Points of a study of Allan curves, each checked as a whole.

use crate::key::document::Places;
use crate::key::sweep::{self, Sweep, Swept, selected};
use crate::kinds::allan::estimate::Estimate;
use crate::kinds::allan::keys::{RATE, SETTINGS};
use crate::kinds::allan::lower::MAX_SAMPLES;
use crate::noise::{FILE, Noise, READOUT_LSB, SETTINGS as NOISE_SETTINGS};
use sagnac_base::quantity::number::significant;
use sagnac_base::source::diagnose::Fault;
use sagnac_records::allan::deviation::Deviation;
use sagnac_records::allan::tau::{TauError, Taus};
use sagnac_theory::allan::estimator::{Difference, Stride};
use sagnac_theory::allan::terms::Term;

/// Fewest samples of a record.
const MIN_SAMPLES: u64 = 16;
/// Relative deviation of a listed time from a whole number of samples that counts as rounding, since not all decimal
/// fractions are exact.
const WHOLE: f64 = 1e-9;

/// The inputs of a record, in ″ and s. Every number has 12 significant digits.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Time from one sample to the next, s.
    pub sample_s: f64,
    /// Requested length, s; a record has the nearest whole number of samples.
    pub length_s: f64,
    /// Constant rate, ″/s, which affects a readout in whole pulses.
    pub rate: f64,
    /// Noise coefficients.
    pub noise: Noise,
}

impl Inputs {
    /// Number of rate samples of a record.
    pub fn samples(&self) -> u64 {
        libm::round(self.length_s / self.sample_s) as u64
    }
}

/// One combination of swept values, with everything derived from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, Swept)>,
    /// Inputs that determine the draws.
    pub inputs: Inputs,
    /// Averaging factors, ascending.
    pub ms: Vec<u64>,
}

/// The inputs common to all points, with their places in the text.
pub(crate) struct Base<'a> {
    pub(crate) inputs: Inputs,
    /// The noise of each file of a sweep over files, combined with the keys of the study.
    pub(crate) files: Vec<Noise>,
    pub(crate) places: &'a Places,
    pub(crate) sweeps: &'a [Sweep],
    pub(crate) estimate: &'a Estimate,
}

impl Base<'_> {
    /// Refuses sweeps over absent parts of the noise, or over a rate without effect.
    pub(crate) fn check_sweeps(&self) -> Result<(), Fault> {
        let noises = self.noises();
        let pulses = self.sweeps.iter().any(|sweep| sweep.key.name == READOUT_LSB.name)
            || noises.iter().any(|noise| noise.readout_lsb > 0.0);
        for sweep in self.sweeps {
            if sweep.key.name == RATE.name && !pulses {
                let message =
                    "record.rate is swept, but a constant rate affects only a readout in whole pulses";
                let help = "give noise.readout_lsb, or leave the sweep out";
                return Err(sweep.fault(message, "no effect", help));
            }
            for noise in noises {
                sweep::check_applies(sweep, noise, &NOISE_SETTINGS, "[noise]")?;
            }
        }
        Ok(())
    }

    /// All points, in order.
    ///
    /// # Errors
    /// The first point that is invalid.
    pub(crate) fn points(&self) -> Result<Vec<Point>, Fault> {
        sweep::points(self.sweeps).map(|swept| self.point(swept)).collect()
    }

    /// The noise of the study, or that of each file of a sweep over files.
    pub(crate) fn noises(&self) -> &[Noise] {
        if self.files.is_empty() { std::slice::from_ref(&self.inputs.noise) } else { &self.files }
    }

    fn point(&self, swept: Vec<(&'static str, Swept)>) -> Result<Point, Fault> {
        let mut inputs = self.inputs.clone();
        if let Some(noise) = selected(&self.files, &FILE, self.sweeps, &swept) {
            inputs.noise = noise.clone();
        }
        sweep::set(&mut inputs, &SETTINGS, &swept);
        sweep::set(&mut inputs.noise, &NOISE_SETTINGS, &swept);
        self.check(&inputs)?;
        let ms = self.factors(&inputs, &swept)?;
        Ok(Point { swept, inputs, ms })
    }

    /// Checks limits that involve more than one value.
    fn check(&self, inputs: &Inputs) -> Result<(), Fault> {
        let Inputs { sample_s, length_s, noise, .. } = inputs;
        let samples = inputs.samples();
        if !(MIN_SAMPLES..=MAX_SAMPLES).contains(&samples) {
            let label = if samples < MIN_SAMPLES { "too short" } else { "too long" };
            let message = format!("record.length = {length_s} s is {samples} samples of {sample_s} s");
            let [shortest, longest] =
                [MIN_SAMPLES, MAX_SAMPLES].map(|samples| significant(samples as f64 * sample_s, 6));
            let help =
                format!("accepted: {MIN_SAMPLES} to {MAX_SAMPLES} samples, {shortest} s to {longest} s here");
            return self.places.refuse(&["record.length", "record.sample"], message, label, help);
        }
        noise.lock_in.map_or(Ok(()), |lock_in| lock_in.check(self.places))?;
        let [_, sine_hz] = noise.of(Term::Sine);
        if sine_hz * sample_s > 0.5 {
            let nyquist = significant(0.5 / sample_s, 6);
            let message = format!(
                "noise.sine.frequency = {} Hz is above the Nyquist frequency of samples of {sample_s} s",
                significant(sine_hz, 6)
            );
            let help = format!("accepted: up to {nyquist} Hz, or a shorter record.sample");
            let names = ["noise.sine.frequency", "noise.sine", "record.sample"];
            return self.places.refuse(&names, message, "too high for the samples", help);
        }
        if let Some(switching) = noise.switching
            && !(1..samples).contains(&switching.interval(*sample_s))
        {
            let interval = switching.interval(*sample_s);
            let interval_s = significant(switching.interval_s, 6);
            let message = match interval {
                0 => format!(
                    "noise.switching.interval = {interval_s} s is less than half a sample of {sample_s} s"
                ),
                _ => format!(
                    "noise.switching.interval = {interval_s} s: there is no switch in a record of {length_s} s"
                ),
            };
            let label = if interval == 0 { "too short" } else { "too long" };
            let longest = significant((samples - 1) as f64 * sample_s, 6);
            let help = format!("accepted: {sample_s} s to {longest} s here, or leave [noise.switching] out");
            let names = ["noise.switching.interval", "noise.file", "record.length", "record.sample"];
            return self.places.refuse(&names, message, label, help);
        }
        let is_silent = noise.process(*sample_s, samples).parts.is_empty() && noise.readout_lsb == 0.0;
        if is_silent && noise.switched(*sample_s).is_none() {
            let message = "[noise] is empty: all records would be constant";
            let help = "add a coefficient as in angle_random_walk = \"0.00048 deg/sqrt(h)\", or file = \"noise.toml\"";
            return self.places.refuse(&["noise"], message, "no noise", help);
        }
        Ok(())
    }

    /// The averaging factors of the point's records.
    fn factors(&self, inputs: &Inputs, swept: &[(&'static str, Swept)]) -> Result<Vec<u64>, Fault> {
        let Estimate { taus, estimator, .. } = self.estimate;
        let place = || self.places.blame(&["allan.tau"]);
        if let Taus::Seconds(times) = taus {
            for tau_s in times {
                let m = tau_s / inputs.sample_s;
                if (m - libm::round(m)).abs() > WHOLE * m {
                    let message =
                        format!("τ = {tau_s} s is not a whole number of samples of {} s", inputs.sample_s);
                    let help = "give multiples of record.sample, or tau = \"octave\"";
                    return Err(Fault::new(place(), message, "between two samples", help));
                }
            }
        }
        let deviation = match estimator.difference {
            Difference::Second => Deviation::Oadev,
            Difference::Third => Deviation::Ohdev,
        };
        let angles = inputs.samples() as usize + 1;
        let factors = taus.factors(angles, inputs.sample_s, deviation).map_err(|error| {
            let message = error.to_string();
            let message = message.lines().next().unwrap_or_default();
            let help = match error {
                TauError::Long { .. } => "leave it out, lengthen the record, or write tau = \"octave\"",
                _ => "give multiples of record.sample, or tau = \"octave\"",
            };
            let at: String = swept.iter().map(|(key, value)| format!(", at {key} = {value}")).collect();
            Fault::new(place(), format!("allan.tau: {message}{at}"), "not for this record", help)
        })?;
        let mut ms: Vec<u64> = factors.into_iter().map(|m| m as u64).collect();
        if let (Taus::Decade(_), Stride::Part(parts)) = (taus, estimator.stride) {
            // Differences are whole strides apart, and a factor without divisors would force a stride of one sample.
            let rounded = |m: &mut u64| *m -= *m % (1 << (*m / parts).max(1).ilog2());
            ms.iter_mut().for_each(rounded);
            ms.dedup();
        }
        Ok(ms)
    }
}
