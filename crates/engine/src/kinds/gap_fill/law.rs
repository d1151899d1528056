//! The values of the laws of gap fillers.

use crate::chart::Law;
use crate::filler::read::Error;
use crate::filler::{Closed, Filler, Method};
use crate::kinds::gap_fill::inputs::Inputs;
use sagnac_theory::published::{
    noise_of_const, noise_of_const_as_published, taylor_extremum_as_published,
    taylor_zero_crossing_as_published,
};

/// Number of ticks for which the published noise law holds.
const PUBLISHED_TICKS: usize = 4;

impl Law {
    /// The value of the law for one of the errors of a filler that reads `ticks` ticks, ″; `None` where the law does
    /// not apply.
    pub fn arcsec(self, inputs: &Inputs, filler: &Filler, error: Error, ticks: usize) -> Option<f64> {
        let Method::Closed(&Closed { order: Some(order), .. }) = filler.method else { return None };
        let three_sigma = 3.0 * inputs.sigma_arcsec();
        let of_const = order == 0 && error != Error::InGap;
        let taylor = |share: fn(usize, f64) -> Option<f64>| {
            let (rate, _) = inputs.motion.single_tone()?;
            share(order, inputs.dt_nu()?).map(|share| share * rate * inputs.tick_s)
        };
        match self {
            Law::TaylorExtremum => taylor(taylor_extremum_as_published),
            Law::TaylorZeroCrossing => taylor(taylor_zero_crossing_as_published),
            Law::NoiseAsPublished => (of_const && ticks == PUBLISHED_TICKS)
                .then(|| noise_of_const_as_published(three_sigma, inputs.gap_ticks)),
            Law::ZeemanTables
            | Law::StrategicGrade
            | Law::NavigationGrade
            | Law::TacticalGrade
            | Law::ConsistentFilter => None,
            Law::Noise => of_const.then(|| noise_of_const(three_sigma, inputs.gap_ticks, ticks)),
        }
    }
}
