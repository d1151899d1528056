//! The expected estimates from the physical inputs: theory that shares no computation with the kernel.
//!
//! Random parts add by the closed forms of their terms. The differences of what all records share are a sum of
//! G(k)·e^{−λk} over ramp, warm-ups and the alternating drift, where G has the period of two intervals between switches:
//! the mean of their square is a geometric sum for each residue of k.

use crate::kinds::allan::point::Point;
use sagnac_theory::allan::estimator::Estimator;
use sagnac_theory::allan::exponential::mean_of_decay;
use sagnac_theory::allan::process::Process;
use sagnac_theory::allan::quantizer;
use sagnac_theory::allan::switching::{Jumps, Switching};

/// Most residues that are summed; beyond them there is no closed form.
const MAX_RESIDUES: u64 = 1 << 20;
/// Error of the sum over what all records share, in floating point, of the sum of the squares of its parts.
const SUM_ERROR: f64 = 1e-12;

/// The physical theory of records.
#[derive(Debug, Clone)]
pub(crate) struct PhysicalTheory {
    pub(crate) process: Process,
    /// Angle of a pulse, ″; 0 where the readout is not quantized.
    pub(crate) readout_lsb: f64,
    /// Constant rate, ″/s.
    pub(crate) mean_rate: f64,
    pub(crate) switching: Option<Switching>,
    /// Samples of a record.
    pub(crate) samples: u64,
    pub(crate) estimator: Estimator,
}

/// A variance with its bound of error, (″/s)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Variance {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// A part of the differences of what all records share, G(k)·e^{−λk}, ″.
struct Shared<'a> {
    /// λ, per sample.
    decay: f64,
    /// G of a residue.
    periodic: Box<dyn Fn(u64) -> f64 + 'a>,
}

impl PhysicalTheory {
    /// The theory of the records of a point.
    pub(crate) fn of(point: &Point, estimator: Estimator) -> PhysicalTheory {
        let inputs = &point.inputs;
        PhysicalTheory {
            process: inputs.noise.process(inputs.sample_s, inputs.samples()),
            readout_lsb: inputs.noise.readout_lsb,
            mean_rate: inputs.rate,
            switching: inputs.noise.switched(inputs.sample_s),
            samples: inputs.samples(),
            estimator,
        }
    }

    /// The expected estimate at an averaging factor; `None` where it has no closed form: of whole pulses under flicker,
    /// random walk, drift or switches.
    pub(crate) fn variance(&self, m: u64) -> Option<Variance> {
        let PhysicalTheory { process, samples, estimator, .. } = self;
        let difference = estimator.difference;
        let [shared, error] = self.shared(m)?;
        let mut sum = process.variance(difference, m) + shared;
        if let Some(Switching { interval, residual, residual_noise, .. }) = self.switching {
            let variance = 0.5 * residual * residual + residual_noise * residual_noise;
            sum += Jumps { interval, variance }.mean_square(*estimator, *samples, m);
        }
        if self.readout_lsb > 0.0 {
            if self.switching.is_some() {
                return None;
            }
            sum += quantizer::mean_square(self.readout_lsb, self.mean_rate, process, difference, m)?;
        }
        let tau = process.sample_s * m as f64;
        let unit = 1.0 / (difference.divisor() * tau * tau);
        Some(Variance { value: sum * unit, error: error * unit })
    }

    /// Mean square of the differences of what all records share, and its error, ″².
    fn shared(&self, m: u64) -> Option<[f64; 2]> {
        let (terms, stride) = (self.estimator.terms(self.samples, m), self.estimator.stride(m));
        if terms == 0 {
            return None;
        }
        let trends = self.process.parts.iter().filter_map(|part| {
            let trend = part.trend(self.estimator.difference, self.process.sample_s, m)?;
            Some(Shared { decay: trend.decay, periodic: Box::new(move |_| trend.first) })
        });
        let mut parts: Vec<Shared> = trends.collect();
        let mut period = 1;
        if let Some(switching) = self.switching.filter(Switching::drifts) {
            period = 2 * switching.interval;
            parts.extend(self.alternating(switching, m));
        }
        if parts.is_empty() {
            return Some([0.0; 2]);
        }
        let residues = period / common_divisor(period, stride);
        let summed = residues.min(terms);
        if summed > MAX_RESIDUES {
            return None;
        }
        // The residues of as many differences, and the rest of one less.
        let counts = [terms.div_ceil(residues), terms / residues];
        let step = (stride * residues) as f64;
        let sum_of_decay = |a: &Shared, b: &Shared| {
            counts.map(|count| match count {
                0 => 0.0,
                count => count as f64 * mean_of_decay(a.decay + b.decay, step, count),
            })
        };
        let sums: Vec<Vec<[f64; 2]>> =
            parts.iter().map(|a| parts.iter().map(|b| sum_of_decay(a, b)).collect()).collect();
        let [mut mean, mut squares] = [0.0; 2];
        for place in 0..summed {
            let k = place * stride;
            let which = usize::from(place >= terms - counts[1] * residues);
            let value = |part: &Shared| (part.periodic)(k % period) * libm::exp(-part.decay * k as f64);
            let values: Vec<f64> = parts.iter().map(value).collect();
            for (a, row) in values.iter().zip(&sums) {
                for (b, sum) in values.iter().zip(row) {
                    mean += a * b * sum[which];
                    squares += (a * b * sum[which]).abs();
                }
            }
        }
        Some([mean / terms as f64, SUM_ERROR * squares / terms as f64])
    }

    /// The differences of the alternating drift: with w whole intervals before k and r samples since then, its angle is
    /// (A + Ω_m0) times the distance in time from the nearest even switch, minus, up to a constant,
    /// Aτ(−1)^w e^{−λk}(2e^{−λ(M − r)}/(1 + e^{−λM}) − 1).
    fn alternating(&self, switching: Switching, m: u64) -> [Shared<'_>; 2] {
        let Switching { interval, magnetic, .. } = switching;
        let (t0, coefficients) = (self.process.sample_s, self.estimator.difference.coefficients());
        let decay = t0 / magnetic.time_s;
        let difference = move |angle: &dyn Fn(u64, f64) -> f64, k: u64| -> f64 {
            let places = (0..).map(|span| span * m).zip(coefficients);
            places.map(|(after, c)| c * angle((k + after) % (2 * interval), after as f64)).sum()
        };
        let linear = move |place: u64, _: f64| {
            (magnetic.amplitude + magnetic.initial) * t0 * place.min(2 * interval - place) as f64
        };
        let decaying = move |place: u64, after: f64| {
            let (sign, rest) = if place < interval { (1.0, place) } else { (-1.0, place - interval) };
            let ahead = libm::exp(-decay * (interval - rest) as f64);
            let shape = 2.0 * ahead / (1.0 + libm::exp(-decay * interval as f64)) - 1.0;
            -magnetic.amplitude * magnetic.time_s * sign * libm::exp(-decay * after) * shape
        };
        [
            Shared { decay: 0.0, periodic: Box::new(move |k| difference(&linear, k)) },
            Shared { decay, periodic: Box::new(move |k| difference(&decaying, k)) },
        ]
    }
}

fn common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}
