//! Noise coefficients of a column: the fit to its overlapping Allan curve, in the units of data sheets.

use sagnac::allan::Angles;
use sagnac::fit::{Coefficient, Fit, Term, Terms, Verdict, curve_of, fit_record};
use serde_json::{Value, json};

use super::analysis::Unit;

/// What the record says of one coefficient, in the unit of data sheets.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub name: &'static str,
    /// As files have it.
    pub unit: &'static str,
    /// For people.
    pub symbol: &'static str,
    pub value: Option<f64>,
    pub interval: Option<[f64; 2]>,
    pub verdict: &'static str,
}

/// The noise of a column.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    pub rows: Vec<Row>,
    /// In ″ and s, or in plain numbers and s.
    pub fit: Fit,
}

/// The noise of a record, or why it cannot be told.
pub fn noise(angles: &Angles, terms: &Terms, unit: Unit) -> Result<Noise, String> {
    let fit =
        curve_of(angles).and_then(|curve| fit_record(&curve, terms)).map_err(|error| error.to_string())?;
    Ok(Noise { rows: rows(&fit, unit), fit })
}

fn rows(fit: &Fit, unit: Unit) -> Vec<Row> {
    let mut rows = Vec::new();
    for coefficient in &fit.coefficients {
        let (factor, in_files, symbol) = unit_of(coefficient.term, unit);
        rows.push(Row {
            name: coefficient.term.symbol(),
            unit: in_files,
            symbol,
            value: coefficient.value.map(|value| factor * value),
            interval: coefficient.interval.map(|ends| ends.map(|end| factor * end)),
            verdict: verdict(coefficient),
        });
        if let Some(shape) = coefficient.shape {
            let (name, unit) =
                if coefficient.term == Term::Sine { ("sine_frequency", "Hz") } else { ("markov_time", "s") };
            let (value, interval) = (Some(shape.value), Some(shape.interval));
            rows.push(Row { name, unit, symbol: unit, value, interval, verdict: verdict(coefficient) });
        }
    }
    rows
}

fn verdict(coefficient: &Coefficient) -> &'static str {
    match coefficient.verdict {
        Verdict::Identified => "identified",
        Verdict::AtBoundary { .. } => "none found, at most the upper end",
        Verdict::NotIdentifiable { below: Some(_) } => "not identifiable, at most the upper end",
        Verdict::NotIdentifiable { below: None } => "not identifiable",
    }
}

/// From ″ and s to the unit of data sheets: factor, name in files, symbol. Plain numbers keep theirs, times a power of s.
pub fn unit_of(term: Term, unit: Unit) -> (f64, &'static str, &'static str) {
    match (unit, term) {
        (Unit::Angular, Term::Quantisation) => (1.0, "arcsec", "″"),
        (Unit::Angular, Term::AngleRandomWalk) => (1.0 / 60.0, "deg/sqrt(h)", "°/√h"),
        (Unit::Angular, Term::RateRandomWalk) => (60.0, "deg/h/sqrt(h)", "°/h/√h"),
        (Unit::Angular, Term::RateRamp) => (3600.0, "deg/h/h", "°/h/h"),
        (Unit::Angular, _) => (1.0, "deg/h", "°/h"),
        (Unit::Plain, Term::Quantisation) => (1.0, "s", "· s"),
        (Unit::Plain, Term::AngleRandomWalk) => (1.0, "sqrt(s)", "· √s"),
        (Unit::Plain, Term::RateRandomWalk) => (1.0, "1/sqrt(s)", "/ √s"),
        (Unit::Plain, Term::RateRamp) => (1.0, "1/s", "/ s"),
        (Unit::Plain, _) => (1.0, "", ""),
    }
}

/// A coefficient for programs.
pub fn document(row: &Row) -> Value {
    json!({
        "coefficient": row.name,
        "value": row.value,
        "lower": row.interval.map(|ends| ends[0]),
        "upper": row.interval.map(|ends| ends[1]),
        "unit": row.unit,
        "verdict": row.verdict,
    })
}
