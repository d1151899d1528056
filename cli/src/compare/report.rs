//! Output of `sagnac compare` for people.

use sagnac::allan::deviation::Deviation;
use sagnac::analysis::compare::logs::{Analysis, Side};
use sagnac::analysis::compare::ratio::Ratio;
use sagnac::analysis::compare::rows::Row;
use sagnac::analysis::compare::words::{duration, length, probability, times};
use sagnac::quantity::number::significant;
use sagnac::table::titled;

use crate::shown::{THESE, shown};
use crate::terminal::{headed, number};

/// Both records, the ratios and the coefficients.
pub fn report(analysis: &Analysis) -> String {
    let [a, b] = &analysis.sides;
    let treatment = analysis.treatment();
    let mut text = format!("A  {}\nB  {}{}\n", heading(a), heading(b), treatment.left_out());
    text += &format!("{}\n", treatment.effect(analysis.shorter_s()));
    text += &shown(THESE, &analysis.events().concat());
    text += &format!("\n{}", ratios(analysis));
    text + &coefficients(analysis)
}

/// A heading such as `lgv1.csv: 32400 samples at 1 Hz, 9 h`.
pub fn heading(side: &Side) -> String {
    format!(
        "{}, {}: {} samples at {} Hz, {}",
        side.path.display(),
        side.column,
        side.samples,
        significant(1.0 / side.step_s, 7),
        duration(side.length_s())
    )
}

fn ratios(analysis: &Analysis) -> String {
    let [a, b] = &analysis.sides;
    let title = titled("overlapping Allan deviations", analysis.unit.symbol(Deviation::Oadev));
    let heading = ["τ, s", &a.label, &b.label, "ratio", "lower", "upper", ""];
    let line = |ratio: &Ratio| {
        let end = |k: usize| of_ratio(ratio.interval.map(|ends| ends[k]));
        let value = |k: usize| number(ratio.points[k].value, 5);
        let mark = match ratio.is_above() {
            Some(true) => "higher",
            Some(false) => "lower",
            None => "",
        };
        let tau = significant(ratio.tau_s(), 7);
        vec![tau, value(0), value(1), of_ratio(ratio.value), end(0), end(1), mark.to_owned()]
    };
    let all = &analysis.comparison.ratios;
    let apart = all.iter().filter(|ratio| ratio.is_above().is_some()).count();
    format!(
        "{title}, and the second over the first with 95 % interval\n{}  \
         at {apart} of {} averaging times the interval excludes 1, as it would at 1 in 20 for equal noise\n",
        headed(heading, all.iter().map(line)),
        all.len()
    )
}

fn of_ratio(ratio: Option<f64>) -> String {
    ratio.map_or_else(String::new, |ratio| times(ratio, 4))
}

/// The coefficients, one per line.
fn coefficients(analysis: &Analysis) -> String {
    let Ok(rows) = &analysis.rows else { return String::new() };
    if rows.is_empty() {
        return String::new();
    }
    let [a, b] = [&analysis.sides[0].label, &analysis.sides[1].label];
    let heading = ["", "", a, b, "ratio", "lower", "upper", "difference", "lower", "upper", "p", "length"];
    let line = |row: &Row| {
        let found = &row.found;
        let value = |k: usize| match (found.values[k], found.at_most[k]) {
            (None, Some(most)) => format!("< {}", significant(most, 3)),
            (value, _) => number(value, 4),
        };
        let p = found.p.map_or_else(String::new, |p| probability(p).replace("p ", "").replace("= ", ""));
        let [ratio, lower, upper] =
            [found.ratio, found.ratio_interval[0], found.ratio_interval[1]].map(of_ratio);
        let difference = [found.difference, found.interval[0], found.interval[1]].map(|x| number(x, 4));
        let named = [row.name.to_owned(), row.symbol.to_owned(), value(0), value(1), ratio, lower, upper];
        named.into_iter().chain(difference).chain([p, length(row.length)]).collect()
    };
    format!(
        "\ncoefficients of both curves up to an eighth of each record, with 95 % intervals\n{}  \
         length: of records that resolve such a difference with 90 % power\n",
        headed(heading, rows.iter().map(line))
    )
}
