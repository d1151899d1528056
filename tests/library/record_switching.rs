//! Records of a gyro that switches modes: against their theory, the sawtooth itself and an independent sampler.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::device::Cpu;
use sagnac::theory::allan::{Difference, Estimator, Part, Process};
use sagnac::theory::drift::{Magnetic, Switching};
use sagnac_engine::key::Unrepresentable;
use sagnac_engine::kinds::allan::lower::{Asked, Records};
use sagnac_engine::kinds::allan::verify::THINNED;
use sagnac_kernel::width::Width;

const SAMPLE_S: f64 = 0.5;
const SAMPLES: u64 = 2000;

const QUIET: Switching = Switching {
    interval: 40,
    magnetic: Magnetic { amplitude: 0.0, time_s: 1.0, initial: 0.0 },
    residual: 0.0,
    residual_noise: 0.0,
};

struct Model {
    parts: Vec<Part>,
    switching: Switching,
    readout_lsb: f64,
    estimator: Estimator,
    ms: Vec<u64>,
}

impl Model {
    fn new(switching: Switching) -> Model {
        let ms = vec![1, 2, 7, 16, 37, 40, 64, 80, 100, 160, 333, 640];
        Model { parts: vec![], switching, readout_lsb: 0.0, estimator: Estimator::OVERLAPPING, ms }
    }

    fn process(&self) -> Process {
        Process { sample_s: SAMPLE_S, parts: self.parts.clone() }
    }

    fn lower(&self) -> Result<Records, Unrepresentable> {
        Records::new(&Asked {
            process: &self.process(),
            readout_lsb: self.readout_lsb,
            mean_rate: 0.0,
            switching: Some(self.switching),
            samples: SAMPLES,
            estimator: self.estimator,
            ms: &self.ms,
            key: [2026, 5],
        })
    }
}

/// The estimates of some records at each averaging factor.
fn sampled(records: &Records, count: usize) -> Vec<Vec<f64>> {
    let recipe = records.recipe();
    let sums = Cpu::new(Width::widest(), 0).unwrap().sums(recipe, 0, count, &|_| {});
    let rows: Vec<Vec<f64>> =
        sums.chunks_exact(recipe.places()).map(|sums| records.variances(sums)).collect();
    (0..records.ms().len()).map(|at| rows.iter().map(|row| row[at]).collect()).collect()
}

/// Mean and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

fn differences(angles: &[f64], estimator: Estimator, m: u64) -> impl Iterator<Item = f64> {
    let coefficients = estimator.difference.coefficients();
    (0..estimator.terms(SAMPLES, m)).map(move |k| {
        let start = k * estimator.stride(m);
        let terms = (0..).zip(coefficients);
        terms.map(|(place, c)| c * angles[(start + place * m) as usize]).sum()
    })
}

/// The estimate of a record from its angles.
fn estimate(angles: &[f64], estimator: Estimator, m: u64) -> f64 {
    let sum: f64 = differences(angles, estimator, m).map(|difference| difference * difference).sum();
    let tau = SAMPLE_S * m as f64;
    sum / estimator.terms(SAMPLES, m) as f64 / (estimator.difference.divisor() * tau * tau)
}

/// The sawtooth, each interval integrated by Gauss and Legendre between two switches.
fn sawtooth(switching: &Switching) -> Vec<f64> {
    let rate = |t: f64| switching.magnetic.rate(t);
    let mut angle = 0.0;
    let step = |k: u64| {
        let sign = if (k / switching.interval).is_multiple_of(2) { 1.0 } else { -1.0 };
        let nodes = [0.5 - 0.6_f64.sqrt() / 2.0, 0.5, 0.5 + 0.6_f64.sqrt() / 2.0];
        let values = nodes.map(|node| rate(SAMPLE_S * (k as f64 + node)));
        sign * SAMPLE_S * (5.0 * values[0] + 8.0 * values[1] + 5.0 * values[2]) / 18.0
    };
    let rest = (0..SAMPLES).map(|k| {
        angle += step(k);
        angle
    });
    core::iter::once(0.0).chain(rest).collect()
}

const ESTIMATORS: [Estimator; 4] = [
    Estimator::OVERLAPPING,
    THINNED,
    Estimator::NON_OVERLAPPING,
    Estimator { difference: Difference::Third, ..THINNED },
];

#[test]
fn the_sawtooth_is_that_of_the_turning_drift() {
    let magnetic = |amplitude, time_s, initial| Magnetic { amplitude, time_s, initial };
    for (interval, magnetic) in [
        (1, magnetic(0.0, 1.0, 3.0)),
        (37, magnetic(14.0, 300.0, 0.0)),
        (64, magnetic(-14.0, 90.0, 14.5)),
        (700, magnetic(14.0, 1e6, -0.1)),
        (1999, magnetic(2.0, 100.0, 1.0)),
    ] {
        let switching = Switching { interval, magnetic, ..QUIET };
        let angles = sawtooth(&switching);
        for estimator in ESTIMATORS {
            let records = Model { estimator, ..Model::new(switching) }.lower().unwrap();
            for (at, found) in sampled(&records, 2).into_iter().enumerate() {
                let (m, theory) = (records.ms()[at], records.theory(at));
                assert_eq!(found[0], found[1], "M = {interval}, m = {m}");
                // Every angle is rounded by half an LSB.
                let per_tau = records.lsb_arcsec() / (SAMPLE_S * m as f64);
                let off = (estimator.difference.spans() as f64).exp2() / 2.0 * per_tau
                    / estimator.difference.divisor().sqrt();
                let expected = estimate(&angles, estimator, m);
                let is_near =
                    (found[0].sqrt() - expected.sqrt()).abs() <= 1.01 * off + 1e-9 * expected.sqrt();
                assert!(is_near, "M = {interval}, m = {m}: {}, not {expected} ± {off}", found[0]);
                if let Some(value) = theory.value {
                    assert!((found[0] - value).abs() <= theory.rounding, "m = {m}: {found:?}, {theory:?}");
                }
            }
        }
    }
}

#[test]
fn fill_residuals_have_their_theory_at_all_averaging_times() {
    let white = Part::angle_random_walk(0.03);
    let flicker = Part::bias_instability(0.01, 24);
    let magnetic = Magnetic { amplitude: 0.2, time_s: 200.0, initial: 0.01 };
    let of = |interval, residual, residual_noise| Switching { interval, residual, residual_noise, ..QUIET };
    let tables: Vec<(&str, Vec<Part>, Switching, f64)> = vec![
        ("a random phase", vec![], of(37, 10.0, 0.0), 0.0),
        ("noise", vec![], of(64, 0.0, 2.0), 0.0),
        ("a switch after every sample", vec![], of(1, 3.0, 1.0), 0.0),
        ("two switches in the record", vec![white], of(800, 3.0, 1.0), 0.0),
        ("one switch at its end", vec![white], of(SAMPLES - 1, 3.0, 1.0), 0.0),
        ("beside white noise", vec![white], of(40, 0.5, 0.1), 0.0),
        (
            "beside flicker and a sawtooth",
            vec![white, flicker],
            Switching { magnetic, ..of(100, 1.0, 0.2) },
            0.0,
        ),
        ("in pulses", vec![Part::angle_random_walk(0.9)], Switching { magnetic, ..of(23, 2.0, 0.0) }, 0.05),
    ];
    let mut largest: f64 = 0.0;
    for (name, parts, switching, readout_lsb) in tables {
        for estimator in ESTIMATORS {
            let model =
                Model { parts: parts.clone(), switching, readout_lsb, estimator, ..Model::new(switching) };
            let records = model.lower().unwrap_or_else(|error| panic!("{name}: {error}"));
            for (at, found) in sampled(&records, 2048).iter().enumerate() {
                let (m, (mean, se), theory) = (records.ms()[at], mean(found), records.theory(at));
                let Some(value) = theory.value else { panic!("{name}, m = {m}: no theory, {theory:?}") };
                let z = (mean - value) / se.hypot(theory.rounding);
                assert!(z.abs() < 5.0, "{name}, {estimator:?}, m = {m}: {mean} ± {se}, not {value}, z = {z}");
                assert!(se < 0.05 * value && theory.rounding < 0.005 * value, "{name}, m = {m} says nothing");
                largest = largest.max(z.abs());
                if switching.drifts() || readout_lsb > 0.0 {
                    continue;
                }
                let tau = SAMPLE_S * m as f64;
                let jumps = switching.jumps().unwrap().mean_square(estimator, SAMPLES, m);
                let expected = model.process().expected(estimator, SAMPLES, m).unwrap()
                    + jumps / (estimator.difference.divisor() * tau * tau);
                let off = value / expected - 1.0;
                assert!(off.abs() < 0.01, "{name}, m = {m}: the words are off the model by {off}");
            }
        }
    }
    println!("largest |z| {largest:.2}");
}

/// A record in f64, straight from the definition.
fn angles_of(model: &Model, rng: &mut StdRng) -> Vec<f64> {
    let Switching { interval, residual, residual_noise, .. } = model.switching;
    let mut angles = crate::noise::record(&model.process(), SAMPLES as usize, rng);
    let mut jumped = 0.0;
    for (k, (angle, saw)) in (0..).zip(angles.iter_mut().zip(sawtooth(&model.switching))) {
        *angle += saw + jumped;
        if k > 0 && k % interval == 0 {
            let turns: f64 = rng.random();
            jumped += residual * (core::f64::consts::TAU * turns).sin()
                + residual_noise * crate::noise::normal(rng);
        }
    }
    angles
}

#[test]
fn an_independent_sampler_agrees() {
    let magnetic = Magnetic { amplitude: 0.05, time_s: 300.0, initial: 0.0 };
    for (interval, difference) in [(37, Difference::Second), (150, Difference::Third)] {
        let switching = Switching { interval, magnetic, residual: 1.0, residual_noise: 0.3 };
        let estimator = Estimator { difference, ..Estimator::OVERLAPPING };
        let ms = vec![1, 16, 40, 74, 160, 300];
        let parts = vec![Part::angle_random_walk(0.02)];
        let model = Model { parts, ms, estimator, ..Model::new(switching) };
        let records = model.lower().unwrap();
        let found = sampled(&records, 4096);
        let mut rng = StdRng::seed_from_u64(11);
        let others: Vec<Vec<f64>> = (0..1000).map(|_| angles_of(&model, &mut rng)).collect();
        for (at, &m) in records.ms().iter().enumerate() {
            let (mean_a, se_a) = mean(&found[at]);
            let estimates: Vec<f64> = others.iter().map(|angles| estimate(angles, estimator, m)).collect();
            let (mean_b, se_b) = mean(&estimates);
            let z = (mean_a - mean_b) / se_a.hypot(se_b);
            assert!(z.abs() < 5.0, "M = {interval}, m = {m}: {mean_a} ± {se_a}, not {mean_b} ± {se_b}");
        }
    }
}

#[test]
fn switches_shift_no_other_draw() {
    let parts = || vec![Part::angle_random_walk(0.03)];
    let switching = Switching { residual: 1e-3, ..QUIET };
    let with = Model { parts: parts(), ..Model::new(switching) }.lower().unwrap();
    let without = Model { parts: parts(), ..Model::new(QUIET) }.lower().unwrap();
    let [with, without] = [&with, &without].map(|records| sampled(records, 5));
    for (with, without) in with[0].iter().zip(&without[0]) {
        assert!((with / without - 1.0).abs() < 0.02 && with != without, "{with}, {without}");
    }
}

#[test]
fn what_cannot_be_made_is_refused_by_the_name_of_its_key() {
    let of = |switching| Model::new(switching);
    let white = |n, switching| Model { parts: vec![Part::angle_random_walk(n)], ..Model::new(switching) };
    let magnetic = |amplitude, time_s| Magnetic { amplitude, time_s, initial: 0.0 };
    let table = [
        ("noise.switching.interval", of(Switching { interval: 0, ..QUIET })),
        ("noise.switching.interval", of(Switching { interval: SAMPLES, ..QUIET })),
        ("noise.switching.residual", of(Switching { residual: -1.0, ..QUIET })),
        ("noise.switching.residual_noise", of(Switching { residual_noise: f64::NAN, ..QUIET })),
        ("noise.switching.magnetic", of(Switching { magnetic: magnetic(f64::INFINITY, 1.0), ..QUIET })),
        ("noise.switching.warm_up_time", of(Switching { magnetic: magnetic(1.0, 0.0), ..QUIET })),
        ("noise", of(QUIET)),
        ("noise.switching.residual", white(1e3, Switching { residual: 1e-7, ..QUIET })),
        ("noise.switching.residual_noise", white(1e3, Switching { residual_noise: 1e-7, ..QUIET })),
        ("noise.switching.magnetic", white(1e3, Switching { magnetic: magnetic(1e-9, 1.0), ..QUIET })),
    ];
    for (key, model) in table {
        let error = model.lower().map(|records| records.recipe().clone()).expect_err(key);
        assert_eq!(error.key, key, "{error}");
        assert!(error.to_string().starts_with(&format!("{key}: ")) && !error.help.is_empty(), "{error}");
    }
}

#[test]
fn no_difference_leaves_the_room_that_there_is() {
    let mut random = StdRng::seed_from_u64(3);
    let mut most: f64 = 0.0;
    for _ in 0..300 {
        let mut size = || 10.0_f64.powf(random.random_range(-3.0..3.0));
        let magnetic = Magnetic { amplitude: size(), time_s: 30.0 * size(), initial: -size() };
        let (residual, residual_noise) = (size(), size());
        let interval = random.random_range(0.0..10.9_f64).exp2() as u64;
        let switching = Switching { interval, magnetic, residual, residual_noise };
        let Ok(records) = Model::new(switching).lower() else { continue };
        let angles = sawtooth(&switching);
        let sigma = switching.jumps().unwrap().variance.sqrt();
        for difference in [Difference::Second, Difference::Third] {
            let estimator = Estimator { difference, ..Estimator::OVERLAPPING };
            let fits = |m: &u64| estimator.terms(SAMPLES, *m) > 0;
            for m in [1, 3, interval, SAMPLES / 3, SAMPLES / 2].into_iter().filter(fits) {
                let saw = differences(&angles, estimator, m).fold(0.0_f64, |most, x| most.max(x.abs()));
                let jumps = (difference.divisor() * (m / interval + 1) as f64).sqrt() * sigma;
                let largest = (saw + 16.0 * jumps) / records.lsb_arcsec() / 2.0_f64.powi(29);
                assert!(largest < 1.0, "{switching:?}, m = {m}: {largest} of the limit");
                most = most.max(largest);
            }
        }
    }
    assert!(most > 0.5, "at most {most} of the limit");
}

#[test]
fn the_words_of_switches_are_the_same_on_every_machine() {
    let switching = Switching {
        interval: 37,
        magnetic: Magnetic { amplitude: 14.0, time_s: 300.0, initial: 0.1 },
        residual: 10.0,
        residual_noise: 2.0,
    };
    let records =
        Model { parts: vec![Part::angle_random_walk(0.03)], ..Model::new(switching) }.lower().unwrap();
    assert_eq!(records.recipe().switching.map(|words| words[0]), Some(37));
    assert_eq!(records.digest().to_string(), "c7885dfdbb1a2c3ec64f9dab4266e60a");
}
