//! A log in memory, and what is done to it before it is analysed.

use crate::quantity::number::significant;

use crate::record::error::RecordError;
use crate::record::log::measure::{Data, Unit};
use crate::record::log::samples::Samples;
use crate::source::place::Place;

/// A log: one or several columns of evenly spaced samples.
#[derive(Debug, Clone)]
pub struct Log {
    pub(crate) file: String,
    /// From sample to sample, s.
    pub step_s: f64,
    /// What the samples are.
    pub data: Data,
    /// Where the samples begin, from the start of the file, s.
    pub start_s: f64,
    /// One for each column that was asked for.
    pub channels: Vec<Channel>,
}

/// One column of a log.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Without unit; the column's number where it has none.
    pub name: String,
    /// Of `samples`.
    pub unit: Unit,
    /// What the header says, whether or not it was followed.
    pub unit_in_header: Option<String>,
    /// As in the file, finite; NaN where one is missing.
    pub samples: Vec<f64>,
    pub(crate) place: Option<Place>,
}

impl Log {
    /// The number of samples of a channel, missing ones among them.
    pub fn samples(&self) -> usize {
        self.channels.first().map_or(0, |channel| channel.samples.len())
    }

    /// From the first sample to the end of the last, s.
    pub fn length_s(&self) -> f64 {
        self.samples() as f64 * self.step_s
    }

    /// Keeps the samples from `skip_s` to `until_s`, both from the start of the file.
    ///
    /// # Errors
    /// None is left.
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
        for channel in &mut self.channels {
            channel.samples.truncate(end);
            channel.samples.drain(..first);
        }
        Ok(())
    }
}

impl Channel {
    /// Its samples with what they measure, in a log of such `data`.
    pub fn view(&self, data: Data, step_s: f64) -> Samples<'_> {
        Samples { data, unit: &self.unit, step_s, values: &self.samples }
    }
}
