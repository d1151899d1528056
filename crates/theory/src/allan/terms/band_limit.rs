//! The filter of the sensor itself, beyond its memory.
//!
//! A filter of unit gain at rest leaves the random walk of the angle as it is, except that each angle is a mean of that walk over the
//! memory of the filter. The variance of an increment over n samples, as long as n exceeds that memory, is then less by a
//! constant, as quantization makes it greater by one. For white rate noise N through a first-order low-pass of the time T,
//! that constant is N²T, and L² = N²T/2.

use crate::allan::terms::{Increment, MICRO_G, Row, quantization};

pub(super) static ROW: Row = Row {
    symbol: "L",
    title: "band limit L",
    name: ["a ", "band limit"],
    unit: (1.0, "arcsec", "″"),
    unit_of_acceleration: (MICRO_G, "m/s", "m/s"),
    plain: ("s", "· s"),
    variance: |part, difference, t0, m| -(quantization::ROW.variance)(part, difference, t0, m),
    continuous: |part, tau| Some(-3.0 * part.size * part.size / (tau * tau)),
    covariance: |part, met| -met * part.size * part.size,
    increment: |part, _, _| Increment::Normal(-2.0 * part.size * part.size),
    turned: |_, _| 0.0,
    ..Row::NOISE
};
