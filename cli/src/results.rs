//! The results of a study as files of its folder, as text and as JSON, and the detection of results folders of studies and of other
//! commands.

use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::look;
use crate::output::{
    LINES_OF_FACTS, Printed, save_page, save_text, show, show_facts, show_result, spell, write_table,
};
use crate::progress::Shown;
use sagnac::analysis::model::writers::WRITERS;
use sagnac::described::files;
use sagnac::report::chart::ChartError;
use sagnac::report::page::FILE as REPORT;
use sagnac::run::{Plan, RESOLVED, Tables};
use sagnac::store::folder::Folder;
use sagnac::store::{self, CARD, Store};
use sagnac::study::Study;
use sagnac::table::text::{aligned, pivot};
use sagnac::table::{Cell, Column, ColumnError, Role, Table, Usual};
use sagnac::use_cases::{Sampled, study_outcome};
use sagnac::view::Shown as Curves;
use sagnac::view::{refused, shown as curves, written};
use sagnac_base::quantity::number::significant;
use sagnac_engine::chart::{Chart, Source};

/// The store of existing results; an empty one for closed forms.
///
/// # Errors
/// The folder is in use, belongs to another study or kernel, or is damaged.
pub fn held(folder: &Folder, plan: &Plan) -> Result<Store, Failure> {
    Ok(store::Source::open_in(folder)?.into_store(&plan.identity())?)
}

/// Whether [`chart_stem`](sagnac::view::chart_stem) gives this name to a chart.
pub fn is_chart_stem(stem: &str) -> bool {
    let number = stem.strip_prefix("chart-").and_then(|number| number.parse().ok());
    stem == "chart" || number.is_some_and(|number: usize| number >= 1 && stem == format!("chart-{number}"))
}

/// Writes the tables of a study, and returns the SHA-256 of the first, that of its points.
fn write_tables(folder: &Folder, tables: &Tables) -> Result<String, Failure> {
    let write = |(source, table): (Source, &Table)| write_table(folder, source.file(), table);
    let digests = tables.all().map(write).collect::<Result<Vec<_>, _>>()?;
    Ok(digests.into_iter().next().unwrap_or_default())
}

/// The note of a page that is there before it is complete.
const PARTIAL: &str = "the error budget and the change that helps most are still being computed; the page is written again with them";

/// A study with results to show.
pub struct Ran<'a> {
    pub plan: &'a Plan<'a>,
    pub folder: &'a Folder,
    /// The path of the folder.
    pub path: &'a Path,
    pub sampled: Sampled,
    /// Whether results are returned as JSON instead of printed.
    pub json: bool,
    /// The parts of the results that are printed.
    pub shown: Printed,
}

impl Ran<'_> {
    /// Writes the files of all results in the store, and prints them with the line `place` below them, or returns them as JSON if
    /// requested. `progress` receives the progress of fits, and is cleared.
    ///
    /// # Errors
    /// A row of the store is damaged, or a file cannot be written.
    pub fn show(
        &self,
        store: &Store,
        progress: &Shown,
        place: Option<String>,
    ) -> Result<Option<String>, Failure> {
        let Ran { plan, folder, sampled, shown, .. } = self;
        let study = plan.study();
        let mut details = String::new();
        let write = |tables: &Tables| {
            if shown.table {
                details = summary(study, tables, &curves(study, tables)?)?;
            }
            write_tables(folder, tables)
        };
        let mut results = study_outcome(plan, store, sampled, write, progress)?;
        results.outcome.details = details;
        let pictures = folder.listed().into_iter().filter_map(|name| {
            let stem = name.strip_suffix(".svg").or(name.strip_suffix(".png"))?;
            is_chart_stem(stem).then(|| stem.to_owned())
        });
        results.outcome.names = pictures.collect();
        let is_partial = results.is_partial;
        if is_partial {
            results.outcome.page.notes.insert(0, PARTIAL.to_owned());
        }
        save_page(&results.outcome, folder)?;
        progress.clear();
        let is_shown = !(self.json || shown.quiet && sampled.lacking > 0);
        if is_partial {
            results.outcome.page.notes.remove(0);
            if is_shown {
                show_result(&results.outcome, shown, LINES_OF_FACTS)?;
            }
            results.complete(progress)?;
            save_text(&results.outcome, folder)?;
            progress.clear();
        }
        let outcome = results.outcome;
        match is_shown {
            true if is_partial => show_facts(&outcome, place.as_slice(), shown, self.path)?,
            true => show(&outcome, place.as_slice(), shown, self.path)?,
            false => shown.open_page(self.path),
        }
        Ok(self.json.then(|| outcome.json(&spell)))
    }
}

/// The table of the first chart and the coefficients, for people.
pub(crate) fn summary(study: &Study, tables: &Tables, curves: &[Curves]) -> Result<String, Failure> {
    let failed = |error: ColumnError| Failure::Picture(error.to_string());
    let points = &tables.points;
    let brief: Vec<&Column> = points.columns.iter().filter(|column| column.brief).collect();
    let shown = match study.charts.iter().zip(curves).next() {
        Some((chart, shown)) if !(shown.is_supplied(chart) && study.sweeps.is_empty()) => {
            of_chart(study, points, shown, chart).map_err(|error| refused(study, chart, &error))?
        }
        _ if study.sweeps.is_empty() && !brief.is_empty() => {
            let keys = points.columns.iter().filter(|column| column.role == Role::Key && !column.brief);
            listed(&keys.chain(brief).collect::<Vec<_>>())
        }
        _ => undrawn(study, points).map_err(failed)?,
    };
    let mut text = shown;
    if let Some(coefficients) = &tables.coefficients {
        text += &format!("\n{}", coefficients_found(study, coefficients));
    }
    Ok(text)
}

/// Each column of a table on its own line, with its values.
fn columns(table: &Table) -> String {
    let table = table.read();
    let line = |column: &Column| {
        let cells = column.cells.iter().map(|cell| cell.rounded(6));
        std::iter::once(column.title()).chain(cells).collect::<Vec<String>>()
    };
    aligned(&table.columns.iter().map(line).collect::<Vec<_>>(), look::columns())
}

/// The points of a study without a chart as a grid, as after sweeps over names alone. Of the texts that a summary of
/// one point lists, only the usual one is shown.
fn undrawn(study: &Study, table: &Table) -> Result<String, ColumnError> {
    let Some(estimate) = table.usual(Usual::Estimate).filter(|_| !study.kind().is_exact) else {
        return Ok(columns(table));
    };
    let mut rows = study.usual_rows();
    rows.retain(|(name, _)| table.column(name).is_ok_and(|column| column.brief));
    let [first, last] = lines(table);
    let swept = study.sweeps.iter().map(|sweep| sweep.key.name);
    let across: Vec<&str> = first.into_iter().chain(swept).chain(last).collect();
    pivot(table, &across, &estimate.name, &[], &study.text_columns(Source::Points), &rows, look::columns())
}

/// The columns of a table of points that label lines, before and after those of swept keys: an abscissa that
/// distinguishes rows, and the text that names its places otherwise.
fn lines(table: &Table) -> [Option<&str>; 2] {
    let name = |usual| table.usual(usual).map(|column| column.name.as_str());
    match name(Usual::Places) {
        None => [name(Usual::Abscissa), None],
        places => [None, places],
    }
}

/// The rows of a chart as a grid.
fn of_chart(study: &Study, points: &Table, shown: &Curves, chart: &Chart) -> Result<String, ChartError> {
    let table: &Table = &shown.table;
    let sweeps = study.sweeps.iter().map(|sweep| sweep.key.name);
    let across: Vec<&str> = match lines(points) {
        // Compensations are side by side, and ticks one below the other.
        [_, Some(last)] => sweeps.chain([last]).collect(),
        [None, None] if !study.sweeps.is_empty() => sweeps.collect(),
        _ => {
            let x = table.column(&chart.x.name)?.name.as_str();
            std::iter::once(x).chain(sweeps.filter(|sweep| *sweep != x)).collect()
        }
    };
    let series: Vec<&str> = shown.series.iter().map(String::as_str).collect();
    let texts = study.text_columns(chart.source);
    Ok(pivot(table, &across, &shown.estimate, &series, &texts, &written(study, chart), look::columns())?)
}

/// Some columns, with a line for each of their rows.
fn listed(columns: &[&Column]) -> String {
    let line = |row: usize| columns.iter().map(|column| column.cells[row].rounded(4)).collect();
    let heading: Vec<String> = columns.iter().map(|column| column.title()).collect();
    let rows = columns.first().map_or(0, |column| column.cells.len());
    aligned(&std::iter::once(heading).chain((0..rows).map(line)).collect::<Vec<_>>(), look::columns())
}

/// Most coefficients that are shown in addition to their file.
const MAX_COEFFICIENTS: usize = 24;

/// The coefficients of every point, one per line.
fn coefficients_found(study: &Study, table: &Table) -> String {
    if table.rows() > MAX_COEFFICIENTS {
        return format!("coefficients of {} points are in coefficients.csv\n", points_of(study));
    }
    let (table, swept) = (table.read(), study.sweeps.len());
    let (keys, own) = table.columns.split_at(swept);
    let columns: Vec<&Column> = keys.iter().chain(own.iter().filter(|column| column.brief)).collect();
    let heading = |(at, column): (usize, &&Column)| {
        if at < swept { column.title() } else { column.name.clone() }
    };
    let line = |row: usize| {
        let cell = |column: &&Column| match &column.cells[row] {
            Cell::Number(x) => significant(*x, 4),
            cell => cell.text(),
        };
        columns.iter().map(cell).collect::<Vec<String>>()
    };
    let mut lines = vec![columns.iter().enumerate().map(heading).collect::<Vec<String>>()];
    lines.extend((0..table.rows()).map(line));
    format!("coefficients found in each record\n{}", aligned(&lines, look::columns()))
}

fn points_of(study: &Study) -> usize {
    study.sweeps.iter().map(|sweep| sweep.values.len()).product()
}

/// Files that identify folders, with the commands that write them.
const WRITTEN: [(&str, &str); 10] = [
    ("curve.csv", "allan"),
    ("psd.csv", "allan"),
    ("compare.csv", "compare"),
    ("batch.csv", "compare"),
    ("hat.csv", "compare"),
    ("model.csv", "model"),
    ("design.json", "design"),
    ("sensitivity.json", "sensitivity"),
    ("weights.csv", "filler"),
    ("simulated.toml", "simulate"),
];

/// Files without columns that commands write into results folders.
const FILES: [&str; 4] = [RESOLVED, REPORT, CARD, "sagnac_filler.h"];

/// Beginnings of the names of pictures, and of studies and noise of columns, that commands write.
const PICTURES: [&str; 7] = ["chart", "design", "pareto", "psd", "response", "sensitivity", "trade"];
const TEXTS: [&str; 2] = ["noise", "navigation"];

/// Whether a command writes a file of this name into a results folder.
pub fn is_ours(name: &str) -> bool {
    let begins = |stems: &[&str], ends: &[&str]| {
        stems.iter().any(|stem| name.starts_with(stem)) && ends.iter().any(|end| name.ends_with(end))
    };
    FILES.contains(&name)
        || files().iter().any(|file| file.name == name)
        || WRITTEN.iter().any(|(file, _)| *file == name)
        || WRITERS.iter().any(|writer| writer.file == name)
        || name.starts_with("inputs/")
        || begins(&PICTURES, &[".svg", ".png"])
        || begins(&TEXTS, &[".toml"])
}

/// Most folders listed in a message.
const MAX_NAMED: usize = 4;

/// Whether the folder contains results of a study.
pub fn is_study(folder: &Path) -> bool {
    folder.join(RESOLVED).is_file()
}

/// Whether the folder contains results of another command, with their card.
pub fn is_carded(folder: &Path) -> bool {
    folder.join(CARD).is_file()
}

/// The subfolders of a folder, sorted by name.
///
/// # Errors
/// The folder cannot be read.
fn within(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
    let mut found = entries.collect::<Result<Vec<_>, _>>()?;
    found.retain(|path| path.is_dir());
    found.sort();
    Ok(found)
}

/// The study whose results the folder contains.
///
/// # Errors
/// The folder has no results of a study, and the message says what it has instead; or the study cannot be read.
pub fn study(folder: &Path) -> Result<Study, Failure> {
    if is_study(folder) {
        return Ok(Study::read(&folder.join(RESOLVED))?);
    }
    let shown = folder.display();
    let give = "give a folder that `sagnac run` wrote results to";
    let message = if folder.is_file() {
        format!("{shown} is a file, not a folder of results\n{give}")
    } else if !folder.exists() {
        format!("there is no folder {shown}\n{give}")
    } else if let Some(command) =
        [folder, &folder.join("design"), &folder.join("filler")].into_iter().find_map(writer)
    {
        format!("{shown} holds output of `sagnac {command}`, not results of a study\n{give}")
    } else {
        let none = || format!("{shown} has no {RESOLVED}, so it holds no results of a study\n{give}");
        several(folder).unwrap_or_else(none)
    };
    Err(Failure::Usage(message))
}

/// A message if the folder has results in subfolders instead.
pub fn several(folder: &Path) -> Option<String> {
    let mut studies = within(folder).unwrap_or_default();
    studies.retain(|folder| is_study(folder));
    let names = named(&studies);
    let holds = || format!("{} holds folders of results\ngive one of them: {names}", folder.display());
    (!names.is_empty()).then(holds)
}

/// The command other than `run` that wrote to the folder, if any.
pub fn writer(folder: &Path) -> Option<&'static str> {
    WRITTEN.iter().find(|(file, _)| folder.join(file).is_file()).map(|(_, command)| *command)
}

/// A line with the folders in `folder` that a gallery omits, because earlier versions wrote them without a card.
pub fn left_out(folder: &Path) -> Option<String> {
    if is_study(folder) || is_carded(folder) {
        return None;
    }
    let others =
        results_within(folder).unwrap_or_default().into_iter().filter(|(_, command)| command.is_some());
    let named: Vec<String> = others
        .filter_map(|(path, command)| {
            Some(format!("{} (sagnac {})", path.strip_prefix(folder).ok()?.display(), command?))
        })
        .collect();
    (!named.is_empty()).then(|| {
        format!(
            "left out, because an earlier version wrote no {CARD} there (run the command again): {}",
            named.join(", ")
        )
    })
}

/// The folders of results in a folder, with the command of those that lack a card: studies, what other commands wrote, and what these
/// wrote into the folders of studies or one level deeper.
///
/// # Errors
/// The folder cannot be read.
pub fn results_within(folder: &Path) -> std::io::Result<Vec<(PathBuf, Option<&'static str>)>> {
    let mut found = Vec::new();
    for path in within(folder)? {
        let deeper = within(&path).unwrap_or_default();
        let others = std::iter::once(&path).chain(&deeper).filter(|path| !is_study(path));
        found.extend(is_study(&path).then(|| (path.clone(), None)));
        found.extend(others.filter_map(|path| match is_carded(path) {
            true => Some((path.clone(), None)),
            false => Some((path.clone(), Some(writer(path)?))),
        }));
    }
    Ok(found)
}

fn named(folders: &[PathBuf]) -> String {
    let more = if folders.len() > MAX_NAMED { ", …" } else { "" };
    let names = folders.iter().take(MAX_NAMED).map(|folder| folder.display().to_string());
    names.collect::<Vec<_>>().join(", ") + more
}
