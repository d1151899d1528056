//! The charts of `sagnac compare`.

use sagnac::allan::{Deviation, Point};
use sagnac::chart::{Axis, Entry, Figure, Grouping, Limit, Parts, Scale, Series, SeriesPoint};
use sagnac::table::significant;

use super::analysis::Analysis;
use super::rows::{Row, Verdict};
use super::words::{duration, probability};

/// Both curves.
pub fn curves(analysis: &Analysis) -> Figure {
    let labels = [0, 1].map(|i| analysis.sides[i].label.clone());
    let entries = [0, 1].map(|style| Entry { style, name: labels[style].clone() }).into();
    let series = |colour: usize| {
        let point = |point: &Point| {
            let positive = point.value.filter(|value| *value > 0.0)?;
            Some(SeriesPoint { x: point.tau_s, y: positive, band: point.interval })
        };
        let points = analysis.comparison.curves[colour].iter().filter_map(point).collect();
        Series { colour, dash: 0, points, law: vec![] }
    };
    Figure {
        title: format!("Overlapping Allan deviations of {} and {}", labels[0], labels[1]),
        subtitle: Some(subtitle(analysis)),
        x: time(),
        y: axis("deviation σ(τ)", analysis.unit.symbol(Deviation::Oadev)),
        colours: Grouping { title: "records".to_owned(), entries },
        dashes: Grouping::default(),
        points: String::new(),
        bands: "95 % intervals".to_owned(),
        lines: String::new(),
        series: [0, 1].map(series).into(),
        laws: vec![],
        parts: Parts::default(),
        limit: None,
        chosen: vec![],
    }
}

/// The second curve over the first.
pub fn ratio(analysis: &Analysis) -> Figure {
    let [a, b] = [0, 1].map(|i| analysis.sides[i].label.clone());
    let points = analysis.comparison.ratios.iter().filter_map(|ratio| {
        let band = ratio.interval.map(|ends| (ends[0], ends[1]));
        Some(SeriesPoint { x: ratio.tau_s(), y: ratio.value?, band })
    });
    Figure {
        title: format!("{b} over {a}: ratio of overlapping Allan deviations"),
        subtitle: Some(found(analysis)),
        x: time(),
        y: axis("ratio of the deviations", ""),
        colours: Grouping {
            title: "ratio".to_owned(),
            entries: vec![Entry { style: 0, name: format!("{b} / {a}") }],
        },
        dashes: Grouping::default(),
        points: String::new(),
        bands: "95 % interval".to_owned(),
        lines: String::new(),
        series: vec![Series { colour: 0, dash: 0, points: points.collect(), law: vec![] }],
        laws: vec![],
        parts: Parts::default(),
        limit: Some(Limit { value: 1.0, label: "equal".to_owned() }),
        chosen: vec![],
    }
}

/// How long both records are and what was done to them.
fn subtitle(analysis: &Analysis) -> String {
    let of = |i: usize| format!("{}: {}", analysis.sides[i].label, duration(analysis.sides[i].length_s()));
    format!("{}; {}; {}", of(0), of(1), analysis.treatment().summary())
}

/// The verdicts in a few words.
fn found(analysis: &Analysis) -> String {
    let rows = analysis.rows.iter().flatten();
    let of = |row: &Row| {
        let ratio = significant(row.found.ratio?, 3);
        let open = if row.verdict() == Verdict::NotToldApart { ", not told apart" } else { "" };
        Some(format!("{}: {ratio} ({}{open})", row.name, probability(row.found.p?)))
    };
    let coefficients = rows.filter_map(of);
    let same = analysis.comparison.same.map(|same| format!("same noise in both: {}", probability(same.p)));
    let all: Vec<String> = coefficients.chain(same).collect();
    if all.is_empty() { subtitle(analysis) } else { all.join("; ") }
}

fn time() -> Axis {
    axis("averaging time τ", "s")
}

fn axis(label: &str, unit: &str) -> Axis {
    Axis { label: label.to_owned(), unit: unit.to_owned(), scale: Scale::Log, whole: false }
}
