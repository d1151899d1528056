//! Averaging factors in the order of the kernel, which groups them by the stride of their differences.

use crate::kernel::recipe::Level;
use crate::theory::allan::estimator::Estimator;

/// The levels for some averaging factors, grouped by stride in ascending order and, within one stride, in the given
/// order; and the place of each factor in the sums.
pub(crate) fn levels(estimator: Estimator, ms: &[u64]) -> (Vec<Level>, Vec<usize>) {
    let mut order: Vec<usize> = (0..ms.len()).collect();
    order.sort_by_key(|&at| estimator.stride(ms[at]));
    let mut levels: Vec<Level> = Vec::new();
    let mut places = vec![0; ms.len()];
    for (place, &at) in order.iter().enumerate() {
        places[at] = place;
        let stride = estimator.stride(ms[at]) as u32;
        let span = ms[at] as u32 / stride;
        match levels.last_mut() {
            Some(level) if level.stride == stride => level.spans.push(span),
            _ => levels.push(Level { stride, spans: vec![span] }),
        }
    }
    (levels, places)
}
