//! Errors of the results on disk.

use std::io;
#[cfg(feature = "store")]
use std::path::Path;
use std::path::PathBuf;

#[cfg(feature = "store")]
use rusqlite::ErrorCode;

#[cfg(feature = "store")]
use crate::store::lock::Holder;
use crate::store::{FILE, SCHEMA_VERSION};
use crate::tally::Id;

/// An error of the results on disk, with what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The folder cannot be created or opened.
    #[error(
        "cannot use the results folder {path}: {source}\nmake it writable or choose another one with `out = DIR`"
    )]
    Folder {
        /// Path of the folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The folder holds no results.
    #[error("{0} has no results: its {FILE} is missing or empty\ngive the folder of a study that was run")]
    NoResults(PathBuf),
    /// Another program is writing to the folder.
    #[cfg(feature = "store")]
    #[error(
        "{path} is in use by {holder}\nwait for it to end; a run can go to another folder with `out = DIR`"
    )]
    Busy {
        /// Path of the folder.
        path: PathBuf,
        /// The program, where it is known.
        holder: Holder,
    },
    /// The disk is full.
    #[error("no space is left for {0}\ncompleted work is kept: make room and run again to resume")]
    Full(PathBuf),
    /// The disk or file is read-only.
    #[error(
        "{0} cannot be written: it or its disk is read-only\nmake it writable, or choose another folder with `out = DIR`"
    )]
    ReadOnly(PathBuf),
    /// A journal must be replayed first, but the folder is read-only.
    #[error(
        "{0} cannot be read here: an interrupted run left a journal, {FILE}-wal, that must be replayed, and the folder is \
         read-only\ncopy the folder to where it can be written"
    )]
    Unfinished(PathBuf),
    /// The database is no longer in its place.
    #[error(
        "{0} was removed or replaced while it was in use\nwhat was stored there is lost with it: run again, or bring the folder back and run again to resume"
    )]
    Gone(PathBuf),
    /// SQLite or the disk failed in another way.
    #[cfg(feature = "store")]
    #[error("cannot keep results in {path}: {source}\ncompleted work is kept: run again when the disk works")]
    Storage {
        /// Path of the database.
        path: PathBuf,
        /// Error of SQLite.
        source: rusqlite::Error,
    },
    /// The file is not a results database, or its header is damaged.
    #[error(
        "{path} is not a results database ({what})\nit belongs to another program, or its beginning is damaged: restore it from a copy, or choose another folder with `out = DIR`"
    )]
    Foreign {
        /// Path of the file.
        path: PathBuf,
        /// The evidence.
        what: String,
    },
    /// The database was written by a later or earlier version with another layout.
    #[error(
        "{path} has schema version {found}; this program writes version {SCHEMA_VERSION}\nuse the program that wrote it, or choose another folder with `out = DIR` and run again"
    )]
    Schema {
        /// Path of the database.
        path: PathBuf,
        /// Its schema version.
        found: String,
    },
    /// The results were computed by kernels that give other numbers.
    #[error(
        "{path} was computed by {program} with the kernels {found}; those of this program, {ours}, give other numbers\n\
         use the program that wrote it, or choose another folder with `out = DIR` and run again"
    )]
    Kernels {
        /// Path of the database.
        path: PathBuf,
        /// Program that wrote it.
        program: String,
        /// Its kernels with their versions.
        found: String,
        /// The kernels of this program with their versions.
        ours: String,
    },
    /// The folder belongs to another study.
    #[error(
        "{path} holds results of another study (seed {seed}, streams {streams}, kind {kind})\nchoose another folder with `out = DIR`, or remove this one"
    )]
    OtherStudy {
        /// Path of the database.
        path: PathBuf,
        /// Kind of the study that it holds.
        kind: String,
        /// Seed of that study.
        seed: String,
        /// Streams of that study.
        streams: String,
    },
    /// The checksum or the content of a row is wrong.
    #[error(
        "{path}: the row of point {point}, estimate {estimate}, trials from {first} is damaged ({what})\n{SALVAGE}"
    )]
    DamagedRow {
        /// Path of the database.
        path: PathBuf,
        /// Point of the row.
        point: Id,
        /// Estimate of the row.
        estimate: Id,
        /// Number of its first trial.
        first: u64,
        /// The damage.
        what: &'static str,
    },
    /// The database is damaged elsewhere than in a row.
    #[error("{path} is damaged ({what})\n{SALVAGE}")]
    Damaged {
        /// Path of the database.
        path: PathBuf,
        /// The damage.
        what: String,
    },
    /// Two computations of the same trials disagree.
    #[error(
        "{path}: trials from {first} of point {point}, estimate {estimate} differ from those stored already\none of the programs or machines computes wrongly: run `sagnac device verify` on each"
    )]
    Disagrees {
        /// Path of the database.
        path: PathBuf,
        /// Point of the row.
        point: Id,
        /// Estimate of the row.
        estimate: Id,
        /// Number of its first trial.
        first: u64,
    },
}

/// Advice on damage.
const SALVAGE: &str = "merge this folder with `salvage = true` into a new one, which leaves out the damage, and run the study there, or \
                       restore the folder from a copy";

impl StoreError {
    /// Converts an error of SQLite.
    #[cfg(feature = "store")]
    pub(crate) fn new(path: &Path, source: rusqlite::Error) -> StoreError {
        let path = path.to_owned();
        let what = source.to_string();
        match (&source, source.sqlite_error_code()) {
            (_, Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked)) => {
                StoreError::Busy { path, holder: Holder::Unknown }
            }
            (rusqlite::Error::SqliteFailure(error, _), _)
                if error.extended_code == rusqlite::ffi::SQLITE_IOERR_SHORT_READ =>
            {
                StoreError::Damaged { path, what: "it ends too early".to_owned() }
            }
            (_, Some(ErrorCode::DiskFull)) => StoreError::Full(path),
            (_, Some(ErrorCode::ReadOnly)) => StoreError::ReadOnly(path),
            (_, Some(ErrorCode::TooBig)) => {
                StoreError::Damaged { path, what: "it holds a row that is longer than any".to_owned() }
            }
            (_, Some(ErrorCode::NotADatabase)) => StoreError::Foreign { path, what },
            // Wrong column types, invalid text or a missing table, none of which this program writes.
            (_, Some(ErrorCode::DatabaseCorrupt | ErrorCode::Unknown))
            | (
                rusqlite::Error::FromSqlConversionFailure(..)
                | rusqlite::Error::IntegralValueOutOfRange(..)
                | rusqlite::Error::Utf8Error(..)
                | rusqlite::Error::InvalidColumnType(..),
                _,
            ) => StoreError::Damaged { path, what },
            _ => StoreError::Storage { path, source },
        }
    }

    /// Whether the contents differ from what was written.
    pub fn is_damage(&self) -> bool {
        matches!(
            self,
            StoreError::Damaged { .. } | StoreError::DamagedRow { .. } | StoreError::Disagrees { .. }
        )
    }
}
