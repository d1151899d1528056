//! Tables and charts of a comparison.

use crate::analysis::compare::answer::times;
use crate::analysis::compare::logs::{Analysis, Row, Verdict};
use crate::analysis::compare::{Length, Ratio};
use crate::analysis::given_curve;
use crate::analysis::log::figures::{along, line, points};
use crate::analysis::log::report::{Record, text};
use crate::analysis::log::{self, figures};
use sagnac_base::quantity::number::probability;
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::Deviation;
use sagnac_report::chart::figure::{Axis, Figure, Grouping, Limit, Series, SeriesPoint};

/// A result of two logs: a row of `compare.csv` or of `coefficients.csv`.
pub(crate) struct Line<'a, T> {
    found: &'a T,
    unit: &'a str,
    logs: [&'a str; 2],
}

/// The columns of `compare.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn ratio_columns<'a>() -> Vec<ColumnOf<Line<'a, Ratio>>> {
    type Of<'a> = ColumnOf<Line<'a, Ratio>>;
    vec![
        Of::new("tau", Unit::S, "tau", |row| Cell::Number(row.found.tau_s()))
            .is(Role::Coordinate, "Averaging time τ, s."),
        Of::new("m_a", Unit::NONE, "m of A", |row| factor(row.found, 0))
            .is(Role::Count, "Averaging time in samples of A."),
        Of::new("m_b", Unit::NONE, "m of B", |row| factor(row.found, 1))
            .is(Role::Count, "Averaging time in samples of B."),
        Of::new("a", Unit::NONE, "A", |row| row.found.points[0].value.into())
            .is(Role::Error, "Overlapping Allan deviation of A, in `unit`."),
        Of::new("b", Unit::NONE, "B", |row| row.found.points[1].value.into())
            .is(Role::Error, "Overlapping Allan deviation of B, in `unit`."),
        Of::new("ratio", Unit::NONE, "ratio", |row| row.found.value.into())
            .is(Role::Estimate, "Value of B divided by that of A."),
        Of::new("lower", Unit::NONE, "lower", |row| row.found.interval.map(|ends| ends[0]).into())
            .is_of("ratio", Role::Lower, "Lower end of the 95 % interval of `ratio`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.found.interval.map(|ends| ends[1]).into())
            .is_of("ratio", Role::Upper, "Upper end of the 95 % interval of `ratio`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.unit))
            .is(Role::Note, "Unit of `a` and `b`."),
        Of::new("p", Unit::NONE, "p", |row| row.found.p.into())
            .is(Role::Estimate, "Probability that a ratio is at least as far from 1 by chance if both have the same noise."),
        Of::new("status", Unit::NONE, "status", |row| text(&row.found.verdict().map_or_else(String::new, |verdict| verdict.text(row.logs[1]))))
            .is(Role::Note, "`consistent`, or the label of B with `higher` or `lower`, as in `after higher`, at 95 %."),
        log_a(),
        log_b(),
    ]
}

/// The averaging factor of a side; a curve that was read has none.
fn factor(ratio: &Ratio, side: usize) -> Cell {
    match ratio.points[side].m {
        0 => Cell::Blank,
        m => Cell::Integer(m as i64),
    }
}

/// The table of all ratios, `compare.csv`.
pub fn ratios(analysis: &Analysis) -> Table {
    let unit = analysis.unit.in_files(Deviation::Oadev);
    let rows = analysis.comparison.ratios.iter().map(|found| (found, unit));
    table(analysis.labels(), &ratio_columns(), rows)
}

/// The columns of `coefficients.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn coefficient_columns<'a>() -> Vec<ColumnOf<Line<'a, Row>>> {
    type Of<'a> = ColumnOf<Line<'a, Row>>;
    vec![
        Of::new("coefficient", Unit::NONE, "coefficient", |row| text(row.found.name))
            .is(Role::Key, "Q, N, B, K, R of data sheets, `markov`, `markov_time`, `sine`, `sine_frequency`, L."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.unit))
            .is(Role::Note, "Unit of `a`, `b` and `difference`."),
        Of::new("a", Unit::NONE, "A", |row| row.found.found.values[0].into())
            .is(Role::Estimate, "The coefficient of A; blank where its record does not show it."),
        Of::new("b", Unit::NONE, "B", |row| row.found.found.values[1].into())
            .is(Role::Estimate, "The coefficient of B; blank where its record does not show it."),
        Of::new("difference", Unit::NONE, "difference", |row| row.found.found.difference.into())
            .is(Role::Estimate, "Value of B minus that of A."),
        Of::new("lower", Unit::NONE, "lower", |row| row.found.found.interval[0].into())
            .is_of("difference", Role::Lower, "Lower end of the 95 % interval of `difference`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.found.found.interval[1].into())
            .is_of("difference", Role::Upper, "Upper end of the 95 % interval of `difference`."),
        Of::new("p", Unit::NONE, "p", |row| row.found.found.p.into())
            .is(Role::Estimate, "Probability that a difference is at least as large by chance if both have the same coefficient."),
        Of::new("length_needed", Unit::S, "length_needed", |row| needed(row.found.length).into())
            .is(Role::Estimate, "Length of records, s, that resolves such a difference with 90 % power."),
        Of::new("status", Unit::NONE, "status", |row| text(&row.found.verdict().text(row.logs[1])))
            .is(Role::Note, "`consistent`, `equal`, `in neither record`, `not compared` if a side lacks it or an event explains it as well, or the label of B with \
                `higher` or `lower`, as in `after higher`."),
        Of::new("ratio", Unit::NONE, "ratio", |row| row.found.found.ratio.into())
            .is(Role::Estimate, "Value of B divided by that of A."),
        Of::new("ratio_lower", Unit::NONE, "ratio_lower", |row| row.found.found.ratio_interval[0].into())
            .is_of("ratio", Role::Lower, "Lower end of the 95 % interval of `ratio`."),
        Of::new("ratio_upper", Unit::NONE, "ratio_upper", |row| row.found.found.ratio_interval[1].into())
            .is_of("ratio", Role::Upper, "Upper end of the 95 % interval of `ratio`."),
        Of::new("a_at_most", Unit::NONE, "A at most", |row| row.found.found.at_most[0].into())
            .is(Role::Estimate, "Upper bound on the coefficient of A, if its record does not show it."),
        Of::new("b_at_most", Unit::NONE, "B at most", |row| row.found.found.at_most[1].into())
            .is(Role::Estimate, "Upper bound on the coefficient of B, if its record does not show it."),
        Of::new("length_beyond", Unit::S, "length_beyond", |row| beyond(row.found.length).into())
            .is(Role::Estimate, "Length of records, s, up to which none was found that would distinguish such values."),
        Of::new("described", Unit::NONE, "described", |row| text(described(row.found.described, row.logs)))
            .is(Role::Note, "Whose curve the fit describes: `both`, `neither` or the label of a log; the coefficients of the others were forced."),
        log_a(),
        log_b(),
    ]
}

fn log_a<'a, T>() -> ColumnOf<Line<'a, T>> {
    ColumnOf::new("log_a", Unit::NONE, "first log", |row: &Line<'a, T>| text(row.logs[0])).is(
        Role::Note,
        "Label of A, the first log: the name of its file, with the column or the path where names are alike.",
    )
}

fn log_b<'a, T>() -> ColumnOf<Line<'a, T>> {
    ColumnOf::new("log_b", Unit::NONE, "second log", |row: &Line<'a, T>| text(row.logs[1]))
        .is(Role::Note, "Label of B, the second log.")
}

/// The table of all coefficients, `coefficients.csv`.
pub fn coefficients(analysis: &Analysis) -> Table {
    let rows = analysis.rows.iter().flatten().map(|found| (found, found.unit));
    table(analysis.labels(), &coefficient_columns(), rows)
}

/// The table of some results with their units. Labels of columns have the labels of the logs in place of A and B.
fn table<'a, T: Sync>(
    logs: [&'a str; 2],
    columns: &[ColumnOf<Line<'a, T>>],
    rows: impl Iterator<Item = (&'a T, &'a str)>,
) -> Table {
    let rows: Vec<Line<'a, T>> = rows.map(|(found, unit)| Line { found, unit, logs }).collect();
    let mut columns = columns_of(columns, &rows);
    for column in &mut columns {
        let own = ['A', 'B'].into_iter().zip(logs).find(|(letter, _)| column.label.contains(*letter));
        column.label =
            own.map_or_else(|| column.label.clone(), |(letter, log)| column.label.replace(letter, log));
    }
    Table { columns }
}

fn described(of: [bool; 2], logs: [&str; 2]) -> &str {
    match of {
        [true, true] => "both",
        [true, false] => logs[0],
        [false, true] => logs[1],
        [false, false] => "neither",
    }
}

fn needed(length: Length) -> Option<f64> {
    if let Length::Needed(length_s) = length { Some(length_s) } else { None }
}

/// The length up to which none was found to suffice.
fn beyond(length: Length) -> Option<f64> {
    if let Length::Beyond(length_s) = length { Some(length_s) } else { None }
}

/// The records of the logs: `records.csv`.
pub fn records(analysis: &Analysis) -> Table {
    log::report::records(analysis.logs().map(|(log, label)| Record {
        mean: None,
        slope: None,
        ..Record::new(log, &log.columns[0], label)
    }))
}

/// Label of the times.
const TIME: &str = "averaging time τ";

/// Range of ratios below which the axis is linear.
const NARROW: f64 = 3.0;

/// The kind of the deviations: that of records is overlapping, a curve may be another.
fn of_allan(analysis: &Analysis) -> &'static str {
    if analysis.is_of_logs() { "Overlapping Allan" } else { "Allan" }
}

/// The chart of both curves.
pub fn curves(analysis: &Analysis) -> Figure {
    let labels = analysis.labels();
    let fits = fits(analysis).unwrap_or_default();
    let series = |colour: usize| {
        let points = points(&analysis.comparison.curves[colour]).collect();
        Series { colour, dash: 0, points, law: fits[colour].clone() }
    };
    Figure {
        title: format!("{} deviations of {} and {}", of_allan(analysis), labels[0], labels[1]),
        subtitle: Some(subtitle(analysis)),
        x: Axis::new(TIME, "s"),
        y: Axis::new("deviation σ(τ)", analysis.unit.symbol(Deviation::Oadev)),
        colours: Grouping::new("records", labels.map(str::to_owned)),
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
        title: format!(
            "{b} over {a}: ratio of {} deviations",
            of_allan(analysis).replace("Overlapping", "overlapping")
        ),
        subtitle: Some(found(analysis)),
        x: Axis::new(TIME, "s"),
        y,
        colours: Grouping::new("ratio", [format!("{b} / {a}")]),
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
type ChartLine = Vec<(f64, f64)>;

/// The curves of the fits of both sides over the τ on which they were fitted.
fn fits(analysis: &Analysis) -> Option<[ChartLine; 2]> {
    let fits = analysis.comparison.fits()?;
    Some([0, 1].map(|i| match analysis.sides[i].log() {
        Some(log) => {
            let points = figures::described(&fits[i], &analysis.comparison.curves[i]);
            let longest = points.partition_point(|point| point.tau_s < 1.01 * fits[i].tau_range[1]);
            line(&fits[i].process, Deviation::Oadev, &points[..longest], log.samples)
        }
        None => given_curve::line(&fits[i].process.parts, fits[i].tau_range),
    }))
}

/// The second line over the first, at the times of the first that the second spans.
fn of_fits([a, b]: &[ChartLine; 2]) -> ChartLine {
    a.iter().filter_map(|&(tau_s, of_a)| Some((tau_s, along(b, tau_s)? / of_a))).collect()
}

/// Name of the points in the legend, needed where there is a fit too.
fn measured(fit: &ChartLine) -> String {
    if fit.is_empty() { String::new() } else { "measured".to_owned() }
}

/// The kinds of both sides, and the treatment of records.
fn subtitle(analysis: &Analysis) -> String {
    let sides = analysis.sides.iter().map(|side| format!("{}: {}", side.label, side.extent()));
    sides.chain(analysis.treatment().map(|treatment| treatment.summary())).collect::<Vec<_>>().join("; ")
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
    use crate::analysis::compare::logs::Compared;
    use crate::analysis::log::Treatment;
    use sagnac_records::fit::{Term, Terms};
    use sagnac_records::record::log::Log;
    use sagnac_records::record::log::measure::{Data, Unit};

    #[test]
    fn fits_are_drawn_over_the_times_on_which_they_were_fitted() {
        let log = |seed: u64| {
            let numbers = successors(Some(seed), |n| Some(16_807 * n % 2_147_483_647));
            let rates = numbers.map(|n| n as f64 / 2_147_483_647.0 - 0.5).take(4096).collect();
            Log::of_column("gz", Data::Rate, Unit::parse("deg/h", Data::Rate).unwrap(), 1.0, rates)
        };
        let (a, b) = (log(1), log(2));
        let fitting = Terms::Given(vec![Term::AngleRandomWalk]).into();
        let logs = [(Path::new("a.csv"), Compared::Log(&a)), (Path::new("b.csv"), Compared::Log(&b))];
        let analysis = Analysis::of(logs, &Treatment::AS_RECORDED, Some(&fitting)).unwrap();
        for (series, fit) in curves(&analysis).series.iter().zip(analysis.comparison.fits().unwrap()) {
            let [from_s, to_s] = fit.tau_range;
            assert_eq!((series.law[0].0, series.law.last().unwrap().0), (from_s, to_s));
            assert!(series.points.last().unwrap().x > to_s, "{to_s} s");
        }
    }
}
