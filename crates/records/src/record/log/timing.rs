//! The times of the rows of a log: which column has them, in which unit, and which samples they show as missing.

use crate::record::column_file::ColumnFile;
use crate::record::log::read::{Duplicates, RULES, Timing};
use crate::record::names::{Name, unit_of, words};
use crate::record::time::{Calendar, DAY_S, TimeFault, grid, median_step};
use crate::record::timestamps::{
    Doubled, are_coarse, are_rounded, are_serial_days, coarseness, doubled as doubled_of, epoch_unit,
    epoch_unit_of, exact_step, faults as faults_of, few_distinct, grid_of_rows, is_step_of_sensor,
    likely_units, mean_step, rows_of_lost_digits, step_in_stamps, uncertainty, unroll,
};
use crate::record::{Faults, RecordError};
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, parse as parse_quantity};

/// Names of columns of times, without signs between words.
const TIMES: [&str; 16] = [
    "time",
    "t",
    "timestamp",
    "timestamps",
    "stamp",
    "stamps",
    "epoch",
    "times",
    "timetag",
    "systemtime",
    "timeus",
    "timestartup",
    "sampletimefine",
    "sampleus",
    "rtctime",
    "datetime",
];

/// Ends of names of columns with lengths of time.
const SPANS: [&str; 6] = ["dt", "interval", "period", "duration", "delay", "latency"];

/// Names of columns that number the samples.
const COUNTERS: [&str; 12] = [
    "counter",
    "count",
    "sample",
    "index",
    "seq",
    "sequence",
    "n",
    "packetcounter",
    "packet",
    "framecounter",
    "frame",
    "samplecounter",
];

/// Most rows that repeat the numbers of the row before, for each that has only its time, in a log with a coarse clock.
const REPEATED_PER_OTHER: usize = 20;

/// Names of columns with whole seconds.
const SECONDS: [&str; 4] = ["sec", "secs", "second", "seconds"];

/// Names of columns with the rest of a second, and their units, s.
const RESTS: [(&[&str], f64); 3] = [
    (&["nsec", "nsecs", "nanosec", "nanosecs", "nanosecond", "nanoseconds", "nanos", "ns"], 1e-9),
    (&["usec", "usecs", "microsec", "microsecs", "microsecond", "microseconds", "micros", "us"], 1e-6),
    (&["msec", "msecs", "millisec", "millisecs", "millisecond", "milliseconds", "millis", "ms"], 1e-3),
];

/// Least size of the largest of some rests of a second, s; in a finer unit they would be those of a far shorter time.
const MIN_REST_S: f64 = 1e-3;

/// Largest deviation of the rate by the stamps from the given one, as a part of it; the stamps may be late or rounded.
const MAX_DEVIATION: f64 = 0.1;

/// Largest part by which the rate by the stamps may be off, because they do not tell which samples are missing.
const MAX_UNCERTAINTY: f64 = 0.03;

/// The unit of stamps that are numbers of samples, or whose unit does not matter.
const ANY: f64 = 1.0;

/// A column of stamps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Time {
    pub column: usize,
    /// The unit, s, where it is known.
    unit_s: Option<f64>,
    unit_is: Stated,
    /// The column with the rest of the second, where this one has whole seconds.
    pub rest: Option<Rest>,
}

/// The source of the unit of the stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stated {
    /// The user, or a clock in the stamps.
    Surely,
    /// The header.
    InHeader,
    /// The kind of the logger.
    ByLogger,
}

/// A column with the rest of the seconds of another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rest {
    pub column: usize,
    unit_s: f64,
}

impl Rest {
    /// The column that has the rest of the seconds in `column`: `tv_usec` for `tv_sec`, or `stamp.nanosec` for `stamp.sec`.
    fn new(file: &ColumnFile, column: usize) -> Option<Rest> {
        let names = file.names();
        if names.is_empty() {
            return Rest::without_names(file, column);
        }
        let (base, word) = last_word(&names.get(column)?.whole);
        let is = |known: &[&str], word: &str| known.iter().any(|known| known.eq_ignore_ascii_case(word));
        let unit = |at: usize| {
            let (other, word) = last_word(&names[at].whole);
            RESTS.iter().find(|(known, _)| other == base && is(known, word)).map(|(_, unit_s)| *unit_s)
        };
        let rest =
            |at: usize| Some(Rest { column: at, unit_s: unit(at).filter(|_| file.sample(at).is_some())? });
        is(&SECONDS, word).then(|| (0..names.len()).find_map(rest)).flatten()
    }

    /// The column after whole seconds since 1970 in `column` if it has the whole ns or µs of each.
    fn without_names(file: &ColumnFile, column: usize) -> Option<Rest> {
        let (seconds, rests) = (file.rows(column), file.rows(column + 1));
        let is_second = |second: &f64| second.fract() == 0.0 && matches!(epoch_unit(*second), Some(("s", _)));
        let largest = rests.iter().copied().fold(0.0, f64::max);
        let unit_s = RESTS.iter().map(|(_, unit_s)| *unit_s).find(|unit_s| largest * unit_s >= MIN_REST_S)?;
        let is_rest = |rest: &f64| rest.fract() == 0.0 && (0.0..1.0).contains(&(rest * unit_s));
        let first = *seconds.first()?;
        let times: Vec<f64> =
            seconds.iter().zip(rests).map(|(second, rest)| second - first + rest * unit_s).collect();
        let are_parts = seconds.len() == rests.len()
            && seconds.iter().all(is_second)
            && rests.iter().all(is_rest)
            && times.windows(2).all(|pair| pair[1] > pair[0]);
        are_parts.then_some(Rest { column: column + 1, unit_s })
    }

    /// The times from the first one on, which keeps all digits, and where they are taken from: whole seconds have rests, of which
    /// single ones may reach beyond a second; else a column of rests that increases has all of the time. `None` where the two do not
    /// fit each other.
    pub(crate) fn times(&self, seconds: &[f64], rests: &[f64]) -> Option<(Vec<f64>, &'static str)> {
        let from_first = |times: &[f64]| {
            let first = times.iter().copied().find(|time| !time.is_nan()).unwrap_or(0.0);
            times.iter().map(|time| time - first).collect::<Vec<f64>>()
        };
        let are_whole = seconds.iter().all(|second| second.is_nan() || second.fract() == 0.0);
        let within = rests.iter().filter(|rest| (0.0..1.0).contains(&(**rest * self.unit_s))).count();
        if are_whole && 2 * within > rests.len() {
            let sum = |(second, rest): (f64, &f64)| second + rest * self.unit_s;
            return Some((
                from_first(seconds).into_iter().zip(rests).map(sum).collect(),
                "the rest of each second is",
            ));
        }
        let increase =
            rests.windows(2).all(|pair| pair[1] >= pair[0] || pair[0].is_nan() || pair[1].is_nan());
        let times = || from_first(rests).iter().map(|rest| rest * self.unit_s).collect();
        (are_whole && increase).then(|| (times(), "not rests of seconds, but all times are"))
    }

    /// The fault of columns that do not fit each other.
    pub(crate) fn refused(&self, file: &ColumnFile, column: usize) -> RecordError {
        let message =
            format!("{} has no rests of the seconds in {}", file.title(self.column), file.title(column));
        let help = "name a column with the whole time, as in `time = COLUMN`, or give `rate = HZ` with `time = none`";
        file.refuse(Some(self.column), &message, "no rest of a second", help)
    }
}

/// A name without the letters at its end, and these.
fn last_word(name: &str) -> (&str, &str) {
    let letters = name.trim_end_matches([']', ')', '}', ' ']);
    letters.split_at(letters.trim_end_matches(|c: char| c.is_ascii_alphabetic()).len())
}

/// How the times of the rows are found.
pub(crate) struct Clock {
    /// The sampling step, where it is given, s.
    pub step_s: Option<f64>,
    pub time: Option<Time>,
    /// Whether the column has times. If not, it is ignored where they are not in order.
    pub is_sure: bool,
    pub duplicates: Option<Duplicates>,
}

impl Timing {
    /// The sampling step that is given, or else the one that the file states, s.
    pub(crate) fn step_s(&self, file: &ColumnFile) -> Option<f64> {
        match self {
            Timing::Step(step_s) => Some(*step_s),
            Timing::Stamps { step_s, .. } => step_s.or(file.step_s()),
        }
    }
}

/// Whether a column with this name has times.
pub(crate) fn is_time(name: &str) -> bool {
    is_called(name, &TIMES)
}

/// Whether the unit of a column is one of time, or a number of these.
fn has_unit_of_time(name: &Name) -> bool {
    let wanted = &[Dimension::Time];
    name.unit
        .as_deref()
        .is_some_and(|unit| unit_of(unit, wanted).is_ok() || parse_quantity(unit, wanted).is_ok())
}

/// Whether a column has times, lengths of time or numbers of samples, by its name or its unit.
pub(crate) fn is_timing(name: &Name) -> bool {
    // An index without a name stands first in tables of pandas.
    has_unit_of_time(name)
        || name.has_word(&["time", "timestamp"])
        || name.whole.is_empty()
        || is_time(&name.bare)
        || is_called(&name.bare, &COUNTERS)
        || is_span(&name.bare)
}

/// The columns of whole seconds, and those with the rest of each.
pub(crate) fn parts_of_times(file: &ColumnFile) -> Vec<usize> {
    let both = |column| Rest::new(file, column).map(|rest| [column, rest.column]);
    (0..file.columns()).filter_map(both).flatten().collect()
}

/// Whether a column with this name has lengths of time.
fn is_span(name: &str) -> bool {
    SPANS.iter().any(|end| name.to_lowercase().ends_with(end))
}

/// Whether the last part of `imu/time.stamp_ns` is one of the names.
fn is_called(name: &str, names: &[&str]) -> bool {
    let last = name.rsplit(['/', '.']).next().unwrap_or(name);
    let letters: String = last.chars().filter(|c| c.is_alphanumeric()).collect();
    // T is a temperature.
    letters != "T" && names.iter().any(|known| letters.eq_ignore_ascii_case(known))
}

/// The column of stamps, if there is one, and whether its name says so. It is neither one of the `wanted` columns nor the one
/// `taken` as a temperature, unless it is asked for by name.
pub(crate) fn found(
    file: &ColumnFile,
    timing: &Timing,
    wanted: &[String],
    taken: Option<usize>,
    notes: &mut Vec<String>,
) -> Result<(Option<Time>, bool), RecordError> {
    let Timing::Stamps { step_s, column, unit } = timing else { return Ok((None, true)) };
    let has_unit = unit.is_some();
    let time = |column: usize, is_sure: bool| {
        let rest = Rest::new(file, column);
        let known = rest.map(|_| 1.0).filter(|_| unit.is_none());
        let unit_s = match known {
            None => unit_s(file, column, unit.as_deref(), &time_column(file, column))?,
            seconds => seconds,
        };
        let is_known = unit.is_some() || known.is_some() || file.calendar(column).is_some();
        let unit_is = match file.names().get(column) {
            _ if is_known => Stated::Surely,
            Some(name) if name.is_assumed => Stated::ByLogger,
            _ => Stated::InHeader,
        };
        Ok((Some(Time { column, unit_s, unit_is, rest }), is_sure))
    };
    if let Some(word) = column {
        return time(file.find(word, None)?, true);
    }
    let wanted: Vec<usize> = wanted.iter().filter_map(|word| file.find(word, None).ok()).collect();
    let candidates = |is: &dyn Fn(usize) -> bool| -> Vec<usize> {
        (0..file.columns().min(file.names().len()))
            .filter(|column| !wanted.contains(column) && taken != Some(*column) && is(*column))
            .collect()
    };
    let bare = |column: usize| file.names()[column].bare.as_str();
    let unit = |column: usize| file.names()[column].unit.as_deref();
    let measures_time = |column: usize| has_unit_of_time(&file.names()[column]);
    let is_time_or_serial = |column: usize| {
        is_time(bare(column)) || is_called(bare(column), &["date"]) && file.calendar(column).is_none()
    };
    let is_of_time =
        |column: usize| is_time_or_serial(column) && (unit(column).is_none() || measures_time(column));
    let mut times = candidates(&is_of_time);
    let unread = times.iter().copied().find(|column| file.sample(*column).is_none());
    if let Some(column) = unread {
        notes.push(format!("{} holds no numbers and is not used", time_column(file, column)));
        times.retain(|column| file.sample(*column).is_some());
    }
    if let Some(column) = nearest(file, times, wanted.first()) {
        // A column `t` without a unit may have temperatures.
        let is_sure = step_s.is_none() || unit(column).is_some() || !is_called(bare(column), &["t"]);
        if is_sure {
            notes.push(format!("times are taken from {}", time_column(file, column)));
        }
        return time(column, is_sure);
    }
    if let Some(column) =
        nearest(file, candidates(&|column| Rest::new(file, column).is_some()), wanted.first())
    {
        notes.push(format!("times are taken from {}", time_column(file, column)));
        return time(column, true);
    }
    let are_parts = |column: &usize| {
        let is_wanted =
            [*column, column + 1].iter().any(|part| wanted.contains(part) || taken == Some(*part));
        file.names().is_empty() && !is_wanted && Rest::new(file, *column).is_some()
    };
    if let Some(column) = (0..file.columns()).find(are_parts) {
        notes.push(format!("times are taken from columns {} and {}", column + 1, column + 2));
        return time(column, true);
    }
    let has_times = |column| measures_time(column) && !is_span(bare(column)) && file.sample(column).is_some();
    if let [column] = candidates(&has_times)[..] {
        notes.push(format!("times are taken from {}, by its unit", time_column(file, column)));
        return time(column, false);
    }
    let is_calendar = |column: &usize| {
        file.calendar(*column) == Some(Calendar::Time) && !wanted.contains(column) && taken != Some(*column)
    };
    if let Some(column) = (0..file.columns()).find(is_calendar) {
        notes.push(format!("times are taken from {}, a clock", time_column(file, column)));
        return time(column, true);
    }
    if let (None, Some(step_s)) = (step_s, file.step_s()) {
        let step = significant(step_s, 9);
        notes.push(format!("the sampling step of {step} s is taken from the header"));
    }
    let is_counter = |column: usize| is_called(bare(column), &COUNTERS) && file.sample(column).is_some();
    let counter = candidates(&is_counter).first().copied();
    // The first column often has times under another name. It must not be missed among samples that are not named.
    let has_step = step_s.or(file.step_s()).is_some();
    let is_time = |sample| file.names().is_empty() || epoch_unit(sample).is_some();
    let may_be_first =
        file.columns() > 1 && !wanted.contains(&0) && taken != Some(0) && file.sample(0).is_some_and(is_time);
    let first = (may_be_first && !(has_step && wanted.is_empty())).then_some(0);
    let column = if has_step { counter.or(first) } else { first };
    if column.is_none() && !has_step {
        return Err(without_times(file, unread));
    }
    if let Some(column) = column.filter(|_| has_unit && file.names().is_empty()) {
        return time(column, false);
    }
    Ok((column.map(|column| Time { column, unit_s: None, unit_is: Stated::InHeader, rest: None }), false))
}

/// The error for a file without times, or with a column of such a name that is `unread`.
fn without_times(file: &ColumnFile, unread: Option<usize>) -> RecordError {
    let help = "give the rate of your logger as `rate = HZ`, or `time = COLUMN` for a column of time stamps, or both: the stamps then \
                only show where samples are missing";
    match unread {
        None => file.refuse(None, "the times of the samples are not given", "no column called time", help),
        Some(column) => {
            let message =
                format!("{} holds text that is neither a number nor a time", time_column(file, column));
            file.refuse(unread, &message, "not read", help)
        }
    }
}

/// What is to be given for the times of a file without a header, where they are not found without it, and the column that would have
/// them.
pub(crate) fn asked(file: &ColumnFile, timing: &Timing) -> Option<(Option<usize>, String)> {
    let Timing::Stamps { step_s: None, column, unit: None } = timing else { return None };
    let is_clock =
        |column: usize| file.calendar(column) == Some(Calendar::Time) || Rest::new(file, column).is_some();
    let is_epoch =
        |column: usize| file.rows(column).first().is_some_and(|first| epoch_unit(*first).is_some());
    let at = match column {
        Some(word) => file.find(word, None).ok().filter(|at| !is_clock(*at) && !is_epoch(*at))?,
        None if file.step_s().is_some() || is_epoch(0) || (0..file.columns()).any(is_clock) => return None,
        None => 0,
    };
    let rows = file.rows(at);
    if rows.is_empty() || !are_times(rows, true) {
        return column.is_none().then(|| (None, "`rate = HZ`, the rate of your logger".to_owned()));
    }
    let units = in_units(&likely_units(median_step(rows), &[]), "s");
    Some((Some(at), format!("`time = {}` with {units}", at + 1)))
}

/// The settings of some units of time with the rate that each gives, or else of the unit `other`.
fn in_units(likely: &[(&str, f64)], other: &str) -> String {
    let settings = likely
        .iter()
        .map(|(unit, rate_hz)| format!("`time_unit = {unit}` for {} Hz", significant(*rate_hz, 6)));
    if likely.is_empty() {
        format!("`time_unit = {other}`")
    } else {
        settings.collect::<Vec<_>>().join(" or ")
    }
}

/// A column of times in a sentence.
fn time_column(file: &ColumnFile, column: usize) -> String {
    let name = file.names().get(column).map(|name| name.bare.clone()).filter(|name| !name.is_empty());
    format!("the time column `{}`", name.unwrap_or_else(|| (column + 1).to_string()))
}

/// The column that shares the most leading groups of its path with the `wanted` column, or of several the one with a unit, or else the
/// stamp of the sensor; `None` if several remain.
fn nearest(file: &ColumnFile, columns: Vec<usize>, wanted: Option<&usize>) -> Option<usize> {
    let alike = |column: usize| {
        let name = |column: usize| file.names()[column].whole.as_bytes();
        let pairs =
            wanted.filter(|at| **at < file.names().len()).map(|&at| name(column).iter().zip(name(at)));
        let groups = pairs
            .map_or(0, |pairs| pairs.take_while(|(a, b)| a == b).filter(|(a, _)| b"/.".contains(a)).count());
        let name = &file.names()[column];
        (groups, name.unit.is_some(), is_called(&name.bare, &["stamp", "sampleus"]))
    };
    let best = columns.iter().map(|&column| alike(column)).max()?;
    let mut equal = columns.into_iter().filter(|&column| alike(column) == best);
    equal.next().filter(|_| equal.next().is_none())
}

/// The unit of a column of stamps: the one given, or that of its header, if there is one.
fn unit_s(
    file: &ColumnFile,
    column: usize,
    given: Option<&str>,
    what: &str,
) -> Result<Option<f64>, RecordError> {
    if file.calendar(column).is_some() {
        return Ok(Some(1.0));
    }
    if given.is_none() && file.names().get(column).is_none_or(|name| name.unit.is_none()) {
        return Ok(None);
    }
    let help = "give its unit as in `time_unit = ms`; accepted: s, ms, us, ns, min, h";
    file.unit_size(column, given, Dimension::Time, what, help).map(Some)
}

/// The sampling step, s, and the samples of all columns on an even grid, with NaN where one is missing.
pub(crate) fn spread(
    file: &ColumnFile,
    clock: &Clock,
    stamps: Option<Vec<f64>>,
    mut samples: Vec<Vec<f64>>,
    notes: &mut Vec<String>,
    faults: &mut Faults,
) -> Option<(f64, Vec<Vec<f64>>)> {
    let (Some(time), Some(mut stamps)) = (clock.time, stamps) else {
        return clock.step_s.map(|step_s| (step_s, samples));
    };
    let title = time_column(file, time.column);
    // Stamps that may be none need no decision.
    let has_step = clock.step_s.is_some();
    let may_be_times = clock.is_sure || stamps.first().is_some_and(|first| epoch_unit(*first).is_some());
    if let Some(equal) = rows_of_lost_digits(&stamps, has_step).filter(|_| may_be_times) {
        let message = format!(
            "{title} has lost its digits: {equal} of {} rows have the time of the row before",
            stamps.len()
        );
        let settings =
            if has_step { "`time = none`" } else { "`time = none` and `rate = HZ`, the rate of your logger" };
        let help = format!(
            "spreadsheets round long numbers: take the log as it was recorded, or ignore its times with {settings}"
        );
        faults.add(file.refuse_row(0, time.column, [message, "rounded".to_owned(), help]));
        return None;
    }
    let given = clock.duplicates.or((!clock.is_sure && has_step).then_some(Duplicates::Keep));
    let mut duplicates = given;
    let mut doubled = doubled_of(&stamps, &samples, duplicates);
    // Of a coarse clock, which many rows share, each row is a sample.
    let differs = |found: &Doubled| REPEATED_PER_OTHER * found.differing > found.repeated;
    if given.is_none() && !has_step && are_coarse(&stamps) && doubled.as_ref().is_some_and(differs) {
        duplicates = Some(Duplicates::Keep);
        doubled = doubled_of(&stamps, &samples, duplicates);
    }
    let are_samples = |found: &Doubled| duplicates.is_none() && found.differing > found.repeated;
    let mut all = doubled.as_ref().is_some_and(are_samples).then(|| stamps.clone());
    if let Some(Doubled { kept, .. }) = &doubled {
        stamps = kept.iter().map(|&row| stamps[row]).collect();
    }
    let rolled = unroll(&mut stamps);
    if let Some(all) = &mut all {
        unroll(all);
    }
    let name = file.names().get(time.column);
    let may_number = time.unit_s.is_some()
        || name.is_none_or(|name| has_step && (is_called(&name.bare, &COUNTERS) || is_time(&name.bare)));
    if !clock.is_sure && !are_times(&stamps, may_number) {
        if !has_step {
            faults.add(without_times(file, None));
        }
        if name.is_some_and(|name| is_time(&name.bare) || is_called(&name.bare, &COUNTERS)) {
            notes.push(format!(
                "{title} does not increase evenly, so it is not taken for times: `time = COLUMN` takes it"
            ));
        }
        return clock.step_s.map(|step_s| (step_s, samples));
    }
    if let Some((limit, times)) = rolled {
        let times = if times == 1 { "once".to_owned() } else { format!("{times} times") };
        notes.push(format!("{title} is a counter that rolls over at {limit} ({times})"));
    }
    let row_of = |row: usize| doubled.as_ref().map_or(row, |doubled| doubled.kept[row]);
    let refuse = |fault: TimeFault| file.refuse_row(row_of(fault.row), time.column, fault.words);
    if let Some(found) = &doubled {
        if found.repeated > 0 {
            let rows = if found.repeated == 1 { "row that repeats" } else { "rows that repeat" };
            notes.push(format!("left out: {} {rows} the row before", found.repeated));
        }
        match (found.first, duplicates) {
            (None, _) => {}
            (Some(_), Some(duplicates)) => {
                let fate = match duplicates {
                    Duplicates::First => "the first is used",
                    Duplicates::Last => "the last is used",
                    Duplicates::Keep => "each is a sample",
                };
                notes.push(format!("{} the time of the row before: {fate}", have(found.differing)));
            }
            (Some(row), None) => {
                let message =
                    format!("{} the time of the row before, but other numbers", have(found.differing));
                let help = "give `duplicates = first` or `duplicates = last` to use one of them, or `duplicates = keep` if each is a \
                            sample";
                let words = [message, "the first one".to_owned(), help.to_owned()];
                faults.add(file.refuse_row(row, time.column, words));
            }
        }
        for column in &mut samples {
            *column = found.kept.iter().map(|&row| column[row]).collect();
        }
    }
    let unit_s = unit_of_stamps(file, clock, time, &stamps, notes, faults);
    let are_kept = duplicates == Some(Duplicates::Keep) && doubled.is_some();
    let is_by_mean = !has_step && stamps.len() > 1 && (are_kept || are_rounded(&stamps));
    let mean = is_by_mean.then(|| mean_step(&stamps));
    let jitter = (clock.step_s.is_none() && mean.is_none()).then_some(RULES.jitter);
    let found = faults_of(&stamps, all.as_ref().unwrap_or(&stamps), unit_s.unwrap_or(ANY), jitter);
    if !found.is_empty() || !faults.is_empty() {
        found.into_iter().for_each(|fault| faults.add(refuse(fault)));
        return None;
    }
    if let Some((mean, unit_s)) = mean.zip(unit_s) {
        let rate = significant(1.0 / (mean * unit_s), 6);
        notes.push(format!("by {title}, the mean rate of the samples is {rate} Hz"));
    }
    if let (false, Some(unit_s)) = (has_step, unit_s)
        && let Some((doubt, help, is_large)) = doubted(&title, &stamps, unit_s)
    {
        if is_large {
            faults.add(file.refuse(Some(time.column), &doubt, "these stamps", &help));
            return None;
        }
        notes.push(format!("{doubt}; {help}"));
    }
    if let Some(distinct) = few_distinct(&stamps).filter(|_| !has_step) {
        notes.push(format!(
            "{title} has only {distinct} different times, too few to tell whether samples are missing, by which the rate would be higher; if \
             it is known, give it as `rate = HZ`"
        ));
    }
    let (step_s, grid) = match clock.step_s.or(mean.zip(unit_s).map(|(mean, unit_s)| mean * unit_s)) {
        None => {
            let grid = faults.take(grid(&stamps, unit_s?, &RULES).map_err(refuse))?;
            (unit_s? * grid.step, grid)
        }
        Some(step_s) => {
            let step = step_in_stamps(&stamps, step_s, unit_s);
            let refuse_rate = |apart_s| other_rate(file, time.column, apart_s, step_s);
            let [given, step] = faults.take(step.map_err(refuse_rate))?;
            let grid = faults.take(grid_of_rows(&stamps, step, RULES.most).map_err(refuse))?;
            if has_step {
                let told = tell(&title, &stamps, given, grid.samples, notes);
                faults.take(told.map_err(|ratio| refuse_rate(ratio * step_s)))?;
            }
            (step_s, grid)
        }
    };
    Some((step_s, samples.into_iter().map(|values| grid.spread(values)).collect()))
}

/// Whether numbers increase like times since 1970, of which some may be equal, or evenly like times and numbers of samples.
fn are_times(numbers: &[f64], may_number: bool) -> bool {
    let steps = || numbers.windows(2).map(|pair| pair[1] - pair[0]);
    let are_since_1970 = numbers.first().is_some_and(|first| epoch_unit(*first).is_some());
    let is_even = || {
        let median = median_step(numbers);
        let near = steps().filter(|step| (0.5 * median..=1.5 * median).contains(step)).count();
        median > 0.0 && 4 * near >= 3 * (numbers.len() - 1)
    };
    numbers.len() > 1 && steps().all(|step| step >= 0.0) && (are_since_1970 || may_number && is_even())
}

/// The unit of the stamps; they may be times since 1970. That of a logger is only taken if it gives the rate of a sensor.
fn unit_of_stamps(
    file: &ColumnFile,
    clock: &Clock,
    time: Time,
    stamps: &[f64],
    notes: &mut Vec<String>,
    faults: &mut Faults,
) -> Option<f64> {
    let epoch = epoch_unit_of(stamps);
    let title = time_column(file, time.column);
    let step = (stamps.len() > 1).then(|| mean_step(stamps)).filter(|step| *step > 0.0);
    let is_of_sensor = |unit_s: f64| step.is_none_or(|step| is_step_of_sensor(step * unit_s));
    let unit_s = time.unit_s.filter(|unit_s| time.unit_is != Stated::ByLogger || is_of_sensor(*unit_s));
    // Times since 1970 are too large in a coarser unit. In a finer one they are those of a device that has run for weeks, with a thousand
    // times the rate.
    let contradicts = |unit_s: f64, of_epoch: f64| match time.unit_is {
        Stated::ByLogger => false,
        _ if unit_s >= of_epoch => unit_s > of_epoch,
        Stated::InHeader => is_of_sensor(of_epoch),
        Stated::Surely => is_of_sensor(of_epoch) && !is_of_sensor(unit_s),
    };
    match (unit_s, epoch) {
        (Some(unit_s), Some((unit, of_epoch))) if clock.step_s.is_none() && contradicts(unit_s, of_epoch) => {
            let rate = step.map_or(String::new(), |step| {
                let [stated, by_epoch] =
                    [unit_s, of_epoch].map(|unit_s| significant(1.0 / (step * unit_s), 6));
                format!(": {by_epoch} Hz, not {stated} Hz")
            });
            let message = format!("{title} does not fit its unit, but {unit} since 1970{rate}");
            let help = format!("give `time_unit = {unit}`, or else its own unit in the same way");
            faults.add(file.refuse(Some(time.column), &message, "this unit", &help));
            None
        }
        (None, Some((unit, unit_s))) => {
            notes.push(format!("{title} is taken for {unit} since 1970"));
            Some(unit_s)
        }
        (None, None) if clock.is_sure && step.is_some_and(|step| are_serial_days(stamps, step)) => {
            notes.push(format!("{title} is taken for days, as spreadsheets count them"));
            Some(DAY_S)
        }
        (None, None) if clock.step_s.is_none() => {
            let message = match time.unit_s.zip(step) {
                None => format!("{title} has no unit"),
                Some((unit_s, step)) => {
                    let rate = significant(1.0 / (step * unit_s), 6);
                    format!("{title} is not in the unit of this logger, which gives {rate} Hz")
                }
            };
            let words = file.names().get(time.column).map(|name| words(&name.whole)).unwrap_or_default();
            let likely = step.map(|step| likely_units(step, &words)).unwrap_or_default();
            let examples = in_units(&likely, "ms");
            let help = format!("give its unit as in {examples}; accepted: s, ms, us, ns, min, h");
            faults.add(file.refuse(Some(time.column), &message, "its unit is missing", &help));
            None
        }
        (unit_s, _) => unit_s,
    }
}

/// A note and a help where stamps do not tell which samples are missing, and whether the rate is too uncertain.
fn doubted(title: &str, stamps: &[f64], unit_s: f64) -> Option<(String, String, bool)> {
    let off = if stamps.len() > 1 { uncertainty(stamps) } else { 0.0 };
    let rate = || significant(1.0 / (mean_step(stamps) * unit_s), 6);
    let doubt = |rate: &str| {
        let percent = significant(100.0 * off, 1);
        format!(
            "{title} does not tell for sure which samples are missing: its rate of {rate} Hz may be off by up to {percent} %"
        )
    };
    // Not that rate, which is the doubtful one.
    let help = "if the rate of the gyro is known, give it as `rate = HZ`".to_owned();
    (off > 0.0).then(rate).map(|rate| (doubt(&rate), help, off > MAX_UNCERTAINTY))
}

/// Notes what the stamps were used for.
///
/// # Errors
/// They contradict the given rate; with their step as a part of the given one.
fn tell(title: &str, stamps: &[f64], step: f64, samples: usize, notes: &mut Vec<String>) -> Result<(), f64> {
    let missing = samples.saturating_sub(stamps.len());
    notes.push(format!(
        "the given rate is the sampling rate; {title} only shows which samples are missing ({missing})"
    ));
    let [first, .., last] = *stamps else { return Ok(()) };
    let ratio = (last - first) / step / (samples.max(2) - 1) as f64;
    // The first and the last stamp of a coarse clock may have few rows.
    let deviation = (ratio - 1.0).abs() - coarseness(stamps) / (last - first);
    // With a wrong rate, even stamps may also look like those of a log in which samples are missing at every step.
    let other = exact_step(stamps).map(|own| own / step).filter(|own| (own - 1.0).abs() > MAX_DEVIATION);
    if let Some(ratio) = other.or((deviation > MAX_DEVIATION).then_some(ratio)) {
        return Err(ratio);
    }
    if deviation > 0.01 {
        let percent = significant(100.0 / ratio, 4);
        notes.push(format!("by the stamps the rate is {percent} % of the given one: is it right?"));
    }
    Ok(())
}

/// The error for stamps that are `apart_s` apart where the given step is another.
fn other_rate(file: &ColumnFile, column: usize, apart_s: f64, step_s: f64) -> RecordError {
    let (apart, rate) = (significant(apart_s, 6), significant(1.0 / apart_s, 6));
    let message = format!("the stamps are {apart} s apart, the given rate says {} s", significant(step_s, 4));
    let help = format!("correct the rate, as in `rate = {rate}Hz`, or ignore the stamps with `time = none`");
    file.refuse(Some(column), &message, "these stamps", &help)
}

fn have(rows: usize) -> String {
    if rows == 1 { "1 row has".to_owned() } else { format!("{rows} rows have") }
}
