//! A C header with the whole model.

use crate::analysis::model::search::MAX_STATES;
use crate::analysis::model::state_space::si;
use crate::analysis::model::writers::{Axis, Takes, Writer, number};
use sagnac_records::allan::Unit;

pub(super) static C_HEADER: Writer = Writer {
    name: "c",
    file: "sagnac_noise.h",
    tool: "C and C++",
    convention: "SI units and two-sided densities: white is N in rad/sqrt(s), walk is K in rad/s/sqrt(s), quantization is the rms error of the angle in \
                 rad, sigma is the stationary standard deviation of a Markov state in rad/s; of accelerometers with m/s in place of rad",
    takes: Takes::ALL,
    text: |sheet| {
        let row = |axis: &Axis, unit: Unit| {
            let size = si(unit);
            let model = &axis.model;
            let padded = |values: Vec<f64>| {
                let zeros = std::iter::repeat_n(0.0, MAX_STATES - values.len());
                values.into_iter().chain(zeros).map(number).collect::<Vec<_>>().join(", ")
            };
            format!(
                "    {{{}, {}, {}, {}, {{{}}}, {{{}}}}},\n",
                number(size * model.white),
                number(size * model.walk),
                number(size * model.quantization),
                model.markov.len(),
                padded(model.markov.iter().map(|state| size * state.sigma).collect()),
                padded(model.markov.iter().map(|state| state.time_s).collect())
            )
        };
        let table = |axes: &[Axis], name: &str, unit: Unit| {
            let rows: String = axes.iter().map(|axis| row(axis, unit)).collect();
            let count = axes.len();
            let text = format!("static const struct sagnac_noise sagnac_{name}[{count}] = {{\n{rows}}};\n");
            if axes.is_empty() { String::new() } else { text }
        };
        // A name could end the comment.
        let heading: String =
            sheet.heading.iter().map(|line| format!(" * {}\n", line.replace("*/", "* /"))).collect();
        format!(
            "/*\n{heading} */\n#ifndef SAGNAC_NOISE_H\n#define SAGNAC_NOISE_H\n\nstruct sagnac_noise {{\n    double white;\n    double walk;\n    \
             double quantization;\n    int states;\n    double sigma[{MAX_STATES}];\n    double time_s[{MAX_STATES}];\n}};\n\n{}{}\n#endif\n",
            table(&sheet.gyros, "gyros", Unit::Angular),
            table(&sheet.accelerometers, "accelerometers", Unit::Acceleration)
        )
    },
};
