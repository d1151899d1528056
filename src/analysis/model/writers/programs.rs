//! The whole model for programs of your own: a C header, MATLAB and JSON.

use crate::analysis::model::search::MAX_STATES;
use crate::analysis::model::si;
use crate::analysis::model::tables::{ColumnModel, Models};
use crate::analysis::model::writers::{Axis, Takes, Writer, list, number, plain_number, three};
use sagnac_records::allan::Unit;
use sagnac_report::page::json;
use serde::Serialize;

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

pub(super) static MATLAB: Writer = Writer {
    name: "matlab",
    file: "imu_sensor.m",
    tool: "imuSensor of MATLAB",
    convention: "N in (rad/s)/sqrt(Hz) and K in (rad/s)*sqrt(Hz), which with the NoiseType single-sided are what imuSensor draws (its \
                 default, double-sided, would draw N/sqrt(2)); of accelerometers in (m/s^2)/sqrt(Hz) and (m/s^2)*sqrt(Hz)",
    takes: Takes::WALK,
    text: |sheet| {
        let sensor = |axes: &[Axis], variable: &str, unit: Unit| {
            let size = si(unit);
            let [density, walk] =
                [three(axes, |model| size * model.white), three(axes, |model| size * model.walk)]
                    .map(|values| list(values, " "));
            let text = format!(
                "{variable} = {variable}params('NoiseDensity', [{density}], 'RandomWalk', [{walk}], ...\n    'NoiseType', 'single-sided');\n"
            );
            if axes.is_empty() { String::new() } else { text }
        };
        let parts = [
            sensor(&sheet.gyros, "gyro", Unit::Angular),
            sensor(&sheet.accelerometers, "accel", Unit::Acceleration),
        ];
        let rate = sheet.rate_hz().map_or_else(String::new, |rate_hz| {
            format!(
                "% imu = imuSensor('accel-gyro', 'SampleRate', {}, 'Gyroscope', gyro);\n",
                plain_number(rate_hz)
            )
        });
        sheet.comments("%") + &parts.concat() + &rate
    },
};

/// The file: the models, of which a single one stands at the top too, where `navigation.filter` reads it.
#[derive(Serialize)]
struct File<'a> {
    heading: &'a [String],
    #[serde(flatten)]
    only: Option<&'a ColumnModel>,
    #[serde(flatten)]
    models: &'a Models,
}

pub(super) static JSON: Writer = Writer {
    name: "json",
    file: "model.json",
    tool: "programs of your own",
    convention: "units are part of the names of keys; matrices are in SI units, white noise and random walk are square roots of two-sided densities",
    takes: Takes::ALL,
    text: |sheet| {
        let models = Models::new(sheet.analysis);
        let only = if let [only] = &models.columns[..] { Some(only) } else { None };
        json(&File { heading: &sheet.heading, only, models: &models }) + "\n"
    },
};
