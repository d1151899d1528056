//! Writing of HDF5 files: a group with a contiguous dataset of numbers for each column, in the oldest version of the format, which every
//! reader knows.
//!
//! All addresses follow from the number of samples, so that datasets are written one after the other and nothing is sought.

use std::io::{self, Write};

use super::{Head, Numbers, write_numbers};

/// An address that is not there.
const UNDEFINED: u64 = u64::MAX;

/// Half of the most entries of a node of symbols, and of the tree, whose single node is the root.
const LEAF: usize = 8;
const TREE: usize = 16;

/// Types of messages of a header.
const DATASPACE: u16 = 1;
const DATATYPE: u16 = 3;
const FILL_VALUE: u16 = 5;
const LAYOUT: u16 = 8;
const ATTRIBUTE: u16 = 12;
const SYMBOL_TABLE: u16 = 17;

/// Sizes of what has one size only.
const SUPERBLOCK: usize = 96;
const ROOT_HEADER: usize = 16 + 8 + 16;
const TREE_NODE: usize = 24 + 8 * (4 * TREE + 1);
const HEAP_HEADER: usize = 32;
const SYMBOLS: usize = 8 + 2 * LEAF * 40;

/// Most columns besides the times.
pub(super) const MAX_COLUMNS: usize = 2 * LEAF - 1;

/// Little-endian numbers, one after the other.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn raw(mut self, bytes: &[u8]) -> Bytes {
        self.0.extend(bytes);
        self
    }

    fn word(self, number: u64, length: usize) -> Bytes {
        self.raw(&number.to_le_bytes()[..length])
    }

    fn words(self, numbers: &[u64]) -> Bytes {
        numbers.iter().fold(self, |bytes, number| bytes.word(*number, 8))
    }

    fn padded(mut self, length: usize) -> Bytes {
        self.0.resize(length.max(self.0.len()), 0);
        self
    }

    /// Up to a multiple of 8 bytes.
    fn whole(self) -> Bytes {
        let length = self.0.len().next_multiple_of(8);
        self.padded(length)
    }
}

/// The header of an object with messages, each with its type.
fn object(messages: &[(u16, Vec<u8>)]) -> Vec<u8> {
    let size: usize = messages.iter().map(|(_, bytes)| 8 + bytes.len()).sum();
    let start = Bytes::default().word(1, 2).word(messages.len() as u64, 2).word(1, 4).word(size as u64, 8);
    let message = |to: Bytes, (kind, bytes): &(u16, Vec<u8>)| {
        to.word((*kind).into(), 2).word(bytes.len() as u64, 2).word(0, 4).raw(bytes)
    };
    messages.iter().fold(start, message).0
}

/// The type of numbers of 8 bytes of IEEE 754.
fn double() -> Vec<u8> {
    // Class 1 of version 1, with an implied leading bit, the sign at bit 63, 11 bits of exponent at 52, and 52 of fraction at 0.
    let head = Bytes::default().raw(&[0x11, 0x20, 63, 0]).word(8, 4);
    head.word(0, 2).word(64, 2).raw(&[52, 11, 0, 52]).word(1023, 4).whole().0
}

/// The space of a scalar, or of a vector of so many numbers.
fn space(count: Option<u64>) -> Vec<u8> {
    let rank = u8::from(count.is_some());
    Bytes::default().raw(&[1, rank, 0, 0, 0, 0, 0, 0]).words(count.as_slice()).0
}

/// An attribute with one value of a type.
fn attribute(name: &str, datatype: &[u8], value: &[u8]) -> (u16, Vec<u8>) {
    let space = space(None);
    let sizes = [name.len() + 1, datatype.len(), space.len()];
    let head = sizes.iter().fold(Bytes::default().word(1, 2), |bytes, size| bytes.word(*size as u64, 2));
    let named = head.raw(name.as_bytes()).word(0, 1).whole();
    (ATTRIBUTE, named.raw(datatype).raw(&space).raw(value).whole().0)
}

/// The header of a dataset of numbers at an address.
fn dataset(count: u64, address: u64, unit: &str, rate_hz: f64) -> Vec<u8> {
    // A text in UTF-8 that ends with a zero.
    let text = Bytes::default().raw(&[0x13, 0x10, 0, 0]).word(unit.len() as u64 + 1, 4).0;
    let value = Bytes::default().raw(unit.as_bytes()).word(0, 1).0;
    object(&[
        (DATASPACE, space(Some(count))),
        (DATATYPE, double()),
        // Version 2, with space at the time of writing, and a value of size 0.
        (FILL_VALUE, vec![2, 2, 2, 1, 0, 0, 0, 0]),
        // Version 3, contiguous.
        (LAYOUT, Bytes::default().raw(&[3, 1]).words(&[address, 8 * count]).whole().0),
        attribute("units", &text, &value),
        attribute("sampling_rate_hz", &double(), &rate_hz.to_le_bytes()),
    ])
}

/// All of the file before the numbers, with a dataset for each name and unit, whose numbers follow in this order.
fn before(named: &[(&str, &str)], count: u64, rate_hz: f64) -> Vec<u8> {
    let headers = |addresses: u64| -> Vec<Vec<u8>> {
        (0..)
            .zip(named)
            .map(|(k, (_, unit))| dataset(count, addresses + 8 * count * k, unit, rate_hz))
            .collect()
    };
    // Names begin after an empty one.
    let (mut heap, mut names) = (Bytes::default().word(0, 8), vec![]);
    for (name, _) in named {
        names.push(heap.0.len() as u64);
        heap = heap.raw(name.as_bytes()).word(0, 1).whole();
    }
    let sizes = [SUPERBLOCK, ROOT_HEADER, TREE_NODE, HEAP_HEADER, heap.0.len(), SYMBOLS];
    let mut places = sizes.iter().scan(0, |end, size| {
        *end += *size as u64;
        Some(*end)
    });
    let [root, tree, heap_header, heap_data, symbols, first] =
        std::array::from_fn(|_| places.next().unwrap_or_default());
    let lengths: Vec<u64> = headers(0).iter().map(|header| header.len() as u64).collect();
    let numbers = first + lengths.iter().sum::<u64>();
    // Symbols are sorted by their names.
    let mut order: Vec<usize> = (0..named.len()).collect();
    order.sort_by_key(|k| named[*k].0);
    let last = order.last().map_or(0, |k| names[*k]);
    let end = numbers + 8 * count * named.len() as u64;

    let mut file = Bytes::default().raw(b"\x89HDF\r\n\x1a\n").raw(&[0, 0, 0, 0, 0, 8, 8, 0]);
    file = file.word(LEAF as u64, 2).word(TREE as u64, 2).word(0, 4);
    file = file.words(&[0, UNDEFINED, end, UNDEFINED, 0, root]).word(1, 8).words(&[tree, heap_header]);
    file = file.raw(&object(&[(SYMBOL_TABLE, Bytes::default().words(&[tree, heap_header]).0)]));
    file = file.raw(b"TREE").word(0, 2).word(1, 2).words(&[UNDEFINED, UNDEFINED, 0, symbols, last]);
    file = file.padded(heap_header as usize);
    // No part of the heap is free.
    file = file.raw(b"HEAP").word(0, 4).words(&[heap.0.len() as u64, 1, heap_data]).raw(&heap.0);
    file = file.raw(b"SNOD").word(1, 2).word(named.len() as u64, 2);
    for k in order {
        let header = first + lengths[..k].iter().sum::<u64>();
        file = file.words(&[names[k], header, 0, 0, 0]);
    }
    file = file.padded(first as usize);
    headers(numbers).iter().fold(file, |file, header| file.raw(header)).0
}

/// Writes times and columns, each as a dataset with its unit and the sampling rate as attributes.
pub(super) fn write<'a>(
    head: &Head,
    column: &dyn Fn(usize) -> Numbers<'a>,
    to: &mut dyn Write,
) -> io::Result<()> {
    let columns = head.columns.iter().map(|column| (&*column.name, &*column.unit));
    let named: Vec<(&str, &str)> = [("time", "s")].into_iter().chain(columns).collect();
    to.write_all(&before(&named, head.samples, 1.0 / head.step_s))?;
    write_numbers(head.times(), to)?;
    (0..head.columns.len()).try_for_each(|place| write_numbers(column(place), to))
}
