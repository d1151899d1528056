//! The use cases: each is a function from a request to an [`Outcome`], a page with its tables and further files, for any front end.

mod added;
mod convert;
mod logs;
#[cfg(feature = "store")]
mod merge;
mod simulate;
mod studies;

use std::collections::BTreeMap;

use crate::analysis::model::tables::{ModelDocument, Models};
use sagnac_base::table::Table;
use sagnac_report::page::Page;
use sagnac_report::page::{Document, Provenance, json};

pub use added::{MotionText, Sensitivity, Warming};
pub use convert::{Conversion, Converted, convert};
pub use logs::{
    AllanRequest, BatchRequest, CompareRequest, LogError, ModelSource, Segments, allan, compare_logs,
    compare_units, fit_curve, model_noise, three_cornered_hat,
};
#[cfg(feature = "store")]
pub use merge::{MergeError, MergeOutcome, MergeRequest, absolute, check_places, merge, once};
pub use simulate::{Numbers, SimulateError, SimulateRequest, Simulation};
pub use studies::{Sampled, StudyOutcome, study_outcome};

/// The result of a use case, with the contents of its files by their names.
#[derive(Debug)]
pub struct Outcome {
    /// Name of a folder for it among the results of a study; empty where it is of none.
    pub name: String,
    /// A line above the answer.
    pub heading: String,
    /// The page, whose charts and tables are files too.
    pub page: Page,
    /// Tables as text that are printed before the sections of the page, where tables are asked for.
    pub details: String,
    /// Tables that the page has no room for, by the names of their files.
    pub tables: Vec<(&'static str, Table)>,
    /// Further files by their names.
    pub files: Vec<(String, Vec<u8>)>,
    /// The names of all files that the use case may write besides its page, in which a star stands for any text, and the stems of
    /// charts. Those that it did not write this time belong to an earlier outcome.
    pub names: Vec<String>,
    /// How the results were sampled, if anything was.
    pub provenance: Option<Provenance>,
    /// The models for filters, of a use case that finds some.
    pub models: Option<Models>,
}

impl Outcome {
    /// A page alone, of a use case that writes its charts and tables always.
    pub fn new(heading: String, page: Page) -> Outcome {
        let (details, tables, files, names) = (String::new(), vec![], vec![], vec![]);
        let name = String::new();
        Outcome { name, heading, page, details, tables, files, names, provenance: None, models: None }
    }

    /// Names the files and charts that the use case may write; see [`Outcome::names`].
    #[must_use]
    pub fn among<'n>(self, names: impl IntoIterator<Item = &'n str>) -> Outcome {
        Outcome { names: names.into_iter().map(str::to_owned).collect(), ..self }
    }

    /// The tables of the page, and those that it has no room for.
    pub fn all_tables(&self) -> impl Iterator<Item = &(&'static str, Table)> {
        self.page.tables.iter().chain(&self.tables)
    }

    /// The document for programs as JSON, with settings in the words of `spell`.
    pub fn json(&self, spell: &dyn Fn(&str) -> String) -> String {
        let document = self.page.document(&self.tables);
        let notes = document.notes.iter().map(|note| spell(note)).collect();
        let document = Document { provenance: self.provenance.clone(), notes, ..document };
        let Some(model) = &self.models else { return json(&document) };
        let text = |(name, contents): &(String, Vec<u8>)| {
            (name.clone(), String::from_utf8_lossy(contents).into_owned())
        };
        let files: BTreeMap<String, String> = self.files.iter().map(text).collect();
        json(&ModelDocument { document, model, files })
    }

    /// Adds the document for programs as a file.
    pub fn add_json(&mut self, name: &str, spell: &dyn Fn(&str) -> String) {
        let text = self.json(spell);
        self.files.push((name.to_owned(), text.into_bytes()));
    }
}
