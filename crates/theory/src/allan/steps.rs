//! The exact step of a random walk and of a Markov state of the rate, with the angle that they accumulate.

use crate::allan::exponential::beyond_square;

/// A state of the rate over a step Δ beside the angle: F = [1 `onto_angle`; 0 `own`], and what Q adds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The angle that a state of one accumulates over the step.
    pub onto_angle: f64,
    /// The part of the state that remains after the step.
    pub own: f64,
    /// Variance that the step adds to the angle, covariance of both, and variance that it adds to the state.
    pub added: [f64; 3],
}

impl Step {
    /// A random walk of the rate with the square K² of its coefficient.
    pub fn walk(k: f64, d: f64) -> Step {
        Step { onto_angle: d, own: 1.0, added: [k * d * d * d / 3.0, k * d * d / 2.0, k * d] }
    }

    /// A Markov state with a variance and a correlation time.
    pub fn markov(variance: f64, t: f64, d: f64) -> Step {
        let z = d / t;
        let (a, less) = (libm::exp(-z), -libm::expm1(-z));
        // z − 2(1 − a) + (1 − a²)/2, whose powers up to z² cancel.
        let bracket = 2.0 * beyond_square(z) - 0.5 * beyond_square(2.0 * z);
        let added = [2.0 * t * t * bracket, t * less * less, -libm::expm1(-2.0 * z)];
        Step { onto_angle: t * less, own: a, added: added.map(|part| variance * part) }
    }
}
