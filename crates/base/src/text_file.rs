//! Files that are read: only regular ones, with a limit of their size.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::{File, Metadata};
use std::io::{Error, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest size of a study or of a noise file, in bytes. The parser of TOML takes up to 100 bytes for each of them.
pub const MAX_TOML: u64 = 4 << 20;

/// Largest size of a record in bytes, 2^28, which is read and refused in less than 1 GiB of memory.
pub const MAX_RECORD: u64 = 1 << 28;

/// The folders of the numbers of files that a shell has opened for the program, as for `<(command)`.
const INHERITED: [&str; 3] = ["/dev/fd", "/proc/self/fd", "/proc/thread-self/fd"];

/// Whether a shell has opened the file for the program: `/dev/stdin`, or `/dev/fd/63` of `<(command)`. Its other end is open
/// already, so reading it does not wait for a stranger.
fn is_inherited(path: &Path) -> bool {
    let number = path.file_name().and_then(|name| name.to_str()).and_then(|name| name.parse::<u32>().ok());
    let folder = path.parent().filter(|_| number.is_some());
    path == Path::new("/dev/stdin")
        || folder.is_some_and(|folder| INHERITED.iter().any(|known| folder == Path::new(known)))
}

/// Opens a file for reading. What a shell has opened for the program may be of any kind.
///
/// # Errors
/// The file cannot be opened, or is of a kind that may have no end or never begin: a folder, a pipe with a name, a
/// device, a socket, a file of the kernel.
pub fn open(path: &Path) -> Result<File, Error> {
    if is_inherited(path) {
        return File::open(path);
    }
    let file = open_at_once(path)?;
    // The kind is that of what was opened, whatever has taken its place since.
    ordinary(&file.metadata()?)?;
    Ok(file)
}

/// Refuses what may have no end or never begin.
fn ordinary(found: &Metadata) -> Result<(), Error> {
    let what = match found.file_type() {
        _ if is_of_kernel(found) => "it is a file of the kernel",
        kind if kind.is_file() => return Ok(()),
        kind if kind.is_dir() => "it is a folder",
        _ => "it is a pipe, a device or a socket",
    };
    Err(Error::new(
        ErrorKind::InvalidInput,
        format!("{what}, not an ordinary file; write the data to a file"),
    ))
}

/// Opens a file without waiting for the other end of a pipe.
#[cfg(feature = "files")]
fn open_at_once(path: &Path) -> Result<File, Error> {
    use cap_fs_ext::OpenOptionsSyncExt;
    let mut options = cap_std::fs::OpenOptions::new();
    let options = options.read(true).nonblock(true);
    cap_std::fs::File::open_ambient_with(path, options, cap_std::ambient_authority())
        .map(cap_std::fs::File::into_std)
}

/// Opens an ordinary file.
#[cfg(not(feature = "files"))]
fn open_at_once(path: &Path) -> Result<File, Error> {
    ordinary(&std::fs::metadata(path)?)?;
    File::open(path)
}

/// Whether a file is one of those that the kernel makes up while they are read, some without an end.
fn is_of_kernel(found: &Metadata) -> bool {
    #[cfg(target_os = "linux")]
    {
        use std::os::linux::fs::MetadataExt;
        let device = |path: &str| std::fs::metadata(path).ok().map(|found| found.st_dev());
        // Where the kernel's files are not mounted, as in a chroot, their folders are ordinary ones.
        let is_on = |folder: &&str| device(folder) == Some(found.st_dev());
        ["/proc", "/sys"].iter().any(is_on) && !is_on(&"/")
    }
    #[cfg(not(target_os = "linux"))]
    {
        let _ = found;
        false
    }
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
    Err(too_long(most))
}

/// The text of the file at `path`.
///
/// # Errors
/// It fails where [`read_bytes`] does, and where the file is not UTF-8.
pub fn read_text(path: &Path, most: u64) -> Result<String, Error> {
    utf8(read_bytes(path, most)?)
}

fn utf8(bytes: Vec<u8>) -> Result<String, Error> {
    String::from_utf8(bytes)
        .map_err(|_| Error::new(ErrorKind::InvalidData, "it is not UTF-8: save it in that encoding"))
}

/// Files by the names that a study gives them, wherever a front end keeps them: in a folder, or in the memory of a page.
pub trait Files {
    /// The bytes of a file.
    ///
    /// # Errors
    /// There is no such file, it cannot be read, or has `most` bytes or more.
    fn bytes(&self, name: &str, most: u64) -> Result<Vec<u8>, Error>;

    /// The path of a file in messages. Names with the same path are the same file.
    fn path(&self, name: &str) -> PathBuf {
        PathBuf::from(name)
    }
}

/// The files of a folder, which [`open`] accepts.
#[derive(Debug)]
pub struct FolderFiles(pub PathBuf);

impl Files for FolderFiles {
    fn bytes(&self, name: &str, most: u64) -> Result<Vec<u8>, Error> {
        read_bytes(&self.path(name), most)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

/// Files in memory.
impl Files for BTreeMap<String, Vec<u8>> {
    fn bytes(&self, name: &str, most: u64) -> Result<Vec<u8>, Error> {
        match self.get(name) {
            None => Err(Error::new(ErrorKind::NotFound, "there is no such file")),
            Some(bytes) if bytes.len() as u64 >= most => Err(too_long(most)),
            Some(bytes) => Ok(bytes.clone()),
        }
    }
}

fn too_long(most: u64) -> Error {
    Error::new(ErrorKind::FileTooLarge, format!("it is longer than {} MiB", most >> 20))
}

/// The files that a study names, each read once. The stored copies are therefore the data used in the computation, even
/// if a file changes meanwhile or is a pipe.
pub struct InputFiles<'a> {
    files: &'a dyn Files,
    read: RefCell<ReadFiles>,
}

/// Files that were read, by their names, with their paths in messages.
#[derive(Debug, Clone, Default)]
pub struct ReadFiles(BTreeMap<String, (PathBuf, Arc<str>)>);

impl Files for ReadFiles {
    fn bytes(&self, name: &str, most: u64) -> Result<Vec<u8>, Error> {
        let (_, text) = self.0.get(name).ok_or(ErrorKind::NotFound)?;
        if text.len() as u64 >= most { Err(too_long(most)) } else { Ok(text.as_bytes().to_vec()) }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.get(name).map_or_else(|| PathBuf::from(name), |(path, _)| path.clone())
    }
}

impl<'a> InputFiles<'a> {
    /// None of `files` has been read yet.
    pub fn new(files: &'a dyn Files) -> InputFiles<'a> {
        InputFiles { files, read: RefCell::default() }
    }

    /// The files that were read.
    pub fn into_read(self) -> ReadFiles {
        self.read.into_inner()
    }

    /// The path of a file in messages.
    pub fn path(&self, name: &str) -> PathBuf {
        self.files.path(name)
    }

    /// The text of a file.
    ///
    /// # Errors
    /// It fails where [`Files::bytes`] does, where the file is not UTF-8, and where all files together have [`MAX_RECORD`] bytes or
    /// more.
    pub fn text(&self, name: &str, most: u64) -> Result<Arc<str>, Error> {
        if let Some((_, known)) = self.read.borrow().0.get(name) {
            return Ok(known.clone());
        }
        let before: u64 = self.read.borrow().0.values().map(|(_, text)| text.len() as u64).sum();
        let left = MAX_RECORD.saturating_sub(before);
        let text = self.files.bytes(name, most.min(left)).and_then(utf8);
        let text: Arc<str> = text
            .map_err(|error| match error.kind() {
                ErrorKind::FileTooLarge if left < most => Error::new(
                    ErrorKind::FileTooLarge,
                    format!(
                        "with it, the files of the study have more than {} MiB; split the study",
                        MAX_RECORD >> 20
                    ),
                ),
                _ => error,
            })?
            .into();
        self.read.borrow_mut().0.insert(name.to_owned(), (self.path(name), text.clone()));
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

    #[test]
    fn the_files_of_a_study_are_bounded_together() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a", "b", "c"] {
            let file = File::create(folder.path().join(name)).unwrap();
            file.set_len(if name == "c" { 1 << 10 } else { MAX_RECORD / 2 }).unwrap();
        }
        let folder = FolderFiles(folder.path().to_owned());
        let files = InputFiles::new(&folder);
        files.text("a", MAX_RECORD).unwrap();
        let refused = files.text("b", MAX_RECORD).unwrap_err().to_string();
        assert!(refused.contains("the files of the study have more than 256 MiB"), "{refused}");
        files.text("c", MAX_RECORD).unwrap();
        // Each counts once.
        files.text("a", MAX_RECORD).unwrap();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn files_of_the_kernel_and_detours_over_open_files_are_refused() {
        for path in ["/proc/self/maps", "/proc/kmsg", "/sys/kernel/mm/transparent_hugepage/enabled"] {
            // Some are not there for everybody.
            let refused = read_bytes(Path::new(path), 10).unwrap_err();
            assert!(
                refused.to_string().contains("kernel") || refused.kind() != ErrorKind::InvalidInput,
                "{path}: {refused}"
            );
        }
        let refused = read_bytes(Path::new("/dev/fd/../../dev/zero"), 10).unwrap_err();
        assert!(
            !is_inherited(Path::new("/dev/fd/../../dev/zero"))
                && !is_inherited(Path::new("/proc/self/fd/../cwd/1"))
        );
        assert_ne!(refused.kind(), ErrorKind::FileTooLarge, "{refused}");
        assert!(is_inherited(Path::new("/dev/fd/63")) && is_inherited(Path::new("/proc/self/fd/0")));
    }
}
