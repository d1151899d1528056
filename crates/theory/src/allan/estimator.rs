//! Estimators of a variance at τ: the differences of the angle that are averaged, and their number.

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
