//! The answer of a design: the best interval and filler, and what the others cost.

use crate::analysis::answer::reading_of_limit;
use crate::analysis::decision::Sheet;
use crate::analysis::design::report::duration;
use crate::analysis::design::result::time;
use crate::analysis::design::{Design, Filler, Found, PapersRule, Tried, Variant};
use sagnac_base::diagnostics::listed;
use sagnac_base::table::Unit;
use sagnac_report::answer::reading::{joined, number, range};
use sagnac_report::answer::{Answer, AnswerCell, AnswerTable, Fact, Kind, Reading, Status};

/// The excess over the least drift up to which an interval costs as much.
const FLAT: f64 = 0.04;

/// Most choices that a caveat names.
const MAX_NAMED: usize = 2;

fn reading(label: &str, found: Found) -> Reading {
    Reading::in_unit(
        label,
        found.value,
        Unit::DEG_PER_H.symbol,
        found.interval.map(|(low, high)| [low, high]),
    )
}

impl Filler {
    /// The intervals around the best one between which the drift is at most 4 % larger, by straight lines between those that were
    /// tried.
    pub(super) fn flat(&self) -> [f64; 2] {
        let most = (1.0 + FLAT) * self.best().drift.value;
        let edge = |tried: &mut dyn Iterator<Item = &Tried>| {
            let mut last = self.best();
            for next in tried {
                if next.drift.value > most {
                    let part = (most - last.drift.value) / (next.drift.value - last.drift.value);
                    return last.interval_s + part * (next.interval_s - last.interval_s);
                }
                last = next;
            }
            last.interval_s
        };
        let (before, after) = self.tried.split_at(self.best);
        [edge(&mut before.iter().rev()), edge(&mut after.iter().skip(1))]
    }

    fn flat_text(&self) -> String {
        let [from, to] = self.flat();
        match from == to {
            true => time("", from).text(),
            false => joined(&range(&number(from), &number(to)), "s"),
        }
    }
}

impl Design {
    /// The answer, with the facts of its `sheet`.
    pub fn answer(&self, sheet: Option<&Sheet>) -> Answer {
        let best = self.best().best();
        Answer {
            kind: Kind::Optimum,
            status: sheet.map_or(Status::NoLimit, Sheet::status),
            headline: self.headline(),
            value: Some(reading(self.measure.label(), best.drift)),
            limit: sheet.and_then(|sheet| sheet.limit).map(reading_of_limit),
            table: self.options(),
            facts: self.facts(sheet),
            checks: vec![],
        }
    }

    /// Interval and filler, with the drift.
    pub fn headline(&self) -> String {
        let best = self.best();
        let choice = self.named(self.variant(), best);
        let choice = if choice.is_empty() { choice } else { format!(" with {choice}") };
        let interval = best.best().interval().text();
        let drift = reading(self.measure.label(), best.best().drift).with_interval();
        format!("Switch every {interval}{choice}: {drift}")
    }

    /// A row for each filler with each combination of swept values, at its own best interval.
    fn options(&self) -> AnswerTable {
        let mut all: Vec<(&Variant, &Filler)> = self.fillers().collect();
        let is_best = |filler: &Filler| std::ptr::eq(filler, self.best());
        all.sort_by(|a, b| {
            let drift = |filler: &Filler| self.deciding(filler.best());
            is_best(b.1).cmp(&is_best(a.1)).then(drift(a.1).total_cmp(&drift(b.1)))
        });
        let name = |variant: &Variant, filler: &Filler| match self.named(variant, filler) {
            name if name.is_empty() => filler.called().to_owned(),
            name => name,
        };
        let row = |(variant, filler): &(&Variant, &Filler)| -> Vec<AnswerCell> {
            let best = filler.best();
            let end = if filler.is_at_edge() { " (end)" } else { "" };
            let interval = best.interval();
            vec![
                name(variant, filler).into(),
                AnswerCell::with_text(interval.text() + end, interval),
                filler.flat_text().into(),
                reading(self.measure.label(), best.drift).into(),
                Reading::in_unit("angle", variant.angle(best.drift.value), "″", None).into(),
                number(self.times_best(best).value).into(),
            ]
        };
        let alike = self.variants.iter().all(|variant| variant.duration_s == self.variant().duration_s);
        let after = if alike { duration(self.variant().duration_s) } else { "the run".to_owned() };
        let after = format!("after {after}");
        let heads = ["filler", "interval", "within 4 %", self.measure.label(), &after, "× best"];
        AnswerTable { best: Some(0), ..AnswerTable::new(heads, all.iter().map(row)) }
    }

    fn facts(&self, sheet: Option<&Sheet>) -> Vec<Fact> {
        let best = self.best();
        let label = self.measure.label();
        let mut facts = sheet.map(Sheet::facts).unwrap_or_default();
        if let Some((low, high)) = best.optimum.interval {
            let interval = Reading::in_unit("interval", best.best().interval_s, "s", Some([low, high]));
            facts.push(Fact::value("Best interval", interval, ""));
        }
        if let Some(cost) = best.cost.filter(|_| self.trades()) {
            facts.push(Fact::value("Latency", time("latency", cost.latency_s), ""));
            let bytes = Reading::in_unit("memory", cost.memory.bytes() as f64, "bytes", None);
            facts.push(Fact::value("Memory", bytes, ""));
        }
        if let Some(PapersRule { interval_s, tried, .. }) = &best.papers_rule {
            let drift = Reading { interval: None, ..reading(label, tried.drift) };
            let times = number(100.0 * (self.times_best(tried).value - 1.0));
            facts.push(Fact::value(
                "Paper's rule",
                drift,
                &format!("at {}, {times} % more", time("", *interval_s).text()),
            ));
        }
        if self.variant().non_magnetic != 0.0 {
            let switched = Reading { interval: None, ..reading(label, best.best().switched) };
            facts.push(Fact::value("From switching alone", switched, ""));
        }
        let alike: Vec<String> = self
            .fillers()
            .filter(|(_, filler)| !std::ptr::eq(*filler, best) && self.is_as_good(filler.best()))
            .map(|(variant, filler)| self.named(variant, filler))
            .collect();
        if !alike.is_empty() {
            let more = alike.len().saturating_sub(MAX_NAMED);
            let mut names: Vec<String> = alike.into_iter().take(MAX_NAMED).collect();
            names.extend((more > 0).then(|| format!("{more} more")));
            facts.push(Fact::caveat(format!("not distinguishable: {}", listed(&names))));
        }
        if best.is_at_edge() {
            facts.push(Fact::caveat("the best interval is an end of those tried"));
        }
        facts
    }
}
