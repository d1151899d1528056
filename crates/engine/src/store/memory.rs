//! A store in memory, whose results end with the program.

use std::collections::HashMap;
use std::path::Path;

use crate::store::row::Raw;
use crate::store::{Address, Keep, Provenance, StoreError};
use crate::tally::{Block, Id, Share};

/// Rows by point and estimate.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    rows: HashMap<(Id, Id), Vec<Raw>>,
    shares: Vec<Share>,
    provenance: Option<Provenance>,
}

impl Keep for Memory {
    fn note_share(&mut self, share: Share) -> Result<(), StoreError> {
        self.shares.push(share);
        Ok(())
    }

    fn shares(&self) -> Result<Vec<Share>, StoreError> {
        Ok(self.shares.clone())
    }

    fn insert(&mut self, rows: &[Raw], so_far: Option<&Provenance>, from: &Path) -> Result<u64, StoreError> {
        let mut added = Vec::new();
        for raw in rows {
            let held =
                self.rows.get(&(raw.address.point, raw.address.estimate)).map_or(&[][..], Vec::as_slice);
            if held.iter().any(|held| held.address != raw.address) {
                return Err(raw.disagrees(from));
            }
            match held.iter().find(|held| held.block == raw.block) {
                Some(held) if held != raw => return Err(raw.disagrees(from)),
                Some(_) => {}
                None => added.push(raw),
            }
        }
        for raw in &added {
            let held = self.rows.entry((raw.address.point, raw.address.estimate)).or_default();
            // Equal points of a study have the same rows, and may have sampled both.
            if held.iter().all(|held| held.block != raw.block) {
                held.push((*raw).clone());
            }
        }
        if let Some(so_far) = so_far {
            self.provenance = Some(so_far.clone());
        }
        Ok(added.len() as u64)
    }

    fn rows(&self, addresses: &[Address]) -> Result<Vec<Vec<Raw>>, StoreError> {
        let of = |address: &Address| self.rows.get(&(address.point, address.estimate)).cloned();
        Ok(addresses.iter().map(|address| of(address).unwrap_or_default()).collect())
    }

    fn keys(&self) -> Result<Vec<(Address, Block)>, StoreError> {
        Ok(self.rows.values().flatten().map(|raw| (raw.address, raw.block)).collect())
    }

    fn provenance(&self) -> Result<Vec<Provenance>, StoreError> {
        Ok(self.provenance.iter().cloned().collect())
    }
}
