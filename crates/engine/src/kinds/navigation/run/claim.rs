//! What a filter claims of its error, against what the error is.

use crate::tally::{NORMAL_95, proportion_interval, z_score};
use sagnac_base::table::column::Band;
use sagnac_theory::navigation::radial::Radial;

use crate::kinds::navigation::run::sizes::Sizes;

/// The consistency of a filter.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Claim {
    /// Standard deviation that the filter claims, ″.
    pub(crate) sigma: f64,
    /// Mean squared error over the claimed variance, with its standard error.
    pub(crate) nees: Option<f64>,
    pub(crate) nees_se: Option<f64>,
    pub(crate) closed_nees: f64,
    pub(crate) z: Option<f64>,
    /// Part of the trials within the 95 % region of the filter.
    pub(crate) within: Option<f64>,
    pub(crate) within_band: Band,
    pub(crate) closed_within: f64,
}

impl Claim {
    /// The consistency of a filter with errors of these `sizes`, of which all are the `errors`.
    pub(crate) fn of(sigma: f64, sizes: &Sizes, distributions: &[Radial], errors: &[f64]) -> Claim {
        let square = |size: f64| size * size / (sigma * sigma);
        let (trials, region) = (errors.len() as u64, NORMAL_95 * sigma);
        let inside = errors.iter().filter(|error| error.abs() <= region).count() as u64;
        let nees = sizes.rms.map(square);
        let nees_se = sizes.rms.zip(sizes.rms_se).map(|(rms, se)| 2.0 * rms * se / (sigma * sigma));
        let closed_nees = square(sizes.closed_rms);
        let rounding = 2.0 * sizes.closed_rms * sizes.rounding / (sigma * sigma);
        let below: f64 = distributions.iter().map(|one| one.below(region)).sum();
        Claim {
            sigma,
            nees,
            nees_se,
            closed_nees,
            z: nees.zip(nees_se).and_then(|(nees, se)| z_score(nees, closed_nees, se, rounding)),
            within: (trials > 0).then(|| inside as f64 / trials as f64),
            within_band: (trials > 0).then(|| proportion_interval(inside, trials)),
            closed_within: below / distributions.len() as f64,
        }
    }

    /// The 95 % interval of the NEES.
    pub(crate) fn nees_band(&self) -> Band {
        let (nees, half) = (self.nees?, NORMAL_95 * self.nees_se?);
        Some(((nees - half).max(0.0), nees + half))
    }
}
