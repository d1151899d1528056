//! Limits of records: what no model may exceed, and what is refused.

use std::collections::BTreeMap;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::theory::allan::{Difference, Part, Process, flicker};
use sagnac_kernel::recipe::Recipe;

use super::{Model, octaves};

/// Largest difference of a record at `m`, LSB, from its words and 16 standard deviations of its noise.
fn largest(recipe: &Recipe, difference: Difference, m: u64) -> f64 {
    let unit = f64::from(recipe.rate_scale) / 2.0_f64.powi(32);
    let of_sigma = |word: u32| f64::from(word) / 16.0;
    let mut parts = vec![
        Part::quantization(of_sigma(recipe.quantization)),
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
        (2.0 * Part::sine(amplitude, frequency_hz).variance(difference, 1.0, m)).sqrt()
    });
    let process = Process { sample_s: 1.0, parts };
    let holds = (1..).zip(&recipe.flicker).map(|(octave, &word)| {
        let streams = if octave < 3 { 1.0 } else { 4.0 };
        let sigma = unit * of_sigma(word);
        streams * sigma * sigma * flicker::mean_square(difference, 1 << octave, m)
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
            ("noise.quantization", Part::quantization(size())),
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
        let model = Model { process, readout_lsb, mean_rate: 15.0, samples, ms: vec![1], ..Model::new(&[]) };
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
    let of = |parts: &[Part]| Model::new(parts);
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
        // What it loses in a sample has not even one unit.
        ("noise.markov", of(&[Part::markov(1.0, 1e9), white])),
        ("noise.markov", of(&[Part::markov(1e-9, 1.0), walk])),
        ("noise.sine", of(&[sine(1.0), sine(2.0)])),
        ("noise.sine", of(&[sine(0.0)])),
        ("noise.sine", of(&[sine(1e-7)])),
        ("noise.sine", of(&[sine(100.0)])),
        ("noise.sine", of(&[Part::sine(1e-9, 1.0), walk])),
        ("noise.quantization", of(&[Part::quantization(-0.1)])),
        ("noise.quantization", of(&[Part::quantization(1e-9), walk])),
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
        (twice(Part::quantization(3.0)).to_vec(), Part::quantization(3.0 * 2.0_f64.sqrt())),
        (twice(Part::angle_random_walk(3.0)).to_vec(), Part::angle_random_walk(3.0 * 2.0_f64.sqrt())),
        (twice(Part::rate_random_walk(3.0)).to_vec(), Part::rate_random_walk(3.0 * 2.0_f64.sqrt())),
        (twice(Part::rate_ramp(3.0)).to_vec(), Part::rate_ramp(6.0)),
        (vec![Part::rate_ramp(0.0), Part::rate_random_walk(1.0)], Part::rate_random_walk(1.0)),
        (vec![Part::markov(0.0, 1.0), Part::markov(1.0, 1.0)], Part::markov(1.0, 1.0)),
    ];
    for (parts, part) in table {
        assert_eq!(Model::new(&parts).lowered().recipe(), Model::new(&[part]).lowered().recipe(), "{part:?}");
    }
}

#[test]
fn the_longest_records_are_lowered() {
    let parts = [Part::quantization(0.24), Part::angle_random_walk(0.04), Part::rate_random_walk(1e-7)];
    let records = Model { samples: 1 << 26, ms: octaves(1 << 26, 2), ..Model::new(&parts) }.lowered();
    assert!(records.recipe().drift.is_empty());
    // What differences of 64ths of τ keep of a record: 64 spans and a chunk, twice, for each octave.
    assert!(records.recipe().depth() < 6000, "{}", records.recipe().depth());
}
