//! A comparison as sentences.

use crate::allan::Unit;
use crate::analysis::compare::Length;
use crate::quantity::number::{significant, with_unit};

use crate::analysis::compare::logs::Analysis;
use crate::analysis::compare::rows::{Row, Verdict};

/// Least probability that is stated; smaller ones belong to tails that no approximation describes.
const LEAST_SAID: f64 = 1e-12;

/// All sentences: on the curves as a whole, then on each coefficient.
pub fn sentences(analysis: &Analysis) -> Vec<String> {
    let [a, b] = [&analysis.sides[0].label, &analysis.sides[1].label];
    if analysis.is_one_record {
        return vec![format!(
            "{a} and {b} are one record: every ratio is 1, and nothing can differ (p = 1)."
        )];
    }
    let of_rows = analysis.rows.iter().flatten();
    let shorter_s = analysis.shorter_s();
    let sentences = of_rows.map(|row| of_row(row, analysis.unit, [a, b], shorter_s));
    same(analysis).into_iter().chain(forced(analysis)).chain(sentences).collect()
}

/// Whose coefficients the fit does not describe.
fn forced(analysis: &Analysis) -> Option<String> {
    let labels = analysis.sides.iter().zip(analysis.comparison.described());
    let forced: Vec<&str> =
        labels.filter(|(_, is_described)| !is_described).map(|(side, _)| side.label.as_str()).collect();
    let whose = forced.join(" and ");
    (!forced.is_empty()).then(|| {
        format!("The coefficients of {whose} were forced: they do not describe the curve, and neither do their differences.")
    })
}

/// Formats a probability as `p = 0.03` or `p < 1e-12`.
pub fn probability(p: f64) -> String {
    if p < LEAST_SAID { format!("p < {LEAST_SAID:e}") } else { format!("p = {}", significant(p, 2)) }
}

/// Formats a duration with two digits, such as `31 h`.
pub fn duration(seconds: f64) -> String {
    const UNITS: [(f64, f64, &str); 5] = [
        (120.0, 1.0, "s"),
        (7200.0, 60.0, "min"),
        (72.0 * 3600.0, 3600.0, "h"),
        (730.0 * 86400.0, 86400.0, "days"),
        (f64::INFINITY, 365.25 * 86400.0, "years"),
    ];
    let (_, size, name) = UNITS.into_iter().find(|(most, ..)| seconds < *most).unwrap_or(UNITS[4]);
    format!("{} {name}", significant(seconds / size, 2))
}

/// The required length of a row, such as `31 h` or `> 2.1 years`; empty where it is unknown.
pub fn length(length: Length) -> String {
    match length {
        Length::Needed(length_s) => duration(length_s),
        Length::Beyond(length_s) => format!("> {}", duration(length_s)),
        Length::Unknown => String::new(),
    }
}

/// Whether the noise is the same over all averaging times together.
fn same(analysis: &Analysis) -> Option<String> {
    let same = analysis.comparison.same?;
    let first = analysis.comparison.ratios.first().map_or(0.0, |ratio| ratio.tau_s());
    let from = match same.shortest_s > first {
        true => format!(" from {}", significant(same.shortest_s, 6)),
        false => String::new(),
    };
    let times = format!("{} averaging times{from} up to {} s", same.times, significant(same.longest_s, 6));
    let how = match same.chi_squared {
        Some(value) => {
            format!("χ² = {} over {times}, with the covariance between them", significant(value, 4))
        }
        None => format!("the least p of {times}, times {}", same.times),
    };
    let said = if same.p < 0.05 { "The noise differs" } else { "No evidence that the noise differs" };
    Some(format!("{said}: {} for equal noise ({how}).", probability(same.p)))
}

fn of_row(row: &Row, unit: Unit, [a, b]: [&str; 2], shorter_s: f64) -> String {
    let name = row.found.quantity.title(unit);
    let found = &row.found;
    let p = found.p.map(probability).unwrap_or_default();
    let ratio = found.ratio.map(|ratio| times(ratio, 3)).unwrap_or_default();
    let range = interval(found.ratio_interval, &|end| times(end, 3));
    let enough = of_significant(row.length, shorter_s);
    let (shows, other) = if found.values[1].is_some() { (b, a) } else { (a, b) };
    let most = at_most(row, found.at_most[usize::from(found.values[1].is_none())]);
    match (row.verdict(), found.ratio) {
        (Verdict::Neither, _) => {
            let [a_most, b_most] = found.at_most.map(|most| at_most(row, most));
            format!("Neither record shows {name}: {a} has {a_most}, {b} {b_most}.")
        }
        (Verdict::Explained, _) => {
            format!("{name} is not compared: an event of {other} explains it as well.")
        }
        (Verdict::Equal, _) => {
            format!("Both have the same {name}: no length of records would show a difference.")
        }
        (Verdict::Higher | Verdict::Lower, Some(_)) => {
            format!("{b} has {ratio} times the {name} of {a} ({range}, {p}){enough}.")
        }
        (Verdict::Higher | Verdict::Lower, None) => {
            format!("{shows} has more {name} than {other}, which shows none: {most} ({p}){enough}.")
        }
        (Verdict::NotToldApart, Some(value)) => {
            let needed = of_open(row.length, value);
            format!(
                "No significant difference in {name}: {b} has {ratio} times that of {a} ({range}, {p}){needed}."
            )
        }
        (Verdict::NotToldApart, None) => format!(
            "Only {shows} shows {name}, but {other} may have as much: {most} ({p}). As long as its value is unknown, no \
             length of records can be given that would show a difference."
        ),
    }
}

/// The required length of records for a significant difference.
fn of_significant(length: Length, shorter_s: f64) -> String {
    match length {
        Length::Needed(s) if s <= shorter_s => {
            format!("; records of {} each would have been enough", duration(s))
        }
        Length::Needed(s) => format!("; to show it in 9 of 10 cases takes records of {} each", duration(s)),
        Length::Beyond(s) => {
            format!("; to show it in 9 of 10 cases takes records of more than {} each", duration(s))
        }
        Length::Unknown => String::new(),
    }
}

/// The length of records required to resolve values with this ratio.
fn of_open(length: Length, ratio: f64) -> String {
    let apart = match ratio {
        0.5..=2.0 => format!("{} %", significant(100.0 * (ratio - 1.0).abs(), 2)),
        _ => format!("a factor of {}", significant(ratio.max(1.0 / ratio), 2)),
    };
    match length {
        Length::Needed(s) => format!("; records of {} each would resolve {apart}", duration(s)),
        Length::Beyond(s) => format!("; to resolve {apart} takes records of more than {} each", duration(s)),
        Length::Unknown => String::new(),
    }
}

fn at_most(row: &Row, most: Option<f64>) -> String {
    match most {
        Some(most) => format!("at most {}", with_unit(most, 3, row.symbol)),
        None => "an unknown amount".to_owned(),
    }
}

/// A ratio with `digits` digits, or near 1 with enough to distinguish it from 1.
pub fn times(ratio: f64, digits: usize) -> String {
    let shown = (digits..digits + 6).map(|digits| significant(ratio, digits));
    shown.into_iter().find(|text| text != "1").unwrap_or_else(|| "1".to_owned())
}

/// An interval such as `0.6 … 1.3`, with words where an end is unknown.
pub(crate) fn interval([low, high]: [Option<f64>; 2], number: &dyn Fn(f64) -> String) -> String {
    match (low, high) {
        (Some(low), Some(high)) => format!("{} … {}", number(low), number(high)),
        (Some(low), None) => format!("at least {}", number(low)),
        (None, Some(high)) => format!("at most {}", number(high)),
        (None, None) => "no interval".to_owned(),
    }
}
