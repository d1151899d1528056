//! Files that are read: only those that have an end.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest size of a study or of a noise file, in bytes.
pub const MOST_TOML: u64 = 16 << 20;

/// Largest size of a record in bytes, 2^28, which is read and refused in less than 1 GiB of memory.
pub const MOST_RECORD: u64 = 1 << 28;

/// The folders of files that a shell has opened for the program: `/dev/stdin`, and `/dev/fd/63` or `/proc/self/fd/63` of
/// `<(command)`. Their other end is open already, so reading them does not wait for a stranger.
const INHERITED: [&str; 4] = ["/dev/stdin", "/dev/fd", "/proc/self/fd", "/proc/thread-self/fd"];

/// Opens a file for reading. What a shell has opened for the program may be of any kind.
///
/// # Errors
/// The file cannot be opened, or is of a kind that may have no end or never begin: a folder, a pipe with a name, a
/// device, a socket.
pub fn open(path: &Path) -> Result<File, Error> {
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_file() || INHERITED.iter().any(|folder| path.starts_with(folder)) {
        return File::open(path);
    }
    let what = if kind.is_dir() { "it is a folder" } else { "it is a pipe, a device or a socket" };
    Err(Error::new(
        ErrorKind::InvalidInput,
        format!("{what}, not an ordinary file; write the data to a file"),
    ))
}

/// The bytes of the file at `path`, which [`open`] accepts.
///
/// # Errors
/// The file cannot be opened or read, or has `most` bytes or more.
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>, Error> {
    let file = open(path)?;
    let mut bytes = Vec::new();
    if file.metadata()?.len() < most {
        file.take(most).read_to_end(&mut bytes)?;
        if (bytes.len() as u64) < most {
            return Ok(bytes);
        }
    }
    Err(Error::new(ErrorKind::FileTooLarge, format!("it is longer than {} MiB", most >> 20)))
}

/// The text of the file at `path`.
///
/// # Errors
/// It fails where [`read_bytes`] does, and where the file is not UTF-8.
pub fn read_text(path: &Path, most: u64) -> Result<String, Error> {
    String::from_utf8(read_bytes(path, most)?)
        .map_err(|_| Error::new(ErrorKind::InvalidData, "stream did not contain valid UTF-8"))
}

/// The files that a study names, each read once. The stored copies are therefore the data used in the computation, even
/// if a file changes meanwhile or is a pipe.
pub(crate) struct Files {
    folder: PathBuf,
    read: RefCell<HashMap<PathBuf, Arc<str>>>,
}

impl Files {
    /// The files of a study in this folder.
    pub(crate) fn of(folder: &Path) -> Files {
        Files { folder: folder.to_owned(), read: RefCell::default() }
    }

    /// The path of a file.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The text of a file.
    ///
    /// # Errors
    /// It fails where [`read_text`] does.
    pub(crate) fn text(&self, name: &str, most: u64) -> Result<Arc<str>, Error> {
        let path = self.path(name);
        if let Some(known) = self.read.borrow().get(&path) {
            return Ok(known.clone());
        }
        let text: Arc<str> = read_text(&path, most)?.into();
        self.read.borrow_mut().insert(path, text.clone());
        Ok(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_too_long_or_has_no_end_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text");
        std::fs::write(&path, "0123456").unwrap();
        assert_eq!(read_text(&path, 8).unwrap(), "0123456");
        assert_eq!(read_text(&path, 7).unwrap_err().kind(), ErrorKind::FileTooLarge);
        assert!(read_text(folder.path(), 8).unwrap_err().to_string().contains("it is a folder"));
        #[cfg(unix)]
        assert!(read_text(Path::new("/dev/zero"), 1 << 20).unwrap_err().to_string().contains("a device"));
    }
}
