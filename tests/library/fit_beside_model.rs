//! Fits to records whose noise is not that of the usual terms: correlated, not Gaussian, with a line.
//!
//! `benches/allan_numpy.py tails` counts coverage over more records, made by NumPy.

use rand::SeedableRng;
use rand::rngs::StdRng;
use sagnac::allan::{Angles, Trend, Unit};
use sagnac::analysis::data_sheet::{DataSheet, Intervals};
use sagnac::events::Events;
use sagnac::fit::{Terms, Verdict};
use sagnac::record::log::outliers::Outliers;
use sagnac::theory::allan::Term;

use crate::fitted::{covers, share};

const RECORDS: u64 = 40;
const SAMPLES: usize = 1 << 15;

fn sheet(rates: &[f64]) -> DataSheet {
    let angles = Angles::from_increments(rates, 1.0, 1.0, Trend::None);
    let closed = Intervals { records: 0, without: None };
    DataSheet::new(
        &Events::new(&angles, &Outliers::default(), &[]),
        &Terms::of_model(Trend::None).into(),
        Unit::Angular,
        closed,
        None,
    )
    .unwrap()
}

fn white(seed: u64) -> Vec<f64> {
    let mut rng = StdRng::seed_from_u64(seed);
    (0..SAMPLES).map(|_| crate::noise::normal(&mut rng)).collect()
}

#[test]
fn markov_noise_added_to_white_noise_is_no_filter() {
    let of = |seed: u64| {
        let (mut rates, kept) = (white(seed), libm::exp(-1.0 / 100.0));
        let mut y = 0.0;
        for (x, new) in rates.iter_mut().zip(white(1000 + seed)) {
            y = kept * y + libm::sqrt(1.0 - kept * kept) * new;
            *x += 0.5 * y;
        }
        sheet(&rates).fit
    };
    let fits: Vec<_> = (0..RECORDS).map(of).collect();
    // In a few records the usual terms describe the curve too.
    let found = share(&fits, |fit| fit.coefficient(Term::Markov).is_some_and(|found| found.value.is_some()));
    assert!(found > 0.9, "{found}");
    assert!(fits.iter().all(|fit| fit.coefficient(Term::BandLimit).is_none()));
    // 95 % less three standard errors of 3.4 %.
    assert!(share(&fits, |fit| covers(fit, Term::AngleRandomWalk, 1.0)) > 0.846);
}

#[test]
fn intervals_contain_changes_of_the_size_of_the_noise() {
    // 128 sizes with a relative scatter of 0.2.
    let of = |seed: u64| {
        let sizes = white(2000 + seed);
        let mut rates = white(seed);
        for (part, size) in rates.chunks_mut(SAMPLES / 128).zip(&sizes) {
            part.iter_mut().for_each(|x| *x *= libm::exp(0.2 * size));
        }
        sheet(&rates).fit
    };
    let fits: Vec<_> = (0..RECORDS).map(of).collect();
    let mean = libm::exp(0.04);
    let covered = share(&fits, |fit| covers(fit, Term::AngleRandomWalk, mean));
    assert!(covered > 0.846, "{covered}");
    // Those of Gaussian noise would be 0.013 wide.
    let widths = fits.iter().map(|fit| fit.coefficient(Term::AngleRandomWalk).unwrap().interval.unwrap());
    assert!(widths.map(|[low, high]| high - low).sum::<f64>() / RECORDS as f64 > 0.05);
}

#[test]
fn a_line_is_no_quantization_noise() {
    // At a third of the sampling rate a sine adds the same to τ²σ² at every octave.
    let sine = |i: usize| 0.7 * libm::sin(core::f64::consts::TAU / 3.0 * i as f64);
    let with_line: Vec<f64> = white(1).iter().enumerate().map(|(i, x)| x + sine(i)).collect();
    let found = sheet(&with_line);
    let verdict = found.fit.coefficient(Term::Quantization).unwrap().verdict;
    assert!(verdict != Verdict::Identified && covers(&found.fit, Term::AngleRandomWalk, 1.0), "{found:?}");

    let errors = white(2);
    let quantized = white(3).into_iter().zip(&errors).zip(&errors[1..]);
    let quantized: Vec<f64> = quantized.map(|((x, before), after)| x + after - before).collect();
    let found = sheet(&quantized);
    assert!(!found.is_hump && covers(&found.fit, Term::Quantization, 1.0), "{found:?}");
}

/// A laser gyro counts pulses, which may be larger than its noise: their errors are no white noise, yet Q is that of a pulse.
#[test]
fn coarse_pulses_have_their_quantization_noise() {
    let mut angle = 0.0;
    let pulses: Vec<f64> = white(5)
        .iter()
        .map(|x| {
            let before = libm::floor(angle);
            angle += 0.37 + 0.05 * x;
            libm::floor(angle) - before
        })
        .collect();
    let found = sheet(&pulses);
    assert!(!found.is_hump && covers(&found.fit, Term::Quantization, 1.0 / libm::sqrt(12.0)), "{found:?}");
}

/// Means of few samples that are known have the noise of as many fewer.
#[test]
fn a_record_with_every_second_sample_missing_has_its_noise() {
    let mut rates = white(6);
    rates.iter_mut().step_by(2).for_each(|x| *x = f64::NAN);
    let found = sheet(&rates);
    assert!(covers(&found.fit, Term::AngleRandomWalk, 1.0), "{found:?}");
}
