//! A log in memory, and what is done to it before it is analysed.

use crate::allan::{Angles, Trend};
use crate::table::significant;

use super::error::{LogError, Place};
use super::{Data, Unit};

/// A log: one or several columns of evenly spaced samples.
#[derive(Debug, Clone)]
pub struct Log {
    pub(super) file: String,
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
    pub(super) place: Option<Place>,
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
    pub fn cut(&mut self, skip_s: f64, until_s: Option<f64>) -> Result<(), LogError> {
        let sample =
            |time_s: f64| libm::round(time_s / self.step_s).clamp(0.0, self.samples() as f64) as usize;
        let (first, end) = (sample(skip_s), until_s.map_or(self.samples(), sample));
        if first >= end {
            let length = significant(self.length_s(), 6);
            let message = format!("nothing of {} is left: it is {length} s long", self.file);
            return Err(LogError::new(message, "", "skip less, or go on until later", None));
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
    /// How many samples are missing.
    pub fn missing(&self) -> usize {
        self.samples.iter().filter(|sample| sample.is_nan()).count()
    }

    /// The samples as rates or increments; those of angles are their differences.
    pub fn increments(&self, data: Data) -> Vec<f64> {
        match data {
            Data::Rate | Data::Increment => self.samples.clone(),
            Data::Angle => self.samples.windows(2).map(|pair| pair[1] - pair[0]).collect(),
        }
    }

    /// The angles, in ″, of samples `step_s` apart; of plain numbers in their unit, rates times s.
    pub fn angles(&self, data: Data, step_s: f64, trend: Trend) -> Angles {
        let factor = self.unit.factor;
        match data {
            Data::Rate => Angles::from_increments(&self.samples, factor * step_s, step_s, trend),
            Data::Increment => Angles::from_increments(&self.samples, factor, step_s, trend),
            Data::Angle => Angles::from_angles(&self.samples, factor, step_s, trend),
        }
    }

    /// The mean rate, in ″/s or for plain numbers in their unit over s where they are no rates.
    pub fn mean_rate(&self, data: Data, step_s: f64) -> Option<f64> {
        let known = || self.samples.iter().copied().enumerate().filter(|(_, sample)| sample.is_finite());
        let mean = match data {
            Data::Rate | Data::Increment => {
                let (count, sum) = known().fold((0.0, 0.0), |(count, sum), (_, y)| (count + 1.0, sum + y));
                if data == Data::Rate { sum / count } else { sum / count / step_s }
            }
            Data::Angle => {
                let (first, last) = (known().next()?, known().next_back()?);
                (last.1 - first.1) / ((last.0 - first.0) as f64 * step_s)
            }
        };
        mean.is_finite().then_some(mean * self.unit.factor)
    }
}
