//! What a record holds besides noise: each kind is found and named, and no coefficient is made of it.
//!
//! `benches/record_events_numpy.py` counts the same over many records of NumPy.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::allan::angles::{Angles, Trend};
use sagnac::allan::deviation::Unit;
use sagnac::analysis::data_sheet::{DataSheet, Intervals};
use sagnac::events::{Event, Events, What};
use sagnac::fit::Verdict;
use sagnac::fit::selection::Terms;
use sagnac::record::log::outliers::outliers;
use sagnac::theory::allan::terms::Term;

use crate::noise::normal;

const SAMPLES: usize = 16_384;

fn white(seed: u64) -> Vec<f64> {
    let mut rng = StdRng::seed_from_u64(seed);
    (0..SAMPLES).map(|_| normal(&mut rng)).collect()
}

/// The events and the coefficients of rates of N = 1 with something else, one a second.
fn found(rates: &[f64], temperatures: &[Vec<f64>]) -> (Vec<Event>, DataSheet) {
    let angles = Angles::from_increments(rates, 1.0, 1.0, Trend::None);
    let events = Events::new(&angles, &outliers(rates), temperatures);
    let closed = Intervals { records: 0, without: None };
    let sheet =
        DataSheet::new(&events, &Terms::of_model(Trend::None).into(), Unit::Angular, closed, None).unwrap();
    (events.list.iter().chain(&sheet.events).cloned().collect(), sheet)
}

/// Whether N is 1 within its interval and no other coefficient is identified.
fn is_white(sheet: &DataSheet) -> bool {
    sheet.fit.coefficients.iter().all(|found| match found.term {
        Term::AngleRandomWalk => found.interval.is_some_and(|[low, high]| low < 1.0 && 1.0 < high),
        Term::Markov => true,
        _ => found.verdict != Verdict::Identified,
    })
}

/// Three records with what `at` adds to a sample: the first events of a kind.
fn named(what: What, at: impl Fn(usize) -> f64) -> Vec<Event> {
    let of = |seed| {
        let rates: Vec<f64> = white(seed).iter().enumerate().map(|(i, x)| x + at(i)).collect();
        let (events, sheet) = found(&rates, &[]);
        assert!(is_white(&sheet), "{what:?}, seed {seed}: {events:?} {:?}", sheet.rows);
        events.into_iter().find(|event| event.what == what).unwrap_or_else(|| panic!("{what:?}, seed {seed}"))
    };
    (1..4).map(of).collect()
}

fn is_near(found: Option<f64>, expected: f64, part: f64) -> bool {
    found.is_some_and(|found| (found / expected - 1.0).abs() < part)
}

#[test]
fn noise_alone_has_no_events() {
    let with_events = (0..40).filter(|&seed| !found(&white(100 + seed), &[]).0.is_empty()).count();
    assert!(with_events <= 2, "{with_events} of 40");
}

#[test]
fn a_step_is_found_where_it_is_and_is_no_random_walk() {
    for event in named(What::Step, |i| if i < 5000 { 0.0 } else { 3.0 }) {
        let [at, _] = event.samples.unwrap();
        assert!(at.abs_diff(5000) <= 3 && is_near(event.size, 3.0, 0.1), "{event:?}");
    }
}

#[test]
fn a_slow_sine_is_no_ramp_and_a_warm_up_no_random_walk() {
    let turn = core::f64::consts::TAU * 2.0 / SAMPLES as f64;
    for event in named(What::Sine, |i| 0.5 * (turn * i as f64).sin()) {
        assert!(is_near(event.size, 0.5, 0.15), "{event:?}");
        assert!(is_near(event.frequency_hz, 2.0 / SAMPLES as f64, 0.15), "{event:?}");
    }
    for event in named(What::WarmUp, |i| 2.0 * (-(i as f64) / 2000.0).exp()) {
        assert!(is_near(event.size, 2.0, 0.2) && is_near(event.time_s, 2000.0, 0.3), "{event:?}");
    }
}

#[test]
fn thirty_spikes_are_spikes_and_long_tails_are_none() {
    for event in named(What::Spikes, |i| if i % 546 == 100 { 40.0 } else { 0.0 }) {
        assert!(event.count == 30 && is_near(event.size, 40.0, 0.2), "{event:?}");
    }
    // Student's t with 3 degrees of freedom.
    let mut rng = StdRng::seed_from_u64(9);
    let mut t = || {
        let squares: f64 = (0..3).map(|_| normal(&mut rng)).map(|x| x * x).sum();
        normal(&mut rng) / (squares / 3.0).sqrt()
    };
    let (events, _) = found(&(0..4 * SAMPLES).map(|_| t()).collect::<Vec<f64>>(), &[]);
    assert!(events.iter().all(|event| event.what != What::Spikes), "{events:?}");
}

#[test]
fn telegraph_noise_is_told_from_flicker_by_its_levels() {
    // A level for 300 samples in the mean.
    let mut state = 1_u64;
    let mut level = 0.4;
    let levels: Vec<f64> = (0..SAMPLES)
        .map(|_| {
            state = 16_807 * state % 2_147_483_647;
            level = if state.is_multiple_of(300) { -level } else { level };
            level
        })
        .collect();
    for event in named(What::Telegraph, |i| levels[i]) {
        assert!(is_near(event.size, 0.4, 0.2) && is_near(event.time_s, 300.0, 0.6), "{event:?}");
    }
}

#[test]
fn a_line_is_subtracted_and_an_alias_is_no_quantization() {
    for event in named(What::Line, |i| 0.3 * (1.1 * i as f64).sin()) {
        assert!(is_near(event.size, 0.3, 0.1), "{event:?}");
        assert!(is_near(event.frequency_hz, 1.1 / core::f64::consts::TAU, 1e-3), "{event:?}");
    }
    // Half of the noise is repeated with the opposite sign one sample later: neither white nor that of quantization, and of N = 1 at
    // long τ.
    let x = white(7);
    let rates: Vec<f64> = x.windows(3).map(|x| 1.4 * x[2] - 0.7 * x[1] + 0.3 * x[0]).collect();
    let (events, sheet) = found(&rates, &[]);
    assert!(is_white(&sheet), "{:?}", sheet.rows);
    assert!(events.iter().any(|event| event.what == What::Filter), "{events:?}");
}

#[test]
fn a_temperature_that_explains_the_rate_is_named() {
    let temperature: Vec<f64> = (0..SAMPLES).map(|i| 20.0 + 5.0 * (i as f64 / 2500.0).sin()).collect();
    let rates: Vec<f64> = white(3).iter().zip(&temperature).map(|(x, t)| x + 0.2 * (t - 20.0)).collect();
    let (events, sheet) = found(&rates, &[temperature]);
    assert_eq!(events.iter().map(|event| event.what).collect::<Vec<_>>(), [What::Temperature]);
    assert!(is_near(events[0].size, 0.2, 0.1) && is_white(&sheet), "{events:?} {:?}", sheet.rows);
}

#[test]
fn a_readout_in_whole_units_is_noted() {
    let rates: Vec<f64> = white(4).iter().map(|x| 2.0 * (x / 2.0).round()).collect();
    let (events, _) = found(&rates, &[]);
    assert!(events[0].what == What::Units && is_near(events[0].size, 2.0, 1e-9), "{events:?}");
}

/// Noise that is not Gaussian, independent from sample to sample.
fn not_gaussian(noise: &str, samples: usize, seed: u64) -> Vec<f64> {
    let mut rng = StdRng::seed_from_u64(seed);
    let mut uniform = || rng.random_range(-1.0..1.0_f64);
    let sample = || match noise {
        "uniform" => uniform(),
        "Laplace" => uniform().signum() * (1.0 - uniform().abs()).ln(),
        // Two values and a little noise.
        _ => uniform().signum() + 0.2 * (uniform() + uniform()),
    };
    std::iter::repeat_with(sample).take(samples).collect()
}

#[test]
fn noise_that_is_not_gaussian_has_no_events() {
    for noise in ["uniform", "Laplace", "two values"] {
        let count = |samples: usize| {
            let has_events = |seed: &u64| {
                found(&not_gaussian(noise, samples, *seed), &[])
                    .0
                    .iter()
                    .any(|event| event.what != What::Units)
            };
            (0..10).filter(has_events).count()
        };
        for samples in [500, 5000, 50_000] {
            let with_events = count(samples);
            assert!(with_events <= 1, "{noise}, {samples} samples: {with_events} of 10");
        }
    }
}

#[test]
fn the_interval_of_n_contains_what_fast_telegraph_noise_adds() {
    let is_covered = |seed: &u64| {
        let mut rng = StdRng::seed_from_u64(500 + seed);
        let mut level = 0.1;
        let rates: Vec<f64> = white(*seed)
            .iter()
            .map(|x| {
                level *= if rng.random::<f64>() < 0.05 { -1.0 } else { 1.0 };
                x + level
            })
            .collect();
        let (_, sheet) = found(&rates, &[]);
        let [low, high] = sheet.fit.coefficient(Term::AngleRandomWalk).unwrap().interval.unwrap();
        low < 1.0 && 1.0 < high
    };
    let covered = (0..60).filter(is_covered).count();
    assert!(covered >= 50, "{covered} of 60");
}

#[test]
fn a_noise_burst_is_found_and_left_out() {
    let louder = 5000..7000;
    let is_right = |seed: u64| {
        let mut rates = white(seed);
        rates[louder.clone()].iter_mut().for_each(|x| *x *= 3.0);
        let (events, sheet) = found(&rates, &[]);
        assert_eq!(events[0].what, What::NoiseBurst, "seed {seed}: {events:?}");
        let [from, to] = events[0].samples.unwrap();
        assert!(from.abs_diff(5000) <= 48 && to.abs_diff(7000) <= 48, "seed {seed}: {events:?}");
        // Noise of 3 is noise of 1 and of √8.
        assert!(is_near(events[0].size, 8.0_f64.sqrt(), 0.1), "seed {seed}: {events:?}");
        events.len() == 1 && is_white(&sheet)
    };
    let right = (1..9).filter(|&seed| is_right(seed)).count();
    assert!(right >= 6, "{right} of 8");
}

#[test]
fn spikes_within_a_noise_burst_belong_to_it_and_loud_halves_are_none() {
    let mut rates = white(5);
    rates[1000..1160].iter_mut().for_each(|x| *x *= 30.0);
    rates[9000] += 60.0;
    let (events, _) = found(&rates, &[]);
    assert_eq!(events.iter().map(|event| event.what).collect::<Vec<_>>(), [What::NoiseBurst, What::Spikes]);
    assert_eq!(events[1].samples, Some([9000, 9001]), "{events:?}");
    let mut rates = white(6);
    rates[2000..SAMPLES - 2000].iter_mut().for_each(|x| *x *= 3.0);
    let (events, _) = found(&rates, &[]);
    assert!(events.iter().all(|event| event.what != What::NoiseBurst), "{events:?}");
}
