//! The next lever: the single input whose change gains most.

use crate::analysis::decision::budget::mean_square;
use crate::analysis::decision::choice::Choice;
use crate::analysis::decision::evaluate::{Effort, Evaluator, Value};
use crate::analysis::decision::{DecisionError, Figure};
use crate::drift::schedule::{End, INTERVAL};
use crate::filler::{FILLERS, Method};
use crate::key::row::Key;
use crate::key::setting::Swept;
use crate::key::sweep::Sweep;
use crate::kinds::gap_fill::GapFill;
use crate::kinds::gyro::TICK;
use crate::kinds::relock::inputs::BIAS;
use crate::kinds::switched_run::SwitchedRun;
use crate::quantity::units::{Dimension, Quantity};
use crate::study::Study;
use crate::table::Table;
use crate::view::report::answer::is_given;

/// Factor by which each input is tried.
const TRIED: f64 = 1.25;

/// Factors by which an input may change at most, the largest first, as a large change may not be a valid study.
const MOST: [f64; 4] = [64.0, 16.0, 4.0, 2.0];

/// Number of bisections for the needed value, which is then exact to 64^(1/1024), 0.4 %.
const BISECTIONS: usize = 10;

/// Most changes whose needed values are compared.
const COMPARED: usize = 6;

/// The least gain that is worth a line.
const LEAST_GAIN: f64 = 0.01;

/// Most conditions under which a lever is tried.
const MOST_CONDITIONS: usize = 1000;

/// Prefixes of keys that are the question itself, or on which the gyro stands: without its bias it locks in.
const ASKED: [&str; 3] = ["run.", "navigation.", BIAS.name];

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
    /// What else a change of it does, as a sentence; empty for nothing.
    pub remark: String,
    /// Other inputs that meet the limit by themselves, each with its key, its label and the value that does.
    pub also: Vec<(&'static str, &'static str, Quantity)>,
}

/// Whether a change of the lever alone meets the limit.
#[derive(Debug, Clone, PartialEq)]
pub enum Needed {
    /// This value does.
    Value(Quantity),
    /// Not even this value does, where the estimate has this value.
    NotEven(Quantity, f64),
}

/// Whether inputs were searched for a lever, and what was found.
pub(crate) enum Search {
    /// They were not.
    None,
    /// They were.
    Done(Option<Lever>),
}

/// An input with its value at the chosen point.
#[derive(Clone, Copy)]
struct Input {
    key: &'static Key,
    value: Quantity,
}

/// An input with a change that lowers the mean square.
struct Tried {
    input: Input,
    /// Factor by which it changes.
    factor: f64,
    /// Logarithm of the mean square that is left, for a change by the factor e.
    left: f64,
}

/// The best lever at the chosen row: of the changes that gain most, the one that meets the limit with the least relative
/// change, else the one that gains most. There is none where no change gains anything, and no search where changes cost too much
/// to sample.
pub(crate) fn lever(
    study: &Study,
    table: &Table,
    choice: &Choice,
    evaluator: &mut Evaluator,
) -> Result<Search, DecisionError> {
    let at = Place::of(study, table, choice);
    let judged = &choice.column.name;
    let limit = choice.limit.filter(|limit| choice.value() > limit.value);
    let Some(tried) = at.tried(&mean_square(table, choice.column).name, evaluator) else {
        return Ok(Search::None);
    };
    let of_one = 1 + if limit.is_some() { BISECTIONS + MOST.len() } else { 0 };
    evaluator.expect(of_one * tried.len().min(if limit.is_some() { COMPARED } else { 1 }));
    let mut levers: Vec<Lever> = Vec::new();
    for Tried { input, factor, .. } in tried {
        let to = changed(&input, factor);
        let found = match at.values(&input, &[input.value, to], judged, evaluator, Effort::Parts) {
            Ok(Some(found)) => found,
            Ok(None) | Err(DecisionError::Study(_)) => continue,
            Err(error) => return Err(error),
        };
        let mut gain: Figure = found[1].with(&found[0], |new, old| 1.0 - new.abs() / old.abs()).into();
        if gain.interval.map_or(gain.value, |(low, _)| low) <= 0.0 {
            continue;
        }
        let tried = (to, found[1].upper());
        let needed =
            limit.and_then(|limit| at.needed(&input, factor < 1.0, limit.value, tried, judged, evaluator));
        let meets = matches!(needed, Some(Needed::Value(_)));
        if !meets && gain.value < LEAST_GAIN {
            continue;
        }
        match at.gain_everywhere(&input, to, judged, evaluator)? {
            Some(largest) if largest < LEAST_GAIN => continue,
            // Another condition becomes the worst.
            Some(value) if gain.interval.map_or(gain.value, |(low, _)| low) > value => {
                gain = Figure { value, interval: None };
            }
            _ => {}
        }
        let (key, label) = (input.key.name, input.key.label);
        let remark = remark(study, table, choice, &input, factor < 1.0);
        levers.push(Lever { key, label, from: input.value, to, gain, needed, remark, also: vec![] });
        if levers.len() == if limit.is_some() { COMPARED } else { 1 } {
            break;
        }
    }
    // The order of equal changes, such as those that do not meet the limit, is that of their gains.
    levers.sort_by(|a, b| a.change().total_cmp(&b.change()));
    let mut levers = levers.into_iter();
    Ok(Search::Done(levers.next().map(|mut first| {
        first.also = levers.filter(|other| other.key != first.key).filter_map(Lever::meets).collect();
        first
    })))
}

/// What a change of an input does besides what its name says: a tick that changes keeps the number of lost ticks, and fillers
/// of least variance are designed for the changed inputs.
fn remark(study: &Study, table: &Table, choice: &Choice, input: &Input, is_down: bool) -> String {
    let fill = study.asked::<GapFill>().or_else(|| study.asked::<SwitchedRun>()?.fill.as_ref());
    let name = table.listed_by(FILLERS).map(|column| column.cells[choice.row].text());
    let chosen = fill.and_then(|fill| fill.fillers.iter().find(|filler| Some(&filler.name) == name.as_ref()));
    let is_designed = chosen.is_some_and(|filler| matches!(filler.method, Method::MinimumVariance(_)));
    let of_design =
        ["gyro.", "motion.", "noise.", "switching."].iter().any(|part| input.key.name.starts_with(part));
    let of_tick = std::ptr::eq(input.key, &TICK) && fill.is_some();
    let length = if is_down { "shorter" } else { "longer" };
    match (of_tick, is_designed && of_design) {
        (true, true) => format!(
            "The number of lost ticks stays, so that the gap is {length} too, and the filler is designed anew for it."
        ),
        (true, false) => format!("The number of lost ticks stays, so that the gap is {length} too."),
        (false, true) => "The filler is designed anew for it.".to_owned(),
        (false, false) => String::new(),
    }
}

impl Lever {
    /// Its key, its label and the value that meets the limit by itself, if any does.
    fn meets(self) -> Option<(&'static str, &'static str, Quantity)> {
        match self.needed {
            Some(Needed::Value(value)) => Some((self.key, self.label, value)),
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

/// The chosen point: the values of its swept keys.
struct Place<'a> {
    study: &'a Study,
    swept: Vec<(&'static Key, Swept)>,
    /// Names of the swept keys that are conditions.
    conditions: Vec<&'static str>,
    /// The swept values under each condition; empty where a lever is not tried under all of them.
    everywhere: Vec<Vec<(&'static Key, Swept)>>,
    point: usize,
}

impl<'a> Place<'a> {
    fn of(study: &'a Study, table: &Table, choice: &Choice) -> Place<'a> {
        let swept = |row: usize| {
            let value = |sweep: &Sweep| {
                let shown = &table.column(sweep.key.name).ok()?.cells[row];
                let value = sweep.values.iter().find(|value| value.cell() == *shown)?;
                Some((sweep.key, value.clone()))
            };
            study.sweeps.iter().filter_map(value).collect::<Vec<_>>()
        };
        let varied = study.sweeps.iter().filter(|sweep| sweep.values.len() > 1).map(|sweep| sweep.key.name);
        let conditions = varied.filter(|name| table.column(name).is_ok_and(is_given)).collect();
        // The least value of a curve is in another row for each condition.
        let has_rows = !choice.is_minimum && (2..=MOST_CONDITIONS).contains(&choice.rows.len());
        let rows = choice.rows.iter().filter(|_| has_rows);
        let everywhere = rows.map(|&row| swept(row)).collect();
        Place { study, swept: swept(choice.row), conditions, everywhere, point: choice.point }
    }

    /// The changes that lower the mean square, the most effective first; `None` where it cannot be evaluated.
    fn tried(&self, square: &str, evaluator: &mut Evaluator) -> Option<Vec<Tried>> {
        let inputs = self.inputs();
        evaluator.expect(1 + 2 * inputs.len());
        let mut screened = |input: &Input, value: Quantity| {
            // Not every change is a valid study.
            let found = self.values(input, &[value], square, evaluator, Effort::Screening).ok()??;
            Some(found.first()?.value.abs())
        };
        let present = inputs.first().and_then(|input| screened(input, input.value))?;
        let mut tried: Vec<Tried> = Vec::new();
        for input in inputs {
            for factor in [1.0 / TRIED, TRIED] {
                let to = changed(&input, factor);
                let Some(value) = screened(&input, to) else { continue };
                let left = libm::log(value / present) / libm::log(to.value / input.value.value).abs();
                if left < 0.0 {
                    tried.push(Tried { input, factor, left });
                }
            }
        }
        tried.sort_by(|a, b| a.left.total_cmp(&b.left));
        Some(tried)
    }

    /// The inputs that can change: those swept and those written, without what the question asks for and the conditions
    /// over which the results are given anyway.
    fn inputs(&self) -> Vec<Input> {
        let swept = self.swept.iter().filter_map(|(key, value)| Some((*key, value.quantity()?)));
        let of_files = self.study.subject.values(self.point);
        let written = self.study.values.iter().copied().chain(of_files);
        let mut inputs: Vec<Input> = Vec::new();
        for (key, value) in swept.chain(written) {
            // Where a run ends exactly, its drift depends on how far the last interval has come.
            let is_parity = std::ptr::eq(key, &INTERVAL) && ends_exactly(self.study, self.point);
            let is_new = inputs.iter().all(|input| !std::ptr::eq(input.key, key));
            let is_asked =
                ASKED.iter().any(|table| key.name.starts_with(table)) || self.conditions.contains(&key.name);
            if is_new && value.value != 0.0 && !is_asked && !is_parity {
                inputs.push(Input { key, value });
            }
        }
        inputs
    }

    /// The judged estimate at this point with some values of one input.
    fn values(
        &self,
        input: &Input,
        values: &[Quantity],
        column: &str,
        evaluator: &mut Evaluator,
        effort: Effort,
    ) -> Result<Option<Vec<Value>>, DecisionError> {
        let others = || self.swept.iter().filter(|(key, _)| !std::ptr::eq(*key, input.key));
        let keys: Vec<&'static Key> = others().map(|(key, _)| *key).chain([input.key]).collect();
        let point = |value: &Quantity| {
            others().map(|(_, value)| value.clone()).chain([Swept::Quantity(*value)]).collect()
        };
        let points: Vec<Vec<Swept>> = values.iter().map(point).collect();
        let study = self.study.at_points(&keys, &points)?;
        evaluator.one(&study, points.len(), column, effort)
    }

    /// The fraction by which a change of an input lowers the largest value under all conditions: it may do so only where the
    /// present value is the largest, and raise another one, as a zone of lock-in that moves. `None` where that is unknown.
    fn gain_everywhere(
        &self,
        input: &Input,
        to: Quantity,
        column: &str,
        evaluator: &mut Evaluator,
    ) -> Result<Option<f64>, DecisionError> {
        let Some(first) = self.everywhere.first() else { return Ok(None) };
        let others = |swept: &[(&'static Key, Swept)]| {
            swept.iter().filter(|(key, _)| !std::ptr::eq(*key, input.key)).cloned().collect::<Vec<_>>()
        };
        let keys: Vec<&'static Key> =
            others(first).into_iter().map(|(key, _)| key).chain([input.key]).collect();
        let mut largest = |value: Quantity| {
            let point = |swept: &Vec<(&'static Key, Swept)>| {
                others(swept).into_iter().map(|(_, value)| value).chain([Swept::Quantity(value)]).collect()
            };
            let points: Vec<Vec<Swept>> = self.everywhere.iter().map(point).collect();
            let study = self.study.at_points(&keys, &points)?;
            let found = evaluator.one(&study, points.len(), column, Effort::Screening)?;
            Ok(found.map(|found| found.iter().map(|found| found.value.abs()).fold(0.0, f64::max)))
        };
        match (largest(input.value), largest(to)) {
            (Ok(Some(present)), Ok(Some(changed))) => Ok(Some(1.0 - changed / present)),
            // Not every change is a valid study under all conditions, nor is every condition cheap enough to sample.
            (Ok(_) | Err(DecisionError::Study(_)), Ok(_) | Err(DecisionError::Study(_))) => Ok(None),
            (Err(error), _) | (_, Err(error)) => Err(error),
        }
    }

    /// Whether and where a change of an input meets the limit with its whole interval, to three digits on the safe side. `tried`
    /// is a small change with the upper end of the estimate there.
    fn needed(
        &self,
        input: &Input,
        is_down: bool,
        limit: f64,
        tried: (Quantity, f64),
        column: &str,
        evaluator: &mut Evaluator,
    ) -> Option<Needed> {
        let mut at = |factor: f64| {
            let value = beyond(input, if is_down { 1.0 / factor } else { factor });
            let found = self.values(input, &[value], column, evaluator, Effort::Parts).ok()??;
            Some((value, found.first()?.upper()))
        };
        let mut ends = MOST.into_iter().filter_map(|most| Some((most, at(most)?)));
        let mut best = ends.next()?;
        // The largest change may lie beyond an optimum.
        if best.1.1 > tried.1 {
            best = ends.chain([best]).min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
        }
        let (most, (end, left)) = best;
        if left > limit && left > tried.1 {
            return Some(Needed::NotEven(tried.0, tried.1));
        }
        if left > limit {
            return Some(Needed::NotEven(end, left));
        }
        let (mut low, mut high, mut met) = (0.0, libm::log(most), end);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            match at(libm::exp(middle)) {
                Some((value, found)) if found <= limit => (high, met) = (middle, value),
                _ => low = middle,
            }
        }
        Some(Needed::Value(met))
    }
}

/// Whether a point is of runs with an exact end.
fn ends_exactly(study: &Study, point: usize) -> bool {
    let runs = study.asked::<SwitchedRun>().map(|runs| &runs.points);
    runs.and_then(|points| points.get(point)).is_some_and(|point| point.schedule.end == End::Exact)
}

/// The value of an input that is tried: multiplied by a factor, or the next whole number.
fn changed(input: &Input, factor: f64) -> Quantity {
    match input.key.is_whole() {
        true => Quantity::new(input.value.value + libm::copysign(1.0, factor - 1.0), Dimension::Count),
        false => scaled(input, factor),
    }
}

/// The value of an input multiplied by a factor.
fn scaled(input: &Input, factor: f64) -> Quantity {
    Quantity::new(input.value.value * factor, input.value.dimension)
}

/// The next value with three digits in the unit of tables, or the next whole number, that an input has when it changes
/// at least by a factor. It is never the present one.
fn beyond(input: &Input, factor: f64) -> Quantity {
    let exact = scaled(input, factor);
    let size = exact.shown().abs();
    let last = if input.key.is_whole() { 1.0 } else { libm::pow(10.0, libm::floor(libm::log10(size)) - 2.0) };
    let steps = if factor < 1.0 { libm::floor(size / last) } else { libm::ceil(size / last) };
    Quantity::new(exact.value * (steps * last / size), exact.dimension)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filler::keys::GAP_TICKS;
    use crate::kinds::gap_fill::keys::READOUT_LSB;

    #[test]
    fn needed_values_lie_beyond_the_change_with_three_digits_and_are_never_the_present_ones() {
        let needed = |key: &'static Key, value: f64, dimension: Dimension, factor: f64| {
            beyond(&Input { key, value: Quantity::new(value, dimension) }, factor).value
        };
        let pulse = |factor| needed(&READOUT_LSB, 3.2, Dimension::Angle, factor);
        assert_eq!([0.35, 0.3499, 1.00001, 0.99999].map(pulse), [1.12, 1.11, 3.21, 3.19]);
        let ticks = |factor| needed(&GAP_TICKS, 5.0, Dimension::Count, factor);
        assert_eq!([0.99, 0.79, 1.01, 1.21].map(ticks), [4.0, 3.0, 6.0, 7.0]);
    }
}
