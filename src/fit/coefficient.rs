//! What is said of a coefficient and of a fit.

use crate::fit::chi_squared::survival;
use crate::fit::evidence::Evidence;
use crate::theory::allan::process::Process;
use crate::theory::allan::terms::Term;

/// How far a coefficient is known. A bound is the upper end of the 95 % interval, so that it fails 2.5 % of the time: a
/// closer one for coefficients that turn out small would spoil the intervals of those that do not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// The 95 % interval of its square does not contain 0.
    Identified,
    /// The best fit has none of it; it is below this.
    AtBoundary {
        /// Upper end of the 95 % interval, in the unit of the term.
        below: f64,
    },
    /// The curve asks for some of it, but not for sure, or another term would do as well: it is below this. Without a
    /// bound it looks like the other terms together, has a shape that the curve does not show, or scatters so much from
    /// record to record that this one says nothing of it.
    NotIdentifiable {
        /// The same; absent where the curve gives no bound.
        below: Option<f64>,
    },
}

/// Correlation time, s, or frequency, Hz, with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// In s or Hz.
    pub value: f64,
    /// In the same unit.
    pub standard_error: f64,
    /// 95 %, lower and upper end.
    pub interval: [f64; 2],
}

/// A coefficient, in the unit of its [`Term`]. Value and shape are there only where it is identified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficient {
    /// Which one; it has the unit.
    pub term: Term,
    /// Not negative: the curve shows squares.
    pub value: Option<f64>,
    /// Of the value: that of its square over twice the value.
    pub standard_error: Option<f64>,
    /// Roots of the 95 % interval of the square, which is the one that is nearly normal; from 0 where that reaches
    /// below, and absent where there is no bound.
    pub interval: Option<[f64; 2]>,
    /// Of Markov noise the time, of a sine the frequency.
    pub shape: Option<Shape>,
    /// How far it is known.
    pub verdict: Verdict,
    /// What is behind all of this; absent where the term looks like others together, or has no shape.
    pub(crate) evidence: Option<Evidence>,
}

/// A fitted curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// One for each term asked for or tried, in that order.
    pub coefficients: Vec<Coefficient>,
    /// The best fit as a noise model, with all it takes to draw the curve: also terms that are not identified.
    pub process: Process,
    /// Residuals in the measure of the covariance.
    pub chi_squared: f64,
    /// Points less the fitted parameters.
    pub degrees_of_freedom: usize,
}

impl Fit {
    /// That of a term; `None` where it was not among those that were tried.
    pub fn coefficient(&self, term: Term) -> Option<&Coefficient> {
        self.coefficients.iter().find(|coefficient| coefficient.term == term)
    }

    /// Probability of residuals as large or larger if the model holds; `None` without degrees of freedom.
    ///
    /// Of Gaussian estimates: those of one record at long τ are not, and their χ² scatters more.
    pub fn p_value(&self) -> Option<f64> {
        (self.degrees_of_freedom > 0).then(|| survival(self.chi_squared, self.degrees_of_freedom))
    }
}
