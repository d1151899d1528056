//! What a record shows besides noise: `events.csv`.

use std::cmp::Ordering;
use std::f64::consts::PI;
use std::ops::Range;

use crate::analysis::log::report::{key, text};
use crate::analysis::log::{Analysis, Column, Treatment};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_records::allan::{Deviation, Unit as Curves};
use sagnac_records::events::{Event, What};
use sagnac_theory::allan::Term;

/// A gap, an outlier or an event of a record with what was done with it: a row of `events.csv`.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The column of the log, or the log.
    record: String,
    unit: Curves,
    what: &'static str,
    time_s: Option<f64>,
    length_s: Option<f64>,
    /// Time from sample to sample, s.
    step_s: f64,
    /// Number of samples, or of events of which the row consists.
    count: usize,
    event: Option<Event>,
    /// The temperature or the record that it refers to.
    other: String,
    done: &'static str,
    /// The option that removes it from curves and spectra too.
    option: String,
}

impl Row {
    fn of_event<T>(&self, of: impl Fn(&Event) -> Option<T>) -> Option<T> {
        self.event.as_ref().and_then(of)
    }

    /// What the size is per, behind its unit.
    fn per(&self) -> &'static str {
        if self.of_event(|event| Some(event.what)) == Some(What::Temperature) { "/K" } else { "" }
    }

    /// Amplitude of a line before the rate is averaged over each sample, in the unit of `size`.
    fn unaveraged(&self) -> Option<f64> {
        let (size, frequency_hz) = self.of_event(|event| event.size.zip(event.frequency_hz))?;
        let half_turn = PI * frequency_hz * self.step_s;
        Some(size * half_turn / libm::sin(half_turn))
    }

    /// The event with what was done with it, in a few words, with the name of its record where there are several.
    pub(crate) fn brief(&self, is_named: bool) -> String {
        let of = if is_named { format!("{}: ", self.record) } else { String::new() };
        let done = self.done.replace("; ", ", ");
        let is_about = [SUBTRACTED, LEFT_OUT, REMOVED].iter().all(|usual| done != *usual);
        format!("{of}{} {}", self.what, if is_about { format!("({done})") } else { done })
    }
}

/// A record with what its rows need besides its events.
pub struct Record<'a> {
    /// The column of the log, or the log.
    pub name: &'a str,
    /// Unit of its curves.
    pub unit: Curves,
    /// Treatment of the log.
    pub treatment: &'a Treatment,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Whether events stay in the record.
    pub keeps_events: bool,
    /// Names of the columns of temperature.
    pub thermometers: &'a [String],
}

impl Record<'_> {
    fn row(&self, what: &'static str, samples: Option<Range<usize>>, done: &'static str) -> Row {
        Row {
            record: self.name.to_owned(),
            unit: self.unit,
            what,
            time_s: samples.as_ref().map(|samples| self.treatment.time(samples.start, self.step_s)),
            length_s: samples.as_ref().map(|samples| samples.len() as f64 * self.step_s),
            step_s: self.step_s,
            count: samples.map_or(1, |samples| samples.len()),
            event: None,
            other: String::new(),
            done,
            option: String::new(),
        }
    }

    fn gap(&self, samples: &Range<usize>) -> Row {
        self.row("gap", Some(samples.clone()), "left out")
    }

    fn outlier(&self, sample: usize, events: &[Event]) -> Row {
        let samples = Some(sample..sample + 1);
        // One of a long tail is no event.
        match self.treatment.outliers_removed || self.treatment.events_removed && Event::is_in(events, sample)
        {
            true => self.row("outlier", samples, "removed"),
            false => Row { option: "--remove-outliers".to_owned(), ..self.row("outlier", samples, "kept") },
        }
    }

    /// The row of a record whose samples are those of an `other` one.
    pub(crate) fn same(&self, other: &str) -> Row {
        Row { other: other.to_owned(), ..self.row("same record", None, "noted") }
    }

    /// The rows of its events.
    pub fn rows<'e>(&self, events: impl IntoIterator<Item = &'e Event>) -> Vec<Row> {
        events.into_iter().map(|event| self.event(event)).collect()
    }

    fn event(&self, event: &Event) -> Row {
        let samples = event.samples.map(|[from, to]| from..to);
        let done = self.done(event);
        let other = event.other.and_then(|other| self.thermometers.get(other)).cloned().unwrap_or_default();
        Row {
            count: event.count,
            event: Some(event.clone()),
            option: if done == REMOVED { String::new() } else { option(event, &other) },
            other,
            ..self.row(event.what.name(), samples, done)
        }
    }

    /// What the analysis does with an event.
    fn done(&self, event: &Event) -> &'static str {
        match event.what {
            _ if self.keeps_events && !self.treatment.events_removed => "kept",
            _ if event.instead_of.is_some() => match event.instead_of {
                Some(Term::RateRamp) => "possible; R not identified",
                _ => "possible; K not identified",
            },
            What::Units => "noted",
            What::Filter => "fit from longer τ; Q not identified",
            What::Correlated if event.size.is_some() => "part of the fit",
            What::Correlated => "B not identified",
            What::Telegraph => "B and K not identified",
            _ if self.treatment.events_removed => REMOVED,
            What::NoiseBurst | What::Spikes => LEFT_OUT,
            _ => SUBTRACTED,
        }
    }
}

/// The words for events that are taken out of the curves too, or for the fit only.
const REMOVED: &str = "removed";
const LEFT_OUT: &str = "left out of the fit";
const SUBTRACTED: &str = "subtracted for the fit";

/// The option that removes an event from curves and spectra too; empty where none does.
fn option(event: &Event, thermometer: &str) -> String {
    match event.what {
        What::Temperature if !thermometer.is_empty() => {
            format!("--temperature {} --compensate", quoted(thermometer))
        }
        What::Spikes => "--remove-outliers".to_owned(),
        What::Units | What::Filter | What::Correlated | What::Telegraph => String::new(),
        _ if event.instead_of.is_some() => String::new(),
        _ => "--remove-events".to_owned(),
    }
}

/// A name as a shell takes it.
fn quoted(name: &str) -> String {
    if name.contains(char::is_whitespace) { format!("\"{name}\"") } else { name.to_owned() }
}

/// The columns of `events.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns() -> Vec<ColumnOf<Row>> {
    type Of = ColumnOf<Row>;
    vec![
        key(|row| text(&row.record)),
        Of::new("event", Unit::NONE, "event", |row| text(row.what))
            .is(Role::Key, "`gap` for missing samples, `outlier` for a sample that stands out from its neighbours, else the kind of the event: \
                noise burst, spikes, step, burst, slow sine, warm-up, temperature, telegraph noise, correlated noise, line, filter or hump, \
                whole units, same record."),
        Of::new("time", Unit::S, "time", |row| row.time_s.into())
            .is(Role::Coordinate, "Time of the first of the samples from the start of the file, s; blank for what lasts through the record."),
        Of::new("length", Unit::S, "length", |row| row.length_s.into())
            .is(Role::Estimate, "Duration of the samples, s."),
        Of::new("samples", Unit::NONE, "samples", |row| Cell::Integer(row.count as i64))
            .is(Role::Count, "Number of samples of a gap, of spikes, or of steps."),
        Of::new("size", Unit::NONE, "size", |row| row.of_event(|event| event.size).into())
            .is(Role::Estimate, "Standard deviation of a sample of the noise that a noise burst adds, change of a step or burst, amplitude of a sine or \
                line, rate at the start of a warm-up, half the distance of the levels of telegraph noise, largest distance of a spike, unit of \
                the readout, in `unit`."),
        Of::new("unaveraged", Unit::NONE, "before averaging", |row| row.unaveraged().into())
            .is(Role::Estimate, "Amplitude of a sine or line of the rate itself, where each sample is its mean over the time between samples, in `unit`: \
                `size` is that of the samples."),
        Of::new("unit", Unit::NONE, "unit", |row| text(&(row.unit.in_files(Deviation::Oadev).to_owned() + row.per())))
            .is(Role::Note, "Unit of `size` and `unaveraged`."),
        Of::new("f", Unit::HZ, "frequency", |row| row.of_event(|event| event.frequency_hz).into())
            .is(Role::Estimate, "Frequency of a sine or line, Hz."),
        Of::new("time_constant", Unit::S, "time constant", |row| row.of_event(|event| event.time_s).into())
            .is(Role::Estimate, "Time of a warm-up or of correlated noise, or mean time between steps of telegraph noise, s."),
        Of::new("other", Unit::NONE, "refers to", |row| text(&row.other))
            .is(Role::Note, "Column of the temperature, or the equal record."),
        Of::new("done", Unit::NONE, "done", |row| text(row.done))
            .is(Role::Note, "What the analysis did with it."),
        Of::new("option", Unit::NONE, "to remove", |row| text(&row.option))
            .is(Role::Note, "The option that removes it from curves and spectra too; blank where none does, or it is removed."),
    ]
}

/// The gaps, outliers and events of all columns, column by column.
pub fn table(analysis: &Analysis) -> Table {
    let all = |column| {
        let record = record(analysis, column);
        let gaps = column.gaps.iter().map(|gap| record.gap(gap));
        let mut rows: Vec<Row> = gaps
            .chain(column.outliers.samples.iter().map(|&sample| record.outlier(sample, &column.events)))
            .collect();
        rows.sort_by(|a, b| a.time_s.partial_cmp(&b.time_s).unwrap_or(Ordering::Equal));
        rows.extend(of_column(analysis, column));
        rows
    };
    table_of(&analysis.columns.iter().flat_map(all).collect::<Vec<_>>())
}

fn record<'a>(analysis: &'a Analysis, column: &'a Column) -> Record<'a> {
    Record {
        name: &column.name,
        unit: column.unit,
        treatment: &analysis.treatment,
        step_s: analysis.step_s,
        keeps_events: analysis.keeps_events,
        thermometers: &analysis.thermometers,
    }
}

/// The events of all columns, without single gaps and outliers.
pub fn rows(analysis: &Analysis) -> Vec<Row> {
    analysis.columns.iter().flat_map(|column| of_column(analysis, column)).collect()
}

/// The events of a column, without single gaps and outliers.
pub(crate) fn of_column(analysis: &Analysis, column: &Column) -> Vec<Row> {
    of_record(analysis, column, &column.name)
}

/// The events of a column under another name, without single gaps and outliers.
pub(crate) fn of_record(analysis: &Analysis, column: &Column, name: &str) -> Vec<Row> {
    let record = Record { name, ..record(analysis, column) };
    let same = column.same_as.iter().map(|other| record.same(other));
    same.chain(record.rows(&column.events)).collect()
}

/// Whether events were removed from the record of any column.
pub(crate) fn are_removed(analysis: &Analysis) -> bool {
    rows(analysis).iter().any(|row| row.done == REMOVED)
}

/// Whether the fit leaves out events that the curves of a column have.
pub(crate) fn are_left_out(analysis: &Analysis, column: &Column) -> bool {
    of_column(analysis, column).iter().any(|row| [LEFT_OUT, SUBTRACTED].contains(&row.done))
}

/// Events as a table.
pub fn table_of(rows: &[Row]) -> Table {
    Table { columns: columns_of(&columns(), rows) }
}
