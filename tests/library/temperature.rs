//! The dependence of logs on temperature: exact without noise, within its intervals with noise of other generators.

use core::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::PathBuf;

use rand::SeedableRng;
use rand::rngs::StdRng;
use sagnac::analysis::log::Treatment;
use sagnac::analysis::temperature::{Dependence, Effect, Effects, Temperature};
use sagnac::fit::regression::Estimate;
use sagnac::record::log::measure::{Data, Unit, UnitCheck};
use sagnac::record::log::read::{Hints, Request, Timing};
use sagnac::record::log::{Log, Thermometer};
use sagnac::theory::allan::{Part, Process};
use tempfile::TempDir;

use crate::noise::record;

const SAMPLES: usize = 20_000;

fn treatment() -> Treatment {
    Treatment { unit_check: UnitCheck::Off, ..Treatment::AS_RECORDED }
}

/// A log of samples in °/h or ″ every second, with a temperature called `t`.
fn log(data: Data, samples: &[f64], temperature: impl Fn(usize) -> Option<f64>) -> Log {
    let folder = TempDir::new().unwrap();
    let path: PathBuf = folder.path().join("log.csv");
    let mut text = "gz,t [degC]\n".to_owned();
    for (i, sample) in samples.iter().enumerate() {
        let cell = temperature(i).map_or_else(String::new, |x| x.to_string());
        writeln!(text, "{},{cell}", if sample.is_nan() { String::new() } else { sample.to_string() })
            .unwrap();
    }
    std::fs::write(&path, text).unwrap();
    let unit = if data == Data::Rate { "deg/h" } else { "arcsec" };
    let request = Request {
        columns: vec![],
        timing: Timing::Stamps { step_s: Some(1.0), column: None, unit: None },
        data: Some(data),
        units: vec![Unit::parse(unit, data).unwrap()],
        temperature: Some(Thermometer { column: "t".to_owned(), unit: None }),
        hints: Hints::default(),
    };
    Log::read(&path, &request).unwrap_or_else(|error| panic!("{}", error.render(false, 110)))
}

fn found(log: &Log, effects: &Effects) -> Temperature {
    Temperature::new(log, &treatment(), effects).unwrap()
}

fn dependence(temperature: &Temperature) -> &Dependence {
    temperature.columns[0].found.as_ref().unwrap_or_else(|why| panic!("{why}"))
}

fn estimate(temperature: &Temperature, effect: Effect) -> Estimate {
    let finding = dependence(temperature).model.findings.iter().find(|finding| finding.effect == effect);
    finding.unwrap().estimate.unwrap()
}

/// Four standard errors are two half intervals.
fn is_within_4_sigma(found: Estimate, truth: f64) -> bool {
    (found.value - truth).abs() < 2.0 * 0.5 * (found.interval[1] - found.interval[0])
}

/// A day's sine of 5 K around 20 °C.
fn day(i: usize) -> f64 {
    20.0 + 5.0 * (TAU * i as f64 / SAMPLES as f64).sin()
}

/// Rates of noise, °/h.
fn rates(parts: Vec<Part>, seed: u64) -> Vec<f64> {
    let process = Process { sample_s: 1.0, parts };
    let angles = record(&process, SAMPLES, &mut StdRng::seed_from_u64(seed));
    angles.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

#[test]
fn a_record_without_noise_is_compensated_to_the_last_digits() {
    let terms = Effects::Given(vec![Effect::Temperature, Effect::Square, Effect::Aging]);
    let free = |i: usize| 8.0 - 0.3 * (i as f64 + 0.5) / 86_400.0;
    let drift = |i: usize| 0.4 * (day(i) - 20.0) - 0.02 * (day(i) - 20.0) * (day(i) - 20.0);
    let rates: Vec<f64> = (0..SAMPLES).map(|i| free(i) + drift(i)).collect();
    let mut angles = vec![0.0];
    // The temperature between two angles is taken as their mean.
    for i in 1..SAMPLES {
        let from = 0.5 * (day(i - 1) + day(i)) - 20.0;
        angles.push(angles[i - 1] + 8.0 + 0.4 * from - 0.02 * from * from);
    }
    for (data, samples) in [(Data::Rate, &rates), (Data::Increment, &rates), (Data::Angle, &angles)] {
        let log = log(data, samples, |i| Some(day(i)));
        let temperature = found(&log, &terms);
        let compensated = temperature.compensated(&log);
        for (i, sample) in compensated.channels[0].samples.iter().enumerate() {
            let expected = if data == Data::Angle { 8.0 * i as f64 } else { 8.0 };
            let tolerance = if data == Data::Angle { 1e-9 * i as f64 + 1e-9 } else { 1e-9 };
            assert!((sample - expected).abs() < tolerance, "{data:?}, sample {i}: {sample}, not {expected}");
        }
        let found = estimate(&temperature, Effect::Temperature);
        assert!((found.value - 0.4).abs() < 1e-9, "{data:?}: {found:?}");
    }
}

#[test]
fn known_coefficients_are_found_in_noise_within_their_intervals() {
    let noises = [
        vec![Part::angle_random_walk(1.0)],
        vec![Part::angle_random_walk(1.0), Part::bias_instability(0.1, 24)],
        vec![Part::angle_random_walk(1.0), Part::rate_random_walk(0.003)],
    ];
    for (seed, parts) in (1..).zip(noises) {
        let noise = rates(parts.clone(), seed);
        let samples: Vec<f64> = noise.iter().enumerate().map(|(i, x)| x + 0.5 * day(i)).collect();
        let temperature = found(&log(Data::Rate, &samples, |i| Some(day(i))), &Effects::Auto);
        let c1 = estimate(&temperature, Effect::Temperature);
        assert!(is_within_4_sigma(c1, 0.5), "{parts:?}: {c1:?}");
        assert!(!dependence(&temperature).model.is_robust, "{parts:?}");
    }
}

#[test]
fn a_coarse_sensor_with_gaps_gives_the_coefficients_of_the_true_temperature() {
    let chamber = |i: usize| 20.0 + 15.0 * (TAU * i as f64 / 6000.0).sin();
    let per_min = |i: usize| 15.0 * TAU / 6000.0 * (TAU * i as f64 / 6000.0).cos() * 60.0;
    let noise = rates(vec![Part::angle_random_walk(1.0)], 7);
    let mut samples: Vec<f64> =
        noise.iter().enumerate().map(|(i, x)| x + 0.1 * chamber(i) + 0.8 * per_min(i)).collect();
    samples[3000..3100].fill(f64::NAN);
    let measured = |i: usize| {
        let is_read = i.is_multiple_of(4) && !(9000..9900).contains(&i);
        is_read.then(|| (chamber(i) / 0.0625).round() * 0.0625)
    };
    let log = log(Data::Rate, &samples, measured);
    let temperature = found(&log, &Effects::Auto);
    let (c1, d) = (estimate(&temperature, Effect::Temperature), estimate(&temperature, Effect::Change));
    assert!(is_within_4_sigma(c1, 0.1), "{c1:?}");
    assert!(is_within_4_sigma(d, 0.8) && d.is_identified(), "{d:?}");
    let missing = temperature.compensated(&log).channels[0].samples.iter().filter(|x| x.is_nan()).count();
    assert!((900..1100).contains(&missing), "{missing}");
}

#[test]
fn a_warm_up_is_told_from_the_temperature_of_a_day_with_its_time() {
    let noise = rates(vec![Part::angle_random_walk(1.0)], 11);
    let samples: Vec<f64> = noise
        .iter()
        .enumerate()
        .map(|(i, x)| x + 0.2 * day(i) + 2.0 * (-(i as f64 + 0.5) / 1500.0).exp())
        .collect();
    let temperature = found(&log(Data::Rate, &samples, |i| Some(day(i))), &Effects::Auto);
    let model = &dependence(&temperature).model;
    let (time_s, interval) = model.warm_up_s.unwrap();
    let [low, high] = interval.unwrap();
    assert!(low < 1500.0 && 1500.0 < high && low < time_s && time_s < high, "{time_s} in {interval:?}");
    assert!(is_within_4_sigma(estimate(&temperature, Effect::WarmUp), 2.0), "{:?}", model.findings);
}

#[test]
fn a_temperature_that_rises_evenly_cannot_be_told_from_aging_and_a_constant_one_from_nothing() {
    let noise = rates(vec![Part::angle_random_walk(1.0)], 13);
    let ramp = |i: usize| 20.0 + 5e-4 * i as f64;
    let samples: Vec<f64> = noise.iter().enumerate().map(|(i, x)| x + 0.5 * ramp(i)).collect();
    let temperature = found(&log(Data::Rate, &samples, |i| Some(ramp(i))), &Effects::Auto);
    let model = &dependence(&temperature).model;
    let finding = model.findings.iter().find(|finding| finding.effect == Effect::Temperature).unwrap();
    assert!(finding.verdict.starts_with("cannot be told from"), "{finding:?}");
    assert!(is_within_4_sigma(finding.estimate.unwrap(), 0.5), "{finding:?}");
    let constant = found(&log(Data::Rate, &samples, |_| Some(25.0)), &Effects::Auto);
    let why = constant.columns[0].found.as_ref().unwrap_err();
    assert!(why.contains("hardly changes"), "{why}");
}

#[test]
fn a_residual_that_no_noise_describes_has_robust_intervals() {
    let noise = rates(vec![Part::angle_random_walk(0.1)], 17);
    let wave = |i: usize| 0.5 * (TAU * i as f64 / 900.0).sin();
    let samples: Vec<f64> = noise.iter().enumerate().map(|(i, x)| x + wave(i) + 0.1 * day(i)).collect();
    let temperature =
        found(&log(Data::Rate, &samples, |i| Some(day(i))), &Effects::Given(vec![Effect::Temperature]));
    assert!(dependence(&temperature).model.is_robust, "p = {}", dependence(&temperature).model.p_value);
    let c1 = estimate(&temperature, Effect::Temperature);
    assert!(is_within_4_sigma(c1, 0.1), "{c1:?}");
}

#[test]
fn the_temperature_is_cut_with_the_samples() {
    let samples: Vec<f64> = (0..100).map(|i| f64::from(i * 37 % 11)).collect();
    let mut log = log(Data::Rate, &samples, |i| Some(i as f64));
    log.cut(10.0, Some(60.0)).unwrap();
    assert_eq!(log.temperature.as_ref().unwrap().1, (10..60).map(f64::from).collect::<Vec<_>>());
    assert_eq!(log.notes, Vec::<String>::new());
}
