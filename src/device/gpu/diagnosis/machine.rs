//! The files and the environment of a machine, or those that a test lays out.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Folders in which the dynamic linker looks without being told.
const LIBRARIES: [&str; 5] = ["/lib", "/usr/lib", "/lib64", "/usr/lib64", "/usr/local/lib"];

/// A machine with its devices and drivers.
pub(super) struct Machine {
    /// The folder that contains all its files.
    pub(super) root: PathBuf,
    /// Variables of the environment.
    pub(super) variables: HashMap<String, String>,
    /// Whether this process may use a device.
    pub(super) may_open: fn(&Path) -> bool,
}

impl Machine {
    /// The machine on which this program runs.
    pub(super) fn own() -> Machine {
        let texts = |(name, value): (std::ffi::OsString, std::ffi::OsString)| {
            Some((name.into_string().ok()?, value.into_string().ok()?))
        };
        Machine {
            root: PathBuf::from("/"),
            variables: std::env::vars_os().filter_map(texts).collect(),
            may_open: |path| {
                let opened = std::fs::File::options().read(true).write(true).open(path);
                !opened.is_err_and(|error| error.kind() == std::io::ErrorKind::PermissionDenied)
            },
        }
    }

    pub(super) fn path(&self, path: &str) -> PathBuf {
        self.root.join(path.trim_start_matches('/'))
    }

    /// Whether a file exists; a link to nothing does not.
    pub(super) fn has(&self, path: &str) -> bool {
        self.path(path).exists()
    }

    /// The contents of a file; empty where it cannot be read.
    pub(super) fn text(&self, path: &str) -> String {
        std::fs::read_to_string(self.path(path)).unwrap_or_default()
    }

    /// The names in a folder, sorted; none where it cannot be read.
    pub(super) fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).into_iter().flatten().flatten();
        let mut names: Vec<String> =
            entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort();
        names
    }

    /// The last part of the path to which a link points.
    pub(super) fn link(&self, path: &str) -> Option<String> {
        let to = std::fs::read_link(self.path(path)).ok()?;
        to.file_name()?.to_str().map(str::to_owned)
    }

    /// The value of a variable; empty where it is not set.
    pub(super) fn variable(&self, name: &str) -> &str {
        self.variables.get(name).map_or("", String::as_str)
    }

    /// The group that owns a file: its name, or its number where it has none.
    #[cfg(unix)]
    pub(super) fn group(&self, path: &str) -> Option<String> {
        let number = std::os::unix::fs::MetadataExt::gid(&self.path(path).metadata().ok()?).to_string();
        let groups = self.text("/etc/group");
        let name = groups.lines().find_map(|line| {
            let fields: Vec<&str> = line.split(':').collect();
            (fields.get(2) == Some(&number.as_str())).then(|| fields[0].to_owned())
        });
        Some(name.unwrap_or(number))
    }

    #[cfg(not(unix))]
    pub(super) fn group(&self, _: &str) -> Option<String> {
        None
    }

    /// Whether this process runs in a container.
    pub(super) fn is_container(&self) -> bool {
        ["/.dockerenv", "/run/.containerenv", "/.singularity.d"].iter().any(|file| self.has(file))
            || ["NVIDIA_VISIBLE_DEVICES", "KUBERNETES_SERVICE_HOST"]
                .iter()
                .any(|name| !self.variable(name).is_empty())
    }

    /// The folders in which the dynamic linker looks.
    fn library_folders(&self) -> Vec<String> {
        let mut folders: Vec<String> =
            self.variable("LD_LIBRARY_PATH").split(':').map(str::to_owned).collect();
        let files = self.names("/etc/ld.so.conf.d").into_iter().map(|name| format!("ld.so.conf.d/{name}"));
        for file in std::iter::once("ld.so.conf".to_owned()).chain(files) {
            let text = self.text(&format!("/etc/{file}"));
            folders.extend(text.lines().filter(|line| line.starts_with('/')).map(str::to_owned));
        }
        for folder in LIBRARIES {
            folders.extend([folder.to_owned(), format!("{folder}/{}-linux-gnu", std::env::consts::ARCH)]);
        }
        folders.retain(|folder| !folder.is_empty());
        folders
    }

    /// Whether the dynamic linker finds a library by its name, or by its path.
    pub(super) fn has_library(&self, name: &str) -> bool {
        if name.contains('/') {
            return self.has(name);
        }
        self.library_folders().iter().any(|folder| self.has(&format!("{folder}/{name}")))
    }

    /// The ends of the names of the libraries that begin with `start`.
    pub(super) fn libraries(&self, start: &str) -> Vec<String> {
        let names = self.library_folders().into_iter().flat_map(|folder| self.names(&folder));
        names.filter_map(|name| name.strip_prefix(start).map(str::to_owned)).collect()
    }
}
