//! How often `compare` finds a difference between records of the same noise: the table of docs/dev/numerics.md.
//!
//! ```text
//! cargo run --release --example compare_calibration
//! ```

use rand::SeedableRng;
use rand::rngs::StdRng;
use rayon::prelude::*;
use sagnac::allan::angles::{Angles, Trend};
use sagnac::analysis::compare::equality_test::SIGNIFICANT;
use sagnac::analysis::compare::logs::Verdict;
use sagnac::analysis::compare::{Comparison, compare};
use sagnac::events::Events;
use sagnac::fit::Quantity;
use sagnac::fit::selection::Terms;
use sagnac::theory::allan::terms::Term;
use sagnac::theory::allan::{Part, Process};

#[path = "../tests/common/noise.rs"]
mod noise;

const PAIRS: u64 = 1000;

/// True coefficients in the order of the model, 0 for absent terms.
type Truth = [f64; 4];

const GYRO: Truth = [3.0, 1.0, 0.3, 0.0];

/// A sampling step, s, and the number of samples.
type Sampling = (f64, usize);

const LONG: Sampling = (1.0, 4096);

fn main() {
    let auto = Terms::Auto(Term::MODEL.to_vec());
    let cases: [(&str, Truth, [Sampling; 2], Option<&Terms>); 10] = [
        ("Q 3, N 1, B 0.3", GYRO, [LONG; 2], None),
        ("the same, terms chosen", GYRO, [LONG; 2], Some(&auto)),
        ("B 0.1, terms chosen", [3.0, 1.0, 0.1, 0.0], [LONG; 2], Some(&auto)),
        ("4096 and 1024 samples", GYRO, [LONG, (1.0, 1024)], None),
        ("1 s and 1.37 s", GYRO, [LONG, (1.37, 1500)], None),
        ("N 1, terms chosen", [0.0, 1.0, 0.0, 0.0], [LONG; 2], Some(&auto)),
        ("Q 3, N 1, K 0.03", [3.0, 1.0, 0.0, 0.03], [LONG; 2], None),
        ("N 1, B 0.1, K 0.01", [0.0, 1.0, 0.1, 0.01], [LONG; 2], None),
        ("B alone", [0.0, 0.0, 1.0, 0.0], [LONG; 2], None),
        ("K alone", [0.0, 0.0, 0.0, 1.0], [LONG; 2], None),
    ];
    for (name, truth, samplings, terms) in cases {
        let shown: Vec<Term> =
            Term::MODEL.into_iter().zip(truth).filter(|(_, x)| *x > 0.0).map(|(term, _)| term).collect();
        let given = Terms::Given(shown);
        let all = comparisons(truth, samplings, terms.unwrap_or(&given));
        println!("{name}: p below {SIGNIFICANT}");
        print("same noise", all.iter().filter_map(|one| Some(one.same?.p)).collect());
        for term in Term::MODEL {
            print(term.symbol(), all.iter().filter_map(|one| p_of(one, term)).collect());
        }
        let left_out = |i: usize| {
            all.iter()
                .filter(|one| matches!(one.ratios[i].verdict(), Some(Verdict::Higher | Verdict::Lower)))
                .count()
        };
        let shares: Vec<String> = (0..all[0].ratios.len())
            .map(|i| format!("{:.1}", 100.0 * left_out(i) as f64 / PAIRS as f64))
            .collect();
        println!("  the interval of the ratio excludes 1, over τ: {} %", shares.join(" "));
    }
}

fn comparisons(truth: Truth, samplings: [Sampling; 2], terms: &Terms) -> Vec<Comparison> {
    let [q, n, b, k] = truth;
    let parts = [
        Part::quantization(q),
        Part::angle_random_walk(n),
        Part::bias_instability(b, 24),
        Part::rate_random_walk(k),
    ];
    let parts: Vec<Part> =
        parts.into_iter().zip(truth).filter(|(_, x)| *x > 0.0).map(|(part, _)| part).collect();
    let pair = |seed: u64| {
        let mut rng = StdRng::seed_from_u64(1000 + seed);
        let [a, b] = samplings.map(|(sample_s, samples)| {
            let process = Process { sample_s, parts: parts.clone() };
            Angles::from_angles(&noise::record(&process, samples, &mut rng), 1.0, sample_s, Trend::None)
        });
        compare(&Events::from(&a), &Events::from(&b), Some(&terms.clone().into()))
    };
    (0..PAIRS).into_par_iter().filter_map(|seed| pair(seed).ok()).collect()
}

fn p_of(comparison: &Comparison, term: Term) -> Option<f64> {
    let mut differences = comparison.differences.as_ref().ok()?.iter();
    differences.find(|found| found.quantity == Quantity::Coefficient(term))?.p
}

fn print(name: &str, ps: Vec<f64>) {
    if !ps.is_empty() {
        let below = |limit: f64| 100.0 * ps.iter().filter(|p| **p < limit).count() as f64 / ps.len() as f64;
        println!("  {name}: {:.1} % of {}; {:.1} % below 0.5", below(SIGNIFICANT), ps.len(), below(0.5));
    }
}
