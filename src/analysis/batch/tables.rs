//! The results of `sagnac compare` as tables.

use crate::analysis::log;
use crate::analysis::log::records::{self, Record};
use crate::analysis::log::tables::text;
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};

use crate::analysis::batch::random_effects::Pooled;
use crate::analysis::batch::{Batch, Coefficient, Found, Outlier};

/// Meaning of the column that names coefficients.
const COEFFICIENT: &str = "Q, N, B, K, R of data sheets, `markov`, `markov_time`, `sine`, `sine_frequency`, L, and `in_run_bias_stability`, the \
     minimum of the curve.";

/// A row of `units.csv`.
pub(crate) struct UnitRow<'a> {
    label: &'a str,
    file: String,
    column: &'a log::Column,
    found: &'a Found,
}

/// The columns of `units.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn unit_columns<'a>() -> Vec<ColumnOf<UnitRow<'a>>> {
    type Of<'a> = ColumnOf<UnitRow<'a>>;
    vec![
        Of::new("label", Unit::NONE, "label", |row| text(row.label))
            .is(Role::Key, "Label of the unit of the batch: the name of its file, of its column, or both."),
        Of::new("coefficient", Unit::NONE, "coefficient", |row| text(row.found.row.name))
            .is(Role::Key, COEFFICIENT),
        Of::new("value", Unit::NONE, "value", |row| row.found.row.value.into())
            .is(Role::Estimate, "The coefficient in `unit`; blank where the record does not show it."),
        Of::new("lower", Unit::NONE, "lower", |row| row.found.row.interval.map(|ends| ends[0]).into())
            .is_of("value", Role::Lower, "Lower end of the 95 % interval."),
        Of::new("upper", Unit::NONE, "upper", |row| row.found.row.interval.map(|ends| ends[1]).into())
            .is_of("value", Role::Upper, "Upper end of the 95 % interval; if `value` is blank, an upper bound on the coefficient."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.found.row.unit))
            .is(Role::Note, "Unit of `value`, `lower` and `upper`."),
        Of::new("status", Unit::NONE, "status", |row| text(row.found.row.verdict))
            .is(Role::Note, "Whether the record identifies the coefficient, in words."),
        Of::new("p", Unit::NONE, "p", |row| row.found.p.into())
            .is(Role::Estimate, "Probability that any test of the batch finds a unit at least as far from the others by chance if all are \
                alike; blank where fewer than three units show the coefficient."),
        Of::new("outlier", Unit::NONE, "outlier", |row| text(row.found.outlier.map_or("", Outlier::name)))
            .is(Role::Note, "`higher` or `lower` than the others where p < 5 %, or `above the bounds of the others`; blank for a unit like \
                the others."),
        Of::new("file", Unit::NONE, "file", |row| text(&row.file))
            .is(Role::Note, "The log of the unit."),
        Of::new("column", Unit::NONE, "column", |row| text(&row.column.name))
            .is(Role::Note, "The column of the log."),
        Of::new("fit_from", Unit::S, "fit_from", |row| row.column.noise().map(|noise| noise.fit.tau_range[0]).into())
            .is(Role::Coordinate, "Shortest τ of the fit, s: the shortest from which its terms describe the curve."),
    ]
}

/// The coefficients of all units: `units.csv`.
pub fn units(batch: &Batch) -> Table {
    let mut rows = Vec::new();
    for (unit, (log, column)) in batch.units().enumerate() {
        for one in &batch.coefficients {
            let Some(found) = &one.found[unit] else { continue };
            rows.push(UnitRow {
                label: &batch.labels[unit],
                file: log.path.display().to_string(),
                column,
                found,
            });
        }
    }
    Table { columns: columns_of(&unit_columns(), &rows) }
}

/// A row of `batch.csv`.
pub(crate) struct BatchRow<'a> {
    one: &'a Coefficient,
    of: &'static str,
    pooled: Option<Pooled>,
}

impl BatchRow<'_> {
    /// A number of the batch that the units determine.
    fn finite(&self, of: impl Fn(&Pooled) -> f64) -> Cell {
        self.pooled.as_ref().map(of).filter(|number| number.is_finite()).into()
    }
}

/// The columns of `batch.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn batch_columns<'a>() -> Vec<ColumnOf<BatchRow<'a>>> {
    type Of<'a> = ColumnOf<BatchRow<'a>>;
    vec![
        Of::new("coefficient", Unit::NONE, "coefficient", |row| text(row.one.name))
            .is(Role::Key, COEFFICIENT),
        Of::new("of", Unit::NONE, "of", |row| text(row.of))
            .is(Role::Key, "`all` units, or `those that show it` where some do not; or the same units `without outliers` ones."),
        Of::new("units", Unit::NONE, "units", |row| Cell::Integer(row.pooled.map_or(row.one.estimates().len(), |pooled| pooled.units) as i64))
            .is(Role::Count, "Number of units in the row, those that show the coefficient."),
        Of::new("bounded", Unit::NONE, "bounded", |row| Cell::Integer(row.one.bounds().len() as i64))
            .is(Role::Count, "Number of units left out because they have only an upper bound: the value is too high for the batch."),
        Of::new("missing", Unit::NONE, "missing", |row| Cell::Integer(row.one.silent().count() as i64))
            .is(Role::Count, "Number of units left out because they say nothing of the coefficient."),
        Of::new("value", Unit::NONE, "value", |row| row.finite(|pooled| pooled.value))
            .is(Role::Estimate, "Median of the batch in `unit`; blank for fewer than two units."),
        Of::new("lower", Unit::NONE, "lower", |row| row.finite(|pooled| pooled.interval[0]))
            .is_of("value", Role::Lower, "Lower end of the 95 % interval of `value`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.finite(|pooled| pooled.interval[1]))
            .is_of("value", Role::Upper, "Upper end of the 95 % interval of `value`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.one.unit))
            .is(Role::Note, "Unit of `value`, its interval and that of the next unit."),
        Of::new("unit_sd", Unit::NONE, "unit_sd", |row| row.finite(|pooled| pooled.spread))
            .is(Role::Estimate, "Standard deviation between units as a part of their mean, without the errors of the records."),
        Of::new("unit_sd_lower", Unit::NONE, "unit_sd_lower", |row| row.finite(|pooled| pooled.spread_interval[0]))
            .is_of("unit_sd", Role::Lower, "Lower end of the 95 % interval of `unit_sd`."),
        Of::new("unit_sd_upper", Unit::NONE, "unit_sd_upper", |row| row.finite(|pooled| pooled.spread_interval[1]))
            .is_of("unit_sd", Role::Upper, "Upper end of the 95 % interval of `unit_sd`; a bound where `unit_sd` is 0."),
        Of::new("prediction_lower", Unit::NONE, "prediction_lower", |row| row.finite(|pooled| pooled.next[0]))
            .is(Role::Estimate, "Lower end of the 95 % prediction interval for a new unit."),
        Of::new("prediction_upper", Unit::NONE, "prediction_upper", |row| row.finite(|pooled| pooled.next[1]))
            .is(Role::Estimate, "Upper end of the 95 % prediction interval for a new unit."),
        Of::new("p_equal", Unit::NONE, "p_equal", |row| row.finite(|pooled| pooled.p_equal))
            .is(Role::Estimate, "Probability that equal units are at least as far apart by chance."),
    ]
}

/// The values of the batch, with and without outliers: `batch.csv`.
pub fn batch(batch: &Batch) -> Table {
    let mut rows = Vec::new();
    for one in &batch.coefficients {
        let of = if one.estimates().len() == one.found.len() { "all" } else { "those that show it" };
        rows.push(BatchRow { one, of, pooled: one.pooled });
        rows.extend(one.without_outliers.map(|rest| BatchRow {
            one,
            of: "without outliers",
            pooled: Some(rest),
        }));
    }
    Table { columns: columns_of(&batch_columns(), &rows) }
}

/// The records of all units: `records.csv`.
pub fn records(batch: &Batch) -> Table {
    let units = batch.units().zip(&batch.labels);
    records::table(units.map(|((log, column), label)| Record::new(log, column, label)))
}
