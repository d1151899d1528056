//! Files of a results folder other than the database.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

/// Writes a file as a whole or not at all: an existing file stays until the new one is on disk.
///
/// # Errors
/// The file cannot be written.
pub fn write_whole(path: &Path, contents: &[u8]) -> io::Result<()> {
    let partial = path.with_extension("partial");
    let written =
        File::create(&partial).and_then(|mut file| file.write_all(contents).and_then(|()| file.sync_all()));
    written.and_then(|()| fs::rename(&partial, path)).inspect_err(|_| {
        // On a full disk, the space is worth more than half a file.
        let _ = fs::remove_file(&partial);
    })
}
