//! Filters that keep a heading: against a Kalman filter that runs step by step, against their own claims, and refusals.

use sagnac::device::Cpu;
use sagnac::study::Study;
use sagnac::theory::allan::Term;
use sagnac::theory::navigation::filter::{Model, filtered};
use sagnac::theory::navigation::{Task, Times, weights};
use sagnac_engine::key::Streams;
use sagnac_engine::kinds::navigation::lower::Lowered;
use sagnac_engine::kinds::navigation::verify::noise_of;
use sagnac_engine::kinds::navigation::{Inputs, Navigation, Noise, Solution};
use sagnac_kernel::width::Width;

const TIMES: Times = Times { sample_s: 1.0, alignment: 300, duration: 500, calibrates: false };

fn everything() -> Model {
    Model { white: 0.04, walk: 2e-5, markov: vec![[2e-3, 40.0], [1e-3, 700.0]], quantization: 0.24 }
}

type Matrix = Vec<Vec<f64>>;

/// A Kalman filter as in textbooks: angle, bias, then the other rates. It begins with the first reading, from which angle and
/// bias follow exactly.
struct Kalman {
    transition: Matrix,
    added: Matrix,
    x: Vec<f64>,
    p: Matrix,
    reading: f64,
}

impl Kalman {
    fn new(model: &Model, step: f64, first: f64) -> Kalman {
        let rates = 2 + usize::from(model.walk > 0.0) + model.markov.len();
        let mut f = vec![vec![0.0; rates]; rates];
        let (mut q, mut p) = (f.clone(), f.clone());
        f[0][0] = 1.0;
        f[0][1] = step;
        f[1][1] = 1.0;
        q[0][0] = model.white * model.white * step;
        let mut at = 2;
        // Angle, covariance and rate after the first step, without the bias.
        let mut before = vec![model.quantization * model.quantization + q[0][0]];
        before.resize(rates, 0.0);
        if model.walk > 0.0 {
            let k = model.walk * model.walk;
            (f[0][at], f[at][at]) = (step, 1.0);
            q[0][0] += k * step.powi(3) / 3.0;
            (q[0][at], q[at][0], q[at][at]) = (k * step * step / 2.0, k * step * step / 2.0, k * step);
            before[0] += k * step.powi(3) / 3.0;
            before[at] = q[0][at];
            p[at][at] = q[at][at];
            at += 1;
        }
        for [sigma, time] in &model.markov {
            let (a, square) = ((-step / time).exp(), sigma * sigma);
            (f[0][at], f[at][at]) = (time * (1.0 - a), a);
            let angle = time * (2.0 * step - time * (3.0 - 4.0 * a + a * a));
            q[0][0] += square * angle;
            let both = square * time * (1.0 - a) * (1.0 - a);
            (q[0][at], q[at][0], q[at][at]) = (both, both, square * (1.0 - a * a));
            before[0] += square * (angle + f[0][at] * f[0][at]);
            before[at] = both + square * f[0][at] * a;
            p[at][at] = square;
            at += 1;
        }
        let reading = model.quantization * model.quantization;
        p[0][0] = reading;
        p[0][1] = reading / step;
        p[1][0] = p[0][1];
        p[1][1] = (reading + before[0]) / (step * step);
        for at in 2..rates {
            p[1][at] = -before[at] / step;
            p[at][1] = p[1][at];
        }
        let mut x = vec![first, first / step];
        x.resize(rates, 0.0);
        Kalman { transition: f, added: q, x, p, reading }
    }

    fn predict(&mut self) {
        let n = self.x.len();
        let f = &self.transition;
        self.x = (0..n).map(|i| (0..n).map(|j| f[i][j] * self.x[j]).sum()).collect();
        let half: Matrix =
            (0..n).map(|i| (0..n).map(|j| (0..n).map(|k| f[i][k] * self.p[k][j]).sum()).collect()).collect();
        let whole = |i: usize, j: usize| (0..n).map(|k| half[i][k] * f[j][k]).sum::<f64>() + self.added[i][j];
        self.p = (0..n).map(|i| (0..n).map(|j| whole(i, j)).collect()).collect();
    }

    fn update(&mut self, angle: f64) {
        let n = self.x.len();
        let variance = self.p[0][0] + self.reading;
        let gains: Vec<f64> = (0..n).map(|i| self.p[i][0] / variance).collect();
        let innovation = angle - self.x[0];
        (0..n).for_each(|i| self.x[i] += gains[i] * innovation);
        let first = self.p[0].clone();
        (0..n).for_each(|i| (0..n).for_each(|j| self.p[i][j] -= gains[i] * first[j]));
    }
}

#[test]
fn weights_are_those_of_a_kalman_filter_that_runs_step_by_step() {
    let white = Model { white: 0.04, ..Model::default() };
    let models = [
        white.clone(),
        Model { walk: 2e-4, ..white.clone() },
        Model { markov: vec![[2e-3, 40.0]], ..white.clone() },
        Model { quantization: 0.24, ..white },
        everything(),
    ];
    let mut word = 1_u64;
    // Sums of uniform numbers beside a bias and a ramp.
    let mut increment = |k: usize| {
        let mut sum = 0.3 + 1e-4 * k as f64;
        for _ in 0..4 {
            word = word.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (word >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        }
        sum
    };
    for model in models {
        let increments: Vec<f64> = (0..TIMES.alignment + TIMES.duration).map(&mut increment).collect();
        let angles: Vec<f64> = increments
            .iter()
            .scan(0.0, |sum, one| {
                Some({
                    *sum += one;
                    *sum
                })
            })
            .collect();
        let mut kalman = Kalman::new(&model, TIMES.sample_s, angles[0]);
        for angle in &angles[1..TIMES.alignment] {
            kalman.predict();
            kalman.update(*angle);
        }
        (0..TIMES.duration).for_each(|_| kalman.predict());
        let expected = angles[angles.len() - 1] - kalman.x[0];
        let found = filtered(&model, &TIMES);
        let error: f64 = found.weights.iter().zip(&increments).map(|(weight, one)| weight * one).sum();
        let size: f64 = found.weights.iter().zip(&increments).map(|(weight, one)| (weight * one).abs()).sum();
        assert!((error - expected).abs() < 1e-9 * size, "{model:?}: {error}, not {expected}");
        let claimed = kalman.p[0][0] + kalman.reading;
        assert!(
            (found.variance / claimed - 1.0).abs() < 1e-9,
            "{model:?}: {}, not {claimed}",
            found.variance
        );
    }
}

#[test]
fn calibration_is_the_filter_that_knows_white_noise() {
    let calibrated = weights(&Task::Heading, &Times { calibrates: true, ..TIMES });
    let found = filtered(&Model { white: 0.04, ..Model::default() }, &TIMES);
    for (found, expected) in found.weights.iter().zip(&calibrated[0].of_errors[0]) {
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }
}

/// A heading kept by a filter after an alignment of 10 minutes.
fn kept(filter: Model, noise: Noise, duration_s: f64) -> (Lowered, f64) {
    let inputs = Inputs {
        solution: Solution::Heading,
        duration_s,
        alignment_s: 600.0,
        calibrates: false,
        filter: Some(filter),
        latitude_arcsec: 0.0,
        speed_m_per_s: 0.0,
        course_arcsec: 0.0,
        sample_s: Some(1.0),
        noise,
    };
    let sigma = inputs.claimed().unwrap();
    let study = Navigation::new(inputs);
    (Lowered::new(&study.points[0], &study, 1, Streams::Independent).unwrap(), sigma)
}

#[test]
fn a_filter_that_knows_the_noise_is_consistent_and_one_that_does_not_is_too_sure() {
    const TRIALS: usize = 4000;
    let truth =
        noise_of(&[(Term::AngleRandomWalk, 0.04), (Term::Quantization, 0.24), (Term::RateRandomWalk, 1e-4)]);
    let model = Model { white: 0.04, walk: 1e-4, markov: vec![], quantization: 0.24 };
    let white = Model { white: 0.04, ..Model::default() };
    let cpu = Cpu::new(Width::widest(), 0).unwrap();
    for duration_s in [60.0, 900.0] {
        for (filter, is_right) in [(model.clone(), true), (white.clone(), false)] {
            let (lowered, sigma) = kept(filter, truth.clone(), duration_s);
            let gyro = &lowered.gyros[0];
            let sums = cpu.sums(&gyro.navigation, 3, TRIALS, &|_| {});
            let squares: Vec<f64> = sums
                .iter()
                .flat_map(|sum| gyro.errors(&[*sum]).map(|e| (e / sigma).powi(2)).collect::<Vec<_>>())
                .collect();
            let mean = squares.iter().sum::<f64>() / TRIALS as f64;
            let variance = squares.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / TRIALS as f64;
            let se = (variance / TRIALS as f64).sqrt();
            let closed = lowered.distributions(&[0])[0].mean_square() / (sigma * sigma);
            assert!((mean - closed).abs() < 5.0 * se, "{duration_s} s: {mean} of {closed} with {se}");
            if is_right {
                // Records hold their rates over each sample, a filter knows them in between.
                assert!((closed - 1.0).abs() < 1e-5, "{duration_s} s: {closed}");
                assert!((mean - 1.0).abs() < 5.0 * se, "{duration_s} s: {mean} with {se}");
            } else {
                assert!(closed > 1.2, "{duration_s} s: {closed}");
            }
        }
    }
}

const MODEL: &str =
    "{\n  \"white_deg_per_rt_h\": 0.001,\n  \"random_walk_deg_per_h_per_rt_h\": 0.0,\n  \"markov\": []\n}\n";

const STUDY: &str = "title = \"T\"\nkind = \"navigation\"\n[navigation]\nsolution = \"heading\"\nduration = \"1 h\"\n\
                     alignment = \"10 min\"\nfilter = \"model.json\"\n[noise]\nangle_random_walk = \"0.001 deg/sqrt(h)\"\n";

fn refused(study: &str, model: &str) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, study).unwrap();
    std::fs::write(folder.path().join("model.json"), model).unwrap();
    Study::read(&path).map(|_| ()).map_err(|error| error.render(false, 400))
}

#[test]
fn bad_filters_are_refused_by_name_with_their_place() {
    assert_eq!(refused(STUDY, MODEL), Ok(()));
    let study = |old: &str, new: &str| {
        assert!(STUDY.contains(old), "{old}");
        (STUDY.replace(old, new), MODEL.to_owned())
    };
    let model = |old: &str, new: &str| {
        assert!(MODEL.contains(old), "{old}");
        (STUDY.to_owned(), MODEL.replace(old, new))
    };
    for ((study, model), pieces) in [
        (study("alignment = \"10 min\"\n", ""), ["a.toml:3", "navigation.filter", "alignment = \"10 min\""]),
        (
            study("[noise]", "calibration = true\n[noise]"),
            ["a.toml:8", "navigation.calibration", "leave it out"],
        ),
        (study("model.json", "other.json"), ["a.toml:7", "other.json", "sagnac model --json"]),
        (
            study("\"heading\"\nduration = \"1 h\"", "\"gyrocompass\"\nlatitude = \"60 deg\""),
            ["a.toml:7", "navigation.filter has no effect", "gyrocompass"],
        ),
        (model("0.001", "-0.001"), ["model.json:2", "-0.001 is not from 0", "sagnac model noise.toml"]),
        (model("0.001", "\"0.001\""), ["model.json:2", "invalid type", "sagnac model noise.toml"]),
        (
            model("\"markov\": []", "\"markov\": 3"),
            ["model.json:4", "invalid type", "sagnac model noise.toml"],
        ),
        (model(",\n  \"markov\": []", ""), ["model.json:4", "markov", "sagnac model noise.toml"]),
        (model("0.001", "0.0"), ["model.json:1", "no noise", "sagnac model noise.toml"]),
        (
            model("[]", "[{ \"sigma_deg_per_h\": 0.001, \"correlation_time_s\": 0 }]"),
            ["model.json:4", "0 is not from", "sagnac model noise.toml"],
        ),
        (model("{\n", "[\n"), ["model.json", "cannot be read", "sagnac model noise.toml"]),
    ] {
        let report = refused(&study, &model).expect_err(&format!("{pieces:?}"));
        for piece in pieces {
            assert!(report.contains(piece), "`{piece}` is missing in\n{report}");
        }
    }
}
