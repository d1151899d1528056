//! The store of another results folder, to be merged or checked; and the check of the rows of a store.

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

use rusqlite::{Connection, OpenFlags};

use crate::store::database::{self, Database};
use crate::store::folder::{Folder, parent, readable, real, single_database, takes_files};
use crate::store::lock::Lock;
use crate::store::row::{COLUMNS, Raw};
use crate::store::{FILE, Identity, Keep as _, Store, StoreError, Tally};
use crate::tally::Share;
use sagnac_kernel::moments::Moments;
use sagnac_kernel::rows::Rows;

/// A store opened only for reading. No other program can open it meanwhile, unless its folder is read-only.
#[derive(Debug)]
pub struct Source {
    pub(crate) database: Database,
}

/// What a merge did with the rows of the other store.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Merged {
    /// New rows.
    pub added: u64,
    /// Rows that existed already with the same values.
    pub held: u64,
    /// Rows or pages left out because they are damaged.
    pub damaged: u64,
}

/// Most rows, and most bytes of rows, in a transaction.
const BATCH: (usize, usize) = (4096, 32 << 20);

/// A connection stays with one thread.
const ALONE: OpenFlags = OpenFlags::SQLITE_OPEN_NO_MUTEX;

impl Source {
    /// Opens the store of a results folder. A journal left by a run that was killed is replayed first, as the run
    /// itself would have done; nothing else in the folder changes.
    ///
    /// # Errors
    /// The store is missing, in use, or cannot be read.
    pub fn open(folder: &Path) -> Result<Source, StoreError> {
        let lock = || match Lock::take(folder) {
            Ok(lock) => Ok(Some(Arc::new(lock))),
            Err(StoreError::ReadOnly(_)) => Ok(None),
            // The folder belongs to another user, or its files are those of a copy too.
            Err(StoreError::Folder { source, .. })
                if matches!(source.kind(), ErrorKind::PermissionDenied | ErrorKind::TooManyLinks) =>
            {
                Ok(None)
            }
            Err(error) => Err(error),
        };
        Source::locked(folder, lock)
    }

    /// Opens the store of a results folder that is open for writing.
    ///
    /// # Errors
    /// It fails where [`Source::open`] does.
    pub fn open_in(folder: &Folder) -> Result<Source, StoreError> {
        Source::locked(folder.path(), || Ok(folder.lock()))
    }

    fn locked(
        folder: &Path,
        lock: impl FnOnce() -> Result<Option<Arc<Lock>>, StoreError>,
    ) -> Result<Source, StoreError> {
        let path = folder.join(FILE);
        let lock = match single_database(&path).and_then(|()| readable(&path)) {
            Ok(_) => lock()?,
            // It can be read, but not written in place.
            Err(source) if source.kind() == ErrorKind::TooManyLinks => None,
            Err(source) if source.kind() == ErrorKind::NotFound => {
                return Err(StoreError::NoResults(folder.to_owned()));
            }
            Err(source) => return Err(StoreError::Folder { path, source }),
        };
        let journal = folder.join(format!("{FILE}-wal"));
        // Without a journal, and where none can be made, the database is all there is to be read.
        let is_replayed = lock.is_some() && (journal.exists() || takes_files(parent(&path)));
        let connection = if is_replayed {
            let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NOFOLLOW;
            Connection::open_with_flags(real(&path), flags | ALONE)
        } else {
            if journal.metadata().is_ok_and(|journal| journal.len() > 0) {
                return Err(StoreError::Unfinished(path));
            }
            let uri = format!("file:{}?immutable=1", escaped(&path));
            let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | ALONE;
            Connection::open_with_flags(uri, flags)
        };
        let connection = connection.map_err(|source| StoreError::new(&path, source))?;
        let database = Database::new(path, connection, lock);
        if is_replayed {
            database.exclusive()?;
        }
        Ok(Source { database })
    }

    /// Opens it as the store of this study. Where the folder is read-only nothing can be added to it.
    ///
    /// # Errors
    /// It belongs to another study, program or version, or is damaged.
    pub fn into_store(self, identity: &Identity) -> Result<Store, StoreError> {
        self.is_of(identity)?;
        if !self.database.is_empty()? {
            self.database.sound()?;
        }
        let path = self.database.path.clone();
        Ok(Store { path, keep: Box::new(self.database), identity: identity.clone() })
    }

    /// The identity of these results; `None` where the folder never held any.
    ///
    /// # Errors
    /// They belong to another program or version, or are damaged.
    pub fn identity(&self) -> Result<Option<Identity>, StoreError> {
        Ok(self.claim()?.map(|claim| claim.identity))
    }

    /// Checks that these are results of `identity`, or that there are none.
    ///
    /// # Errors
    /// They belong to another study, program or version, or are damaged.
    pub fn is_of(&self, identity: &Identity) -> Result<(), StoreError> {
        match self.claim()? {
            Some(theirs) => database::is_same(&theirs, identity, &self.database.path),
            None => Ok(()),
        }
    }

    /// The shares assigned to that folder; the whole study counts as one of them.
    ///
    /// # Errors
    /// The disk fails, or the store is damaged.
    pub fn shares(&self) -> Result<Vec<Share>, StoreError> {
        self.database.shares()
    }

    fn claim(&self) -> Result<Option<database::Claim>, StoreError> {
        (!self.database.is_empty()?).then(|| self.database.claimed()).transpose()
    }

    /// Passes on all rows, intact or not, from the first one forwards or from the last one backwards. The last item may
    /// be the error at which reading ended.
    pub(crate) fn each(
        &self,
        backwards: bool,
        mut hear: impl FnMut(Result<Raw, StoreError>) -> Result<(), StoreError>,
    ) -> Result<(), StoreError> {
        let Database { path, connection, .. } = &self.database;
        let failed = |source| StoreError::new(path, source);
        let order = if backwards { "DESC" } else { "ASC" };
        let keys = ["point", "estimate", "first", "log2"].map(|key| format!("{key} {order}")).join(", ");
        let sql = format!("SELECT {COLUMNS} FROM tally ORDER BY {keys}");
        let mut statement = match connection.prepare(&sql) {
            Ok(statement) => statement,
            Err(error) => return hear(Err(failed(error))),
        };
        let mut rows = statement.query([]).map_err(failed)?;
        loop {
            match rows.next() {
                Ok(None) => return Ok(()),
                Ok(Some(row)) => hear(Raw::read(row).map_err(failed).and_then(|raw| raw.sound(path)))?,
                Err(error) => return hear(Err(failed(error))),
            }
        }
    }
}

/// A path with the characters escaped that have a meaning in a URI.
fn escaped(path: &Path) -> String {
    path.to_string_lossy().replace('%', "%25").replace('?', "%3f").replace('#', "%23")
}

impl Store {
    /// Takes over all rows of another store of the same study. Existing rows count once, so any stores can be merged in
    /// any order and any number of times. With `salvage`, damaged rows are left out and counted; otherwise they are an
    /// error.
    ///
    /// # Errors
    /// The other store belongs to another study or kernel, a row disagrees or is damaged, or the disk fails; rows taken
    /// over before are kept.
    pub fn merge(&mut self, source: &Source, salvage: bool) -> Result<Merged, StoreError> {
        if salvage {
            // Reads what can be read even of a file that is shorter than its header says.
            source.database.execute_batch("PRAGMA writable_schema = ON")?;
        }
        match source.is_of(&self.identity) {
            // The rows identify themselves.
            Err(error) if salvage && error.is_damage() => {}
            found => found?,
        }
        // Nothing is taken over before all is known to be sound.
        if !salvage && !source.database.is_empty()? {
            source.database.sound()?;
        }
        let sessions = match source.database.each_session() {
            Err(error) if salvage && error.is_damage() => vec![],
            sessions => sessions?,
        };
        let mut merged = Merged::default();
        let mut seen = salvage.then(BTreeSet::new);
        let mut batch: Vec<Raw> = Vec::new();
        let mut bytes = 0;
        let mut unreadable = false;
        for backwards in [false, true] {
            source.each(backwards, |row| {
                match (row, &mut seen) {
                    (Ok(raw), seen) => {
                        let key = (raw.address.point, raw.address.estimate, raw.block);
                        if seen.as_mut().is_none_or(|seen| seen.insert(key)) {
                            bytes += raw.sums.len();
                            batch.push(raw);
                        }
                    }
                    (Err(error), Some(_)) if error.is_damage() => {
                        merged.damaged += u64::from(!backwards);
                        unreadable |= !matches!(error, StoreError::DamagedRow { .. });
                    }
                    (Err(error), _) => return Err(error),
                }
                if batch.len() >= BATCH.0 || bytes >= BATCH.1 {
                    bytes = 0;
                    self.take_over(&std::mem::take(&mut batch), source, &mut merged)?;
                }
                Ok(())
            })?;
            // Rows behind a damaged page, where reading ended, can be read from the other end.
            if !unreadable {
                break;
            }
        }
        self.take_over(&batch, source, &mut merged)?;
        // A store in memory records only its own provenance.
        let Some(own) = self.keep.database() else { return Ok(merged) };
        for session in sessions {
            match session {
                Err(error) if salvage && error.is_damage() => {}
                session => own.put_session(&session?)?,
            }
        }
        Ok(merged)
    }

    fn take_over(&mut self, batch: &[Raw], source: &Source, merged: &mut Merged) -> Result<(), StoreError> {
        let added = self.keep.insert(batch, None, &source.database.path)?;
        merged.added += added;
        merged.held += batch.len() as u64 - added;
        Ok(())
    }
}

/// What a check of a store found.
#[derive(Debug, Default)]
pub struct Report {
    /// Rows that are intact.
    pub sound: u64,
    /// Points to which those rows belong.
    pub points: u64,
    /// Damage found.
    pub faults: Vec<StoreError>,
}

impl Source {
    /// Reads everything: the database's own structure, and the checksum and the tally of every row. A row that covers
    /// the trials of others must be their sum.
    ///
    /// # Errors
    /// The store belongs to another program or version, or the disk fails. Damage is not an error here but a fault in
    /// the report.
    pub fn check(&self) -> Result<Report, StoreError> {
        let path = &self.database.path;
        let mut report = Report::default();
        match self.identity() {
            Ok(None) => {
                let folder = path.parent().unwrap_or(Path::new("")).to_owned();
                return Err(StoreError::NoResults(folder));
            }
            Err(error) if error.is_damage() => report.faults.push(error),
            found => drop(found?),
        }
        report.faults.extend(self.database.structure("integrity_check").err());
        let mut group: Vec<Raw> = Vec::new();
        let mut point = None;
        self.each(false, |row| {
            match row {
                Ok(raw) => {
                    report.sound += 1;
                    report.points += u64::from(point.replace(raw.address.point) != Some(raw.address.point));
                    if group.first().is_some_and(|first| !same_tally(first, &raw)) {
                        report.faults.extend(overlaps(&std::mem::take(&mut group), path).err());
                    }
                    group.push(raw);
                }
                Err(error) if error.is_damage() => report.faults.push(error),
                Err(error) => return Err(error),
            }
            Ok(())
        })?;
        report.faults.extend(overlaps(&group, path).err());
        tell_once(&mut report.faults);
        Ok(report)
    }
}

/// Keeps only the most detailed of the faults that concern the whole file, because every reading of such a file repeats
/// them.
fn tell_once(faults: &mut Vec<StoreError>) {
    let told = |fault: &StoreError| match fault {
        StoreError::Damaged { what, .. } => what.len(),
        _ => 0,
    };
    let most = faults.iter().map(told).max().unwrap_or(0);
    let mut first = true;
    faults.retain(|fault| match fault {
        StoreError::Damaged { .. } => told(fault) == most && std::mem::take(&mut first),
        _ => true,
    });
}

fn same_tally(a: &Raw, b: &Raw) -> bool {
    (a.address.point, a.address.estimate) == (b.address.point, b.address.estimate)
}

/// Checks the tallies of an estimate, and that a row that covers others is their sum.
fn overlaps(group: &[Raw], path: &Path) -> Result<(), StoreError> {
    let Some(first) = group.first() else { return Ok(()) };
    // The bytes do not tell the form of the tally, so one form has to fit all rows.
    if first.tally::<Moments>(path).is_ok() {
        agree::<Moments>(group, path)
    } else {
        agree::<Rows>(group, path)
    }
}

fn agree<T: Tally>(group: &[Raw], path: &Path) -> Result<(), StoreError> {
    let mut rows: Vec<&Raw> = group.iter().collect();
    rows.sort_by_key(|raw| (raw.block.first, core::cmp::Reverse(raw.block.log2)));
    for (at, outer) in rows.iter().enumerate() {
        if outer.address.digest != rows[0].address.digest {
            return Err(outer.disagrees(path));
        }
        outer.tally::<T>(path)?;
        let within = rows[at + 1..].iter().take_while(|inner| inner.block.end() <= outer.block.end());
        let parts = crate::tally::fold(within.map(|inner| (inner.block, *inner)).collect());
        let covered: u64 = parts.iter().map(|(block, _)| block.trials()).sum();
        if covered < outer.block.trials() {
            continue;
        }
        let tallies = parts.iter().map(|(_, part)| part.tally::<T>(path)).collect::<Result<Vec<T>, _>>()?;
        let sum = tallies.into_iter().reduce(|mut sum, part| {
            sum.append(part);
            sum
        });
        if sum.is_some_and(|sum| sum.encode() != outer.sums) {
            return Err(outer.disagrees(path));
        }
    }
    Ok(())
}
