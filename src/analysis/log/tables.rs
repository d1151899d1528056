//! The results of `sagnac allan` as a table and as JSON.

use crate::allan::curve::Point;
use crate::allan::deviation::Deviation;
use crate::allan::trend::Trend;
use crate::fit::noise::Row;
use crate::table::{Cell, Column, Table, Unit};
use serde_json::{Value, json};

use crate::analysis::log::{self, Analysis, Curve};

/// All curves, one row for each deviation and τ: `curve.csv`.
pub fn table(analysis: &Analysis) -> Table {
    let rows: Vec<(&log::Column, &Curve, &Point)> = analysis
        .columns
        .iter()
        .flat_map(|column| column.curves.iter().map(move |curve| (column, curve)))
        .flat_map(|(column, curve)| curve.points.iter().map(move |point| (column, curve, point)))
        .collect();
    let treatment = analysis.treatment.summary();
    let text = |text: &str| if text.is_empty() { Cell::Blank } else { Cell::Text(text.to_owned()) };
    let column = |name: &str, unit: Unit, cell: &dyn Fn(&log::Column, &Curve, &Point) -> Cell| Column {
        name: name.to_owned(),
        label: name.to_owned(),
        unit,
        cells: rows.iter().map(|(column, curve, point)| cell(column, curve, point)).collect(),
        ..Column::default()
    };
    let none = Unit::NONE;
    Table {
        columns: vec![
            column("column", none, &|column, _, _| text(&column.name)),
            column("deviation", none, &|_, curve, _| text(curve.deviation.name())),
            column("m", none, &|_, _, point| Cell::Integer(point.m as i64)),
            column("tau", Unit::S, &|_, _, point| Cell::Number(point.tau_s)),
            column("terms", none, &|_, _, point| Cell::Integer(point.terms as i64)),
            column("alpha", none, &|_, _, point| {
                point.noise.map_or(Cell::Blank, |noise| Cell::Integer(noise.alpha.into()))
            }),
            column("lower", none, &|_, _, point| Cell::from(point.interval.map(|ends| ends.0))),
            column("value", none, &|_, _, point| Cell::from(point.value)),
            column("upper", none, &|_, _, point| Cell::from(point.interval.map(|ends| ends.1))),
            column("unit", none, &|column, curve, _| text(column.unit.in_files(curve.deviation))),
            column("alpha_from", none, &|_, _, point| text(alpha_from(point))),
            column("treatment", none, &|_, _, _| text(&treatment)),
        ],
    }
}

/// A row of `coefficients.csv`.
struct Line<'a> {
    column: &'a str,
    row: Row,
    intervals: String,
}

/// The coefficients of a column and the minimum of its curve.
fn lines(column: &log::Column) -> Vec<Line<'_>> {
    let line = |row: &Row, intervals: &str| Line {
        column: &column.name,
        row: row.clone(),
        intervals: intervals.to_owned(),
    };
    let name = column.noise().map_or_else(String::new, |noise| noise.intervals.name());
    let found = column.coefficients().iter().map(|row| line(row, &name));
    found.chain(stability(column).iter().map(|row| line(row, "of the curve"))).collect()
}

/// The coefficients of all columns, and of each the minimum of its curve: `coefficients.csv`.
pub fn coefficients(analysis: &Analysis) -> Table {
    let lines: Vec<Line> = analysis.columns.iter().flat_map(lines).collect();
    let text = |text: &str| if text.is_empty() { Cell::Blank } else { Cell::Text(text.to_owned()) };
    let column = |name: &str, cell: &dyn Fn(&Line) -> Cell| Column {
        name: name.to_owned(),
        label: name.to_owned(),
        unit: Unit::NONE,
        cells: lines.iter().map(cell).collect(),
        ..Column::default()
    };
    Table {
        columns: vec![
            column("column", &|line| text(line.column)),
            column("coefficient", &|line| text(line.row.name)),
            column("value", &|line| line.row.value.into()),
            column("lower", &|line| line.row.interval.map(|ends| ends[0]).into()),
            column("upper", &|line| line.row.interval.map(|ends| ends[1]).into()),
            column("unit", &|line| text(line.row.unit)),
            column("verdict", &|line| text(line.row.verdict)),
            column("intervals", &|line| text(&line.intervals)),
        ],
    }
}

/// The minimum of the first curve that has one, as a row of its own: the in-run stability of data sheets, not B.
fn stability(column: &log::Column) -> Vec<Row> {
    let curve = column.curves.iter().find(|curve| !curve.deviation.is_of_angle());
    let Some((curve, minimum)) = curve.and_then(|curve| Some((curve, curve.minimum?))) else { return vec![] };
    let (unit, symbol) = (column.unit.in_files(curve.deviation), column.unit.symbol(curve.deviation));
    let (value, verdict) = (minimum.point.value, if minimum.at_end { "at the end of the curve" } else { "" });
    let interval = minimum.point.interval.map(|(lower, upper)| [lower, upper]);
    let tau = Some(minimum.point.tau_s);
    vec![
        Row { name: "in_run_stability", unit, symbol, value, interval, verdict },
        Row { name: "in_run_stability_tau", unit: "s", symbol: "s", value: tau, interval: None, verdict },
    ]
}

/// A coefficient for programs.
fn document_of(row: &Row) -> Value {
    json!({
        "coefficient": row.name,
        "value": row.value,
        "lower": row.interval.map(|ends| ends[0]),
        "upper": row.interval.map(|ends| ends[1]),
        "unit": row.unit,
        "verdict": row.verdict,
    })
}

/// Whether the noise was identified at this τ.
fn alpha_from(point: &Point) -> &'static str {
    match point.noise {
        Some(noise) if noise.carried => "carried",
        Some(_) => "identified",
        None => "",
    }
}

/// Everything, for programs.
pub fn document(analysis: &Analysis) -> Value {
    let treatment = &analysis.treatment;
    let columns: Vec<Value> = analysis.columns.iter().map(|column| of_column(analysis, column)).collect();
    json!({
        "file": analysis.path.display().to_string(),
        "data": analysis.data.name(),
        "samples": analysis.samples,
        "step_s": analysis.step_s,
        "length_s": analysis.length_s(),
        "confidence": analysis.confidence,
        "treatment": {
            "from_s": treatment.skip_s,
            "until_s": treatment.until_s,
            "detrend": match treatment.trend { Trend::None => "none", Trend::Linear => "linear" },
            "effect": treatment.effect(analysis.length_s()),
            "outliers_removed": treatment.outliers_removed,
        },
        "columns": columns,
    })
}

fn of_column(analysis: &Analysis, column: &log::Column) -> Value {
    /// Enough to find them; a document with millions helps nobody.
    const MOST: usize = 100;
    let outliers = &column.outliers;
    let times: Vec<f64> = outliers
        .samples
        .iter()
        .take(MOST)
        .map(|&sample| analysis.treatment.skip_s + sample as f64 * analysis.step_s)
        .collect();
    let curves: Vec<Value> = column.curves.iter().map(|curve| of_curve(column, curve)).collect();
    json!({
        "column": column.name,
        "missing": column.missing,
        "mean_rate": column.mean_rate,
        "mean_rate_unit": column.unit.in_files(Deviation::Oadev),
        "removed_slope_per_s": column.slope,
        "outliers": { "count": outliers.samples.len(), "threshold": outliers.threshold, "first_times_s": times },
        "coefficients": column.coefficients().iter().map(document_of).collect::<Vec<_>>(),
        "coefficients_missing": column.noise.as_ref().err(),
        "coefficient_intervals": column.noise().map(|noise| json!({
            "from": noise.intervals.name(),
            "simulated_records": noise.intervals.records(),
        })),
        "curves": curves,
    })
}

fn of_curve(column: &log::Column, curve: &Curve) -> Value {
    let points: Vec<Value> = curve.points.iter().map(of_point).collect();
    let minimum = curve.minimum.filter(|_| !curve.deviation.is_of_angle()).map(|minimum| {
        let mut point = of_point(&minimum.point);
        point["at_end"] = json!(minimum.at_end);
        point
    });
    json!({
        "deviation": curve.deviation.name(),
        "unit": column.unit.in_files(curve.deviation),
        "points": points,
        "in_run_stability": minimum,
    })
}

fn of_point(point: &Point) -> Value {
    json!({
        "m": point.m,
        "tau_s": point.tau_s,
        "terms": point.terms,
        "alpha": point.noise.map(|noise| noise.alpha),
        "alpha_carried": point.noise.map(|noise| noise.carried),
        "edf": point.edf,
        "lower": point.interval.map(|ends| ends.0),
        "value": point.value,
        "upper": point.interval.map(|ends| ends.1),
    })
}
