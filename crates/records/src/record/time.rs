//! Times: conversion of time stamps to evenly spaced samples with gaps, and times of the calendar in cells, such as
//! `2018-04-25 10:00:13.5`, or a date and a time of day in cells of their own.

use crate::record::column_file::Rules;
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

/// What the cells of a column hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Calendar {
    /// A date with a time of day, or a time of day alone.
    Time,
    /// A date.
    Date,
    /// A time from a start with its unit, such as `0.01 sec`.
    Since,
}

/// Which number is first in dates with slashes of which none is a year.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum First {
    Month,
    Day,
}

impl First {
    /// The order of the date in a cell: that of months first, if both are possible.
    pub(crate) fn parse(cell: &[u8]) -> Option<First> {
        let text = std::str::from_utf8(cell).ok().filter(|text| text.find('/').is_some_and(|at| at < 3))?;
        [First::Month, First::Day].into_iter().find(|first| {
            Calendar::Date.seconds(text.as_bytes(), *first).is_some()
                || Calendar::Time.seconds(text.as_bytes(), *first).is_some()
        })
    }

    pub(crate) fn other(self) -> First {
        if self == First::Month { First::Day } else { First::Month }
    }
}

impl Calendar {
    /// What a cell holds, if it is neither a number nor other text.
    pub(crate) fn parse(cell: &[u8]) -> Option<Calendar> {
        let first = First::parse(cell).unwrap_or(First::Month);
        let holds = |calendar: &Calendar| !cell.is_empty() && calendar.seconds(cell, first).is_some();
        [Calendar::Date, Calendar::Time, Calendar::Since].into_iter().find(holds)
    }

    /// The seconds that a cell of such a column stands for, since 1970, since midnight or since a start; NaN for an empty one.
    pub(crate) fn seconds(self, cell: &[u8], first: First) -> Option<f64> {
        let text = std::str::from_utf8(cell).ok()?;
        match self {
            _ if text.is_empty() => Some(f64::NAN),
            Calendar::Date => date(text, first),
            Calendar::Time => time(text, first),
            Calendar::Since => since(text),
        }
    }
}

pub(crate) const DAY_S: f64 = 86_400.0;

/// Units of times from a start, as MATLAB writes them, s.
const SINCE: [(&[&str], f64); 5] = [
    (&["s", "sec", "secs", "second", "seconds"], 1.0),
    (&["ms", "msec"], 1e-3),
    (&["min", "mins", "minute", "minutes"], 60.0),
    (&["h", "hr", "hrs", "hour", "hours"], 3600.0),
    (&["day", "days"], DAY_S),
];

/// A time from a start.
fn since(text: &str) -> Option<f64> {
    let (number, unit) = text.rsplit_once(' ')?;
    let (_, unit_s) = SINCE.iter().find(|(units, _)| units.contains(&unit))?;
    number.trim_end().parse().ok().filter(|number: &f64| number.is_finite()).map(|number| number * unit_s)
}

const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// A time of day, with the date before it if there is one, and with the distance from UTC that may follow.
fn time(text: &str, first: First) -> Option<f64> {
    let dated = text.split_once(['T', ' ', '_']).and_then(|(day, clock)| Some((date(day, first)?, clock)));
    let (day_s, clock, signs) = match dated {
        Some((day_s, clock)) => (day_s, clock.trim_start(), &[':', '-'][..]),
        None => (0.0, text, &[':'][..]),
    };
    let (clock, ahead_s) = zone(clock);
    let (clock, half) = match clock.to_ascii_uppercase().as_str() {
        half if half.ends_with("AM") => (clock[..clock.len() - 2].trim_end(), Some(0)),
        half if half.ends_with("PM") => (clock[..clock.len() - 2].trim_end(), Some(12)),
        _ => (clock, None),
    };
    let mut parts = clock.splitn(3, signs);
    let mut part = |limit: u32, digits: usize| {
        let part = parts.next().filter(|part| part.len() <= digits)?;
        part.parse::<u32>().ok().filter(|part| *part < limit)
    };
    let hours = part(24, 2)?;
    let hours = half.map_or(hours, |half| hours % 12 + half);
    let minutes = 60 * hours + part(60, 2)?;
    // Minutes alone are a time where a date stands before them.
    let seconds = parts.next().or(dated.map(|_| "0"))?.replace([',', '_', ':'], ".");
    let is_plain = seconds.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    let seconds: f64 = seconds.parse().ok().filter(|seconds| is_plain && *seconds < 61.0)?;
    Some(day_s + f64::from(60 * minutes) + seconds - ahead_s)
}

/// A time of day without the distance from UTC at its end, and that distance, s.
fn zone(clock: &str) -> (&str, f64) {
    let clock = clock.trim_end_matches([' ', 'Z']);
    let Some(at) = clock.rfind(['+', '-']).filter(|&at| clock[..at].matches(':').count() == 2) else {
        return (clock, 0.0);
    };
    let digits: String = clock[at + 1..].chars().filter(char::is_ascii_digit).collect();
    let minutes = match digits.len() {
        2 => digits.parse().map(|hours: f64| 60.0 * hours),
        4 => digits.parse().map(|both: f64| 60.0 * libm::floor(both / 100.0) + both % 100.0),
        _ => return (clock, 0.0),
    };
    let sign = if clock[at..].starts_with('-') { -60.0 } else { 60.0 };
    (clock[..at].trim_end(), minutes.map_or(0.0, |minutes| sign * minutes))
}

/// The start of a date such as `2018-04-25`, `25-Apr-2018`, `25.04.2018` or `04/25/2018`, s since 1970. Of two numbers with a slash
/// between the `first` is the month or the day.
fn date(text: &str, first: First) -> Option<f64> {
    let sign = text.chars().find(|c| !c.is_ascii_digit()).filter(|c| ['-', '/', '.'].contains(c))?;
    let month =
        |part: &str| MONTHS.iter().position(|month| part.eq_ignore_ascii_case(month)).map(|at| at as i64 + 1);
    let number = |part: &str| part.parse().ok().or_else(|| month(part)).filter(|_| part.len() <= 4);
    let mut parts = text.split(sign).map(number);
    let (Some(Some(a)), Some(Some(b)), Some(Some(c)), None) =
        (parts.next(), parts.next(), parts.next(), parts.next())
    else {
        return None;
    };
    let [year, month, day] = match sign {
        _ if a > 31 => [a, b, c],
        '/' if first == First::Month => [c, a, b],
        _ => [c, b, a],
    };
    let is_short = text.len() - text.rfind(sign)? == 3 && sign != '-';
    let year = if is_short && year < 100 { 2000 + year } else { year };
    let is_date = (1900..2200).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
    is_date.then(|| DAY_S * days(year, month, day) as f64)
}

/// Days from 1970 to a date of the Gregorian calendar. Years begin in March, so that the leap day is the last.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + day - 719_469
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

    #[test]
    fn times_from_a_start_have_their_unit_in_each_cell() {
        for (cell, expected) in
            [("0 sec", 0.0), ("0.01 sec", 0.01), ("1.5 min", 90.0), ("2 hr", 7200.0), ("1e-3 s", 1e-3)]
        {
            assert_eq!(Calendar::parse(cell.as_bytes()), Some(Calendar::Since), "{cell}");
            assert_eq!(Calendar::Since.seconds(cell.as_bytes(), First::Month), Some(expected), "{cell}");
        }
        for cell in ["0.01", "0.01 V", "sec", "inf sec", "a sec"] {
            assert_eq!(Calendar::parse(cell.as_bytes()), None, "{cell}");
        }
    }

    #[test]
    fn dates_and_times_are_read_as_loggers_and_spreadsheets_write_them() {
        let noon = 1_524_650_413.0;
        let read = |calendar: Calendar, text: &str| {
            let first = First::parse(text.as_bytes()).unwrap_or(First::Month);
            calendar.seconds(text.as_bytes(), first)
        };
        for text in [
            "2018-04-25T10:00:13Z",
            "2018-04-25 10:00:13",
            "2018/04/25 10:00:13.000",
            "25.04.2018 10:00:13,0",
            "25/04/2018 10:00:13",
            "04/25/2018 10:00:13",
            "2018-04-25T12:00:13+02:00",
            "2018-04-25 05:30:13-0430",
            "2018-04-25 10-00-13_000",
            "25-Apr-2018 10:00:13.000",
            "4/25/2018 10:00:13 AM",
            "25.04.18 10:00:13:000",
        ] {
            assert_eq!(read(Calendar::Time, text), Some(noon), "{text}");
            assert_eq!(Calendar::parse(text.as_bytes()), Some(Calendar::Time), "{text}");
        }
        for (text, seconds) in
            [("1970-01-01", 0.0), ("2000-02-29", 951_782_400.0), ("01.03.2000", 951_868_800.0)]
        {
            assert_eq!(read(Calendar::Date, text), Some(seconds), "{text}");
            assert_eq!(Calendar::parse(text.as_bytes()), Some(Calendar::Date), "{text}");
        }
        for (text, seconds) in [("10:00:13.25", 36_013.25), ("12:00:00 am", 0.0), ("1:30:00 PM", 48_600.0)] {
            assert_eq!(read(Calendar::Time, text), Some(seconds), "{text}");
        }
        assert_eq!(read(Calendar::Time, "25.04.2018 10:00"), Some(noon - 13.0));
        assert!(read(Calendar::Time, "").is_some_and(f64::is_nan));
    }

    #[test]
    fn only_dates_with_slashes_have_a_first_number() {
        for (text, first) in [
            ("05/01/2024 23:59:59", Some(First::Month)),
            ("25/01/2024", Some(First::Day)),
            ("2024/01/05", None),
            ("25.01.2024", None),
            ("1.5", None),
        ] {
            assert_eq!(First::parse(text.as_bytes()), first, "{text}");
        }
        assert_eq!(Calendar::Date.seconds(b"25/01/2024", First::Month), None);
    }

    #[test]
    fn other_text_is_no_time() {
        for text in [
            "",
            "1.5",
            "12",
            "-1.5e-3",
            "10:61:00",
            "24:00:00",
            "2018-13-25",
            "1.2.3",
            "10:00",
            "imu",
            "1-2-3",
        ] {
            assert_eq!(Calendar::parse(text.as_bytes()), None, "{text}");
        }
    }
}
