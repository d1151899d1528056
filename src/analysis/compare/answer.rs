//! The answer of a comparison, its notes, and the words of both.

use crate::analysis::compare::logs::{Analysis, Judged, RatioLimit, Row, Side, Subject, Verdict};
use crate::analysis::compare::{Length, NEAREST, SIGNIFICANT};
use crate::analysis::log::report::of_column;
use crate::analysis::requirement::{Decision, Standing, status, value_or_bound};
use sagnac_base::quantity::number::{interval_ends, probability, significant};
use sagnac_records::fit::Term;
use sagnac_report::answer::reading::{number, range};
use sagnac_report::answer::{Alternative, Answer, AnswerCell, AnswerTable, Fact, Kind, Reading};

/// The order in which coefficients are looked at.
const ORDER: [&str; 5] = ["N", "B", "Q", "K", "R"];

/// Most times as long as these that records are proposed.
const MAX_FACTOR: f64 = 1000.0;

impl Row {
    /// The ratio with its interval, where both ends are known.
    fn reading(&self) -> Option<Reading> {
        let ends = self.found.ratio_interval[0].zip(self.found.ratio_interval[1]).map(<[f64; 2]>::from);
        Some(Reading::in_unit("ratio", self.found.ratio?, "", ends))
    }

    /// The row in the table of an answer with these cells of a limit and of a test.
    fn cells(&self, status: &str, p: String, needed: String) -> Vec<AnswerCell> {
        let text = |ratio: &Reading| times(ratio.value, 3) + &ratio.in_brackets();
        let ratio = self.reading();
        let ratio = AnswerCell {
            text: ratio.as_ref().map_or_else(|| "—".to_owned(), text),
            value: ratio,
            ..AnswerCell::default()
        };
        let value =
            |k: usize| value_or_bound(self.name, self.found.values[k], self.found.at_most[k], self.symbol);
        let name = self.name.replace('_', " ");
        vec![name.into(), ratio, status.into(), p.into(), value(0), value(1), needed.into()]
    }

    fn is_apart(&self) -> bool {
        matches!(self.verdict(), Verdict::Higher | Verdict::Lower)
    }
}

impl Analysis {
    /// The answer of the comparison.
    pub fn decision(&self, limits: &[RatioLimit]) -> Decision {
        let labels = self.labels();
        let judged: Vec<Judged> = limits.iter().map(|limit| Judged::new(self, limit)).collect();
        let standings: Vec<Standing> = judged.iter().map(|one| one.standing).collect();
        let critical =
            judged.iter().max_by(|a, b| b.standing.cmp(&a.standing).then(a.upper().total_cmp(&b.upper())));
        let rows = self.ordered();
        let named = |name: &str| rows.iter().copied().find(|row| row.name == name);
        // Without a limit the difference that is the least probable by chance, else the first ratio.
        let apart = rows.iter().copied().filter(|row| row.is_apart());
        let p = |row: &Row| row.found.p.unwrap_or(1.0);
        let surest = apart.min_by(|a, b| p(a).total_cmp(&p(b)));
        let first = || rows.iter().copied().find(|row| row.found.ratio.is_some());
        let told = match critical {
            Some(critical) => named(critical.limit.term.symbol()),
            None => surest.or_else(first),
        };
        let (headline, value) = match critical {
            Some(critical) => (critical.headline(), told.and_then(Row::reading)),
            None => self.headline(told, labels),
        };
        let answer = Answer {
            kind: Kind::Estimate,
            status: status(&standings),
            headline,
            value,
            limit: critical.map(|one| Reading::in_unit("ratio", one.limit.most, "", None)),
            table: self.table(rows, told, &judged),
            facts: self.facts(critical, told),
            checks: vec![],
        };
        let judgements = judged.iter().map(|one| one.judgement(labels)).collect();
        Decision { answer, judgements }
    }

    /// The coefficients, those that data sheets have first.
    fn ordered(&self) -> Vec<&Row> {
        let mut rows: Vec<&Row> = self.rows.iter().flatten().filter(|_| !self.is_one_record).collect();
        rows.sort_by_key(|row| ORDER.iter().position(|name| *name == row.name).unwrap_or(ORDER.len()));
        rows
    }

    fn headline(&self, told: Option<&Row>, [a, b]: [&str; 2]) -> (String, Option<Reading>) {
        if self.is_one_record {
            return (format!("{a} and {b} are one record"), None);
        }
        let Some(row) = told else {
            let same = self.comparison.same.map(|same| match same.p < SIGNIFICANT {
                true => format!("The noise differs ({})", probability(same.p)),
                false => format!("No significant difference ({})", probability(same.p)),
            });
            return (same.unwrap_or_else(|| "No coefficient to compare".to_owned()), None);
        };
        let name = row.name;
        let is_noise = Term::ALL.iter().any(|term| term.symbol() == name);
        let Some(reading) = row.reading() else {
            let (more, less) = if row.verdict() == Verdict::Higher { (b, a) } else { (a, b) };
            let p = row.found.p.map(probability).unwrap_or_default();
            return (format!("{more} has more {name} than {less} ({p})"), None);
        };
        let ratio = reading.value;
        let headline = match row.is_apart() {
            false => {
                let ends = reading.in_brackets();
                format!("No significant difference: {name} ratio {}{ends}", times(ratio, 3))
            }
            // In percent up to twice as much.
            true if is_noise && (0.5..2.0).contains(&ratio) => {
                let word = if ratio > 1.0 { "noisier" } else { "quieter" };
                let percent = |ratio: f64| 100.0 * libm::fabs(ratio - 1.0);
                let ends = reading.interval.filter(|[low, high]| (*low > 1.0) == (*high > 1.0)).map(|ends| {
                    let [one, other] = ends.map(percent);
                    [one.min(other), one.max(other)]
                });
                let ends = ends.and_then(|ends| interval_ends(percent(ratio), ends));
                let ends = ends.map(|[low, high]| format!(" ({} %)", range(&low, &high))).unwrap_or_default();
                format!("{b} is {} % {word} in {name}{ends}", significant(percent(ratio), 2))
            }
            true => format!("{b} has {} × the {name} of {a}{}", number(ratio), reading.in_brackets()),
        };
        (headline, Some(reading))
    }

    /// A row for each coefficient: that of the headline, those with a limit, and those that neither log shows last.
    fn table(&self, mut rows: Vec<&Row>, told: Option<&Row>, judged: &[Judged]) -> AnswerTable {
        let standing = |row: &Row| {
            let own = judged.iter().find(|one| one.limit.term.symbol() == row.name);
            own.map(|one| one.standing.name())
        };
        rows.sort_by_key(|row| {
            let is_told = told.is_some_and(|told| told.name == row.name);
            (!is_told, standing(row).is_none(), row.found.values.iter().all(Option::is_none))
        });
        let row = |row: &&Row| match judged {
            [] => {
                let p = row.found.p.map_or_else(|| "—".to_owned(), probability);
                let needed = if row.is_apart() { String::new() } else { length(row.length) };
                row.cells("", p.trim_start_matches("p = ").trim_start_matches("p ").to_owned(), needed)
            }
            // A limit is judged by the ratio alone, and p is that of a difference.
            _ => row.cells(standing(row).unwrap_or_default(), String::new(), String::new()),
        };
        let [a, b] = self.labels();
        let heads = ["coefficient", "ratio (95 %)", "status", "p", a, b, "record to resolve"];
        AnswerTable { best: told.map(|_| 0), ..AnswerTable::new(heads, rows.iter().map(row)) }
    }

    fn facts(&self, critical: Option<&Judged>, told: Option<&Row>) -> Vec<Fact> {
        let mut facts = Vec::new();
        let records = |to: String| {
            let [a, b] = self.sides.each_ref().map(Side::extent);
            let from = if a == b { a } else { format!("{a} and {b}") };
            let (key, label) = ("length".to_owned(), "records".to_owned());
            Fact::ChangeToDecide { alternatives: vec![Alternative { key, label, from, to }] }
        };
        match critical {
            Some(critical) => {
                let factor = critical.factor(MAX_FACTOR).filter(|_| self.is_of_logs());
                facts.extend(factor.map(|factor| records(duration(factor * self.shorter_s()))));
                facts.extend(critical.why.iter().map(|why| Fact::Caveat { text: why.clone() }));
            }
            None => {
                let needed = told.filter(|row| !row.is_apart() && !matches!(row.length, Length::Unknown));
                facts.extend(needed.map(|row| records(length(row.length))));
            }
        }
        if let Some(same) = self.comparison.same.filter(|_| !self.is_one_record) {
            let longest = significant(same.longest_s, 4);
            facts.push(Fact::Test {
                name: "Test of equality".to_owned(),
                p: same.p,
                of: format!("{} averaging times up to {longest} s", same.times),
            });
        }
        let described = self.comparison.described();
        let rejected = self.sides.iter().zip(described).filter(|(_, is_described)| !is_described);
        facts.extend(
            rejected.map(|(side, _)| Fact::Caveat { text: format!("{}: no noise model fits", side.label) }),
        );
        facts.extend(
            self.rows.as_ref().err().map(|why| Fact::Caveat { text: format!("no coefficients: {why}") }),
        );
        let curves = || {
            let sides = self.sides.iter().filter(|_| !self.is_one_record);
            sides.filter_map(|side| Some((side.curve()?, &side.label)))
        };
        let assumed = curves().filter(|(curve, _)| curve.file.is_assumed);
        facts.extend(assumed.map(|(curve, label)| {
            Fact::caveat(format!("errors of the points of {label} are assumed: {}", curve.file.errors))
        }));
        let independent = "points of curves are taken as independent; their logs would give wider intervals";
        let has_independent = curves().any(|(curve, _)| curve.file.record.is_none());
        facts.extend(has_independent.then(|| Fact::caveat(independent)));
        facts
    }
}

/// All notes on the results.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    let mut notes: Vec<String> = analysis.sides.iter().flat_map(of_side).collect();
    if !analysis.is_of_logs() {
        notes.push(
            "the length of records that resolve a difference, and a test of both curves as a whole, follow from samples and are left out"
                .to_owned(),
        );
    }
    let has_curves = analysis.sides.iter().all(|side| side.subject.column().is_some());
    if analysis.comparison.ratios.is_empty() && has_curves {
        notes.push(
            "the curves have no averaging time in common, and only coefficients are compared".to_owned(),
        );
    }
    let common = &analysis.comparison.common;
    if common.farthest > 0.0 {
        notes.push(format!(
            "the averaging times of the records are up to {} % apart; those of {} are shown",
            significant(100.0 * common.farthest, 2),
            analysis.labels()[0]
        ));
    }
    if common.left_out > 0 {
        notes.push(format!(
            "{} averaging times are omitted, because the other record has none within {} %",
            common.left_out,
            significant(100.0 * NEAREST, 2)
        ));
    }
    if let Err(why) = &analysis.rows {
        notes.push(format!("no coefficients: {why}"));
    }
    notes
}

fn of_side(side: &Side) -> Vec<String> {
    let notes: Vec<String> = match &side.subject {
        Subject::Log(log) => log
            .reading
            .iter()
            .cloned()
            .chain(log.columns.iter().flat_map(|one| of_column(one, log)))
            .collect(),
        Subject::Curve(curve) => curve.notes(),
        Subject::Stated(stated) => stated.notes(),
    };
    notes.into_iter().map(|note| format!("{}: {note}", side.label)).collect()
}

/// Formats a duration with two digits, such as `31 h`.
pub fn duration(seconds: f64) -> String {
    const UNITS: [(f64, f64, &str); 5] = [
        (120.0, 1.0, "s"),
        (7200.0, 60.0, "min"),
        (72.0 * 3600.0, 3600.0, "h"),
        (730.0 * 86400.0, 86400.0, "days"),
        (f64::INFINITY, 365.25 * 86400.0, "years"),
    ];
    let (_, size, name) = UNITS.into_iter().find(|(most, ..)| seconds < *most).unwrap_or(UNITS[4]);
    format!("{} {name}", significant(seconds / size, 2))
}

/// The required length of a row, such as `31 h` or `> 2.1 years`; empty where it is unknown.
pub fn length(length: Length) -> String {
    match length {
        Length::Needed(length_s) => duration(length_s),
        Length::Beyond(length_s) => format!("> {}", duration(length_s)),
        Length::Unknown => String::new(),
    }
}

/// A ratio with `digits` digits, or near 1 with enough to distinguish it from 1.
pub fn times(ratio: f64, digits: usize) -> String {
    let shown = (digits..digits + 6).map(|digits| significant(ratio, digits));
    shown.into_iter().find(|text| text != "1").unwrap_or_else(|| "1".to_owned())
}
