//! The document that programs read: a page as JSON.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use crate::answer::Answer;
use crate::page::Page;
use sagnac_base::table::Table;

/// Version of the form of documents.
const SCHEMA: u32 = 2;

/// The results of a command with their answer, as `--json` prints them.
#[derive(Debug, Serialize, schemars::JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Document<'a> {
    /// Version of this form of documents: 2.
    pub schema: u32,
    /// Title.
    pub title: &'a str,
    /// The question, or of recorded data what was analysed.
    pub question: &'a str,
    /// The answer.
    pub answer: &'a Answer,
    /// Notes attached to the results, each a sentence.
    pub notes: Vec<String>,
    /// How the results were sampled; absent where nothing was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
    /// The tables by the names of their files without the ending. Each row is an object with the headers of the file as its keys;
    /// unknown values are null.
    #[schemars(with = "BTreeMap<String, Vec<BTreeMap<String, sagnac_base::table::Cell>>>")]
    pub tables: BTreeMap<&'a str, Rows<'a>>,
}

/// How results were sampled.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Provenance {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Requested trials of each point.
    pub trials: u64,
    /// Device of this run.
    pub device: Option<String>,
    /// Trials sampled by this run over all points, without those of earlier runs.
    pub sampled_trials: Option<u64>,
    /// Duration of the sampling, s.
    pub seconds: Option<f64>,
    /// Trials that are missing over all points.
    pub missing_trials: u64,
}

impl Provenance {
    /// That of results whose device is not known.
    pub fn new(seed: u64, trials: u64) -> Provenance {
        Provenance { seed, trials, device: None, sampled_trials: None, seconds: None, missing_trials: 0 }
    }
}

/// The rows of a table, which are objects with the headers of the columns as keys.
#[derive(Debug)]
pub struct Rows<'a>(pub &'a Table);

impl Serialize for Rows<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let headers: Vec<String> = self.0.columns.iter().map(|column| column.header()).collect();
        serializer.collect_seq((0..self.0.rows()).map(|row| Row { table: self.0, headers: &headers, row }))
    }
}

struct Row<'a> {
    table: &'a Table,
    headers: &'a [String],
    row: usize,
}

impl Serialize for Row<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let cells = self.table.columns.iter().map(|column| &column.cells[self.row]);
        serializer.collect_map(self.headers.iter().zip(cells))
    }
}

impl<'a> Document<'a> {
    /// The document of results with some tables by the names of their files.
    pub fn new(
        [title, question]: [&'a str; 2],
        answer: &'a Answer,
        notes: Vec<String>,
        tables: impl IntoIterator<Item = (&'a str, &'a Table)>,
    ) -> Document<'a> {
        let stem = |name: &'a str| name.strip_suffix(".csv").unwrap_or(name);
        let tables = tables.into_iter().map(|(name, table)| (stem(name), Rows(table))).collect();
        Document { schema: SCHEMA, title, question, answer, notes, provenance: None, tables }
    }
}

impl Page {
    /// The page as a document, with `further` tables that it has no room for.
    pub fn document<'a>(&'a self, further: &'a [(&'static str, Table)]) -> Document<'a> {
        let tables = self.tables.iter().chain(further).map(|(name, table)| (*name, table));
        Document::new([&self.title, &self.subtitle], &self.answer, self.all_notes(), tables)
    }
}

/// A document as indented text.
pub fn json(document: &impl Serialize) -> String {
    serde_json::to_string_pretty(document).expect("the keys of documents are texts")
}
