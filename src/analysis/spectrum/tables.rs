//! The spectra of a log as tables.

use crate::analysis::data_sheet::Row;
use crate::analysis::log;
use crate::analysis::log::records::{self, Record};
use crate::analysis::log::tables::{key, text};
use crate::analysis::spectrum::{Analysis, Spectrum, White};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_records::allan::{Deviation, Unit as Curves};
use sagnac_records::spectrum::{Line, Point};

/// Unit of densities in files.
fn in_files(unit: Curves) -> &'static str {
    match unit {
        Curves::Angular => "deg2/h2/Hz",
        Curves::Acceleration => "ug2/Hz",
        Curves::Plain => "",
    }
}

/// A row of `psd.csv`.
pub(crate) struct DensityRow<'a> {
    column: &'a log::Column,
    spectrum: &'a Spectrum,
    point: &'a Point,
    treatment: &'a str,
}

/// The columns of `psd.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn density_columns<'a>() -> Vec<ColumnOf<DensityRow<'a>>> {
    type Of<'a> = ColumnOf<DensityRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("f", Unit::HZ, "frequency", |row| Cell::Number(row.point.frequency_hz))
            .is(Role::Coordinate, "Frequency, Hz."),
        Of::new("density", Unit::NONE, "density", |row| Cell::Number(row.point.value))
            .is(Role::Error, "One-sided power spectral density of the rate or acceleration, in `unit`."),
        Of::new("lower", Unit::NONE, "lower", |row| row.point.interval.map(|ends| ends.0).into())
            .is_of("density", Role::Lower, "Lower end of the interval of `density`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.point.interval.map(|ends| ends.1).into())
            .is_of("density", Role::Upper, "Upper end of the interval of `density`."),
        Of::new("model", Unit::NONE, "model", |row| row.spectrum.model_at(row.point.frequency_hz).into())
            .is_of("density", Role::Theory, "Density of the noise model that was fitted to the Allan curve, in `unit`; blank without a fit and above its frequencies."),
        Of::new("unit", Unit::NONE, "unit", |row| text(in_files(row.column.unit)))
            .is(Role::Note, "Unit of `density`, `lower`, `upper` and `model`."),
        Of::new("treatment", Unit::NONE, "treatment", |row| text(row.treatment))
            .is(Role::Note, "What was done to the record: skipped, cut, a line removed, outliers removed."),
    ]
}

/// The densities of all columns: `psd.csv`.
pub fn table(analysis: &Analysis) -> Table {
    let treatment = &analysis.noise.treatment.summary();
    let rows: Vec<DensityRow> = analysis
        .columns()
        .flat_map(|(column, spectrum)| {
            spectrum.density.points.iter().map(move |point| DensityRow { column, spectrum, point, treatment })
        })
        .collect();
    Table { columns: columns_of(&density_columns(), &rows) }
}

/// A row of `lines.csv`.
pub(crate) struct LineRow<'a> {
    column: &'a log::Column,
    line: &'a Line,
}

/// The columns of `lines.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn line_columns<'a>() -> Vec<ColumnOf<LineRow<'a>>> {
    type Of<'a> = ColumnOf<LineRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("f", Unit::HZ, "frequency", |row| Cell::Number(row.line.frequency_hz))
            .is(Role::Coordinate, "Frequency of the line, interpolated, Hz."),
        Of::new("amplitude", Unit::NONE, "amplitude", |row| Cell::Number(row.line.amplitude))
            .is(Role::Estimate, "Amplitude of the sine of the rate or acceleration, in `unit`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.column.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of `amplitude`."),
        Of::new("over_floor", Unit::NONE, "over floor", |row| Cell::Number(row.line.over_floor))
            .is(Role::Estimate, "Highest density of the line over that of the noise around it."),
        Of::new("p", Unit::NONE, "p", |row| Cell::Number(row.line.p))
            .is(Role::Estimate, "Probability that noise alone has such a density anywhere in the record; a line has at most 0.01."),
    ]
}

/// The lines of all columns: `lines.csv`.
pub fn lines(analysis: &Analysis) -> Table {
    let lines = analysis
        .columns()
        .flat_map(|(column, spectrum)| spectrum.lines.iter().map(move |line| LineRow { column, line }));
    let rows: Vec<LineRow> = lines.collect();
    Table { columns: columns_of(&line_columns(), &rows) }
}

/// A row of `white_noise.csv`.
pub(crate) struct WhiteRow<'a> {
    column: &'a log::Column,
    white: &'a White,
    from: &'static str,
    row: &'a Row,
}

/// The columns of `white_noise.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn white_columns<'a>() -> Vec<ColumnOf<WhiteRow<'a>>> {
    type Of<'a> = ColumnOf<WhiteRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("from", Unit::NONE, "from", |row| text(row.from))
            .is(Role::Key, "`floor` for N from the flat range of the density, `fit` for N from the Allan curve."),
        Of::new("n", Unit::NONE, "N", |row| row.row.value.into())
            .is(Role::Estimate, "Angle or velocity random walk N, in `unit`; blank where the fit does not identify it."),
        Of::new("lower", Unit::NONE, "lower", |row| row.row.interval.map(|ends| ends[0]).into())
            .is_of("n", Role::Lower, "Lower end of the interval of `n`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.row.interval.map(|ends| ends[1]).into())
            .is_of("n", Role::Upper, "Upper end of the interval of `n`; if `n` is blank, an upper bound."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.row.unit))
            .is(Role::Note, "Unit of `n`, `lower` and `upper`."),
        Of::new("from_f", Unit::HZ, "from", |row| range(row.white).map(|ends| ends[0]).into())
            .is(Role::Estimate, "Lowest frequency of the flat range, Hz."),
        Of::new("to_f", Unit::HZ, "to", |row| range(row.white).map(|ends| ends[1]).into())
            .is(Role::Estimate, "Highest frequency of the flat range, Hz."),
        Of::new("others", Unit::NONE, "others", |row| row.white.model.map(|[_, others]| others).into())
            .is(Role::Estimate, "Part of the fitted density over the flat range that is of other terms than N."),
        Of::new("status", Unit::NONE, "status", |row| text(row.white.verdict()))
            .is(Role::Note, "Whether the floor is told apart from the fitted density over the flat range, as far as the fit reaches, all \
                terms included."),
        Of::new("n_verdict", Unit::NONE, "n_verdict", |row| text(row.row.verdict))
            .is(Role::Note, "Whether the fit identifies N, in words; blank for the floor."),
    ]
}

/// Ends of the flat range, Hz.
fn range(white: &White) -> Option<[f64; 2]> {
    white.floor.as_ref().map(|floor| floor.range_hz)
}

/// N of all columns from floor and fit: `white_noise.csv`.
pub fn white_noise(analysis: &Analysis) -> Table {
    let rows = analysis.columns().flat_map(|(column, Spectrum { white, .. })| {
        let found = [("floor", &white.from_floor), ("fit", &white.from_fit)];
        found
            .into_iter()
            .filter_map(move |(from, row)| Some(WhiteRow { column, white, from, row: row.as_ref()? }))
    });
    let rows: Vec<WhiteRow> = rows.collect();
    Table { columns: columns_of(&white_columns(), &rows) }
}

/// The records with their fits and spectra: `records.csv`.
pub fn records(analysis: &Analysis) -> Table {
    let Analysis { noise, spectra } = analysis;
    let columns = noise.columns.iter().enumerate();
    records::table(columns.map(|(place, column)| Record {
        density: spectra.get(place).map(|spectrum| &spectrum.density),
        ..Record::new(noise, column, &column.name)
    }))
}
