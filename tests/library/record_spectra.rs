//! Periodograms of the samples that the kernels make, against those that each term of noise has once it is sampled.
//!
//! The expected periodogram of n rates with the autocovariance R is exact, leakage included: it is 2t0 times the Fourier transform
//! of (1 − l/n)R(l) + (l/n)R(n − l). R is written here from the definition of each term, and the holds of flicker are those of
//! `tests/data/flicker_weights.csv`.

use core::f64::consts::{LN_2, PI, TAU};

use sagnac_engine::kinds::allan::lower::{Asked, Records};
use sagnac_theory::allan::terms::Term;
use sagnac_theory::allan::{Estimator, Part, Process};

const SAMPLES: usize = 1 << 12;
const RECORDS: u64 = 64;
const STEPS_S: [f64; 3] = [1.0 / 400.0, 1.0, 30.0];
/// Largest deviate of a band: noise exceeds it in one of 150,000.
const MOST: f64 = 4.5;

fn records(part: Part, step_s: f64, key: u32) -> Records {
    Records::new(&Asked {
        process: &Process { sample_s: step_s, parts: vec![part] },
        readout_lsb: 0.0,
        mean_rate: 0.0,
        switching: None,
        samples: SAMPLES as u64 + 1,
        estimator: Estimator::OVERLAPPING,
        ms: &[1, SAMPLES as u64 / 2],
        key: [key, (1.0 / step_s) as u32],
    })
    .unwrap()
}

/// Sums of values·e^{−2πikl/n} over l for every k, where n is a power of two.
fn transform(values: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n = values.len();
    if n == 1 {
        return values.to_vec();
    }
    let half = |odd: usize| transform(&values.iter().skip(odd).step_by(2).copied().collect::<Vec<_>>());
    let (even, odd) = (half(0), half(1));
    let mut all = vec![[0.0; 2]; n];
    for k in 0..n / 2 {
        let (sine, cosine) = (-TAU * k as f64 / n as f64).sin_cos();
        let turned = [odd[k][0] * cosine - odd[k][1] * sine, odd[k][0] * sine + odd[k][1] * cosine];
        all[k] = [even[k][0] + turned[0], even[k][1] + turned[1]];
        all[k + n / 2] = [even[k][0] - turned[0], even[k][1] - turned[1]];
    }
    all
}

/// The transform of real numbers at the frequencies between 0 and half the sampling rate.
fn between(values: impl Iterator<Item = f64>) -> Vec<[f64; 2]> {
    let values: Vec<[f64; 2]> = values.map(|x| [x, 0.0]).collect();
    transform(&values)[1..values.len() / 2].to_vec()
}

/// Variances of the rate of each octave of holds for an Allan variance of 1.
fn holds() -> Vec<f64> {
    let rows = include_str!("../data/flicker_weights.csv").lines().skip(1);
    rows.map(|row| row.rsplit(',').next().unwrap().parse().unwrap()).collect()
}

/// Autocovariance of the rates at each distance; of their differences for a random walk, which has none itself; of the angles for
/// quantization noise, whose rates have the two ends in common at all low frequencies. The kernel rounds angles to multiples of
/// `lsb`, which is quantization noise.
fn autocovariance(part: Part, step_s: f64, lsb: f64) -> Vec<f64> {
    let mut found = vec![0.0; SAMPLES];
    let mut add = |start: &[f64], factor: f64| {
        found.iter_mut().zip(start).for_each(|(sum, x)| *sum += factor * x);
    };
    let step_squared = step_s * step_s;
    let rounding = lsb * lsb / 12.0 / step_squared;
    let (size, errors) = (part.size * part.size, [2.0, -1.0]);
    match part.term {
        Term::RateRandomWalk => {
            add(&[1.0], size * step_s);
            add(&[6.0, -4.0, 1.0], rounding);
            return found;
        }
        Term::Quantization => {
            add(&[1.0], size + lsb * lsb / 12.0);
            return found;
        }
        Term::AngleRandomWalk => add(&[1.0], size / step_s),
        Term::Markov => {
            let fallen = (0..SAMPLES).map(|l| (-(l as f64) * step_s / part.shape).exp());
            add(&fallen.collect::<Vec<_>>(), 0.5 * size * part.shape);
        }
        Term::BiasInstability => {
            for (octave, variance) in holds().into_iter().enumerate() {
                let left = |l: usize| (1.0 - l as f64 / f64::from(1 << octave)).max(0.0);
                add(&(0..SAMPLES).map(left).collect::<Vec<_>>(), 2.0 * LN_2 / PI * size * variance);
            }
        }
        _ => panic!("{part:?} has no autocovariance"),
    }
    add(&errors, rounding);
    found
}

/// Deviates of the mean periodogram in the octaves of frequency, which would be normal if `part` is what was made.
fn deviates(part: Part, step_s: f64, key: u32) -> Vec<f64> {
    let records = records(part, step_s, key);
    let r = autocovariance(part, step_s, records.lsb_arcsec());
    let n = SAMPLES as f64;
    let folded = |l: usize| (1.0 - l as f64 / n) * r[l] + l as f64 / n * r[(SAMPLES - l) % SAMPLES];
    let expected: Vec<f64> = between((0..SAMPLES).map(folded)).iter().map(|[real, _]| *real).collect();
    let mut ratios = vec![0.0; expected.len()];
    for number in 0..RECORDS {
        let rates: Vec<f64> = records.increments(number).map(|increment| increment / step_s).collect();
        assert_eq!(rates.len(), SAMPLES + 1);
        let used: Vec<f64> = match part.term {
            Term::RateRandomWalk => rates.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            Term::Quantization => rates
                .iter()
                .scan(0.0, |angle, rate| {
                    *angle += rate * step_s;
                    Some(*angle)
                })
                .skip(1)
                .collect(),
            _ => rates[1..].to_vec(),
        };
        for ((ratio, [real, imaginary]), expected) in
            ratios.iter_mut().zip(between(used.into_iter())).zip(&expected)
        {
            *ratio += (real * real + imaginary * imaginary) / n / expected;
        }
    }
    let octaves = (0..).map(|octave| 1_usize << octave).take_while(|k| 2 * k <= SAMPLES / 2);
    let of_octave = |k: usize| {
        let band = &ratios[k - 1..(2 * k - 1).min(ratios.len())];
        // A χ² with two degrees of freedom for each frequency and record, by its cube root (Wilson and Hilferty).
        let count = band.len() as f64 * RECORDS as f64;
        let mean = band.iter().sum::<f64>() / count;
        3.0 * count.sqrt() * (mean.cbrt() - (1.0 - 1.0 / (9.0 * count)))
    };
    octaves.map(of_octave).collect()
}

#[test]
fn each_noise_has_the_periodogram_of_its_closed_form_in_every_octave_and_at_every_rate() {
    let mut all = Vec::new();
    for step_s in STEPS_S {
        let parts = [
            Part::quantization(0.3),
            Part::angle_random_walk(0.02),
            Part::bias_instability(0.01, 24),
            Part::rate_random_walk(1e-3),
            Part::markov(0.01, 25.0 * step_s),
            Part::markov(0.01, 0.7 * step_s),
        ];
        for (key, part) in (1..).zip(parts) {
            let found = deviates(part, step_s, key);
            let least = found.iter().all(|deviate| deviate.abs() < MOST);
            assert!(least, "{part:?} every {step_s} s: {found:?}");
            all.extend(found);
        }
    }
    // They scatter as normal numbers do.
    let (count, square) = (all.len() as f64, all.iter().map(|deviate| deviate * deviate).sum::<f64>());
    assert!((square / count - 1.0).abs() < MOST * (2.0 / count).sqrt(), "{square} of {count}");
}

#[test]
fn a_sine_is_one_line_with_the_amplitude_of_mean_rates_and_a_random_phase() {
    for step_s in STEPS_S {
        let place = 700;
        let turns = place as f64 / SAMPLES as f64;
        let records = records(Part::sine(0.3, turns / step_s), step_s, 1);
        let expected = 0.3 * (PI * turns).sin() / (PI * turns);
        // The angles of a line are rounded, which is not noise.
        let rounding = records.lsb_arcsec() / step_s;
        let mut phases = [0.0; 2];
        for number in 0..RECORDS {
            let rates = records.increments(number).skip(1).map(|increment| increment / step_s);
            let lines = between(rates);
            let amplitude = |[real, imaginary]: &[f64; 2]| 2.0 / SAMPLES as f64 * real.hypot(*imaginary);
            for (k, line) in (1..).zip(&lines) {
                let apart = amplitude(line) - if k == place { expected } else { 0.0 };
                assert!(apart.abs() < rounding, "{step_s} s, {k}: {apart}, {rounding}");
            }
            let [real, imaginary] = lines[place - 1];
            phases[0] += real / real.hypot(imaginary);
            phases[1] += imaginary / real.hypot(imaginary);
        }
        // Rayleigh's test.
        let rayleigh = (phases[0] * phases[0] + phases[1] * phases[1]) / RECORDS as f64;
        assert!(rayleigh < 12.0, "{step_s} s: {rayleigh}");
    }
}

#[test]
fn a_ramp_is_a_straight_line_of_mean_rates() {
    for step_s in STEPS_S {
        let records = records(Part::rate_ramp(1e-4), step_s, 1);
        let mut last = None;
        for (k, increment) in records.increments(3).enumerate() {
            let expected = 1e-4 * (k as f64 + 0.5) * step_s;
            let apart = increment / step_s - expected;
            let first = *last.get_or_insert(apart);
            // The rate at the start is free, and an increment is the difference of two rounded angles.
            let bound = 2.0 * records.lsb_arcsec() / step_s;
            assert!((apart - first).abs() <= bound, "{step_s} s, sample {k}: {apart}, {first}, {bound}");
        }
    }
}
