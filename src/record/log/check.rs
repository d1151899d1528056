//! Check of a log before deviations are computed.

use crate::quantity::number::significant;

use crate::record::error::RecordError;
use crate::record::log::channel::{Channel, Log};
use crate::record::log::measure::Data;
use crate::record::log::samples::{DEGREES, Doubt, Fault};

/// Fewest samples for an analysis.
pub const LEAST_SAMPLES: usize = 16;

/// Whether rates that appear to be in a wrong unit are noted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitCheck {
    /// They are noted, with a suggestion.
    On,
    /// They are accepted.
    Off,
}

impl Log {
    /// Refuses channels that carry no information, by [`Samples::fault`](crate::record::log::samples::Samples::fault):
    /// those with fewer than [`LEAST_SAMPLES`] samples, or with all samples equal.
    ///
    /// With [`UnitCheck::On`] it notes channels whose mean rate looks like that of another unit, by
    /// [`Samples::doubt`](crate::record::log::samples::Samples::doubt). Only the mean is examined, which no deviation depends
    /// on.
    ///
    /// # Errors
    /// The first such fault, with its column.
    pub fn check(&mut self, unit: UnitCheck) -> Result<(), RecordError> {
        for channel in &self.channels {
            if let Some(fault) = channel.view(self.data, self.step_s).fault() {
                let (message, help) = self.told(channel, fault);
                return Err(RecordError::new(message, "this column", help, channel.place.clone()));
            }
        }
        if unit == UnitCheck::On {
            let doubts = self.channels.iter().filter_map(|channel| {
                let doubt = channel.view(self.data, self.step_s).doubt()?;
                Some(self.noted(channel, doubt))
            });
            let doubts: Vec<String> = doubts.collect();
            self.notes.extend(doubts);
        }
        Ok(())
    }

    /// The message and the help for a fault of a column.
    fn told(&self, channel: &Channel, fault: Fault) -> (String, String) {
        let column = format!("column {} of {}", channel.name, self.file);
        let (message, help) = match fault {
            Fault::TooFew(there) => {
                let samples = if there == 1 { "sample" } else { "samples" };
                let help = "record longer, or skip less; the rows of an array are samples, its columns axes";
                (format!("has {there} {samples}, at least {LEAST_SAMPLES} are needed"), help)
            }
            Fault::Constant { there, value } => {
                let help =
                    "is it the right column, and was the sensor on? a constant has no deviation to show";
                (format!("is constant: all {there} samples are {value}"), help)
            }
        };
        (format!("{column} {message}"), help.to_owned())
    }

    /// The note on a doubtful unit of a column.
    fn noted(&self, channel: &Channel, doubt: Doubt) -> String {
        let note = match doubt {
            Doubt::DegreesAsRadians(mean) => {
                let other = if self.data == Data::Rate { "`unit = deg/s`" } else { "`unit = deg`" };
                format!(
                    "may be in degrees, not in radians: its mean is {}, in degrees it would be {}, as a gyro at rest shows of \
                     the Earth's 15.04 °/h; if so, give {other}",
                    rate(mean),
                    rate(mean / DEGREES)
                )
            }
            Doubt::NeverAtRest(mean) => {
                let (unit, data) = (&channel.unit.text, self.data.name());
                format!(
                    "has a mean rate of {}, which no gyro at rest has: is {unit} its unit, and `data = {data}` right?",
                    rate(mean)
                )
            }
        };
        format!("column {} {note}", channel.name)
    }
}

/// A rate in ″/s, formatted for the user.
fn rate(mean: f64) -> String {
    if mean < 3600.0 {
        format!("{} °/h", significant(mean, 3))
    } else {
        format!("{} °/s", significant(mean / 3600.0, 3))
    }
}
