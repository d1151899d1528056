//! The results of a use case.

use sagnac_base::table::Table;
use sagnac_report::page::Page;
use sagnac_report::page::document::{Document, Provenance};

/// The results of a use case: a page, and what belongs beside it in a folder of results.
#[derive(Debug)]
pub struct Outcome {
    /// Name of a folder for these results beside those of others.
    pub name: String,
    /// What was analysed, in a line.
    pub heading: String,
    /// The page, whose charts and tables are files too.
    pub page: Page,
    /// Tables that the page has no room for, by the names of their files.
    pub tables: Vec<(&'static str, Table)>,
    /// How the results were sampled, if anything was.
    pub provenance: Option<Provenance>,
    /// Further files by their names.
    pub files: Vec<(String, Vec<u8>)>,
}

impl Outcome {
    /// Results with a page alone.
    pub fn new(name: impl Into<String>, heading: String, page: Page) -> Outcome {
        Outcome { name: name.into(), heading, page, tables: vec![], provenance: None, files: vec![] }
    }

    /// The results as a document for programs.
    pub fn document(&self) -> Document<'_> {
        Document { provenance: self.provenance.clone(), ..self.page.document(&self.tables) }
    }
}
