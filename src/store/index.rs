//! Which trials of which tallies a store holds.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use crate::store::error::StoreError;
use crate::store::row::NO_BLOCK;
use crate::store::{Address, Store};
use crate::tally::block::{Block, fold};
use crate::tally::id::Id;

/// The blocks of all rows as one reading found them: thousands of points are not asked for one by one.
#[derive(Debug)]
pub struct Index {
    path: PathBuf,
    /// By point and estimate.
    held: HashMap<(Id, Id), Held>,
}

#[derive(Debug)]
struct Held {
    digest: Id,
    blocks: Vec<Block>,
}

impl Store {
    /// What is held now. Of each row the key is read, not the tally, which was checked when the store was opened and is again
    /// when it is read.
    ///
    /// # Errors
    /// A key is none, rows of a tally were computed from different parameters, or the disk fails.
    pub fn index(&self) -> Result<Index, StoreError> {
        let mut index = Index { path: self.path.clone(), held: HashMap::new() };
        for (address, block) in self.keys()? {
            let Address { point, estimate, digest } = address;
            if !block.is_aligned() {
                let (path, first) = (index.path, block.first);
                return Err(StoreError::DamagedRow { path, point, estimate, first, what: NO_BLOCK });
            }
            let held = index.held.entry((point, estimate)).or_insert(Held { digest, blocks: vec![] });
            if held.digest != digest {
                return Err(index.disagrees(&address, block));
            }
            held.blocks.push(block);
        }
        Ok(index)
    }
}

impl Index {
    /// The points that rows are of.
    pub fn points(&self) -> HashSet<Id> {
        self.held.keys().map(|(point, _)| *point).collect()
    }

    /// The blocks held of a tally, as they were written.
    ///
    /// # Errors
    /// They were computed from other parameters.
    pub fn blocks(&self, address: &Address) -> Result<&[Block], StoreError> {
        match self.held.get(&(address.point, address.estimate)) {
            None => Ok(&[]),
            Some(held) if held.digest == address.digest => Ok(&held.blocks),
            Some(held) => Err(self.disagrees(address, held.blocks[0])),
        }
    }

    /// How many trials are held of a tally, if they are its first ones.
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
