//! The results folder's truth: a SQLite database of tallies.
//!
//! A row is the exact tally of one estimate of one point over one block of trials. Inserting an identical row is
//! nothing, a disagreeing one an error, so resuming, asking for more trials and merging are one operation, in any
//! order, any number of times. Crash safety, locking and full disks are SQLite's work.

mod encoding;

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use rusqlite::{Connection, ErrorCode, OptionalExtension, TransactionBehavior, params};

use crate::block::{Block, fold};
use crate::id::Id;
use crate::kernel::moments::Moments;
use crate::kernel::rows::Rows;

/// The name of the database in a results folder.
pub const FILE: &str = "tallies.sqlite";

/// Version of the tables and of the encoding of tallies.
const SCHEMA_VERSION: i64 = 2;

/// What went wrong with the results on disk.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error("cannot create the results folder {path}: {source}\nchoose another one with --out DIR")]
    Folder { path: PathBuf, source: std::io::Error },
    #[error(
        "{path} is in use by another program\nwait for it to end, or choose another folder with --out DIR"
    )]
    Busy { path: PathBuf },
    #[error("cannot keep results in {path}: {source}")]
    Storage { path: PathBuf, source: rusqlite::Error },
    #[error(
        "{path} is of schema version {found}, this program writes version {SCHEMA_VERSION}\nuse the program that wrote it, or choose another folder with --out DIR"
    )]
    Version { path: PathBuf, found: String },
    #[error(
        "{path} holds results of another study (seed {seed}, streams {streams}, kind {kind})\nchoose another folder with --out DIR, or remove this one"
    )]
    OtherStudy { path: PathBuf, kind: String, seed: String, streams: String },
    #[error(
        "{path}: the row of point {point}, estimate {estimate}, trials from {first} is damaged ({what})\nremove the folder and run again, or restore it from a copy"
    )]
    Damaged { path: PathBuf, point: Id, estimate: Id, first: u64, what: &'static str },
    #[error(
        "{path}: trials from {first} of point {point}, estimate {estimate} are there already with other values\nthe folder was written by a program or machine that computes differently: run `sagnac verify`"
    )]
    Disagrees { path: PathBuf, point: Id, estimate: Id, first: u64 },
}

/// What makes two runs the same study: a folder holds one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    pub kind: String,
    pub seed: u64,
    pub streams: String,
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
    pub point: Id,
    pub estimate: Id,
    pub digest: Id,
}

/// A tally as the store keeps it.
pub trait Tally: Sized {
    /// Compact bytes, the same for the same tally.
    fn encode(&self) -> Vec<u8>;

    /// The tally of so many trials that the bytes stand for; `None` where they stand for none.
    fn decode(bytes: &[u8], trials: u64) -> Option<Self>;
}

/// One row of the store.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row<T> {
    pub address: Address,
    pub block: Block,
    pub tally: T,
}

/// Who computes rows, how many trials and how long it took; no part of any identity.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    pub device: String,
    /// Over all points, since the store was opened.
    pub trials: u64,
    pub seconds: f64,
}

/// An open results database; no other program can open it meanwhile.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    connection: Connection,
    /// The row that tells the provenance of what is inserted, once there is any.
    session: Option<i64>,
}

impl Store {
    /// Opens the store of a results folder, which is made where it is missing.
    ///
    /// # Errors
    /// The folder cannot be written, is in use, or holds another study.
    pub fn open(folder: &Path, identity: &Identity) -> Result<Store, StoreError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| StoreError::Folder { path: folder.to_owned(), source })?;
        let path = folder.join(FILE);
        let failed = |source| storage_error(&path, source);
        let mut connection = Connection::open(&path).map_err(failed)?;
        connection
            .execute_batch(
                "PRAGMA locking_mode = EXCLUSIVE;
                 PRAGMA journal_mode = WAL;
                 PRAGMA synchronous = NORMAL;",
            )
            .map_err(failed)?;
        // The tables and whose they are: all or nothing, or a run killed here would leave a folder that is nobody's.
        let transaction =
            connection.transaction_with_behavior(TransactionBehavior::Exclusive).map_err(failed)?;
        transaction
            .execute_batch(
                "CREATE TABLE IF NOT EXISTS study (key TEXT PRIMARY KEY, value TEXT NOT NULL);
                 CREATE TABLE IF NOT EXISTS tally (
                     point BLOB NOT NULL, estimate BLOB NOT NULL, first INTEGER NOT NULL, log2 INTEGER NOT NULL,
                     digest BLOB NOT NULL, sums BLOB NOT NULL, checksum INTEGER NOT NULL,
                     PRIMARY KEY (point, estimate, first, log2)) WITHOUT ROWID;
                 CREATE TABLE IF NOT EXISTS provenance (
                     finished INTEGER NOT NULL, program TEXT NOT NULL, device TEXT NOT NULL,
                     trials INTEGER NOT NULL, seconds REAL NOT NULL);",
            )
            .map_err(failed)?;
        claim(&transaction, &path, identity)?;
        transaction.commit().map_err(failed)?;
        Ok(Store { path, connection, session: None })
    }

    /// Adds rows, all of them or, on an error, none; and notes in the same step what this session has done so far, so
    /// that a run which is killed has left both or neither.
    ///
    /// # Errors
    /// A row is there already with other values, or the disk fails.
    pub fn insert<T: Tally>(&mut self, rows: &[Row<T>], so_far: &Provenance) -> Result<(), StoreError> {
        let path = self.path.clone();
        let failed = |source| storage_error(&path, source);
        let transaction = self.connection.transaction().map_err(failed)?;
        {
            let mut present = transaction
                .prepare_cached(
                    "SELECT digest, sums FROM tally
                     WHERE point = ?1 AND estimate = ?2 AND first = ?3 AND log2 = ?4",
                )
                .map_err(failed)?;
            let mut insert = transaction
                .prepare_cached("INSERT INTO tally VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)")
                .map_err(failed)?;
            for Row { address, block, tally } in rows {
                let sums = tally.encode();
                let key = params![address.point.0, address.estimate.0, block.first as i64, block.log2];
                let held: Option<([u8; 16], Vec<u8>)> = present
                    .query_row(key, |row| Ok((row.get(0)?, row.get(1)?)))
                    .optional()
                    .map_err(failed)?;
                match held {
                    None => {
                        let checksum = checksum(address, *block, &sums);
                        insert
                            .execute(params![
                                address.point.0,
                                address.estimate.0,
                                block.first as i64,
                                block.log2,
                                address.digest.0,
                                sums,
                                checksum
                            ])
                            .map_err(failed)?;
                    }
                    Some(held) if held == (address.digest.0, sums) => {}
                    Some(_) => {
                        let (point, estimate, first) = (address.point, address.estimate, block.first);
                        return Err(StoreError::Disagrees { path, point, estimate, first });
                    }
                }
            }
        }
        let session = note(&transaction, self.session, so_far).map_err(failed)?;
        transaction.commit().map_err(failed)?;
        self.session = Some(session);
        Ok(())
    }

    /// The blocks held of a tally, as they were written.
    ///
    /// # Errors
    /// A row was computed from other parameters, or the disk fails.
    pub fn blocks(&self, address: &Address) -> Result<Vec<Block>, StoreError> {
        let mut statement = self
            .connection
            .prepare_cached("SELECT first, log2, digest FROM tally WHERE point = ?1 AND estimate = ?2")
            .map_err(|e| self.failed(e))?;
        let rows = statement
            .query_map(params![address.point.0, address.estimate.0], |row| {
                let block = Block { first: row.get::<_, i64>(0)? as u64, log2: row.get(1)? };
                Ok((block, row.get::<_, [u8; 16]>(2)?))
            })
            .map_err(|e| self.failed(e))?;
        rows.map(|row| {
            let (block, digest) = row.map_err(|e| self.failed(e))?;
            if digest == address.digest.0 { Ok(block) } else { Err(self.disagrees(address, block)) }
        })
        .collect()
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
        let mut total = Moments::empty(true);
        for (_, tally) in self.held::<Moments>(address, trials)? {
            total.merge(&tally);
        }
        Ok(total)
    }

    /// The rows of all trials held, `width` integers each, in their order.
    ///
    /// # Errors
    /// Those of [`Store::total`].
    pub fn rows(&self, address: &Address, width: usize) -> Result<Vec<Rows>, StoreError> {
        let held = self.held::<Rows>(address, u64::MAX)?;
        match held.iter().find(|(_, rows)| rows.width != width) {
            Some((block, _)) => Err(self.damaged(address, *block, "its rows are of another width")),
            None => Ok(held.into_iter().map(|(_, rows)| rows).collect()),
        }
    }

    /// The tallies that lie within the first `trials` trials, none of them twice.
    fn held<T: Tally>(&self, address: &Address, trials: u64) -> Result<Vec<(Block, T)>, StoreError> {
        let mut statement = self
            .connection
            .prepare_cached(
                "SELECT first, log2, digest, sums, checksum FROM tally WHERE point = ?1 AND estimate = ?2",
            )
            .map_err(|e| self.failed(e))?;
        let rows = statement
            .query_map(params![address.point.0, address.estimate.0], |row| {
                let block = Block { first: row.get::<_, i64>(0)? as u64, log2: row.get(1)? };
                Ok((block, row.get::<_, [u8; 16]>(2)?, row.get::<_, Vec<u8>>(3)?, row.get::<_, u32>(4)?))
            })
            .map_err(|e| self.failed(e))?;
        let mut held = Vec::new();
        for row in rows {
            let (block, digest, sums, sum) = row.map_err(|e| self.failed(e))?;
            if digest != address.digest.0 {
                return Err(self.disagrees(address, block));
            }
            if sum != checksum(address, block, &sums) {
                return Err(self.damaged(address, block, "its checksum is wrong"));
            }
            let tally = T::decode(&sums, block.trials()).ok_or(self.damaged(
                address,
                block,
                "it is no tally of its block",
            ))?;
            if block.end() <= trials {
                held.push((block, tally));
            }
        }
        Ok(fold(held))
    }

    /// Points that the store holds.
    ///
    /// # Errors
    /// The disk fails.
    pub fn points(&self) -> Result<Vec<Id>, StoreError> {
        let mut statement =
            self.connection.prepare("SELECT DISTINCT point FROM tally").map_err(|e| self.failed(e))?;
        let points = statement.query_map([], |row| row.get(0).map(Id)).map_err(|e| self.failed(e))?;
        points.map(|point| point.map_err(|e| self.failed(e))).collect()
    }

    fn failed(&self, source: rusqlite::Error) -> StoreError {
        storage_error(&self.path, source)
    }

    fn damaged(&self, address: &Address, block: Block, what: &'static str) -> StoreError {
        let (point, estimate) = (address.point, address.estimate);
        StoreError::Damaged { path: self.path.clone(), point, estimate, first: block.first, what }
    }

    fn disagrees(&self, address: &Address, block: Block) -> StoreError {
        let (point, estimate) = (address.point, address.estimate);
        StoreError::Disagrees { path: self.path.clone(), point, estimate, first: block.first }
    }
}

/// Writes down whose results these are, or checks it.
fn claim(connection: &Connection, path: &Path, identity: &Identity) -> Result<(), StoreError> {
    let failed = |source| storage_error(path, source);
    let about = |key: &str| -> Result<Option<String>, StoreError> {
        let sql = "SELECT value FROM study WHERE key = ?1";
        connection.query_row(sql, [key], |row| row.get(0)).optional().map_err(failed)
    };
    let (version, id) = (SCHEMA_VERSION.to_string(), identity.id().to_string());
    match (about("schema")?, about("id")?) {
        (Some(found), _) if found != version => Err(StoreError::Version { path: path.to_owned(), found }),
        (Some(_), Some(found)) if found == id => Ok(()),
        (Some(_), Some(_)) => {
            let about = |key| about(key).map(Option::unwrap_or_default);
            let (kind, seed, streams) = (about("kind")?, about("seed")?, about("streams")?);
            Err(StoreError::OtherStudy { path: path.to_owned(), kind, seed, streams })
        }
        // Without an id it was never claimed, and nothing was ever inserted.
        _ => {
            let claims = [
                ("schema", version),
                ("id", id),
                ("kind", identity.kind.clone()),
                ("seed", identity.seed.to_string()),
                ("streams", identity.streams.clone()),
            ];
            claims.iter().try_for_each(|(key, value)| {
                let sql = "INSERT OR REPLACE INTO study VALUES (?1, ?2)";
                connection.execute(sql, params![key, value]).map(drop).map_err(failed)
            })
        }
    }
}

/// Writes the provenance of a session, in place of what is there of it, and returns its row.
fn note(connection: &Connection, session: Option<i64>, so_far: &Provenance) -> Result<i64, rusqlite::Error> {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |time| time.as_secs());
    let program = concat!("sagnac ", env!("CARGO_PKG_VERSION"));
    // Without a row number SQLite takes the next one.
    let sql = "INSERT OR REPLACE INTO provenance (rowid, finished, program, device, trials, seconds)
               VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
    let Provenance { device, trials, seconds } = so_far;
    connection.execute(sql, params![session, now as i64, program, device, *trials as i64, seconds])?;
    Ok(connection.last_insert_rowid())
}

fn storage_error(path: &Path, source: rusqlite::Error) -> StoreError {
    let path = path.to_owned();
    match source.sqlite_error_code() {
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => StoreError::Busy { path },
        _ => StoreError::Storage { path, source },
    }
}

/// Over the whole row, so that a row moved to another place is found out too.
fn checksum(address: &Address, block: Block, sums: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for part in [&address.point.0[..], &address.estimate.0, &address.digest.0, &block.first.to_le_bytes()] {
        hasher.update(part);
    }
    hasher.update(&block.log2.to_le_bytes());
    hasher.update(sums);
    hasher.finalize()
}

#[cfg(test)]
mod tests;
