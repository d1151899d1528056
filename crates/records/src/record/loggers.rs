//! Loggers whose headers name quantities of known units without stating these.

use std::ops::Range;

use crate::record::names::Name;
use sagnac_base::quantity::number::significant;

/// A logger, found by names that its header has.
struct Logger {
    name: &'static str,
    /// Names without index of which all are in the header.
    has: &'static [&'static str],
    /// Names without index, or ends of them after a dot, with their units.
    units: &'static [(&'static str, &'static str)],
    /// Names of columns in the header of its gyro and of its accelerometer, so that their units are only proposed, unless the file
    /// is called like a gyro.
    samples: &'static [&'static str],
    /// What tells it from another maker's logger with the same names.
    signs: Option<Signs>,
}

/// What tells loggers with the same names and other units from each other.
struct Signs {
    /// Names of columns that only this one has.
    columns: &'static [&'static str],
    /// Texts that only this one writes above its header.
    above: &'static [&'static str],
    /// The column of times, and its unit, s.
    time: (&'static str, f64),
    /// Its sampling rates, Hz.
    rates_hz: Range<f64>,
}

/// In the order in which they are tried.
const LOGGERS: [Logger; 12] = [
    Logger {
        name: "PX4",
        has: &["timestamp_sample", "device_id", "x"],
        units: &[("timestamp", "us"), ("timestamp_sample", "us")],
        samples: &["x", "y", "z"],
        signs: None,
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
        signs: None,
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
        signs: None,
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
        signs: None,
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
        signs: None,
    },
    Logger {
        name: "OpenLog Artemis",
        has: &["rtcTime", "gX", "aX"],
        units: &[("gX", "dps"), ("gY", "dps"), ("gZ", "dps"), ("aX", "mg"), ("aY", "mg"), ("aZ", "mg")],
        samples: &[],
        signs: None,
    },
    Logger {
        name: "Sensor Logger",
        has: &["time", "seconds_elapsed"],
        units: &[("time", "ns"), ("seconds_elapsed", "s")],
        samples: &["x", "y", "z"],
        signs: None,
    },
    Logger {
        name: "Physics Toolbox",
        has: &["gFx"],
        units: &[
            ("time", "s"),
            ("wx", "rad/s"),
            ("wy", "rad/s"),
            ("wz", "rad/s"),
            ("gFx", "g"),
            ("gFy", "g"),
            ("gFz", "g"),
        ],
        samples: &[],
        signs: None,
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
        signs: Some(Signs {
            columns: &["Roll", "Quat_q0", "Mat[1][1]", "StatusWord"],
            above: &["// "],
            time: ("SampleTimeFine", 1e-4),
            rates_hz: 0.95..2100.0,
        }),
    },
    Logger {
        name: "Xsens DOT",
        has: &["SampleTimeFine"],
        units: &[
            ("SampleTimeFine", "us"),
            ("Gyr_X", "deg/s"),
            ("Gyr_Y", "deg/s"),
            ("Gyr_Z", "deg/s"),
            ("Acc_X", "m/s^2"),
            ("Acc_Y", "m/s^2"),
            ("Acc_Z", "m/s^2"),
        ],
        samples: &[],
        signs: Some(Signs {
            columns: &["Euler_X", "Quat_W", "dq_W"],
            above: &["DeviceTag:", "OutputRate:"],
            time: ("SampleTimeFine", 1e-6),
            rates_hz: 0.95..126.0,
        }),
    },
    Logger {
        name: "Kalibr",
        has: &["timestamp", "omega_x", "omega_y", "omega_z", "alpha_x", "alpha_y", "alpha_z"],
        units: &[
            ("timestamp", "ns"),
            ("omega_x", "rad/s"),
            ("omega_y", "rad/s"),
            ("omega_z", "rad/s"),
            ("alpha_x", "m/s^2"),
            ("alpha_y", "m/s^2"),
            ("alpha_z", "m/s^2"),
        ],
        samples: &[],
        signs: None,
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
        signs: None,
    },
];

/// What is known of the logger of a header.
#[derive(Debug, PartialEq)]
pub(crate) enum Known {
    /// Which it is, with its units.
    One(String),
    /// Those whose header it may be, with the settings that choose each.
    Several(Rivals),
}

/// Loggers with the same header and other units.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rivals {
    pub message: String,
    pub help: String,
}

/// Whether a column is the one that a logger calls `known`, perhaps after a dot.
fn is(name: &Name, known: &str) -> bool {
    let rest = name.base().strip_suffix(known);
    rest.is_some_and(|rest| rest.is_empty() || rest.ends_with('.')) || name.whole == known
}

impl Logger {
    fn unit(&self, name: &Name) -> Option<&'static str> {
        self.units.iter().find(|(known, _)| is(name, known)).map(|(_, unit)| *unit)
    }
}

impl Signs {
    /// Whether this header, below what is `above` it, has a sign of the logger.
    fn are_in(&self, names: &[Name], above: &str) -> bool {
        self.columns.iter().any(|known| names.iter().any(|name| is(name, known)))
            || self.above.iter().any(|text| above.contains(text))
    }

    /// The sampling rate by the steps of the times, Hz, where there are times.
    fn rate_hz(&self, names: &[Name], step: &dyn Fn(usize) -> Option<f64>) -> Option<f64> {
        let column = names.iter().position(|name| is(name, self.time.0))?;
        Some(1.0 / (step(column)? * self.time.1))
    }
}

/// Gives columns the units that the logger of this header has, and says which logger that is. `file` is the path of the file, `above` the
/// text above the header, and `step` has the steps of the numbers in a column.
pub(crate) fn complete(
    names: &mut [Name],
    file: &str,
    above: &str,
    step: &dyn Fn(usize) -> Option<f64>,
) -> Option<Known> {
    let has_all = |logger: &&Logger| logger.has.iter().all(|known| names.iter().any(|name| is(name, known)));
    let first = LOGGERS.iter().find(has_all)?;
    let differs = |other: &&Logger| {
        let units = |logger: &Logger, name| logger.unit(name).filter(|_| logger.signs.is_some());
        names
            .iter()
            .any(|name| units(first, name).zip(units(other, name)).is_some_and(|(unit, other)| unit != other))
    };
    let rivals: Vec<&Logger> = LOGGERS.iter().filter(has_all).filter(differs).collect();
    let mut why = String::new();
    let logger = if rivals.is_empty() {
        first
    } else {
        let all: Vec<(&Logger, &Signs)> = std::iter::once(first)
            .chain(rivals)
            .filter_map(|logger| logger.signs.as_ref().map(|signs| (logger, signs)))
            .collect();
        let rate_hz = |signs: &Signs| signs.rate_hz(names, step);
        let fits = |signs: &Signs| rate_hz(signs).is_none_or(|rate_hz| signs.rates_hz.contains(&rate_hz));
        let mut fitting: Vec<&Logger> = all
            .iter()
            .filter(|(_, signs)| signs.are_in(names, above) && fits(signs))
            .map(|of| of.0)
            .collect();
        if fitting.len() != 1 && !all.iter().any(|(_, signs)| signs.are_in(names, above)) {
            fitting = all.iter().filter(|(_, signs)| fits(signs)).map(|of| of.0).collect();
            let others = all.iter().filter(|(logger, _)| !fitting.iter().any(|of| of.name == logger.name));
            let others: Vec<String> = others
                .filter_map(|(logger, signs)| {
                    Some(format!("of {} these would be {} Hz", logger.name, significant(rate_hz(signs)?, 3)))
                })
                .collect();
            why = format!(", by the steps of its times ({})", others.join(", "));
        }
        let [logger] = fitting[..] else {
            return Some(Known::Several(Rivals::new(&all, names, step)));
        };
        logger
    };
    let mut units = vec![];
    let is_of_gyro = file.rsplit(['/', '\\']).next().is_some_and(|file| file.to_lowercase().contains("gyro"));
    for name in names.iter_mut().filter(|name| logger.samples.iter().any(|known| is(name, known))) {
        name.logger = Some(logger.name);
        if is_of_gyro && name.unit.is_none() {
            name.unit = Some("rad/s".to_owned());
            name.is_assumed = true;
            units.push(format!("{} rad/s", name.whole));
        }
    }
    if !units.is_empty() {
        why.push_str(", and the name of the file that of a gyro");
    }
    // A unit at the end of a name is what the logger means by it.
    let is_open =
        |name: &&mut Name| name.unit.as_ref().is_none_or(|unit| name.base().ends_with(unit.as_str()));
    for name in names.iter_mut().filter(is_open) {
        if let Some(unit) = logger.unit(name) {
            name.unit = Some(unit.to_owned());
            name.is_assumed = true;
            units.push(format!("{} {unit}", name.whole));
        }
    }
    (!units.is_empty())
        .then(|| Known::One(format!("the header is that of {}{why}: {}", logger.name, units.join(", "))))
}

impl Rivals {
    fn new(all: &[(&Logger, &Signs)], names: &[Name], step: &dyn Fn(usize) -> Option<f64>) -> Rivals {
        let makers: Vec<&str> = all.iter().map(|(logger, _)| logger.name).collect();
        let differs = |name: &&Name| {
            let mut units = all.iter().map(|(logger, _)| logger.unit(name));
            let first = units.next().flatten();
            first.is_some() && units.any(|unit| unit != first)
        };
        let is_sample = |name: &&Name| !all.iter().any(|(_, signs)| is(name, signs.time.0));
        let samples: Vec<&Name> = names.iter().filter(differs).filter(is_sample).collect();
        let columns: Vec<&str> = samples.iter().map(|name| name.whole.as_str()).collect();
        let option = |(logger, signs): &(&Logger, &Signs)| {
            let time = logger.units.iter().find(|(known, _)| *known == signs.time.0).map(|(_, unit)| *unit);
            let time = time.map(|unit| match unit.contains(' ') {
                true => format!("`time_unit = \"{unit}\"`"),
                false => format!("`time_unit = {unit}`"),
            });
            let unit =
                samples.first().and_then(|name| logger.unit(name)).map(|unit| format!("`unit = {unit}`"));
            let settings: Vec<String> = time.into_iter().chain(unit).collect();
            let rate = signs
                .rate_hz(names, step)
                .map_or(String::new(), |rate_hz| format!(", which makes {} Hz", significant(rate_hz, 4)));
            format!("{} for {}{rate}", settings.join(" with "), logger.name)
        };
        let options: Vec<String> = all.iter().map(option).collect();
        let columns =
            if columns.is_empty() { String::new() } else { format!("`column = {}` and ", columns.join(",")) };
        Rivals {
            message: format!("the header is that of {}, which differ in units", makers.join(" and of ")),
            help: format!("give {columns}{}", options.join(", or ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(header: &str, above: &str, step: f64) -> Option<Known> {
        let mut names: Vec<Name> = header.split(',').map(Name::read).collect();
        complete(&mut names, "log.csv", above, &|_| Some(step))
    }

    #[test]
    fn the_name_of_a_file_tells_a_gyro_from_an_accelerometer_with_the_same_header() {
        let header = "time,seconds_elapsed,z,y,x";
        for (file, unit) in
            [("a/Gyroscope.csv", Some("rad/s")), ("gyro/Accelerometer.csv", None), ("log.csv", None)]
        {
            let mut names: Vec<Name> = header.split(',').map(Name::read).collect();
            let known = complete(&mut names, file, "", &|_| Some(1e7));
            assert_eq!(names[2].unit.as_deref(), unit, "{file}");
            assert!(
                matches!(&known, Some(Known::One(note)) if note.contains("name of the file") == unit.is_some()),
                "{known:?}"
            );
        }
    }

    #[test]
    fn headers_of_two_makers_are_told_apart_by_signs_or_steps_or_not_at_all() {
        let bare = "PacketCounter,SampleTimeFine,Gyr_X";
        let dot = "SampleTimeFine,Euler_X,Gyr_X";
        let manager = "SampleTimeFine,Gyr_X,Roll";
        for (header, above, step, expected) in [
            (bare, "", 100.0, Some("Xsens MT Manager")),
            (bare, "", 25.0, Some("Xsens MT Manager")),
            (bare, "", 16_667.0, Some("Xsens DOT")),
            (bare, "", 33_333.0, Some("Xsens DOT")),
            (bare, "", 10_000.0, None),
            (bare, "", 8333.0, None),
            (bare, "OutputRate:,120Hz", 8333.0, Some("Xsens DOT")),
            (bare, "// Update Rate: 1.0Hz", 10_000.0, Some("Xsens MT Manager")),
            (dot, "", 8333.0, Some("Xsens DOT")),
            (dot, "", 100.0, None),
            (manager, "", 10_000.0, Some("Xsens MT Manager")),
            (manager, "", 16_667.0, None),
        ] {
            let found = known(header, above, step);
            let name = match &found {
                Some(Known::One(note)) => note.strip_prefix("the header is that of "),
                _ => None,
            };
            let name = name.map(|note| note.split([':', ',']).next().unwrap_or_default());
            assert_eq!(name, expected, "{header} below {above:?} with steps of {step}: {found:?}");
        }
        let Some(Known::Several(rivals)) = known(bare, "", 10_000.0) else { panic!("no rivals") };
        for piece in [
            "`time_unit = \"0.1 ms\"`",
            "`unit = rad/s`",
            "`time_unit = us`",
            "`unit = deg/s`",
            "1 Hz",
            "100 Hz",
        ] {
            assert!(rivals.help.contains(piece), "{piece} is missing in {}", rivals.help);
        }
    }
}
