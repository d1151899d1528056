//! The store of a results folder: a SQLite database of tallies.
//!
//! A row is the exact tally of one estimate of one point over one block of trials. Inserting an identical row has no
//! effect; inserting one that disagrees is an error. Resuming, adding trials and merging are therefore one operation,
//! which can be repeated any number of times and in any order. SQLite handles crashes, locking and full disks. Two
//! halves of a study give the whole, even if one of them is merged twice:
//!
//! ```
//! # use sagnac_base::progress::Silent;
//! # use sagnac_engine::{run::Plan, study::Study, tally::Share, verify::select};
//! use sagnac_engine::store::{FILE, Source, Store};
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
pub(crate) mod database;
pub mod error;
#[cfg(feature = "store")]
pub mod folder;
#[cfg(feature = "store")]
pub(crate) mod lock;
pub(crate) mod row;
#[cfg(feature = "store")]
pub mod source;
#[cfg(all(test, feature = "store"))]
mod tests;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

#[cfg(feature = "store")]
use crate::store::database::Database;
pub use crate::store::error::StoreError;
#[cfg(feature = "store")]
use crate::store::folder::Folder;
#[cfg(feature = "store")]
use crate::store::lock::Lock;
#[cfg(feature = "store")]
pub use crate::store::lock::{Holder, LOCK};
use crate::store::row::{NO_BLOCK, Raw};
#[cfg(feature = "store")]
pub use crate::store::source::{Merged, Report, Source};
use crate::tally::{Block, Id, Share, fold};
use sagnac_kernel::moments::Moments;
use sagnac_kernel::rows::Rows;
#[cfg(feature = "store")]
use std::sync::Arc;

/// Name of the file of a results folder that has what a gallery shows of it.
pub const CARD: &str = "card.json";

/// The name of the database in a results folder.
pub const FILE: &str = "tallies.sqlite";

/// Version of the tables and of the encoding of tallies.
const SCHEMA_VERSION: i32 = 3;

/// The identity of a study. A folder holds the results of one study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// Kind of the study as written in its file, such as `gap-fill`.
    pub kind: String,
    /// Seed of the study.
    pub seed: u64,
    /// Streams of the study: `independent` or `common`.
    pub streams: String,
    /// Kernels that compute the study, with their versions. They are not part of the study id: rows of other versions
    /// are refused instead of being mistaken for those of another study.
    pub kernels: String,
}

impl Identity {
    /// The study id.
    pub fn id(&self) -> Id {
        Id::from_text(&format!("study\nkind={}\nseed={}\nstreams={}\n", self.kind, self.seed, self.streams))
    }

    /// A digest of the study, its kernels and the encoding of rows.
    fn digest(&self) -> Id {
        Id::from_text(&format!("{}\n{}\n{SCHEMA_VERSION}", self.id(), self.kernels))
    }
}

/// The address of a tally: its point, its estimate and the digest of its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Address {
    /// Identifies everything on which the draws depend.
    pub point: Id,
    /// Identifies what is made of the draws: filler and error, angle, tick or curve.
    pub estimate: Id,
    /// Digest of the parameter words from which the tally was computed.
    pub digest: Id,
}

/// A tally as the store keeps it.
pub trait Tally: Sized {
    /// Compact bytes; equal tallies give equal bytes.
    fn encode(&self) -> Vec<u8>;

    /// Adds the tally of the trials that follow these, of the same estimate.
    fn append(&mut self, next: Self);

    /// Decodes the tally of `trials` trials; `None` where the bytes encode none.
    fn decode(bytes: &[u8], trials: u64) -> Option<Self>;
}

/// One row of the store.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row<T> {
    /// The tally's address.
    pub address: Address,
    /// Its trials.
    pub block: Block,
    /// The exact sums.
    pub tally: T,
}

/// The device that computed rows, with the number of trials and the time. It is not part of any identity.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// Name of the device as `sagnac device list` lists it.
    pub device: String,
    /// Trials over all points since the store was opened.
    pub trials: u64,
    /// Seconds over all points since the store was opened.
    pub seconds: f64,
}

impl Provenance {
    /// The trials of all of them. A folder from someone else may claim any numbers.
    pub fn trials_of(all: &[Provenance]) -> u64 {
        all.iter().fold(0, |sum: u64, by| sum.saturating_add(by.trials))
    }
}

/// The open store of a results folder.
///
/// It guarantees:
///
/// - **One writer.** No other program can open the folder meanwhile; one that tries is refused at once and told which
///   program has it.
/// - **Nothing is lost.** A batch of rows is kept as a whole or not at all, whatever ends the program or fills the
///   disk, and batches kept before stay. (After a power failure the last batches may be missing; they are then
///   resampled.)
/// - **Nothing counts twice.** A trial is in one row or in rows that nest, of which only the outermost counts, so the
///   same rows can be inserted or [merged](Store::merge) any number of times and in any order.
/// - **Nothing wrong is read.** Every row carries a checksum of its whole content and the digest of the parameters from
///   which it was computed. All rows and the structure of the file are checked when the store is opened, and each row
///   again whenever it is read. Damage is reported as an error and never read as a number.
/// - **One study.** A folder holds the results of one study id, computed by one version of its kernels.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    keep: Box<dyn Keep>,
    identity: Identity,
}

/// Storage of the rows.
trait Keep: std::fmt::Debug + Send {
    /// Records that a share of the study is sampled here.
    fn note_share(&mut self, share: Share) -> Result<(), StoreError>;

    /// The shares that were recorded.
    fn shares(&self) -> Result<Vec<Share>, StoreError>;

    /// Inserts rows of the store `from`, all of them or, on an error, none, and replaces the provenance of this session
    /// where it is given. Returns the number of new rows.
    fn insert(&mut self, rows: &[Raw], so_far: Option<&Provenance>, from: &Path) -> Result<u64, StoreError>;

    /// The rows of each of some tallies, without any check.
    fn rows(&self, addresses: &[Address]) -> Result<Vec<Vec<Raw>>, StoreError>;

    /// The trials held of each tally.
    fn keys(&self) -> Result<Vec<(Address, Block)>, StoreError>;

    /// The devices that computed the rows, each once, the one with the most trials first.
    fn provenance(&self) -> Result<Vec<Provenance>, StoreError>;

    /// The database of a store on disk.
    #[cfg(feature = "store")]
    fn database(&self) -> Option<&Database> {
        None
    }
}

/// Tallies whose rows are read at once, while as many others are added up. Rows of many trials have some 2 KiB, and a
/// tally may have fifty rows.
const READ_AT_ONCE: usize = 256;

impl Store {
    /// A store in memory, for a run whose results are used at once.
    pub fn in_memory(identity: &Identity) -> Store {
        let keep = Box::new(Memory::default());
        Store { path: PathBuf::from("memory"), keep, identity: identity.clone() }
    }

    /// Adds the rows of another store of the same study; those that are here already have no effect.
    ///
    /// # Errors
    /// A row disagrees with one that is here, or the disk fails.
    pub fn copy_from(&mut self, other: &Store) -> Result<(), StoreError> {
        self.keep.insert(&other.all()?, None, &other.path).map(|_| ())
    }

    /// All rows, in no order.
    fn all(&self) -> Result<Vec<Raw>, StoreError> {
        let addresses: HashSet<Address> = self.keep.keys()?.into_iter().map(|(address, _)| address).collect();
        Ok(self.keep.rows(&addresses.into_iter().collect::<Vec<_>>())?.concat())
    }

    /// All rows as bytes, which [`add_bytes`](Store::add_bytes) takes in another process, such as another worker of a page in a
    /// browser.
    ///
    /// # Errors
    /// A row is damaged, or the disk fails.
    pub fn to_bytes(&self) -> Result<Vec<u8>, StoreError> {
        let mut bytes = self.identity.digest().0.to_vec();
        self.all()?.iter().for_each(|raw| raw.put(&mut bytes));
        Ok(bytes)
    }

    /// Adds the rows that [`to_bytes`](Store::to_bytes) of a store of the same study gave; those that are here already have no
    /// effect.
    ///
    /// # Errors
    /// The bytes are of another study, kernel or version, or are damaged, a row disagrees with one that is here, or the disk fails.
    pub fn add_bytes(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        let path = PathBuf::from("rows of another process");
        let damaged = |what: &str| StoreError::Damaged { path: path.clone(), what: what.to_owned() };
        let own = self.identity.digest().0;
        let mut rest =
            bytes.strip_prefix(&own).ok_or_else(|| damaged("they are of another study or version"))?;
        let mut rows = Vec::new();
        while !rest.is_empty() {
            let raw = Raw::take(&mut rest).ok_or_else(|| damaged("a row is cut"))?;
            rows.push(raw.sound(&path)?);
        }
        self.keep.insert(&rows, None, &path).map(|_| ())
    }

    /// Opens the store of a results folder, which is created where it is missing.
    ///
    /// # Errors
    /// The folder cannot be written, is in use, holds another study, or is damaged.
    #[cfg(feature = "store")]
    pub fn open(folder: &Path, identity: &Identity) -> Result<Store, StoreError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| StoreError::Folder { path: folder.to_owned(), source })?;
        Store::locked(folder, identity, Arc::new(Lock::take(folder)?))
    }

    /// Opens the store of a results folder that is open for writing.
    ///
    /// # Errors
    /// It fails where [`Store::open`] does.
    #[cfg(feature = "store")]
    pub fn open_in(folder: &Folder, identity: &Identity) -> Result<Store, StoreError> {
        match folder.lock() {
            Some(lock) => Store::locked(folder.path(), identity, lock),
            None => Store::open(folder.path(), identity),
        }
    }

    #[cfg(feature = "store")]
    fn locked(folder: &Path, identity: &Identity, lock: Arc<Lock>) -> Result<Store, StoreError> {
        let path = folder.join(FILE);
        let keep = Box::new(Database::open(folder, path.clone(), identity, lock)?);
        Ok(Store { path, keep, identity: identity.clone() })
    }

    /// Records that a share of the study is sampled here, so that `check` can tell whether the folder is complete.
    ///
    /// # Errors
    /// The disk fails.
    pub fn note_share(&mut self, share: Share) -> Result<(), StoreError> {
        self.keep.note_share(share)
    }

    /// The shares assigned to this folder; the whole study counts as one of them.
    ///
    /// # Errors
    /// The disk fails.
    pub fn shares(&self) -> Result<Vec<Share>, StoreError> {
        self.keep.shares()
    }

    /// Inserts rows, all of them or, on an error, none. The provenance of this session, where given, is written in the
    /// same transaction, so that a run that is killed has left both or neither.
    ///
    /// # Errors
    /// A row exists already with other values, or the disk fails.
    pub fn insert<T: Tally>(
        &mut self,
        rows: &[Row<T>],
        so_far: Option<&Provenance>,
    ) -> Result<(), StoreError> {
        let rows: Vec<Raw> = rows.iter().map(Raw::new).collect();
        self.keep.insert(&rows, so_far, &self.path).map(drop)
    }

    /// The tally over all trials held, merged from its rows.
    ///
    /// # Errors
    /// A row is damaged or was computed from other parameters, or the disk fails.
    pub fn total(&self, address: &Address) -> Result<Moments, StoreError> {
        self.total_within(address, u64::MAX)
    }

    /// The tally over the rows that lie within the first `trials` trials.
    ///
    /// # Errors
    /// It fails where [`Store::total`] does.
    pub fn total_within(&self, address: &Address, trials: u64) -> Result<Moments, StoreError> {
        let held = self.held(std::slice::from_ref(address), trials)?;
        added_up(&held.into_iter().flatten().collect::<Vec<_>>(), &self.path)
    }

    /// Applies `of` to the tallies of several addresses, each given with its index, and returns the results in that
    /// order. While some tallies are read, others are added up.
    ///
    /// # Errors
    /// It fails where [`Store::total`] does.
    pub fn of_totals<T: Send>(
        &self,
        addresses: &[Address],
        of: impl Fn(usize, &Moments) -> T + Sync,
    ) -> Result<Vec<T>, StoreError> {
        let mut all = Vec::with_capacity(addresses.len());
        self.in_parts(addresses.chunks(READ_AT_ONCE), <[Address]>::to_vec, |_, held| {
            let first = all.len();
            all.append(&mut held.totals(|at, tally| of(first + at, tally))?);
            Ok::<(), StoreError>(())
        })?;
        Ok(all)
    }

    /// Reads the tallies of each part, whose addresses `addresses` gives, and passes them on to `make`, part by part. While
    /// it works, the next part is read.
    ///
    /// # Errors
    /// It fails where [`Store::total`] and `make` do.
    pub(crate) fn in_parts<P: Copy + Sync + Send, E: From<StoreError> + Send>(
        &self,
        parts: impl Iterator<Item = P>,
        addresses: impl Fn(P) -> Vec<Address>,
        mut make: impl FnMut(P, Held) -> Result<(), E> + Send,
    ) -> Result<(), E> {
        let path = self.path.as_path();
        let mut read: Option<(P, Vec<Vec<Raw>>)> = None;
        // After the last part nothing is left to read.
        for next in parts.map(Some).chain([None]) {
            let (before, mut made) = (read.take(), Ok(()));
            let (outcome, make) = (&mut made, &mut make);
            let found = rayon::in_place_scope(|scope| {
                if let Some((part, rows)) = before {
                    scope.spawn(move |_| *outcome = make(part, Held { rows, path }));
                }
                next.map(|part| Ok((part, self.held(&addresses(part), u64::MAX)?))).transpose()
            });
            made?;
            read = found?;
        }
        Ok(())
    }

    /// The rows of all trials held, `width` integers each, in order.
    ///
    /// # Errors
    /// It fails where [`Store::total`] does.
    pub fn rows(&self, address: &Address, width: usize) -> Result<Vec<Rows>, StoreError> {
        let rows = |raw: Raw| match raw.tally::<Rows>(&self.path)? {
            rows if rows.width == width => Ok(rows),
            _ => Err(raw.damaged(&self.path, "its rows are of another width")),
        };
        let held = self.held(std::slice::from_ref(address), u64::MAX)?;
        held.into_iter().flatten().map(rows).collect()
    }

    /// The rows of each tally that lie within the first `trials` trials, none of them twice, in order. Each is checked
    /// for damage and for the right parameters.
    fn held(&self, addresses: &[Address], trials: u64) -> Result<Vec<Vec<Raw>>, StoreError> {
        let sound = |(address, rows): (&Address, Vec<Raw>)| -> Result<Vec<Raw>, StoreError> {
            let mut held = Vec::with_capacity(rows.len());
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
        };
        addresses.iter().zip(self.keep.rows(addresses)?).map(sound).collect()
    }

    /// The devices that computed the rows, each once with all its trials and seconds, the one with the most trials
    /// first. Rows merged from other folders count as well; time during which several machines worked at once is added
    /// up.
    ///
    /// # Errors
    /// The database cannot be read.
    pub fn provenance(&self) -> Result<Vec<Provenance>, StoreError> {
        self.keep.provenance()
    }
}

/// The rows of some tallies.
pub(crate) struct Held<'a> {
    /// The rows of each tally, in the order of the addresses.
    rows: Vec<Vec<Raw>>,
    path: &'a Path,
}

impl Held<'_> {
    /// Applies `of` to each tally, given with its index, in parallel.
    ///
    /// # Errors
    /// A row is damaged.
    pub(crate) fn totals<T: Send>(
        &self,
        of: impl Fn(usize, &Moments) -> T + Sync,
    ) -> Result<Vec<T>, StoreError> {
        let one = |(at, rows): (usize, &Vec<Raw>)| Ok(of(at, &added_up(rows, self.path)?));
        self.rows.par_iter().enumerate().map(one).collect()
    }
}

/// The tally of all trials of some rows that have no trials in common.
fn added_up(rows: &[Raw], path: &Path) -> Result<Moments, StoreError> {
    let mut total = Moments::empty(true);
    for raw in rows {
        raw.add_to(&mut total, path)?;
    }
    Ok(total)
}

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
    /// It fails where [`Index::blocks`] does.
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
