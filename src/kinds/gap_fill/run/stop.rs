//! The stop rule: which points are known as well as is asked.

use crate::kernel::moments::Moments;
use crate::kinds::gap_fill::lower::estimate::Estimate;
use crate::kinds::gap_fill::precision::Precision;
use crate::kinds::gap_fill::run::{NORMAL_95, Plan};
use crate::store::Store;
use crate::store::error::StoreError;
use crate::tally::stats::Estimates;

impl Plan<'_> {
    /// Doubles the trials of points where a filler is not precise enough yet. Where there are such, returns how many each
    /// point is expected to need in the end.
    pub(crate) fn raise(&self, wanted: &mut [u64], store: &Store) -> Result<Option<Vec<u64>>, StoreError> {
        let expected = self.expected(wanted, store)?;
        let mut raised = false;
        for ((point, wanted), expected) in self.points.iter().zip(wanted).zip(&expected) {
            if *expected > *wanted {
                *wanted = (2 * *wanted).min(point.trials(self.study.trials));
                raised = true;
            }
        }
        Ok(raised.then_some(expected))
    }

    /// How many trials each point will need, as its first ones show: these where they are enough.
    pub(crate) fn expected(&self, trials: &[u64], store: &Store) -> Result<Vec<u64>, StoreError> {
        let mut expected = trials.to_vec();
        let Some(precision) = &self.gap_fill.precision else { return Ok(expected) };
        for ((point, &trials), expected) in self.points.iter().zip(trials).zip(&mut expected) {
            let most = point.trials(self.study.trials);
            let estimates = point.fillers.iter().flatten();
            for estimate in estimates.take_while(|_| trials < most) {
                let tally = store.total_within(&estimate.address, trials)?;
                *expected = (*expected).max(enough(precision, estimate, tally, trials, most));
            }
        }
        Ok(expected)
    }

    /// Fillers at points whose errors are not as precise as is asked, and how many there are in all.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub(crate) fn imprecise(&self, store: &Store) -> Result<(usize, usize), StoreError> {
        let Some(precision) = &self.gap_fill.precision else { return Ok((0, 0)) };
        let (mut imprecise, mut all) = (0, 0);
        for estimates in self.points.iter().flat_map(|point| &point.fillers) {
            let mut is_precise = true;
            for estimate in estimates {
                is_precise &= known(precision, estimate, &store.total(&estimate.address)?);
            }
            imprecise += usize::from(!is_precise);
            all += 1;
        }
        Ok((imprecise, all))
    }
}

/// How many trials make an estimate as precise as is asked, at most `most`, if those to come are like the `trials` of its
/// tally: these, doubled until they are enough.
fn enough(precision: &Precision, estimate: &Estimate, mut tally: Moments, mut trials: u64, most: u64) -> u64 {
    while trials < most && !known(precision, estimate, &tally) {
        let again = tally.clone();
        tally.merge(&again);
        trials = (2 * trials).min(most);
    }
    trials
}

/// Whether a tally gives the error of an estimate as precisely as is asked.
fn known(precision: &Precision, estimate: &Estimate, tally: &Moments) -> bool {
    let Some(found) = Estimates::of(tally, estimate.bin_base, 1.0) else { return false };
    let within = |part: Option<f64>, half: Option<f64>, value: Option<f64>| {
        part.is_none_or(|part| half.zip(value).is_some_and(|(half, value)| half <= part * value))
    };
    let rms_half = found.rms_se.map(|se| NORMAL_95 * se);
    let q_half = found.q9973.and_then(|q| q.low.zip(q.high)).map(|(low, high)| 0.5 * (high - low));
    within(precision.rms, rms_half, Some(found.rms))
        && within(precision.q9973, q_half, found.q9973.map(|q| q.value))
}
