//! The noise of a log over time as tables.

use crate::analysis::log::tables::{key, text};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_records::allan::{Deviation, Point};

use crate::analysis::dynamic::change::Octave;
use crate::analysis::dynamic::{Column, Dynamic, Window};

/// A row of `dynamic.csv`.
pub(crate) struct PointRow<'a> {
    column: &'a Column,
    window: &'a Window,
    point: &'a Point,
}

/// The columns of `dynamic.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn point_columns<'a>() -> Vec<ColumnOf<PointRow<'a>>> {
    type Of<'a> = ColumnOf<PointRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("start", Unit::S, "start", |row| Cell::Number(row.window.range_s[0]))
            .is(Role::Coordinate, "Start of the window, from the start of the file, s."),
        Of::new("end", Unit::S, "end", |row| Cell::Number(row.window.range_s[1]))
            .is(Role::Coordinate, "End of the window, from the start of the file, s."),
        Of::new("tau", Unit::S, "tau", |row| Cell::Number(row.point.tau_s))
            .is(Role::Coordinate, "Averaging time τ, s."),
        Of::new("differences", Unit::NONE, "differences", |row| Cell::Integer(row.point.terms as i64))
            .is(Role::Count, "Number of differences behind the value."),
        Of::new("lower", Unit::NONE, "lower", |row| row.point.interval.map(|ends| ends.0).into())
            .is_of("value", Role::Lower, "Lower end of the 95 % interval of `value`."),
        Of::new("value", Unit::NONE, "value", |row| row.point.value.into())
            .is(Role::Error, "Overlapping Allan deviation of the window, in `unit`; blank where gaps leave less than half of its differences."),
        Of::new("upper", Unit::NONE, "upper", |row| row.point.interval.map(|ends| ends.1).into())
            .is_of("value", Role::Upper, "Upper end of the 95 % interval of `value`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.column.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of `value`, `lower` and `upper`."),
    ]
}

/// The deviations of all windows: `dynamic.csv`.
pub fn windows(dynamic: &Dynamic) -> Table {
    let mut rows = Vec::new();
    for column in &dynamic.columns {
        for window in &column.windows {
            rows.extend(window.points.iter().map(|point| PointRow { column, window, point }));
        }
    }
    Table { columns: columns_of(&point_columns(), &rows) }
}

/// A row of `stationarity.csv`.
pub(crate) struct OctaveRow<'a> {
    column: &'a Column,
    octave: &'a Octave,
}

/// The columns of `stationarity.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn octave_columns<'a>() -> Vec<ColumnOf<OctaveRow<'a>>> {
    type Of<'a> = ColumnOf<OctaveRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("tau", Unit::S, "tau", |row| Cell::Number(row.octave.tau_s))
            .is(Role::Coordinate, "Averaging time τ, s."),
        Of::new("parts", Unit::NONE, "parts", |row| Cell::Integer(row.octave.parts as i64))
            .is(Role::Count, "Number of parts of the record whose variances are compared."),
        Of::new("p", Unit::NONE, "p", |row| Cell::Number(row.octave.p))
            .is(Role::Estimate, "Probability that noise that does not change looks at least as changed at any of the tested τ."),
        Of::new("at", Unit::S, "at", |row| Cell::Number(row.column.skipped_s + row.octave.at_s))
            .is(Role::Estimate, "Likeliest time of a change, from the start of the file, s."),
        Of::new("before", Unit::NONE, "before", |row| Cell::Number(row.octave.before))
            .is(Role::Error, "Overlapping Allan deviation before that time, in `unit`."),
        Of::new("after", Unit::NONE, "after", |row| Cell::Number(row.octave.after))
            .is(Role::Error, "Overlapping Allan deviation after that time, in `unit`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.column.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of `before` and `after`."),
        Of::new("visible", Unit::NONE, "visible", |row| Cell::Number(row.octave.visible))
            .is(Role::Estimate, "Relative step of the deviation in the middle of the record that is detected with 90 % power at p < 5 %."),
    ]
}

/// The tests for a change: `stationarity.csv`.
pub fn octaves(dynamic: &Dynamic) -> Table {
    let mut rows = Vec::new();
    for column in &dynamic.columns {
        rows.extend(column.octaves.iter().map(|octave| OctaveRow { column, octave }));
    }
    Table { columns: columns_of(&octave_columns(), &rows) }
}
