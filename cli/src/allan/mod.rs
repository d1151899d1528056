//! `sagnac allan`.

mod axes;
pub mod dynamic;
mod navigation;
pub mod options;
pub mod report;
mod temperature;

use std::path::{Path, PathBuf};

use sagnac::analysis::dynamic::Dynamic;
use sagnac::analysis::log::{Analysis, events, figures, kalibr, navigators, noise_file, notes, tables};
use sagnac::analysis::page;
use sagnac::analysis::spectrum::{self, densities};
use sagnac::record::log::channel::Log;
use sagnac::record::log::read::Request;
use sagnac::store::folder::Folder;
use sagnac::view::chart::figure::Figure;
use serde_json::{Value, json};

use crate::allan::navigation::Navigation;
pub use crate::allan::options::Options;
use crate::allan::temperature::Thermal;
use crate::charts::{plotted, write_figures};
use crate::failure::Failure;
use crate::limits;
use crate::output::{print_documents, write_new, write_page, write_table};
use crate::psd;

/// Analyses the logs one after the other.
pub fn allan(options: &Options) -> Result<(), Failure> {
    let request = options.reading.request()?;
    options.check(&request)?;
    let folders = folders(options)?;
    let mut documents: Vec<Value> = Vec::new();
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
) -> Result<Option<Value>, Failure> {
    let treatment = options.reading.treatment();
    let (mut log, temperature) = options.reading.read_as_recorded(path, request)?;
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
        Some(Err(why)) => (vec![], Some(why)),
        None => (vec![], None),
    };
    let with_spectra = spectrum::Analysis::of(analysis, densities);
    let analysis = &with_spectra.noise;
    let decision = with_spectra.decision(&options.limit);
    let navigation = Navigation::of(options, analysis, &progress);
    let figures = figures::figures(analysis);
    let results = Folder::open(folder)?.reading([path]);
    save(analysis, &figures, &results)?;
    psd::save(&with_spectra, &results)?;
    temperature::save(thermal.as_ref(), analysis, &results)?;
    dynamic::save(dynamic.as_ref(), &results)?;
    navigation::save(navigation.as_ref(), &results)?;
    let of_temperature = thermal.iter().map(|thermal| thermal.section(analysis));
    let over_time = dynamic.as_ref().map(page::of_dynamic);
    // Navigators are what is asked for, unless only coefficients have limits.
    let is_asked = options.limit.is_empty() || options.position_limit.is_some();
    let of_navigators = navigation.as_ref().and_then(|found| navigators::answer(&found.columns));
    let (answer, aside) = match of_navigators {
        Some(found) if is_asked => (found, None),
        found => (decision.answer.clone(), found),
    };
    let aside = aside.map(|found| page::of_navigators(&found));
    let further = of_temperature.chain(over_time).chain(aside).collect();
    let page = page::of_log(&log, &with_spectra, answer.clone(), without.as_ref(), further);
    write_page(&results, &page)?;
    let mut all = notes::notes(analysis);
    all.extend(noise_file::notes(analysis));
    if let Some(path) = &options.kalibr {
        let text = kalibr::text(analysis)?;
        write_new(path, |file| file.write_all(text.as_bytes()))?;
        all.extend(kalibr::notes(analysis)?);
    }
    if let Some(path) = &options.record {
        write_new(path, |file| treatment.applied(log).write_csv(file))?;
    }
    if options.output.json {
        let mut document = tables::document(analysis, &decision);
        document["answer"] = json!(answer);
        if let Some(thermal) = &thermal {
            document["temperature"] = thermal.document(analysis);
        }
        dynamic.iter().for_each(|dynamic| dynamic::add(dynamic, &mut document));
        navigation.iter().for_each(|navigation| navigation.add(&mut document));
        return Ok(Some(document));
    }
    let details = || {
        let of_temperature = thermal.as_ref().map_or_else(String::new, |thermal| thermal.report(analysis));
        let over_time = dynamic.as_ref().map_or_else(String::new, dynamic::report);
        Ok(report::report(analysis) + &of_temperature + &over_time)
    };
    options.output.printed.show(&notes::heading(analysis), &answer, &all, || plotted(figures), details)?;
    options.output.whereabouts(folder);
    if !options.output.printed.quiet {
        if let Some(path) = &options.kalibr {
            say!("the Kalibr file is {}", path.display());
        }
        if let Some(path) = &options.record {
            say!("the record as it is analysed is {}", path.display());
        }
    }
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

/// Writes tables, noise and charts, and removes files of an earlier run that are no longer written.
fn save(analysis: &Analysis, figures: &[(String, Option<Figure>)], folder: &Folder) -> Result<(), Failure> {
    write_table(folder, "curve.csv", &tables::table(analysis))?;
    write_table(folder, "coefficients.csv", &tables::coefficients(analysis))?;
    write_table(folder, "events.csv", &events::table(analysis))?;
    let noise = noise_file::files(analysis);
    write_texts(folder, "noise", &noise)?;
    write_figures(folder, figures)
}

/// Writes texts with the names of columns behind a `stem`, and removes those of an earlier run that this one lacks.
fn write_texts(folder: &Folder, stem: &str, texts: &[(String, String)]) -> Result<(), Failure> {
    for name in folder.listed() {
        let of_column = name.strip_prefix(stem).and_then(|rest| rest.strip_suffix(".toml"));
        let is_named = of_column.is_some_and(|column| column.is_empty() || column.starts_with('_'));
        if is_named && !texts.iter().any(|(other, _)| *other == name) {
            folder.remove(&name)?;
        }
    }
    texts.iter().try_for_each(|(name, text)| Ok(folder.write(name, text.as_bytes()).map(drop)?))
}
