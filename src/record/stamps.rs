//! Time stamps as loggers write them: since the epoch, late, doubled, or from a counter that rolls over.

use crate::quantity::number::significant;
use crate::record::log::read::Duplicates;
use crate::record::time::{Grid, LONG_GAP, SPARSEST, TimeFault, median_step};

/// Seconds since 1970 that count as a time stamp, from 2001 to 2096. In a thousandth of the unit they are other years by
/// far, so the unit follows from the size.
const EPOCH_S: std::ops::Range<f64> = 1e9..4e9;

/// Longest sampling step of a log whose stamps have no unit, s.
const LONGEST_STEP_S: f64 = 100.0;

/// Units of time, s.
const UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];

/// Rates of sensors.
const SENSORS_HZ: std::ops::Range<f64> = 0.5..20e3;

/// Values at which counters roll over: those of 16, 24 and 32 bits, the last also of µs shown in ms and in s, and the seconds
/// of a day and of a GPS week, also in ms.
const LIMITS: [f64; 9] = [
    4_294.967_296,
    65_536.0,
    86_400.0,
    604_800.0,
    4_294_967.296,
    16_777_216.0,
    86_400_000.0,
    604_800_000.0,
    4_294_967_296.0,
];

/// Stamps on each side of a row that tell whether samples are missing before it, and those of a coarse clock, of which each has many rows.
const BESIDE: usize = 64;
const BESIDE_COARSE: usize = 8;
/// Stamps before a row with which it is compared first.
const NEAR: usize = 8;
/// Least rise of the stamps over the rows, in sampling steps, that is a gap, and fewest stamps after it that show a short one. The first row
/// of a coarse stamp is up to one step late.
const LEAST_RISE: f64 = 0.7;
const LEAST_RISE_COARSE: f64 = 1.2;
const LEAST_AFTER: usize = 8;
/// Deviation of steps from whole sampling steps, and of the rate of a clock from the given one, that are none of samples.
const JITTER: f64 = 0.1;
const MOST_DRIFT: f64 = 0.02;

/// Most sensors whose rows take turns in a log, and most rows of one of them in a row.
const MOST_SENSORS: usize = 8;
const MOST_ROWS_IN_TURN: usize = 4;

/// Rows of a block of which the mean step is taken.
const BLOCK: usize = 256;
/// Largest part of the samples that may be missing at many steps; else the least distances of stamps are not the sampling step.
const MOST_MISSING: f64 = 0.5;
/// Fewest rows for each gap of samples that are missing for a reason.
const ROWS_PER_GAP: f64 = 50.0;

/// The unit of stamps since the epoch, of which the first is `stamp`.
pub(crate) fn epoch_unit(stamp: f64) -> Option<(&'static str, f64)> {
    UNITS.into_iter().find(|(_, unit_s)| EPOCH_S.contains(&(stamp * unit_s)))
}

/// The unit of the stamps of a log if they count from the epoch. Stamps that count from the start of a device may have the size of
/// those in a coarser unit, so a unit in which the steps are too long is not taken.
pub(crate) fn epoch_unit_of(stamps: &[f64]) -> Option<(&'static str, f64)> {
    let is_short = |unit_s: f64| stamps.len() < 2 || median_step(stamps) * unit_s <= LONGEST_STEP_S;
    epoch_unit(*stamps.first()?).filter(|(_, unit_s)| is_short(*unit_s))
}

/// Whether steps of `step_s` are those of a sensor.
pub(crate) fn is_step_of_sensor(step_s: f64) -> bool {
    SENSORS_HZ.contains(&(1.0 / step_s))
}

/// The units of stamps with a mean step that give the rate of a sensor, with that rate, Hz; only the one that is the last of the `words`
/// of the name of the stamps, where it does.
pub(crate) fn likely_units(step: f64, words: &[String]) -> Vec<(&'static str, f64)> {
    let likely = UNITS.into_iter().filter(|(_, unit_s)| is_step_of_sensor(step * unit_s));
    let mut likely: Vec<_> = likely.map(|(unit, unit_s)| (unit, 1.0 / (step * unit_s))).collect();
    let is_named = |unit: &str| words.len() > 1 && words.last().is_some_and(|word| word == unit);
    if likely.iter().any(|(unit, _)| is_named(unit)) {
        likely.retain(|(unit, _)| is_named(unit));
    }
    likely
}

/// The stamps of a counter in a row: wherever it has rolled over, its limit is added. Returns that limit and how many times
/// it was reached.
///
/// Only a limit that no stamp exceeds is taken, and only if it turns each step back into one of at most ten sampling steps.
pub(crate) fn unroll(stamps: &mut [f64]) -> Option<(f64, usize)> {
    let backwards: Vec<f64> =
        stamps.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step < 0.0).collect();
    if backwards.is_empty() || stamps.iter().any(|stamp| stamp.is_nan() || *stamp < 0.0) {
        return None;
    }
    let most = stamps.iter().copied().fold(0.0, f64::max);
    let step = if are_coarse(stamps) { step_of_distinct(stamps) } else { median_step(stamps) };
    let longest = LONG_GAP * step;
    let fits =
        |limit: &f64| *limit > most && backwards.iter().all(|step| (0.0..=longest).contains(&(step + limit)));
    let limit = LIMITS.into_iter().find(fits)?;
    let (mut offset, mut before) = (0.0, stamps[0]);
    for stamp in stamps {
        if *stamp < before {
            offset += limit;
        }
        before = *stamp;
        *stamp += offset;
    }
    Some((limit, backwards.len()))
}

/// Rows that have the stamp of the row before.
pub(crate) struct Doubled {
    /// The rows that remain.
    pub kept: Vec<usize>,
    /// Rows that repeat all requested numbers of the row before.
    pub repeated: usize,
    /// Rows with other numbers, and the first of them.
    pub differing: usize,
    pub first: Option<usize>,
}

/// Finds rows with the stamp of the row before. Those that repeat the row are left out, and the others as `duplicates` says;
/// if all are kept, counts may repeat too.
pub(crate) fn doubled(
    stamps: &[f64],
    columns: &[Vec<f64>],
    duplicates: Option<Duplicates>,
) -> Option<Doubled> {
    if stamps.windows(2).all(|pair| pair[0] != pair[1]) {
        return None;
    }
    let mut found =
        Doubled { kept: Vec::with_capacity(stamps.len()), repeated: 0, differing: 0, first: None };
    for row in 0..stamps.len() {
        let Some(&before) = found.kept.last().filter(|&&before| stamps[before] == stamps[row]) else {
            found.kept.push(row);
            continue;
        };
        let is_repeated = columns.iter().all(|column| column[row].to_bits() == column[before].to_bits());
        match duplicates {
            Some(Duplicates::Keep) => found.kept.push(row),
            _ if is_repeated => {
                found.repeated += 1;
                continue;
            }
            Some(Duplicates::Last) => *found.kept.last_mut().unwrap_or(&mut 0) = row,
            _ => {}
        }
        found.differing += 1;
        found.first = found.first.or(Some(row));
    }
    Some(found)
}

/// The numbers of the sensors whose rows take turns, where `numbers` has that of each row and the stamps are not evenly spaced.
pub(crate) fn interleaved(stamps: &[f64], numbers: &[f64]) -> Option<Vec<f64>> {
    let changes = numbers.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let mut sensors: Vec<f64> = Vec::new();
    for number in numbers {
        if !sensors.contains(number) {
            sensors.push(*number);
        }
        if sensors.len() > MOST_SENSORS || number.fract() != 0.0 {
            return None;
        }
    }
    let take_turns = sensors.len() > 1 && changes >= numbers.len() / MOST_ROWS_IN_TURN;
    let is_interleaved = take_turns && !is_even(stamps, median_step(stamps));
    sensors.sort_by(f64::total_cmp);
    is_interleaved.then_some(sensors)
}

/// All faults in the order and the spacing of `stamps` in a unit of `unit_s`: of each kind the first, with the number of the
/// others. Steps may deviate by `jitter` sampling steps from whole ones, if at all.
pub(crate) fn faults(stamps: &[f64], unit_s: f64, jitter: Option<f64>) -> Vec<TimeFault> {
    let mut faults = Vec::new();
    let mut tell = |rows: &[usize], words: &dyn Fn(usize) -> [String; 3]| {
        let Some(&row) = rows.first() else { return };
        let [message, label, help] = words(row);
        let more = if rows.len() > 1 { format!(" ({} such rows)", rows.len()) } else { String::new() };
        faults.push(TimeFault { row, words: [message + &more, label, help] });
    };
    let missing: Vec<usize> = (0..stamps.len()).filter(|&row| !stamps[row].is_finite()).collect();
    tell(&missing, &|_| {
        let help = "remove the row; or give `rate = 100Hz` with `time = none`, which takes all rows as one gapless series";
        ["the time is missing", "no number", help].map(str::to_owned)
    });
    let step = |row: usize| stamps[row] - stamps[row - 1];
    let backwards: Vec<usize> = (1..stamps.len()).filter(|&row| step(row) < 0.0).collect();
    tell(&backwards, &|row| {
        let help = "sort the rows by time; logs appended to each other are several records: cut the file there; if the column \
                    has no times, name another with `time = COLUMN`, or give `rate = 100Hz` with `time = none`";
        let message = format!("the time does not increase: {} after {}", stamps[row], stamps[row - 1]);
        [message, "earlier than the row before".to_owned(), help.to_owned()]
    });
    let (Some(jitter), true) = (jitter, stamps.len() > 1 && missing.is_empty()) else { return faults };
    let median = median_step(stamps);
    let is_uneven = |row: &usize| {
        let steps = step(*row) / median;
        step(*row) > 0.0 && (steps < 0.5 || steps < LONG_GAP && (steps - libm::round(steps)).abs() > jitter)
    };
    let mut uneven: Vec<usize> = (1..stamps.len()).filter(is_uneven).collect();
    if uneven.is_empty() && backwards.is_empty() && !is_even(stamps, median) {
        uneven = (1..stamps.len()).filter(|&row| step(row) > 1.5 * median).collect();
    }
    let mean = mean_step(stamps);
    tell(&uneven, &|row| {
        let seconds = |step: f64| format!("{} s", significant(step * unit_s, 6));
        let message = format!(
            "the samples are not evenly spaced: a step of {}, the mean is {}",
            seconds(step(row)),
            seconds(mean)
        );
        let rate = significant(1.0 / (mean * unit_s), 6);
        let help = format!(
            "if the samples are even, and only the stamps are rounded, late or in bursts, give the sampling rate too, here \
             `rate = {rate}Hz`: the stamps then only show where samples are missing"
        );
        [message, "not on the grid".to_owned(), help]
    });
    faults
}

/// The grid of rows that were sampled every `step`, in the unit of the stamps, which may be late, doubled or coarse. It has at most `most`
/// samples.
///
/// Samples that are missing raise all later stamps over their rows; stamps that are late, early or in bursts do not. So the least and the
/// median rise of the stamps on both sides of a row are compared. Rows with the same stamp are successive samples.
pub(crate) fn grid_of_rows(stamps: &[f64], step: f64, most: usize) -> Result<Grid, TimeFault> {
    let gaps = gaps(stamps, step);
    let mut next = gaps.iter().peekable();
    let steps = |row: usize| 1.0 + next.next_if(|gap| gap.0 == row).map_or(0.0, |gap| gap.1);
    placed(stamps.len(), step, most, steps)
}

/// The rows before which samples are missing, with their number.
fn gaps(stamps: &[f64], step: f64) -> Vec<(usize, f64)> {
    if stamps.len() < 2 {
        return vec![];
    }
    let is_first = |row: usize| row > 0 && stamps[row] != stamps[row - 1];
    let median = median_step(stamps);
    if is_even(stamps, median) && (median / step - 1.0).abs() < JITTER {
        let missing = |row: usize| libm::round((stamps[row] - stamps[row - 1]) / median) - 1.0;
        return (1..stamps.len()).map(|row| (row, missing(row))).filter(|gap| gap.1 > 0.0).collect();
    }
    let is_coarse = are_coarse(stamps);
    let (beside, least_rise) =
        if is_coarse { (BESIDE_COARSE, LEAST_RISE_COARSE) } else { (BESIDE, LEAST_RISE) };
    // The record may begin within the first stamp of a coarse clock.
    let rows: Vec<usize> = (0..stamps.len()).filter(|&row| is_first(row) || row == 0 && !is_coarse).collect();
    let rise = |row: usize| (stamps[row] - stamps[0]) / step - row as f64;
    let (mut gaps, mut lost) = (vec![], 0.0);
    let mut rises: Vec<f64> = Vec::with_capacity(rows.len());
    for (at, &row) in rows.iter().enumerate() {
        let before = &rises[at.saturating_sub(beside)..];
        let near = before.iter().rev().take(NEAR).copied().fold(f64::INFINITY, f64::min);
        if rise(row) - lost - near >= least_rise {
            let after: Vec<f64> = rows[at..].iter().take(beside).map(|&row| rise(row) - lost).collect();
            // Few stamps do not reach the next gap, and many outlast a burst.
            let of = |count: usize| {
                let [least, median] = least_and_median(&before[before.len().saturating_sub(count)..]);
                let [next_least, next_median] = least_and_median(&after[..after.len().min(count)]);
                (next_least - least).min(next_median - median)
            };
            let missing = if before.is_empty() { 0.0 } else { of(NEAR).min(of(beside)) };
            if missing >= if after.len() < LEAST_AFTER { LONG_GAP } else { least_rise } {
                lost += libm::round(missing);
                gaps.push((row, libm::round(missing)));
            }
        }
        rises.push(rise(row) - lost);
    }
    gaps
}

fn least_and_median(values: &[f64]) -> [f64; 2] {
    let mut values = values.to_vec();
    // Of two in the middle the lower one, because gaps raise values.
    let middle = (values.len() - 1) / 2;
    let (below, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let median = *median;
    [below.iter().copied().fold(median, f64::min), median]
}

fn median_of(values: &mut dyn Iterator<Item = f64>) -> f64 {
    least_and_median(&values.collect::<Vec<_>>())[1]
}

/// Whether all short steps are within a tenth of whole multiples of the median one, which is the sampling step. It is not where more than half
/// of the samples would be missing at many places, as between stamps in bursts.
pub(crate) fn is_even(stamps: &[f64], median: f64) -> bool {
    let (mut total, mut gaps) = (0.0, 0.0);
    let mut is_whole = |pair: &[f64]| {
        let ratio = (pair[1] - pair[0]) / median;
        let steps = libm::round(ratio);
        total += steps;
        gaps += f64::from(u8::from(steps > 1.0));
        steps >= LONG_GAP || steps >= 1.0 && (ratio - steps).abs() <= JITTER
    };
    let is_whole = median > 0.0 && stamps.windows(2).all(&mut is_whole);
    let rows = stamps.len() as f64;
    is_whole && (MOST_MISSING * total < rows || ROWS_PER_GAP * gaps < rows)
}

/// The mean step between samples over the whole record, without the gaps.
///
/// It is refined from the median step, or from the mean steps of blocks where these contradict it.
pub(crate) fn mean_step(stamps: &[f64]) -> f64 {
    let rows = stamps.len();
    let firsts: Vec<usize> = (1..rows).filter(|&row| stamps[row] != stamps[row - 1]).collect();
    let block = BLOCK.min(firsts.len().saturating_sub(1));
    if block == 0 {
        return (stamps[rows - 1] - stamps[0]) / (rows - 1) as f64;
    }
    let ends = (0..firsts.len() - block).step_by(block).map(|at| [firsts[at], firsts[at + block]]);
    let of_blocks = median_of(&mut ends.map(|[a, b]| (stamps[b] - stamps[a]) / (b - a) as f64));
    let median = median_step(stamps);
    let is_near = is_even(stamps, median) || (of_blocks / median - 1.0).abs() < JITTER;
    let mut step = if is_near { median } else { of_blocks };
    // The median distances from the grid in the first and the last part of the record.
    let part = (rows / 4).clamp(1, 4 * block * rows.div_ceil(firsts.len()));
    for _ in 0..2 {
        let Ok(Grid { places, samples, .. }) = grid_of_rows(stamps, step, usize::MAX) else { break };
        let place = |row: usize| places.as_ref().map_or(row as f64, |places| f64::from(places[row]));
        let away = |row: usize| stamps[row] - stamps[0] - step * place(row);
        let [first, last] = [0..part, rows - part..rows].map(|rows| median_of(&mut rows.map(away)));
        step += (last - first) / (samples - part).max(1) as f64;
    }
    step
}

/// The grid of rows of which each is so many `steps` after the one before.
fn placed(
    rows: usize,
    step: f64,
    most: usize,
    mut steps: impl FnMut(usize) -> f64,
) -> Result<Grid, TimeFault> {
    let mut places: Vec<u32> = Vec::with_capacity(rows);
    let (mut place, mut is_gapless) = (0.0, true);
    let most = (SPARSEST * rows as f64).min(most as f64);
    for row in 0..rows {
        let steps = steps(row);
        if row > 0 {
            is_gapless &= steps == 1.0;
            place += steps;
            if place >= most {
                let message = "most of the record is missing".to_owned();
                let help = "is a time stamp wrong? correct it, cut the log there, or ignore the stamps with `time = none`: at \
                            most ten times as many samples may be missing as there are";
                let label = "after the longest gap".to_owned();
                return Err(TimeFault { row, words: [message, label, help.to_owned()] });
            }
        }
        places.push(place as u32);
    }
    let samples = if rows == 0 { 0 } else { place as usize + 1 };
    Ok(Grid { step, samples, places: (!is_gapless).then_some(places) })
}

/// The median step of stamps that differ from the one before.
fn step_of_distinct(stamps: &[f64]) -> f64 {
    let mut distinct = stamps.to_vec();
    distinct.dedup();
    if distinct.len() < 2 { 0.0 } else { median_step(&distinct) }
}

/// The step of stamps of which most rows share one, 0 of others.
pub(crate) fn coarseness(stamps: &[f64]) -> f64 {
    if are_coarse(stamps) { step_of_distinct(stamps) } else { 0.0 }
}

/// Whether most rows have the stamp of the row before.
pub(crate) fn are_coarse(stamps: &[f64]) -> bool {
    stamps.len() > 1 && median_step(stamps) == 0.0
}

/// A sampling step of `step_s` in the unit of the stamps: by `unit_s`, or else by the unit of time that gives it nearly the mean step, or
/// else that step itself, as in numbered rows; and the same step by the clock of the stamps, which may go a little faster or slower.
///
/// # Errors
/// The stamps are in another spacing, which is returned, s.
pub(crate) fn step_in_stamps(stamps: &[f64], step_s: f64, unit_s: Option<f64>) -> Result<[f64; 2], f64> {
    if stamps.len() < 2 {
        return Ok([step_s; 2]);
    }
    let mean = mean_step(stamps);
    let is_near = |unit_s: &f64| (0.5..=2.0).contains(&(mean * unit_s / step_s));
    let unit_s = match unit_s {
        Some(unit_s) if !is_near(&unit_s) => return Err(mean * unit_s),
        None => UNITS.iter().map(|unit| unit.1).find(is_near),
        known => known,
    };
    let step = unit_s.map_or(mean, |unit_s| step_s / unit_s);
    Ok([step, if (mean / step - 1.0).abs() < MOST_DRIFT { mean } else { step }])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::names::words;

    #[test]
    fn stamps_since_a_start_are_not_taken_for_those_since_the_epoch() {
        let stamps =
            |first: f64, step: f64| (0..100).map(|i| first + step * f64::from(i)).collect::<Vec<_>>();
        // 100 Hz in µs 20 minutes after a start, and 200 Hz in ns.
        for stamps in [stamps(1.2e9, 1e4), stamps(1.2e12, 5e6)] {
            assert_eq!(epoch_unit_of(&stamps), None);
        }
        assert_eq!(epoch_unit_of(&[1.7e9]), Some(("s", 1.0)));
        assert_eq!(epoch_unit_of(&stamps(1.7e9, 60.0)), Some(("s", 1.0)));
        assert_eq!(epoch_unit_of(&stamps(1.7e18, 1e7)), Some(("ns", 1e-9)));
    }

    #[test]
    fn stamps_since_the_epoch_tell_their_unit() {
        for (stamp, unit) in [
            (1.7e9, Some("s")),
            (1.7e12, Some("ms")),
            (1.7e15, Some("us")),
            (1.7e18, Some("ns")),
            (5e9, None),
            (12.0, None),
        ] {
            assert_eq!(epoch_unit(stamp).map(|unit| unit.0), unit, "{stamp}");
        }
    }

    #[test]
    fn all_units_that_give_the_rate_of_a_sensor_are_likely_unless_the_name_has_one() {
        for (step, name, expected) in [
            (1000.0, "time", &[("ms", 1.0), ("us", 1000.0)][..]),
            (2.0, "time", &[("s", 0.5), ("ms", 500.0)]),
            (1000.0, "TimeUS", &[("us", 1000.0)]),
            (2.0, "TimeUS", &[("s", 0.5), ("ms", 500.0)]),
            (5e6, "t", &[("ns", 200.0)]),
            (1e9, "t", &[("ns", 1.0)]),
            (1e-9, "t", &[]),
        ] {
            let found = likely_units(step, &words(name));
            let rounded = found.iter().map(|(unit, rate_hz)| (*unit, libm::round(1e6 * rate_hz) / 1e6));
            assert_eq!(rounded.collect::<Vec<_>>(), expected, "{name} with steps of {step}");
        }
    }

    #[test]
    fn a_counter_that_rolls_over_goes_on() {
        let limit = 4_294_967_296.0;
        let true_stamps: Vec<f64> = (0..3000).map(|i| 4.2e9 + 1e6 * f64::from(i)).collect();
        let mut stamps: Vec<f64> = true_stamps.iter().map(|stamp| stamp % limit).collect();
        assert_eq!(unroll(&mut stamps), Some((limit, 1)));
        assert_eq!(stamps, true_stamps);
        for other in
            [&[0.0, 1.0, 2.0, 1.5, 3.0][..], &[5.0, 6.0, 0.0, 1.0], &[0.0, f64::NAN, -1.0], &[1.0, 2.0, 3.0]]
        {
            let mut stamps = other.to_vec();
            assert_eq!(unroll(&mut stamps), None, "{other:?}");
        }
    }

    #[test]
    fn late_stamps_are_no_gaps_and_gaps_stay() {
        let late = |i: usize| if i % 7 == 3 { 2.4 } else { 0.3 * ((i * 5 % 8) as f64) / 8.0 };
        let kept: Vec<usize> = (0..500).filter(|i| !(100..177).contains(i) && *i != 300).collect();
        let mut stamps: Vec<f64> = kept.iter().map(|&i| 10.0 + i as f64 + late(i)).collect();
        (1..stamps.len()).for_each(|i| stamps[i] = stamps[i].max(stamps[i - 1] + 1e-3));
        let grid = grid_of_rows(&stamps, 1.0, 10_000).unwrap();
        let places: Vec<usize> = grid.places.unwrap().iter().map(|place| *place as usize).collect();
        assert_eq!((grid.samples, places), (500, kept));
        assert!(grid_of_rows(&stamps, 1.0, 450).is_err(), "more samples than are allowed");
    }

    #[test]
    fn an_early_stamp_is_no_gap() {
        let kept: Vec<usize> = (0..500).filter(|i| !(300..305).contains(i)).collect();
        let early = |i: usize| if i % 50 == 20 { 1.3 } else { 0.0 };
        let stamps: Vec<f64> = kept.iter().map(|&i| 10.0 + i as f64 - early(i)).collect();
        let grid = grid_of_rows(&stamps, 1.0, 10_000).unwrap();
        let places: Vec<usize> = grid.places.unwrap().iter().map(|place| *place as usize).collect();
        assert_eq!((grid.samples, places), (500, kept));
    }

    #[test]
    fn rows_of_a_coarse_stamp_are_successive_samples_and_losses_stay() {
        // Stamps in whole seconds at 100 Hz and 33.3 Hz, which begin within a second; 20 samples are lost in the 20th.
        for (step, per_second) in [(0.01, 100.0), (0.03, 100.0 / 3.0)] {
            let count = libm::round(60.0 * per_second) as usize;
            let lost = libm::round(20.1 * per_second) as usize;
            let kept: Vec<usize> = (0..count).filter(|i| !(lost..lost + 20).contains(i)).collect();
            let stamps: Vec<f64> = kept.iter().map(|&i| libm::floor(1.7e9 + 0.4 + i as f64 * step)).collect();
            assert!(are_coarse(&stamps));
            assert_eq!(step_in_stamps(&stamps, step, Some(1.0)).unwrap()[0], step);
            assert!((mean_step(&stamps) / step - 1.0).abs() < 1e-3, "{}", mean_step(&stamps));
            let grid = grid_of_rows(&stamps, step, 100_000).unwrap();
            assert!(grid.samples.abs_diff(count) <= 1, "{} of {count} at {step}", grid.samples);
            let whole: Vec<f64> = (0..count).map(|i| libm::floor(0.4 + i as f64 * step)).collect();
            assert_eq!(grid_of_rows(&whole, step, 100_000).unwrap().places, None);
        }
    }

    /// Loggers' clocks, each for rows of a hundredth of a second, with the sample of each row.
    fn clock(kind: usize, seed: u64) -> (Vec<f64>, Vec<usize>, f64) {
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let count = 20_000;
        let kept: Vec<usize> = (0..count).filter(|_| kind != 7 || uniform() > 0.01).collect();
        // With 49 samples to half a second the coarse clock has a beat of many stamps.
        let step =
            if kind == 5 && seed == 0 { 0.5 / 48.9675 } else { 0.01 * (1.0 + 0.1 * (uniform() - 0.5)) };
        let mut stamps: Vec<f64> = kept.iter().map(|&i| 3.0 + step * i as f64).collect();
        let mut at = 0;
        while at < stamps.len() {
            let near = stamps[at];
            match kind {
                1 => stamps[at] += step * 0.6 * (uniform() - 0.5),
                2 => {
                    let end = stamps.len().min(at + 1 + (9.0 * uniform()) as usize);
                    let last = stamps[end - 1];
                    (at..end).for_each(|row| stamps[row] = last + 0.1 * step * (row - at) as f64);
                    at = end;
                    continue;
                }
                3 if uniform() < 0.1 => stamps[at] += 5.0 * step * uniform(),
                4 if at % 2 == 1 && uniform() < 0.2 => stamps[at] = near - step,
                5 => stamps[at] = libm::floor(2.0 * near) / 2.0,
                6 => stamps[at] += 0.01 * step * (at * at) as f64 / count as f64,
                _ => {}
            }
            at += 1;
        }
        (1..stamps.len()).for_each(|i| stamps[i] = stamps[i].max(stamps[i - 1]));
        let mean = if kind == 6 { step * (1.0 + 0.01) } else { step };
        (stamps, kept, mean)
    }

    #[test]
    fn clocks_of_all_kinds_have_the_mean_step_of_their_samples_and_no_other_gaps() {
        for kind in 0..8 {
            for seed in 0..25 {
                let (stamps, kept, step) = clock(kind, seed);
                let last = kept.len() - 1;
                let found = mean_step(&stamps);
                assert!((found / step - 1.0).abs() < 1e-4, "clock {kind}, {seed}: {found} and not {step}");
                let grid = grid_of_rows(&stamps, found, 1 << 20).unwrap();
                assert_eq!(grid.samples, kept[last] - kept[0] + 1, "clock {kind}, {seed}");
            }
        }
    }

    #[test]
    fn the_step_is_found_in_stamps_of_any_unit() {
        let stamps = |step: f64| (0..20).map(|i| f64::from(i) * step).collect::<Vec<_>>();
        assert_eq!(step_in_stamps(&stamps(10.0), 0.01, None), Ok([10.0, 10.0]));
        for rows in 0..2 {
            assert_eq!(grid_of_rows(&stamps(10.0)[..rows], 0.01, 9).unwrap().samples, rows);
        }
        assert_eq!(step_in_stamps(&stamps(1.0), 0.01, None), Ok([1.0, 1.0]));
        assert_eq!(step_in_stamps(&stamps(0.013), 0.01, Some(1.0)), Ok([0.01, 0.01]));
        assert_eq!(step_in_stamps(&stamps(0.5), 0.01, Some(1.0)), Err(0.5));
    }
}
