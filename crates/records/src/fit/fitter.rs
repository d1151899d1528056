//! The fit of one curve, or of many curves from records of one length.

use std::sync::{Arc, OnceLock};

use crate::allan::chi_squared::normal_quantile;
use crate::fit::assess::Judge;
use crate::fit::choose::Choice;
use crate::fit::covariance::Growth;
use crate::fit::search::{Basis, Fitted, Solution, System};
use crate::fit::{Covariance, Curve, Fit, FitError, Terms};
use sagnac_theory::allan::{Part, Term};

/// The source of the covariance between the estimates, which determines the errors of the coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Errors {
    /// The covariance is known and does not depend on the coefficients: intervals are ± 1.96 standard errors of the
    /// square.
    Known,
    /// The covariance is that of one record of the fitted model, so that a coefficient that came out low seems precise.
    /// Intervals contain the values for which the outcome would not be rare, with the covariance of a record of that
    /// value.
    OfModel,
}

/// Fits `terms` to a curve whose estimates have this covariance.
///
/// With [`Terms::Auto`], the terms are those with the least χ² + Σ penalty over all subsets
/// ([`PENALTY`](crate::fit::choose::PENALTY)). All subsets are compared with the same covariance, so that a term gains
/// nothing by making points uncertain.
///
/// # Errors
/// There are no terms, or fewer points than fitted parameters.
pub fn fit(curve: &Curve, covariance: &Covariance, terms: &Terms, errors: Errors) -> Result<Fit, FitError> {
    Fitter::new(curve, terms)?.fit(curve.variances(), covariance, errors)
}

/// Fits `terms` to the overlapping estimates of one record, without further information on their covariance.
///
/// Estimates at m above N/8 come from so few differences that all of them are often low together. If they are included,
/// intervals of K cover the truth in 86 to 92 % of records instead of 94 to 96 %. Q, N and B of a gyro without K are
/// not impaired by them, and a ramp shows best there.
///
/// The first weights are those of independent points with relative variances 2m/N. The best fit of all terms gives a
/// covariance in closed form, with that a better fit, and that fit gives the final covariance. To continue with
/// simulated realizations of `Fit::process`, use [`Covariance::of_realizations`] and [`fit`].
///
/// # Errors
/// It fails where [`fit`] does, and where the curve is explained best without any noise.
pub fn fit_record(curve: &Curve, terms: &Terms) -> Result<Fit, FitError> {
    Fitter::new(curve, terms)?.fit_record(curve.variances())
}

/// Fits the same terms to many curves of one geometry, from records of one length and at the same averaging factors.
///
/// The terms at these factors and, for terms without shape, the covariance as a form of their squares are computed
/// once. A fit is some hundred times faster than [`fit_record`] and gives the same bits. One fitter serves any number
/// of threads.
///
/// ```
/// # use sagnac_records::fit::{Curve, Fitter, Term, Terms, fit_record};
/// # use sagnac_theory::allan::estimator::Difference;
/// let curve = |variances: &[f64]| {
///     Curve::new(1.0, 64, Difference::Second, vec![1, 2, 4, 8], variances.to_vec())
/// };
/// let (first, second) = (curve(&[1.0, 0.6, 0.2, 0.1])?, curve(&[1.1, 0.5, 0.3, 0.1])?);
/// let terms = Terms::Given(vec![Term::AngleRandomWalk, Term::BiasInstability]);
/// let fitter = Fitter::new(&first, &terms)?;
/// assert_eq!(fitter.fit_record(second.variances())?, fit_record(&second, &terms)?);
/// # Ok::<(), sagnac_records::fit::curve::FitError>(())
/// ```
#[derive(Debug)]
pub struct Fitter {
    geometry: Curve,
    terms: Terms,
    candidates: Vec<Term>,
    basis: Basis,
    /// Growth of the covariance, common to all curves; unused if a term has a shape, because the growth then differs.
    growth: OnceLock<Arc<Growth>>,
}

impl Fitter {
    /// A fitter for curves with the geometry of this one, whatever its variances.
    ///
    /// # Errors
    /// There are no terms.
    pub fn new(geometry: &Curve, terms: &Terms) -> Result<Fitter, FitError> {
        let candidates = terms.candidates()?;
        let basis = Basis::new(geometry, &candidates);
        let (geometry, terms) = (geometry.clone(), terms.clone());
        Ok(Fitter { geometry, terms, candidates, basis, growth: OnceLock::new() })
    }

    /// The curve of the geometry, whose variances it was made with.
    pub fn curve(&self) -> &Curve {
        &self.geometry
    }

    /// The fitter for the averaging factors from the position `start` on, which takes over all that is the same for it.
    pub(crate) fn from(&self, start: usize) -> Fitter {
        let has_shapes = self.candidates.iter().any(|term| term.has_shape());
        let growth = (!has_shapes).then(|| self.growth(&self.complete(&[]), None).from(start));
        Fitter {
            geometry: self.geometry.from(start),
            terms: self.terms.clone(),
            candidates: self.candidates.clone(),
            basis: self.basis.map(|column| column[start..].to_vec()),
            growth: growth.map(|growth| Arc::new(growth).into()).unwrap_or_default(),
        }
    }

    /// Fits the curve with these variances, (″/s)², like [`fit`].
    ///
    /// # Errors
    /// It fails where [`fit`] does, and where the variances are invalid.
    pub fn fit(&self, variances: &[f64], covariance: &Covariance, errors: Errors) -> Result<Fit, FitError> {
        self.fit_with(&self.geometry.with(variances)?, covariance, errors, None, &[])
    }

    /// Fits like [`fit_record`], with simulated curves of `first`, a fit of the same variances.
    ///
    /// The simulated curves give the weights by [`Covariance::of_realizations`]. They also give the quantiles of the
    /// outcomes for the intervals, in standard deviations of the outcomes, which grow with the coefficient according to
    /// the closed form.
    ///
    /// # Errors
    /// It fails where [`fit`] does, and where the variances are invalid, there are fewer than two realizations, or some
    /// have another geometry.
    pub fn fit_realized(
        &self,
        variances: &[f64],
        first: &Fit,
        realizations: &[Vec<f64>],
    ) -> Result<Fit, FitError> {
        let curve = self.geometry.with(variances)?;
        let (growth, model) = self.model(&self.complete(&found(first)), None)?;
        let realizations = with_costs(realizations, &curve);
        let covariance = Covariance::of_realizations(&realizations, &model)?;
        let realizations = with_spread(&realizations, &curve);
        self.fit_with(&curve, &covariance, Errors::OfModel, Some(growth), &realizations)
    }

    /// Fits the curve with these variances, (″/s)², like [`fit_record`].
    ///
    /// # Errors
    /// It fails where [`fit_record`] does, and where the variances are invalid.
    pub fn fit_record(&self, variances: &[f64]) -> Result<Fit, FitError> {
        let curve = self.geometry.with(variances)?;
        let mut covariance = Covariance::of_independent(&curve)?;
        let mut growth = None;
        for _ in 0..2 {
            let best = System::new(&curve, &covariance, &self.basis).best(&self.candidates);
            let (of_best, model) = self.model(&best.terms, growth)?;
            (growth, covariance) = (Some(of_best), model);
        }
        self.fit_with(&curve, &covariance, Errors::OfModel, growth, &[])
    }

    /// The covariance of the curve if it were that of the process of a fit.
    pub(crate) fn covariance(&self, fit: &Fit) -> Result<Covariance, FitError> {
        self.model(&self.complete(&found(fit)), None).map(|(_, covariance)| covariance)
    }

    /// The least χ² of the curve with a covariance.
    pub(crate) fn least_chi_squared(&self, covariance: &Covariance) -> f64 {
        System::new(&self.geometry, covariance, &self.basis).best(&self.candidates).chi_squared
    }

    fn fit_with(
        &self,
        curve: &Curve,
        covariance: &Covariance,
        errors: Errors,
        growth: Option<Arc<Growth>>,
        realizations: &[Vec<f64>],
    ) -> Result<Fit, FitError> {
        let system = System::new(curve, covariance, &self.basis);
        let Choice { best, replaceable, others } = match self.terms {
            Terms::Given(_) => Choice::given(&system, &self.candidates),
            Terms::Auto(_) => Choice::auto(&system, &self.candidates),
        };
        let growth = (errors == Errors::OfModel).then(|| self.growth(&self.complete(&best.terms), growth));
        let judge = |solution: &Solution| {
            Judge::new(&system, &solution.terms, growth.as_deref(), &replaceable, realizations)
        };
        let mut fit = judge(&best).fit(&self.candidates)?;
        for other in &others {
            judge(other).widen(&mut fit);
        }
        Ok(fit)
    }

    /// All candidates as in `found`, or with a square of 0 and the shortest shape.
    fn complete(&self, found: &[Fitted]) -> Vec<Fitted> {
        let of = |&term: &Term| {
            let absent = Fitted { term, square: 0.0, shape: self.basis.of(term)[0].0 };
            found.iter().find(|fitted| fitted.term == term).copied().unwrap_or(absent)
        };
        self.candidates.iter().map(of).collect()
    }

    /// The growth of all candidates, and the covariance with these squares and shapes.
    fn model(
        &self,
        terms: &[Fitted],
        at_hand: Option<Arc<Growth>>,
    ) -> Result<(Arc<Growth>, Covariance), FitError> {
        let growth = self.growth(terms, at_hand);
        let covariance = growth.covariance(terms)?;
        Ok((growth, covariance))
    }

    /// The growth of all candidates with these shapes, which is `at_hand` if that matches.
    fn growth(&self, terms: &[Fitted], at_hand: Option<Arc<Growth>>) -> Arc<Growth> {
        let new = || Arc::new(Growth::new(&self.geometry, terms));
        if !self.candidates.iter().any(|term| term.has_shape()) {
            return self.growth.get_or_init(new).clone();
        }
        at_hand.filter(|growth| growth.is_of(terms)).unwrap_or_else(new)
    }
}

/// The terms of a fit.
fn found(fit: &Fit) -> Vec<Fitted> {
    let of = |part: &Part| Fitted { term: part.term, square: part.square(), shape: part.shape };
    fit.process.parts.iter().map(of).collect()
}

/// Simulated curves that scatter as those of a record with gaps.
fn with_costs(rows: &[Vec<f64>], curve: &Curve) -> Vec<Vec<f64>> {
    let mut rows = rows.to_vec();
    for (i, cost) in curve.costs().iter().enumerate().filter(|(_, cost)| **cost != 1.0) {
        let mean = rows.iter().filter_map(|row| row.get(i)).sum::<f64>() / rows.len() as f64;
        rows.iter_mut().filter_map(|row| row.get_mut(i)).for_each(|x| *x = mean + (*x - mean) * cost);
    }
    rows
}

/// Simulated curves of Gaussian noise with the deviations that the estimates of their record have in common. Any order of normal
/// quantiles will do, because the rows are in none; that of a golden section leaves no pattern.
fn with_spread(rows: &[Vec<f64>], curve: &Curve) -> Vec<Vec<f64>> {
    let golden = 0.5 * (libm::sqrt(5.0) - 1.0);
    let of_row = |(i, row): (usize, &Vec<f64>)| {
        let place = (i as f64 + 0.5) * golden;
        let normal = normal_quantile(place - libm::floor(place));
        row.iter().zip(curve.ms()).map(|(x, m)| x * (1.0 + curve.spread().at(*m) * normal)).collect()
    };
    rows.iter().enumerate().map(of_row).collect()
}
