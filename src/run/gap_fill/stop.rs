//! The stop rule: which points are known as well as is asked.

use super::{NORMAL_95, Plan};
use crate::lower::Estimate;
use crate::stats::Estimates;
use crate::store::{Store, StoreError};
use crate::study::Precision;

impl Plan<'_> {
    /// Doubles the trials of points where a filler is not precise enough yet. Where there are such, returns how many each
    /// point is expected to need in the end: half-widths fall with the square root of trials.
    pub(super) fn raise(&self, wanted: &mut [u64], store: &Store) -> Result<Option<Vec<u64>>, StoreError> {
        let Some(precision) = &self.gap_fill.precision else { return Ok(None) };
        let mut raised = false;
        let mut expected = wanted.to_vec();
        for ((point, wanted), expected) in self.points.iter().zip(wanted).zip(&mut expected) {
            let most = point.trials(self.study.trials);
            let mut widest: Option<f64> = None;
            for estimates in &point.fillers {
                let excess = excess(precision, estimates, *wanted, store)?;
                widest = excess.map_or(widest, |excess| Some(widest.unwrap_or(1.0).max(excess)));
            }
            if let Some(excess) = widest.filter(|_| *wanted < most) {
                let doublings = (2.0 * libm::log2(excess)).ceil().clamp(1.0, 63.0);
                *expected = most.min((libm::exp2(doublings) * *wanted as f64) as u64);
                *wanted = (2 * *wanted).min(most);
                raised = true;
            }
        }
        Ok(raised.then_some(expected))
    }

    /// Fillers at points whose errors are not as precise as is asked, and how many there are in all.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub(super) fn imprecise(&self, store: &Store) -> Result<(usize, usize), StoreError> {
        let Some(precision) = &self.gap_fill.precision else { return Ok((0, 0)) };
        let (mut imprecise, mut all) = (0, 0);
        for estimates in self.points.iter().flat_map(|point| &point.fillers) {
            imprecise += usize::from(excess(precision, estimates, u64::MAX, store)?.is_some());
            all += 1;
        }
        Ok((imprecise, all))
    }
}

/// By which factor the errors of a filler are less precise than asked in their first `trials` trials, the worst of them; infinite
/// where one is not known at all, `None` where all are precise enough.
fn excess(
    precision: &Precision,
    estimates: &[Estimate],
    trials: u64,
    store: &Store,
) -> Result<Option<f64>, StoreError> {
    let mut worst: Option<f64> = None;
    for estimate in estimates {
        let tally = store.total_within(&estimate.address, trials)?;
        let found = Estimates::of(&tally, estimate.bin_base, 1.0);
        let beyond = |part: Option<f64>, half: Option<f64>, value: Option<f64>| match (part?, half, value) {
            (part, Some(half), Some(value)) if half <= part * value => None,
            (part, Some(half), Some(value)) => Some(half / (part * value)),
            _ => Some(f64::INFINITY),
        };
        let rms_half = found.and_then(|found| found.rms_se).map(|se| NORMAL_95 * se);
        let q = found.and_then(|found| found.q9973);
        let q_half = q.and_then(|q| q.low.zip(q.high)).map(|(low, high)| 0.5 * (high - low));
        let rms = beyond(precision.rms, rms_half, found.map(|found| found.rms));
        let level = beyond(precision.q9973, q_half, q.map(|q| q.value));
        for excess in rms.into_iter().chain(level) {
            worst = Some(worst.map_or(excess, |worst| worst.max(excess)));
        }
    }
    Ok(worst)
}
