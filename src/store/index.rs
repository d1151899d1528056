//! The trials that a store holds of each tally.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use crate::store::row::NO_BLOCK;
use crate::store::{Address, Store, StoreError};
use crate::tally::block::{Block, fold};
use crate::tally::id::Id;

/// The blocks of all rows, read at once to avoid a query for each of thousands of points.
#[derive(Debug)]
pub struct Index {
    path: PathBuf,
    /// Digests of parameters and blocks, by point and estimate.
    held: HashMap<(Id, Id), (Id, Vec<Block>)>,
}

impl Store {
    /// The trials held now. Only the keys of rows are read, not their tallies, which were checked when the store was
    /// opened and are checked again when they are read.
    ///
    /// # Errors
    /// A key is invalid, rows of a tally were computed from different parameters, or the disk fails.
    pub fn index(&self) -> Result<Index, StoreError> {
        let mut index = Index { path: self.path.clone(), held: HashMap::new() };
        for (address, block) in self.keep.keys()? {
            let Address { point, estimate, digest } = address;
            if !block.is_aligned() {
                let (path, first) = (index.path, block.first);
                return Err(StoreError::DamagedRow { path, point, estimate, first, what: NO_BLOCK });
            }
            let (known, blocks) = index.held.entry((point, estimate)).or_insert((digest, vec![]));
            if *known != digest {
                return Err(index.disagrees(&address, block));
            }
            blocks.push(block);
        }
        Ok(index)
    }
}

impl Index {
    /// The points of which rows are held.
    pub fn points(&self) -> HashSet<Id> {
        self.held.keys().map(|(point, _)| *point).collect()
    }

    /// The blocks held of a tally, as written.
    ///
    /// # Errors
    /// They were computed from other parameters.
    pub fn blocks(&self, address: &Address) -> Result<&[Block], StoreError> {
        match self.held.get(&(address.point, address.estimate)) {
            None => Ok(&[]),
            Some((digest, blocks)) if *digest == address.digest => Ok(blocks),
            Some((_, blocks)) => Err(self.disagrees(address, blocks[0])),
        }
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
