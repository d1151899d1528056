//! The charts of the dependence on temperature.

use crate::analysis::log::figures::{of_columns, per_unit};
use crate::analysis::log::notes::heading;
use crate::analysis::log::{Analysis, Column};
use crate::analysis::temperature::effect::Effect;
use crate::analysis::temperature::{Dependence, Temperature};
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::{Deviation, Point, Unit};
use sagnac_report::answer::reading::capitalized;
use sagnac_report::chart::figure::{Axis, Figure, Grouping, Series, SeriesPoint};

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
fn deviations([before, after]: [&Analysis; 2], unit: Unit) -> Option<Figure> {
    let deviation = before.of_unit(unit).next()?.curves.first()?.deviation;
    let series = |colour: usize, dash: usize, column: &Column| {
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
        dashes: Grouping::of("record", ["before", "after"].map(str::to_owned)),
        bands: format!("{} intervals", before.percent()),
        series: before.of_unit(unit).zip(after.of_unit(unit)).enumerate().flat_map(each).collect(),
        ..Figure::default()
    })
}

/// The mean rates of blocks over their temperature with the fitted line, without the effects that are none of temperature.
fn rates(temperature: &Temperature, before: &Analysis, unit: Unit) -> Option<Figure> {
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
