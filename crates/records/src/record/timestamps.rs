//! Time stamps as loggers write them: since the epoch, late, doubled, or from a counter that rolls over.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::record::log::read::Duplicates;
use crate::record::time::{DAY_S, Grid, LONG_GAP, SPARSEST, TimeFault, median_step, whole_steps};
use sagnac_base::quantity::number::significant;

/// Seconds since 1970 that count as a time stamp, from 2001 to 2096. In a thousandth of the unit they are other years by
/// far, so the unit follows from the size.
const EPOCH_S: std::ops::Range<f64> = 1e9..4e9;

/// Longest sampling step of a log whose stamps have no unit, s.
const MAX_STEP_S: f64 = 100.0;

/// Units of time, s.
const UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];

/// Rates of sensors.
const SENSORS_HZ: std::ops::Range<f64> = 0.5..20e3;

/// Values at which counters roll over: those of 8, 16, 24 and 32 bits, the last also of µs shown in ms and in s, and the seconds
/// of a minute, an hour, half a day, a day and a GPS week, the last two also in ms.
const LIMITS: [f64; 13] = [
    4_294.967_296,
    65_536.0,
    86_400.0,
    604_800.0,
    4_294_967.296,
    16_777_216.0,
    86_400_000.0,
    604_800_000.0,
    4_294_967_296.0,
    256.0,
    60.0,
    3600.0,
    43_200.0,
];

/// Deviation of steps from whole sampling steps, and of the rate of a clock from the given one, that are none of samples.
const JITTER: f64 = 0.1;
const MAX_DRIFT: f64 = 0.02;

/// Most sensors whose rows take turns in a log, and most rows of one of them in a row.
const MAX_SENSORS: usize = 8;
const MAX_ROWS_IN_TURN: usize = 4;

/// Fewest and most stamps on each side of a row that tell whether samples are missing before it. A gap is a rise by more than so many
/// times the fall that one in so many rows exceeds.
const MIN_WINDOW: usize = 8;
const MAX_WINDOW: usize = 256;
const FALLS: f64 = 1.5;
const ONE_IN: usize = 1000;
/// Most rows at which falls are examined.
const MAX_COMPARED: usize = 1 << 12;
/// Stamps over which mean steps are taken first, most of them, and most turns in which they are refined.
const MAX_LAG: usize = 256;
const MAX_SAMPLED: usize = 1 << 16;
const MAX_TURNS: usize = 10;
/// Largest part of the samples that may be missing at many steps; else the least distances of stamps are not the sampling step.
const MAX_MISSING: f64 = 0.5;
/// Fewest rows for each gap of samples that are missing, or row that is doubled, for a reason.
const ROWS_PER_GAP: f64 = 50.0;
/// Fewest blocks of stamps of which the wander is compared, and the least part and number of the samples that it shows to be missing:
/// slow beats of coarse clocks wander too. The estimated part is uncertain, and the rate is off by at most so many times it.
const MIN_BLOCKS: usize = 8;
const MIN_UNSEEN_SHARE: f64 = 5e-4;
const MIN_UNSEEN: f64 = 8.0;
const MAX_PER_UNSEEN: f64 = 4.0;
/// Longest beat of a rounded clock with the sampling rate that is found among losses, in samples.
const MAX_BEAT: usize = 1000;

/// The unit of stamps since the epoch, of which the first is `stamp`.
pub(crate) fn epoch_unit(stamp: f64) -> Option<(&'static str, f64)> {
    UNITS.into_iter().find(|(_, unit_s)| EPOCH_S.contains(&(stamp * unit_s)))
}

/// The unit of the stamps of a log if they count from the epoch. Stamps that count from the start of a device may have the size of
/// those in a coarser unit, so a unit in which the steps are too long is not taken.
pub(crate) fn epoch_unit_of(stamps: &[f64]) -> Option<(&'static str, f64)> {
    let is_short = |unit_s: f64| stamps.len() < 2 || median_step(stamps) * unit_s <= MAX_STEP_S;
    epoch_unit(*stamps.first()?).filter(|(_, unit_s)| is_short(*unit_s))
}

/// Numbers of days by which spreadsheets count times, from 1954 to 2119. In seconds their steps are far shorter than those of a sensor.
const SERIAL_DAYS: Range<f64> = 2e4..8e4;

/// Whether stamps with a mean `step` are times of a spreadsheet, in days.
pub(crate) fn are_serial_days(stamps: &[f64], step: f64) -> bool {
    stamps.iter().all(|stamp| SERIAL_DAYS.contains(stamp)) && is_step_of_sensor(step * DAY_S)
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
/// Only a limit within which all stamps lie is taken, and only if it turns each step back into one of at most ten sampling steps.
pub(crate) fn unroll(stamps: &mut [f64]) -> Option<(f64, usize)> {
    let backwards: Vec<f64> =
        stamps.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step < 0.0).collect();
    if backwards.is_empty() || stamps.iter().any(|stamp| stamp.is_nan() || *stamp < 0.0) {
        return None;
    }
    // A clock of twelve hours goes from 1 to 13.
    let least = stamps.iter().copied().fold(f64::INFINITY, f64::min);
    let range = stamps.iter().copied().fold(0.0, f64::max) - least;
    let step = if are_coarse(stamps) { step_of_distinct(stamps) } else { median_step(stamps) };
    let longest = LONG_GAP * step;
    let fits = |limit: &f64| {
        *limit > range && backwards.iter().all(|step| (0.0..=longest).contains(&(step + limit)))
    };
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
        if sensors.len() > MAX_SENSORS || number.fract() != 0.0 {
            return None;
        }
    }
    let take_turns = sensors.len() > 1 && changes >= numbers.len() / MAX_ROWS_IN_TURN;
    let is_interleaved = take_turns && exact_step(stamps).is_none();
    sensors.sort_by(f64::total_cmp);
    is_interleaved.then_some(sensors)
}

/// All faults in the order and the spacing of `stamps` in a unit of `unit_s`: of each kind the first, with the number of the
/// others. Steps may deviate by `jitter` sampling steps from whole ones, if at all. `samples` are the stamps of all rows, of which
/// those with the stamp of the row before may be samples too.
pub(crate) fn faults(stamps: &[f64], samples: &[f64], unit_s: f64, jitter: Option<f64>) -> Vec<TimeFault> {
    let mut faults = Vec::new();
    let mut tell = |rows: &[usize], words: &dyn Fn(usize) -> [String; 3]| {
        let Some(&row) = rows.first() else { return };
        let [message, label, help] = words(row);
        let more = if rows.len() > 1 { format!(" ({} such rows)", rows.len()) } else { String::new() };
        faults.push(TimeFault { row, words: [message + &more, label, help] });
    };
    let missing: Vec<usize> = (0..stamps.len()).filter(|&row| !stamps[row].is_finite()).collect();
    tell(&missing, &|_| {
        let help = "remove the row; or give `rate = HZ` with `time = none`, which takes all rows as one gapless series";
        ["the time is missing", "no number", help].map(str::to_owned)
    });
    let step = |row: usize| stamps[row] - stamps[row - 1];
    let backwards: Vec<usize> = (1..stamps.len()).filter(|&row| step(row) < 0.0).collect();
    tell(&backwards, &|row| {
        let help = "sort the rows by time; logs appended to each other are several records: cut the file there; if the column \
                    has no times, name another with `time = COLUMN`, or give `rate = HZ` with `time = none`";
        let message = format!("the time does not increase: {} after {}", stamps[row], stamps[row - 1]);
        [message, "earlier than the row before".to_owned(), help.to_owned()]
    });
    let (Some(jitter), true) = (jitter, stamps.len() > 1 && missing.is_empty()) else { return faults };
    let median = median_step(stamps);
    let is_uneven = |row: &usize| step(*row) > 0.0 && whole_steps(step(*row), median, jitter).is_none();
    let mut uneven: Vec<usize> = (1..stamps.len()).filter(is_uneven).collect();
    if uneven.is_empty() && backwards.is_empty() && exact_gaps(stamps).is_none() {
        uneven = (1..stamps.len()).filter(|&row| step(row) > 1.5 * median).collect();
    }
    if uneven.is_empty() {
        return faults;
    }
    // Rows that are doubled for a reason are rare; more of them are late samples.
    let doubled = (samples.len() - stamps.len()) as f64;
    let stamps_of_samples = if ROWS_PER_GAP * doubled > samples.len() as f64 { samples } else { stamps };
    let mean = mean_step(stamps_of_samples);
    let doubt = match uncertainty(stamps_of_samples) {
        0.0 => String::new(),
        off => format!(
            ". They do not tell for sure which, so this rate may be off by up to {} %: give that of the gyro if it is known",
            significant(100.0 * off, 1)
        ),
    };
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
             `rate = {rate}Hz`: the stamps then only show where samples are missing{doubt}"
        );
        [message, "not on the grid".to_owned(), help]
    });
    faults
}

/// The grid of rows that were sampled every `step`, in the unit of the stamps, which may be late, doubled or coarse. It has at most `most`
/// samples. Rows with the same stamp are successive samples.
pub(crate) fn grid_of_rows(stamps: &[f64], step: f64, most: usize) -> Result<Grid, TimeFault> {
    let gaps = match exact_gaps(stamps) {
        Some(exact) if (exact.step / step - 1.0).abs() < MAX_DRIFT => exact.gaps,
        _ => Points::new(stamps).gaps(step),
    };
    let mut next = gaps.iter().peekable();
    let steps = |row: usize| 1.0 + next.next_if(|gap| gap.0 == row).map_or(0.0, |gap| gap.1);
    placed(stamps.len(), step, most, steps)
}

/// The mean step between samples over the whole record, without the gaps.
pub(crate) fn mean_step(stamps: &[f64]) -> f64 {
    exact_gaps(stamps).map_or_else(|| Points::new(stamps).step(), |exact| exact.step)
}

/// The part by which the mean step may be off because the stamps do not tell which samples are missing; 0 where they do.
pub(crate) fn uncertainty(stamps: &[f64]) -> f64 {
    if let Some(exact) = exact_gaps(stamps) {
        return beat(&exact.gaps).map_or(0.0, |distance| 1.0 / distance as f64);
    }
    let unseen = Points::new(stamps).unseen();
    let are_many = unseen > MIN_UNSEEN_SHARE && unseen * stamps.len() as f64 > MIN_UNSEEN;
    if are_many { MAX_PER_UNSEEN * unseen } else { 0.0 }
}

/// The distance at which far more gaps follow each other than losses at random places do, in sampling steps: the beat of a rounded
/// clock with the sampling rate, among losses.
fn beat(gaps: &[(usize, f64)]) -> Option<usize> {
    let (mut lost, mut places) = (0, Vec::with_capacity(gaps.len()));
    for gap in gaps {
        places.push(gap.0 + lost);
        lost += gap.1 as usize;
    }
    let span = (places.last()? - places[0]) as f64;
    let mut pairs = [0_usize; MAX_BEAT + 2];
    for (at, place) in places.iter().enumerate() {
        let distances = places[at + 1..].iter().map(|next| next - place);
        distances.take_while(|distance| *distance < MAX_BEAT + 2).for_each(|distance| pairs[distance] += 1);
    }
    let at_random = 2.0 * (places.len() * places.len()) as f64 / span;
    let most_at_random = at_random + 6.0 * at_random.sqrt() + 6.0;
    (2..=MAX_BEAT).find(|&distance| {
        let pairs = (pairs[distance] + pairs[distance + 1]) as f64;
        pairs > most_at_random.max(0.5 * span / distance as f64)
    })
}

/// Rows before which samples are missing, with their number.
type Gaps = Vec<(usize, f64)>;

/// The gaps of stamps that resolve each sampling step, and that step.
struct Exact {
    step: f64,
    gaps: Gaps,
}

/// The gaps where all steps are whole multiples of the median one, unless more than half of the samples would be missing at many
/// places, as between bursts.
fn whole_gaps(stamps: &[f64]) -> Option<Exact> {
    let (first, last) = (stamps.first()?, stamps.last()?);
    let median = if stamps.len() > 1 { median_step(stamps) } else { 0.0 };
    let (mut gaps, mut total) = (vec![], 0.0);
    for (before, pair) in stamps.windows(2).enumerate() {
        let steps = whole_steps(pair[1] - pair[0], median, JITTER)?;
        total += steps;
        if steps > 1.0 {
            gaps.push((before + 1, steps - 1.0));
        }
    }
    let rows = stamps.len() as f64;
    let are_few = MAX_MISSING * total < rows || ROWS_PER_GAP * (gaps.len() as f64) < rows;
    (total > 0.0 && are_few).then(|| Exact { step: (last - first) / total, gaps })
}

/// The gaps of stamps that resolve each sampling step, and are not rounded.
fn exact_gaps(stamps: &[f64]) -> Option<Exact> {
    whole_gaps(stamps).filter(|exact| !are_regular(&exact.gaps))
}

/// The sampling step, where stamps resolve each step and are not rounded.
pub(crate) fn exact_step(stamps: &[f64]) -> Option<f64> {
    exact_gaps(stamps).map(|exact| exact.step)
}

/// Whether stamps are rounded to a unit a little finer than the sampling step.
pub(crate) fn are_rounded(stamps: &[f64]) -> bool {
    whole_gaps(stamps).is_some_and(|exact| are_regular(&exact.gaps))
}

/// Whether single samples are missing at regular distances, which is the beat of a rounded clock with the sampling rate. Losses
/// are at random ones.
fn are_regular(gaps: &[(usize, f64)]) -> bool {
    let is_regular = |gaps: &[(usize, f64)]| {
        let [a, b] = [gaps[1].0 - gaps[0].0, gaps[2].0 - gaps[1].0];
        gaps.iter().all(|gap| gap.1 == 1.0)
            && a.min(b) > 1
            && a.abs_diff(b) as f64 <= 1.0 + JITTER * a.max(b) as f64
    };
    2 * gaps.windows(3).filter(|gaps| is_regular(gaps)).count() > gaps.len().saturating_sub(2)
}

/// The rows by which the samples are counted: of those in a burst, or with one stamp, only the first or the last.
struct Points {
    rows: Vec<usize>,
    /// The first row of each burst.
    starts: Vec<usize>,
    stamps: Vec<f64>,
    /// Least rise of the stamps over the rows, in sampling steps, that is a gap.
    least_rise: f64,
    /// Whether all stamps are whole units of a coarse clock, so that the first row of each is late by up to a step.
    are_units: bool,
}

impl Points {
    /// Where stamps are rounded down, the first row of each is nearest to it; in a burst it is the last one. Those of which the
    /// stamps follow the rows more closely are taken.
    fn new(stamps: &[f64]) -> Points {
        let rows = stamps.len();
        let points = |rows: Vec<usize>, starts: Vec<usize>| {
            let stamps = rows.iter().map(|&row| stamps[row]).collect();
            Points { rows, starts, stamps, least_rise: 0.5, are_units: false }
        };
        let all = points((0..rows).collect(), (0..rows).collect());
        if rows < 2 {
            return all;
        }
        let near = 0.5 * all.step_of_lags();
        // The record may begin and end within a burst.
        let starts: Vec<usize> = (1..rows).filter(|&row| stamps[row] - stamps[row - 1] > near).collect();
        if starts.len() + 1 >= rows || starts.len() < 2 {
            return all;
        }
        let firsts = points(starts.clone(), starts.clone());
        let lasts = points(starts[1..].iter().map(|row| row - 1).collect(), starts);
        let noise = |points: &Points| {
            let fall = points.levels(points.step_of_lags()).fall(MIN_WINDOW);
            fall.map_or(f64::INFINITY, |[_, fall]| fall)
        };
        let mut points = if lasts.rows.len() > 1 && noise(&lasts) <= noise(&firsts) { lasts } else { firsts };
        let unit = median_step(&points.stamps);
        let is_unit = |pair: &[f64]| whole_steps(pair[1] - pair[0], unit, 1e-3).is_some();
        if are_coarse(stamps) && points.stamps.windows(2).all(is_unit) {
            points.are_units = true;
            points.least_rise = 1.0 + JITTER;
        }
        points
    }

    /// The median of the mean steps over many rows, or over few ones if it is about the same, because these have fewer gaps.
    fn step_of_lags(&self) -> f64 {
        let points = self.rows.len();
        let of = |lag: usize| {
            let lag = lag.clamp(1, MAX_LAG);
            let stride = (points / MAX_SAMPLED).max(1);
            let mean = |at: usize| {
                (self.stamps[at + lag] - self.stamps[at]) / (self.rows[at + lag] - self.rows[at]) as f64
            };
            median_of(&mut (0..points.saturating_sub(lag)).step_by(stride).map(mean))
        };
        let [long, short] = [of(points / 16), of(MIN_WINDOW.min(points / 16))];
        if (short / long - 1.0).abs() < JITTER { short.min(long) } else { long }
    }

    /// The mean step, found together with the gaps: each in turn until neither changes.
    fn step(&self) -> f64 {
        let points = self.rows.len();
        let mut step = self.step_of_lags();
        let part = (points / 4).clamp(1, 4 * MAX_LAG);
        for _ in 0..MAX_TURNS {
            let places = self.places(step);
            let middle = |part: Range<usize>| {
                let away = |at: usize| self.stamps[at] - self.stamps[0] - step * places[at];
                [median_of(&mut part.clone().map(|at| places[at])), median_of(&mut part.map(away))]
            };
            let [[start, first], [end, last]] = [middle(0..part), middle(points - part..points)];
            let change = (last - first) / (end - start);
            if !change.is_finite() {
                break;
            }
            step += change;
            if change.abs() < 1e-12 * step {
                break;
            }
        }
        step
    }

    /// The places of the points among the samples that follow each other in `step`.
    fn places(&self, step: f64) -> Vec<f64> {
        let gaps = self.gaps(step);
        let mut next = gaps.iter().peekable();
        let mut lost = 0.0;
        let place = |&row: &usize| {
            while let Some(gap) = next.next_if(|gap| gap.0 <= row) {
                lost += gap.1;
            }
            row as f64 + lost
        };
        self.rows.iter().map(place).collect()
    }

    /// About the part of the samples that is missing without being found, or found without being missing.
    ///
    /// The stamps of samples lost at random places wander about the grid without them: the second differences of their medians over
    /// n samples have n times that part as variance. Stamps that are late, rounded or in bursts make it smaller with n, and
    /// a clock that drifts makes it larger, so the least over all n is taken.
    fn unseen(&self) -> f64 {
        let points = self.rows.len();
        let are_few = points < MIN_BLOCKS * MIN_WINDOW;
        if are_few && !(self.are_units && points >= MIN_BLOCKS) {
            return 0.0;
        }
        let step = self.step();
        let places = self.places(step);
        let away = |(stamp, place): (&f64, f64)| (stamp - self.stamps[0]) / step - place;
        let away: Vec<f64> = self.stamps.iter().zip(places).map(away).collect();
        let rows_per_point = (self.rows[points - 1] - self.rows[0]) as f64 / (points - 1) as f64;
        if are_few {
            // Those of single points have twice n times that part, and up to 1 by the first rows of units, which are late.
            let second = |of: &[f64]| of[2] - 2.0 * of[1] + of[0];
            let squares: f64 = away.windows(3).map(|of| second(of) * second(of)).sum();
            return (squares / (points - 2) as f64 - 1.0).max(0.0) / (2.0 * rows_per_point);
        }
        let part = |window: usize| {
            let starts = (0..points - window).step_by(window / 2);
            let medians: Vec<f64> = starts.map(|at| low_and_median(&away[at..at + window])[1]).collect();
            // Blocks begin at every half of them, so those side by side are two apart.
            let second = |of: &[f64]| of[4] - 2.0 * of[2] + of[0];
            let squares: f64 = medians.windows(5).map(|of| second(of) * second(of)).sum();
            squares / (medians.len() - 4) as f64 / (window as f64 * rows_per_point)
        };
        let windows = std::iter::successors(Some(MIN_WINDOW), |window| Some(2 * window));
        windows.take_while(|window| MIN_BLOCKS * window <= points).map(part).fold(f64::INFINITY, f64::min)
    }

    /// The rises of the stamps over the rows, in steps.
    fn levels(&self, step: f64) -> Levels {
        let rise = |(row, stamp): (&usize, &f64)| (stamp - self.stamps[0]) / step - *row as f64;
        Levels(self.rows.iter().zip(&self.stamps).map(rise).collect())
    }

    /// The gaps between samples that follow each other in `step`.
    ///
    /// Samples that are missing raise all later stamps over their rows; stamps that are late, early, rounded or in bursts do not. So
    /// the levels on both sides of a row are compared, over as many rows as make their differences small against one sample.
    fn gaps(&self, step: f64) -> Gaps {
        let mut levels = self.levels(step);
        let (window, trend, least_rise) = levels.window();
        let least_rise = least_rise.max(self.least_rise);
        let stride = window / MIN_WINDOW;
        let (mut gaps, mut lost, mut lowered) = (BTreeMap::new(), 0.0, 0);
        let points = self.rows.len();
        for at in (1..points).step_by(stride) {
            let reached = points.min(at + 2 * window);
            levels.0[lowered..reached].iter_mut().for_each(|level| *level -= lost);
            lowered = reached;
            let rise = |at: usize| {
                let is_sure = points - at >= MIN_WINDOW;
                let rise = levels.rise(at, window) - trend;
                (at, rise, rise >= if is_sure { least_rise } else { LONG_GAP })
            };
            if !levels.may_rise(at, stride, least_rise) || !rise(at).2 {
                continue;
            }
            // The gap is at the first of the rows with about the largest rise.
            let around = at.saturating_sub(stride).max(1)..points.min(at + window);
            let around: Vec<(usize, f64, bool)> = around.map(rise).collect();
            let largest = around.iter().map(|found| found.1).fold(0.0, f64::max);
            let at = around.iter().find(|found| found.1 >= 0.75 * largest).map_or(at, |found| found.0);
            let missing = libm::round(largest).max(1.0);
            *gaps.entry(self.starts[at]).or_insert(0.0) += missing;
            lost += missing;
            levels.0[at..lowered].iter_mut().for_each(|level| *level -= missing);
        }
        let mut gaps: Gaps = gaps.into_iter().collect();
        if are_regular(&gaps) {
            gaps.retain(|gap| gap.1 > 1.0);
        }
        gaps
    }
}

/// Rises of stamps over their rows, in sampling steps.
struct Levels(Vec<f64>);

impl Levels {
    /// By how much the levels rise at a point, within so many on each side.
    fn rise(&self, at: usize, window: usize) -> f64 {
        let [low, median] = low_and_median(&self.0[at.saturating_sub(window)..at]);
        let [next_low, next_median] = low_and_median(&self.0[at..self.0.len().min(at + window)]);
        (next_low - low).min(next_median - median)
    }

    /// Whether one of some levels from a point on is so much higher than one just before it.
    fn may_rise(&self, at: usize, count: usize, least_rise: f64) -> bool {
        let near = self.0[at.saturating_sub(MIN_WINDOW)..at].iter().copied().fold(f64::INFINITY, f64::min);
        self.0[at..self.0.len().min(at + count)].iter().any(|level| level - near >= least_rise)
    }

    /// The median rise over `window` levels on each side of a point, and how far rises fall below it in one of [`ONE_IN`] points,
    /// which gaps do not cause; `None` in a shorter record.
    fn fall(&self, window: usize) -> Option<[f64; 2]> {
        let inner = self.0.len().checked_sub(2 * window).filter(|inner| *inner > 0)?;
        let stride = (inner / MAX_COMPARED).max(1);
        let mut rises: Vec<f64> =
            (0..inner).step_by(stride).map(|at| self.rise(at + window, window)).collect();
        let [_, median] = low_and_median(&rises);
        let lowest = rises.len() / ONE_IN;
        Some([median, median - *rises.select_nth_unstable_by(lowest, f64::total_cmp).1])
    }

    /// The shortest window in which rises vary little against one sample, the median rise there, and the least one of a gap.
    fn window(&self) -> (usize, f64, f64) {
        let mut found = (MIN_WINDOW, 0.0, LONG_GAP);
        let mut window = MIN_WINDOW;
        while let Some([trend, fall]) = self.fall(window).filter(|_| window <= MAX_WINDOW) {
            if FALLS * fall < found.2 {
                found = (window, trend, FALLS * fall);
            }
            if found.2 <= 0.5 {
                break;
            }
            window *= 2;
        }
        found
    }
}

/// The value below which an eighth of them lies, and the median.
fn low_and_median(values: &[f64]) -> [f64; 2] {
    let mut values = values.to_vec();
    // Of two in the middle the lower one, because gaps raise values.
    let middle = (values.len() - 1) / 2;
    let (below, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let median = *median;
    let low = below.len() / 4;
    let low = if below.is_empty() { median } else { *below.select_nth_unstable_by(low, f64::total_cmp).1 };
    [low, median]
}

fn median_of(values: &mut dyn Iterator<Item = f64>) -> f64 {
    let values = values.collect::<Vec<_>>();
    if values.is_empty() { f64::NAN } else { low_and_median(&values)[1] }
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
                let help = "is a time stamp wrong? correct it, cut the log there, or ignore the stamps with `time = none`: at most \
                            ten times as many samples may be missing as there are";
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

/// The number of rows with the stamp of the row before, where these are so many that the others show no sampling rate: all, or all
/// but one where the rate is not given.
pub(crate) fn rows_of_lost_digits(stamps: &[f64], has_rate: bool) -> Option<usize> {
    let equal = stamps.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let most_others = if has_rate { 0 } else { 1 };
    (are_coarse(stamps) && stamps.len() - 1 - equal <= most_others).then_some(equal)
}

/// The number of different stamps of a coarse clock, where these are too few to show whether samples are missing.
pub(crate) fn few_distinct(stamps: &[f64]) -> Option<usize> {
    let distinct = 1 + stamps.windows(2).filter(|pair| pair[0] != pair[1]).count();
    (are_coarse(stamps) && distinct < MIN_BLOCKS + 2).then_some(distinct)
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
    Ok([step, if (mean / step - 1.0).abs() < MAX_DRIFT { mean } else { step }])
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
    fn stamps_rounded_to_a_little_less_than_the_step_have_its_rate_and_no_gaps() {
        for (rate_hz, digits) in [(952.0, 1e3), (833.0, 1e3), (90.0, 1e2), (75.0, 1e2), (99.5, 1e2)] {
            let stamps: Vec<f64> =
                (0..20_000).map(|i| libm::round(f64::from(i) / rate_hz * digits) / digits).collect();
            assert!(are_rounded(&stamps), "{rate_hz} Hz");
            let found = 1.0 / mean_step(&stamps);
            assert!((found / rate_hz - 1.0).abs() < 1e-4, "{found} and not {rate_hz} Hz");
            for step in [1.0 / found, 1.0 / rate_hz] {
                let samples = grid_of_rows(&stamps, step, 1 << 20).unwrap().samples;
                assert_eq!(samples, 20_000, "{rate_hz} Hz at {step} s");
            }
        }
    }

    #[test]
    fn short_records_of_coarse_stamps_have_their_rate_within_a_sample_and_no_gaps() {
        for (rate_hz, unit_s, phase) in
            [(100.0, 1.0, 0.0), (200.0, 1.0, 0.0), (50.0, 1.0, 0.0), (1000.0, 0.1, 0.0), (100.0, 1.0, 3.5)]
        {
            for count in [600_u32, 1000, 1500, 3000] {
                let stamps: Vec<f64> = (0..count)
                    .map(|i| libm::floor((f64::from(i) + 0.5) / rate_hz / unit_s + phase) * unit_s)
                    .collect();
                let found = 1.0 / mean_step(&stamps);
                let bound = 2.0 / f64::from(count);
                assert!((found / rate_hz - 1.0).abs() < bound, "{found} and not {rate_hz} Hz, {count} rows");
                let samples = grid_of_rows(&stamps, 1.0 / found, 1 << 20).unwrap().samples;
                assert_eq!(samples, count as usize, "{rate_hz} Hz");
            }
        }
    }

    #[test]
    fn losses_at_random_places_are_no_beat() {
        let mut state = 7_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for lost in [0.001, 0.01, 0.2] {
            let kept: Vec<f64> = (0..20_000).map(f64::from).filter(|_| uniform() >= lost).collect();
            let stamps: Vec<f64> = kept.iter().map(|at| 0.01 * at).collect();
            let samples = grid_of_rows(&stamps, mean_step(&stamps), 1 << 20).unwrap().samples;
            let right = (kept[kept.len() - 1] - kept[0]) as usize + 1;
            assert_eq!(samples, right, "{lost} lost");
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
                assert_eq!(uncertainty(&stamps), 0.0, "clock {kind}, {seed}");
            }
        }
    }

    /// Loggers' clocks of which 1 % of the samples is lost, for rows of `step`.
    fn clock_with_losses(kind: &str, seed: u64, step: f64) -> Vec<f64> {
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut stamps: Vec<f64> = (0..20_000).map(|i| 3.0 + step * f64::from(i)).collect();
        let mut normal = |sigma: f64| step * sigma * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0);
        match kind {
            "jitter of 0.5" => stamps.iter_mut().for_each(|stamp| *stamp += normal(0.5)),
            "jitter of 0.8" => stamps.iter_mut().for_each(|stamp| *stamp += normal(0.8)),
            "units of 0.95 steps" => {
                stamps.iter_mut().for_each(|stamp| *stamp = libm::round(*stamp / step / 0.95) * 0.95 * step);
            }
            "10 ms" => stamps.iter_mut().for_each(|stamp| *stamp = libm::round(*stamp * 100.0) / 100.0),
            "0.5 s" => stamps.iter_mut().for_each(|stamp| *stamp = libm::floor(*stamp * 2.0) / 2.0),
            "1 s" => stamps.iter_mut().for_each(|stamp| *stamp = libm::floor(*stamp)),
            _ => {
                let mut at = 0;
                while at < stamps.len() {
                    let end = stamps.len().min(at + 1 + (9.0 * uniform()) as usize);
                    let last = stamps[end - 1];
                    (at..end).for_each(|row| stamps[row] = last + 0.1 * step * (row - at) as f64);
                    at = end;
                }
            }
        }
        (1..stamps.len()).for_each(|i| stamps[i] = stamps[i].max(stamps[i - 1]));
        stamps.retain(|_| uniform() > 0.01);
        stamps
    }

    #[test]
    fn clocks_that_do_not_tell_which_samples_are_lost_are_uncertain() {
        for (kind, rate_hz) in [
            ("jitter of 0.5", 98.7),
            ("jitter of 0.8", 98.7),
            ("bursts", 101.3),
            ("units of 0.95 steps", 98.7),
            ("10 ms", 99.5),
            ("10 ms", 98.7),
            ("0.5 s", 98.7),
            ("1 s", 98.7),
            ("1 s", 100.0),
        ] {
            for seed in 0..8 {
                let stamps = clock_with_losses(kind, seed, 1.0 / rate_hz);
                let error = (mean_step(&stamps) * rate_hz - 1.0).abs();
                let uncertain = uncertainty(&stamps);
                assert!(
                    error < 1e-4 || uncertain > 1e-3,
                    "{kind}, {seed}: off by {error}, uncertain {uncertain}"
                );
            }
        }
    }

    #[test]
    fn few_stamps_of_a_coarse_clock_show_by_their_wander_that_samples_are_lost() {
        let mut state = 7_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for rate_hz in [100.0, 197.3, 199.55, 400.0] {
            for seconds in [12.0, 30.0, 60.0] {
                let count = (rate_hz * seconds) as usize;
                let stamp = |i: usize| libm::floor(1.7e9 + 0.3 + i as f64 / rate_hz);
                let whole: Vec<f64> = (0..count).map(stamp).collect();
                assert_eq!(uncertainty(&whole), 0.0, "{rate_hz} Hz, {seconds} s");
                if seconds < 30.0 {
                    continue;
                }
                let kept: Vec<f64> = (0..count).filter(|_| uniform() > 0.02).map(stamp).collect();
                let error = (mean_step(&kept) * rate_hz - 1.0).abs();
                let uncertain = uncertainty(&kept);
                assert!(
                    uncertain > error,
                    "{rate_hz} Hz, {seconds} s: off by {error}, uncertain {uncertain}"
                );
            }
        }
    }

    #[test]
    fn stamps_that_have_lost_their_digits_are_found() {
        let coarse = |distinct: usize| (0..600).map(|i| (i * distinct / 600) as f64).collect::<Vec<_>>();
        assert_eq!(rows_of_lost_digits(&coarse(1), false), Some(599));
        assert_eq!(rows_of_lost_digits(&coarse(1), true), Some(599));
        assert_eq!(rows_of_lost_digits(&coarse(2), false), Some(598));
        assert_eq!(rows_of_lost_digits(&coarse(2), true), None);
        assert_eq!(rows_of_lost_digits(&coarse(3), false), None);
        assert_eq!(rows_of_lost_digits(&[0.0, 1.0], false), None);
        assert_eq!([5, 30].map(|distinct| few_distinct(&coarse(distinct))), [Some(5), None]);
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
