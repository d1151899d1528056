//! The trials that a store holds of each tally.

use std::collections::HashSet;
use std::path::PathBuf;

use crate::store::row::NO_BLOCK;
use crate::store::{Address, Store, StoreError};
use crate::tally::{Block, Id, fold};

/// The blocks of all rows, read at once to avoid a query for each of thousands of points.
#[derive(Debug)]
pub struct Index {
    path: PathBuf,
    /// The address of each tally, by point and estimate, with the place behind its last block.
    held: Vec<(Address, usize)>,
    /// The blocks of all tallies, one tally after the other.
    blocks: Vec<Block>,
}

impl Store {
    /// The trials held now. Only the keys of rows are read, not their tallies, which were checked when the store was
    /// opened and are checked again when they are read.
    ///
    /// # Errors
    /// A key is invalid, rows of a tally were computed from different parameters, or the disk fails.
    pub fn index(&self) -> Result<Index, StoreError> {
        let mut keys = self.keep.keys()?;
        // A database gives them in this order already, and a stable sort then takes one look at each.
        keys.sort_by_key(|(address, _)| (address.point, address.estimate));
        let mut index =
            Index { path: self.path.clone(), held: Vec::new(), blocks: Vec::with_capacity(keys.len()) };
        for (address, block) in keys {
            let Address { point, estimate, digest } = address;
            if !block.is_aligned() {
                let (path, first) = (index.path, block.first);
                return Err(StoreError::DamagedRow { path, point, estimate, first, what: NO_BLOCK });
            }
            index.blocks.push(block);
            let end = index.blocks.len();
            match index.held.last_mut() {
                Some((last, behind)) if (last.point, last.estimate) == (point, estimate) => {
                    if last.digest != digest {
                        return Err(index.disagrees(&address, block));
                    }
                    *behind = end;
                }
                _ => index.held.push((address, end)),
            }
        }
        Ok(index)
    }
}

impl Index {
    /// The points of which rows are held.
    pub fn points(&self) -> HashSet<Id> {
        self.held.iter().map(|(address, _)| address.point).collect()
    }

    /// The blocks held of a tally, as written.
    ///
    /// # Errors
    /// They were computed from other parameters.
    pub fn blocks(&self, address: &Address) -> Result<&[Block], StoreError> {
        let key = (address.point, address.estimate);
        let Ok(place) = self.held.binary_search_by_key(&key, |(own, _)| (own.point, own.estimate)) else {
            return Ok(&[]);
        };
        let start = place.checked_sub(1).map_or(0, |before| self.held[before].1);
        let (own, end) = &self.held[place];
        let blocks = &self.blocks[start..*end];
        if own.digest == address.digest { Ok(blocks) } else { Err(self.disagrees(address, blocks[0])) }
    }

    /// The number of trials held of a tally, if they are its first ones.
    ///
    /// # Errors
    /// Those of [`Index::blocks`].
    pub fn trials(&self, address: &Address) -> Result<Option<u64>, StoreError> {
        let blocks = fold(self.blocks(address)?.iter().map(|&block| (block, ())).collect());
        let end = blocks.last().map_or(0, |(block, ())| block.end());
        let held: u64 = blocks.iter().map(|(block, ())| block.trials()).sum();
        Ok((held == end).then_some(end))
    }

    fn disagrees(&self, address: &Address, block: Block) -> StoreError {
        let Address { point, estimate, .. } = *address;
        StoreError::Disagrees { path: self.path.clone(), point, estimate, first: block.first }
    }
}
