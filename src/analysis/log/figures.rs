//! The charts of `sagnac allan`.

use sagnac_base::quantity::number::{joined, significant};
use sagnac_base::table::{between, crossing_fraction};
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::{Deviation, Point, Unit};
use sagnac_records::fit::{Fit, Quantity};
use sagnac_report::answer::reading::capitalized;
use sagnac_report::chart::figure::{self, Axis, Figure, Grouping, Mark, Parts, Series, SeriesPoint};
use sagnac_theory::allan::terms::Shape;
use sagnac_theory::allan::{Part, Process, Term};

use crate::analysis::compare::estimate::SAME;
use crate::analysis::log::events::are_left_out;
use crate::analysis::log::report::{heading, in_run_bias_stability};
use crate::analysis::log::{Analysis, Column, Curve};

/// Points of a line per octave of τ: of a sine, whose hump has ripples, and of any other term.
const PLACES: [f64; 2] = [64.0, 12.0];
/// Most ripples of a sine's own line; further ones would fill the picture below the curve.
const MAX_RIPPLES: f64 = 8.0;

/// The figures with the stems of their file names: for each unit one for deviations of the rate or acceleration, and one for
/// those of the angle or velocity.
pub fn figures(analysis: &Analysis) -> Vec<(String, Figure)> {
    let of = |of_angle: bool| {
        let wanted = move |deviation: Deviation| deviation.is_of_angle() == of_angle;
        move |unit| figure(analysis, unit, &wanted)
    };
    [per_unit(analysis, "chart", of(false)), per_unit(analysis, "chart-tdev", of(true))].concat()
}

/// The figures of each unit: that of the first unit has the `stem` itself, those of further units an ending.
pub(crate) fn per_unit(
    analysis: &Analysis,
    stem: &str,
    figure: impl Fn(Unit) -> Option<Figure>,
) -> Vec<(String, Figure)> {
    let of = |(place, unit): (usize, Unit)| {
        let ending = match unit {
            _ if place == 0 => "",
            Unit::Acceleration => "-accelerometers",
            Unit::Angular | Unit::Plain => "-numbers",
        };
        Some((format!("{stem}{ending}"), figure(unit)?))
    };
    analysis.units().enumerate().filter_map(of).collect()
}

/// The columns of a log as the colours of a chart.
pub(crate) fn of_columns(names: impl Iterator<Item = String>) -> Grouping {
    let names: Vec<String> = names.collect();
    Grouping::new(if names.len() > 1 { "columns" } else { "column" }, names)
}

/// The figure of the `wanted` deviations of the columns of a unit; `None` without any.
fn figure(analysis: &Analysis, unit: Unit, wanted: &dyn Fn(Deviation) -> bool) -> Option<Figure> {
    let all: Vec<&Column> = analysis.of_unit(unit).collect();
    let first = *all.first()?;
    let deviations: Vec<Deviation> =
        first.curves.iter().map(|curve| curve.deviation).filter(|deviation| wanted(*deviation)).collect();
    let [deviation, others @ ..] = &deviations[..] else { return None };
    let names: Vec<String> = deviations.iter().map(|deviation| deviation.name().to_owned()).collect();
    let title = match others {
        [] => capitalized(deviation.title()),
        _ => format!("Deviations {}", names.join(", ")),
    };
    let several = all.len() > 1;
    let columns = all.iter().map(|column| column.name.clone());
    let columns = of_columns(columns);
    let names = Grouping::new("deviations", names);
    // With one column, colours distinguish the deviations instead of the columns.
    let (colours, dashes) = match (others.is_empty(), several) {
        (true, false) => (Grouping::default(), Grouping::default()),
        (true, true) => (columns, Grouping::default()),
        (false, true) => (columns, names),
        (false, false) => (names, Grouping::default()),
    };
    let of_column = |(colour, column): (usize, &&Column)| {
        let curves = column.curves.iter().filter(|curve| wanted(curve.deviation)).enumerate();
        curves
            .map(|(dash, curve)| match several {
                true => series(analysis, column, curve, (colour, dash)),
                false => series(analysis, column, curve, (dash, 0)),
            })
            .collect::<Vec<_>>()
    };
    let series: Vec<Series> = all.iter().enumerate().flat_map(of_column).collect();
    let is_without_events = all.iter().any(|column| are_left_out(analysis, column));
    let terms = if several { vec![] } else { terms(analysis, first, &deviations) };
    let is_fitted = series.iter().any(|series| !series.law.is_empty());
    Some(Figure {
        title,
        subtitle: Some(format!("{}; {}", heading(analysis), analysis.treatment.summary())),
        x: Axis::new("averaging time τ", "s"),
        y: Axis::new("deviation σ(τ)", unit.symbol(*deviation)),
        colours,
        dashes,
        points: if is_fitted { "measured".to_owned() } else { String::new() },
        bands: format!("{} intervals", analysis.percent()),
        lines: if is_without_events { "fit without events" } else { "fit" }.to_owned(),
        series,
        marks: if several { vec![] } else { marks(analysis, first, &terms, wanted) },
        slopes: !deviation.is_of_angle(),
        parts: parts(first, &deviations, terms),
        ..Figure::default()
    })
}

/// The measured deviations over those of the fit, of the single column with one; the panel below its curve.
pub fn residuals(analysis: &Analysis) -> Option<Figure> {
    let [column] = &analysis.columns[..] else { return None };
    let (fit, curve) =
        (&column.noise()?.fit, column.curves.first().filter(|curve| !curve.deviation.is_of_angle())?);
    if curve.deviation.is_modified() || !curve.deviation.is_of_differences() {
        return None;
    }
    let point = |point: &Point| {
        let estimator = curve.deviation.estimator();
        let expected =
            libm::sqrt(fit.process.expected(estimator, analysis.samples as u64, point.m as u64)?);
        let band = point.interval.map(|(lower, upper)| (lower / expected, upper / expected));
        Some(SeriesPoint { x: point.tau_s, y: point.value? / expected, band, key: None })
    };
    let points: Vec<SeriesPoint> = described(fit, &curve.points).iter().filter_map(point).collect();
    let (first, last) = (points.first()?.x, points.last()?.x);
    Some(Figure {
        title: "Residuals of the fit".to_owned(),
        x: Axis::new("averaging time τ", "s"),
        y: Axis { scale: Scale::Linear, ..Axis::new("measured / fit", "") },
        points: "measured".to_owned(),
        bands: format!("{} intervals", analysis.percent()),
        lines: "fit".to_owned(),
        series: vec![Series { colour: 0, dash: 0, points, law: vec![(first, 1.0), (last, 1.0)] }],
        is_panel: true,
        ..Figure::default()
    })
}

/// The coefficients on the lines of their terms, the bias instability where the fit is least, and the minimum of the curve; each with
/// its value as in the answer.
fn marks(
    analysis: &Analysis,
    column: &Column,
    terms: &[(Term, figure::Part)],
    wanted: &dyn Fn(Deviation) -> bool,
) -> Vec<Mark> {
    let Some(curve) = column.curves.iter().find(|curve| wanted(curve.deviation)) else { return vec![] };
    let total = column
        .noise()
        .map(|noise| line(&noise.fit.process, curve.deviation, &curve.points, analysis.samples));
    let plateau =
        total.and_then(|line| line.into_iter().min_by(|a, b| a.1.total_cmp(&b.1))).map(|place| place.0);
    let coefficient = |(term, part): &(Term, figure::Part)| {
        let row =
            column.coefficients().iter().find(|row| row.name == term.symbol() && row.value.is_some())?;
        let tau_s = if *term == Term::BiasInstability { plateau } else { term.read_at() };
        let place = (tau_s?, along(&part.points, tau_s?)?);
        let label = match term {
            // The plateau is this much lower.
            Term::BiasInstability => format!("0.664 B, B {}", row.cell().text),
            _ => format!("{} {}", term.symbol(), row.cell().text),
        };
        Some(Mark { shape: figure::Shape::Coefficient, place, range: None, label })
    };
    let minimum = curve.minimum.and_then(|least| {
        let row = in_run_bias_stability(column.unit, curve.deviation, &least);
        // Where the curve still falls, its label is an upper bound.
        let y = if least.at_end { least.point.interval?.1 } else { least.point.value? };
        let place = (least.point.tau_s, y);
        Some(Mark {
            shape: figure::Shape::Extremum,
            place,
            range: None,
            label: format!("minimum {}", row.cell().text),
        })
    });
    terms.iter().filter_map(coefficient).chain(minimum).collect()
}

/// The value of a line at x, where it is known. A place that differs from an end by the rate of a clock alone is that end.
pub(crate) fn along(line: &[(f64, f64)], x: f64) -> Option<f64> {
    let [first, last] = [line.first()?.0, line.last()?.0];
    let is_at = |end: f64| (x / end - 1.0).abs() < SAME;
    let x = if is_at(first) || is_at(last) { x.clamp(first, last) } else { x };
    let after = line.partition_point(|place| place.0 < x * (1.0 - 1e-9));
    let (to, value) = *line.get(after)?;
    if (to / x - 1.0).abs() < 1e-9 {
        return Some(value);
    }
    let (from, before) = *line.get(after.checked_sub(1)?)?;
    Some(between(before, value, crossing_fraction(from, to, x)))
}

fn series(analysis: &Analysis, column: &Column, curve: &Curve, (colour, dash): (usize, usize)) -> Series {
    let law = column.noise().map(|noise| {
        let points = described(&noise.fit, &curve.points);
        line(&noise.fit.process, curve.deviation, points, analysis.samples)
    });
    Series { colour, dash, points: points(&curve.points).collect(), law: law.unwrap_or_default() }
}

/// The known deviations of a curve with their intervals.
pub(crate) fn points(points: &[Point]) -> impl Iterator<Item = SeriesPoint> {
    let point = |point: &Point| {
        Some(SeriesPoint { x: point.tau_s, y: point.value?, band: point.interval, key: None })
    };
    points.iter().filter_map(point)
}

/// The points of a curve from the shortest τ that the fit describes on; none where it describes none.
pub fn described<'a>(fit: &Fit, points: &'a [Point]) -> &'a [Point] {
    let first = points.partition_point(|point| point.tau_s < 0.99 * fit.tau_range[0]);
    if fit.is_described() { &points[first..] } else { &[] }
}

/// The expected deviation of a process over the times of a curve; empty where there is no closed form.
pub fn line(process: &Process, deviation: Deviation, points: &[Point], samples: usize) -> Vec<(f64, f64)> {
    if deviation.is_modified() || !deviation.is_of_differences() {
        return vec![];
    }
    let shown: Vec<f64> =
        points.iter().filter(|point| point.value.is_some()).map(|point| point.m as f64).collect();
    let [Some(&first), Some(&last)] = [shown.first(), shown.last()] else { return vec![] };
    let is_rippled = process.parts.iter().any(|part| part.term == Term::Sine);
    let octave = if is_rippled { PLACES[0] } else { PLACES[1] };
    let count = libm::ceil(octave * libm::log2(last / first)) as u32;
    let place = |i: u32| libm::round(first * libm::exp2(f64::from(i) / octave)).min(last) as u64;
    let mut ms: Vec<u64> = (0..=count).map(place).collect();
    ms.dedup();
    let at = |m: u64| {
        let variance = process.expected(deviation.estimator(), samples as u64, m)?;
        Some((process.sample_s * m as f64, libm::sqrt(variance)))
    };
    ms.into_iter().filter_map(at).collect()
}

/// The curve of the Allan deviation of a column among those of a figure.
fn allan<'a>(column: &'a Column, deviations: &[Deviation]) -> Option<&'a Curve> {
    column.curves.iter().find(|curve| {
        deviations.contains(&curve.deviation) && matches!(curve.deviation, Deviation::Adev | Deviation::Oadev)
    })
}

/// The lines of the terms of the fit of the single column, where its Allan deviation is among those of a figure.
fn terms(analysis: &Analysis, column: &Column, deviations: &[Deviation]) -> Vec<(Term, figure::Part)> {
    let (Some(curve), Some(noise)) = (allan(column, deviations), column.noise()) else { return vec![] };
    let of = |part: &Part| {
        // The contribution of a band limit is negative.
        let coefficient = noise.fit.coefficient(part.term).filter(|found| found.term != Term::BandLimit)?;
        let process = Process { sample_s: analysis.step_s, parts: vec![*part] };
        let points = described(&noise.fit, &curve.points);
        let mut points = line(&process, curve.deviation, points, analysis.samples);
        if part.term == Term::Sine {
            points.retain(|(tau_s, _)| part.shape * tau_s <= MAX_RIPPLES);
        }
        let label = label(part, Quantity::Coefficient(part.term).unit(column.unit));
        let is_known = coefficient.value.is_some();
        // Earlier colours are those of the curves and of the fit.
        let colour = deviations.len() + 1 + Term::ALL.iter().position(|other| *other == part.term)?;
        let label = if is_known { label } else { format!("{label}, not identified") };
        Some((part.term, figure::Part { label, colour, points }))
    };
    noise.fit.process.parts.iter().filter_map(of).collect()
}

/// The terms for the legend.
fn parts(column: &Column, deviations: &[Deviation], terms: Vec<(Term, figure::Part)>) -> Parts {
    let title = match (deviations, allan(column, deviations)) {
        ([_, _, ..], Some(curve)) => format!("parts of the fit of {}", curve.deviation.name()),
        _ => "parts of the fit".to_owned(),
    };
    Parts { title, lines: terms.into_iter().map(|(_, part)| part).collect() }
}

/// A label such as `N = 0.003 °/√h`.
pub(crate) fn label(part: &Part, (factor, _, unit): (f64, &str, &str)) -> String {
    let shown = |value: f64| significant(value, 3);
    let value = joined(&shown(factor * part.size), unit);
    // No-break spaces keep each value with its unit.
    let text = match part.term.shape() {
        Some(Shape { letters: [size, letter], unit, .. }) => {
            format!("{size} = {value}, {letter} = {}", joined(&shown(part.shape), unit))
        }
        None => format!("{} = {value}", part.term.symbol()),
    };
    text.trim_end().replace(' ', "\u{a0}").replace(",\u{a0}", ", ").replace(":\u{a0}", ": ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_known_up_to_an_end_that_another_clock_puts_elsewhere() {
        let line = [(1.0, 4.0), (4.0, 2.0)];
        assert_eq!([0.999_99, 1.0, 4.0, 4.000_04].map(|x| along(&line, x)), [4.0, 4.0, 2.0, 2.0].map(Some));
        assert_eq!([0.99, 4.1].map(|x| along(&line, x)), [None; 2]);
        assert!(along(&line, 2.0).is_some_and(|value| (2.0..4.0).contains(&value)));
    }
}
