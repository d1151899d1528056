//! Points of a study of lock-in, each checked as a whole.

use crate::key::document::Places;
use crate::kinds::allan::lower::MAX_SAMPLES;
use crate::kinds::lock_in::inputs::{DITHER_RATE, FREQUENCY, LENGTH, SAMPLE, THRESHOLD};
use crate::kinds::lock_in::{Inputs, Readout};
use sagnac_base::quantity::number::significant;
use sagnac_base::source::diagnose::Fault;
use sagnac_records::allan::deviation::Deviation;
use sagnac_records::allan::tau::{TauError, Taus};
use sagnac_theory::allan::estimator::{Difference, Estimator, Stride};

/// Fewest samples of a record.
const MIN_SAMPLES: u64 = 16;

/// Sampling time without dither, s.
const USUAL_SAMPLE_S: f64 = 0.01;

/// Inverse of the averaging time relative to the record, where none is given: most of the record's reversals then count in each
/// estimate of N, and each averaging time has many of them.
const USUAL_PART: u64 = 64;

/// Relative deviation of an averaging time from a whole number of samples that counts as rounding.
const WHOLE: f64 = 1e-9;

/// The times of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Times {
    /// Time from one sample to the next, s.
    pub sample_s: f64,
    /// Periods of the dither in it; 0 where samples are not tied to them.
    pub periods: u64,
    /// Number of samples N; there are N + 1 angles.
    pub samples: u64,
    /// Averaging factors, ascending.
    pub ms: Vec<u64>,
}

impl Times {
    /// Length of the record, s.
    pub fn length_s(&self) -> f64 {
        self.sample_s * self.samples as f64
    }
}

/// Checks limits that involve more than one value, and chooses the times that are not given.
pub(crate) fn check(
    inputs: &Inputs,
    taus: Option<&Taus>,
    estimator: Estimator,
    places: &Places,
) -> Result<Times, Fault> {
    if let Some(dither) = &inputs.dither
        && dither.rate <= inputs.threshold
    {
        let message = format!(
            "lock_in.threshold = {} ″/s is not below the amplitude of the dither rate, {} ″/s: the gyro is locked",
            significant(inputs.threshold, 6),
            significant(dither.rate, 6)
        );
        let help = "accepted: a threshold below dither.rate, or leave [dither] out for a gyro without dither";
        return places.refuse(&[THRESHOLD.name, DITHER_RATE.name], message, "locked", help);
    }
    let (sample_s, periods) = sampled(inputs);
    let samples = libm::round(inputs.length_s / sample_s);
    if !(MIN_SAMPLES as f64..=MAX_SAMPLES as f64).contains(&samples) {
        let label = if samples < MIN_SAMPLES as f64 { "too short" } else { "too long" };
        let [length, sample] = [inputs.length_s, sample_s].map(|s| significant(s, 6));
        let message =
            format!("record.length = {length} s is {} samples of {sample} s", significant(samples, 6));
        let [shortest, longest] =
            [MIN_SAMPLES, MAX_SAMPLES].map(|samples| significant(samples as f64 * sample_s, 6));
        let help =
            format!("accepted: {MIN_SAMPLES} to {MAX_SAMPLES} samples, {shortest} s to {longest} s here");
        return places.refuse(&[LENGTH.name, SAMPLE.name, FREQUENCY.name], message, label, help);
    }
    let samples = samples as u64;
    let ms = factors(sample_s, samples, taus, estimator, places)?;
    Ok(Times { sample_s, periods, samples, ms })
}

/// Time from one sample to the next, s, and the periods of the dither in it.
fn sampled(inputs: &Inputs) -> (f64, u64) {
    match &inputs.dither {
        None => (inputs.sample_s.unwrap_or(USUAL_SAMPLE_S), 0),
        Some(dither) => {
            let asked = inputs.sample_s.map_or(1.0, |sample_s| sample_s * dither.frequency_hz);
            if dither.readout == Readout::Stripped {
                let periods = libm::fmax(libm::round(asked), 1.0);
                return (periods / dither.frequency_hz, periods as u64);
            }
            (asked / dither.frequency_hz, 0)
        }
    }
}

/// The averaging factors of the record's angles.
fn factors(
    sample_s: f64,
    samples: u64,
    taus: Option<&Taus>,
    estimator: Estimator,
    places: &Places,
) -> Result<Vec<u64>, Fault> {
    let Some(taus) = taus else { return Ok(vec![1 << (samples / USUAL_PART).max(1).ilog2()]) };
    let fault = |message: String, label| {
        let help = "give multiples of the sampling time, a longer record, or tau = \"octave\"";
        Err(Fault::new(places.blame(&["allan.tau"]), message, label, help))
    };
    if let Taus::Seconds(times) = taus {
        for tau_s in times {
            let m = tau_s / sample_s;
            if libm::fabs(m - libm::round(m)) > WHOLE * m {
                let [tau, sample] = [*tau_s, sample_s].map(|s| significant(s, 9));
                return fault(
                    format!("allan.tau = {tau} s is no multiple of {sample} s"),
                    "between two samples",
                );
            }
        }
    }
    let deviation = match estimator.difference {
        Difference::Second => Deviation::Oadev,
        Difference::Third => Deviation::Ohdev,
    };
    let found = taus.factors(samples as usize + 1, sample_s, deviation);
    let mut ms: Vec<u64> = match found {
        Ok(found) => found.into_iter().map(|m| m as u64).collect(),
        Err(error) => {
            let text = error.to_string();
            let label =
                if matches!(error, TauError::Long { .. }) { "too long" } else { "not for this record" };
            return fault(format!("allan.tau: {}", text.lines().next().unwrap_or_default()), label);
        }
    };
    if let (Taus::Decade(_), Stride::Part(parts)) = (taus, estimator.stride) {
        // Differences are whole strides apart, and a factor without divisors would force a stride of one sample.
        ms.iter_mut().for_each(|m| *m -= *m % (1 << (*m / parts).max(1).ilog2()));
        ms.dedup();
    }
    Ok(ms)
}
