//! The report: the results of a study as one HTML page that can be sent to a colleague, and a gallery of several.
//!
//! ```text
//! pictures, tables, answer, source ─▶ Report ─ html() ─▶ one file: text, styles, data, script; no network
//!                                   several ─ Gallery ─▶ one file with a card for each
//! ```
//!
//! A page draws its charts itself, from the numbers of the pictures, so that curves can be switched, axes changed and values
//! read off. Its script is our own, some tens of kilobytes: a chart library that has bands, closed forms under points, winner maps with hatching,
//! slices, keyboard and print takes a megabyte, or a canvas that neither prints sharply nor can be read by a screen reader.

mod agreement;
mod answer;
mod data;
mod gallery;
mod page;

pub use agreement::{Agreement, agreements};
pub use answer::{Answer, least, of_map, of_verdict};
pub use gallery::{Card, gallery};

use crate::chart::Picture;
use crate::store::Provenance;
use crate::table::Table;

/// A chart with what belongs to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// The name of its files without their endings: `chart-1`.
    pub stem: String,
    /// What it shows.
    pub picture: Picture,
    /// A sentence on what is to be said of it.
    pub note: Option<String>,
}

impl Drawn {
    /// What is to be said of it, with its name.
    pub fn sentence(&self) -> Option<String> {
        self.note.as_ref().map(|note| format!("{}: {note}", self.stem))
    }
}

/// All that a page says of a study.
#[derive(Debug)]
pub struct Report<'a> {
    /// The title of the study.
    pub title: &'a str,
    /// Its question; may be empty.
    pub question: &'a str,
    /// The answer.
    pub answer: Answer,
    /// What should be known besides, each a sentence.
    pub notes: &'a [String],
    /// The charts, in the order of the study.
    pub charts: &'a [Drawn],
    /// The tables with the names of their files. Of large ones the page shows a part and says which.
    pub tables: Vec<(&'static str, &'a Table)>,
    /// What was simulated, and by whom.
    pub source: Source<'a>,
}

/// Where results are from, so that they can be had again.
#[derive(Debug)]
pub struct Source<'a> {
    /// The study as it was run, as TOML.
    pub study: &'a str,
    /// Its kind: `gap-fill`.
    pub kind: &'a str,
    /// The study id.
    pub id: String,
    /// Seed and trials at each point; none of closed forms.
    pub sampled: Option<(u64, u64)>,
    /// How many points its sweeps make.
    pub points: usize,
    /// Who sampled how much.
    pub provenance: Vec<Provenance>,
    /// The kernels with their versions; empty of closed forms.
    pub kernels: &'a str,
    /// SHA-256 of points.csv, in hexadecimal figures.
    pub digest: String,
}

impl Report<'_> {
    /// The page. Equal reports give equal bytes on every machine.
    pub fn html(&self) -> String {
        page::page(self)
    }
}
