//! Covariances of gtsam's `PreintegrationCombinedParams`, for C++ and for Python.

use crate::analysis::model::si;
use crate::analysis::model::writers::{Axis, Sheet, Takes, Writer, list, three};
use sagnac_records::allan::Unit;

const CONVENTION: &str = "continuous covariances, which are two-sided densities: N^2 in (rad/s)^2/Hz and K^2 in (rad/s^2)^2/Hz; of accelerometers in \
                          (m/s^2)^2/Hz and (m/s^3)^2/Hz";

pub(super) static CPP: Writer = Writer {
    name: "gtsam_cpp",
    file: "gtsam_noise.h",
    tool: "gtsam in C++",
    convention: CONVENTION,
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

pub(super) static PYTHON: Writer = Writer {
    name: "gtsam_python",
    file: "gtsam_noise.py",
    tool: "gtsam in Python",
    convention: CONVENTION,
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
