//! The Allan variance of sampled noise, in closed form: the theory of the Monte Carlo and the basis of the fit.
//!
//! The angles θ_k, in ″, at the times k·t0, k = 0 … N, are a record of N samples. At the averaging factor m and τ =
//! m·t0 an estimator takes the mean square of differences of angles over 2τ² or 6τ² ([`Difference`], [`Estimator`]).
//! Everything here refers to that sampled record instead of the continuous noise of A(4), from which it differs at
//! small m; see [`continuous_variance`] for the latter. Definitions: IEEE Std 952-2020 and 647-2006, two-sided spectra of the
//! rate.
//!
//! Each [`Part`] of the angle is sampled as follows, where t0 is `sample_s`:
//!
//! | part | sampled as |
//! |---|---|
//! | quantization Q | independent errors of rms Q on all N + 1 angles, θ_0 too |
//! | angle random walk N | independent increments θ_k − θ_{k−1} of variance N²t0 |
//! | bias instability B | rate held over t0, a sum of [octave holds](flicker) |
//! | rate random walk K | r_k = r_{k−1} + K√t0·g_k with independent normal g_k of variance 1, θ_k = θ_{k−1} + r_k·t0 |
//! | Markov noise q_c, T_c | r_k = a·r_{k−1} + σ√(1 − a²)·g_k, a = e^{−t0/T_c}, stationary, σ² = q_c²·T_c/2; θ_k = θ_{k−1} + r_k·t0 |
//! | sine Ω_0, f | rate Ω_0 sin(2πft + φ) of uniform φ, integrated exactly |
//! | rate ramp R | rate R·t; whether integrated exactly or held over t0 is the same in all differences |
//! | warm-up A, T | rate A·e^{−t/T} from t = 0, the start of the record, integrated exactly |
//!
//! A readout that counts whole pulses is not white: see [`pulse`](crate::pulse). A gyro that switches modes adds a sawtooth and
//! jumps: see [`Switching`](crate::drift::Switching). LGV-1 by table 2 of A, 9 hours at 1 Hz:
//!
//! ```
//! use sagnac_theory::allan::gaussian::covariance;
//! use sagnac_theory::allan::{self, Difference, Estimator, Part, Process};
//! use sagnac_theory::drift::Jumps;
//! use sagnac_theory::pulse;
//!
//! let parts = vec![
//!     Part::quantization(0.11),
//!     Part::angle_random_walk(0.00048 * 60.0),
//!     Part::bias_instability(0.00164, 24),
//! ];
//! let gyro = Process { sample_s: 1.0, parts };
//! let at_100_s = gyro.expected(Estimator::OVERLAPPING, 32_400, 100).unwrap();
//! assert!((at_100_s.sqrt() - 0.0036).abs() < 5e-5);
//! let model: f64 = gyro.parts.iter().filter_map(|part| allan::continuous_variance(part, 100.0)).sum();
//! assert!((at_100_s / model - 1.0).abs() < 1e-3);
//!
//! // The uncertainty of one record: the scatter of σ² at 100 s.
//! let scatter = covariance(&gyro, Difference::Second, 32_400, &[100])[0][0].sqrt();
//! assert!((scatter / at_100_s - 0.0474).abs() < 5e-4);
//!
//! // A switch every 40 s that leaves 7.07 ″ is an angle random walk of 0.0186 °/√h.
//! let jumps = Jumps { interval: 40, variance: 50.0 };
//! assert!((jumps.angle_random_walk(1.0) / 60.0 - 0.0186).abs() < 5e-5);
//!
//! // At rest, whole pulses of 0.381 ″ are not white noise of q/√12: at 1 s they lack most of 6 q²/12.
//! let still = Process { sample_s: 1.0, parts: vec![Part::angle_random_walk(0.0288)] };
//! let pulses = pulse::mean_square(0.381, 0.0, &still, Difference::Second, 1).unwrap();
//! assert!(pulses < 0.5 * 0.381 * 0.381);
//! ```
//!
//! [`density`] is the power spectral density of the rate. All densities are **one-sided**: their integral from 0 to half the
//! sampling rate is the variance of the rate. They are twice the two-sided densities of IEEE Std 952, which has N² for white
//! rate. [`continuous_variance`] is the Allan variance of continuous noise, for curves in charts.

pub mod flicker;
pub mod gaussian;
pub mod markov;
pub mod terms;

use core::f64::consts::{LN_2, PI};

use crate::allan::markov::mean_of_decay;
pub use crate::allan::terms::Term;
use crate::allan::terms::{Covariance, Differences, Increment, Kernel, Source};

/// Differences of angles that are m samples apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Difference {
    /// θ_{k+2m} − 2θ_{k+m} + θ_k, whose mean square over 2τ² is the Allan variance.
    Second,
    /// θ_{k+3m} − 3θ_{k+2m} + 3θ_{k+m} − θ_k, whose mean square over 6τ² is the Hadamard variance. It is insensitive to
    /// a ramp.
    Third,
}

impl Difference {
    /// Coefficients of θ_k, θ_{k+m}, ….
    pub fn coefficients(self) -> &'static [f64] {
        match self {
            Difference::Second => &[1.0, -2.0, 1.0],
            Difference::Third => &[-1.0, 3.0, -3.0, 1.0],
        }
    }

    /// Number of times that a difference spans m samples: 2 or 3.
    pub fn spans(self) -> u64 {
        match self {
            Difference::Second => 2,
            Difference::Third => 3,
        }
    }

    /// The factor between the mean square of the differences over τ² and the variance: 2 or 6.
    pub fn divisor(self) -> f64 {
        match self {
            Difference::Second => 2.0,
            Difference::Third => 6.0,
        }
    }
}

/// Distance from one difference to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stride {
    /// Every sample, for the overlapping estimators.
    Sample,
    /// m samples, for the non-overlapping estimators.
    Cluster,
    /// The largest divisor of m that is at most max(1, m/parts), so that the angles of all differences at m are whole
    /// strides apart. From 64 parts on it loses almost nothing compared with the overlapping estimators.
    Part(u64),
}

/// An estimator of a variance at τ = m·t0: the mean square of its differences over `divisor`·τ².
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Estimator {
    /// Order of the differences.
    pub difference: Difference,
    /// Distance between the differences.
    pub stride: Stride,
}

impl Estimator {
    /// The overlapping Allan variance, A(3).
    pub const OVERLAPPING: Estimator = Estimator { difference: Difference::Second, stride: Stride::Sample };
    /// The Allan variance of ⌊N/m⌋ adjacent groups.
    pub const NON_OVERLAPPING: Estimator =
        Estimator { difference: Difference::Second, stride: Stride::Cluster };
    /// The overlapping Hadamard variance.
    pub const HADAMARD: Estimator = Estimator { difference: Difference::Third, stride: Stride::Sample };

    /// Number of samples from one difference to the next at the averaging factor `m`.
    pub fn stride(self, m: u64) -> u64 {
        match self.stride {
            Stride::Sample => 1,
            Stride::Cluster => m,
            Stride::Part(parts) => {
                let most = (m / parts.max(1)).max(1);
                (1..=most).rev().find(|&stride| m.is_multiple_of(stride)).unwrap_or(1)
            }
        }
    }

    /// Number of differences in a record of `samples` rate samples, which has `samples` + 1 angles; 0 where the record
    /// is too short.
    pub fn terms(self, samples: u64, m: u64) -> u64 {
        match samples.checked_sub(self.difference.spans() * m) {
            Some(left) if m > 0 => left / self.stride(m) + 1,
            _ => 0,
        }
    }
}

/// A part of the angle, in ″ and s, sampled as described [above](self).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Term of which this is a part.
    pub term: Term,
    /// Coefficient; IEEE's q_c for Markov noise.
    pub size: f64,
    /// Time, s, or frequency, Hz; 1 for terms without one.
    pub shape: f64,
    /// Number of octaves of holds of flicker, of 1, 2, 4, … samples; 0 for all other terms.
    pub octaves: usize,
}

/// The k-th deterministic difference of a record: `first`·e^{−`decay`·k}, ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    /// Difference at the start, ″.
    pub first: f64,
    /// Decay per sample.
    pub decay: f64,
}

/// Allan variance of a bias instability of 1: 2 ln2/π.
pub const FLAT_LEVEL: f64 = 2.0 * LN_2 / PI;

impl Part {
    /// The part whose first numbers are its size and shape.
    pub const fn new<const N: usize>(term: Term, numbers: [f64; N]) -> Part {
        Part { term, size: numbers[0], shape: numbers[1], octaves: 0 }
    }

    /// Square of the coefficient, as [`Term::part`] takes it.
    pub fn square(&self) -> f64 {
        (self.term.row().square)(self)
    }

    /// Variance of a difference of angles `m` samples apart, ″²; 0 of the deterministic ramp and warm-up, which are a
    /// [`Trend`]. The Allan variance is this over 2τ² (A(3), (4)), the Hadamard variance over 6τ².
    ///
    /// It is exact for the sampled process at any m, for every record that is long enough, and so for the mean of
    /// overlapping and non-overlapping differences alike.
    pub fn variance(&self, difference: Difference, sample_s: f64, m: u64) -> f64 {
        match self.term.row().forms.differences {
            Differences::Random(variance) => variance(self, difference, sample_s, m),
            Differences::Shared(_) => 0.0,
        }
    }

    /// The differences of a ramp or a warm-up; `None` for random parts.
    pub fn trend(&self, difference: Difference, sample_s: f64, m: u64) -> Option<Trend> {
        match self.term.row().forms.differences {
            Differences::Random(_) => None,
            Differences::Shared(trend) => Some(trend(self, difference, sample_s, m)),
        }
    }

    /// The generators of the kernel that make it in a record of `samples` samples.
    pub fn sources(&self, sample_s: f64, samples: u64) -> Vec<Source> {
        (self.term.row().forms.sources)(self, sample_s, samples)
    }

    /// The covariance of its differences, if it is noise whose samples depend on each other.
    pub(crate) fn kernel(&self, sample_s: f64) -> Option<Kernel> {
        match self.term.row().forms.covariance {
            Covariance::Kernel(kernel) => Some(kernel(self, sample_s)),
            Covariance::Meeting(_) | Covariance::Product(_) => None,
        }
    }

    /// The angle over `n` samples.
    pub(crate) fn increment(&self, sample_s: f64, n: u64) -> Increment {
        (self.term.row().forms.increment)(self, sample_s, n)
    }
}

/// sin 2πx without the loss of digits for large x.
pub(crate) fn sine_of_turns(x: f64) -> f64 {
    libm::sin(2.0 * PI * (x - libm::round(x)))
}

/// Independent parts of an angle sampled every `sample_s`.
#[derive(Debug, Clone, PartialEq)]
pub struct Process {
    /// Time t0 from one sample to the next, s.
    pub sample_s: f64,
    /// Parts, of which any kind may occur several times.
    pub parts: Vec<Part>,
}

impl Process {
    /// Variance of a difference at `m` of all random parts, ″².
    pub fn variance(&self, difference: Difference, m: u64) -> f64 {
        self.parts.iter().map(|part| part.variance(difference, self.sample_s, m)).sum()
    }

    /// Expected value of an estimator on a record of `samples` rate samples, (″/s)²; `None` where the estimator has no
    /// difference.
    ///
    /// Variances add. Ramp and warm-up are the same in every record, so their differences are added before they are
    /// squared. For a warm-up the number of differences matters: its mean over the M differences at k = 0, s, 2s, … is
    /// a geometric sum.
    pub fn expected(&self, estimator: Estimator, samples: u64, m: u64) -> Option<f64> {
        let terms = estimator.terms(samples, m);
        if terms == 0 {
            return None;
        }
        let (difference, step) = (estimator.difference, estimator.stride(m) as f64);
        let trends: Vec<Trend> =
            self.parts.iter().filter_map(|part| part.trend(difference, self.sample_s, m)).collect();
        let mut mean_square = self.variance(difference, m);
        for a in &trends {
            for b in &trends {
                mean_square += a.first * b.first * mean_of_decay(a.decay + b.decay, step, terms);
            }
        }
        let tau = self.sample_s * m as f64;
        Some(mean_square / (difference.divisor() * tau * tau))
    }
}

/// One-sided density of the rate of one part at a frequency up to half the sampling rate, (″/s)²/Hz.
///
/// With t0 = `sample_s` and s = sin πft0 it is 8Q²s²/t0 of quantization, 2N² of white rate, B²/πf of flicker, K²t0²/2s²
/// of a random walk of the rate, and that of the sampled exponential correlation for Markov noise. Where ft0 is small,
/// these are 2(2πf)²Q²t0, 2N², B²/πf, 2K²/(2πf)² and 2q_c²T_c²/(1 + (2πfT_c)²). The rates are means over t0, and those
/// of a random walk or of Markov noise are held over it, as [everywhere](self). Flicker alone is that of the continuous
/// noise.
///
/// `None` for a sine, which is a line, and for a ramp and a warm-up, which are no noise.
pub fn density(part: &Part, sample_s: f64, frequency_hz: f64) -> Option<f64> {
    (part.term.row().forms.density)(part, sample_s, frequency_hz)
}

impl Process {
    /// One-sided density of the rate of all parts that have a [`density`]; `None` where no part has one.
    pub fn density(&self, frequency_hz: f64) -> Option<f64> {
        let parts = self.parts.iter().filter_map(|part| density(part, self.sample_s, frequency_hz));
        parts.reduce(|sum, part| sum + part)
    }
}

/// The term of one part at `tau_s`, (″/s)²: 3Q²/τ², N²/τ, (2 ln2/π)B², K²τ/3, R²τ²/2 — A(4). It is (q_cT_c)²/τ·[1 −
/// (T_c/2τ)(3 − 4e^{−τ/T_c} + e^{−2τ/T_c})] for Markov noise, and Ω_0²(sin²πfτ/πfτ)² for a sine.
///
/// `None` for a warm-up, whose Allan variance depends on the length of the record.
pub fn continuous_variance(part: &Part, tau_s: f64) -> Option<f64> {
    (part.term.row().forms.continuous)(part, tau_s)
}

/// Covariance of the mean rates of two blocks of `m` samples that start 0, 1, … `blocks` − 1 blocks apart, (″/s)², up to a
/// constant.
///
/// A random walk of the rate has no covariance, but every sum of its means whose weights add up to 0 has a variance, on
/// which the constant has no effect. Regressions with a constant term consist of such sums. Ramps, warm-ups and sines,
/// which are no Gaussian noise, have 0.
///
/// ```
/// # use sagnac_theory::allan::{Part, block_covariance};
/// assert_eq!(block_covariance(&Part::angle_random_walk(3.0), 0.5, 4, 3), [4.5, 0.0, 0.0]);
/// // The variance of the difference of neighbours is K²τ·2/3 for long blocks.
/// let walk = block_covariance(&Part::rate_random_walk(3.0), 0.5, 1000, 2);
/// assert!((2.0 * (walk[0] - walk[1]) / (9.0 * 500.0 * 2.0 / 3.0) - 1.0).abs() < 1e-5);
/// ```
pub fn block_covariance(part: &Part, sample_s: f64, m: u64, blocks: usize) -> Vec<f64> {
    let (kernel, samples) = (part.kernel(sample_s), m as f64);
    let tau = sample_s * samples;
    let at = |lag: usize| match (&kernel, &part.term.row().forms.covariance) {
        (Some(kernel), _) => -kernel(samples, samples * lag as f64),
        // The product of the coefficients of the angles that both blocks have.
        (None, Covariance::Meeting(met)) => met(part, [2.0, -1.0].get(lag).copied().unwrap_or_default()),
        _ => 0.0,
    };
    (0..blocks).map(|lag| at(lag) / (tau * tau)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::flicker;

    #[test]
    fn terms_are_those_of_the_text_books() {
        // Overlapping: N − 2m + 1 of N samples; non-overlapping: ⌊N/m⌋ − 1; Hadamard: N − 3m + 1.
        let terms = |estimator: Estimator, m| estimator.terms(1000, m);
        assert_eq!([1, 7, 500, 501].map(|m| terms(Estimator::OVERLAPPING, m)), [999, 987, 1, 0]);
        assert_eq!([1, 7, 500, 501].map(|m| terms(Estimator::NON_OVERLAPPING, m)), [999, 141, 1, 0]);
        assert_eq!([1, 7, 333, 334].map(|m| terms(Estimator::HADAMARD, m)), [998, 980, 2, 0]);
        let thinned = Estimator { stride: Stride::Part(64), ..Estimator::OVERLAPPING };
        assert_eq!([1, 127, 128, 200, 1024, 1031, 6400].map(|m| thinned.stride(m)), [1, 1, 2, 2, 16, 1, 100]);
        assert_eq!(thinned.terms(1000, 200), 301);
        assert_eq!(terms(Estimator::OVERLAPPING, 0), 0);
    }

    fn allan(part: Part, sample_s: f64, m: u64) -> f64 {
        let tau = sample_s * m as f64;
        let trend =
            part.trend(Difference::Second, sample_s, m).map_or(0.0, |trend| trend.first * trend.first);
        (part.variance(Difference::Second, sample_s, m) + trend) / (2.0 * tau * tau)
    }

    fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
        assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found}, not {expected}");
    }

    #[test]
    fn each_part_has_its_law() {
        for (t0, m) in [(0.01, 1), (0.01, 37), (2.0, 4), (1.0, 100_000)] {
            let (n, tau) = (m as f64, t0 * m as f64);
            near(allan(Part::quantization(0.3), t0, m), 3.0 * 0.09 / (tau * tau), 1e-13, "Q");
            near(allan(Part::angle_random_walk(0.3), t0, m), 0.09 / tau, 1e-13, "N");
            let walk = 0.09 * tau / 3.0 * (1.0 + 0.5 / (n * n));
            near(allan(Part::rate_random_walk(0.3), t0, m), walk, 1e-13, "K");
            near(allan(Part::rate_ramp(0.3), t0, m), 0.09 * tau * tau / 2.0, 1e-13, "R");
            near(allan(Part::bias_instability(0.3, 24), t0, m), FLAT_LEVEL * 0.09, 0.005, "B");
        }
        assert!(allan(Part::bias_instability(1.0, 3), 1.0, 1).is_nan());
    }

    #[test]
    fn a_sine_is_the_mean_over_its_phase() {
        let (t0, f, amplitude) = (0.02, 1.7, 5.0);
        let part = Part::sine(amplitude, f);
        for difference in [Difference::Second, Difference::Third] {
            for m in [1, 3, 11, 100] {
                let angle = |k: usize, turns: f64| {
                    -amplitude / (2.0 * PI * f)
                        * libm::cos(2.0 * PI * (f * t0 * (k as u64 * m) as f64 + turns))
                };
                let square = |turns: f64| {
                    let value: f64 =
                        difference.coefficients().iter().enumerate().map(|(k, c)| c * angle(k, turns)).sum();
                    value * value
                };
                let mean = (0..16).map(|i| square(f64::from(i) / 16.0)).sum::<f64>() / 16.0;
                near(part.variance(difference, t0, m), mean, 1e-9, "sine");
            }
        }
        // A long τ keeps its digits where fτ is an integer plus one half.
        let long = Part::sine(1.0, 0.5);
        near(allan(long, 1.0, 1_000_001), 1.0 / (PI * PI * 500_000.5 * 500_000.5), 1e-9, "long sine");
    }

    #[test]
    fn a_warm_up_beside_a_ramp_is_its_sum_by_definition() {
        let (t0, samples, r, amplitude, time_s) = (0.5, 400_u64, 1e-3, 2.0, 30.0);
        let process =
            Process { sample_s: t0, parts: vec![Part::rate_ramp(r), Part::warm_up(amplitude, time_s)] };
        let angle = |k: u64| {
            let t = t0 * k as f64;
            0.5 * r * t * t - amplitude * time_s * libm::expm1(-t / time_s)
        };
        let thinned = Estimator { stride: Stride::Part(4), ..Estimator::OVERLAPPING };
        for estimator in [Estimator::OVERLAPPING, Estimator::NON_OVERLAPPING, Estimator::HADAMARD, thinned] {
            for m in [1, 2, 9, 50, 130] {
                let terms = estimator.terms(samples, m);
                let difference = |k: u64| -> f64 {
                    let coefficients = estimator.difference.coefficients().iter().enumerate();
                    coefficients.map(|(i, c)| c * angle(k + i as u64 * m)).sum()
                };
                let squares = (0..terms).map(|i| difference(i * estimator.stride(m)).powi(2));
                let tau = t0 * m as f64;
                let mean = squares.sum::<f64>() / terms as f64 / (estimator.difference.divisor() * tau * tau);
                let found = process.expected(estimator, samples, m).unwrap();
                assert!((found / mean - 1.0).abs() < 1e-7, "{estimator:?}, m = {m}: {found}, not {mean}");
            }
            assert_eq!(process.expected(estimator, samples, 201), None);
        }
    }

    /// Variance of a difference at `m` from the density: ∫ S(f)·(t0²/4s²)·(2 sin πfτ)⁴ df by midpoints.
    fn from_density(part: &Part, t0: f64, m: u64) -> f64 {
        const STEPS: u32 = 400_000;
        let width = 0.5 / t0 / f64::from(STEPS);
        let at = |i: u32| {
            let f = width * (f64::from(i) + 0.5);
            let (one, all) = (libm::sin(PI * f * t0), libm::sin(PI * f * t0 * m as f64));
            let gain = 2.0 * all * all * t0 / one;
            density(part, t0, f).unwrap() * gain * gain
        };
        (0..STEPS).map(at).sum::<f64>() * width
    }

    #[test]
    fn the_integral_of_the_density_is_the_variance_of_differences() {
        let (t0, parts) = (
            0.02,
            [
                Part::quantization(0.3),
                Part::angle_random_walk(0.3),
                Part::rate_random_walk(0.3),
                Part::markov(0.3, 0.1),
            ],
        );
        for part in parts {
            for m in [1, 3, 20] {
                let (found, expected) =
                    (from_density(&part, t0, m), part.variance(Difference::Second, t0, m));
                assert!((found / expected - 1.0).abs() < 1e-8, "{part:?}, m = {m}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn the_density_of_flicker_is_nearly_that_of_its_holds() {
        let (t0, b) = (0.01, 0.7);
        let part = Part::bias_instability(b, flicker::OCTAVES);
        let variances = flicker::variances(flicker::OCTAVES).unwrap();
        let of_holds = |f: f64| -> f64 {
            let one = |(o, v): (usize, &f64)| {
                let length = f64::from(1_u32 << o);
                let ratio = libm::sin(PI * f * length * t0) / libm::sin(PI * f * t0);
                2.0 * t0 * v / length * ratio * ratio
            };
            let sum: f64 = variances.iter().enumerate().map(one).sum();
            crate::allan::FLAT_LEVEL * b * b * sum
        };
        for turns in [1e-4, 1.3e-3, 0.01, 0.013, 0.017, 0.03, 0.07, 0.09, 0.1] {
            let (found, holds) = (density(&part, t0, turns / t0).unwrap(), of_holds(turns / t0));
            assert!((found / holds - 1.0).abs() < 0.14, "f t0 = {turns}: {found}, holds {holds}");
        }
    }

    #[test]
    fn sampled_densities_are_the_continuous_ones_at_low_frequencies() {
        let (t0, f, omega) = (1e-5, 0.3, 0.6 * PI);
        let table = [
            (Part::quantization(0.2), 2.0 * omega * omega * 0.04 * t0),
            (Part::angle_random_walk(0.2), 0.08),
            (Part::bias_instability(0.2, flicker::OCTAVES), 0.04 / (PI * f)),
            (Part::rate_random_walk(0.2), 0.08 / (omega * omega)),
            (Part::markov(0.2, 3.0), 0.08 * 9.0 / (1.0 + 9.0 * omega * omega)),
        ];
        for (part, expected) in table {
            let found = density(&part, t0, f).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-8, "{part:?}: {found}, not {expected}");
        }
        for part in [Part::sine(1.0, 0.1), Part::rate_ramp(1.0), Part::warm_up(1.0, 1.0)] {
            assert_eq!(density(&part, t0, f), None, "{part:?}");
        }
    }

    #[test]
    fn the_papers_gyros_have_the_curves_of_the_reference() {
        let gyros =
            [("LGK-400", [0.24, 0.00067 * 60.0, 0.00192]), ("LGV-1", [0.11, 0.00048 * 60.0, 0.00164])];
        let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/allan_model.csv"));
        assert_eq!(text.lines().count(), 27);
        for line in text.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let (tau, expected): (f64, f64) = (cells[1].parse().unwrap(), cells[2].parse().unwrap());
            let (_, [q, n, b]) = gyros.iter().find(|(name, _)| *name == cells[0]).unwrap();
            let parts = [Part::quantization(*q), Part::angle_random_walk(*n), Part::bias_instability(*b, 24)];
            let found = libm::sqrt(parts.iter().filter_map(|part| continuous_variance(part, tau)).sum());
            assert!((found / expected - 1.0).abs() < 1e-11, "{line}: {found}");
        }
    }

    #[test]
    fn finely_sampled_noise_is_the_continuous_one() {
        let parts = [
            Part::quantization(0.2),
            Part::angle_random_walk(0.2),
            Part::rate_random_walk(0.2),
            Part::markov(0.2, 3.0),
            Part::sine(0.2, 0.3),
        ];
        for part in parts {
            for tau in [0.01, 1.0, 2.5, 41.0] {
                let m = 100_000;
                let sampled = part.variance(Difference::Second, tau / m as f64, m) / (2.0 * tau * tau);
                let found = continuous_variance(&part, tau).unwrap();
                assert!((found / sampled - 1.0).abs() < 1e-8, "{part:?} at {tau}: {found}, not {sampled}");
            }
        }
        assert_eq!(continuous_variance(&Part::warm_up(1.0, 1.0), 1.0), None);
    }

    /// The Allan variance at τ = one block is half the mean square difference of neighbours, a contrast.
    #[test]
    fn differences_of_neighbours_have_the_allan_variance() {
        use crate::allan::{Estimator, Process};

        for part in [
            Part::quantization(0.3),
            Part::angle_random_walk(0.3),
            Part::bias_instability(0.3, 24),
            Part::rate_random_walk(0.3),
            Part::markov(0.3, 40.0),
        ] {
            for m in [1, 7, 100] {
                let process = Process { sample_s: 0.5, parts: vec![part] };
                let expected = process.expected(Estimator::OVERLAPPING, 10_000, m).unwrap();
                let covariance = block_covariance(&part, 0.5, m, 2);
                let found = covariance[0] - covariance[1];
                assert!((found / expected - 1.0).abs() < 1e-9, "{part:?}, m = {m}: {found}, not {expected}");
            }
        }
    }
}
