//! The results folder's truth: a SQLite database of tallies.
//!
//! A row is the exact tally of one estimate of one point over one block of trials. Inserting an identical row is
//! nothing, a disagreeing one an error, so resuming, asking for more trials and merging are one operation, in any
//! order, any number of times. Crash safety, locking and full disks are SQLite's work.
//! Two halves of a study, merged twice over, are the whole:
//!
//! ```
//! # use sagnac::{progress::Silent, run::Plan, study::Study, tally::share::Share, verify::select};
//! use sagnac::store::{FILE, Source, Store};
//! # let text = "title = \"Noise\"\nkind = \"gap-fill\"\ntrials = 1000\n[gyro]\ntick = \"5 ms\"\ntick_noise = { std = \"1 arcsec\" }\n\
//! #     [motion]\nrate = \"0 deg/s\"\n[switching]\ngap_ticks = 2\nfillers = [\"const\"]\nerrors = [\"residual\"]\n";
//! # let study = Study::parse("noise.toml", text)?;
//! # let plan = Plan::new(&study)?;
//! # let mut device = select("cpu", 1)?.device;
//! # let folder = tempfile::tempdir()?;
//! for number in [1, 2] {
//!     let mut half = Store::open(&folder.path().join(number.to_string()), &plan.identity())?;
//!     plan.run(&mut half, &mut device, Share::new(number, 2).unwrap(), &Silent)?;
//! }
//! let mut whole = Store::open(&folder.path().join("whole"), &plan.identity())?;
//! for half in ["1", "2", "1"] {
//!     whole.merge(&Source::open(&folder.path().join(half))?, false)?;
//! }
//! assert_eq!(plan.lacks(&whole, Share::WHOLE)?, 0);
//! assert_eq!(plan.held(&whole.index()?)?, 1000);
//! assert!(folder.path().join("whole").join(FILE).exists());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "store")]
pub mod check;
#[cfg(feature = "store")]
pub mod database;
pub mod encoding;
pub mod error;
pub mod index;
#[cfg(feature = "store")]
pub mod lock;
mod memory;
pub mod row;
#[cfg(feature = "store")]
pub mod schema;
#[cfg(feature = "store")]
pub mod source;
#[cfg(all(test, feature = "store"))]
mod tests;
pub mod whole;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::kernel::moments::Moments;
use crate::kernel::rows::Rows;
#[cfg(feature = "store")]
pub use crate::store::check::Report;
#[cfg(feature = "store")]
use crate::store::database::Database;
pub use crate::store::error::StoreError;
pub use crate::store::index::Index;
#[cfg(feature = "store")]
pub use crate::store::lock::{Holder, LOCK};
use crate::store::memory::Memory;
use crate::store::row::Raw;
#[cfg(feature = "store")]
pub use crate::store::source::{Merged, Source};
pub use crate::store::whole::write_whole;
use crate::tally::block::{Block, fold};
use crate::tally::id::Id;
use crate::tally::share::Share;

/// The name of the database in a results folder.
pub const FILE: &str = "tallies.sqlite";

/// Version of the tables and of the encoding of tallies.
const SCHEMA_VERSION: i32 = 3;

/// What makes two runs the same study: a folder holds one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// As a study writes it: `gap-fill`.
    pub kind: String,
    /// As in the study.
    pub seed: u64,
    /// `independent` or `common`.
    pub streams: String,
    /// The kernels that compute it, with their versions. No part of the study id: rows of others are refused, not taken for
    /// those of another study.
    pub kernels: String,
}

impl Identity {
    /// The study id.
    pub fn id(&self) -> Id {
        Id::of(&format!("study\nkind={}\nseed={}\nstreams={}\n", self.kind, self.seed, self.streams))
    }
}

/// Which tally: of a point, of an estimate, computed from parameters with this digest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Address {
    /// All that its draws depend on.
    pub point: Id,
    /// What is made of the draws: filler and error, angle, tick or curve.
    pub estimate: Id,
    /// Of the words that it was computed from.
    pub digest: Id,
}

/// A tally as the store keeps it.
pub trait Tally: Sized {
    /// Compact bytes, the same for the same tally.
    fn encode(&self) -> Vec<u8>;

    /// Adds the tally of the trials behind these, of the same estimate.
    fn append(&mut self, next: Self);

    /// The tally of so many trials that the bytes stand for; `None` where they stand for none.
    fn decode(bytes: &[u8], trials: u64) -> Option<Self>;
}

/// One row of the store.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row<T> {
    /// Which tally.
    pub address: Address,
    /// Of which trials.
    pub block: Block,
    /// The exact sums.
    pub tally: T,
}

/// Who computes rows, how many trials and how long it took; no part of any identity.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// As `sagnac devices` calls it.
    pub device: String,
    /// Over all points, since the store was opened.
    pub trials: u64,
    /// Over all points, since the store was opened.
    pub seconds: f64,
}

/// The open store of a results folder.
///
/// What it promises:
///
/// - **One writer.** No other program can open the folder meanwhile; one that tries is refused at once and told by whom.
/// - **Nothing is lost.** A batch of rows is kept as a whole or not at all, whatever ends the program or fills the disk, and what
///   was kept before stays. (After a power failure the last batches may be missing; they are then sampled again.)
/// - **Nothing counts twice.** A trial is in one row or in rows that nest, of which the outermost counts, so the same rows
///   can be inserted or [merged](Store::merge) any number of times and in any order.
/// - **Nothing wrong is read.** Every row carries a checksum over all of it and the digest of the parameters that it was
///   computed from, and all rows are checked when the store is opened, as is the structure of the file, and each again
///   whenever it is read. What is not as it was written is an error and never a number.
/// - **One study.** A folder holds the results of one study id, computed by one version of its kernels.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    keep: Keep,
    identity: Identity,
}

/// What holds the rows.
#[derive(Debug)]
enum Keep {
    #[cfg(feature = "store")]
    Database(Database),
    Memory(Memory),
}

/// Tallies whose rows are read at once, while those of as many are added up; rows of many trials have some 2 KiB, and a tally may have fifty.
const READ_AT_ONCE: usize = 1024;

impl Store {
    /// A store in memory, for a run whose results are used at once.
    pub fn in_memory(identity: &Identity) -> Store {
        let keep = Keep::Memory(Memory::default());
        Store { path: PathBuf::from("memory"), keep, identity: identity.clone() }
    }

    /// Opens the store of a results folder, which is made where it is missing.
    ///
    /// # Errors
    /// The folder cannot be written, is in use, holds another study, or is damaged.
    #[cfg(feature = "store")]
    pub fn open(folder: &Path, identity: &Identity) -> Result<Store, StoreError> {
        let path = folder.join(FILE);
        let keep = Keep::Database(Database::open(folder, &path, identity)?);
        Ok(Store { path, keep, identity: identity.clone() })
    }

    /// The study whose results it holds.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// Notes that a share of the study is sampled here, for who looks whether the folder has all that it should.
    ///
    /// # Errors
    /// The disk fails.
    pub fn note_share(&mut self, share: Share) -> Result<(), StoreError> {
        match &mut self.keep {
            #[cfg(feature = "store")]
            Keep::Database(database) => database.note_share(share, &self.path),
            Keep::Memory(memory) => {
                memory.shares.push(share);
                Ok(())
            }
        }
    }

    /// The shares that were to be sampled here, the whole study as one of them.
    ///
    /// # Errors
    /// The disk fails.
    pub fn shares(&self) -> Result<Vec<Share>, StoreError> {
        match &self.keep {
            #[cfg(feature = "store")]
            Keep::Database(database) => database.shares(&self.path),
            Keep::Memory(memory) => Ok(memory.shares.clone()),
        }
    }

    /// Adds rows, all of them or, on an error, none; and notes in the same step what this session has done so far, if that
    /// is told, so that a run which is killed has left both or neither.
    ///
    /// # Errors
    /// A row is there already with other values, or the disk fails.
    pub fn insert<T: Tally>(
        &mut self,
        rows: &[Row<T>],
        so_far: Option<&Provenance>,
    ) -> Result<(), StoreError> {
        let rows: Vec<Raw> = rows.iter().map(Raw::of).collect();
        match &mut self.keep {
            #[cfg(feature = "store")]
            Keep::Database(database) => database.insert(&rows, so_far, &self.path, &self.path).map(drop),
            Keep::Memory(memory) => memory.insert(&rows, so_far, &self.path).map(drop),
        }
    }

    /// The tally over all trials held, folded from its rows.
    ///
    /// # Errors
    /// A row is damaged or was computed from other parameters, or the disk fails.
    pub fn total(&self, address: &Address) -> Result<Moments, StoreError> {
        self.total_within(address, u64::MAX)
    }

    /// The same of the rows that lie within the first `trials` trials.
    ///
    /// # Errors
    /// Those of [`Store::total`].
    pub fn total_within(&self, address: &Address, trials: u64) -> Result<Moments, StoreError> {
        added_up(&self.held(address, trials)?, &self.path)
    }

    /// What `of` makes of the same of several, each told by its place, in their order. While some are read others are added up.
    ///
    /// # Errors
    /// Those of [`Store::total`].
    pub fn of_totals<T: Send>(
        &self,
        addresses: &[Address],
        of: impl Fn(usize, &Moments) -> T + Sync,
    ) -> Result<Vec<T>, StoreError> {
        let mut all = Vec::with_capacity(addresses.len());
        let mut read: Vec<Vec<Raw>> = Vec::new();
        let path = self.path.as_path();
        // Behind the last ones nothing is left to read.
        for addresses in addresses.chunks(READ_AT_ONCE).chain([&[][..]]) {
            let (first, mut made) = (all.len(), Ok(vec![]));
            let next = rayon::in_place_scope(|scope| {
                scope.spawn(|_| {
                    let one = |(at, rows): (usize, &Vec<Raw>)| Ok(of(first + at, &added_up(rows, path)?));
                    made = read.par_iter().enumerate().map(one).collect();
                });
                let held = addresses.iter().map(|address| self.held(address, u64::MAX));
                held.collect::<Result<_, StoreError>>()
            });
            all.append(&mut made?);
            read = next?;
        }
        Ok(all)
    }

    /// The rows of all trials held, `width` integers each, in their order.
    ///
    /// # Errors
    /// Those of [`Store::total`].
    pub fn rows(&self, address: &Address, width: usize) -> Result<Vec<Rows>, StoreError> {
        let rows = |raw: Raw| match raw.tally::<Rows>(&self.path)? {
            rows if rows.width == width => Ok(rows),
            _ => Err(raw.damaged(&self.path, "its rows are of another width")),
        };
        self.held(address, u64::MAX)?.into_iter().map(rows).collect()
    }

    /// The rows that lie within the first `trials` trials, none of them twice, in their order, each of them sound and of the right
    /// parameters.
    fn held(&self, address: &Address, trials: u64) -> Result<Vec<Raw>, StoreError> {
        let rows = match &self.keep {
            #[cfg(feature = "store")]
            Keep::Database(database) => database.rows(address, &self.path)?,
            Keep::Memory(memory) => memory.rows(address),
        };
        let mut held = Vec::new();
        for raw in rows {
            let raw = raw.sound(&self.path)?;
            if raw.address.digest != address.digest {
                return Err(raw.disagrees(&self.path));
            }
            if raw.block.end() <= trials {
                held.push((raw.block, raw));
            }
        }
        Ok(fold(held).into_iter().map(|(_, raw)| raw).collect())
    }

    /// Which devices computed the rows, each once with all its trials and seconds, the one with the most trials first. Rows that
    /// were merged from other folders count as well; time that several machines worked at once is added up.
    ///
    /// # Errors
    /// The database cannot be read.
    pub fn provenance(&self) -> Result<Vec<Provenance>, StoreError> {
        match &self.keep {
            #[cfg(feature = "store")]
            Keep::Database(database) => database.provenance(&self.path),
            Keep::Memory(memory) => Ok(memory.provenance()),
        }
    }

    /// Which trials of which tallies are held.
    fn keys(&self) -> Result<Vec<(Address, Block)>, StoreError> {
        match &self.keep {
            #[cfg(feature = "store")]
            Keep::Database(database) => database.keys(&self.path),
            Keep::Memory(memory) => Ok(memory.keys()),
        }
    }
}

/// The tally of all trials of some rows that have none in common.
fn added_up(rows: &[Raw], path: &Path) -> Result<Moments, StoreError> {
    let mut total = Moments::empty(true);
    for raw in rows {
        raw.add_to(&mut total, path)?;
    }
    Ok(total)
}
