//! The mean squares of synthetic records against the closed forms of the sampled processes.

use std::sync::Arc;

use sagnac::device::Cpu;
use sagnac::theory::allan::{Difference, Estimator, Part, Process, flicker};
use sagnac_kernel::recipe::{Level, Recipe};
use sagnac_kernel::width::Width;

const SAMPLES: u32 = 4000;
const RECORDS: usize = 4096;

/// Angles are in LSB of 1 ″, samples are 1 s apart, the rate has units of 1/256 LSB.
const RATE_UNIT: f64 = 1.0 / 256.0;

fn quiet() -> Recipe {
    Recipe {
        key: [7, 11],
        samples: SAMPLES,
        white: 0,
        rate_scale: 1 << 24,
        walk: 0,
        flicker: vec![],
        markov: None,
        sine: None,
        quantization: 0,
        pulse: None,
        switching: None,
        drift: Arc::new([]),
        order: 2,
        levels: vec![
            Level { stride: 1, spans: vec![1, 2, 3, 8, 64] },
            Level { stride: 4, spans: vec![32, 100] },
            Level { stride: 50, spans: vec![1, 20] },
        ],
    }
}

/// m at each place, in the order of the sums.
fn factors(recipe: &Recipe) -> Vec<u64> {
    let of_level = |level: &Level| {
        let stride = u64::from(level.stride);
        level.spans.iter().map(move |&span| stride * u64::from(span)).collect::<Vec<_>>()
    };
    recipe.levels.iter().flat_map(of_level).collect()
}

/// Compares the mean square of each difference, ″², with what `expected` says for m.
fn check(name: &str, recipe: &Recipe, expected: impl Fn(u64) -> f64) {
    let sums = Cpu::new(Width::widest(), 0).unwrap().sums(recipe, 1000, RECORDS, &|_| {});
    let (places, terms) = (recipe.places(), recipe.terms());
    let mut largest: f64 = 0.0;
    for (place, m) in factors(recipe).into_iter().enumerate() {
        let squares = || sums.iter().skip(place).step_by(places).map(|&sum| sum as f64 / terms[place] as f64);
        let count = RECORDS as f64;
        let mean = squares().sum::<f64>() / count;
        let variance = squares().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0);
        // Angles are rounded down to whole LSB: that adds up to (1 + 4 + 1)/12 or (1 + 9 + 9 + 1)/12.
        let (se, rounding) = ((variance / count).sqrt(), if recipe.order == 2 { 0.5 } else { 20.0 / 12.0 });
        let z = (mean - expected(m)) / se.hypot(rounding);
        assert!(z.abs() < 5.0, "{name}, m = {m}: {mean} ± {se}, not {}, z = {z}", expected(m));
        assert!(se < 0.03 * mean, "{name}, m = {m}: {mean} ± {se} says nothing");
        largest = largest.max(z.abs());
    }
    println!("{name}: {places} averaging factors, largest |z| {largest:.2}");
}

fn process(part: Part) -> impl Fn(u64) -> f64 {
    let process = Process { sample_s: 1.0, parts: vec![part] };
    move |m| process.variance(Difference::Second, m)
}

#[test]
fn every_noise_has_the_variance_of_its_closed_form() {
    let white = Recipe { white: 16 * 1000, ..quiet() };
    check("white", &white, process(Part::angle_random_walk(1000.0)));
    let quantization = Recipe { quantization: 16 * 1000, ..quiet() };
    check("quantization", &quantization, process(Part::quantization(1000.0)));
    let walk = Recipe { walk: 16 * 25_600, ..quiet() };
    check("rate random walk", &walk, process(Part::rate_random_walk(25_600.0 * RATE_UNIT)));

    // A loss of 2^−5 a sample; the stationary variance follows from the step's.
    let (loss, step): (f64, f64) = (1.0 / 32.0, 25_600.0);
    let sigma = step / (1.0 - (1.0 - loss) * (1.0 - loss)).sqrt();
    let words = [1 << 25, 4 * 25_600, (4.0 * sigma).round() as u32];
    let time_s = -1.0 / (1.0 - loss).ln();
    let q_c = sigma * RATE_UNIT * (2.0 / time_s).sqrt();
    check("Markov", &Recipe { markov: Some(words), ..quiet() }, process(Part::markov(q_c, time_s)));

    // The angle's amplitude is A/(2πf).
    let (step, amplitude) = (123_456_789_u32, 40_000.0);
    let frequency_hz = f64::from(step) / 4_294_967_296.0;
    let sine = Recipe { sine: Some([step, (4.0 * amplitude) as u32]), ..quiet() };
    let rate = amplitude * std::f64::consts::TAU * frequency_hz;
    check("sine", &sine, process(Part::sine(rate, frequency_hz)));
}

#[test]
fn flicker_is_the_sum_of_its_octave_holds() {
    let sigmas: Vec<f64> = (1..=13).map(|octave| 20_000.0 + 1000.0 * f64::from(octave)).collect();
    for octave in 1..=13 {
        // In octaves with four streams each has half of the standard deviation.
        let sigma =
            |o: usize| if o == octave { 16.0 * sigmas[o - 1] / if o < 3 { 1.0 } else { 2.0 } } else { 0.0 };
        let alone = Recipe { flicker: (1..=13).map(|o| sigma(o) as u32).collect(), ..quiet() };
        // Long holds hardly change in short differences: only what is seen well is compared.
        let levels = vec![Level { stride: 1, spans: vec![1 << octave.min(9), 1 << octave.min(10)] }];
        check(&format!("holds of octave {octave}"), &Recipe { levels, ..alone }, |m| {
            let rate = sigmas[octave - 1] * RATE_UNIT;
            rate * rate * flicker::mean_square(Difference::Second, 1 << octave, m)
        });
    }
}

#[test]
fn a_readout_and_all_noises_together_add_up() {
    let all = Recipe { white: 16 * 300, walk: 16 * 2560, quantization: 16 * 500, pulse: Some(10), ..quiet() };
    let parts = vec![
        Part::angle_random_walk(300.0),
        Part::rate_random_walk(10.0),
        Part::quantization(500.0),
        // Pulses of 1024 LSB under more than half a pulse of white noise: white themselves to 1e-3.
        Part::quantization(1024.0 / 12.0_f64.sqrt()),
    ];
    let process = Process { sample_s: 1.0, parts };
    check("all", &all, |m| process.variance(Difference::Second, m));
}

#[test]
fn third_differences_are_those_of_hadamard() {
    let recipe = Recipe { white: 16 * 1000, walk: 16 * 2560, order: 3, ..quiet() };
    let parts = vec![Part::angle_random_walk(1000.0), Part::rate_random_walk(10.0)];
    let process = Process { sample_s: 1.0, parts };
    check("Hadamard", &recipe, |m| process.variance(Difference::Third, m));
    for m in factors(&recipe) {
        assert!(Estimator::HADAMARD.terms(u64::from(SAMPLES), m) > 0, "m = {m}");
    }
}
