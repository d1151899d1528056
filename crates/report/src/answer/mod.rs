//! The answer of an analysis to its question, as data: a headline with one result, a table of the options, facts and checks.
//!
//! ```text
//! tables ─ analysis ─▶ Answer ─┬ text ─▶ terminal
//!                              ├ card ─▶ page
//!                              └ serde ─▶ JSON, Python
//! ```
//!
//! All outputs show the same values, because they are those of one [`Answer`]. Nothing is composed from lists: what there is once
//! for each option is a cell of the table.

pub mod card;
mod facts;
pub mod reading;
pub(crate) mod text;

use serde::Serialize;

pub use crate::answer::facts::{Alternative, Fact, Part};
pub use crate::answer::reading::Reading;

use sagnac_base::quantity::number::short;

/// Most words of a headline.
pub const MAX_WORDS: usize = 12;

/// Most rows of an answer's table.
pub const MAX_ROWS: usize = 7;

/// Most columns of an answer's table.
pub const MAX_COLUMNS: usize = 6;

/// The kind of a question.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Which option has the least value?
    Choice,
    /// How far is each option good enough?
    Threshold,
    /// At which value of a design choice is something least?
    Optimum,
    /// Is the limit met?
    Requirement,
    /// How large is something?
    #[default]
    Estimate,
    /// Which option is the best where?
    Map,
}

/// The state of the limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", tag = "is")]
pub enum Status {
    /// The best option is within it under all conditions.
    Met,
    /// The best option is within it under none.
    NotMet,
    /// The best option is within it under some conditions.
    PartlyMet {
        /// Number of conditions under which it is.
        met: usize,
        /// Number of all conditions.
        of: usize,
    },
    /// The 95 % interval contains the limit.
    Inconclusive,
    /// There is no limit.
    #[default]
    NoLimit,
    /// Trials are missing.
    Incomplete {
        /// Number of missing trials.
        missing: u64,
    },
}

impl Status {
    /// The status as a word.
    pub fn text(self) -> String {
        match self {
            Status::Met => "met".to_owned(),
            Status::NotMet => "not met".to_owned(),
            Status::PartlyMet { met, of } => format!("partly met {met}/{of}"),
            Status::Inconclusive => "inconclusive".to_owned(),
            Status::NoLimit => "no limit".to_owned(),
            Status::Incomplete { missing } => format!("incomplete: {} trials missing", short(missing as f64)),
        }
    }
}

/// A cell of an answer's table.
#[derive(Debug, Clone, PartialEq, Serialize, Default, schemars::JsonSchema)]
pub struct AnswerCell {
    /// Its text, with its unit.
    pub text: String,
    /// Its value, where it has a single one.
    pub value: Option<Reading>,
    /// Whether the value is that of the cell or a bound of it; absent where it is that of the cell.
    #[serde(skip_serializing_if = "Relation::is_equal")]
    #[schemars(default)]
    pub relation: Relation,
}

/// The relation of a cell to its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Default, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// The cell has this value.
    #[default]
    Equal,
    /// The cell has at most this value.
    AtMost,
    /// The cell has at least this value.
    AtLeast,
}

impl Relation {
    fn is_equal(&self) -> bool {
        *self == Relation::Equal
    }
}

impl AnswerCell {
    /// A cell of which a bound is known.
    pub fn bounded(relation: Relation, bound: Reading) -> AnswerCell {
        let sign = match relation {
            Relation::Equal => "",
            Relation::AtMost => "≤ ",
            Relation::AtLeast => "≥ ",
        };
        AnswerCell { text: format!("{sign}{}", bound.text()), value: Some(bound), relation }
    }

    /// A cell with a value and a text of its own.
    pub fn with_text(text: String, value: Reading) -> AnswerCell {
        AnswerCell { text, value: Some(value), relation: Relation::Equal }
    }
}

impl From<String> for AnswerCell {
    fn from(text: String) -> AnswerCell {
        AnswerCell { text, ..AnswerCell::default() }
    }
}

impl From<&str> for AnswerCell {
    fn from(text: &str) -> AnswerCell {
        text.to_owned().into()
    }
}

impl From<Reading> for AnswerCell {
    fn from(value: Reading) -> AnswerCell {
        AnswerCell::bounded(Relation::Equal, value)
    }
}

/// The table of an answer: a row for each option, the best one first.
#[derive(Debug, Clone, PartialEq, Serialize, Default, schemars::JsonSchema)]
pub struct AnswerTable {
    /// Headings of the columns; the first one is that of the options.
    pub columns: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<AnswerCell>>,
    /// The row of the headline.
    pub best: Option<usize>,
    /// Number of rows that are not shown.
    pub omitted: usize,
    /// Whether the columns are places or conditions of one quantity: where they do not all fit, those in the middle are left out, else
    /// those at the end.
    #[serde(skip)]
    pub are_places: bool,
}

impl AnswerTable {
    /// The table of these rows, of which it shows the first [`MAX_ROWS`], without columns that are empty or dashes in all of them.
    pub fn new(
        columns: impl IntoIterator<Item: Into<String>>,
        rows: impl IntoIterator<Item = Vec<AnswerCell>>,
    ) -> AnswerTable {
        let mut rows: Vec<Vec<AnswerCell>> = rows.into_iter().collect();
        let omitted = rows.len().saturating_sub(MAX_ROWS);
        rows.truncate(MAX_ROWS);
        let columns = columns.into_iter().map(Into::into).collect();
        AnswerTable { columns, rows, omitted, ..AnswerTable::default() }.without_blanks()
    }

    /// The table without columns that are empty or dashes in all rows; the first one stays.
    pub fn without_blanks(mut self) -> AnswerTable {
        let is_blank = |at: &usize| self.rows.iter().all(|row| matches!(&*row[*at].text, "" | "—"));
        let blank: Vec<usize> = match self.rows[..] {
            [] => vec![],
            _ => (1..self.columns.len()).rev().filter(is_blank).collect(),
        };
        for at in blank {
            self.columns.remove(at);
            self.rows.iter_mut().for_each(|row| drop(row.remove(at)));
        }
        self
    }
}

/// A check of the results.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", tag = "check")]
pub enum Check {
    /// Agreement of sampled values with their closed forms.
    Theory {
        /// Number of values with a closed form.
        values: usize,
        /// The largest deviation in standard errors.
        max_abs_z: f64,
        /// Whether chance explains it.
        holds: bool,
    },
}

impl Check {
    /// Whether it is passed.
    pub fn holds(&self) -> bool {
        let Check::Theory { holds, .. } = self;
        *holds
    }

    /// The check as a line.
    pub fn text(&self) -> String {
        let Check::Theory { values, max_abs_z, holds } = self;
        let agrees = if *holds { "agrees" } else { "does not agree" };
        format!("{agrees} with theory (max |z| {} of {values})", reading::number(*max_abs_z))
    }
}

/// An answer.
#[derive(Debug, Clone, PartialEq, Default, Serialize, schemars::JsonSchema)]
pub struct Answer {
    /// The kind of the question.
    pub kind: Kind,
    /// The state of the limit.
    pub status: Status,
    /// One result in at most twelve words; empty for a table without a value.
    pub headline: String,
    /// The value of the headline.
    pub value: Option<Reading>,
    /// The limit.
    pub limit: Option<Reading>,
    /// The table of the options.
    pub table: AnswerTable,
    /// What else is worth knowing.
    pub facts: Vec<Fact>,
    /// Checks of the results.
    pub checks: Vec<Check>,
}

impl Answer {
    /// The status, the limit and the scope in a few words each.
    pub fn chips(&self) -> Vec<String> {
        let limit = self.limit.as_ref().map(|limit| format!("limit {}", limit.text()));
        std::iter::once(self.status.text()).chain(limit).collect()
    }
}
