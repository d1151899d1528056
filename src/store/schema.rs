//! The tables of a database, and whose results are in them.

use std::collections::BTreeMap;
use std::path::Path;

use rusqlite::{Connection, params};

use crate::store::error::StoreError;
use crate::store::{Identity, SCHEMA_VERSION};

/// What SQLite's header says of a database of ours: "SGNC".
const APPLICATION: i32 = 0x5347_4e43;

/// The program that writes rows now.
pub(crate) const PROGRAM: &str = concat!("sagnac ", env!("CARGO_PKG_VERSION"));

/// Makes the tables of an empty database and claims it for a study, or checks that they are of this study.
///
/// # Errors
/// They are of another study, program or version, or damaged.
pub(crate) fn claim(connection: &Connection, path: &Path, identity: &Identity) -> Result<(), StoreError> {
    if is_empty(connection, path)? {
        return create(connection, identity).map_err(|error| StoreError::of(path, error));
    }
    let found = claimed(connection, path)?;
    is_same(&found, identity, path)
}

/// Checks that results may be added to those of `identity`.
///
/// # Errors
/// They are of another study, or of kernels that give other numbers.
pub(crate) fn is_same(found: &Claim, identity: &Identity, path: &Path) -> Result<(), StoreError> {
    let Claim { identity: theirs, program } = found;
    let path = path.to_owned();
    if theirs.id() != identity.id() {
        let Identity { kind, seed, streams, .. } = theirs.clone();
        return Err(StoreError::OtherStudy { path, kind, seed: seed.to_string(), streams });
    }
    if theirs.kernels != identity.kernels {
        let (found, ours) = (theirs.kernels.clone(), identity.kernels.clone());
        return Err(StoreError::Kernels { path, program: program.clone(), found, ours });
    }
    Ok(())
}

/// Whose a database is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Claim {
    pub(crate) identity: Identity,
    /// Which claimed it.
    pub(crate) program: String,
}

/// Whose a database is that is not empty.
///
/// # Errors
/// It is of another program or version, or damaged.
pub(crate) fn claimed(connection: &Connection, path: &Path) -> Result<Claim, StoreError> {
    let failed = |error| StoreError::of(path, error);
    let header = |name: &str| connection.pragma_query_value(None, name, |row| row.get::<_, i32>(0));
    let application = header("application_id").map_err(failed)?;
    if application != APPLICATION {
        return Err(foreign(connection, path));
    }
    let version = header("user_version").map_err(failed)?;
    if version != SCHEMA_VERSION {
        return Err(StoreError::Schema { path: path.to_owned(), found: version.to_string() });
    }
    let mut statement = connection.prepare("SELECT key, value FROM study").map_err(failed)?;
    let pairs = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?))).map_err(failed)?;
    let mut about: BTreeMap<String, String> = pairs.collect::<Result<_, _>>().map_err(failed)?;
    let mut take = |key: &str| about.remove(key);
    let claim = take("seed").and_then(|seed| seed.parse().ok()).and_then(|seed| {
        let identity =
            Identity { kind: take("kind")?, seed, streams: take("streams")?, kernels: take("kernels")? };
        (take("id")? == identity.id().to_string()).then_some(Claim { identity, program: take("program")? })
    });
    claim.ok_or_else(|| {
        let what = "what it says of its study makes no sense".to_owned();
        StoreError::Damaged { path: path.to_owned(), what }
    })
}

/// Whether nobody has claimed a database: a program that is killed while it does leaves it so.
pub(crate) fn is_empty(connection: &Connection, path: &Path) -> Result<bool, StoreError> {
    let count = connection.query_row("SELECT COUNT(*) FROM sqlite_schema", [], |row| row.get::<_, i64>(0));
    count.map(|tables| tables == 0).map_err(|error| StoreError::of(path, error))
}

/// What a database is that is not marked as ours: one of our first versions, which had no mark, or of another program.
fn foreign(connection: &Connection, path: &Path) -> StoreError {
    let path = path.to_owned();
    let version = connection
        .query_row("SELECT value FROM study WHERE key = 'schema'", [], |row| row.get::<_, String>(0));
    match version {
        Ok(found) => StoreError::Schema { path, found },
        Err(_) => StoreError::Foreign { path, what: "it is one of another program".to_owned() },
    }
}

fn create(connection: &Connection, identity: &Identity) -> Result<(), rusqlite::Error> {
    connection.execute_batch(&format!(
        "PRAGMA application_id = {APPLICATION};
         PRAGMA user_version = {SCHEMA_VERSION};
         CREATE TABLE study (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
         CREATE TABLE tally (
             point BLOB NOT NULL, estimate BLOB NOT NULL, first INTEGER NOT NULL, log2 INTEGER NOT NULL,
             digest BLOB NOT NULL, sums BLOB NOT NULL, checksum INTEGER NOT NULL,
             PRIMARY KEY (point, estimate, first, log2)) WITHOUT ROWID;
         CREATE TABLE provenance (
             session BLOB PRIMARY KEY, finished INTEGER NOT NULL, program TEXT NOT NULL, device TEXT NOT NULL,
             trials INTEGER NOT NULL, seconds REAL NOT NULL) WITHOUT ROWID;"
    ))?;
    let Identity { kind, seed, streams, kernels } = identity;
    let claims = [
        ("id", &identity.id().to_string()),
        ("kind", kind),
        ("seed", &seed.to_string()),
        ("streams", streams),
        ("kernels", kernels),
        ("program", &PROGRAM.to_owned()),
    ];
    claims.iter().try_for_each(|(key, value)| {
        connection.execute("INSERT INTO study VALUES (?1, ?2)", params![key, value]).map(drop)
    })
}
