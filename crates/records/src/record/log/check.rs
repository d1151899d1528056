//! Check of a log before deviations are computed.

use sagnac_base::quantity::number::significant;

use crate::allan::Unit as Curves;
use crate::record::error::RecordError;
use crate::record::log::channel::{Channel, Log};
use crate::record::log::doubt::{DEGREES, Doubt};
use crate::record::log::measure::Data;
use crate::record::log::samples::Fault;

/// Fewest samples for an analysis.
pub const MIN_SAMPLES: usize = 16;

/// Axes of a sensor.
const AXES: usize = 3;

/// Whether rates and accelerations that appear to be in a wrong unit are noted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitCheck {
    /// They are noted, with a suggestion.
    On,
    /// They are accepted.
    Off,
}

impl Log {
    /// Refuses channels that carry no information, by [`Samples::fault`](crate::record::log::samples::Samples::fault):
    /// those with fewer than [`MIN_SAMPLES`] samples, or with all samples equal.
    ///
    /// With [`UnitCheck::On`] it notes channels whose mean looks like that of another unit, by
    /// [`Doubt`]. Only the mean is examined, which no deviation depends on. Gravity is sought
    /// in up to three accelerometers of one unit together.
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
            let doubts: Vec<String> = self.sensors().iter().filter_map(|axes| self.doubt(axes)).collect();
            self.notes.extend(doubts);
        }
        Ok(())
    }

    /// The channels whose means belong together: each gyro by itself, and the axes of accelerometers.
    fn sensors(&self) -> Vec<Vec<&Channel>> {
        let mut sensors: Vec<Vec<&Channel>> = Vec::new();
        for channel in &self.channels {
            let is_of = |axes: &&mut Vec<&Channel>| {
                channel.unit.curves == Curves::Acceleration
                    && axes[0].unit == channel.unit
                    && axes.len() < AXES
            };
            match sensors.iter_mut().find(is_of) {
                Some(axes) => axes.push(channel),
                None => sensors.push(vec![channel]),
            }
        }
        sensors
    }

    /// The note on the unit of some axes, if it is doubtful.
    fn doubt(&self, axes: &[&Channel]) -> Option<String> {
        let means = axes.iter().map(|channel| channel.view(self.data, self.step_s).mean_rate());
        let means: Vec<f64> = means.collect::<Option<_>>()?;
        let doubt = Doubt::of(means.into_iter().fold(0.0, libm::hypot), &axes[0].unit, self.data)?;
        let has_mean = |axis: &&Channel| axis.view(self.data, self.step_s).has_mean();
        let is_known = !matches!(doubt, Doubt::DegreesAsRadians(_)) || axes.iter().all(has_mean);
        let is_guessed = axes.iter().any(|axis| axis.is_unit_guessed);
        (is_known && (is_guessed || doubt.is_strong())).then(|| self.noted(axes, doubt))
    }

    /// The message and the help for a fault of a column.
    fn told(&self, channel: &Channel, fault: Fault) -> (String, String) {
        let column = format!("column {} of {}", channel.name, self.file);
        let (message, help) = match fault {
            Fault::TooFew(there) => {
                let samples = if there == 1 { "sample" } else { "samples" };
                let help = "record longer, or skip less; the rows of an array are samples, its columns axes";
                (format!("has {there} {samples}, at least {MIN_SAMPLES} are needed"), help)
            }
            Fault::Constant { there, value } => {
                let help =
                    "is it the right column, and was the sensor on? a constant has no deviation to show";
                (format!("is constant: all {there} samples are {value}"), help)
            }
        };
        (format!("{column} {message}"), help.to_owned())
    }

    /// The note on a doubtful unit of some axes.
    fn noted(&self, axes: &[&Channel], doubt: Doubt) -> String {
        let (unit, data) = (&axes[0].unit, self.data.name());
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
                let (text, other) = (&unit.text, unit.curves == Curves::Acceleration);
                let (mean, sensor) = if other { (in_g(mean), "accelerometer") } else { (rate(mean), "gyro") };
                format!(
                    "has a mean {} of {mean}, which no {sensor} at rest has: is {text} its unit, and `data = {data}` right?",
                    unit.curves.measured()
                )
            }
            Doubt::Gravity { mean, other } => format!(
                "may be in {other}, not in {}: its mean is {}, in {other} it would be 1 g, as an accelerometer at rest shows of \
                 gravity; if so, give `unit = {other}`",
                unit.text,
                in_g(mean)
            ),
        };
        let names: Vec<&str> = axes.iter().map(|channel| channel.name.as_str()).collect();
        let columns = if names.len() == 1 { "column" } else { "the vector of columns" };
        format!("{columns} {} {note}", names.join(", "))
    }
}

/// An acceleration in µg, formatted for the user.
fn in_g(mean: f64) -> String {
    format!("{} g", significant(1e-6 * mean, 3))
}

/// A rate in ″/s, formatted for the user.
fn rate(mean: f64) -> String {
    if mean < 3600.0 {
        format!("{} °/h", significant(mean, 3))
    } else {
        format!("{} °/s", significant(mean / 3600.0, 3))
    }
}
