//! Exclusive use of a results folder, with the name of the program that has it, and the sessions that wrote to it.
//!
//! The lock is one of the operating system on a file beside the database; it ends with the program that holds it,
//! however that ends. SQLite's own lock on the database is a second guard for file systems without such locks.
//!
//! The checksum of a session is kept among the keys of the study, because earlier versions, which write none, must still
//! read the table. Their sessions have no checksum and are believed.

use std::fmt;
use std::fs::{File, TryLockError};
use std::io::{Error, ErrorKind, Read, Seek, Write};
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rusqlite::{Row, params};

use crate::store::database::Database;
use crate::store::folder::single;
use crate::store::{Provenance, StoreError};

/// The name of the file in a results folder.
pub const LOCK: &str = "tallies.lock";

/// An exclusive lock on a folder.
#[derive(Debug)]
pub(crate) struct Lock {
    file: File,
}

impl Drop for Lock {
    /// Unlocks explicitly, because a program that another thread is just starting still has a copy of the file, which
    /// would keep the lock.
    fn drop(&mut self) {
        // If unlocking fails, closing the last copy of the file releases the lock.
        let _ = self.file.unlock();
    }
}

impl Lock {
    /// Takes a folder for as long as the lock lives.
    ///
    /// # Errors
    /// Another program has the folder, or the lock file cannot be opened.
    pub(crate) fn take(folder: &Path) -> Result<Lock, StoreError> {
        Lock::new(folder, single(&folder.join(LOCK)))
    }

    /// Takes a folder by its lock file.
    ///
    /// # Errors
    /// It fails where [`Lock::take`] does.
    pub(crate) fn new(folder: &Path, opened: std::io::Result<File>) -> Result<Lock, StoreError> {
        let failed = |source: std::io::Error| match source.kind() {
            ErrorKind::ReadOnlyFilesystem => StoreError::ReadOnly(folder.to_owned()),
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => StoreError::Full(folder.to_owned()),
            _ => StoreError::Folder { path: folder.to_owned(), source },
        };
        let mut file = opened.map_err(failed)?;
        match file.try_lock() {
            // On a file system without such locks, SQLite's lock is the only one.
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => {
                let holder = text_of(&file).and_then(|text| Holder::parse(&text)).unwrap_or(Holder::Unknown);
                return Err(StoreError::Busy { path: folder.to_owned(), holder });
            }
        }
        if !text_of(&file).is_some_and(|text| is_ours(&text)) {
            return Err(failed(Error::other(format!("{LOCK} is not a lock of sagnac"))));
        }
        // The name serves messages only; if the disk is full, more important writes will report it.
        let _ =
            file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(own_name().as_bytes()));
        Ok(Lock { file })
    }
}

/// Most bytes of a lock that are read.
const MAX_BYTES: u64 = 4096;

/// All of a lock; `None` where that is none.
fn text_of(file: &File) -> Option<String> {
    let mut text = String::new();
    let is_read = file.take(MAX_BYTES + 1).read_to_string(&mut text).is_ok();
    (is_read && text.len() as u64 <= MAX_BYTES).then_some(text)
}

/// Whether a program wrote this as its name, or a power failure left it of one: nothing, zeros, or its beginning.
fn is_ours(text: &str) -> bool {
    let is_number = |line: &str| !line.is_empty() && line.bytes().all(|byte| byte.is_ascii_digit());
    let is_host = |line: &str| !line.contains(char::is_control);
    match text.trim_end_matches('\0').split('\n').collect::<Vec<_>>()[..] {
        [""] => true,
        [process] => is_number(process),
        [process, host] => is_number(process) && is_host(host),
        [process, host, since] => {
            is_number(process) && is_host(host) && (since.is_empty() || is_number(since))
        }
        _ => Holder::parse(text).is_some(),
    }
}

/// The program that has a results folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Holder {
    /// A program that wrote its name.
    Known {
        /// Its process number on that machine.
        process: u32,
        /// Name of the machine.
        host: String,
        /// Time at which it took the folder.
        since: SystemTime,
    },
    /// A program that did not, such as one that inspects the database.
    Unknown,
}

impl Holder {
    fn parse(text: &str) -> Option<Holder> {
        let [process, host, since, ""] = text.split('\n').collect::<Vec<_>>()[..] else { return None };
        let since = UNIX_EPOCH.checked_add(Duration::from_secs(since.parse().ok()?))?;
        Some(Holder::Known { process: process.parse().ok()?, host: host.to_owned(), since })
    }
}

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Holder::Unknown => write!(f, "another program"),
            Holder::Known { process, host, since } => {
                let held = since.elapsed().map_or(0, |time| time.as_secs());
                let (number, unit) = match held {
                    0..120 => (held, "s"),
                    120..7200 => (held / 60, "min"),
                    _ => (held / 3600, "h"),
                };
                write!(f, "process {process} on {host}, for {number} {unit} now")
            }
        }
    }
}

/// The name of this process, as written for the next program.
pub(crate) fn own_name() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
    format!("{}\n{}\n{since}\n", std::process::id(), gethostname::gethostname().to_string_lossy())
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_one_is_told_who_is_first() {
        let folder = tempfile::tempdir().unwrap();
        let first = Lock::take(folder.path()).unwrap();
        let refused = Lock::take(folder.path()).unwrap_err().to_string();
        let host = gethostname::gethostname().to_string_lossy().into_owned();
        assert!(refused.contains(&format!("process {} on {host}, for 0 s", std::process::id())), "{refused}");
        drop(first);
        Lock::take(folder.path()).unwrap();
    }

    #[test]
    fn of_a_lock_without_end_only_the_beginning_is_read() {
        let folder = tempfile::tempdir().unwrap();
        File::create(folder.path().join(LOCK)).unwrap().set_len(1 << 40).unwrap();
        let refused = Lock::take(folder.path()).unwrap_err().to_string();
        assert!(refused.contains("tallies.lock is not a lock of sagnac"), "{refused}");
    }

    #[test]
    fn only_a_whole_lock_or_what_a_power_failure_leaves_of_one_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(LOCK);
        let own = own_name();
        for text in ["", "\0\0\0\0", "12", "12\n", "12\ndesk", "12\ndesk\n17", &own, &own[..own.len() - 1]] {
            std::fs::write(&path, text).unwrap();
            Lock::take(folder.path()).unwrap();
        }
        for text in ["notes", "12 apples\n", "12\ndesk\n17\nand more", "\n\n\n", "12\ndesk\n17\n\n", "a\0"] {
            std::fs::write(&path, text).unwrap();
            assert!(Lock::take(folder.path()).is_err(), "{text:?}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
    }

    #[test]
    fn what_is_no_name_is_nobody() {
        assert_eq!(Holder::parse(""), None);
        assert_eq!(Holder::parse("12\nhost\nyesterday\n"), None);
        assert_eq!(Holder::parse("12\nhost\n18446744073709551615\n"), None);
        assert_eq!(Holder::Unknown.to_string(), "another program");
        let since = SystemTime::now() - Duration::from_secs(7300);
        let held = Holder::Known { process: 7, host: "desk".to_owned(), since };
        assert_eq!(held.to_string(), "process 7 on desk, for 2 h now");
    }
}
