//! Provenance: what each session of a program added to a database, with a checksum.
//!
//! The checksum of a session is kept among the keys of the study, because earlier versions, which write none, must still
//! read the table. Their sessions have no checksum and are believed.

use std::path::Path;

use rusqlite::{Row, params};

use crate::store::database::Database;
use crate::store::{Provenance, StoreError};

/// Prefix of the checksum of a session among the keys of the study.
const CHECKSUM: &str = "session ";

/// A row of the provenance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Session {
    pub(crate) id: Vec<u8>,
    pub(crate) finished: i64,
    pub(crate) program: String,
    pub(crate) device: String,
    pub(crate) trials: i64,
    pub(crate) seconds: f64,
}

impl Session {
    fn read(row: &Row) -> Result<Session, rusqlite::Error> {
        let (id, finished, program, device, trials, seconds) = row.try_into()?;
        Ok(Session { id, finished, program, device, trials, seconds })
    }

    fn checksum(&self) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        for text in [&self.id[..], self.program.as_bytes(), self.device.as_bytes()] {
            hasher.update(&text.len().to_le_bytes());
            hasher.update(text);
        }
        hasher.update(&self.finished.to_le_bytes());
        hasher.update(&self.trials.to_le_bytes());
        hasher.update(&self.seconds.to_bits().to_le_bytes());
        hasher.finalize()
    }

    /// Its key among those of the study.
    fn key(&self) -> String {
        let id: String = self.id.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("{CHECKSUM}{id}")
    }

    /// The session if it is as written; `checksum` is that among the keys of the study.
    ///
    /// # Errors
    /// It is damaged, or holds numbers that no session has.
    fn sound(self, checksum: Option<&str>, path: &Path) -> Result<Session, StoreError> {
        let is_written = checksum.is_none_or(|checksum| checksum == self.checksum().to_string());
        let has_sense = self.trials >= 0 && self.seconds.is_finite() && self.seconds >= 0.0;
        match is_written && has_sense {
            true => Ok(self),
            false => Err(damaged(path, "a session of its provenance is altered")),
        }
    }
}

fn damaged(path: &Path, what: &str) -> StoreError {
    StoreError::Damaged { path: path.to_owned(), what: what.to_owned() }
}

impl Database {
    /// All sessions, each checked, and an error for those that are missing.
    ///
    /// # Errors
    /// The table cannot be read.
    pub(crate) fn each_session(&self) -> Result<Vec<Result<Session, StoreError>>, StoreError> {
        let sql = "SELECT session, finished, program, device, trials, seconds FROM provenance";
        let sessions = self.query(sql, [], |row| Ok(Session::read(row)))?;
        let mut checksums = self.keys_with(CHECKSUM)?;
        let mut checked = Vec::with_capacity(sessions.len());
        for session in sessions {
            checked.push(session.map_err(|error| self.failed(error)).and_then(|session| {
                let checksum = checksums.remove(&session.key());
                session.sound(checksum.as_deref(), &self.path)
            }));
        }
        if !checksums.is_empty() {
            checked.push(Err(damaged(&self.path, "a session of its provenance is missing")));
        }
        Ok(checked)
    }

    /// All sessions.
    ///
    /// # Errors
    /// One of them is damaged or cannot be read.
    pub(crate) fn sessions(&self) -> Result<Vec<Session>, StoreError> {
        self.each_session()?.into_iter().collect()
    }

    /// Inserts a session, or updates it where it has continued.
    pub(crate) fn put_session(&self, session: &Session) -> Result<(), StoreError> {
        let Session { id, finished, program, device, trials, seconds } = session;
        let sql = "INSERT INTO provenance VALUES (?1, ?2, ?3, ?4, ?5, ?6)
                   ON CONFLICT DO UPDATE SET finished = ?2, program = ?3, device = ?4, trials = ?5, seconds = ?6
                   WHERE trials <= ?5";
        if self.execute(sql, params![id, finished, program, device, trials, seconds])? == 0 {
            return Ok(());
        }
        let sql = "INSERT OR REPLACE INTO study VALUES (?1, ?2)";
        self.execute(sql, [session.key(), session.checksum().to_string()]).map(drop)
    }

    /// The sums of the sessions on each device, those with most trials first.
    pub(crate) fn by_device(&self) -> Result<Vec<Provenance>, StoreError> {
        let mut found: Vec<Provenance> = Vec::new();
        for Session { device, trials, seconds, .. } in self.sessions()? {
            let trials = trials.unsigned_abs();
            match found.iter_mut().find(|other| other.device == device) {
                Some(other) => {
                    other.trials = other.trials.saturating_add(trials);
                    other.seconds += seconds;
                }
                None => found.push(Provenance { device, trials, seconds }),
            }
        }
        found.sort_by(|a, b| b.trials.cmp(&a.trials).then_with(|| a.device.cmp(&b.device)));
        Ok(found)
    }
}
