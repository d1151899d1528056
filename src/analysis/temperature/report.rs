//! The report of the dependence on temperature: tables, charts and notes.

use crate::analysis::log::figures::{of_columns, per_unit};
use crate::analysis::log::report::{heading, key, text};
use crate::analysis::log::{self, Analysis};
use crate::analysis::temperature::{Column, Dependence, Effect, Finding, Temperature};
use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{ColumnOf, Role, Table, Unit};
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::{self, Deviation, Point};
use sagnac_records::fit::regression::Estimate;
use sagnac_report::answer::reading::capitalized;
use sagnac_report::chart::figure::{Axis, Figure, Grouping, Series, SeriesPoint};

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
    /// Unit in files.
    pub unit: String,
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
        row("reference_temperature", Some(found.averages.reference_c), "degC".to_owned(), ""),
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
        ..row("warm-up_time", Some(value), "s".to_owned(), "")
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
        Of::new("unit", Unit::NONE, "unit", |CoefficientRow(_, row)| text(&row.unit))
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

/// Places of a fitted line.
const PLACES: u32 = 100;

/// The figures with the stems of their file names, for each unit the deviations before and after compensation and the rate over
/// temperature.
pub fn figures(temperature: &Temperature, [before, after]: [&Analysis; 2]) -> Vec<(String, Figure)> {
    let deviations = |unit| deviations([before, after], unit);
    let rates = |unit| rates(temperature, before, unit);
    [per_unit(before, "chart-temperature", deviations), per_unit(before, "chart-rate", rates)].concat()
}

/// The first deviation of each column of a unit before and after, with intervals after.
fn deviations([before, after]: [&Analysis; 2], unit: allan::Unit) -> Option<Figure> {
    let deviation = before.of_unit(unit).next()?.curves.first()?.deviation;
    let series = |colour: usize, dash: usize, column: &log::Column| {
        let point = |point: &Point| {
            let band = point.interval.filter(|_| dash == 1);
            Some(SeriesPoint { x: point.tau_s, y: point.value?, band, key: None })
        };
        let points = column.curves.iter().take(1).flat_map(|curve| curve.points.iter().filter_map(point));
        Series { colour, dash, points: points.collect(), law: vec![] }
    };
    let each = |(colour, (before, after))| [series(colour, 0, before), series(colour, 1, after)];
    Some(Figure {
        title: "Deviation before and after compensation".to_owned(),
        subtitle: Some(format!("{}; {}", heading(before), deviation.title())),
        x: Axis::new("averaging time τ", "s"),
        y: Axis::new("deviation σ(τ)", unit.symbol(deviation)),
        colours: of_columns(before.of_unit(unit).map(|column| column.name.clone())),
        dashes: Grouping::new("record", ["before", "after"].map(str::to_owned)),
        bands: format!("{} intervals", before.percent()),
        series: before.of_unit(unit).zip(after.of_unit(unit)).enumerate().flat_map(each).collect(),
        ..Figure::default()
    })
}

/// The mean rates of blocks over their temperature with the fitted line, without the effects that are none of temperature.
fn rates(temperature: &Temperature, before: &Analysis, unit: allan::Unit) -> Option<Figure> {
    let mut names = Vec::new();
    let mut series = Vec::new();
    for column in temperature.columns.iter().filter(|column| column.unit == unit) {
        let Ok(found) = &column.found else { continue };
        let mut points = found.points();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let [low, high] = found.averages.range_c;
        let place = |i| low + (high - low) * f64::from(i) / f64::from(PLACES);
        let at = |x: f64| (x, found.model.offset + found.model.at(x - found.averages.reference_c).value);
        let law = (0..=PLACES).map(|i| at(place(i))).collect();
        series.push(Series { colour: names.len(), dash: 0, points, law });
        names.push(column.name.clone());
    }
    (!series.is_empty()).then(|| Figure {
        title: format!("{} over temperature", capitalized(unit.measured())),
        subtitle: Some(format!(
            "{}; without warm-up, aging and the change of the temperature",
            heading(before)
        )),
        x: Axis { scale: Scale::Linear, ..Axis::new("temperature", "°C") },
        y: Axis { scale: Scale::Linear, ..Axis::new(unit.measured(), unit.symbol(Deviation::Oadev)) },
        colours: of_columns(names.into_iter()),
        points: "means of blocks".to_owned(),
        lines: "fit".to_owned(),
        series,
        ..Figure::default()
    })
}

impl Dependence {
    /// The mean rate of each block over its temperature, less the effects of the model that are none of temperature.
    fn points(&self) -> Vec<SeriesPoint> {
        let time_s = self.model.warm_up_s.map_or(1.0, |(time_s, _)| time_s);
        let mut rates = self.averages.rates.clone();
        let is_other = |effect: &Effect| !matches!(effect, Effect::Temperature | Effect::Square);
        for (effect, size) in self.model.coefficients.iter().filter(|(effect, _)| is_other(effect)) {
            let column = self.averages.column(*effect, time_s);
            rates.iter_mut().zip(&column).for_each(|(rate, x)| *rate -= size * x);
        }
        let temperatures = self.averages.temperatures.iter().map(|from| from + self.averages.reference_c);
        temperatures.zip(rates).map(|(x, y)| SeriesPoint { x, y, band: None, key: None }).collect()
    }
}

/// What was done with the temperature, and what limits the results of columns, in a line each.
pub fn notes(temperature: &Temperature) -> Vec<String> {
    let course = &temperature.course;
    let [missing, unknown] = temperature.missing;
    let smoothed = (course.half_window > 0).then(|| {
        format!(
            "the temperature is smoothed by straight lines over {} s, to the error of its sensor of {} K",
            significant((2 * course.half_window + 1) as f64 * temperature.step_s, 4),
            significant(course.error, 2)
        )
    });
    let gaps = (missing > 0).then(|| {
        format!(
            "{missing} samples have no temperature: {} lie in short gaps, which straight lines bridge, and {unknown} are left out",
            missing - unknown
        )
    });
    let of_columns = temperature.columns.iter().flat_map(of_column);
    smoothed.into_iter().chain(gaps).chain(of_columns).collect()
}

fn of_column(column: &Column) -> Vec<String> {
    let said = |note: String| format!("{}: {note}", column.name);
    match &column.found {
        Err(why) => vec![said(format!("no temperature coefficients, and no compensation: {why}"))],
        Ok(found) if found.model.is_robust => vec![said(format!(
            "white noise, flicker and random walk do not describe the residual of the temperature model (p = {}): the intervals of \
             its coefficients are robust ones, from the correlation of the residual",
            significant(found.model.p_value, 2)
        ))],
        Ok(_) => vec![],
    }
}
