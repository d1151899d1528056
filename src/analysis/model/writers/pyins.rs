//! Sensor models of pyins.

use crate::analysis::model::state_space::si;
use crate::analysis::model::writers::{Axis, Takes, Writer, list, three};
use sagnac_records::allan::Unit;

pub(super) static PYINS: Writer = Writer {
    name: "pyins",
    file: "pyins_model.py",
    tool: "pyins",
    convention: "square roots of two-sided densities in SI units: noise is N in rad/sqrt(s), bias_walk is K in rad/s/sqrt(s); of accelerometers in \
                 m/s/sqrt(s) and m/s^2/sqrt(s). bias_sd is what the walk accumulates over the longest averaging time; add the turn-on bias",
    takes: Takes::WALK,
    text: |sheet| {
        let sensor = |axes: &[Axis], name: &str, unit: Unit| {
            let longest_s = axes.iter().map(|axis| axis.column.target.taus()[1]).fold(0.0, f64::max);
            let walk = three(axes, |model| si(unit) * model.walk);
            let lines = [
                ("bias_sd", walk.map(|walk| walk * libm::sqrt(longest_s))),
                ("noise", three(axes, |model| si(unit) * model.white)),
                ("bias_walk", walk),
            ]
            .map(|(name, values)| format!("    \"{name}\": [{}],\n", list(values, ", ")));
            if axes.is_empty() { String::new() } else { format!("{name} = {{\n{}}}\n", lines.concat()) }
        };
        format!(
            "{}{}{}\n\ndef model(values):\n    \"\"\"The sensor model of pyins with the values of a sensor above.\"\"\"\n    \
             from pyins import inertial_sensor\n\n    \
             made = getattr(inertial_sensor, \"EstimationModel\", None) or inertial_sensor.InertialSensorModel\n    \
             return made(**values)\n",
            sheet.comments("#"),
            sensor(&sheet.gyros, "gyro", Unit::Angular),
            sensor(&sheet.accelerometers, "accel", Unit::Acceleration)
        )
    },
};
