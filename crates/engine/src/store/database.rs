//! The database under a store: its schema, opening, checking, reading and inserting.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

use rusqlite::limits::Limit;
use rusqlite::{Connection, OpenFlags, Params, Row, Transaction, TransactionBehavior, params};

use crate::store::folder::{file_of, real, single_database};
use crate::store::lock::{Lock, Session, own_name};
use crate::store::row::{COLUMNS, Raw};
use crate::store::{Address, Identity, Keep, Provenance, SCHEMA_VERSION, StoreError};
use crate::tally::{Block, Id, Share};

/// The open database of a results folder.
#[derive(Debug)]
pub(crate) struct Database {
    pub(crate) path: PathBuf,
    // Dropped before the lock is released.
    pub(crate) connection: Connection,
    /// Which file was opened, where the system tells.
    file: Option<[u64; 2]>,
    _lock: Option<Arc<Lock>>,
    /// The key of this session's provenance.
    session: Id,
}

/// Number of sessions that this process has opened.
static SESSIONS: AtomicU64 = AtomicU64::new(0);

/// Most bytes of a row, or of a text, that SQLite reads into memory. Rows have kilobytes, those of a million records some
/// tens of megabytes; a database of a stranger may claim gigabytes of zeros.
const MAX_BYTES: i32 = 256 << 20;

/// Most KiB of pages that stay in memory.
const MAX_CACHED_KIB: u32 = 64 << 10;

/// Prefix of a share among the keys of the study.
const SHARE: &str = "share ";

impl Database {
    pub(crate) fn open(
        folder: &Path,
        path: PathBuf,
        identity: &Identity,
        lock: Arc<Lock>,
    ) -> Result<Database, StoreError> {
        single_database(&path).map_err(|source| StoreError::Folder { path: folder.to_owned(), source })?;
        let flags = OpenFlags::default() | OpenFlags::SQLITE_OPEN_NOFOLLOW;
        let connection = Connection::open_with_flags(real(&path), flags)
            .map_err(|source| StoreError::new(&path, source))?;
        let database = Database::new(path, connection, Some(lock));
        database.exclusive()?;
        if !database.is_empty()? {
            database.sound()?;
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

    pub(crate) fn new(path: PathBuf, connection: Connection, lock: Option<Arc<Lock>>) -> Database {
        // It fails only for a negative limit.
        let _ = connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, MAX_BYTES);
        let count = SESSIONS.fetch_add(1, Ordering::Relaxed);
        let session = Id::from_text(&format!("{}{count}{:?}", own_name(), SystemTime::now()));
        Database { file: file_of(&path), path, connection, _lock: lock, session }
    }

    /// Converts an error of SQLite.
    pub(crate) fn failed(&self, error: rusqlite::Error) -> StoreError {
        StoreError::new(&self.path, error)
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

    /// Checks everything that is read later: the owner, the tables, the pages, every row and the provenance. Every opening of
    /// a store of a study begins with it, to sample, to show and to merge.
    ///
    /// # Errors
    /// The database belongs to another program or version, or is damaged.
    pub(crate) fn sound(&self) -> Result<(), StoreError> {
        self.claimed()?;
        // Pages are read by both checks, for the index and for the tables, and stay in memory as far as they fit.
        self.execute_batch(&format!("PRAGMA cache_size = -{MAX_CACHED_KIB};"))?;
        self.structure("quick_check")?;
        self.all_sound()?;
        self.sessions().map(drop)
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
        match self.execute(&sql, row)? {
            1 => Ok(true),
            _ => Err(StoreError::Damaged {
                path: self.path.clone(),
                what: "it does not keep a row".to_owned(),
            }),
        }
    }

    /// Writes the provenance of this session, replacing any earlier one.
    fn note(&self, Provenance { device, trials, seconds }: &Provenance) -> Result<(), StoreError> {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |time| time.as_secs());
        self.put_session(&Session {
            id: self.session.0.to_vec(),
            finished: now as i64,
            program: PROGRAM.to_owned(),
            device: device.clone(),
            trials: i64::try_from(*trials).unwrap_or(i64::MAX),
            seconds: *seconds,
        })
    }

    /// The keys of the study with this prefix, with their values.
    pub(crate) fn keys_with(&self, prefix: &str) -> Result<BTreeMap<String, String>, StoreError> {
        let pairs: Vec<(String, String)> =
            self.query("SELECT key, value FROM study", [], |row| row.try_into())?;
        Ok(pairs.into_iter().filter(|(key, _)| key.starts_with(prefix)).collect())
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
        let keys = self.keys_with(SHARE)?;
        Ok(keys.keys().filter_map(|key| key.strip_prefix(SHARE)?.parse().ok()).collect())
    }

    fn insert(&mut self, rows: &[Raw], so_far: Option<&Provenance>, from: &Path) -> Result<u64, StoreError> {
        let transaction = self.connection.unchecked_transaction().map_err(|error| self.failed(error))?;
        let mut added = 0;
        for raw in rows {
            added += u64::from(self.put(raw, from)?);
        }
        so_far.map_or(Ok(()), |so_far| self.note(so_far))?;
        transaction.commit().map_err(|error| self.failed(error))?;
        // SQLite goes on writing to a file that has been removed.
        if self.file.is_some() && file_of(&self.path) != self.file {
            return Err(StoreError::Gone(self.path.clone()));
        }
        Ok(added)
    }

    fn rows(&self, addresses: &[Address]) -> Result<Vec<Vec<Raw>>, StoreError> {
        let failed = |error| self.failed(error);
        let sql = format!("SELECT {COLUMNS} FROM tally WHERE point = ?1 AND estimate BETWEEN ?2 AND ?3");
        // Without it, SQLite would begin and end a transaction for each query.
        let _reading = self.connection.unchecked_transaction().map_err(failed)?;
        // The statement is looked up once, as a study may have hundreds of thousands of tallies.
        let mut statement = self.connection.prepare_cached(&sql).map_err(failed)?;
        let mut all = vec![Vec::new(); addresses.len()];
        let mut rest = &mut all[..];
        // The rows of a point are next to each other, and looking up a place costs more than reading on.
        for group in addresses.chunk_by(|one, next| one.point == next.point) {
            let of_group;
            (of_group, rest) = rest.split_at_mut(group.len());
            let estimates = || group.iter().map(|address| address.estimate.0);
            let ends = params![group[0].point.0, estimates().min(), estimates().max()];
            for raw in statement.query_map(ends, Raw::read).map_err(failed)? {
                let raw = raw.map_err(failed)?;
                let is_of = |place: &usize| group[*place].estimate == raw.address.estimate;
                let mut places = (0..group.len()).filter(is_of);
                // Between two estimates there may be one that is not asked for, and one may be asked for twice.
                let Some(first) = places.next() else { continue };
                places.for_each(|place| of_group[place].push(raw.clone()));
                of_group[first].push(raw);
            }
        }
        Ok(all)
    }

    fn keys(&self) -> Result<Vec<(Address, Block)>, StoreError> {
        let sql = "SELECT point, estimate, first, log2, digest FROM tally";
        self.query(sql, [], Raw::read_key)
    }

    fn provenance(&self) -> Result<Vec<Provenance>, StoreError> {
        self.by_device()
    }

    fn database(&self) -> Option<&Database> {
        Some(self)
    }
}

/// Application id in SQLite's header, "SGNC".
const APPLICATION: i32 = 0x5347_4e43;

/// Name and version of this program.
const PROGRAM: &str = concat!("sagnac ", env!("CARGO_PKG_VERSION"));

/// Checks that results may be added to those of `identity`.
///
/// # Errors
/// They belong to another study, or to kernels that give other numbers.
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

/// The owner of a database.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Claim {
    pub(crate) identity: Identity,
    /// The program that claimed it.
    pub(crate) program: String,
}

/// The tables of a database, as SQLite keeps their text.
const TABLES: [&str; 3] = [
    "CREATE TABLE study (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID",
    "CREATE TABLE tally (
         point BLOB NOT NULL, estimate BLOB NOT NULL, first INTEGER NOT NULL, log2 INTEGER NOT NULL,
         digest BLOB NOT NULL, sums BLOB NOT NULL, checksum INTEGER NOT NULL,
         PRIMARY KEY (point, estimate, first, log2)) WITHOUT ROWID",
    "CREATE TABLE provenance (
         session BLOB PRIMARY KEY, finished INTEGER NOT NULL, program TEXT NOT NULL, device TEXT NOT NULL,
         trials INTEGER NOT NULL, seconds REAL NOT NULL) WITHOUT ROWID",
];

impl Database {
    /// Creates the tables of an empty database and claims it for a study, or checks that they belong to this study.
    ///
    /// # Errors
    /// They belong to another study, program or version, or are damaged.
    pub(crate) fn claim(&self, identity: &Identity) -> Result<(), StoreError> {
        if self.is_empty()? {
            return self.create(identity);
        }
        is_same(&self.claimed()?, identity, &self.path)
    }

    /// The owner of a database that is not empty.
    ///
    /// # Errors
    /// The database belongs to another program or version, or is damaged.
    pub(crate) fn claimed(&self) -> Result<Claim, StoreError> {
        let header = |name: &str| {
            let found = self.connection.pragma_query_value(None, name, |row| row.get::<_, i32>(0));
            found.map_err(|error| self.failed(error))
        };
        if header("application_id")? != APPLICATION {
            return Err(self.foreign());
        }
        let version = header("user_version")?;
        if version != SCHEMA_VERSION {
            return Err(StoreError::Schema { path: self.path.clone(), found: version.to_string() });
        }
        self.only_ours()?;
        let pairs = self.query("SELECT key, value FROM study", [], |row| row.try_into())?;
        let mut about: BTreeMap<String, String> = pairs.into_iter().collect();
        let mut take = |key: &str| about.remove(key);
        let claim = take("seed").and_then(|seed| seed.parse().ok()).and_then(|seed| {
            let identity =
                Identity { kind: take("kind")?, seed, streams: take("streams")?, kernels: take("kernels")? };
            (take("id")? == identity.id().to_string())
                .then_some(Claim { identity, program: take("program")? })
        });
        claim.ok_or_else(|| {
            let what = "its identification of the study is inconsistent".to_owned();
            StoreError::Damaged { path: self.path.clone(), what }
        })
    }

    /// Checks that the database holds our tables and nothing else: a trigger could drop what is written, and a view in the
    /// place of a table could give anything, or never end.
    fn only_ours(&self) -> Result<(), StoreError> {
        let sql = "SELECT type, name, sql FROM sqlite_schema";
        let held: Vec<(String, String, Option<String>)> = self.query(sql, [], |row| row.try_into())?;
        // Versions break lines in different places.
        let words = |sql: &str| sql.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        let is_ours = |sql: &str| TABLES.iter().any(|table| words(table) == words(sql));
        let path = self.path.clone();
        let others = || held.iter().filter(|(_, _, sql)| !sql.as_deref().is_some_and(is_ours));
        // First what computes when it is read: of an altered table, salvage reads what is left.
        let computes = |(kind, _, sql): &&(String, String, Option<String>)| {
            kind != "table"
                || sql.as_deref().is_none_or(|sql| {
                    words(sql).get(1).is_some_and(|word| word.eq_ignore_ascii_case("virtual"))
                })
        };
        if let Some((kind, name, _)) = others().find(computes) {
            let what = format!("it holds the {} `{}`", kind.escape_debug(), name.escape_debug());
            return Err(StoreError::Foreign { path, what });
        }
        if let Some((kind, name, _)) = others().next() {
            let what = format!("{} `{}`", kind.escape_debug(), name.escape_debug());
            return Err(StoreError::Damaged { path, what: format!("its {what} is not as it was written") });
        }
        match held.len() == TABLES.len() {
            true => Ok(()),
            false => Err(StoreError::Damaged { path, what: "a table is missing".to_owned() }),
        }
    }

    /// Whether a database has no owner yet, as after a program was killed while claiming it.
    pub(crate) fn is_empty(&self) -> Result<bool, StoreError> {
        let counts = self.query("SELECT COUNT(*) FROM sqlite_schema", [], |row| row.get::<_, i64>(0))?;
        Ok(counts == [0])
    }

    /// The error for a database without our application id: it is from our first versions, which had none, or from
    /// another program.
    fn foreign(&self) -> StoreError {
        let path = self.path.clone();
        // Views are not read: one of a stranger may never end.
        let sql = "SELECT COUNT(*) FROM sqlite_schema WHERE type = 'view'";
        let has_views = self.query(sql, [], |row| row.get::<_, i64>(0)).map_or(true, |views| views != [0]);
        let sql = "SELECT value FROM study WHERE key = 'schema'";
        let found = || self.connection.query_row(sql, [], |row| row.get::<_, String>(0)).ok();
        match (!has_views).then(found).flatten() {
            Some(found) => StoreError::Schema { path, found },
            None => StoreError::Foreign { path, what: "it was written by another program".to_owned() },
        }
    }

    fn create(&self, identity: &Identity) -> Result<(), StoreError> {
        self.execute_batch(&format!(
            "PRAGMA application_id = {APPLICATION};
             PRAGMA user_version = {SCHEMA_VERSION};
             {};",
            TABLES.join(";")
        ))?;
        let Identity { kind, seed, streams, kernels } = identity;
        let claims = [
            ("id", &*identity.id().to_string()),
            ("kind", kind),
            ("seed", &seed.to_string()),
            ("streams", streams),
            ("kernels", kernels),
            ("program", PROGRAM),
        ];
        let sql = "INSERT INTO study VALUES (?1, ?2)";
        claims.into_iter().try_for_each(|claim| self.execute(sql, claim).map(drop))
    }
}
