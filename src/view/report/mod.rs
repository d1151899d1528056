//! The report: results as one HTML page that can be sent to a colleague, and a gallery of several results.
//!
//! ```text
//! answer, pictures, tables, source of a study ─▶ Report ─┬ html() ─▶ one file: text, styles, data, script; no network
//! answer, sections, tables of other commands ──▶ Page ───┘
//!                                         several Cards ─ gallery ─▶ one file with all of them
//! ```
//!
//! A page has still pictures of its charts. Its script replaces them by charts that it draws from the numbers of the
//! pictures, so that curves can be switched, axes changed and values read. The script is our own, some tens of kilobytes. A chart library with bands, closed forms under points,
//! winner maps with hatching, slices, keyboard control and printing takes a megabyte, or uses a canvas that neither
//! prints sharply nor works with a screen reader.

pub(crate) mod agreement;
pub(crate) mod axes;
pub(crate) mod bandless;
pub(crate) mod data;
pub mod document;
pub mod gallery;
pub(crate) mod notch;
mod page;
pub(crate) mod role;
pub mod sections;
pub(crate) mod shell;
pub mod source;
pub(crate) mod still;
#[cfg(test)]
mod tests;
mod text;

pub use crate::view::report::agreement::{Agreement, agreements};
pub use crate::view::report::gallery::{CARD, Card, MARKS, gallery};
pub use crate::view::report::source::{Named, Source};

use crate::answer::Answer;
use crate::chart;
use crate::table::Table;
use crate::view::picture::Drawn;

/// The name of a page in its folder of results.
pub const FILE: &str = "report.html";

/// The contents of the page of a study.
#[derive(Debug)]
pub struct Report<'a> {
    /// Title of the study.
    pub title: &'a str,
    /// Question of the study; may be empty.
    pub question: &'a str,
    /// Answer.
    pub answer: &'a Answer,
    /// Notes attached to the results, each a sentence.
    pub notes: &'a [String],
    /// Charts, in the order of the study.
    pub charts: &'a [Drawn],
    /// Tables with their sources. Of a large table the page shows a part and says which.
    pub tables: Vec<(chart::Source, &'a Table)>,
    /// Simulation and its provenance.
    pub source: &'a Source,
    /// SHA-256 of the table of points as a file, in hexadecimal digits.
    pub digest: &'a str,
}

impl Report<'_> {
    /// The page. Equal reports give equal bytes on every machine.
    pub fn html(&self) -> String {
        crate::view::report::page::page(self)
    }
}
