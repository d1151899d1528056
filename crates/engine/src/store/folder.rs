//! A results folder, through which everything in it is written.
//!
//! The folder has a list of the files that this program wrote there, with their sizes and their SHA-256. A file is replaced or
//! removed only if the list has it with the digest of its present contents. All else belongs to someone else and is left as it
//! is, and what is to be written in its place is refused. The files of a command are written beside those that they replace,
//! and take their places together, once none is refused. Below the folder no link is followed: each component is opened from
//! the one that contains it.

use std::collections::{BTreeMap, HashMap};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cap_fs_ext::{DirExt, FollowSymlinks, MetadataExt, OpenOptionsFollowExt, OpenOptionsSyncExt};
use cap_std::ambient_authority;
use cap_std::fs::{Dir, File, Metadata, OpenOptions};
use cap_std::time::SystemTime;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::store::lock::{LOCK, Lock};
use crate::store::{CARD, FILE, StoreError};

/// The name of the list.
pub const LIST: &str = "written_by_sagnac.jsonl";

/// What the first line of the list says, without which a file of that name is not one.
const HEAD: &str = "files that sagnac wrote here, with the SHA-256 of each";

/// End of the name that a file has while it is written. No other program gives it.
const PARTIAL: &str = ".sagnac_partial";

/// Largest list that is read, and longest name in it, in bytes.
const MAX_LIST: u64 = 64 << 20;
const MAX_NAME: usize = 1 << 10;

/// Longest name of a file that file systems take, in bytes.
const MAX_COMPONENT: usize = 255;

/// Length of the beginning of a page in which its marks are sought, in bytes.
const MAX_BEGINNING: u64 = 1 << 18;

/// Largest file that is compared with an entry without a size, in bytes.
const MAX_UNSIZED: u64 = 1 << 30;

/// Least size of a file of which the space on the disk is compared with its size, in bytes, and most times that the size of a file
/// of this program is that space, whatever a file system compresses.
const MIN_HOLLOW: u64 = 64 << 20;
const MAX_COMPRESSED: u64 = 64;

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
    /// Another command has the folder, or it cannot be locked.
    #[error(transparent)]
    Lock(#[from] StoreError),
    /// The operating system refused to write it.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The operating system refused to read it.
    #[error("cannot read {}: {source}", path.display())]
    Unread {
        /// The file.
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
    #[error("{} is {what}, and nothing is written there\n{}, or write to another folder", path.display(), if *what == HARD_LINK { "copy it in its place" } else { "remove it" })]
    Special {
        /// The component.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// The folder of a page that belongs to no results has some.
    #[error("{} would be among the files of a results folder\nname another file with `out = FILE`", path.display())]
    Within {
        /// The page.
        path: PathBuf,
    },
    /// The file is one that the command reads.
    #[error("{} is read by this command, and is not replaced\nwrite to another folder", path.display())]
    Input {
        /// The file.
        path: PathBuf,
    },
}

/// What a file with several names is.
const HARD_LINK: &str = "a hard link";

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

/// A line of the list.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Entry {
    name: String,
    /// Absent for a file that was removed.
    sha256: Option<String>,
    /// Absent in lists of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    size: Option<u64>,
    /// Whether it was there before the list, so that it may be replaced under its name, but not removed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    is_adopted: bool,
    /// Whether files that are made of it were still to be written.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    is_ahead: bool,
}

/// The list as it is known: the entries of each name in their order.
#[derive(Debug, Default)]
struct List {
    /// Absent before it is begun, and where it is only read.
    file: Option<File>,
    /// Whether its file has the first line.
    is_begun: bool,
    /// Whether its last line is a part of one, as a command that was killed leaves it.
    is_torn: bool,
    is_late: bool,
    entries: HashMap<String, Vec<Entry>>,
}

/// A file that is there.
struct Found {
    path: PathBuf,
    file: File,
    stamp: Stamp,
    is_hollow: bool,
    digest: Option<String>,
}

/// What tells a file, and a state of it, from another one without reading it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    number: [u64; 2],
    size: u64,
    modified: Option<SystemTime>,
}

impl Stamp {
    fn new(found: &Metadata) -> Stamp {
        Stamp { number: [found.dev(), found.ino()], size: found.len(), modified: found.modified().ok() }
    }
}

/// What a command does to a file once all its files are written.
#[derive(Debug)]
enum Staged {
    Written { sha256: String, size: u64, is_ahead: bool },
    Removed,
}

/// What a command does to a file, with what was in its place when it was looked at.
#[derive(Debug)]
enum Change {
    Written(Option<Stamp>),
    /// Nothing is removed where the file was gone or somebody else's.
    Removed(Option<Stamp>),
}

/// How a listed file differs from what was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Difference {
    /// It has other contents, or is no ordinary file.
    Changed,
    /// It is not there.
    Missing,
    /// A command was interrupted before this file, or those that are made of it, had their places.
    Unfinished,
    /// It cannot be looked at, as with a name that no file can have.
    Unreadable,
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
    /// Absent where the folder is only read.
    lock: Option<Arc<Lock>>,
    /// Whether there were results before the list, as of an earlier version.
    is_earlier: bool,
    list: Mutex<List>,
    staged: Mutex<BTreeMap<String, Staged>>,
}

impl Drop for Folder {
    /// Removes what was written but not committed.
    fn drop(&mut self) {
        let staged = std::mem::take(&mut *self.staged());
        staged.keys().for_each(|name| self.discard(name));
    }
}

impl Folder {
    /// Opens the folder for writing, which is made if it is missing. No other command can write there meanwhile.
    ///
    /// # Errors
    /// It cannot be made or opened, is in use, or is a link within another results folder.
    pub fn open(path: &Path) -> Result<Folder, FolderError> {
        let mut folder = Folder::at(path, true)?;
        // Below the folder that is open, whatever takes the place of its path meanwhile.
        let opened = single_in(&folder.root, LOCK);
        folder.lock = Some(Arc::new(Lock::new(path, opened)?));
        folder.with_list()
    }

    /// Opens an existing folder for reading.
    ///
    /// # Errors
    /// It cannot be opened, or is a link within another results folder.
    pub fn read(path: &Path) -> Result<Folder, FolderError> {
        Folder::at(path, false)?.with_list()
    }

    fn at(path: &Path, make: bool) -> Result<Folder, FolderError> {
        let failed = |source| FolderError::Folder { path: path.to_owned(), source };
        let root = match path.parent().zip(path.file_name()).filter(|(parent, _)| is_results(parent)) {
            // Whoever made that folder may have made this component of it.
            Some((parent, name)) => {
                let parent = Folder::at(parent, false)?;
                parent.within(Path::new(name), make)?.ok_or_else(|| failed(ErrorKind::NotFound.into()))?
            }
            None => {
                let path = if path == Path::new("") { Path::new(".") } else { path };
                if make {
                    std::fs::create_dir_all(path).map_err(failed)?;
                }
                Dir::open_ambient_dir(path, ambient_authority()).map_err(failed)?
            }
        };
        Ok(Folder {
            path: path.to_owned(),
            device: root.dir_metadata().map_err(failed)?.dev(),
            root,
            inputs: vec![],
            lock: None,
            is_earlier: false,
            list: Mutex::default(),
            staged: Mutex::default(),
        })
    }

    fn with_list(mut self) -> Result<Folder, FolderError> {
        self.is_earlier = match self.read_list()? {
            true => self.list().is_late,
            false => is_results(&self.path),
        };
        Ok(self)
    }

    /// Its lock, for the store within it.
    pub(crate) fn lock(&self) -> Option<Arc<Lock>> {
        self.lock.clone()
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

    /// Whether files of these names may be written, with contents where they are known, so that long work need not end in a
    /// refusal.
    ///
    /// # Errors
    /// One of them is in the place of a file that [`Folder::write`] would refuse to replace.
    pub fn check<'a>(
        &self,
        files: impl IntoIterator<Item = (&'a str, Option<&'a [u8]>)>,
    ) -> Result<(), FolderError> {
        files.into_iter().try_for_each(|(name, contents)| self.replaceable(name, contents).map(drop))
    }

    /// Writes a file, which takes its place when the folder is [committed](Folder::commit). One with the same contents stays as
    /// it is.
    ///
    /// # Errors
    /// The file cannot be written, or one of this name is not from this program.
    pub fn write(&self, name: &str, contents: &[u8]) -> Result<Written, FolderError> {
        let (place, _) = self.replaceable(name, Some(contents))?;
        match place {
            Written::Same => {
                self.staged().remove(name);
                self.discard(name);
            }
            _ => drop(self.stage(name, false, |file| file.write_all(contents))?),
        }
        Ok(place)
    }

    /// Writes a file as [`Folder::write`] does, of which others are made that are committed later: it is
    /// [unfinished](Difference::Unfinished) until it is written again with them.
    ///
    /// # Errors
    /// It fails where [`Folder::write`] does.
    pub fn write_ahead(&self, name: &str, contents: &[u8]) -> Result<(), FolderError> {
        // Of a file of somebody else nothing can be told in the list.
        if self.write(name, contents)? != Written::Same || self.is_listed(name) {
            self.stage(name, true, |file| file.write_all(contents))?;
        }
        Ok(())
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
        self.stage(name, false, contents)
    }

    /// Removes a file that this program wrote and nobody changed when the folder is [committed](Folder::commit); `false` if there
    /// is none. Whatever else has its name stays, and is no longer listed; one that was adopted stays as it is.
    ///
    /// # Errors
    /// It cannot be looked at.
    pub fn remove(&self, name: &str) -> Result<bool, FolderError> {
        let removal = self.removal(name)?;
        if removal.is_some() {
            self.staged().insert(name.to_owned(), Staged::Removed);
        }
        Ok(removal.is_some_and(|removal| removal.is_some()))
    }

    /// Takes files that are gone out of the list when the folder is [committed](Folder::commit), as nobody may write them again.
    ///
    /// # Errors
    /// One of them cannot be looked at.
    pub fn forget_missing(&self) -> Result<(), FolderError> {
        let is_missing = |name: &String| matches!(self.found(name), Ok(None)) && !self.is_partial(name);
        self.listed().iter().filter(|name| is_missing(name)).try_for_each(|name| self.remove(name).map(drop))
    }

    /// Puts the files that were written in their places, and removes those to be removed: all of them, or none where one is
    /// refused.
    ///
    /// # Errors
    /// A file in the place of one of them is not from this program, or the disk fails.
    pub fn commit(&self) -> Result<(), FolderError> {
        let staged = std::mem::take(&mut *self.staged());
        // On a full disk, the space is worth more than files without a place.
        let entries =
            self.entered(&staged).inspect_err(|_| staged.keys().for_each(|name| self.discard(name)))?;
        // From here on a later command finishes what is not done.
        entries.into_iter().try_for_each(|(name, change)| self.put(&name, change))
    }

    /// Enters changes into the list, with the file that each is about.
    fn entered(&self, staged: &BTreeMap<String, Staged>) -> Result<Vec<(String, Change)>, FolderError> {
        self.finish(staged)?;
        let (mut entries, mut changes) = (Vec::new(), Vec::new());
        for (name, change) in staged {
            // What is there now may have come meanwhile.
            let (sha256, size, is_ahead, change) = match change {
                Staged::Written { sha256, size, is_ahead } => {
                    let change = Change::Written(self.replaceable(name, None)?.1);
                    (Some(sha256.clone()), Some(*size), *is_ahead, change)
                }
                Staged::Removed => match self.removal(name)? {
                    Some(before) => (None, None, false, Change::Removed(before)),
                    None => continue,
                },
            };
            entries.push(Entry { name: name.clone(), sha256, size, is_adopted: false, is_ahead });
            changes.push((name.clone(), change));
        }
        self.enter(entries).map_err(|source| self.failed(LIST, source))?;
        Ok(changes)
    }

    /// Does to a file what the list has of it.
    ///
    /// # Errors
    /// Another file came in its place since it was looked at, or the disk fails.
    fn put(&self, name: &str, change: Change) -> Result<(), FolderError> {
        let (Some(folder), last) = self.place(name, false)? else {
            return match change {
                // Its folder is gone too.
                Change::Removed(_) => Ok(()),
                Change::Written(_) => Err(self.failed(name, ErrorKind::NotFound.into())),
            };
        };
        let done = match change {
            Change::Written(before) => put_in_place(&folder, &last, before),
            Change::Removed(before) => {
                let now = folder.symlink_metadata(&last).ok().map(|found| Stamp::new(&found));
                if now.is_some() && now == before { folder.remove_file(&last) } else { Ok(()) }
            }
        };
        done.map_err(|source| match source.kind() {
            ErrorKind::AlreadyExists => FolderError::Foreign { path: self.path.join(name), earlier: None },
            _ => self.failed(name, source),
        })
    }

    /// Puts in their places what a command that was interrupted had entered into the list, but for what is `staged` now, and
    /// removes what else it was writing.
    fn finish(&self, staged: &BTreeMap<String, Staged>) -> Result<(), FolderError> {
        let names: Vec<String> =
            self.list().entries.keys().filter(|name| !staged.contains_key(*name)).cloned().collect();
        for name in names.iter().filter(|name| self.is_partial(name)) {
            match self.replaceable(name, None) {
                Ok((_, before)) if self.is_whole(name) => self.put(name, Change::Written(before))?,
                _ => self.discard(name),
            }
        }
        Ok(())
    }

    /// Whether what stands beside the place of a file is what the list has of it.
    fn is_whole(&self, name: &str) -> bool {
        let (Ok((Some(folder), last)), Some(Entry { sha256: Some(wanted), size: Some(size), .. })) =
            (self.place(name, false), self.last(name))
        else {
            return false;
        };
        open(&folder, &partial(&last), OpenOptions::new().read(true)).is_ok_and(|mut file| {
            file.metadata().is_ok_and(|found| found.len() == size && !is_hollow(&found))
                && digest_of(&mut file).is_ok_and(|digest| digest == wanted)
        })
    }

    /// Removes a file that was written and has not got its place.
    fn discard(&self, name: &str) {
        if let Ok((Some(folder), last)) = self.place(name, false) {
            let _ = folder.remove_file(partial(&last));
        }
    }

    /// Writes a file beside its place, and returns its SHA-256.
    fn stage(
        &self,
        name: &str,
        is_ahead: bool,
        contents: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<String, FolderError> {
        let (folder, last) = self.place(name, true)?;
        let folder = folder.ok_or_else(|| self.failed(name, ErrorKind::NotFound.into()))?;
        let partial = partial(&last);
        let mut file = Hashed { file: self.begin(&folder, name, &partial)?, digest: Sha256::new(), size: 0 };
        let written = contents(&mut file).and_then(|()| file.file.sync_all());
        written.map_err(|source| {
            let _ = folder.remove_file(&partial);
            self.failed(name, source)
        })?;
        let (sha256, size) = (hexadecimal(file.digest), file.size);
        let staged = Staged::Written { sha256: sha256.clone(), size, is_ahead };
        self.staged().insert(name.to_owned(), staged);
        Ok(sha256)
    }

    /// The names of files in the list that were not removed, or that are still there.
    pub fn listed(&self) -> Vec<String> {
        let list = self.list();
        let is_listed = |(name, entries): &(&String, &Vec<Entry>)| {
            entries.last().is_some_and(|entry| entry.sha256.is_some())
                || self.has(name, |last| last.to_owned())
        };
        list.entries.iter().filter(is_listed).map(|(name, _)| name.clone()).collect()
    }

    /// The files in the list that are no longer as they were last written, by name; `None` in a folder without a list.
    pub fn changed(&self) -> Option<BTreeMap<String, Difference>> {
        let difference = |name: String| {
            let difference = self.difference(&name).unwrap_or(Some(Difference::Unreadable));
            difference.map(|difference| (name, difference))
        };
        let changed = self.listed().into_iter().filter_map(difference).collect();
        self.list().is_begun.then_some(changed)
    }

    fn difference(&self, name: &str) -> Result<Option<Difference>, FolderError> {
        let is_removed = !self.is_listed(name);
        let known = match self.found(name) {
            Err(FolderError::Special { .. }) => None,
            Err(error) => return Err(error),
            Ok(None) if self.is_partial(name) => return Ok(Some(Difference::Unfinished)),
            Ok(None) => return Ok(self.is_sized(name).then_some(Difference::Missing)),
            Ok(Some(mut found)) => self.known(name, &mut found)?,
        };
        Ok(match known {
            Some((entry, true)) => entry.is_ahead.then_some(Difference::Unfinished),
            Some((entry, _)) if is_removed => (!entry.is_adopted).then_some(Difference::Unfinished),
            Some(_) if self.is_partial(name) => Some(Difference::Unfinished),
            // What was removed is no longer ours.
            None if is_removed => None,
            _ => Some(Difference::Changed),
        })
    }

    /// Whether the last entry of a name has a size. Lists of earlier versions have none, and do not say what was removed.
    fn is_sized(&self, name: &str) -> bool {
        self.last(name).is_some_and(|entry| entry.size.is_some())
    }

    /// Whether the list has a file of this name that was not removed.
    fn is_listed(&self, name: &str) -> bool {
        self.last(name).is_some_and(|entry| entry.sha256.is_some())
    }

    /// The last entry of a name.
    fn last(&self, name: &str) -> Option<Entry> {
        self.list().entries.get(name).and_then(|entries| entries.last().cloned())
    }

    /// Whether a command was interrupted while it wrote a file of this name, or before this had its place.
    fn is_partial(&self, name: &str) -> bool {
        self.has(name, partial)
    }

    /// Whether an ordinary file has the name that `of` makes of the last component of this one.
    fn has(&self, name: &str, of: impl Fn(&str) -> String) -> bool {
        self.place(name, false).is_ok_and(|(folder, last)| {
            folder.is_some_and(|folder| folder.symlink_metadata(of(&last)).is_ok_and(|found| found.is_file()))
        })
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
                if let Some(mut found) = self.found(&name)?
                    && found.stamp.size <= MAX_UNSIZED
                    && !found.is_hollow
                    && !self.list().entries.contains_key(&name)
                {
                    let (sha256, size) = (Some(found.digest()?), Some(found.stamp.size));
                    adopted.push(Entry { name, sha256, size, is_adopted: true, is_ahead: false });
                }
            }
        }
        adopted.sort_by(|a, b| a.name.cmp(&b.name));
        let names = adopted.iter().map(|entry| entry.name.clone()).collect();
        if adopted.is_empty() && self.can_adopt() {
            // The list itself is no file that is written: this tells that there was nothing.
            let (name, is_adopted) = (LIST.to_owned(), true);
            adopted.push(Entry { name, sha256: None, size: None, is_adopted, is_ahead: false });
        }
        self.enter(adopted).map_err(|source| self.failed(LIST, source))?;
        Ok(names)
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

    /// What a file of this name with these contents would be, and what is there now.
    ///
    /// # Errors
    /// Something of this name is not from this program.
    fn replaceable(
        &self,
        name: &str,
        contents: Option<&[u8]>,
    ) -> Result<(Written, Option<Stamp>), FolderError> {
        let Some(mut found) = self.found(name)? else { return Ok((Written::New, None)) };
        let is_same = match contents.filter(|contents| contents.len() as u64 == found.stamp.size) {
            Some(contents) => found.digest()? == digest_of(&mut &contents[..]).unwrap_or_default(),
            None => false,
        };
        match self.known(name, &mut found)? {
            None if is_same => return Ok((Written::Same, Some(found.stamp))),
            // One that is listed as an earlier version, or ahead of others, is written again, so that it is listed as the present one.
            Some((entry, true)) if is_same && !entry.is_ahead => {
                return Ok((Written::Same, Some(found.stamp)));
            }
            None => {
                let earlier = self.can_adopt().then(|| self.path.clone());
                return Err(FolderError::Foreign { path: found.path, earlier });
            }
            Some(_) => {}
        }
        match found.path.canonicalize().is_ok_and(|path| self.inputs.contains(&path)) {
            true => Err(FolderError::Input { path: found.path }),
            false => Ok((Written::Replaced, Some(found.stamp))),
        }
    }

    /// What the removal of a file takes: `None` where nothing is to be done, else the file to be removed, which may be gone or
    /// somebody else's, so that only its entry is.
    fn removal(&self, name: &str) -> Result<Option<Option<Stamp>>, FolderError> {
        let found = match self.found(name) {
            Err(FolderError::Special { .. }) => None,
            found => found?,
        };
        let is_listed = self.is_listed(name);
        let Some(mut found) = found else { return Ok(is_listed.then_some(None)) };
        Ok(match self.known(name, &mut found)? {
            None => is_listed.then_some(None),
            Some((entry, _)) => (!entry.is_adopted).then_some(Some(found.stamp)),
        })
    }

    /// The last entry of a file with these contents, and whether it is the last of its name; `None` if there is none. Only a file
    /// of a listed size is read, which has that size on the disk too.
    fn known(&self, name: &str, found: &mut Found) -> Result<Option<(Entry, bool)>, FolderError> {
        let may_be = |entry: &Entry| {
            entry.sha256.is_some()
                && entry.size.map_or(found.stamp.size <= MAX_UNSIZED, |size| size == found.stamp.size)
        };
        let entries = self.list().entries.get(name).cloned().unwrap_or_default();
        if found.is_hollow || !entries.iter().any(may_be) {
            return Ok(None);
        }
        let digest = found.digest()?;
        let place = entries.iter().rposition(|entry| entry.sha256.as_ref() == Some(&digest));
        Ok(place.map(|place| (entries[place].clone(), place + 1 == entries.len())))
    }

    /// The file of this name; `None` if there is none.
    ///
    /// # Errors
    /// It is no ordinary file, or cannot be opened.
    fn found(&self, name: &str) -> Result<Option<Found>, FolderError> {
        let (Some(folder), last) = self.place(name, false)? else { return Ok(None) };
        let path = self.path.join(name);
        let failed = |source| FolderError::Unread { path: path.clone(), source };
        let metadata = match folder.symlink_metadata(&last) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            found => found.map_err(failed)?,
        };
        if let Some(what) = special(&metadata) {
            return Err(FolderError::Special { path, what });
        }
        let file = open(&folder, &last, OpenOptions::new().read(true)).map_err(failed)?;
        let metadata = file.metadata().map_err(failed)?;
        let (stamp, is_hollow) = (Stamp::new(&metadata), is_hollow(&metadata));
        Ok(Some(Found { path, file, stamp, is_hollow, digest: None }))
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

    /// The file that a file is until it is whole, in place of one that a command that was killed left.
    fn begin(&self, folder: &Dir, name: &str, partial: &str) -> Result<File, FolderError> {
        let path = || self.path.join(name).with_file_name(partial);
        if folder.symlink_metadata(partial).is_ok_and(|found| found.is_file()) {
            folder.remove_file(partial).map_err(|source| FolderError::Io { path: path(), source })?;
        }
        match open(folder, partial, OpenOptions::new().write(true).create_new(true)) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                Err(FolderError::Foreign { path: path(), earlier: None })
            }
            made => made.map_err(|source| FolderError::Io { path: path(), source }),
        }
    }

    fn staged(&self) -> MutexGuard<'_, BTreeMap<String, Staged>> {
        self.staged.lock().unwrap_or_else(PoisonError::into_inner)
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
        let unread = |source| FolderError::Unread { path: path.clone(), source };
        let found = match self.root.symlink_metadata(LIST) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
            found => found.map_err(unread)?,
        };
        // It is written in place.
        let is_written = self.lock.is_some();
        if let Some(what) = if is_written { in_place(&found) } else { special(&found) } {
            return Err(FolderError::Special { path, what });
        }
        let file = match is_written {
            true => open_in_place(&self.root, LIST, OpenOptions::new().read(true).append(true))
                .map_err(|source| self.failed(LIST, source))?,
            false => open(&self.root, LIST, OpenOptions::new().read(true)).map_err(unread)?,
        };
        let mut text = Vec::new();
        (&file).take(MAX_LIST + 1).read_to_end(&mut text).map_err(unread)?;
        if text.len() as u64 > MAX_LIST {
            return Err(unread(too_long()));
        }
        let text = String::from_utf8_lossy(&text);
        let mut list = self.list();
        list.file = is_written.then_some(file);
        let mut lines = text.lines();
        // A command that was killed may have made it, and no more.
        let Some(head) = lines.next() else { return Ok(false) };
        let head = serde_json::from_str(head).ok().filter(|head: &Head| head.list == HEAD);
        let Some(head) = head else { return Err(FolderError::Foreign { path, earlier: None }) };
        (list.is_begun, list.is_late, list.is_torn) = (true, head.is_late, !text.ends_with('\n'));
        let entries = lines.filter_map(|line| serde_json::from_str::<Entry>(line).ok());
        entries.filter(|entry| entry.name.len() <= MAX_NAME).for_each(|entry| list.add(entry));
        Ok(true)
    }

    /// Adds entries to the list, on disk first.
    fn enter(&self, entries: Vec<Entry>) -> io::Result<()> {
        if entries.is_empty() {
            return Ok(());
        }
        let mut list = self.list();
        if list.file.is_none() {
            let mut options = OpenOptions::new();
            list.file =
                Some(open_in_place(&self.root, LIST, options.read(true).append(true).create_new(true))?);
        }
        let mut text = String::new();
        if !list.is_begun {
            let head = Head { list: HEAD.to_owned(), is_late: self.is_earlier };
            text = serde_json::to_string(&head)? + "\n";
        } else if list.is_torn {
            text.push('\n');
        }
        for entry in &entries {
            text += &(serde_json::to_string(entry)? + "\n");
        }
        let file = list.file.as_mut().ok_or(ErrorKind::NotFound)?;
        let before = file.metadata()?.len();
        if before + text.len() as u64 > MAX_LIST {
            return Err(too_long());
        }
        // A file must not be on disk before its entry.
        let written = file.write_all(text.as_bytes()).and_then(|()| file.sync_data());
        // Some of the entries alone would tell of files that are not written.
        written.inspect_err(|_| drop(file.set_len(before)))?;
        (list.is_begun, list.is_torn) = (true, false);
        list.is_late |= self.is_earlier;
        entries.into_iter().for_each(|entry| list.add(entry));
        Ok(())
    }
}

impl List {
    fn add(&mut self, entry: Entry) {
        self.entries.entry(entry.name.clone()).or_default().push(entry);
    }
}

impl Found {
    /// Its SHA-256, in hexadecimal digits.
    fn digest(&mut self) -> Result<String, FolderError> {
        if let Some(digest) = &self.digest {
            return Ok(digest.clone());
        }
        let digest = digest_of(&mut self.file)
            .map_err(|source| FolderError::Unread { path: self.path.clone(), source })?;
        Ok(self.digest.insert(digest).clone())
    }
}

/// A file with the digest of what is written to it.
struct Hashed {
    file: File,
    digest: Sha256,
    size: u64,
}

impl Write for Hashed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.digest.update(&bytes[..count]);
        self.size += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The name of a file while it is written: a digest in place of one that leaves no room for more.
fn partial(name: &str) -> String {
    match name.len() + PARTIAL.len() {
        0..=MAX_COMPONENT => format!("{name}{PARTIAL}"),
        _ => digest_of(&mut name.as_bytes()).unwrap_or_default() + PARTIAL,
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

/// Whether a file claims far more bytes than it has on the disk, as no file of this program does. Reading it could take hours.
fn is_hollow(found: &Metadata) -> bool {
    #[cfg(unix)]
    let space = cap_std::fs::MetadataExt::blocks(found).saturating_mul(512);
    #[cfg(not(unix))]
    let space = found.len();
    found.len() >= MIN_HOLLOW && space < found.len() / MAX_COMPRESSED
}

/// What forbids to write to a file in place: it is no ordinary one, or has other names.
fn in_place(found: &Metadata) -> Option<&'static str> {
    special(found).or((found.nlink() > 1).then_some(HARD_LINK))
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
    match what {
        None => Ok(()),
        Some(HARD_LINK) => {
            let message =
                format!("{name} is a hard link: copy the files of the folder instead of linking them");
            Err(io::Error::new(ErrorKind::TooManyLinks, message))
        }
        Some(what) => Err(io::Error::other(format!("{name} is {what}"))),
    }
}

/// Gives a file a name that no other one has. One that came meanwhile is not replaced, where the file system can tell.
fn rename_new(folder: &Dir, from: &str, to: &str) -> io::Result<()> {
    #[cfg(any(target_os = "linux", target_vendor = "apple"))]
    match rustix::fs::renameat_with(folder, from, folder, to, rustix::fs::RenameFlags::NOREPLACE) {
        Err(rustix::io::Errno::INVAL | rustix::io::Errno::NOSYS | rustix::io::Errno::NOTSUP) => {}
        done => return Ok(done?),
    }
    folder.rename(from, folder, to)
}

/// A list has or would have more bytes than are read of one.
fn too_long() -> io::Error {
    let message = format!(
        "it has more than {} MiB\nmove it away, and take over the files of the folder with `sagnac check DIR --adopt`",
        MAX_LIST >> 20
    );
    io::Error::new(ErrorKind::FileTooLarge, message)
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
    Ok(hexadecimal(digest))
}

fn hexadecimal(digest: Sha256) -> String {
    digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Opens a file that is written in place, without following a link; it is made if it is missing.
///
/// # Errors
/// It is a link, a hard link or no ordinary file, or cannot be opened.
pub(crate) fn single(path: &Path) -> io::Result<std::fs::File> {
    let (folder, name) = parts(path)?;
    single_in(&folder, &name)
}

fn single_in(folder: &Dir, name: &str) -> io::Result<std::fs::File> {
    check_single(folder, name)?;
    open_in_place(folder, name, OpenOptions::new().read(true).write(true).create(true)).map(File::into_std)
}

/// Opens a file for reading, without following a link or waiting for a pipe.
///
/// # Errors
/// It is no ordinary file, or cannot be opened.
pub(crate) fn readable(path: &Path) -> io::Result<std::fs::File> {
    let (folder, name) = parts(path)?;
    open(&folder, &name, OpenOptions::new().read(true)).map(File::into_std)
}

/// Whether files can be made in a folder, as far as its permissions tell.
pub(crate) fn takes_files(folder: &Path) -> bool {
    #[cfg(unix)]
    let takes = rustix::fs::access(folder, rustix::fs::Access::WRITE_OK).is_ok();
    #[cfg(not(unix))]
    let takes = folder.is_dir();
    takes
}

/// Refuses a database that is no ordinary file of one name, or has a journal that is none.
///
/// # Errors
/// One of the files is a link, a hard link or no ordinary file.
pub(crate) fn single_database(path: &Path) -> io::Result<()> {
    ["", "-wal", "-journal", "-shm"].into_iter().try_for_each(|end| {
        let mut name = path.as_os_str().to_owned();
        name.push(end);
        let (folder, name) = parts(Path::new(&name))?;
        check_single(&folder, &name)
    })
}

/// Writes a page that is kept outside of results folders, and therefore in no list: where there is none of its name, or in the place
/// of one that has all `marks` near its beginning. No link is followed below its folder.
///
/// # Errors
/// Its folder has results, the file in its place lacks a mark or is no ordinary one, or the disk fails.
pub fn write_marked(path: &Path, marks: &[&str], contents: &[u8]) -> Result<(), FolderError> {
    let failed = |source| FolderError::Io { path: path.to_owned(), source };
    if is_results(parent(path)) {
        return Err(FolderError::Within { path: path.to_owned() });
    }
    std::fs::create_dir_all(parent(path)).map_err(failed)?;
    let (folder, name) = parts(path).map_err(failed)?;
    let before = match folder.symlink_metadata(&name) {
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        found => {
            let found = found.map_err(failed)?;
            if let Some(what) = special(&found) {
                return Err(FolderError::Special { path: path.to_owned(), what });
            }
            let mut beginning = Vec::new();
            let before = open(&folder, &name, OpenOptions::new().read(true)).map_err(failed)?;
            before.take(MAX_BEGINNING).read_to_end(&mut beginning).map_err(failed)?;
            let beginning = String::from_utf8_lossy(&beginning);
            if !marks.iter().all(|mark| beginning.contains(mark)) {
                return Err(FolderError::Foreign { path: path.to_owned(), earlier: None });
            }
            Some(Stamp::new(&found))
        }
    };
    write_whole(&folder, &name, before, |file| file.write_all(contents)).map_err(failed)
}

/// Writes a file of which a user gave the name, where there is none of it. It has its place once it is whole.
///
/// # Errors
/// There is one, or it cannot be written.
pub fn write_new(path: &Path, contents: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let (folder, name) = parts(path)?;
    match folder.symlink_metadata(&name) {
        Err(error) if error.kind() == ErrorKind::NotFound => write_whole(&folder, &name, None, contents),
        found => found.and(Err(ErrorKind::AlreadyExists.into())),
    }
}

/// Writes a file beside its place, and puts it there if that is still as it was `before`.
fn write_whole(
    folder: &Dir,
    name: &str,
    before: Option<Stamp>,
    contents: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let partial = partial(name);
    if folder.symlink_metadata(&partial).is_ok_and(|found| found.is_file()) {
        folder.remove_file(&partial)?;
    }
    let mut file = open(folder, &partial, OpenOptions::new().write(true).create_new(true))?;
    let written = contents(&mut file).and_then(|()| file.sync_all());
    written
        .and_then(|()| put_in_place(folder, name, before))
        .inspect_err(|_| drop(folder.remove_file(&partial)))
}

/// Puts what was written beside the place of a file there, if that is still as it was `before`, or empty.
fn put_in_place(folder: &Dir, name: &str, before: Option<Stamp>) -> io::Result<()> {
    match folder.symlink_metadata(name).ok().map(|found| Stamp::new(&found)) {
        None => rename_new(folder, &partial(name), name),
        now if now == before => folder.rename(partial(name), folder, name),
        Some(_) => Err(ErrorKind::AlreadyExists.into()),
    }
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

fn check_single(folder: &Dir, name: &str) -> io::Result<()> {
    let found = match folder.symlink_metadata(name) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        found => found?,
    };
    refuse(name, in_place(&found))
}

/// The folder of a file, and the name of the file. A name that is not UTF-8 is refused, as no text could tell where the file is.
fn parts(path: &Path) -> io::Result<(Dir, String)> {
    let folder = Dir::open_ambient_dir(parent(path), ambient_authority())?;
    let name = path.file_name().unwrap_or_default().to_str();
    let name = name.ok_or_else(|| io::Error::new(ErrorKind::InvalidInput, "its name is not UTF-8"))?;
    Ok((folder, name.to_owned()))
}

/// The folder of a file.
pub(crate) fn parent(path: &Path) -> &Path {
    path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_file_whose_name_is_not_utf_8_is_refused_and_none_is_written_in_its_place() {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt;
        let parent = tempfile::tempdir().unwrap();
        let path = parent.path().join(OsStr::from_bytes(b"\xff.toml"));
        let refused = write_new(&path, |file| file.write_all(b"kind")).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::InvalidInput);
        assert_eq!(std::fs::read_dir(parent.path()).unwrap().count(), 0);
    }

    fn new() -> (tempfile::TempDir, Folder) {
        let parent = tempfile::tempdir().unwrap();
        let folder = Folder::open(&parent.path().join("results")).unwrap();
        (parent, folder)
    }

    /// The folder as the next command opens it.
    fn reopened(folder: Folder) -> Folder {
        let path = folder.path().to_owned();
        drop(folder);
        Folder::open(&path).unwrap()
    }

    fn put(folder: &Folder, name: &str, contents: &[u8]) -> Result<Written, FolderError> {
        let written = folder.write(name, contents)?;
        folder.commit().map(|()| written)
    }

    fn removed(folder: &Folder, name: &str) -> Result<bool, FolderError> {
        let removed = folder.remove(name)?;
        folder.commit().map(|()| removed)
    }

    fn read(folder: &Folder, name: &str) -> String {
        std::fs::read_to_string(folder.path().join(name)).unwrap()
    }

    #[test]
    fn own_files_are_replaced_and_removed_also_by_a_later_command() {
        let (_parent, folder) = new();
        assert_eq!(put(&folder, "inputs/a.toml", b"one").unwrap(), Written::New);
        assert_eq!(put(&folder, "inputs/a.toml", b"one").unwrap(), Written::Same);
        let folder = reopened(folder);
        assert_eq!(put(&folder, "inputs/a.toml", b"two").unwrap(), Written::Replaced);
        assert_eq!(read(&folder, "inputs/a.toml"), "two");
        let digest = folder.write_by("points.csv", |file| file.write_all(b"abc")).unwrap();
        assert_eq!(digest, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        // It has not got its place.
        assert!(!folder.path().join("points.csv").exists());
        folder.commit().unwrap();
        let folder = reopened(folder);
        assert!(removed(&folder, "points.csv").unwrap());
        assert!(!removed(&folder, "points.csv").unwrap());
        assert_eq!(folder.listed(), ["inputs/a.toml"]);
        assert_eq!(std::fs::read_dir(folder.path().join("inputs")).unwrap().count(), 1);
        let list = read(&folder, LIST);
        assert!(!list.contains("\n\n"), "{list}");
    }

    #[test]
    fn files_of_others_stay_and_what_was_changed_belongs_to_who_changed_it() {
        let (_parent, folder) = new();
        put(&folder, "report.html", b"ours").unwrap();
        for (name, text) in [("curve.csv", "mine"), ("report.html", "changed")] {
            std::fs::write(folder.path().join(name), text).unwrap();
            let error = put(&folder, name, b"new").unwrap_err();
            assert!(matches!(error, FolderError::Foreign { earlier: None, .. }), "{name}: {error}");
            assert!(folder.check([(name, None)]).is_err(), "{name}");
            assert_eq!(read(&folder, name), text);
        }
        std::fs::write(folder.path().join("psd.csv.partial"), "mine too").unwrap();
        put(&folder, "psd.csv", b"new").unwrap();
        put(&folder, "psd.csv", b"newer").unwrap();
        assert_eq!(read(&folder, "psd.csv.partial"), "mine too");
        // With the same contents nothing is written.
        assert_eq!(put(&folder, "curve.csv", b"mine").unwrap(), Written::Same);
        assert!(put(&folder, "curve.csv", b"new").is_err());
        let changed = || folder.changed().unwrap().into_iter().collect::<Vec<_>>();
        assert_eq!(changed(), [("report.html".to_owned(), Difference::Changed)]);
        std::fs::remove_file(folder.path().join("report.html")).unwrap();
        assert_eq!(changed(), [("report.html".to_owned(), Difference::Missing)]);
        put(&folder, "report.html", b"newer").unwrap();
        assert_eq!(changed(), []);
        // What is to be removed, and was changed, stays and is no longer listed.
        std::fs::write(folder.path().join("report.html"), "mine").unwrap();
        assert!(!removed(&folder, "report.html").unwrap() && folder.changed().unwrap().is_empty());
        assert_eq!(read(&folder, "report.html"), "mine");
        std::fs::write(folder.path().join("report.html"), "newer").unwrap();
        put(&folder, "report.html", b"newer").unwrap();
        // Only the last one is as it was written.
        std::fs::write(folder.path().join("report.html"), "ours").unwrap();
        assert_eq!(changed(), [("report.html".to_owned(), Difference::Changed)]);
        put(&folder, "report.html", b"ours").unwrap();
        assert_eq!(changed(), []);
    }

    #[test]
    fn where_one_file_is_refused_none_is_replaced() {
        let (_parent, folder) = new();
        for name in ["a.csv", "b.csv", "c.csv"] {
            put(&folder, name, b"old").unwrap();
        }
        folder.write("a.csv", b"new").unwrap();
        folder.write("b.csv", b"new").unwrap();
        folder.remove("c.csv").unwrap();
        std::fs::write(folder.path().join("b.csv"), "edited meanwhile").unwrap();
        assert!(matches!(folder.commit(), Err(FolderError::Foreign { .. })));
        assert_eq!(
            ["a.csv", "b.csv", "c.csv"].map(|name| read(&folder, name)),
            ["old", "edited meanwhile", "old"]
        );
        folder.write("a.csv", b"new").unwrap();
        let folder = reopened(folder);
        assert_eq!(read(&folder, "a.csv"), "old");
        let names = std::fs::read_dir(folder.path()).unwrap();
        assert_eq!(names.filter(|entry| ending_is_partial(entry.as_ref().unwrap())).count(), 0);
    }

    fn ending_is_partial(entry: &std::fs::DirEntry) -> bool {
        entry.file_name().to_string_lossy().ends_with(PARTIAL)
    }

    #[test]
    fn one_command_at_a_time_writes() {
        let (_parent, folder) = new();
        assert!(matches!(Folder::open(folder.path()), Err(FolderError::Lock(StoreError::Busy { .. }))));
        assert!(Folder::read(folder.path()).unwrap().changed().is_none());
        drop(reopened(folder));
    }

    #[test]
    fn a_file_of_another_size_is_not_read() {
        let (_parent, folder) = new();
        put(&folder, "curve.csv", b"ours").unwrap();
        let file = std::fs::File::create(folder.path().join("curve.csv")).unwrap();
        // Reading it would take minutes.
        file.set_len(200 << 30).unwrap();
        let started = std::time::Instant::now();
        assert!(put(&folder, "curve.csv", b"new").is_err() && folder.changed().unwrap().len() == 1);
        assert!(started.elapsed().as_secs() < 5);
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_not_on_the_disk_is_not_read_whatever_its_size() {
        let (_parent, folder) = new();
        put(&folder, "a.csv", b"ours").unwrap();
        let zeros = "0".repeat(64);
        for name in ["a.csv", "b.csv"] {
            folder
                .enter(vec![Entry {
                    name: name.to_owned(),
                    sha256: Some(zeros.clone()),
                    size: (name == "a.csv").then_some(200 << 30),
                    is_adopted: false,
                    is_ahead: false,
                }])
                .unwrap();
            std::fs::File::create(folder.path().join(name)).unwrap().set_len(200 << 30).unwrap();
        }
        let started = std::time::Instant::now();
        assert!(put(&folder, "a.csv", b"new").is_err() && put(&folder, "b.csv", b"new").is_err());
        assert_eq!(folder.changed().unwrap().len(), 2);
        assert!(started.elapsed().as_secs() < 5);
    }

    #[test]
    fn a_list_of_the_form_without_sizes_is_read() {
        let (_parent, folder) = new();
        let digest = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let entries = [
            r#"{"name":"a.csv.partial","sha256":null}"#.to_owned(),
            format!(r#"{{"name":"a.csv","sha256":"{digest}"}}"#),
            format!(r#"{{"name":"gone.csv","sha256":"{digest}"}}"#),
        ];
        let text = format!("{{\"list\":\"{HEAD}\"}}\n\n{}\n", entries.join("\n\n"));
        std::fs::write(folder.path().join(LIST), text).unwrap();
        std::fs::write(folder.path().join("a.csv"), "abc").unwrap();
        let folder = reopened(folder);
        // It does not say what was removed.
        assert!(folder.changed().unwrap().is_empty());
        assert_eq!(put(&folder, "a.csv", b"new").unwrap(), Written::Replaced);
    }

    #[test]
    fn an_input_is_never_an_output() {
        let (_parent, folder) = new();
        put(&folder, "curve.csv", b"ours").unwrap();
        let path = folder.path().join("../results/curve.csv");
        let folder = folder.reading([path.as_path()]);
        assert!(matches!(put(&folder, "curve.csv", b"new"), Err(FolderError::Input { .. })));
        assert_eq!(read(&folder, "curve.csv"), "ours");
    }

    #[test]
    fn what_a_run_that_was_killed_left_is_removed_and_a_torn_list_goes_on() {
        let (_parent, folder) = new();
        put(&folder, "a.csv", b"a").unwrap();
        std::fs::write(folder.path().join(partial("a.csv")), "half").unwrap();
        let list = folder.path().join(LIST);
        let torn = std::fs::read_to_string(&list).unwrap() + "{\"name\":\"b.cs";
        std::fs::write(&list, torn).unwrap();
        let folder = reopened(folder);
        put(&folder, "a.csv", b"b").unwrap();
        put(&folder, "b.csv", b"b").unwrap();
        let folder = reopened(folder);
        assert_eq!([read(&folder, "a.csv"), read(&folder, "b.csv")], ["b", "b"]);
        assert!(put(&folder, "a.csv", b"c").is_ok() && put(&folder, "b.csv", b"c").is_ok());
        assert!(!folder.path().join(partial("a.csv")).exists());
    }

    /// The folder as a command leaves it that is killed once its files are in the list, and the names of those that have their places.
    fn killed(folder: &Folder, placed: &[&str]) {
        let staged = std::mem::take(&mut *folder.staged());
        for (name, change) in folder.entered(&staged).unwrap() {
            if placed.contains(&&*name) {
                folder.put(&name, change).unwrap();
            }
        }
    }

    fn differences(folder: &Folder) -> Vec<(String, Difference)> {
        folder.changed().unwrap().into_iter().collect()
    }

    #[test]
    fn what_a_command_that_was_killed_had_listed_is_unfinished_until_the_next_one_finishes_it() {
        let (_parent, folder) = new();
        for name in ["a.csv", "b.csv", "c.csv"] {
            put(&folder, name, b"old").unwrap();
        }
        for name in ["a.csv", "b.csv", "d.csv"] {
            folder.write(name, b"new").unwrap();
        }
        folder.remove("c.csv").unwrap();
        killed(&folder, &["a.csv"]);
        let folder = reopened(folder);
        let unfinished = |name: &str| (name.to_owned(), Difference::Unfinished);
        assert_eq!(differences(&folder), ["b.csv", "c.csv", "d.csv"].map(unfinished));
        put(&folder, "other.svg", b"drawn").unwrap();
        assert_eq!(["b.csv", "d.csv"].map(|name| read(&folder, name)), ["new", "new"]);
        // What is removed is told by the command that removes it.
        assert_eq!(differences(&folder), [unfinished("c.csv")]);
        assert!(folder.listed().contains(&"c.csv".to_owned()) && removed(&folder, "c.csv").unwrap());
        assert_eq!(differences(&folder), []);
        assert!(!std::fs::read_dir(folder.path()).unwrap().any(|entry| ending_is_partial(&entry.unwrap())));
    }

    #[test]
    fn what_a_command_that_was_killed_wrote_replaces_nothing_of_others() {
        let (_parent, folder) = new();
        put(&folder, "a.csv", b"old").unwrap();
        folder.write("a.csv", b"new").unwrap();
        folder.write("b.csv", b"new").unwrap();
        killed(&folder, &[]);
        let folder = reopened(folder);
        std::fs::write(folder.path().join("a.csv"), "edited").unwrap();
        std::fs::write(folder.path().join(partial("b.csv")), "half").unwrap();
        put(&folder, "other.svg", b"drawn").unwrap();
        assert_eq!(read(&folder, "a.csv"), "edited");
        assert!(!folder.path().join("b.csv").exists());
        assert!(!std::fs::read_dir(folder.path()).unwrap().any(|entry| ending_is_partial(&entry.unwrap())));
    }

    #[test]
    fn a_file_that_comes_between_the_last_look_and_the_change_stays() {
        let (_parent, folder) = new();
        for name in ["old.csv", "gone.csv", "away.csv"] {
            put(&folder, name, b"old").unwrap();
        }
        for name in ["old.csv", "new.csv", "gone.csv"] {
            folder.write(name, b"new").unwrap();
        }
        folder.remove("away.csv").unwrap();
        let staged = std::mem::take(&mut *folder.staged());
        let entered = folder.entered(&staged).unwrap();
        for name in ["old.csv", "new.csv", "away.csv"] {
            std::fs::write(folder.path().join(name), "mine").unwrap();
        }
        std::fs::remove_file(folder.path().join("gone.csv")).unwrap();
        for (name, change) in entered {
            let is_put = folder.put(&name, change).is_ok();
            assert_eq!(is_put, ["gone.csv", "away.csv"].contains(&&*name), "{name}");
            assert_eq!(read(&folder, &name), if name == "gone.csv" { "new" } else { "mine" });
        }
        let (partial, new) = (partial("new.csv"), "new.csv");
        let error = rename_new(&folder.root, &partial, new).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::AlreadyExists);
    }

    #[test]
    fn a_file_is_unfinished_while_those_that_are_made_of_it_are_not_written() {
        let (_parent, folder) = new();
        put(&folder, "study.toml", b"old").unwrap();
        put(&folder, "report.html", b"old").unwrap();
        folder.write_ahead("study.toml", b"new").unwrap();
        folder.commit().unwrap();
        let folder = reopened(folder);
        let unfinished = [("study.toml".to_owned(), Difference::Unfinished)];
        assert_eq!(differences(&folder), unfinished);
        put(&folder, "drawn.svg", b"drawn").unwrap();
        assert_eq!(differences(&folder), unfinished);
        folder.write("study.toml", b"new").unwrap();
        folder.write("report.html", b"new").unwrap();
        folder.commit().unwrap();
        assert_eq!(differences(&folder), []);
    }

    #[test]
    fn a_name_as_long_as_file_systems_take_is_written() {
        let (_parent, folder) = new();
        let name = "n".repeat(MAX_COMPONENT);
        put(&folder, &name, b"one").unwrap();
        assert_eq!(put(&folder, &name, b"two").unwrap(), Written::Replaced);
        assert_eq!(read(&folder, &name), "two");
    }

    #[test]
    fn a_new_file_is_whole_or_is_not_there() {
        let parent = tempfile::tempdir().unwrap();
        let path = parent.path().join("record.csv");
        let full = |file: &mut dyn Write| file.write_all(b"half").and(Err(ErrorKind::StorageFull.into()));
        assert_eq!(write_new(&path, full).unwrap_err().kind(), ErrorKind::StorageFull);
        assert_eq!(std::fs::read_dir(parent.path()).unwrap().count(), 0);
        let late = |file: &mut dyn Write| {
            std::fs::write(&path, "mine")?;
            file.write_all(b"ours")
        };
        for _ in 0..2 {
            assert_eq!(write_new(&path, late).unwrap_err().kind(), ErrorKind::AlreadyExists);
            assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
        }
        assert_eq!(std::fs::read_dir(parent.path()).unwrap().count(), 1);
        std::fs::remove_file(&path).unwrap();
        write_new(&path, |file| file.write_all(b"ours")).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "ours");
    }

    #[test]
    fn a_name_that_no_file_can_have_is_one_fault_among_others() {
        let (_parent, folder) = new();
        put(&folder, "a.csv", b"ours").unwrap();
        let names = ["", "..", "../a.csv", "n\0", &"n".repeat(MAX_NAME)];
        for name in names {
            let (name, sha256, size) = (name.to_owned(), Some(String::new()), Some(1));
            folder.enter(vec![Entry { name, sha256, size, is_adopted: false, is_ahead: false }]).unwrap();
        }
        std::fs::write(folder.path().join("a.csv"), "edited").unwrap();
        let folder = reopened(folder);
        let found = differences(&folder);
        assert_eq!(found.len(), names.len() + 1, "{found:?}");
        assert!(found.contains(&("a.csv".to_owned(), Difference::Changed)));
        folder.forget_missing().unwrap();
        put(&folder, "b.csv", b"ours").unwrap();
    }

    #[test]
    fn a_list_that_is_too_long_is_neither_read_in_part_nor_written() {
        let (_parent, folder) = new();
        put(&folder, "a.csv", b"ours").unwrap();
        let grown = |size: u64| {
            let list = std::fs::File::options().write(true).open(folder.path().join(LIST)).unwrap();
            list.set_len(size).unwrap();
        };
        grown(MAX_LIST);
        assert!(put(&folder, "b.csv", b"ours").unwrap_err().to_string().contains("more than 64 MiB"));
        assert_eq!(std::fs::metadata(folder.path().join(LIST)).unwrap().len(), MAX_LIST);
        assert!(!folder.path().join("b.csv").exists());
        grown(MAX_LIST + 1);
        assert!(Folder::read(folder.path()).unwrap_err().to_string().contains("move it away"));
    }

    #[test]
    fn files_that_are_gone_can_be_forgotten() {
        let (_parent, folder) = new();
        put(&folder, "drawn.svg", b"drawn").unwrap();
        put(&folder, "report.html", b"page").unwrap();
        std::fs::remove_file(folder.path().join("drawn.svg")).unwrap();
        assert_eq!(differences(&folder), [("drawn.svg".to_owned(), Difference::Missing)]);
        folder.forget_missing().unwrap();
        folder.commit().unwrap();
        let folder = reopened(folder);
        assert_eq!(differences(&folder), []);
        assert_eq!(folder.listed(), ["report.html"]);
        // One that was changed is the user's once it is to be removed.
        std::fs::write(folder.path().join("report.html"), "edited").unwrap();
        assert!(!removed(&folder, "report.html").unwrap());
        assert_eq!((differences(&folder), read(&folder, "report.html")), (vec![], "edited".to_owned()));
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_in_the_place_of_one_to_be_removed_stays() {
        let (_parent, folder) = new();
        put(&folder, "chart-2.svg", b"drawn").unwrap();
        let path = folder.path().join("chart-2.svg");
        std::fs::remove_file(&path).unwrap();
        std::os::unix::fs::symlink("elsewhere", &path).unwrap();
        assert!(!removed(&folder, "chart-2.svg").unwrap());
        assert!(path.is_symlink() && differences(&folder).is_empty());
    }

    #[test]
    fn a_folder_of_an_earlier_version_is_taken_over_by_name_only() {
        let (_parent, folder) = new();
        for name in ["card.json", "report.html", "letter.txt"] {
            std::fs::write(folder.path().join(name), "{}").unwrap();
        }
        let folder = reopened(folder);
        assert!(matches!(
            put(&folder, "report.html", b"new"),
            Err(FolderError::Foreign { earlier: Some(_), .. })
        ));
        assert_eq!(
            folder.adopt(|name| !["letter.txt", LOCK].contains(&name)).unwrap(),
            ["card.json", "report.html"]
        );
        assert!(put(&folder, "report.html", b"new").is_ok() && put(&folder, "letter.txt", b"new").is_err());
    }

    #[test]
    fn adopted_files_are_replaced_but_never_removed_and_are_adopted_once() {
        let (_parent, folder) = new();
        for name in ["card.json", "noise.toml", "noise_of_unit7.toml"] {
            std::fs::write(folder.path().join(name), "{}").unwrap();
        }
        // Whoever found nothing has adopted all there was.
        let (_other, empty) = new();
        std::fs::write(empty.path().join("card.json"), "{}").unwrap();
        let empty = reopened(empty);
        assert!(empty.adopt(|_| false).unwrap().is_empty() && !empty.can_adopt());
        std::fs::write(empty.path().join("report.html"), "mine").unwrap();
        assert!(reopened(empty).adopt(|_| true).unwrap().is_empty());
        // A list that is begun late does not have them.
        let folder = reopened(folder);
        put(&folder, "redrawn.svg", b"ours").unwrap();
        let folder = reopened(folder);
        assert_eq!(
            folder.adopt(|name| ![LIST, LOCK].contains(&name)).unwrap(),
            ["card.json", "noise.toml", "noise_of_unit7.toml"]
        );
        let folder = reopened(folder);
        assert!(!removed(&folder, "noise_of_unit7.toml").unwrap());
        assert_eq!(read(&folder, "noise_of_unit7.toml"), "{}");
        put(&folder, "noise.toml", b"new").unwrap();
        assert!(removed(&folder, "noise.toml").unwrap());
        // What comes later is no file of an earlier version.
        std::fs::write(folder.path().join("card.json"), "edited").unwrap();
        std::fs::write(folder.path().join("noise_x.toml"), "mine").unwrap();
        assert!(folder.adopt(|_| true).unwrap().is_empty());
        assert!(matches!(put(&folder, "card.json", b"new"), Err(FolderError::Foreign { earlier: None, .. })));
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
            assert!(put(&folder, name, b"new").is_err(), "{name}");
            assert!(!matches!(removed(&folder, name), Ok(true)), "{name}");
        }
        symlink(victim.join("new.csv"), folder.path().join(partial("new.csv"))).unwrap();
        assert!(put(&folder, "new.csv", b"new").is_err());
        put(&folder, "own.csv", b"own").unwrap();
        // Within results a folder is none of the user's choice.
        symlink(&victim, folder.path().join("shard-1-of-2")).unwrap();
        assert!(matches!(
            Folder::open(&folder.path().join("shard-1-of-2")),
            Err(FolderError::Special { .. })
        ));
        assert_eq!(std::fs::read_dir(&victim).unwrap().count(), 1);
        // The list is written in place.
        std::fs::hard_link(folder.path().join(LIST), victim.join("list")).unwrap();
        let path = folder.path().to_owned();
        drop(folder);
        assert!(matches!(Folder::open(&path), Err(FolderError::Special { what: HARD_LINK, .. })));
        assert!(Folder::read(&path).unwrap().changed().unwrap().is_empty());
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
        put(&folder, "inputs/a.toml", b"0").unwrap();
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
                    ["inputs/a.toml", "points.csv"].map(|name| put(&folder, name, text.as_bytes()).is_ok());
                u32::from(done[0]) + u32::from(done[1])
            };
            let written: u32 = (1..=1000).map(write).sum();
            is_done.store(true, Ordering::Relaxed);
            written
        });
        assert!(written > 0);
        assert_eq!(std::fs::read_to_string(victim.join("a.toml")).unwrap(), "mine");
        assert_eq!(std::fs::read_dir(&victim).unwrap().count(), 1);
        // Whole, unless its folder was removed above while a new one stood in its place.
        if let Ok(text) = std::fs::read_to_string(place("inputs/a.toml")) {
            assert!(text.parse::<u32>().is_ok(), "{text}");
        }
    }
}
