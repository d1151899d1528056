//! The results of `sagnac compare` as tables.

use crate::allan::Deviation;
use crate::analysis::compare::{Length, Ratio};
use crate::table::column::columns_of;
use crate::table::{Cell, ColumnOf, Role, Table, Unit};

use crate::analysis::compare::logs::Analysis;
use crate::analysis::compare::rows::Row;
use crate::analysis::log::records::{self, Record};
use crate::analysis::log::tables::text;

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

/// The records of both logs: `records.csv`.
pub fn records(analysis: &Analysis) -> Table {
    records::table(analysis.sides.iter().map(|side| Record {
        name: &side.label,
        path: &side.path,
        data: side.data,
        samples: side.samples,
        step_s: side.step_s,
        missing: side.missing,
        outliers: &side.outliers,
        unit: analysis.unit,
        mean: None,
        slope: None,
        noise: None,
        density: None,
    }))
}
