//! The outcome of a command: its files in a folder, and what is printed of it.

use std::path::Path;

use rayon::prelude::*;
use sagnac::report::chart::Picture;
use sagnac::report::page::FILE as REPORT;
use sagnac::store::CARD;
use sagnac::store::folder::Folder;
use sagnac::use_cases::Outcome;
use serde_json::json;

use crate::failure::{Failure, in_options};
use crate::look;
use crate::output::{Printed, print, print_drawn, write_table};

/// Notes that are printed in any case, and lines up to which there is room for more of them.
const MIN_NOTES: usize = 2;
const MAX_LINES: usize = 20;

/// Lines that facts take which are not known yet, at most.
pub const LINES_OF_FACTS: usize = 4;

/// Writes the results of a command that read `inputs` into a folder, and prints them with the lines `places` on what else was written;
/// or returns them as JSON.
///
/// # Errors
/// A chart cannot be drawn, a file cannot be written or removed, or the output cannot be written.
pub fn finish<'a>(
    outcome: &Outcome,
    path: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
    places: &[String],
    json: bool,
    printed: &Printed,
) -> Result<Option<String>, Failure> {
    save(outcome, path, inputs)?;
    if json {
        return Ok(Some(outcome.json(&spell)));
    }
    show(outcome, places, printed, path)?;
    Ok(None)
}

/// Writes the results of a command that read `inputs` into a folder.
///
/// # Errors
/// A chart cannot be drawn, or a file cannot be written or removed.
pub fn save<'a>(
    outcome: &Outcome,
    path: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), Failure> {
    let folder = Folder::open(path)?.reading(inputs);
    for (name, table) in outcome.all_tables() {
        write_table(&folder, name, table)?;
    }
    folder.write(CARD, json!(outcome.page.card(&spell)).to_string().as_bytes())?;
    save_page(outcome, &folder)
}

/// Spells settings as options.
pub fn spell(text: &str) -> String {
    in_options(&text)
}

/// Writes the page with its charts and the further files, and removes those of the [names](Outcome::names) of the outcome that an
/// earlier command wrote and this one does not.
///
/// # Errors
/// A chart cannot be drawn, or a file cannot be written or removed.
pub fn save_page(outcome: &Outcome, folder: &Folder) -> Result<(), Failure> {
    for (name, contents) in &outcome.files {
        folder.write(name, contents)?;
    }
    let charts: Vec<_> = outcome.page.figures().collect();
    // In parallel: a chart of 10,000 points takes half a second, and the page as long.
    let (drawn, made) = rayon::join(
        || charts.par_iter().try_for_each(|drawn| write_pictures(folder, &drawn.stem, &drawn.picture)),
        || folder.write(REPORT, outcome.page.html(&spell).as_bytes()),
    );
    drawn?;
    made?;
    let pictures = charts.iter().flat_map(|drawn| ["svg", "png"].map(|end| format!("{}.{end}", drawn.stem)));
    let files = outcome.files.iter().map(|(name, _)| name.clone());
    let tables = outcome.all_tables().map(|(name, _)| (*name).to_owned());
    let written: Vec<String> = pictures.chain(files).chain(tables).collect();
    for name in folder.listed() {
        if outcome.names.iter().any(|own| matches(own, &name)) && !written.contains(&name) {
            folder.remove(&name)?;
        }
    }
    Ok(folder.commit()?)
}

/// Writes the page again, whose charts and tables are as they were.
///
/// # Errors
/// The file cannot be written.
pub fn save_text(outcome: &Outcome, folder: &Folder) -> Result<(), Failure> {
    folder.write(REPORT, outcome.page.html(&spell).as_bytes())?;
    Ok(folder.commit()?)
}

/// Prints the notes, what is asked for of the first chart and the details, the answer and where the files are, and opens the page if
/// that is asked for.
///
/// # Errors
/// The output cannot be written.
pub fn show(outcome: &Outcome, places: &[String], printed: &Printed, folder: &Path) -> Result<(), Failure> {
    let facts = outcome.page.answer.text_of_facts(look::width());
    show_result(outcome, printed, facts.lines().count())?;
    show_facts(outcome, places, printed, folder)
}

/// Prints what [`show`] prints before the facts of the answer, for which it leaves room.
///
/// # Errors
/// The output cannot be written.
pub fn show_result(outcome: &Outcome, printed: &Printed, lines_of_facts: usize) -> Result<(), Failure> {
    let Outcome { page, heading, details, .. } = outcome;
    if printed.quiet {
        let headline = &page.answer.headline;
        return if headline.is_empty() { Ok(()) } else { print(headline) };
    }
    let width = look::width();
    let text = format!("{}\n{}", look::wrapped(heading, width), page.answer.text_without_facts(width));
    let notes = page.all_notes();
    let room = MAX_LINES.saturating_sub(text.lines().count() + 1 + lines_of_facts).max(MIN_NOTES);
    let few = if printed.verbose { notes.len() } else { room };
    notes.iter().take(few).for_each(|note| note!("{}", in_options(note)));
    if notes.len() > few {
        note!("{} more with --verbose", notes.len() - few);
    }
    if printed.plot {
        let first = page.figures().next();
        let plot = first.map_or_else(String::new, |drawn| drawn.picture.text(look::of_output()));
        print_drawn(&format!("{plot}\n"))?;
        print("")?;
    }
    let is_table = printed.table || printed.verbose;
    let details = Some(details.clone()).filter(|details| is_table && !details.is_empty());
    let has_sections = printed.verbose || is_table && details.is_none();
    let sections = has_sections.then(|| page.text(look::columns(), &spell));
    for part in [details, sections].into_iter().flatten() {
        print(&part)?;
        print("")?;
    }
    print(&text)
}

/// Prints the facts of the answer and where the files are, and opens the page if that is asked for.
///
/// # Errors
/// The output cannot be written.
pub fn show_facts(
    outcome: &Outcome,
    places: &[String],
    printed: &Printed,
    folder: &Path,
) -> Result<(), Failure> {
    if !printed.quiet {
        let facts = outcome.page.answer.text_of_facts(look::width());
        if !facts.is_empty() {
            print(&format!("\n{facts}"))?;
        }
        places.iter().for_each(|place| say!("{place}"));
        say!("report {}", folder.join(REPORT).display());
    }
    printed.open_page(folder);
    Ok(())
}

/// Writes a chart as `<stem>.svg` and `<stem>.png`.
///
/// # Errors
/// It cannot be drawn or written.
pub fn write_pictures(folder: &Folder, stem: &str, picture: &Picture) -> Result<(), Failure> {
    let png =
        picture.png(2.0).map_err(|error| Failure::Picture(format!("cannot draw {stem}.png: {error}")))?;
    folder.write(&format!("{stem}.svg"), picture.svg().as_bytes())?;
    folder.write(&format!("{stem}.png"), &png)?;
    Ok(())
}

/// Whether a name is one of `own`: a file, with a star for any text, or without an ending the pictures of a chart.
fn matches(own: &str, name: &str) -> bool {
    let stem = || name.strip_suffix(".svg").or(name.strip_suffix(".png"));
    let Some(name) = (if own.contains('.') { Some(name) } else { stem() }) else { return false };
    match own.split_once('*') {
        Some((start, end)) => {
            name.len() >= start.len() + end.len() && name.starts_with(start) && name.ends_with(end)
        }
        None => own == name,
    }
}
