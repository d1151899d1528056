//! What a record shows besides noise: `events.csv`, and the list at the head of a report.

use std::ops::Range;

use serde_json::Value;

use crate::allan::Deviation;
use crate::analysis::log::tables::{key, text};
use crate::analysis::log::{Analysis, Column};
use crate::events::{Event, What};
use crate::quantity::number::significant;
use crate::table::column::{columns_of, object};
use crate::table::{Cell, ColumnOf, Role, Table, Unit};
use crate::theory::allan::Term;

/// A row of `events.csv`.
pub(crate) struct Row<'a> {
    column: &'a Column,
    what: &'static str,
    samples: Option<Range<usize>>,
    /// Number of samples, or of events of which the row consists.
    count: usize,
    event: Option<&'a Event>,
    analysis: &'a Analysis,
}

impl Row<'_> {
    fn of_event<T>(&self, of: impl Fn(&Event) -> Option<T>) -> Option<T> {
        self.event.and_then(of)
    }

    /// What the analysis does with it.
    fn done(&self) -> &'static str {
        let treatment = &self.analysis.treatment;
        match self.event {
            None if self.what == "outlier" && treatment.outliers_removed => "removed",
            None if self.what == "outlier" => "kept",
            None => "left out",
            Some(_) if self.analysis.is_fit_given && !treatment.events_removed => "kept",
            Some(event) if event.instead_of.is_some() => match event.instead_of {
                Some(Term::RateRamp) => "possible; R not identified",
                _ => "possible; K not identified",
            },
            Some(Event { what: What::Units | What::Same, .. }) => "noted",
            Some(_) if treatment.events_removed => "removed",
            Some(event) => match event.what {
                What::Filter => "fit from longer τ; Q not identified",
                What::Correlated if event.size.is_some() => "part of the fit",
                What::Correlated => "B not identified",
                What::Telegraph => "B and K not identified",
                What::Spikes => "left out of the fit",
                _ => "subtracted for the fit",
            },
        }
    }

    /// The option that removes it from curves and spectra too.
    fn option(&self) -> String {
        let other = self.of_event(|event| event.other);
        let thermometer = other.and_then(|other| self.analysis.thermometers.get(other));
        match (self.event.map(|event| event.what), thermometer) {
            (Some(What::Temperature), Some(name)) => format!("--temperature {name} --compensate"),
            (Some(What::Spikes), _) => "--remove-outliers".to_owned(),
            (Some(What::Units | What::Same | What::Filter | What::Correlated | What::Telegraph), _) => {
                String::new()
            }
            _ if self.event.is_some_and(|event| event.instead_of.is_some()) => String::new(),
            (Some(_), _) => "--remove-events".to_owned(),
            (None, _) if self.what == "outlier" => "--remove-outliers".to_owned(),
            (None, _) => String::new(),
        }
    }

    /// The temperature or the record that it refers to.
    fn refers_to(&self) -> &str {
        let other = self.of_event(|event| Some((event.what, event.other?)));
        match other {
            Some((What::Temperature, other)) => {
                self.analysis.thermometers.get(other).map_or("", String::as_str)
            }
            Some((_, other)) => self.analysis.columns.get(other).map_or("", |column| &column.name),
            None => "",
        }
    }
}

/// The columns of `events.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("event", Unit::NONE, "event", |row| text(row.what))
            .is(Role::Key, "`gap` for missing samples, `outlier` for a sample that stands out from its neighbours, else the kind of the event: \
                spikes, step, burst, slow sine, warm-up, temperature, telegraph noise, correlated noise, line, filter or hump, whole units, \
                same record."),
        Of::new("time", Unit::S, "time", |row| row.samples.as_ref().map(|samples| row.analysis.time(samples.start)).into())
            .is(Role::Coordinate, "Time of the first of the samples from the start of the file, s; blank for what lasts through the record."),
        Of::new("length", Unit::S, "length", |row| row.samples.as_ref().map(|samples| samples.len() as f64 * row.analysis.step_s).into())
            .is(Role::Estimate, "Duration of the samples, s."),
        Of::new("samples", Unit::NONE, "samples", |row| Cell::Integer(row.count as i64))
            .is(Role::Count, "Number of samples of a gap, of spikes, or of steps."),
        Of::new("size", Unit::NONE, "size", |row| row.of_event(|event| event.size).into())
            .is(Role::Estimate, "Change of a step or burst, amplitude of a sine or line, rate at the start of a warm-up, half the distance of the \
                levels of telegraph noise, largest distance of a spike, unit of the readout, in `unit`; for a temperature in `unit` per K."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.column.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of `size`."),
        Of::new("f", Unit::HZ, "frequency", |row| row.of_event(|event| event.frequency_hz).into())
            .is(Role::Estimate, "Frequency of a sine or line, Hz."),
        Of::new("time_constant", Unit::S, "time constant", |row| row.of_event(|event| event.time_s).into())
            .is(Role::Estimate, "Time of a warm-up or of correlated noise, or mean time between steps of telegraph noise, s."),
        Of::new("other", Unit::NONE, "refers to", |row| text(row.refers_to()))
            .is(Role::Note, "Column of the temperature, or the equal record."),
        Of::new("done", Unit::NONE, "done", |row| text(row.done()))
            .is(Role::Note, "What the analysis did with it."),
        Of::new("option", Unit::NONE, "to remove", |row| text(&row.option()))
            .is(Role::Note, "The option that removes it from curves and spectra too."),
    ]
}

/// The gaps, outliers and events of all columns, column by column.
pub fn table(analysis: &Analysis) -> Table {
    let of_column = |column| {
        let row = move |what, samples: Range<usize>| Row {
            column,
            what,
            count: samples.len(),
            samples: Some(samples),
            event: None,
            analysis,
        };
        let gaps = column.gaps.iter().map(move |gap| row("gap", gap.clone()));
        let outliers = column.outliers.samples.iter().map(move |&sample| row("outlier", sample..sample + 1));
        let mut rows: Vec<Row> = gaps.chain(outliers).collect();
        rows.sort_by_key(|row| row.samples.as_ref().map(|samples| samples.start));
        rows.extend(shown(column, analysis));
        rows
    };
    let rows: Vec<Row> = analysis.columns.iter().flat_map(of_column).collect();
    Table { columns: columns_of(&columns(), &rows) }
}

/// The events of a column, without single gaps and outliers.
fn shown<'a>(column: &'a Column, analysis: &'a Analysis) -> impl Iterator<Item = Row<'a>> {
    column.events.iter().map(move |event| Row {
        column,
        what: event.what.name(),
        samples: event.samples.map(|[from, to]| from..to),
        count: event.count,
        event: Some(event),
        analysis,
    })
}

/// The heading of the list of what a log shows.
pub const HEADING: [&str; 7] = ["", "event", "size", "at", "number", "done", "to remove"];

/// What a log shows besides noise, a line for each event.
pub fn list(analysis: &Analysis) -> Vec<Vec<String>> {
    let line = |row: Row| {
        let unit = row.column.unit.symbol(Deviation::Oadev);
        let per = if row.event.is_some_and(|event| event.what == What::Temperature) { "/K" } else { "" };
        let size =
            row.of_event(|event| event.size).map(|size| format!("{} {unit}{per}", significant(size, 3)));
        let time =
            row.samples.as_ref().map(|samples| format!("{} s", significant(analysis.time(samples.start), 6)));
        let frequency = row.of_event(|event| event.frequency_hz).map(|f| format!("{} Hz", significant(f, 5)));
        let constant =
            row.of_event(|event| event.time_s).map(|time_s| format!("{} s", significant(time_s, 3)));
        let other = Some(row.refers_to().to_owned()).filter(|other| !other.is_empty());
        let at = other.or(frequency).or(constant).or(time);
        let number = if row.count > 1 { row.count.to_string() } else { String::new() };
        let [size, at] = [size, at].map(Option::unwrap_or_default);
        vec![
            row.column.name.clone(),
            row.what.to_owned(),
            size,
            at,
            number,
            row.done().to_owned(),
            row.option(),
        ]
    };
    analysis.columns.iter().flat_map(|column| shown(column, analysis)).map(line).collect()
}

/// The events of a column as JSON.
pub(crate) fn document(column: &Column, analysis: &Analysis) -> Vec<Value> {
    let columns = columns();
    shown(column, analysis).map(|row| object(&columns, &row, &["column"])).collect()
}
