//! Recorded data: one reader for all files, profiles of motion, which are evenly spaced samples of an angular rate with the
//! angles of ticks over them, and in [`log`] the logs of sensors.
//!
//! ```text
//! file ─ format ─▶ ColumnFile: columns with names, units, places ─▶ Record of a motion | Log of a sensor
//! ```
//!
//! Text is read in blocks, whose lines are parsed in parallel. Memory is 8 bytes for each sample of a requested column,
//! plus 16 MiB. Numbers are parsed by the correctly rounded parser of the standard library. The csv crate is not used
//! here because it takes only one delimiter and one comment sign, no runs of blanks, and does not give the place of a
//! cell.

pub mod binary;
pub(crate) mod cells;
pub(crate) mod column_file;
pub mod curve_file;
pub(crate) mod format;
pub mod layout;
pub mod log;
pub(crate) mod loggers;
pub(crate) mod names;
pub(crate) mod profile;
pub(crate) mod text;
pub(crate) mod time;
pub(crate) mod timestamps;
pub mod write;

use std::io;
use std::ops::RangeInclusive;

use crate::record::column_file::ColumnFile;
use crate::record::format::Origin;
use crate::record::log::read::Hints;
use sagnac_base::diagnostics::{Place, StudyError, Wrong};

/// Most samples of a record, 2^24, which is more than four hours at 1 kHz.
pub const MAX_SAMPLES: usize = 1 << 24;

/// The largest size of a number of a record or a log, in any unit: sums of squares stay finite.
const MAX_NUMBER: f64 = 1e100;

/// What is wrong with a number that is too large to be computed with; `None` for others and for a missing one.
pub fn excess(number: f64) -> Option<String> {
    match number.abs() {
        f64::INFINITY => Some("infinite".to_owned()),
        size if size > MAX_NUMBER => Some(format!("{number:e}, beyond {MAX_NUMBER:e},")),
        _ => None,
    }
}

/// Allowed sampling steps of a record or a log, s. A step outside is an error in a unit, or the bytes are not times.
pub const STEPS_S: RangeInclusive<f64> = 1e-9..=1e9;

/// An angular rate at evenly spaced times, the first of which is time 0. Between its samples the rate is linear in
/// [`Record::tick_angles`], and without power above half the sampling rate in [`Record::band_limited_tick_angles`].
///
/// # File
/// Text in UTF-8, as of a [`Log`](log::Log): a header, then one row per sample. Two columns are read, in
/// any order, and all others ignored: `time` and `rate`, in upper or lower case, each with its unit as in `time [ms]`,
/// `rate (°/s)` or `rate_deg_per_s`. A name such as `rate_x`, whose end is not a unit of a rate, is another column. The
/// times may start anywhere, but each step must be within 1 % of the median one; the steps are then taken as equal.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// The samples, ″/s, 2 … [`MAX_SAMPLES`] of them.
    pub rates: Vec<f64>,
}

impl Record {
    /// Reads a record from its `text`; `name` is the name of the file in messages.
    ///
    /// # Errors
    /// The first fault found, with its place in the text: a missing column, a missing or wrong unit, a cell that is
    /// missing or not a finite number, times that do not increase or are not evenly spaced, steps outside [`STEPS_S`],
    /// too few or too many samples.
    ///
    /// # Example
    /// ```
    /// # use sagnac_records::record::Record;
    /// let record = Record::parse("base.csv", "time [ms], rate [deg/s]\n0, 1.5\n2, 1.5\n4, 1.5\n").unwrap();
    /// assert_eq!((record.step_s, &record.rates[..]), (0.002, &[5400.0; 3][..]));
    /// assert_eq!(record.tick_angles(0.001).len(), 4);
    /// ```
    pub fn parse(name: &str, text: &str) -> Result<Record, RecordError> {
        let file = ColumnFile::open(name.to_owned(), Origin::Bytes(text.as_bytes()), &Hints::default())?;
        profile::read(file, MAX_SAMPLES)
    }

    /// Time from the first sample to the last, s.
    pub fn duration_s(&self) -> f64 {
        self.last() as f64 * self.step_s
    }

    /// Number of whole ticks of `tick_s` > 0 in the record.
    pub fn whole_ticks(&self, tick_s: f64) -> usize {
        // Times are rounded to 12 digits, which must not drop a tick that ends with the record.
        let ticks = self.duration_s() / tick_s * (1.0 + 1e-11);
        if tick_s > 0.0 { ticks as usize } else { 0 }
    }

    /// The angle of each whole tick of `tick_s` > 0, ″: tick k is the integral of the rate over (kT, (k + 1)T].
    ///
    /// It is exact for a rate that is linear between the samples, whatever the ratio of tick and step. It does not know
    /// the rate between samples: with a step longer than the tick, the ticks in between only follow the line. It takes
    /// time in proportion to samples and ticks, and 8 bytes per tick; [`Record::whole_ticks`] counts the ticks
    /// beforehand.
    pub fn tick_angles(&self, tick_s: f64) -> Vec<f64> {
        let angle = |k: usize| self.angle(self.samples_at(k, tick_s), self.samples_at(k + 1, tick_s));
        (0..self.whole_ticks(tick_s)).map(angle).collect()
    }

    /// The start of a tick in steps from the first sample.
    fn samples_at(&self, tick: usize, tick_s: f64) -> f64 {
        (tick as f64 * tick_s / self.step_s).min(self.last() as f64)
    }

    /// The index of the last sample.
    fn last(&self) -> usize {
        self.rates.len().saturating_sub(1)
    }

    /// The integral of the rate from `start` to `end`, both counted in steps from the first sample, ″.
    ///
    /// It is summed for each tick separately, because differences of one running integral would lose digits over a long
    /// record.
    fn angle(&self, start: f64, end: f64) -> f64 {
        let mut sum = 0.0;
        for i in start as usize..(libm::ceil(end) as usize).min(self.last()) {
            let (from, to) = (start.max(i as f64), end.min((i + 1) as f64));
            // The mean of a straight line is at its middle.
            let along = 0.5 * (from + to) - i as f64;
            sum += (to - from) * (self.rates[i] + along * (self.rates[i + 1] - self.rates[i]));
        }
        sum * self.step_s
    }
}

/// Why a record or a log was refused: the finding with its place, the accepted values and a remedy.
///
/// A [`miette::Diagnostic`]; [`RecordError::render`] gives the text for a terminal. It converts to a [`StudyError`] for
/// the study that names the record.
#[derive(Debug, Clone, thiserror::Error, miette::Diagnostic)]
#[error(transparent)]
#[diagnostic(transparent)]
pub struct RecordError(StudyError);

impl RecordError {
    /// An error with the complete finding as `message`, a `label` for the text at `place`, and advice as `help`.
    pub fn new(
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
        place: impl Into<Option<Place>>,
    ) -> RecordError {
        RecordError(StudyError::new(message, label, help, place.into()))
    }

    /// The error for a file that cannot be read.
    pub(crate) fn unreadable(file: &str, error: &io::Error) -> RecordError {
        RecordError::new(format!("cannot read {file}: {error}"), "", "give the path of a log", None)
    }

    /// Replaces the advice of the error.
    pub(crate) fn with_help(self, help: &str) -> RecordError {
        RecordError(self.0.with_help(help))
    }

    /// Returns the error with its settings spelled as a front end spells them; see [`spelled`](sagnac_base::diagnostics::spelled).
    pub fn spelled(self, spell: &dyn Fn(&str, &str) -> Option<String>) -> RecordError {
        RecordError(self.0.spelled(spell))
    }

    /// The report for the user, with file, line, caret and help, `width` columns wide; it has escape codes only if
    /// `color`.
    pub fn render(&self, color: bool, width: usize) -> String {
        self.0.render(color, width)
    }
}

/// The error of bytes without the structure of their format.
pub(crate) fn malformed<T>(why: &str) -> io::Result<T> {
    Err(io::Error::other(why))
}

/// Why bytes cannot be read, in words.
pub(crate) fn told(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "it ends too early".to_owned(),
        _ => error.to_string(),
    }
}

/// The faults found in a file so far.
#[derive(Default)]
pub(crate) struct Faults(Vec<RecordError>);

impl Faults {
    pub(crate) fn add(&mut self, fault: RecordError) {
        self.0.push(fault);
    }

    /// The value, or none after its fault was added.
    pub(crate) fn take<T>(&mut self, result: Result<T, RecordError>) -> Option<T> {
        result.map_err(|fault| self.add(fault)).ok()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The only fault, or one that lists all; there is at least one.
    pub(crate) fn into_error(self, file: &str) -> RecordError {
        let message = format!("{file} has {} problems, each with what settles it", self.0.len());
        self.listed(message)
    }

    /// The only fault, or all below a `message`.
    pub(crate) fn listed(mut self, message: String) -> RecordError {
        match self.0.len() {
            1 => self.0.remove(0),
            _ => RecordError(StudyError::of_several(message, self.0.into_iter().map(|fault| fault.0))),
        }
    }
}

impl From<RecordError> for StudyError {
    fn from(error: RecordError) -> StudyError {
        error.0
    }
}

impl From<RecordError> for Wrong {
    fn from(error: RecordError) -> Wrong {
        Wrong::Elsewhere(error.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of `rate` at 0, `step_s`, … up to `duration_s`.
    fn sampled(duration_s: f64, step_s: f64, rate: impl Fn(f64) -> f64) -> Record {
        let steps = libm::round(duration_s / step_s) as usize;
        Record { step_s, rates: (0..=steps).map(|i| rate(i as f64 * step_s)).collect() }
    }

    /// Ticks shorter and longer than the steps of 2 ms used in the tests, commensurate and not.
    const TICKS: [f64; 6] = [0.0005, 0.000_73, 0.002, 0.003_1, 0.005, 0.031_4];

    #[test]
    fn a_constant_rate_turns_by_rate_times_tick() {
        let record = sampled(1.0, 0.002, |_| 7.0);
        for tick_s in TICKS {
            let angles = record.tick_angles(tick_s);
            assert_eq!(angles.len(), libm::floor(1.0 / tick_s + 1e-9) as usize, "tick {tick_s}");
            for (k, angle) in angles.iter().enumerate() {
                assert!((angle / (7.0 * tick_s) - 1.0).abs() < 1e-12, "tick {k} of {tick_s} s: {angle}");
            }
        }
    }

    #[test]
    fn a_ramp_is_integrated_exactly() {
        let record = sampled(1.0, 0.002, |t| 300.0 - 1000.0 * t);
        for tick_s in TICKS {
            for (k, angle) in record.tick_angles(tick_s).iter().enumerate() {
                let middle = (k as f64 + 0.5) * tick_s;
                let exact = (300.0 - 1000.0 * middle) * tick_s;
                assert!(
                    (angle - exact).abs() < 1e-12 * 300.0 * tick_s,
                    "tick {k} of {tick_s} s: {angle}, not {exact}"
                );
            }
        }
    }

    #[test]
    fn a_sine_is_met_within_the_error_of_straight_lines_and_no_better() {
        let (amplitude, step_s) = (12000.0, 0.002);
        let omega = core::f64::consts::TAU * 20.0;
        let record = sampled(2.0, step_s, |t| amplitude * libm::sin(omega * t));
        for tick_s in TICKS {
            // The line deviates from the curve by at most h²/8 of its second derivative, in the middle.
            let bound = tick_s * amplitude * omega * omega * step_s * step_s / 8.0;
            let error = |(k, angle): (usize, &f64)| {
                let (from, to) = (k as f64 * tick_s, (k + 1) as f64 * tick_s);
                let exact = amplitude / omega * (libm::cos(omega * from) - libm::cos(omega * to));
                (angle - exact).abs()
            };
            let worst = record.tick_angles(tick_s).iter().enumerate().map(error).fold(0.0, f64::max);
            assert!(worst <= bound && worst > 0.2 * bound, "tick {tick_s}: {worst} against {bound}");
        }
    }

    #[test]
    fn the_ticks_add_up_to_the_turn_of_the_whole_record() {
        let record = sampled(3.0, 0.002, |t| 50.0 + 12000.0 * libm::sin(91.0 * t));
        let inner: f64 = record.rates[1..record.last()].iter().sum();
        let whole = record.step_s * (inner + 0.5 * (record.rates[0] + record.rates[record.last()]));
        for ticks in [1, 7, 600, 1501, 4000] {
            let angles = record.tick_angles(3.0 / f64::from(ticks));
            let sum: f64 = angles.iter().sum();
            assert_eq!(angles.len(), ticks as usize, "{ticks} ticks of {} s", 3.0 / f64::from(ticks));
            assert!((sum - whole).abs() < 1e-9, "{ticks} ticks: {sum}, not {whole}");
        }
    }

    #[test]
    fn a_tick_longer_than_the_record_or_not_positive_has_no_angle() {
        let record = sampled(1.0, 0.002, |_| 7.0);
        for tick_s in [1.001, f64::INFINITY, 0.0, -1.0, f64::NAN] {
            assert_eq!(record.tick_angles(tick_s).len(), 0, "{tick_s}");
        }
    }

    #[test]
    fn the_record_that_is_shipped_is_read() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../studies/data/base_vibration.csv");
        let text = std::fs::read_to_string(path).unwrap();
        let record =
            Record::parse(path, &text).unwrap_or_else(|error| panic!("{}", error.render(false, 110)));
        assert_eq!((record.rates.len(), record.step_s, record.whole_ticks(0.005)), (6000, 0.002, 2399));
        let ticks = record.tick_angles(0.005);
        let rms = libm::sqrt(ticks.iter().map(|angle| angle * angle).sum::<f64>() / ticks.len() as f64);
        assert!((rms - 41.938_86).abs() < 1e-5, "{rms}");
    }

    #[test]
    fn an_error_shows_the_true_line_and_column_even_of_a_line_that_is_cut() {
        let line = format!("{}oops,{}", "1,".repeat(5000), "2,".repeat(5000));
        let place = Place::new("g.csv", 1_000_001, line.as_bytes(), 10_000..10_004);
        let shown = RecordError::new("bad cell", "not a number", "mend it", place).render(false, 100);
        for piece in ["g.csv:1000001:10001", "oops", "not a number", "mend it"] {
            assert!(shown.contains(piece), "{piece} is missing in\n{shown}");
        }
        assert!(shown.len() < 1500, "{shown}");
    }

    #[test]
    fn a_line_that_is_no_utf_8_is_shown_all_the_same() {
        let place = Place::new("g.csv", 1, b"rate [\xb0/s],x", 6..8);
        let shown = RecordError::new("bad unit", "here", "write deg/s", place).render(false, 100);
        assert!(shown.contains("g.csv:1:7"), "{shown}");
        let beyond = Place::new("g.csv", 1, b"1,2", 40..50);
        assert!(RecordError::new("short", "here", "", beyond).render(false, 80).contains("g.csv:1:"));
    }
}
