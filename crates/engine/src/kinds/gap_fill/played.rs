//! The error of some weights on a motion, played as it is or faster: its rms and its 99.73 % level.

use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::judged::{Size, played, rms};
use crate::motion::keys::Phase;
use crate::motion::{Frequency, Motion, Tone, Value};
use crate::tally::LEVEL;
use sagnac_theory::level::of_sine;
use sagnac_theory::quadrature::Rule;
use sagnac_theory::rows::TickRows;

/// A motion at a speed.
pub(crate) struct Played<'a> {
    inputs: &'a Inputs,
    /// Its ticks, ″.
    rows: TickRows,
    /// The sine that the motion is, at each of the frequencies from which it is drawn, with their probabilities; empty for
    /// other motions, whose errors count as normally distributed.
    sines: Vec<(TickRows, f64)>,
}

impl<'a> Played<'a> {
    /// The motion of `inputs` played faster by a factor, with `sides` ticks on either side of the gap.
    pub(crate) fn new(inputs: &'a Inputs, speed: f64, sides: usize) -> Played<'a> {
        let at = |frequency_hz: f64| {
            let tone = Tone { frequency: Frequency::Fixed(frequency_hz), ..inputs.motion.tones[0] };
            let inputs = Inputs { motion: Motion::of_tone(tone), ..inputs.clone() };
            played(&inputs, speed, sides)
        };
        let sines = match sine(&inputs.motion).map(|tone| &tone.frequency) {
            None => vec![],
            Some(Frequency::Fixed(frequency_hz)) => vec![(at(*frequency_hz), 1.0)],
            Some(Frequency::Band(band)) => {
                let mut sines = Vec::new();
                let width = band.high_hz - band.low_hz;
                Rule::Panels.integrate(band.low_hz, band.high_hz, 0.0, |frequency_hz, weight| {
                    sines.push((at(frequency_hz), weight / width));
                });
                sines
            }
        };
        Played { inputs, rows: played(inputs, speed, sides), sines }
    }

    /// The size of the error, with noise.
    pub(crate) fn errors(&self, ticks: &[i32], weights: &[f64]) -> Size {
        let Played { inputs, rows, sines } = self;
        let of = |rows: &TickRows| rms(inputs, ticks, weights, rows);
        let all = of(rows);
        if sines.is_empty() {
            return Size { rms: all, level: of_sine(&[(0.0, 1.0)], all, LEVEL) };
        }
        let amplitude = |(rows, share): &(TickRows, f64)| {
            // A sine of uniform phase has half its squared amplitude as variance.
            (libm::sqrt(2.0 * rows.error_variance(ticks, weights, inputs.gap_ticks)), *share)
        };
        let amplitudes: Vec<(f64, f64)> = sines.iter().map(amplitude).collect();
        Size { rms: all, level: of_sine(&amplitudes, of(&TickRows::default()), LEVEL) }
    }
}

/// The single sine of fixed amplitude and uniform phase that a motion is; `None` for other motions.
fn sine(motion: &Motion) -> Option<&Tone> {
    let [tone] = &motion.tones[..] else { return None };
    let is_alone = motion.gaussian.is_none() && motion.profile.is_none();
    let is_plain = tone.phase == Phase::Uniform && matches!(tone.amplitude.value, Value::Fixed(_));
    (is_alone && is_plain).then_some(tone)
}
