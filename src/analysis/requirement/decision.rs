//! The decision to which records lead, as five lines.

use serde_json::{Value as Json, json};

use crate::allan::Unit;
use crate::analysis::compare::words::duration;
use crate::analysis::data_sheet::Row;
use crate::analysis::decision::Lines;
use crate::analysis::requirement::best::{by_margin, by_value, ranked};
use crate::analysis::requirement::judged::{Judged, Judgement, Standing, met};
use crate::analysis::requirement::largest::{runs, told as largest_told, usual};
use crate::analysis::requirement::lever;
use crate::analysis::requirement::limit::{Limit, Limited};
use crate::analysis::requirement::subject::{Gap, Subject};
use crate::quantity::list::listed;
use crate::quantity::number::percent;
use crate::view::report::agreement::capitalised;

/// Most judgements that are named in a sentence.
const MOST_NAMED: usize = 3;

/// A decision with the judgements on which it rests.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The five lines.
    pub lines: Lines,
    /// Each limit with each record to which it applies.
    pub judgements: Vec<Judgement>,
}

impl Decision {
    /// The decision as JSON.
    pub fn json(&self) -> Json {
        let mut document = self.lines.json();
        document["limits"] = json!(self.judgements.iter().map(Judgement::json).collect::<Vec<_>>());
        document
    }
}

/// The decision to which some records lead; `what` they are: `column`, or `unit` of a lot.
pub fn decide(subjects: &[Subject], limits: &[Limit], what: &str) -> Decision {
    let applies = |subject: &Subject, limit: &&Limit| subject.unit == limit.unit;
    let judged: Vec<Judged> = subjects
        .iter()
        .flat_map(|subject| {
            let own = limits.iter().filter(move |limit| applies(subject, limit));
            own.map(move |limit| Judged::new(subject, limit))
        })
        .collect();
    let panel = Panel { subjects, judged: &judged, what };
    let standings: Vec<Standing> = judged.iter().map(Judged::standing).collect();
    let met = met(&standings);
    let sentences = match judged.is_empty() {
        true => panel.without_limits(),
        false => [
            panel.requirement(met),
            by_margin(&judged, subjects, what),
            panel.margin(),
            panel.limits(),
            panel.lever(),
        ],
    };
    Decision { lines: Lines { met, sentences }, judgements: judged.iter().map(Judged::judgement).collect() }
}

/// Records with their judgements.
struct Panel<'a> {
    subjects: &'a [Subject<'a>],
    judged: &'a [Judged<'a>],
    what: &'a str,
}

impl<'a> Panel<'a> {
    /// Which record a statement is on, where there are several.
    fn of(&self, subject: &Subject) -> String {
        if self.subjects.len() > 1 { format!(" of {}", subject.label) } else { String::new() }
    }

    fn requirement(&self, met: Option<bool>) -> String {
        let all = self.judged.len();
        let of =
            |standing: Standing| self.judged.iter().filter(move |one| one.standing() == standing).count();
        let mut named: Vec<&Judged> = match met {
            Some(true) => self.judged.iter().collect(),
            Some(false) => self.judged.iter().filter(|one| one.standing() == Standing::NotMet).collect(),
            None => self.judged.iter().filter(|one| one.standing() != Standing::Met).collect(),
        };
        named.sort_by(|a, b| b.upper().total_cmp(&a.upper()));
        named.truncate(MOST_NAMED);
        let told = |one: &&Judged| match self.subjects.len() {
            1 => one.told(),
            _ => format!("{}: {}", one.subject.label, one.told()),
        };
        let told: Vec<String> = named.iter().map(told).collect();
        let begin = match met {
            Some(true) => "Met",
            Some(false) => "Not met",
            None => "Not decided",
        };
        let counted = |standing: Standing| match of(standing) {
            0 => None,
            1 => Some(format!("1 is {}", standing.name())),
            count => Some(format!("{count} are {}", standing.name())),
        };
        let counts = [Standing::Met, Standing::Open, Standing::Unknown, Standing::NotMet]
            .into_iter()
            .filter_map(counted);
        let each = if self.subjects.len() > 1 {
            format!(", counted for each {},", self.what)
        } else {
            String::new()
        };
        let counted = match all > named.len() {
            true => format!(" Of {all} limits{each} {}.", listed(&counts.collect::<Vec<_>>())),
            false => String::new(),
        };
        format!("{begin}: {}.{counted}", told.join("; "))
    }

    /// The judgement of which the unfavourable end of the interval is the farthest up.
    fn tightest(&self) -> Option<&Judged<'a>> {
        let known = self.judged.iter().filter(|one| one.shown.is_ok());
        known.max_by(|a, b| a.upper().total_cmp(&b.upper()))
    }

    /// The judgement that decides: the worst standing, and of several the least margin.
    fn critical(&self) -> Option<&Judged<'a>> {
        let worse =
            |a: &&Judged, b: &&Judged| b.standing().cmp(&a.standing()).then(a.upper().total_cmp(&b.upper()));
        self.judged.iter().max_by(worse)
    }

    fn margin(&self) -> String {
        let Some(tightest) = self.tightest() else {
            return "Unknown, because no limit can be judged.".to_owned();
        };
        let margin = tightest.margin().unwrap_or_default();
        match self.judged.len() {
            1 => margin,
            _ => format!(
                "The least is that of {}{}. {margin}",
                tightest.of().told(),
                self.of(tightest.subject)
            ),
        }
    }

    fn limits(&self) -> String {
        let Some(critical) = self.critical() else { return String::new() };
        let (subject, name) = (critical.subject, critical.of().told());
        let whose = format!("{name}{}", self.of(subject));
        let identified = critical.shown.as_ref().is_ok_and(|shown| shown.value.is_some());
        let length = duration(subject.length_s());
        let told = match critical.standing() {
            Standing::NotMet => format!(
                "{whose}: even the lower end of its interval is above the limit, so the length of the record, {length}, is not what \
                 limits."
            ),
            Standing::Open if identified => {
                format!("{whose}: its interval from a record of {length} is too wide to decide.")
            }
            Standing::Open if critical.of() == Limited::Stability => {
                format!(
                    "{whose}: the curve of the record of {length} still falls at an eighth of its length."
                )
            }
            Standing::Open => {
                format!("{whose}: the record of {length} does not show it, and bounds it above the limit.")
            }
            Standing::Met if self.judged.len() == 1 => String::new(),
            Standing::Met => format!("{whose} has the least margin."),
            Standing::Unknown => match self.subjects.len() {
                1 => format!("{}.", critical.told()),
                _ => format!("{}: {}.", subject.label, critical.told()),
            },
        };
        // The name of a record stays as it is.
        let is_begun = critical.standing() == Standing::Unknown && self.subjects.len() > 1;
        let told = if is_begun { told } else { capitalised(&told) };
        match (told.is_empty(), self.largest(subject)) {
            (true, None) => "No term can be named without a fit that describes the curve.".to_owned(),
            (true, Some(largest)) => largest,
            (false, None) => told,
            (false, Some(largest)) => format!("{told} {largest}"),
        }
    }

    /// Which terms are the largest at which τ; `None` without a fit that describes its curve.
    fn largest(&self, subject: &Subject) -> Option<String> {
        Some(largest_told(&runs(subject, subject.fit().ok()?), &self.of(subject)))
    }

    fn lever(&self) -> String {
        let Some(critical) = self.critical() else { return String::new() };
        let told = lever::told(critical);
        match critical.standing() {
            Standing::Met => told,
            _ if self.subjects.len() > 1 => format!("{}: {told}", critical.subject.label),
            _ => told,
        }
    }

    fn without_limits(&self) -> [String; 5] {
        let worst = self.worst();
        let runs = worst.and_then(|subject| Some(runs(subject, subject.fit().ok()?)));
        let why = self.subjects.first().and_then(|subject| subject.fit().err());
        let limits = match (worst, &runs) {
            (Some(subject), Some(runs)) => largest_told(runs, &self.of(subject)),
            _ => format!("No term can be named: {}.", why.map_or_else(String::new, |gap| self.why(&gap))),
        };
        let begin = "Without a limit nothing has to change";
        let lever = match runs.as_deref().map(usual) {
            Some(Some(term)) => format!(
                "{begin}; {} is the largest part at the most octaves of τ, where lowering it gains most.",
                Limited::Coefficient(term).told()
            ),
            Some(None) => format!("{begin}; no identified term is the largest part at any τ."),
            None => format!("{begin}."),
        };
        [self.shown(), by_value(self.subjects, self.what), self.width(), limits, lever]
    }

    fn why(&self, gap: &Gap) -> String {
        match (gap, self.subjects.len()) {
            (Gap::NotDescribed, 1) => "the fit describes no range of τ".to_owned(),
            (Gap::NotDescribed, _) => "no fit describes a range of τ".to_owned(),
            (Gap::Failed(why), 1) => format!("there are no coefficients: {why}"),
            (Gap::Failed(_), _) => format!("no {} has coefficients that describe it", self.what),
            _ => "no coefficients were fitted".to_owned(),
        }
    }

    /// The requirement without one: what is identified.
    fn shown(&self) -> String {
        let [only] = self.subjects else { return "None is given.".to_owned() };
        let Some(sheet) = only.noise.ok().flatten().filter(|_| only.fit().is_ok()) else {
            return "None is given.".to_owned();
        };
        let names: Vec<&str> =
            sheet.rows.iter().filter(|row| row.value.is_some()).map(|row| row.name).collect();
        match names.is_empty() {
            true => "None is given, and no coefficient is identified.".to_owned(),
            false => format!("None is given; the record identifies {}.", listed(&names)),
        }
    }

    /// The record with the largest value of the compared coefficient; else the first with a fit.
    fn worst(&self) -> Option<&'a Subject<'a>> {
        let ranked = Unit::ALL.into_iter().find_map(|unit| ranked(self.subjects, unit, 1));
        let worst = ranked.and_then(|ranked| ranked.by_value.last().map(|(subject, ..)| *subject));
        worst.or_else(|| self.subjects.iter().find(|subject| subject.fit().is_ok()))
    }

    /// How wide the interval of the compared coefficient is.
    fn width(&self) -> String {
        let ranked = Unit::ALL.into_iter().find_map(|unit| ranked(self.subjects, unit, 1));
        let relative = |row: &Row, value: f64| row.interval.map(|ends| ends.map(|end| end / value - 1.0));
        let widest = ranked.and_then(|ranked| {
            let widths = ranked.by_value.iter();
            let widths = widths.filter_map(|(subject, row, value)| Some((*subject, relative(row, *value)?)));
            let (subject, ends) = widths.max_by(|a, b| (a.1[1] - a.1[0]).total_cmp(&(b.1[1] - b.1[0])))?;
            Some((ranked.term, subject, ends))
        });
        let Some((term, subject, [low, high])) = widest else {
            return "Without a limit there is none, and no coefficient has a value.".to_owned();
        };
        let name = term.symbol();
        let which = match self.subjects.len() {
            1 => format!("the 95 % interval of {name}"),
            _ => format!("the widest 95 % interval of {name}, that of {},", subject.label),
        };
        format!(
            "Without a limit there is none; {which} is {} to +{} of its value.",
            percent(low),
            percent(high)
        )
    }
}
