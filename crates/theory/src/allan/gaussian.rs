//! Covariance between the estimates of a curve, for Gaussian noise.
//!
//! For Gaussian differences D of the angle, overlapping at every sample, two estimates have the covariance ΣΣ [2c² +
//! 4cp]/(M_i M_j d²τ_i²τ_j²), where c is the covariance of the two differences, p the product of their deterministic
//! parts, and d the divisor 2 or 6. The sum over lags is exact near the lags where an angle of one difference meets one
//! of the other, and by quadrature in between, where c is smooth. It is accurate to 1e-4 of √(C_ii·C_jj), or 2e-3 with
//! a sine, at a cost that does not grow with the record.
//!
//! [`freedom`] gives the equivalent degrees of freedom of one estimate of a variance, from the covariance of its differences.
//! An estimate is the mean of M squares (d + p)², where d is Gaussian with the autocovariance c(l) and p is the deterministic part.
//! Its variance is Σ (M − |l|)(2c(l)² + 4c(l)p(l))/M² over all lags l, and 2E²/variance are the degrees of freedom of the χ²
//! with the same mean and variance (Satterthwaite).

#[cfg(test)]
mod tests;

use crate::allan::terms::{Apart, Covariance, Kernel};
use crate::allan::{Difference, Estimator, Process, Stride};

/// Lags beyond the meeting of the differences up to which the sum extends, relative to their length; the covariance of
/// flicker has then fallen as the square of the lag.
const FOLLOWED: f64 = 32.0;
/// Length of a quadrature panel relative to its distance to the nearest meeting.
const PANEL: f64 = 0.25;
/// Number of lags on either side of a meeting that are summed one by one.
const DENSE: f64 = 6.0;

/// Covariance of the overlapping estimates at the averaging factors `ms` of one record, (″/s)⁴.
///
/// Octave holds are taken as Gaussian, which makes the scatter of flicker at most 2 % too small (four streams). A
/// warm-up is left out, as it is the same in every record and not stationary. Every m must leave at least one
/// difference.
pub fn covariance(process: &Process, difference: Difference, samples: u64, ms: &[u64]) -> Vec<Vec<f64>> {
    Components::new(process, difference, samples, ms).covariance(&vec![1.0; process.parts.len()])
}

/// The covariance of estimates by components: the contribution of each pair of parts of a process.
///
/// The covariance of differences is a sum over parts, so that of the estimates is a quadratic form of the parts'
/// variances. The covariance for other coefficients then costs almost nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Components {
    parts: usize,
    /// For each pair of points i ≥ j, the symmetric matrix over parts, row by row.
    points: Vec<Vec<Vec<f64>>>,
}

impl Components {
    /// The components for the overlapping estimates at `ms` of a record of `samples` samples; see [`covariance`].
    pub fn new(process: &Process, difference: Difference, samples: u64, ms: &[u64]) -> Components {
        let pair = |i: usize, j: usize| {
            let (a, b) = (ms[i].min(ms[j]), ms[i].max(ms[j]));
            Pair::new(process, difference, samples, a, b).components()
        };
        let points = (0..ms.len()).map(|i| (0..=i).map(|j| pair(i, j)).collect()).collect();
        Components { parts: process.parts.len(), points }
    }

    /// The covariance, (″/s)⁴, with the squared coefficient of every part multiplied by its scale.
    pub fn covariance(&self, scales: &[f64]) -> Vec<Vec<f64>> {
        let products: Vec<f64> = scales.iter().flat_map(|a| scales.iter().map(move |b| a * b)).collect();
        let total =
            |cells: &Vec<f64>| cells.iter().zip(&products).map(|(cell, product)| cell * product).sum();
        let cell = |i: usize, j: usize| total(&self.points[i.max(j)][i.min(j)]);
        let count = self.points.len();
        (0..count).map(|i| (0..count).map(|j| cell(i, j)).collect()).collect()
    }

    /// The components for the averaging factors from the position `start` on.
    pub fn from(&self, start: usize) -> Components {
        let points = self.points.iter().skip(start).map(|row| row[start..].to_vec()).collect();
        Components { parts: self.parts, points }
    }

    /// The contribution of each pair of parts to the variance of Σ `weights` · estimates.
    pub fn variance_of(&self, weights: &[f64]) -> Vec<Vec<f64>> {
        let mut sums = vec![0.0; self.parts * self.parts];
        for (i, row) in self.points.iter().enumerate() {
            for (j, cells) in row.iter().enumerate() {
                let weight = weights[i] * weights[j] * if i == j { 1.0 } else { 2.0 };
                sums.iter_mut().zip(cells).for_each(|(sum, cell)| *sum += weight * cell);
            }
        }
        sums.chunks(self.parts.max(1)).map(<[f64]>::to_vec).collect()
    }
}

/// Two averaging factors a ≤ b, with the quantities needed for the sums over their differences.
struct Pair<'a> {
    process: &'a Process,
    difference: Difference,
    a: f64,
    b: f64,
    terms_a: f64,
    terms_b: f64,
    /// Kernel of each part of noise that has one.
    kernels: Vec<Option<Kernel>>,
}

/// For each part, the covariance c of two differences if it is noise, else the product p of them.
struct Products {
    noise: Vec<f64>,
    steady: Vec<f64>,
}

impl<'a> Pair<'a> {
    fn new(process: &'a Process, difference: Difference, samples: u64, a: u64, b: u64) -> Pair<'a> {
        let terms = |m: u64| (samples + 1).saturating_sub(difference.spans() * m) as f64;
        Pair {
            process,
            difference,
            a: a as f64,
            b: b as f64,
            terms_a: terms(a),
            terms_b: terms(b),
            kernels: process.parts.iter().map(|part| part.kernel(process.sample_s)).collect(),
        }
    }

    /// 2cc + 2cp + 2pc for each pair of parts, summed over all differences and scaled to the covariance.
    fn components(&self) -> Vec<f64> {
        let spans = self.difference.spans() as f64;
        let (t0, divisor) = (self.process.sample_s, self.difference.divisor());
        let white_errors = self.meetings();
        let mut meetings: Vec<f64> = white_errors.iter().map(|meeting| meeting.0).collect();
        // The lags where the number of pairs begins to fall, and the ends.
        let reach = FOLLOWED * (self.a + self.b) * spans;
        let (low, high) = ((1.0 - self.terms_a).max(-reach), (self.terms_b - 1.0).min(reach));
        meetings.extend([0.0, self.terms_b - self.terms_a, low, high]);
        meetings.retain(|lag| (low..=high).contains(lag));
        meetings.sort_by(f64::total_cmp);
        meetings.dedup();
        let count = self.process.parts.len();
        let mut products = Products { noise: vec![0.0; count], steady: vec![0.0; count] };
        let mut sums = vec![0.0; count * count];
        let mut add = |lag: f64, width: f64, met: f64| {
            self.products(lag, width, met, &mut products);
            let pairs = 2.0 * width * self.pairs_at(lag);
            let Products { noise, steady } = &products;
            for i in 0..count {
                for j in 0..count {
                    sums[i * count + j] +=
                        pairs * (noise[i] * noise[j] + noise[i] * steady[j] + steady[i] * noise[j]);
                }
            }
        };
        for lag in &meetings {
            add(
                *lag,
                1.0,
                white_errors.iter().filter(|meeting| meeting.0 == *lag).map(|meeting| meeting.1).sum(),
            );
        }
        for ends in meetings.windows(2) {
            panels(ends[0], ends[1], |middle, width| add(middle, width, 0.0));
        }
        let tau_squares = t0 * t0 * self.a * self.a * t0 * t0 * self.b * self.b;
        let scale = self.terms_a * self.terms_b * divisor * divisor * tau_squares;
        sums.iter().map(|sum| sum / scale).collect()
    }

    /// Number of pairs of differences at this lag.
    fn pairs_at(&self, lag: f64) -> f64 {
        self.terms_a.min(self.terms_b - lag) - (-lag).max(0.0)
    }

    /// Lags of the difference at b relative to that at a where an angle of one meets one of the other, each with the
    /// product of their coefficients there.
    fn meetings(&self) -> Vec<(f64, f64)> {
        let coefficients = self.difference.coefficients();
        let of_angle = |(i, u): (u32, &f64)| {
            let (at, u) = (f64::from(i) * self.a, *u);
            (0_u32..).zip(coefficients).map(move |(j, v)| (at - f64::from(j) * self.b, u * v))
        };
        (0_u32..).zip(coefficients).flat_map(of_angle).collect()
    }

    /// The products at a lag, with a sine averaged over `width` lags around it; `met` is the product of the
    /// coefficients of angles that meet.
    fn products(&self, lag: f64, width: f64, met: f64, products: &mut Products) {
        let coefficients = self.difference.coefficients();
        let (difference, a, b) = (self.difference, self.a, self.b);
        let apart = Apart { difference, sample_s: self.process.sample_s, a, b, lag, width };
        for (i, (part, kernel)) in self.process.parts.iter().zip(&self.kernels).enumerate() {
            let covariance = &part.term.row().forms.covariance;
            products.noise[i] = match (kernel, covariance) {
                (Some(kernel), _) => {
                    // The difference over a, whose angles are x behind those of b.
                    let inner = |x: f64| match difference {
                        Difference::Second => kernel(a, (x - a).abs()),
                        Difference::Third => kernel(a, (x - 2.0 * a).abs()) - kernel(a, (x - a).abs()),
                    };
                    let one = |(j, v): (u32, &f64)| v * inner(lag + f64::from(j) * b);
                    (0..).zip(coefficients).map(one).sum()
                }
                (None, Covariance::Meeting(covariance)) => covariance(part, met),
                _ => 0.0,
            };
            products.steady[i] = match covariance {
                Covariance::Product(product) => product(part, &apart),
                _ => 0.0,
            };
        }
    }
}

/// Divides the whole lags between two meetings, both excluded, into panels and passes the middle and the width of each
/// part to `add`: single lags near the ends, else three points of Gauss–Legendre.
fn panels(low: f64, high: f64, mut add: impl FnMut(f64, f64)) {
    const NODE: f64 = 0.774_596_669_241_483_4;
    let mut next = low + 1.0;
    while next < high {
        let distance = (next - low).min(high - next);
        // Towards the far end panels become shorter again.
        let width = libm::floor(PANEL * distance).min(high - next);
        if distance <= DENSE || width < 3.0 {
            add(next, 1.0);
            next += 1.0;
        } else {
            let middle = next + 0.5 * (width - 1.0);
            for (node, weight) in [(-NODE, 5.0 / 18.0), (0.0, 8.0 / 18.0), (NODE, 5.0 / 18.0)] {
                add(middle + 0.5 * width * node, weight * width);
            }
            next += width;
        }
    }
}

/// Points over which a modified variance averages the angle within τ; its covariance is smooth enough for so few.
const AVERAGED: u64 = 32;
/// Lags up to which differences of the angle are correlated, in their own lengths.
const FOLLOWED_IN_FREEDOM: f64 = 8.0;

/// Equivalent degrees of freedom of the estimate at `m` from one record of `samples` samples; `is_modified` if the angle is
/// averaged over τ. `None` where the record has no difference, and for a process that has no noise.
pub fn freedom(
    process: &Process,
    estimator: Estimator,
    is_modified: bool,
    samples: u64,
    m: u64,
) -> Option<f64> {
    let found = match (is_modified, estimator.stride) {
        (true, _) => of_averages(process, estimator, samples, m)?,
        (false, Stride::Sample) => {
            let mean = process.expected(estimator, samples, m)?;
            2.0 * mean * mean / covariance(process, estimator.difference, samples, &[m])[0][0]
        }
        (false, _) => {
            let terms = estimator.terms(samples, m) as f64;
            let stride = estimator.stride(m) as f64;
            let own = Own::new(process, estimator, samples, m, [stride, 1.0]);
            own.freedom(terms, |k| if k == 0.0 { terms } else { 2.0 * (terms - k).max(0.0) })
        }
    };
    Some(found).filter(|freedom| freedom.is_finite() && *freedom > 0.0)
}

/// Equivalent degrees of freedom of a modified variance, whose differences are those of angles averaged over m samples.
fn of_averages(process: &Process, estimator: Estimator, samples: u64, m: u64) -> Option<f64> {
    let span = (estimator.difference.spans() + 1) * m;
    let terms = (samples + 2).checked_sub(span).filter(|terms| *terms > 0)? as f64;
    let parts = m.min(AVERAGED);
    let step = m as f64 / parts as f64;
    // A mean of few points has the scatter of one over all m if each point scatters as a mean over a step.
    let own = Own::new(process, estimator, samples, m, [step; 2]).averaged(parts as usize);
    // Pairs of terms whose lag rounds to a lag of the grid.
    let pairs_within = |lag: f64| {
        let lag = lag.clamp(0.0, terms);
        2.0 * lag * terms - lag * lag
    };
    Some(own.freedom(terms, |k| pairs_within((k + 0.5) * step) - pairs_within((k - 0.5) * step)))
}

/// Autocovariance c and products p of the differences at lags 0, 1, 2, … of a grid.
struct Own(Vec<[f64; 2]>);

impl Own {
    /// The differences at `m` over lags of `step` samples, each of which stands for `width` lags.
    fn new(process: &Process, estimator: Estimator, samples: u64, m: u64, [step, width]: [f64; 2]) -> Own {
        let difference = estimator.difference;
        let pair = Pair::new(process, difference, samples, m, m);
        let span = (difference.spans() * m) as f64;
        let most = (FOLLOWED_IN_FREEDOM * span / step).min(samples as f64 / step);
        let coefficients = difference.coefficients();
        let shared = |shift: usize| {
            coefficients.iter().zip(coefficients.iter().skip(shift)).map(|(a, b)| a * b).sum::<f64>()
        };
        let count = process.parts.len();
        let mut products = Products { noise: vec![0.0; count], steady: vec![0.0; count] };
        let at = |k: u32| {
            let lag = f64::from(k) * step;
            let times = libm::round(lag / m as f64);
            let meets =
                if libm::fabs(lag - times * m as f64) < 0.25 { shared(times as usize) / width } else { 0.0 };
            pair.products(lag, width, meets, &mut products);
            [products.noise.iter().sum(), products.steady.iter().sum()]
        };
        Own((0..=most as u32).map(at).collect())
    }

    /// Autocovariance and products of means of `parts` successive differences of the grid.
    fn averaged(&self, parts: usize) -> Own {
        let reach = self.0.len().saturating_sub(parts).max(1);
        let square = (parts * parts) as f64;
        let at = |k: usize, kind: usize| {
            let near = |u: usize| self.0.get(u).map_or(0.0, |own| own[kind]);
            let both = |u: usize| near(k + u) + near(k.abs_diff(u));
            let sum: f64 = (1..parts).map(|u| (parts - u) as f64 * both(u)).sum();
            (parts as f64 * near(k) + sum) / square
        };
        Own((0..reach).map(|k| [at(k, 0), at(k, 1)]).collect())
    }

    /// Degrees of freedom of the mean square of `terms` differences, with the number of pairs at each lag.
    fn freedom(&self, terms: f64, pairs: impl Fn(f64) -> f64) -> f64 {
        let [noise, steady] = self.0[0];
        let mean = noise + steady;
        let at = |(k, [c, p]): (u32, &[f64; 2])| pairs(f64::from(k)) * (2.0 * c * c + 4.0 * c * p);
        2.0 * mean * mean * terms * terms / (0..).zip(&self.0).map(at).sum::<f64>()
    }
}
