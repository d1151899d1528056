//! The charts of `sagnac compare`.

use crate::analysis::compare::Ratio;
use sagnac_base::quantity::number::probability;
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::Deviation;
use sagnac_report::chart::figure::{Axis, Figure, Grouping, Limit, Series, SeriesPoint};

use crate::analysis::compare::logs::Analysis;
use crate::analysis::compare::rows::{Row, Verdict};
use crate::analysis::compare::words::{duration, times};
use crate::analysis::log::figures::{along, described, line, points};

/// Label of the times.
const TIME: &str = "averaging time τ";

/// Range of ratios below which the axis is linear.
const NARROW: f64 = 3.0;

/// The chart of both curves.
pub fn curves(analysis: &Analysis) -> Figure {
    let labels = analysis.labels();
    let fits = fits(analysis).unwrap_or_default();
    let series = |colour: usize| {
        let points = points(&analysis.comparison.curves[colour]).collect();
        Series { colour, dash: 0, points, law: fits[colour].clone() }
    };
    Figure {
        title: format!("Overlapping Allan deviations of {} and {}", labels[0], labels[1]),
        subtitle: Some(subtitle(analysis)),
        x: Axis::new(TIME, "s"),
        y: Axis::new("deviation σ(τ)", analysis.unit.symbol(Deviation::Oadev)),
        colours: Grouping::of("records", labels.map(str::to_owned)),
        points: measured(&fits[0]),
        bands: "95 % intervals".to_owned(),
        lines: "fit".to_owned(),
        series: [0, 1].map(series).into(),
        ..Figure::default()
    }
}

/// The chart of the ratio of the second curve to the first.
pub fn ratio(analysis: &Analysis) -> Figure {
    let [a, b] = analysis.labels();
    let point = |ratio: &Ratio| {
        let band = ratio.interval.map(|ends| (ends[0], ends[1]));
        Some(SeriesPoint { x: ratio.tau_s(), y: ratio.value?, band, key: None })
    };
    let points: Vec<SeriesPoint> = analysis.comparison.ratios.iter().filter_map(point).collect();
    let ends = points.iter().flat_map(|point| point.band.map_or([point.y; 2], |(low, high)| [low, high]));
    let y = of_ratios("ratio of the deviations", ends);
    let law = of_fits(&fits(analysis).unwrap_or_default());
    Figure {
        title: format!("{b} over {a}: ratio of overlapping Allan deviations"),
        subtitle: Some(found(analysis)),
        x: Axis::new(TIME, "s"),
        y,
        colours: Grouping::of("ratio", [format!("{b} / {a}")]),
        points: measured(&law),
        bands: "95 % interval".to_owned(),
        lines: "ratio of the fits".to_owned(),
        series: vec![Series { colour: 0, dash: 0, points, law }],
        limit: Some(Limit { value: 1.0, label: "equal".to_owned() }),
        ..Figure::default()
    }
}

/// The axis of ratios to 1. It is linear over a narrow range, where a logarithmic axis would have hardly a tick above 1.
pub(crate) fn of_ratios(label: &str, ratios: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = ratios.fold((1.0_f64, 1.0_f64), |(low, high), end| (low.min(end), high.max(end)));
    let scale = if high < NARROW * low { Scale::Linear } else { Scale::Log };
    Axis { scale, ..Axis::new(label, "") }
}

/// A line by its points.
type Line = Vec<(f64, f64)>;

/// The curves of the fits of both records over the τ on which they were fitted.
fn fits(analysis: &Analysis) -> Option<[Line; 2]> {
    let fits = analysis.comparison.fits()?;
    Some([0, 1].map(|i| {
        let points = described(&fits[i], &analysis.comparison.curves[i]);
        let longest = points.partition_point(|point| point.tau_s < 1.01 * fits[i].tau_range[1]);
        line(&fits[i].process, Deviation::Oadev, &points[..longest], analysis.sides[i].samples)
    }))
}

/// The second line over the first, at the times of the first that the second spans.
fn of_fits([a, b]: &[Line; 2]) -> Line {
    a.iter().filter_map(|&(tau_s, of_a)| Some((tau_s, along(b, tau_s)? / of_a))).collect()
}

/// Name of the points in the legend, needed where there is a fit too.
fn measured(fit: &Line) -> String {
    if fit.is_empty() { String::new() } else { "measured".to_owned() }
}

/// The lengths of both records and their treatment.
fn subtitle(analysis: &Analysis) -> String {
    let of = |i: usize| format!("{}: {}", analysis.sides[i].label, duration(analysis.sides[i].length_s()));
    format!("{}; {}; {}", of(0), of(1), analysis.treatment().summary())
}

/// The verdicts in a few words.
fn found(analysis: &Analysis) -> String {
    let rows = analysis.rows.iter().flatten();
    let of = |row: &Row| {
        let ratio = times(row.found.ratio?, 3);
        let open = if row.verdict() == Verdict::Consistent { ", not significant" } else { "" };
        Some(format!("{}: {ratio} ({}{open})", row.name, probability(row.found.p?)))
    };
    let coefficients = rows.filter_map(of);
    let same = analysis.comparison.same.map(|same| format!("same noise in both: {}", probability(same.p)));
    let all: Vec<String> = coefficients.chain(same).collect();
    if all.is_empty() { subtitle(analysis) } else { all.join("; ") }
}

#[cfg(test)]
mod tests {
    use std::iter::successors;
    use std::path::Path;

    use super::*;
    use crate::analysis::log::Treatment;
    use sagnac_records::allan::Trend;
    use sagnac_records::fit::{Term, Terms};
    use sagnac_records::record::log::channel::Log;
    use sagnac_records::record::log::check::UnitCheck;
    use sagnac_records::record::log::measure::{Data, Unit};

    #[test]
    fn fits_are_drawn_over_the_times_on_which_they_were_fitted() {
        let log = |seed: u64| {
            let numbers = successors(Some(seed), |n| Some(16_807 * n % 2_147_483_647));
            let rates = numbers.map(|n| n as f64 / 2_147_483_647.0 - 0.5).take(4096).collect();
            Log::of_column("gz", Data::Rate, Unit::parse("deg/h", Data::Rate).unwrap(), 1.0, rates)
        };
        let (a, b) = (log(1), log(2));
        let treatment = Treatment {
            skip_s: 0.0,
            until_s: None,
            trend: Trend::None,
            outliers_removed: false,
            events_removed: false,
            unit_check: UnitCheck::Off,
            is_compensated: false,
        };
        let fitting = Terms::Given(vec![Term::AngleRandomWalk]).into();
        let logs = [(Path::new("a.csv"), &a), (Path::new("b.csv"), &b)];
        let analysis = Analysis::of(logs, &treatment, Some(&fitting)).unwrap();
        for (series, fit) in curves(&analysis).series.iter().zip(analysis.comparison.fits().unwrap()) {
            let [from_s, to_s] = fit.tau_range;
            assert_eq!((series.law[0].0, series.law.last().unwrap().0), (from_s, to_s));
            assert!(series.points.last().unwrap().x > to_s, "{to_s} s");
        }
    }
}
