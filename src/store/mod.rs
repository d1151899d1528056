//! The results folder's truth: a SQLite database of tallies.
//!
//! A row is the exact tally of one estimate of one point over one block of trials. Inserting an identical row is
//! nothing, a disagreeing one an error, so resuming, asking for more trials and merging are one operation, in any
//! order, any number of times. Crash safety, locking and full disks are SQLite's work.
//! Two halves of a study, merged twice over, are the whole:
//!
//! ```
//! # use sagnac::{device::select::select, progress::Silent, run::Plan, study::Study, tally::share::Share};
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

pub mod check;
pub mod database;
pub mod encoding;
pub mod error;
pub mod index;
pub mod lock;
pub mod row;
pub mod schema;
pub mod source;
#[cfg(test)]
mod tests;
pub mod whole;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

use rayon::prelude::*;
use rusqlite::{Connection, TransactionBehavior, params};

use crate::kernel::moments::Moments;
use crate::kernel::rows::Rows;
pub use crate::store::check::Report;
use crate::store::database::{SHARE, all_sound, exclusive, note, put, shares, structure};
pub use crate::store::error::StoreError;
pub use crate::store::index::Index;
use crate::store::lock::Lock;
pub use crate::store::lock::{Holder, LOCK};
use crate::store::row::{COLUMNS, Raw};
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
    // Closed before the lock is given up.
    connection: Connection,
    _lock: Option<Lock>,
    identity: Identity,
    /// What its provenance is noted under.
    session: Id,
}

/// Tallies whose rows are read at once, while those of as many are added up; rows of many trials have some 2 KiB, and a tally may have fifty.
const READ_AT_ONCE: usize = 1024;

/// Sessions of this process.
static SESSIONS: AtomicU64 = AtomicU64::new(0);

impl Store {
    /// Opens the store of a results folder, which is made where it is missing.
    ///
    /// # Errors
    /// The folder cannot be written, is in use, holds another study, or is damaged.
    pub fn open(folder: &Path, identity: &Identity) -> Result<Store, StoreError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| StoreError::Folder { path: folder.to_owned(), source })?;
        let lock = Lock::take(folder)?;
        let path = folder.join(FILE);
        let failed = |source| StoreError::of(&path, source);
        let mut connection = Connection::open(&path).map_err(failed)?;
        exclusive(&connection).map_err(failed)?;
        if !crate::store::schema::is_empty(&connection, &path)? {
            crate::store::schema::claimed(&connection, &path)?;
            structure(&connection, &path, "quick_check")?;
            all_sound(&connection, &path)?;
        }
        connection
            .execute_batch("PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL;")
            .map_err(failed)?;
        // The tables and whose they are: all or nothing, or a run killed here would leave a folder that is nobody's.
        let transaction =
            connection.transaction_with_behavior(TransactionBehavior::Exclusive).map_err(failed)?;
        crate::store::schema::claim(&transaction, &path, identity)?;
        transaction.commit().map_err(failed)?;
        Ok(Store::of(path, connection, Some(lock), identity))
    }

    fn of(path: PathBuf, connection: Connection, lock: Option<Lock>, identity: &Identity) -> Store {
        let count = SESSIONS.fetch_add(1, Ordering::Relaxed);
        let session = Id::of(&format!("{}{count}{:?}", crate::store::lock::own_name(), SystemTime::now()));
        Store { path, connection, _lock: lock, identity: identity.clone(), session }
    }

    /// Notes that a share of the study is sampled here, for who looks whether the folder has all that it should.
    ///
    /// # Errors
    /// The disk fails.
    pub fn note_share(&mut self, share: Share) -> Result<(), StoreError> {
        let sql = "INSERT OR IGNORE INTO study VALUES (?1, '')";
        self.connection
            .execute(sql, [format!("{SHARE}{}/{}", share.number(), share.of())])
            .map_err(|e| self.failed(e))?;
        Ok(())
    }

    /// The shares that were to be sampled here, the whole study as one of them.
    ///
    /// # Errors
    /// The disk fails.
    pub fn shares(&self) -> Result<Vec<Share>, StoreError> {
        shares(&self.connection, &self.path)
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
        let failed = |source| StoreError::of(&self.path, source);
        let transaction = self.connection.transaction().map_err(failed)?;
        for row in rows {
            put(&transaction, &self.path, &Raw::of(row), &self.path)?;
        }
        if let Some(so_far) = so_far {
            note(&transaction, &self.session, so_far).map_err(failed)?;
        }
        transaction.commit().map_err(failed)
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
        let failed = |source| StoreError::of(&self.path, source);
        let sql = format!("SELECT {COLUMNS} FROM tally WHERE point = ?1 AND estimate = ?2");
        let mut statement = self.connection.prepare_cached(&sql).map_err(failed)?;
        let mut rows = statement.query(params![address.point.0, address.estimate.0]).map_err(failed)?;
        let mut held = Vec::new();
        while let Some(row) = rows.next().map_err(failed)? {
            let raw = Raw::read(row).map_err(failed)?.sound(&self.path)?;
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
        let failed = |source| StoreError::of(&self.path, source);
        let sql =
            "SELECT device, SUM(trials), SUM(seconds) FROM provenance GROUP BY device ORDER BY 2 DESC, 1";
        let mut statement = self.connection.prepare(sql).map_err(failed)?;
        let rows = statement.query_map([], |row| {
            Ok(Provenance {
                device: row.get(0)?,
                trials: row.get::<_, i64>(1)?.max(0) as u64,
                seconds: row.get(2)?,
            })
        });
        rows.map_err(failed)?.collect::<Result<_, _>>().map_err(failed)
    }

    fn failed(&self, source: rusqlite::Error) -> StoreError {
        StoreError::of(&self.path, source)
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
