//! The model as a linear system at the rate of a filter, in SI units.
//!
//! The states are the angle that the noise accumulates (the velocity of an accelerometer), the random walk of the rate, and the Markov
//! states. The rate error is the sum of all but the first; white noise drives the angle. With a = e^{−Δ/T}, z = Δ/T the exact
//! transition over a step Δ and the covariance Q of what it adds are, for a Markov state of variance σ²,
//!
//! ```text
//! F = [1  T(1 − a)]      Q = σ² [2T²(z − 2(1 − a) + (1 − a²)/2)   T(1 − a)²]
//!     [0      a   ]             [            T(1 − a)²             1 − a²  ]
//! ```
//!
//! for the random walk F = [1 Δ; 0 1] and Q = K² [Δ³/3 Δ²/2; Δ²/2 Δ], and N²Δ for the angle.

use crate::analysis::model::Model;
use sagnac_base::quantity::expression::STANDARD_GRAVITY;
use sagnac_records::allan::Unit;
use sagnac_theory::allan::markov::Step;
use serde::Serialize;

/// Size of the unit of a model in SI: of ″ in rad, or of µg in m/s².
pub(crate) fn si(unit: Unit) -> f64 {
    match unit {
        Unit::Acceleration => STANDARD_GRAVITY * 1e-6,
        Unit::Angular | Unit::Plain => core::f64::consts::PI / 648_000.0,
    }
}

/// A model at the rate of a filter. Angles are in rad, rates in rad/s; of accelerometers velocities in m/s and accelerations in m/s².
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct Discrete {
    /// Step Δ, s.
    pub step_s: f64,
    /// Names of the states.
    #[serde(rename = "states")]
    pub names: Vec<String>,
    /// Transition matrix F, row by row.
    #[serde(rename = "F")]
    pub transition: Vec<Vec<f64>>,
    /// Covariance Q of what a step adds.
    #[serde(rename = "Q")]
    pub added: Vec<Vec<f64>>,
    /// Variance R of a reading of the angle: Q² of the quantization; 0 without it.
    #[serde(rename = "R")]
    pub reading: f64,
    /// Variance of a rate sample over the step: N²/Δ.
    #[serde(rename = "rate_variance")]
    pub rate: f64,
    /// Stationary variance of each state; absent of those that have none.
    #[serde(rename = "stationary_variance")]
    pub stationary: Vec<Option<f64>>,
    /// Variance of each state at the start: 0 for the angle, the stationary one of Markov states, and of the random walk what it
    /// accumulates over the longest τ. The turn-on bias is not part of it.
    #[serde(rename = "initial_variance")]
    pub initial: Vec<f64>,
}

/// The model of sensors with this unit at steps of Δ, up to the longest τ.
pub fn discrete(model: &Model, unit: Unit, step_s: f64, longest_s: f64) -> Discrete {
    let size = si(unit);
    let square = |x: f64| size * size * x * x;
    let angle = if unit == Unit::Acceleration { "velocity" } else { "angle" };
    let walks = model.walk > 0.0;
    let count = 1 + usize::from(walks) + model.markov.len();
    let mut found = Discrete {
        step_s,
        names: vec![angle.to_owned()],
        transition: vec![vec![0.0; count]; count],
        added: vec![vec![0.0; count]; count],
        reading: square(model.quantization),
        rate: square(model.white) / step_s,
        stationary: vec![None],
        initial: vec![0.0],
    };
    found.transition[0][0] = 1.0;
    found.added[0][0] = square(model.white) * step_s;
    if walks {
        let k = square(model.walk);
        found.join("walk".to_owned(), Step::walk(k, step_s));
        found.stationary.push(None);
        found.initial.push(k * longest_s);
    }
    for (state, number) in model.markov.iter().zip(1..) {
        let variance = square(state.sigma);
        found.join(format!("markov_{number}"), Step::markov(variance, state.time_s, step_s));
        found.stationary.push(Some(variance));
        found.initial.push(variance);
    }
    found
}

impl Discrete {
    /// Joins a state of the rate: its column of F, and its share of Q for the angle, for both and for itself.
    fn join(&mut self, name: String, Step { onto_angle, own, added: [angle, both, itself] }: Step) {
        let place = self.names.len();
        self.names.push(name);
        self.transition[0][place] = onto_angle;
        self.transition[place][place] = own;
        self.added[0][0] += angle;
        self.added[0][place] = both;
        self.added[place][0] = both;
        self.added[place][place] = itself;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::model::Markov;

    /// Q by the sum of many short steps, each F Q Fᵀ + Q.
    fn by_steps(model: &Model, step_s: f64, parts: u32) -> Vec<Vec<f64>> {
        let short = discrete(model, Unit::Angular, step_s / f64::from(parts), 1.0);
        let count = short.names.len();
        let (f, q) = (&short.transition, &short.added);
        let mut sum = vec![vec![0.0; count]; count];
        for _ in 0..parts {
            let once = |i: usize, j: usize| -> f64 {
                let product: f64 =
                    (0..count).map(|k| (0..count).map(|l| f[i][k] * sum[k][l] * f[j][l]).sum::<f64>()).sum();
                product + q[i][j]
            };
            sum = (0..count).map(|i| (0..count).map(|j| once(i, j)).collect()).collect();
        }
        sum
    }

    #[test]
    fn a_long_step_is_many_short_ones() {
        let markov = vec![Markov { sigma: 0.3, time_s: 0.7 }, Markov { sigma: 2.0, time_s: 900.0 }];
        let model = Model { white: 0.1, walk: 0.02, markov, quantization: 0.5 };
        for step_s in [0.01, 1.0, 40.0] {
            let whole = discrete(&model, Unit::Angular, step_s, 1.0);
            let summed = by_steps(&model, step_s, 64);
            for (i, row) in summed.iter().enumerate() {
                for (j, expected) in row.iter().enumerate() {
                    let found = whole.added[i][j];
                    assert!(
                        (found - expected).abs() <= 1e-9 * expected.abs(),
                        "Δ = {step_s}, {i} {j}: {found}, not {expected}"
                    );
                }
            }
            assert!((whole.reading / (si(Unit::Angular) * 0.5).powi(2) - 1.0).abs() < 1e-12);
        }
    }
}
