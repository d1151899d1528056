use super::*;
use core::f64::consts::PI;

use crate::allan::terms::Term;
use crate::allan::{FLAT_LEVEL, Part, flicker};

fn all_parts() -> Process {
    Process {
        sample_s: 0.5,
        parts: vec![
            Part::quantization(0.4),
            Part::angle_random_walk(0.5),
            Part::bias_instability(0.3, 24),
            Part::rate_random_walk(0.02),
            Part::markov(0.05, 20.0),
            Part::sine(0.2, 0.013),
            Part::rate_ramp(1e-4),
        ],
    }
}

/// Covariance of the increments of the samples i and j, ″²; for sine and ramp their product.
fn increments(part: &Part, t0: f64, i: usize, j: usize) -> f64 {
    let lag = i.abs_diff(j) as f64;
    let Part { size, shape, .. } = *part;
    t0 * t0
        * match part.term {
            Term::AngleRandomWalk if i == j => size * size / t0,
            Term::BiasInstability => {
                let hold = |(o, v): (usize, f64)| v * (1.0 - lag / (1_u64 << o) as f64).max(0.0);
                let variances = flicker::variances(part.octaves).unwrap();
                FLAT_LEVEL * size * size * variances.into_iter().enumerate().map(hold).sum::<f64>()
            }
            Term::RateRandomWalk => size * size * t0 * (i.min(j) + 1) as f64,
            Term::Markov => 0.5 * size * size * shape * libm::exp(-lag * t0 / shape),
            Term::Sine => {
                let half = PI * shape * t0;
                let smoothed = size * libm::sin(half) / half;
                0.5 * smoothed * smoothed * libm::cos(2.0 * half * lag)
            }
            Term::RateRamp => size * size * t0 * t0 * (i as f64 + 0.5) * (j as f64 + 0.5),
            _ => 0.0,
        }
}

/// ΣΣ 2c² + 4cp over all differences, from the covariance of the increments.
fn by_definition(process: &Process, difference: Difference, samples: usize, a: usize, b: usize) -> f64 {
    let (t0, spans) = (process.sample_s, difference.spans() as usize);
    let is_noise = |part: &Part| !matches!(part.term, Term::Sine | Term::RateRamp);
    let (noise, steady): (Vec<Part>, Vec<Part>) = process.parts.iter().partition(|part| is_noise(part));
    let table = |parts: &[Part]| -> Vec<Vec<f64>> {
        let cell = |i, j| parts.iter().map(|part| increments(part, t0, i, j)).sum();
        (0..samples).map(|i| (0..samples).map(|j| cell(i, j)).collect()).collect()
    };
    let (noise_table, steady_table) = (table(&noise), table(&steady));
    // Weights of increments in a difference, or of angles for the white errors.
    let weights = |m: usize| -> Vec<f64> {
        let c = difference.coefficients();
        (0..spans * m).map(|i| c[i / m + 1..].iter().sum()).collect()
    };
    let (u, v) = (weights(a), weights(b));
    let product = |table: &[Vec<f64>], k: usize, l: usize| {
        let row = |i: usize| v.iter().enumerate().map(|(j, v)| v * table[k + i][l + j]).sum::<f64>();
        u.iter().enumerate().map(|(i, u)| u * row(i)).sum::<f64>()
    };
    let white = |k: usize, l: usize| {
        let c = difference.coefficients();
        let mut sum = 0.0;
        for (i, u) in c.iter().enumerate() {
            for (j, v) in c.iter().enumerate() {
                sum += if k + i * a == l + j * b { u * v } else { 0.0 };
            }
        }
        let q = |part: &Part| if part.term == Term::Quantization { part.size * part.size } else { 0.0 };
        sum * process.parts.iter().map(q).sum::<f64>()
    };
    let mut sum = 0.0;
    for k in 0..=samples - spans * a {
        for l in 0..=samples - spans * b {
            let c = product(&noise_table, k, l) + white(k, l);
            sum += 2.0 * c * c + 4.0 * c * product(&steady_table, k, l);
        }
    }
    let terms = ((samples - spans * a + 1) * (samples - spans * b + 1)) as f64;
    let scale = difference.divisor() * t0 * t0;
    sum / (terms * scale * scale * (a * a * b * b) as f64)
}

#[test]
fn the_covariance_is_the_double_sum_over_differences() {
    let all = all_parts();
    let alone = all.parts[..5].iter().map(|&part| vec![part]);
    // Deterministic parts count only together with noise.
    let beside = all.parts[5..].iter().map(|&part| vec![Part::angle_random_walk(0.5), part]);
    for parts in alone.chain(beside).chain([all.parts.clone()]) {
        let process = Process { parts, ..all };
        for difference in [Difference::Second, Difference::Third] {
            let ms = [1, 2, 3, 8, 13];
            let found = covariance(&process, difference, 60, &ms);
            for (i, &a) in ms.iter().enumerate() {
                for (j, &b) in ms.iter().enumerate() {
                    let expected = by_definition(&process, difference, 60, a as usize, b as usize);
                    let scale = libm::sqrt(found[i][i] * found[j][j]);
                    assert!(
                        (found[i][j] - expected).abs() < 2e-3 * scale,
                        "{:?}, {difference:?}, m = {a}, {b}: {}, not {expected}",
                        process.parts,
                        found[i][j]
                    );
                }
            }
        }
    }
}

#[test]
fn panels_are_the_sum_over_every_lag() {
    let mut process = all_parts();
    process.parts.retain(|part| part.term != Term::Quantization);
    let count = process.parts.len();
    for (a, b) in [(1, 1), (1, 900), (40, 45), (30, 700), (1200, 1200)] {
        let pair = Pair::new(&process, Difference::Second, 5000, a, b);
        let mut products = Products { noise: vec![0.0; count], steady: vec![0.0; count] };
        let mut sum = 0.0;
        for lag in 1 - pair.terms_a as i64..pair.terms_b as i64 {
            pair.products(lag as f64, 1.0, 0.0, &mut products);
            let [c, p] = [&products.noise, &products.steady].map(|each| each.iter().sum::<f64>());
            sum += pair.pairs_at(lag as f64) * (2.0 * c * c + 4.0 * c * p);
        }
        let scale = pair.terms_a * pair.terms_b * 4.0 * 0.0625 * (a * a * b * b) as f64;
        let total = |pair: Pair| pair.components().iter().sum::<f64>();
        let own = |m: u64| total(Pair::new(&process, Difference::Second, 5000, m, m));
        let (expected, norm) = (sum / scale, libm::sqrt(own(a) * own(b)));
        let found = total(pair);
        let error = (found - expected) / norm;
        assert!(error.abs() < 2e-3, "m = {a}, {b}: {found}, not {expected}: {error}");
    }
}

#[test]
fn components_are_a_quadratic_form_of_the_variances() {
    let process = all_parts();
    let ms = [1, 5, 16];
    let components = Components::new(&process, Difference::Second, 100, &ms);
    let scales = [2.0, 0.5, 1.0, 3.0, 0.0, 1.5, 0.25];
    let scaled = |(part, scale): (&Part, f64)| Part { size: libm::sqrt(scale) * part.size, ..*part };
    let parts = process.parts.iter().zip(scales).map(scaled).collect();
    let expected = covariance(&Process { parts, ..process }, Difference::Second, 100, &ms);
    let found = components.covariance(&scales);
    let weights = [1.0, -2.0, 0.5];
    let mut variance = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            assert!((found[i][j] / expected[i][j] - 1.0).abs() < 1e-9, "{i}, {j}");
            variance += weights[i] * weights[j] * expected[i][j];
        }
    }
    let form = components.variance_of(&weights);
    let found: f64 = form
        .iter()
        .zip(scales)
        .flat_map(|(row, a)| row.iter().zip(scales).map(move |(x, b)| a * b * x))
        .sum();
    assert!((found / variance - 1.0).abs() < 1e-9, "{found}, not {variance}");
}

/// Degrees of freedom by the double sum over terms, each given by its weights of the angles.
fn freedom_by_definition(process: &Process, terms: &[Vec<f64>]) -> f64 {
    let samples = terms[0].len() - 1;
    let (steady, noise): (Vec<Part>, Vec<Part>) =
        process.parts.iter().partition(|part| matches!(part.term, Term::Sine | Term::RateRamp));
    let table = |parts: &[Part]| -> Vec<Vec<f64>> {
        let cell = |i, j| parts.iter().map(|part| increments(part, process.sample_s, i, j)).sum();
        (0..samples).map(|i| (0..samples).map(|j| cell(i, j)).collect()).collect()
    };
    let tables = [table(&noise), table(&steady)];
    let q = |part: &Part| if part.term == Term::Quantization { part.size * part.size } else { 0.0 };
    let white: f64 = process.parts.iter().map(q).sum();
    let of_increments =
        |weights: &Vec<f64>| (0..samples).map(|i| weights[i + 1..].iter().sum()).collect::<Vec<f64>>();
    let increments: Vec<Vec<f64>> = terms.iter().map(of_increments).collect();
    let product = |k: usize, l: usize| {
        let (a, b) = (&increments[k], &increments[l]);
        let row = |row: &[f64]| row.iter().zip(b).map(|(x, b)| x * b).sum::<f64>();
        let met: f64 = terms[k].iter().zip(&terms[l]).map(|(u, v)| u * v).sum();
        let [c, p] = [&tables[0], &tables[1]].map(|table| {
            a.iter().zip(table).filter(|(a, _)| **a != 0.0).map(|(a, x)| a * row(x)).sum::<f64>()
        });
        [c + white * met, p]
    };
    let (mut mean, mut variance) = (0.0, 0.0);
    for k in 0..terms.len() {
        for l in 0..=k {
            let [c, p] = product(k, l);
            mean += if k == l { c + p } else { 0.0 };
            variance += if k == l { 1.0 } else { 2.0 } * (2.0 * c * c + 4.0 * c * p);
        }
    }
    2.0 * mean * mean / variance
}

#[test]
fn degrees_of_freedom_are_those_of_the_double_sum_over_terms() {
    use crate::allan::{Estimator, Stride};
    let all = all_parts();
    let alone = all.parts[..4].iter().map(|&part| vec![part]);
    for parts in alone.chain([all.parts.clone()]) {
        let process = Process { parts, ..all };
        for (difference, stride, is_modified) in [
            (Difference::Second, Stride::Sample, false),
            (Difference::Second, Stride::Cluster, false),
            (Difference::Third, Stride::Cluster, false),
            (Difference::Second, Stride::Sample, true),
        ] {
            for (samples, m, bound) in [(30, 1, 1e-2), (30, 2, 1e-2), (36, 6, 2e-2), (125, 40, 5e-2)] {
                let step = if stride == Stride::Sample { 1 } else { m };
                let averaged = if is_modified { m } else { 1 };
                let spans = difference.spans() as usize;
                let weights = |start: usize| {
                    let mut weights = vec![0.0; samples + 1];
                    for i in 0..averaged {
                        for (k, c) in difference.coefficients().iter().enumerate() {
                            weights[start + i + k * m] += c / averaged as f64;
                        }
                    }
                    weights
                };
                let last = samples + 1 - spans * m - averaged;
                let terms: Vec<Vec<f64>> = (0..=last).step_by(step).map(weights).collect();
                let expected = freedom_by_definition(&process, &terms);
                let estimator = Estimator { difference, stride };
                let found = freedom(&process, estimator, is_modified, samples as u64, m as u64).unwrap();
                assert!(
                    (found / expected - 1.0).abs() < bound,
                    "{:?}, {difference:?}, {stride:?}, {is_modified}, m = {m}: {found}, not {expected}",
                    process.parts
                );
            }
        }
    }
    let none = Process { sample_s: 1.0, parts: vec![] };
    assert_eq!(freedom(&none, Estimator::OVERLAPPING, false, 30, 1), None);
}
