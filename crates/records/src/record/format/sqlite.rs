//! Tables of SQLite databases, read row by row.
//!
//! The reader is our own, because that of SQLite is a large library in C, and needs a file system. It walks from the root of a table to
//! its leaves. The format is that of sqlite.org/fileformat2.html.

use std::collections::HashSet;
use std::io::{self, SeekFrom};

use crate::record::format::Seekable;
use crate::record::malformed;

pub(crate) const MAGIC: &[u8] = b"SQLite format 3\0";

/// Length of the header at the start of the first page.
const HEADER: usize = 100;

/// Types of pages with rows, and of those above them.
const LEAF: u8 = 13;
const INTERIOR: u8 = 5;

/// Deepest pages above each other; SQLite itself allows 20.
const DEEPEST: usize = 20;

/// Longest row, in bytes.
const MAX_ROW: u64 = 1 << 28;

/// A value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Value<'r> {
    /// Nothing, or a number that is no integer, which no table of a recording has.
    Other,
    Integer(i64),
    Text(&'r str),
    Blob(&'r [u8]),
}

/// An open database.
pub(crate) struct Database<'a> {
    bytes: Box<dyn Seekable + 'a>,
    page: usize,
    /// Bytes of a page that are used.
    usable: usize,
    /// Number of pages in the file.
    pages: u64,
    tables: Vec<Table>,
}

/// A table: its name, the first page, and the names of its columns.
#[derive(Debug, Clone)]
pub(crate) struct Table {
    pub name: String,
    root: u32,
    columns: Vec<String>,
}

impl Table {
    /// The place of a column, by its name in lower case.
    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
}

/// Takes each row: its number and its values.
type Visitor<'v> = &'v mut dyn FnMut(i64, &[Value]) -> io::Result<()>;

impl<'a> Database<'a> {
    /// Reads the header and the list of tables of a file of `length` bytes.
    ///
    /// # Errors
    /// It cannot be read, or is no database that can be read by itself.
    pub(crate) fn open(mut bytes: Box<dyn Seekable + 'a>, length: u64) -> io::Result<Database<'a>> {
        let mut header = [0; HEADER];
        bytes.read_exact(&mut header)?;
        let page = match usize::from(u16::from_be_bytes([header[16], header[17]])) {
            1 => 1 << 16,
            page => page,
        };
        let usable = page.saturating_sub(header[20].into());
        if !page.is_power_of_two() || page < 512 || usable < 480 {
            return malformed("its header is damaged");
        }
        if header[56..60] == [0, 0, 0, 2] || header[56..60] == [0, 0, 0, 3] {
            return malformed("its texts are in UTF-16");
        }
        let mut database = Database { bytes, page, usable, pages: length / page as u64, tables: vec![] };
        // A length in the header that is that of the file was written by the last change.
        let stated = u32::from_be_bytes([header[28], header[29], header[30], header[31]]);
        if stated > 0 && header[24..28] == header[92..96] && u64::from(stated) > database.pages {
            return malformed("it ends too early");
        }
        let schema = Table { name: String::new(), root: 1, columns: vec![] };
        let mut tables = Vec::new();
        database.rows(&schema, &mut |_, values| {
            if let [Value::Text("table"), Value::Text(name), _, Value::Integer(root), Value::Text(sql), ..] =
                values
                && let Ok(root) = u32::try_from(*root)
            {
                tables.push(Table { name: (*name).to_owned(), root, columns: columns(sql) });
            }
            Ok(())
        })?;
        database.tables = tables;
        Ok(database)
    }

    /// A table by its name.
    pub(crate) fn table(&self, name: &str) -> Option<Table> {
        self.tables.iter().find(|table| table.name == name).cloned()
    }

    /// Names of all tables.
    pub(crate) fn names(&self) -> Vec<String> {
        self.tables.iter().map(|table| table.name.clone()).collect()
    }

    /// Passes on all rows of a table, in the order of their numbers.
    ///
    /// # Errors
    /// The table is damaged, or `visit` fails.
    pub(crate) fn rows(&mut self, table: &Table, visit: Visitor) -> io::Result<()> {
        self.tree(table.root, 0, &mut HashSet::new(), visit)
    }

    /// The bytes of a page.
    fn page(&mut self, number: u32) -> io::Result<Vec<u8>> {
        if number == 0 || u64::from(number) > self.pages {
            return malformed("it names a page that is not there");
        }
        let mut page = vec![0; self.page];
        self.bytes.seek(SeekFrom::Start(u64::from(number - 1) * self.page as u64))?;
        self.bytes.read_exact(&mut page)?;
        Ok(page)
    }

    /// Passes on the rows in a page and in those below it; `seen` has the pages so far.
    fn tree(&mut self, number: u32, depth: usize, seen: &mut HashSet<u32>, visit: Visitor) -> io::Result<()> {
        if depth > DEEPEST || !seen.insert(number) {
            return malformed("its pages are damaged: one is below itself or in two places");
        }
        let page = self.page(number)?;
        let start = if number == 1 { HEADER } else { 0 };
        let damaged = || malformed(&format!("page {number} is damaged"));
        let Some(&[kind, _, _, high, low, _, _, _]) = page.get(start..).and_then(|head| head.first_chunk())
        else {
            return damaged();
        };
        let (cells, used) = (usize::from(u16::from_be_bytes([high, low])), &page[..self.usable]);
        let pointers = start + if kind == INTERIOR { 12 } else { 8 };
        let cell = |at: usize| {
            let pointer = used.get(pointers + 2 * at..)?.first_chunk().copied()?;
            used.get(usize::from(u16::from_be_bytes(pointer))..)
        };
        let below = |bytes: Option<&[u8]>| {
            bytes.and_then(|bytes| bytes.first_chunk().copied()).map(u32::from_be_bytes)
        };
        match kind {
            INTERIOR => {
                let children: Option<Vec<u32>> = (0..cells).map(|at| below(cell(at))).collect();
                let (Some(children), Some(last)) = (children, below(page.get(start + 8..))) else {
                    return damaged();
                };
                children
                    .into_iter()
                    .chain([last])
                    .try_for_each(|child| self.tree(child, depth + 1, seen, &mut *visit))
            }
            LEAF => {
                for at in 0..cells {
                    let Some(cell) = cell(at) else { return damaged() };
                    let Some((row, payload)) = self.payload(cell, seen)? else { return damaged() };
                    let Some(values) = values(&payload) else { return damaged() };
                    visit(row, &values)?;
                }
                Ok(())
            }
            _ => damaged(),
        }
    }

    /// The number and the bytes of the row in a cell, with those on other pages; nothing if the cell is damaged.
    fn payload(&mut self, cell: &[u8], seen: &mut HashSet<u32>) -> io::Result<Option<(i64, Vec<u8>)>> {
        let mut rest = cell;
        let (Some(length), Some(row)) = (varint(&mut rest), varint(&mut rest)) else { return Ok(None) };
        let length = length as u64;
        if length > MAX_ROW || length > self.pages * self.page as u64 {
            return malformed("a row is too long");
        }
        let (length, usable) = (length as usize, self.usable);
        let (most, least) = (usable - 35, (usable - 12) * 32 / 255 - 23);
        if length <= most {
            return Ok(rest.get(..length).map(|bytes| (row, bytes.to_vec())));
        }
        let fitting = least + (length - least) % (usable - 4);
        let here = if fitting <= most { fitting } else { least };
        let Some((bytes, rest)) = rest.split_at_checked(here) else { return Ok(None) };
        let (mut bytes, mut next) = (bytes.to_vec(), rest.first_chunk().copied());
        while bytes.len() < length {
            let Some(number) = next.map(u32::from_be_bytes) else { return Ok(None) };
            if !seen.insert(number) {
                return malformed("its pages are damaged: one is below itself or in two places");
            }
            let page = self.page(number)?;
            next = page.first_chunk().copied();
            bytes.extend(&page[4..usable.min(4 + length - bytes.len())]);
        }
        Ok(Some((row, bytes)))
    }
}

/// Takes a number of one to nine bytes, of which all but the ninth have seven bits.
fn varint(bytes: &mut &[u8]) -> Option<i64> {
    let mut number = 0_u64;
    for place in 0..9 {
        let (byte, rest) = bytes.split_first()?;
        *bytes = rest;
        if place == 8 {
            return Some((number << 8 | u64::from(*byte)) as i64);
        }
        number = number << 7 | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            break;
        }
    }
    Some(number as i64)
}

/// The values of a row: the types stand before them.
fn values(row: &[u8]) -> Option<Vec<Value<'_>>> {
    let mut types = row;
    let header = usize::try_from(varint(&mut types)?).ok()?;
    let (mut types, mut body) = (row.get(row.len() - types.len()..header)?, row.get(header..)?);
    let mut values = Vec::new();
    while !types.is_empty() {
        let kind = varint(&mut types)?;
        let length = match kind {
            0 | 8 | 9 => 0,
            1..=4 => kind as usize,
            5 => 6,
            6 | 7 => 8,
            _ if kind >= 12 => usize::try_from((kind - 12) / 2).ok()?,
            _ => return None,
        };
        let (bytes, rest) = body.split_at_checked(length)?;
        body = rest;
        // Integers of any length have their sign in the first bit.
        let integer = || {
            let sign = if bytes.first().is_some_and(|first| first & 0x80 != 0) { -1 } else { 0 };
            bytes.iter().fold(sign, |number: i64, byte| number << 8 | i64::from(*byte))
        };
        values.push(match kind {
            0 | 7 => Value::Other,
            8 => Value::Integer(0),
            9 => Value::Integer(1),
            1..=6 => Value::Integer(integer()),
            _ if kind % 2 == 0 => Value::Blob(bytes),
            _ => Value::Text(std::str::from_utf8(bytes).unwrap_or_default()),
        });
    }
    Some(values)
}

/// The names of the columns in the statement that creates a table, in lower case.
fn columns(sql: &str) -> Vec<String> {
    let Some((_, list)) = sql.split_once('(') else { return vec![] };
    let (mut names, mut depth, mut start) = (Vec::new(), 0, 0);
    for (at, sign) in list.char_indices() {
        match sign {
            '(' => depth += 1,
            ')' if depth > 0 => depth -= 1,
            ',' | ')' if depth == 0 => {
                let name = list[start..at].split_whitespace().next().unwrap_or_default();
                names.push(name.trim_matches(['"', '`', '[', ']', '\'']).to_lowercase());
                start = at + 1;
                if sign == ')' {
                    break;
                }
            }
            _ => {}
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// A bag with pages of 512 bytes, as `tests/data/formats/make.py` writes it.
    const BAG: &[u8] = include_bytes!("../../../../../tests/data/formats/imu.db3");
    const PAGE: usize = 512;

    fn open(bytes: &[u8]) -> io::Result<Database<'_>> {
        Database::open(Box::new(Cursor::new(bytes)), bytes.len() as u64)
    }

    /// Numbers of rows and bytes of the blobs in a table.
    fn blobs(bytes: &[u8], table: &str) -> io::Result<(usize, usize)> {
        let (mut database, mut rows, mut size) = (open(bytes)?, 0, 0);
        let table = database.table(table).unwrap();
        database.rows(&table, &mut |row, values| {
            rows += 1;
            assert_eq!((row, values[0]), (rows as i64, Value::Other));
            size += values
                .iter()
                .map(|value| if let Value::Blob(blob) = value { blob.len() } else { 0 })
                .sum::<usize>();
            Ok(())
        })?;
        Ok((rows, size))
    }

    #[test]
    fn rows_over_many_pages_are_all_read_in_their_order() {
        let database = open(BAG).unwrap();
        assert_eq!(database.names(), ["schema", "topics", "messages"]);
        let columns = ["id", "name", "type", "serialization_format", "offered_qos_profiles"];
        assert_eq!(
            columns.map(|name| database.table("topics").unwrap().column(name)),
            [0, 1, 2, 3, 4].map(Some)
        );
        // An Imu has 316 bytes, a text of 100 letters 109 and a twist 68.
        assert_eq!(blobs(BAG, "messages").unwrap(), (108, 36 * (316 + 109 + 68)));
    }

    #[test]
    fn numbers_of_all_lengths_are_read() {
        let of = |bytes: &[u8]| varint(&mut &*bytes);
        assert_eq!(
            [of(&[5]), of(&[0x81, 0]), of(&[0x80]), of(&[0xff; 9])],
            [Some(5), Some(128), None, Some(-1)]
        );
        let row = [8, 0, 1, 2, 6, 7, 9, 14, 0xfe, 0xff, 0xfe, 0, 0, 0, 0, 0, 0, 0, 3];
        let values = values(&[&row[..], &1.5_f64.to_be_bytes(), &[7]].concat()).unwrap().len();
        assert_eq!(values, 7);
    }

    #[test]
    fn damaged_pages_are_refused() {
        let root = usize::try_from(open(BAG).unwrap().table("messages").unwrap().root).unwrap();
        let start = (root - 1) * PAGE;
        assert_eq!(BAG[start], INTERIOR);
        let with = |at: usize, bytes: &[u8]| {
            let mut damaged = BAG.to_vec();
            damaged[at..at + bytes.len()].copy_from_slice(bytes);
            blobs(&damaged, "messages").unwrap_err().to_string()
        };
        for (at, bytes, piece) in [
            (start + 8, &(root as u32).to_be_bytes()[..], "one is below itself"),
            (start + 8, &[0, 1, 0, 0], "a page that is not there"),
            (start, &[7], "is damaged"),
            (start + 3, &[0xff, 0xff], "is damaged"),
            (16, &[2, 1], "its header is damaged"),
            (59, &[2], "UTF-16"),
        ] {
            let said = with(at, bytes);
            assert!(said.contains(piece), "{piece} is missing in {said}");
        }
        let cut = blobs(&BAG[..BAG.len() - PAGE], "messages").unwrap_err().to_string();
        assert!(cut.contains("ends too early"), "{cut}");
    }
}
