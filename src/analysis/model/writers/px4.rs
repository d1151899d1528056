//! Parameters of EKF2, the filter of the autopilot PX4, in a file that `QGroundControl` loads.
//!
//! Per prediction of Δ, EKF2 adds (Δ·noise)² to the variance of the angle and (Δ·process noise)² to that of the bias of the rate. White
//! noise adds N²Δ and a random walk K²Δ, so that the parameters are N/√Δ in rad/s and K/√Δ in rad/s².

use std::ops::RangeInclusive;

use crate::analysis::model::si;
use crate::analysis::model::writers::{Axis, Sheet, Takes, Writer, largest};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::Unit;

pub(super) static PX4: Writer = Writer {
    name: "px4",
    file: "px4.params",
    tool: "EKF2 of PX4",
    convention: "noise of the rate N/sqrt(T) in rad/s and of its bias K/sqrt(T) in rad/s^2, of which EKF2 adds the squares times T^2 per prediction \
                 of T; of accelerometers in m/s^2 and m/s^3",
    takes: Takes::WALK,
    text: |sheet| {
        let step_us = step_us(sheet);
        let gyros = [("EKF2_GYR_NOISE", 1e-4..=0.1), ("EKF2_GYR_B_NOISE", 0.0..=0.01)];
        let accelerometers = [("EKF2_ACC_NOISE", 0.01..=1.0), ("EKF2_ACC_B_NOISE", 0.0..=0.01)];
        format!(
            "{}# T is EKF2_PREDICT_US, {step_us} us, or the step of the IMU if that is longer.\n# Of several axes, the largest value.\n#\n\
             # Vehicle-Id\tComponent-Id\tName\tValue\tType\n{}{}1\t1\tEKF2_PREDICT_US\t{step_us}\t6\n",
            sheet.comments("#"),
            lines(&sheet.gyros, Unit::Angular, step_us, gyros),
            lines(&sheet.accelerometers, Unit::Acceleration, step_us, accelerometers),
        )
    },
};

/// Step of the filter, µs: that which was asked for, or the default of PX4.
fn step_us(sheet: &Sheet) -> u32 {
    sheet.analysis.request.filter_hz.map_or(10_000, |filter_hz| libm::round(1e6 / filter_hz).max(1.0) as u32)
}

/// The lines of a sensor; those of one without columns are left out. A value beyond the range in the documents of PX4 has a comment.
fn lines(axes: &[Axis], unit: Unit, step_us: u32, names: [(&str, RangeInclusive<f64>); 2]) -> String {
    if axes.is_empty() {
        return String::new();
    }
    let per_step = si(unit) / libm::sqrt(1e-6 * f64::from(step_us));
    let values = [largest(axes, |model| model.white), largest(axes, |model| model.walk)];
    let line = |((name, range), value): ((&str, RangeInclusive<f64>), f64)| {
        let value = per_step * value;
        let (low, high) = (range.start(), range.end());
        let beyond = match range.contains(&value) {
            true => String::new(),
            false => format!("# PX4 recommends {low} to {high} for the next parameter.\n"),
        };
        // Type 9 is a float of 32 bits.
        format!("{beyond}1\t1\t{name}\t{}\t9\n", significant(value, 6))
    };
    names.into_iter().zip(values).map(line).collect()
}
