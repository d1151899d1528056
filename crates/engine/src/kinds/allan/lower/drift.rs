//! The angles common to all records, from constant rate, ramp, warm-up and alternating drift, in LSB; and their
//! differences.

use std::sync::Arc;

use crate::kinds::allan::lower::fixed::{Fixed, TURN};
use crate::kinds::allan::lower::model::Model;
use sagnac_theory::allan::estimator::Difference;
use sagnac_theory::allan::exponential::settling;

/// The angles at all samples, wrapped; empty where nothing drifts.
///
/// From a warm-up that outlasts the record, its initial rate is subtracted; it affects a readout only, and
/// [`Fixed::rate`] contains it. The rest is not much larger than its differences, and keeps its digits.
pub(crate) fn angles(model: &Model, fixed: &Fixed) -> Arc<[u32]> {
    if !model.is_curved() && fixed.rate == 0 {
        return Arc::new([]);
    }
    let end = model.samples as f64;
    let angle = |sample: u64| {
        let k = sample as f64;
        let mut curved = 0.5 * model.ramp * k * k;
        for warm_up in &model.warm_ups {
            let passed = warm_up.decay * k;
            curved += warm_up.reach
                * match warm_up.decay * end < 1.0 {
                    true => -settling(passed),
                    false => -libm::expm1(-passed),
                };
        }
        if let Some(switching) = &model.switching {
            curved += switching.magnetic.signed_integral(switching.interval as f64, k);
        }
        let curved = libm::round(curved / fixed.lsb_arcsec * TURN) as i128 as u64;
        let angle = fixed.rate.wrapping_mul(sample).wrapping_add(curved);
        (angle.wrapping_add(1 << 31) >> 32) as u32
    };
    (0..=model.samples).map(angle).collect()
}

/// Mean square of the differences of the angles at `m`, `stride` apart, and the first of the differences, LSB.
pub(crate) fn differences(
    angles: &[u32],
    difference: Difference,
    stride: usize,
    m: usize,
    terms: u64,
) -> [f64; 2] {
    let at = |start: usize| -> i32 {
        let angle = |n: usize| angles[start + n * m];
        let second = |n: usize| {
            angle(n + 2).wrapping_sub(angle(n + 1)).wrapping_sub(angle(n + 1).wrapping_sub(angle(n)))
        };
        match difference {
            Difference::Second => second(0) as i32,
            Difference::Third => second(1).wrapping_sub(second(0)) as i32,
        }
    };
    if angles.is_empty() {
        return [0.0; 2];
    }
    let square = |k: u64| u128::from(at(k as usize * stride).unsigned_abs()).pow(2);
    let sum: u128 = (0..terms).map(square).sum();
    [sum as f64 / terms as f64, f64::from(at(0))]
}
