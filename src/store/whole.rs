//! Files of a results folder other than the database.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

/// Refuses what is not an ordinary file, where there is something: a link in a folder from someone else may lead to any
/// file, and a pipe may never end.
///
/// # Errors
/// It is not an ordinary file.
#[cfg(feature = "store")]
pub(crate) fn ordinary(path: &Path) -> io::Result<()> {
    match fs::symlink_metadata(path) {
        Ok(found) if !found.is_file() => {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            Err(io::Error::other(format!("{name} is a link or no ordinary file")))
        }
        _ => Ok(()),
    }
}

/// Refuses a database that is not an ordinary file, or has a journal that is none.
///
/// # Errors
/// One of the files is not an ordinary file.
#[cfg(feature = "store")]
pub(crate) fn ordinary_database(path: &Path) -> io::Result<()> {
    ["", "-wal", "-journal", "-shm"].into_iter().try_for_each(|end| {
        let mut name = path.as_os_str().to_owned();
        name.push(end);
        ordinary(Path::new(&name))
    })
}

/// Writes a file as a whole or not at all: an existing file stays until the new one is on disk.
///
/// # Errors
/// The file cannot be written.
pub fn write_whole(path: &Path, contents: &[u8]) -> io::Result<()> {
    write_whole_by(path, |file| file.write_all(contents))
}

/// Writes a file as [`write_whole`] does, with contents that need not be in memory together.
///
/// # Errors
/// The file cannot be written, or `contents` fails.
pub fn write_whole_by(path: &Path, contents: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let partial = path.with_extension("partial");
    // What is there is left over by a run that was killed, or a link into the files of whoever writes here.
    let _ = fs::remove_file(&partial);
    let written =
        File::create_new(&partial).and_then(|mut file| contents(&mut file).and_then(|()| file.sync_all()));
    written.and_then(|()| fs::rename(&partial, path)).inspect_err(|_| {
        // On a full disk, the space is worth more than half a file.
        let _ = fs::remove_file(&partial);
    })
}
