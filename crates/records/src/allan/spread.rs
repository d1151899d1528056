//! Deviations of the estimates of a record beyond those of Gaussian noise with the same autocorrelation.
//!
//! Noise with long tails, noise that comes and goes, and single events make the mean squares of the parts of a record differ by
//! more than those of Gaussian noise do. The estimates of the whole record are as much less certain. As the same events and
//! changes are behind those of all averaging times, the estimates deviate together.

use rayon::prelude::*;

use crate::allan::sums::{Sum, sums};
use crate::allan::{Angles, Deviation, chi_squared, differences};

/// Number of parts, and how many of them gaps must leave.
const PARTS: usize = 32;
const MIN_PARTS: usize = 16;
/// Fewest degrees of freedom of a part; with them its mean square is nearly normal.
const MIN_FREEDOM: f64 = 32.0;
/// Probability, if the noise is Gaussian, that parts differ by less, from which on their differences count.
const SURE: f64 = 0.999;

/// Relative standard deviations that the Allan variances of a record have beyond those of Gaussian noise, one for each octave of the
/// averaging factor.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Spread(Vec<f64>);

impl Spread {
    /// The spread of the overlapping Allan variances of a record. It is 0 unless the parts differ at some averaging factor more than
    /// those of one in a thousand records of Gaussian noise.
    pub(crate) fn of(angles: &Angles) -> Spread {
        let length = angles.len() / PARTS;
        let octaves: Vec<usize> =
            (0..usize::BITS).map(|octave| 1 << octave).take_while(|m| 2 * m < length).collect();
        if octaves.is_empty() {
            return Spread::default();
        }
        let of_part = |i: usize| sums(&angles.part(i * length..(i + 1) * length), Deviation::Oadev, &octaves);
        let parts: Vec<Vec<Sum>> = (0..PARTS).map(of_part).collect();
        let scatter = |(octave, m): (usize, &usize)| {
            let terms = Deviation::Oadev.terms(angles.len(), *m) as f64;
            let freedom = differences::freedom(angles, Deviation::Oadev, *m)? / terms;
            scatter_of(parts.iter().map(|part| part[octave]).collect(), freedom)
        };
        let found: Vec<Option<Scatter>> = octaves.par_iter().enumerate().map(scatter).collect();
        let found: Vec<Scatter> = found.into_iter().map_while(|scatter| scatter).collect();
        let is_sure = found.iter().any(|scatter| scatter.is_sure);
        Spread(found.iter().map(|scatter| if is_sure { scatter.spread } else { 0.0 }).collect())
    }

    /// The relative standard deviation at the averaging factor `m`. Beyond the longest one for which parts show it, it is that of
    /// the longest one, as of noise whose size changes.
    pub fn at(&self, m: u64) -> f64 {
        let octave = m.max(1).ilog2() as usize;
        self.0.get(octave).or(self.0.last()).copied().unwrap_or(0.0)
    }

    /// That of a record of the same noise that is `times` as long.
    pub fn over(&self, times: f64) -> Spread {
        Spread(self.0.iter().map(|spread| spread / libm::sqrt(times)).collect())
    }

    /// The greatest one.
    pub fn most(&self) -> f64 {
        self.0.iter().copied().fold(0.0, f64::max)
    }
}

/// What the parts of a record show at one averaging factor.
struct Scatter {
    /// Relative standard deviation of the mean of all parts beyond that of Gaussian noise.
    spread: f64,
    is_sure: bool,
}

/// The scatter of the sums of parts, whose noise has `freedom` degrees of freedom per term; `None` where they are too few.
fn scatter_of(mut parts: Vec<Sum>, freedom: f64) -> Option<Scatter> {
    let most = parts.iter().map(|sum| sum.terms).max()?;
    parts.retain(|sum| 2 * sum.terms > most);
    let of_part = freedom * most as f64;
    if of_part < MIN_FREEDOM || parts.len() < MIN_PARTS {
        return None;
    }
    let count = parts.len() as f64;
    let means: Vec<f64> = parts.iter().map(|sum| sum.squares / sum.terms as f64).collect();
    let mean = means.iter().sum::<f64>() / count;
    let squares: f64 = means.iter().map(|x| (x / mean - 1.0) * (x / mean - 1.0)).sum();
    let gaussian = 2.0 / of_part;
    let excess = (squares / (count - 1.0) - gaussian).max(0.0);
    let is_sure = squares / gaussian > chi_squared::quantile(SURE, count - 1.0)?;
    Some(Scatter { spread: libm::sqrt(excess / count), is_sure })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::Trend;

    fn spread(rates: &[f64]) -> Spread {
        Spread::of(&Angles::from_increments(rates, 1.0, 1.0, Trend::None))
    }

    fn white(count: usize) -> Vec<f64> {
        let numbers = std::iter::successors(Some(1_234_567_890_u64), |n| Some(16807 * n % 2_147_483_647));
        let uniform: Vec<f64> = numbers.map(|n| n as f64 / 2_147_483_647.0 - 0.5).take(12 * count).collect();
        uniform.chunks(12).map(|twelve| twelve.iter().sum()).collect()
    }

    #[test]
    fn gaussian_noise_has_none() {
        assert_eq!(spread(&white(100_000)).most(), 0.0);
        assert_eq!(spread(&white(20)), Spread(vec![]));
    }

    /// Half of the parts have four times the variance: the parts scatter by 0.6 of their mean.
    #[test]
    fn noise_that_comes_and_goes_spreads_by_the_scatter_of_its_parts() {
        let mut rates = white(1 << 17);
        rates.chunks_mut(1 << 12).step_by(2).flatten().for_each(|x| *x *= 2.0);
        let (found, expected) = (spread(&rates), 0.6 / libm::sqrt(31.0));
        for m in [1, 8, 64, 1 << 16] {
            assert!((found.at(m) / expected - 1.0).abs() < 0.1, "{found:?}, not {expected}");
        }
    }

    /// One sample in a hundred is ten times as large: the excess kurtosis is 73.5, and a quadratic form of many such samples with
    /// equal weights has the relative variance of a Gaussian one and 73.5 divided by their number more, whatever the averaging time.
    #[test]
    fn long_tails_spread_all_averaging_times_alike() {
        let mut rates = white(1 << 17);
        let mut places = 1_u64;
        for x in &mut rates {
            places = 16807 * places % 2_147_483_647;
            *x *= if places.is_multiple_of(100) { 10.0 } else { 1.0 };
        }
        let (found, expected) = (spread(&rates), libm::sqrt(73.5 / f64::from(1 << 17)));
        for m in [1, 2, 4, 8, 16] {
            assert!((found.at(m) / expected - 1.0).abs() < 0.15, "{found:?}, not {expected}");
        }
    }
}
