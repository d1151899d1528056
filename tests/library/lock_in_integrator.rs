//! Gyros of the kernel against an adaptive integrator in f64, which shares only the draws with it.

use std::f64::consts::TAU;

use sagnac::theory::allan::Estimator;
use sagnac_engine::kinds::lock_in::verify::{checked, lowered};
use sagnac_engine::kinds::lock_in::{Dither, Inputs};

/// Largest error of a step of the integrator, in radians of the beat phase.
const TOLERANCE: f64 = 1e-10;
/// Largest difference of an angle, in pulses.
const MAX_DIFFERENCE: f64 = 1e-3;
/// Samples of a run, each of one period of the dither, or of 10 ms without it.
const SAMPLES: u64 = 40;

/// Nodes, weights of the stages, and weights of the fifth order less those of the fourth: Dormand and Prince, J. Comput. Appl.
/// Math. 6 (1980), 19–26.
const NODES: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
const STAGES: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
const ERRORS: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];

/// Integrates ẏ = f(t, y) from `from` to `to`, with steps whose error stays below the tolerance.
fn integrate(f: impl Fn(f64, f64) -> f64, mut y: f64, [from, to]: [f64; 2]) -> f64 {
    let mut t = from;
    let mut h = (to - from) / 64.0;
    while t < to {
        h = h.min(to - t);
        let mut slopes = [0.0; 7];
        let mut next = y;
        for stage in 0..7 {
            let by: f64 = STAGES[stage].iter().zip(slopes).map(|(weight, slope)| weight * slope).sum();
            next = y + h * by;
            slopes[stage] = f(t + NODES[stage] * h, next);
        }
        let error = h * ERRORS.iter().zip(slopes).map(|(weight, slope)| weight * slope).sum::<f64>();
        let ratio = libm::fabs(error) / TOLERANCE;
        if ratio <= 1.0 {
            // The last stage is the fifth order itself.
            (t, y) = if h == to - t { (to, next) } else { (t + h, next) };
        }
        h *= (0.9 * libm::pow(ratio.max(1e-10), -0.2)).clamp(0.2, 5.0);
    }
    y
}

/// The angle of a gyro beyond its input after each sample, in pulses, with the draws of the kernel.
fn angles(inputs: &Inputs, start: u32, amplitudes: &[f64], phases: &[f64]) -> Vec<f64> {
    let factor = TAU / inputs.scale_factor;
    let turned = |t: f64| factor * (inputs.rate * t + 0.5 * inputs.ramp * t * t);
    let psi = TAU * f64::from(start) / 4_294_967_296.0;
    let mut locked = 0.0;
    let mut angles = vec![0.0];
    for sample in 0..SAMPLES as usize {
        match &inputs.dither {
            None => {
                let ends = [sample, sample + 1].map(|end| 0.01 * end as f64);
                let slope = |t: f64, y: f64| factor * inputs.threshold * libm::sin(psi + turned(t) + y);
                locked = integrate(slope, locked, ends);
            }
            Some(dither) => {
                let half_s = 0.5 / dither.frequency_hz;
                for half in [2 * sample, 2 * sample + 1] {
                    let slope = |t: f64, y: f64| {
                        let turn = 0.5 * (t / half_s - half as f64);
                        let turn = turn + phases[half] * libm::sin(TAU * turn);
                        let dither = TAU * amplitudes[half] * libm::sin(TAU * turn);
                        factor * inputs.threshold * libm::sin(psi + turned(t) + dither + y)
                    };
                    let ends = [half, half + 1].map(|end| half_s * end as f64);
                    locked = integrate(slope, locked, ends);
                }
            }
        }
        angles.push(locked / TAU);
    }
    angles
}

/// Threshold and rate in ″/s, scale factor in ″, dither rate in ″/s and frequency in Hz, its amplitude noise, and its phase noise
/// in degrees.
const RUNS: [(f64, f64, f64, f64, f64, f64, f64); 16] = [
    (180.0, 37.0, 2.0, 360_000.0, 400.0, 0.02, 0.0),
    (180.0, 0.0, 2.0, 360_000.0, 400.0, 0.02, 0.0),
    (180.0, 523.0, 2.0, 360_000.0, 400.0, 0.02, 0.0),
    (180.0, 37.0, 2.0, 360_000.0, 400.0, 0.0, 0.0),
    (180.0, -37.0, 2.0, 360_000.0, 400.0, 0.002, 0.0),
    (180.0, 37.0, 2.0, 360_000.0, 400.0, 0.02, 0.5),
    (60.0, 1000.0, 1.0, 120_000.0, 270.0, 0.02, 0.0),
    (60.0, 15.041, 2.6, 250_000.0, 270.0, 0.03, 0.0),
    (400.0, -300.0, 2.0, 700_000.0, 400.0, 0.005, 0.0),
    (1000.0, 37.0, 2.0, 360_000.0, 400.0, 0.02, 0.0),
    (10.0, 5.0, 1.5, 36_000.0, 400.0, 0.1, 0.0),
    (5.0, 3.0, 2.0, 800.0, 400.0, 0.0, 0.0),
    (20.0, 801.0, 2.0, 2400.0, 400.0, 0.0, 0.0),
    (20.0, 1590.0, 2.0, 4000.0, 400.0, 0.05, 0.0),
    (180.0, 20_000.0, 2.0, 360_000.0, 400.0, 0.02, 0.0),
    (200.0, 100.0, 0.5, 100_000.0, 600.0, 0.01, 0.2),
];

#[test]
fn twenty_gyros_have_the_angles_of_an_adaptive_integrator() {
    let dithered =
        RUNS.map(|(threshold, rate, scale_factor, dither_rate, frequency_hz, amplitude_noise, phase)| {
            let dither = Dither {
                frequency_hz,
                rate: dither_rate,
                amplitude_noise,
                phase_noise: 3600.0 * phase,
                ..Dither::default()
            };
            // The difference grows with the threshold and falls with the steps.
            let refinement = if threshold >= 1000.0 { 2.0 } else { 1.0 };
            Inputs { threshold, rate, scale_factor, refinement, dither: Some(dither), ..checked() }
        });
    let still = [50.0, 185.0, -250.0, 3000.0].map(|rate| Inputs { rate, dither: None, ..checked() });
    let mut worst = 0.0_f64;
    for (number, inputs) in dithered.into_iter().chain(still).enumerate() {
        let gyros = lowered(&inputs, 1, SAMPLES, Estimator::OVERLAPPING);
        let recipe = gyros.recipe();
        let trace = recipe.trace(number as u64);
        let unit = libm::exp2(-f64::from(recipe.amplitude_bits));
        let amplitudes: Vec<f64> = trace.amplitudes.iter().map(|word| f64::from(*word) * unit).collect();
        let phases: Vec<f64> = trace.phases.iter().map(|word| f64::from(*word) / 4_294_967_296.0).collect();
        let expected = angles(&inputs, trace.start, &amplitudes, &phases);
        let lsb = gyros.lsb_arcsec() / inputs.scale_factor;
        assert_eq!(trace.angles.len(), expected.len());
        let mut of_run = 0.0_f64;
        for (sample, (word, expected)) in trace.angles.iter().zip(&expected).enumerate() {
            let found = f64::from(*word) * lsb;
            of_run = of_run.max((found - expected).abs());
            assert!(
                of_run < MAX_DIFFERENCE,
                "run {number}, sample {sample}: {found} pulses instead of {expected}: {inputs:?}"
            );
        }
        println!(
            "run {number}: largest difference {of_run:.1e} pulses of {:.3}",
            expected[expected.len() - 1]
        );
        worst = worst.max(of_run);
    }
    println!("largest difference {worst:.1e} pulses");
}
