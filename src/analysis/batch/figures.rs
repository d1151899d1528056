//! The charts of `sagnac compare`.

use sagnac_base::quantity::number::probability;
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::Deviation;
use sagnac_report::chart::figure::{Axis, Entry, Figure, Grouping, Law, LawLine, Limit, Series, SeriesPoint};

use crate::analysis::batch::{Batch, Coefficient, Found};
use crate::analysis::compare::figures::of_ratios;
use crate::analysis::compare::words::duration;
use crate::analysis::log;
use crate::analysis::log::figures::points;

/// Distance of neighbouring coefficients of a unit, where units are 1 apart, and the most that all of them take.
const APART: f64 = 0.12;
const WIDEST: f64 = 0.7;

/// The chart of the curves of all units, with the outliers in colours of their own.
pub fn curves(batch: &Batch) -> Figure {
    let outliers = batch.outliers();
    let colour = |unit: usize| outliers.iter().position(|other| *other == unit).map_or(0, |place| place + 1);
    let mut series = Vec::new();
    for (unit, (_, column)) in batch.units().enumerate() {
        let points = column.curves.iter().take(1).flat_map(|curve| points(&curve.points));
        let points = points.map(|point| SeriesPoint { band: None, ..point });
        series.push(Series { colour: colour(unit), dash: 0, points: points.collect(), law: vec![] });
    }
    // Outliers are drawn over the others.
    series.sort_by_key(|series| series.colour);
    let like = batch.labels.len() - outliers.len();
    let others = match outliers.len() {
        0 => format!("{like} units"),
        _ => format!("{like} other units"),
    };
    let others = (like > 0).then_some(Entry { style: 0, name: others });
    let named = outliers
        .iter()
        .map(|&unit| Entry { style: colour(unit), name: format!("{}, outlier", batch.labels[unit]) });
    let unit = batch.units().next().map_or("", |(_, column)| column.unit.symbol(Deviation::Oadev));
    Figure {
        title: format!("Overlapping Allan deviations of a batch of {} units", batch.labels.len()),
        subtitle: Some(subtitle(batch)),
        x: Axis::new("averaging time τ", "s"),
        y: Axis::new("deviation σ(τ)", unit),
        colours: Grouping { title: "units".to_owned(), entries: others.into_iter().chain(named).collect() },
        series,
        ..Figure::default()
    }
}

/// The chart of all coefficients of all units as parts of the values of the batch without outliers; `None` where nothing is pooled.
pub fn coefficients(batch: &Batch) -> Option<Figure> {
    let shown: Vec<(&Coefficient, f64, [f64; 2])> = batch
        .coefficients
        .iter()
        .filter_map(|one| one.without_outliers.or(one.pooled).map(|batch| (one, batch.value, batch.next)))
        .collect();
    if shown.is_empty() {
        return None;
    }
    let apart = APART.min(WIDEST / shown.len() as f64);
    let across = |unit: usize, place: usize| {
        (unit + 1) as f64 + apart * (place as f64 - 0.5 * (shown.len() - 1) as f64)
    };
    let series = shown.iter().enumerate().map(|(place, (one, value, _))| {
        let point = |(unit, found): (usize, &Found)| {
            let band = found.row.interval.map(|[lower, upper]| (lower / value, upper / value));
            found.estimate()?;
            Some(SeriesPoint { x: across(unit, place), y: found.row.value? / value, band, key: None })
        };
        Series { colour: place, dash: 0, points: one.shown().filter_map(point).collect(), law: vec![] }
    });
    let series: Vec<Series> = series.collect();
    let ends = [0.5, batch.labels.len() as f64 + 0.5];
    let lines = shown.iter().enumerate().flat_map(|(place, (_, value, next))| {
        next.map(|end| LawLine { colours: vec![place], points: ends.map(|x| (x, end / value)).into() })
    });
    let values = series.iter().flat_map(|series| &series.points).map(|point| point.y);
    let y = of_ratios("value over that of the batch", values);
    Some(Figure {
        title: format!("Coefficients of {} units over those of the batch", batch.labels.len()),
        subtitle: Some(found(batch)),
        x: Axis { scale: Scale::Linear, whole: true, names: batch.labels.clone(), ..Axis::new("unit", "") },
        y,
        colours: Grouping::of("coefficients", shown.iter().map(|(one, ..)| one.title())),
        bands: "95 % intervals".to_owned(),
        laws: vec![Law {
            label: "95 % prediction interval".to_owned(),
            lines: lines.collect(),
            is_area: false,
        }],
        limit: Some(Limit { value: 1.0, label: "the batch".to_owned() }),
        series,
        ..Figure::default()
    })
}

/// The lengths of the records and their treatment.
pub(crate) fn subtitle(batch: &Batch) -> String {
    let lengths = batch.logs.iter().map(log::Analysis::length_s);
    let (shortest, longest) =
        lengths.fold((f64::INFINITY, 0.0_f64), |(low, high), s| (low.min(s), high.max(s)));
    let of = if longest > 1.01 * shortest { format!(" to {}", duration(longest)) } else { String::new() };
    let treatment = batch.treatment();
    format!("records of {}{of}; {treatment}", duration(shortest))
}

/// The outliers in a few words.
fn found(batch: &Batch) -> String {
    let of = |one: &Coefficient| {
        let outliers = one.outliers().map(|(unit, found, outliers)| {
            let p = found.p.map_or_else(String::new, |p| format!(" ({})", probability(p)));
            format!("{}: {} {}{p}", batch.labels[unit], one.title(), outliers.name())
        });
        outliers.collect::<Vec<_>>()
    };
    let outliers: Vec<String> = batch.coefficients.iter().flat_map(of).collect();
    if outliers.is_empty() { "no unit is an outlier".to_owned() } else { outliers.join("; ") }
}
