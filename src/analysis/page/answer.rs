//! The answer of a log: its noise, in a sentence for each column.

use crate::allan::{Deviation, Minimum};
use crate::analysis::data_sheet::{DataSheet, Row};
use crate::analysis::log::{self, Column};
use crate::analysis::spectrum::{Analysis, Spectrum};
use crate::fit::Fit;
use crate::quantity::number::significant;
use crate::spectrum::Line;
use crate::theory::allan::Term;

/// Significant digits of values.
const DIGITS: usize = 4;

/// The noise of a single column, or how many of several are described.
pub(crate) fn headline(noise: &log::Analysis) -> String {
    if let [column] = &noise.columns[..] {
        return of_column(column);
    }
    let is_described = |column: &&Column| column.noise().is_some_and(|noise| noise.fit.is_described());
    let (described, others): (Vec<&Column>, Vec<&Column>) = noise.columns.iter().partition(is_described);
    let all = noise.columns.len();
    match &others[..] {
        [] => format!("Noise coefficients describe all {all} columns."),
        _ if described.is_empty() => format!("Noise coefficients describe none of {all} columns."),
        others => {
            let names: Vec<&str> = others.iter().map(|column| &*column.name).collect();
            format!(
                "Noise coefficients describe {} of {all} columns; not {}.",
                described.len(),
                names.join(", ")
            )
        }
    }
}

/// A sentence for each of several columns, and for each column with lines.
pub(crate) fn sentences(analysis: &Analysis) -> Vec<String> {
    let columns = &analysis.noise.columns;
    let each = columns.iter().filter(|_| columns.len() > 1).map(of_column);
    each.chain(analysis.columns().filter_map(|(column, spectrum)| lines(column, spectrum))).collect()
}

fn of_column(column: &Column) -> String {
    let said = match &column.noise {
        Err(why) => format!("no coefficients: {why}"),
        Ok(None) => stability(column).map_or_else(
            || "no coefficients were requested".to_owned(),
            |least| format!("in-run stability {least}"),
        ),
        Ok(Some(noise)) => of_noise(noise),
    };
    format!("{}: {said}.", column.name)
}

/// The coefficients of a record in words, such as `N = 0.2 °/√h (0.199 … 0.201)`, with those that are not identified.
pub fn of_noise(noise: &DataSheet) -> String {
    let found: Vec<String> = noise.rows.iter().filter_map(value).collect();
    let missing: Vec<String> = noise.rows.iter().filter(|row| row.value.is_none()).map(bound).collect();
    let range = range(&noise.fit);
    match (noise.fit.is_described(), &found[..], &missing[..]) {
        (false, [], _) => {
            "not described: no range of τ follows the terms of the fit, so there are no coefficients"
                .to_owned()
        }
        (false, found, _) => format!("not described; the best fit all the same: {}", found.join(", ")),
        (true, [], missing) => format!("no coefficient is identified: {}", missing.join(", ")),
        (true, found, []) => format!("{} ({range})", found.join(", ")),
        (true, found, missing) => {
            format!("{} ({range}); not identified: {}", found.join(", "), missing.join(", "))
        }
    }
}

/// The range of a fit.
pub(crate) fn range(fit: &Fit) -> String {
    let [from, to] = fit.tau_range.map(|tau_s| significant(tau_s, DIGITS));
    format!("τ from {from} s to {to} s")
}

/// An identified coefficient, such as `N = 0.2 °/√h (0.199 … 0.201)`.
fn value(row: &Row) -> Option<String> {
    Some(format!("{} = {}", row.name, measured(row.value?, row.interval, row.symbol)))
}

/// A value with its interval, such as `0.2 °/√h (0.199 … 0.201)`.
fn measured(value: f64, ends: Option<[f64; 2]>, unit: &str) -> String {
    in_unit(value, unit) + &ends.map(|ends| format!(" ({})", interval(ends))).unwrap_or_default()
}

/// An interval such as `0.199 … 0.201`.
pub(crate) fn interval(ends: [f64; 2]) -> String {
    ends.map(|end| significant(end, DIGITS)).join(" … ")
}

/// A value with its unit, if it has one.
pub(crate) fn in_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", significant(value, DIGITS)).trim_end().to_owned()
}

/// A coefficient without a value; that of N and of B, on which data sheets are compared, with its bound.
fn bound(row: &Row) -> String {
    let is_asked =
        [Term::AngleRandomWalk, Term::BiasInstability].iter().any(|term| term.symbol() == row.name);
    match row.interval.filter(|_| is_asked) {
        Some([_, most]) => format!("{} (at most {})", row.name, in_unit(most, row.symbol)),
        None => row.name.to_owned(),
    }
}

/// The minimum of the first curve of rates, such as `0.01 °/h (0.009 … 0.012) at τ = 100 s`.
pub(crate) fn stability(column: &Column) -> Option<String> {
    let curve = column.curves.iter().find(|curve| !curve.deviation.is_of_angle())?;
    let Minimum { point, at_end } = curve.minimum?;
    let minimum = measured(point.value?, point.interval.map(Into::into), column.unit.symbol(curve.deviation));
    let end = if at_end { ", where the curve ends" } else { "" };
    Some(format!("{minimum} at τ = {} s{end}", significant(point.tau_s, DIGITS)))
}

/// The lines of a column, such as `a line of 0.3 °/h at 20 Hz`.
fn lines(column: &Column, spectrum: &Spectrum) -> Option<String> {
    /// Most lines that are named.
    const MOST: usize = 5;
    let unit = column.unit.symbol(Deviation::Oadev);
    let line = |line: &Line| {
        format!("{} at {} Hz", in_unit(line.amplitude, unit), significant(line.frequency_hz, 5))
    };
    let count = spectrum.lines.len();
    let named: Vec<String> = spectrum.lines.iter().take(MOST).map(line).collect();
    let named = format!("{}{}", named.join(", "), if count > MOST { ", …" } else { "" });
    match count {
        0 => None,
        1 => Some(format!("{}: a line of {named}.", column.name)),
        _ => Some(format!("{}: {count} lines, of {named}.", column.name)),
    }
}
