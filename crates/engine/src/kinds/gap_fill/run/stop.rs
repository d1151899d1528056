//! The stop rule, which decides which points have the requested precision.

use crate::key::row::Precision;
use crate::kinds::gap_fill::run::Plan;
use crate::kinds::gap_fill::run::proven::Proof;
use crate::kinds::plan::Launched;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::tally::{Estimates, NORMAL_95};
use sagnac_kernel::moments::Moments;

impl Plan<'_> {
    /// Doubles the trials of points where an error is not precise enough; returns whether there were any.
    pub(crate) fn raise_imprecise(&self, wanted: &mut [u64], store: &Store) -> Result<bool, StoreError> {
        let Some(precision) = &self.study.precision else { return Ok(false) };
        let mut raised = false;
        for (point, wanted) in self.points.iter().zip(wanted) {
            let most = point.trials(self.study.trials);
            let mut estimates = point.estimates.iter().take_while(|_| *wanted < most);
            let is_imprecise = estimates.try_fold(false, |is_imprecise, estimate| {
                let within = |tally| known(precision, estimate, &tally);
                let address = point.address(estimate);
                Ok(is_imprecise || !within(store.total_within(&address, *wanted)?))
            })?;
            if is_imprecise {
                *wanted = (2 * *wanted).min(most);
                raised = true;
            }
        }
        Ok(raised)
    }

    /// The number of fillers at points whose errors lack the requested precision, followed by the number of all fillers
    /// at points.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub(crate) fn imprecise(&self, store: &Store) -> Result<(usize, usize), StoreError> {
        let Some(precision) = &self.study.precision else { return Ok((0, 0)) };
        let (mut imprecise, mut all) = (0, 0);
        let fillers = self.points.iter().flat_map(|point| point.fillers().map(move |own| (point, own)));
        for (point, estimates) in fillers {
            let mut is_precise = true;
            for estimate in estimates {
                is_precise &= known(precision, estimate, &store.total(&point.address(estimate))?);
            }
            imprecise += usize::from(!is_precise);
            all += 1;
        }
        Ok((imprecise, all))
    }
}

/// Whether a tally gives the error of an estimate with the requested precision.
fn known(precision: &Precision, estimate: &Proof, tally: &Moments) -> bool {
    let Some(found) = Estimates::of(tally, estimate.bin_base, 1.0) else { return false };
    let within = |part: Option<f64>, half: Option<f64>, value: Option<f64>| {
        part.is_none_or(|part| half.zip(value).is_some_and(|(half, value)| half <= part * value))
    };
    let rms_half = found.rms_se.map(|se| NORMAL_95 * se);
    let q_half = found.p99_73.and_then(|q| q.low.zip(q.high)).map(|(low, high)| 0.5 * (high - low));
    within(precision.rms, rms_half, Some(found.rms))
        && within(precision.p99_73, q_half, found.p99_73.map(|q| q.value))
}
