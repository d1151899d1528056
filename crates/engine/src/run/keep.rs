//! Storage of a study with its results.

use std::path::Path;

use crate::run::RESOLVED;
use crate::store::folder::{Folder, FolderError, Written};
use crate::study::Study;
use crate::study::kept::INPUTS;

/// Stores a study in the folder of its results, with the files that it names as they were when it was read, so that the
/// results can be merged, repeated and moved as a whole. Returns the names of files whose earlier contents were
/// different, as of a study that was run there before. Results of such a study make the folder unfinished until the study is
/// written again with its own.
///
/// # Errors
/// A file cannot be written.
pub fn keep(study: &Study, folder: &Folder) -> Result<Vec<String>, FolderError> {
    folder.forget_missing()?;
    let replaced = write_inputs(study, folder)?;
    let text = study.resolved(study.trials);
    let is_same = folder.write(RESOLVED, text.as_bytes())? == Written::Same && replaced.is_empty();
    let is_result = |name: &String| {
        name != RESOLVED && !Path::new(name).starts_with(INPUTS) && folder.path().join(name).is_file()
    };
    if !is_same && folder.listed().iter().any(is_result) {
        folder.write_ahead(RESOLVED, text.as_bytes())?;
    }
    folder.commit()?;
    Ok(replaced)
}

/// Adds what folders of earlier versions lack: the files that the study of a folder names, under their names there. They take
/// their places when the folder is committed.
///
/// # Errors
/// A file cannot be written.
pub fn complete(study: &Study, folder: &Folder) -> Result<(), FolderError> {
    folder.forget_missing()?;
    write_inputs(study, folder)?;
    let text = study.resolved(study.trials);
    if text != study.text() {
        folder.write(RESOLVED, text.as_bytes())?;
    }
    Ok(())
}

/// Writes the files that a study names, and returns the names of those that were different.
fn write_inputs(study: &Study, folder: &Folder) -> Result<Vec<String>, FolderError> {
    let mut replaced = Vec::new();
    for input in study.inputs() {
        if folder.write(&input.name, input.text.as_bytes())? == Written::Replaced {
            replaced.push(input.name.clone());
        }
    }
    Ok(replaced)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn results(folder: &Path) -> Folder {
        Folder::open(folder).unwrap()
    }

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
        assert!(keep(&first, &results(there)).unwrap().is_empty());
        let kept = std::fs::read_to_string(there.join(RESOLVED)).unwrap();
        assert!(kept.contains("list = [\"inputs/a.toml\", \"inputs/b.toml\"]"), "{kept}");
        assert!(kept.contains("# gyros") && !kept.contains(&*here.to_string_lossy()), "{kept}");
        // The original is deleted; the stored copy remains where it is and is the same study.
        drop(std::fs::remove_dir_all(here));
        let second = Study::read(&there.join(RESOLVED)).unwrap();
        assert!(keep(&second, &results(there)).unwrap().is_empty());
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
        assert!(keep(&first, &results(there)).unwrap().is_empty());
        assert_eq!(noise(&Study::read(&there.join(RESOLVED)).unwrap()), noise(&first));
        // What somebody else wrote there stays.
        std::fs::write(there.join("inputs/b.toml"), "").unwrap();
        let error = keep(&first, &results(there)).unwrap_err().to_string();
        assert!(error.contains("b.toml is not as sagnac wrote it"), "{error}");
        assert_eq!(std::fs::read(there.join("inputs/b.toml")).unwrap(), b"");
    }
}
