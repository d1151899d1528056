//! What can be wrong with the results on disk.

use std::io;
#[cfg(feature = "store")]
use std::path::Path;
use std::path::PathBuf;

#[cfg(feature = "store")]
use rusqlite::ErrorCode;

use crate::store::SCHEMA_VERSION;
#[cfg(feature = "store")]
use crate::store::lock::Holder;
use crate::tally::id::Id;

/// What went wrong with the results on disk, and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The folder cannot be made or opened.
    #[error(
        "cannot use the results folder {path}: {source}\nmake it writable or choose another one with `out = DIR`"
    )]
    Folder {
        /// Of the folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// No study was run into the folder.
    #[error(
        "{folder} has no results: its {} is missing or empty\ngive the folder of a study that was run",
        crate::store::FILE
    )]
    NoResults {
        /// Its path.
        folder: PathBuf,
    },
    /// Another program writes to it.
    #[cfg(feature = "store")]
    #[error(
        "{path} is in use by {holder}\nwait for it to end; a run can go to another folder with `out = DIR`"
    )]
    Busy {
        /// Of the folder.
        path: PathBuf,
        /// Which program, where it says so.
        holder: Holder,
    },
    /// A full disk.
    #[error(
        "no space is left for {path}\nwhat was complete is kept: make room and run again, and it goes on from there"
    )]
    Full {
        /// Of the file that could not grow.
        path: PathBuf,
    },
    /// A read-only disk or file.
    #[error(
        "{path} cannot be written: it or its disk is read-only\nmake it writable, or choose another folder with `out = DIR`"
    )]
    ReadOnly {
        /// Of the file.
        path: PathBuf,
    },
    /// A journal that must be taken over first, in a folder that is read-only.
    #[error(
        "{path} cannot be read here: what a run that was cut short left in {}-wal has to be taken over, and the folder is \
         read-only\ncopy the folder to where it can be written",
        crate::store::FILE
    )]
    Unfinished {
        /// Of the database.
        path: PathBuf,
    },
    /// Anything else that SQLite or the disk refuses.
    #[cfg(feature = "store")]
    #[error(
        "cannot keep results in {path}: {source}\nwhat was complete is kept: run again when the disk works"
    )]
    Storage {
        /// Of the database.
        path: PathBuf,
        /// What SQLite says.
        source: rusqlite::Error,
    },
    /// A file that is not ours, or whose head is damaged.
    #[error(
        "{path} is no database of results ({what})\nit is another program's, or its beginning is damaged: restore it from a copy, or choose another folder with `out = DIR`"
    )]
    Foreign {
        /// Of the file.
        path: PathBuf,
        /// How it shows.
        what: String,
    },
    /// Written by a later or earlier program in another layout.
    #[error(
        "{path} is of schema version {found}, this program writes version {SCHEMA_VERSION}\nuse the program that wrote it, or choose another folder with `out = DIR` and run again"
    )]
    Schema {
        /// Of the database.
        path: PathBuf,
        /// Its version.
        found: String,
    },
    /// Computed by kernels that give other numbers.
    #[error(
        "{path} was computed by {program} with the kernels {found}; those of this program, {ours}, give other numbers\n\
         use the program that wrote it, or choose another folder with `out = DIR` and run again"
    )]
    Kernels {
        /// Of the database.
        path: PathBuf,
        /// That wrote it.
        program: String,
        /// Its kernels with their versions.
        found: String,
        /// Those of this program.
        ours: String,
    },
    /// A folder that belongs to another study.
    #[error(
        "{path} holds results of another study (seed {seed}, streams {streams}, kind {kind})\nchoose another folder with `out = DIR`, or remove this one"
    )]
    OtherStudy {
        /// Of the database.
        path: PathBuf,
        /// Of the study that it holds.
        kind: String,
        /// Of that study.
        seed: String,
        /// Of that study.
        streams: String,
    },
    /// A row whose checksum or content is wrong.
    #[error(
        "{path}: the row of point {point}, estimate {estimate}, trials from {first} is damaged ({what})\n{SALVAGE}"
    )]
    DamagedRow {
        /// Of the database.
        path: PathBuf,
        /// Of the row.
        point: Id,
        /// Of the row.
        estimate: Id,
        /// Number of its first trial.
        first: u64,
        /// What is wrong.
        what: &'static str,
    },
    /// Damage that is not that of a row.
    #[error("{path} is damaged ({what})\n{SALVAGE}")]
    Damaged {
        /// Of the database.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// Two computations of the same trials differ.
    #[error(
        "{path}: trials from {first} of point {point}, estimate {estimate} have other values than those that are there already\na program or machine computes differently: run `sagnac verify` on each"
    )]
    Disagrees {
        /// Of the database.
        path: PathBuf,
        /// Of the row.
        point: Id,
        /// Of the row.
        estimate: Id,
        /// Number of its first trial.
        first: u64,
    },
}

/// What to do about damage.
const SALVAGE: &str = "merge this folder into a new one without what is damaged, `salvage = true`, and run that again, or restore \
                       the folder from a copy";

impl StoreError {
    /// What SQLite says, in our words.
    #[cfg(feature = "store")]
    pub(crate) fn of(path: &Path, source: rusqlite::Error) -> StoreError {
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
            (_, Some(ErrorCode::DiskFull)) => StoreError::Full { path },
            (_, Some(ErrorCode::ReadOnly)) => StoreError::ReadOnly { path },
            (_, Some(ErrorCode::NotADatabase)) => StoreError::Foreign { path, what },
            // Columns of another type, text that is none, a table that is gone: nothing that this program writes.
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

    /// Whether what is on disk is not what was written.
    pub fn is_damage(&self) -> bool {
        matches!(
            self,
            StoreError::Damaged { .. } | StoreError::DamagedRow { .. } | StoreError::Disagrees { .. }
        )
    }
}
