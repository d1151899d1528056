//! The answer of a log.

use crate::analysis::log::{Column, events};
use crate::analysis::requirement::{Decision, Limit, Subject, decide};
use crate::analysis::spectrum::{Analysis, Spectrum};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::Deviation;
use sagnac_report::answer::{Fact, Reading};

/// Most events that are named; the page has all.
const MAX_EVENTS: usize = 3;

impl Analysis {
    /// The answer of the log: its coefficients, the minima of its curves, and N of its densities where there are some.
    pub fn decision(&self, limits: &[Limit]) -> Decision {
        let floor = |place: usize| self.spectra.get(place)?.white.from_floor.as_ref();
        let columns = self.noise.columns.iter().enumerate();
        let subjects: Vec<Subject> =
            columns.map(|(place, column)| Subject::of_column(&self.noise, column, floor(place))).collect();
        let mut decision = decide(&subjects, limits, "column");
        let facts = &mut decision.answer.facts;
        if let [column] = &self.noise.columns[..] {
            let fit = column.noise().map(|noise| &noise.fit).filter(|fit| fit.is_described());
            facts.extend(fit.map(|fit| Fact::Fit {
                tau_s: fit.tau_range,
                chi_squared: fit.chi_squared,
                degrees_of_freedom: fit.degrees_of_freedom,
                p: fit.p_value(),
            }));
        }
        facts.extend(self.highest_line());
        facts.extend(self.events());
        decision
    }

    /// The line that is the highest above its floor.
    fn highest_line(&self) -> Option<Fact> {
        let lines = |(column, spectrum): (&'_ Column, &'_ Spectrum)| {
            let unit = column.unit.symbol(Deviation::Oadev);
            spectrum.lines.iter().map(|line| (column.name.clone(), unit, line.clone())).collect::<Vec<_>>()
        };
        let all: Vec<_> = self.columns().flat_map(lines).collect();
        let (name, unit, line) = all.iter().max_by(|a, b| a.2.over_floor.total_cmp(&b.2.over_floor))?;
        let of = if self.noise.columns.len() > 1 { format!(" in {name}") } else { String::new() };
        let more = if all.len() > 1 { format!("; {} lines", all.len()) } else { String::new() };
        let (frequency, over) = (significant(line.frequency_hz, 4), significant(line.over_floor, 3));
        Some(Fact::Value {
            name: "Spectral line".to_owned(),
            value: Reading::in_unit("amplitude", line.amplitude, unit, None),
            at: format!("at {frequency} Hz{of}, {over} × floor{more}"),
        })
    }

    /// What the record shows besides noise.
    fn events(&self) -> Option<Fact> {
        let mut names: Vec<String> = Vec::new();
        for row in events::rows(&self.noise) {
            let name = row.brief(self.noise.columns.len() > 1);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let more = names.len().saturating_sub(MAX_EVENTS);
        names.truncate(MAX_EVENTS);
        let more = if more > 0 { format!("; {more} more") } else { String::new() };
        (!names.is_empty()).then(|| Fact::Caveat { text: names.join("; ") + &more })
    }
}
