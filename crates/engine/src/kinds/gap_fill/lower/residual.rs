//! The residual that a filler leaves at a switch, as a function of the phase of the motion there; whole runs accumulate
//! it.

use crate::filler::read::Error;
use crate::kinds::gap_fill::lower::estimate::{Estimate, functionals};
use crate::kinds::gap_fill::lower::{Lowered, readout};
use sagnac_kernel::relock_ticks::MAX_TICKS;

/// The residual of a switch, ″.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Residual {
    /// Sines of the phases of the tones.
    pub tones: Vec<ResidualTone>,
    /// Constant part, the same at every switch.
    pub constant_arcsec: f64,
    /// Variance of the part that is normally distributed or taken as such: noise, Gaussian motion, fractions of a
    /// pulse, drawn amplitudes and frequencies, profiles.
    pub variance_arcsec2: f64,
    /// Weights of the filler on the ticks n+1, n+2, … as far as a relock can reach.
    pub after: Vec<f64>,
}

impl Residual {
    /// Root mean square over switches, ″.
    pub fn rms(&self) -> f64 {
        let squares = self.tones.iter().map(|tone| 0.5 * tone.amplitude_arcsec * tone.amplitude_arcsec);
        let swinging: f64 = squares.sum();
        libm::sqrt(self.constant_arcsec * self.constant_arcsec + self.variance_arcsec2 + swinging)
    }
}

/// The part of the residual from a tone of random phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualTone {
    /// Amplitude of the residual angle, ″.
    pub amplitude_arcsec: f64,
    /// Index of the tone in the motion.
    pub tone: usize,
}

impl Lowered {
    /// The residual of a filler, from the words with which its trials are sampled; `None` where it has none.
    pub fn residual(&self, filler: usize) -> Option<Residual> {
        let estimate: &Estimate =
            self.fillers[filler].iter().find(|estimate| estimate.error == Error::Residual)?;
        let fixed = &self.fixed;
        let all = functionals(&estimate.rows, Error::Residual, fixed.gap_ticks);
        let f = all.last()?;
        let whole = fixed.response(f);
        let (mut mean, mut variance) = (whole.mean, whole.variance);
        let mut tones = Vec::new();
        for (place, tone) in fixed.tones.iter().enumerate() {
            if tone.is_sine() {
                let part = tone.response(f, fixed.gap_ticks);
                // A sine of uniform phase has half its squared amplitude as variance.
                mean -= part.mean;
                variance -= part.variance;
                tones.push((place, libm::sqrt(2.0 * part.variance)));
            }
        }
        let sigma = fixed.sigma_lsb() * f.noise_gain();
        let fractions = readout::variance(fixed, f);
        let unit = fixed.lsb_arcsec / estimate.rows.denominator as f64;
        // Differences of equal numbers may come out below 0.
        let normal = (variance.max(0.0) + sigma * sigma + fractions).max(0.0);
        let weight = |tick: i32| {
            let place = f.ticks.iter().position(|&own| own == tick);
            place.map_or(0.0, |place| f.weights[place] as f64 / f.scale as f64)
        };
        let after = (1..=MAX_TICKS as i32).map(|k| weight(fixed.gap_ticks + k));
        let tones =
            tones.into_iter().map(|(tone, size)| ResidualTone { tone, amplitude_arcsec: size * unit });
        Some(Residual {
            tones: tones.filter(|tone| tone.amplitude_arcsec > 0.0).collect(),
            constant_arcsec: mean * unit,
            variance_arcsec2: normal * unit * unit,
            after: after.collect(),
        })
    }
}
