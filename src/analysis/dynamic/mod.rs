//! The Allan deviation over time: windows along a log, and whether its noise changes.
//!
//! ```text
//! Log ─ angles ─┬─ windows ─▶ deviation over time and τ: dynamic.csv, map
//!               └─ change ──▶ p of a change at each octave of τ: stationarity.csv, sentence
//! ```
//!
//! To test whether the noise changes, the record is divided into [`PARTS`] parts, and each has its own Allan variance at an octave of
//! τ. If the noise is stationary, the logarithms of these variances scatter about a constant, nearly independently, because the
//! differences of the angle that enter them remember hardly more than 2τ of any noise. The test is the largest of their cumulative
//! sums, in units of their own scatter: the Brownian bridge of Kolmogorov, with the correction for a finite number of steps
//! (D. Siegmund, Sequential Analysis, 1985, ch. 10). The noise model of the record does not enter. p counts all octaves (Bonferroni).
//!
//! A sine whose period is about the length of a part beats with the parts, which looks like a change.

pub mod report;

use rayon::prelude::*;

use crate::analysis::log::{Treatment, model, temperatures};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::sums::{Sum, sums};
use sagnac_records::allan::{Angles, Deviation, Point, Unit, curve, suppose};
use sagnac_records::record::log::{Channel, Log};
use sagnac_theory::allan::Process;

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

/// Number of parts of a record.
pub const PARTS: usize = 64;
/// Fewest parts without long gaps that suffice.
pub const MIN_PARTS: usize = 16;
/// Shortest part, in τ.
const MIN_PART: usize = 8;

/// Mean overshoot of a random walk over a limit, in steps.
const OVERSHOOT: f64 = 0.5826;
/// Probability of a change that is missed at the stated size, as a deviate, times the scatter of a bridge in its middle.
const MISSED: f64 = 1.281_551_565_544_600_4 * 0.5;
/// Probability of a change in a record without one.
pub const FALSE_ALARM: f64 = 0.05;

/// The test at one averaging time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Octave {
    /// Averaging factor m, τ in samples.
    pub m: usize,
    /// Averaging time τ, s.
    pub tau_s: f64,
    /// Number of parts that have a variance.
    pub parts: usize,
    /// Probability of sums at least as large in any of the octaves if the noise is stationary.
    pub p: f64,
    /// The likeliest time of a change, from the start of the record, s.
    pub at_s: f64,
    /// Deviation of the whole record, and those before and after that time, in the unit of the angle per second.
    pub whole: f64,
    /// Deviation before the change.
    pub before: f64,
    /// Deviation after it.
    pub after: f64,
    /// Relative step of the deviation in the middle of the record that would be significant in 9 of 10 cases.
    pub visible: f64,
}

/// The tests of all octaves of a record that have at least [`MIN_PARTS`] parts; empty for a short record.
pub fn octaves(angles: &Angles) -> Vec<Octave> {
    let length = angles.len().saturating_sub(1) / PARTS;
    let ms: Vec<usize> =
        (0..usize::BITS - 1).map(|octave| 1 << octave).take_while(|m| m * MIN_PART <= length).collect();
    let part = |i: usize| sums(&angles.part(i * length..(i + 1) * length + 1), Deviation::Oadev, &ms);
    let parts: Vec<Vec<Sum>> = (0..PARTS).into_par_iter().map(part).collect();
    let mut tested: Vec<(usize, Vec<(usize, Sum)>)> = Vec::new();
    for (place, &m) in ms.iter().enumerate() {
        // Half of the terms of a part without gaps: a variance of fewer would scatter more than the others.
        let least = (length + 2 - 2 * m) as u64 / 2;
        let is_known = |sum: &Sum| sum.terms >= least.max(1) && sum.squares > 0.0;
        let sums = parts.iter().map(|sums| sums[place]).enumerate();
        tested.push((m, sums.filter(|(_, sum)| is_known(sum)).collect()));
    }
    tested.retain(|(_, known)| known.len() >= MIN_PARTS);
    let part_s = length as f64 * angles.step_s;
    let of_octave = |(m, known): &(usize, Vec<(usize, Sum)>)| {
        octave(known, *m, *m as f64 * angles.step_s, part_s, tested.len() as f64)
    };
    tested.iter().map(of_octave).collect()
}

/// The octave with the least p.
fn clearest(octaves: &[Octave]) -> Option<&Octave> {
    octaves.iter().min_by(|a, b| a.p.total_cmp(&b.p))
}

/// The test at one of `tests` octaves, from the sums of the parts that are known, each of which is `part_s` long.
fn octave(known: &[(usize, Sum)], m: usize, tau_s: f64, part_s: f64, tests: f64) -> Octave {
    let count = known.len() as f64;
    let mean_of = |sums: &[(usize, Sum)]| {
        let all: f64 = sums.iter().map(|(_, sum)| sum.squares).sum();
        let terms: u64 = sums.iter().map(|(_, sum)| sum.terms).sum();
        libm::sqrt(all / (2.0 * terms as f64)) / tau_s
    };
    let logs: Vec<f64> = known.iter().map(|(_, sum)| libm::log(sum.squares / sum.terms as f64)).collect();
    let mean = logs.iter().sum::<f64>() / count;
    let squares: f64 = logs.iter().map(|log| (log - mean) * (log - mean)).sum();
    let scatter = libm::sqrt(squares / (count - 1.0));
    let mut sum = 0.0;
    let mut largest = (0.0, known.len() / 2);
    for (place, log) in logs.iter().enumerate().take(known.len() - 1) {
        sum += log - mean;
        if libm::fabs(sum) > largest.0 {
            largest = (libm::fabs(sum), place + 1);
        }
    }
    let (before, after) = known.split_at(largest.1);
    let statistic = if scatter > 0.0 { (largest.0 / scatter + OVERSHOOT) / libm::sqrt(count) } else { 0.0 };
    Octave {
        m,
        tau_s,
        parts: known.len(),
        p: (kolmogorov(statistic) * tests).min(1.0),
        at_s: after.first().map_or(0, |(part, _)| *part) as f64 * part_s,
        whole: mean_of(known),
        before: mean_of(before),
        after: mean_of(after),
        visible: visible(scatter, count, FALSE_ALARM / tests),
    }
}

/// The relative step of a deviation in the middle whose sum exceeds the limit of this p in 9 of 10 cases, for logarithms of variances
/// with this scatter. The step δ of the logarithms itself widens their scatter, to √(scatter² + δ²/4).
fn visible(scatter: f64, parts: f64, p: f64) -> f64 {
    let limit = quantile(p) - OVERSHOOT / libm::sqrt(parts);
    // δ√n/4 = limit·√(scatter² + δ²/4) + 0.64·scatter, a quadratic equation in δ.
    let root = 0.25 * libm::sqrt(parts);
    let (a, b, c) = (
        root * root - 0.25 * limit * limit,
        -2.0 * root * MISSED * scatter,
        (MISSED * MISSED - limit * limit) * scatter * scatter,
    );
    libm::expm1(0.5 * (-b + libm::sqrt(b * b - 4.0 * a * c)) / (2.0 * a))
}

/// The probability that the largest distance of a Brownian bridge from 0 exceeds `x`.
fn kolmogorov(x: f64) -> f64 {
    /// Below it the probability is 1 to 16 digits.
    const MIN_SERIES: f64 = 0.2;
    /// Terms of the series, which are enough above it.
    const TERMS: u32 = 30;
    if x < MIN_SERIES {
        return 1.0;
    }
    let term = |k: u32| {
        let k_x = f64::from(k) * x;
        (if k % 2 == 1 { 2.0 } else { -2.0 }) * libm::exp(-2.0 * k_x * k_x)
    };
    (1..=TERMS).map(term).sum::<f64>().clamp(0.0, 1.0)
}

/// The distance that is exceeded with this probability.
fn quantile(p: f64) -> f64 {
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if kolmogorov(middle) > p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};
    use sagnac_records::allan::Trend;

    fn record(samples: usize, seed: u64, scale: impl Fn(usize) -> f64) -> Angles {
        let mut rng = StdRng::seed_from_u64(seed);
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let rates: Vec<f64> = (0..samples).map(|i| scale(i) * normal()).collect();
        Angles::from_increments(&rates, 0.5, 0.5, Trend::None)
    }

    fn least(octaves: &[Octave]) -> f64 {
        clearest(octaves).unwrap().p
    }

    #[test]
    fn probabilities_are_those_of_scipy() {
        // scipy.stats.kstwobign.sf and .isf, SciPy 1.17.
        for (x, p) in [
            (0.5, 0.9639452436648751),
            (1.0, 0.26999967167735456),
            (1.5, 0.022217962616525127),
            (3.0, 3.045995948942539e-08),
        ] {
            assert!((kolmogorov(x) / p - 1.0).abs() < 1e-12, "{x}: {}", kolmogorov(x));
            assert!((quantile(p) / x - 1.0).abs() < 1e-9, "{p}: {}", quantile(p));
        }
        assert_eq!(kolmogorov(0.1), 1.0);
    }

    #[test]
    fn stationary_records_show_a_change_in_about_5_percent() {
        let shown =
            (0..300).filter(|&seed| least(&octaves(&record(2048, seed, |_| 1.0))) < FALSE_ALARM).count();
        // 5 % of 300 and 3 standard errors.
        assert!(shown <= 26, "{shown} of 300");
    }

    #[test]
    fn a_step_is_found_where_it_is_and_with_its_size() {
        let found = octaves(&record(8192, 7, |i| if i < 5120 { 2.0 } else { 2.6 }));
        let clearest = clearest(&found).unwrap();
        assert!(clearest.p < 1e-6 && clearest.tau_s == 0.5, "{clearest:?}");
        assert!((clearest.at_s - 2560.0).abs() <= 64.0, "{clearest:?}");
        // 3 standard errors of the deviation of 3072 samples.
        assert!((clearest.after / 2.6 - 1.0).abs() < 0.05, "{clearest:?}");
        assert!((clearest.before / 2.0 - 1.0).abs() < 0.05, "{clearest:?}");
    }

    #[test]
    fn the_step_called_visible_is_seen_in_most_records() {
        let visible = octaves(&record(4096, 1, |_| 1.0))[0].visible;
        assert!((0.02..0.2).contains(&visible), "{visible}");
        let scale = |i: usize| if i < 2048 { 1.0 } else { 1.0 + visible };
        let seen =
            (0..100).filter(|&seed| octaves(&record(4096, 100 + seed, scale))[0].p < FALSE_ALARM).count();
        // 90 % less 3 standard errors.
        assert!(seen >= 81, "{seen} of 100 steps of {visible}");
    }

    #[test]
    fn gaps_leave_out_their_parts_and_short_records_have_no_test() {
        let mut rates: Vec<f64> = (0..4096).map(|i| f64::from(i * 7919 % 1009)).collect();
        rates[1000..1400].fill(f64::NAN);
        let found = octaves(&Angles::from_increments(&rates, 1.0, 1.0, Trend::None));
        // Parts have 64 samples; 6 are within the gap entirely or for the most part.
        assert_eq!(found[0].parts, 58);
        assert_eq!(octaves(&record(PARTS * MIN_PART - 1, 1, |_| 1.0)), []);
    }
}
