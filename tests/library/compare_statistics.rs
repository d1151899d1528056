//! What `compare` says of simulated records: how often it is wrong, how often it finds a difference that is there.

use rand::SeedableRng;
use rand::rngs::StdRng;
use rayon::prelude::*;
use sagnac::allan::angles::{Angles, Trend};
use sagnac::analysis::compare::equality_test::{Difference, Length, SIGNIFICANT};
use sagnac::analysis::compare::{Comparison, compare};
use sagnac::events::Events;
use sagnac::fit::Quantity;
use sagnac::fit::selection::Terms;
use sagnac::theory::allan::terms::Term;
use sagnac::theory::allan::{Part, Process};

const PAIRS: u64 = 400;
/// 2.3 standard errors of a share of 5 % of so many.
const TOLERANCE: f64 = 0.025;
/// Pairs where most are to be found; three standard errors of a share of 90 %.
const FEWER: u64 = 100;
const THREE_ERRORS: f64 = 0.09;

const QNB: [Term; 3] = [Term::Quantization, Term::AngleRandomWalk, Term::BiasInstability];

/// The gyro of these tests: every term shows in 4096 samples.
const GYRO: [f64; 3] = [3.0, 1.0, 0.3];

fn process([q, n, b]: [f64; 3], sample_s: f64) -> Process {
    let parts = vec![Part::quantization(q), Part::angle_random_walk(n), Part::bias_instability(b, 24)];
    Process { sample_s, parts }
}

/// Comparisons of so many pairs of independent records of two processes.
fn comparisons(two: [(&Process, usize); 2], pairs: u64, seed: u64, terms: &Terms) -> Vec<Comparison> {
    let pair = |i: u64| {
        let mut rng = StdRng::seed_from_u64((seed << 32) + i);
        let [a, b] = two.map(|(process, samples)| {
            let angles = crate::noise::record(process, samples, &mut rng);
            Angles::from_angles(&angles, 1.0, process.sample_s, Trend::None)
        });
        compare(&Events::from(&a), &Events::from(&b), Some(&terms.clone().into())).unwrap()
    };
    (0..pairs).into_par_iter().map(pair).collect()
}

fn of(comparison: &Comparison, term: Term) -> Option<&Difference> {
    let differences = comparison.differences.as_ref().unwrap();
    differences.iter().find(|found| found.quantity == Quantity::Coefficient(term))
}

/// The part of all that have a p whose p is significant, and how many these are.
fn significant(ps: impl Iterator<Item = Option<f64>>) -> (f64, usize) {
    let known: Vec<f64> = ps.flatten().collect();
    (known.iter().filter(|p| **p < SIGNIFICANT).count() as f64 / known.len().max(1) as f64, known.len())
}

/// Checks that equal coefficients, and equal noise, differ in one of twenty comparisons.
fn one_of_twenty(name: &str, all: &[Comparison]) {
    for term in QNB {
        let (share, count) = significant(all.iter().map(|one| of(one, term)?.p));
        println!("{name}: {} differs in {share} of {count}", term.symbol());
        assert!(count > 380 && (share - 0.05).abs() < TOLERANCE, "{name}, {term:?}: {share} of {count}");
        let holds = |found: &&Difference| {
            let [low, high] = found.interval;
            low.is_none_or(|low| low <= 0.0) && high.is_none_or(|high| high >= 0.0)
        };
        let covered = all.iter().filter_map(|one| of(one, term)).filter(holds).count();
        // What the p says the interval says too.
        assert_eq!(covered, all.len() - (share * count as f64).round() as usize, "{name}, {term:?}");
    }
    let (share, _) = significant(all.iter().map(|one| Some(one.same?.p)));
    println!("{name}: the noise is not the same in {share}");
    assert!((share - 0.05).abs() < TOLERANCE, "{name}: the noise is not the same in {share}");
}

#[test]
fn equal_coefficients_differ_in_one_of_twenty_comparisons_and_others_in_most() {
    let gyro = process(GYRO, 1.0);
    let given = Terms::Given(QNB.to_vec());
    let equal = comparisons([(&gyro, 4096), (&gyro, 4096)], PAIRS, 1, &given);
    one_of_twenty("equal", &equal);
    for (i, term) in QNB.into_iter().enumerate() {
        let squares = equal.iter().filter_map(|one| {
            let [a, b] = of(one, term)?.values;
            Some((b? * b? - a? * a?).powi(2))
        });
        let error = (squares.sum::<f64>() / equal.len() as f64).sqrt();
        let mut other = GYRO;
        other[i] = (GYRO[i] * GYRO[i] + 3.0 * error).sqrt();
        let other = process(other, 1.0);
        let all = comparisons([(&gyro, 4096), (&other, 4096)], FEWER, 5 + i as u64, &given);
        let (share, count) = significant(all.iter().map(|one| of(one, term)?.p));
        println!("{}: 3 standard errors are found in {share} of {count}", term.symbol());
        // Of normal numbers in 85 %; a larger square scatters more, B's most.
        assert!(share > 0.55, "{term:?}: found in {share} of {count}");
    }
}

#[test]
fn the_same_noise_at_two_sampling_rates_and_lengths_is_the_same() {
    // Steps of which none is a multiple of the other: τ that differ by up to 2 %, and another discretization.
    let [a, b] = [1.0, 1.37].map(|sample_s| process(GYRO, sample_s));
    let all = comparisons([(&a, 4096), (&b, 1500)], PAIRS, 3, &Terms::Given(QNB.to_vec()));
    let common = &all[0].common;
    assert!(common.farthest > 0.0 && common.farthest < 0.02 && common.left_out > 0, "{common:?}");
    one_of_twenty("two rates", &all);
}

#[test]
fn at_the_length_that_is_named_nine_of_ten_comparisons_tell() {
    // Long records, so that what they say of the length is about what is so.
    let terms = Terms::Given(vec![Term::AngleRandomWalk, Term::BiasInstability]);
    let of_truth = |[n, b]: [f64; 2]| {
        let parts = vec![Part::angle_random_walk(n), Part::bias_instability(b, 24)];
        Process { sample_s: 0.5, parts }
    };
    let [a, b] = [[1.0, 0.2], [1.1, 0.3]].map(of_truth);
    let long = comparisons([(&a, 1 << 17), (&b, 1 << 17)], 1, 9, &terms);
    let lengths = long[0].lengths();
    let found = |i: usize| -> [f64; 2] {
        [Term::AngleRandomWalk, Term::BiasInstability]
            .map(|term| of(&long[0], term).unwrap().values[i].unwrap())
    };
    let [a, b] = [found(0), found(1)].map(of_truth);
    for (term, length) in [Term::AngleRandomWalk, Term::BiasInstability].into_iter().zip(lengths) {
        let Length::Needed(length_s) = length else { panic!("{term:?}: {length:?}") };
        let samples = (length_s / 0.5).round() as usize;
        let all = comparisons([(&a, samples), (&b, samples)], FEWER, 10, &terms);
        let p = |one: &Comparison| of(one, term).map(|found| found.p.unwrap_or(1.0));
        let (share, _) = significant(all.iter().map(p));
        println!("{}: records of {samples} samples tell in {share}", term.symbol());
        assert!((share - 0.9).abs() < THREE_ERRORS, "{term:?}: {samples} samples tell in {share}");
    }
}
