//! The distances at which a covariance is wanted.

/// Distances of two ticks, from 0 on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lags {
    /// Number of distances for which the quadrature is fine enough. Its rounding depends on it, and nothing else does.
    pub resolved: usize,
    /// Number of distances at which the covariance is computed, which takes time in proportion.
    pub computed: usize,
}

impl From<usize> for Lags {
    fn from(count: usize) -> Lags {
        Lags { resolved: count, computed: count }
    }
}
