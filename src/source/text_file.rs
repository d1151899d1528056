//! Files that are read as a whole.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest size of a study or of a noise file, in bytes.
pub(crate) const MOST_TOML: u64 = 16 << 20;

/// Largest size of a record in bytes, 2^28, which is read and refused in less than 1 GiB of memory.
pub(crate) const MOST_RECORD: u64 = 1 << 28;

/// The text of the file at `path`, which may be a pipe.
///
/// # Errors
/// The file cannot be read, or has `most` bytes or more; a device may have no end.
pub(crate) fn read_text(path: &Path, most: u64) -> Result<String, Error> {
    let file = File::open(path)?;
    let mut text = String::new();
    if file.metadata()?.len() < most {
        file.take(most).read_to_string(&mut text)?;
        if (text.len() as u64) < most {
            return Ok(text);
        }
    }
    Err(Error::new(ErrorKind::FileTooLarge, format!("it is longer than {} MiB", most >> 20)))
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
        #[cfg(unix)]
        assert_eq!(read_text(Path::new("/dev/zero"), 1 << 20).unwrap_err().kind(), ErrorKind::FileTooLarge);
    }
}
