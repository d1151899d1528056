//! Whether a log is one that deviations can be taken of.

use crate::table::significant;

use super::error::LogError;
use super::{Channel, Data, Log};

/// Fewest samples that are analysed.
pub const LEAST_SAMPLES: usize = 16;

/// The most that a good gyro at rest shows, ″/s (°/h): the Earth's rotation on its axis, and 1 °/h of bias.
const AT_REST: f64 = 16.041_067;

/// One rad in °.
const DEGREES: f64 = 57.295_779_513_082_32;

/// Above this, ″/s, no gyro is at rest: 20 °/s is the bias of the worst.
const NEVER_AT_REST: f64 = 72_000.0;

/// Whether rates that look as if in another unit are refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitCheck {
    /// They are, with what to write instead.
    On,
    /// They are taken as they stand.
    Off,
}

impl Log {
    /// Refuses what says nothing: fewer than [`LEAST_SAMPLES`] samples, and all of them equal.
    ///
    /// With [`UnitCheck::On`] also numbers in rad whose mean rate is above the Earth's rotation and 1 °/h of bias, if
    /// in ° it would be within these, as those of a gyro at rest in °/s that were taken for rad/s; and any mean rate
    /// above 20 °/s. Only the mean is looked at, which no deviation depends on.
    ///
    /// # Errors
    /// The first of these, with its column.
    pub fn check(&self, unit: UnitCheck) -> Result<(), LogError> {
        for channel in &self.channels {
            self.check_samples(channel)?;
            if unit == UnitCheck::On && channel.unit.is_angular {
                self.check_rest(channel)?;
            }
        }
        Ok(())
    }

    fn check_samples(&self, channel: &Channel) -> Result<(), LogError> {
        let mut known = channel.samples.iter().copied().filter(|sample| !sample.is_nan());
        let there = known.clone().count();
        let name = &channel.name;
        if there < LEAST_SAMPLES {
            let samples = if there == 1 { "sample" } else { "samples" };
            let message = format!(
                "column {name} of {} has {there} {samples}, at least {LEAST_SAMPLES} are needed",
                self.file
            );
            let help = "record longer, or skip less; the rows of an array are samples, its columns axes";
            return Err(LogError::new(message, "this column", help, channel.place.clone()));
        }
        let first = known.next().unwrap_or(0.0);
        if known.all(|sample| sample == first) {
            let message =
                format!("column {name} of {} is constant: all {there} samples are {first}", self.file);
            let help = "is it the right column, and was the sensor on? a constant has no deviation to show";
            return Err(LogError::new(message, "this column", help, channel.place.clone()));
        }
        Ok(())
    }

    fn check_rest(&self, channel: &Channel) -> Result<(), LogError> {
        let Some(mean) = channel.mean_rate(self.data, self.step_s).map(f64::abs) else { return Ok(()) };
        let (name, file) = (&channel.name, &self.file);
        let shown = |rate: f64| {
            if rate < 3600.0 {
                format!("{} °/h", significant(rate, 3))
            } else {
                format!("{} °/s", significant(rate / 3600.0, 3))
            }
        };
        let in_rad = channel.unit.text.contains("rad");
        let help_off = "if the unit is right, say --unit-check off";
        if in_rad && mean > AT_REST && mean <= AT_REST * DEGREES {
            let message = format!(
                "column {name} of {file} looks like degrees taken for radians: its mean is {}, \
                 in degrees it would be {}, as a gyro at rest shows of the Earth's 15.04 °/h",
                shown(mean),
                shown(mean / DEGREES)
            );
            let other = if self.data == Data::Rate { "--unit deg/s" } else { "--unit deg" };
            let help = format!("give {other}; {help_off}");
            return Err(LogError::new(message, "this column", help, channel.place.clone()));
        }
        if mean > NEVER_AT_REST {
            let message =
                format!("column {name} of {file} has a mean rate of {}: no gyro at rest has", shown(mean));
            let help = format!("is {} its unit? is --data right? {help_off}", channel.unit.text);
            return Err(LogError::new(message, "this column", help, channel.place.clone()));
        }
        Ok(())
    }
}
