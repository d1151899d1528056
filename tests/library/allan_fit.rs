//! The fit of noise coefficients to exact curves, and to curves whose scatter is known.

use crate::fitted::{QNB, covers, is_identified, share};
use crate::noise::normal;
use rand::SeedableRng;
use rand::rngs::StdRng;
use sagnac::fit::curve::{Covariance, Curve};
use sagnac::fit::selection::Terms;
use sagnac::fit::{Errors, Fit, Verdict, describe, fit, ranking};
use sagnac::theory::allan::terms::Term;
use sagnac::theory::allan::{Difference, Estimator, Part, Process};
use sagnac::theory::cholesky;

/// Averaging factors, `per_decade` to a factor of ten or 0 for octaves, up to a tenth of the record.
fn factors(samples: u64, per_decade: u32) -> Vec<u64> {
    let step = if per_decade == 0 { 2.0 } else { 10_f64.powf(1.0 / f64::from(per_decade)) };
    let mut ms: Vec<u64> =
        (0..400).map(|i| step.powi(i).round() as u64).take_while(|m| 10 * m <= samples).collect();
    ms.dedup();
    ms
}

/// The curve that a process gives on average.
fn mean_curve(process: &Process, samples: u64, per_decade: u32) -> Curve {
    let ms = factors(samples, per_decade);
    let at = |&m: &u64| process.expected(Estimator::OVERLAPPING, samples, m).unwrap();
    let variances = ms.iter().map(at).collect();
    Curve::new(process.sample_s, samples, Difference::Second, ms, variances).unwrap()
}

fn process(parts: &[Part]) -> Process {
    Process { sample_s: 1.0, parts: parts.to_vec() }
}

/// LGV-1 of the paper's table 2.
fn lgv1() -> [Part; 3] {
    [Part::quantization(0.11), Part::angle_random_walk(0.00048 * 60.0), Part::bias_instability(0.00164, 24)]
}

fn near(found: Option<f64>, expected: f64, tolerance: f64, what: &str) {
    let found = found.unwrap_or_else(|| panic!("{what} is not identified"));
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found}, not {expected}");
}

fn value(fit: &Fit, term: Term) -> Option<f64> {
    fit.coefficient(term).unwrap().value
}

/// Curves drawn from a normal distribution about `mean`; those that reach below 0 are no curves and are left out.
fn draws(mean: &Curve, covariance: &Covariance, count: usize, seed: u64) -> Vec<Curve> {
    let points = mean.ms().len();
    let factor = cholesky::definite(points, |i, j| covariance.rows()[i][j]).unwrap();
    let mut rng = StdRng::seed_from_u64(seed);
    let draw = |_| {
        let g: Vec<f64> = (0..points).map(|_| normal(&mut rng)).collect();
        let error = |i: usize| (0..=i).map(|k| factor[i][k] * g[k]).sum::<f64>();
        let variances = (0..points).map(|i| mean.variances()[i] + error(i)).collect();
        Curve::new(1.0, mean.samples(), mean.difference(), mean.ms().to_vec(), variances).ok()
    };
    (0..count).filter_map(draw).collect()
}

#[test]
fn curves_without_noise_are_recovered() {
    let parts = [
        (Term::Quantization, Part::quantization(0.11), 0.11),
        (Term::AngleRandomWalk, Part::angle_random_walk(0.0288), 0.0288),
        (Term::BiasInstability, Part::bias_instability(0.00164, 24), 0.00164),
        (Term::RateRandomWalk, Part::rate_random_walk(2e-5), 2e-5),
        (Term::RateRamp, Part::rate_ramp(4e-7), 4e-7),
    ];
    let all = process(&parts.map(|(_, part, _)| part));
    for per_decade in [0, 10] {
        let curve = mean_curve(&all, 1_000_000, per_decade);
        let covariance = Covariance::of_process(&all, &curve).unwrap();
        let fit = fit(&curve, &covariance, &Terms::Given(Term::MODEL.to_vec()), Errors::Known).unwrap();
        assert!(fit.chi_squared < 1e-12, "χ² = {}", fit.chi_squared);
        assert_eq!(fit.degrees_of_freedom, curve.ms().len() - 5);
        assert_eq!(fit.p_value(), Some(1.0));
        for (term, _, truth) in parts {
            near(value(&fit, term), truth, 1e-7, term.symbol());
        }
    }
    // Each alone, the white floor of a good instrument under what is not noise itself.
    for (term, part, truth) in parts {
        let alone = process(&[part]);
        let weights = process(&[part, Part::angle_random_walk(1e-4)]);
        let curve = mean_curve(&alone, 1_000_000, 0);
        let covariance = Covariance::of_process(&weights, &curve).unwrap();
        let fit = fit(&curve, &covariance, &Terms::Auto(Term::MODEL.to_vec()), Errors::Known).unwrap();
        near(value(&fit, term), truth, 1e-7, term.symbol());
        for other in Term::MODEL.into_iter().filter(|other| *other != term) {
            assert!(!is_identified(&fit, other), "{other:?} beside {term:?} alone");
        }
    }
}

#[test]
fn correlation_time_and_frequency_are_recovered() {
    let (sigma, time_s) = (0.004, 200.0);
    let markov = Part::markov(sigma * f64::sqrt(2.0 / time_s), time_s);
    let sine = Part::sine(0.01, 0.003);
    let terms = [&QNB[..], &[Term::Markov, Term::Sine]].concat();
    let truth = process(&[&lgv1()[..], &[markov, sine]].concat());
    let curve = mean_curve(&truth, 324_000, 10);
    let covariance = Covariance::of_process(&truth, &curve).unwrap();
    for terms in [Terms::Given(terms.clone()), Terms::Auto(terms)] {
        let fit = fit(&curve, &covariance, &terms, Errors::Known).unwrap();
        let shape = |term| fit.coefficient(term).unwrap().shape.map(|shape| shape.value);
        near(value(&fit, Term::Markov), sigma, 1e-4, "σ");
        near(shape(Term::Markov), time_s, 1e-4, "T_c");
        near(value(&fit, Term::Sine), 0.01, 1e-4, "Ω_0");
        near(shape(Term::Sine), 0.003, 1e-4, "f");
        near(value(&fit, Term::AngleRandomWalk), 0.0288, 1e-4, "N");
    }
    // A correlation time far beyond the record is not told from a random walk of the rate.
    let slow = Part::markov(1e-4, 1e9);
    let truth = process(&[lgv1()[1], slow]);
    let curve = mean_curve(&truth, 324_000, 0);
    let covariance = Covariance::of_process(&truth, &curve).unwrap();
    let fit =
        fit(&curve, &covariance, &Terms::Given(vec![Term::AngleRandomWalk, Term::Markov]), Errors::Known)
            .unwrap();
    let verdict = fit.coefficient(Term::Markov).unwrap().verdict;
    assert_eq!(verdict, Verdict::NotIdentifiable { below: None });
}

#[test]
fn intervals_cover_the_truth_95_times_in_100() {
    let truth = process(&lgv1());
    let mean = mean_curve(&truth, 32_400, 0);
    let covariance = Covariance::of_process(&truth, &mean).unwrap();
    let terms = Terms::Given(QNB.to_vec());
    let fits: Vec<Fit> = draws(&mean, &covariance, 4000, 51)
        .iter()
        .map(|curve| fit(curve, &covariance, &terms, Errors::Known).unwrap())
        .collect();
    for (term, truth) in QNB.into_iter().zip([0.11, 0.0288, 0.00164]) {
        let coverage = share(&fits, |fit| covers(fit, term, truth));
        println!("{}: covered {coverage}", term.symbol());
        assert!((coverage - 0.95).abs() < 0.02, "{term:?}: {coverage}");
    }
    let small = share(&fits, |fit| fit.p_value().unwrap() < 0.05);
    println!("χ² beyond its 95 % level: {small}");
    assert!((small - 0.05).abs() < 0.02, "{small}");
}

#[test]
fn intervals_of_markov_noise_cover_its_time_too() {
    let (sigma, time_s) = (0.004, 200.0);
    let markov = Part::markov(sigma * f64::sqrt(2.0 / time_s), time_s);
    let truth = process(&[lgv1()[0], lgv1()[1], markov]);
    let mean = mean_curve(&truth, 324_000, 0);
    let covariance = Covariance::of_process(&truth, &mean).unwrap();
    let terms = Terms::Given(vec![Term::Quantization, Term::AngleRandomWalk, Term::Markov]);
    let fits: Vec<Fit> = draws(&mean, &covariance, 1000, 52)
        .iter()
        .map(|curve| fit(curve, &covariance, &terms, Errors::Known).unwrap())
        .collect();
    let in_shape = |fit: &Fit| {
        let shape = fit.coefficient(Term::Markov).unwrap().shape;
        shape.is_some_and(|shape| shape.interval[0] <= time_s && time_s <= shape.interval[1])
    };
    let shares = [share(&fits, |fit| covers(fit, Term::Markov, sigma)), share(&fits, in_shape)];
    println!("σ and T_c: covered {shares:?}");
    // Three standard errors of 1000 draws beside the 2 %.
    assert!(shares.iter().all(|share| (share - 0.95).abs() < 0.04), "{shares:?}");
}

#[test]
fn what_is_not_there_is_bounded_and_not_invented() {
    let white = process(&[Part::angle_random_walk(0.03)]);
    let mean = mean_curve(&white, 32_400, 0);
    let covariance = Covariance::of_process(&white, &mean).unwrap();
    let terms = Terms::Given(Term::MODEL.to_vec());
    let fits: Vec<Fit> = draws(&mean, &covariance, 2000, 53)
        .iter()
        .map(|curve| fit(curve, &covariance, &terms, Errors::Known).unwrap())
        .collect();
    for term in [Term::Quantization, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp] {
        let invented = share(&fits, |fit| is_identified(fit, term));
        println!("{}: identified in {invented}", term.symbol());
        assert!(invented < 0.04, "{term:?}: {invented}");
        assert!(fits.iter().all(|fit| is_identified(fit, term) || covers(fit, term, 0.0)), "{term:?}");
    }
    // A bias instability of one standard error of its square is below its bound, or identified and in its interval.
    let error = {
        let fit = fit(
            &mean,
            &covariance,
            &Terms::Given(vec![Term::AngleRandomWalk, Term::BiasInstability]),
            Errors::Known,
        )
        .unwrap();
        let (Verdict::AtBoundary { below } | Verdict::NotIdentifiable { below: Some(below) }) =
            fit.coefficient(Term::BiasInstability).unwrap().verdict
        else {
            panic!("{fit:?}")
        };
        below / 1.96_f64.sqrt()
    };
    let faint = process(&[Part::angle_random_walk(0.03), Part::bias_instability(error, 24)]);
    let mean = mean_curve(&faint, 32_400, 0);
    let covariance = Covariance::of_process(&faint, &mean).unwrap();
    let terms = Terms::Given(vec![Term::AngleRandomWalk, Term::BiasInstability]);
    let fits: Vec<Fit> = draws(&mean, &covariance, 4000, 54)
        .iter()
        .map(|curve| fit(curve, &covariance, &terms, Errors::Known).unwrap())
        .collect();
    let coverage = share(&fits, |fit| covers(fit, Term::BiasInstability, error));
    println!("B of one standard error: covered {coverage}");
    assert!((0.93..0.99).contains(&coverage), "{coverage}");
}

#[test]
fn the_criterion_of_a_ranking_is_the_chi_squared_of_other_records() {
    let truth = process(&[Part::angle_random_walk(0.03), Part::rate_random_walk(2e-4)]);
    let all = mean_curve(&truth, 1 << 20, 0);
    // Up to averaging factors whose estimates never fall below 0.
    let (ms, variances) = (all.ms()[..13].to_vec(), all.variances()[..13].to_vec());
    let mean = Curve::new(1.0, all.samples(), all.difference(), ms, variances).unwrap();
    let covariance = Covariance::of_process(&truth, &mean).unwrap();

    // The average curve has the fit of its process, and so its covariance.
    let described = describe(&mean, &Terms::Auto(Term::MODEL.to_vec()).into()).unwrap();
    let models = ranking(&described).unwrap();
    assert_eq!(models[0].terms, [Term::AngleRandomWalk, Term::RateRandomWalk]);
    assert!(models.windows(2).all(|pair| pair[0].criterion <= pair[1].criterion));
    let plain = models.iter().filter(|model| model.terms.iter().all(|term| Term::MODEL.contains(term)));
    let mut count = 0;
    for model in plain {
        let alone = fit(&mean, &covariance, &Terms::Given(model.terms.clone()), Errors::Known).unwrap();
        let (chi_squared, parameters) = (alone.chi_squared, model.terms.len() as f64);
        assert!(
            (model.chi_squared - chi_squared).abs() < 1e-6 * (1.0 + chi_squared),
            "{model:?} {chi_squared}"
        );
        assert_eq!(model.degrees_of_freedom, alone.degrees_of_freedom);
        assert!((model.criterion - model.chi_squared - 2.0 * parameters).abs() < 1e-12);
        count += 1;
    }
    assert!(count >= 5, "{count} models");

    // What the fit to one record costs at another one, on average.
    let terms = Terms::Given(models[0].terms.clone());
    let excess = |pair: &[Curve]| {
        let fit = fit(&pair[0], &covariance, &terms, Errors::Known).unwrap();
        let of = |part: &Part| mean.of_term(part.term, part.square(), part.shape);
        let parts: Vec<Vec<f64>> = fit.process.parts.iter().map(of).collect();
        let residual = |i: usize| pair[1].variances()[i] - parts.iter().map(|part| part[i]).sum::<f64>();
        let residuals: Vec<f64> = (0..mean.ms().len()).map(residual).collect();
        covariance.whiten(&residuals).iter().map(|x| x * x).sum::<f64>() - fit.chi_squared
    };
    let pairs = draws(&mean, &covariance, 16_000, 60);
    assert_eq!(pairs.len(), 16_000);
    let excesses: Vec<f64> = pairs.chunks(2).map(excess).collect();
    let average = excesses.iter().sum::<f64>() / excesses.len() as f64;
    let squares: f64 = excesses.iter().map(|x| (x - average) * (x - average)).sum();
    let error = squares.sqrt() / excesses.len() as f64;
    println!("excess {average} ± {error}");
    assert!((average - 4.0).abs() < 3.0 * error && error < 0.1, "{average} ± {error}, not 4");
}

#[test]
fn a_covariance_of_few_realizations_is_drawn_to_the_model() {
    let truth = process(&lgv1());
    let mean = mean_curve(&truth, 32_400, 0);
    let model = Covariance::of_process(&truth, &mean).unwrap();
    let rows = |count, seed| -> Vec<Vec<f64>> {
        draws(&mean, &model, count, seed).iter().map(|curve| curve.variances().to_vec()).collect()
    };
    let distance = |found: &Covariance, from: &Covariance| {
        let points = mean.ms().len();
        let deviation = |i: usize, j: usize| {
            let scale = (from.rows()[i][i] * from.rows()[j][j]).sqrt();
            ((found.rows()[i][j] - from.rows()[i][j]) / scale).abs()
        };
        (0..points * points).map(|cell| deviation(cell / points, cell % points)).fold(0.0, f64::max)
    };
    // Five rows of twelve points: singular without the model.
    let few = Covariance::of_realizations(&rows(5, 57), &model).unwrap();
    assert!(distance(&few, &model) < 0.7, "{}", distance(&few, &model));
    let fit_of_few = fit(&mean, &few, &Terms::Given(QNB.to_vec()), Errors::Known).unwrap();
    near(value(&fit_of_few, Term::BiasInstability), 0.00164, 1e-7, "B");
    // A model that is far off gives way to many rows.
    let wrong = Covariance::of_process(&process(&[Part::angle_random_walk(0.1)]), &mean).unwrap();
    let many = Covariance::of_realizations(&rows(4000, 58), &wrong).unwrap();
    println!("few from the model by {}, many by {}", distance(&few, &model), distance(&many, &model));
    assert!(distance(&many, &model) < 0.1, "{}", distance(&many, &model));
    assert!(Covariance::of_realizations(&rows(1, 59), &model).is_err());
}
