//! The range of τ over which noise terms describe a record, with the filter of a sensor before them.
//!
//! `benches/allan_numpy.py` counts coverage over many more records, made by NumPy.

use rand::SeedableRng;
use rand::rngs::StdRng;
use sagnac::allan::angles::{Angles, Trend};
use sagnac::analysis::compare::compare;
use sagnac::events::Events;
use sagnac::fit::curve::curve_of;
use sagnac::fit::selection::{Fitting, Terms, describe};
use sagnac::fit::{Fit, Verdict, fit_record};
use sagnac::theory::allan::terms::Term;

use crate::fitted::{covers, is_identified, share};

const RECORDS: u64 = 40;
const SAMPLES: usize = 1 << 14;

/// White noise of 1 per √Hz at 1 Hz through y_k = a·y_{k−1} + b·x_k + (1 − a − b)·x_{k−1}.
fn filtered([a, b]: [f64; 2], seed: u64) -> Angles {
    let mut rng = StdRng::seed_from_u64(seed);
    let (mut y, mut before) = (0.0, 0.0);
    let mut next = || {
        let x = crate::noise::normal(&mut rng);
        y = a * y + b * x + (1.0 - a - b) * before;
        before = x;
        y
    };
    let rates: Vec<f64> = (0..SAMPLES + 100).map(|_| next()).skip(100).collect();
    Angles::from_increments(&rates, 1.0, 1.0, Trend::None)
}

/// The mean of two samples, and a first-order low-pass of a tenth of the sampling rate.
const FILTERS: [[f64; 2]; 2] = [[0.0, 0.5], [0.533_488, 0.466_512]];

fn model() -> Fitting {
    Terms::of_model(Trend::None).into()
}

fn fitted(angles: &Angles, asked: &Fitting) -> Fit {
    let described = describe(&asked.curve(angles).unwrap(), asked).unwrap();
    described.judged(described.fit.clone(), asked.is_forced)
}

#[test]
fn white_noise_through_a_filter_has_its_n_and_no_flicker() {
    for filter in FILTERS {
        let records: Vec<Angles> = (0..RECORDS).map(|seed| filtered(filter, seed)).collect();
        let whole = |angles| fit_record(&curve_of(angles).unwrap(), &Terms::of_model(Trend::None)).unwrap();
        let misled: Vec<Fit> = records.iter().map(whole).collect();
        assert!(share(&misled, |fit| covers(fit, Term::AngleRandomWalk, 1.0)) < 0.1);
        let fits: Vec<Fit> = records.iter().map(|angles| fitted(angles, &model())).collect();
        let covered = share(&fits, |fit| covers(fit, Term::AngleRandomWalk, 1.0));
        let invented = share(&fits, |fit| is_identified(fit, Term::BiasInstability));
        println!("{filter:?}: N covered {covered}, B invented {invented}");
        // 95 % less three standard errors of 3.4 %, and 5 % more three of them.
        assert!(covered > 0.846 && invented < 0.152, "{filter:?}: {covered}, {invented}");
        assert!(fits.iter().all(|fit| fit.tau_range[0] > 1.0 && fit.is_described()));
    }
}

#[test]
fn a_record_without_a_filter_is_fitted_from_the_first_octave_on() {
    let fits: Vec<Fit> = (0..RECORDS).map(|seed| fitted(&filtered([0.0, 1.0], seed), &model())).collect();
    let whole = share(&fits, |fit| fit.tau_range == [1.0, 2048.0]);
    assert!(whole > 0.9, "{whole}");
    let limited = share(&fits, |fit| fit.coefficient(Term::BandLimit).is_some());
    // 5 % of 40, and three standard errors.
    assert!(limited <= 0.15, "{limited} show a filter");
}

#[test]
fn equal_noise_behind_a_filter_is_not_told_apart() {
    let same = |pair: u64| {
        let [a, b] = [0, 1].map(|i| filtered(FILTERS[1], 1000 + 2 * pair + i));
        compare(&Events::from(&a), &Events::from(&b), Some(&model())).unwrap().same.unwrap()
    };
    let all: Vec<_> = (0..RECORDS).map(same).collect();
    let apart = all.iter().filter(|same| same.p < 0.05).count();
    // 5 % of 40, and three standard errors.
    assert!(apart <= 6, "{apart} of {RECORDS}");
    assert!(all.iter().all(|same| same.shortest_s > 1.0), "{all:?}");
}

#[test]
fn terms_that_describe_no_range_have_no_value_unless_forced() {
    let mut rng = StdRng::seed_from_u64(3);
    let sine = |i: usize, hz: f64| 10.0 * libm::sin(core::f64::consts::TAU * hz * i as f64);
    let rate = |i: usize| crate::noise::normal(&mut rng) + sine(i, 0.003) + sine(i, 0.0011);
    let rates: Vec<f64> = (0..SAMPLES).map(rate).collect();
    let angles = Angles::from_increments(&rates, 1.0, 1.0, Trend::None);
    let refused = fitted(&angles, &model());
    assert!(!refused.is_described() && refused.coefficients.len() == 5, "{refused:?}");
    for found in &refused.coefficients {
        assert_eq!(
            (found.verdict, found.value, found.interval, found.standard_error),
            (Verdict::NotDescribed, None, None, None)
        );
    }
    let forced = fitted(&angles, &Fitting { is_forced: true, ..model() });
    assert!(!forced.is_described() && forced.coefficients.iter().any(|found| found.value.is_some()));
    assert!(
        compare(&Events::from(&angles), &Events::from(&angles), Some(&model())).unwrap().differences.is_err()
    );
    // Below the periods there is white noise alone.
    let short = fitted(&angles, &Fitting { to_s: Some(8.0), ..model() });
    assert!(short.tau_range == [1.0, 8.0] && short.is_described(), "{short:?}");
}

#[test]
fn a_sine_takes_precedence_over_a_fit_that_loses_its_octaves() {
    let mut rng = StdRng::seed_from_u64(4);
    let sine = |i: usize| 10.0 * libm::sin(core::f64::consts::TAU * 0.02 * i as f64);
    let rates: Vec<f64> = (0..SAMPLES).map(|i| crate::noise::normal(&mut rng) + sine(i)).collect();
    let fit = fitted(&Angles::from_increments(&rates, 1.0, 1.0, Trend::None), &model());
    let found = fit.coefficient(Term::Sine).unwrap();
    assert_eq!((found.verdict, fit.tau_range[0]), (Verdict::Identified, 1.0));
    let frequency = found.shape.unwrap().value;
    assert!((frequency / 0.02 - 1.0).abs() < 0.01 && covers(&fit, Term::AngleRandomWalk, 1.0), "{fit:?}");
}

#[test]
fn a_given_range_is_not_searched_and_needs_a_point_for_each_term() {
    let angles = filtered(FILTERS[1], 5);
    let at = |from_s: f64| fitted(&angles, &Fitting { from_s: Some(from_s), ..model() });
    assert!(!at(1.0).is_described());
    let late = at(16.0);
    assert!(late.is_described() && late.tau_range == [16.0, 2048.0], "{late:?}");
    let narrow = Fitting { from_s: Some(3.0), to_s: Some(3.5), ..model() };
    let said = narrow.curve(&angles).unwrap_err().to_string();
    assert!(said.contains("0 points cannot determine 1 parameters"), "{said}");
}
