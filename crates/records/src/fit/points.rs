//! The fit to the points of a curve that is of no record at hand: each has its own error, which is known in parts of its value.

use crate::fit::curve::{Covariance, Curve, FitError};
use crate::fit::search::{Fitted, System};
use crate::fit::selection::{Fitting, MIN_P, Terms};
use crate::fit::{Coefficient, Errors, Fit, Fitter, Verdict};
use sagnac_theory::allan::Term;

/// Rounds in which the errors take on the values of the model.
const ROUNDS: usize = 4;
/// Distance in octaves of τ within which points share the weight of one, because those of one record are of the same differences.
const NEAR: f64 = 0.5;
/// Points at the shortest τ that a fit may leave out, and the fewest that it must keep.
const MAX_LEFT_OUT: usize = 4;
const MIN_POINTS: usize = 5;

/// The fit of `asked` to points with averaging times, s, Allan variances, (″/s)², and standard errors of the variances in parts of
/// them.
///
/// The points are independent, but those within half an octave of τ of each other share the weight of one. Errors are parts of the
/// fitted curve instead of the points, because low points would then get the largest weights. Where the terms do not describe the points,
/// up to four of the shortest τ are left out, and then a sine or Markov noise is tried; if that fails too, every coefficient is
/// [not described](Verdict::NotDescribed).
///
/// # Errors
/// The points are no curve, or there are fewer than terms.
///
/// # Example
/// ```
/// use sagnac_records::fit::points::fit_points;
/// use sagnac_records::fit::{Term, Terms};
///
/// let taus: Vec<f64> = (0..12).map(|octave| f64::from(1 << octave)).collect();
/// let variances: Vec<f64> = taus.iter().map(|tau| 0.03_f64.powi(2) / tau + 1e-6 * tau / 3.0).collect();
/// let fit = fit_points(&taus, &variances, &[0.1; 12], &Terms::Auto(Term::MODEL.to_vec()).into())?;
/// assert!((fit.coefficient(Term::AngleRandomWalk).unwrap().value.unwrap() - 0.03).abs() < 1e-9);
/// assert!((fit.coefficient(Term::RateRandomWalk).unwrap().value.unwrap() - 0.001).abs() < 1e-9);
/// # Ok::<(), sagnac_records::fit::curve::FitError>(())
/// ```
pub fn fit_points(
    taus_s: &[f64],
    variances: &[f64],
    errors: &[f64],
    asked: &Fitting,
) -> Result<Fit, FitError> {
    let is_within = |tau_s: f64| {
        asked.from_s.is_none_or(|from_s| tau_s > from_s * (1.0 - 1e-9))
            && asked.to_s.is_none_or(|to_s| tau_s < to_s * (1.0 + 1e-9))
    };
    let within: Vec<usize> = (0..taus_s.len()).filter(|&i| is_within(taus_s[i])).collect();
    let of = |values: &[f64]| within.iter().map(|&i| values[i]).collect::<Vec<f64>>();
    let points = Points { taus_s: of(taus_s), variances: of(variances), errors: of(errors) };
    let whole = points.fit(&asked.terms, 0)?;
    let is_likely = |fit: &Fit| fit.p_value().is_none_or(|p| p > MIN_P);
    let is_chosen = matches!(asked.terms, Terms::Auto(_));
    if is_likely(&whole) {
        return Ok(whole);
    }
    let most = match is_chosen && asked.from_s.is_none() {
        true => points.taus_s.len().saturating_sub(MIN_POINTS).min(MAX_LEFT_OUT),
        false => 0,
    };
    let shorter = (1..=most).filter_map(|start| points.fit(&asked.terms, start).ok());
    let shaped = [Term::Sine, Term::Markov].into_iter().filter(|_| is_chosen);
    let shaped = shaped.filter_map(|term| points.fit(&asked.terms.with(term), 0).ok());
    if let Some(fit) = shorter.chain(shaped).find(is_likely) {
        return Ok(fit);
    }
    let rejected = |found: Coefficient| match asked.is_forced {
        true => Coefficient { verdict: Verdict::NotDescribed, ..found },
        false => found.without_value(Verdict::NotDescribed),
    };
    Ok(Fit { coefficients: whole.coefficients.into_iter().map(rejected).collect(), ..whole })
}

struct Points {
    taus_s: Vec<f64>,
    variances: Vec<f64>,
    errors: Vec<f64>,
}

impl Points {
    /// Number of points among which each shares the weight of one.
    fn crowd(&self, place: usize) -> f64 {
        let is_near = |tau_s: &&f64| libm::fabs(libm::log2(*tau_s / self.taus_s[place])) < NEAR;
        self.taus_s.iter().filter(is_near).count() as f64
    }

    /// The fit of terms to the points from a place on.
    fn fit(&self, terms: &Terms, start: usize) -> Result<Fit, FitError> {
        let (taus_s, variances) = (self.taus_s[start..].to_vec(), self.variances[start..].to_vec());
        let crowds: Vec<f64> = (start..self.taus_s.len()).map(|place| self.crowd(place)).collect();
        let curve = Curve::of_points(taus_s, variances)?;
        let fitter = Fitter::new(&curve, terms)?;
        let covariance = |model: &[f64]| {
            let each = model.iter().zip(&self.errors[start..]).zip(&crowds);
            let deviations: Vec<f64> =
                each.map(|((x, error), crowd)| x * error * libm::sqrt(*crowd)).collect();
            Covariance::of_deviations(&deviations)
        };
        let mut model = curve.variances().to_vec();
        for _ in 0..ROUNDS {
            let found = System::new(&curve, &covariance(&model)?, &fitter.basis).best(&fitter.candidates);
            model = sum(&curve, &found.terms);
        }
        let fit = fitter.fit(curve.variances(), &covariance(&model)?, Errors::Known)?;
        // As many points as there are with a weight of their own.
        let points = libm::round(crowds.iter().map(|crowd| 1.0 / crowd).sum());
        let parameters = curve.variances().len() - fit.degrees_of_freedom;
        Ok(Fit { degrees_of_freedom: (points as usize).saturating_sub(parameters), ..fit })
    }
}

/// The curve of some terms.
fn sum(curve: &Curve, terms: &[Fitted]) -> Vec<f64> {
    let mut sum = vec![0.0; curve.variances().len()];
    for fitted in terms.iter().filter(|fitted| fitted.square > 0.0) {
        let column = curve.of_term(fitted.term, fitted.square, fitted.shape);
        sum.iter_mut().zip(column).for_each(|(sum, x)| *sum += x);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_theory::allan::{Part, continuous_variance};

    const PARTS: [Part; 3] =
        [Part::angle_random_walk(0.03), Part::bias_instability(0.004, 1), Part::rate_random_walk(2e-5)];

    fn at(tau_s: f64) -> f64 {
        PARTS.iter().filter_map(|part| continuous_variance(part, tau_s)).sum()
    }

    fn octaves() -> Vec<f64> {
        (0..16).map(|octave| f64::from(1 << octave)).collect()
    }

    fn model() -> Fitting {
        Terms::Auto(Term::MODEL.to_vec()).into()
    }

    #[test]
    fn a_curve_in_closed_form_gives_its_coefficients() {
        let taus = octaves();
        let variances: Vec<f64> = taus.iter().map(|&tau_s| at(tau_s)).collect();
        let fit = fit_points(&taus, &variances, &[0.05; 16], &model()).unwrap();
        for part in PARTS {
            let value = fit.coefficient(part.term).and_then(|found| found.value);
            assert!(
                value.is_some_and(|value| (value / part.size - 1.0).abs() < 1e-6),
                "{:?}: {value:?}",
                part.term
            );
        }
        assert!(fit.is_described() && fit.chi_squared < 1e-6);
    }

    /// Numbers from 0 to 1 by a linear congruence.
    struct Draws(u64);

    impl Draws {
        fn normal(&mut self) -> f64 {
            let mut next = || {
                self.0 =
                    self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
            };
            let (radius, turn) = (libm::sqrt(-2.0 * libm::log(next())), 2.0 * core::f64::consts::PI * next());
            radius * libm::cos(turn)
        }
    }

    #[test]
    fn intervals_cover_where_the_errors_are_known() {
        // 95 % intervals of ±10 % of the deviation.
        const ERROR: f64 = 0.1 / 1.96;
        const CURVES: usize = 200;
        let (taus, mut draws, mut covered) = (octaves(), Draws(7), [0; 3]);
        for _ in 0..CURVES {
            let read = |&tau_s: &f64| at(tau_s) * libm::exp(2.0 * ERROR * draws.normal());
            let variances: Vec<f64> = taus.iter().map(read).collect();
            let fit = fit_points(&taus, &variances, &[2.0 * ERROR; 16], &model()).unwrap();
            for (count, part) in covered.iter_mut().zip(PARTS) {
                let interval = fit.coefficient(part.term).and_then(|found| found.interval);
                *count +=
                    usize::from(interval.is_some_and(|[low, high]| low <= part.size && part.size <= high));
            }
        }
        // 190 are expected, with a standard deviation of 3.1.
        assert!(covered.iter().all(|&count| (184..=197).contains(&count)), "{covered:?} of {CURVES}");
    }

    #[test]
    fn a_curve_that_no_noise_has_is_rejected() {
        let taus = octaves();
        let steps = |place: usize| if place % 4 < 2 { 1.0 } else { 3.0 };
        let variances: Vec<f64> = taus.iter().enumerate().map(|(i, &tau_s)| at(tau_s) * steps(i)).collect();
        let fit = fit_points(&taus, &variances, &[0.1; 16], &model()).unwrap();
        assert!(!fit.is_described(), "{:?}", fit.coefficients);
    }

    #[test]
    fn dense_points_weigh_no_more_than_octaves() {
        let dense: Vec<f64> = (0..151).map(|i| libm::exp2(f64::from(i) / 10.0)).collect();
        let width = |taus: &[f64]| {
            let variances: Vec<f64> = taus.iter().map(|&tau_s| at(tau_s)).collect();
            let fit = fit_points(taus, &variances, &vec![0.1; taus.len()], &model()).unwrap();
            let [low, high] = fit.coefficient(Term::AngleRandomWalk).unwrap().interval.unwrap();
            high - low
        };
        let ratio = width(&dense) / width(&octaves());
        assert!((0.7..1.3).contains(&ratio), "{ratio}");
    }
}
