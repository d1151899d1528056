//! Check of a log before deviations are computed.

use crate::quantity::number::significant;

use crate::record::error::RecordError;
use crate::record::log::channel::{Channel, Log};
use crate::record::log::measure::Data;
use crate::record::log::samples::{DEGREES, Fault};

/// Fewest samples for an analysis.
pub const LEAST_SAMPLES: usize = 16;

/// Whether rates that appear to be in a wrong unit are refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitCheck {
    /// They are refused, with a suggestion.
    On,
    /// They are accepted.
    Off,
}

impl Log {
    /// Refuses channels that carry no information, by [`Samples::fault`](crate::record::log::samples::Samples::fault):
    /// those with fewer than [`LEAST_SAMPLES`] samples, or with all samples equal.
    ///
    /// With [`UnitCheck::On`] it also refuses any mean rate above 20 °/s, and numbers in rad whose mean rate is above
    /// the Earth's rotation plus 1 °/h of bias but would be below it in °, like those of a gyro at rest in °/s that
    /// were taken for rad/s. Only the mean is examined, which no deviation depends on.
    ///
    /// # Errors
    /// The first such fault, with its column.
    pub fn check(&self, unit: UnitCheck) -> Result<(), RecordError> {
        for channel in &self.channels {
            if let Some(fault) = channel.view(self.data, self.step_s).fault(unit) {
                let (message, help) = self.told(channel, fault);
                return Err(RecordError::new(message, "this column", help, channel.place.clone()));
            }
        }
        Ok(())
    }

    /// The message and the help for a fault of a column.
    fn told(&self, channel: &Channel, fault: Fault) -> (String, String) {
        let column = format!("column {} of {}", channel.name, self.file);
        let help_off = "if the unit is right, say `unit_check = off`";
        let (message, help) = match fault {
            Fault::TooFew(there) => {
                let samples = if there == 1 { "sample" } else { "samples" };
                let help = "record longer, or skip less; the rows of an array are samples, its columns axes";
                (format!("has {there} {samples}, at least {LEAST_SAMPLES} are needed"), help.to_owned())
            }
            Fault::Constant { there, value } => {
                let help =
                    "is it the right column, and was the sensor on? a constant has no deviation to show";
                (format!("is constant: all {there} samples are {value}"), help.to_owned())
            }
            Fault::DegreesAsRadians(mean) => {
                let other = if self.data == Data::Rate { "`unit = deg/s`" } else { "`unit = deg`" };
                let message = format!(
                    "looks like degrees taken for radians: its mean is {}, in degrees it would be {}, as a gyro at rest \
                     shows of the Earth's 15.04 °/h",
                    rate(mean),
                    rate(mean / DEGREES)
                );
                (message, format!("give {other}; {help_off}"))
            }
            Fault::NeverAtRest(mean) => {
                let (unit, data) = (&channel.unit.text, self.data.name());
                let help = format!("is {unit} its unit? is `data = {data}` right? {help_off}");
                (format!("has a mean rate of {}, which no gyro at rest has", rate(mean)), help)
            }
        };
        (format!("{column} {message}"), help)
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
