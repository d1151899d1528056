//! Files of a results folder beside the tallies.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

/// Writes a file as a whole or not at all: what was there stays until the new one is on disk.
///
/// # Errors
/// The file cannot be written.
pub fn write_whole(path: &Path, contents: &[u8]) -> io::Result<()> {
    let partial = path.with_extension("partial");
    let written =
        File::create(&partial).and_then(|mut file| file.write_all(contents).and_then(|()| file.sync_all()));
    written.and_then(|()| fs::rename(&partial, path)).inspect_err(|_| {
        // Of a full disk half a file is worth less than its room.
        let _ = fs::remove_file(&partial);
    })
}
