//! Samples in memory from any source: their quantity and unit, and their preparation for analysis.

use std::borrow::Cow;
use std::ops::Range;

use crate::allan::{Angles, Trend};
use crate::record::log::check::MIN_SAMPLES;
use crate::record::log::doubt::Doubt;
use crate::record::log::measure::{Data, Unit};
use crate::record::log::outliers::{Outliers, outliers};

/// Parts of a record whose means show the error of the mean.
const PARTS: usize = 16;

/// Evenly spaced samples of one axis. Nothing is copied until angles are computed from them.
///
/// ```
/// use sagnac_records::allan::trend::Trend;
/// use sagnac_records::record::log::measure::{Data, Unit};
/// use sagnac_records::record::log::samples::Samples;
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
    fn scale(&self) -> f64 {
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
        let doubt = Doubt::of(self.mean_rate()?.abs(), self.unit, self.data);
        doubt.filter(|doubt| !matches!(doubt, Doubt::DegreesAsRadians(_)) || self.has_mean())
    }
}
