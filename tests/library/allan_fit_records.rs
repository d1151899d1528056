//! The fit of noise coefficients to simulated records: the choice of terms, and coverage with weights from the fit itself.

use crate::fitted::{QNB, covers, is_identified, share};
use rand::SeedableRng;
use rand::rngs::StdRng;
use sagnac::fit::curve::{Covariance, Curve, FitError};
use sagnac::fit::selection::Terms;
use sagnac::fit::{Errors, Fit, Fitter, fit, fit_record};
use sagnac::theory::allan::terms::Term;
use sagnac::theory::allan::{Difference, Part, Process};

/// Records of each test; three standard errors of a share of 5 %.
const RECORDS: usize = 300;
const THREE_ERRORS: f64 = 0.038;

/// Overlapping Allan variances of a record, by definition.
fn curve_of_angles(theta: &[f64], ms: &[u64]) -> Curve {
    let at = |&m: &u64| {
        let m = m as usize;
        let terms = theta.len() - 2 * m;
        let sum: f64 = (0..terms).map(|k| (theta[k + 2 * m] - 2.0 * theta[k + m] + theta[k]).powi(2)).sum();
        sum / (2 * terms * m * m) as f64
    };
    Curve::new(1.0, theta.len() as u64 - 1, Difference::Second, ms.to_vec(), ms.iter().map(at).collect())
        .unwrap()
}

/// Curves of records of 1 s samples, over so many octaves.
fn curves(parts: &[Part], samples: usize, octaves: u32, seed: u64) -> Vec<Curve> {
    let process = Process { sample_s: 1.0, parts: parts.to_vec() };
    let ms: Vec<u64> = (0..octaves).map(|octave| 1 << octave).collect();
    let mut rng = StdRng::seed_from_u64(seed);
    (0..RECORDS).map(|_| curve_of_angles(&crate::noise::record(&process, samples, &mut rng), &ms)).collect()
}

fn fits(curves: &[Curve], terms: &Terms) -> Vec<Fit> {
    let fitter = Fitter::new(&curves[0], terms).unwrap();
    curves.iter().map(|curve| fitter.fit_record(curve.variances()).unwrap()).collect()
}

#[test]
fn one_fitter_gives_many_curves_the_bits_of_fits_of_their_own() {
    let parts = [Part::quantization(3.0), Part::angle_random_walk(1.0)];
    let curves = &curves(&parts, 4096, 10, 62)[..12];
    let covariance =
        Covariance::of_process(&Process { sample_s: 1.0, parts: parts.to_vec() }, &curves[0]).unwrap();
    let with_shapes = vec![Term::AngleRandomWalk, Term::Markov, Term::Sine];
    for terms in [Terms::Given(QNB.to_vec()), Terms::Auto(Term::MODEL.to_vec()), Terms::Auto(with_shapes)] {
        let fitter = Fitter::new(&curves[0], &terms).unwrap();
        for curve in curves {
            // Debug text of f64 tells all bits but those of NaN.
            let text = |fit: Fit| format!("{fit:?}");
            let alone = fit_record(curve, &terms).unwrap();
            assert_eq!(text(fitter.fit_record(curve.variances()).unwrap()), text(alone));
            for errors in [Errors::Known, Errors::OfModel] {
                let alone = fit(curve, &covariance, &terms, errors).unwrap();
                assert_eq!(text(fitter.fit(curve.variances(), &covariance, errors).unwrap()), text(alone));
            }
        }
        let wrong = fitter.fit_record(&curves[0].variances()[1..]).unwrap_err();
        assert_eq!(wrong, FitError::Lengths { ms: 10, variances: 9 });
    }
}

#[test]
fn white_records_have_no_flicker() {
    // Up to half of the record, where one difference is left and the estimate most skewed.
    let curves = curves(&[Part::angle_random_walk(1.0)], 4096, 12, 55);
    let fits = fits(&curves, &Terms::Auto(Term::MODEL.to_vec()));
    let shares = Term::MODEL.map(|term| share(&fits, |fit| is_identified(fit, term)));
    println!("white noise: Q, N, B, K, R found in {shares:?}");
    assert_eq!(shares[1], 1.0);
    for (term, share) in Term::MODEL.into_iter().zip(shares) {
        assert!(term == Term::AngleRandomWalk || share < 0.05 + THREE_ERRORS, "{term:?}: {share}");
    }
    let coverage = share(&fits, |fit| covers(fit, Term::AngleRandomWalk, 1.0));
    println!("white noise: N covered {coverage}");
    assert!((coverage - 0.95).abs() < THREE_ERRORS, "{coverage}");
}

#[test]
fn white_records_have_neither_markov_noise_nor_sines() {
    let curves = curves(&[Part::angle_random_walk(1.0)], 4096, 12, 61);
    for term in [Term::Markov, Term::Sine] {
        let fits = fits(&curves, &Terms::Auto(vec![Term::AngleRandomWalk, term]));
        let invented = share(&fits, |fit| is_identified(fit, term));
        println!("white noise: {} invented in {invented}", term.symbol());
        assert!(invented < 0.05 + THREE_ERRORS, "{term:?}: {invented}");
    }
}

#[test]
fn markov_noise_beside_a_strong_sine_has_its_time() {
    let (sigma, time_s) = (0.02, 100.0);
    let parts = [
        Part::angle_random_walk(0.03),
        Part::markov(sigma * f64::sqrt(2.0 / time_s), time_s),
        Part::sine(0.1, 0.02),
    ];
    let terms = Terms::Given(vec![Term::AngleRandomWalk, Term::Markov, Term::Sine]);
    let fits = fits(&curves(&parts, 16_384, 12, 63)[..100], &terms);
    let in_shape = |fit: &Fit, term: Term, truth: f64| {
        let shape = fit.coefficient(term).unwrap().shape;
        shape.is_some_and(|shape| shape.interval[0] <= truth && truth <= shape.interval[1])
    };
    let shares = [
        share(&fits, |fit| in_shape(fit, Term::Markov, time_s)),
        share(&fits, |fit| in_shape(fit, Term::Sine, 0.02)),
        share(&fits, |fit| fit.p_value().unwrap() > 1e-3),
    ];
    println!("T_c and f covered, and the fit good: {shares:?}");
    assert!(shares.iter().all(|share| *share > 0.85), "{shares:?}");
}

#[test]
fn terms_that_a_record_shows_are_found() {
    let (q, n, k) = (3.0, 1.0, 0.01);
    let truths = [(Term::Quantization, q), (Term::AngleRandomWalk, n), (Term::RateRandomWalk, k)];
    let parts = [Part::quantization(q), Part::angle_random_walk(n), Part::rate_random_walk(k)];
    // Up to an eighth of the record.
    let fits = fits(&curves(&parts, 16_384, 12, 56), &Terms::Auto(Term::MODEL.to_vec()));
    for (term, truth) in truths {
        let found = share(&fits, |fit| is_identified(fit, term));
        let coverage = share(&fits, |fit| covers(fit, term, truth));
        println!("{}: found in {found}, covered {coverage}", term.symbol());
        // Coverage holds for the chosen terms, which are not always the true ones.
        assert!(found > 0.85 && coverage > 0.89, "{term:?}: found in {found}, covered {coverage}");
    }
    for term in [Term::BiasInstability, Term::RateRamp] {
        let invented = share(&fits, |fit| is_identified(fit, term));
        println!("{}: invented in {invented}", term.symbol());
        assert!(invented < 0.05 + THREE_ERRORS, "{term:?}: {invented}");
    }
}

#[test]
fn intervals_of_a_gyros_records_cover_the_truth() {
    // LGV-1 of the paper's table 2, 9 h.
    let (q, n, b) = (0.11, 0.0288, 0.00164);
    let parts = [Part::quantization(q), Part::angle_random_walk(n), Part::bias_instability(b, 24)];
    let curves = curves(&parts, 32_400, 14, 60);
    let given = fits(&curves, &Terms::Given(QNB.to_vec()));
    let auto = fits(&curves, &Terms::Auto(Term::MODEL.to_vec()));
    for (term, truth) in QNB.into_iter().zip([q, n, b]) {
        for (name, fits) in [("given", &given), ("auto", &auto)] {
            let found = share(fits, |fit| is_identified(fit, term));
            let coverage = share(fits, |fit| covers(fit, term, truth));
            println!("LGV-1, {name}, {}: found in {found}, covered {coverage}", term.symbol());
            assert!(found > 0.85, "{name}, {term:?}: found in {found}");
            assert!((coverage - 0.95).abs() < 0.02 + THREE_ERRORS, "{name}, {term:?}: covered {coverage}");
        }
    }
    for term in [Term::RateRandomWalk, Term::RateRamp] {
        let invented = share(&auto, |fit| is_identified(fit, term));
        println!("LGV-1, auto, {}: invented in {invented}", term.symbol());
        assert!(invented < 0.05 + THREE_ERRORS, "{term:?}: {invented}");
    }
}

#[test]
fn intervals_of_n_cover_the_truth_where_a_bias_instability_does_not_show() {
    let (q, n) = (0.11, 0.0288);
    let parts = [Part::quantization(q), Part::angle_random_walk(n), Part::bias_instability(0.005, 24)];
    let fits = fits(&curves(&parts, 4096, 10, 64), &Terms::Auto(Term::MODEL.to_vec()));
    let found = share(&fits, |fit| is_identified(fit, Term::BiasInstability));
    for (term, truth) in [(Term::Quantization, q), (Term::AngleRandomWalk, n)] {
        let coverage = share(&fits, |fit| covers(fit, term, truth));
        println!("B found in {found}, {} covered {coverage}", term.symbol());
        assert!((coverage - 0.95).abs() < 0.02 + THREE_ERRORS, "{term:?}: {coverage}");
    }
    assert!((0.4..0.9).contains(&found), "{found}");
}
