//! The decision sheet as sentences and as JSON.

use serde_json::{Value as Json, json};

use crate::analysis::decision::Figure;
use crate::analysis::decision::budget::Part;
use crate::analysis::decision::choice::{Choice, Next};
use crate::analysis::decision::lever::{Found, Lever, Needed};
use crate::analysis::decision::lines::Lines;
use crate::analysis::decision::varied::Varied;
use crate::analysis::decision::words::{LEVEL, margin_in_words, rounded, with_interval};
use crate::chart::Limit;
use crate::quantity::list::listed;
use crate::quantity::number::percent;
use crate::table::{Unit, titled, worded};
use crate::view::report::agreement::capitalised;

/// Parts below this fraction of the mean square are not worth a line.
const LEAST_SHARE: f64 = 0.005;

/// The decision sheet of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Label of the judged estimate.
    pub label: String,
    /// Its unit.
    pub unit: Unit,
    /// The limit, where there is one.
    pub limit: Option<Limit>,
    /// The best option; empty where there is only one.
    pub option: String,
    /// Number of options.
    pub options: usize,
    /// The condition under which the best option is worst; empty where there is only one.
    pub condition: String,
    /// Whether a condition has a whole curve over the averaging time, which counts at its minimum.
    pub is_minimum: bool,
    /// Number of conditions under which it is within the limit, and of all conditions.
    pub met: [usize; 2],
    /// The estimate of the best option under that condition.
    pub value: Figure,
    /// Options with the same value as the best one.
    pub equal: Vec<String>,
    /// The next best option.
    pub next: Option<Next>,
    /// Fillers that are no options, because firmware cannot have them.
    pub left_out: Vec<String>,
    /// The error budget, the largest part first; empty where there is none.
    pub budget: Vec<Part>,
    /// The next lever.
    pub lever: Option<Lever>,
    /// Where there is no lever, the first input tried that gains under the worst condition, but makes another one as bad.
    pub only_here: Option<Lever>,
    /// Whether inputs were searched for it.
    pub is_searched: bool,
    /// Whether notches interrupt the judged curves.
    pub is_notched: bool,
    /// Whether the best option is the shortest record that meets the limit as often.
    pub is_shortest: bool,
    /// Whether a map shows where each option is the best.
    pub is_mapped: bool,
    /// The change of a swept key of the gyro itself that gains most.
    pub varied: Option<Varied>,
    /// Labels of the swept keys that are conditions, which no lever is, and of all swept keys.
    pub swept: [Vec<String>; 2],
    /// The sentences of a study that asks which coefficients records show, instead of those on the estimate.
    pub shown: Option<[String; 5]>,
}

impl Sheet {
    pub(crate) fn new(choice: &Choice, budget: Vec<Part>, found: Option<Found>) -> Sheet {
        let is_searched = found.is_some();
        let Found { lever, only_here } = found.unwrap_or_default();
        Sheet {
            label: choice.column.label.clone(),
            unit: choice.column.unit,
            limit: choice.limit,
            option: choice.option.clone(),
            options: choice.options,
            condition: choice.condition.clone(),
            is_minimum: choice.is_minimum,
            met: choice.met,
            value: (choice.value(), choice.interval()).into(),
            equal: choice.equal.clone(),
            next: choice.next.clone(),
            left_out: choice.left_out.clone(),
            is_shortest: choice.is_shortest,
            varied: choice.varied.clone(),
            is_mapped: choice.is_mapped,
            budget,
            lever,
            only_here,
            is_searched,
            is_notched: choice.is_notched,
            swept: choice.swept.clone(),
            shown: None,
        }
    }

    /// Whether the best option meets the limit under all conditions; `None` without a limit, and where the 95 % interval
    /// contains it.
    pub fn is_met(&self) -> Option<bool> {
        let limit = self.limit?.value;
        (!self.is_open(limit)).then_some(self.value.value <= limit)
    }

    fn is_open(&self, limit: f64) -> bool {
        self.value.interval.is_some_and(|(low, high)| low <= limit && limit < high)
    }

    /// The fraction of the limit that is left; negative where it is exceeded.
    pub fn margin(&self) -> Option<Figure> {
        let limit = self.limit?.value;
        let left = |value: f64| 1.0 - value / limit;
        let interval = self.value.interval.map(|(low, high)| (left(high), left(low)));
        Some(Figure { value: left(self.value.value), interval })
    }

    /// The five lines of the sheet: a heading with a sentence each.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        if let Some(sentences) = &self.shown {
            return Lines { met: None, sentences: sentences.clone() }.headed();
        }
        let sentences =
            [self.requirement(), self.best(), self.margin_told(), self.limits(), self.lever_told()];
        Lines { met: self.is_met(), sentences }.headed()
    }

    pub(super) fn shown(&self, value: f64) -> String {
        if !value.is_finite() {
            return "unknown".to_owned();
        }
        Limit { value: rounded(value), unit: self.unit }.text()
    }

    /// Where the best option is worst, as the end of a sentence.
    pub(super) fn at(&self) -> String {
        if self.condition.is_empty() { String::new() } else { format!(" at {}", self.condition) }
    }

    fn requirement(&self) -> String {
        let (label, value, at) = (worded(&self.label), self.shown(self.value.value), self.at());
        let which = match (self.met[1] > 1, self.is_minimum) {
            (true, true) => "largest minimum of the ",
            (true, false) => "largest ",
            (false, true) => "least ",
            (false, false) => "",
        };
        let of_best = if self.options > 1 { " of the best option" } else { "" };
        let told = format!("the {which}{label}{of_best} is {value}{at}");
        match (self.limit, self.is_met()) {
            // Both sides of the limit are in the interval.
            (Some(limit), _) if self.is_open(limit.value) => {
                format!("Not decided by these trials: {told}, whose 95 % interval contains {}.", limit.text())
            }
            (Some(limit), Some(true)) => format!("Met: {told}, within {}.", limit.text()),
            (Some(limit), _) => {
                let [met, all] = self.met;
                let part =
                    if met > 0 { format!("Met under {met} of {all} conditions") } else { "Not met".into() };
                match self.value.value.is_finite() {
                    true => format!("{part}: {told}, above {}.", limit.text()),
                    false => format!("{part}: {told}, so that nothing shows it within {}.", limit.text()),
                }
            }
            (None, _) if !self.value.value.is_finite() => "None is given.".to_owned(),
            (None, _) => format!("None is given; {told}."),
        }
    }

    fn best(&self) -> String {
        let left_out = match &self.left_out[..] {
            [] => String::new(),
            names => format!(" {} would need a motion that firmware does not know.", listed(names)),
        };
        if self.options < 2 {
            let [conditions, all] = &self.swept;
            let fixed: Vec<&String> = all.iter().filter(|label| !conditions.contains(label)).collect();
            let none = match (&conditions[..], &fixed[..]) {
                ([], _) => "There is only one option.".to_owned(),
                (conditions, []) => {
                    format!("None is compared: the study varies conditions only ({}).", listed(conditions))
                }
                (conditions, fixed) => format!(
                    "None is compared: what is judged has one {}, and varies conditions only ({}).",
                    listed(fixed),
                    listed(conditions)
                ),
            };
            return format!("{none}{left_out}");
        }
        let equal = match &self.equal[..] {
            [] => String::new(),
            names => format!(" (as good: {})", listed(names)),
        };
        let [met, all] = self.met;
        let next = match &self.next {
            _ if self.is_shortest => {
                let under = match all {
                    1 => String::new(),
                    all => format!(" under {met} of {all} conditions"),
                };
                format!(", the shortest of {} lengths within the limit{under}", self.options)
            }
            // The option that meets the limit more often may be the one with the larger value.
            Some(Next { option, met: less, .. }) if *less != met => {
                let other = if self.options == 2 { "the other one," } else { "next is" };
                format!(", within the limit under {met} of {all} conditions; {other} {option}, under {less}")
            }
            Some(Next { option, value, is_alike: true, .. }) => format!(
                ", of {} options; but {option} has {}, and the 95 % intervals show no difference",
                self.options,
                self.shown(*value)
            ),
            Some(Next { option, value, .. }) if self.options == 2 => {
                format!("; the other one, {option}, has {}", self.shown(*value))
            }
            Some(Next { option, value, .. }) => {
                format!(", of {} options; next is {option} with {}", self.options, self.shown(*value))
            }
            None => format!(", of {} options", self.options),
        };
        let is_alike = self.next.as_ref().is_some_and(|next| next.is_alike && next.met == met);
        let begin = match (self.is_mapped, is_alike) {
            (false, false) => "",
            (false, true) => "None is shown to be the best: least is ",
            (true, false) => "Which is the best depends on the place in the map; over all conditions it is ",
            (true, true) => {
                "Which is the best depends on the place in the map; over all conditions none is shown to be the best, and least is "
            }
        };
        format!("{begin}{}{equal}{next}.{left_out}", self.option)
    }

    fn margin_told(&self) -> String {
        let Some(margin) = self.margin().filter(|margin| margin.value.is_finite()) else {
            if self.limit.is_some() {
                return format!("It is unknown{}, where too few records show a value.", self.at());
            }
            let over = |next: f64| next / self.value.value - 1.0;
            return match &self.next {
                Some(Next { value, .. }) if over(*value) > 0.0 => {
                    format!("The next option is {} above the best.", percent(over(*value)))
                }
                _ => "Without a limit there is none.".to_owned(),
            };
        };
        let worst = margin_in_words(margin, LEVEL);
        match self.met {
            [met, all] if (1..all).contains(&met) => {
                let worst = match worst.strip_prefix("The") {
                    Some(rest) => format!("the{rest}"),
                    None => worst,
                };
                format!("The limit is met under {met} of {all} conditions;{} {worst}", self.at())
            }
            _ => worst,
        }
    }

    fn limits(&self) -> String {
        let Some(first) = self.budget.first() else {
            return "The parts of this estimate are not separated.".to_owned();
        };
        let without = |part: &Part| with_interval(part.without, |value| self.shown(value));
        let told = |part: &Part| format!("{} {}", part.name, with_interval(part.share, percent));
        let parts: Vec<String> =
            self.budget.iter().filter(|part| part.share.value >= LEAST_SHARE).map(told).collect();
        // A share below 0 would not tell how much the part helps.
        let helps = |part: &Part| {
            format!(" {} lowers it: without that it is {}.", capitalised(part.name), without(part))
        };
        let helpful: String =
            self.budget.iter().filter(|part| part.share.value <= -LEAST_SHARE).map(helps).collect();
        let all: f64 = self.budget.iter().map(|part| part.share.value).sum();
        let together = match (all - 1.0).abs() > 0.02 && helpful.is_empty() {
            true => " The shares do not add up to 100 %, because parts act together.",
            false => "",
        };
        format!(
            "{} of the mean square; without {} the {} is {}.{helpful}{together}",
            capitalised(&parts.join(", ")),
            first.name,
            worded(&self.label),
            without(first)
        )
    }

    /// The sheet as JSON; values are in the units of tables, fractions as such.
    pub fn json(&self) -> Json {
        let figure = |figure: Figure| json!({ "value": figure.value, "interval95": figure.interval });
        let unit = self.unit.symbol;
        let part = |part: &Part| json!({ "part": part.name, "share_of_mean_square": figure(part.share), "without": figure(part.without) });
        let lever = |lever: &Lever| {
            let (meets, not_even) = match &lever.needed {
                Some(Needed::Value(value)) => (Some(value.to_string()), None),
                Some(Needed::NotEven(value, _)) => (None, Some(value.to_string())),
                None => (None, None),
            };
            json!({
                "key": lever.key,
                "from": lever.from.to_string(),
                "to": lever.to.to_string(),
                "gain": figure(lever.gain),
                "meets_limit": meets,
                "not_even": not_even,
                "remark": lever.remark,
                "also_meet": lever.also.iter().map(|also| json!({ "key": also.key, "value": also.to.to_string() })).collect::<Vec<_>>(),
            })
        };
        json!({
            "of": titled(&self.label, unit),
            "unit": unit,
            "limit": self.limit.map(|limit| limit.value),
            "met": self.is_met(),
            "best": { "option": self.option, "of": self.options, "at": self.condition, "estimate": figure(self.value) },
            "as_good": self.equal,
            "next": self.next.as_ref().map(|next| json!({ "option": next.option, "estimate": next.value })),
            "margin": self.margin().map(figure),
            "budget": self.budget.iter().map(part).collect::<Vec<_>>(),
            "lever": self.lever.as_ref().map(lever),
            "sentences": self.lines(),
        })
    }
}
