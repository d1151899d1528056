//! A Kalman filter that keeps a heading: what it makes of a gyro's record, and the variance that it claims.
//!
//! During the alignment the vehicle is at rest, so that the angle which the gyro counts is all error: the filter reads it
//! after every sample. Its states are the accumulated error, the states of its noise model, and a constant bias of which
//! nothing is known before. From the start on it predicts the error and takes it off the counted angle. Neither gains nor
//! variances depend on the readings, so the error of the heading is a sum of the readings with fixed weights, which one pass
//! through the gains backwards gives.
//!
//! An unknown bias is no state of large variance, which would cost digits, but is estimated beside a filter without it
//! (de Jong, *Annals of Statistics* 19, 1991): with ν(u) the innovations that this filter has for a bias of one, ν(z) those
//! for the readings and S their variances, it is Σ ν(u) ν(z)/S over Σ ν(u)²/S, which is the inverse of its variance.

use crate::allan::markov::Step;
use crate::navigation::Times;

/// The noise model of a filter, in ″ and s.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Model {
    /// White noise N, ″/√s.
    pub white: f64,
    /// Random walk K of the rate, ″/s^1.5.
    pub walk: f64,
    /// Standard deviation, ″/s, and correlation time, s, of each Markov state.
    pub markov: Vec<[f64; 2]>,
    /// Rms error Q of each reading of the angle, ″.
    pub quantization: f64,
}

/// The heading of a filter.
#[derive(Debug, Clone, PartialEq)]
pub struct Filtered {
    /// Weight of each increment of the angle in the error of the heading.
    pub weights: Vec<f64>,
    /// Variance of that error as claimed by the filter, ″².
    pub variance: f64,
}

/// The model over a step.
struct Stepped {
    states: Vec<Step>,
    white: f64,
}

/// A state: the angle, then those of the rate.
type State = Vec<f64>;

impl Model {
    /// Whether it has no noise.
    pub fn is_nothing(&self) -> bool {
        let sizes = [self.white, self.walk, self.quantization];
        sizes.iter().chain(self.markov.iter().map(|[sigma, _]| sigma)).all(|size| *size == 0.0)
    }

    fn over(&self, step_s: f64) -> Stepped {
        let walk = (self.walk > 0.0).then(|| Step::walk(self.walk * self.walk, step_s));
        let markov = self.markov.iter().map(|[sigma, time_s]| Step::markov(sigma * sigma, *time_s, step_s));
        Stepped { states: walk.into_iter().chain(markov).collect(), white: self.white * self.white * step_s }
    }

    /// Variances at the start. The angle counts from the first reading, which has an error too; a random walk starts at 0,
    /// since the bias has the rest.
    fn initial(&self) -> State {
        let walk = (self.walk > 0.0).then_some(0.0);
        let markov = self.markov.iter().map(|[sigma, _]| sigma * sigma);
        [self.quantization * self.quantization].into_iter().chain(walk).chain(markov).collect()
    }
}

impl Stepped {
    /// F x.
    fn ahead(&self, x: &mut State) {
        for (i, step) in (1..).zip(&self.states) {
            x[0] += step.onto_angle * x[i];
            x[i] *= step.own;
        }
    }

    /// Fᵀ λ.
    fn back(&self, adjoint: &mut State) {
        for (i, step) in (1..).zip(&self.states) {
            adjoint[i] = step.onto_angle * adjoint[0] + step.own * adjoint[i];
        }
    }

    /// F P Fᵀ + Q.
    fn spread(&self, p: &mut [State]) {
        p.iter_mut().for_each(|row| self.ahead(row));
        for column in 0..p.len() {
            let mut x: State = p.iter().map(|row| row[column]).collect();
            self.ahead(&mut x);
            p.iter_mut().zip(x).for_each(|(row, x)| row[column] = x);
        }
        p[0][0] += self.white;
        for (i, Step { added: [angle, both, itself], .. }) in (1..).zip(&self.states) {
            p[0][0] += angle;
            p[0][i] += both;
            p[i][0] += both;
            p[i][i] += itself;
        }
    }
}

/// What a reading does: its gains, and the innovation of a bias of one over its variance.
struct Reading {
    gains: State,
    of_bias: f64,
}

/// The heading that a filter with this model keeps. Without an alignment nothing is known of the bias, and the variance is
/// infinite.
pub fn filtered(model: &Model, times: &Times) -> Filtered {
    let Times { sample_s, alignment, duration, .. } = *times;
    let (step, reading) = (model.over(sample_s), model.quantization * model.quantization);
    let initial = model.initial();
    let count = initial.len();
    let mut p: Vec<State> =
        (0..count).map(|i| (0..count).map(|j| if i == j { initial[i] } else { 0.0 }).collect()).collect();
    let (mut bias, mut known) = (vec![0.0; count], 0.0);
    let mut readings = Vec::with_capacity(alignment);
    for k in 1..=alignment {
        step.ahead(&mut bias);
        step.spread(&mut p);
        let variance = p[0][0] + reading;
        let gains: State = p.iter().map(|row| row[0] / variance).collect();
        let innovation = k as f64 * sample_s - bias[0];
        bias.iter_mut().zip(&gains).for_each(|(bias, gain)| *bias += gain * innovation);
        let first = p[0].clone();
        for (row, gain) in p.iter_mut().zip(&gains) {
            row.iter_mut().zip(&first).for_each(|(p, first)| *p -= gain * first);
        }
        known += innovation * innovation / variance;
        readings.push(Reading { gains, of_bias: innovation / variance });
    }
    let ahead = model.over(duration as f64 * sample_s);
    ahead.spread(&mut p);
    ahead.ahead(&mut bias);
    // The angle of a bias of one at the end that the filter without it leaves.
    let left = (alignment + duration) as f64 * sample_s - bias[0];
    let mut adjoint = vec![0.0; count];
    adjoint[0] = 1.0;
    ahead.back(&mut adjoint);
    // Weights of the angles from their sums on: increment k is in all angles after it.
    let mut weights = vec![1.0; alignment + duration];
    let mut sum = 1.0;
    for (weight, Reading { gains, of_bias }) in weights[..alignment].iter_mut().zip(&readings).rev() {
        let of_reading: f64 = gains.iter().zip(&adjoint).map(|(gain, adjoint)| gain * adjoint).sum();
        let of_reading = of_reading + left * of_bias / known;
        sum -= of_reading;
        *weight = sum;
        adjoint[0] -= of_reading;
        step.back(&mut adjoint);
    }
    Filtered { weights, variance: p[0][0] + reading + left * left / known }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: Times = Times { sample_s: 2.0, alignment: 12, duration: 7, calibrates: false };

    fn models() -> Vec<Model> {
        let white = Model { white: 0.3, ..Model::default() };
        let markov = vec![[0.02, 9.0], [0.1, 40.0]];
        vec![
            white.clone(),
            Model { walk: 0.01, ..white.clone() },
            Model { quantization: 0.5, ..white.clone() },
            Model { white: 0.3, walk: 0.01, markov, quantization: 0.2 },
            Model { white: 0.0, markov: vec![[0.1, 30.0]], ..Model::default() },
        ]
    }

    /// Covariances of the increments, by definition.
    fn increments(model: &Model, count: usize) -> Vec<Vec<f64>> {
        let d = TIMES.sample_s;
        let of = |i: usize, j: usize| {
            let (near, lag) = (i.min(j) as f64, i.abs_diff(j));
            let same = |of_same: f64, of_other: f64| if lag == 0 { of_same } else { of_other };
            let walk = model.walk * model.walk * d * d * d * same(near + 1.0 / 3.0, near + 0.5);
            let markov = model.markov.iter().map(|[sigma, t]| {
                let z = d / t;
                let square = sigma * sigma * t * t;
                let apart = libm::expm1(z) * -libm::expm1(-z) * libm::exp(-z * lag as f64);
                square * same(2.0 * (z + libm::expm1(-z)), apart)
            });
            let square = model.quantization * model.quantization;
            let quantized = same(2.0 * square, if lag == 1 { -square } else { 0.0 });
            same(model.white * model.white * d, 0.0) + walk + markov.sum::<f64>() + quantized
        };
        (0..count).map(|i| (0..count).map(|j| of(i, j)).collect()).collect()
    }

    /// The solutions x of A x = b for some b, by elimination.
    fn solved(mut a: Vec<Vec<f64>>, mut b: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        for i in 0..a.len() {
            let (row, rest) = a[i..].split_first_mut().unwrap();
            for (below, under) in rest.iter_mut().zip(i + 1..) {
                let factor = below[i] / row[i];
                below.iter_mut().zip(row.iter()).for_each(|(below, x)| *below -= factor * x);
                b.iter_mut().for_each(|b| b[under] -= factor * b[i]);
            }
        }
        for i in (0..a.len()).rev() {
            for b in &mut b {
                let known: f64 = (i + 1..a.len()).map(|j| a[i][j] * b[j]).sum();
                b[i] = (b[i] - known) / a[i][i];
            }
        }
        b
    }

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn the_filter_is_the_best_linear_unbiased_prediction() {
        let (n, all) = (TIMES.alignment, TIMES.alignment + TIMES.duration);
        for model in models() {
            let c = increments(&model, all);
            let seen: Vec<Vec<f64>> = c[..n].iter().map(|row| row[..n].to_vec()).collect();
            let ahead: Vec<f64> = c[..n].iter().map(|row| row[n..].iter().sum()).collect();
            let ones = vec![1.0; n];
            let [of_ahead, of_ones] =
                <[_; 2]>::try_from(solved(seen, vec![ahead.clone(), ones.clone()])).unwrap();
            let share = (TIMES.duration as f64 - dot(&ones, &of_ahead)) / dot(&ones, &of_ones);
            let found = filtered(&model, &TIMES);
            for k in 0..n {
                let expected = -(of_ahead[k] + share * of_ones[k]);
                assert!(
                    (found.weights[k] - expected).abs() < 1e-9,
                    "{model:?}, {k}: {} {expected}",
                    found.weights[k]
                );
            }
            assert!(found.weights[n..].iter().all(|weight| *weight == 1.0));
            assert!(found.weights.iter().sum::<f64>().abs() < 1e-9);
            let claimed: f64 = (0..all).map(|i| found.weights[i] * dot(&c[i], &found.weights)).sum();
            assert!((found.variance / claimed - 1.0).abs() < 1e-9, "{model:?}: {} {claimed}", found.variance);
        }
    }

    #[test]
    fn a_constant_bias_in_white_noise_is_calibrated_by_its_mean() {
        let found = filtered(&Model { white: 0.3, ..Model::default() }, &TIMES);
        let (n, d) = (TIMES.alignment as f64, TIMES.duration as f64);
        assert!(found.weights[..TIMES.alignment].iter().all(|weight| (weight + d / n).abs() < 1e-12));
        let variance = 0.09 * TIMES.sample_s * (d + d * d / n);
        assert!((found.variance / variance - 1.0).abs() < 1e-12);
    }
}
