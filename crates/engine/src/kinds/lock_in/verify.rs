//! Named gyros that cover every distinction made by the kernel of lock-in.

use std::sync::Arc;

use crate::device::{Work, Workload};
use crate::key::Streams;
use crate::kinds::lock_in::lower::Gyros;
use crate::kinds::lock_in::{Dither, Inputs, Point, Readout, Times};
use crate::motion::{Motion, Tone};
use sagnac_theory::allan::{Difference, Estimator, Stride};

const THINNED: Estimator = Estimator { difference: Difference::Second, stride: Stride::Part(64) };

/// The gyro of the checked figure of docs/dev/equations.md: 180 ″/s, 2 ″ per pulse, dithered by 100 °/s at 400 Hz.
pub fn checked() -> Inputs {
    Inputs {
        scale_factor: 2.0,
        threshold: 180.0,
        beam_noise: 0.0,
        refinement: 1.0,
        dither: Some(Dither {
            frequency_hz: 400.0,
            rate: 360_000.0,
            amplitude_noise: 0.02,
            ..Dither::default()
        }),
        rate: 37.0,
        ramp: 0.0,
        motion: None,
        sample_s: None,
        length_s: 10.0,
    }
}

/// Lowers a gyro whose record has so many samples, each of so many periods of the dither, or of 10 ms without dither.
///
/// # Panics
/// The gyro cannot be represented.
pub fn lowered(inputs: &Inputs, periods: u64, samples: u64, estimator: Estimator) -> Gyros {
    let sample_s = match &inputs.dither {
        Some(dither) => periods as f64 / dither.frequency_hz,
        None => 0.01,
    };
    let is_tied = inputs.dither.is_some() && inputs.readout() == Readout::Stripped;
    let times = Times {
        sample_s,
        periods: if is_tied { periods } else { 0 },
        samples,
        ms: (0..63).map(|octave| 1 << octave).take_while(|&m| estimator.terms(samples, m) > 0).collect(),
    };
    let point = Point { swept: vec![], inputs: inputs.clone(), times };
    Gyros::new(&point, estimator, 1, Streams::Independent)
        .unwrap_or_else(|refusal| panic!("{inputs:?} does not lower: {refusal}"))
}

/// The loads on which the kernel is checked.
pub fn loads() -> Vec<Workload> {
    let load = |(name, gyros): (&'static str, Gyros)| Workload {
        name,
        self_test_units: (name == "everything").then(|| 40 * u64::from(gyros.recipe().samples)),
        work: Work::Records(Arc::new(gyros.recipe().clone())),
    };
    named_gyros().into_iter().map(load).collect()
}

/// Gyros that cover every distinction made by the kernel.
pub fn named_gyros() -> Vec<(&'static str, Gyros)> {
    let with = |change: fn(&mut Dither)| {
        let mut inputs = checked();
        inputs.dither.as_mut().into_iter().for_each(change);
        inputs
    };
    let still = Inputs { dither: None, rate: 200.0, ..checked() };
    let small = |dither: &mut Dither| dither.rate = 3000.0;
    let everything = |dither: &mut Dither| {
        *dither = Dither {
            frequency_hz: 270.0,
            rate: 7200.0,
            amplitude_noise: 0.02,
            amplitude_walk: 0.001,
            phase_noise: 900.0,
            readout: Readout::Demodulated,
        };
    };
    let motion = Some(Motion::of_tone(Tone::of_rate(500.0, 3.0)));
    let everything = Inputs { motion, beam_noise: 0.05, ramp: -30.0, rate: -900.0, ..with(everything) };
    let shaken = Inputs { motion: Some(Motion::of_tone(Tone::of_rate(3000.0, 7.0))), ..checked() };
    let hadamard = Estimator { difference: Difference::Third, ..THINNED };
    vec![
        ("no dither", lowered(&still, 0, 130, THINNED)),
        ("no dither, with noise", lowered(&Inputs { beam_noise: 0.1, ramp: 50.0, ..still }, 0, 130, THINNED)),
        ("dither without noise", lowered(&with(|dither| dither.amplitude_noise = 0.0), 1, 130, THINNED)),
        ("amplitude noise", lowered(&checked(), 1, 130, THINNED)),
        ("small dither", lowered(&with(small), 3, 200, THINNED)),
        (
            "dither left in",
            lowered(
                &with(|dither| (dither.rate, dither.readout) = (9000.0, Readout::Dithered)),
                1,
                130,
                THINNED,
            ),
        ),
        ("motion of the base", lowered(&shaken, 1, 130, THINNED)),
        ("everything", lowered(&everything, 1, 200, THINNED)),
        ("everything-hadamard", lowered(&everything, 1, 200, hadamard)),
    ]
}
