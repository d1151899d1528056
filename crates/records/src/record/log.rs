//! Logs of sensors, read into evenly spaced samples, some of which may be missing, and prepared for analysis.
//!
//! ```text
//! ColumnFile ─ Request ─▶ Log ─ cut, check, outliers ─▶ channels ─▶ allan::Angles
//! ```

mod columns;
pub mod measure;
pub mod outliers;
pub mod read;
#[cfg(test)]
mod tests;
pub(crate) mod timing;

use std::borrow::Cow;
use std::io;
use std::iter::once;
use std::ops::Range;

use crate::allan::{Angles, Trend};
use crate::record::RecordError;
use crate::record::column_file::ColumnFile;
use crate::record::log::measure::{Data, Doubt, MIN_SAMPLES, Unit};
use crate::record::log::outliers::{Outliers, outliers};
use sagnac_base::diagnostics::Place;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::text::csv_error;

/// Most samples of a log, 2^28, which is a week at 400 Hz.
pub const MAX_SAMPLES: usize = 1 << 28;

/// A log with one or several columns of evenly spaced samples.
#[derive(Debug, Clone)]
pub struct Log {
    /// Name of the file.
    pub file: String,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Quantity of the samples.
    pub data: Data,
    /// Time of the first sample from the start of the file, s.
    pub start_s: f64,
    /// Whether the dependence on temperature was subtracted.
    pub is_compensated: bool,
    /// Channels, one for each requested column.
    pub channels: Vec<Channel>,
    /// The column of the temperature with its name, °C at each sample, NaN where it is missing; absent if it was not requested.
    pub temperature: Option<(String, Vec<f64>)>,
    /// Other columns that are called like temperatures, with their names; NaN where one is missing.
    pub thermometers: Vec<(String, Vec<f64>)>,
    /// What was inferred about the file, and what looks doubtful in it, in a line each.
    pub notes: Vec<String>,
}

/// One column of a log.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Name without unit; the column's number where it has no name.
    pub name: String,
    /// Unit of `samples`.
    pub unit: Unit,
    /// Unit in the header, whether or not it was used.
    pub unit_in_header: Option<String>,
    /// Whether the unit is not stated, but guessed from the name of the column.
    pub is_unit_guessed: bool,
    /// Samples as in the file, finite; NaN where one is missing.
    pub samples: Vec<f64>,
    /// Place of the column in the file, where it has one.
    pub place: Option<Place>,
    /// The field of messages from which it was read, where the file holds such.
    pub field: Option<Field>,
}

/// A field of the messages of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Topic of the messages, or their sensor.
    pub topic: String,
    /// Type of the messages.
    pub kind: String,
    /// Name of the field in a message.
    pub name: String,
}

impl Channel {
    /// The unit in the header, where another one was used.
    pub fn overruled(&self) -> Option<String> {
        self.unit_in_header.clone().filter(|text| *text != self.unit.text)
    }
}

impl Log {
    /// A log of one column from memory, called `name`; `samples` are finite, and NaN where one is missing.
    pub fn of_column(name: &str, data: Data, unit: Unit, step_s: f64, samples: Vec<f64>) -> Log {
        let channel = Channel {
            name: name.to_owned(),
            unit,
            unit_in_header: None,
            is_unit_guessed: false,
            samples,
            place: None,
            field: None,
        };
        let (file, channels) = (name.to_owned(), vec![channel]);
        Log {
            file,
            step_s,
            data,
            start_s: 0.0,
            is_compensated: false,
            channels,
            temperature: None,
            thermometers: vec![],
            notes: vec![],
        }
    }

    /// The log with one of its channels alone; `None` if there is none at this place.
    pub fn only(&self, place: usize) -> Option<Log> {
        Some(Log {
            file: self.file.clone(),
            channels: vec![self.channels.get(place)?.clone()],
            temperature: self.temperature.clone(),
            thermometers: self.thermometers.clone(),
            notes: self.notes.clone(),
            ..*self
        })
    }

    /// The number of samples of a channel, including missing ones.
    pub fn samples(&self) -> usize {
        self.channels.first().map_or(0, |channel| channel.samples.len())
    }

    /// Time from the first sample to the end of the last, s.
    pub fn length_s(&self) -> f64 {
        self.samples() as f64 * self.step_s
    }

    /// Keeps the samples from `skip_s` to `until_s`, both from the start of the file.
    ///
    /// # Errors
    /// No samples are left.
    pub fn cut(&mut self, skip_s: f64, until_s: Option<f64>) -> Result<(), RecordError> {
        let sample =
            |time_s: f64| libm::round(time_s / self.step_s).clamp(0.0, self.samples() as f64) as usize;
        let (first, end) = (sample(skip_s), until_s.map_or(self.samples(), sample));
        if first >= end {
            let length = significant(self.length_s(), 6);
            let message = format!("nothing of {} is left: it is {length} s long", self.file);
            return Err(RecordError::new(message, "", "skip less, or go on until later", None));
        }
        self.start_s = first as f64 * self.step_s;
        let channels = self.channels.iter_mut().map(|channel| &mut channel.samples);
        let thermometers = self.temperature.iter_mut().chain(&mut self.thermometers);
        for numbers in channels.chain(thermometers.map(|(_, numbers)| numbers)) {
            numbers.truncate(end);
            numbers.drain(..first);
        }
        Ok(())
    }
}

impl Channel {
    /// The samples of the channel, in a log of quantity `data`.
    pub fn view(&self, data: Data, step_s: f64) -> Samples<'_> {
        Samples { data, unit: &self.unit, step_s, values: &self.samples }
    }
}

/// Parts of a record whose means show the error of the mean.
const PARTS: usize = 16;

/// Evenly spaced samples of one axis. Nothing is copied until angles are computed from them.
///
/// ```
/// use sagnac_records::allan::angles::Trend;
/// use sagnac_records::record::log::measure::{Data, Unit};
/// use sagnac_records::record::log::Samples;
///
/// let rates: Vec<f64> = (0..100).map(|i| f64::from(i * 37 % 100)).collect();
/// let unit = Unit::parse("deg/h", Data::Rate)?;
/// let samples = Samples { data: Data::Rate, unit: &unit, step_s: 0.01, values: &rates };
/// assert_eq!((samples.fault(), samples.mean_rate()), (None, Some(49.5)));
/// assert_eq!(samples.angles(Trend::None).len(), 101);
/// # Ok::<(), sagnac_records::record::log::measure::UnitMismatch>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// Quantity of the samples.
    pub data: Data,
    /// Unit of the samples.
    pub unit: &'a Unit,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Values, finite; NaN where one is missing.
    pub values: &'a [f64],
}

/// Why samples are unusable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// There are only so many samples that are not missing, fewer than [`MIN_SAMPLES`].
    TooFew(usize),
    /// All samples are equal.
    Constant {
        /// Number of samples that are not missing.
        there: usize,
        /// Their value.
        value: f64,
    },
}

impl<'a> Samples<'a> {
    /// Number of missing samples.
    pub fn missing(&self) -> usize {
        self.values.iter().filter(|sample| sample.is_nan()).count()
    }

    /// The stretches of missing samples, in their order.
    pub fn gaps(&self) -> Vec<Range<usize>> {
        let mut gaps = Vec::new();
        let mut start = 0;
        for stretch in self.values.chunk_by(|a, b| a.is_nan() == b.is_nan()) {
            if stretch[0].is_nan() {
                gaps.push(start..start + stretch.len());
            }
            start += stretch.len();
        }
        gaps
    }

    /// The samples as rates or increments; those of angles are their differences.
    pub fn increments(&self) -> Cow<'a, [f64]> {
        match self.data {
            Data::Rate | Data::Increment => Cow::Borrowed(self.values),
            Data::Angle => self.values.windows(2).map(|pair| pair[1] - pair[0]).collect(),
        }
    }

    /// The angles, in ″, or the velocities, in µg·s; for plain numbers in their unit, or for plain rates in their unit times s.
    pub fn angles(&self, trend: Trend) -> Angles {
        match self.data {
            Data::Angle => Angles::from_angles(self.values, self.scale(), self.step_s, trend),
            _ => Angles::from_increments(self.values, self.scale(), self.step_s, trend),
        }
    }

    /// The angles with outliers treated as missing increments.
    pub fn angles_without(&self, outliers: &Outliers, trend: Trend) -> Angles {
        if outliers.samples.is_empty() {
            return self.angles(trend);
        }
        let mut increments = self.increments().into_owned();
        outliers.samples.iter().for_each(|&sample| increments[sample] = f64::NAN);
        Angles::from_increments(&increments, self.scale(), self.step_s, trend)
    }

    /// The rates or increments of angles as [`Samples::angles`] has them, with the line that was removed, in the unit of the samples;
    /// NaN where one is missing.
    pub fn of_angles(&self, angles: &Angles) -> Vec<f64> {
        let (line, factor) = (angles.removed(), self.step_s / self.scale());
        let rates = angles.rates(0..angles.len() - 1).into_iter();
        rates.enumerate().map(|(i, rate)| rate * factor + line.at(i)).collect()
    }

    /// Factor from a sample, or from the difference of two angles, to ″ or µg·s.
    pub fn scale(&self) -> f64 {
        if self.data == Data::Rate { self.unit.factor * self.step_s } else { self.unit.factor }
    }

    /// The outliers among the rates or increments.
    pub fn outliers(&self) -> Outliers {
        outliers(&self.increments())
    }

    /// The mean rate, in ″/s, or acceleration, in µg; for plain numbers in their unit, or per s where they are not rates.
    pub fn mean_rate(&self) -> Option<f64> {
        let known = || self.values.iter().copied().enumerate().filter(|(_, sample)| sample.is_finite());
        let mean = match self.data {
            Data::Rate | Data::Increment => {
                let (count, sum) = known().fold((0.0, 0.0), |(count, sum), (_, y)| (count + 1.0, sum + y));
                if self.data == Data::Rate { sum / count } else { sum / count / self.step_s }
            }
            Data::Angle => {
                let (first, last) = (known().next()?, known().next_back()?);
                (last.1 - first.1) / ((last.0 - first.0) as f64 * self.step_s)
            }
        };
        mean.is_finite().then_some(mean * self.unit.factor)
    }

    /// Whether the mean rate exceeds three times its standard error, by the scatter of the means of 16 parts of the record, and half of the
    /// least difference of two samples, by which a coarse readout may shift it.
    pub(crate) fn has_mean(&self) -> bool {
        let differences = self.values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let least = differences.filter(|difference| *difference > 0.0).fold(f64::INFINITY, f64::min);
        let shift = match self.data {
            Data::Rate => 0.5 * least * self.unit.factor,
            Data::Increment => 0.5 * least * self.unit.factor / self.step_s,
            Data::Angle => 0.0,
        };
        let length = self.values.len() / PARTS;
        let part =
            |at: usize| Samples { values: &self.values[at * length..(at + 1) * length], ..*self }.mean_rate();
        let means: Vec<f64> = (0..PARTS).filter_map(part).collect();
        let count = means.len() as f64;
        let mean = means.iter().sum::<f64>() / count;
        let square = means.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0);
        mean.abs() > shift.max(3.0 * libm::sqrt(square / count))
    }

    /// Why these samples are refused, if they are: they are too few, or all equal.
    pub fn fault(&self) -> Option<Fault> {
        let mut known = self.values.iter().copied().filter(|sample| !sample.is_nan());
        let there = known.clone().count();
        if there < MIN_SAMPLES {
            return Some(Fault::TooFew(there));
        }
        let value = known.next().unwrap_or(0.0);
        known.all(|sample| sample == value).then_some(Fault::Constant { there, value })
    }

    /// Why the unit of these samples is doubtful, if it is. Only the mean is examined, which no deviation depends on. A mean within its own
    /// error says nothing of the Earth's rotation.
    pub fn doubt(&self) -> Option<Doubt> {
        let doubt = Doubt::new(self.mean_rate()?.abs(), self.unit, self.data);
        doubt.filter(|doubt| !matches!(doubt, Doubt::DegreesAsRadians(_)) || self.has_mean())
    }
}

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
    pub(crate) fn parse(text: &str) -> Option<&'static Degree> {
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
        Degree::parse(unit)
    }
}

impl Thermometer {
    /// The unit of its column in a file; `notes` receives it where it is assumed.
    ///
    /// # Errors
    /// The unit is unknown.
    pub(crate) fn degree(
        &self,
        file: &ColumnFile,
        column: usize,
        notes: &mut Vec<String>,
    ) -> Result<&'static Degree, RecordError> {
        let name = file.names().get(column);
        match self.unit.as_deref().or(name.and_then(|name| name.unit.as_deref())) {
            Some(unit) => Degree::parse(unit).ok_or_else(|| {
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

impl Log {
    /// Writes the channels as CSV that [`Log::read`] reads back with their kind of data alone: the times from the first sample on,
    /// each name with its unit, and an empty cell where a sample is missing.
    ///
    /// Samples keep all their digits. Times are rounded, so that the sampling step that they give may differ in its last digit.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_csv(&self, to: impl io::Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(to);
        let names = self.channels.iter().map(|channel| format!("{} [{}]", channel.name, channel.unit.text));
        writer.write_record(once("time_s".to_owned()).chain(names)).map_err(csv_error)?;
        for i in 0..self.samples() {
            let samples = self.channels.iter().map(|channel| channel.samples[i]);
            let numbers = once(i as f64 * self.step_s).chain(samples);
            let cells =
                numbers.map(|number| if number.is_nan() { String::new() } else { number.to_string() });
            writer.write_record(cells).map_err(csv_error)?;
        }
        writer.flush()
    }
}
