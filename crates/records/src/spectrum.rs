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

use core::f64::consts::{FRAC_2_PI, PI, TAU};
use std::ops::Range;

use rayon::prelude::*;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::allan::{Angles, Line as Trendline, Trend, distributions};
use crate::fit::survival;
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

/// Most probability that a record of Gaussian noise with a smooth density shows any line at all.
pub const FALSE_ALARM: f64 = 0.003;

/// The first multiple of the spacing that the removed means do not affect.
const FIRST: usize = 2;
/// Fewest and most densities on each side of one that determine the floor around it.
const SIDES: [usize; 2] = [12, 50];
/// Half the width of a line in the density: the main lobe of the Hann window.
const LOBE: usize = 2;
/// Ratio to the leakage of a stronger line below which a density is not a line of its own.
const LEAKAGE: f64 = 4.0;

/// A line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Frequency, Hz, interpolated between those of the density.
    pub frequency_hz: f64,
    /// Amplitude of the sine of the rate, ″/s. That of a line broader than the window is of a sine with the same power.
    pub amplitude: f64,
    /// Highest density over that of the floor around it.
    pub over_floor: f64,
    /// Probability that noise alone has a density as high anywhere in the record.
    pub p: f64,
    /// The points of the density that it raises.
    pub places: Range<usize>,
}

/// The lines of a density, by rising frequency.
///
/// # Method
/// Each density is divided by that of the floor, the median of up to 50 densities on each side of it over the median of
/// their distribution. As many are taken on both sides, so that the median of a monotonic floor is the one in the middle;
/// beyond half the sampling rate the density is mirrored. The ratio has the F distribution, with the degrees of freedom
/// of the density and of the median. It belongs to a line where its probability times the number of tested frequencies is
/// below [`FALSE_ALARM`]. Up to 50 spacings beside a stronger line it must be so over the median of 12 on each side too,
/// because the skirt of a broad line is no line.
///
/// The power of a line is the sum of the densities above the floor, which does not depend on where the line lies between
/// two frequencies. The frequency is that at which the main lobe of the window has the ratio of the two highest densities.
///
/// # Limits
/// Lines below 14 spacings, where a floor cannot be told from the red noise of a gyro, and those closer than 3 spacings
/// to a stronger one are not found. The mean over a sample makes a sine smaller by sin πft0/πft0; this is not undone.
pub fn lines(density: &Density) -> Vec<Line> {
    let Some(median) = Median::new(density.freedom) else { return vec![] };
    let spectrum = Mirrored { density };
    let tested = FIRST + SIDES[0]..tested_end(density);
    let over: Vec<(f64, f64)> =
        tested.clone().map(|k| spectrum.over_floor(k, SIDES[1].min(k - FIRST), &median)).collect();
    let tests = tested.len() as f64;
    let p = |k: usize| tests * over[k - tested.start].1;
    let mut found: Vec<Line> = Vec::new();
    let significant: Vec<usize> = tested.clone().filter(|&k| p(k) < FALSE_ALARM).collect();
    for run in significant.chunk_by(|a, b| b - a <= LOBE) {
        let ratio = |k: usize| over[k - tested.start].0;
        let Some(&peak) = run.iter().max_by(|&&a, &&b| spectrum.at(a).total_cmp(&spectrum.at(b))) else {
            continue;
        };
        let floor = spectrum.at(peak) / ratio(peak);
        let bins = run[0] - LOBE..(run[run.len() - 1] + LOBE + 1).min(density.points.len() + 1);
        let power: f64 = bins.clone().map(|k| spectrum.at(k) - floor).sum();
        found.push(Line {
            frequency_hz: density.spacing_hz() * spectrum.centre(peak, floor),
            amplitude: libm::sqrt(2.0 * power.max(0.0) * density.spacing_hz()),
            over_floor: ratio(peak),
            p: p(peak),
            places: bins.start - 1..bins.end - 1,
        });
    }
    let all = found.clone();
    let is_narrow = |line: &Line| {
        let peak = libm::round(line.frequency_hz / density.spacing_hz()) as usize;
        tests * spectrum.over_floor(peak.max(tested.start), SIDES[0], &median).1 < FALSE_ALARM
    };
    found.retain(|line| {
        let stronger = all.iter().filter(|other| other.amplitude > line.amplitude);
        let mut near = stronger.map(|other| (other, spacings(line, other, density)));
        !near.any(|(other, apart)| {
            is_leakage(line, other, density) || apart < SIDES[1] as f64 && !is_narrow(line)
        })
    });
    found
}

/// The end of the multiples of the spacing that are tested: below half the sampling rate.
fn tested_end(density: &Density) -> usize {
    density.segment.div_ceil(2)
}

/// Distance of two lines in spacings.
fn spacings(line: &Line, other: &Line, density: &Density) -> f64 {
    (line.frequency_hz - other.frequency_hz).abs() / density.spacing_hz()
}

/// Whether the density of a line is no more than what the window spreads of a stronger one.
fn is_leakage(line: &Line, stronger: &Line, density: &Density) -> bool {
    let highest =
        |line: &Line| density.points[line.places.clone()].iter().map(|point| point.value).fold(0.0, f64::max);
    let apart = spacings(line, stronger, density);
    // Of a sine on a multiple of the spacing the highest density is a²/3 over the spacing.
    let peak = stronger.amplitude * stronger.amplitude / (3.0 * density.spacing_hz());
    let envelope = 1.0 / (PI * apart * (apart * apart - 1.0));
    apart > 1.0 && highest(line) <= LEAKAGE * peak * envelope * envelope
}

/// A density by multiples of the spacing, mirrored at half the sampling rate.
struct Mirrored<'a> {
    density: &'a Density,
}

impl Mirrored<'_> {
    fn at(&self, k: usize) -> f64 {
        let points = &self.density.points;
        let k = if k > points.len() { self.density.segment - k } else { k };
        points[k - 1].value
    }

    /// The density over the floor of some densities on each side, and the probability that noise has a ratio as high. A
    /// floor of 0 has no ratio.
    fn over_floor(&self, k: usize, side: usize, median: &Median) -> (f64, f64) {
        let values: Vec<f64> = (k - side..=k + side).map(|k| self.at(k)).collect();
        let count = values.len();
        let floor = median.mean(values).filter(|floor| *floor > 0.0);
        let ratio = floor.map_or(0.0, |floor| self.at(k) / floor);
        let tails = distributions::f_tails(ratio, self.density.freedom, median.freedom(count));
        (ratio, tails.map_or(1.0, |[_, above]| above))
    }

    /// The frequency of a line in spacings, from the amplitudes 1 and r of its two highest densities: ± (2r − 1)/(1 + r)
    /// beside the higher one, for the main lobe of the Hann window.
    fn centre(&self, peak: usize, floor: f64) -> f64 {
        let root = |k: usize| libm::sqrt((self.at(k) - floor).max(0.0));
        let (below, above) = (root(peak - 1), root(peak + 1));
        let side = if above > below { 1.0 } else { -1.0 };
        let ratio = below.max(above) / root(peak);
        peak as f64 + side * ((2.0 * ratio - 1.0) / (1.0 + ratio)).clamp(-0.5, 0.5)
    }
}

/// Fewest densities in a cell, the unit of a range of frequencies.
const MIN_IN_CELL: usize = 16;
/// Ratio of the ends of a cell.
const CELL: f64 = 1.189_207_115_002_721;
/// Fewest cells in a range, and least ratio of its ends.
const MIN_CELLS: usize = 3;
const MIN_RATIO: f64 = 2.0;
/// Probability of the scatter of the cells of a white range below which a range is not taken as white.
const UNLIKELY: f64 = 0.05;
/// Most standard errors of the slope of a white range.
const MAX_SLOPE: f64 = 2.0;

/// The density of the widest range of frequencies in which it is flat.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    /// The points of the density that are in the range; those of lines are left out.
    pub places: Range<usize>,
    /// Ends of the range, Hz.
    pub range_hz: [f64; 2],
    /// One-sided density, (″/s)²/Hz.
    pub density: f64,
    /// Its interval, with the probability of those of the density.
    pub interval: (f64, f64),
    /// Degrees of freedom of the density.
    pub freedom: f64,
}

/// The level of a cell.
struct Cell {
    bins: Range<usize>,
    /// Logarithms of the middle frequency and of the density.
    at: f64,
    level: f64,
    /// Inverse of the variance of `level`.
    weight: f64,
}

impl Floor {
    /// The floor of a density with these lines; `None` where no range of at least an octave is flat.
    ///
    /// # Method
    /// The frequencies are divided into cells of a quarter of an octave and at least 16 densities. The level of a cell is
    /// the median of its densities, without those of lines. A range of cells is flat if the χ² of the logarithms of their
    /// levels around their mean has a probability of at least 5 %, and a slope over the logarithm of the frequency is at
    /// most two standard errors. The floor is the median of all densities of the widest flat range over the median of
    /// their distribution.
    ///
    /// # Bias
    /// Other noise that is too weak in the range to show as a slope is part of the floor.
    pub fn new(density: &Density, lines: &[Line]) -> Option<Floor> {
        let median = Median::new(density.freedom)?;
        let is_clear = |k: &usize| !lines.iter().any(|line| line.places.contains(&(k - 1)));
        let values = |bins: Range<usize>| -> Vec<f64> {
            bins.filter(is_clear).map(|k| density.points[k - 1].value).collect()
        };
        let cell = |bins: Range<usize>| {
            let values = values(bins.clone());
            let weight = 0.5 * median.freedom(values.len());
            let level = libm::log(median.mean(values)?);
            let at = libm::log(0.5 * (bins.start + bins.end) as f64);
            level.is_finite().then_some(Cell { bins, at, level, weight })
        };
        let cells: Vec<Cell> = cells(FIRST..tested_end(density)).into_iter().filter_map(cell).collect();
        let bins = widest(&cells)?;
        Floor::over(density, lines, bins.start - 1..bins.end - 1)
    }

    /// The level of a density over some of its points, without those of lines, as if it were flat there; `None` if there are
    /// too few.
    pub fn over(density: &Density, lines: &[Line], places: Range<usize>) -> Option<Floor> {
        let median = Median::new(density.freedom)?;
        let is_clear = |place: &usize| !lines.iter().any(|line| line.places.contains(place));
        let values: Vec<f64> =
            places.clone().filter(is_clear).map(|place| density.points[place].value).collect();
        if values.len() < MIN_IN_CELL {
            return None;
        }
        let freedom = median.freedom(values.len());
        let level = median.mean(values)?;
        let (low, high) = ends(freedom, density.confidence)?;
        let hz = |place: usize| density.points[place].frequency_hz;
        Some(Floor {
            range_hz: [hz(places.start), hz(places.end - 1)],
            places,
            density: level,
            interval: (low * level, high * level),
            freedom,
        })
    }
}

/// Cells over a range of multiples of the spacing; a short rest belongs to the last one.
fn cells(all: Range<usize>) -> Vec<Range<usize>> {
    let mut cells = Vec::new();
    let mut start = all.start;
    while start < all.end {
        let end = (start + MIN_IN_CELL).max(libm::ceil(CELL * start as f64) as usize);
        let end = if end + MIN_IN_CELL > all.end { all.end } else { end };
        cells.push(start..end);
        start = end;
    }
    cells
}

/// The widest flat range of cells.
fn widest(cells: &[Cell]) -> Option<Range<usize>> {
    let mut best: Option<Range<usize>> = None;
    for first in 0..cells.len() {
        for end in first + MIN_CELLS..=cells.len() {
            let range = cells[first].bins.start..cells[end - 1].bins.end;
            let is_wider = best.as_ref().is_none_or(|best| range.len() > best.len());
            let is_octave = range.end as f64 >= MIN_RATIO * range.start as f64;
            if is_wider && is_octave && is_flat(&cells[first..end]) {
                best = Some(range);
            }
        }
    }
    best
}

/// Whether the levels of some cells are equal but for their scatter.
fn is_flat(cells: &[Cell]) -> bool {
    let weights: f64 = cells.iter().map(|cell| cell.weight).sum();
    let mean = |of: fn(&Cell) -> f64| cells.iter().map(|cell| cell.weight * of(cell)).sum::<f64>() / weights;
    let (level, at) = (mean(|cell| cell.level), mean(|cell| cell.at));
    let sum = |of: &dyn Fn(&Cell) -> f64| cells.iter().map(|cell| cell.weight * of(cell)).sum::<f64>();
    let chi_squared = sum(&|cell| (cell.level - level) * (cell.level - level));
    let slope =
        sum(&|cell| (cell.at - at) * cell.level) / libm::sqrt(sum(&|cell| (cell.at - at) * (cell.at - at)));
    survival(chi_squared, cells.len() - 1) >= UNLIKELY && slope.abs() <= MAX_SLOPE
}

/// The distribution of the median of densities at neighbouring frequencies, in units of their mean.
#[derive(Debug, Clone, Copy)]
struct Median {
    /// Median of one density.
    pub(crate) factor: f64,
    /// Variance of the median of n densities over its square, times n.
    variance: f64,
}

impl Median {
    /// That of densities with these degrees of freedom; `None` if they have no quantiles.
    ///
    /// The variance of a median of n values is Σ_d C_d/(4f²n) with the density f of one value at its median and the
    /// correlation C_d = (2/π) arcsin ρ_d of the signs of two values, d places apart, around it. The latter is that of
    /// normal values.
    pub(crate) fn new(freedom: f64) -> Option<Median> {
        let median = distributions::chi_squared_quantile(0.5, freedom)?;
        let half = 0.5 * freedom;
        let log = (half - 1.0) * libm::log(0.5 * median) - 0.5 * median - libm::lgamma(half);
        // Of χ² itself, whose mean is `freedom`: f times the median is free of the unit.
        let density = 0.5 * libm::exp(log) * median;
        let signs = 1.0 + NEIGHBOURS.map(|c| 2.0 * FRAC_2_PI * libm::asin(c)).iter().sum::<f64>();
        Some(Median { factor: median / freedom, variance: signs / (4.0 * density * density) })
    }

    /// Degrees of freedom of a mean that scatters as much as the median of `count` densities.
    pub(crate) fn freedom(&self, count: usize) -> f64 {
        2.0 * count as f64 / self.variance
    }

    /// The mean of densities by their median, which a few of them cannot change by much however large they are.
    pub(crate) fn mean(&self, mut values: Vec<f64>) -> Option<f64> {
        let middle = values.len() / 2;
        let is_even = values.len().is_multiple_of(2);
        if values.is_empty() {
            return None;
        }
        let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
        let lower = below.iter().copied().filter(|_| is_even).fold(f64::NEG_INFINITY, f64::max);
        let median = if is_even { 0.5 * (lower + *upper) } else { *upper };
        Some(median / self.factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_and_the_variance_are_those_of_scipy() {
        // chi2.median(v)/v and Σ_d C_d/(4·(v·chi2.pdf(v·m, v))²)/m² with that m, SciPy 1.17.
        for (freedom, factor, variance) in FROM_SCIPY {
            let found = Median::new(freedom).unwrap();
            assert!((found.factor / factor - 1.0).abs() < 1e-7, "{freedom}: {}", found.factor);
            assert!((found.variance / variance - 1.0).abs() < 1e-7, "{freedom}: {}", found.variance);
        }
    }

    #[test]
    fn the_median_of_an_even_number_is_between_the_middle_ones() {
        let one = Median { factor: 1.0, variance: 1.0 };
        assert_eq!(one.mean(vec![4.0, 1.0, 9.0, 2.0]), Some(3.0));
        assert_eq!(one.mean(vec![4.0, 1.0, 9.0]), Some(4.0));
        assert_eq!(one.mean(vec![]), None);
    }

    const FROM_SCIPY: [(f64, f64, f64); 3] = [
        (2.0, 0.6931471805599455, 3.375497338446589),
        (5.785714285714286, 0.8874347777611452, 0.9703553261931418),
        (28.52112676056338, 0.9767251465076218, 0.1821607320326096),
    ];
}
