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

/// Rows after a late one from which its true time is found. A queue that holds up more rows leaves a gap and rows too near
/// to each other.
const AHEAD: usize = 8;

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
    let uneven: Vec<usize> = (1..stamps.len()).filter(is_uneven).collect();
    tell(&uneven, &|row| {
        let seconds = |step: f64| format!("{} s", significant(step * unit_s, 6));
        let message = format!(
            "the samples are not evenly spaced: a step of {}, the median is {}",
            seconds(step(row)),
            seconds(median)
        );
        let rate = significant(1.0 / (median * unit_s), 4);
        let help = format!(
            "steps within 10 % of whole multiples of the median are taken; if the stamps are only rounded or late, give the \
             sampling rate too, here about `rate = {rate}Hz`: the stamps then only show where samples are missing"
        );
        [message, "not on the grid".to_owned(), help]
    });
    faults
}

/// The grid of rows that were sampled every `step`, in the unit of the stamps, and stamped late, or a little early, by up to
/// several steps. It has at most `most` samples.
///
/// The true time of a row is the least that it and the rows after it allow: a late stamp is followed by short steps, a gap is
/// not. Where that is too near to the row before, a stamp is early, unless more rows in a row are than look ahead.
pub(crate) fn late_grid(stamps: &[f64], step: f64, most: usize) -> Result<Grid, TimeFault> {
    let time = |row: usize| {
        let ahead = row..stamps.len().min(row + AHEAD + 1);
        ahead.map(|later| stamps[later] - (later - row) as f64 * step).fold(f64::INFINITY, f64::min)
    };
    let (mut before, mut early) = (f64::NAN, 0);
    let steps = |row: usize| {
        let now = time(row);
        let is_early = row > 0 && now - before < 0.5 * step && early <= AHEAD;
        let steps = libm::round((now - before) / step).max(1.0);
        before = if is_early { before + step } else { now };
        early = if is_early { early + 1 } else { 0 };
        steps
    };
    placed(stamps.len(), step, most, steps)
}

/// The grid of rows that were sampled every `step`, in the unit of the stamps, of which several have each stamp.
///
/// The rows of a stamp are taken for successive samples. Samples are missing before a stamp, to within one, by as many as its
/// rows and those of the stamps around it are too few.
pub(crate) fn coarse_grid(stamps: &[f64], step: f64, most: usize) -> Result<Grid, TimeFault> {
    let starts: Vec<usize> =
        (0..stamps.len()).filter(|&row| row == 0 || stamps[row] != stamps[row - 1]).collect();
    let lag = |&row: &usize| (stamps[row] - stamps[0]) / step - row as f64;
    let mut next = 0;
    let steps = |row: usize| {
        if starts.get(next) != Some(&row) {
            return 1.0;
        }
        next += 1;
        // The record may begin within the first stamp.
        if next < 3 {
            return 1.0;
        }
        let (before, after) = starts.split_at(next - 1);
        let before = before.iter().rev().take(AHEAD).map(lag).fold(f64::NEG_INFINITY, f64::max);
        let after = after.iter().take(AHEAD).map(lag).fold(f64::INFINITY, f64::min);
        1.0 + libm::round(after - before).max(0.0)
    };
    placed(stamps.len(), step, most, steps)
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

/// The sampling step of `step_s` in the unit of the stamps: by `unit_s`, or else by the unit of time that gives it nearly the
/// median step, or else that step itself, as in numbered rows.
///
/// # Errors
/// The stamps are in another spacing, which is returned, s.
pub(crate) fn step_in_stamps(stamps: &[f64], step_s: f64, unit_s: Option<f64>) -> Result<f64, f64> {
    if stamps.len() < 2 {
        return Ok(step_s);
    }
    let rows_per_stamp =
        || stamps.len() as f64 / (1 + stamps.windows(2).filter(|pair| pair[0] != pair[1]).count()) as f64;
    let median = match are_coarse(stamps) {
        true => step_of_distinct(stamps) / rows_per_stamp(),
        false => median_step(stamps),
    };
    let is_near = |unit_s: f64| (0.5..=2.0).contains(&(median * unit_s / step_s));
    match unit_s {
        Some(unit_s) if is_near(unit_s) => Ok(step_s / unit_s),
        Some(unit_s) => Err(median * unit_s),
        None => Ok(UNITS
            .into_iter()
            .find(|(_, unit_s)| is_near(*unit_s))
            .map_or(median, |(_, unit_s)| step_s / unit_s)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let grid = late_grid(&stamps, 1.0, 10_000).unwrap();
        let places: Vec<usize> = grid.places.unwrap().iter().map(|place| *place as usize).collect();
        assert_eq!((grid.samples, places), (500, kept));
        assert!(late_grid(&stamps, 1.0, 450).is_err(), "more samples than are allowed");
    }

    #[test]
    fn an_early_stamp_is_no_gap() {
        let kept: Vec<usize> = (0..500).filter(|i| !(300..305).contains(i)).collect();
        let early = |i: usize| if i % 50 == 20 { 1.3 } else { 0.0 };
        let stamps: Vec<f64> = kept.iter().map(|&i| 10.0 + i as f64 - early(i)).collect();
        let grid = late_grid(&stamps, 1.0, 10_000).unwrap();
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
            assert!((step_in_stamps(&stamps, step, Some(1.0)).unwrap() / step - 1.0).abs() < 1e-12);
            let grid = coarse_grid(&stamps, step, 100_000).unwrap();
            assert!(grid.samples.abs_diff(count) <= 1, "{} of {count} at {step}", grid.samples);
            let whole: Vec<f64> = (0..count).map(|i| libm::floor(0.4 + i as f64 * step)).collect();
            assert_eq!(coarse_grid(&whole, step, 100_000).unwrap().places, None);
        }
    }

    #[test]
    fn the_step_is_found_in_stamps_of_any_unit() {
        let stamps = |step: f64| (0..20).map(|i| f64::from(i) * step).collect::<Vec<_>>();
        assert_eq!(step_in_stamps(&stamps(10.0), 0.01, None), Ok(10.0));
        assert_eq!(step_in_stamps(&stamps(1.0), 0.01, None), Ok(1.0));
        assert_eq!(step_in_stamps(&stamps(0.013), 0.01, Some(1.0)), Ok(0.01));
        assert_eq!(step_in_stamps(&stamps(0.5), 0.01, Some(1.0)), Err(0.5));
    }
}
