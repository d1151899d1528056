//! What can be wrong with the results on disk.

use std::io;
use std::path::{Path, PathBuf};

use rusqlite::ErrorCode;

use super::SCHEMA_VERSION;
use super::lock::Holder;
use crate::id::Id;

/// What went wrong with the results on disk, and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error(
        "cannot use the results folder {path}: {source}\nmake it writable or choose another one with --out DIR"
    )]
    Folder { path: PathBuf, source: io::Error },
    #[error(
        "{folder} has no results: its {} is missing or empty\ngive the folder of a study that was run",
        super::FILE
    )]
    NoResults { folder: PathBuf },
    #[error(
        "{path} is in use by {holder}\nwait for it to end; a run can go to another folder with --out DIR"
    )]
    Busy { path: PathBuf, holder: Holder },
    #[error(
        "no space is left for {path}\nwhat was complete is kept: make room and run again, and it goes on from there"
    )]
    Full { path: PathBuf },
    #[error(
        "{path} cannot be written: it or its disk is read-only\nmake it writable, or choose another folder with --out DIR"
    )]
    ReadOnly { path: PathBuf },
    #[error(
        "{path} cannot be read here: what a run that was cut short left in {}-wal has to be taken over, and the folder is \
         read-only\ncopy the folder to where it can be written",
        super::FILE
    )]
    Unfinished { path: PathBuf },
    #[error(
        "cannot keep results in {path}: {source}\nwhat was complete is kept: run again when the disk works"
    )]
    Storage { path: PathBuf, source: rusqlite::Error },
    #[error(
        "{path} is no database of results ({what})\nit is another program's, or its beginning is damaged: restore it from a copy, or choose another folder with --out DIR"
    )]
    Foreign { path: PathBuf, what: String },
    #[error(
        "{path} is of schema version {found}, this program writes version {SCHEMA_VERSION}\nuse the program that wrote it, or choose another folder with --out DIR and run again"
    )]
    Schema { path: PathBuf, found: String },
    #[error(
        "{path} was computed by {program} with the kernels {found}; those of this program, {ours}, give other numbers\n\
         use the program that wrote it, or choose another folder with --out DIR and run again"
    )]
    Kernels { path: PathBuf, program: String, found: String, ours: String },
    #[error(
        "{path} holds results of another study (seed {seed}, streams {streams}, kind {kind})\nchoose another folder with --out DIR, or remove this one"
    )]
    OtherStudy { path: PathBuf, kind: String, seed: String, streams: String },
    #[error(
        "{path}: the row of point {point}, estimate {estimate}, trials from {first} is damaged ({what})\n{SALVAGE}"
    )]
    DamagedRow { path: PathBuf, point: Id, estimate: Id, first: u64, what: &'static str },
    #[error("{path} is damaged ({what})\n{SALVAGE}")]
    Damaged { path: PathBuf, what: String },
    #[error(
        "{path}: trials from {first} of point {point}, estimate {estimate} have other values than those that are there already\na program or machine computes differently: run `sagnac verify` on each"
    )]
    Disagrees { path: PathBuf, point: Id, estimate: Id, first: u64 },
}

/// What to do about damage.
const SALVAGE: &str = "take what is sound to a new folder with `sagnac merge --salvage THIS --out NEW` and run that again, or \
                       restore the folder from a copy";

impl StoreError {
    /// What SQLite says, in our words.
    pub(super) fn of(path: &Path, source: rusqlite::Error) -> StoreError {
        let path = path.to_owned();
        let what = source.to_string();
        match (&source, source.sqlite_error_code()) {
            (_, Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked)) => {
                StoreError::Busy { path, holder: Holder::Unknown }
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
