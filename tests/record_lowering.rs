//! Noise models in physical units, lowered to records: their curves against the laws and the oracles of the lowered words.

use sagnac::backend::cpu::{Cpu, Width};
use sagnac::lower::{Asked, Records, RecordsError};
use sagnac::theory::allan::{Difference, Estimator, Part, Process, Stride};

const THINNED: Estimator = Estimator { difference: Difference::Second, stride: Stride::Part(64) };

/// What a test asks for: 100 Hz and no readout, unless told.
#[derive(Clone)]
struct Model {
    process: Process,
    readout_lsb: f64,
    mean_rate: f64,
    samples: u64,
    estimator: Estimator,
    ms: Vec<u64>,
}

impl Model {
    fn of(parts: &[Part]) -> Model {
        Model {
            process: Process { sample_s: 0.01, parts: parts.to_vec() },
            readout_lsb: 0.0,
            mean_rate: 0.0,
            samples: 4096,
            estimator: THINNED,
            ms: octaves(4096, 2),
        }
    }

    fn lower(&self) -> Result<Records, RecordsError> {
        Records::new(&Asked {
            process: &self.process,
            readout_lsb: self.readout_lsb,
            mean_rate: self.mean_rate,
            samples: self.samples,
            estimator: self.estimator,
            ms: &self.ms,
            key: [2024, 11],
        })
    }

    fn lowered(&self) -> Records {
        self.lower().unwrap_or_else(|error| panic!("{:?}: {error}", self.process))
    }
}

/// Averaging factors 1, 2, 4, … of which a difference spans `spans`.
fn octaves(samples: u64, spans: u64) -> Vec<u64> {
    (0..40).map(|octave| 1 << octave).take_while(|m| spans * m <= samples).collect()
}

/// The estimates of some records: of each averaging factor those of all records.
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

/// Compares the mean of each estimate with its oracle; the largest |z|.
fn compare(name: &str, records: &Records, sampled: &[Vec<f64>]) -> f64 {
    let mut largest: f64 = 0.0;
    for (at, &m) in records.ms().iter().enumerate() {
        let (mean, se) = mean(&sampled[at]);
        let oracle = records.oracle(at);
        let Some(value) = oracle.value else {
            panic!("{name}, m = {m}: no oracle beside {mean}: {oracle:?}")
        };
        let z = (mean - value) / se.hypot(oracle.rounding);
        assert!(z.abs() < 5.0, "{name}, m = {m}: {mean} ± {se}, not {value} ± {}, z = {z}", oracle.rounding);
        assert!(se < 0.04 * value, "{name}, m = {m}: {mean} ± {se} says nothing");
        assert!(oracle.rounding < 0.005 * value, "{name}, m = {m}: {oracle:?} says nothing");
        largest = largest.max(z.abs());
    }
    largest
}

/// Slope of log σ over log τ through the means from `from` up to `to`, and its standard error from the scatter over
/// records.
fn slope(records: &Records, sampled: &[Vec<f64>], from: u64, to: u64) -> (f64, f64) {
    let places: Vec<usize> =
        (0..records.ms().len()).filter(|&at| (from..=to).contains(&records.ms()[at])).collect();
    let x: Vec<f64> = places.iter().map(|&at| (records.ms()[at] as f64).ln()).collect();
    let middle = x.iter().sum::<f64>() / x.len() as f64;
    let squares: f64 = x.iter().map(|x| (x - middle) * (x - middle)).sum();
    let weights: Vec<f64> = x.iter().map(|x| (x - middle) / squares / 2.0).collect();
    let means: Vec<f64> = places.iter().map(|&at| mean(&sampled[at]).0).collect();
    let slope = weights.iter().zip(&means).map(|(w, mean)| w * mean.ln()).sum();
    // To first order, log of a mean is scattered as its estimates over it.
    let one = |record: usize| {
        let terms = places.iter().zip(&weights).zip(&means);
        terms.map(|((&at, w), mean)| w * sampled[at][record] / mean).sum()
    };
    let scatter: Vec<f64> = (0..sampled[0].len()).map(one).collect();
    (slope, mean(&scatter).1)
}

/// Largest relative difference of the oracles from the model in physical units.
fn off_the_model(model: &Model, records: &Records) -> f64 {
    let off = |(at, &m): (usize, &u64)| {
        let expected = model.process.expected(model.estimator, model.samples, m).unwrap();
        (records.oracle(at).value.unwrap() / expected - 1.0).abs()
    };
    model.ms.iter().enumerate().map(off).fold(0.0, f64::max)
}

#[test]
fn every_noise_has_its_slope_and_its_oracle() {
    // Up to where a curve of so many records says something, and from where the sampled law is the continuous one.
    let laws = [
        ("quantisation", Part::Quantisation { q: 0.24 }, -1.0, [1, 1024]),
        ("angle random walk", Part::AngleRandomWalk { n: 0.04 }, -0.5, [1, 1024]),
        ("bias instability", Part::BiasInstability { b: 0.002, octaves: 24 }, 0.0, [1, 1024]),
        ("rate random walk", Part::RateRandomWalk { k: 1e-4 }, 0.5, [16, 1024]),
    ];
    for (name, part, law, [from, to]) in laws {
        let model = Model { ms: octaves(2048, 2), ..Model::of(&[part]) };
        let records = model.lowered();
        let sampled = sampled(&records, 4096);
        let z = compare(name, &records, &sampled);
        let (slope, se) = slope(&records, &sampled, from, to);
        assert!((slope - law).abs() < 5.0 * se, "{name}: slope {slope} ± {se}, not {law}");
        assert!(se < 0.005, "{name}: slope {slope} ± {se} says nothing");
        let off = off_the_model(&model, &records);
        assert!(off < 0.01, "{name}: the words are off the model by {off}");
        println!("{name}: slope {slope:.4} ± {se:.4}, largest |z| {z:.2}, words off by {off:.1e}");
    }
}

#[test]
fn what_is_the_same_in_all_records_is_exact() {
    let ramp = Part::RateRamp { r: -3e-3 };
    let warm_ups = [
        Part::WarmUp { amplitude: 0.5, time_s: 7.0 },
        Part::WarmUp { amplitude: -2.0, time_s: 0.1 },
        Part::WarmUp { amplitude: 30.0, time_s: 1e5 },
    ];
    let tables =
        [vec![ramp], vec![warm_ups[0]], vec![warm_ups[1]], vec![warm_ups[2]], vec![ramp, warm_ups[0]]];
    for parts in tables {
        for estimator in [THINNED, Estimator::NON_OVERLAPPING, Estimator::OVERLAPPING] {
            let model = Model { estimator, ..Model::of(&parts) };
            let records = model.lowered();
            for (at, found) in sampled(&records, 2).into_iter().enumerate() {
                let (m, oracle) = (model.ms[at], records.oracle(at));
                let value = oracle.value.unwrap();
                assert_eq!(found[0], found[1], "{parts:?}, m = {m}");
                assert!(
                    (found[0] - value).abs() <= oracle.rounding,
                    "{parts:?}, m = {m}: {found:?}, {oracle:?}"
                );
                // Every angle is rounded by half an LSB: a difference by two.
                let expected = model.process.expected(estimator, model.samples, m).unwrap();
                let off = 2.0 * records.lsb_arcsec() / (0.01 * m as f64) / 2.0_f64.sqrt();
                let near = (value.sqrt() - expected.sqrt()).abs() <= 1.001 * off;
                assert!(near, "{parts:?}, m = {m}: {value}, not {expected}");
            }
        }
    }
    let records = Model { ms: vec![64, 128, 256, 512, 1024, 2048], ..Model::of(&[ramp]) }.lowered();
    let (slope, _) = slope(&records, &sampled(&records, 2), 64, 2048);
    assert!((slope - 1.0).abs() < 1e-6, "ramp: slope {slope}");
}

#[test]
fn markov_noise_sines_and_readouts_have_their_oracles() {
    let n = Part::AngleRandomWalk { n: 0.04 };
    let markov = |time_s| Part::Markov { q_c: 0.01, time_s };
    let sine = |frequency_hz| Part::Sine { amplitude: 0.3, frequency_hz };
    let ramp = Part::RateRamp { r: 1e-3 };
    let warm_up = Part::WarmUp { amplitude: 0.5, time_s: 7.0 };
    let flicker = Part::BiasInstability { b: 0.01, octaves: 24 };
    let quiet = 0.0;
    let tables: Vec<(&str, Vec<Part>, f64, f64)> = vec![
        ("Markov, short", vec![markov(0.003)], quiet, 0.0),
        ("Markov", vec![markov(0.5)], quiet, 0.0),
        ("Markov, long", vec![markov(1000.0)], quiet, 0.0),
        ("sine", vec![n, sine(1.234)], quiet, 0.0),
        ("slow sine", vec![n, sine(0.003)], quiet, 0.0),
        ("sine beyond half the rate", vec![n, sine(61.0)], quiet, 0.0),
        ("pulses of the earth's rate", vec![], 0.38, 15.041),
        ("pulses and white noise", vec![n], 0.38, 15.041),
        (
            "pulses, noises and a sine",
            vec![n, markov(0.5), sine(1.7), Part::Quantisation { q: 0.05 }],
            0.1,
            3.3,
        ),
        ("pulses and flicker", vec![Part::AngleRandomWalk { n: 0.9 }, flicker], 0.02, 15.041),
        ("pulses on a ramp", vec![Part::AngleRandomWalk { n: 0.9 }, ramp, warm_up], 0.02, 15.041),
        ("ramp and noise", vec![n, ramp, warm_up], quiet, 0.0),
    ];
    for (name, parts, readout_lsb, mean_rate) in tables {
        for estimator in [THINNED, Estimator { difference: Difference::Third, ..THINNED }] {
            let ms = octaves(if name == "Markov, long" { 512 } else { 2048 }, estimator.difference.spans());
            let model = Model { readout_lsb, mean_rate, estimator, ms, ..Model::of(&parts) };
            let records = model.lowered();
            let z = compare(name, &records, &sampled(&records, 4096));
            if readout_lsb == 0.0 {
                let off = off_the_model(&model, &records);
                assert!(off < 0.01, "{name}: the words are off the model by {off}");
            }
            println!("{name}, {:?}: largest |z| {z:.2}", estimator.difference);
        }
    }
}
