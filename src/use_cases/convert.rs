//! Noise coefficients in the units and conventions of data sheets.

use sagnac_base::quantity::expression;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{UnitError, parse_in};
use serde::Serialize;

/// A value in other units and conventions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Conversion {
    /// The coefficient, by its dimension.
    pub quantity: &'static str,
    /// The value in each convention and unit.
    pub rows: Vec<Converted>,
    /// The lines of a noise file for a gyro with the value, each with the convention that it supposes.
    #[serde(skip)]
    pub lines: Vec<String>,
}

/// A value in one convention and unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Converted {
    /// The meaning of the number.
    pub convention: &'static str,
    /// The number.
    pub value: f64,
    /// The unit of the number.
    pub unit: &'static str,
}

impl Converted {
    /// The number with its unit, to six digits.
    pub fn text(&self) -> String {
        format!("{} {}", significant(self.value, 6), self.unit.replace("^2", "²"))
    }
}

/// A convention: what it makes of a value in base units (″, s and g), and the units in which it is written.
struct Convention {
    name: &'static str,
    convert: fn(f64) -> f64,
    units: &'static [&'static str],
    /// Whether it applies only to a value that is given as a density, in a unit over √Hz.
    only_densities: bool,
}

struct Coefficient {
    name: &'static str,
    /// The key of a noise file, and the conventions whose values it takes; empty where no noise file has it.
    key: &'static str,
    taken: &'static [&'static str],
    conventions: &'static [Convention],
}

const fn convention(
    name: &'static str,
    convert: fn(f64) -> f64,
    units: &'static [&'static str],
) -> Convention {
    Convention { name, convert, units, only_densities: false }
}

/// The flat minimum of the Allan deviation of flicker of coefficient B, over B: √(2 ln 2/π).
const FLAT: f64 = 0.664_282_466_894_803_2;

fn same(x: f64) -> f64 {
    x
}

fn one_sided(x: f64) -> f64 {
    x * core::f64::consts::SQRT_2
}

fn of_one_sided(x: f64) -> f64 {
    x * core::f64::consts::FRAC_1_SQRT_2
}

fn squared(x: f64) -> f64 {
    x * x
}

fn twice_squared(x: f64) -> f64 {
    2.0 * x * x
}

fn root(x: f64) -> f64 {
    libm::sqrt(x)
}

fn root_of_half(x: f64) -> f64 {
    libm::sqrt(0.5 * x)
}

fn minimum(x: f64) -> f64 {
    FLAT * x
}

fn of_minimum(x: f64) -> f64 {
    x / FLAT
}

fn pulse(x: f64) -> f64 {
    libm::sqrt(12.0) * x
}

fn of_pulse(x: f64) -> f64 {
    x / libm::sqrt(12.0)
}

const GIVEN_ONE_SIDED: &str = "N, if the density given is one-sided";
const OF_MINIMUM: &str = "B, of this minimum of the Allan deviation, where N and K add nothing";

/// Gyros first, then accelerometers.
const COEFFICIENTS: [Coefficient; 11] = [
    Coefficient {
        name: "angle random walk N",
        key: "angle_random_walk",
        taken: &["N", GIVEN_ONE_SIDED],
        conventions: &[
            convention("N", same, &["°/√h", "″/√s", "rad/√s"]),
            convention("density of the rate, two-sided", same, &["°/h/√Hz", "°/s/√Hz", "rad/s/√Hz"]),
            convention("density of the rate, one-sided", one_sided, &["°/h/√Hz", "°/s/√Hz", "rad/s/√Hz"]),
            convention("power density, two-sided", squared, &["(°/s)^2/Hz", "(rad/s)^2/Hz"]),
            convention("power density, one-sided", twice_squared, &["(°/s)^2/Hz", "(rad/s)^2/Hz"]),
            convention("Allan deviation at τ = 1 s", same, &["°/h"]),
            Convention {
                only_densities: true,
                ..convention(GIVEN_ONE_SIDED, of_one_sided, &["°/√h", "rad/√s"])
            },
        ],
    },
    Coefficient {
        name: "rate: bias instability B, or the minimum of an Allan deviation",
        key: "bias_instability",
        taken: &["rate", OF_MINIMUM],
        conventions: &[
            convention("rate", same, &["°/h", "″/s", "°/s", "rad/s"]),
            convention("minimum of the Allan deviation, of this B", minimum, &["°/h", "rad/s"]),
            convention(OF_MINIMUM, of_minimum, &["°/h", "rad/s"]),
        ],
    },
    Coefficient {
        name: "rate random walk K",
        key: "rate_random_walk",
        taken: &["K"],
        conventions: &[
            convention("K", same, &["°/h/√h", "°/s/√s", "rad/s/√s", "rad/s^2/√Hz"]),
            convention("Allan deviation at τ = 3 s", same, &["°/h"]),
        ],
    },
    Coefficient {
        name: "rate ramp R",
        key: "rate_ramp",
        taken: &["R"],
        conventions: &[convention("R", same, &["°/h/h", "°/s^2", "rad/s^2"])],
    },
    Coefficient {
        name: "angle: quantization noise Q, or a pulse",
        key: "quantization",
        taken: &["angle", "Q of a readout, of this pulse"],
        conventions: &[
            convention("angle", same, &["″", "°", "µrad", "rad"]),
            convention("pulse of a readout, of this Q", pulse, &["″", "µrad"]),
            convention("Q of a readout, of this pulse", of_pulse, &["″", "µrad"]),
        ],
    },
    Coefficient {
        name: "power density of a rate",
        key: "angle_random_walk",
        taken: &["N, if it is two-sided", "N, if it is one-sided"],
        conventions: &[
            convention("power density", same, &["(°/s)^2/Hz", "(rad/s)^2/Hz"]),
            convention("N, if it is two-sided", root, &["°/√h", "°/s/√Hz", "rad/s/√Hz"]),
            convention("N, if it is one-sided", root_of_half, &["°/√h", "°/s/√Hz", "rad/s/√Hz"]),
        ],
    },
    Coefficient {
        name: "velocity random walk N",
        key: "",
        taken: &[],
        conventions: &[
            convention("N", same, &["m/s/√h", "m/s/√s"]),
            convention("density of the acceleration, two-sided", same, &["µg/√Hz", "m/s^2/√Hz"]),
            convention("density of the acceleration, one-sided", one_sided, &["µg/√Hz", "m/s^2/√Hz"]),
            convention("Allan deviation at τ = 1 s", same, &["µg", "m/s^2"]),
            Convention {
                only_densities: true,
                ..convention(GIVEN_ONE_SIDED, of_one_sided, &["m/s/√h", "m/s/√s"])
            },
        ],
    },
    Coefficient {
        name: "acceleration: bias instability B, or the minimum of an Allan deviation",
        key: "",
        taken: &[],
        conventions: &[
            convention("acceleration", same, &["µg", "mg", "m/s^2"]),
            convention("minimum of the Allan deviation, of this B", minimum, &["µg", "m/s^2"]),
            convention(OF_MINIMUM, of_minimum, &["µg", "m/s^2"]),
        ],
    },
    Coefficient {
        name: "acceleration random walk K",
        key: "",
        taken: &[],
        conventions: &[convention("K", same, &["µg/√h", "m/s^2/√h", "m/s^2/√s"])],
    },
    Coefficient {
        name: "velocity: quantization noise Q, or a pulse",
        key: "",
        taken: &[],
        conventions: &[
            convention("velocity", same, &["mm/s", "m/s"]),
            convention("pulse of a readout, of this Q", pulse, &["mm/s"]),
            convention("Q of a readout, of this pulse", of_pulse, &["mm/s"]),
        ],
    },
    Coefficient {
        name: "power density of an acceleration",
        key: "",
        taken: &[],
        conventions: &[
            convention("power density", same, &["g^2/Hz", "(m/s^2)^2/Hz"]),
            convention("N, if it is two-sided", root, &["m/s/√h", "µg/√Hz"]),
            convention("N, if it is one-sided", root_of_half, &["m/s/√h", "µg/√Hz"]),
        ],
    },
];

/// Converts a coefficient such as `0.0135 deg/s/sqrt(Hz)` into the units and conventions of data sheets.
///
/// N is that of IEEE 952: N² is the two-sided power density of white noise, and the rms angle after a time t is N√t. Spectrum
/// analysers and many data sheets give one-sided densities, which are √2 times as large.
///
/// # Errors
/// The text is no number with a unit, or no coefficient has such a unit.
///
/// # Example
/// ```
/// let found = sagnac::use_cases::convert("0.0135 deg/s/sqrt(Hz)")?;
/// assert_eq!((found.quantity, found.rows[0].text().as_str()), ("angle random walk N", "0.81 °/√h"));
/// # Ok::<(), sagnac_base::quantity::UnitError>(())
/// ```
pub fn convert(text: &str) -> Result<Conversion, UnitError> {
    let first = COEFFICIENTS.each_ref().map(|coefficient| coefficient.conventions[0].units[0]);
    let (value, place) = parse_in(text, &first)?;
    let Coefficient { name, key, taken, conventions } = &COEFFICIENTS[place];
    let base = value * expression::parse(first[place])?.factor;
    let mut rows = Vec::new();
    for one in conventions.iter().filter(|one| !one.only_densities || text.contains("Hz")) {
        for &unit in one.units {
            let value = (one.convert)(base) / expression::parse(unit)?.factor;
            // A negative power density has no root, and a square may be too large.
            if !value.is_finite() {
                return Err(UnitError::NotFinite(text.to_owned()));
            }
            rows.push(Converted { convention: one.name, value, unit });
        }
    }
    let of = |convention: &&str| rows.iter().find(|row| row.convention == *convention);
    let line = |row: &Converted| {
        let is_density = row.convention == "N" && text.contains("Hz");
        let meaning = if is_density { "N, if the density given is two-sided" } else { row.convention };
        format!("{key} = \"{}\"  # {meaning}", row.text())
    };
    let lines = taken.iter().filter_map(of).map(line).collect();
    Ok(Conversion { quantity: name, rows, lines })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_of_a_coefficient_is_read_back_as_it() {
        for Coefficient { name, conventions, .. } in &COEFFICIENTS {
            let own = &conventions[0];
            for unit in own.units {
                let found = convert(&format!("2.5 {unit}")).unwrap();
                assert_eq!(found.quantity, *name, "{unit}");
                let same = found.rows.iter().find(|row| row.unit == *unit).unwrap();
                assert!((same.value - 2.5).abs() < 1e-11, "{name}: {unit}: {}", same.value);
            }
        }
    }

    /// Known pairs of IEEE 952, of data sheets and of textbooks.
    #[test]
    fn conversions_are_those_of_the_standard() {
        let value = |text: &str, convention: &str, unit: &str| {
            let found = convert(text).unwrap();
            let is_it = |row: &&Converted| row.convention.starts_with(convention) && row.unit == unit;
            found.rows.iter().find(is_it).unwrap_or_else(|| panic!("{text}: {convention}, {unit}")).value
        };
        let near =
            |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        near(value("1 deg/h/sqrt(Hz)", "N", "°/√h"), 1.0 / 60.0);
        near(value("1 deg/s/sqrt(Hz)", "N", "°/√h"), 60.0);
        near(value("60 deg/sqrt(h)", "density of the rate, two-sided", "°/s/√Hz"), 1.0);
        near(value("60 deg/sqrt(h)", "density of the rate, one-sided", "°/s/√Hz"), 2.0_f64.sqrt());
        near(value("0.1 deg/s/√Hz", GIVEN_ONE_SIDED, "°/√h"), 6.0 / 2.0_f64.sqrt());
        near(value("4 (deg/s)^2/Hz", "N, if it is two-sided", "°/√h"), 120.0);
        near(value("4 mdps/rtHz", "N", "°/√h"), 0.24);
        near(value("1 rad/s", "rate", "°/h"), 180.0 / core::f64::consts::PI * 3600.0);
        near(value("0.664282466894803 deg/h", "B, of this minimum", "°/h"), 1.0);
        near(value("100 ug/sqrt(Hz)", "N", "m/s/√h"), 100e-6 * 9.80665 * 60.0);
        near(value("12 arcsec", "Q of a readout", "″"), 12.0_f64.sqrt());
        near(value("1 deg/h/sqrt(h)", "Allan deviation at τ = 3 s", "°/h"), 1.0 / 60.0);
    }

    #[test]
    fn lines_of_a_noise_file_are_read_by_studies() {
        let texts = [
            "0.2 deg/√h",
            "0.005 deg/s/√Hz",
            "1.2 deg/h",
            "0.01 deg/h/√h",
            "0.1 deg/h/h",
            "2 arcsec",
            "4 (deg/s)^2/Hz",
        ];
        for text in texts {
            let lines = convert(text).unwrap().lines;
            assert!(!lines.is_empty(), "{text}");
            for line in lines {
                let noise = sagnac_engine::noise::Noise::parse("noise.toml", &line);
                assert!(noise.is_ok(), "{line}: {:?}", noise.err());
            }
        }
        assert_eq!(convert("1.2 deg/h").unwrap().lines[0], "bias_instability = \"1.2 °/h\"  # rate");
        assert!(convert("100 ug/√Hz").unwrap().lines.is_empty());
    }

    #[test]
    fn texts_that_are_no_coefficient_are_refused() {
        for (text, piece) in [
            ("5", "unit is missing"),
            ("fast", "number"),
            ("5 s", "is a time"),
            ("5 deg/furlong", "not a known unit"),
            ("-4 (deg/s)^2/Hz", "not a finite number"),
            ("1e200 deg/h/sqrt(Hz)", "not a finite number"),
        ] {
            let error = convert(text).unwrap_err().to_string();
            assert!(error.contains(piece), "{text}: {error}");
        }
    }
}
