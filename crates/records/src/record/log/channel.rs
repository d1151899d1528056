//! A log in memory, and its preparation for analysis.

use sagnac_base::quantity::number::significant;

use crate::record::error::RecordError;
use crate::record::log::measure::{Data, Unit};
use crate::record::log::samples::Samples;
use sagnac_base::source::place::Place;

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
