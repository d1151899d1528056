//! Weights of navigation against an independent simulation and closed forms.

use std::f64::consts::PI;
use std::path::Path;

use sagnac::theory::navigation::covariance;
use sagnac::theory::navigation::equations::{ARCSEC, EARTH_RATE};
use sagnac::theory::navigation::weights::Times;
use sagnac::theory::navigation::{GRAVITY, Leg, RADIUS, Task, weights};

/// The rows of a file that `tests/data/navigation/simulate.py` wrote: the texts of the first columns, then the numbers.
fn rows(file: &str, texts: usize) -> Vec<(Vec<String>, Vec<f64>)> {
    let path = Path::new(crate::ROOT).join("tests/data/navigation").join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers = cells[texts..].iter().map(|cell| cell.parse().unwrap()).collect();
        (cells[..texts].iter().map(|cell| (*cell).to_owned()).collect(), numbers)
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn weights_give_the_errors_of_the_full_equations_to_a_ten_thousandth() {
    const SAMPLE: f64 = 2.0;
    let rows = rows("responses.csv", 5);
    assert_eq!(rows.len(), 18);
    for (start, numbers) in rows {
        let [latitude, speed, course, duration] = [0, 1, 2, 3].map(|at| start[at].parse::<f64>().unwrap());
        let gyro = ["north", "east", "down"].iter().position(|name| *name == start[4]).unwrap();
        let [a, b, c, f] = [0, 1, 2, 3].map(|at| numbers[at]);
        let course = course * PI / 180.0;
        let leg = Leg {
            earth_rate: EARTH_RATE,
            latitude: latitude * PI / 180.0,
            velocity: [speed * course.cos(), speed * course.sin()],
        };
        let samples = (duration / SAMPLE) as usize;
        let times = Times { sample_s: SAMPLE, alignment: 0, duration: samples, calibrates: false };
        let weights = &weights(&Task::Inertial(leg), &times)[gyro].of_errors;
        // 1 deg/h is 1 arcsec/s.
        let angle = |t: f64| {
            let sine = if f > 0.0 { c * (1.0 - (2.0 * PI * f * t).cos()) / (2.0 * PI * f) } else { 0.0 };
            a * t + b / 3600.0 * t * t / 2.0 + sine
        };
        let increment = |k: usize| angle((k + 1) as f64 * SAMPLE) - angle(k as f64 * SAMPLE);
        let found: Vec<f64> = weights
            .iter()
            .map(|weights| weights.iter().enumerate().map(|(k, weight)| weight * increment(k)).sum())
            .collect();
        let expected = &numbers[4..];
        // Small components are compared with the whole of their kind.
        for (kind, errors) in [("heading", 0..1), ("tilt", 1..3), ("velocity", 3..5), ("position", 5..7)] {
            let off = errors.clone().map(|e| found[e] - expected[e]).fold(0.0, f64::hypot);
            let size = errors.map(|e| expected[e]).fold(0.0, f64::hypot);
            assert!(off < 1e-4 * size, "{start:?}, {kind}: off by {off} of {size}");
        }
    }
}

#[test]
fn closed_forms_are_the_rms_of_an_independent_simulation() {
    let rows = rows("noise.csv", 1);
    assert_eq!(rows.len(), 6);
    let leg = Leg { earth_rate: EARTH_RATE, latitude: PI / 3.0, velocity: [0.0; 2] };
    for (noise, numbers) in rows {
        let [size, shape, duration] = [0, 1, 2].map(|at| numbers[at]);
        // Samples of 1 s.
        let times = Times { sample_s: 1.0, alignment: 0, duration: duration as usize, calibrates: false };
        let nothing = covariance::Noise::default();
        let of_increments = match noise[0].as_str() {
            "angle_random_walk" => covariance::Noise { white: size, ..nothing },
            "rate_random_walk" => covariance::Noise { walk: size, ..nothing },
            "markov" => covariance::Noise { markov: Some([size, 1.0 / shape]), ..nothing },
            other => panic!("{other}"),
        };
        let gyros = weights(&Task::Inertial(leg), &times);
        for (error, found) in numbers[3..].chunks_exact(2).enumerate() {
            let of_gyro = |gyro: &sagnac::theory::navigation::Weights| {
                of_increments.covariance(&gyro.of_errors[error], &gyro.of_errors[error])
            };
            let closed = gyros.iter().map(of_gyro).sum::<f64>().sqrt();
            let z = (found[0] - closed) / found[1];
            assert!(z.abs() < 5.0, "{}, {duration} s, error {error}: {z} standard errors", noise[0]);
        }
    }
}

/// wᵀCw of white noise with weights of one functional.
fn white(weights: &[f64], n: f64, sample_s: f64) -> f64 {
    let noise = covariance::Noise { white: n * sample_s.sqrt(), ..covariance::Noise::default() };
    noise.covariance(weights, weights)
}

#[test]
fn white_noise_has_the_variances_of_theory() {
    let (n, sample_s) = (0.0288, 1.0);
    let at_rest = Leg { earth_rate: 0.0, latitude: 0.8, velocity: [0.0; 2] };
    let omega = (GRAVITY / RADIUS).sqrt();
    for duration in [600, 3600, 5064, 20_000] {
        let times = Times { sample_s, alignment: 0, duration, calibrates: false };
        let t = duration as f64;
        let found = weights(&Task::Inertial(at_rest), &times);
        let (sine, double) = ((omega * t).sin() / omega, (2.0 * omega * t).sin() / (4.0 * omega));
        let position = (RADIUS * n * ARCSEC).powi(2) * (1.5 * t - 2.0 * sine + double);
        for (gyro, error) in [(0, 6), (1, 5)] {
            let variance = white(&found[gyro].of_errors[error], n, sample_s);
            assert!(
                (variance / position - 1.0).abs() < 1e-5,
                "position after {t} s: {variance}, not {position}"
            );
        }
        let heading = white(&weights(&Task::Heading, &times)[0].of_errors[0], n, sample_s);
        assert!((heading / (n * n * t) - 1.0).abs() < 1e-12);
    }
    let task = Task::Gyrocompass { earth_rate: EARTH_RATE, latitude: PI / 3.0 };
    let times = Times { sample_s, alignment: 600, duration: 0, calibrates: false };
    let found = white(&weights(&task, &times)[0].of_errors[0], n, sample_s).sqrt();
    let expected = n / (600_f64.sqrt() * EARTH_RATE * (PI / 3.0).cos());
    assert!((found / expected - 1.0).abs() < 1e-12);
    assert!((found - 32.0).abs() < 0.5, "LGV-1, 10 min, 60°: {found}");
}
