//! Check that every part of a noise model has enough units in its words.

use crate::key::row::{Refusal, shown};
use crate::kinds::allan::lower::fixed::{Fixed, SIGMA_UNITS, TURN, loss};
use crate::kinds::allan::lower::model::{Markov, Model, Sine};
use sagnac_base::quantity::number::significant;
use sagnac_theory::allan::estimator::Difference;

/// Fewest units of a standard deviation or an amplitude, which is then rounded by at most 1 %.
const MIN_UNITS: f64 = 50.0;
/// Fewest LSB of the largest difference of a ramp or a warm-up, and of the range of an alternating drift.
const MIN_TREND: f64 = 128.0;
/// Fewest units of 2^−32 turns by which the phase of a sine advances in a sample.
const MIN_TURN: f64 = 64.0;

/// Refuses a correlation so long that what the rate loses in a sample has too few units, whatever the unit of angle.
pub(crate) fn check_decay(markov: Option<Markov>) -> Result<(), Refusal> {
    let Some(Markov { decay, .. }) = markov.filter(|markov| loss(markov.decay) < MIN_UNITS) else {
        return Ok(());
    };
    let found = format!(
        "a correlation time of {} samples is too long for 32-bit arithmetic, which takes 2 * 10^7",
        shown(1.0 / decay)
    );
    Err(Refusal::new("noise.markov", found, "take a rate random walk in its place"))
}

impl Fixed {
    /// Refuses the first part that is too small next to `whole`, the largest difference of the angle, ″. The message states their
    /// ratio, without a unit, because the record of an accelerometer is simulated in µg·s instead.
    pub(crate) fn check(&self, model: &Model, whole: f64) -> Result<(), Refusal> {
        let Model { noise, .. } = model;
        let check = |key, what: &str, found: f64, units: f64, least: f64| {
            if found == 0.0 || units >= least {
                return Ok(());
            }
            let lost = format!(
                "{what} is lost in 32-bit arithmetic: over {} samples the record has differences up to {} times as large",
                model.samples,
                significant(whole / libm::fabs(found), 3)
            );
            let help = "make it larger, or 0; or what is large beside it smaller, or the record shorter";
            Err(Refusal::new(key, lost, help))
        };
        let sigma = |key, what, found, word: u32| check(key, what, found, word.into(), MIN_UNITS);
        let (key, what) = ("noise.quantization", "quantization noise");
        sigma(key, what, noise.quantization, self.quantization)?;
        let (key, what) = ("noise.angle_random_walk", "white noise");
        check(key, what, noise.white, noise.white / self.lsb_arcsec * SIGMA_UNITS, MIN_UNITS)?;
        let (key, what) = ("noise.bias_instability", "flicker noise");
        for (&found, &word) in noise.octaves.iter().zip(core::iter::once(&self.white).chain(&self.flicker)) {
            sigma(key, what, found, word)?;
        }
        sigma("noise.rate_random_walk", "a step of the rate", noise.walk, self.walk)?;
        if let (Some(Markov { sigma: found, .. }), Some([_, step, _])) = (noise.markov, self.markov) {
            sigma("noise.markov", "Markov noise", found, step)?;
        }
        if let (Some(Sine { amplitude, turns }), Some([_, word])) = (model.sine, self.sine) {
            if libm::fabs(turns - libm::round(turns)) * TURN < MIN_TURN {
                let found = format!(
                    "{} periods a sample are too near a whole number: from sample to sample the phase must turn by more than \
                     2^-26",
                    significant(turns, 12)
                );
                let help = "take another frequency, or a rate ramp in its place";
                return Err(Refusal::new("noise.sine", found, help));
            }
            sigma("noise.sine", "a sine", amplitude, word)?;
        }
        let m = model.longest(Difference::Second) as f64;
        let ramp = libm::fabs(model.ramp) * m * m / self.lsb_arcsec;
        check("noise.rate_ramp", "a ramp", model.ramp, ramp, MIN_TREND)?;
        for warm_up in &model.warm_ups {
            let part = libm::expm1(-warm_up.decay * m);
            let largest = libm::fabs(warm_up.reach) * part * part / self.lsb_arcsec;
            check("noise.warm_up", "a warm-up", warm_up.rate(), largest, MIN_TREND)?;
        }
        if let Some(switching) = model.switching {
            let (key, what) = ("noise.switching.magnetic", "an alternating angle");
            check(key, what, model.sawtooth, model.sawtooth / self.lsb_arcsec, MIN_TREND)?;
            let [_, amplitude, noise] = self.switching.unwrap_or_default();
            sigma("noise.switching.residual", "an amplitude", switching.residual, amplitude)?;
            sigma("noise.switching.residual_noise", "a noise", switching.residual_noise, noise)?;
        }
        Ok(())
    }
}
