//! What changes of single inputs do at the operating point of a study.

use crate::analysis::decision::best_option::BestOption;
use crate::analysis::decision::evaluate::{Effort, Evaluator, Value, mean_square};
use crate::analysis::decision::{DecisionError, Figure, short};
use crate::analysis::question::is_given;
use sagnac_base::quantity::{Dimension, Quantity};
use sagnac_base::table::Table;
use sagnac_engine::drift::{End, INTERVAL};
use sagnac_engine::key::Key;
use sagnac_engine::key::sweep::{Sweep, SweepValue};
use sagnac_engine::kinds::lock_in::{FREQUENCY, LockInStudy, SCALE_FACTOR, THRESHOLD};
use sagnac_engine::kinds::switched_run::SwitchedRun;
use sagnac_engine::study::Study;
use sagnac_report::answer::{Alternative, Fact};

/// Factor by which each input is tried.
const TRIED: f64 = 1.25;

/// Factors by which an input may change at most, the largest first, as a large change may not be a valid study.
const MAX_FACTORS: [f64; 4] = [64.0, 16.0, 4.0, 2.0];

/// Number of bisections for the needed value, which is then exact to 64^(1/1024), 0.4 %.
const BISECTIONS: usize = 10;

/// Evaluations for a needed value under one condition.
pub(super) const EVALUATIONS: usize = MAX_FACTORS.len() + BISECTIONS;

/// Most conditions under which a lever is tried.
const MAX_CONDITIONS: usize = 1000;

/// Keys that move a zone of lock-in or change its width, which takes it off the inputs that are sampled or onto them.
const ZONE: [&str; 3] = [SCALE_FACTOR.name, THRESHOLD.name, FREQUENCY.name];

/// Most conditions under which the needed value is searched one after the other.
const CONDITIONS_SEARCHED: usize = 3;

/// An input with its value at the chosen point.
#[derive(Clone, Copy)]
pub(super) struct Input {
    pub(super) key: &'static Key,
    pub(super) value: Quantity,
}

/// An input with a change that lowers the mean square.
pub(super) struct Tried {
    pub(super) input: Input,
    /// Factor by which it changes.
    pub(super) factor: f64,
    /// Logarithm of the mean square that is left, for a change by the factor e.
    left: f64,
}

/// The direction in which an input changes.
pub(super) struct Change {
    pub(super) input: Input,
    pub(super) is_down: bool,
}

/// The chosen point: the values of its swept keys.
pub(super) struct Place<'a> {
    study: &'a Study,
    pub(super) swept: Vec<(&'static Key, SweepValue)>,
    /// Names of the swept keys that are conditions.
    conditions: Vec<&'static str>,
    /// The swept values under each condition; empty where a lever is not tried under all of them.
    everywhere: Vec<Vec<(&'static Key, SweepValue)>>,
    /// Place of the chosen point among them.
    at: Option<usize>,
    point: usize,
}

impl<'a> Place<'a> {
    pub(super) fn new(study: &'a Study, table: &Table, choice: &BestOption) -> Place<'a> {
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
        let has_rows = !choice.is_minimum && (2..=MAX_CONDITIONS).contains(&choice.rows.len());
        let rows = choice.rows.iter().filter(|_| has_rows);
        let everywhere = rows.map(|&row| swept(row)).collect();
        let at = choice.rows.iter().position(|&row| row == choice.row);
        Place { study, swept: swept(choice.row), conditions, everywhere, at, point: choice.point }
    }

    /// The changes that lower the mean square, the most effective first; `None` where it cannot be evaluated.
    pub(super) fn tried(&self, square: &str, evaluator: &mut Evaluator) -> Option<Vec<Tried>> {
        let inputs = self.inputs();
        evaluator.expect(1 + 2 * inputs.len());
        let mut screened = |input: &Input, value: Quantity| {
            // Not every change is a valid study.
            let found =
                self.values(&self.swept, input, &[value], square, evaluator, Effort::Screening).ok()??;
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
            let is_asked = !key.role.may_change() || self.conditions.contains(&key.name);
            let moves_zones = ZONE.contains(&key.name) && has_zones(self.study, self.point);
            if is_new && value.value != 0.0 && !is_asked && !is_parity && !moves_zones {
                inputs.push(Input { key, value });
            }
        }
        inputs
    }

    /// The judged estimate under one condition with some values of one input.
    pub(super) fn values(
        &self,
        swept: &[(&'static Key, SweepValue)],
        input: &Input,
        values: &[Quantity],
        column: &str,
        evaluator: &mut Evaluator,
        effort: Effort,
    ) -> Result<Option<Vec<Value>>, DecisionError> {
        let keys: Vec<&'static Key> = others(swept, input).map(|(key, _)| *key).chain([input.key]).collect();
        let points: Vec<Vec<SweepValue>> = values.iter().map(|value| moved(swept, input, *value)).collect();
        let study = self.study.at_points(&keys, &points)?;
        evaluator.values(&study, points.len(), column, effort)
    }

    /// The fraction by which a change of an input lowers the largest value under all conditions: it may do so only where the
    /// present value is the largest, and raise another one, as a zone of lock-in that moves. `None` where that is unknown.
    pub(super) fn gain_everywhere(
        &self,
        input: &Input,
        to: Quantity,
        column: &str,
        evaluator: &mut Evaluator,
    ) -> Result<Option<f64>, DecisionError> {
        let present = self.worst(input, input.value, column, evaluator)?;
        let changed = self.worst(input, to, column, evaluator)?;
        Ok(present.zip(changed).map(|((_, present), (_, changed))| 1.0 - changed / present))
    }

    /// The condition with the largest value, and that value, with a value of an input; `None` where a lever is not tried under
    /// all conditions, where the value is not valid under all of them, and where they cost too much to sample.
    fn worst(
        &self,
        input: &Input,
        value: Quantity,
        column: &str,
        evaluator: &mut Evaluator,
    ) -> Result<Option<(usize, f64)>, DecisionError> {
        let Some(first) = self.everywhere.first() else { return Ok(None) };
        let keys: Vec<&'static Key> = others(first, input).map(|(key, _)| *key).chain([input.key]).collect();
        let points: Vec<Vec<SweepValue>> =
            self.everywhere.iter().map(|swept| moved(swept, input, value)).collect();
        let found = self
            .study
            .at_points(&keys, &points)
            .map_err(DecisionError::from)
            .and_then(|study| evaluator.values(&study, points.len(), column, Effort::Screening));
        match found {
            Ok(found) => {
                let sizes = found.into_iter().flatten().map(|found| found.value.abs()).enumerate();
                Ok(sizes.max_by(|a, b| a.1.total_cmp(&b.1)))
            }
            Err(DecisionError::Study(_)) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The smallest change of an input that meets the limit under all conditions. Where another condition becomes the worst,
    /// the search goes on under that one.
    pub(super) fn needed(
        &self,
        change: &Change,
        limit: f64,
        column: &str,
        evaluator: &mut Evaluator,
    ) -> Result<Option<Quantity>, DecisionError> {
        let (mut swept, mut searched, mut least) = (&self.swept, self.at, 0.0);
        for _ in 0..CONDITIONS_SEARCHED {
            let found = self.needed_at(swept, change, least, limit, column, evaluator);
            let Some(value) = found else { return Ok(None) };
            let worst = self.worst(&change.input, value, column, evaluator)?;
            // Under the condition that was searched only the scatter of fewer trials is left.
            let Some((worst, _)) = worst.filter(|&(at, left)| left > limit && Some(at) != searched) else {
                return Ok(found);
            };
            (swept, searched) = (&self.everywhere[worst], Some(worst));
            least = libm::log(value.value / change.input.value.value).abs();
        }
        Ok(None)
    }

    /// The smallest change of an input that meets the limit under one condition with its whole interval, to three digits on the
    /// safe side. The change is `least` or larger, as a logarithm.
    fn needed_at(
        &self,
        swept: &[(&'static Key, SweepValue)],
        change: &Change,
        least: f64,
        limit: f64,
        column: &str,
        evaluator: &mut Evaluator,
    ) -> Option<Quantity> {
        let Change { input, is_down } = change;
        let mut at = |factor: f64| {
            let value = beyond(input, if *is_down { 1.0 / factor } else { factor });
            let found = self.values(swept, input, &[value], column, evaluator, Effort::Parts).ok()??;
            Some((value, found.first()?.upper()))
        };
        let mut ends = MAX_FACTORS.into_iter().filter_map(|most| Some((most, at(most)?)));
        let mut best = ends.next()?;
        let rest: Vec<(f64, (Quantity, f64))> = if best.1.1 > limit { ends.collect() } else { vec![] };
        // The largest change may lie beyond an optimum.
        best = rest.into_iter().chain([best]).min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
        let (most, (end, left)) = best;
        if left > limit {
            return None;
        }
        let (mut low, mut high, mut met) = (least, libm::log(most), end);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            match at(libm::exp(middle)) {
                Some((value, found)) if found <= limit => (high, met) = (middle, value),
                _ => low = middle,
            }
        }
        Some(met)
    }
}

/// The swept values without that of an input.
fn others<'s>(
    swept: &'s [(&'static Key, SweepValue)],
    input: &'s Input,
) -> impl Iterator<Item = &'s (&'static Key, SweepValue)> {
    swept.iter().filter(|(key, _)| !std::ptr::eq(*key, input.key))
}

/// The swept values of a point with a value of an input, which comes last.
fn moved(swept: &[(&'static Key, SweepValue)], input: &Input, value: Quantity) -> Vec<SweepValue> {
    others(swept, input).map(|(_, value)| value.clone()).chain([SweepValue::Quantity(value)]).collect()
}

/// Whether a point is of runs with an exact end.
fn ends_exactly(study: &Study, point: usize) -> bool {
    let runs = study.asked::<SwitchedRun>().map(|runs| &runs.points);
    runs.and_then(|points| points.get(point)).is_some_and(|point| point.schedule.end == End::Exact)
}

/// Whether a point is of a dither without randomization, whose zones of lock-in are sharp.
fn has_zones(study: &Study, point: usize) -> bool {
    let points = study.asked::<LockInStudy>().map(|study| &study.points);
    let inputs = points.and_then(|points| points.get(point)).map(|point| &point.inputs);
    let dither = inputs.and_then(|inputs| Some((inputs.dither.as_ref()?, inputs.length_s)));
    dither.is_some_and(|(dither, length_s)| dither.spread(length_s) == 0.0 && dither.phase_noise == 0.0)
}

/// The value of an input that is tried: multiplied by a factor, or the next whole number.
pub(super) fn changed(input: &Input, factor: f64) -> Quantity {
    match input.key.is_whole() {
        true => Quantity::new(input.value.value + libm::copysign(1.0, factor - 1.0), Dimension::Count),
        false => scaled(input, factor),
    }
}

/// The value of an input multiplied by a factor.
fn scaled(input: &Input, factor: f64) -> Quantity {
    input.value.with(input.value.value * factor)
}

/// The next value with three digits in the unit in which it is read, or the next whole number, that an input has when it changes
/// at least by a factor. It is never the present one.
fn beyond(input: &Input, factor: f64) -> Quantity {
    let exact = scaled(input, factor);
    let size = exact.read().abs();
    let last = if input.key.is_whole() { 1.0 } else { libm::pow(10.0, libm::floor(libm::log10(size)) - 2.0) };
    let steps = if factor < 1.0 { libm::floor(size / last) } else { libm::ceil(size / last) };
    exact.with(exact.value * (steps * last / size))
}

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
    choice: &BestOption,
    evaluator: &mut Evaluator,
) -> Result<Option<Lever>, DecisionError> {
    // A change of an input may move a notch to the place that is judged.
    if choice.is_notched {
        return Ok(None);
    }
    let at = Place::new(study, table, choice);
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

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_engine::filler::read::GAP_TICKS;
    use sagnac_engine::kinds::gap_fill::inputs::READOUT_LSB;

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
