//! A lot as sentences.

use crate::analysis::compare::words::{probability, times};
use crate::quantity::number::significant;

use crate::analysis::lot::{Coefficient, FALSE_ALARM, Found, Lot, Odd};

/// All sentences: the odd units, then the units that are not pooled.
pub fn sentences(lot: &Lot) -> Vec<String> {
    let odd = lot
        .coefficients
        .iter()
        .flat_map(|one| one.odd().map(|(unit, found, odd)| of_odd(lot, one, unit, found, odd)));
    let mut all: Vec<String> = odd.collect();
    if all.is_empty() {
        all.push(none(lot));
    }
    all.extend(lot.coefficients.iter().filter_map(|one| left_out(lot, one)));
    let (hidden, symbols) = hidden(lot);
    if hidden > 0 {
        all.push(format!("No unit shows {symbols}."));
    }
    all
}

fn none(lot: &Lot) -> String {
    match lot.tests {
        0 => "No test for an odd unit: it takes three units that show the same coefficient.".to_owned(),
        tests => format!(
            "No unit is odd in {tests} tests, which find one by chance in at most {} % of lots.",
            significant(100.0 * FALSE_ALARM, 2)
        ),
    }
}

fn of_odd(lot: &Lot, one: &Coefficient, unit: usize, found: &Found, odd: Odd) -> String {
    let (label, title) = (&lot.labels[unit], one.title());
    let shown = |value: f64| format!("{} {}", significant(value, 3), one.symbol).trim_end().to_owned();
    let value = found.row.value.unwrap_or_default();
    let p = found.p.map(probability).unwrap_or_default();
    let rest = one.without_odd.map_or_else(String::new, |rest| {
        let spread = significant(100.0 * rest.spread, 2);
        format!("; without odd units the lot has {} and a spread of {spread} %", shown(rest.value))
    });
    match odd {
        Odd::Alone => {
            let most = one.bounds().into_iter().map(|(_, most)| most).fold(0.0, f64::max);
            let count = one.found.len() - 1;
            format!(
                "{label} is odd: it has {title} of {}, above the bounds of the {count} others, at most {}.",
                shown(value),
                shown(most)
            )
        }
        Odd::Higher | Odd::Lower => {
            let of_others = one.without_odd.or(one.pooled).map_or(1.0, |lot| lot.value);
            format!(
                "{label} is odd: its {title} of {} is {} times that of the others ({p}, counting {} tests){rest}.",
                shown(value),
                times(value / of_others, 3),
                lot.tests
            )
        }
    }
}

/// The units that are not pooled, and what that does to the values of the lot.
fn left_out(lot: &Lot, one: &Coefficient) -> Option<String> {
    let shown = one.estimates().len();
    let (bounds, missing) = (one.bounds(), one.missing());
    if shown == 0 || bounds.is_empty() && missing == 0 {
        return None;
    }
    let title = one.title();
    let names = |units: &mut dyn Iterator<Item = usize>| {
        units.map(|unit| lot.labels[unit].as_str()).collect::<Vec<_>>().join(", ")
    };
    let most = bounds.iter().map(|(_, most)| *most).fold(0.0, f64::max);
    let bounded = (!bounds.is_empty()).then(|| {
        let most = format!("{} {}", significant(most, 3), one.symbol);
        format!("{} with at most {}", names(&mut bounds.iter().map(|(unit, _)| *unit)), most.trim_end())
    });
    let silent = (missing > 0).then(|| {
        let is_silent = |unit: &usize| match &one.found[*unit] {
            Some(found) => found.estimate().is_none() && found.bound().is_none(),
            None => true,
        };
        format!("{} without a bound", names(&mut (0..one.found.len()).filter(is_silent)))
    });
    let left_out: Vec<String> = [bounded, silent].into_iter().flatten().collect();
    let effect = match one.pooled {
        Some(_) if !bounds.is_empty() => {
            "; the values are those of units that show it, so the median is too high for the lot, and the spread too low"
        }
        _ => "",
    };
    Some(format!(
        "{title}: {shown} of {} units show it; left out are {}{effect}.",
        one.found.len(),
        left_out.join(", and ")
    ))
}

/// Number and names of the coefficients that no unit shows.
fn hidden(lot: &Lot) -> (usize, String) {
    let hidden: Vec<String> =
        lot.coefficients.iter().filter(|one| one.estimates().is_empty()).map(Coefficient::title).collect();
    (hidden.len(), hidden.join(", "))
}
