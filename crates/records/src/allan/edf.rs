//! Equivalent degrees of freedom of deviations, which set the width of their intervals.
//!
//! C. A. Greenhall and W. J. Riley, "Uncertainty of stability variances based on finite differences", PTTI 2003: one
//! procedure for first, second and third differences, overlapping or not, modified or not, and power laws of the phase
//! from white to random run. Comments give the numbers of its equations and tables; NIST SP 1065 (5.4) has the same
//! procedure.
//!
//! [`freedom`] needs no noise model: it takes the degrees of freedom from the autocorrelation of the differences themselves.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::allan::sums::of_lines;
use crate::allan::{Angles, Deviation, theo, total};

/// Most terms of a sum; for longer sums the paper's fits are used.
const MAX_TERMS: f64 = 100.0;

/// The filter factor F of an unmodified variance with an infinite averaging factor.
const INFINITE: f64 = f64::INFINITY;

/// Equivalent degrees of freedom of the variance of `angles` angles without gaps, for noise of the exponent `alpha`.
///
/// `alpha` is the exponent of the spectral density of the rate, −4 … 2. The variance converges above −2d + 1, where d
/// is its order of differences. `None` below that, and without terms.
///
/// Compared with the covariances of sampled noise, the result is exact for white angle noise, and within 3 % from m =
/// 30 on for white rate noise. For white rate noise it is 17 % too large at m = 1 and 12 % too small at m = 4
/// (intervals 8 % too narrow and 6 % too wide), since the paper takes the noise as continuous.
pub(crate) fn edf(deviation: Deviation, alpha: i32, angles: usize, m: usize) -> Option<f64> {
    let d = deviation.differences();
    let terms = deviation.terms(angles, m);
    if terms == 0 || alpha > 2 || alpha + 2 * d as i32 <= 1 {
        return None;
    }
    let samples = angles - 1;
    match deviation {
        Deviation::Totdev => {
            let of_rate = total::edf(alpha, samples, m);
            return of_rate.or_else(|| edf(Deviation::Oadev, alpha, angles, m));
        }
        Deviation::Mtotdev if m <= total::MAX_OF_ALLAN => return edf(Deviation::Mdev, alpha, angles, m),
        Deviation::Mtotdev => return Some(total::modified_edf(alpha, samples, m)),
        Deviation::Theo1 => return Some(theo::edf(alpha, angles, deviation.tau(m))),
        Deviation::Pdev if m > 1 => return Some(parabolic(alpha, terms as f64, m as f64)),
        Deviation::Mtie => return None,
        _ => {}
    }
    // The stride is τ/S.
    let s = if deviation.overlaps() { m as f64 } else { 1.0 };
    let shape = Shape { alpha, d, m: m as f64, s, terms: terms as f64, r: terms as f64 / s };
    let inverse = match (deviation.is_modified(), alpha) {
        (true, _) => shape.general(1.0, 1.0, table_1(alpha, d)),
        (false, 2) => shape.white_angle(),
        (false, 1) => shape.flicker_angle(),
        (false, _) => {
            let is_short = m as f64 * (d as f64 + 1.0) <= MAX_TERMS;
            shape.general(if is_short { m as f64 } else { INFINITE }, INFINITE, table_2(alpha, d))
        }
    };
    Some(1.0 / inverse).filter(|edf| edf.is_finite() && *edf > 0.0)
}

/// The symbols of the paper: `terms` is its M, `r` is M/S.
struct Shape {
    alpha: i32,
    d: usize,
    m: f64,
    s: f64,
    terms: f64,
    r: f64,
}

impl Shape {
    /// J, the number of neighbours with which a term is correlated.
    fn reach(&self) -> f64 {
        self.terms.min((self.d as f64 + 1.0) * self.s)
    }

    fn is_long(&self) -> bool {
        self.r >= self.d as f64 + 1.0
    }

    /// Case 1 of the paper for modified variances, which have a filter factor of 1, and case 2 for others, with the
    /// coefficients of a long record. The filter factor of few terms is `near`, that of many terms `far`.
    fn general(&self, near: f64, far: f64, [a0, a1]: [f64; 2]) -> f64 {
        if self.reach() <= MAX_TERMS {
            self.sum(self.reach(), self.terms, self.s, near)
        } else if self.is_long() {
            (a0 - a1 / self.r) / self.r
        } else {
            self.sum(MAX_TERMS, MAX_TERMS, MAX_TERMS / self.r, far)
        }
    }

    /// Case 3 of the paper.
    fn flicker_angle(&self) -> f64 {
        if self.reach() <= MAX_TERMS {
            // Beyond 1e6 no digits are left in the second difference of s_w.
            return self.sum(self.reach(), self.terms, self.s, self.m.min(1e6));
        }
        let [b0, b1] = table_3(self.d);
        let variance = b0 + b1 * libm::log(self.m);
        if self.is_long() {
            let [a0, a1] = table_2(1, self.d);
            (a0 - a1 / self.r) / (variance * variance * self.r)
        } else {
            let stride = MAX_TERMS / self.r;
            self.basic_sum(MAX_TERMS, MAX_TERMS, stride, stride) / (variance * variance * MAX_TERMS)
        }
    }

    /// Case 4 of the paper: a term is correlated only with those that share one of its d + 1 angles, k τ away.
    fn white_angle(&self) -> f64 {
        let d = self.d as u64;
        let own = binomial(2 * d, d);
        let shared: f64 = (1..=d)
            .map(|k| (k as f64, binomial(2 * d, d - k) / own))
            .filter(|&(k, _)| k < self.r)
            .map(|(k, correlation)| 2.0 * (1.0 - k / self.r) * correlation * correlation)
            .sum();
        (1.0 + shared) / self.terms
    }

    /// Eq. (13): the basic sum, divided by the squared variance of a term and by their number.
    fn sum(&self, reach: f64, terms: f64, stride: f64, filter: f64) -> f64 {
        let variance = s_z(0.0, filter, self.alpha, self.d);
        self.basic_sum(reach, terms, stride, filter) / (variance * variance * terms)
    }

    /// Eq. (10): squares of the covariances of a term with its neighbours.
    fn basic_sum(&self, reach: f64, terms: f64, stride: f64, filter: f64) -> f64 {
        let square = |j: f64| {
            let covariance = s_z(j / stride, filter, self.alpha, self.d);
            covariance * covariance
        };
        let between: f64 =
            (1..reach as u32).map(|j| (1.0 - f64::from(j) / terms) * square(f64::from(j))).sum();
        square(0.0) + (1.0 - reach / terms) * square(reach) + 2.0 * between
    }
}

/// Eq. (7): generalized autocovariance of the integrated phase.
fn s_w(t: f64, alpha: i32) -> f64 {
    let t = libm::fabs(t);
    let log = |power: f64| if t == 0.0 { 0.0 } else { libm::pow(t, power) * libm::log(t) };
    match alpha {
        2 => -t,
        1 => log(2.0),
        0 => libm::pow(t, 3.0),
        -1 => -log(4.0),
        -2 => -libm::pow(t, 5.0),
        -3 => log(6.0),
        _ => libm::pow(t, 7.0),
    }
}

/// Eq. (8): the same for the phase averaged over τ/F.
fn s_x(t: f64, filter: f64, alpha: i32) -> f64 {
    if filter == INFINITE {
        return s_w(t, alpha + 2);
    }
    let step = 1.0 / filter;
    filter * filter * (2.0 * s_w(t, alpha) - s_w(t - step, alpha) - s_w(t + step, alpha))
}

/// Eq. (9): the same for its `d`-th difference.
fn s_z(t: f64, filter: f64, alpha: i32, d: usize) -> f64 {
    let at = |shift: f64| s_x(t + shift, filter, alpha);
    let both = |shift: f64| at(shift) + at(-shift);
    match d {
        2 => 6.0 * at(0.0) - 4.0 * both(1.0) + both(2.0),
        _ => 20.0 * at(0.0) - 15.0 * both(1.0) + 6.0 * both(2.0) - both(3.0),
    }
}

/// Most samples per group, and groups beyond which terms of the parabolic deviation are taken as uncorrelated.
const MAX_PER_GROUP: usize = 64;
const REACH: usize = 4;

/// Degrees of freedom of the parabolic variance, from the covariances of its terms by eq. (8), for m ≥ 2. Longer groups are taken with
/// [`MAX_PER_GROUP`] samples, which leave the correlation at a distance in τ as it is.
fn parabolic(alpha: i32, terms: f64, m: f64) -> f64 {
    let count = (m as usize).min(MAX_PER_GROUP);
    let per_group = count as f64;
    let weight = |k: usize| {
        let of_line = 0.5 * (per_group - 1.0) - (k % count) as f64;
        if k < count { of_line } else { -of_line }
    };
    let product = |shift: usize| (shift..2 * count).map(|k| weight(k) * weight(k - shift)).sum::<f64>();
    let products: Vec<f64> = (0..2 * count).map(product).collect();
    // Noise of the angle is that of means over a sample.
    let filter = if alpha > 0 { per_group } else { INFINITE };
    let at: Vec<f64> =
        (0..(REACH + 2) * count).map(|distance| s_x(distance as f64 / per_group, filter, alpha)).collect();
    let covariance = |lag: usize| {
        let both = |(j, product): (usize, &f64)| product * (at[lag + j] + at[lag.abs_diff(j)]);
        products[0] * at[lag] + products.iter().enumerate().skip(1).map(both).sum::<f64>()
    };
    // As many terms as samples so far apart would have.
    let terms = terms * per_group / m;
    let own = covariance(0);
    let square = |lag: usize| {
        let correlation = covariance(lag) / own;
        (1.0 - lag as f64 / terms).max(0.0) * correlation * correlation
    };
    terms.max(1.0) / (1.0 + 2.0 * (1..=REACH * count).map(square).sum::<f64>())
}

/// The rows of tables 1 and 2 by exponent from 2 down, as pairs a0, a1 for d = 2 and d = 3.
type Rows = [[[f64; 2]; 2]; 7];

/// Entry where the variance does not converge.
const NONE: [f64; 2] = [f64::NAN; 2];

fn row(table: &Rows, alpha: i32, d: usize) -> [f64; 2] {
    usize::try_from(2 - alpha)
        .ok()
        .and_then(|row| table.get(row))
        .map_or(NONE, |pairs| pairs[usize::from(d == 3)])
}

fn table_1(alpha: i32, d: usize) -> [f64; 2] {
    const TABLE: Rows = [
        [[7.0 / 9.0, 1.0 / 2.0], [22.0 / 25.0, 2.0 / 3.0]],
        [[0.997, 0.616], [1.141, 0.843]],
        [[1.033, 0.607], [1.184, 0.848]],
        [[1.048, 0.534], [1.180, 0.816]],
        [[1.302, 0.535], [1.175, 0.777]],
        [NONE, [1.194, 0.703]],
        [NONE, [1.489, 0.702]],
    ];
    row(&TABLE, alpha, d)
}

fn table_2(alpha: i32, d: usize) -> [f64; 2] {
    const TABLE: Rows = [
        // White noise of the angle has a closed form.
        [NONE, NONE],
        [[790.0, 410.0], [9950.0, 6520.0]],
        [[2.0 / 3.0, 1.0 / 3.0], [7.0 / 9.0, 1.0 / 2.0]],
        [[0.852, 0.375], [0.997, 0.617]],
        [[1.079, 0.368], [1.033, 0.607]],
        [NONE, [1.053, 0.553]],
        [NONE, [1.302, 0.535]],
    ];
    row(&TABLE, alpha, d)
}

fn table_3(d: usize) -> [f64; 2] {
    if d == 2 { [15.23, 12.0] } else { [47.8, 40.0] }
}

fn binomial(n: u64, k: u64) -> f64 {
    (1..=k).map(|i| (n - k + i) as f64 / i as f64).product()
}

/// Most angles used, from the middle of the longest stretch.
const MAX_ANGLES: usize = 1 << 16;
/// Most lags whose products are summed one by one.
const MAX_DIRECT: usize = 64;
/// Fewest differences per lag, so that the scatter of the autocorrelation adds little.
const MIN_PER_LAG: usize = 16;

/// Equivalent degrees of freedom at the averaging factor `m` for a record without gaps: M/Σ(1 − |l|/M)ρ(l)² over the lags l
/// at which two of the M differences share angles. `None` where the record is too short to show ρ.
pub(crate) fn freedom(angles: &Angles, deviation: Deviation, m: usize) -> Option<f64> {
    let solid = angles.bridged();
    let run = solid.runs.iter().max_by_key(|run| run.len())?;
    let kept = run.len().min(MAX_ANGLES);
    let first = run.start + (run.len() - kept) / 2;
    let d = of_every_sample(&solid.values[first..first + kept], deviation, m);
    let (stride, terms) = (if deviation.overlaps() { 1 } else { m }, deviation.terms(angles.len(), m) as f64);
    let lags = deviation.span(m) / stride;
    if d.len() < MIN_PER_LAG * lags * stride {
        return None;
    }
    let sums = products(&d, lags * stride);
    let product = |lag: usize| sums[lag * stride] / (d.len() - lag * stride) as f64;
    let own = product(0);
    let square =
        |lag: usize| (product(lag) / own) * (product(lag) / own) * (1.0 - lag as f64 / terms).max(0.0);
    let sum = 1.0 + 2.0 * (1..=lags).map(square).sum::<f64>();
    // The squares of the scatter of each ρ, whose variance is nearly that of the mean square itself.
    let scatter = 1.0 + 2.0 * (lags * stride) as f64 / d.len() as f64;
    Some(terms * scatter / sum).filter(|freedom| freedom.is_finite() && *freedom > 0.0)
}

/// The sums of products of values 0 to `lags` places apart.
fn products(d: &[f64], lags: usize) -> Vec<f64> {
    if lags <= MAX_DIRECT {
        return (0..=lags).map(|lag| d.iter().zip(&d[lag..]).map(|(a, b)| a * b).sum()).collect();
    }
    // The inverse transform of the power, with zeros behind the values so that ends do not meet.
    let size = (d.len() + lags).next_power_of_two();
    let mut padded: Vec<Complex<f64>> = d.iter().map(|&value| Complex::new(value, 0.0)).collect();
    padded.resize(size, Complex::default());
    let mut planner = FftPlanner::new();
    planner.plan_fft_forward(size).process(&mut padded);
    padded.iter_mut().for_each(|value| *value = Complex::new(value.norm_sqr(), 0.0));
    planner.plan_fft_inverse(size).process(&mut padded);
    padded[..=lags].iter().map(|value| value.re / size as f64).collect()
}

/// The differences of a deviation that start at every sample, up to a factor.
fn of_every_sample(x: &[f64], deviation: Deviation, m: usize) -> Vec<f64> {
    let differenced = |x: &[f64]| -> Vec<f64> { x.iter().zip(&x[m..]).map(|(a, b)| b - a).collect() };
    if x.len() <= deviation.span(m) {
        return Vec::new();
    }
    if deviation == Deviation::Pdev && m > 1 {
        let mut slopes = Vec::with_capacity(x.len() - 2 * m);
        of_lines(x, m, 0..x.len() - 2 * m, |slope| slopes.push(slope));
        return slopes;
    }
    let mut d = x.to_vec();
    for _ in 0..deviation.differences() {
        d = differenced(&d);
    }
    if !deviation.is_modified() {
        return d;
    }
    let mut sum: f64 = d[..m].iter().sum();
    let mut averages = vec![sum];
    for (old, new) in d.iter().zip(&d[m..]) {
        sum += new - old;
        averages.push(sum);
    }
    averages
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::Trend;

    /// The exact degrees of freedom edf = (Σ ρ_ij²)⁻¹ M² from the covariances of the terms, for white rate noise and
    /// white angle noise, by counting the samples that two terms share.
    fn by_definition(deviation: Deviation, white_angle: bool, angles: usize, m: usize) -> f64 {
        let terms = deviation.terms(angles, m);
        let stride = if deviation.overlaps() { 1 } else { m };
        let span = deviation.span(m);
        // The weights of one term over angles, or for white rate noise over increments, which are the running sums of
        // the former.
        let coefficients: &[f64] =
            if deviation.differences() == 2 { &[1.0, -2.0, 1.0] } else { &[-1.0, 3.0, -3.0, 1.0] };
        let mut weights = vec![0.0; span];
        for (j, c) in coefficients.iter().enumerate() {
            for i in 0..if deviation.is_modified() { m } else { 1 } {
                weights[j * m + i] += c;
            }
        }
        if !white_angle {
            let mut sum = 0.0;
            weights.iter_mut().for_each(|w| {
                sum += *w;
                *w = sum;
            });
        }
        let covariance = |lag: usize| -> f64 { (lag..span).map(|i| weights[i] * weights[i - lag]).sum() };
        let own = covariance(0);
        let squares: f64 = (1..terms)
            .take_while(|j| j * stride < span)
            .map(|j| {
                let rho = covariance(j * stride) / own;
                2.0 * (terms - j) as f64 * rho * rho
            })
            .sum();
        (terms as f64).powi(2) / (terms as f64 + squares)
    }

    #[test]
    fn degrees_of_freedom_are_those_of_the_terms_own_covariances() {
        for deviation in Deviation::ALL.into_iter().filter(|deviation| deviation.is_of_differences()) {
            for (angles, m) in [(1001, 1), (1001, 4), (1001, 30), (1001, 128), (1001, 300), (20_001, 100)] {
                for (alpha, white_angle) in [(2, true), (0, false)] {
                    let Some(found) = edf(deviation, alpha, angles, m) else { continue };
                    let exact = by_definition(deviation, white_angle, angles, m);
                    // The paper's white rate noise is continuous, and sampled noise differs from it where m is small.
                    let bound = if m < 30 { 0.19 } else { 0.035 };
                    assert!(
                        (found / exact - 1.0).abs() < bound,
                        "{deviation}, α = {alpha}, {angles} angles, m = {m}: {found}, not {exact}"
                    );
                }
            }
        }
    }

    /// The scatter of 2000 simulated records of 501 angles, by a program of its own; the standard error is 3 %.
    #[test]
    fn degrees_of_freedom_of_the_parabolic_variance_are_those_of_simulated_records() {
        let simulated = [
            (2, 2, 281.03),
            (0, 2, 334.62),
            (-2, 2, 344.82),
            (2, 4, 175.63),
            (0, 4, 159.17),
            (-2, 4, 133.43),
            (2, 16, 44.61),
            (0, 16, 38.83),
            (-2, 16, 31.85),
            (2, 64, 9.35),
            (0, 64, 7.43),
            (-2, 64, 5.88),
            (2, 128, 3.99),
            (0, 128, 3.10),
            (-2, 128, 2.37),
            (2, 200, 2.25),
            (0, 200, 1.33),
            (-2, 200, 1.13),
        ];
        for (alpha, m, simulated) in simulated {
            let found = edf(Deviation::Pdev, alpha, 501, m).unwrap();
            // Simulated walks are sums of single steps, the formula's are continuous; and few terms leave much to their number.
            let bound = if m < 4 || m == 200 { 0.2 } else { 0.1 };
            assert!(
                (found / simulated - 1.0).abs() < bound,
                "α = {alpha}, m = {m}: {found}, not {simulated}"
            );
        }
    }

    #[test]
    fn every_noise_that_converges_has_degrees_of_freedom_and_they_fall_with_m() {
        for deviation in Deviation::ALL.into_iter().filter(|deviation| deviation.is_of_differences()) {
            let least = -2 * (deviation.differences() as i32 - 1);
            for alpha in least..=2 {
                let mut before = f64::INFINITY;
                for m in [1, 3, 10, 33, 100, 1000, 10_000, 30_000] {
                    let found = edf(deviation, alpha, 100_001, m).unwrap();
                    let terms = deviation.terms(100_001, m) as f64;
                    assert!(
                        found > 0.9 && found <= 1.01 * terms,
                        "{deviation}, α = {alpha}, m = {m}: {found}"
                    );
                    // White angle noise has as many degrees of freedom as terms at any m.
                    assert!(
                        found < 1.25 * before,
                        "{deviation}, α = {alpha}, m = {m}: {found} after {before}"
                    );
                    before = found;
                }
            }
            assert_eq!(edf(deviation, least - 1, 1001, 10), None, "{deviation}");
            assert_eq!(edf(deviation, 0, 10, 10), None, "{deviation}");
        }
    }

    #[test]
    fn white_noise_has_the_degrees_of_freedom_of_its_closed_form() {
        let numbers = std::iter::successors(Some(1_234_567_890_u64), |n| Some(16807 * n % 2_147_483_647));
        let rates: Vec<f64> = numbers.map(|n| n as f64 / 2_147_483_647.0 - 0.5).take(40_000).collect();
        let angles = Angles::from_increments(&rates, 1.0, 1.0, Trend::None);
        // At m = 1 the correlations of second differences of the angle are −1/2, those of third ones −2/3 and 1/6.
        for (deviation, squares) in [
            (Deviation::Adev, 1.0 + 2.0 * 0.25),
            (Deviation::Oadev, 1.0 + 2.0 * 0.25),
            (Deviation::Ohdev, 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0)),
        ] {
            let found = freedom(&angles, deviation, 1).unwrap() / 40_000.0;
            assert!((found * squares - 1.0).abs() < 0.02, "{deviation}: {found}, not {}", 1.0 / squares);
        }
        assert_eq!(freedom(&angles, Deviation::Oadev, 4000), None);
    }

    #[test]
    fn products_of_many_lags_are_those_of_each() {
        let numbers = std::iter::successors(Some(987_654_321_u64), |n| Some(16807 * n % 2_147_483_647));
        let d: Vec<f64> = numbers.map(|n| n as f64 / 2_147_483_647.0 - 0.5).take(3000).collect();
        let all = products(&d, 500);
        let most = (0..=500).map(|lag| {
            let one: f64 = d.iter().zip(&d[lag..]).map(|(a, b)| a * b).sum();
            (one - all[lag]).abs()
        });
        assert!(most.fold(0.0, f64::max) < 1e-12 * all[0]);
    }
}
