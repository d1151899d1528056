//! `sagnac allan`.

pub mod options;
mod thermal;

use std::path::{Path, PathBuf};

use sagnac::analysis::dynamic::{self, Dynamic};
use sagnac::analysis::log::navigators::{self, Navigators, navigators};
use sagnac::analysis::log::{Analysis, noise_file, notes};
use sagnac::analysis::page;
use sagnac::analysis::spectrum::{self, densities, tables};
use sagnac::record::log::channel::Log;
use sagnac::record::log::read::Request;
use sagnac::store::folder::Folder;
use sagnac::view::report::document::json;

pub use crate::allan::options::Options;
use crate::allan::thermal::Thermal;
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
    let (mut log, temperature) = options.reading.read_as_recorded(path, request)?;
    options.check_record(&log)?;
    limits::apply(&options.limit, &log)?;
    let (asked, progress) = (options.asked(), options.output.progress());
    let of = |log: &Log| Analysis::of(log, path, &treatment, &asked, &progress);
    let mut analysis = of(&log)?;
    let to_compensate = options.reading.compensate;
    let thermal = temperature.map(|found| Thermal::of(found, to_compensate, &mut log, &mut analysis, of));
    let thermal = thermal.transpose()?;
    analysis.note_equal(earlier);
    let dynamic = options.dynamic.map(|window_s| Dynamic::of(&log, &treatment, window_s)).transpose()?;
    let welch = options.segments.welch(&log, options.confidence);
    let densities = (!options.no_psd).then(|| densities(&log, &treatment, &welch));
    let (densities, without) = match densities {
        Some(Ok(densities)) => (densities, None),
        Some(Err(why)) if options.segments.length_s.is_some() => return Err(why.into()),
        Some(Err(why)) => (vec![], Some(why)),
        None => (vec![], None),
    };
    let with_spectra = spectrum::Analysis::of(analysis, densities);
    let analysis = &with_spectra.noise;
    let decision = with_spectra.decision(&options.limit);
    let asked =
        options.navigate.map(|duration_s| navigators::Asked { duration_s, limit: options.position_limit });
    let navigation = asked.map(|asked| navigators(analysis, &asked, &progress));
    // Navigators are what is asked for, unless only coefficients have limits.
    let is_asked = options.limit.is_empty() || options.position_limit.is_some();
    let of_navigators = navigation.as_ref().and_then(|found| navigators::answer(found));
    let (answer, aside) = match of_navigators {
        Some(found) if is_asked => (found, None),
        found => (decision.answer.clone(), found),
    };
    let mut page = page::of_log(&log, &with_spectra, answer, without.as_ref());
    if let Some(thermal) = &thermal {
        thermal.add_to(&mut page, analysis);
    }
    if let Some(dynamic) = &dynamic {
        page.sections.push(page::of_dynamic(dynamic));
        page.tables.push(("dynamic.csv", dynamic::tables::windows(dynamic)));
        page.tables.push(("stationarity.csv", dynamic::tables::octaves(dynamic)));
    }
    page.tables.extend(navigation.as_ref().map(|found| ("navigation.csv", navigators::table(found))));
    page.tables.extend(decision.file());
    page.sections.extend(aside.map(|found| page::of_navigators(&found)));
    let mut outcome = Outcome::new(notes::heading(analysis), page);
    if !with_spectra.spectra.is_empty() {
        outcome.tables.push(("psd.csv", tables::table(&with_spectra)));
    }
    let texts = noise_file::files(analysis).into_iter().chain(studies(analysis, navigation.as_deref()));
    outcome.files.extend(texts.map(|(name, text)| (name, text.into_bytes())));
    let results = Folder::open(folder)?.reading([path]);
    outcome.save(&results, &NAMES)?;
    if let Some(path) = &options.record {
        write_new(path, |file| treatment.applied(log).write_csv(file))?;
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

/// The study behind the navigators of each column, by the name of its file.
fn studies(
    analysis: &Analysis,
    navigation: Option<&[Result<Navigators, String>]>,
) -> impl Iterator<Item = (String, String)> {
    let found = navigators::names(analysis).into_iter().zip(navigation.into_iter().flatten());
    found
        .filter_map(|(name, found)| Some((name, found.as_ref().ok()?.study.clone())))
        .collect::<Vec<_>>()
        .into_iter()
}
