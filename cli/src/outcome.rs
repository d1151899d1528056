//! The results of a command with a page: its files in a folder, and what it prints.

use std::path::Path;

use rayon::prelude::*;
use sagnac::report::chart::Picture;
use sagnac::report::page::document::{self, Document, Provenance};
use sagnac::report::page::{FILE as REPORT, Page};
use sagnac::store::CARD;
use sagnac::store::folder::Folder;
use sagnac::table::Table;
use serde_json::json;

use crate::failure::{Failure, in_options};
use crate::look;
use crate::output::{Printed, print, print_drawn, write_table};

/// Notes that are printed in any case, and lines up to which there is room for more of them.
const MIN_NOTES: usize = 2;
const MAX_LINES: usize = 20;

/// Lines that facts take which are not known yet, at most.
pub const LINES_OF_FACTS: usize = 4;

/// The results of a command.
pub struct Outcome {
    /// A line above the answer.
    pub heading: String,
    /// The page, whose charts and tables are files too.
    pub page: Page,
    /// Tables that are printed before the sections of the page, where tables are asked for.
    pub details: String,
    /// Tables that the page has no room for.
    pub tables: Vec<(&'static str, Table)>,
    /// How the results were sampled, if anything was.
    pub provenance: Option<Provenance>,
    /// Further files by their names.
    pub files: Vec<(String, Vec<u8>)>,
    /// What else was written, a line each.
    pub places: Vec<String>,
}

impl Outcome {
    /// Results with a page alone.
    pub fn new(heading: String, page: Page) -> Outcome {
        let details = String::new();
        Outcome { heading, page, details, tables: vec![], provenance: None, files: vec![], places: vec![] }
    }

    fn all_tables(&self) -> impl Iterator<Item = &(&'static str, Table)> {
        self.page.tables.iter().chain(&self.tables)
    }

    /// The results as a document for programs.
    pub fn document(&self) -> Document<'_> {
        let document = self.page.document(&self.tables);
        let notes = document.notes.iter().map(|note| in_options(note)).collect();
        Document { provenance: self.provenance.clone(), notes, ..document }
    }

    /// Adds the document as a file.
    pub fn add_document(&mut self, name: &str) {
        let text = document::json(&self.document());
        self.files.push((name.to_owned(), text.into_bytes()));
    }

    /// Writes all files. `names` are those that the command may write besides its page, in which a star stands for any text, and the
    /// stems of charts; of an earlier run, those are removed that this one does not write.
    ///
    /// # Errors
    /// A chart cannot be drawn, or a file cannot be written or removed.
    pub fn save(&self, folder: &Folder, names: &[&str]) -> Result<(), Failure> {
        for (name, table) in self.all_tables() {
            write_table(folder, name, table)?;
        }
        let card = self.page.card(&|text| in_options(&text));
        folder.write(CARD, json!(card).to_string().as_bytes())?;
        self.save_page(folder, names)
    }

    /// Writes the page with its charts and the further files, and removes what [`Outcome::save`] removes.
    ///
    /// # Errors
    /// It fails where [`Outcome::save`] does.
    pub fn save_page(&self, folder: &Folder, names: &[&str]) -> Result<(), Failure> {
        for (name, contents) in &self.files {
            folder.write(name, contents)?;
        }
        let charts: Vec<_> = self.page.figures().collect();
        // In parallel: a chart of 10,000 points takes half a second, and the page as long.
        let (drawn, made) = rayon::join(
            || charts.par_iter().try_for_each(|drawn| write_pictures(folder, &drawn.stem, &drawn.picture)),
            || folder.write(REPORT, self.page.html(&|text| in_options(&text)).as_bytes()),
        );
        drawn?;
        made?;
        let pictures =
            charts.iter().flat_map(|drawn| ["svg", "png"].map(|end| format!("{}.{end}", drawn.stem)));
        let names_of_files = self.files.iter().map(|(name, _)| name.clone());
        let tables = self.all_tables().map(|(name, _)| (*name).to_owned());
        let written: Vec<String> = pictures.chain(names_of_files).chain(tables).collect();
        for name in folder.listed() {
            if names.iter().any(|own| matches(own, &name)) && !written.contains(&name) {
                folder.remove(&name)?;
            }
        }
        Ok(folder.commit()?)
    }

    /// Writes the page again, whose charts and tables are as they were.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save_text(&self, folder: &Folder) -> Result<(), Failure> {
        folder.write(REPORT, self.page.html(&|text| in_options(&text)).as_bytes())?;
        Ok(folder.commit()?)
    }

    /// Prints the notes, what is asked for of the first chart and the details, the answer and where the files are.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn show(&self, printed: &Printed, folder: &Path) -> Result<(), Failure> {
        self.show_result(printed, self.page.answer.text_of_facts(look::width()).lines().count())?;
        self.show_facts(printed, folder)
    }

    /// Prints what [`Outcome::show`] prints before the facts of the answer, for which it leaves room.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn show_result(&self, printed: &Printed, lines_of_facts: usize) -> Result<(), Failure> {
        let Outcome { page, heading, details, .. } = self;
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
        let sections = has_sections.then(|| page.text(look::columns(), &|text| in_options(&text)));
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
    pub fn show_facts(&self, printed: &Printed, folder: &Path) -> Result<(), Failure> {
        if !printed.quiet {
            let facts = self.page.answer.text_of_facts(look::width());
            if !facts.is_empty() {
                print(&format!("\n{facts}"))?;
            }
            self.places.iter().for_each(|place| say!("{place}"));
            say!("report {}", folder.join(REPORT).display());
        }
        printed.open_page(folder);
        Ok(())
    }
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
