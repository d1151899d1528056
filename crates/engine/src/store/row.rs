//! Rows as stored in the database, their encoding and their checks.

use std::path::Path;

use crate::store::{Address, Row, StoreError, Tally};
use crate::tally::{Block, Id};
use sagnac_kernel::moments::Moments;
use sagnac_kernel::rows::Rows;

/// The columns of a row, in the order in which [`Raw`] reads them.
#[cfg(feature = "store")]
pub(crate) const COLUMNS: &str = "point, estimate, first, log2, digest, sums, checksum";

/// Damage of a row whose key is invalid.
pub(crate) const NO_BLOCK: &str = "it is of no block of trials";

/// Damage of a row whose bytes encode no tally.
const NO_TALLY: &str = "it is no tally of its block";

/// A row with its tally as bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Raw {
    pub(crate) address: Address,
    pub(crate) block: Block,
    pub(crate) sums: Vec<u8>,
    pub(crate) checksum: u32,
}

impl Raw {
    pub(crate) fn new<T: Tally>(row: &Row<T>) -> Raw {
        let Row { address, block, tally } = row;
        let sums = tally.encode();
        Raw { address: *address, block: *block, checksum: checksum(address, *block, &sums), sums }
    }

    /// Reads the key of a row, which begins with point, estimate, first trial, log2 and digest.
    #[cfg(feature = "store")]
    pub(crate) fn read_key(row: &rusqlite::Row) -> Result<(Address, Block), rusqlite::Error> {
        let address = Address { point: Id(row.get(0)?), estimate: Id(row.get(1)?), digest: Id(row.get(4)?) };
        Ok((address, Block { first: row.get::<_, i64>(2)? as u64, log2: row.get(3)? }))
    }

    /// Reads a row without any check.
    #[cfg(feature = "store")]
    pub(crate) fn read(row: &rusqlite::Row) -> Result<Raw, rusqlite::Error> {
        let (address, block) = Raw::read_key(row)?;
        Ok(Raw { address, block, sums: row.get(5)?, checksum: row.get(6)? })
    }

    /// Appends the row to `bytes`.
    pub(crate) fn put(&self, bytes: &mut Vec<u8>) {
        let Address { point, estimate, digest } = self.address;
        [point, estimate, digest].iter().for_each(|id| bytes.extend(id.0));
        bytes.extend(self.block.first.to_le_bytes());
        bytes.extend(self.block.log2.to_le_bytes());
        bytes.extend(self.checksum.to_le_bytes());
        bytes.extend((self.sums.len() as u64).to_le_bytes());
        bytes.extend(&self.sums);
    }

    /// Takes a row from the front of `bytes`; `None` where they end within it.
    pub(crate) fn take(bytes: &mut &[u8]) -> Option<Raw> {
        let mut next = || -> Option<[u8; 16]> {
            let (id, rest) = bytes.split_first_chunk()?;
            *bytes = rest;
            Some(*id)
        };
        let address = Address { point: Id(next()?), estimate: Id(next()?), digest: Id(next()?) };
        let (first, rest) = bytes.split_first_chunk()?;
        let (log2, rest) = rest.split_first_chunk()?;
        let (checksum, rest) = rest.split_first_chunk()?;
        let (length, rest) = rest.split_first_chunk()?;
        let block = Block { first: u64::from_le_bytes(*first), log2: u32::from_le_bytes(*log2) };
        let (sums, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
        *bytes = rest;
        Some(Raw { address, block, sums: sums.to_vec(), checksum: u32::from_le_bytes(*checksum) })
    }

    /// Returns the row if it is as written.
    ///
    /// # Errors
    /// The row is damaged.
    pub(crate) fn sound(self, path: &Path) -> Result<Raw, StoreError> {
        if self.checksum != checksum(&self.address, self.block, &self.sums) {
            return Err(self.damaged(path, "its checksum is wrong"));
        }
        if !self.block.is_aligned() {
            return Err(self.damaged(path, NO_BLOCK));
        }
        Ok(self)
    }

    /// Decodes the tally of the row.
    ///
    /// # Errors
    /// The bytes are no tally of the row's block.
    pub(crate) fn tally<T: Tally>(&self, path: &Path) -> Result<T, StoreError> {
        T::decode(&self.sums, self.block.trials()).ok_or_else(|| self.damaged(path, NO_TALLY))
    }

    /// Adds the tally of the row to `total`, which belongs to other trials and is invalid after an error.
    ///
    /// # Errors
    /// It fails where [`Raw::tally`] does.
    pub(crate) fn add_to(&self, total: &mut Moments, path: &Path) -> Result<(), StoreError> {
        add(&self.sums, self.block.trials(), total).ok_or_else(|| self.damaged(path, NO_TALLY))
    }

    pub(crate) fn damaged(&self, path: &Path, what: &'static str) -> StoreError {
        let Address { point, estimate, .. } = self.address;
        StoreError::DamagedRow { path: path.to_owned(), point, estimate, first: self.block.first, what }
    }

    pub(crate) fn disagrees(&self, path: &Path) -> StoreError {
        let Address { point, estimate, .. } = self.address;
        StoreError::Disagrees { path: path.to_owned(), point, estimate, first: self.block.first }
    }
}

/// Checksum over the whole row, so that a row moved to another place is detected too.
fn checksum(address: &Address, block: Block, sums: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for part in [&address.point.0[..], &address.estimate.0, &address.digest.0, &block.first.to_le_bytes()] {
        hasher.update(part);
    }
    hasher.update(&block.log2.to_le_bytes());
    hasher.update(sums);
    hasher.finalize()
}

impl Tally for Moments {
    fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        put(&mut bytes, u128::from(self.count));
        put(&mut bytes, zigzag(self.sum));
        put(&mut bytes, self.square);
        put(&mut bytes, zigzag(self.least.into()));
        put(&mut bytes, zigzag(self.greatest.into()));
        let mut rest = &self.bins[..];
        while let Some(empty) = rest.iter().position(|&count| count > 0) {
            let filled = rest[empty..].iter().position(|&count| count == 0).unwrap_or(rest.len() - empty);
            put(&mut bytes, empty as u128);
            put(&mut bytes, filled as u128);
            rest[empty..empty + filled].iter().for_each(|&count| put(&mut bytes, u128::from(count)));
            rest = &rest[empty + filled..];
        }
        bytes
    }

    fn append(&mut self, next: Moments) {
        self.merge(&next);
    }

    fn decode(bytes: &[u8], trials: u64) -> Option<Moments> {
        let mut tally = Moments::empty(true);
        add(bytes, trials, &mut tally)?;
        Some(tally)
    }
}

impl Tally for Rows {
    fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        put(&mut bytes, self.width as u128);
        self.values.iter().for_each(|&value| put(&mut bytes, value));
        bytes
    }

    fn append(&mut self, next: Rows) {
        self.values.extend(next.values);
    }

    fn decode(bytes: &[u8], trials: u64) -> Option<Rows> {
        let mut rest = bytes;
        let width = usize::try_from(take(&mut rest)?).ok()?;
        // A number takes at least one byte, so no count of a damaged row requests more memory than there are bytes.
        let mut values =
            Vec::with_capacity(rest.len().min(width.checked_mul(usize::try_from(trials).ok()?)?));
        while !rest.is_empty() {
            values.push(take(&mut rest)?);
        }
        let rows = Rows { width, values };
        (width as u128 * u128::from(trials) == rows.values.len() as u128).then_some(rows)
    }
}

/// Adds the tally of `trials` trials that the bytes encode to `total`, which has a histogram. Returns `None` where the
/// bytes encode none; `total` is then invalid.
fn add(bytes: &[u8], trials: u64, total: &mut Moments) -> Option<()> {
    let mut rest = bytes;
    let part = Moments {
        count: take(&mut rest)?.try_into().ok().filter(|&count: &u64| count == trials)?,
        sum: unzigzag(take(&mut rest)?),
        square: take(&mut rest)?,
        least: unzigzag(take(&mut rest)?).try_into().ok()?,
        greatest: unzigzag(take(&mut rest)?).try_into().ok()?,
        bins: vec![],
    };
    total.merge(&part);
    let (mut bin, mut counted): (usize, u64) = (0, 0);
    while !rest.is_empty() {
        bin = bin.checked_add(usize::try_from(take(&mut rest)?).ok()?)?;
        let filled = usize::try_from(take(&mut rest)?).ok()?;
        for count in total.bins.get_mut(bin..bin.checked_add(filled)?)? {
            let more = take(&mut rest)?.try_into().ok()?;
            counted = counted.checked_add(more)?;
            *count = count.checked_add(more)?;
        }
        bin += filled;
    }
    (counted == trials).then_some(())
}

fn put(bytes: &mut Vec<u8>, mut number: u128) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

fn take(bytes: &mut &[u8]) -> Option<u128> {
    // Most numbers are small.
    if let Some((&byte, rest)) = bytes.split_first()
        && byte < 0x80
    {
        *bytes = rest;
        return Some(byte.into());
    }
    let (mut number, mut shift) = (0_u128, 0);
    loop {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        let part = u128::from(byte & 0x7f);
        if shift >= 128 || part.leading_zeros() < shift {
            return None;
        }
        number |= part << shift;
        if byte < 0x80 {
            return Some(number);
        }
        shift += 7;
    }
}

fn zigzag(number: i128) -> u128 {
    ((number << 1) ^ (number >> 127)) as u128
}

fn unzigzag(number: u128) -> i128 {
    (number >> 1) as i128 ^ -((number & 1) as i128)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_kernel::moments::BINS;

    #[test]
    fn a_tally_survives_its_bytes() {
        let mut tally = Moments::empty(true);
        tally.bins[3] = 1;
        tally.bins[BINS - 1] = u64::MAX - 1;
        tally.count = u64::MAX;
        for sum in [0, 1, -1, i128::MAX, i128::MIN] {
            (tally.sum, tally.square, tally.least, tally.greatest) = (sum, u128::MAX, i32::MIN, i32::MAX);
            assert_eq!(<Moments as Tally>::decode(&tally.encode(), tally.count).as_ref(), Some(&tally));
        }
    }

    #[test]
    fn rows_survive_their_bytes_and_are_refused_when_cut_or_of_other_trials() {
        let rows = Rows { width: 3, values: vec![0, 1, u128::MAX, 1 << 90, 127, 128] };
        let bytes = Tally::encode(&rows);
        assert_eq!(<Rows as Tally>::decode(&bytes, 2).as_ref(), Some(&rows));
        for length in 0..bytes.len() {
            assert_eq!(<Rows as Tally>::decode(&bytes[..length], 2), None, "cut to {length}");
        }
        assert_eq!(<Rows as Tally>::decode(&[&bytes[..], &[0]].concat(), 2), None);
        assert_eq!(<Rows as Tally>::decode(&bytes, 1), None);
        assert_eq!(<Rows as Tally>::decode(&bytes, u64::MAX), None);
    }

    #[test]
    fn cut_or_lengthened_bytes_are_refused() {
        let mut tally = Moments::empty(true);
        (tally.count, tally.bins[5]) = (300, 300);
        let bytes = tally.encode();
        let decoded = |bytes: &[u8]| <Moments as Tally>::decode(bytes, 300);
        for length in 0..bytes.len() {
            assert_eq!(decoded(&bytes[..length]), None, "cut to {length}");
        }
        assert_eq!(decoded(&[&bytes[..], &[0]].concat()), None);
        assert_eq!(decoded(&[0xff; 40]), None);
        assert_eq!(<Moments as Tally>::decode(&bytes, 299), None);
        assert_eq!(decoded(&bytes), Some(tally));
    }
}
