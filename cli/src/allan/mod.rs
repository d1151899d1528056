//! `sagnac allan`.

pub mod options;

use std::path::{Path, PathBuf};

use sagnac::analysis::log::report;
use sagnac::analysis::whole::Whole;
use sagnac::record::log::read::Request;
use sagnac::report::page::document::json;
use sagnac::store::folder::Folder;

pub use crate::allan::options::Options;
use crate::failure::Failure;
use crate::limits;
use crate::outcome::Outcome;
use crate::output::{print_documents, write_new};

/// The files of the command, of which stars stand for names of columns and units.
const NAMES: [&str; 22] = [
    "curve.csv",
    "coefficients.csv",
    "events.csv",
    "psd.csv",
    "lines.csv",
    "white_noise.csv",
    "temperature.csv",
    "compensation.csv",
    "dynamic.csv",
    "stationarity.csv",
    "limits.csv",
    "navigation.csv",
    "noise*.toml",
    "navigation*.toml",
    "chart",
    "chart-accelerometers",
    "chart-numbers",
    "chart-tdev*",
    "chart-temperature*",
    "chart-rate*",
    "chart-dynamic*",
    "psd*",
];

/// Analyses the logs one after the other.
pub fn allan(options: &Options) -> Result<(), Failure> {
    let request = options.reading.request()?;
    options.check()?;
    let folders = folders(options)?;
    let mut documents: Vec<String> = Vec::new();
    let mut earlier = vec![];
    for (path, folder) in options.files.iter().zip(&folders) {
        documents.extend(of_log(options, &request, path, folder, &mut earlier)?);
    }
    print_documents(&documents, options.files.len())
}

/// Analyses a log and writes its results; prints them, or returns them as JSON. Notes columns that are those of an `earlier` log.
fn of_log(
    options: &Options,
    request: &Request,
    path: &Path,
    folder: &Path,
    earlier: &mut Vec<(u64, String)>,
) -> Result<Option<String>, Failure> {
    let treatment = options.reading.treatment();
    let (log, temperature) = options.reading.read_as_recorded(path, request)?;
    options.check_record(&log)?;
    limits::apply(&options.limit, &log)?;
    let (asked, progress) = (options.asked(), options.output.progress());
    let whole = Whole::of(log, temperature, path, &treatment, &asked, earlier, &progress)?;
    let analysis = &whole.analysis.noise;
    let mut outcome = Outcome::new(report::heading(analysis), whole.page);
    outcome.tables = whole.tables;
    outcome.files = whole.files.into_iter().map(|(name, text)| (name, text.into_bytes())).collect();
    let results = Folder::open(folder)?.reading([path]);
    outcome.save(&results, &NAMES)?;
    if let Some(path) = &options.record {
        write_new(path, |file| treatment.applied(whole.log).write_csv(file))?;
        outcome.places.push(format!("the record as it is analysed is {}", path.display()));
    }
    if options.output.json {
        return Ok(Some(json(&outcome.document())));
    }
    outcome.show(&options.output.printed, folder)?;
    Ok(None)
}

/// The results folder of each file.
fn folders(options: &Options) -> Result<Vec<PathBuf>, Failure> {
    if options.output.out.is_some() && options.files.len() > 1 {
        let message =
            "--out names one folder, but there are several files\ngive them one by one, or leave out --out";
        return Err(Failure::Usage(message.to_owned()));
    }
    let mut folders: Vec<PathBuf> = Vec::new();
    for path in &options.files {
        let folder = options.output.folder(path.file_stem().unwrap_or_default());
        if folders.contains(&folder) {
            let message = format!(
                "several files would write to {}, the last one {}\ngive them one by one, each with its --out DIR",
                folder.display(),
                path.display()
            );
            return Err(Failure::Usage(message));
        }
        folders.push(folder);
    }
    Ok(folders)
}
