//! The results of `sagnac compare` as tables and as JSON.

use crate::allan::curve::Point;
use crate::allan::deviation::Deviation;
use crate::analysis::compare::length::Length;
use crate::analysis::compare::ratio::Ratio;
use crate::analysis::compare::same::By;
use crate::table::{Cell, Column, Table, Unit};
use serde_json::{Value, json};

use crate::analysis::compare::logs::{Analysis, Side};
use crate::analysis::compare::rows::Row;
use crate::analysis::compare::words::sentences;

/// Every ratio: `compare.csv`.
pub fn ratios(analysis: &Analysis) -> Table {
    let unit = text(analysis.unit.in_files(Deviation::Oadev));
    let column = |name: &str, unit: Unit, cell: &dyn Fn(&Ratio) -> Cell| Column {
        name: name.to_owned(),
        label: name.to_owned(),
        unit,
        cells: analysis.comparison.ratios.iter().map(cell).collect(),
        ..Column::default()
    };
    let none = Unit::NONE;
    Table {
        columns: vec![
            column("tau", Unit::S, &|ratio| Cell::Number(ratio.tau_s())),
            column("m_a", none, &|ratio| Cell::Integer(ratio.points[0].m as i64)),
            column("m_b", none, &|ratio| Cell::Integer(ratio.points[1].m as i64)),
            column("a", none, &|ratio| ratio.points[0].value.into()),
            column("b", none, &|ratio| ratio.points[1].value.into()),
            column("ratio", none, &|ratio| ratio.value.into()),
            column("lower", none, &|ratio| ratio.interval.map(|ends| ends[0]).into()),
            column("upper", none, &|ratio| ratio.interval.map(|ends| ends[1]).into()),
            column("unit", none, &|_| unit.clone()),
            column("p", none, &|ratio| ratio.p.into()),
            column("verdict", none, &|ratio| text(verdict(ratio))),
        ],
    }
}

/// Every coefficient: `coefficients.csv`.
pub fn coefficients(analysis: &Analysis) -> Table {
    let rows: Vec<&Row> = analysis.rows.iter().flatten().collect();
    let column = |name: &str, unit: Unit, cell: &dyn Fn(&Row) -> Cell| Column {
        name: name.to_owned(),
        label: name.to_owned(),
        unit,
        cells: rows.iter().map(|row| cell(row)).collect(),
        ..Column::default()
    };
    let none = Unit::NONE;
    Table {
        columns: vec![
            column("coefficient", none, &|row| text(row.name)),
            column("unit", none, &|row| text(row.unit)),
            column("a", none, &|row| row.found.values[0].into()),
            column("b", none, &|row| row.found.values[1].into()),
            column("difference", none, &|row| row.found.difference.into()),
            column("lower", none, &|row| row.found.interval[0].into()),
            column("upper", none, &|row| row.found.interval[1].into()),
            column("p", none, &|row| row.found.p.into()),
            column("length_needed", Unit::S, &|row| needed(row.length).into()),
            column("verdict", none, &|row| text(row.verdict().name())),
            column("ratio", none, &|row| row.found.ratio.into()),
            column("ratio_lower", none, &|row| row.found.ratio_interval[0].into()),
            column("ratio_upper", none, &|row| row.found.ratio_interval[1].into()),
            column("a_at_most", none, &|row| row.found.at_most[0].into()),
            column("b_at_most", none, &|row| row.found.at_most[1].into()),
            column("length_beyond", Unit::S, &|row| beyond(row.length).into()),
        ],
    }
}

fn text(text: &str) -> Cell {
    if text.is_empty() { Cell::Blank } else { Cell::Text(text.to_owned()) }
}

fn verdict(ratio: &Ratio) -> &'static str {
    match ratio.is_above() {
        Some(true) => "B higher",
        Some(false) => "B lower",
        None if ratio.interval.is_some() => "not told apart",
        None => "",
    }
}

fn needed(length: Length) -> Option<f64> {
    if let Length::Needed { length_s } = length { Some(length_s) } else { None }
}

/// The length up to which none was found.
fn beyond(length: Length) -> Option<f64> {
    if let Length::Beyond { length_s } = length { Some(length_s) } else { None }
}

/// Everything, for programs.
pub fn document(analysis: &Analysis) -> Value {
    let comparison = &analysis.comparison;
    let [a, b] = &analysis.sides;
    let same = comparison.same.map(|same| {
        let (by, chi_squared) = match same.by {
            By::ChiSquared { value } => ("chi_squared", Some(value)),
            By::LeastP => ("least_p", None),
        };
        json!({ "p": same.p, "times": same.times, "longest_s": same.longest_s, "by": by, "chi_squared": chi_squared })
    });
    json!({
        "a": of_side(a, &comparison.curves[0]),
        "b": of_side(b, &comparison.curves[1]),
        "one_record": analysis.is_one_record,
        "treatment": analysis.treatment().summary(),
        "unit": analysis.unit.in_files(Deviation::Oadev),
        "times_left_out": comparison.common.left_out,
        "times_apart": comparison.common.farthest,
        "ratios": comparison.ratios.iter().map(of_ratio).collect::<Vec<_>>(),
        "same_noise": same,
        "coefficients": analysis.rows.iter().flatten().map(of_row).collect::<Vec<_>>(),
        "coefficients_missing": analysis.rows.as_ref().err(),
        "sentences": sentences(analysis),
    })
}

fn of_side(side: &Side, curve: &[Point]) -> Value {
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
        "outliers": side.outliers.samples.len(),
        "points": points,
    })
}

fn of_point(point: &Point) -> Value {
    json!({
        "m": point.m,
        "tau_s": point.tau_s,
        "terms": point.terms,
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
        "verdict": verdict(ratio),
    })
}

fn of_row(row: &Row) -> Value {
    let found = &row.found;
    json!({
        "coefficient": row.name,
        "unit": row.unit,
        "a": found.values[0],
        "b": found.values[1],
        "a_at_most": found.at_most[0],
        "b_at_most": found.at_most[1],
        "difference": found.difference,
        "lower": found.interval[0],
        "upper": found.interval[1],
        "ratio": found.ratio,
        "ratio_lower": found.ratio_interval[0],
        "ratio_upper": found.ratio_interval[1],
        "p": found.p,
        "length_needed_s": needed(row.length),
        "length_beyond_s": beyond(row.length),
        "verdict": row.verdict().name(),
    })
}
