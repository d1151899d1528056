//! The rows of a text, read in blocks and parsed in parallel.

use std::io::{BufRead, BufReader, Read};
use std::ops::Range;

use rayon::prelude::*;

use crate::record::cells::{Cells, Decimal};
use crate::record::column_file::Rules;
use crate::record::format::{Bytes, Columns, HEAD, Origin, Source};
use crate::record::layout::Layout;
use crate::record::log::measure::Data;
use crate::record::loggers::Rivals;
use crate::record::names::Name;
use crate::record::time::{Calendar, DAY_S, First};
use crate::record::{Faults, RecordError, excess};
use sagnac_base::diagnostics::{Place, decoded};

/// Bytes read at a time; no line may be longer.
const BLOCK: usize = 16 << 20;

/// Bytes parsed by one thread at a time.
const PART: usize = 1 << 20;

/// Faulty rows that a refusal shows; it counts all.
const MAX_SHOWN: usize = 3;

/// A part of a text.
struct Part<'b> {
    columns: Vec<Vec<f64>>,
    lines: usize,
    comments: usize,
    /// Number of lines that cannot be read, and the first of them, each with the number of lines before it.
    faulty: usize,
    shown: Vec<(usize, &'b [u8])>,
}

/// A text of which the layout is known.
pub(crate) struct Text<'a> {
    layout: Layout,
    origin: Origin<'a>,
    rows: Bytes<'a>,
    /// Number of comments among the rows.
    comments: usize,
}

impl<'a> Text<'a> {
    /// Finds the layout, with these decimals if they are given.
    pub(crate) fn open(source: Source<'a>, decimal: Option<Decimal>) -> Result<Text<'a>, RecordError> {
        let layout = if source.is_whole() {
            Layout::parse(&source.head, &source.file, decimal)?
        } else {
            // The last line goes on behind the head: its cells cannot be counted.
            let whole = source.head.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
            match whole {
                // Not text, which is said where the rows are read.
                0 if source.head.contains(&0) => Layout::parse(&source.head, &source.file, decimal)?,
                _ => Layout::parse(&source.head[..whole], &source.file, decimal)
                    .map_err(|_| hidden(&source))?,
            }
        };
        Ok(Text { origin: source.origin.clone(), rows: source.from(layout.start), layout, comments: 0 })
    }
}

/// The error for a text whose first line with content is not within the head.
fn hidden(source: &Source) -> RecordError {
    let most = HEAD >> 20;
    let message =
        format!("{} has no complete header and no complete row in its first {most} MiB", source.file);
    let help = format!("remove long comments, and keep the header or the first row below {most} MiB");
    RecordError::new(message, "", help, None)
}

impl Columns for Text<'_> {
    fn names(&self) -> &[Name] {
        &self.layout.names
    }

    fn count(&self) -> usize {
        self.layout.columns
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        let mut found = read(&self.layout, &mut self.rows, wanted, rules);
        let span_s = |found: &Result<(Vec<Vec<f64>>, usize), RecordError>| {
            found.as_ref().map_or(f64::INFINITY, |(columns, _)| span_s(&self.layout, wanted, columns))
        };
        // Within a day the order of the date does not matter.
        if let Some(first) = self.layout.first.filter(|_| span_s(&found) > DAY_S) {
            let mut layout = self.layout.clone();
            layout.first = Some(first.other());
            let other = reopened(&layout, &self.origin).map(|rows| read(&layout, rows, wanted, rules));
            if let Some(other) = other.filter(|other| span_s(other) < span_s(&found)) {
                (found, self.layout) = (other, layout);
            }
        }
        let (columns, comments) = found?;
        self.comments = comments;
        Ok(columns)
    }

    fn found(&self) -> Vec<String> {
        let comments = match self.comments {
            0 => None,
            1 => Some("1 line among the rows is a comment, which is no sample".to_owned()),
            count => Some(format!("{count} lines among the rows are comments, which are no samples")),
        };
        let order = self.layout.first.map(|first| match first {
            First::Month => "month/day/year",
            First::Day => "day/month/year",
        });
        let order = order.map(|order| format!("dates with slashes are read as {order}"));
        comments.into_iter().chain(order).collect()
    }

    fn sample(&self, column: usize) -> Option<f64> {
        self.layout.numbers.get(column).copied().flatten()
    }

    fn rows(&self, column: usize) -> &[f64] {
        self.layout.rows.get(column).map_or(&[], Vec::as_slice)
    }

    fn rivals(&self) -> Option<&Rivals> {
        self.layout.rivals.as_ref()
    }

    fn calendar(&self, column: usize) -> Option<Calendar> {
        self.layout.calendar.get(column).copied().flatten()
    }

    fn inferred(&self) -> Vec<String> {
        self.layout.inferred.clone()
    }

    fn step_s(&self) -> Option<f64> {
        self.layout.stated.step_s
    }

    fn data(&self) -> Option<Data> {
        self.layout.stated.data
    }

    fn place(&self, column: Option<usize>) -> Option<Place> {
        Some(self.layout.place(column))
    }

    fn place_of_row(&self, row: usize, column: usize) -> Option<Place> {
        place_of_row(&self.layout, &self.origin, row, column)
    }
}

/// The rows of a text again.
fn reopened<'a>(layout: &Layout, origin: &Origin<'a>) -> Option<impl Read + use<'a>> {
    let mut bytes = BufReader::new(origin.open().ok()?.0);
    std::io::copy(&mut bytes.by_ref().take(layout.start as u64), &mut std::io::sink()).ok()?;
    Some(bytes)
}

/// Time from the first row to the last by the wanted times of the calendar, s, infinite where they are not in order.
fn span_s(layout: &Layout, wanted: &[usize], columns: &[Vec<f64>]) -> f64 {
    let are_times = |column: &usize| layout.calendar.get(*column) == Some(&Some(Calendar::Time));
    let times = wanted.iter().zip(columns).filter(|(column, _)| are_times(column));
    let span = |times: &Vec<f64>| {
        let known = || times.iter().copied().filter(|time| !time.is_nan());
        let is_in_order = known().zip(known().skip(1)).all(|(before, time)| before <= time);
        let ends = known().next().zip(known().next_back()).filter(|_| is_in_order);
        ends.map_or(f64::INFINITY, |(first, last)| last - first)
    };
    times.map(|(_, times)| span(times)).fold(0.0, f64::max)
}

/// Reads the `wanted` columns in the given order from the `bytes` of all rows, with NaN for missing values, and counts comments
/// between rows.
///
/// # Errors
/// The file cannot be read, has too many rows, or rows do not fit the layout; these are counted, and the first are shown.
fn read(
    layout: &Layout,
    mut bytes: impl Read,
    wanted: &[usize],
    rules: &Rules,
) -> Result<(Vec<Vec<f64>>, usize), RecordError> {
    let mut slots = vec![None; layout.columns];
    wanted.iter().enumerate().for_each(|(slot, &column)| slots[column] = Some(slot));
    let dates = dates(layout, &slots);
    let mut columns = vec![Vec::new(); wanted.len()];
    let (mut block, mut lines) = (Vec::with_capacity(BLOCK), layout.lines);
    let (mut faults, mut faulty, mut comments) = (Faults::default(), 0, 0);
    loop {
        let room = BLOCK - block.len();
        let more = bytes.by_ref().take(room as u64).read_to_end(&mut block);
        // Fewer bytes than requested come only at the end.
        let at_end = more.map_err(|error| RecordError::unreadable(&layout.file, &error))? < room;
        let last_end = block.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        let whole = if at_end { block.len() } else { last_end };
        if whole == 0 && !at_end {
            return Err(endless(layout, lines, &block));
        }
        let parts = split(&block[..whole]);
        let parts: Vec<Part> =
            parts.par_iter().map(|part| parse(part, layout, &slots, &dates, wanted.len())).collect();
        for part in parts {
            let shown = part.shown.into_iter().take(MAX_SHOWN.saturating_sub(faulty));
            shown.for_each(|(before, line)| {
                faults.add(refusal(layout, lines + before + 1, line, &slots, rules.missing));
            });
            faulty += part.faulty;
            comments += part.comments;
            lines += part.lines;
            columns.iter_mut().zip(part.columns).for_each(|(column, values)| column.extend(values));
        }
        rules.limit(&layout.file, columns.first().map_or(0, Vec::len).max(faulty))?;
        block.drain(..whole);
        if at_end && faulty > 0 {
            let more = if faulty > MAX_SHOWN { "; the first of them are shown" } else { "" };
            let message = format!("{faulty} rows of {} cannot be read{more}", layout.file);
            return Err(faults.listed(message));
        }
        let other = layout
            .stated
            .points
            .as_ref()
            .zip(columns.first())
            .filter(|(stated, rows)| stated.0 != rows.len());
        if let (true, Some(((points, place), rows))) = (at_end, other) {
            let (file, rows) = (&layout.file, rows.len());
            let message = format!("{file} has {rows} rows, but its header states {points} points");
            let help = "copy it again from where it was recorded, or correct the header";
            return Err(RecordError::new(message, "another number", help, place.clone()));
        }
        if at_end {
            return Ok((columns, comments));
        }
    }
}

/// Pieces of about [`PART`] bytes that end at ends of lines.
fn split(block: &[u8]) -> Vec<&[u8]> {
    let (mut parts, mut rest) = (Vec::new(), block);
    while rest.len() > PART {
        let Some(end) = rest[PART..].iter().position(|byte| *byte == b'\n') else { break };
        let (part, after) = rest.split_at(PART + end + 1);
        parts.push(part);
        rest = after;
    }
    parts.push(rest);
    parts
}

/// The columns of dates, each with the slot of the times of day in the column after it, or else before it.
fn dates(layout: &Layout, slots: &[Option<usize>]) -> Vec<(usize, usize)> {
    let holds = |column: usize, calendar| layout.calendar.get(column) == Some(&Some(calendar));
    let slot = |column: usize| slots.get(column).copied().flatten().filter(|_| holds(column, Calendar::Time));
    let before = |column: usize| {
        let clock = column.checked_sub(1)?;
        let has_own = clock.checked_sub(1).is_some_and(|date| holds(date, Calendar::Date));
        slot(clock).filter(|_| !has_own)
    };
    let columns = (0..layout.calendar.len()).filter(|&column| holds(column, Calendar::Date));
    columns.filter_map(|column| Some((column, slot(column + 1).or_else(|| before(column))?))).collect()
}

fn parse<'b>(
    part: &'b [u8],
    layout: &Layout,
    slots: &[Option<usize>],
    dates: &[(usize, usize)],
    wanted: usize,
) -> Part<'b> {
    let about = part.len() / 8 / layout.columns.max(1);
    let columns = (0..wanted).map(|_| Vec::with_capacity(about)).collect();
    let mut read = Part { columns, lines: 0, comments: 0, faulty: 0, shown: vec![] };
    for line in part.split_inclusive(|byte| *byte == b'\n') {
        let text = line.trim_ascii_end();
        let mut is_read = || {
            parse_row(text, layout, slots, &mut read.columns)
                && add_dates(text, layout, dates, &mut read.columns)
        };
        if layout.delimiter.skips(text) {
            // Those at the end are remarks on the whole.
            read.comments += usize::from(!text.is_empty());
        } else if !is_read() {
            read.faulty += 1;
            if read.faulty <= MAX_SHOWN {
                read.shown.push((read.lines, text));
            }
        }
        read.lines += 1;
    }
    read
}

/// Whether a row fits the layout and has finite or missing numbers in the wanted columns.
#[inline]
fn parse_row(text: &[u8], layout: &Layout, slots: &[Option<usize>], columns: &mut [Vec<f64>]) -> bool {
    let (mut count, mut last_is_empty) = (0, false);
    for cell in Cells::new(text, layout.delimiter) {
        if let Some(slot) = slots.get(count).copied().flatten() {
            match layout.value(count, &text[cell.clone()]) {
                Some(number) if excess(number).is_none() => columns[slot].push(number),
                _ => return false,
            }
        }
        last_is_empty = cell.is_empty();
        count += 1;
    }
    // Many loggers end each line with a delimiter.
    count == layout.columns || count == layout.columns + 1 && last_is_empty
}

/// Adds the dates of a row to its times of day; `false` where one is none.
fn add_dates(text: &[u8], layout: &Layout, dates: &[(usize, usize)], columns: &mut [Vec<f64>]) -> bool {
    dates.iter().all(|&(column, slot)| {
        let cell = Cells::new(text, layout.delimiter).nth(column).unwrap_or(0..0);
        let day_s = Calendar::Date.seconds(&text[cell], layout.first.unwrap_or(First::Month));
        columns[slot].last_mut().zip(day_s).map(|(clock, day_s)| *clock += day_s).is_some()
    })
}

/// The error for the line of this number, which [`parse_row`] does not accept.
fn refusal(
    layout: &Layout,
    number: usize,
    text: &[u8],
    slots: &[Option<usize>],
    missing: &str,
) -> RecordError {
    let refused = |span: Range<usize>, message: String, label: &str, help: &str| {
        RecordError::new(message, label, help, Place::new(&layout.file, number, text, span))
    };
    if text.contains(&0) {
        let message = "this is not text: it contains a zero byte".to_owned();
        return refused(0..text.len(), message, "in this line", TEXT_WANTED);
    }
    let cells: Vec<Range<usize>> = Cells::new(text, layout.delimiter).collect();
    let wanted = cells.iter().zip(slots).enumerate().filter(|(_, (_, slot))| slot.is_some());
    for (column, (cell, _)) in wanted {
        let name = match layout.names.get(column) {
            Some(name) => format!("`{}`", name.whole),
            None => format!("column {}", column + 1),
        };
        let shown = decoded(&text[cell.clone()]);
        let Some(number) = layout.value(column, &text[cell.clone()]) else {
            let help = match layout.decimal {
                Decimal::Point if Decimal::is_comma(shown.as_bytes()) => {
                    "give `decimal = comma` if the comma is one; thousands are written without a sign"
                        .to_owned()
                }
                Decimal::Point => format!("write numbers with a point for decimals; {missing}"),
                Decimal::Comma => {
                    format!("decimals are commas in this file; if not, give `decimal = point`; {missing}")
                }
            };
            let message = format!("{name} holds \"{shown}\", which is not a number");
            return refused(cell.clone(), message, "not a number", &help);
        };
        if let Some(excess) = excess(number) {
            return refused(cell.clone(), format!("{name} is {excess} here"), "too large", missing);
        }
    }
    let cells_of = |count: usize| format!("{count} cell{}", if count == 1 { "" } else { "s" });
    let before = if layout.names.is_empty() { "the first row" } else { "the header" };
    let message = format!("this row has {}, {before} has {}", cells_of(cells.len()), layout.columns);
    let help = format!(
        "cells are divided by {} here, each row needs {}; a last line that was cut off may be removed",
        layout.delimiter.name(),
        cells_of(layout.columns)
    );
    let label = if cells.len() < layout.columns { "a cell is missing" } else { "a cell too many" };
    refused(0..text.len(), message, label, &help)
}

/// Advice on binary files.
pub(crate) const TEXT_WANTED: &str =
    "give text (CSV, TSV, or blanks between columns), .npy, .npz, MATLAB .mat, HDF5, MCAP or a ROS bag";

fn endless(layout: &Layout, lines: usize, block: &[u8]) -> RecordError {
    if block.contains(&0) {
        let message = format!("{} is not text: it contains zero bytes", layout.file);
        return RecordError::new(message, "", TEXT_WANTED, None);
    }
    let message = format!("{} has a line of more than {} MiB", layout.file, BLOCK >> 20);
    RecordError::new(message, "begins here", TEXT_WANTED, Place::new(&layout.file, lines + 1, block, 0..0))
}

/// The place of a row, counted from 0. Rows are read again for it, because places are not kept for millions of rows.
fn place_of_row(layout: &Layout, origin: &Origin, row: usize, column: usize) -> Option<Place> {
    let lines = BufReader::new(origin.open().ok()?.0).split(b'\n').map_while(Result::ok);
    let lines = lines.zip(1..).skip(layout.lines);
    let mut rows = lines.filter(|(line, _)| !layout.delimiter.skips(line));
    let (line, number) = rows.nth(row)?;
    let text = line.trim_ascii_end();
    let span = Cells::new(text, layout.delimiter).nth(column).unwrap_or(0..text.len());
    Some(Place::new(&layout.file, number, text, span))
}
