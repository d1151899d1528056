//! Output of `sagnac allan` for people.

use sagnac::allan::curve::{Minimum, Point};
use sagnac::allan::noise::LEAST_GROUPS;
use sagnac::allan::trend::Trend;
use sagnac::allan::unit::Unit;
use sagnac::analysis::data_sheet::Row;
use sagnac::analysis::log::notes::heading;
use sagnac::analysis::log::{Analysis, Column, Curve, events};
use sagnac::fit::coefficient::Fit;
use sagnac::quantity::number::significant;
use sagnac::table::titled;

use crate::allan::axes;
use crate::shown::{THIS, shown};
use crate::terminal::{WITH_INTERVAL, headed, with_interval, with_its_interval};

/// Most lines of a curve; of longer curves every second, third, … point is shown.
pub(super) const MOST_LINES: usize = 48;

/// The curves and coefficients of a column, or tables over several columns, with the treatment of the data.
pub fn report(analysis: &Analysis) -> String {
    let mut text = format!("{}{}\n", heading(analysis), analysis.treatment.left_out());
    text += &format!("{}\n", analysis.treatment.effect(analysis.length_s()));
    text += &shown(THIS, &events::rows(analysis));
    let [column] = &analysis.columns[..] else {
        return text + &analysis.units().map(|unit| axes::report(analysis, unit)).collect::<String>();
    };
    for curve in &column.curves {
        text += &format!("\n{}\n", of_curve(analysis, column, curve));
    }
    text + &coefficients(column)
}

fn of_curve(analysis: &Analysis, column: &Column, curve: &Curve) -> String {
    let title = titled(curve.deviation.title(), column.unit.symbol(curve.deviation));
    let mut text = format!("{}: {title}, with {} intervals", column.name, analysis.percent());
    if analysis.treatment.trend == Trend::Linear {
        let (slope, unit) = removed(column);
        text += &format!("; a trend of {slope} {unit} was removed");
    }
    let heading = ["τ, s", "differences", curve.deviation.name(), "lower", "upper", "α", "noise"];
    let step = curve.points.len().div_ceil(MOST_LINES).max(1);
    text += &format!(
        "\n{}",
        headed(heading, curve.points.iter().step_by(step).map(|point| line(point, column.unit)))
    );
    if step > 1 {
        text += &format!("  one in {step} of the {} times; curve.csv has all of them\n", curve.points.len());
    }
    if curve.points.iter().any(|point| point.noise.is_some_and(|noise| noise.carried)) {
        text += &format!("  * fewer than {LEAST_GROUPS} groups: noise type of a shorter τ\n");
    }
    text + &stability(curve, column.unit)
}

/// The coefficients of a column, one per line.
fn coefficients(column: &Column) -> String {
    let Some(noise) = column.noise() else { return String::new() };
    let line = |row: &Row| with_interval(row.name, row.value, row.interval, row.symbol, row.verdict);
    format!(
        "{}: coefficients of the overlapping Allan curve {}, with 95 % intervals {}\n{}",
        column.name,
        range(&noise.fit),
        noise.intervals.words(),
        headed(WITH_INTERVAL, noise.rows.iter().map(line))
    )
}

/// The τ of a fit in words.
fn range(fit: &Fit) -> String {
    let [from, to] = fit.tau_range.map(|tau_s| significant(tau_s, 6));
    format!("from τ = {from} s to {to} s")
}

/// The slope that was removed, with its unit.
pub(super) fn removed(column: &Column) -> (String, &'static str) {
    let (factor, unit) = match column.unit {
        Unit::Angular => (3600.0, "°/h/h"),
        Unit::Acceleration => (3600.0, "µg/h"),
        Unit::Plain => (1.0, "1/s"),
    };
    (significant(factor * column.slope, 4), unit)
}

fn line(point: &Point, unit: Unit) -> Vec<String> {
    let (alpha, name) = point.noise.map_or_else(Default::default, |noise| {
        let mark = if noise.carried { "*" } else { "" };
        (format!("{}{mark}", noise.alpha), noise.name(unit).to_owned())
    });
    let [value, lower, upper] = with_its_interval(point.value, point.interval.map(Into::into), 5);
    vec![significant(point.tau_s, 7), point.terms.to_string(), value, lower, upper, alpha, name]
}

/// The minimum of a curve, and whether the curve ends there.
fn stability(curve: &Curve, unit: Unit) -> String {
    let Some(Minimum { point, at_end }) = curve.minimum else { return String::new() };
    let [value, lower, upper] = with_its_interval(point.value, point.interval.map(Into::into), 4);
    let interval = point.interval.map_or_else(String::new, |_| format!(" ({lower} … {upper})"));
    let found = format!("{value}{interval} {}", unit.symbol(curve.deviation));
    let end = if at_end { "; the curve ends there, and a longer record may show a lower one" } else { "" };
    format!(
        "  in-run bias stability, the minimum: {} at τ = {} s{end}\n",
        found.trim_end(),
        significant(point.tau_s, 7)
    )
}
