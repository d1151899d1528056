//! The temperature recorded with the samples of a log.

use crate::record::error::RecordError;
use crate::record::recording::Recording;

/// The column of a temperature.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Thermometer {
    /// Its name, or its number from 1.
    pub column: String,
    /// Its unit; if absent, that in the header, or °C.
    pub unit: Option<String>,
}

/// A unit of temperature: its spellings in lower case without blanks, its size in K, and its zero in °C.
pub(crate) struct Degree {
    spellings: &'static [&'static str],
    size: f64,
    zero: f64,
}

const DEGREES: [Degree; 3] = [
    Degree {
        spellings: &["°c", "ºc", "℃", "degc", "deg_c", "c", "celsius", "degreescelsius"],
        size: 1.0,
        zero: 0.0,
    },
    Degree { spellings: &["k", "kelvin", "degk"], size: 1.0, zero: -273.15 },
    Degree {
        spellings: &["°f", "ºf", "℉", "degf", "deg_f", "f", "fahrenheit", "degreesfahrenheit"],
        size: 5.0 / 9.0,
        zero: -160.0 / 9.0,
    },
];

/// Accepted units, for messages.
const ACCEPTED: &str = "give its unit as in `temperature_unit = K`; accepted: °C (degC, C, celsius), K, °F (degF, F, fahrenheit)";

impl Degree {
    pub(crate) fn of(text: &str) -> Option<&'static Degree> {
        let text: String = text.chars().filter(|c| !c.is_whitespace()).flat_map(char::to_lowercase).collect();
        DEGREES.iter().find(|degree| degree.spellings.contains(&text.as_str()))
    }

    /// Numbers in this unit in °C.
    pub(crate) fn celsius(&self, mut numbers: Vec<f64>) -> Vec<f64> {
        numbers.iter_mut().for_each(|number| *number = *number * self.size + self.zero);
        numbers
    }

    /// The unit at the end of a name such as `temp_degC` or `temp C`.
    fn at_the_end(name: &str) -> Option<&'static Degree> {
        let (_, unit) = name.rsplit_once(['_', ' '])?;
        Degree::of(unit)
    }
}

impl Thermometer {
    /// The unit of its column in a file; `notes` receives it where it is assumed.
    ///
    /// # Errors
    /// The unit is unknown.
    pub(crate) fn degree(
        &self,
        file: &Recording,
        column: usize,
        notes: &mut Vec<String>,
    ) -> Result<&'static Degree, RecordError> {
        let name = file.names().get(column);
        match self.unit.as_deref().or(name.and_then(|name| name.unit.as_deref())) {
            Some(unit) => Degree::of(unit).ok_or_else(|| {
                let message = format!(
                    "`{unit}` is not a unit of temperature, for the temperature {}",
                    file.title(column)
                );
                file.refuse(Some(column), &message, "of this column", ACCEPTED)
            }),
            None => Ok(name.and_then(|name| Degree::at_the_end(&name.whole)).unwrap_or_else(|| {
                notes.push(format!("the temperature {} is taken to be in °C", file.title(column)));
                &DEGREES[0]
            })),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_as_loggers_spell_them() {
        for (text, zero) in [("degC", 0.0), ("° C", 0.0), ("K", -273.15), ("Celsius", 0.0)] {
            assert_eq!(Degree::of(text).map(|degree| degree.zero), Some(zero), "{text}");
        }
        for (name, size) in [("temp_degC", 1.0), ("Temp F", 5.0 / 9.0), ("board_temp_K", 1.0)] {
            assert_eq!(Degree::at_the_end(name).map(|degree| degree.size), Some(size), "{name}");
        }
        for text in ["deg", "", "s", "temp"] {
            assert!(Degree::of(text).is_none() && Degree::at_the_end(text).is_none(), "{text}");
        }
        let boiling = Degree::of("°F").unwrap().celsius(vec![212.0, 32.0]);
        assert!((boiling[0] - 100.0).abs() < 1e-12 && boiling[1].abs() < 1e-12, "{boiling:?}");
    }
}
