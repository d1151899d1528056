//! The report: the results of a study as one HTML page that can be sent to a colleague, and a gallery of several.
//!
//! ```text
//! answer, pictures, tables, source ─▶ Report ─ html() ─▶ one file: text, styles, data, script; no network
//!                                   several ─ Gallery ─▶ one file with a card for each
//! ```
//!
//! A page draws its charts itself, from the numbers of the pictures, so that curves can be switched, axes changed and values
//! read off. Its script is our own, some tens of kilobytes: a chart library that has bands, closed forms under points, winner maps with hatching,
//! slices, keyboard and print takes a megabyte, or a canvas that neither prints sharply nor can be read by a screen reader.

pub mod agreement;
pub mod answer;
pub(crate) mod axes;
pub mod curves;
pub mod data;
pub mod gallery;
pub mod notes;
pub mod page;
pub mod sentences;
pub mod source;
pub mod standing;

pub use crate::view::report::agreement::{Agreement, agreements};
pub use crate::view::report::answer::{Answer, answer};
pub use crate::view::report::gallery::{Card, gallery};
pub use crate::view::report::notes::notes;
pub use crate::view::report::source::{Named, Source};

use crate::chart;
use crate::table::Table;
use crate::view::picture::Drawn;

/// The name of a study's page in its folder of results.
pub const FILE: &str = "report.html";

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
    /// The tables, each with what it is. Of large ones the page shows a part and says which.
    pub tables: Vec<(chart::Source, &'a Table)>,
    /// What was simulated, and by whom.
    pub source: &'a Source,
}

impl Report<'_> {
    /// The page. Equal reports give equal bytes on every machine.
    pub fn html(&self) -> String {
        crate::view::report::page::page(self)
    }
}
