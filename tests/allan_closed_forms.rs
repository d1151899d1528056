//! The closed forms of the Allan variance against sampled noise, straight from the definition of each part.

use core::f64::consts::{LN_2, PI, TAU};

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::theory::allan::{Difference, Estimator, Part, Process, Stride, holds, quantiser};

/// Standard errors within which a mean has to lie.
const SIGMAS: f64 = 5.0;
const SAMPLES: usize = 3000;
const MS: [u64; 10] = [1, 2, 3, 8, 25, 64, 200, 500, 1000, 1500];

/// A normal number, by Box and Muller.
fn normal(rng: &mut StdRng) -> f64 {
    let (radius, turn): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - radius).ln()).sqrt() * (TAU * turn).cos()
}

/// N + 1 angles of one part.
fn angles(part: Part, t0: f64, rng: &mut StdRng) -> Vec<f64> {
    let held = |rates: &mut dyn FnMut(usize) -> f64| {
        let mut angle = 0.0;
        let rest = (0..SAMPLES).map(|k| {
            angle += t0 * rates(k);
            angle
        });
        core::iter::once(0.0).chain(rest).collect()
    };
    match part {
        Part::Quantisation { q } => (0..=SAMPLES).map(|_| q * normal(rng)).collect(),
        Part::AngleRandomWalk { n } => held(&mut |_| n / t0.sqrt() * normal(rng)),
        Part::BiasInstability { b, octaves } => {
            let level = 2.0 * LN_2 / PI * b * b;
            let mut rates = vec![0.0; SAMPLES];
            for (o, variance) in holds::variances(octaves).unwrap().into_iter().enumerate() {
                let length = 1_usize << o;
                let streams = if o < 3 { 1 } else { 4 };
                for _ in 0..streams {
                    let offset = rng.random_range(0..length);
                    let scale = (level * variance / f64::from(streams)).sqrt();
                    let mut hold = scale * normal(rng);
                    for (k, rate) in rates.iter_mut().enumerate() {
                        if (k + offset).is_multiple_of(length) {
                            hold = scale * normal(rng);
                        }
                        *rate += hold;
                    }
                }
            }
            held(&mut |k| rates[k])
        }
        Part::RateRandomWalk { k } => {
            let mut rate = 0.0;
            held(&mut |_| {
                rate += k * t0.sqrt() * normal(rng);
                rate
            })
        }
        Part::Markov { q_c, time_s } => {
            let (a, sigma) = ((-t0 / time_s).exp(), q_c * (0.5 * time_s).sqrt());
            let mut rate = sigma * normal(rng);
            held(&mut |_| {
                rate = a * rate + sigma * (1.0 - a * a).sqrt() * normal(rng);
                rate
            })
        }
        Part::Sine { amplitude, frequency_hz } => {
            let phase: f64 = rng.random();
            let at = |k: usize| (TAU * (frequency_hz * t0 * k as f64 + phase)).cos();
            (0..=SAMPLES).map(|k| -amplitude / (TAU * frequency_hz) * at(k)).collect()
        }
        Part::RateRamp { r } => (0..=SAMPLES).map(|k| 0.5 * r * (t0 * k as f64).powi(2)).collect(),
        Part::WarmUp { amplitude, time_s } => {
            (0..=SAMPLES).map(|k| -amplitude * time_s * (-t0 * k as f64 / time_s).exp_m1()).collect()
        }
    }
}

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
        Part::Quantisation { q: 0.11 },
        Part::AngleRandomWalk { n: 0.03 },
        Part::BiasInstability { b: 0.002, octaves: 24 },
        Part::RateRandomWalk { k: 1e-3 },
        Part::Markov { q_c: 1e-3, time_s: 20.0 },
        Part::Markov { q_c: 1e-3, time_s: 0.1 },
        Part::Sine { amplitude: 0.1, frequency_hz: 0.0371 },
        Part::RateRamp { r: 1e-4 },
        Part::WarmUp { amplitude: 0.5, time_s: 100.0 },
    ];
    for (i, part) in parts.into_iter().enumerate() {
        let process = Process { sample_s: t0, parts: vec![part] };
        let mut rng = StdRng::seed_from_u64(4000 + i as u64);
        compare(&format!("{part:?}"), &process, 1000, || angles(part, t0, &mut rng), |_, _| 0.0);
    }
    // Together, ramp and warm-up add before they are squared.
    let process = Process { sample_s: t0, parts: parts.to_vec() };
    let mut rng = StdRng::seed_from_u64(4100);
    let all = || {
        let each: Vec<Vec<f64>> = parts.iter().map(|&part| angles(part, t0, &mut rng)).collect();
        (0..=SAMPLES).map(|k| each.iter().map(|theta| theta[k]).sum()).collect()
    };
    compare("all", &process, 1000, all, |_, _| 0.0);
}

#[test]
fn a_readout_of_whole_pulses_adds_the_variance_of_its_closed_form() {
    let (t0, q, rate) = (0.25, 0.38, 15.041);
    let parts = [
        Part::AngleRandomWalk { n: 0.05 },
        Part::Markov { q_c: 3e-3, time_s: 10.0 },
        Part::Sine { amplitude: 0.3, frequency_hz: 0.31 },
        Part::Quantisation { q: 0.01 },
    ];
    for (name, parts) in [("noise", &parts[..1]), ("all", &parts[..])] {
        let process = Process { sample_s: t0, parts: parts.to_vec() };
        let mut rng = StdRng::seed_from_u64(4200 + parts.len() as u64);
        let record = || {
            let each: Vec<Vec<f64>> = process.parts.iter().map(|&part| angles(part, t0, &mut rng)).collect();
            let start: f64 = rng.random();
            let true_angle = |k: usize| rate * t0 * k as f64 + each.iter().map(|theta| theta[k]).sum::<f64>();
            (0..=SAMPLES).map(|k| q * (true_angle(k) / q + start).floor()).collect()
        };
        let readout = |estimator: Estimator, m: u64| {
            let difference = estimator.difference;
            let mean_square = quantiser::mean_square(q, rate, &process, difference, m).unwrap();
            let white = q * q / 12.0 * difference.coefficients().iter().map(|c| c * c).sum::<f64>();
            let bound = quantiser::white_error(q, &process, difference, m);
            assert!(
                (mean_square - white).abs() <= bound + 1e-15,
                "m = {m}: {mean_square}, {white} ± {bound}"
            );
            let tau = t0 * m as f64;
            mean_square / (difference.divisor() * tau * tau)
        };
        compare(&format!("readout, {name}"), &process, 1000, record, readout);
    }
}
