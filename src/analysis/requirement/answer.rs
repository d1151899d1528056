//! The answer of records: what they show of their noise, and whether that meets limits.

use crate::analysis::data_sheet::Row;
use crate::analysis::requirement::check::{
    Judged, Judgement, Shown, Standing, Subject, columns, to_decide, to_meet,
};
use crate::analysis::requirement::{Limit, Limited};
use sagnac_base::quantity::number::significant;
use sagnac_base::table::Table;
use sagnac_base::table::column::columns_of;
use sagnac_records::allan::Unit;
use sagnac_records::fit::{Quantity, Term};
use sagnac_report::answer::{
    Answer, AnswerCell, AnswerTable, Fact, Kind, MAX_COLUMNS, MAX_ROWS, Reading, Relation, Status,
};

/// Most records whose table has the intervals too, each in a line of its own: the axes of an IMU.
const MAX_WITH_INTERVALS: usize = 6;

/// Coefficients by which records are compared without a limit, the first that they show.
const ORDER: [Term; 5] =
    [Term::AngleRandomWalk, Term::BiasInstability, Term::Quantization, Term::RateRandomWalk, Term::RateRamp];

/// The answer of records with the judgements on which it rests.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The answer.
    pub answer: Answer,
    /// Each limit with each record to which it applies.
    pub judgements: Vec<Judgement>,
}

impl Decision {
    /// The judgements as a table.
    pub fn table(&self) -> Table {
        Table { columns: columns_of(&columns(), &self.judgements) }
    }

    /// The file of the judgements; `None` without limits.
    pub fn file(&self) -> Option<(&'static str, Table)> {
        (!self.judgements.is_empty()).then(|| ("limits.csv", self.table()))
    }
}

/// The answer of some records, each called `what`: `column` of a log, or `unit` of a batch.
pub fn decide(subjects: &[Subject], limits: &[Limit], what: &str) -> Decision {
    let judged: Vec<Judged> = subjects
        .iter()
        .flat_map(|subject| {
            let own = limits.iter().filter(move |limit| subject.unit == limit.unit);
            own.map(move |limit| Judged::new(subject, limit))
        })
        .collect();
    let panel = Panel { subjects, judged: &judged };
    let (headline, value) = panel.headline();
    let answer = Answer {
        kind: if judged.is_empty() { Kind::Estimate } else { Kind::Requirement },
        status: status(&judged.iter().map(Judged::standing).collect::<Vec<_>>()),
        headline,
        value,
        limit: panel.critical().map(Judged::limit),
        table: match subjects {
            [only] => panel.coefficients(only),
            _ => panel.records(what),
        },
        facts: panel.facts(),
        checks: vec![],
    };
    Decision { answer, judgements: judged.iter().map(Judged::judgement).collect() }
}

/// The state of several limits together.
pub(crate) fn status(standings: &[Standing]) -> Status {
    let count = |standing: Standing| standings.iter().filter(|one| **one == standing).count();
    let (all, met) = (standings.len(), count(Standing::Met));
    match (all, met, count(Standing::NotMet)) {
        (0, ..) => Status::NoLimit,
        (all, met, _) if met == all => Status::Met,
        (_, _, 0) => Status::Inconclusive,
        (_, 0, _) => Status::NotMet,
        (of, met, _) => Status::PartlyMet { met, of },
    }
}

/// The name of a row in headlines.
fn name(row: &Row) -> &'static str {
    if row.name == Limited::Stability.name() { "in-run bias stability" } else { row.name }
}

/// What the record shows of a coefficient, in a word or two.
fn state(row: &Row) -> &'static str {
    row.verdict.split(',').next().unwrap_or_default()
}

/// A value, or its upper limit.
pub(crate) fn value_or_bound(name: &str, value: Option<f64>, most: Option<f64>, symbol: &str) -> AnswerCell {
    let reading = |value: f64| Reading::in_unit(name, value, symbol, None);
    match (value, most) {
        (Some(value), _) => reading(value).into(),
        (None, Some(most)) => AnswerCell::bounded(Relation::AtMost, reading(most)),
        (None, None) => "—".to_owned().into(),
    }
}

impl Row {
    /// The value with its interval; `None` where the record does not show it.
    pub(crate) fn reading(&self) -> Option<Reading> {
        Some(Reading::in_unit(self.name, self.value?, self.symbol, self.interval))
    }

    /// The value, or the bound, as answers have it.
    pub(crate) fn cell(&self) -> AnswerCell {
        match self.reading() {
            Some(reading) => reading.into(),
            None => value_or_bound(self.name, None, self.interval.map(|[_, most]| most), self.symbol),
        }
    }
}

/// Records with their judgements.
struct Panel<'a> {
    subjects: &'a [Subject<'a>],
    judged: &'a [Judged<'a>],
}

impl<'a> Panel<'a> {
    /// The name of a record in front of a headline, where there are several.
    fn whose(&self, subject: &Subject) -> String {
        if self.subjects.len() > 1 { format!("{}: ", subject.label) } else { String::new() }
    }

    /// The judgement that decides: the worst standing, and of several the least margin.
    fn critical(&self) -> Option<&Judged<'a>> {
        let worse =
            |a: &&Judged, b: &&Judged| b.standing().cmp(&a.standing()).then(a.upper().total_cmp(&b.upper()));
        self.judged.iter().max_by(worse)
    }

    fn headline(&self) -> (String, Option<Reading>) {
        if let Some(critical) = self.critical() {
            let whose = self.whose(critical.subject);
            return (whose + &critical.headline(), critical.reading());
        }
        let ranked = Unit::ALL.into_iter().find_map(|unit| self.ranked(unit));
        if let Some((subject, row, reading)) = ranked.and_then(|all| all.into_iter().next()) {
            let value = reading.with_interval();
            let headline = match self.subjects.len() {
                1 => format!("{} = {value}", name(row)),
                _ => format!("{}: smallest {}, {value}", subject.label, name(row)),
            };
            return (headline, Some(reading));
        }
        let bound = self.subjects.iter().find_map(|subject| {
            let row = |term: Term| subject.shown(Limited::Coefficient(term)).ok();
            ORDER.into_iter().find_map(|term| Some((subject, row(term)?)))
        });
        if let Some((subject, row)) = bound {
            return (format!("{}{} {}", self.whose(subject), name(row), row.cell().text), None);
        }
        let rejected = self.subjects.iter().any(|subject| matches!(subject.noise, Ok(Some(_))));
        let minimum = self.subjects.iter().find_map(|subject| Some((subject, subject.stability.as_ref()?)));
        let only = if rejected { "No noise model fits; " } else { "" };
        match minimum {
            Some((subject, row)) => {
                let reading = row.reading();
                let value = reading.as_ref().map_or_else(|| row.cell().text, Reading::with_interval);
                (format!("{}{only}curve minimum {value}", self.whose(subject)), reading)
            }
            None if rejected => ("No noise model fits".to_owned(), None),
            None => ("No coefficient and no curve minimum".to_owned(), None),
        }
    }

    /// The records of a unit by the first coefficient of which one has a value, the least first.
    fn ranked(&self, unit: Unit) -> Option<Vec<(&'a Subject<'a>, &'a Row, Reading)>> {
        let alike = || self.subjects.iter().filter(move |subject| subject.unit == unit);
        ORDER.into_iter().find_map(|term| {
            let row = |subject: &'a Subject<'a>| {
                let row = subject.shown(Limited::Coefficient(term)).ok()?;
                Some((subject, row, row.reading()?))
            };
            let mut by_value: Vec<_> = alike().filter_map(row).collect();
            by_value.sort_by(|a, b| a.2.value.total_cmp(&b.2.value));
            (!by_value.is_empty()).then_some(by_value)
        })
    }

    /// A row for each coefficient of a record.
    fn coefficients(&self, subject: &Subject) -> AnswerTable {
        let rows = subject.noise.ok().flatten().map_or(&[][..], |sheet| &sheet.rows);
        let (stability, floor) = (subject.stability.iter(), subject.floor.into_iter());
        let floor = floor.filter(|_| self.judged.iter().any(|one| one.of() == Limited::Floor));
        let line = |(row, title, state): (&Row, &str, &str)| -> Vec<AnswerCell> {
            let interval = row.reading().and_then(|reading| reading.ends_text()).unwrap_or_default();
            vec![title.to_owned().into(), row.cell(), interval.into(), state.to_owned().into()]
        };
        let at = subject.stability_tau_s.map(|tau_s| format!("τ = {} s", significant(tau_s, 3)));
        let state = |row: &Row| self.judgement(row).map_or_else(|| state(row), |one| one.standing().name());
        let all: Vec<(&Row, String, String)> = rows
            .iter()
            .map(|row| (row, title(row.name, subject.unit), state(row).to_owned()))
            .chain(stability.map(|row| {
                let state = self.judgement(row).map(|one| one.standing().name().to_owned());
                (row, "curve minimum".to_owned(), state.or(at.clone()).unwrap_or_default())
            }))
            .chain(floor.map(|row| (row, "N of the floor".to_owned(), state(row).to_owned())))
            .collect();
        // What the record shows, and what has a limit, takes precedence.
        let is_shown = |row: &Row| row.value.is_some() || self.judgement(row).is_some();
        let mut spare = all.len().saturating_sub(MAX_ROWS);
        let mut kept: Vec<&(&Row, String, String)> = all.iter().collect();
        for place in (0..kept.len()).rev() {
            if spare > 0 && !is_shown(kept[place].0) {
                kept.remove(place);
                spare -= 1;
            }
        }
        kept.truncate(MAX_ROWS);
        let headed = self.critical().map(|one| one.of().name());
        let best = kept.iter().position(|(row, ..)| match headed {
            Some(name) => row.name == name,
            None => ORDER.iter().any(|term| term.symbol() == row.name) && row.value.is_some(),
        });
        let first = ORDER.iter().find_map(|term| {
            kept.iter().position(|(row, ..)| row.name == term.symbol() && row.value.is_some())
        });
        let heads = ["coefficient", "estimate", "95 % interval", "status"];
        AnswerTable {
            columns: heads.map(str::to_owned).into(),
            best: if headed.is_some() { best } else { first.or(best) },
            omitted: all.len() - kept.len(),
            rows: kept.into_iter().map(|(row, title, state)| line((row, title, state))).collect(),
            ..AnswerTable::default()
        }
    }

    fn judgement(&self, row: &Row) -> Option<&Judged<'a>> {
        self.judged.iter().find(|one| one.is_of(row))
    }

    /// A row for each of several records: those with the least margin first, without limits those with the least value.
    fn records(&self, what: &str) -> AnswerTable {
        let upper = |subject: &Subject| {
            let own = self.judged.iter().filter(|one| std::ptr::eq(one.subject, subject));
            own.map(Judged::upper).fold(0.0, f64::max)
        };
        let mut subjects: Vec<&Subject> = self.subjects.iter().collect();
        match self.judged.is_empty() {
            false => subjects.sort_by(|a, b| upper(b).total_cmp(&upper(a))),
            true => {
                let ranked: Vec<_> = Unit::ALL.into_iter().filter_map(|unit| self.ranked(unit)).collect();
                let place = |subject: &Subject| {
                    let all = ranked.iter().flatten();
                    all.map(|(other, ..)| *other).position(|other| std::ptr::eq(other, subject))
                };
                subjects.sort_by_key(|subject| place(subject).unwrap_or(usize::MAX));
            }
        }
        let is_limited = |of: &Limited| self.judged.iter().any(|one| one.of() == *of);
        let has_value = |of: &Limited| {
            subjects.iter().any(|subject| subject.shown(*of).is_ok_and(|row| row.value.is_some()))
        };
        let all = ORDER.into_iter().map(Limited::Coefficient).chain([Limited::Stability]);
        let (first, others): (Vec<Limited>, Vec<Limited>) =
            Limited::OF_LOG.into_iter().chain([Limited::Floor]).partition(is_limited);
        let others: Vec<Limited> = all.filter(|of| others.contains(of)).collect();
        let is_given = |of: &Limited| subjects.iter().any(|subject| subject.shown(*of).is_ok());
        // Bounds alone are shown where there are no values at all.
        let has_values = !first.is_empty() || others.iter().any(has_value);
        let others = others.into_iter().filter(|of| if has_values { has_value(of) } else { is_given(of) });
        let is_judged = !self.judged.is_empty();
        let most = MAX_COLUMNS - 1 - usize::from(is_judged);
        // The status is that of the columns before it.
        let limited = 1 + first.len().min(most);
        let shown: Vec<Limited> = first.into_iter().chain(others).take(most).collect();
        // Those of a single coefficient have a column.
        let ends = |subject: &Subject| match &shown[..] {
            [only] => subject.shown(*only).ok()?.reading()?.ends_text(),
            _ => None,
        };
        let has_interval = subjects.iter().any(|subject| ends(subject).is_some());
        let row = |subject: &&Subject| {
            let cell = |of: &Limited| subject.shown(*of).map_or_else(|_| "—".into(), Row::cell);
            let own: Vec<Standing> = self
                .judged
                .iter()
                .filter(|one| std::ptr::eq(one.subject, *subject))
                .map(Judged::standing)
                .collect();
            let mut cells = vec![AnswerCell::from(subject.label)];
            cells.extend(shown.iter().map(cell));
            if is_judged {
                cells.insert(limited, status(&own).text().into());
            }
            if has_interval {
                cells.insert(2, ends(subject).unwrap_or_default().into());
            }
            cells
        };
        let mut heads = vec![what];
        heads.extend(shown.iter().map(|of| of.told().trim_start_matches("the ")));
        if is_judged {
            heads.insert(limited, "status");
        }
        if has_interval {
            heads.insert(2, "95 % interval");
        }
        AnswerTable {
            best: Some(0),
            shows_intervals: shown.len() > 1 && subjects.len() <= MAX_WITH_INTERVALS,
            ..AnswerTable::new(heads, subjects.iter().map(row))
        }
    }

    fn facts(&self) -> Vec<Fact> {
        let change = self.critical().and_then(|critical| match (&critical.shown, critical.standing()) {
            (Ok(Shown { value: Some(value), .. }), Standing::NotMet) => to_meet(critical, *value),
            (Ok(Shown { value: Some(value), ends }), Standing::Open) => to_decide(critical, *value, *ends),
            _ => None,
        });
        let unknown = self.judged.iter().filter_map(|one| {
            let why = one.shown.as_ref().err()?;
            Some(format!("{}{why}", self.whose(one.subject)))
        });
        let failed = self.subjects.iter().filter_map(|subject| {
            let why = subject.noise.err()?;
            Some(format!("{}no coefficients: {why}", self.whose(subject)))
        });
        let rejected = self.subjects.iter().filter(|_| self.subjects.len() > 1).filter_map(|subject| {
            let sheet = subject.noise.ok()??;
            (!sheet.fit.is_described()).then(|| format!("{}: no noise model fits", subject.label))
        });
        let mut caveats: Vec<String> = Vec::new();
        for caveat in unknown.chain(failed).chain(rejected) {
            if !caveats.contains(&caveat) {
                caveats.push(caveat);
            }
        }
        let caveats = caveats.into_iter().take(MAX_CAVEATS).map(|text| Fact::Caveat { text });
        change.into_iter().chain(caveats).collect()
    }
}

/// Most caveats that are shown.
const MAX_CAVEATS: usize = 2;

/// The symbol of a coefficient with its name, such as `N, angle random walk`.
fn title(symbol: &str, unit: Unit) -> String {
    let quantity = Quantity::all(&Term::ALL).into_iter().find(|quantity| quantity.name() == symbol);
    match quantity.map(|quantity| quantity.title(unit)) {
        Some(title) => match title.strip_suffix(symbol) {
            Some(words) => format!("{symbol}, {}", words.trim_end()),
            None => title.to_owned(),
        },
        None => symbol.replace("in_run", "in-run").replace('_', " "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_that_some_records_meet_are_partly_met() {
        use Standing::{Met, NotMet, Open, Unknown};
        assert_eq!(status(&[]), Status::NoLimit);
        assert_eq!(status(&[Met, Met]), Status::Met);
        assert_eq!(status(&[Met, NotMet, Open]), Status::PartlyMet { met: 1, of: 3 });
        assert_eq!(status(&[Met, Unknown]), Status::Inconclusive);
        assert_eq!(status(&[NotMet, Open]), Status::NotMet);
    }

    #[test]
    fn coefficients_are_named_by_symbol_and_words() {
        assert_eq!(title("N", Unit::Angular), "N, angle random walk");
        assert_eq!(title("markov_time", Unit::Angular), "correlation time of the Markov noise");
        assert_eq!(title("in_run_bias_stability", Unit::Angular), "in-run bias stability");
    }
}
