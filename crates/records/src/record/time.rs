//! Conversion of time stamps to evenly spaced samples with gaps.

use crate::record::recording::Rules;
use sagnac_base::quantity::number::significant;

/// Steps from which on a gap is rounded to a whole number of them without a check, because clocks drift.
pub(crate) const LONG_GAP: f64 = 10.0;

/// Largest ratio of the number of samples to those in the file. A larger one is an error in a time stamp, for which no
/// memory may be allocated.
pub(crate) const SPARSEST: f64 = 10.0;

/// Most steps from which the median is taken.
const MAX_STEPS: usize = 1 << 16;

/// The rows of a log on an even grid.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Grid {
    /// Step in the unit of the stamps.
    pub step: f64,
    /// Number of samples from the first row to the last, both included.
    pub samples: usize,
    /// Index of the sample of each row; absent where rows are samples without a gap.
    pub places: Option<Vec<u32>>,
}

/// A fault in the stamp of a row, counted from 0, with its message, label and help.
#[derive(Debug)]
pub(crate) struct TimeFault {
    pub row: usize,
    pub words: [String; 3],
}

impl TimeFault {
    fn new(row: usize, message: impl Into<String>, label: &str, help: &str) -> TimeFault {
        TimeFault { row, words: [message.into(), label.to_owned(), help.to_owned()] }
    }
}

/// The grid of `stamps` in a unit of `unit_s`, as far as `rules` accept it.
///
/// The sampling step is the median one, refined over the whole record. Where a step is longer, samples are missing.
pub(crate) fn grid(stamps: &[f64], unit_s: f64, rules: &Rules) -> Result<Grid, TimeFault> {
    let seconds = |stamp: f64| format!("{} s", significant(stamp * unit_s, 6));
    for (row, stamp) in stamps.iter().enumerate() {
        if !stamp.is_finite() {
            let help = "remove the row, or give `rate = HZ` instead of stamps";
            return Err(TimeFault::new(row, "the time is missing", "no number", help));
        }
        if row > 0 && *stamp <= stamps[row - 1] {
            let message = format!("the time does not increase: {stamp} after {}", stamps[row - 1]);
            let help =
                "sort the rows by time and remove doubles; logs appended to each other are several records";
            return Err(TimeFault::new(row, message, "not later than the row before", help));
        }
    }
    let [first, .., last] = *stamps else {
        return Ok(Grid { step: 1.0, samples: stamps.len(), places: None });
    };
    let median = median_step(stamps);
    let (mut longest, mut gapless, mut total) = ((0, 0.0), true, 0.0);
    for (before, pair) in stamps.windows(2).enumerate() {
        let step = pair[1] - pair[0];
        let steps = whole_steps(step, median, rules.jitter).filter(|steps| *steps == 1.0 || rules.has_gaps);
        let Some(steps) = steps else {
            let (step, median) = (seconds(step), seconds(median));
            let message =
                format!("the samples are not evenly spaced: a step of {step}, the median is {median}");
            return Err(TimeFault::new(before + 1, message, "not on the grid", rules.uneven));
        };
        gapless &= steps == 1.0;
        total += steps;
        if step > longest.1 {
            longest = (before + 1, step);
        }
    }
    if total + 1.0 > rules.most as f64 || total > SPARSEST * stamps.len() as f64 {
        let (gap, median) = (seconds(longest.1), seconds(median));
        let message = format!("most of the record is missing: a gap of {gap} at steps of {median}");
        let help = "is a time stamp wrong? correct it, or cut the log there: at most ten times as many samples may be \
                    missing as there are";
        return Err(TimeFault::new(longest.0, message, "after the longest gap", help));
    }
    let places = (!gapless).then(|| {
        let mut place = 0;
        let steps = stamps.windows(2).map(|pair| libm::round((pair[1] - pair[0]) / median) as u32);
        let after = steps.map(|steps| {
            place += steps;
            place
        });
        std::iter::once(0).chain(after).collect()
    });
    Ok(Grid { step: (last - first) / total, samples: total as usize + 1, places })
}

/// The whole number of median steps in a `step` between stamps, from which it may deviate by `jitter` of them, unless it is long.
pub(crate) fn whole_steps(step: f64, median: f64, jitter: f64) -> Option<f64> {
    let steps = libm::round(step / median);
    let is_whole = steps >= LONG_GAP || steps >= 1.0 && (step / median - steps).abs() <= jitter;
    is_whole.then_some(steps)
}

/// The median of all steps, or of [`MAX_STEPS`] evenly spread over the record. Of two in the middle the shorter one is
/// taken, because longer ones are gaps.
pub(crate) fn median_step(stamps: &[f64]) -> f64 {
    let stride = (stamps.len() / MAX_STEPS).max(1);
    let mut steps: Vec<f64> = stamps.windows(2).step_by(stride).map(|pair| pair[1] - pair[0]).collect();
    let middle = (steps.len() - 1) / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

impl Grid {
    /// The values of the rows at their samples, NaN at the others.
    pub(crate) fn spread(&self, values: Vec<f64>) -> Vec<f64> {
        let Some(places) = &self.places else { return values };
        let mut samples = vec![f64::NAN; self.samples];
        for (&place, value) in places.iter().zip(values) {
            samples[place as usize] = value;
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOG: Rules = Rules { most: 1 << 20, missing: "", jitter: 0.1, has_gaps: true, uneven: "" };

    #[test]
    fn steps_of_several_samples_are_gaps_and_the_step_is_that_of_the_whole_record() {
        let stamps: Vec<f64> =
            (0..100).filter(|i| ![3, 50, 51].contains(i)).map(|i| 7.0 + 0.02 * f64::from(i)).collect();
        let grid = grid(&stamps, 1.0, &LOG).unwrap();
        assert_eq!(grid.samples, 100);
        assert!((grid.step - 0.02).abs() < 1e-15);
        let samples = grid.spread(vec![1.0; 97]);
        let missing: Vec<usize> = (0..100).filter(|&i| samples[i].is_nan()).collect();
        assert_eq!(missing, [3, 50, 51]);
    }

    #[test]
    fn stamps_of_the_epoch_in_ns_keep_their_step() {
        let stamps: Vec<f64> =
            (0..1000_u64).map(|i| (1_700_000_000_000_000_000 + 2_500_000 * i) as f64).collect();
        let grid = grid(&stamps, 1.0, &LOG).unwrap();
        assert_eq!((grid.samples, grid.places), (1000, None));
        assert!((grid.step / 2.5e6 - 1.0).abs() < 1e-6, "{}", grid.step);
    }

    #[test]
    fn stamps_that_are_no_grid_are_refused_at_their_row() {
        let even = |i: usize| i as f64;
        let with = |row: usize, stamp: f64| {
            let mut stamps: Vec<f64> = (0..20).map(even).collect();
            stamps[row] = stamp;
            grid(&stamps, 1.0, &LOG).unwrap_err()
        };
        for (row, stamp, piece) in [
            (5, 4.0, "does not increase: 4 after 4"),
            (5, 3.0, "does not increase: 3 after 4"),
            (5, f64::NAN, "missing"),
            (5, 5.2, "a step of 1.2 s"),
            (5, 4.3, "a step of 0.3 s"),
            // One year at 1 s.
            (19, 3.2e7, "most of the record is missing"),
            (19, 1e300, "most of the record is missing"),
        ] {
            let fault = with(row, stamp);
            assert_eq!(fault.row, row, "{fault:?}");
            assert!(fault.words[0].contains(piece), "{fault:?}");
        }
    }

    #[test]
    fn few_rows_are_a_grid_too() {
        assert_eq!(grid(&[], 1.0, &LOG).unwrap().samples, 0);
        assert_eq!(grid(&[3.0], 1.0, &LOG).unwrap().samples, 1);
        assert_eq!(grid(&[3.0, 5.0], 1.0, &LOG).unwrap(), Grid { step: 2.0, samples: 2, places: None });
        assert_eq!(grid(&[0.0, 1.0, 3.0], 1.0, &LOG).unwrap().places, Some(vec![0, 1, 3]));
    }
}
