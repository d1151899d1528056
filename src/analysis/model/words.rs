//! Models in words: the answer, the five lines of the decision, and notes.

use crate::allan::{Deviation, Unit};
use crate::analysis::decision::Lines;
use crate::analysis::model::search::{MOST_STATES, Tried};
use crate::analysis::model::tables::{figures, parts};
use crate::analysis::model::target::{LONGEST, NEAR};
use crate::analysis::model::{Aim, Analysis, Column};
use crate::quantity::number::significant;
use crate::view::report::agreement::capitalised;

/// Width of the band, as a ratio of its upper end to the value, from which on a longer record is proposed.
const WIDE: f64 = 1.3;

impl Analysis {
    /// The confidence as a percentage, such as `95 %`.
    pub fn percent(&self) -> String {
        percent(self.asked.confidence)
    }

    /// The column whose bound lies farthest above.
    pub(crate) fn worst(&self) -> Option<&Column> {
        let excess = |column: &&Column| column.found.over_bound(&column.target)[0];
        self.columns.iter().max_by(|a, b| excess(a).total_cmp(&excess(b)))
    }
}

fn percent(part: f64) -> String {
    format!("{} %", significant(100.0 * part, 3))
}

/// A ratio in words: in percent below 2 times, else as a factor.
fn above(excess: f64) -> String {
    match excess {
        ..1.0 => format!("{} above", percent(excess)),
        _ => format!("{} times", significant(1.0 + excess, 3)),
    }
}

/// The model in a sentence, such as `gz: white noise 0.003 °/√h, random walk 0.01 °/h/√h, Markov states 0.02 °/h in 30 s.`
pub fn sentence(column: &Column) -> String {
    let values = figures(column);
    let named = values.iter().filter(|figure| !figure.name.is_empty() && figure.value > 0.0);
    let mut said: Vec<String> = named
        .map(|figure| format!("{} {} {}", figure.name, significant(figure.value, 3), figure.unit))
        .collect();
    let symbol = column.target.unit.symbol(Deviation::Oadev);
    said.extend(column.found.model.markov.iter().map(|state| {
        format!(
            "a Markov state of {} {symbol} with {} s",
            significant(state.sigma, 3),
            significant(state.time_s, 3)
        )
    }));
    format!("{}: {}.", column.target.name, said.join(", "))
}

/// What the model of a column does.
pub(crate) fn bounded(column: &Column, analysis: &Analysis) -> String {
    let [from_s, to_s] = column.target.taus().map(|tau_s| significant(tau_s, 4));
    let range = format!("from τ = {from_s} s to {to_s} s");
    match (analysis.asked.aim, column.target.has_band) {
        (Aim::Describe, _) => format!("The Allan deviation lies within the band of the record {range}."),
        (Aim::Bound, true) => format!(
            "The Allan deviation is nowhere below the upper end of the {} band {range}.",
            analysis.percent()
        ),
        (Aim::Bound, false) => format!("The Allan deviation is nowhere below the curve {range}."),
        (Aim::BoundRepeat, _) => format!(
            "The Allan deviation is nowhere below the upper end of the band of {} of records like this one {range}.",
            analysis.percent()
        ),
    }
}

/// The five lines.
pub fn decision(analysis: &Analysis) -> Lines {
    let Some(column) = analysis.worst() else {
        return Lines { met: None, sentences: Default::default() };
    };
    let (target, found) = (&column.target, &column.found);
    let whose = if analysis.columns.len() > 1 { format!("{}: ", target.name) } else { String::new() };
    let requirement = format!("Met: {whose}{}", bounded(column, analysis));
    let [over_bound, bound_s] = found.over_bound(target);
    let [over_record, record_s] = found.over_record(target);
    let at = |tau_s: f64| format!("at τ = {} s", significant(tau_s, 3));
    let what = match analysis.asked.aim {
        Aim::BoundRepeat => "the band of another record",
        _ if target.has_band => "the upper end of the band",
        _ => "the curve",
    };
    let margin = match analysis.asked.aim {
        Aim::Describe => format!(
            "The model is within the band, {} the record at most, {}.",
            above(over_record),
            at(record_s)
        ),
        _ if !target.has_band => {
            format!("The model is at most {} {what}, {}.", above(over_bound), at(bound_s))
        }
        _ => format!(
            "The model is at most {} {what}, {}, and at most {} the deviation of the record itself, {}.",
            above(over_bound),
            at(bound_s),
            above(over_record),
            at(record_s)
        ),
    };
    let [_, nearest_s] = found.nearest(target);
    let limits = match analysis.asked.aim {
        Aim::Describe => format!("The upper end of the band is nearest {}.", at(nearest_s)),
        _ => format!("The model touches {what} {}.", at(nearest_s)),
    };
    let sentences =
        [requirement, best(column, analysis), margin, limits + &wide(column), lever(column, analysis)];
    Lines { met: Some(true), sentences }
}

/// How the number of states was found.
fn best(column: &Column, analysis: &Analysis) -> String {
    let asked = &analysis.asked;
    let parts = capitalised(&parts(column));
    let reached = |tried: &Tried| {
        tried.excess.map(|excess| match tried.states {
            1 => format!("1 state reaches {}", percent(excess)),
            states => format!("{states} states reach {}", percent(excess)),
        })
    };
    let before: Vec<String> = column.found.tried.iter().rev().skip(1).rev().filter_map(reached).collect();
    let last = column.found.tried.last().and_then(|tried| tried.excess);
    match (asked.states, asked.aim) {
        (Some(_), _) => format!("{parts}, as many states as were asked for."),
        (None, Aim::Describe) => format!("{parts}: with fewer states no model lies within the band."),
        _ if last.is_some_and(|excess| excess <= asked.margin) && before.is_empty() => {
            format!("{parts}, which lie at most {} above without any Markov state.", percent(asked.margin))
        }
        _ if last.is_some_and(|excess| excess <= asked.margin) => {
            format!(
                "{parts}: the fewest that lie at most {} above ({}).",
                percent(asked.margin),
                before.join(", ")
            )
        }
        _ => format!(
            "{parts}: the nearest with up to {MOST_STATES} states, none of which lies within {} above.",
            percent(asked.margin)
        ),
    }
}

/// How wide the band is at the longest τ.
fn wide(column: &Column) -> String {
    let Some(last) = column.target.points.last() else { return String::new() };
    let Some(edf) = last.edf else { return String::new() };
    format!(
        " At τ = {} s the upper end of the band is {} times the deviation, of {} degrees of freedom.",
        significant(last.tau_s, 3),
        significant(last.upper / last.value, 3),
        significant(edf, 2)
    )
}

/// What would lower the bound.
fn lever(column: &Column, analysis: &Analysis) -> String {
    let last = column.target.points.last();
    let is_wide = last.is_some_and(|last| last.upper > WIDE * last.value);
    match (analysis.asked.aim, column.target.length_s) {
        (Aim::Describe, _) => "A bound, where the filter must not trust the gyro too much.".to_owned(),
        (_, Some(_)) if is_wide => {
            "A longer record, which narrows the band at the longest τ, or a shorter range of τ, if the mission allows it.".to_owned()
        }
        _ if column.found.model.markov.len() < MOST_STATES => {
            "A smaller margin, which adds a Markov state and lowers the bound.".to_owned()
        }
        _ => "A shorter range of τ, if the mission allows it: about one Markov state covers one and a half decades of flicker.".to_owned(),
    }
}

/// Notes on what was read and on what the model leaves out.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    let quantised = analysis.columns.iter().filter_map(|column| {
        let [_, upper] = column.target.quantisation?;
        let (angle, unit, factor) = match column.target.unit {
            Unit::Acceleration => ("velocity", "m/s", crate::analysis::model::states::si(Unit::Acceleration)),
            _ => ("angle", "arcsec", 1.0),
        };
        Some(format!(
            "{}: the quantisation, up to {} {unit}, is measurement noise R of the {angle} and no part of the rate; `quantisation = white` covers \
             it by white noise",
            column.target.name,
            significant(factor * upper, 3)
        ))
    });
    let widened = analysis.columns.iter().filter_map(|column| widened(column, analysis));
    analysis.source.notes.iter().cloned().chain(widened).chain(quantised).collect()
}

/// That a model covers longer averaging times than were asked for, because the curve has none there.
fn widened(column: &Column, analysis: &Analysis) -> Option<String> {
    let usual_s = column.target.length_s.map(|length_s| length_s / LONGEST);
    let [_, to_s] = column.target.taus();
    let (asked_s, why) = match analysis.asked.to_s {
        Some(asked_s) => (asked_s, "which was asked for"),
        None => (usual_s?, "a tenth of the record"),
    };
    (to_s > asked_s * (1.0 + NEAR)).then(|| {
        let [to_s, asked_s] = [to_s, asked_s].map(|tau_s| significant(tau_s, 4));
        format!(
            "{}: the model covers averaging times up to {to_s} s, because the curve has no point at {asked_s} s, {why}",
            column.target.name
        )
    })
}

/// The answer in a sentence.
pub fn headline(analysis: &Analysis) -> String {
    match &analysis.columns[..] {
        [column] => sentence(column),
        columns => format!("Models for the {} columns of {}.", columns.len(), analysis.source.heading),
    }
}
