//! The distribution of the size of an error, sampled and in closed form.

use crate::tally::{NORMAL_95, central_interval, z_score};
use sagnac_base::table::column::Band;
use sagnac_theory::navigation::radial::{Radial, quantile};

/// The two reported levels.
const MEDIAN: f64 = 0.5;
const P95: f64 = 0.95;

/// A level with its 95 % interval from order statistics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Level {
    pub(crate) value: f64,
    pub(crate) low: Option<f64>,
    pub(crate) high: Option<f64>,
}

/// The size of an error in one direction, or in two; estimates are absent before anything is sampled.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Sizes {
    pub(crate) rms: Option<f64>,
    /// Standard error of the rms.
    pub(crate) rms_se: Option<f64>,
    /// The level of 50 %.
    pub(crate) half: Option<Level>,
    /// The level of 95 %.
    pub(crate) most: Option<Level>,
    pub(crate) closed_rms: f64,
    pub(crate) closed_half: f64,
    pub(crate) closed_most: f64,
    /// Bound of the deviation of an error due to rounding in the kernel.
    pub(crate) rounding: f64,
}

impl Sizes {
    /// The closed forms alone, for sets of coefficients that are equally likely.
    pub(crate) fn closed(distributions: &[Radial], rounding: f64) -> Sizes {
        let squares: f64 = distributions.iter().map(Radial::mean_square).sum();
        Sizes {
            closed_rms: libm::sqrt(squares / distributions.len() as f64),
            closed_half: quantile(distributions, MEDIAN),
            closed_most: quantile(distributions, P95),
            rounding,
            ..Sizes::default()
        }
    }

    /// Adds the estimates from some sizes.
    pub(crate) fn with(self, mut sizes: Vec<f64>) -> Sizes {
        if sizes.is_empty() {
            return self;
        }
        let n = sizes.len() as f64;
        let second = sizes.iter().map(|size| size * size).sum::<f64>() / n;
        let rms = libm::sqrt(second);
        let squares: f64 = sizes.iter().map(|size| size * size - second).map(|rest| rest * rest).sum();
        let se = libm::sqrt(squares / (n - 1.0) / n) / (2.0 * rms);
        sizes.sort_unstable_by(f64::total_cmp);
        Sizes {
            rms: Some(rms),
            rms_se: (sizes.len() > 1).then_some(if squares == 0.0 { 0.0 } else { se }),
            half: Some(level(&sizes, MEDIAN)),
            most: Some(level(&sizes, P95)),
            ..self
        }
    }

    /// The deviation of the rms from its closed form in standard errors.
    pub(crate) fn z(&self) -> Option<f64> {
        z_score(self.rms?, self.closed_rms, self.rms_se?, self.rounding)
    }

    pub(crate) fn rms_band(&self) -> Band {
        let (rms, half) = (self.rms?, NORMAL_95 * self.rms_se?);
        Some((rms - half, rms + half))
    }
}

/// The level that a part of some sorted sizes stay below.
fn level(sorted: &[f64], part: f64) -> Level {
    let n = sorted.len();
    let at = |rank: u64| rank.checked_sub(1).and_then(|place| sorted.get(place as usize)).copied();
    // About n·part sizes lie below the level; in 95 % of all cases their number is between these two.
    let (fewest, most) = central_interval(n as u64, part);
    let place = part * (n - 1) as f64;
    let (below, above) = (libm::floor(place) as usize, libm::ceil(place) as usize);
    Level {
        value: sorted[below] + (place - below as f64) * (sorted[above] - sorted[below]),
        low: at(fewest),
        high: at(most + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_have_intervals_where_the_trials_bound_them() {
        let sizes: Vec<f64> = (1..=1000).map(f64::from).collect();
        let found = Sizes::closed(&[Radial { mean: [0.0; 2], covariance: [1.0, 0.0, 0.0] }], 0.0).with(sizes);
        let half = found.half.unwrap();
        assert_eq!((half.value, half.low, half.high), (500.5, Some(469.0), Some(532.0)));
        let few = Sizes::default().with(vec![3.0, 1.0]);
        assert_eq!((few.most.unwrap().low, few.most.unwrap().high), (Some(1.0), None));
        assert_eq!(Sizes::default().with(vec![]).rms, None);
    }
}
