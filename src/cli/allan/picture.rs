//! The charts of `sagnac allan`.

use sagnac::allan::Deviation;
use sagnac::chart::{Axis, Entry, Figure, Grouping, Scale, Series, SeriesPoint};

use super::analysis::{Analysis, Column, Curve};
use super::report::heading;

/// The figures with the stems of their files: one for deviations of the rate, one for those of the angle.
pub fn figures(analysis: &Analysis) -> Vec<(&'static str, Option<Figure>)> {
    [("chart", false), ("chart-tdev", true)]
        .map(|(stem, of_angle)| (stem, figure(analysis, &|deviation| deviation.is_of_angle() == of_angle)))
        .into()
}

/// The deviations that are `wanted`; `None` without any.
fn figure(analysis: &Analysis, wanted: &dyn Fn(Deviation) -> bool) -> Option<Figure> {
    let first = analysis.columns.first()?;
    let deviations: Vec<Deviation> =
        first.curves.iter().map(|curve| curve.deviation).filter(|deviation| wanted(*deviation)).collect();
    let [deviation, others @ ..] = &deviations[..] else { return None };
    let several_deviations =
        deviations.iter().map(|deviation| deviation.name()).collect::<Vec<_>>().join(", ");
    let title = if others.is_empty() {
        capitalised(deviation.title())
    } else {
        format!("Deviations {several_deviations}")
    };
    let entries = |names: Vec<String>| {
        names.into_iter().enumerate().map(|(style, name)| Entry { style, name }).collect()
    };
    let several = analysis.columns.len() > 1;
    let columns = Grouping {
        title: if several { "columns".to_owned() } else { "column".to_owned() },
        entries: entries(analysis.columns.iter().map(|column| column.name.clone()).collect()),
    };
    let names = Grouping {
        title: "deviations".to_owned(),
        entries: entries(deviations.iter().map(|deviation| deviation.name().to_owned()).collect()),
    };
    // One column needs no colours of its own: they tell the deviations apart.
    let (colours, dashes) = match (others.is_empty(), several) {
        (true, _) => (columns, Grouping::default()),
        (false, true) => (columns, names),
        (false, false) => (names, Grouping::default()),
    };
    let of_column = |(colour, column): (usize, &Column)| {
        let curves = column.curves.iter().filter(|curve| wanted(curve.deviation)).enumerate();
        curves
            .map(|(dash, curve)| match several {
                true => series(curve, colour, dash),
                false => series(curve, dash, 0),
            })
            .collect::<Vec<_>>()
    };
    Some(Figure {
        title,
        subtitle: Some(format!("{}; {}", heading(analysis), analysis.treatment.summary())),
        x: axis("averaging time τ", "s"),
        y: axis("deviation σ(τ)", first.unit.symbol(*deviation)),
        colours,
        dashes,
        points: String::new(),
        bands: format!("{} intervals", analysis.percent()),
        series: analysis.columns.iter().enumerate().flat_map(of_column).collect(),
        laws: vec![],
        limit: None,
        chosen: vec![],
    })
}

fn axis(label: &str, unit: &str) -> Axis {
    Axis { label: label.to_owned(), unit: unit.to_owned(), scale: Scale::Log, whole: false }
}

fn series(curve: &Curve, colour: usize, dash: usize) -> Series {
    let points = curve
        .points
        .iter()
        .filter_map(|point| Some(SeriesPoint { x: point.tau_s, y: point.value?, band: point.interval }));
    Series { colour, dash, points: points.collect(), law: vec![] }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
