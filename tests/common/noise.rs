//! Sampled noise in f64, straight from the definition of each part: what closed forms and fits are tried on.

#![allow(dead_code, reason = "each test binary uses a part")]

use core::f64::consts::{LN_2, PI, TAU};

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::theory::allan::terms::Term;
use sagnac::theory::allan::{Part, Process, flicker};

/// A normal number, by Box and Muller.
pub fn normal(rng: &mut StdRng) -> f64 {
    let (radius, turn): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - radius).ln()).sqrt() * (TAU * turn).cos()
}

/// White noise of this standard deviation.
pub fn white(count: usize, sigma: f64, seed: u64) -> Vec<f64> {
    let mut rng = StdRng::seed_from_u64(seed);
    (0..count).map(|_| sigma * normal(&mut rng)).collect()
}

/// A log of five gyros at 1 Hz, of which the fourth has twice the noise.
pub fn units() -> String {
    let units = [5.0, 5.2, 4.9, 10.0, 5.1].into_iter().zip(1..).map(|(sigma, seed)| white(4096, sigma, seed));
    let units: Vec<Vec<f64>> = units.collect();
    let row = |i: usize| units.iter().map(|unit| format!("{:.4}", unit[i])).collect::<Vec<_>>().join(",");
    let names: Vec<String> = (1..6).map(|unit| format!("g{unit} [deg/h]")).collect();
    let rows: Vec<String> = std::iter::once(names.join(",")).chain((0..4096).map(row)).collect();
    rows.join("\n")
}

/// A log of a gyro at 1 Hz in a chamber: 0.5 °/h/K over ±5 K, and a warm-up of 2.1 °/h that decays in 1600 s.
pub fn chamber() -> String {
    let noise = white(36_000, 3.6, 1);
    let row = |(second, noise): (usize, &f64)| {
        let second = second as f64;
        let temperature = 20.0 + 5.0 * (TAU * second / 9000.0).sin();
        let rate = 10.0 + 0.5 * (temperature - 20.0) + 2.1 * (-second / 1600.0).exp() + noise;
        format!("{rate:.4},{temperature:.3}\n")
    };
    "gz [deg/h],temp [degC]\n".to_owned() + &noise.iter().enumerate().map(row).collect::<String>()
}

/// The angles of one part of a record of `samples` rates, one more than these.
pub fn angles(part: Part, t0: f64, samples: usize, rng: &mut StdRng) -> Vec<f64> {
    let held = |rates: &mut dyn FnMut(usize) -> f64| {
        let mut angle = 0.0;
        let rest = (0..samples).map(|k| {
            angle += t0 * rates(k);
            angle
        });
        core::iter::once(0.0).chain(rest).collect()
    };
    let Part { term, size, shape, octaves } = part;
    match term {
        Term::Quantization => (0..=samples).map(|_| size * normal(rng)).collect(),
        Term::AngleRandomWalk => held(&mut |_| size / t0.sqrt() * normal(rng)),
        Term::BiasInstability => {
            let level = 2.0 * LN_2 / PI * size * size;
            let mut rates = vec![0.0; samples];
            for (o, variance) in flicker::variances(octaves).unwrap().into_iter().enumerate() {
                let length = 1_usize << o;
                let streams = if o < 3 { 1 } else { 4 };
                for _ in 0..streams {
                    let offset = rng.random_range(0..length);
                    let scale = (level * variance / f64::from(streams)).sqrt();
                    let mut hold = scale * normal(rng);
                    for (k, rate) in rates.iter_mut().enumerate() {
                        if (k + offset).is_multiple_of(length) {
                            hold = scale * normal(rng);
                        }
                        *rate += hold;
                    }
                }
            }
            held(&mut |k| rates[k])
        }
        Term::RateRandomWalk => {
            let mut rate = 0.0;
            held(&mut |_| {
                rate += size * t0.sqrt() * normal(rng);
                rate
            })
        }
        Term::Markov => {
            let (a, sigma) = ((-t0 / shape).exp(), size * (0.5 * shape).sqrt());
            let mut rate = sigma * normal(rng);
            held(&mut |_| {
                rate = a * rate + sigma * (1.0 - a * a).sqrt() * normal(rng);
                rate
            })
        }
        Term::Sine => {
            let phase: f64 = rng.random();
            let at = |k: usize| (TAU * (shape * t0 * k as f64 + phase)).cos();
            (0..=samples).map(|k| -size / (TAU * shape) * at(k)).collect()
        }
        Term::RateRamp => (0..=samples).map(|k| 0.5 * size * (t0 * k as f64).powi(2)).collect(),
        Term::WarmUp => (0..=samples).map(|k| -size * shape * (-t0 * k as f64 / shape).exp_m1()).collect(),
        Term::BandLimit => panic!("a band limit takes from other noise and has no samples of its own"),
    }
}

/// Those of all parts of a process together.
pub fn record(process: &Process, samples: usize, rng: &mut StdRng) -> Vec<f64> {
    let each: Vec<Vec<f64>> =
        process.parts.iter().map(|&part| angles(part, process.sample_s, samples, rng)).collect();
    (0..=samples).map(|k| each.iter().map(|theta| theta[k]).sum()).collect()
}
