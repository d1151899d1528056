//! The database under a store: opening, checking, reading and inserting.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

use rusqlite::{Connection, Params, Row, Transaction, TransactionBehavior, params};

use crate::store::lock::{Lock, own_name};
use crate::store::row::{COLUMNS, Raw};
use crate::store::{Address, Identity, Keep, Provenance, StoreError, schema};
use crate::tally::block::Block;
use crate::tally::id::Id;
use crate::tally::share::Share;

/// The open database of a results folder.
#[derive(Debug)]
pub(crate) struct Database {
    pub(crate) path: PathBuf,
    // Dropped before the lock is released.
    pub(crate) connection: Connection,
    _lock: Option<Lock>,
    /// The key of this session's provenance.
    session: Id,
}

/// Number of sessions that this process has opened.
static SESSIONS: AtomicU64 = AtomicU64::new(0);

/// Prefix of a share among the keys of the study.
const SHARE: &str = "share ";

impl Database {
    pub(crate) fn open(folder: &Path, path: PathBuf, identity: &Identity) -> Result<Database, StoreError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| StoreError::Folder { path: folder.to_owned(), source })?;
        let lock = Lock::take(folder)?;
        let connection = Connection::open(&path).map_err(|source| StoreError::of(&path, source))?;
        let database = Database::of(path, connection, Some(lock));
        database.exclusive()?;
        if !database.is_empty()? {
            database.claimed()?;
            database.structure("quick_check")?;
            database.all_sound()?;
        }
        database.execute_batch("PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL;")?;
        // The tables and their owner are written together; otherwise a run killed here would leave a folder without an
        // owner.
        let transaction = Transaction::new_unchecked(&database.connection, TransactionBehavior::Exclusive);
        let transaction = transaction.map_err(|error| database.failed(error))?;
        database.claim(identity)?;
        transaction.commit().map_err(|error| database.failed(error))?;
        Ok(database)
    }

    pub(crate) fn of(path: PathBuf, connection: Connection, lock: Option<Lock>) -> Database {
        let count = SESSIONS.fetch_add(1, Ordering::Relaxed);
        let session = Id::of(&format!("{}{count}{:?}", own_name(), SystemTime::now()));
        Database { path, connection, _lock: lock, session }
    }

    /// Converts an error of SQLite.
    pub(crate) fn failed(&self, error: rusqlite::Error) -> StoreError {
        StoreError::of(&self.path, error)
    }

    pub(crate) fn execute_batch(&self, sql: &str) -> Result<(), StoreError> {
        self.connection.execute_batch(sql).map_err(|error| self.failed(error))
    }

    pub(crate) fn execute(&self, sql: &str, params: impl Params) -> Result<usize, StoreError> {
        let statement = self.connection.prepare_cached(sql);
        statement.and_then(|mut statement| statement.execute(params)).map_err(|error| self.failed(error))
    }

    /// All rows of a query.
    pub(crate) fn query<T>(
        &self,
        sql: &str,
        params: impl Params,
        of: impl FnMut(&Row) -> Result<T, rusqlite::Error>,
    ) -> Result<Vec<T>, StoreError> {
        let statement = self.connection.prepare_cached(sql);
        let rows = statement.and_then(|mut statement| statement.query_map(params, of)?.collect());
        rows.map_err(|error| self.failed(error))
    }

    /// Takes the database for this connection alone. This comes before any other access, so that its journal needs no
    /// shared memory, which network file systems lack.
    pub(crate) fn exclusive(&self) -> Result<(), StoreError> {
        self.execute_batch("PRAGMA locking_mode = EXCLUSIVE;")
    }

    /// Has SQLite check its pages with `quick_check` or `integrity_check`.
    pub(crate) fn structure(&self, check: &str) -> Result<(), StoreError> {
        let found = self.connection.pragma_query_value(None, check, |row| row.get::<_, String>(0));
        match found.map_err(|error| self.failed(error))?.as_str() {
            "ok" => Ok(()),
            fault => Err(StoreError::Damaged { path: self.path.clone(), what: fault.replace('\n', "; ") }),
        }
    }

    /// Reads every row. Rows are looked up by key, so a row with an altered key would hide those behind it, which SQLite's
    /// quick check does not notice.
    fn all_sound(&self) -> Result<(), StoreError> {
        let failed = |error| self.failed(error);
        let mut statement =
            self.connection.prepare(&format!("SELECT {COLUMNS} FROM tally")).map_err(failed)?;
        let mut rows = statement.query([]).map_err(failed)?;
        let mut before = None;
        while let Some(row) = rows.next().map_err(failed)? {
            let raw = Raw::read(row).map_err(failed)?.sound(&self.path)?;
            let key = Some((raw.address.point, raw.address.estimate, raw.block));
            if key <= before {
                return Err(raw.damaged(&self.path, "it is out of its place"));
            }
            before = key;
        }
        Ok(())
    }

    /// Inserts a row of the database `from` and returns whether it was new.
    ///
    /// # Errors
    /// The row exists with other values, rows of the same estimate were computed from other parameters, or the disk
    /// fails.
    fn put(&self, raw: &Raw, from: &Path) -> Result<bool, StoreError> {
        let Raw { address: Address { point, estimate, digest }, block, sums, checksum } = raw;
        let sql = format!(
            "SELECT {COLUMNS} FROM tally WHERE point = ?1 AND estimate = ?2 AND first = ?3 AND log2 = ?4"
        );
        let key = params![point.0, estimate.0, block.first as i64, block.log2];
        match self.query(&sql, key, Raw::read)?.pop() {
            Some(held) if held == *raw => return Ok(false),
            Some(held) => return Err(held.sound(&self.path)?.disagrees(from)),
            None => {}
        }
        let sql = "SELECT digest FROM tally WHERE point = ?1 AND estimate = ?2 LIMIT 1";
        let held = self.query(sql, params![point.0, estimate.0], |row| row.get::<_, [u8; 16]>(0))?;
        if held.iter().any(|held| *held != digest.0) {
            return Err(raw.disagrees(from));
        }
        let sql = format!("INSERT INTO tally ({COLUMNS}) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
        let row = params![point.0, estimate.0, block.first as i64, block.log2, digest.0, sums, checksum];
        self.execute(&sql, row)?;
        Ok(true)
    }

    /// Writes the provenance of this session, replacing any earlier one.
    fn note(&self, Provenance { device, trials, seconds }: &Provenance) -> Result<(), StoreError> {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |time| time.as_secs());
        let sql = "INSERT OR REPLACE INTO provenance (session, finished, program, device, trials, seconds)
                   VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
        let values = params![self.session.0, now as i64, schema::PROGRAM, device, *trials as i64, seconds];
        self.execute(sql, values).map(drop)
    }

    /// Takes over the provenance of another store. A session that has continued since the last merge is updated.
    ///
    /// # Errors
    /// A session of the other store cannot be read, or the disk fails; sessions taken over before are kept.
    pub(crate) fn take_over_provenance(&self, source: &Database) -> Result<(), StoreError> {
        let theirs = |error| source.failed(error);
        let sql = "SELECT session, finished, program, device, trials, seconds FROM provenance";
        let mut statement = source.connection.prepare(sql).map_err(theirs)?;
        let mut sessions = statement.query([]).map_err(theirs)?;
        while let Some(row) = sessions.next().map_err(theirs)? {
            self.put_session(&Session::read(row).map_err(theirs)?)?;
        }
        Ok(())
    }

    /// Inserts a session, or updates it where it has continued.
    fn put_session(&self, session: &Session) -> Result<(), StoreError> {
        let Session { id, finished, program, device, trials, seconds } = session;
        let sql = "INSERT INTO provenance VALUES (?1, ?2, ?3, ?4, ?5, ?6)
                   ON CONFLICT DO UPDATE SET finished = ?2, device = ?4, trials = ?5, seconds = ?6
                   WHERE trials < ?5";
        self.execute(sql, params![id, finished, program, device, trials, seconds]).map(drop)
    }
}

/// A row of the provenance.
struct Session {
    id: Vec<u8>,
    finished: i64,
    program: String,
    device: String,
    trials: i64,
    seconds: f64,
}

impl Session {
    fn read(row: &Row) -> Result<Session, rusqlite::Error> {
        let (id, finished, program, device, trials, seconds) = row.try_into()?;
        Ok(Session { id, finished, program, device, trials, seconds })
    }
}

impl Keep for Database {
    fn note_share(&mut self, share: Share) -> Result<(), StoreError> {
        let key = format!("{SHARE}{}/{}", share.number(), share.of());
        self.execute("INSERT OR IGNORE INTO study VALUES (?1, '')", [key]).map(drop)
    }

    fn shares(&self) -> Result<Vec<Share>, StoreError> {
        if self.is_empty()? {
            return Ok(vec![]);
        }
        let keys = self.query("SELECT key FROM study", [], |row| row.get::<_, String>(0))?;
        Ok(keys.iter().filter_map(|key| key.strip_prefix(SHARE)?.parse().ok()).collect())
    }

    fn insert(&mut self, rows: &[Raw], so_far: Option<&Provenance>, from: &Path) -> Result<u64, StoreError> {
        let transaction = self.connection.unchecked_transaction().map_err(|error| self.failed(error))?;
        let mut added = 0;
        for raw in rows {
            added += u64::from(self.put(raw, from)?);
        }
        so_far.map_or(Ok(()), |so_far| self.note(so_far))?;
        transaction.commit().map_err(|error| self.failed(error))?;
        Ok(added)
    }

    fn rows(&self, address: &Address) -> Result<Vec<Raw>, StoreError> {
        let sql = format!("SELECT {COLUMNS} FROM tally WHERE point = ?1 AND estimate = ?2");
        self.query(&sql, params![address.point.0, address.estimate.0], Raw::read)
    }

    fn keys(&self) -> Result<Vec<(Address, Block)>, StoreError> {
        let sql = "SELECT point, estimate, first, log2, digest FROM tally";
        self.query(sql, [], Raw::read_key)
    }

    fn provenance(&self) -> Result<Vec<Provenance>, StoreError> {
        let sql =
            "SELECT device, SUM(trials), SUM(seconds) FROM provenance GROUP BY device ORDER BY 2 DESC, 1";
        self.query(sql, [], |row| {
            let trials = row.get::<_, i64>(1)?.max(0) as u64;
            Ok(Provenance { device: row.get(0)?, trials, seconds: row.get(2)? })
        })
    }

    fn database(&self) -> Option<&Database> {
        Some(self)
    }
}
