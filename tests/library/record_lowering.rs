//! Noise models in physical units, lowered to records: their curves against the laws and the oracles of the lowered words.

use std::collections::BTreeMap;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::device::cpu::Cpu;
use sagnac::kernel::recipe::Recipe;
use sagnac::kernel::width::Width;
use sagnac::key::refusal::Refusal;
use sagnac::kinds::allan::lower::{Asked, Records};
use sagnac::kinds::allan::verify::THINNED;
use sagnac::theory::allan::estimator::{Difference, Estimator};
use sagnac::theory::allan::holds;
use sagnac::theory::allan::part::{FLAT_LEVEL, Part};
use sagnac::theory::allan::process::Process;
use sagnac::theory::allan::switching::Switching;

/// What a test asks for: 100 Hz and no readout, unless told.
#[derive(Debug, Clone)]
struct Model {
    process: Process,
    readout_lsb: f64,
    mean_rate: f64,
    switching: Option<Switching>,
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
            switching: None,
            samples: 4096,
            estimator: THINNED,
            ms: octaves(4096, 2),
        }
    }

    fn lower(&self) -> Result<Records, Refusal> {
        Records::new(&Asked {
            process: &self.process,
            readout_lsb: self.readout_lsb,
            mean_rate: self.mean_rate,
            switching: self.switching,
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
        ("quantisation", Part::quantisation(0.24), -1.0, [1, 1024]),
        ("angle random walk", Part::angle_random_walk(0.04), -0.5, [1, 1024]),
        ("bias instability", Part::bias_instability(0.002, 24), 0.0, [1, 1024]),
        ("rate random walk", Part::rate_random_walk(1e-4), 0.5, [16, 1024]),
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
    let ramp = Part::rate_ramp(-3e-3);
    let warm_ups = [Part::warm_up(0.5, 7.0), Part::warm_up(-2.0, 0.1), Part::warm_up(30.0, 1e5)];
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
    let n = Part::angle_random_walk(0.04);
    let markov = |time_s| Part::markov(0.01, time_s);
    let sine = |frequency_hz| Part::sine(0.3, frequency_hz);
    let ramp = Part::rate_ramp(1e-3);
    let warm_up = Part::warm_up(0.5, 7.0);
    let flicker = Part::bias_instability(0.01, 24);
    let quiet = 0.0;
    let tables: Vec<(&str, Vec<Part>, f64, f64)> = vec![
        ("Markov, short", vec![markov(0.003)], quiet, 0.0),
        ("Markov", vec![markov(0.5)], quiet, 0.0),
        ("Markov, long", vec![markov(1000.0)], quiet, 0.0),
        ("Markov, longest", vec![markov(1.5e5)], quiet, 0.0),
        ("sine", vec![n, sine(1.234)], quiet, 0.0),
        ("slow sine", vec![n, sine(0.003)], quiet, 0.0),
        ("sine beyond half the rate", vec![n, sine(61.0)], quiet, 0.0),
        ("pulses of the earth's rate", vec![], 0.38, 15.041),
        ("pulses and white noise", vec![n], 0.38, 15.041),
        ("pulses, noises and a sine", vec![n, markov(0.5), sine(1.7), Part::quantisation(0.05)], 0.1, 3.3),
        ("pulses and flicker", vec![Part::angle_random_walk(0.9), flicker], 0.02, 15.041),
        ("pulses on a ramp", vec![Part::angle_random_walk(0.9), ramp, warm_up], 0.02, 15.041),
        ("ramp and noise", vec![n, ramp, warm_up], quiet, 0.0),
    ];
    for (name, parts, readout_lsb, mean_rate) in tables {
        for estimator in [THINNED, Estimator { difference: Difference::Third, ..THINNED }] {
            let ms = octaves(
                if name.starts_with("Markov, long") { 512 } else { 2048 },
                estimator.difference.spans(),
            );
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

/// The gyros of the Allan paper's table 2: Q in ″, N in °/√h, B in °/h.
fn gyros() -> [(&'static str, Vec<Part>); 2] {
    let parts = |q: f64, n: f64, b: f64| {
        vec![Part::quantisation(q), Part::angle_random_walk(n * 60.0), Part::bias_instability(b, 24)]
    };
    [("LGK-400", parts(0.24, 0.00067, 0.00192)), ("LGV-1", parts(0.11, 0.00048, 0.00164))]
}

/// Records of nine hours at 1 Hz.
fn nine_hours(parts: &[Part]) -> Model {
    let process = Process { sample_s: 1.0, parts: parts.to_vec() };
    Model { process, samples: 32_400, ms: octaves(32_400, 2), ..Model::of(&[]) }
}

#[test]
fn the_papers_gyros_have_their_oracles_at_all_octaves() {
    for (name, parts) in gyros() {
        let model = nine_hours(&parts);
        let records = model.lowered();
        let z = compare(name, &records, &sampled(&records, 1024));
        let off = off_the_model(&model, &records);
        assert!(off < 1e-4, "{name}: the words are off the model by {off}");
        println!("{name}: {} octaves, largest |z| {z:.2}, words off by {off:.1e}", model.ms.len());
    }
}

#[test]
fn flicker_is_flat_to_half_a_percent_for_all_octaves_of_a_record() {
    let b = 0.00192;
    let parts = [Part::bias_instability(b, 24)];
    let ms: Vec<u64> = (0..=80).map(|eighth| (f64::from(eighth) / 4.0).exp2().round() as u64).collect();
    let records = Model { samples: 1 << 21, ms: ms.clone(), ..Model::of(&parts) }.lowered();
    let off = |at: usize| records.oracle(at).value.unwrap() / (FLAT_LEVEL * b * b) - 1.0;
    let offs: Vec<f64> = (0..ms.len()).map(off).collect();
    for (m, off) in ms.iter().zip(&offs) {
        assert!(off.abs() < 0.005, "m = {m}: {off}");
    }
    println!("flicker: off by at most {:.2e}", offs.iter().fold(0.0_f64, |most, off| most.max(off.abs())));
}

/// Models that differ in all that lowering distinguishes.
fn models() -> Vec<Model> {
    let everything = [
        Part::quantisation(0.24),
        Part::angle_random_walk(0.04),
        Part::bias_instability(0.002, 24),
        Part::rate_random_walk(1e-4),
        Part::markov(0.01, 3.0),
        Part::sine(0.3, 1.234),
        Part::rate_ramp(1e-4),
        Part::warm_up(0.5, 7.0),
    ];
    let all = Model { samples: 3000, ms: octaves(3000, 3), ..Model::of(&everything) };
    vec![
        nine_hours(&gyros()[0].1),
        all.clone(),
        Model { readout_lsb: 0.38, mean_rate: 15.041, ..all },
        Model::of(&everything[3..5]),
        Model::of(&everything[5..7]),
    ]
}

#[test]
fn another_curve_of_the_same_record_changes_no_draw() {
    for model in models() {
        let records = model.lowered();
        let overlapping = [Estimator::OVERLAPPING, Estimator::NON_OVERLAPPING, Estimator::HADAMARD, THINNED];
        for estimator in overlapping {
            for ms in [vec![1], vec![3, 7, 100, 640], vec![model.samples / estimator.difference.spans()]] {
                let other = Model { estimator, ms: ms.clone(), ..model.clone() }.lowered();
                assert_eq!(other.lsb_arcsec(), records.lsb_arcsec());
                let drawn = Recipe {
                    order: records.recipe().order,
                    levels: records.recipe().levels.clone(),
                    ..other.recipe().clone()
                };
                assert_eq!(&drawn, records.recipe(), "{estimator:?}, {ms:?}");
                assert_ne!(other.digest(), records.digest(), "{estimator:?}, {ms:?}");
                assert_eq!(
                    other.terms(),
                    ms.iter().map(|&m| estimator.terms(model.samples, m)).collect::<Vec<_>>()
                );
            }
        }
    }
}

#[test]
fn estimates_are_in_the_order_asked_whatever_that_of_the_kernel() {
    let model = Model { ms: vec![6, 64, 127, 128, 130, 192, 640, 1000], ..models().remove(1) };
    let records = model.lowered();
    let strides: Vec<u32> = records.recipe().levels.iter().map(|level| level.stride).collect();
    assert_eq!(strides, [1, 2, 3, 10]);
    let together = sampled(&records, 3);
    for (at, &m) in model.ms.iter().enumerate() {
        let alone = sampled(&Model { ms: vec![m], ..model.clone() }.lowered(), 3);
        assert_eq!(together[at], alone[0], "m = {m}");
    }
}

#[test]
fn the_words_of_a_model_are_the_same_on_every_machine() {
    let digests: Vec<String> = models().iter().map(|model| model.lowered().digest().to_string()).collect();
    let golden = [
        "999dc8447b93a525b3e433f3cffd6cb4",
        "725d3a5c7de4b5075577de58fd98d542",
        "e04734152ea58ecb75629af0629ce8ae",
        "8b9a8ca5966e791dfbc6181d59e00d26",
        "3a6a1cb0cb9e151fdce410797684759f",
    ];
    assert_eq!(digests, golden, "raise kernel::allan::VERSION where sums change, and put the new ones here");
}

#[test]
fn where_rounding_hides_the_angle_the_oracle_is_blank() {
    // The rate walks so far in 2^21 samples that from one sample to the next it is lost in the unit of angle.
    let parts = [Part::rate_random_walk(1.0)];
    let records = Model { samples: 1 << 21, ms: octaves(1 << 21, 2), ..Model::of(&parts) }.lowered();
    let known: Vec<bool> = (0..records.ms().len()).map(|at| records.oracle(at).value.is_some()).collect();
    let first = known.iter().position(|&known| known).unwrap();
    assert!((1..=10).contains(&first) && known[first..].iter().all(|&known| known), "{known:?}");
    // Pulses that the angle stays in for many samples, of an angle without a closed form.
    let parts = [Part::angle_random_walk(0.04), Part::bias_instability(0.01, 24)];
    let records = Model { readout_lsb: 0.38, ..Model::of(&parts) }.lowered();
    assert_eq!(records.oracle(0).value, None, "{:?}", records.oracle(0));
    assert!(records.oracle(11).value.is_some());
}

/// Largest difference of a record at `m`, LSB, from its words and 16 standard deviations of its noise.
fn largest(recipe: &Recipe, difference: Difference, m: u64) -> f64 {
    let unit = f64::from(recipe.rate_scale) / 2.0_f64.powi(32);
    let of_sigma = |word: u32| f64::from(word) / 16.0;
    let mut parts = vec![
        Part::quantisation(of_sigma(recipe.quantisation)),
        Part::angle_random_walk(of_sigma(recipe.white)),
        Part::rate_random_walk(unit * of_sigma(recipe.walk)),
    ];
    if let Some([loss, _, start]) = recipe.markov {
        let time_s = -1.0 / (-f64::from(loss) / 2.0_f64.powi(30)).ln_1p();
        let q_c = unit * f64::from(start) / 4.0 * (2.0 / time_s).sqrt();
        parts.push(Part::markov(q_c, time_s));
    }
    let sine = recipe.sine.map_or(0.0, |[step, amplitude]| {
        let frequency_hz = f64::from(step) / 2.0_f64.powi(32);
        let amplitude = f64::from(amplitude) / 4.0 * std::f64::consts::TAU * frequency_hz;
        Part::sine(amplitude, frequency_hz).largest(difference, 1.0, m)
    });
    let process = Process { sample_s: 1.0, parts };
    let holds = (1..).zip(&recipe.flicker).map(|(octave, &word)| {
        let streams = if octave < 3 { 1.0 } else { 4.0 };
        let sigma = unit * of_sigma(word);
        streams * sigma * sigma * holds::mean_square(difference, 1 << octave, m)
    });
    let noise = process.variance(difference, m) + holds.sum::<f64>();
    let spans = difference.spans();
    let drift = |k: u64| {
        let angle = |n: u64| recipe.drift[(k + n * m) as usize];
        let second = |n: u64| angle(n).wrapping_add(angle(n + 2)).wrapping_sub(angle(n + 1).wrapping_mul(2));
        let found = if spans == 2 { second(0) } else { second(1).wrapping_sub(second(0)) };
        f64::from(found as i32).abs()
    };
    let last = if recipe.drift.is_empty() { 0 } else { u64::from(recipe.samples) - spans * m + 1 };
    let drift = (0..last).step_by(1 + last as usize / 500).map(drift).fold(0.0, f64::max);
    let pulses = recipe.pulse.map_or(0.0, |bits| f64::from(bits).exp2()) * f64::from(1 << (spans - 1));
    16.0 * noise.sqrt() + sine + drift + pulses
}

#[test]
fn no_model_leaves_the_room_that_there_is() {
    let mut random = StdRng::seed_from_u64(7);
    let (mut lowered, mut most, mut refused) = (0, 0.0_f64, BTreeMap::new());
    for _ in 0..3000 {
        let mut size = || 10.0_f64.powf(random.random_range(-5.0..3.0));
        let all = [
            ("noise.quantisation", Part::quantisation(size())),
            ("noise.angle_random_walk", Part::angle_random_walk(size())),
            ("noise.bias_instability", Part::bias_instability(size(), 24)),
            ("noise.rate_random_walk", Part::rate_random_walk(size())),
            ("noise.markov", Part::markov(size(), size())),
            ("noise.sine", Part::sine(size(), size())),
            ("noise.rate_ramp", Part::rate_ramp(size())),
            ("noise.warm_up", Part::warm_up(-size(), size())),
        ];
        let readout_lsb = if random.random_bool(0.2) { random.random_range(0.01..1.0) } else { 0.0 };
        let chosen: Vec<_> = all.into_iter().filter(|_| random.random_bool(0.3)).collect();
        let samples = random.random_range(1.0..17.0_f64).exp2() as u64;
        let process = Process {
            sample_s: 10.0_f64.powi(random.random_range(-3..1)),
            parts: chosen.iter().map(|c| c.1).collect(),
        };
        let model = Model { process, readout_lsb, mean_rate: 15.0, samples, ms: vec![1], ..Model::of(&[]) };
        match model.lower() {
            Ok(records) => {
                lowered += 1;
                let recipe = records.recipe();
                for difference in [Difference::Second, Difference::Third] {
                    let longest = samples / difference.spans();
                    for m in [1, 2, 3, longest / 3, longest / 2, longest]
                        .into_iter()
                        .filter(|m| (1..=longest).contains(m))
                    {
                        let largest = largest(recipe, difference, m) / 2.0_f64.powi(29);
                        assert!(largest < 1.0, "{model:?}, {difference:?}, m = {m}: {largest} of the limit");
                        most = most.max(largest);
                    }
                }
                let held: f64 = (1..)
                    .zip(&recipe.flicker)
                    .map(|(o, &w)| if o < 3 { 1.0 } else { 4.0 } * f64::from(w).powi(2))
                    .sum();
                let walked = f64::from(recipe.walk).powi(2) * samples as f64;
                let markov = recipe.markov.map_or(0.0, |[_, _, start]| 4.0 * f64::from(start));
                let rate = 16.0 * (held + walked + markov * markov).sqrt() / 16.0;
                assert!(rate < 2.0_f64.powi(31), "{model:?}: a rate of {rate}");
            }
            Err(error) => {
                let readout = ("noise.readout_lsb", readout_lsb > 0.0);
                let nothing = ("noise", chosen.is_empty());
                let mut keys = chosen.iter().map(|c| (c.0, true)).chain([readout, nothing]);
                assert!(keys.any(|key| key == (error.key, true)), "{model:?}: {error}");
                *refused.entry(error.key).or_insert(0) += 1;
            }
        }
    }
    assert!(lowered > 500 && most > 0.9, "{lowered} models of at most {most} of the limit");
    println!("{lowered} models, at most {most:.3} of the limit; refused: {refused:?}");
}

#[test]
fn what_cannot_be_made_is_refused_by_the_name_of_its_key() {
    let walk = Part::rate_random_walk(1e3);
    let sine = |frequency_hz| Part::sine(1.0, frequency_hz);
    let markov = Part::markov(1.0, 1.0);
    let white = Part::angle_random_walk(1.0);
    let flicker = Part::bias_instability(1.0, 24);
    let of = |parts: &[Part]| Model::of(parts);
    let table = [
        ("record.length", Model { samples: 1, ..of(&[white]) }),
        ("record.length", Model { samples: (1 << 26) + 1, ..of(&[white]) }),
        ("allan.tau", Model { ms: vec![], ..of(&[white]) }),
        ("allan.tau", Model { ms: vec![0], ..of(&[white]) }),
        ("allan.tau", Model { ms: vec![1, 2049], ..of(&[white]) }),
        ("noise", of(&[])),
        ("noise", of(&[Part::angle_random_walk(0.0), Part::markov(0.0, 1.0)])),
        ("noise.markov", of(&[markov, Part::markov(2.0, 1.0)])),
        ("noise.markov", of(&[Part::markov(1.0, 0.0)])),
        ("noise.markov", of(&[Part::markov(1.0, 1e6)])),
        ("noise.markov", of(&[Part::markov(1e-9, 1.0), walk])),
        ("noise.sine", of(&[sine(1.0), sine(2.0)])),
        ("noise.sine", of(&[sine(0.0)])),
        ("noise.sine", of(&[sine(1e-7)])),
        ("noise.sine", of(&[sine(100.0)])),
        ("noise.sine", of(&[Part::sine(1e-9, 1.0), walk])),
        ("noise.quantisation", of(&[Part::quantisation(-0.1)])),
        ("noise.quantisation", of(&[Part::quantisation(1e-9), walk])),
        ("noise.angle_random_walk", of(&[Part::angle_random_walk(f64::NAN)])),
        ("noise.angle_random_walk", of(&[Part::angle_random_walk(1e-9), walk])),
        ("noise.bias_instability", of(&[Part::bias_instability(1e-9, 24), walk])),
        ("noise.bias_instability", Model { samples: 1 << 26, ..of(&[flicker]) }),
        ("noise.rate_random_walk", of(&[Part::rate_random_walk(1e-20), white])),
        ("noise.rate_ramp", of(&[Part::rate_ramp(f64::INFINITY)])),
        ("noise.rate_ramp", of(&[Part::rate_ramp(1e-9), walk])),
        ("noise.warm_up", of(&[Part::warm_up(1e-9, 1.0), walk])),
        ("noise.readout_lsb", Model { readout_lsb: 1e-3, ..of(&[walk]) }),
        ("noise.readout_lsb", Model { readout_lsb: -1.0, ..of(&[white]) }),
    ];
    for (key, model) in table {
        let error = model.lower().map(|records| records.recipe().clone()).expect_err(key);
        assert_eq!(error.key, key, "{error}");
        assert!(error.to_string().starts_with(&format!("{key}: ")) && !error.help.is_empty(), "{error}");
        println!("{error}; {}", error.help);
    }
}

#[test]
fn parts_of_a_kind_add_up_and_those_of_0_are_none() {
    let twice = |part: Part| [part, part];
    let table = [
        (twice(Part::quantisation(3.0)).to_vec(), Part::quantisation(3.0 * 2.0_f64.sqrt())),
        (twice(Part::angle_random_walk(3.0)).to_vec(), Part::angle_random_walk(3.0 * 2.0_f64.sqrt())),
        (twice(Part::rate_random_walk(3.0)).to_vec(), Part::rate_random_walk(3.0 * 2.0_f64.sqrt())),
        (twice(Part::rate_ramp(3.0)).to_vec(), Part::rate_ramp(6.0)),
        (vec![Part::rate_ramp(0.0), Part::rate_random_walk(1.0)], Part::rate_random_walk(1.0)),
        (vec![Part::markov(0.0, 1.0), Part::markov(1.0, 1.0)], Part::markov(1.0, 1.0)),
    ];
    for (parts, part) in table {
        assert_eq!(Model::of(&parts).lowered().recipe(), Model::of(&[part]).lowered().recipe(), "{part:?}");
    }
}

#[test]
fn the_longest_records_are_lowered() {
    let parts = [Part::quantisation(0.24), Part::angle_random_walk(0.04), Part::rate_random_walk(1e-7)];
    let records = Model { samples: 1 << 26, ms: octaves(1 << 26, 2), ..Model::of(&parts) }.lowered();
    assert!(records.recipe().drift.is_empty());
    // What differences of 64ths of τ keep of a record: 64 spans and a chunk, twice, for each octave.
    assert!(records.recipe().depth() < 6000, "{}", records.recipe().depth());
}
