//! A results folder, through which everything in it is written.
//!
//! The folder has a list of the files that this program wrote there, with their SHA-256. A file is replaced or removed only if
//! the list has it with the digest of its present contents. All else belongs to someone else and is left as it is, and what is
//! to be written in its place is refused. Below the folder no link is followed: each component is opened from the one that
//! contains it.

use std::collections::{HashMap, HashSet};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use cap_fs_ext::{DirExt, FollowSymlinks, MetadataExt, OpenOptionsFollowExt, OpenOptionsSyncExt};
use cap_std::ambient_authority;
use cap_std::fs::{Dir, File, Metadata, OpenOptions};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::store::{CARD, FILE};

/// The name of the list.
pub const LIST: &str = "written_by_sagnac.jsonl";

/// What the first line of the list says, without which a file of that name is not one.
const HEAD: &str = "files that sagnac wrote here, with the SHA-256 of each";

/// Largest list that is read, in bytes.
const MOST_LIST: u64 = 64 << 20;

/// Why a file of a results folder was not written or removed.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The folder itself cannot be made or opened.
    #[error("cannot use the results folder {}: {source}\nmake it writable or choose another one with `out = DIR`", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The operating system refused it.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A file of this name is not one that this program wrote, or was changed since.
    #[error("{} is not as sagnac wrote it, and is not replaced\n{}", path.display(), help(earlier.as_deref()))]
    Foreign {
        /// The file.
        path: PathBuf,
        /// Its folder, where that has results of a version that kept no list.
        earlier: Option<PathBuf>,
    },
    /// A component of the path is a link, a pipe or a mount.
    #[error("{} is {what}, and nothing is written there\nremove it, or write to another folder", path.display())]
    Special {
        /// The component.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// The file is one that the command reads.
    #[error("{} is read by this command, and is not replaced\nwrite to another folder", path.display())]
    Input {
        /// The file.
        path: PathBuf,
    },
}

/// What to do about a file of someone else.
fn help(earlier: Option<&Path>) -> String {
    match earlier {
        None => "move it, or write to another folder".to_owned(),
        Some(folder) => format!(
            "the folder has results of an earlier version: take over its files with `sagnac check {} --adopt`, or write to another \
             folder",
            folder.display()
        ),
    }
}

/// The first line of a list.
#[derive(Serialize, Deserialize)]
struct Head {
    list: String,
    /// Whether there were results of an earlier version when it was begun, which it lacks.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    is_late: bool,
}

/// A file in the list.
#[derive(Debug, Serialize, Deserialize)]
struct Entry {
    name: String,
    /// Absent for a name that files have only while they are written.
    sha256: Option<String>,
    /// Whether it was there before the list, so that it may be replaced under its name, but not removed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    is_adopted: bool,
}

/// The list as it is known: the entries of each name in their order, and the names of files being written.
#[derive(Debug, Default)]
struct List {
    file: Option<File>,
    is_late: bool,
    entries: HashMap<String, Vec<Entry>>,
    partial: HashSet<String>,
}

/// What became of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Written {
    /// There was none of its name.
    New,
    /// It took the place of another one that this program had written.
    Replaced,
    /// It was there with the same contents, and is as it was.
    Same,
}

/// An open results folder.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    root: Dir,
    device: u64,
    inputs: Vec<PathBuf>,
    /// Whether there were results before the list, as of an earlier version.
    is_earlier: bool,
    list: Mutex<List>,
}

impl Folder {
    /// Opens the folder, which is made if it is missing.
    ///
    /// # Errors
    /// It cannot be made or opened, or is a link within another results folder.
    pub fn open(path: &Path) -> Result<Folder, FolderError> {
        let failed = |source| FolderError::Folder { path: path.to_owned(), source };
        let root = match path.parent().zip(path.file_name()).filter(|(parent, _)| is_results(parent)) {
            // Whoever made that folder may have made this component of it.
            Some((parent, name)) => {
                let parent = Folder::open(parent)?;
                parent.within(Path::new(name), true)?.ok_or_else(|| failed(ErrorKind::NotFound.into()))?
            }
            None => {
                let path = if path == Path::new("") { Path::new(".") } else { path };
                std::fs::create_dir_all(path).map_err(failed)?;
                Dir::open_ambient_dir(path, ambient_authority()).map_err(failed)?
            }
        };
        let device = root.dir_metadata().map_err(failed)?.dev();
        let mut folder = Folder {
            path: path.to_owned(),
            root,
            device,
            inputs: vec![],
            is_earlier: false,
            list: Mutex::default(),
        };
        folder.is_earlier = match folder.read_list()? {
            true => folder.list().is_late,
            false => is_results(path),
        };
        Ok(folder)
    }

    /// The folder of a command that reads these files, none of which it replaces.
    #[must_use]
    pub fn reading<'a>(mut self, inputs: impl IntoIterator<Item = &'a Path>) -> Folder {
        self.inputs.extend(inputs.into_iter().filter_map(|path| path.canonicalize().ok()));
        self
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether files of these names may be written, so that long work need not end in a refusal.
    ///
    /// # Errors
    /// One of them is in the place of a file that [`Folder::write`] would refuse to replace.
    pub fn check<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Result<(), FolderError> {
        names.into_iter().try_for_each(|name| self.replaceable(name, None).map(drop))
    }

    /// Writes a file as a whole or not at all: an existing file stays until the new one is on disk. One with the same contents
    /// stays as it is.
    ///
    /// # Errors
    /// The file cannot be written, or one of this name is not from this program.
    pub fn write(&self, name: &str, contents: &[u8]) -> Result<Written, FolderError> {
        let place = self.replaceable(name, Some(contents))?;
        if place != Written::Same {
            self.write_by(name, |file| file.write_all(contents))?;
        }
        Ok(place)
    }

    /// Writes a file as [`Folder::write`] does, with contents that need not be in memory together; returns its SHA-256 in
    /// hexadecimal digits.
    ///
    /// # Errors
    /// It fails where [`Folder::write`] does, and where `contents` does.
    pub fn write_by(
        &self,
        name: &str,
        contents: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<String, FolderError> {
        self.replaceable(name, None)?;
        let (folder, last) = self.place(name, true)?;
        let folder = folder.ok_or_else(|| self.failed(name, ErrorKind::NotFound.into()))?;
        let partial = format!("{last}.partial");
        let failed = |source| self.failed(name, source);
        let mut file = self.begin(&folder, name, &partial)?;
        let written = contents(&mut file)
            .and_then(|()| file.sync_all())
            .and_then(|()| file.seek(SeekFrom::Start(0)))
            .and_then(|_| digest_of(&mut file))
            .and_then(|digest| self.enter(Entry::written(name, Some(&digest))).map(|()| digest));
        // What is there now may have come meanwhile.
        let renamed = written.map_err(failed).and_then(|digest| {
            self.replaceable(name, None)?;
            folder.rename(&partial, &folder, &last).map_err(failed).map(|()| digest)
        });
        renamed.inspect_err(|_| {
            // On a full disk, the space is worth more than half a file.
            let _ = folder.remove_file(&partial);
        })
    }

    /// Removes a file that this program wrote and nobody changed; `false` if there is none. One that was adopted stays.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn remove(&self, name: &str) -> Result<bool, FolderError> {
        let is_own = |(digest, _): (String, _)| self.list().entry(name, &digest).is_some_and(|entry| !entry.is_adopted);
        if !self.found(name)?.is_some_and(is_own) {
            return Ok(false);
        }
        let (Some(folder), last) = self.place(name, false)? else { return Ok(false) };
        folder.remove_file(last).map_err(|source| self.failed(name, source)).map(|()| true)
    }

    /// The names in the list.
    pub fn listed(&self) -> Vec<String> {
        self.list().entries.keys().cloned().collect()
    }

    /// The files in the list that somebody changed since they were written, by name; `None` in a folder without a list.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn changed(&self) -> Result<Option<Vec<String>>, FolderError> {
        let mut changed = Vec::new();
        let listed = self.listed();
        for name in &listed {
            let is_changed = match self.found(name) {
                Err(FolderError::Special { .. }) => true,
                found => found?.is_some_and(|(digest, _)| !self.has(name, &digest)),
            };
            if is_changed {
                changed.push(name.clone());
            }
        }
        changed.sort();
        Ok((!listed.is_empty()).then_some(changed))
    }

    /// Enters files of an earlier version, which kept no list, so that they can be replaced under their names; returns these. It
    /// does so once for a folder, as nothing tells files of later date from those of somebody else.
    ///
    /// # Errors
    /// One of them cannot be read.
    pub fn adopt(&self, is_ours: impl Fn(&str) -> bool) -> Result<Vec<String>, FolderError> {
        let mut adopted = Vec::new();
        if self.can_adopt() {
            for name in self.names()?.into_iter().filter(|name| is_ours(name)) {
                if let Some((digest, _)) = self.found(&name)?
                    && !self.list().entries.contains_key(&name)
                {
                    self.enter(Entry { name: name.clone(), sha256: Some(digest), is_adopted: true })
                        .map_err(|source| self.failed(&name, source))?;
                    adopted.push(name);
                }
            }
        }
        adopted.sort();
        Ok(adopted)
    }

    /// Whether files of an earlier version can still be adopted.
    fn can_adopt(&self) -> bool {
        self.is_earlier && !self.list().entries.values().flatten().any(|entry| entry.is_adopted)
    }

    /// The names of ordinary files in the folder and one level deeper.
    fn names(&self) -> Result<Vec<String>, FolderError> {
        let mut names = Vec::new();
        let entries = |dir: &Dir| dir.entries().and_then(|entries| entries.collect::<io::Result<Vec<_>>>());
        for entry in entries(&self.root).map_err(|source| self.failed("", source))? {
            let Ok(name) = entry.file_name().into_string() else { continue };
            let Ok(kind) = entry.file_type() else { continue };
            if kind.is_file() {
                names.push(name);
            } else if kind.is_dir()
                && let Ok(Some(inner)) = self.within(Path::new(&name), false)
            {
                let inner = entries(&inner).map_err(|source| self.failed(&name, source))?;
                let files =
                    inner.into_iter().filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
                names.extend(
                    files.filter_map(|entry| {
                        Some(format!("{name}/{}", entry.file_name().into_string().ok()?))
                    }),
                );
            }
        }
        Ok(names)
    }

    /// What a file of this name with these contents would be.
    ///
    /// # Errors
    /// Something of this name is not from this program.
    fn replaceable(&self, name: &str, contents: Option<&[u8]>) -> Result<Written, FolderError> {
        let Some((digest, path)) = self.found(name)? else { return Ok(Written::New) };
        if contents.is_some_and(|contents| digest_of(&mut &contents[..]).is_ok_and(|new| new == digest)) {
            return Ok(Written::Same);
        }
        if !self.has(name, &digest) {
            // Another command may have written it meanwhile.
            self.read_list()?;
        }
        if !self.has(name, &digest) {
            return Err(FolderError::Foreign { path, earlier: self.can_adopt().then(|| self.path.clone()) });
        }
        match path.canonicalize().is_ok_and(|path| self.inputs.contains(&path)) {
            true => Err(FolderError::Input { path }),
            false => Ok(Written::Replaced),
        }
    }

    /// The digest and the path of the file of this name; `None` if there is none.
    ///
    /// # Errors
    /// It is no ordinary file, or cannot be read.
    fn found(&self, name: &str) -> Result<Option<(String, PathBuf)>, FolderError> {
        let (Some(folder), last) = self.place(name, false)? else { return Ok(None) };
        let path = self.path.join(name);
        let metadata = match folder.symlink_metadata(&last) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            found => found.map_err(|source| self.failed(name, source))?,
        };
        if let Some(what) = special(&metadata) {
            return Err(FolderError::Special { path, what });
        }
        let digest = open(&folder, &last, OpenOptions::new().read(true))
            .and_then(|mut file| digest_of(&mut file))
            .map_err(|source| self.failed(name, source))?;
        Ok(Some((digest, path)))
    }

    /// The folder that contains a file, and the last component of its name; `None` if that folder is missing and not made.
    fn place(&self, name: &str, make: bool) -> Result<(Option<Dir>, String), FolderError> {
        let path = Path::new(name);
        let last = path.file_name().map(|last| last.to_string_lossy().into_owned());
        let last = last.ok_or_else(|| self.failed(name, ErrorKind::InvalidFilename.into()))?;
        Ok((self.within(path.parent().unwrap_or(Path::new("")), make)?, last))
    }

    /// Opens a folder below this one, component by component.
    fn within(&self, path: &Path, make: bool) -> Result<Option<Dir>, FolderError> {
        let mut dir = self.root.try_clone().map_err(|source| self.failed("", source))?;
        let mut below = PathBuf::new();
        for component in path.components() {
            below.push(component);
            let at = self.path.join(&below);
            let failed = |source| FolderError::Io { path: at.clone(), source };
            match dir.symlink_metadata(component) {
                Err(error) if error.kind() == ErrorKind::NotFound && !make => return Ok(None),
                Err(error) if error.kind() == ErrorKind::NotFound => {
                    dir.create_dir(component).map_err(failed)?
                }
                Err(error) => return Err(failed(error)),
                Ok(found) if found.is_symlink() => {
                    return Err(FolderError::Special { path: at, what: "a link" });
                }
                Ok(found) if !found.is_dir() => {
                    return Err(FolderError::Special { path: at, what: "no folder" });
                }
                Ok(_) => {}
            }
            dir = dir.open_dir_nofollow(component).map_err(failed)?;
            if dir.dir_metadata().map_err(failed)?.dev() != self.device {
                return Err(FolderError::Special { path: at, what: "on another file system" });
            }
        }
        Ok(Some(dir))
    }

    /// The file that a file is until it is whole.
    fn begin(&self, folder: &Dir, name: &str, partial: &str) -> Result<File, FolderError> {
        let whole_name = format!("{name}.partial");
        let options = || OpenOptions::new().read(true).write(true).create_new(true).clone();
        let is_left_over = self.list().partial.contains(&whole_name);
        if is_left_over && folder.symlink_metadata(partial).is_ok_and(|found| found.is_file()) {
            folder.remove_file(partial).map_err(|source| self.failed(&whole_name, source))?;
        }
        if !is_left_over {
            self.enter(Entry::written(&whole_name, None)).map_err(|source| self.failed(LIST, source))?;
        }
        let path = || self.path.join(&whole_name);
        match open(folder, partial, &mut options()) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                Err(FolderError::Foreign { path: path(), earlier: None })
            }
            made => made.map_err(|source| FolderError::Io { path: path(), source }),
        }
    }

    fn has(&self, name: &str, digest: &str) -> bool {
        self.list().entry(name, digest).is_some()
    }

    fn list(&self) -> MutexGuard<'_, List> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn failed(&self, name: &str, source: io::Error) -> FolderError {
        FolderError::Io { path: self.path.join(name), source }
    }

    /// Reads the list; `false` if there is none.
    fn read_list(&self) -> Result<bool, FolderError> {
        let path = self.path.join(LIST);
        let failed = |source| self.failed(LIST, source);
        let mut list = self.list();
        match self.root.symlink_metadata(LIST) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
            Err(error) => return Err(failed(error)),
            // It is written in place.
            Ok(found) => {
                if let Some(what) = in_place(&found) {
                    return Err(FolderError::Special { path, what });
                }
            }
        }
        let file = open_in_place(&self.root, LIST, OpenOptions::new().read(true).append(true));
        // A list on a read-only disk can still be read.
        let (file, can_write) = match file {
            Ok(file) => (file, true),
            Err(_) => (open(&self.root, LIST, OpenOptions::new().read(true)).map_err(failed)?, false),
        };
        let mut text = Vec::new();
        (&file).take(MOST_LIST).read_to_end(&mut text).map_err(failed)?;
        let text = String::from_utf8_lossy(&text);
        let mut lines = text.lines();
        let head = lines.next().and_then(|line| serde_json::from_str::<Head>(line).ok());
        let Some(head) = head.filter(|head| head.list == HEAD) else {
            return Err(FolderError::Foreign { path, earlier: None });
        };
        let file = can_write.then_some(file);
        *list = List { file, is_late: head.is_late, ..List::default() };
        // The last line of a run that was killed may be a part of one.
        for entry in lines.filter_map(|line| serde_json::from_str::<Entry>(line).ok()) {
            list.add(entry);
        }
        Ok(true)
    }

    /// Adds a file to the list, on disk first.
    fn enter(&self, entry: Entry) -> io::Result<()> {
        if entry.sha256.as_ref().is_some_and(|digest| self.has(&entry.name, digest)) {
            return Ok(());
        }
        let mut list = self.list();
        if list.file.is_none() {
            let made =
                open_in_place(&self.root, LIST, OpenOptions::new().read(true).append(true).create_new(true));
            match made {
                Ok(mut file) => {
                    list.is_late = self.is_earlier;
                    let head = Head { list: HEAD.to_owned(), is_late: self.is_earlier };
                    file.write_all(format!("{}\n", serde_json::to_string(&head)?).as_bytes())?;
                    list.file = Some(file);
                }
                // Another command has begun it.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                    drop(list);
                    self.read_list().map_err(io::Error::other)?;
                    list = self.list();
                }
                Err(error) => return Err(error),
            }
        }
        // A line of its own, even behind a torn one.
        let line = format!("\n{}\n", serde_json::to_string(&entry)?);
        if let Some(file) = &mut list.file {
            file.write_all(line.as_bytes())?;
            // A file must not be on disk before its entry.
            if entry.sha256.is_some() {
                file.sync_data()?;
            }
        }
        list.add(entry);
        Ok(())
    }
}

impl Entry {
    fn written(name: &str, sha256: Option<&str>) -> Entry {
        Entry { name: name.to_owned(), sha256: sha256.map(str::to_owned), is_adopted: false }
    }
}

impl List {
    fn add(&mut self, entry: Entry) {
        match entry.sha256 {
            Some(_) => self.entries.entry(entry.name.clone()).or_default().push(entry),
            None => drop(self.partial.insert(entry.name)),
        }
    }

    /// The last entry of this name and digest.
    fn entry(&self, name: &str, digest: &str) -> Option<&Entry> {
        let entries = self.entries.get(name)?.iter().rev();
        entries.into_iter().find(|entry| entry.sha256.as_deref() == Some(digest))
    }
}

/// Whether this program keeps results in a folder: there is a list, a database or a card.
fn is_results(folder: &Path) -> bool {
    [LIST, CARD, FILE].iter().any(|name| folder.join(name).is_file())
}

/// Names the kind of a file that is not an ordinary one; `None` for an ordinary file.
fn special(found: &Metadata) -> Option<&'static str> {
    match found.file_type() {
        kind if kind.is_file() => None,
        kind if kind.is_symlink() => Some("a link"),
        kind if kind.is_dir() => Some("a folder"),
        _ => Some("a pipe, a device or a socket"),
    }
}

/// What forbids to write to a file in place: it is no ordinary one, or has other names.
fn in_place(found: &Metadata) -> Option<&'static str> {
    special(found).or((found.nlink() > 1).then_some("a hard link"))
}

/// Opens an ordinary file without following a link, or waiting for a pipe that took its place since it was looked at.
fn open(folder: &Dir, name: &str, options: &mut OpenOptions) -> io::Result<File> {
    let file = folder.open_with(name, options.follow(FollowSymlinks::No).nonblock(true))?;
    refuse(name, special(&file.metadata()?)).map(|()| file)
}

/// Opens a file that is written in place, which has no other names.
fn open_in_place(folder: &Dir, name: &str, options: &mut OpenOptions) -> io::Result<File> {
    let file = open(folder, name, options)?;
    refuse(name, in_place(&file.metadata()?)).map(|()| file)
}

fn refuse(name: &str, what: Option<&str>) -> io::Result<()> {
    what.map_or(Ok(()), |what| Err(io::Error::other(format!("{name} is {what}"))))
}

/// The SHA-256 of what remains to be read, in hexadecimal digits.
fn digest_of(source: &mut dyn Read) -> io::Result<String> {
    let (mut digest, mut block) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match source.read(&mut block)? {
            0 => break,
            count => digest.update(&block[..count]),
        }
    }
    Ok(digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Opens a file that is written in place, without following a link; it is made if it is missing.
///
/// # Errors
/// It is a link, a hard link or no ordinary file, or cannot be opened.
pub(crate) fn single(path: &Path) -> io::Result<std::fs::File> {
    check_single(path)?;
    let (folder, name) = parts(path)?;
    open_in_place(&folder, &name, OpenOptions::new().read(true).write(true).create(true)).map(File::into_std)
}

/// Refuses a database that is no ordinary file of one name, or has a journal that is none.
///
/// # Errors
/// One of the files is a link, a hard link or no ordinary file.
pub(crate) fn single_database(path: &Path) -> io::Result<()> {
    ["", "-wal", "-journal", "-shm"].into_iter().try_for_each(|end| {
        let mut name = path.as_os_str().to_owned();
        name.push(end);
        check_single(Path::new(&name))
    })
}

/// Device and number of a file, where there is one.
pub(crate) fn file_of(path: &Path) -> Option<[u64; 2]> {
    let (folder, name) = parts(path).ok()?;
    let found = folder.symlink_metadata(name).ok()?;
    Some([found.dev(), found.ino()])
}

/// The path of a file with its folder as it is behind all links: SQLite follows none.
pub(crate) fn real(path: &Path) -> PathBuf {
    let folder = parent(path).canonicalize();
    folder.ok().zip(path.file_name()).map_or_else(|| path.to_owned(), |(folder, name)| folder.join(name))
}

fn check_single(path: &Path) -> io::Result<()> {
    let (folder, name) = parts(path)?;
    let found = match folder.symlink_metadata(&name) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        found => found?,
    };
    refuse(&name, in_place(&found))
}

fn parts(path: &Path) -> io::Result<(Dir, String)> {
    let folder = Dir::open_ambient_dir(parent(path), ambient_authority())?;
    Ok((folder, path.file_name().unwrap_or_default().to_string_lossy().into_owned()))
}

fn parent(path: &Path) -> &Path {
    path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn new() -> (tempfile::TempDir, Folder) {
        let parent = tempfile::tempdir().unwrap();
        let folder = Folder::open(&parent.path().join("results")).unwrap();
        (parent, folder)
    }

    fn read(folder: &Folder, name: &str) -> String {
        std::fs::read_to_string(folder.path().join(name)).unwrap()
    }

    #[test]
    fn own_files_are_replaced_and_removed_also_by_a_later_command() {
        let (_parent, folder) = new();
        assert_eq!(folder.write("inputs/a.toml", b"one").unwrap(), Written::New);
        assert_eq!(folder.write("inputs/a.toml", b"one").unwrap(), Written::Same);
        let again = Folder::open(folder.path()).unwrap();
        assert_eq!(again.write("inputs/a.toml", b"two").unwrap(), Written::Replaced);
        assert_eq!(read(&again, "inputs/a.toml"), "two");
        // The first one has read the list before.
        assert!(folder.write("inputs/a.toml", b"three").is_ok());
        let digest = folder.write_by("points.csv", |file| file.write_all(b"abc")).unwrap();
        assert_eq!(digest, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        assert!(Folder::open(folder.path()).unwrap().remove("points.csv").unwrap());
        assert!(!folder.remove("points.csv").unwrap());
        assert!(!folder.path().join("inputs/a.toml.partial").exists());
    }

    #[test]
    fn files_of_others_stay_and_what_was_changed_belongs_to_who_changed_it() {
        let (_parent, folder) = new();
        folder.write("report.html", b"ours").unwrap();
        for (name, text) in
            [("curve.csv", "mine"), ("report.html", "changed"), ("psd.csv.partial", "mine too")]
        {
            std::fs::write(folder.path().join(name), text).unwrap();
            let written = name.trim_end_matches(".partial");
            let error = folder.write(written, b"new").unwrap_err();
            assert!(matches!(error, FolderError::Foreign { earlier: None, .. }), "{name}: {error}");
            assert!(folder.check([written]).is_err() || name.ends_with("partial"), "{name}");
            assert!(!folder.remove(name).unwrap(), "{name}");
            assert_eq!(read(&folder, name), text);
        }
        // With the same contents nothing is written.
        assert_eq!(folder.write("curve.csv", b"mine").unwrap(), Written::Same);
        assert!(folder.write("curve.csv", b"new").is_err());
        assert_eq!(folder.changed().unwrap().unwrap(), ["report.html"]);
    }

    #[test]
    fn an_input_is_never_an_output() {
        let (_parent, folder) = new();
        folder.write("curve.csv", b"ours").unwrap();
        let path = folder.path().join("../results/curve.csv");
        let folder = folder.reading([path.as_path()]);
        assert!(matches!(folder.write("curve.csv", b"new"), Err(FolderError::Input { .. })));
        assert_eq!(read(&folder, "curve.csv"), "ours");
    }

    #[test]
    fn what_a_run_that_was_killed_left_is_removed_and_a_torn_list_goes_on() {
        let (_parent, folder) = new();
        folder.write("a.csv", b"a").unwrap();
        std::fs::write(folder.path().join("a.csv.partial"), "half").unwrap();
        let list = folder.path().join(LIST);
        let torn = std::fs::read_to_string(&list).unwrap() + "{\"name\":\"b.cs";
        std::fs::write(&list, torn).unwrap();
        let folder = Folder::open(folder.path()).unwrap();
        folder.write("a.csv", b"b").unwrap();
        folder.write("b.csv", b"b").unwrap();
        let folder = Folder::open(folder.path()).unwrap();
        assert_eq!([read(&folder, "a.csv"), read(&folder, "b.csv")], ["b", "b"]);
        assert!(folder.write("a.csv", b"c").is_ok() && folder.write("b.csv", b"c").is_ok());
        assert!(!folder.path().join("a.csv.partial").exists());
    }

    #[test]
    fn a_folder_of_an_earlier_version_is_taken_over_by_name_only() {
        let (_parent, folder) = new();
        for name in ["card.json", "report.html", "letter.txt"] {
            std::fs::write(folder.path().join(name), "{}").unwrap();
        }
        let folder = Folder::open(folder.path()).unwrap();
        assert!(matches!(
            folder.write("report.html", b"new"),
            Err(FolderError::Foreign { earlier: Some(_), .. })
        ));
        assert_eq!(folder.adopt(|name| name != "letter.txt").unwrap(), ["card.json", "report.html"]);
        assert!(folder.write("report.html", b"new").is_ok() && folder.write("letter.txt", b"new").is_err());
    }

    #[test]
    fn adopted_files_are_replaced_but_never_removed_and_are_adopted_once() {
        let (_parent, folder) = new();
        for name in ["card.json", "noise.toml", "noise_of_unit7.toml"] {
            std::fs::write(folder.path().join(name), "{}").unwrap();
        }
        // A list that is begun late does not have them.
        Folder::open(folder.path()).unwrap().write("redrawn.svg", b"ours").unwrap();
        let folder = Folder::open(folder.path()).unwrap();
        assert_eq!(folder.adopt(|name| name != LIST).unwrap(), ["card.json", "noise.toml", "noise_of_unit7.toml"]);
        let folder = Folder::open(folder.path()).unwrap();
        assert!(!folder.remove("noise_of_unit7.toml").unwrap());
        assert_eq!(read(&folder, "noise_of_unit7.toml"), "{}");
        folder.write("noise.toml", b"new").unwrap();
        assert!(folder.remove("noise.toml").unwrap());
        // What comes later is no file of an earlier version.
        std::fs::write(folder.path().join("card.json"), "edited").unwrap();
        std::fs::write(folder.path().join("noise_x.toml"), "mine").unwrap();
        assert!(folder.adopt(|_| true).unwrap().is_empty());
        assert!(matches!(folder.write("card.json", b"new"), Err(FolderError::Foreign { earlier: None, .. })));
    }

    #[cfg(unix)]
    #[test]
    fn no_link_is_followed_wherever_it_is_in_the_path() {
        use std::os::unix::fs::symlink;
        let (parent, folder) = new();
        let victim = parent.path().join("victim");
        std::fs::create_dir(&victim).unwrap();
        std::fs::write(victim.join("a.toml"), "mine").unwrap();
        symlink(&victim, folder.path().join("inputs")).unwrap();
        symlink(victim.join("a.toml"), folder.path().join("points.csv")).unwrap();
        std::fs::hard_link(victim.join("a.toml"), folder.path().join("hard.csv")).unwrap();
        std::fs::create_dir(folder.path().join("folder.csv")).unwrap();
        for name in
            ["inputs/a.toml", "inputs/new.toml", "points.csv", "hard.csv", "folder.csv", "../victim/a.toml"]
        {
            assert!(folder.write(name, b"new").is_err(), "{name}");
            assert!(!matches!(folder.remove(name), Ok(true)), "{name}");
        }
        symlink(victim.join("new.csv"), folder.path().join("new.csv.partial")).unwrap();
        assert!(folder.write("new.csv", b"new").is_err());
        folder.write("own.csv", b"own").unwrap();
        // Within results a folder is none of the user's choice.
        symlink(&victim, folder.path().join("shard-1-of-2")).unwrap();
        assert!(matches!(
            Folder::open(&folder.path().join("shard-1-of-2")),
            Err(FolderError::Special { .. })
        ));
        assert_eq!(std::fs::read_dir(&victim).unwrap().count(), 1);
        // The list is written in place.
        std::fs::hard_link(folder.path().join(LIST), victim.join("list")).unwrap();
        assert!(matches!(Folder::open(folder.path()), Err(FolderError::Special { .. })));
        assert_eq!(std::fs::read_to_string(victim.join("a.toml")).unwrap(), "mine");
    }

    #[cfg(unix)]
    #[test]
    fn a_thousand_writes_follow_no_link_that_takes_the_place_of_a_folder_or_a_file_meanwhile() {
        use std::os::unix::fs::symlink;
        use std::sync::atomic::{AtomicBool, Ordering};
        let (parent, folder) = new();
        let victim = parent.path().join("victim");
        std::fs::create_dir(&victim).unwrap();
        std::fs::write(victim.join("a.toml"), "mine").unwrap();
        folder.write("inputs/a.toml", b"0").unwrap();
        let place = |name: &str| folder.path().join(name);
        let (inputs, away) = (place("inputs"), place("away"));
        let is_done = AtomicBool::new(false);
        let written = std::thread::scope(|scope| {
            scope.spawn(|| {
                while !is_done.load(Ordering::Relaxed) {
                    // The folder may be made again at any time.
                    let _ = std::fs::rename(&inputs, &away);
                    if symlink(&victim, &inputs).is_ok() {
                        std::thread::yield_now();
                        std::fs::remove_file(&inputs).unwrap();
                    }
                    if std::fs::rename(&away, &inputs).is_err() {
                        let _ = std::fs::remove_dir_all(&away);
                    }
                    let _ = symlink(victim.join("a.toml"), place("points.csv"));
                    std::thread::yield_now();
                    let _ = std::fs::remove_file(place("points.csv"));
                }
            });
            let write = |k: u32| {
                let text = k.to_string();
                let done =
                    ["inputs/a.toml", "points.csv"].map(|name| folder.write(name, text.as_bytes()).is_ok());
                u32::from(done[0]) + u32::from(done[1])
            };
            let written: u32 = (1..=1000).map(write).sum();
            is_done.store(true, Ordering::Relaxed);
            written
        });
        assert!(written > 0);
        assert_eq!(std::fs::read_to_string(victim.join("a.toml")).unwrap(), "mine");
        assert_eq!(std::fs::read_dir(&victim).unwrap().count(), 1);
        assert!(std::fs::read_to_string(place("inputs/a.toml")).unwrap().parse::<u32>().is_ok());
    }
}
