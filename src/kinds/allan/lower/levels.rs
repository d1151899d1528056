//! Averaging factors in the order of the kernel, which groups them by the stride of their differences.

use crate::kernel::recipe::Level;
use crate::theory::allan::estimator::Estimator;

/// The levels for some averaging factors, and the place of each factor in the sums.
pub(crate) struct Places {
    pub(crate) levels: Vec<Level>,
    pub(crate) places: Vec<usize>,
}

impl Places {
    /// Groups the averaging factors by stride, in ascending order of stride and, within one stride, in the given order.
    pub(crate) fn of(estimator: Estimator, ms: &[u64]) -> Places {
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
        Places { levels, places }
    }
}
