//! The results of `sagnac compare` as tables.

use crate::analysis::compare::{Length, Ratio};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_records::allan::Deviation;

use crate::analysis::compare::logs::Analysis;
use crate::analysis::compare::rows::Row;
use crate::analysis::log::records::{self, Record};
use crate::analysis::log::tables::text;

/// A result of two logs: a row of `compare.csv` or of `coefficients.csv`.
pub(crate) struct Line<'a, T> {
    found: &'a T,
    unit: &'a str,
    logs: [&'a str; 2],
}

/// The columns of `compare.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn ratio_columns<'a>() -> Vec<ColumnOf<Line<'a, Ratio>>> {
    type Of<'a> = ColumnOf<Line<'a, Ratio>>;
    vec![
        Of::new("tau", Unit::S, "tau", |row| Cell::Number(row.found.tau_s()))
            .is(Role::Coordinate, "Averaging time τ, s."),
        Of::new("m_a", Unit::NONE, "m of A", |row| Cell::Integer(row.found.points[0].m as i64))
            .is(Role::Count, "Averaging time in samples of A."),
        Of::new("m_b", Unit::NONE, "m of B", |row| Cell::Integer(row.found.points[1].m as i64))
            .is(Role::Count, "Averaging time in samples of B."),
        Of::new("a", Unit::NONE, "A", |row| row.found.points[0].value.into())
            .is(Role::Error, "Overlapping Allan deviation of A, in `unit`."),
        Of::new("b", Unit::NONE, "B", |row| row.found.points[1].value.into())
            .is(Role::Error, "Overlapping Allan deviation of B, in `unit`."),
        Of::new("ratio", Unit::NONE, "ratio", |row| row.found.value.into())
            .is(Role::Estimate, "Value of B divided by that of A."),
        Of::new("lower", Unit::NONE, "lower", |row| row.found.interval.map(|ends| ends[0]).into())
            .is_of("ratio", Role::Lower, "Lower end of the 95 % interval of `ratio`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.found.interval.map(|ends| ends[1]).into())
            .is_of("ratio", Role::Upper, "Upper end of the 95 % interval of `ratio`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.unit))
            .is(Role::Note, "Unit of `a` and `b`."),
        Of::new("p", Unit::NONE, "p", |row| row.found.p.into())
            .is(Role::Estimate, "Probability that a ratio is at least as far from 1 by chance if both have the same noise."),
        Of::new("status", Unit::NONE, "status", |row| text(&row.found.verdict().map_or_else(String::new, |verdict| verdict.text(row.logs[1]))))
            .is(Role::Note, "`consistent`, or the label of B with `higher` or `lower`, as in `after higher`, at 95 %."),
        log_a(),
        log_b(),
    ]
}

/// The table of all ratios, `compare.csv`.
pub fn ratios(analysis: &Analysis) -> Table {
    let unit = analysis.unit.in_files(Deviation::Oadev);
    let rows = analysis.comparison.ratios.iter().map(|found| (found, unit));
    table(analysis.labels(), &ratio_columns(), rows)
}

/// The columns of `coefficients.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn coefficient_columns<'a>() -> Vec<ColumnOf<Line<'a, Row>>> {
    type Of<'a> = ColumnOf<Line<'a, Row>>;
    vec![
        Of::new("coefficient", Unit::NONE, "coefficient", |row| text(row.found.name))
            .is(Role::Key, "Q, N, B, K, R of data sheets, `markov`, `markov_time`, `sine`, `sine_frequency`, L."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.unit))
            .is(Role::Note, "Unit of `a`, `b` and `difference`."),
        Of::new("a", Unit::NONE, "A", |row| row.found.found.values[0].into())
            .is(Role::Estimate, "The coefficient of A; blank where its record does not show it."),
        Of::new("b", Unit::NONE, "B", |row| row.found.found.values[1].into())
            .is(Role::Estimate, "The coefficient of B; blank where its record does not show it."),
        Of::new("difference", Unit::NONE, "difference", |row| row.found.found.difference.into())
            .is(Role::Estimate, "Value of B minus that of A."),
        Of::new("lower", Unit::NONE, "lower", |row| row.found.found.interval[0].into())
            .is_of("difference", Role::Lower, "Lower end of the 95 % interval of `difference`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.found.found.interval[1].into())
            .is_of("difference", Role::Upper, "Upper end of the 95 % interval of `difference`."),
        Of::new("p", Unit::NONE, "p", |row| row.found.found.p.into())
            .is(Role::Estimate, "Probability that a difference is at least as large by chance if both have the same coefficient."),
        Of::new("length_needed", Unit::S, "length_needed", |row| needed(row.found.length).into())
            .is(Role::Estimate, "Length of records, s, that resolves such a difference with 90 % power."),
        Of::new("status", Unit::NONE, "status", |row| text(&row.found.verdict().text(row.logs[1])))
            .is(Role::Note, "`consistent`, `equal`, `in neither record`, `not compared` if an event of a record explains it as well, or the label of B with \
                `higher` or `lower`, as in `after higher`."),
        Of::new("ratio", Unit::NONE, "ratio", |row| row.found.found.ratio.into())
            .is(Role::Estimate, "Value of B divided by that of A."),
        Of::new("ratio_lower", Unit::NONE, "ratio_lower", |row| row.found.found.ratio_interval[0].into())
            .is_of("ratio", Role::Lower, "Lower end of the 95 % interval of `ratio`."),
        Of::new("ratio_upper", Unit::NONE, "ratio_upper", |row| row.found.found.ratio_interval[1].into())
            .is_of("ratio", Role::Upper, "Upper end of the 95 % interval of `ratio`."),
        Of::new("a_at_most", Unit::NONE, "A at most", |row| row.found.found.at_most[0].into())
            .is(Role::Estimate, "Upper bound on the coefficient of A, if its record does not show it."),
        Of::new("b_at_most", Unit::NONE, "B at most", |row| row.found.found.at_most[1].into())
            .is(Role::Estimate, "Upper bound on the coefficient of B, if its record does not show it."),
        Of::new("length_beyond", Unit::S, "length_beyond", |row| beyond(row.found.length).into())
            .is(Role::Estimate, "Length of records, s, up to which none was found that would distinguish such values."),
        Of::new("described", Unit::NONE, "described", |row| text(described(row.found.described, row.logs)))
            .is(Role::Note, "Whose curve the fit describes: `both`, `neither` or the label of a log; the coefficients of the others were forced."),
        log_a(),
        log_b(),
    ]
}

fn log_a<'a, T>() -> ColumnOf<Line<'a, T>> {
    ColumnOf::new("log_a", Unit::NONE, "first log", |row: &Line<'a, T>| text(row.logs[0])).is(
        Role::Note,
        "Label of A, the first log: the name of its file, with the column or the path where names are alike.",
    )
}

fn log_b<'a, T>() -> ColumnOf<Line<'a, T>> {
    ColumnOf::new("log_b", Unit::NONE, "second log", |row: &Line<'a, T>| text(row.logs[1]))
        .is(Role::Note, "Label of B, the second log.")
}

/// The table of all coefficients, `coefficients.csv`.
pub fn coefficients(analysis: &Analysis) -> Table {
    let rows = analysis.rows.iter().flatten().map(|found| (found, found.unit));
    table(analysis.labels(), &coefficient_columns(), rows)
}

/// The table of some results with their units. Labels of columns have the labels of the logs in place of A and B.
fn table<'a, T: Sync>(
    logs: [&'a str; 2],
    columns: &[ColumnOf<Line<'a, T>>],
    rows: impl Iterator<Item = (&'a T, &'a str)>,
) -> Table {
    let rows: Vec<Line<'a, T>> = rows.map(|(found, unit)| Line { found, unit, logs }).collect();
    let mut columns = columns_of(columns, &rows);
    for column in &mut columns {
        let own = ['A', 'B'].into_iter().zip(logs).find(|(letter, _)| column.label.contains(*letter));
        column.label =
            own.map_or_else(|| column.label.clone(), |(letter, log)| column.label.replace(letter, log));
    }
    Table { columns }
}

fn described(of: [bool; 2], logs: [&str; 2]) -> &str {
    match of {
        [true, true] => "both",
        [true, false] => logs[0],
        [false, true] => logs[1],
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
