//! The rms of the errors of a navigator from the physical inputs: theory that shares no computation with the kernel but
//! the weights before they are rounded, which tests compare with an independent simulation.

use core::f64::consts::PI;

use crate::kinds::navigation::Navigation;
use crate::kinds::navigation::lower::drawn;
use crate::kinds::navigation::point::Point;
use crate::noise::Noise;
use sagnac_theory::allan::holds;
use sagnac_theory::allan::part::FLAT_LEVEL;
use sagnac_theory::allan::terms::Term;
use sagnac_theory::drift::magnetic::Magnetic;
use sagnac_theory::navigation::covariance;
use sagnac_theory::navigation::weights::Weights;

/// The physical theory of a point.
pub(crate) struct PhysicalTheory {
    /// The weights of each gyro, per ″.
    weights: Vec<Weights>,
    /// The noise of each set of coefficients.
    sets: Vec<Set>,
}

/// The noise of a set of coefficients, in ″ and samples.
struct Set {
    random: covariance::Noise,
    /// The increments that all records share.
    shared: Vec<f64>,
}

impl PhysicalTheory {
    /// The theory of a point of a study with this seed.
    pub(crate) fn new(point: &Point, study: &Navigation, seed: u64) -> PhysicalTheory {
        let (sample_s, samples) = (point.inputs.sample(), point.inputs.samples());
        let set = |set| {
            let noise = drawn(point, study, seed, set);
            Set { random: random(&noise, sample_s, samples), shared: shared(&noise, sample_s, samples) }
        };
        PhysicalTheory { weights: point.inputs.weights(), sets: (0..study.draws).map(set).collect() }
    }

    /// The rms of some errors together over all sets, in their unit.
    pub(crate) fn rms(&self, errors: &[usize]) -> f64 {
        let of_set = |set: &Set| -> f64 {
            let of_error = |&error: &usize| {
                let (mut mean, mut variance) = (0.0, 0.0);
                for gyro in &self.weights {
                    let weights = &gyro.of_errors[error];
                    mean += set.shared.iter().zip(weights).map(|(step, weight)| step * weight).sum::<f64>();
                    variance += set.random.covariance(weights, weights);
                }
                mean * mean + variance
            };
            errors.iter().map(of_error).sum()
        };
        libm::sqrt(self.sets.iter().map(of_set).sum::<f64>() / self.sets.len() as f64)
    }
}

/// The random parts.
fn random(noise: &Noise, t0: f64, samples: u64) -> covariance::Noise {
    let root = libm::sqrt(t0);
    let [b, _] = noise.of(Term::BiasInstability);
    let variances = holds::octaves(samples).and_then(holds::variances).filter(|_| b != 0.0);
    let octave = |v: f64| b * t0 * libm::sqrt(FLAT_LEVEL * v);
    let shaped = |term: Term| Some(noise.of(term)).filter(|[size, _]| *size != 0.0);
    let switching = noise.switched(t0);
    covariance::Noise {
        errors: noise.of(Term::Quantization)[0],
        white: noise.of(Term::AngleRandomWalk)[0] * root,
        octaves: variances.into_iter().flatten().map(octave).collect(),
        walk: noise.of(Term::RateRandomWalk)[0] * t0 * root,
        markov: shaped(Term::Markov).map(|[sigma, time_s]| [sigma * t0, t0 / time_s]),
        sine: shaped(Term::Sine).map(|[rate, hz]| [rate / (2.0 * PI * hz), hz * t0]),
        jumps: switching.map(|one| {
            let variance = 0.5 * one.residual * one.residual + one.residual_noise * one.residual_noise;
            (one.interval as usize, variance)
        }),
    }
}

/// The increments that all records share, ″: each an integral of the rate over a sample.
fn shared(noise: &Noise, t0: f64, samples: u64) -> Vec<f64> {
    let [ramp, _] = noise.of(Term::RateRamp);
    let [warm_up, time_s] = noise.of(Term::WarmUp);
    let switching = noise.switched(t0);
    // ∫ e^{−t/T} dt over the sample after `start`.
    let decayed = |start: f64, time_s: f64| -time_s * libm::exp(-start / time_s) * libm::expm1(-t0 / time_s);
    let increment = |k: u64| {
        let start = t0 * k as f64;
        let mut sum = ramp * t0 * (start + 0.5 * t0);
        if warm_up != 0.0 {
            sum += warm_up * decayed(start, time_s);
        }
        if let Some(one) = &switching {
            let Magnetic { amplitude, time_s, initial } = one.magnetic;
            let sign = if (k / one.interval).is_multiple_of(2) { 1.0 } else { -1.0 };
            sum += sign * ((amplitude + initial) * t0 - amplitude * decayed(start, time_s));
        }
        sum
    };
    (0..samples).map(increment).collect()
}
