//! The fit of noise coefficients to an Allan (or Hadamard) curve, with the uncertainty of each.
//!
//! ```
//! use sagnac_records::fit::{Curve, Term, Terms, Verdict, fit_record};
//! use sagnac_theory::allan::{Difference, Estimator, Part, Process};
//!
//! // The curve that a record of 36000 s of a gyro with N = 0.03 ″/√s gives on average.
//! let gyro = Process { sample_s: 1.0, parts: vec![Part::angle_random_walk(0.03)] };
//! let ms: Vec<u64> = (0..14).map(|octave| 1 << octave).collect();
//! let at = |&m: &u64| gyro.expected(Estimator::OVERLAPPING, 36_000, m).unwrap();
//! let variances = ms.iter().map(at).collect();
//! let curve = Curve::new(1.0, 36_000, Difference::Second, ms, variances)?;
//!
//! let fit = fit_record(&curve, &Terms::Auto(Term::MODEL.to_vec()))?;
//! let n = fit.coefficient(Term::AngleRandomWalk).unwrap();
//! assert_eq!(n.verdict, Verdict::Identified);
//! assert!((n.value.unwrap() - 0.03).abs() < 1e-9);
//! assert_ne!(fit.coefficient(Term::BiasInstability).unwrap().verdict, Verdict::Identified);
//! # Ok::<(), sagnac_records::fit::curve::FitError>(())
//! ```
//!
//! **Method.** A curve is a sum of terms, linear in the squares of their coefficients. Each term is the closed form of
//! the *sampled* noise ([`sagnac_theory::allan`]), so short τ cause no bias. The squares are found by non-negative
//! least squares (Lawson and Hanson) with the full covariance between the estimates. The correlation time of Markov
//! noise and the frequency of a sine are found by an outer search (variable projection). Weights come from the
//! covariance of a model ([`Covariance`]) instead of the estimates themselves, because low estimates would then get the
//! largest weights.
//!
//! **Calls.** An analysis of a log calls [`describe`], which chooses the range of τ, fits by [`Fitter::fit_record`] and, with simulated
//! records, again by [`Fitter::fit_realized`]; [`search`] solves for the squares, and [`uncertainty`] gives values and intervals.
//!
//! **Results.** A term has a value only where the 95 % interval of its square does not contain 0; otherwise it has a
//! bound, or the statement that the curve gives none ([`Verdict`]). Intervals hold for the terms of the fit; those of
//! [`Terms::Auto`] cover all [likely](LIKELY) choices of terms.
//!
//! Linear algebra is that of [`sagnac_theory::cholesky`]. Systems have at most nine columns, and loops in fixed order
//! give the same digits on every machine, unlike a library that selects its kernels at run time.

pub mod curve;
pub mod points;
pub mod regression;
pub mod search;
pub mod selection;
mod times;
pub mod uncertainty;

use std::sync::{Arc, OnceLock};

use crate::allan::Unit;
use crate::allan::distributions::normal_quantile;
pub use crate::allan::distributions::survival;
use crate::fit::curve::Growth;
pub use crate::fit::curve::{Covariance, Curve, FitError, curve_of};
pub use crate::fit::search::nnls;
use crate::fit::search::{Basis, Fitted, Solution, System};
use crate::fit::selection::Choice;
pub use crate::fit::selection::{
    Described, Fitting, LIKELY, PENALTY, PENALTY_OF_LIMIT, PENALTY_OF_SHAPE, RIVAL, RankedModel, Terms,
    describe, describe_without_shortest, is_fast, ranking, room_for_correlation, white_beside_correlation,
    with_correlation,
};
use crate::fit::uncertainty::{Evidence, Judge};
pub use sagnac_theory::allan::Term;
use sagnac_theory::allan::{Part, Process, terms};

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
/// ([`PENALTY`]). All subsets are compared with the same covariance, so that a term gains
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
/// # use sagnac_theory::allan::Difference;
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

/// How well a coefficient is determined. A bound is the upper end of the 95 % interval, so it fails in 2.5 % of cases;
/// a tighter one for coefficients that turn out small would invalidate the intervals of the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// The 95 % interval of its square does not contain 0.
    Identified,
    /// The best fit does not contain the term; its coefficient is below this bound.
    AtBoundary {
        /// Upper end of the 95 % interval, in the unit of the term.
        below: f64,
    },
    /// The best fit contains the term, but with an interval that includes 0, or another term would fit as well. Its
    /// coefficient is below this bound. Without a bound, the term resembles the other terms together, has a shape that
    /// the curve does not resolve, or scatters so much from record to record that this one gives no limit.
    NotIdentifiable {
        /// Upper end of the 95 % interval; absent where the curve gives no bound.
        below: Option<f64>,
    },
    /// The fitted terms describe the curve over no range of τ, so their coefficients mean nothing.
    NotDescribed,
}

/// Correlation time, s, or frequency, Hz, with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// Value, in s or Hz.
    pub value: f64,
    /// Standard error, in the same unit.
    pub standard_error: f64,
    /// Lower and upper end of the 95 % interval.
    pub interval: [f64; 2],
}

/// A coefficient, in the unit of its [`Term`]. Value and shape are present only where it is identified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficient {
    /// Term, which determines the unit.
    pub term: Term,
    /// Value, never negative, because the curve shows squares.
    pub value: Option<f64>,
    /// Standard error of the value: that of its square over twice the value.
    pub standard_error: Option<f64>,
    /// Square roots of the ends of the 95 % interval of the square, which is nearly normal. The lower end is 0 where
    /// that of the square is negative; the interval is absent where there is no bound.
    pub interval: Option<[f64; 2]>,
    /// Correlation time of Markov noise, or frequency of a sine.
    pub shape: Option<Shape>,
    /// How well it is determined.
    pub verdict: Verdict,
    /// The estimate behind this result; absent where the term resembles others together, or has no shape.
    pub evidence: Option<Evidence>,
}

impl Coefficient {
    /// The coefficient without its value, and with this verdict.
    pub fn without_value(self, verdict: Verdict) -> Coefficient {
        let interval = match verdict {
            Verdict::AtBoundary { below } | Verdict::NotIdentifiable { below: Some(below) } => {
                Some([0.0, below])
            }
            _ => None,
        };
        Coefficient {
            value: None,
            standard_error: None,
            interval,
            shape: None,
            verdict,
            evidence: None,
            ..self
        }
    }
}

/// A fitted curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Coefficients, one for each term given or tried, in that order.
    pub coefficients: Vec<Coefficient>,
    /// The best fit as a noise model that reproduces the curve, including terms that are not identified.
    pub process: Process,
    /// χ² of the residuals, weighted by the covariance.
    pub chi_squared: f64,
    /// Number of points less the number of fitted parameters.
    pub degrees_of_freedom: usize,
    /// Shortest and longest τ of the fitted points, s.
    pub tau_range: [f64; 2],
}

impl Fit {
    /// The coefficient of a term; `None` where the term was not tried.
    pub fn coefficient(&self, term: Term) -> Option<&Coefficient> {
        self.coefficients.iter().find(|coefficient| coefficient.term == term)
    }

    /// Whether the fitted terms describe the curve; see [`crate::fit::selection`].
    pub fn is_described(&self) -> bool {
        self.coefficients.iter().all(|found| found.verdict != Verdict::NotDescribed)
    }

    /// Time of the filter of the sensor that the record shows, s, as if it were a first-order low-pass: 2L²/N². `None` where the
    /// fit does not describe the curve, or does not identify L and N.
    pub fn filter_s(&self) -> Option<f64> {
        let square = |term: Term| {
            self.coefficient(term)?.value?;
            Some(self.process.parts.iter().find(|part| part.term == term)?.square())
        };
        let limit = square(Term::BandLimit).filter(|_| self.is_described())?;
        Some(2.0 * limit / square(Term::AngleRandomWalk)?)
    }

    /// Probability of residuals at least as large if the model holds; `None` without degrees of freedom.
    ///
    /// It holds for Gaussian estimates; those of one record at long τ are not Gaussian, and their χ² scatters more.
    pub fn p_value(&self) -> Option<f64> {
        (self.degrees_of_freedom > 0).then(|| survival(self.chi_squared, self.degrees_of_freedom))
    }
}

/// A number that a fit determines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Coefficient, in the unit of the [`Term`].
    Coefficient(Term),
    /// The correlation time of Markov noise, s, or the frequency of a sine, Hz.
    Shape(Term),
}

impl Quantity {
    /// The coefficients of some terms, each followed by its time or frequency.
    pub fn all(terms: &[Term]) -> Vec<Quantity> {
        let of_term = |&term: &Term| {
            let shape = term.has_shape().then_some(Quantity::Shape(term));
            [Some(Quantity::Coefficient(term)), shape].into_iter().flatten()
        };
        terms.iter().flat_map(of_term).collect()
    }

    /// The term, with the row of its shape if this is a shape.
    pub fn parts(self) -> (Term, Option<&'static terms::Shape>) {
        match self {
            Quantity::Coefficient(term) => (term, None),
            Quantity::Shape(term) => (term, term.shape()),
        }
    }

    /// Name in tables of coefficients.
    pub fn name(self) -> &'static str {
        let (term, shape) = self.parts();
        shape.map_or(term.symbol(), |shape| shape.symbol)
    }

    /// Name for people, on the data sheet of a sensor whose curves have this unit.
    pub fn title(self, unit: Unit) -> &'static str {
        let (term, shape) = self.parts();
        match (shape, unit) {
            (Some(shape), _) => shape.title,
            (None, Unit::Acceleration) => term.row().title_of_acceleration.unwrap_or(term.row().title),
            (None, Unit::Angular | Unit::Plain) => term.row().title,
        }
    }

    /// Factor from ″ and s, or from µg and s, to the unit of data sheets, that unit in files, and its symbol. Plain numbers
    /// keep their unit, times a power of s.
    pub fn unit(self, unit: Unit) -> (f64, &'static str, &'static str) {
        let (term, shape) = self.parts();
        let (in_files, symbol) = term.row().plain;
        match (shape, unit) {
            (Some(shape), _) => (1.0, shape.unit, shape.unit),
            (None, Unit::Angular) => term.row().unit,
            (None, Unit::Acceleration) => term.row().unit_of_acceleration,
            (None, Unit::Plain) => (1.0, in_files, symbol),
        }
    }

    /// Value and interval of a fitted coefficient or its shape, in ″ and s.
    pub fn of(self, found: &Coefficient) -> (Option<f64>, Option<[f64; 2]>) {
        match self {
            Quantity::Coefficient(_) => (found.value, found.interval),
            Quantity::Shape(_) => {
                (found.shape.map(|shape| shape.value), found.shape.map(|shape| shape.interval))
            }
        }
    }
}
