//! wᵀCw: the covariance of two weighted sums of the increments of a noisy angle, for each noise.
//!
//! Increment k, from 0 on, is the difference of the angles k + 1 and k. Each covariance follows from that of the
//! increments, without the matrix C: sums over samples replace it.

use core::f64::consts::PI;

/// The noise of a record, with angles in any unit and times in samples; 0 and `None` stand for nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Noise {
    /// Standard deviation of independent errors of all angles.
    pub errors: f64,
    /// Standard deviation of independent increments.
    pub white: f64,
    /// Standard deviations of rates that are held for 1, 2, 4, … samples on a grid with a random position.
    pub octaves: Vec<f64>,
    /// Standard deviation of the steps of a random walk of the rate, which starts with one step before the first sample.
    pub walk: f64,
    /// Stationary standard deviation of a Markov rate, and its decay per sample.
    pub markov: Option<[f64; 2]>,
    /// Amplitude of a sine of the angle, and its turns per sample; its phase is random.
    pub sine: Option<[f64; 2]>,
    /// Jumps of the angle after every so many samples, and their variance.
    pub jumps: Option<(usize, f64)>,
}

impl Noise {
    /// Covariance of the sums with the weights `a` and `b`.
    pub fn covariance(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut sum = self.errors * self.errors * dot(&of_angles(a), &of_angles(b));
        sum += self.white * self.white * dot(a, b);
        let held = self.octaves.iter().enumerate().filter(|(_, sigma)| **sigma != 0.0);
        if held.clone().next().is_some() {
            let (a, b) = (sums_before(a), sums_before(b));
            for (octave, sigma) in held {
                sum += sigma * sigma * of_holds(&a, &b, octave);
            }
        }
        if self.walk != 0.0 {
            sum += self.walk * self.walk * dot(&from_here_on(a), &from_here_on(b));
        }
        if let Some([sigma, decay]) = self.markov {
            sum += sigma * sigma * of_markov(a, b, libm::exp(-decay));
        }
        if let Some([amplitude, turns]) = self.sine {
            sum += 0.5 * amplitude * amplitude * of_sine(a, b, turns);
        }
        if let Some((interval, variance)) = self.jumps {
            // The jump after a sample is in the increment that follows.
            let jumps = (interval..a.len()).step_by(interval).map(|at| a[at] * b[at]);
            sum += variance * jumps.sum::<f64>();
        }
        sum
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The weights of the angles of increments with these weights, one more.
pub fn of_angles(weights: &[f64]) -> Vec<f64> {
    let at = |k: usize| weights.get(k).copied().unwrap_or(0.0);
    let before = |k: usize| k.checked_sub(1).map_or(0.0, at);
    (0..=weights.len()).map(|k| before(k) - at(k)).collect()
}

/// Sums of the weights from each sample on: the response to a step of the rate there.
fn from_here_on(weights: &[f64]) -> Vec<f64> {
    let mut sums = weights.to_vec();
    for k in (1..sums.len()).rev() {
        sums[k - 1] += sums[k];
    }
    sums
}

/// Sums of the weights before each sample, and of all.
fn sums_before(weights: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; weights.len() + 1];
    for (k, weight) in weights.iter().enumerate() {
        sums[k + 1] = sums[k] + weight;
    }
    sums
}

/// Σ_p S_a(p) S_b(p)/L over all places p of a window of L = 2^octave samples, with S the sum of the weights in it, from the
/// sums of the weights before each sample.
fn of_holds(a: &[f64], b: &[f64], octave: usize) -> f64 {
    let (samples, length) = (a.len() - 1, 1_usize << octave);
    // A window longer than the record overlaps it as one of its length does, and holds all of it more often.
    let overlap = length.min(samples);
    let mut sum = (length - overlap) as f64 * (a[samples] - a[0]) * (b[samples] - b[0]);
    // Windows that begin before the record, lie in it, and end after it.
    for (a_to, b_to) in a[1..overlap].iter().zip(&b[1..overlap]) {
        sum += (a_to - a[0]) * (b_to - b[0]);
    }
    for ((a_from, a_to), (b_from, b_to)) in a.iter().zip(&a[overlap..]).zip(b.iter().zip(&b[overlap..])) {
        sum += (a_to - a_from) * (b_to - b_from);
    }
    for (a_from, b_from) in a[samples - overlap + 1..samples].iter().zip(&b[samples - overlap + 1..samples]) {
        sum += (a[samples] - a_from) * (b[samples] - b_from);
    }
    sum / length as f64
}

/// Σ a_k b_l r^|k − l|.
fn of_markov(a: &[f64], b: &[f64], r: f64) -> f64 {
    let (mut before_a, mut before_b, mut sum) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        sum += a * b + a * before_b + b * before_a;
        before_a = r * (before_a + a);
        before_b = r * (before_b + b);
    }
    sum
}

/// The real part of Ã·B̃*, transforms of the weights of the angles at the frequency of the sine.
fn of_sine(a: &[f64], b: &[f64], turns: f64) -> f64 {
    let turns = turns - libm::floor(turns);
    let transform = |weights: &[f64]| {
        let mut sums = [0.0; 2];
        for (k, weight) in of_angles(weights).iter().enumerate() {
            let phase = k as f64 * turns;
            let phase = 2.0 * PI * (phase - libm::floor(phase));
            sums[0] += weight * libm::cos(phase);
            sums[1] += weight * libm::sin(phase);
        }
        sums
    };
    let ([ar, ai], [br, bi]) = (transform(a), transform(b));
    ar * br + ai * bi
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLES: usize = 23;

    fn two() -> [Vec<f64>; 2] {
        let of = |from: f64| (0..SAMPLES).map(|k| libm::sin(from + 0.37 * k as f64) + 0.2).collect();
        [of(0.3), of(1.9)]
    }

    /// ΣΣ a_k C_kl b_l.
    fn by_definition(covariance: impl Fn(usize, usize) -> f64) -> f64 {
        let [a, b] = two();
        let row = |k: usize| b.iter().enumerate().map(|(l, b)| covariance(k, l) * b).sum::<f64>();
        a.iter().enumerate().map(|(k, a)| a * row(k)).sum()
    }

    fn check(noise: &Noise, covariance: impl Fn(usize, usize) -> f64) {
        let [a, b] = two();
        let (found, expected) = (noise.covariance(&a, &b), by_definition(covariance));
        assert!(
            (found - expected).abs() < 1e-12 * expected.abs().max(1.0),
            "{noise:?}: {found}, not {expected}"
        );
    }

    #[test]
    fn covariances_are_those_of_the_whole_matrix() {
        let nothing = Noise::default();
        check(&Noise { white: 3.0, ..nothing.clone() }, |k, l| if k == l { 9.0 } else { 0.0 });
        check(&Noise { errors: 2.0, ..nothing.clone() }, |k, l| match k.abs_diff(l) {
            0 => 8.0,
            1 => -4.0,
            _ => 0.0,
        });
        check(&Noise { walk: 0.5, ..nothing.clone() }, |k, l| 0.25 * (k.min(l) + 1) as f64);
        for octave in 0..8 {
            let mut octaves = vec![0.0; octave + 1];
            octaves[octave] = 1.5;
            let length = f64::from(1 << octave);
            check(&Noise { octaves, ..nothing.clone() }, |k, l| {
                2.25 * libm::fmax(0.0, 1.0 - k.abs_diff(l) as f64 / length)
            });
        }
        check(&Noise { markov: Some([2.0, 0.3]), ..nothing.clone() }, |k, l| {
            4.0 * libm::exp(-0.3 * k.abs_diff(l) as f64)
        });
        // Increments of A cos(φ + k δ) with a random φ.
        let turns = 0.13;
        let angle = |lag: f64| libm::cos(2.0 * PI * turns * lag);
        check(&Noise { sine: Some([2.0, turns]), ..nothing.clone() }, |k, l| {
            let lag = k as f64 - l as f64;
            2.0 * (2.0 * angle(lag) - angle(lag + 1.0) - angle(lag - 1.0))
        });
        check(&Noise { jumps: Some((5, 7.0)), ..nothing }, |k, l| {
            if k == l && k > 0 && k % 5 == 0 { 7.0 } else { 0.0 }
        });
    }
}
