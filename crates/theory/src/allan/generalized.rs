//! The generalized covariance of a sampled angle, which gives the covariance of any two of its differences.
//!
//! An angle with a random walk has no covariance, but its differences have: Σ c_i c_j G(k_i − k_j) with G = −V/2, where
//! V(n) is the variance of its increment over n samples. G may differ by a parabola, which second differences cancel.
//! The quantity needed is the second difference of G over the shorter of two differences, written so that nothing
//! cancels for lags much longer than it.

/// Octave holds. A hold is a random walk of the rate that is undone after its length.
pub struct Holds {
    /// Variance of the rate of each octave times t0², ″²; the sum over all octaves before it; and the sum of variance
    /// over length from it on.
    octaves: Vec<f64>,
    before: Vec<f64>,
    from: Vec<f64>,
}

impl Holds {
    /// Holds with these variances of the rate of each octave times t0², ″².
    pub fn new(octaves: Vec<f64>) -> Holds {
        let (mut before, mut from) = (vec![0.0; octaves.len() + 1], vec![0.0; octaves.len() + 1]);
        for o in 0..octaves.len() {
            before[o + 1] = before[o] + octaves[o];
        }
        for o in (0..octaves.len()).rev() {
            from[o] = from[o + 1] + octaves[o] / length(o);
        }
        Holds { octaves, before, from }
    }

    /// The second difference of the generalized covariance, `m` apart around the lag `n`, both in units of t0, ″².
    pub fn at(&self, m: f64, n: f64) -> f64 {
        let within = |lag: f64| match lag < 1.0 {
            true => 0,
            false => self.octaves.len().min(1 + libm::ilogb(lag) as usize),
        };
        // Holds that end before all three lags contribute the same at every lag, and those that end after them are not
        // reversed.
        let (short, reached) = (within(n - m), within(n + m));
        let hold = |o: usize| {
            let taken_back = one_sided_cubic(m, n - length(o)) + one_sided_cubic(m, -n - length(o));
            2.0 * self.octaves[o] / length(o) * (cubic(m, n) - taken_back)
        };
        self.before[short] * m * m
            + (short..reached).map(hold).sum::<f64>()
            + 2.0 * self.from[reached] * cubic(m, n)
    }
}

/// Length in samples of a hold of an octave.
fn length(octave: usize) -> f64 {
    (1_u64 << octave) as f64
}

/// Second difference, m apart, of (|n|³ − |n|)/12, n ≥ 0.
pub fn cubic(m: f64, n: f64) -> f64 {
    match n >= m {
        true => 0.5 * n * m * m,
        false => g(n + m) - 2.0 * g(n) + g(m - n),
    }
}

/// The second difference of (u³ − u)/12 for u > 0, else 0.
fn one_sided_cubic(m: f64, u: f64) -> f64 {
    match u {
        u if u >= m => 0.5 * u * m * m,
        u if u <= -m => 0.0,
        u => g(u + m) - 2.0 * g(u.max(0.0)),
    }
}

fn g(n: f64) -> f64 {
    (n * n * n - n) / 12.0
}
