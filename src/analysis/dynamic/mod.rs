//! The Allan deviation over time: windows along a log, and whether its noise changes.
//!
//! ```text
//! Log ─ angles ─┬─ windows ─▶ deviation over time and τ: dynamic.csv, map
//!               └─ change ──▶ p of a change at each octave of τ: stationarity.csv, sentence
//! ```

pub mod change;
pub mod report;

use crate::analysis::log::{Treatment, model, temperatures};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::{Angles, Deviation, Point, Unit, curve, suppose};
use sagnac_records::record::log::{Channel, Log};
use sagnac_theory::allan::Process;

use crate::analysis::dynamic::change::{Octave, octaves};

/// Windows of the default length in a record without overlap.
const USUAL_PARTS: f64 = 16.0;
/// Fewest samples of a window.
const MIN_WINDOW: usize = 64;
/// Most windows of a record, more than a map can show.
const MAX_WINDOWS: usize = 4000;
/// Longest τ, as a part of a window.
const MAX_TAU_PART: usize = 4;
/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;

/// Why a record cannot be divided into windows.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DynamicError {
    /// The window has too few samples.
    #[error(
        "the window of {} s is too short: it has {samples} samples and needs {MIN_WINDOW}\ngive at least `dynamic = {}s`",
        shown(*window_s), shown(*least_s)
    )]
    Short {
        /// Length of the window, s.
        window_s: f64,
        /// Number of its samples.
        samples: usize,
        /// Length of the shortest window, s.
        least_s: f64,
    },
    /// The record has too few windows to show a change.
    #[error(
        "the window of {} s is too long for a record of {} s, which must contain at least two\ngive at most `dynamic = {}s`",
        shown(*window_s), shown(*length_s), shown(*most_s)
    )]
    Long {
        /// Length of the window, s.
        window_s: f64,
        /// Length of the record, s.
        length_s: f64,
        /// Length of the longest window, s.
        most_s: f64,
    },
    /// The record has more windows than anything can show.
    #[error(
        "the record of {} s has more than {MAX_WINDOWS} windows of {} s\ngive at least `dynamic = {}s`",
        shown(*length_s), shown(*window_s), shown(*least_s)
    )]
    Many {
        /// Length of the window, s.
        window_s: f64,
        /// Length of the record, s.
        length_s: f64,
        /// Length of the shortest window that is accepted, s.
        least_s: f64,
    },
}

/// A time of a message, with digits enough to give it back.
fn shown(time_s: f64) -> String {
    significant(time_s, 9)
}

/// The noise of a log over time.
#[derive(Debug)]
pub struct Dynamic {
    /// Length of the windows, s.
    pub window_s: f64,
    /// Columns of the log.
    pub columns: Vec<Column>,
}

/// The noise of a column over time.
#[derive(Debug)]
pub struct Column {
    /// Name without unit.
    pub name: String,
    /// Unit of its deviations.
    pub unit: Unit,
    /// Overlapping Allan deviations of the whole record at the octaves of the windows.
    pub whole: Vec<Point>,
    /// Windows in the order of time, each of which overlaps half of the one before.
    pub windows: Vec<Window>,
    /// Tests for a change at octaves of τ; empty for a short record.
    pub octaves: Vec<Octave>,
    /// The noise that describes the curve of the record, if there is one.
    pub model: Option<Process>,
    /// Number of samples of the record.
    pub samples: usize,
    /// Time left out at the start of the file, s.
    pub skipped_s: f64,
}

/// A window of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Start and end, from the start of the file, s.
    pub range_s: [f64; 2],
    /// Overlapping Allan deviations at octaves of τ; a point without value has lost more than half of its terms to gaps.
    pub points: Vec<Point>,
}

impl Dynamic {
    /// The noise of all columns of a log over time, in windows of this length, s; by default a sixteenth of the record.
    ///
    /// # Errors
    /// The window is too short or too long.
    pub fn new(log: &Log, treatment: &Treatment, window_s: Option<f64>) -> Result<Dynamic, DynamicError> {
        let (samples, step_s) = (log.samples(), log.step_s);
        let length_s = samples as f64 * step_s;
        let usual_s = (length_s / USUAL_PARTS).max(MIN_WINDOW as f64 * step_s);
        let window = libm::round(window_s.unwrap_or(usual_s) / step_s) as usize;
        let window_s = window as f64 * step_s;
        let least_s = MIN_WINDOW as f64 * step_s;
        if window < MIN_WINDOW {
            return Err(DynamicError::Short { window_s, samples: window, least_s });
        }
        if 2 * window > samples {
            return Err(DynamicError::Long { window_s, length_s, most_s: (samples / 2) as f64 * step_s });
        }
        if 2 * samples / window > MAX_WINDOWS {
            let least_s = (2 * samples).div_ceil(MAX_WINDOWS) as f64 * step_s;
            return Err(DynamicError::Many { window_s, length_s, least_s });
        }
        let temperatures = if treatment.events_removed { temperatures(log).1 } else { vec![] };
        let column = |channel: &Channel| {
            let (angles, _) = treatment.angles(&channel.view(log.data, step_s), &temperatures);
            let model = model(&angles, treatment.trend);
            Column {
                name: channel.name.clone(),
                unit: channel.unit.curves,
                whole: points(&angles, window, model.as_ref()),
                windows: windows(&angles, window, log.start_s, model.as_ref()),
                octaves: octaves(&angles),
                model: model.map(|(process, _)| process),
                samples,
                skipped_s: log.start_s,
            }
        };
        Ok(Dynamic { window_s, columns: log.channels.iter().map(column).collect() })
    }
}

/// The windows of a record that starts at this time.
fn windows(angles: &Angles, window: usize, start_s: f64, model: Option<&(Process, f64)>) -> Vec<Window> {
    let starts = (0..).step_by(window / 2).take_while(|start| start + window < angles.len());
    let of = |start: usize| Window {
        range_s: [start, start + window].map(|sample| start_s + sample as f64 * angles.step_s),
        points: points(&angles.part(start..start + window + 1), window, model),
    };
    starts.map(of).collect()
}

/// The deviations of a part of a record at the octaves of a window.
fn points(angles: &Angles, window: usize, model: Option<&(Process, f64)>) -> Vec<Point> {
    let ms: Vec<usize> =
        (0..usize::BITS - 1).map(|octave| 1 << octave).take_while(|m| MAX_TAU_PART * m <= window).collect();
    let mut points = curve(angles, Deviation::Oadev, &ms, CONFIDENCE);
    suppose(&mut points, angles, Deviation::Oadev, CONFIDENCE, model);
    for point in &mut points {
        if 2 * point.terms < Deviation::Oadev.terms(angles.len(), point.m) as u64 {
            *point = Point { value: None, edf: None, interval: None, ..*point };
        }
    }
    points
}
