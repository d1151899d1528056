//! The power spectral density of a record, the lines in it, and the level of its white noise.
//!
//! ```text
//! Angles, Welch ─ Density::new ─▶ Density ─ lines ─▶ Lines ─ Floor::new ─▶ Floor
//! ```
//!
//! All densities are **one-sided**: their integral from 0 to half the sampling rate is the variance of the rate. White
//! rate of the coefficient N has the density 2N². Rates are those between the angles of a record, in ″/s, so densities
//! are in (″/s)²/Hz, which is the same number in (°/h)²/Hz.
//!
//! ```
//! use sagnac_records::allan::{Angles, Trend};
//! use sagnac_records::spectrum::{Density, Floor, Welch, lines};
//!
//! // Scattered rates and a sine of 20 Hz with the amplitude 3.
//! let mut state = 1_u64;
//! let mut scattered = || {
//!     state = 16_807 * state % 2_147_483_647;
//!     state as f64 / 2_147_483_647.0
//! };
//! let sine = |i: u32| 3.0 * (0.4 * std::f64::consts::PI * f64::from(i)).sin();
//! let rates: Vec<f64> = (0..8192).map(|i| scattered() + sine(i)).collect();
//! let angles = Angles::from_increments(&rates, 0.01, 0.01, Trend::None);
//!
//! let density = Density::new(&angles, &Welch::default())?;
//! assert_eq!((density.segment, density.segments), (1024, 15));
//! let lines = lines(&density);
//! assert_eq!(lines.len(), 1);
//! assert!((lines[0].frequency_hz - 20.0).abs() < 3e-3 && (lines[0].amplitude - 3.0).abs() < 0.02);
//! // Uniform numbers between 0 and 1 have the variance 1/12.
//! let floor = Floor::new(&density, &lines).unwrap();
//! assert!((floor.density / (2.0 * 0.01 / 12.0) - 1.0).abs() < 0.1);
//! # Ok::<(), sagnac_records::spectrum::SpectrumError>(())
//! ```
//!
//! Method: P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Trans. Audio
//! Electroacoust. 15 (1967); F. J. Harris, "On the use of windows for harmonic analysis", Proc. IEEE 66 (1978).

pub mod lines;

use core::f64::consts::TAU;
use std::ops::Range;

use rayon::prelude::*;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::allan::{Angles, Line as Trendline, Trend, distributions};
pub use crate::spectrum::lines::{FALSE_ALARM, Floor, Line, lines};
use sagnac_base::quantity::number::significant;

/// Correlation of the densities at frequencies one and two places apart, for the Hann window: the squares of its
/// squared window's Fourier coefficients ⅔ and ⅙.
pub(crate) const NEIGHBOURS: [f64; 2] = [4.0 / 9.0, 1.0 / 36.0];

/// Fewest samples in a segment.
pub const MIN_SEGMENT: usize = 16;
/// Most samples in a default segment: 8192 frequencies are enough for a table and a chart.
pub const MAX_USUAL: usize = 1 << 14;
/// Number of default segments, without overlap, in a record of moderate length.
const USUAL_SEGMENTS: usize = 8;
/// Number of pairs of segments that are transformed at once.
const AT_ONCE: usize = 64;

/// How a density is estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Welch {
    /// Number of samples in a segment; by default an eighth of the record, rounded down to a power of two and at most
    /// 16384, or less if most of the record is in shorter stretches between gaps.
    pub segment: Option<usize>,
    /// The trend that is removed from each segment: with [`Trend::None`] its mean, with [`Trend::Linear`] its line of least squares.
    pub trend: Trend,
    /// Probability of the intervals.
    pub confidence: f64,
}

impl Default for Welch {
    fn default() -> Welch {
        Welch { segment: None, trend: Trend::None, confidence: 0.95 }
    }
}

/// The density of a record at evenly spaced frequencies.
#[derive(Debug, Clone, PartialEq)]
pub struct Density {
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Number of samples in a segment.
    pub segment: usize,
    /// What was removed from each segment, besides its mean.
    pub trend: Trend,
    /// Number of segments averaged.
    pub segments: usize,
    /// Number of samples that are in none of them: behind the last segment of a stretch, or in one shorter than a segment.
    pub unused: usize,
    /// Degrees of freedom of each value, except that at half the sampling rate, which has half as many.
    pub freedom: f64,
    /// Probability of the intervals.
    pub confidence: f64,
    /// Values at the multiples 1, 2, … of the [spacing](Density::spacing_hz), up to half the sampling rate.
    pub points: Vec<Point>,
}

/// The density at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// One-sided density, (″/s)²/Hz.
    pub value: f64,
    /// Lower and upper end of the interval. Absent at the lowest frequency, where the value is too low because the mean
    /// of each segment was removed: by a sixth for white noise.
    pub interval: Option<(f64, f64)>,
    /// Degrees of freedom.
    pub freedom: f64,
}

/// Why a record has no density. Lengths are in samples.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SpectrumError {
    /// No stretch has [`MIN_SEGMENT`] samples, or most of the record is in stretches below that.
    #[error(
        "the record is too short for a spectrum: its longest stretch without gaps has {longest} samples, and most of the \
         record must be in stretches of at least {MIN_SEGMENT}\nrecord longer, or leave out less"
    )]
    RecordTooShort {
        /// Length of the longest stretch without gaps.
        longest: usize,
    },
    /// The requested segment does not fit between gaps.
    #[error(
        "the segment of {} s is too long: the longest stretch without gaps has {} s\ngive at most `segment = {}s`, better an \
         eighth of that, so that several segments are averaged",
        shown(*.segment, *.step_s), shown(*.longest, *.step_s), shown(*.longest, *.step_s)
    )]
    SegmentTooLong {
        /// Requested length.
        segment: usize,
        /// Length of the longest stretch without gaps.
        longest: usize,
        /// Time from sample to sample, s.
        step_s: f64,
    },
    /// The requested segment has fewer than [`MIN_SEGMENT`] samples.
    #[error(
        "the segment of {segment} samples is too short: at least {MIN_SEGMENT} are needed\ngive at least `segment = {}s`",
        shown(MIN_SEGMENT, *.step_s)
    )]
    SegmentTooShort {
        /// Requested length.
        segment: usize,
        /// Time from sample to sample, s.
        step_s: f64,
    },
}

/// The duration of some samples.
fn shown(samples: usize, step_s: f64) -> String {
    significant(samples as f64 * step_s, 9)
}

impl Density {
    /// The density of the rates between the `angles` of a record.
    ///
    /// # Method
    /// The mean, or a line, is removed from segments that overlap by half. They get the periodic Hann window
    /// ½(1 − cos 2πj/L), and the squares of their Fourier transforms are averaged. Gaps of up to 64 samples are bridged, and the density
    /// is divided by the part of the samples that is known; no segment crosses a longer gap. Values
    /// equal those of `scipy.signal.welch` for a record without gaps to 1e-9. The transform is scalar code, so it does not
    /// depend on the vector units of the machine.
    ///
    /// The interval is that of χ². K segments, of which P pairs overlap, have 2K²/(K + 2ρP) degrees of freedom, where
    /// ρ = 1/36 is the correlation of the powers of two overlapping segments of white noise.
    ///
    /// # Limits
    /// Intervals hold for stationary Gaussian noise whose density hardly changes over 3 frequencies.
    ///
    /// # Errors
    /// The record is too short, or the requested segment does not fit.
    pub fn new(angles: &Angles, asked: &Welch) -> Result<Density, SpectrumError> {
        let step_s = angles.step_s;
        let solid = angles.bridged();
        let stretches: Vec<Range<usize>> = solid.runs.iter().map(|run| run.start..run.end - 1).collect();
        let segment = segment(&stretches, asked, step_s)?;
        let starts: Vec<usize> = stretches.iter().flat_map(|stretch| starts(stretch, segment)).collect();
        let window = hann(segment);
        let power: f64 = window.iter().map(|w| w * w).sum();
        let sums = powers(solid.values, &starts, &window, asked.trend);
        let freedom = freedom(&starts, &window, power);
        let [inner, last] = [freedom, 0.5 * freedom].map(|freedom| ends(freedom, asked.confidence));
        let point = |k: usize| {
            // Half the sampling rate has no second side.
            let is_last = 2 * k == segment;
            let sides = if is_last { 1.0 } else { 2.0 };
            // Rates are differences of angles over the step.
            let value = sides * sums[k] / (power * step_s * starts.len() as f64 * solid.share);
            let ends = if is_last { last } else { inner };
            let interval =
                ends.filter(|_| k > 1 && value > 0.0).map(|(low, high)| (low * value, high * value));
            let freedom = if is_last { 0.5 * freedom } else { freedom };
            Point { frequency_hz: k as f64 / (segment as f64 * step_s), value, interval, freedom }
        };
        Ok(Density {
            step_s,
            segment,
            trend: asked.trend,
            segments: starts.len(),
            unused: stretches.iter().map(|stretch| stretch.len() - used(stretch.len(), segment)).sum(),
            freedom,
            confidence: asked.confidence,
            points: (1..=segment / 2).map(point).collect(),
        })
    }

    /// Distance from one frequency to the next, Hz; two lines closer than 3 of it are one.
    pub fn spacing_hz(&self) -> f64 {
        1.0 / (self.segment as f64 * self.step_s)
    }

    /// The mean density over the points of a range, with its interval; that of a single point as it is.
    pub fn mean(&self, places: Range<usize>) -> Option<Point> {
        let points = self.points.get(places)?;
        let [first, .., last] = points else { return points.first().copied() };
        let count = points.len() as f64;
        let beside: f64 =
            (1..).zip(NEIGHBOURS).map(|(d, c)| 2.0 * (1.0 - f64::from(d) / count).max(0.0) * c).sum();
        let freedom = self.freedom * count / (1.0 + beside);
        let value = points.iter().map(|point| point.value).sum::<f64>() / count;
        let is_known = points.iter().all(|point| point.interval.is_some());
        let ends = ends(freedom, self.confidence).filter(|_| is_known);
        let interval = ends.map(|(low, high)| (low * value, high * value));
        let frequency_hz = libm::sqrt(first.frequency_hz * last.frequency_hz);
        Some(Point { frequency_hz, value, interval, freedom })
    }
}

/// Ends of the interval of a density with these degrees of freedom, over the density.
pub(crate) fn ends(freedom: f64, confidence: f64) -> Option<(f64, f64)> {
    let tail = 0.5 * (1.0 - confidence);
    let end = |probability| Some(freedom / distributions::chi_squared_quantile(probability, freedom)?);
    Some((end(1.0 - tail)?, end(tail)?))
}

/// The number of samples in a segment.
fn segment(stretches: &[Range<usize>], asked: &Welch, step_s: f64) -> Result<usize, SpectrumError> {
    let lengths = || stretches.iter().map(Range::len);
    let (longest, samples) = (lengths().max().unwrap_or(0), lengths().sum::<usize>());
    match asked.segment {
        _ if longest < MIN_SEGMENT => Err(SpectrumError::RecordTooShort { longest }),
        Some(segment) if segment < MIN_SEGMENT => Err(SpectrumError::SegmentTooShort { segment, step_s }),
        Some(segment) if segment > longest => Err(SpectrumError::SegmentTooLong { segment, longest, step_s }),
        Some(segment) => Ok(segment),
        None => {
            let most = (samples / USUAL_SEGMENTS).clamp(MIN_SEGMENT, MAX_USUAL).ilog2();
            let usable = |segment: usize| lengths().map(|length| used(length, segment)).sum::<usize>();
            let powers = (MIN_SEGMENT.ilog2()..=most).rev().map(|power| 1 << power);
            powers
                .into_iter()
                .find(|&segment| 2 * usable(segment) >= samples)
                .ok_or(SpectrumError::RecordTooShort { longest })
        }
    }
}

/// Distance between the starts of segments: half a segment, rounded up.
fn stride(segment: usize) -> usize {
    segment - segment / 2
}

/// The starts of the segments in a stretch of samples.
fn starts(stretch: &Range<usize>, segment: usize) -> impl Iterator<Item = usize> + use<> {
    (stretch.start..(stretch.end + 1).saturating_sub(segment)).step_by(stride(segment))
}

/// The number of samples in the segments of a stretch.
fn used(length: usize, segment: usize) -> usize {
    let strides = length.checked_sub(segment).map(|rest| rest / stride(segment));
    strides.map_or(0, |strides| segment + strides * stride(segment))
}

/// The periodic Hann window.
fn hann(segment: usize) -> Vec<f64> {
    let weight = |j: usize| 0.5 * (1.0 - libm::cos(TAU * j as f64 / segment as f64));
    (0..segment).map(weight).collect()
}

/// Equivalent degrees of freedom of a mean over segments.
fn freedom(starts: &[usize], window: &[f64], power: f64) -> f64 {
    let stride = stride(window.len());
    let product: f64 = window.iter().zip(&window[stride..]).map(|(a, b)| a * b).sum();
    let correlation = product * product / (power * power);
    let pairs = starts.windows(2).filter(|pair| pair[1] - pair[0] == stride).count() as f64;
    let count = starts.len() as f64;
    2.0 * count * count / (count + 2.0 * correlation * pairs)
}

/// The sums of the squares of the transforms of all segments, at the multiples 0 … L/2 of the spacing.
///
/// Two real segments are transformed as one of complex numbers: |A_k|² + |B_k|² = ½(|Z_k|² + |Z_{L−k}|²).
fn powers(angles: &[f64], starts: &[usize], window: &[f64], trend: Trend) -> Vec<f64> {
    let length = window.len();
    let fft = FftPlanner::new().plan_fft_forward(length);
    let increments = |start: usize| {
        let increment = move |j: usize| angles[start + j + 1] - angles[start + j];
        let line = Trendline::new(trend, length, increment);
        move |j: usize| window[j] * (increment(j) - line.at(j))
    };
    let space = || {
        let empty = |length| vec![Complex::default(); length];
        (empty(length), empty(fft.get_inplace_scratch_len()))
    };
    let transformed = |(buffer, scratch): &mut (Vec<_>, Vec<_>), pair: &[usize]| {
        let first = increments(pair[0]);
        let second = pair.get(1).map(|&start| increments(start));
        for (j, value) in buffer.iter_mut().enumerate() {
            *value = Complex::new(first(j), second.as_ref().map_or(0.0, |second| second(j)));
        }
        fft.process_with_scratch(buffer, scratch);
        let power = |k: usize| 0.5 * (buffer[k].norm_sqr() + buffer[(length - k) % length].norm_sqr());
        (0..=length / 2).map(power).collect()
    };
    let mut sums = vec![0.0; length / 2 + 1];
    // In the order of time, so that the sums do not depend on the number of threads.
    for starts in starts.chunks(2 * AT_ONCE) {
        let powers: Vec<Vec<f64>> = starts.par_chunks(2).map_init(space, transformed).collect();
        powers.iter().for_each(|powers| sums.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power));
    }
    sums
}
