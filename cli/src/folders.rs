//! Detection of results folders of studies and of other commands.

use std::path::{Path, PathBuf};

use sagnac::analysis::model::writers::WRITERS;
use sagnac::described::files;
use sagnac::report::page::FILE as REPORT;
use sagnac::run::RESOLVED;
use sagnac::store::CARD;
use sagnac::study::Study;

use crate::failure::Failure;

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
pub fn within(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
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
