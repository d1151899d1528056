//! Noise coefficients of a column: the fit to its overlapping Allan curve, in the units of data sheets.

use sagnac::allan::Angles;
use sagnac::backend::cpu::{Cpu, Width};
use sagnac::fit::{Coefficient, Curve, Fit, FitError, Fitter, Term, Terms, Verdict, curve_of, realisations};
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
    pub intervals: Intervals,
}

/// Where the 95 % intervals of coefficients come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Intervals {
    /// So many simulated records of the fit.
    Bootstrap { records: usize },
    /// And where simulated records were asked for, why there are none.
    ClosedForm { why: Option<String> },
}

impl Intervals {
    /// In files: `bootstrap of 1000`.
    pub fn name(&self) -> String {
        match self {
            Intervals::Bootstrap { records } => format!("bootstrap of {records}"),
            Intervals::ClosedForm { .. } => "closed form".to_owned(),
        }
    }

    /// For people: `from 1000 simulated records of the fit`.
    pub fn words(&self) -> String {
        match self {
            Intervals::Bootstrap { records } => format!("from {records} simulated records of the fit"),
            Intervals::ClosedForm { .. } => "in closed form".to_owned(),
        }
    }

    /// Simulated records: 0 of the closed form.
    pub fn records(&self) -> usize {
        match self {
            Intervals::Bootstrap { records } => *records,
            Intervals::ClosedForm { .. } => 0,
        }
    }
}

/// How many simulated records the intervals are to come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Simulated {
    pub records: usize,
    /// Why there are none, where nobody asked for that.
    pub without: Option<String>,
}

/// The noise of a record, or why it cannot be told.
pub fn noise(angles: &Angles, terms: &Terms, unit: Unit, simulated: Simulated) -> Result<Noise, String> {
    let said = |error: FitError| error.to_string();
    let curve = curve_of(angles).map_err(said)?;
    let fitter = Fitter::new(&curve, terms).map_err(said)?;
    let first = fitter.fit_record(curve.variances()).map_err(said)?;
    let Simulated { records, without } = simulated;
    let realised = (records > 0).then(|| realised(&fitter, &curve, &first, records)).transpose();
    let (fit, intervals) = match realised {
        Ok(None) => (first, Intervals::ClosedForm { why: without }),
        Ok(Some(fit)) => (fit, Intervals::Bootstrap { records }),
        Err(why) => {
            (first, Intervals::ClosedForm { why: Some(format!("the fit cannot be simulated: {why}")) })
        }
    };
    Ok(Noise { rows: rows(&fit, unit), fit, intervals })
}

/// The fit once more, with intervals from simulated records of the first.
fn realised(fitter: &Fitter, curve: &Curve, first: &Fit, count: usize) -> Result<Fit, String> {
    let cpu = Cpu::new(Width::widest(), 0).map_err(|error| error.to_string())?;
    let rows = realisations(&cpu, curve, first, count, &|_| {}).map_err(|error| error.to_string())?;
    fitter.fit_realised(curve.variances(), first, &rows).map_err(|error| error.to_string())
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
        (Unit::Angular, term) => term.data_sheet_unit(),
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
