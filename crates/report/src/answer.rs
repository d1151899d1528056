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

pub mod reading;
pub mod text;

use serde::Serialize;

pub use crate::answer::reading::Reading;
use crate::answer::reading::{joined, number, percent_of, range};
use sagnac_base::quantity::number::{percent, probability, short, significant};

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
    /// Whether the 95 % intervals of values are shown below them, of which the first column says so.
    #[serde(skip)]
    pub shows_intervals: bool,
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

    /// The text below a cell of the column `at`: the ends of the interval of the value, if the table shows them.
    fn below(&self, row: &[AnswerCell], at: usize) -> Option<String> {
        let ends =
            |cell: &AnswerCell| cell.value.as_ref().filter(|_| cell.relation == Relation::Equal)?.ends_text();
        match at {
            _ if !self.shows_intervals => None,
            0 => row.iter().any(|cell| ends(cell).is_some()).then(|| "95 %".to_owned()),
            at => ends(row.get(at)?),
        }
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

/// Parts of an error below this share are not shown.
const MIN_SHARE: f64 = 0.05;

/// The sum of shares above which parts of an error are not independent.
const MAX_SUM: f64 = 1.05;

/// Cells of the bar of a whole.
const BAR: f64 = 10.0;

/// The eighths of a cell of a bar.
const EIGHTHS: [&str; 9] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉", "█"];

/// A part of an error.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// The fraction of the mean square that is gone without it.
    pub share: f64,
    /// Its 95 % interval.
    pub interval: Option<[f64; 2]>,
}

/// A change of an input.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Alternative {
    /// Key of the input.
    pub key: String,
    /// Its label.
    pub label: String,
    /// Its present value.
    pub from: String,
    /// The changed value.
    pub to: String,
}

/// A fact beside an answer.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", tag = "fact")]
pub enum Fact {
    /// The largest value of the best option.
    WorstCase {
        /// The value.
        value: Reading,
        /// The condition; empty where there is only one.
        at: String,
        /// The value over the limit.
        ratio_to_limit: Option<f64>,
    },
    /// The parts of the mean square, the largest first.
    ErrorBudget {
        /// The parts.
        parts: Vec<Part>,
        /// The condition, where no other fact states it.
        at: String,
    },
    /// The changes that meet the limit, each by itself.
    ChangeToMeet {
        /// The changes, the smallest first.
        alternatives: Vec<Alternative>,
    },
    /// The changes that show whether the limit is met, each by itself.
    ChangeToDecide {
        /// The changes, the smallest first.
        alternatives: Vec<Alternative>,
    },
    /// The change of a single input that lowers the value most.
    MostEffectiveChange {
        /// The change.
        change: Alternative,
        /// The fraction by which the value falls.
        gain: f64,
        /// Its 95 % interval.
        interval: Option<[f64; 2]>,
    },
    /// How well a model fits a curve.
    Fit {
        /// Shortest and longest time of the fitted points, s.
        tau_s: [f64; 2],
        /// χ² of the residuals.
        chi_squared: f64,
        /// Degrees of freedom of χ².
        degrees_of_freedom: usize,
        /// Probability of residuals at least as large if the model holds.
        p: Option<f64>,
    },
    /// A test of a hypothesis.
    Test {
        /// The hypothesis, as the heading of its row.
        name: String,
        /// Probability of data at least as far from it if it holds.
        p: f64,
        /// What was tested.
        of: String,
    },
    /// Another value that is worth knowing.
    Value {
        /// What it is, as the heading of its row.
        name: String,
        /// The value.
        value: Reading,
        /// The place or the condition; may be empty.
        at: String,
    },
    /// Messages from which columns were read.
    Source {
        /// Topic of the messages, or their sensor.
        topic: String,
        /// Type of the messages.
        kind: String,
        /// Their fields, in the order of the columns.
        fields: Vec<Field>,
    },
    /// A condition on the answer.
    Caveat {
        /// A line.
        text: String,
    },
}

/// A field of messages.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Field {
    /// The column that was read from it.
    pub column: String,
    /// Its name in a message.
    pub name: String,
    /// Unit of its numbers.
    pub unit: String,
}

impl Fact {
    /// Another value, with its place or condition, which may be empty.
    pub fn value(name: &str, value: Reading, at: &str) -> Fact {
        Fact::Value { name: name.to_owned(), value, at: at.to_owned() }
    }

    /// A condition on the answer.
    pub fn caveat(text: impl Into<String>) -> Fact {
        Fact::Caveat { text: text.into() }
    }

    /// The heading of its row.
    pub fn label(&self) -> &str {
        match self {
            Fact::WorstCase { .. } => "Worst case",
            Fact::ErrorBudget { .. } => "Error budget",
            Fact::ChangeToMeet { .. } => "To meet the limit",
            Fact::ChangeToDecide { .. } => "To decide",
            Fact::MostEffectiveChange { .. } => "Most effective change",
            Fact::Fit { .. } => "Fit",
            Fact::Test { name, .. } | Fact::Value { name, .. } => name,
            Fact::Source { .. } => "Source",
            Fact::Caveat { .. } => "Caveat",
        }
    }

    /// The parts of an error budget that are large enough to show.
    pub fn parts(&self) -> impl Iterator<Item = &Part> {
        let parts = if let Fact::ErrorBudget { parts, .. } = self { &parts[..] } else { &[] };
        parts.iter().filter(|part| part.share >= MIN_SHARE)
    }

    /// A remark on the whole error budget: its condition, and whether its parts interact.
    pub fn remark(&self) -> Option<String> {
        let Fact::ErrorBudget { parts, at } = self else { return None };
        let at = Some(at).filter(|at| !at.is_empty()).map(|at| format!("at {at}"));
        // An effect of two parts together is lost if either is removed, so shares may add up to more than 1.
        let is_shared = parts.iter().map(|part| part.share).sum::<f64>() > MAX_SUM;
        let remarks: Vec<String> =
            at.into_iter().chain(is_shared.then(|| "parts interact".to_owned())).collect();
        (!remarks.is_empty()).then(|| format!("({})", remarks.join("; ")))
    }

    /// Its content in one line.
    pub fn text(&self) -> String {
        match self {
            Fact::WorstCase { value, at, ratio_to_limit } => {
                let at = if at.is_empty() { String::new() } else { format!(" at {at}") };
                let ratio = ratio_to_limit.map(|ratio| format!(" ({} × limit)", significant(ratio, 3)));
                format!("{}{at}{}", value.text(), ratio.unwrap_or_default())
            }
            Fact::ErrorBudget { .. } => {
                let part =
                    |part: &Part| format!("{} {} {}", part.name, percent_of(part.share), bar(part.share));
                self.parts().map(part).chain(self.remark()).collect::<Vec<_>>().join("  ")
            }
            Fact::ChangeToMeet { alternatives } | Fact::ChangeToDecide { alternatives } => {
                alternatives.iter().map(Alternative::text).collect::<Vec<_>>().join(" · or ")
            }
            Fact::MostEffectiveChange { change, gain, .. } => {
                format!("{}: −{}", change.text(), percent(*gain))
            }
            Fact::Fit { tau_s: [from, to], chi_squared, degrees_of_freedom, p } => {
                let tau = joined(&range(&number(*from), &number(*to)), "s");
                let p = p.map(|p| format!(", p = {}", significant(p, 2))).unwrap_or_default();
                format!("τ {tau}, χ² {} / {degrees_of_freedom} dof{p}", number(*chi_squared))
            }
            Fact::Test { p, of, .. } => format!("{}, {of}", probability(*p)),
            Fact::Value { value, at, .. } if at.is_empty() => value.with_interval(),
            Fact::Value { value, at, .. } => format!("{} {at}", value.with_interval()),
            Fact::Source { topic, kind, fields } => {
                let of_unit =
                    |fields: &[Field]| format!("{} [{}]", vectors(fields).join(", "), fields[0].unit);
                let units = fields.chunk_by(|a, b| a.unit == b.unit).map(of_unit);
                format!("{topic} ({kind}): {}", units.collect::<Vec<_>>().join(", "))
            }
            Fact::Caveat { text } => text.clone(),
        }
    }
}

/// The names of fields, those of the components of a vector as one.
fn vectors(fields: &[Field]) -> Vec<&str> {
    let mut names: Vec<&str> = fields.iter().map(|field| &*field.name).collect();
    if names.len() > 1 {
        let vector = |name: &mut &str| *name = name.rfind(['.', '[']).map_or(*name, |end| &name[..end]);
        names.iter_mut().for_each(vector);
    }
    names.dedup();
    names
}

impl Alternative {
    /// The change, with the unit once where both values have it.
    pub fn text(&self) -> String {
        let unit = |text: &str| text.split_once(' ').map(|(_, unit)| unit.to_owned());
        let from = match (unit(&self.from), unit(&self.to)) {
            (Some(one), Some(other)) if one == other => self.from.split(' ').next().unwrap_or_default(),
            _ if self.to.ends_with('″') => self.from.trim_end_matches('″'),
            _ => &self.from,
        };
        format!("{} {from} → {}", self.label, self.to)
    }
}

/// A bar whose length is a share of ten cells.
fn bar(share: f64) -> String {
    let eighths = libm::round(share.clamp(0.0, 1.0) * BAR * 8.0) as usize;
    EIGHTHS[8].repeat(eighths / 8) + EIGHTHS[eighths % 8]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_bars_and_small_ones_are_left_out() {
        let part = |name: &str, share| Part { name: name.to_owned(), share, interval: None };
        let budget = Fact::ErrorBudget {
            parts: vec![part("noise", 0.86), part("vibration", 0.125), part("rest", 0.01)],
            at: String::new(),
        };
        assert_eq!(budget.text(), "noise 86 % ████████▋  vibration 13 % █▎");
    }

    #[test]
    fn a_budget_says_where_it_holds_and_that_its_parts_interact() {
        let part = |share| Part { name: "drift".to_owned(), share, interval: None };
        let budget = |shares: &[f64], at: &str| Fact::ErrorBudget {
            parts: shares.iter().copied().map(part).collect(),
            at: at.to_owned(),
        };
        assert_eq!(budget(&[1.0], "1 h").remark().as_deref(), Some("(at 1 h)"));
        assert_eq!(budget(&[0.97, 0.92], "").remark().as_deref(), Some("(parts interact)"));
        assert_eq!(budget(&[0.6, 0.4], "").remark(), None);
    }

    #[test]
    fn a_source_has_each_vector_once() {
        let source = |names: &[(&str, &str)]| {
            let field = |(name, unit): &(&str, &str)| Field {
                column: String::new(),
                name: (*name).to_owned(),
                unit: (*unit).to_owned(),
            };
            let fields = names.iter().map(field).collect();
            Fact::Source { topic: "/imu".to_owned(), kind: "Imu".to_owned(), fields }.text()
        };
        let all = [("w.x", "rad/s"), ("w.y", "rad/s"), ("a[0]", "m/s^2"), ("a[1]", "m/s^2")];
        assert_eq!(source(&all), "/imu (Imu): w [rad/s], a [m/s^2]");
        assert_eq!(source(&all[1..2]), "/imu (Imu): w.y [rad/s]");
        assert_eq!(source(&[("x", "rad/s"), ("y", "rad/s")]), "/imu (Imu): x, y [rad/s]");
    }

    #[test]
    fn a_change_has_its_unit_once() {
        let change = |from: &str, to: &str| {
            let [key, label, from, to] = ["gyro.tick", "tick", from, to].map(str::to_owned);
            Alternative { key, label, from, to }
        };
        assert_eq!(change("5 ms", "2.04 ms").text(), "tick 5 → 2.04 ms");
        assert_eq!(change("5 ms", "0.2 s").text(), "tick 5 ms → 0.2 s");
        assert_eq!(change("3", "2").text(), "tick 3 → 2");
    }
}
