//! The next lever: the single input whose change gains most.

use crate::analysis::decision::budget::mean_square;
use crate::analysis::decision::choice::Choice;
use crate::analysis::decision::evaluate::{Effort, Evaluator};
use crate::analysis::decision::place::{Change, EVALUATIONS, Place, Tried, changed};
use crate::analysis::decision::words::short;
use crate::analysis::decision::{DecisionError, Figure};
use crate::answer::{Alternative, Fact};
use crate::quantity::units::Quantity;
use crate::study::Study;
use crate::table::Table;

/// Most changes whose needed values are compared.
const COMPARED: usize = 6;

/// The least gain that is worth a line.
const LEAST_GAIN: f64 = 0.01;

/// Most changes that are named beside one another.
const MAX_ALTERNATIVES: usize = 3;

/// The input whose change gains most.
#[derive(Debug, Clone, PartialEq)]
pub struct Lever {
    /// Key of the input.
    pub key: &'static str,
    /// Its label.
    pub label: &'static str,
    /// Its present value.
    pub from: Quantity,
    /// The value that was tried: a quarter more, a fifth less, or the next whole number.
    pub to: Quantity,
    /// The fraction by which the judged estimate falls at the tried value.
    pub gain: Figure,
    /// What meets the limit; absent where the limit is met or there is none.
    pub needed: Option<Needed>,
    /// Other inputs that meet the limit by themselves.
    pub also: Vec<Also>,
}

/// An input that meets the limit by itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Also {
    /// Its key.
    pub key: &'static str,
    /// Its label.
    pub label: &'static str,
    /// Its present value.
    pub from: Quantity,
    /// The value that meets the limit.
    pub to: Quantity,
}

/// Whether a change of the lever alone meets the limit.
#[derive(Debug, Clone, PartialEq)]
pub enum Needed {
    /// This value does.
    Value(Quantity),
    /// Not even this value does, where the estimate has this value.
    NotEven(Quantity, f64),
}

/// The best lever at the chosen row: of the changes that gain most, the one that meets the limit with the least relative
/// change, else the one that gains most. There is none where no change gains anything, and no search where changes cost too much
/// to sample.
pub(crate) fn lever(
    study: &Study,
    table: &Table,
    choice: &Choice,
    evaluator: &mut Evaluator,
) -> Result<Option<Lever>, DecisionError> {
    // A change of an input may move a notch to the place that is judged.
    if choice.is_notched {
        return Ok(None);
    }
    let at = Place::of(study, table, choice);
    let judged = &choice.column.name;
    let limit = choice.limit.filter(|limit| choice.value() > limit.value);
    let Some(tried) = at.tried(&mean_square(table, choice.column).name, evaluator) else {
        return Ok(None);
    };
    let of_one = 1 + if limit.is_some() { EVALUATIONS } else { 0 };
    evaluator.expect(of_one * tried.len().min(if limit.is_some() { COMPARED } else { 1 }));
    let mut levers = Vec::<Lever>::new();
    for Tried { input, factor, .. } in tried {
        let to = changed(&input, factor);
        let found = match at.values(&at.swept, &input, &[input.value, to], judged, evaluator, Effort::Parts) {
            Ok(Some(found)) => found,
            Ok(None) | Err(DecisionError::Study(_)) => continue,
            Err(error) => return Err(error),
        };
        let mut gain: Figure = found[1].with(&found[0], |new, old| 1.0 - new.abs() / old.abs()).into();
        if gain.interval.map_or(gain.value, |(low, _)| low) <= 0.0 {
            continue;
        }
        let change = Change { input, to, is_down: factor < 1.0 };
        let needed = match limit {
            Some(limit) => at.needed(&change, limit.value, judged, evaluator)?,
            None => None,
        };
        let meets = matches!(needed, Some(Needed::Value(_)));
        if !meets && gain.value < LEAST_GAIN {
            continue;
        }
        let lever = |gain, needed| {
            let (key, label, from) = (input.key.name, input.key.label, input.value);
            Lever { key, label, from, to, gain, needed, also: vec![] }
        };
        match at.gain_everywhere(&input, to, judged, evaluator)? {
            Some(largest) if largest < LEAST_GAIN => continue,
            // Another condition becomes the worst.
            Some(value) if gain.interval.map_or(gain.value, |(low, _)| low) > value => {
                gain = Figure { value, interval: None };
            }
            _ => {}
        }
        levers.push(lever(gain, needed));
        if levers.len() == if limit.is_some() { COMPARED } else { 1 } {
            break;
        }
    }
    // The order of equal changes, such as those that do not meet the limit, is that of their gains.
    levers.sort_by(|a, b| a.change().total_cmp(&b.change()));
    let mut levers = levers.into_iter();
    Ok(levers.next().map(|mut first| {
        first.also = levers.filter(|other| other.key != first.key).filter_map(Lever::meets).collect();
        first
    }))
}

/// Significant digits of an input.
const DIGITS: usize = 4;

/// A quantity with the sign of arc seconds.
fn shown(quantity: Quantity) -> String {
    let text = short(quantity, DIGITS);
    text.strip_suffix(" ″").map_or(text.clone(), |number| format!("{number}″"))
}

impl Lever {
    /// The changes that meet the limit, else the change that gains most.
    pub(crate) fn fact(&self) -> Fact {
        let alternative = |key: &str, label: &str, from, to| Alternative {
            key: key.to_owned(),
            label: label.to_owned(),
            from: shown(from),
            to: shown(to),
        };
        match self.needed {
            Some(Needed::Value(to)) => {
                let first = alternative(self.key, self.label, self.from, to);
                let also = self.also.iter();
                let others = also.map(|Also { key, label, from, to }| alternative(key, label, *from, *to));
                let alternatives = std::iter::once(first).chain(others).take(MAX_ALTERNATIVES).collect();
                Fact::ChangeToMeet { alternatives }
            }
            _ => Fact::MostEffectiveChange {
                change: alternative(self.key, self.label, self.from, self.to),
                gain: self.gain.value,
                interval: self.gain.interval.map(|(low, high)| [low, high]),
            },
        }
    }

    /// The input with the value that meets the limit by itself, if any does.
    fn meets(self) -> Option<Also> {
        let Lever { key, label, from, needed, .. } = self;
        match needed {
            Some(Needed::Value(to)) => Some(Also { key, label, from, to }),
            _ => None,
        }
    }

    /// The relative change that meets the limit, as a logarithm.
    fn change(&self) -> f64 {
        match &self.needed {
            Some(Needed::Value(value)) => libm::log(value.value / self.from.value).abs(),
            _ => f64::INFINITY,
        }
    }
}
