//! Storage of a study with its results.

use std::io::Error;
use std::path::{Path, PathBuf};

use crate::run::RESOLVED;
use crate::source::text_file::{MOST_RECORD, read_bytes};
use crate::store::whole::write_whole;
use crate::study::Study;

/// Why a study could not be stored: the folder of its results cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct KeepError {
    /// The path that could not be written.
    pub path: PathBuf,
    /// The cause.
    pub source: Error,
}

/// Stores a study in the folder of its results, with the files that it names as they were when it was read, so that the
/// results can be merged, repeated and moved as a whole. Returns the names of files whose earlier contents were
/// different, as of a study that was run there before.
///
/// # Errors
/// A file cannot be written.
pub fn keep(study: &Study, folder: &Path) -> Result<Vec<String>, KeepError> {
    let mut replaced = Vec::new();
    for input in study.inputs() {
        let path = folder.join(&input.name);
        match read_bytes(&path, MOST_RECORD) {
            // The file may be the one from which the study was read.
            Ok(there) if there == input.text.as_bytes() => continue,
            Ok(_) => replaced.push(input.name.clone()),
            Err(_) => {}
        }
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)
                .map_err(|source| KeepError { path: parent.to_owned(), source })?;
        }
        write_whole(&path, input.text.as_bytes()).map_err(|source| KeepError { path, source })?;
    }
    let path = folder.join(RESOLVED);
    let text = study.resolved(study.trials);
    write_whole(&path, text.as_bytes()).map_err(|source| KeepError { path, source })?;
    Ok(replaced)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn study(folder: &Path, text: &str) -> Study {
        let path = folder.join("study.toml");
        std::fs::write(&path, text).unwrap();
        Study::read(&path).unwrap()
    }

    #[test]
    fn a_study_that_is_kept_needs_nothing_else() {
        let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let [here, there] = folders.each_ref().map(tempfile::TempDir::path);
        std::fs::create_dir_all(here.join("gyros")).unwrap();
        for (name, n) in [("a", 0.001), ("b", 0.002)] {
            let noise = format!("angle_random_walk = \"{n} deg/sqrt(h)\"\n");
            std::fs::write(here.join(format!("gyros/{name}.toml")), noise).unwrap();
        }
        let text = "title = \"Two\" # gyros\nkind = \"allan\"\ntrials = 8\n[record]\nsample = \"1 s\"\nlength = \"1 h\"\n[allan]\n\
                    tau = \"octave\"\n[noise]\n[[sweep]]\nkey = \"noise.file\"\nlist = [\"gyros/a.toml\", \"gyros/b.toml\"]\n";
        let first = study(here, text);
        assert!(keep(&first, there).unwrap().is_empty());
        let kept = std::fs::read_to_string(there.join(RESOLVED)).unwrap();
        assert!(kept.contains("list = [\"inputs/a.toml\", \"inputs/b.toml\"]"), "{kept}");
        assert!(kept.contains("# gyros") && !kept.contains(&*here.to_string_lossy()), "{kept}");
        // The original is deleted; the stored copy remains where it is and is the same study.
        drop(std::fs::remove_dir_all(here));
        let second = Study::read(&there.join(RESOLVED)).unwrap();
        assert!(keep(&second, there).unwrap().is_empty());
        assert_eq!(second.resolved(8), kept);
        let noise = |study: &Study| {
            study
                .asked::<crate::kinds::allan::Allan>()
                .unwrap()
                .points
                .iter()
                .map(|point| point.inputs.noise.clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(noise(&first), noise(&second));
        // The stored copy is what was read, whatever happened to the file since.
        std::fs::remove_file(there.join("inputs/a.toml")).unwrap();
        std::fs::write(there.join("inputs/b.toml"), "").unwrap();
        assert_eq!(keep(&first, there).unwrap(), ["inputs/b.toml"]);
        assert_eq!(noise(&Study::read(&there.join(RESOLVED)).unwrap()), noise(&first));
        std::fs::write(there.join("file"), "").unwrap();
        let error = keep(&first, &there.join("file")).unwrap_err();
        assert!(error.to_string().contains("cannot write"), "{error}");
    }
}
