//! The whole model for programs of your own: a C header, MATLAB and JSON; and error models of inertial navigation toolboxes: KF-GINS,
//! NaveGo, PSINS and pyins.

use crate::analysis::model::search::MAX_STATES;
use crate::analysis::model::si;
use crate::analysis::model::tables::{ColumnModel, Models};
use crate::analysis::model::writers::{
    Axis, Takes, Writer, list, number, plain_number, sigma, three, time_s,
};
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

pub(super) static NAVEGO: Writer = Writer {
    name: "navego",
    file: "navego_imu.m",
    tool: "NaveGo",
    convention: "fields before imu_si_errors(): arw in deg/sqrt(h), vrw in m/s/sqrt(h), both of two-sided densities; gb_dyn in deg/s and ab_dyn in \
                 mg are for ins_gnss() and sqrt(2) times the standard deviation of the Markov state, because the filter drives it with \
                 gb_dyn/sqrt(gb_corr); gyro_gen() and acc_gen() take the standard deviation itself, which is in comments",
    takes: Takes::STATE,
    text: |sheet| {
        /// Lines for the fields of a sensor.
        fn fields(axes: &[Axis], names: [&str; 5], white: f64, bias: f64) -> String {
            if axes.is_empty() {
                return String::new();
            }
            let of_state = |factor: f64| three(axes, |model| factor * bias * sigma(model));
            let values = [
                three(axes, |model| white * model.white),
                [0.0; 3],
                [0.0; 3],
                of_state(core::f64::consts::SQRT_2),
                three(axes, time_s),
            ];
            let line = |(name, values): (&str, [f64; 3])| format!("imu.{name} = [{}];\n", list(values, " "));
            let all: String = names.into_iter().zip(values).map(line).collect();
            format!("{all}% For simulation: {}", line((names[3], of_state(1.0))))
        }
        let gyros =
            fields(&sheet.gyros, ["arw", "arrw", "gb_sta", "gb_dyn", "gb_corr"], 1.0 / 60.0, 1.0 / 3600.0);
        // 1 µg·√s is 60 s·9.80665e-6 m/s² over √h.
        let of_accelerometers = ["vrw", "vrrw", "ab_sta", "ab_dyn", "ab_corr"];
        let accelerometers = fields(&sheet.accelerometers, of_accelerometers, 60.0 * 9.806_65e-6, 1e-3);
        let rate = sheet
            .rate_hz()
            .map_or_else(String::new, |rate_hz| format!("imu.freq = {};\n", plain_number(rate_hz)));
        sheet.comments("%") + &gyros + &accelerometers + &rate
    },
};

pub(super) static PSINS: Writer = Writer {
    name: "psins",
    file: "psins_imuerr.m",
    tool: "PSINS",
    convention: "arguments of imuerrset(): web in deg/sqrt(h) and wdb in ug/sqrt(Hz), of two-sided densities; sqrtR0G in deg/h and sqrtR0A in ug are \
                 stationary standard deviations with correlation times TauG and TauA in s",
    takes: Takes::STATE,
    text: |sheet| {
        let column = |name: &str, values: [f64; 3]| format!("{name} = [{}];\n", list(values, "; "));
        let (gyros, accelerometers) = (&sheet.gyros, &sheet.accelerometers);
        sheet.comments("%")
            + "% Constant biases eb and db are those of turn-on, which a record does not show.\n"
            + &column("eb", [0.0; 3])
            + &column("db", [0.0; 3])
            + &column("web", three(gyros, |model| model.white / 60.0))
            + &column("wdb", three(accelerometers, |model| model.white))
            + &column("sqrtR0G", three(gyros, sigma))
            + &column("TauG", if gyros.is_empty() { [1.0; 3] } else { three(gyros, time_s) })
            + &column("sqrtR0A", three(accelerometers, sigma))
            + &column(
                "TauA",
                if accelerometers.is_empty() { [1.0; 3] } else { three(accelerometers, time_s) },
            )
            + "imuerr = imuerrset(eb, db, web, wdb, sqrtR0G, TauG, sqrtR0A, TauA);\n"
    },
};

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
