//! Rows as stored in the database, and their checks.

use std::path::Path;

use crate::store::encoding::add;
use crate::store::{Address, Row, StoreError, Tally};
use crate::tally::Block;
#[cfg(feature = "store")]
use crate::tally::Id;
use sagnac_kernel::moments::Moments;

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
    pub(crate) fn of<T: Tally>(row: &Row<T>) -> Raw {
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
