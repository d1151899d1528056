//! The error of some weights on a motion, played as it is or faster: its rms and its 99.73 % level.

use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::judged::{played, rms};
use crate::motion::keys::Phase;
use crate::motion::{Frequency, Motion, Tone, Value};
use crate::tally::stats::LEVEL;
use crate::theory::level::of_sine;
use crate::theory::minimum_variance::error_variance;
use crate::theory::quadrature::pairs;

/// A motion at a speed, as the covariance of its ticks by lag, ″².
pub(crate) struct Played<'a> {
    inputs: &'a Inputs,
    pub(crate) covariance: Vec<f64>,
    /// The sine that the motion is, at each of the frequencies from which it is drawn, with their probabilities; empty for
    /// other motions, whose errors count as normally distributed.
    sines: Vec<(Vec<f64>, f64)>,
}

impl<'a> Played<'a> {
    /// The motion of `inputs` played faster by a factor.
    pub(crate) fn new(inputs: &'a Inputs, speed: f64, lags: usize) -> Played<'a> {
        let at = |frequency_hz: f64| {
            let tone = Tone { frequency: Frequency::Fixed(frequency_hz), ..inputs.motion.tones[0] };
            let inputs = Inputs { motion: Motion::of_tone(tone), ..inputs.clone() };
            played(&inputs, speed, lags)
        };
        let sines = match sine(&inputs.motion).map(|tone| &tone.frequency) {
            None => vec![],
            Some(Frequency::Fixed(frequency_hz)) => vec![(at(*frequency_hz), 1.0)],
            Some(Frequency::Band(band)) => pairs(band.low_hz, band.high_hz, 1.0)
                .flat_map(|(both, weight)| both.map(|frequency_hz| (frequency_hz, 0.5 * weight)))
                .map(|(frequency_hz, share)| (at(frequency_hz), share))
                .collect(),
        };
        Played { inputs, covariance: played(inputs, speed, lags), sines }
    }

    /// The rms error and the level below which 99.73 % of errors stay, with noise, ″.
    pub(crate) fn errors(&self, ticks: &[i32], weights: &[f64]) -> [f64; 2] {
        let Played { inputs, covariance, sines } = self;
        let of = |covariance: &[f64]| rms(inputs, ticks, weights, covariance);
        let all = of(covariance);
        if sines.is_empty() {
            return [all, of_sine(&[(0.0, 1.0)], all, LEVEL)];
        }
        let amplitude = |(covariance, share): &(Vec<f64>, f64)| {
            let variance = error_variance(ticks, weights, inputs.gap_ticks, covariance, 0.0);
            // A sine of uniform phase has half its squared amplitude as variance.
            (libm::sqrt(2.0 * variance.max(0.0)), *share)
        };
        let amplitudes: Vec<(f64, f64)> = sines.iter().map(amplitude).collect();
        [all, of_sine(&amplitudes, of(&vec![0.0; covariance.len()]), LEVEL)]
    }
}

/// The single sine of fixed amplitude and uniform phase that a motion is; `None` for other motions.
fn sine(motion: &Motion) -> Option<&Tone> {
    let [tone] = &motion.tones[..] else { return None };
    let is_alone = motion.gaussian.is_none() && motion.profile.is_none();
    let is_plain = tone.phase == Phase::Uniform && matches!(tone.amplitude.value, Value::Fixed(_));
    (is_alone && is_plain).then_some(tone)
}
