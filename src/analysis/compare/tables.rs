//! The results of `sagnac compare` as tables and as JSON.

use crate::allan::{Deviation, Point};
use crate::analysis::compare::{Length, Ratio};
use crate::table::column::{columns_of, object};
use crate::table::{Cell, ColumnOf, Role, Table, Unit};
use serde_json::{Value, json};

use crate::analysis::compare::logs::{Analysis, Side};
use crate::analysis::compare::rows::Row;
use crate::analysis::log::events;
use crate::analysis::log::tables::text;
use crate::analysis::requirement::Decision;

/// A row of `compare.csv`.
pub(crate) struct RatioRow<'a> {
    ratio: &'a Ratio,
    unit: &'a str,
}

/// The columns of `compare.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn ratio_columns<'a>() -> Vec<ColumnOf<RatioRow<'a>>> {
    type Of<'a> = ColumnOf<RatioRow<'a>>;
    vec![
        Of::new("tau", Unit::S, "tau", |row| Cell::Number(row.ratio.tau_s()))
            .is(Role::Coordinate, "Averaging time τ, s."),
        Of::new("m_a", Unit::NONE, "m_a", |row| Cell::Integer(row.ratio.points[0].m as i64))
            .is(Role::Count, "Averaging time in samples of A."),
        Of::new("m_b", Unit::NONE, "m_b", |row| Cell::Integer(row.ratio.points[1].m as i64))
            .is(Role::Count, "Averaging time in samples of B."),
        Of::new("a", Unit::NONE, "a", |row| row.ratio.points[0].value.into())
            .is(Role::Error, "Overlapping Allan deviation of A, in `unit`."),
        Of::new("b", Unit::NONE, "b", |row| row.ratio.points[1].value.into())
            .is(Role::Error, "Overlapping Allan deviation of B, in `unit`."),
        Of::new("ratio", Unit::NONE, "ratio", |row| row.ratio.value.into())
            .is(Role::Estimate, "Value of B divided by that of A."),
        Of::new("lower", Unit::NONE, "lower", |row| row.ratio.interval.map(|ends| ends[0]).into())
            .is_of("ratio", Role::Lower, "Lower end of the 95 % interval of `ratio`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.ratio.interval.map(|ends| ends[1]).into())
            .is_of("ratio", Role::Upper, "Upper end of the 95 % interval of `ratio`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.unit))
            .is(Role::Note, "Unit of `a` and `b`."),
        Of::new("p", Unit::NONE, "p", |row| row.ratio.p.into())
            .is(Role::Estimate, "Probability that a ratio is at least as far from 1 by chance if both have the same noise."),
        Of::new("status", Unit::NONE, "status", |row| text(verdict(row.ratio)))
            .is(Role::Note, "`B higher`, `B lower` or `consistent`, at 95 %."),
    ]
}

/// The table of all ratios, `compare.csv`.
pub fn ratios(analysis: &Analysis) -> Table {
    let unit = &analysis.unit.in_files(Deviation::Oadev);
    let rows: Vec<RatioRow> =
        analysis.comparison.ratios.iter().map(|ratio| RatioRow { ratio, unit }).collect();
    Table { columns: columns_of(&ratio_columns(), &rows) }
}

/// The columns of `coefficients.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn coefficient_columns<'a>() -> Vec<ColumnOf<&'a Row>> {
    type Of<'a> = ColumnOf<&'a Row>;
    vec![
        Of::new("coefficient", Unit::NONE, "coefficient", |row| text(row.name))
            .is(Role::Key, "Q, N, B, K, R of data sheets, `markov`, `markov_time`, `sine`, `sine_frequency`, L."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.unit))
            .is(Role::Note, "Unit of `a`, `b` and `difference`."),
        Of::new("a", Unit::NONE, "a", |row| row.found.values[0].into())
            .is(Role::Estimate, "The coefficient of A; blank where its record does not show it."),
        Of::new("b", Unit::NONE, "b", |row| row.found.values[1].into())
            .is(Role::Estimate, "The coefficient of B; blank where its record does not show it."),
        Of::new("difference", Unit::NONE, "difference", |row| row.found.difference.into())
            .is(Role::Estimate, "Value of B minus that of A."),
        Of::new("lower", Unit::NONE, "lower", |row| row.found.interval[0].into())
            .is_of("difference", Role::Lower, "Lower end of the 95 % interval of `difference`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.found.interval[1].into())
            .is_of("difference", Role::Upper, "Upper end of the 95 % interval of `difference`."),
        Of::new("p", Unit::NONE, "p", |row| row.found.p.into())
            .is(Role::Estimate, "Probability that a difference is at least as large by chance if both have the same coefficient."),
        Of::new("length_needed", Unit::S, "length_needed", |row| needed(row.length).into())
            .is(Role::Estimate, "Length of records, s, that resolves such a difference with 90 % power."),
        Of::new("status", Unit::NONE, "status", |row| text(row.verdict().name()))
            .is(Role::Note, "`B higher`, `B lower`, `consistent`, `equal`, `in neither record`, or `not compared` if an event of a record explains it as well."),
        Of::new("ratio", Unit::NONE, "ratio", |row| row.found.ratio.into())
            .is(Role::Estimate, "Value of B divided by that of A."),
        Of::new("ratio_lower", Unit::NONE, "ratio_lower", |row| row.found.ratio_interval[0].into())
            .is_of("ratio", Role::Lower, "Lower end of the 95 % interval of `ratio`."),
        Of::new("ratio_upper", Unit::NONE, "ratio_upper", |row| row.found.ratio_interval[1].into())
            .is_of("ratio", Role::Upper, "Upper end of the 95 % interval of `ratio`."),
        Of::new("a_at_most", Unit::NONE, "a_at_most", |row| row.found.at_most[0].into())
            .is(Role::Estimate, "Upper bound on the coefficient of A, if its record does not show it."),
        Of::new("b_at_most", Unit::NONE, "b_at_most", |row| row.found.at_most[1].into())
            .is(Role::Estimate, "Upper bound on the coefficient of B, if its record does not show it."),
        Of::new("length_beyond", Unit::S, "length_beyond", |row| beyond(row.length).into())
            .is(Role::Estimate, "Length of records, s, up to which none was found that would distinguish such values."),
        Of::new("described", Unit::NONE, "described", |row| text(described(row.described)))
            .is(Role::Note, "Whose curve the fit describes: `both`, `A`, `B` or `neither`; the coefficients of the others were forced."),
    ]
}

/// The table of all coefficients, `coefficients.csv`.
pub fn coefficients(analysis: &Analysis) -> Table {
    let rows: Vec<&Row> = analysis.rows.iter().flatten().collect();
    Table { columns: columns_of(&coefficient_columns(), &rows) }
}

fn verdict(ratio: &Ratio) -> &'static str {
    match ratio.is_above() {
        Some(true) => "B higher",
        Some(false) => "B lower",
        None if ratio.interval.is_some() => "consistent",
        None => "",
    }
}

fn described(of: [bool; 2]) -> &'static str {
    match of {
        [true, true] => "both",
        [true, false] => "A",
        [false, true] => "B",
        [false, false] => "neither",
    }
}

fn needed(length: Length) -> Option<f64> {
    if let Length::Needed(length_s) = length { Some(length_s) } else { None }
}

/// The length up to which none was found to suffice.
fn beyond(length: Length) -> Option<f64> {
    if let Length::Beyond(length_s) = length { Some(length_s) } else { None }
}

/// The complete comparison as JSON, with the decision to which it leads.
pub fn document(analysis: &Analysis, decision: &Decision) -> Value {
    let comparison = &analysis.comparison;
    let [a, b] = &analysis.sides;
    let [of_a, of_b] = analysis.events();
    let same = comparison.same.map(|same| {
        let by = if same.chi_squared.is_some() { "chi_squared" } else { "least_p" };
        json!({ "p": same.p, "times": same.times, "shortest_s": same.shortest_s, "longest_s": same.longest_s, "by": by, "chi_squared": same.chi_squared })
    });
    json!({
        "a": of_side(a, &of_a, &comparison.curves[0]),
        "b": of_side(b, &of_b, &comparison.curves[1]),
        "one_record": analysis.is_one_record,
        "treatment": analysis.treatment().summary(),
        "unit": analysis.unit.in_files(Deviation::Oadev),
        "times_left_out": comparison.common.left_out,
        "times_apart": comparison.common.farthest,
        "ratios": comparison.ratios.iter().map(of_ratio).collect::<Vec<_>>(),
        "same_noise": same,
        "coefficients": analysis.rows.iter().flatten().map(of_row).collect::<Vec<_>>(),
        "coefficients_missing": analysis.rows.as_ref().err(),
        "described": described(comparison.described()),
        "answer": decision.answer,
        "decision": decision.json(),
    })
}

fn of_side(side: &Side, events: &[events::Row], curve: &[Point]) -> Value {
    let points: Vec<Value> = curve.iter().map(of_point).collect();
    json!({
        "file": side.path.display().to_string(),
        "column": side.column,
        "label": side.label,
        "data": side.data.name(),
        "samples": side.samples,
        "step_s": side.step_s,
        "length_s": side.length_s(),
        "missing": side.missing,
        "reading": side.reading,
        "outliers": side.outliers.samples.len(),
        "events": events::document(events),
        "points": points,
    })
}

fn of_point(point: &Point) -> Value {
    json!({
        "m": point.m,
        "tau_s": point.tau_s,
        "differences": point.terms,
        "edf": point.edf,
        "lower": point.interval.map(|ends| ends.0),
        "value": point.value,
        "upper": point.interval.map(|ends| ends.1),
    })
}

fn of_ratio(ratio: &Ratio) -> Value {
    let [a, b] = &ratio.points;
    json!({
        "tau_s": ratio.tau_s(),
        "m_a": a.m,
        "m_b": b.m,
        "a": a.value,
        "b": b.value,
        "edf_a": a.edf,
        "edf_b": b.edf,
        "ratio": ratio.value,
        "lower": ratio.interval.map(|ends| ends[0]),
        "upper": ratio.interval.map(|ends| ends[1]),
        "p": ratio.p,
        "status": verdict(ratio),
    })
}

fn of_row(row: &Row) -> Value {
    let mut document = object(&coefficient_columns(), &row, &["described"]);
    // Plain numbers have an empty unit.
    document["unit"] = json!(row.unit);
    document
}
