//! Files of estimators that take white noise and a random walk of each sensor: YAML files of visual-inertial tools, which have the
//! keys of Kalibr; covariances of gtsam's `PreintegrationCombinedParams`, for C++ and for Python; and parameters of EKF2, the filter of
//! the autopilot PX4, in a file that `QGroundControl` loads.

use std::ops::RangeInclusive;

use crate::analysis::model::si;
use crate::analysis::model::writers::{
    Axis, Sheet, Takes, Writer, largest, list, number, plain_number, three,
};
use sagnac_base::diagnostics::listed;
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::Unit;

const OF_KALIBR: &str = "square roots of two-sided densities per Hz, which are N in rad/s/sqrt(Hz) = rad/sqrt(s) and K in rad/s^2/sqrt(Hz); of \
                          accelerometers in m/s^2/sqrt(Hz) and m/s^3/sqrt(Hz)";

pub(super) static KALIBR: Writer = Writer {
    name: "kalibr",
    file: "kalibr.yaml",
    tool: "Kalibr",
    convention: OF_KALIBR,
    takes: Takes::WALK,
    text: |sheet| sheet.comments("#") + &keys(sheet, "", "/imu0"),
};

pub(super) static ALLAN_VARIANCE_ROS: Writer = Writer {
    name: "allan_variance_ros",
    file: "allan_variance_ros.yaml",
    tool: "what reads the imu.yaml of allan_variance_ros",
    convention: OF_KALIBR,
    takes: Takes::WALK,
    text: |sheet| sheet.comments("#") + &keys(sheet, "", "/sensors/imu"),
};

pub(super) static OPENVINS: Writer = Writer {
    name: "openvins",
    file: "kalibr_imu_chain.yaml",
    tool: "OpenVINS",
    convention: OF_KALIBR,
    takes: Takes::WALK,
    text: |sheet| {
        let rows = ["1.0, 0.0, 0.0, 0.0", "0.0, 1.0, 0.0, 0.0", "0.0, 0.0, 1.0, 0.0", "0.0, 0.0, 0.0, 1.0"];
        let rows: String = rows.into_iter().map(|row| format!("    - [{row}]\n")).collect();
        // OpenCV reads it and needs its directive first.
        format!(
            "%YAML:1.0\n{}imu0:\n  T_i_b:\n{rows}{}  time_offset: 0.0\n  model: \"kalibr\"\n",
            sheet.comments("#"),
            keys(sheet, "  ", "/imu0")
        )
    },
};

/// Part of its variance at the longest τ that a walk may add to a model without one.
const NEGLIGIBLE: f64 = 0.002;

/// A walk that raises no deviation by more than 0.1 %: Kalibr refuses a walk of 0.
fn least_walk(axes: &[Axis]) -> f64 {
    let of_axis = |axis: &Axis| {
        let [_, longest_s] = axis.column.target.taus();
        libm::sqrt(3.0 * NEGLIGIBLE * axis.model.variance(longest_s) / longest_s)
    };
    axes.iter().map(of_axis).fold(f64::INFINITY, f64::min)
}

/// The keys of both sensors; those of a sensor without columns are comments. `topic` is that of a record without one.
fn keys(sheet: &Sheet, indent: &str, topic: &str) -> String {
    let sensor = |axes: &[Axis], name: &str, unit: Unit, units: [&str; 2]| -> String {
        let size = si(unit);
        let values =
            [largest(axes, |model| model.white), largest(axes, |model| model.walk).max(least_walk(axes))];
        let keys = ["noise_density", "random_walk"].into_iter().zip(values).zip(units);
        let line = |((key, value), unit): ((&str, f64), &str)| match axes {
            [] => format!("#{indent}{name}_{key}:  # {unit}\n"),
            _ => format!("{indent}{name}_{key}: {}  # {unit}\n", number(size * value)),
        };
        let without = format!("# Nothing is known of {name}s; the tool needs their keys too.\n");
        let start = match axes {
            [] => without,
            [_] => String::new(),
            axes => {
                let names: Vec<&str> = axes.iter().map(|axis| axis.column.target.name.as_str()).collect();
                format!(
                    "{indent}# The largest values of {}, which the tool takes for all axes.\n",
                    listed(&names)
                )
            }
        };
        start + &keys.map(line).collect::<String>()
    };
    let units = ["m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)"];
    let rate = match sheet.rate_hz() {
        Some(rate_hz) => format!("{indent}update_rate: {}  # Hz\n", plain_number(rate_hz)),
        None => format!("#{indent}update_rate:  # Hz\n"),
    };
    sensor(&sheet.accelerometers, "accelerometer", Unit::Acceleration, units)
        + &sensor(&sheet.gyros, "gyroscope", Unit::Angular, ["rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)"])
        + &format!("{indent}rostopic: {}\n{rate}", sheet.analysis.source.topic.as_deref().unwrap_or(topic))
}

const OF_GTSAM: &str = "continuous covariances, which are two-sided densities: N^2 in (rad/s)^2/Hz and K^2 in (rad/s^2)^2/Hz; of accelerometers in \
                          (m/s^2)^2/Hz and (m/s^3)^2/Hz";

pub(super) static GTSAM_CPP: Writer = Writer {
    name: "gtsam_cpp",
    file: "gtsam_noise.h",
    tool: "gtsam in C++",
    convention: OF_GTSAM,
    takes: Takes::WALK,
    text: |sheet| {
        let line = |(name, values): (&str, [f64; 3])| {
            let name = name[..1].to_lowercase() + &name[1..];
            format!("  params.{name} = gtsam::Vector3({}).asDiagonal();\n", list(values, ", "))
        };
        let lines: String = covariances(sheet).into_iter().map(line).collect();
        format!(
            "{}#pragma once\n#include <gtsam/navigation/CombinedImuFactor.h>\n\n\
             inline void set_noise(gtsam::PreintegrationCombinedParams& params) {{\n{lines}}}\n",
            sheet.comments("//")
        )
    },
};

pub(super) static GTSAM_PYTHON: Writer = Writer {
    name: "gtsam_python",
    file: "gtsam_noise.py",
    tool: "gtsam in Python",
    convention: OF_GTSAM,
    takes: Takes::WALK,
    text: |sheet| {
        let line = |(name, values): (&str, [f64; 3])| {
            format!("    params.set{name}(np.diag([{}]))\n", list(values, ", "))
        };
        let lines: String = covariances(sheet).into_iter().map(line).collect();
        format!(
            "{}import numpy as np\n\n\ndef set_noise(params):\n    \"\"\"Sets the noise of a gtsam.PreintegrationCombinedParams.\"\"\"\n{lines}",
            sheet.comments("#")
        )
    },
};

/// The covariances by their names, without those of sensors without columns.
fn covariances(sheet: &Sheet) -> Vec<(&'static str, [f64; 3])> {
    let of = |axes: &[Axis], unit: Unit, names: [&'static str; 2]| {
        let square = |x: f64| si(unit) * si(unit) * x * x;
        let values = [three(axes, |model| square(model.white)), three(axes, |model| square(model.walk))];
        let all = names.into_iter().zip(values).collect();
        if axes.is_empty() { vec![] } else { all }
    };
    [
        of(&sheet.gyros, Unit::Angular, ["GyroscopeCovariance", "BiasOmegaCovariance"]),
        of(&sheet.accelerometers, Unit::Acceleration, ["AccelerometerCovariance", "BiasAccCovariance"]),
    ]
    .concat()
}

/// Per prediction of Δ, EKF2 adds (Δ·noise)² to the variance of the angle and (Δ·process noise)² to that of the bias of the rate. White
/// noise adds N²Δ and a random walk K²Δ, so that the parameters are N/√Δ in rad/s and K/√Δ in rad/s².
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

/// The step of the filter, µs: the requested one, or the default of PX4.
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
