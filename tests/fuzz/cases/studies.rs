//! Study files: whatever they hold, they are refused in words, or every point of them is lowered.

use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};

use sagnac::device::{Cpu, Device};
use sagnac::progress::Silent;
use sagnac::run::{Plan, RESOLVED, keep};
use sagnac::store::Store;
use sagnac::store::folder::Folder;
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac_base::diagnostics::StudyError;
use sagnac_engine::kinds::allan::Allan;
use sagnac_engine::kinds::switched_run::SwitchedRun;
use sagnac_kernel::width::Width;

use super::Outcome;

/// Most points that are lowered.
const MAX_POINTS: usize = 40;

/// Trials that are sampled of a study that is accepted.
const TRIALS: u64 = 2;

/// The name of every study, beside those that are shipped, so that the files they name are found.
pub fn name() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = package.ancestors().find(|folder| folder.join("studies").is_dir());
    root.unwrap_or(package).join("studies/fuzzed.toml")
}

/// Reads a study, lowers its points, and samples some trials of a cheap one.
///
/// # Panics
/// The study shows a fault of the library.
pub fn run(bytes: &[u8]) -> Vec<Outcome> {
    let outcome = match read(bytes) {
        // The time that it takes goes by the points, and is no surprise.
        Ok(study) if points(&study) > MAX_POINTS => Ok(format!("{} of many points", study.kind().name)),
        Ok(study) => planned(&study),
        Err(error) => Err(error),
    };
    vec![match outcome {
        Ok(kind) => Outcome::Accepted(kind),
        Err(error) => {
            let report = error.render(false, 110);
            assert!(!error.to_string().trim().is_empty() && report.contains("help"), "no help in\n{report}");
            Outcome::Refused(error.to_string())
        }
    }]
}

/// Points of the study, those that are fitted counted as several.
fn points(study: &Study) -> usize {
    let weight = match study.asked::<Allan>() {
        Some(allan) if allan.terms.is_some() => 8,
        Some(_) => 2,
        None => 1,
    };
    weight * study.sweeps.iter().map(|sweep| sweep.values.len()).product::<usize>()
}

fn read(bytes: &[u8]) -> Result<Study, StudyError> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Study::parse(&name().to_string_lossy(), text),
        Err(_) => {
            let file = tempfile::NamedTempFile::new().unwrap();
            std::fs::write(file.path(), bytes).unwrap();
            Err(Study::read(file.path()).expect_err("it is no UTF-8"))
        }
    }
}

/// The study as it is kept.
fn resolved(study: &Study) -> Result<Study, StudyError> {
    if study.inputs().is_empty() {
        return Study::parse("elsewhere/resolved_study.toml", &study.resolved(study.trials));
    }
    let folder = tempfile::tempdir().unwrap();
    keep(study, &Folder::open(folder.path()).unwrap()).unwrap();
    Study::read(&folder.path().join(RESOLVED))
}

/// Lowers all points, and those of the study as it is resolved, which has to be the same one.
fn planned(study: &Study) -> Result<String, StudyError> {
    let plan = Plan::new(study)?;
    let tables = plan.blank_tables();
    let again = resolved(study).unwrap_or_else(|error| panic!("as resolved:\n{}", error.render(false, 110)));
    let same = Plan::new(&again).unwrap_or_else(|error| panic!("as resolved:\n{}", error.render(false, 110)));
    assert_eq!((same.identity(), again.trials), (plan.identity(), study.trials));
    // Numbers that are none differ from themselves.
    assert_eq!(format!("{:?}", same.blank_tables()), format!("{tables:?}"));
    if is_cheap(study) && tables.points.rows() <= 16 {
        sample(study);
    }
    Ok(study.kind().name.to_owned())
}

/// Whether a few trials take no time worth naming.
fn is_cheap(study: &Study) -> bool {
    let records = study
        .asked::<Allan>()
        .map(|allan| allan.points.iter().map(|point| point.inputs.samples()).sum::<u64>());
    let runs = study
        .asked::<SwitchedRun>()
        .map(|runs| runs.points.iter().map(|point| point.switches()).sum::<u64>());
    !study.kind().is_exact
        && records.is_none_or(|samples| samples < 50_000)
        && runs.is_none_or(|switches| switches < 5_000)
}

/// Runs the study with some trials, and makes its tables.
fn sample(study: &Study) {
    static DEVICE: LazyLock<Mutex<Device>> =
        LazyLock::new(|| Mutex::new(Device::Cpu(Cpu::new(Width::widest(), 1).expect("a thread"))));
    let mut study = study.clone();
    study.trials = TRIALS;
    // Another number of trials may be refused, of whole replays of a record.
    let Ok(plan) = Plan::new(&study) else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &plan.identity()).unwrap();
    let mut device = DEVICE.lock().unwrap_or_else(PoisonError::into_inner);
    plan.run(&mut store, &mut device, Share::WHOLE, &Silent).unwrap();
    let (rows, blank) =
        (plan.tables(&store, &Silent).unwrap().points.rows(), plan.blank_tables().points.rows());
    assert_eq!(rows, blank, "rows with trials and without");
    let index = store.index().unwrap();
    plan.notes(&store, &index, plan.held(&index).unwrap()).unwrap();
}
