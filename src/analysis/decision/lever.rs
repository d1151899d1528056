//! The next lever: the single input whose change gains most.

use crate::analysis::decision::budget::mean_square;
use crate::analysis::decision::choice::Choice;
use crate::analysis::decision::evaluate::{Effort, Evaluator};
use crate::analysis::decision::place::{Change, EVALUATIONS, Place, Tried, changed};
use crate::analysis::decision::words::short;
use crate::analysis::decision::{DecisionError, Figure};
use sagnac_base::quantity::units::Quantity;
use sagnac_base::table::Table;
use sagnac_engine::study::Study;
use sagnac_report::answer::{Alternative, Fact};

/// Most changes whose needed values are compared.
const COMPARED: usize = 6;

/// The least gain that is worth a line.
const MIN_GAIN: f64 = 0.01;

/// Most changes that are named beside one another.
const MAX_ALTERNATIVES: usize = 3;

/// A change of an input.
#[derive(Debug, Clone, PartialEq)]
pub struct InputChange {
    /// Key of the input.
    pub key: &'static str,
    /// Its label.
    pub label: &'static str,
    /// Its present value.
    pub from: Quantity,
    /// The changed value.
    pub to: Quantity,
}

/// What changes of single inputs do to the judged estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct Lever {
    /// The change that was tried, a quarter more, a fifth less, or the next whole number: of the input that meets the limit with the
    /// smallest relative change, else the most effective one.
    pub change: InputChange,
    /// The fraction by which the judged estimate falls at the tried value.
    pub gain: Figure,
    /// The changes that meet the limit by themselves, the smallest first; empty where the limit is met or there is none.
    pub meets: Vec<InputChange>,
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
    let mut levers = Vec::<(InputChange, Figure, Option<Quantity>)>::new();
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
        let change = Change { input, is_down: factor < 1.0 };
        let needed = match limit {
            Some(limit) => at.needed(&change, limit.value, judged, evaluator)?,
            None => None,
        };
        if needed.is_none() && gain.value < MIN_GAIN {
            continue;
        }
        match at.gain_everywhere(&input, to, judged, evaluator)? {
            Some(largest) if largest < MIN_GAIN => continue,
            // Another condition becomes the worst.
            Some(value) if gain.interval.map_or(gain.value, |(low, _)| low) > value => {
                gain = Figure { value, interval: None };
            }
            _ => {}
        }
        let change = InputChange { key: input.key.name, label: input.key.label, from: input.value, to };
        levers.push((change, gain, needed));
        if levers.len() == if limit.is_some() { COMPARED } else { 1 } {
            break;
        }
    }
    // The relative change that meets the limit, as a logarithm. The order of equal changes, such as those that do not meet it, is
    // that of their gains.
    let size = |(change, _, needed): &(InputChange, Figure, Option<Quantity>)| {
        needed.map_or(f64::INFINITY, |to| libm::log(to.value / change.from.value).abs())
    };
    levers.sort_by(|a, b| size(a).total_cmp(&size(b)));
    let mut meets = Vec::<InputChange>::new();
    for (change, _, needed) in &levers {
        let is_new = meets.iter().all(|other| other.key != change.key);
        meets.extend(needed.filter(|_| is_new).map(|to| InputChange { to, ..change.clone() }));
    }
    Ok(levers.into_iter().next().map(|(change, gain, _)| Lever { change, gain, meets }))
}

/// Significant digits of an input.
const DIGITS: usize = 4;

impl InputChange {
    fn alternative(&self) -> Alternative {
        let [from, to] = [self.from, self.to].map(|quantity| {
            let text = short(quantity, DIGITS);
            text.strip_suffix(" ″").map_or(text.clone(), |number| format!("{number}″"))
        });
        Alternative { key: self.key.to_owned(), label: self.label.to_owned(), from, to }
    }
}

impl Lever {
    /// The changes that meet the limit, else the change that gains most.
    pub(crate) fn fact(&self) -> Fact {
        match &self.meets[..] {
            [] => Fact::MostEffectiveChange {
                change: self.change.alternative(),
                gain: self.gain.value,
                interval: self.gain.interval.map(|(low, high)| [low, high]),
            },
            meets => {
                let few = meets.iter().take(MAX_ALTERNATIVES);
                Fact::ChangeToMeet { alternatives: few.map(InputChange::alternative).collect() }
            }
        }
    }
}
