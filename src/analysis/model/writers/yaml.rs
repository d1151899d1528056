//! YAML files of visual-inertial tools, which have the keys of Kalibr.

use crate::analysis::model::si;
use crate::analysis::model::writers::{Axis, Sheet, Takes, Writer, largest, number, plain_number};
use sagnac_base::diagnostics::listed;
use sagnac_records::allan::Unit;

const CONVENTION: &str = "square roots of two-sided densities per Hz, which are N in rad/s/sqrt(Hz) = rad/sqrt(s) and K in rad/s^2/sqrt(Hz); of \
                          accelerometers in m/s^2/sqrt(Hz) and m/s^3/sqrt(Hz)";

pub(super) static KALIBR: Writer = Writer {
    name: "kalibr",
    file: "kalibr.yaml",
    tool: "Kalibr",
    convention: CONVENTION,
    takes: Takes::WALK,
    text: |sheet| sheet.comments("#") + &keys(sheet, "", "/imu0"),
};

pub(super) static ALLAN_VARIANCE_ROS: Writer = Writer {
    name: "allan_variance_ros",
    file: "allan_variance_ros.yaml",
    tool: "what reads the imu.yaml of allan_variance_ros",
    convention: CONVENTION,
    takes: Takes::WALK,
    text: |sheet| sheet.comments("#") + &keys(sheet, "", "/sensors/imu"),
};

pub(super) static OPENVINS: Writer = Writer {
    name: "openvins",
    file: "kalibr_imu_chain.yaml",
    tool: "OpenVINS",
    convention: CONVENTION,
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
