//! Degrees of freedom of a deviation from the autocorrelation of its own differences, which needs no noise model.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::allan::{Angles, Deviation};

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
