//! Records themselves: their facts, and charts of their samples.

use std::ops::Range;

use crate::allan::Deviation;
use crate::analysis::log::{Analysis, Column};
use crate::analysis::page::answer::in_unit;
use crate::analysis::page::trace::{extremes, means};
use crate::key::scale::Scale;
use crate::quantity::number::significant;
use crate::record::log::channel::{Channel, Log};
use crate::record::log::measure::Data;
use crate::record::log::outliers::Outliers;
use crate::view::chart::figure::{Axis, Entry, Figure, Grouping, Law, LawLine, Series, SeriesPoint};
use crate::view::chart::picture::Picture;
use crate::view::picture::Drawn;
use crate::view::report::sections::{Block, Section};

/// Most stretches of a chart, over all of its records and of each.
const MOST_PARTS: [usize; 2] = [6000, 1000];
/// Most gaps that a chart marks; a chart has no room for more.
const MOST_MARKED: usize = 200;

/// A record to draw.
pub(crate) struct Recorded<'a> {
    pub name: &'a str,
    pub log: &'a Log,
    pub channel: &'a Channel,
    pub outliers: &'a Outliers,
    pub gaps: &'a [Range<usize>],
}

/// The section on the record of a log.
pub(crate) fn section(log: &Log, analysis: &Analysis) -> Section {
    let recorded = log.channels.iter().zip(&analysis.columns).map(|(channel, column)| {
        let Column { name, outliers, gaps, .. } = column;
        Recorded { name, log, channel, outliers, gaps }
    });
    let mut blocks = charts(&recorded.collect::<Vec<_>>());
    blocks.push(Block::Facts(facts(analysis)));
    Section { id: "record", heading: "Record", blocks }
}

fn facts(analysis: &Analysis) -> Vec<(&'static str, Vec<String>)> {
    let of = |said: &dyn Fn(&Column) -> Option<String>| {
        by_name(analysis.columns.iter().filter_map(|column| Some((&*column.name, said(column)?))).collect())
    };
    let mean = |column: &Column| Some(in_unit(column.mean_rate?, column.unit.symbol(Deviation::Oadev)));
    let facts = [
        ("File", vec![analysis.path.display().to_string()]),
        ("Samples", vec![sampling(analysis.samples, analysis.step_s)]),
        ("Treatment", vec![analysis.treatment.effect(analysis.length_s())]),
        ("Mean", of(&mean)),
        ("Gaps", of(&|column| Some(gaps(&column.gaps, analysis.step_s, |sample| analysis.time(sample))))),
        ("Outliers", of(&|column| Some(outliers(&column.outliers, |sample| analysis.time(sample))))),
    ];
    facts.into_iter().filter(|(_, lines)| !lines.is_empty()).collect()
}

/// The number of samples and their spacing.
pub(crate) fn sampling(samples: usize, step_s: f64) -> String {
    format!("{samples}, one every {} s ({} Hz)", significant(step_s, 9), significant(1.0 / step_s, 7))
}

/// The gaps of a record in words.
pub(crate) fn gaps(gaps: &[Range<usize>], step_s: f64, time: impl Fn(usize) -> f64) -> String {
    let Some(longest) = gaps.iter().max_by_key(|gap| gap.len()) else { return "none".to_owned() };
    let missing: usize = gaps.iter().map(Range::len).sum();
    let (length, at) = (significant(longest.len() as f64 * step_s, 4), significant(time(longest.start), 9));
    match gaps.len() {
        1 => format!("one of {length} s, {missing} samples, at {at} s"),
        count => format!("{count} with {missing} samples, the longest of {length} s at {at} s"),
    }
}

/// The outliers of a record in words.
pub(crate) fn outliers(outliers: &Outliers, time: impl Fn(usize) -> f64) -> String {
    match &outliers.samples[..] {
        [] => "none".to_owned(),
        [only] => format!("one at {} s", significant(time(*only), 9)),
        [first, .., last] => {
            let [first, last] = [first, last].map(|&sample| significant(time(sample), 9));
            format!("{}, the first at {first} s, the last at {last} s", outliers.samples.len())
        }
    }
}

/// A line for each name, or one for all if they say the same.
pub(crate) fn by_name(said: Vec<(&str, String)>) -> Vec<String> {
    match &said[..] {
        [] => vec![],
        [(_, only)] => vec![only.clone()],
        [(_, first), others @ ..] if others.iter().all(|(_, other)| other == first) => {
            vec![format!("each column: {first}")]
        }
        _ => said.into_iter().map(|(name, text)| format!("{name}: {text}")).collect(),
    }
}

/// The charts of some records, two for each of their units: the extremes, and the means less their mean.
pub(crate) fn charts(records: &[Recorded]) -> Vec<Block> {
    let mut units: Vec<&str> = records.iter().map(|record| &*record.channel.unit.text).collect();
    units.sort_unstable();
    units.dedup();
    let of_unit = |unit: &str| {
        let alike = |(_, record): &(usize, &Recorded)| record.channel.unit.text == unit;
        let records: Vec<(usize, &Recorded)> = records.iter().enumerate().filter(alike).collect();
        [of_samples(&records), of_means(&records)]
    };
    let stem =
        |(at, drawn): (usize, Drawn)| Block::Trace(Drawn { stem: format!("record-{}", at + 1), ..drawn });
    units.into_iter().flat_map(of_unit).enumerate().map(stem).collect()
}

/// The samples themselves, of many the least and the largest of each stretch.
fn of_samples(records: &[(usize, &Recorded)]) -> Drawn {
    let parts = parts(records);
    let series = |(colour, record): &(usize, &Recorded), size: f64| {
        let increments = record.values();
        let mut last = 0.0;
        let point = |place: Option<usize>| {
            if let Some(sample) = place {
                last = record.time(sample as f64) / size;
            }
            SeriesPoint { x: last, y: place.map_or(f64::NAN, |sample| increments[sample]), band: None }
        };
        let points = extremes(&increments, parts).into_iter().map(point).collect();
        Series { colour: *colour, dash: 0, points, law: vec![] }
    };
    let thinned = stretch(records, parts);
    let note =
        thinned.map(|length| format!("The least and the largest sample of every {length} s are drawn."));
    Drawn { note, ..drawn(records, "As recorded", &series) }
}

/// Means of stretches of the samples without outliers, less the mean of the whole.
fn of_means(records: &[(usize, &Recorded)]) -> Drawn {
    let parts = (parts(records) / 2).max(1);
    let series = |(colour, record): &(usize, &Recorded), size: f64| {
        let mut values = record.values().into_owned();
        record.outliers.samples.iter().for_each(|&sample| values[sample] = f64::NAN);
        let whole = means(&values, 1).first().and_then(|(_, mean)| *mean).unwrap_or(0.0);
        let point = |(samples, mean): (Range<usize>, Option<f64>)| SeriesPoint {
            x: record.time(0.5 * (samples.start + samples.end) as f64) / size,
            y: mean.map_or(f64::NAN, |mean| mean - whole),
            band: None,
        };
        let points = means(&values, parts).into_iter().map(point).collect();
        Series { colour: *colour, dash: 0, points, law: vec![] }
    };
    let title = match stretch(records, parts) {
        Some(length) => format!("Means over {length} s without outliers, less the mean of the record"),
        None => "Samples without outliers, less the mean of the record".to_owned(),
    };
    drawn(records, &title, &series)
}

/// A chart over time with the gaps of its records.
fn drawn(
    records: &[(usize, &Recorded)],
    title: &str,
    series: &dyn Fn(&(usize, &Recorded), f64) -> Series,
) -> Drawn {
    let end_s =
        records.iter().map(|(_, record)| record.time(record.values().len() as f64)).fold(0.0, f64::max);
    let (size, unit) = time_unit(end_s);
    let series: Vec<Series> = records.iter().map(|record| series(record, size)).collect();
    let linear = |label: &str, unit: &str| Axis { scale: Scale::Linear, ..Axis::new(label, unit) };
    let entry = |(style, record): &(usize, &Recorded)| Entry { style: *style, name: record.name.to_owned() };
    let (label, unit_of_values) = records.first().map_or(("", ""), |(_, record)| record.axis());
    let figure = Figure {
        title: title.to_owned(),
        x: linear("time", unit),
        y: linear(label, unit_of_values),
        colours: Grouping {
            title: if records.len() > 1 { "columns" } else { "column" }.to_owned(),
            entries: records.iter().map(entry).collect(),
        },
        laws: marks(records, &series, size).into_iter().collect(),
        series,
        ..Figure::default()
    };
    Drawn { stem: String::new(), picture: Picture::Curves(figure), note: None }
}

/// A stripe over the whole height at the start and at the end of each gap, of many of the longest; `None` without gaps.
fn marks(records: &[(usize, &Recorded)], series: &[Series], size: f64) -> Option<Law> {
    let ys =
        || series.iter().flat_map(|series| &series.points).map(|point| point.y).filter(|y| y.is_finite());
    let (low, high) = (ys().reduce(f64::min)?, ys().reduce(f64::max)?);
    let mut gaps: Vec<[f64; 2]> = records
        .iter()
        .flat_map(|(_, record)| {
            record.gaps.iter().map(|gap| [gap.start, gap.end].map(|sample| record.time(sample as f64) / size))
        })
        .collect();
    gaps.sort_by(|a, b| (b[1] - b[0]).total_cmp(&(a[1] - a[0])).then(a[0].total_cmp(&b[0])));
    gaps.dedup();
    gaps.truncate(MOST_MARKED);
    let points: Vec<(f64, f64)> =
        gaps.iter().flatten().flat_map(|&at| [(at, low), (at, high), (f64::NAN, f64::NAN)]).collect();
    let line = LawLine { colours: vec![], points };
    (!line.points.is_empty()).then(|| Law { label: "gaps".to_owned(), lines: vec![line] })
}

/// The number of stretches of each record in a chart.
fn parts(records: &[(usize, &Recorded)]) -> usize {
    (MOST_PARTS[0] / records.len().max(1)).clamp(1, MOST_PARTS[1])
}

/// The length of a stretch, s; `None` where it is a sample.
fn stretch(records: &[(usize, &Recorded)], parts: usize) -> Option<String> {
    let length = |record: &Recorded| record.values().len() as f64 / parts as f64;
    let (_, longest) = records.iter().max_by(|a, b| length(a.1).total_cmp(&length(b.1)))?;
    (length(longest) > 1.0).then(|| significant(length(longest) * longest.log.step_s, 3))
}

/// Size and name of the unit of a time axis.
fn time_unit(end_s: f64) -> (f64, &'static str) {
    match end_s {
        ..600.0 => (1.0, "s"),
        ..10_800.0 => (60.0, "min"),
        ..345_600.0 => (3600.0, "h"),
        _ => (86_400.0, "days"),
    }
}

impl Recorded<'_> {
    fn values(&self) -> std::borrow::Cow<'_, [f64]> {
        self.channel.view(self.log.data, self.log.step_s).increments()
    }

    /// What the values are, and their unit.
    fn axis(&self) -> (&'static str, &str) {
        let label = match self.log.data {
            Data::Rate => self.channel.unit.curves.measured(),
            Data::Increment => "increment",
            Data::Angle => "increment of the angle",
        };
        let unit = &self.channel.unit.text;
        (label, if unit == "none" { "" } else { unit })
    }

    /// Time of a sample from the start of the file, s.
    pub(crate) fn time(&self, sample: f64) -> f64 {
        self.log.start_s + sample * self.log.step_s
    }
}
