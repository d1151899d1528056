//! The charts of the dependence on temperature.

use crate::allan::{Deviation, Point};
use crate::analysis::log::notes::heading;
use crate::analysis::log::{self, Analysis};
use crate::analysis::temperature::effect::Effect;
use crate::analysis::temperature::{Column, Dependence, Temperature};
use crate::key::scale::Scale;
use crate::view::chart::figure::{Axis, Figure, Grouping, Series, SeriesPoint};

/// Places of a fitted line.
const PLACES: u32 = 100;

/// Stems of the file names of figures.
pub const STEMS: [&str; 2] = ["chart-temperature", "chart-rate"];

/// The figures with the stems of their file names: the deviation before and after compensation, and the rate over temperature.
pub fn figures(
    temperature: &Temperature,
    before: &Analysis,
    after: &Analysis,
) -> [(&'static str, Option<Figure>); 2] {
    let [deviation, rate] = STEMS;
    [(deviation, deviations(before, after)), (rate, rates(temperature, before))]
}

fn columns(names: impl ExactSizeIterator<Item = String>) -> Grouping {
    Grouping::of(if names.len() > 1 { "columns" } else { "column" }, names)
}

/// The first deviation of each column before and after, with intervals after.
fn deviations(before: &Analysis, after: &Analysis) -> Option<Figure> {
    let first = before.columns.first()?;
    let deviation = first.curves.first()?.deviation;
    let colours = columns(before.columns.iter().map(|column| column.name.clone()));
    let series = |colour: usize, dash: usize, column: &log::Column| {
        let point = |point: &Point| {
            let band = point.interval.filter(|_| dash == 1);
            Some(SeriesPoint { x: point.tau_s, y: point.value?, band })
        };
        let points =
            column.curves.first().map_or(vec![], |curve| curve.points.iter().filter_map(point).collect());
        Series { colour, dash, points, law: vec![] }
    };
    let each = |(colour, (before, after))| [series(colour, 0, before), series(colour, 1, after)];
    Some(Figure {
        title: "Deviation before and after compensation".to_owned(),
        subtitle: Some(format!("{}; {}", heading(before), deviation.title())),
        x: Axis::new("averaging time τ", "s"),
        y: Axis::new("deviation σ(τ)", first.unit.symbol(deviation)),
        colours,
        dashes: Grouping::of("record", ["before", "after"].map(str::to_owned)),
        bands: format!("{} intervals", before.percent()),
        series: before.columns.iter().zip(&after.columns).enumerate().flat_map(each).collect(),
        ..Figure::default()
    })
}

/// The mean rates of blocks over their temperature with the fitted line, without the effects that are none of temperature.
fn rates(temperature: &Temperature, before: &Analysis) -> Option<Figure> {
    let found: Vec<(&Column, &Dependence)> =
        temperature.columns.iter().filter_map(|column| Some((column, column.found.as_ref().ok()?))).collect();
    let (first, _) = found.first()?;
    let series = |(colour, (_, found)): (usize, &(&Column, &Dependence))| {
        let mut points = found.points();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let [low, high] = found.averages.range_c;
        let place = |i| low + (high - low) * f64::from(i) / f64::from(PLACES);
        let at = |x: f64| found.model.offset + found.model.at(x - found.averages.reference_c).value;
        Series { colour, dash: 0, points, law: (0..=PLACES).map(|i| (place(i), at(place(i)))).collect() }
    };
    Some(Figure {
        title: "Rate over temperature".to_owned(),
        subtitle: Some(format!(
            "{}; without warm-up, aging and the change of the temperature",
            heading(before)
        )),
        x: Axis { scale: Scale::Linear, ..Axis::new("temperature", "°C") },
        y: Axis { scale: Scale::Linear, ..Axis::new("rate", first.unit.symbol(Deviation::Oadev)) },
        colours: columns(found.iter().map(|(column, _)| column.name.clone())),
        points: "means of blocks".to_owned(),
        lines: "fit".to_owned(),
        series: found.iter().enumerate().map(series).collect(),
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
        temperatures.zip(rates).map(|(x, y)| SeriesPoint { x, y, band: None }).collect()
    }
}
