//! Facts beside an answer. Each is a row with a value; there is none without content.

use serde::Serialize;

use crate::answer::reading::{Reading, joined, number, percent_of, range};
use sagnac_base::quantity::number::probability;
use sagnac_base::quantity::number::{percent, significant};

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
    /// A condition on the answer.
    Caveat {
        /// A line.
        text: String,
    },
}

impl Fact {
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
            Fact::Caveat { text } => text.clone(),
        }
    }
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
