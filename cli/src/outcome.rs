//! The results of a command with a page: its files in a folder, and what it prints.

use std::path::Path;

use rayon::prelude::*;
use sagnac::store::folder::Folder;
use sagnac::table::Table;
use sagnac::view::report::document::{self, Document, Provenance};
use sagnac::view::report::sections::Page;
use sagnac::view::report::{CARD, FILE as REPORT};
use serde_json::json;

use crate::charts::write_pictures;
use crate::failure::{Failure, in_options};
use crate::look;
use crate::output::{Printed, write_table};

/// The results of a command.
pub struct Outcome {
    /// A line above the answer.
    pub heading: String,
    /// The page, whose charts and tables are files too.
    pub page: Page,
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
        Outcome { heading, page, tables: vec![], provenance: None, files: vec![], places: vec![] }
    }

    /// The results as a document for programs.
    pub fn document(&self) -> Document<'_> {
        Document { provenance: self.provenance.clone(), ..self.page.document(&self.tables) }
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
        let mut written: Vec<String> = self.files.iter().map(|(name, _)| name.clone()).collect();
        for (name, table) in self.page.tables.iter().chain(&self.tables) {
            write_table(folder, name, table)?;
            written.push((*name).to_owned());
        }
        for (name, contents) in &self.files {
            folder.write(name, contents)?;
        }
        let charts: Vec<_> = self.page.figures().collect();
        // In parallel: a chart of 10,000 points takes half a second.
        charts.par_iter().try_for_each(|drawn| write_pictures(folder, &drawn.stem, &drawn.picture))?;
        written.extend(
            charts.iter().flat_map(|drawn| ["svg", "png"].map(|end| format!("{}.{end}", drawn.stem))),
        );
        for name in folder.listed() {
            if names.iter().any(|own| matches(own, &name)) && !written.contains(&name) {
                folder.remove(&name)?;
            }
        }
        let spell = |text: &str| in_options(&text);
        folder.write(REPORT, self.page.html(&spell).as_bytes())?;
        folder.write(CARD, json!(self.page.card(&spell)).to_string().as_bytes())?;
        Ok(folder.commit()?)
    }

    /// Prints the answer with what else is asked for.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn show(&self, printed: &Printed, folder: &Path) -> Result<(), Failure> {
        let plot = || {
            let first = self.page.figures().next();
            first.map_or_else(String::new, |drawn| drawn.picture.text(look::of_output()))
        };
        let details = || Ok(self.page.text(look::columns(), &|text| in_options(&text)));
        printed.show(&self.heading, &self.page.answer, &self.page.notes, plot, details)?;
        if !printed.quiet {
            self.places.iter().for_each(|place| say!("{place}"));
        }
        printed.whereabouts(folder);
        Ok(())
    }
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
