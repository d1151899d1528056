//! The error profile of an IMU for NaveGo, in the units of manufacturers that `imu_si_errors` converts.
//!
//! Its filter drives the bias with gb_dyn/√gb_corr, so the stationary standard deviation there is gb_dyn/√2: σ is written times
//! √2. Its simulator (`noise_b_dyn`) takes gb_dyn for σ, which is written in a comment.

use crate::analysis::model::writers::{Axis, Takes, Writer, list, plain_number, sigma, three, time_s};

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
