//! The charts of `sagnac model`.

use crate::analysis::log::figures::of_columns;
use crate::analysis::model::tables::lines;
use crate::analysis::model::{Aim, Analysis, Column};
use sagnac_records::allan::{Deviation, Unit};
use sagnac_report::chart::figure::{Axis, Figure, Law, LawLine, Part, Parts, Series, SeriesPoint};

/// Most points of a curve that are marked.
const MAX_POINTS: usize = 40;
/// Points of a line between two points of the curve.
const BETWEEN: u32 = 4;

/// The figures with the stems of their file names, one for each unit.
pub fn figures(analysis: &Analysis) -> Vec<(String, Figure)> {
    let first = analysis.columns.first().map(|column| column.target.unit);
    let further = Some(Unit::Acceleration).filter(|unit| first != Some(*unit));
    let of = |(unit, stem): (Option<Unit>, &str)| Some((stem.to_owned(), figure(analysis, unit?)?));
    [(first, "model"), (further, "model-accelerometers")].into_iter().filter_map(of).collect()
}

fn figure(analysis: &Analysis, unit: Unit) -> Option<Figure> {
    let all: Vec<&Column> = analysis.columns.iter().filter(|column| column.target.unit == unit).collect();
    let first = *all.first()?;
    let is_bound = analysis.asked.aim != Aim::Describe;
    let bound = |(colour, column): (usize, &&Column)| LawLine {
        colours: vec![colour],
        points: column
            .target
            .points
            .iter()
            .zip(&column.found.bounds)
            .map(|(point, bound)| (point.tau_s, *bound))
            .collect(),
    };
    let laws = Law {
        label: "bounded: the band of another record".to_owned(),
        lines: all.iter().enumerate().map(bound).collect(),
        is_area: false,
    };
    let title = match (analysis.asked.aim, unit) {
        (Aim::Describe, Unit::Acceleration) => "Acceleration noise for a filter",
        (Aim::Describe, _) => "Rate noise for a filter",
        (_, Unit::Acceleration) => "Acceleration noise for a filter, bounded",
        (_, _) => "Rate noise for a filter, bounded",
    };
    let has_band =
        all.iter().any(|column| column.target.points.iter().any(|point| point.lower < point.upper));
    Some(Figure {
        title: title.to_owned(),
        subtitle: Some(analysis.source.heading.clone()),
        x: Axis::new("averaging time τ", "s"),
        y: Axis::new("Allan deviation σ(τ)", unit.symbol(Deviation::Oadev)),
        colours: of_columns(all.iter().map(|column| column.target.name.clone())),
        points: if is_bound && !has_band { "curve".to_owned() } else { "record".to_owned() },
        bands: format!("{} intervals", analysis.percent()),
        lines: "model".to_owned(),
        series: all.iter().enumerate().map(|(colour, column)| series(colour, column)).collect(),
        laws: if analysis.asked.aim == Aim::BoundRepeat { vec![laws] } else { vec![] },
        parts: if all.len() > 1 { Parts::default() } else { parts(first) },
        ..Figure::default()
    })
}

fn series(colour: usize, column: &Column) -> Series {
    let points = &column.target.points;
    let step = points.len().div_ceil(MAX_POINTS).max(1);
    let shown = points.iter().step_by(step).map(|point| SeriesPoint {
        x: point.tau_s,
        y: point.value,
        band: (point.lower < point.upper).then_some((point.lower, point.upper)),
        key: None,
    });
    let law = taus(column).into_iter().map(|tau_s| (tau_s, column.found.model.deviation(tau_s)));
    Series { colour, dash: 0, points: shown.collect(), law: law.collect() }
}

/// The times of the curve, and some between them.
fn taus(column: &Column) -> Vec<f64> {
    let points = &column.target.points;
    let between = |pair: &[crate::analysis::model::target::Point]| {
        let (from_s, ratio) = (pair[0].tau_s, pair[1].tau_s / pair[0].tau_s);
        (0..BETWEEN)
            .map(move |i| from_s * libm::pow(ratio, f64::from(i) / f64::from(BETWEEN)))
            .collect::<Vec<_>>()
    };
    points.windows(2).flat_map(between).chain(points.last().map(|point| point.tau_s)).collect()
}

fn parts(column: &Column) -> Parts {
    let lines = lines(column, &taus(column)).into_iter().enumerate();
    // The first colour is that of the curve.
    let lines = lines.map(|(place, (label, points))| Part { label, colour: 1 + place, points });
    Parts { title: "parts of the model".to_owned(), lines: lines.collect() }
}
