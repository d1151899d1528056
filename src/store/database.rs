//! The database under a store: taking it, looking it over, adding to it.

use std::path::Path;
use std::time::SystemTime;

use rusqlite::{Connection, OptionalExtension, Transaction, params};

use crate::store::error::StoreError;
use crate::store::row::{COLUMNS, Raw};
use crate::store::{Provenance, schema};
use crate::tally::id::Id;
use crate::tally::share::Share;

/// Takes a database for this connection alone. Before anything else is asked of it, so that its journal needs no memory that
/// programs share, which network file systems do not have.
pub(crate) fn exclusive(connection: &Connection) -> Result<(), rusqlite::Error> {
    connection.execute_batch("PRAGMA locking_mode = EXCLUSIVE;")
}

/// Lets SQLite look over its pages: `quick_check` or `integrity_check`.
pub(crate) fn structure(connection: &Connection, path: &Path, check: &str) -> Result<(), StoreError> {
    let found = connection.pragma_query_value(None, check, |row| row.get::<_, String>(0));
    match found.map_err(|error| StoreError::of(path, error))?.as_str() {
        "ok" => Ok(()),
        fault => Err(StoreError::Damaged { path: path.to_owned(), what: fault.replace('\n', "; ") }),
    }
}

/// Reads every row. A row is looked for by its key, so one with an altered key would hide those behind it; SQLite's quick check
/// does not see that.
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

/// Adds a row of the database `from` where it is not there yet; whether it was not.
///
/// # Errors
/// It is there with other values, rows of the same estimate were computed from other parameters, or the disk fails.
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

/// Writes the provenance of a session, in place of what is there of it.
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

/// What stands before a share among the keys of the study.
pub(crate) const SHARE: &str = "share ";

/// The shares that were to be sampled here.
pub(crate) fn shares(connection: &Connection, path: &Path) -> Result<Vec<Share>, StoreError> {
    let failed = |source| StoreError::of(path, source);
    let mut statement = connection.prepare("SELECT key FROM study").map_err(failed)?;
    let keys = statement.query_map([], |row| row.get::<_, String>(0)).map_err(failed)?;
    let keys: Vec<String> = keys.collect::<Result<_, _>>().map_err(failed)?;
    Ok(keys.iter().filter_map(|key| key.strip_prefix(SHARE)?.parse().ok()).collect())
}
