//! Parameters of MATLAB's `imuSensor`.
//!
//! With `'NoiseType', 'single-sided'`, MATLAB draws white noise of NoiseDensity·√SampleRate, which has N = NoiseDensity, and
//! RandomWalk is K; the default, 'double-sided', divides densities by √2. MathWorks' example of Allan variances sets it for this
//! reason.

use crate::analysis::model::state_space::si;
use crate::analysis::model::writers::{Axis, Takes, Writer, list, plain_number, three};
use sagnac_records::allan::Unit;

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
