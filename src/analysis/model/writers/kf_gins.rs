//! The part `imunoise` of the configuration of KF-GINS.

use crate::analysis::model::writers::{Axis, Takes, Writer, list, number, sigma, three, time_s};

pub(super) static KF_GINS: Writer = Writer {
    name: "kf_gins",
    file: "kf_gins.yaml",
    tool: "KF-GINS",
    convention: "arw in deg/sqrt(h) and vrw in m/s/sqrt(h), of two-sided densities; gbstd in deg/h and abstd in mGal are stationary standard \
                 deviations with the correlation time corrtime in h, which all sensors share",
    takes: Takes { shares_time: true, ..Takes::STATE },
    text: |sheet| {
        let line = |axes: &[Axis], name: &str, values: [f64; 3]| match axes {
            [] => format!("#  {name}:  # nothing is known of this sensor\n"),
            _ => format!("  {name}: [{}]\n", list(values, ", ")),
        };
        let (gyros, accelerometers) = (&sheet.gyros, &sheet.accelerometers);
        let all = || gyros.iter().chain(accelerometers);
        let shared =
            all().find(|axis| !axis.model.markov.is_empty()).map_or(3600.0, |axis| time_s(&axis.model));
        // 1 µg·√s is 60 s·9.80665e-6 m/s² over √h, and 1 µg is 0.980665 mGal.
        sheet.comments("#")
            + "imunoise:\n"
            + &line(gyros, "arw", three(gyros, |model| model.white / 60.0))
            + &line(accelerometers, "vrw", three(accelerometers, |model| 60.0 * 9.806_65e-6 * model.white))
            + &line(gyros, "gbstd", three(gyros, sigma))
            + &line(accelerometers, "abstd", three(accelerometers, |model| 0.980_665 * sigma(model)))
            + "  # Scale factors, ppm: a record at rest does not show them.\n"
            + "  gsstd: [0.0, 0.0, 0.0]\n  asstd: [0.0, 0.0, 0.0]\n"
            + &format!("  corrtime: {}\n", number(shared / 3600.0))
    },
};
