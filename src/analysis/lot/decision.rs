//! The decision to which a lot leads.

use crate::analysis::decision::Figure;
use crate::analysis::decision::words::with_interval;
use crate::analysis::lot::pool::Pooled;
use crate::analysis::lot::{Coefficient, Lot};
use crate::analysis::requirement::{Decision, Judgement, Limit, Standing, Subject, decide};
use crate::quantity::list::listed;
use crate::quantity::number::percent;
use crate::quantity::number::with_unit;

impl Lot {
    /// The decision to which the units of the lot lead, and what the next unit of the lot is held against.
    pub fn decision(&self, limits: &[Limit]) -> Decision {
        let units = self.units().zip(&self.labels);
        let subjects: Vec<Subject> = units
            .map(|((log, column), label)| Subject { label, ..Subject::of_column(log, column, None) })
            .collect();
        let mut decision = decide(&subjects, limits, "unit");
        let [_, _, margin, what_limits, lever] = &mut decision.lines.sentences;
        for told in limits.iter().filter_map(|limit| self.next_unit(limit)) {
            *margin += &format!(" {told}");
        }
        let spread = match limits {
            [] => self.coefficients.iter().find_map(spread),
            _ => limits.iter().find_map(|limit| spread(self.coefficient(limit.of.name())?)),
        };
        if let Some(spread) = spread {
            *what_limits += &format!(" {spread}");
        }
        if let Some(told) = self.without_odd(&decision.judgements) {
            *lever = told;
        }
        decision
    }

    fn coefficient(&self, name: &str) -> Option<&Coefficient> {
        self.coefficients.iter().find(|one| one.name == name)
    }

    /// The next unit of the lot beside a limit; `None` where the lot does not tell.
    fn next_unit(&self, limit: &Limit) -> Option<String> {
        let one = self.coefficient(limit.of.name())?;
        let Pooled { next: [_, most], .. } = whole(one).filter(|pooled| pooled.next[1].is_finite())?;
        let shown = with_unit(most, 4, one.symbol);
        let name = one.title();
        let side = if most <= limit.value { "within" } else { "above" };
        Some(format!(
            "The {name} of the next unit is below {shown} with a probability of 97.5 %, which is {side} the limit."
        ))
    }

    /// That the limits are met without the odd units, where these alone do not meet them.
    fn without_odd(&self, judgements: &[Judgement]) -> Option<String> {
        let odd: Vec<&str> = self.odd().into_iter().map(|unit| self.labels[unit].as_str()).collect();
        let (of_odd, others): (Vec<&Judgement>, Vec<&Judgement>) =
            judgements.iter().partition(|one| odd.contains(&one.record.as_str()));
        let are_met = |all: &[&Judgement]| all.iter().all(|one| one.standing == Standing::Met);
        let names = listed(&odd);
        let verb = if odd.len() > 1 { "are" } else { "is" };
        (!others.is_empty() && are_met(&others) && !are_met(&of_odd))
            .then(|| format!("Without {names}, which {verb} odd, every unit meets its limits."))
    }
}

/// The lot of a coefficient that every unit shows. That of some units says too much of the others.
fn whole(one: &Coefficient) -> Option<Pooled> {
    one.pooled.filter(|_| one.estimates().len() == one.found.len())
}

/// How far units differ in a coefficient.
fn spread(one: &Coefficient) -> Option<String> {
    let Pooled { spread, spread_interval: [low, high], .. } = whole(one)?;
    let figure = Figure { value: spread, interval: Some((low, high)) };
    let shown = with_interval(figure, percent);
    (spread.is_finite() && high.is_finite())
        .then(|| format!("Units differ in {} by {shown} (standard deviation).", one.title()))
}
