//! The page of results as one HTML file that can be sent to a colleague and as a JSON document, and a gallery of several results.
//!
//! ```text
//! answer, sections, tables ─▶ Page ─┬ html ─▶ one file: text, styles, data, script; no network
//!                                   ├ text ─▶ terminal
//!                                   ├ document ─▶ JSON
//!                                   └ card ─▶ gallery of several results
//! ```
//!
//! A page has still pictures of its charts. Its script replaces them by charts that it draws from the numbers of the
//! pictures, so that curves can be switched, axes changed and values read. The script is our own, some tens of kilobytes. A chart library with bands, closed forms under points,
//! winner maps with hatching, slices, keyboard control and printing takes a megabyte, or uses a canvas that neither
//! prints sharply nor works with a screen reader.

mod data;
pub mod html;

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use crate::answer::text::{labelled, wrapped};
use crate::answer::{Answer, AnswerTable};
use crate::chart::Drawn;
use crate::page::html::still;
use sagnac_base::table::Table;
use sagnac_base::table::text::aligned;

pub use crate::page::html::{Card, MARKS, gallery};

/// The name of a page in its folder of results.
pub const FILE: &str = "report.html";

/// A page with an answer, sections and tables. Its texts may contain settings such as `force = true` in backticks, which
/// the front end spells as its options.
#[derive(Debug)]
pub struct Page {
    /// Title.
    pub title: String,
    /// A line below the title.
    pub subtitle: String,
    /// What was analysed, such as `72 points × 2000 trials`; may be empty.
    pub scope: String,
    /// The answer.
    pub answer: Answer,
    /// Notes attached to the results.
    pub notes: Vec<String>,
    /// Sections in their order; those without blocks are left out.
    pub sections: Vec<Section>,
    /// Tables with the names of their files. Of a large table the page shows a part and says which, and none without rows.
    pub tables: Vec<(&'static str, Table)>,
}

/// A section of a page.
#[derive(Debug)]
pub struct Section {
    /// Its id in links.
    pub id: &'static str,
    /// Its heading, which the bar shows too.
    pub heading: &'static str,
    /// Its content from top to bottom.
    pub blocks: Vec<Block>,
}

/// A part of a section.
#[derive(Debug)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// A remark in smaller letters.
    Note(String),
    /// Names, each with one or more lines.
    Facts(Vec<(&'static str, Vec<String>)>),
    /// A small table to read.
    Grid(Grid),
    /// A small table that a page shows on demand, below its title.
    More(String, Grid),
    /// The table of an answer beside that of the page.
    Options(AnswerTable),
    /// A chart.
    Chart(Drawn),
    /// A chart of so many points that none has a marker.
    Trace(Drawn),
    /// A command to type.
    Command(String),
    /// A file by its name, with its text.
    File(String, String),
}

/// A small table to read: the first cell of each row names it.
#[derive(Debug)]
pub struct Grid {
    /// Headings of the columns.
    pub head: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell of a [`Grid`].
#[derive(Debug, Clone, Default)]
pub struct Cell {
    /// Its text.
    pub text: String,
    /// A smaller text below it; may be empty.
    pub below: String,
}

impl Grid {
    /// A table of cells that are texts, or texts with a smaller one below.
    pub fn new<R: IntoIterator<Item: Into<Cell>>>(
        head: impl IntoIterator<Item: Into<String>>,
        rows: impl IntoIterator<Item = R>,
    ) -> Grid {
        let row = |row: R| row.into_iter().map(Into::into).collect();
        Grid { head: head.into_iter().map(Into::into).collect(), rows: rows.into_iter().map(row).collect() }
    }
}

impl Section {
    /// A section with these blocks.
    pub fn new(id: &'static str, heading: &'static str, blocks: impl IntoIterator<Item = Block>) -> Section {
        Section { id, heading, blocks: blocks.into_iter().collect() }
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell { text, below: String::new() }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        text.to_owned().into()
    }
}

impl Page {
    /// The charts of all sections, in their order.
    pub fn charts(&self) -> impl Iterator<Item = &Drawn> {
        self.sections.iter().flat_map(|section| &section.blocks).filter_map(Block::chart)
    }

    /// The charts of results, which are files too.
    pub fn figures(&self) -> impl Iterator<Item = &Drawn> {
        let blocks = self.sections.iter().flat_map(|section| &section.blocks);
        blocks.filter_map(|block| if let Block::Chart(drawn) = block { Some(drawn) } else { None })
    }

    /// The notes attached to the results, each once, with those on charts first.
    pub fn all_notes(&self) -> Vec<String> {
        let mut of_charts: Vec<(&str, String)> = Vec::new();
        for drawn in self.figures() {
            let Some(note) = &drawn.note else { continue };
            match of_charts.iter_mut().find(|(earlier, _)| earlier == note) {
                Some((_, stems)) => *stems += &format!(", {}", drawn.stem),
                None => of_charts.push((note, drawn.stem.clone())),
            }
        }
        let of_charts = of_charts.into_iter().map(|(note, stems)| format!("{stems}: {note}"));
        of_charts.chain(self.notes.iter().cloned()).collect()
    }

    /// The card of the page in galleries, with its settings in the words of `spell`.
    pub fn card(&self, spell: &dyn Fn(&str) -> String) -> Card {
        // Rather a chart of results than a record.
        let first = self.figures().next().or_else(|| self.charts().next());
        let [title, question, headline] =
            [&self.title, &self.subtitle, &self.answer.headline].map(|text| spell(text));
        Card {
            title,
            question,
            headline,
            picture: first.map(|drawn| still(&drawn.picture)),
            ..Card::default()
        }
    }
}

impl Block {
    /// The chart, if it is one.
    pub fn chart(&self) -> Option<&Drawn> {
        match self {
            Block::Chart(drawn) | Block::Trace(drawn) => Some(drawn),
            _ => None,
        }
    }
}

/// Width of running text where no terminal has one.
const USUAL_WIDTH: usize = 80;

/// Most rows of a small table; of longer ones every second, third, … is shown.
const MAX_ROWS: usize = 48;

impl Page {
    /// The sections without their charts and files, within `limit` columns, with settings in the words of `spell`.
    pub fn text(&self, limit: Option<usize>, spell: &dyn Fn(&str) -> String) -> String {
        let sections = self.sections.iter().filter_map(|section| section.text(limit, spell));
        sections.collect::<Vec<_>>().join("\n")
    }
}

impl Section {
    fn text(&self, limit: Option<usize>, spell: &dyn Fn(&str) -> String) -> Option<String> {
        let blocks: Vec<String> = self.blocks.iter().filter_map(|block| block.text(limit, spell)).collect();
        (!blocks.is_empty()).then(|| format!("{}\n{}", self.heading, blocks.join("\n")))
    }
}

impl Block {
    fn text(&self, limit: Option<usize>, spell: &dyn Fn(&str) -> String) -> Option<String> {
        let width = limit.unwrap_or(USUAL_WIDTH);
        let indented = |text: &str| {
            wrapped(&spell(text), width.saturating_sub(2)).iter().map(|line| format!("  {line}\n")).collect()
        };
        match self {
            Block::Text(text) | Block::Note(text) => Some(indented(text)),
            Block::Facts(facts) => {
                let rows = facts.iter().flat_map(|(name, lines)| {
                    let names = std::iter::once(*name).chain(std::iter::repeat(""));
                    names.zip(lines.iter().map(|line| spell(line)))
                });
                Some(labelled(&rows.collect::<Vec<_>>(), width))
            }
            Block::Grid(grid) => Some(grid.text(limit)),
            Block::More(title, grid) => Some(format!("  {title}\n{}", grid.text(limit))),
            Block::Options(table) => Some(table.text(width)),
            Block::Command(command) => Some(format!("    {command}\n")),
            Block::Chart(_) | Block::Trace(_) | Block::File(..) => None,
        }
    }
}

impl Grid {
    fn text(&self, limit: Option<usize>) -> String {
        let step = self.rows.len().div_ceil(MAX_ROWS).max(1);
        let cell = |cell: &Cell| match &*cell.below {
            "" => cell.text.clone(),
            below => format!("{} ({below})", cell.text),
        };
        let rows = self.rows.iter().step_by(step).map(|row| row.iter().map(cell).collect());
        let text = aligned(&std::iter::once(self.head.clone()).chain(rows).collect::<Vec<_>>(), limit);
        if step == 1 { text } else { format!("{text}  one in {step} of {} rows\n", self.rows.len()) }
    }
}

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
