//! The parts of the error of a gyro with lock-in.

use crate::kinds::lock_in::inputs::{Dither, Inputs};
use crate::study::Part;

/// All parts. The threshold has no value without lock-in, so a negligible one takes its place.
pub(crate) static PARTS: [Part<Inputs>; 5] = [
    Part { name: "lock-in", off: |inputs| inputs.threshold *= NEGLIGIBLE },
    Part { name: "noise of the beam", off: |inputs| inputs.beam_noise = 0.0 },
    Part {
        name: "amplitude noise of the dither",
        off: |inputs| with_dither(inputs, |dither| dither.amplitude_noise = 0.0),
    },
    Part {
        name: "amplitude walk of the dither",
        off: |inputs| with_dither(inputs, |dither| dither.amplitude_walk = 0.0),
    },
    Part {
        name: "phase noise of the dither",
        off: |inputs| with_dither(inputs, |dither| dither.phase_noise = 0.0),
    },
];

/// Part of the threshold that has no effect.
const NEGLIGIBLE: f64 = 1e-6;

fn with_dither(inputs: &mut Inputs, off: impl FnOnce(&mut Dither)) {
    if let Some(dither) = &mut inputs.dither {
        off(dither);
    }
}
