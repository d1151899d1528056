//! The closed forms of the Allan variance against sampled noise, straight from the definition of each part.

use crate::noise::{angles, record};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::theory::allan::{Difference, Estimator, Part, Process, Stride};
use sagnac::theory::pulse;

/// Standard errors within which a mean has to lie.
const SIGMAS: f64 = 5.0;
const SAMPLES: usize = 3000;
const MS: [u64; 10] = [1, 2, 3, 8, 25, 64, 200, 500, 1000, 1500];

fn estimate(estimator: Estimator, theta: &[f64], t0: f64, m: u64) -> f64 {
    let terms = estimator.terms(theta.len() as u64 - 1, m);
    let square = |k: u64| {
        let coefficients = estimator.difference.coefficients().iter().enumerate();
        let value: f64 = coefficients.map(|(i, c)| c * theta[(k + i as u64 * m) as usize]).sum();
        value * value
    };
    let sum: f64 = (0..terms).map(|i| square(i * estimator.stride(m))).sum();
    let tau = t0 * m as f64;
    sum / (terms as f64 * estimator.difference.divisor() * tau * tau)
}

const ESTIMATORS: [Estimator; 4] = [
    Estimator::OVERLAPPING,
    Estimator::NON_OVERLAPPING,
    Estimator::HADAMARD,
    Estimator { difference: Difference::Second, stride: Stride::Part(64) },
];

/// Mean of each estimator over `trials` records, against what is expected.
fn compare(
    name: &str,
    process: &Process,
    trials: usize,
    mut record: impl FnMut() -> Vec<f64>,
    extra: impl Fn(Estimator, u64) -> f64,
) {
    let cases: Vec<(Estimator, u64)> =
        ESTIMATORS.into_iter().flat_map(|estimator| MS.map(|m| (estimator, m))).collect();
    let mut sums = vec![[0.0; 2]; cases.len()];
    let mut largest: f64 = 0.0;
    for _ in 0..trials {
        let theta = record();
        largest = theta.iter().fold(largest, |largest, angle| largest.max(angle.abs()));
        for ((estimator, m), sum) in cases.iter().zip(&mut sums) {
            if estimator.terms(SAMPLES as u64, *m) > 0 {
                let value = estimate(*estimator, &theta, process.sample_s, *m);
                *sum = [sum[0] + value, sum[1] + value * value];
            }
        }
    }
    let mut worst: f64 = 0.0;
    for ((estimator, m), [sum, squares]) in cases.iter().zip(sums) {
        let Some(expected) = process.expected(*estimator, SAMPLES as u64, *m) else { continue };
        let expected = expected + extra(*estimator, *m);
        let mean = sum / trials as f64;
        let se = ((squares / trials as f64 - mean * mean).max(0.0) / trials as f64).sqrt();
        // Rounding of the angles shows where parts without scatter nearly cancel.
        let tau = process.sample_s * *m as f64;
        let rounding = 8.0 * f64::EPSILON * largest / tau;
        let z = (mean - expected) / (se + rounding * (rounding + 2.0 * expected.sqrt()));
        worst = worst.max(z.abs());
        assert!(z.abs() < SIGMAS, "{name}, {estimator:?}, m = {m}: {mean} ± {se}, not {expected}: z = {z}");
    }
    println!("{name}: {trials} records, largest |z| = {worst:.2}");
}

#[test]
fn each_part_sampled_has_the_expected_variances() {
    let t0 = 0.25;
    let parts = [
        Part::quantization(0.11),
        Part::angle_random_walk(0.03),
        Part::bias_instability(0.002, 24),
        Part::rate_random_walk(1e-3),
        Part::markov(1e-3, 20.0),
        Part::markov(1e-3, 0.1),
        Part::sine(0.1, 0.0371),
        Part::rate_ramp(1e-4),
        Part::warm_up(0.5, 100.0),
    ];
    for (i, part) in parts.into_iter().enumerate() {
        let process = Process { sample_s: t0, parts: vec![part] };
        let mut rng = StdRng::seed_from_u64(4000 + i as u64);
        compare(&format!("{part:?}"), &process, 1000, || angles(part, t0, SAMPLES, &mut rng), |_, _| 0.0);
    }
    // Together, ramp and warm-up add before they are squared.
    let process = Process { sample_s: t0, parts: parts.to_vec() };
    let mut rng = StdRng::seed_from_u64(4100);
    let all = || record(&process, SAMPLES, &mut rng);
    compare("all", &process, 1000, all, |_, _| 0.0);
}

#[test]
fn a_readout_of_whole_pulses_adds_the_variance_of_its_closed_form() {
    let (t0, q, rate) = (0.25, 0.38, 15.041);
    let parts = [
        Part::angle_random_walk(0.05),
        Part::markov(3e-3, 10.0),
        Part::sine(0.3, 0.31),
        Part::quantization(0.01),
    ];
    for (name, parts) in [("noise", &parts[..1]), ("all", &parts[..])] {
        let process = Process { sample_s: t0, parts: parts.to_vec() };
        let mut rng = StdRng::seed_from_u64(4200 + parts.len() as u64);
        let pulses = || {
            let noise = record(&process, SAMPLES, &mut rng);
            let start: f64 = rng.random();
            let pulse = |(k, angle): (usize, f64)| q * ((rate * t0 * k as f64 + angle) / q + start).floor();
            noise.into_iter().enumerate().map(pulse).collect()
        };
        let readout = |estimator: Estimator, m: u64| {
            let difference = estimator.difference;
            let mean_square = pulse::mean_square(q, rate, &process, difference, m).unwrap();
            let white = q * q / 12.0 * difference.coefficients().iter().map(|c| c * c).sum::<f64>();
            let bound = pulse::white_error(q, &process, difference, m);
            assert!(
                (mean_square - white).abs() <= bound + 1e-15,
                "m = {m}: {mean_square}, {white} ± {bound}"
            );
            let tau = t0 * m as f64;
            mean_square / (difference.divisor() * tau * tau)
        };
        compare(&format!("readout, {name}"), &process, 1000, pulses, readout);
    }
}
