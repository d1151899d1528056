//! Loggers whose headers name quantities of known units without stating these.

use crate::record::names::Name;

/// A logger, found by names that its header has.
struct Logger {
    name: &'static str,
    /// Names without index of which all are in the header.
    has: &'static [&'static str],
    /// Names without index, or ends of them after a dot, with their units.
    units: &'static [(&'static str, &'static str)],
    /// Names of columns in the header of its gyro and of its accelerometer, so that their units are only proposed.
    samples: &'static [&'static str],
}

/// In the order in which they are tried.
const LOGGERS: [Logger; 10] = [
    Logger {
        name: "PX4",
        has: &["timestamp_sample", "device_id", "x"],
        units: &[("timestamp", "us"), ("timestamp_sample", "us")],
        samples: &["x", "y", "z"],
    },
    Logger {
        name: "PX4",
        has: &["timestamp", "gyro_rad"],
        units: &[
            ("timestamp", "us"),
            ("timestamp_sample", "us"),
            ("gyro_rad", "rad/s"),
            ("gyro_integral_dt", "us"),
            ("accelerometer_integral_dt", "us"),
        ],
        samples: &[],
    },
    Logger {
        name: "PX4",
        has: &["timestamp", "delta_angle"],
        units: &[
            ("timestamp", "us"),
            ("timestamp_sample", "us"),
            ("delta_angle", "rad"),
            ("delta_velocity", "m/s"),
            ("delta_angle_dt", "us"),
            ("delta_velocity_dt", "us"),
        ],
        samples: &[],
    },
    Logger {
        name: "ArduPilot",
        has: &["TimeUS", "GyrX"],
        units: &[
            ("TimeUS", "us"),
            ("SampleUS", "us"),
            ("GyrX", "rad/s"),
            ("GyrY", "rad/s"),
            ("GyrZ", "rad/s"),
            ("AccX", "m/s^2"),
            ("AccY", "m/s^2"),
            ("AccZ", "m/s^2"),
        ],
        samples: &[],
    },
    Logger {
        name: "ROS",
        has: &["angular_velocity.x"],
        units: &[
            ("time", "ns"),
            ("stamp", "ns"),
            ("angular_velocity.x", "rad/s"),
            ("angular_velocity.y", "rad/s"),
            ("angular_velocity.z", "rad/s"),
            ("linear_acceleration.x", "m/s^2"),
            ("linear_acceleration.y", "m/s^2"),
            ("linear_acceleration.z", "m/s^2"),
        ],
        samples: &[],
    },
    Logger {
        name: "OpenLog Artemis",
        has: &["rtcTime", "gX", "aX"],
        units: &[("gX", "dps"), ("gY", "dps"), ("gZ", "dps"), ("aX", "mg"), ("aY", "mg"), ("aZ", "mg")],
        samples: &[],
    },
    Logger {
        name: "Sensor Logger",
        has: &["time", "seconds_elapsed"],
        units: &[("time", "ns"), ("seconds_elapsed", "s")],
        samples: &["x", "y", "z"],
    },
    Logger {
        name: "Physics Toolbox",
        has: &["gFx"],
        units: &[("wx", "rad/s"), ("wy", "rad/s"), ("wz", "rad/s"), ("gFx", "g"), ("gFy", "g"), ("gFz", "g")],
        samples: &[],
    },
    Logger {
        name: "Xsens MT Manager",
        has: &["SampleTimeFine"],
        units: &[
            ("SampleTimeFine", "0.1 ms"),
            ("Gyr_X", "rad/s"),
            ("Gyr_Y", "rad/s"),
            ("Gyr_Z", "rad/s"),
            ("Acc_X", "m/s^2"),
            ("Acc_Y", "m/s^2"),
            ("Acc_Z", "m/s^2"),
        ],
        samples: &[],
    },
    Logger {
        name: "VectorNav",
        has: &["AngularRateX"],
        units: &[
            ("TimeStartup", "ns"),
            ("AngularRateX", "rad/s"),
            ("AngularRateY", "rad/s"),
            ("AngularRateZ", "rad/s"),
            ("AccelX", "m/s^2"),
            ("AccelY", "m/s^2"),
            ("AccelZ", "m/s^2"),
        ],
        samples: &[],
    },
];

/// Gives columns the units that the logger of this header has, and says which logger that is.
pub(crate) fn complete(names: &mut [Name]) -> Option<String> {
    let is = |name: &Name, known: &str| {
        let rest = name.base().strip_suffix(known);
        rest.is_some_and(|rest| rest.is_empty() || rest.ends_with('.'))
    };
    let logger = LOGGERS
        .iter()
        .find(|logger| logger.has.iter().all(|known| names.iter().any(|name| is(name, known))))?;
    for name in names.iter_mut().filter(|name| logger.samples.iter().any(|known| is(name, known))) {
        name.logger = Some(logger.name);
    }
    let mut units = vec![];
    // A unit at the end of a name is what the logger means by it.
    let is_open =
        |name: &&mut Name| name.unit.as_ref().is_none_or(|unit| name.base().ends_with(unit.as_str()));
    for name in names.iter_mut().filter(is_open) {
        if let Some((_, unit)) = logger.units.iter().find(|(known, _)| is(name, known)) {
            name.unit = Some((*unit).to_owned());
            name.is_assumed = true;
            units.push(format!("{} {unit}", name.whole));
        }
    }
    (!units.is_empty()).then(|| format!("the header is that of {}: {}", logger.name, units.join(", ")))
}
