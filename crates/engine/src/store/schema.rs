//! The tables of a database, and the study to which they belong.

use std::collections::BTreeMap;
use std::path::Path;

use crate::store::database::Database;
use crate::store::{Identity, SCHEMA_VERSION, StoreError};

/// Application id in SQLite's header, "SGNC".
const APPLICATION: i32 = 0x5347_4e43;

/// Name and version of this program.
pub(crate) const PROGRAM: &str = concat!("sagnac ", env!("CARGO_PKG_VERSION"));

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
