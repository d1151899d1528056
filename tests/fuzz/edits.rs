//! Edits of bytes, whatever they stand for.

use std::ops::Range;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

/// Longest input that edits make.
pub const MAX_INPUT: usize = 1 << 21;

/// One edit; places are parts of whatever there is.
#[derive(Debug, Clone)]
pub enum Edit {
    Cut(Index, usize),
    /// Everything behind a place.
    End(Index),
    Flip(Index, u8),
    Insert(Index, Vec<u8>),
    /// Some bytes from one place once more at another.
    Copy(Index, usize, Index),
    /// A line once more, so many times.
    Repeat(Index, usize),
    RemoveLine(Index),
    /// The same again and again.
    Fill(Index, Vec<u8>, usize),
}

/// Some edits, `most` at most; `words` are what is likely to be met at a place.
pub fn edits(most: usize, words: &'static [&'static str]) -> impl Strategy<Value = Vec<Edit>> {
    let index = any::<Index>;
    let inserted = move || {
        prop_oneof![
            4 => proptest::sample::select(words).prop_map(|word| word.as_bytes().to_vec()),
            1 => vec(any::<u8>(), 1..8),
        ]
    };
    // Up to a megabyte or so: what takes the square of a length is found by that.
    let times = prop_oneof![4 => 1_usize..100, 1 => 100_usize..200_000];
    let length = || prop_oneof![4 => 1_usize..8, 1 => 1_usize..512];
    let edit = prop_oneof![
        2 => (index(), length()).prop_map(|(at, length)| Edit::Cut(at, length)),
        1 => index().prop_map(Edit::End),
        2 => (index(), 0_u8..8).prop_map(|(at, bit)| Edit::Flip(at, bit)),
        4 => (index(), inserted()).prop_map(|(at, bytes)| Edit::Insert(at, bytes)),
        2 => (index(), length(), index()).prop_map(|(from, length, to)| Edit::Copy(from, length, to)),
        1 => (index(), prop_oneof![4 => 1_usize..3, 1 => 1_usize..2000]).prop_map(|(at, n)| Edit::Repeat(at, n)),
        1 => index().prop_map(Edit::RemoveLine),
        1 => (index(), inserted(), times).prop_map(|(at, bytes, times)| Edit::Fill(at, bytes, times)),
    ];
    vec(edit, 0..=most)
}

/// Carries out `edits` one after the other.
pub fn apply(bytes: &mut Vec<u8>, edits: &[Edit]) {
    for edit in edits {
        let place = |index: &Index| index.index(bytes.len() + 1);
        match edit {
            Edit::Cut(at, length) => drop(bytes.drain(range(bytes, place(at), *length))),
            Edit::End(at) => bytes.truncate(place(at)),
            Edit::Flip(at, bit) => {
                let at = place(at);
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << bit;
                }
            }
            Edit::Insert(at, inserted) => insert(bytes, place(at), inserted),
            Edit::Copy(from, length, to) => {
                let copied = bytes[range(bytes, place(from), *length)].to_owned();
                insert(bytes, place(to), &copied);
            }
            Edit::Repeat(at, times) => {
                let line = line(bytes, place(at));
                let copied = repeated(&bytes[line.clone()], *times);
                insert(bytes, line.end, &copied);
            }
            Edit::Fill(at, filling, times) => insert(bytes, place(at), &repeated(filling, *times)),
            Edit::RemoveLine(at) => drop(bytes.drain(line(bytes, place(at)))),
        }
    }
}

fn range(bytes: &[u8], start: usize, length: usize) -> Range<usize> {
    start..(start + length).min(bytes.len())
}

fn repeated(part: &[u8], times: usize) -> Vec<u8> {
    part.repeat(times.min(MAX_INPUT / part.len().max(1)))
}

/// Nothing where that would be too long.
fn insert(bytes: &mut Vec<u8>, at: usize, inserted: &[u8]) {
    if bytes.len() + inserted.len() <= MAX_INPUT {
        bytes.splice(at..at, inserted.iter().copied());
    }
}

/// The line around a place, with its end.
fn line(bytes: &[u8], at: usize) -> Range<usize> {
    let start = bytes[..at].iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
    let end = bytes[at..].iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |end| at + end + 1);
    start..end
}
