//! The dependence on temperature as tables.

use crate::analysis::log::tables::{key, text};
use crate::analysis::temperature::effect::Effect;
use crate::analysis::temperature::model::Finding;
use crate::analysis::temperature::{Column, Dependence, Temperature};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{ColumnOf, Role, Table, Unit};
use sagnac_records::allan::Deviation;
use sagnac_records::fit::regression::Estimate;

/// Steps of a compensation table, K, of which the least is taken that gives no more than so many rows.
const STEPS: [f64; 7] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];
const MAX_ROWS: f64 = 60.0;

/// A row of `temperature.csv`.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name of the coefficient.
    pub name: &'static str,
    /// Value; absent where it is not part of the model.
    pub value: Option<f64>,
    /// 95 % interval.
    pub interval: Option<[f64; 2]>,
    /// Unit in files, and for the user.
    pub unit: [String; 2],
    /// How well it is known.
    pub verdict: String,
    /// Source of the interval.
    pub intervals: &'static str,
}

/// The coefficients of a column; empty where there are none.
pub fn rows(column: &Column) -> Vec<Row> {
    let Ok(found) = &column.found else { return vec![] };
    let model = &found.model;
    let row = |name, value, unit, verdict: &str| Row {
        name,
        value,
        interval: None,
        unit,
        verdict: verdict.to_owned(),
        intervals: "",
    };
    let start = [
        row("reference_temperature", Some(found.averages.reference_c), ["degC", "°C"].map(str::to_owned), ""),
        row(
            "offset",
            Some(model.offset),
            Effect::WarmUp.unit(column.unit),
            "at the reference temperature; never subtracted",
        ),
    ];
    let of = |finding: &Finding| Row {
        name: finding.effect.name(),
        value: finding.estimate.filter(|_| finding.is_used).map(|estimate| estimate.value),
        interval: finding.estimate.map(|estimate| estimate.interval),
        unit: finding.effect.unit(column.unit),
        verdict: finding.verdict.clone(),
        intervals: found.intervals(),
    };
    let time = model.warm_up_s.map(|(value, interval)| Row {
        interval,
        intervals: "profile of the likelihood",
        ..row("warm-up_time", Some(value), ["s"; 2].map(str::to_owned), "")
    });
    start.into_iter().chain(model.findings.iter().map(of)).chain(time).collect()
}

impl Dependence {
    /// Source of the intervals.
    pub fn intervals(&self) -> &'static str {
        if self.model.is_robust { "robust" } else { "likelihood of the noise" }
    }

    /// Temperatures over the range of the record in whole steps, °C, with what the temperature adds there to the rate at the
    /// reference temperature.
    pub fn compensation(&self) -> Vec<(f64, Estimate)> {
        let [low, high] = self.averages.range_c;
        let wide = STEPS[STEPS.len() - 1];
        let step = STEPS.into_iter().find(|step| (high - low) / step <= MAX_ROWS).unwrap_or(wide);
        let (first, last) = (libm::ceil(low / step) as i64, libm::floor(high / step) as i64);
        // Whole steps are divided, so that 0.1 K gives 20.3 and not 20.299999999999997.
        let at = |i: i64| if step < 1.0 { i as f64 / libm::round(1.0 / step) } else { i as f64 * step };
        let inner = (first..=last).map(at).filter(|x| *x > low && *x < high);
        let each = std::iter::once(low).chain(inner).chain([high]);
        each.map(|x| (x, self.model.at(x - self.averages.reference_c))).collect()
    }
}

/// A row of `temperature.csv` with its column.
pub(crate) struct CoefficientRow<'a>(&'a str, Row);

/// The columns of `temperature.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn coefficient_columns<'a>() -> Vec<ColumnOf<CoefficientRow<'a>>> {
    type Of<'a> = ColumnOf<CoefficientRow<'a>>;
    vec![
        key(|CoefficientRow(column, _)| text(column)),
        Of::new("coefficient", Unit::NONE, "coefficient", |CoefficientRow(_, row)| text(row.name))
            .is(Role::Key, "`reference_temperature`, from which temperatures count; `offset`, the rate there; `T` and `T2`, the \
                coefficients of the temperature and its square; `dT`, that of its change; `warm-up`, the rate at the start of the \
                record of a decay with the `warm-up_time`; `aging`, the slope over time."),
        Of::new("value", Unit::NONE, "value", |CoefficientRow(_, row)| row.value.into())
            .is(Role::Estimate, "The coefficient in `unit`; blank where it is not part of the model."),
        Of::new("lower", Unit::NONE, "lower", |CoefficientRow(_, row)| row.interval.map(|ends| ends[0]).into())
            .is_of("value", Role::Lower, "Lower end of the 95 % interval; if `value` is blank, of the coefficient if it were part of the model."),
        Of::new("upper", Unit::NONE, "upper", |CoefficientRow(_, row)| row.interval.map(|ends| ends[1]).into())
            .is_of("value", Role::Upper, "Upper end of the 95 % interval, likewise."),
        Of::new("unit", Unit::NONE, "unit", |CoefficientRow(_, row)| text(&row.unit[0]))
            .is(Role::Note, "Unit of `value`, `lower` and `upper`."),
        Of::new("status", Unit::NONE, "status", |CoefficientRow(_, row)| text(&row.verdict))
            .is(Role::Note, "How well the record determines the coefficient, in words."),
        Of::new("intervals", Unit::NONE, "intervals", |CoefficientRow(_, row)| text(row.intervals))
            .is(Role::Note, "How the interval was found: `likelihood of the noise`, averaged over the noises that the record leaves \
                likely; `robust`, from the correlation of the residual, where none of these noises describes it; `profile of the \
                likelihood` for the time of a warm-up."),
    ]
}

/// The coefficients of all columns: `temperature.csv`.
pub fn coefficients(temperature: &Temperature) -> Table {
    let of = |column| rows(column).into_iter().map(|row| CoefficientRow(&column.name, row));
    let lines: Vec<CoefficientRow> = temperature.columns.iter().flat_map(of).collect();
    Table { columns: columns_of(&coefficient_columns(), &lines) }
}

/// A row of `compensation.csv`.
pub(crate) struct CompensationRow<'a> {
    column: &'a Column,
    temperature_c: f64,
    rate: Estimate,
}

/// The columns of `compensation.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn compensation_columns<'a>() -> Vec<ColumnOf<CompensationRow<'a>>> {
    type Of<'a> = ColumnOf<CompensationRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("temperature", Unit::NONE, "temperature", |row| Some(row.temperature_c).into())
            .is(Role::Coordinate, "Temperature in °C, over the range of the record."),
        Of::new("rate", Unit::NONE, "rate", |row| Some(row.rate.value).into())
            .is(Role::Estimate, "Rate to subtract at this temperature, in `unit`; 0 at the reference temperature."),
        Of::new("lower", Unit::NONE, "lower", |row| Some(row.rate.interval[0]).into())
            .is_of("rate", Role::Lower, "Lower end of the 95 % interval of `rate`."),
        Of::new("upper", Unit::NONE, "upper", |row| Some(row.rate.interval[1]).into())
            .is_of("rate", Role::Upper, "Upper end of the 95 % interval of `rate`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.column.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of `rate`, `lower` and `upper`."),
    ]
}

/// The compensation of all columns: `compensation.csv`.
pub fn compensation(temperature: &Temperature) -> Table {
    let of = |column| {
        let table = Column::table(column);
        table.into_iter().map(move |(temperature_c, rate)| CompensationRow { column, temperature_c, rate })
    };
    let lines: Vec<CompensationRow> = temperature.columns.iter().flat_map(of).collect();
    Table { columns: columns_of(&compensation_columns(), &lines) }
}

impl Column {
    /// The compensation table; empty where temperature is no part of a model.
    pub fn table(&self) -> Vec<(f64, Estimate)> {
        self.found
            .as_ref()
            .ok()
            .filter(|found| found.is_of_temperature())
            .map_or(vec![], Dependence::compensation)
    }
}
