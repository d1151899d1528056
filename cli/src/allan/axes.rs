//! Output of `sagnac allan` for people where there are several columns: tables whose columns are the axes of a sensor.

use sagnac::allan::curve::Minimum;
use sagnac::allan::trend::Trend;
use sagnac::allan::unit::Unit;
use sagnac::analysis::data_sheet::{Row, each_once};
use sagnac::analysis::log::{Analysis, Column, Curve};
use sagnac::quantity::number::significant;
use sagnac::table::titled;

use crate::allan::report::{MOST_LINES, removed};
use crate::terminal::{aligned, number, row};

/// The deviations and the coefficients of all columns of a unit.
pub fn report(analysis: &Analysis, unit: Unit) -> String {
    let columns: Vec<&Column> = analysis.of_unit(unit).collect();
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    let curves = columns.first().map_or(0, |column| column.curves.len());
    let deviations = (0..curves).map(|at| {
        let curves: Vec<&Curve> = columns.iter().map(|column| &column.curves[at]).collect();
        deviations(&names, &curves, unit)
    });
    deviations.collect::<String>() + &coefficients(analysis, &names, &columns)
}

/// A deviation of all columns over τ, and its minimum.
fn deviations(names: &[&str], curves: &[&Curve], unit: Unit) -> String {
    let Curve { deviation, points, .. } = curves[0];
    let mut table = vec![row("τ", "s", names, |name| (*name).to_owned())];
    let step = points.len().div_ceil(MOST_LINES).max(1);
    table.extend((0..points.len()).step_by(step).map(|at| {
        row(&significant(points[at].tau_s, 7), "", curves, |curve| number(curve.points[at].value, 4))
    }));
    let minima: Vec<Option<Minimum>> = curves.iter().map(|curve| curve.minimum).collect();
    if minima.iter().any(Option::is_some) {
        table.push(row("minimum", "", &minima, |minimum| {
            minimum.map_or_else(String::new, |Minimum { point, at_end }| {
                number(point.value, 4) + if at_end { "*" } else { "" }
            })
        }));
        let tau = |minimum: &Option<Minimum>| number(minimum.map(|minimum| minimum.point.tau_s), 7);
        table.push(row("at τ", "s", &minima, tau));
    }
    let mut text = format!(
        "\n{}: {}; the minimum is the in-run bias stability, and curve.csv has the intervals\n{}",
        names.join(", "),
        titled(deviation.title(), unit.symbol(*deviation)),
        aligned(&table)
    );
    if step > 1 {
        text += &format!("  one in {step} of the {} times; curve.csv has all of them\n", points.len());
    }
    if minima.iter().flatten().any(|minimum| minimum.at_end) {
        text += "  * the curve ends there, and a longer record may show a lower one\n";
    }
    text
}

/// The coefficients of all columns, with their verdicts; empty where none were fitted.
fn coefficients(analysis: &Analysis, names: &[&str], columns: &[&Column]) -> String {
    let rows = each_once(columns.iter().flat_map(|column| column.coefficients()));
    if rows.is_empty() {
        return String::new();
    }
    let mut table = vec![row("", "", names, |name| (*name).to_owned())];
    table.extend(rows.iter().map(|Row { name, symbol, .. }| {
        row(name, symbol, columns, |column| {
            let found = column.coefficients().iter().find(|other| other.name == *name);
            let is_described = column.noise().is_some_and(|noise| noise.fit.is_described());
            found.map_or_else(String::new, |found| cell(found, is_described))
        })
    }));
    let ends = ["fit from τ", "to τ"].into_iter().enumerate();
    table.extend(ends.map(|(end, name)| {
        row(name, "s", columns, |column| number(column.noise().map(|noise| noise.fit.tau_range[end]), 6))
    }));
    if analysis.treatment.trend == Trend::Linear {
        let (_, unit) = removed(columns[0]);
        table.push(row("removed trend", unit, columns, |column| removed(column).0));
    }
    format!(
        "\n{}: coefficients of the overlapping Allan curves; coefficients.csv has the 95 % intervals\n{}  ≤: not identified, at \
         most the upper end of its interval\n",
        names.join(", "),
        aligned(&table)
    )
}

/// A coefficient with its verdict: a value alone is identified.
fn cell(row: &Row, is_described: bool) -> String {
    match (row.value, row.interval) {
        (Some(value), _) if is_described => significant(value, 4),
        (Some(value), _) => format!("{} {}", significant(value, 4), row.verdict),
        (None, Some([_, most])) => format!("≤ {}", significant(most, 4)),
        (None, None) => row.verdict.to_owned(),
    }
}
