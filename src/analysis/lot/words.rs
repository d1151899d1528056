//! A lot as sentences.

use crate::analysis::compare::words::{probability, times};
use crate::analysis::log;
use crate::quantity::list::listed;
use crate::quantity::number::{significant, with_unit};

use crate::analysis::lot::pool::Pooled;
use crate::analysis::lot::{Coefficient, FALSE_ALARM, Found, Lot, Odd};

/// Notes attached to the results, each with the path of its log.
pub fn notes(lot: &Lot) -> Vec<String> {
    let of_log = |log: &log::Analysis| {
        let notes = log::notes::notes(log).into_iter();
        notes.map(|note| format!("{}: {note}", log.path.display())).collect::<Vec<_>>()
    };
    lot.logs.iter().flat_map(of_log).collect()
}

/// All sentences: the odd units, then the units that are left out of a coefficient, and the coefficients that no unit shows.
pub fn sentences(lot: &Lot) -> Vec<String> {
    let mut all = Vec::new();
    for one in &lot.coefficients {
        all.extend(one.odd().map(|(unit, found, odd)| of_odd(lot, one, unit, found, odd)));
    }
    if all.is_empty() {
        all.push(none(lot));
    }
    all.extend(lot.coefficients.iter().filter_map(|one| left_out(lot, one)));
    let is_hidden = |one: &&Coefficient| one.estimates().is_empty();
    let hidden: Vec<String> = lot.coefficients.iter().filter(is_hidden).map(Coefficient::title).collect();
    if !hidden.is_empty() {
        all.push(format!("No unit shows {}.", hidden.join(", ")));
    }
    all
}

fn none(lot: &Lot) -> String {
    match lot.tests {
        0 => "No unit was tested for being odd, which takes three units that show the same coefficient."
            .to_owned(),
        tests => format!(
            "No unit is odd in any of {tests} tests. At most {} % of lots without an odd unit fail one of them.",
            significant(100.0 * FALSE_ALARM, 2)
        ),
    }
}

fn of_odd(lot: &Lot, one: &Coefficient, unit: usize, found: &Found, odd: Odd) -> String {
    let (label, title) = (&lot.labels[unit], one.title());
    let shown = |value: f64| with_unit(value, 3, one.symbol);
    let value = found.row.value.unwrap_or_default();
    let is_odd = format!("{label} is odd: its {title} of {}", shown(value));
    if odd == Odd::Alone {
        let others = one.shown().filter(|(other, _)| *other != unit);
        let most = others.filter_map(|(_, other)| other.row.interval).map(|ends| ends[1]).fold(0.0, f64::max);
        let count = one.found.len() - 1;
        return format!(
            "{is_odd} is above the upper bounds of all {count} others, which are at most {}.",
            shown(most)
        );
    }
    let p = found.p.map(probability).unwrap_or_default();
    let (whom, median) = match (one.without_odd, one.pooled) {
        (Some(rest), _) => ("the others", rest.value),
        (None, all) => ("the lot", all.map_or(value, |all| all.value)),
    };
    let ratio = times(value / median, 3);
    let rest = one.without_odd.map_or_else(String::new, |rest| {
        format!(" Without odd units the median is {}, and {}.", shown(rest.value), spread(&rest))
    });
    format!("{is_odd} is {ratio} times the median of {whom} ({p}, counting {} tests).{rest}", lot.tests)
}

/// The spread of a lot, or its bound where the units are no farther apart than the errors of their records make them.
fn spread(pooled: &Pooled) -> String {
    let percent = |spread: f64| format!("{} %", significant(100.0 * spread, 2));
    if pooled.spread > 0.0 {
        format!("the spread is {}", percent(pooled.spread))
    } else {
        format!("no spread was found, at most {}", percent(pooled.spread_interval[1]))
    }
}

/// The units that are not pooled, and what that does to the values of the lot.
fn left_out(lot: &Lot, one: &Coefficient) -> Option<String> {
    let (shown, bounds) = (one.estimates().len(), one.bounds());
    if shown == 0 || shown == one.found.len() {
        return None;
    }
    let label = |unit: usize| lot.labels[unit].as_str();
    let mut left_out = Vec::new();
    if !bounds.is_empty() {
        let most = bounds.iter().map(|(_, most)| *most).fold(0.0, f64::max);
        let names: Vec<&str> = bounds.iter().map(|(unit, _)| label(*unit)).collect();
        left_out.push(format!("{} (at most {})", names.join(", "), with_unit(most, 3, one.symbol)));
    }
    let silent: Vec<&str> = one.silent().map(label).collect();
    if !silent.is_empty() {
        left_out.push(format!("{} (no bound)", silent.join(", ")));
    }
    let effect = match one.pooled {
        Some(_) if !bounds.is_empty() => {
            ". Median and spread are those of the units that show it; of the whole lot the median may be lower, and the spread larger"
        }
        _ => "",
    };
    Some(format!(
        "{}: {shown} of {} units show it; left out: {}{effect}.",
        one.title(),
        one.found.len(),
        listed(&left_out)
    ))
}
