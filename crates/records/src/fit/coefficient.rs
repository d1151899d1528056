//! The results of a fit and of its coefficients.

use crate::fit::evidence::Evidence;
use crate::fit::survival;
use sagnac_theory::allan::{Process, Term};

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

    /// Whether the fitted terms describe the curve; see [`crate::fit::range`].
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
