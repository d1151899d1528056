//! Noise models in physical units, lowered to records: their curves against the laws and the theory of the lowered words.

use sagnac::device::Cpu;
use sagnac::theory::allan::{Difference, Estimator, FLAT_LEVEL, Part, Process};
use sagnac::theory::drift::Switching;
use sagnac_engine::key::Unrepresentable;
use sagnac_engine::kinds::allan::lower::{Asked, Records};
use sagnac_engine::kinds::allan::verify::THINNED;
use sagnac_kernel::recipe::Recipe;
use sagnac_kernel::width::Width;

mod limits;

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
    fn new(parts: &[Part]) -> Model {
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

    fn lower(&self) -> Result<Records, Unrepresentable> {
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

/// Compares the mean of each estimate with its theory; the largest |z|.
fn compare(name: &str, records: &Records, sampled: &[Vec<f64>]) -> f64 {
    let mut largest: f64 = 0.0;
    for (at, &m) in records.ms().iter().enumerate() {
        let (mean, se) = mean(&sampled[at]);
        let theory = records.theory(at);
        let Some(value) = theory.value else {
            panic!("{name}, m = {m}: no theory beside {mean}: {theory:?}")
        };
        let z = (mean - value) / se.hypot(theory.rounding);
        assert!(z.abs() < 5.0, "{name}, m = {m}: {mean} ± {se}, not {value} ± {}, z = {z}", theory.rounding);
        assert!(se < 0.04 * value, "{name}, m = {m}: {mean} ± {se} says nothing");
        assert!(theory.rounding < 0.005 * value, "{name}, m = {m}: {theory:?} says nothing");
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

/// Largest relative difference of the theory from the model in physical units.
fn off_the_model(model: &Model, records: &Records) -> f64 {
    let off = |(at, &m): (usize, &u64)| {
        let expected = model.process.expected(model.estimator, model.samples, m).unwrap();
        (records.theory(at).value.unwrap() / expected - 1.0).abs()
    };
    model.ms.iter().enumerate().map(off).fold(0.0, f64::max)
}

#[test]
fn every_noise_has_its_slope_and_its_theory() {
    // Up to where a curve of so many records says something, and from where the sampled law is the continuous one.
    let references = [
        ("quantization", Part::quantization(0.24), -1.0, [1, 1024]),
        ("angle random walk", Part::angle_random_walk(0.04), -0.5, [1, 1024]),
        ("bias instability", Part::bias_instability(0.002, 24), 0.0, [1, 1024]),
        ("rate random walk", Part::rate_random_walk(1e-4), 0.5, [16, 1024]),
    ];
    for (name, part, law, [from, to]) in references {
        let model = Model { ms: octaves(2048, 2), ..Model::new(&[part]) };
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
            let model = Model { estimator, ..Model::new(&parts) };
            let records = model.lowered();
            for (at, found) in sampled(&records, 2).into_iter().enumerate() {
                let (m, theory) = (model.ms[at], records.theory(at));
                let value = theory.value.unwrap();
                assert_eq!(found[0], found[1], "{parts:?}, m = {m}");
                assert!(
                    (found[0] - value).abs() <= theory.rounding,
                    "{parts:?}, m = {m}: {found:?}, {theory:?}"
                );
                // Every angle is rounded by half an LSB: a difference by two.
                let expected = model.process.expected(estimator, model.samples, m).unwrap();
                let off = 2.0 * records.lsb_arcsec() / (0.01 * m as f64) / 2.0_f64.sqrt();
                let near = (value.sqrt() - expected.sqrt()).abs() <= 1.001 * off;
                assert!(near, "{parts:?}, m = {m}: {value}, not {expected}");
            }
        }
    }
    let records = Model { ms: vec![64, 128, 256, 512, 1024, 2048], ..Model::new(&[ramp]) }.lowered();
    let (slope, _) = slope(&records, &sampled(&records, 2), 64, 2048);
    assert!((slope - 1.0).abs() < 1e-6, "ramp: slope {slope}");
}

#[test]
fn markov_noise_sines_and_readouts_have_their_theories() {
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
        ("pulses, noises and a sine", vec![n, markov(0.5), sine(1.7), Part::quantization(0.05)], 0.1, 3.3),
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
            let model = Model { readout_lsb, mean_rate, estimator, ms, ..Model::new(&parts) };
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
        vec![Part::quantization(q), Part::angle_random_walk(n * 60.0), Part::bias_instability(b, 24)]
    };
    [("LGK-400", parts(0.24, 0.00067, 0.00192)), ("LGV-1", parts(0.11, 0.00048, 0.00164))]
}

/// Records of nine hours at 1 Hz.
fn nine_hours(parts: &[Part]) -> Model {
    let process = Process { sample_s: 1.0, parts: parts.to_vec() };
    Model { process, samples: 32_400, ms: octaves(32_400, 2), ..Model::new(&[]) }
}

#[test]
fn the_papers_gyros_have_their_theories_at_all_octaves() {
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
    let records = Model { samples: 1 << 21, ms: ms.clone(), ..Model::new(&parts) }.lowered();
    let off = |at: usize| records.theory(at).value.unwrap() / (FLAT_LEVEL * b * b) - 1.0;
    let offs: Vec<f64> = (0..ms.len()).map(off).collect();
    for (m, off) in ms.iter().zip(&offs) {
        assert!(off.abs() < 0.005, "m = {m}: {off}");
    }
    println!("flicker: off by at most {:.2e}", offs.iter().fold(0.0_f64, |most, off| most.max(off.abs())));
}

/// Models that differ in all that lowering distinguishes.
fn models() -> Vec<Model> {
    let everything = [
        Part::quantization(0.24),
        Part::angle_random_walk(0.04),
        Part::bias_instability(0.002, 24),
        Part::rate_random_walk(1e-4),
        Part::markov(0.01, 3.0),
        Part::sine(0.3, 1.234),
        Part::rate_ramp(1e-4),
        Part::warm_up(0.5, 7.0),
    ];
    let all = Model { samples: 3000, ms: octaves(3000, 3), ..Model::new(&everything) };
    vec![
        nine_hours(&gyros()[0].1),
        all.clone(),
        Model { readout_lsb: 0.38, mean_rate: 15.041, ..all },
        Model::new(&everything[3..5]),
        Model::new(&everything[5..7]),
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
fn where_rounding_hides_the_angle_the_theory_is_blank() {
    // The rate walks so far in 2^21 samples that from one sample to the next it is lost in the unit of angle.
    let parts = [Part::rate_random_walk(1.0)];
    let records = Model { samples: 1 << 21, ms: octaves(1 << 21, 2), ..Model::new(&parts) }.lowered();
    let known: Vec<bool> = (0..records.ms().len()).map(|at| records.theory(at).value.is_some()).collect();
    let first = known.iter().position(|&known| known).unwrap();
    assert!((1..=10).contains(&first) && known[first..].iter().all(|&known| known), "{known:?}");
    // Pulses that the angle stays in for many samples, of an angle without a closed form.
    let parts = [Part::angle_random_walk(0.04), Part::bias_instability(0.01, 24)];
    let records = Model { readout_lsb: 0.38, ..Model::new(&parts) }.lowered();
    assert_eq!(records.theory(0).value, None, "{:?}", records.theory(0));
    assert!(records.theory(11).value.is_some());
}
