//! Records themselves: their facts, and charts of their samples.

use std::borrow::Cow;
use std::ops::Range;

use crate::analysis::log::{Analysis, Column, Treatment};
use crate::analysis::page::in_unit;
use crate::view::Drawn;
use sagnac_base::quantity::number::significant;
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::{Deviation, Trend, Unit as Curves};
use sagnac_records::events::{Event, What};
use sagnac_records::record::log::measure::{Data, Unit};
use sagnac_records::record::log::outliers::Outliers;
use sagnac_records::record::log::{Channel, Log};
use sagnac_report::chart::Picture;
use sagnac_report::chart::figure::{Axis, Entry, Figure, Grouping, Law, LawLine, Series, SeriesPoint};
use sagnac_report::page::{Block, Section};

/// Most stretches of all records together, which leaves room for the other charts of a page, and of each record.
const MAX_PARTS: [usize; 2] = [4000, 1000];

/// A record to draw.
struct Recorded<'a> {
    pub name: &'a str,
    pub log: &'a Log,
    pub unit: &'a Unit,
    /// Rates, or increments.
    pub values: Cow<'a, [f64]>,
    pub outliers: &'a Outliers,
    pub gaps: &'a [Range<usize>],
    /// Outliers and samples of events that are treated as gaps.
    pub removed: Vec<usize>,
}

/// A column of a log with its analysis, as a section shows it.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    /// Name of the record.
    pub name: &'a str,
    pub log: &'a Log,
    pub channel: &'a Channel,
    pub analysis: &'a Analysis,
    pub column: &'a Column,
}

/// The section on some records, which its legend calls `columns` or `records`; `treatment` says what was done to all of them.
pub(crate) fn section(
    heading: &'static str,
    sources: &[Source],
    called: &str,
    treatment: Vec<String>,
) -> Section {
    let recorded = sources.iter().map(|one| {
        let Column { outliers, gaps, events, .. } = one.column;
        let Treatment { events_removed, outliers_removed, .. } = one.analysis.treatment;
        let removed = removed(outliers, outliers_removed, if events_removed { events } else { &[] });
        Recorded::new(one.name, one.log, one.channel, outliers, gaps, removed)
    });
    let mut blocks = charts(&recorded.collect::<Vec<_>>(), called);
    blocks.push(Block::Facts(facts(sources, treatment)));
    Section::new("record", heading, blocks)
}

fn facts(sources: &[Source], treatment: Vec<String>) -> Vec<(&'static str, Vec<String>)> {
    let of = |text: &dyn Fn(&Source) -> Option<String>| {
        by_name(sources.iter().filter_map(|one| Some((one.name, text(one)?))).collect())
    };
    let mean = |column: &Column| Some(in_unit(column.mean_rate?, column.unit.symbol(Deviation::Oadev)));
    let is_linear = |one: &Source| one.analysis.treatment.trend == Trend::Linear;
    let gaps = |one: &Source| gaps(&one.column.gaps, one.analysis.step_s, |sample| one.analysis.time(sample));
    let facts = [
        ("File", of(&|one| Some(one.analysis.path.display().to_string()))),
        ("Samples", of(&|one| Some(sampling(one.analysis.samples, one.analysis.step_s)))),
        ("Treatment", treatment),
        ("Mean", of(&|one| mean(one.column))),
        ("Removed trend", of(&|one| is_linear(one).then(|| slope(one.column)))),
        ("Gaps", of(&|one| Some(gaps(one)))),
        ("Outliers", of(&|one| Some(outliers(&one.column.outliers, |sample| one.analysis.time(sample))))),
    ];
    facts.into_iter().filter(|(_, lines)| !lines.is_empty()).collect()
}

/// The slope that was removed, with its unit.
fn slope(column: &Column) -> String {
    let (factor, unit) = match column.unit {
        Curves::Angular => (3600.0, "°/h/h"),
        Curves::Acceleration => (3600.0, "µg/h"),
        Curves::Plain => (1.0, "1/s"),
    };
    in_unit(factor * column.slope, unit)
}

/// The number of samples and their spacing.
fn sampling(samples: usize, step_s: f64) -> String {
    format!("{samples}, one every {} s ({} Hz)", significant(step_s, 9), significant(1.0 / step_s, 7))
}

/// The gaps of a record in words.
fn gaps(gaps: &[Range<usize>], step_s: f64, time: impl Fn(usize) -> f64) -> String {
    let Some(longest) = gaps.iter().max_by_key(|gap| gap.len()) else { return "none".to_owned() };
    let missing: usize = gaps.iter().map(Range::len).sum();
    let (length, at) = (significant(longest.len() as f64 * step_s, 4), significant(time(longest.start), 9));
    match gaps.len() {
        1 => format!("one of {length} s, {missing} samples, at {at} s"),
        count => format!("{count} with {missing} samples, the longest of {length} s at {at} s"),
    }
}

/// The outliers of a record in words.
fn outliers(outliers: &Outliers, time: impl Fn(usize) -> f64) -> String {
    match &outliers.samples[..] {
        [] => "none".to_owned(),
        [only] => format!("one at {} s", significant(time(*only), 9)),
        [first, .., last] => {
            let [first, last] = [first, last].map(|&sample| significant(time(sample), 9));
            format!("{}, the first at {first} s, the last at {last} s", outliers.samples.len())
        }
    }
}

/// A line for each name, or a single one if all say the same.
pub(crate) fn by_name(said: Vec<(&str, String)>) -> Vec<String> {
    match &said[..] {
        [(_, first), others @ ..] if others.iter().all(|(_, other)| other == first) => vec![first.clone()],
        _ => said.into_iter().map(|(name, text)| format!("{name}: {text}")).collect(),
    }
}

/// The charts of some records, two for each of their units: the extremes, and the means less their mean. The legend calls
/// them `columns` or `records`.
fn charts(records: &[Recorded], called: &str) -> Vec<Block> {
    let mut of_units: Vec<Vec<(usize, &Recorded)>> = Vec::new();
    for (at, record) in records.iter().enumerate() {
        let is_alike = |unit: &Unit| (unit.curves, unit.factor) == (record.unit.curves, record.unit.factor);
        match of_units.iter_mut().find(|alike| is_alike(alike[0].1.unit)) {
            Some(alike) => alike.push((at, record)),
            None => of_units.push(vec![(at, record)]),
        }
    }
    let parts = (MAX_PARTS[0] / records.len().max(1)).clamp(2, MAX_PARTS[1]);
    let of_unit = |alike| [of_samples(alike, called, parts), of_means(alike, called, parts / 2)];
    let drawn = of_units.iter().flat_map(|alike| of_unit(alike));
    let stem = |(at, drawn)| Block::Trace(Drawn { stem: format!("record-{}", at + 1), ..drawn });
    drawn.enumerate().map(stem).collect()
}

/// The samples themselves, of many the least and the largest of each stretch.
fn of_samples(records: &[(usize, &Recorded)], called: &str, parts: usize) -> Drawn {
    let series = |(colour, record): &(usize, &Recorded), size: f64| {
        let mut last = 0.0;
        let point = |place: Option<usize>| {
            if let Some(sample) = place {
                last = record.time(sample as f64) / size;
            }
            SeriesPoint {
                x: last,
                y: place.map_or(f64::NAN, |sample| record.values[sample]),
                band: None,
                key: None,
            }
        };
        let points = extremes(&record.values, parts).into_iter().map(point).collect();
        Series { colour: *colour, dash: 0, points, law: vec![] }
    };
    let thinned = stretch(records, parts);
    let note =
        thinned.map(|length| format!("The least and the largest sample of every {length} s are drawn."));
    Drawn { note, ..drawn(records, called, parts, "As recorded", &series) }
}

/// Means of stretches of the samples without outliers, less the mean of the whole.
fn of_means(records: &[(usize, &Recorded)], called: &str, parts: usize) -> Drawn {
    let series = |(colour, record): &(usize, &Recorded), size: f64| {
        let mut values = record.values.to_vec();
        record.outliers.samples.iter().for_each(|&sample| values[sample] = f64::NAN);
        let whole = means(&values, 1).first().and_then(|(_, mean)| *mean).unwrap_or(0.0);
        let point = |(samples, mean): (Range<usize>, Option<f64>)| SeriesPoint {
            x: record.time(0.5 * (samples.start + samples.end) as f64) / size,
            y: mean.map_or(f64::NAN, |mean| mean - whole),
            band: None,
            key: None,
        };
        let points = means(&values, parts).into_iter().map(point).collect();
        Series { colour: *colour, dash: 0, points, law: vec![] }
    };
    let title = match stretch(records, parts) {
        Some(length) => format!("Means over {length} s without outliers, less the mean of the record"),
        None => "Samples without outliers, less the mean of the record".to_owned(),
    };
    drawn(records, called, parts, &title, &series)
}

/// A chart over time with the gaps of its records.
fn drawn(
    records: &[(usize, &Recorded)],
    called: &str,
    parts: usize,
    title: &str,
    series: &dyn Fn(&(usize, &Recorded), f64) -> Series,
) -> Drawn {
    let end_s = records.iter().map(|(_, record)| record.time(record.values.len() as f64)).fold(0.0, f64::max);
    let (size, unit) = time_unit(end_s);
    let series: Vec<Series> = records.iter().map(|record| series(record, size)).collect();
    let linear = |label: &str, unit: &str| Axis { scale: Scale::Linear, ..Axis::new(label, unit) };
    let entry = |(style, record): &(usize, &Recorded)| Entry { style: *style, name: record.name.to_owned() };
    let (label, unit_of_values) = records[0].1.axis();
    let figure = Figure {
        title: title.to_owned(),
        x: linear("time", unit),
        y: linear(label, unit_of_values),
        colours: Grouping { title: called.to_owned(), entries: records.iter().map(entry).collect() },
        laws: marks(records, &series, size, parts),
        series,
        ..Figure::default()
    };
    Drawn { stem: String::new(), picture: Picture::Curves(figure), note: None }
}

/// Bars over the stretches of records: from below the share of samples that are missing, and from above that of outliers and samples
/// of events that are removed.
fn marks(records: &[(usize, &Recorded)], series: &[Series], size: f64, parts: usize) -> Vec<Law> {
    let ys =
        || series.iter().flat_map(|series| &series.points).map(|point| point.y).filter(|y| y.is_finite());
    let (Some(low), Some(high)) = (ys().reduce(f64::min), ys().reduce(f64::max)) else { return vec![] };
    let all = || records.iter().map(|(_, record)| record);
    let law = |count: usize, label: &str, is_lost: fn(&Recorded, usize) -> bool, [foot, top]: [f64; 2]| {
        let lines = records.iter().flat_map(|(style, record)| {
            let time = |sample: usize| record.time(sample as f64) / size;
            let shares = shares(record.values.len(), parts, |sample| is_lost(record, sample));
            let runs = shares.chunk_by(|a, b| (a.1 > 0.0) == (b.1 > 0.0)).filter(|run| run[0].1 > 0.0);
            let bars = runs.map(|run| {
                let ends = [run[0].0.start, run[run.len() - 1].0.end].map(|end| (time(end), foot));
                let over = run.iter().flat_map(|(samples, share)| {
                    [samples.start, samples.end].map(|end| (time(end), foot + share * (top - foot)))
                });
                let points = [ends[0]].into_iter().chain(over).chain([ends[1]]).collect();
                LawLine { colours: vec![*style], points }
            });
            bars.collect::<Vec<_>>()
        });
        (count > 0).then(|| Law { label: format!("{count} {label}"), lines: lines.collect(), is_area: true })
    };
    let missing = all().flat_map(|record| record.gaps).map(Range::len).sum();
    let removed = all().map(|record| record.removed.len()).sum();
    let is_missing = |record: &Recorded, sample: usize| record.values[sample].is_nan();
    let is_removed = |record: &Recorded, sample| record.removed.binary_search(&sample).is_ok();
    [
        law(missing, "missing, share from below", is_missing, [low, high]),
        law(removed, "removed, share from above", is_removed, [high, low]),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The length of a stretch, s; `None` where it is a sample.
fn stretch(records: &[(usize, &Recorded)], parts: usize) -> Option<String> {
    let length = |record: &Recorded| record.values.len() as f64 / parts as f64;
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

/// The samples that are treated as gaps, with these events removed, in their order.
fn removed(outliers: &Outliers, are_outliers_removed: bool, events: &[Event]) -> Vec<usize> {
    let bursts = events.iter().filter(|event| event.what == What::NoiseBurst);
    let bursts = bursts.filter_map(|event| event.samples).flat_map(|[from, to]| from..to);
    let is_removed = |sample: &usize| are_outliers_removed || Event::is_in(events, *sample);
    let mut samples: Vec<usize> = bursts.chain(outliers.samples.iter().copied().filter(is_removed)).collect();
    samples.sort_unstable();
    samples.dedup();
    samples
}

impl<'a> Recorded<'a> {
    fn new(
        name: &'a str,
        log: &'a Log,
        channel: &'a Channel,
        outliers: &'a Outliers,
        gaps: &'a [Range<usize>],
        mut removed: Vec<usize>,
    ) -> Recorded<'a> {
        let values = channel.view(log.data, log.step_s).increments();
        removed.retain(|&sample| values[sample].is_finite());
        Recorded { name, log, unit: &channel.unit, values, outliers, gaps, removed }
    }

    /// What the values are, and their unit.
    fn axis(&self) -> (&'static str, &str) {
        match (self.log.data, self.unit.curves) {
            (Data::Rate, Curves::Plain) => ("rate", ""),
            (_, Curves::Plain) => ("increment", ""),
            (Data::Rate, curves) => (curves.measured(), &self.unit.text),
            (_, Curves::Angular) => ("angle increment", &self.unit.text),
            (_, Curves::Acceleration) => ("velocity increment", &self.unit.text),
        }
    }

    /// Time of a sample from the start of the file, s.
    pub(crate) fn time(&self, sample: f64) -> f64 {
        self.log.start_s + sample * self.log.step_s
    }
}

/// The samples to draw: of each of at most `parts` stretches of equal length the least and the largest, in the order of
/// time. `None` stands for as many missing samples as a stretch has, where a line is interrupted.
pub(crate) fn extremes(values: &[f64], parts: usize) -> Vec<Option<usize>> {
    let of_part = |part: Range<usize>| {
        let known = || part.clone().filter(|&i| values[i].is_finite());
        let least = known().min_by(|&a, &b| values[a].total_cmp(&values[b]));
        let largest = known().max_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut both: Vec<usize> = least.into_iter().chain(largest).collect();
        both.sort_unstable();
        both.dedup();
        both
    };
    let length = (values.len() / parts).max(1);
    let has_gaps = values.iter().fold(false, |has, value| has | !value.is_finite());
    let is_gap = |run: &[f64]| run.len() >= length && !run[0].is_finite();
    let mut drawn: Vec<Option<usize>> = Vec::new();
    let mut from = 0;
    for place in stretches(values.len(), parts).flat_map(of_part) {
        if has_gaps && values[from..place].chunk_by(|a, b| a.is_finite() == b.is_finite()).any(is_gap) {
            drawn.push(None);
        }
        drawn.push(Some(place));
        from = place + 1;
    }
    drawn
}

/// The shares of lost samples in at most `parts` stretches of equal length, each with its samples.
pub(crate) fn shares(
    count: usize,
    parts: usize,
    is_lost: impl Fn(usize) -> bool,
) -> Vec<(Range<usize>, f64)> {
    let share = |part: Range<usize>| {
        let lost = part.clone().filter(|&i| is_lost(i)).count();
        (part.clone(), lost as f64 / part.len() as f64)
    };
    stretches(count, parts).map(share).collect()
}

/// The means of at most `parts` stretches of equal length, each with its samples; `None` where all are missing.
pub(crate) fn means(values: &[f64], parts: usize) -> Vec<(Range<usize>, Option<f64>)> {
    let mean = |part: Range<usize>| {
        let known = values[part.clone()].iter().filter(|value| value.is_finite());
        let (count, sum) = known.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
        (part, (count > 0.0).then(|| sum / count))
    };
    stretches(values.len(), parts).map(mean).collect()
}

fn stretches(count: usize, parts: usize) -> impl Iterator<Item = Range<usize>> {
    let parts = parts.min(count);
    // Products of 64 bits: WebAssembly has lengths of 32.
    let start = move |part: usize| (part as u64 * count as u64 / parts as u64) as usize;
    (0..parts).map(move |part| start(part)..start(part + 1))
}

#[cfg(test)]
mod record_tests {
    use super::*;

    #[test]
    fn bars_are_as_high_as_the_share_that_is_missing_or_removed() {
        let unit = Unit::parse("deg/s", Data::Rate).unwrap();
        let gaps = [1..2, 4..9];
        let mut values = vec![0.0; 40];
        gaps.iter().for_each(|gap| values[gap.clone()].fill(f64::NAN));
        let log = Log::of_column("gz", Data::Rate, unit, 0.5, values);
        let outliers = Outliers { samples: vec![31], ..Outliers::default() };
        let one = Recorded::new("gz", &log, &log.channels[0], &outliers, &gaps, vec![31]);
        let points = [0.0, 8.0].map(|y| SeriesPoint { x: 0.0, y, band: None, key: None }).into();
        let series = [Series { colour: 0, dash: 0, points, law: vec![] }];
        let [missing, removed] = &marks(&[(0, &one)], &series, 1.0, 10)[..] else { panic!() };
        assert_eq!(missing.label, "6 missing, share from below");
        let steps = [(0.0, 2.0), (2.0, 2.0), (2.0, 8.0), (4.0, 8.0), (4.0, 2.0), (6.0, 2.0)];
        let [bar] = &missing.lines[..] else { panic!("{missing:?}") };
        assert_eq!(bar.points, [&[(0.0, 0.0)], &steps[..], &[(6.0, 0.0)]].concat());
        assert_eq!(removed.label, "1 removed, share from above");
        assert_eq!(removed.lines[0].points, [(14.0, 8.0), (14.0, 6.0), (16.0, 6.0), (16.0, 8.0)]);
    }

    #[test]
    fn records_of_a_unit_share_charts_that_name_what_they_show() {
        for (data, units, expected) in [
            (Data::Rate, ["deg/s", "g", "dps"], [("rate", "deg/s"), ("acceleration", "g")]),
            (Data::Increment, ["none", "deg", "none"], [("increment", ""), ("angle increment", "deg")]),
            (Data::Angle, ["m/s", "deg", "m/s"], [("velocity increment", "m/s"), ("angle increment", "deg")]),
        ] {
            let channels = units.map(|unit| {
                let (name, unit) = (unit.to_owned(), Unit::parse(unit, data).unwrap());
                let samples = vec![1.0, 2.0, 4.0];
                Channel {
                    name,
                    unit,
                    unit_in_header: None,
                    is_unit_guessed: false,
                    samples,
                    place: None,
                    field: None,
                }
            });
            let (file, notes) = (String::new(), vec![]);
            let channels = channels.into();
            let log = Log {
                file,
                step_s: 1.0,
                data,
                start_s: 0.0,
                is_compensated: false,
                channels,
                temperature: None,
                thermometers: vec![],
                notes,
            };
            let outliers = Outliers { threshold: 1.0, ..Outliers::default() };
            let recorded =
                log.channels.iter().map(|one| Recorded::new(&one.name, &log, one, &outliers, &[], vec![]));
            let axes: Vec<(String, String)> = charts(&recorded.collect::<Vec<_>>(), "columns")
                .into_iter()
                .map(|block| match block {
                    Block::Trace(Drawn { picture: Picture::Curves(figure), .. }) => {
                        (figure.y.label, figure.y.unit)
                    }
                    other => panic!("{other:?}"),
                })
                .collect();
            let expected = expected.map(|(label, unit)| (label.to_owned(), unit.to_owned()));
            assert_eq!(axes, [&expected[0], &expected[0], &expected[1], &expected[1]].map(Clone::clone));
        }
    }
}

#[cfg(test)]
mod trace_tests {
    use super::*;

    const GAP: f64 = f64::NAN;

    #[test]
    fn spikes_survive_and_gaps_stay_open() {
        let mut values = vec![0.0; 1000];
        (values[333], values[334]) = (7.0, -7.0);
        values[550..650].fill(GAP);
        let drawn = extremes(&values, 10);
        assert!(drawn.contains(&Some(333)) && drawn.contains(&Some(334)), "{drawn:?}");
        assert_eq!(drawn.iter().filter(|place| place.is_none()).count(), 1, "{drawn:?}");
        let known: Vec<usize> = drawn.iter().flatten().copied().collect();
        assert!(known.is_sorted() && known.iter().all(|i| !(550..650).contains(i)), "{known:?}");
    }

    #[test]
    fn a_stretch_without_some_of_its_samples_is_no_gap() {
        let values: Vec<f64> = (0..1000).map(|i| if i % 25 == 7 { GAP } else { i as f64 }).collect();
        assert!(extremes(&values, 10).iter().all(Option::is_some), "{:?}", extremes(&values, 10));
    }

    #[test]
    fn shares_are_the_lost_parts_of_stretches() {
        let shares = shares(1000, 10, |i| i % 25 == 7 || (600..750).contains(&i));
        let expected = [0.04, 0.04, 0.04, 0.04, 0.04, 0.04, 1.0, 0.52, 0.04, 0.04];
        assert_eq!(shares.iter().map(|(_, share)| *share).collect::<Vec<f64>>(), expected);
        assert_eq!(shares[6].0, 600..700);
    }

    #[test]
    fn few_samples_are_all_drawn() {
        assert_eq!(extremes(&[1.0, GAP, 3.0], 10), [Some(0), None, Some(2)]);
        assert_eq!(extremes(&[], 10), []);
        assert_eq!(means(&[1.0, 3.0, GAP, GAP], 2), [(0..2, Some(2.0)), (2..4, None)]);
    }
}
