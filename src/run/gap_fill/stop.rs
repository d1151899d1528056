//! The stop rule: which points are known as well as is asked.

use super::{NORMAL_95, Plan};
use crate::lower::Estimate;
use crate::stats::Estimates;
use crate::store::{Store, StoreError};
use crate::study::Precision;

impl Plan<'_> {
    /// Doubles the trials of points where a filler is not precise enough yet; whether there are such.
    pub(super) fn raise(&self, wanted: &mut [u64], store: &Store) -> Result<bool, StoreError> {
        let Some(precision) = &self.gap_fill.precision else { return Ok(false) };
        let mut raised = false;
        for (point, wanted) in self.points.iter().zip(wanted) {
            let most = point.trials(self.study.trials);
            let mut enough = true;
            for estimates in &point.fillers {
                enough = enough && precise(precision, estimates, *wanted, store)?;
            }
            if *wanted < most && !enough {
                *wanted = (2 * *wanted).min(most);
                raised = true;
            }
        }
        Ok(raised)
    }

    /// Fillers at points whose errors are not as precise as is asked, and how many there are in all.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub(super) fn imprecise(&self, store: &Store) -> Result<(usize, usize), StoreError> {
        let Some(precision) = &self.gap_fill.precision else { return Ok((0, 0)) };
        let (mut imprecise, mut all) = (0, 0);
        for estimates in self.points.iter().flat_map(|point| &point.fillers) {
            imprecise += usize::from(!precise(precision, estimates, u64::MAX, store)?);
            all += 1;
        }
        Ok((imprecise, all))
    }
}

/// Whether all errors of a filler are as precise as is asked in their first `trials` trials.
fn precise(
    precision: &Precision,
    estimates: &[Estimate],
    trials: u64,
    store: &Store,
) -> Result<bool, StoreError> {
    for estimate in estimates {
        let tally = store.total_within(&estimate.address, trials)?;
        let found = Estimates::of(&tally, estimate.bin_base, 1.0);
        let within = |part: Option<f64>, half: Option<f64>, value: Option<f64>| match (part, half, value) {
            (None, ..) => true,
            (Some(part), Some(half), Some(value)) => half <= part * value,
            _ => false,
        };
        let rms_half = found.and_then(|found| found.rms_se).map(|se| NORMAL_95 * se);
        let q = found.and_then(|found| found.q9973);
        let q_half = q.and_then(|q| q.low.zip(q.high)).map(|(low, high)| 0.5 * (high - low));
        if !within(precision.rms, rms_half, found.map(|found| found.rms))
            || !within(precision.q9973, q_half, q.map(|q| q.value))
        {
            return Ok(false);
        }
    }
    Ok(true)
}
