//! Samples that stand out from their neighbours.

use rayon::prelude::*;

/// Distance from which on a sample is an outlier, in units of the scatter. Of 2 million samples of Gaussian noise, white or behind a
/// low-pass of any order and frequency, the farthest is at 6.2.
pub const OUTLYING: f64 = 8.0;

/// Part of that distance from which on samples belong to the tail of the noise; few of Gaussian noise are as far.
const TAIL: f64 = 0.75;

/// Number of samples on each side with which a sample is compared.
const BESIDE: usize = 2;

/// Samples that one thread examines at a time, and from which the scatter is estimated.
const PART: usize = 1 << 16;

/// Part of the distances whose largest shows the scatter; more outliers than the rest would hide themselves.
const CORE_PART: f64 = 0.95;

/// Ratios of the standard deviation of a normal distribution to this quantile, and to the median, of its absolute values.
const OF_MAX: f64 = 0.510_213;
const OF_MEDIAN: f64 = 1.482_602;

/// The outliers of a record.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outliers {
    /// Indices of the samples, rising.
    pub samples: Vec<usize>,
    /// Largest allowed distance from the median of the neighbourhood.
    pub threshold: f64,
    /// Number of samples that are more than 0.75 as far, but no outliers.
    pub tail: usize,
}

/// Most part of the samples that are spikes; more are noise that comes and goes.
const MAX_SPIKES: f64 = 0.01;
/// Fewest spikes for each sample that is nearly one.
const OVER_TAIL: usize = 4;

impl Outliers {
    /// Whether they are spikes among so many samples, and not the tails of the noise, of which there would be as many a little nearer.
    pub fn are_spikes(&self, samples: usize) -> bool {
        let count = self.samples.len();
        count > 0 && count as f64 <= MAX_SPIKES * samples as f64 && count >= OVER_TAIL * self.tail
    }
}

/// Finds the samples whose distance from the median of themselves and two neighbours on each side is more than
/// [`OUTLYING`] times the scatter. The scatter is the greater of two: that of a normal distribution whose distances have the same
/// 95 % quantile, and that of independent samples whose steps have the same median. Behind a low-pass neighbours are alike, so that
/// the median of the distances is far below the scatter or 0. Where most distances are 0, as in counts of pulses, the scatter is
/// at least the smallest other one.
///
/// Spikes of one or two samples are found even in a record with slow changes; steps are not outliers. NaN is neither an
/// outlier nor a neighbour. `samples` are rates or increments.
pub fn outliers(samples: &[f64]) -> Outliers {
    let scatter = scatter(samples);
    let threshold = OUTLYING * scatter;
    let parts: Vec<Vec<usize>> = (0..samples.len().div_ceil(PART))
        .into_par_iter()
        .map(|part| {
            let places = part * PART..((part + 1) * PART).min(samples.len());
            places.filter(|&i| !is_near(samples, i, threshold) && distance(samples, i) > threshold).collect()
        })
        .collect();
    let found = if scatter > 0.0 { parts.concat() } else { vec![] };
    let tail = if found.is_empty() { 0 } else { tail(samples, threshold).saturating_sub(found.len()) };
    Outliers { samples: found, threshold, tail }
}

/// Number of samples whose distance is more than [`TAIL`] of the threshold.
fn tail(samples: &[f64], threshold: f64) -> usize {
    let places = (0..samples.len()).into_par_iter();
    places
        .filter(|&i| !is_near(samples, i, TAIL * threshold) && distance(samples, i) > TAIL * threshold)
        .count()
}

/// The scatter of [`PART`] samples evenly spread over the record.
fn scatter(samples: &[f64]) -> f64 {
    let stride = (samples.len() / PART).max(1);
    let places = || (0..samples.len()).step_by(stride);
    let known = |values: &mut dyn Iterator<Item = f64>| values.filter(|value| !value.is_nan()).collect();
    let mut distances: Vec<f64> = known(&mut places().map(|i| distance(samples, i)));
    let mut steps: Vec<f64> = known(&mut places().skip(1).map(|i| (samples[i] - samples[i - 1]).abs()));
    let of_distances = OF_MAX * quantile(&mut distances, CORE_PART);
    let of_steps = OF_MEDIAN * core::f64::consts::FRAC_1_SQRT_2 * quantile(&mut steps, 0.5);
    let scatter = of_distances.max(of_steps);
    if quantile(&mut distances, 0.5) > 0.0 {
        return scatter;
    }
    let least = distances.into_iter().filter(|distance| *distance > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { scatter.max(least) } else { scatter }
}

/// A quantile of some values, 0 of none.
fn quantile(values: &mut [f64], probability: f64) -> f64 {
    let place = (probability * values.len() as f64) as usize;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(place, f64::total_cmp).1 }
}

/// Whether sample `i` is within `threshold` of those before and after it, and therefore of the median, beyond which lie
/// three of four neighbours.
#[inline]
fn is_near(samples: &[f64], i: usize, threshold: f64) -> bool {
    let Some(&[before, sample, after]) = i.checked_sub(1).and_then(|from| samples.get(from..i + 2)) else {
        return false;
    };
    (sample - before).abs() <= threshold && (sample - after).abs() <= threshold
}

/// The distance of sample `i` from the median of itself and its neighbours; NaN where it is missing or alone.
fn distance(samples: &[f64], i: usize) -> f64 {
    let near = &samples[i.saturating_sub(BESIDE)..(i + BESIDE + 1).min(samples.len())];
    let mut known = [0.0; 2 * BESIDE + 1];
    let mut count = 0;
    for value in near.iter().filter(|value| !value.is_nan()) {
        // Insertion into the sorted part, which suffices for five values.
        let mut at = count;
        while at > 0 && known[at - 1] > *value {
            known[at] = known[at - 1];
            at -= 1;
        }
        known[at] = *value;
        count += 1;
    }
    if count < 3 { f64::NAN } else { (samples[i] - known[count / 2]).abs() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(count: usize) -> Vec<f64> {
        let mut n: u64 = 1_234_567_890;
        let mut uniform = || {
            n = 16807 * n % 2_147_483_647;
            n as f64 / 2_147_483_647.0
        };
        (0..count).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
    }

    #[test]
    fn spikes_of_one_and_two_samples_are_found_and_steps_and_drift_are_not() {
        let mut samples = noise(200_000);
        for (i, value) in samples.iter_mut().enumerate() {
            *value += 1e-2 * i as f64 + if i > 100_000 { 1000.0 } else { 0.0 };
        }
        for i in [70, 500, 501, 150_000] {
            samples[i] += 20.0;
        }
        samples[80] = f64::NAN;
        let found = outliers(&samples);
        assert_eq!(found.samples, [70, 500, 501, 150_000], "threshold {}", found.threshold);
        assert!((5.0..12.0).contains(&found.threshold), "{}", found.threshold);
    }

    #[test]
    fn noise_behind_a_low_pass_has_no_outliers_but_its_spikes() {
        // Means of means, so that neighbours are nearly equal.
        let mut samples = noise(300_000);
        for _ in 0..4 {
            samples = samples.windows(12).map(|near| near.iter().sum::<f64>() / 12.0).collect();
        }
        assert_eq!(outliers(&samples).samples, Vec::<usize>::new());
        samples[1000] += 1.0;
        assert_eq!(outliers(&samples).samples, [1000]);
    }

    #[test]
    fn counts_of_pulses_are_compared_with_one_pulse() {
        let mut counts: Vec<f64> = (0..1000).map(|i| if i % 9 == 0 { 3.0 } else { 2.0 }).collect();
        assert_eq!(outliers(&counts).samples, Vec::<usize>::new());
        counts[400] = 40.0;
        assert_eq!(outliers(&counts).samples, [400]);
    }

    #[test]
    fn nothing_stands_out_of_nothing_or_of_equals() {
        for samples in [vec![], vec![1.0], vec![f64::NAN; 10], vec![5.0; 100]] {
            assert!(outliers(&samples).samples.is_empty(), "{samples:?}");
        }
    }
}
