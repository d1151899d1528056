//! Running a study: missing trials are sampled and added to the store, then everything stored is tabulated; and storage of the
//! study with its results.

use std::collections::HashSet;

use crate::device::Device;
use crate::sampling;
use crate::sampling::batches::drive;
pub use crate::sampling::batches::{Batch, Budget, Steps};
pub use crate::sampling::{RunError, RunStats, Tables, Worker};
use crate::store::error::StoreError;
#[cfg(feature = "store")]
use crate::store::folder::{Folder, FolderError, Written};
use crate::store::{Identity, Index, Store};
#[cfg(feature = "store")]
use crate::study::INPUTS;
use crate::study::Study;
use crate::tally::{Id, Share};
use sagnac_base::diagnostics::StudyError;
use sagnac_base::progress::{Progress, Silent};
use sagnac_base::table::Table;
#[cfg(feature = "store")]
use std::path::Path;

/// A study whose points are all proven to fit.
#[derive(Debug)]
pub struct Plan<'a> {
    study: &'a Study,
    work: Box<dyn sampling::Plan + 'a>,
}

/// The name of the study file beside its results, which repeats the run.
pub const RESOLVED: &str = "resolved_study.toml";

impl<'a> Plan<'a> {
    /// Lowers every point.
    ///
    /// # Errors
    /// A point cannot be represented; the error points at the key to change.
    pub fn new(study: &'a Study) -> Result<Plan<'a>, StudyError> {
        let plan = Plan::watched(study, &Silent)?;
        Ok(plan.unwrap_or_else(|| unreachable!("nothing asks to stop")))
    }

    /// Lowers every point, in parallel. `progress` receives the number of points and each as it is lowered. `None` if it
    /// asks to stop before that.
    ///
    /// # Errors
    /// A point cannot be represented; the error is that of the first such point and points at the key to change.
    pub fn watched(study: &'a Study, progress: &dyn Progress) -> Result<Option<Plan<'a>>, StudyError> {
        Ok(study.subject.plan(study, progress)?.map(|work| Plan { study, work }))
    }

    /// The study.
    pub fn study(&self) -> &'a Study {
        self.study
    }

    /// Whether there is anything to sample, for which a device is needed.
    pub fn is_sampled(&self) -> bool {
        !self.study.kind().is_exact
    }

    /// The identity of the results, which ties them to this study.
    pub fn identity(&self) -> Identity {
        Identity {
            kind: self.study.kind().name.to_owned(),
            seed: self.study.seed,
            streams: self.study.streams.name().to_owned(),
            kernels: (self.study.kind().kernels)(),
        }
    }

    /// Samples the trials that the store lacks of a share. `progress` receives the total, and the work done as it
    /// completes; work of earlier runs counts as done.
    ///
    /// A GPU that fails does not end a run: it takes smaller tiles when memory runs out, is opened again when it is
    /// lost, and where neither helps it leaves its group, or, as the last or only device, `device` becomes the CPU. The
    /// results are the same bits; [`RunStats::degraded`] describes the failures.
    ///
    /// # Errors
    /// The disk fails, or the device fails and no threads can be started for the CPU to replace it. Trials sampled
    /// before are in the store.
    pub fn run(
        &self,
        store: &mut Store,
        device: &mut Device,
        share: Share,
        progress: &dyn Progress,
    ) -> Result<RunStats, RunError> {
        let mut worker = Worker::new(device, progress);
        let mut steps = self.steps(store, share)?;
        let done = drive(&mut *steps, store, &mut worker, progress)?;
        if !done.stopped {
            self.keep(store, share)?;
        }
        Ok(RunStats { degraded: worker.into_notes(), ..done })
    }

    /// The steps of [`run`](Plan::run), for a driver of its own, such as a page in a browser: it takes batches by
    /// [`Steps::next`], puts their results into the store by [`Batch::put`], and ends with [`keep`](Plan::keep). Nothing of
    /// the results depends on the driver.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn steps<'p>(&'p self, store: &Store, share: Share) -> Result<Box<dyn Steps + 'p>, StoreError> {
        self.work.steps(store, share)
    }

    /// Stores what a share keeps besides tallies, after all its steps.
    ///
    /// # Errors
    /// The disk fails.
    pub fn keep(&self, store: &mut Store, share: Share) -> Result<(), RunError> {
        self.work.keep(store, share)
    }

    /// Whether the number of sampled trials exceeds that of all points together. This happens because estimates of a
    /// point that are not sampled together count separately.
    pub fn counts_again(&self, sampled: u64) -> bool {
        sampled > self.work.all_trials()
    }

    /// Number of trials that the store still lacks of a share, over all points.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        let mut steps = self.steps(store, share)?;
        while steps.missing_trials() == 0 && steps.more(store)? {}
        Ok(steps.missing_trials() + self.work.lacks_kept(store, share)?)
    }

    /// Number of steps of one trial of every point; `None` where records are sampled instead of trials, or nothing.
    pub fn steps_of_a_trial(&self) -> Option<u64> {
        self.work.steps_of_a_trial()
    }

    /// The tables before anything is sampled, with all rows but without estimates.
    pub fn blank_tables(&self) -> Tables {
        let nothing = Tables::of_points(Table::default());
        self.work.tables(None, &Silent).unwrap_or(nothing)
    }

    /// The tables of all stored estimates; `progress` receives numbers of fits.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn tables(&self, store: &Store, progress: &dyn Progress) -> Result<Tables, RunError> {
        self.work.tables(Some(store), progress)
    }

    /// The number of trials for a study that repeats this one: that of all points, where it is the same for all and
    /// exceeds the requested number, else the latter.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn held(&self, index: &Index) -> Result<u64, StoreError> {
        Ok(self.work.held(index)?.unwrap_or(0).max(self.study.trials))
    }

    /// Notes attached to the results, each a sentence. `index` is that of the store, and `held` the result of
    /// [`Plan::held`].
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn notes(&self, store: &Store, index: &Index, held: u64) -> Result<Vec<String>, StoreError> {
        let mut notes = self.study.notes.clone();
        notes.extend(self.work.notes(store)?);
        if held > self.study.trials {
            let why = self.work.surplus();
            notes.push(format!("{held} trials per point instead of {}: {why}", self.study.trials));
        }
        let points = index.points();
        let asked: HashSet<Id> = self.work.ids().into_iter().collect();
        match points.iter().filter(|id| !asked.contains(id)).count() {
            0 => {}
            1 => notes.push(
                "1 point of earlier runs is kept but not shown: the study no longer contains it".to_owned(),
            ),
            n => notes.push(format!(
                "{n} points of earlier runs are kept but not shown: the study no longer contains them"
            )),
        }
        Ok(notes)
    }
}

/// Stores a study in the folder of its results, with the files that it names as they were when it was read, so that the
/// results can be merged, repeated and moved as a whole. Returns the names of files whose earlier contents were
/// different, as of a study that was run there before. Results of such a study make the folder unfinished until the study is
/// written again with its own.
///
/// # Errors
/// A file cannot be written.
#[cfg(feature = "store")]
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
#[cfg(feature = "store")]
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
///
/// # Errors
/// A file cannot be written.
#[cfg(feature = "store")]
pub fn write_inputs(study: &Study, folder: &Folder) -> Result<Vec<String>, FolderError> {
    let mut replaced = Vec::new();
    for input in study.inputs() {
        if folder.write(&input.name, input.text.as_bytes())? == Written::Replaced {
            replaced.push(input.name.clone());
        }
    }
    Ok(replaced)
}

#[cfg(all(test, feature = "store"))]
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
