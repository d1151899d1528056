//! The rows of a text log, read in blocks and parsed in parallel.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;

use crate::record::log::cells::{Cells, Delimiter, Value, value};
use crate::record::log::error::LogError;
use crate::record::log::layout::Layout;
use crate::record::log::{MOST_SAMPLES, unreadable};
use crate::source::place::Place;

/// Bytes read at a time; no line may be longer.
const BLOCK: usize = 16 << 20;

/// Bytes parsed by one thread at a time.
const PART: usize = 1 << 20;

/// A cell or a row that cannot be read, with its place.
struct Flaw {
    /// Number of lines before it in its part.
    line: usize,
    text: Vec<u8>,
    span: Range<usize>,
    what: What,
}

enum What {
    Cells(usize),
    Text(usize),
    Infinite(usize),
    Binary,
}

#[derive(Default)]
struct Part {
    columns: Vec<Vec<f64>>,
    lines: usize,
    flaw: Option<Flaw>,
}

/// Reads the `wanted` columns of a log from its start, in the order given; NaN stands for a missing value.
///
/// # Errors
/// The file cannot be read, or a row does not fit the layout; of several such rows the first is reported.
pub(crate) fn read(
    layout: &Layout,
    mut bytes: impl Read,
    wanted: &[usize],
) -> Result<Vec<Vec<f64>>, LogError> {
    let failed = |error: io::Error| unreadable(&layout.file, &error);
    io::copy(&mut bytes.by_ref().take(layout.start as u64), &mut io::sink()).map_err(failed)?;
    let mut columns = vec![Vec::new(); wanted.len()];
    let (mut block, mut lines) = (Vec::with_capacity(BLOCK), layout.lines);
    loop {
        let room = BLOCK - block.len();
        // Fewer bytes than requested come only at the end.
        let at_end = bytes.by_ref().take(room as u64).read_to_end(&mut block).map_err(failed)? < room;
        let last_end = block.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        let whole = if at_end { block.len() } else { last_end };
        if whole == 0 && !at_end {
            return Err(endless(layout, lines, &block));
        }
        let parts: Vec<Part> =
            split(&block[..whole]).par_iter().map(|part| parse(part, layout, wanted)).collect();
        for part in parts {
            if let Some(flaw) = part.flaw {
                return Err(refusal(layout, lines, flaw));
            }
            lines += part.lines;
            for (column, values) in columns.iter_mut().zip(part.columns) {
                column.extend(values);
            }
        }
        if columns.first().is_some_and(|column| column.len() > MOST_SAMPLES) {
            let message = format!("{} has more than {MOST_SAMPLES} samples", layout.file);
            return Err(LogError::new(message, "", "cut it, or average it to a lower rate", None));
        }
        block.drain(..whole);
        if at_end {
            return Ok(columns);
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

fn parse(part: &[u8], layout: &Layout, wanted: &[usize]) -> Part {
    let about = part.len() / 8 / layout.columns.max(1);
    let mut columns: Vec<Vec<f64>> = wanted.iter().map(|_| Vec::with_capacity(about)).collect();
    let mut slots = vec![None; layout.columns];
    wanted.iter().enumerate().for_each(|(slot, &column)| slots[column] = Some(slot));
    let mut lines = 0;
    for line in part.split_inclusive(|byte| *byte == b'\n') {
        let text = line.trim_ascii_end();
        if !layout.delimiter.skips(text)
            && let Err((span, what)) = parse_row(text, layout, &slots, &mut columns)
        {
            let what = if text.contains(&0) { What::Binary } else { what };
            return Part {
                flaw: Some(Flaw { line: lines, text: text.to_vec(), span, what }),
                ..Part::default()
            };
        }
        lines += 1;
    }
    Part { columns, lines, flaw: None }
}

#[inline]
fn parse_row(
    text: &[u8],
    layout: &Layout,
    slots: &[Option<usize>],
    columns: &mut [Vec<f64>],
) -> Result<(), (Range<usize>, What)> {
    let (mut count, mut last_is_empty) = (0, false);
    for cell in Cells::new(text, layout.delimiter) {
        if let Some(slot) = slots.get(count).copied().flatten() {
            match value(&text[cell.clone()]) {
                Value::Number(number) => columns[slot].push(number),
                Value::Infinite => return Err((cell, What::Infinite(count))),
                Value::Text => return Err((cell, What::Text(count))),
            }
        }
        last_is_empty = cell.is_empty();
        count += 1;
    }
    // Many loggers end each line with a delimiter.
    let ends_with_delimiter = count == layout.columns + 1 && last_is_empty;
    if count == layout.columns || ends_with_delimiter {
        Ok(())
    } else {
        Err((0..text.len(), What::Cells(count)))
    }
}

fn refusal(layout: &Layout, lines: usize, flaw: Flaw) -> LogError {
    let Flaw { line, text, span, what } = flaw;
    let column = |column: usize| match &layout.names {
        Some(names) => format!("`{}`", names[column].whole),
        None => format!("column {}", column + 1),
    };
    let cell = String::from_utf8_lossy(&text[span.clone()]).into_owned();
    let place = Place::new(&layout.file, lines + line + 1, &text, span);
    match what {
        What::Binary => {
            LogError::new("this is not text: it contains a zero byte", "in this line", TEXT_WANTED, place)
        }
        What::Cells(found) => {
            let cells = |count: usize| format!("{count} cell{}", if count == 1 { "" } else { "s" });
            let before = if layout.names.is_some() { "the header" } else { "the first row" };
            let message = format!("this row has {}, {before} has {}", cells(found), layout.columns);
            let help = format!(
                "cells are divided by {} here, each row needs {}; a last line that was cut off may be removed",
                layout.delimiter.name(),
                cells(layout.columns)
            );
            let label = if found < layout.columns { "a cell is missing" } else { "a cell too many" };
            LogError::new(message, label, help, place)
        }
        What::Infinite(at) => {
            let help = "leave the cell empty \
                      or write NaN where a sample is missing";
            LogError::new(format!("{} is infinite here", column(at)), "not finite", help, place)
        }
        What::Text(at) => {
            let message = format!("{} holds \"{cell}\", which is not a number", column(at));
            let help = match (cell.contains(','), layout.delimiter) {
                (true, Delimiter::Byte(b';' | b'\t') | Delimiter::Blanks) => "write decimals with a point",
                _ => {
                    "write numbers with a point for decimals; leave the cell empty or write NaN where a sample is \
                     missing"
                }
            };
            LogError::new(message, "not a number", help, place)
        }
    }
}

/// Advice on binary files.
pub(crate) const TEXT_WANTED: &str =
    "give CSV, TSV or columns with blanks between them as text, or a NumPy .npy file";

fn endless(layout: &Layout, lines: usize, block: &[u8]) -> LogError {
    if block.contains(&0) {
        return LogError::new(
            format!("{} is not text: it contains zero bytes", layout.file),
            "",
            TEXT_WANTED,
            None,
        );
    }
    let message = format!("{} has a line of more than {} MiB", layout.file, BLOCK >> 20);
    LogError::new(message, "begins here", TEXT_WANTED, Place::new(&layout.file, lines + 1, block, 0..0))
}

/// The place of a row, counted from 0. Rows are read again for it, because places are not kept for millions of rows.
pub(crate) fn place_of_row(layout: &Layout, path: &Path, row: usize, column: usize) -> Option<Place> {
    let mut reader = BufReader::new(File::open(path).ok()?);
    let (mut line, mut number, mut rows) = (Vec::new(), 0, 0);
    loop {
        line.clear();
        if reader.read_until(b'\n', &mut line).ok()? == 0 {
            return None;
        }
        number += 1;
        let text = line.trim_ascii_end();
        if number <= layout.lines || layout.delimiter.skips(text) {
            continue;
        }
        if rows == row {
            let span = Cells::new(text, layout.delimiter).nth(column).unwrap_or(0..text.len());
            return Some(Place::new(&layout.file, number, text, span));
        }
        rows += 1;
    }
}
