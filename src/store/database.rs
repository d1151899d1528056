//! The database under a store: opening, checking, reading and inserting.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

use rusqlite::{Connection, OptionalExtension, Transaction, TransactionBehavior, params};

use crate::store::error::StoreError;
use crate::store::lock::{Lock, own_name};
use crate::store::row::{COLUMNS, Raw};
use crate::store::{Address, Identity, Provenance, schema};
use crate::tally::block::Block;
use crate::tally::id::Id;
use crate::tally::share::Share;

/// The open database of a results folder.
#[derive(Debug)]
pub(crate) struct Database {
    // Dropped before the lock is released.
    pub(crate) connection: Connection,
    _lock: Option<Lock>,
    /// The key of this session's provenance.
    session: Id,
}

/// Number of sessions that this process has opened.
static SESSIONS: AtomicU64 = AtomicU64::new(0);

impl Database {
    pub(crate) fn open(folder: &Path, path: &Path, identity: &Identity) -> Result<Database, StoreError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| StoreError::Folder { path: folder.to_owned(), source })?;
        let lock = Lock::take(folder)?;
        let failed = |source| StoreError::of(path, source);
        let mut connection = Connection::open(path).map_err(failed)?;
        exclusive(&connection).map_err(failed)?;
        if !schema::is_empty(&connection, path)? {
            schema::claimed(&connection, path)?;
            structure(&connection, path, "quick_check")?;
            all_sound(&connection, path)?;
        }
        connection
            .execute_batch("PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL;")
            .map_err(failed)?;
        // The tables and their owner are written together; otherwise a run killed here would leave a folder without an
        // owner.
        let transaction =
            connection.transaction_with_behavior(TransactionBehavior::Exclusive).map_err(failed)?;
        schema::claim(&transaction, path, identity)?;
        transaction.commit().map_err(failed)?;
        Ok(Database::of(connection, Some(lock)))
    }

    pub(crate) fn of(connection: Connection, lock: Option<Lock>) -> Database {
        let count = SESSIONS.fetch_add(1, Ordering::Relaxed);
        let session = Id::of(&format!("{}{count}{:?}", own_name(), SystemTime::now()));
        Database { connection, _lock: lock, session }
    }

    pub(crate) fn note_share(&self, share: Share, path: &Path) -> Result<(), StoreError> {
        let sql = "INSERT OR IGNORE INTO study VALUES (?1, '')";
        let key = format!("{SHARE}{}/{}", share.number(), share.of());
        self.connection.execute(sql, [key]).map(drop).map_err(|error| StoreError::of(path, error))
    }

    pub(crate) fn shares(&self, path: &Path) -> Result<Vec<Share>, StoreError> {
        shares(&self.connection, path)
    }

    /// Inserts rows of the database `from`, all of them or, on an error, none. Returns the number of new rows.
    pub(crate) fn insert(
        &mut self,
        rows: &[Raw],
        so_far: Option<&Provenance>,
        from: &Path,
        path: &Path,
    ) -> Result<u64, StoreError> {
        let failed = |source| StoreError::of(path, source);
        let transaction = self.connection.transaction().map_err(failed)?;
        let mut added = 0;
        for raw in rows {
            added += u64::from(put(&transaction, path, raw, from)?);
        }
        if let Some(so_far) = so_far {
            note(&transaction, &self.session, so_far).map_err(failed)?;
        }
        transaction.commit().map_err(failed)?;
        Ok(added)
    }

    /// The rows of a tally, without any check.
    pub(crate) fn rows(&self, address: &Address, path: &Path) -> Result<Vec<Raw>, StoreError> {
        let failed = |source| StoreError::of(path, source);
        let sql = format!("SELECT {COLUMNS} FROM tally WHERE point = ?1 AND estimate = ?2");
        let mut statement = self.connection.prepare_cached(&sql).map_err(failed)?;
        let key = params![address.point.0, address.estimate.0];
        let rows = statement.query_map(key, Raw::read).map_err(failed)?;
        rows.collect::<Result<_, _>>().map_err(failed)
    }

    /// The trials held of each tally.
    pub(crate) fn keys(&self, path: &Path) -> Result<Vec<(Address, Block)>, StoreError> {
        let failed = |source| StoreError::of(path, source);
        let sql = "SELECT point, estimate, first, log2, digest FROM tally";
        let mut statement = self.connection.prepare(sql).map_err(failed)?;
        let key = |row: &rusqlite::Row| {
            let address =
                Address { point: Id(row.get(0)?), estimate: Id(row.get(1)?), digest: Id(row.get(4)?) };
            Ok((address, Block { first: row.get::<_, i64>(2)? as u64, log2: row.get(3)? }))
        };
        let keys = statement.query_map([], key).map_err(failed)?;
        keys.collect::<Result<_, _>>().map_err(failed)
    }

    pub(crate) fn provenance(&self, path: &Path) -> Result<Vec<Provenance>, StoreError> {
        let failed = |source| StoreError::of(path, source);
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
}

/// Takes a database for this connection alone. This comes before any other access, so that its journal needs no shared
/// memory, which network file systems lack.
pub(crate) fn exclusive(connection: &Connection) -> Result<(), rusqlite::Error> {
    connection.execute_batch("PRAGMA locking_mode = EXCLUSIVE;")
}

/// Has SQLite check its pages with `quick_check` or `integrity_check`.
pub(crate) fn structure(connection: &Connection, path: &Path, check: &str) -> Result<(), StoreError> {
    let found = connection.pragma_query_value(None, check, |row| row.get::<_, String>(0));
    match found.map_err(|error| StoreError::of(path, error))?.as_str() {
        "ok" => Ok(()),
        fault => Err(StoreError::Damaged { path: path.to_owned(), what: fault.replace('\n', "; ") }),
    }
}

/// Reads every row. Rows are looked up by key, so a row with an altered key would hide those behind it, which SQLite's
/// quick check does not notice.
pub(crate) fn all_sound(connection: &Connection, path: &Path) -> Result<(), StoreError> {
    let failed = |source| StoreError::of(path, source);
    let mut statement = connection.prepare(&format!("SELECT {COLUMNS} FROM tally")).map_err(failed)?;
    let mut rows = statement.query([]).map_err(failed)?;
    let mut before = None;
    while let Some(row) = rows.next().map_err(failed)? {
        let raw = Raw::read(row).map_err(failed)?.sound(path)?;
        let key = Some((raw.address.point, raw.address.estimate, raw.block));
        if key <= before {
            return Err(raw.damaged(path, "it is out of its place"));
        }
        before = key;
    }
    Ok(())
}

/// Inserts a row of the database `from` and returns whether it was new.
///
/// # Errors
/// The row exists with other values, rows of the same estimate were computed from other parameters, or the disk fails.
pub(crate) fn put(
    transaction: &Transaction,
    path: &Path,
    raw: &Raw,
    from: &Path,
) -> Result<bool, StoreError> {
    let failed = |source| StoreError::of(path, source);
    let Raw { address, block, sums, checksum } = raw;
    let key = params![address.point.0, address.estimate.0, block.first as i64, block.log2];
    let sql = format!(
        "SELECT {COLUMNS} FROM tally WHERE point = ?1 AND estimate = ?2 AND first = ?3 AND log2 = ?4"
    );
    let held = transaction
        .prepare_cached(&sql)
        .and_then(|mut statement| statement.query_row(key, Raw::read).optional())
        .map_err(failed)?;
    match held {
        Some(held) if held == *raw => return Ok(false),
        Some(held) => return Err(held.sound(path)?.disagrees(from)),
        None => {}
    }
    let sql = "SELECT digest FROM tally WHERE point = ?1 AND estimate = ?2 LIMIT 1";
    let digest = transaction
        .prepare_cached(sql)
        .and_then(|mut statement| {
            let key = params![address.point.0, address.estimate.0];
            statement.query_row(key, |row| row.get::<_, [u8; 16]>(0)).optional()
        })
        .map_err(failed)?;
    if digest.is_some_and(|digest| digest != address.digest.0) {
        return Err(raw.disagrees(from));
    }
    let row = params![
        address.point.0,
        address.estimate.0,
        block.first as i64,
        block.log2,
        address.digest.0,
        sums,
        checksum
    ];
    let sql = format!("INSERT INTO tally ({COLUMNS}) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
    transaction.prepare_cached(&sql).and_then(|mut statement| statement.execute(row)).map_err(failed)?;
    Ok(true)
}

/// Writes the provenance of a session, replacing any earlier one.
pub(crate) fn note(
    connection: &Connection,
    session: &Id,
    so_far: &Provenance,
) -> Result<(), rusqlite::Error> {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |time| time.as_secs());
    let sql = "INSERT OR REPLACE INTO provenance (session, finished, program, device, trials, seconds)
               VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
    let Provenance { device, trials, seconds } = so_far;
    let values = params![session.0, now as i64, schema::PROGRAM, device, *trials as i64, seconds];
    connection.execute(sql, values).map(drop)
}

/// Prefix of a share among the keys of the study.
pub(crate) const SHARE: &str = "share ";

/// The shares assigned to this folder.
pub(crate) fn shares(connection: &Connection, path: &Path) -> Result<Vec<Share>, StoreError> {
    let failed = |source| StoreError::of(path, source);
    let mut statement = connection.prepare("SELECT key FROM study").map_err(failed)?;
    let keys = statement.query_map([], |row| row.get::<_, String>(0)).map_err(failed)?;
    let keys: Vec<String> = keys.collect::<Result<_, _>>().map_err(failed)?;
    Ok(keys.iter().filter_map(|key| key.strip_prefix(SHARE)?.parse().ok()).collect())
}
