//! The report of fillers for firmware: answer and tables.

use crate::analysis::answer::{Line, table};
use crate::analysis::firmware::shown;
use crate::analysis::firmware::{Candidate, Closed, Design, Firmware, Rule, Trade};
use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_engine::filler::FILLERS;
use sagnac_engine::filler::read::Error;
use sagnac_engine::kinds::gap_fill::columns::{FILLER, Judged, Size, deviation};
use sagnac_report::answer::reading::{begun, number};
use sagnac_report::answer::{
    Alternative, Answer, AnswerCell, AnswerTable, Fact, Kind, MAX_ROWS, Part, Reading, Status,
};

fn arcsec(name: &str, value: f64) -> Reading {
    Reading::in_unit(name, value, "″", None)
}

/// A 99.73 % level that meets or misses a limit.
fn status(level: f64, limit: Option<f64>) -> Status {
    match limit {
        None => Status::NoLimit,
        Some(limit) if level <= limit => Status::Met,
        Some(_) => Status::NotMet,
    }
}

/// A filler with its 99.73 % level where the motion is `off`, which may have a limit.
fn headline(name: &str, level: f64, off: &str, limit: Option<f64>) -> String {
    let level_text = arcsec("", level).text();
    match limit {
        None => format!("{name}: {level_text} at 99.73 %, {off}"),
        Some(limit) => {
            let verb = if level <= limit { "meets" } else { "misses" };
            format!("{name}: {level_text} {verb} the {} limit, {off}", arcsec("", limit).text())
        }
    }
}

/// The words for the largest deviation of frequencies, such as `f ±5 %`.
fn off(shift: Option<f64>) -> String {
    match shift {
        Some(shift) => format!("f ±{} %", significant(100.0 * shift, 3)),
        None => "within tolerance".to_owned(),
    }
}

/// The parts of a mean square of motion and noise, which are independent.
fn budget(rms: f64, noise_rms: f64) -> Fact {
    let part = (noise_rms / rms).min(1.0);
    let noise = part * part;
    let mut parts = [("motion", 1.0 - noise), ("noise", noise)].map(|(name, share)| Part {
        name: name.to_owned(),
        share,
        interval: None,
    });
    parts.sort_by(|a, b| b.share.total_cmp(&a.share));
    Fact::ErrorBudget { parts: parts.into(), at: String::new() }
}

impl Firmware {
    /// The lost ticks, such as `3 lost ticks of 5 ms`.
    pub(crate) fn lost(&self) -> String {
        self.ticks("lost tick")
    }

    /// The ticks of the gap under a name, with their length.
    pub(crate) fn ticks(&self, name: &str) -> String {
        let n = self.gap_ticks;
        let plural = if n == 1 { "" } else { "s" };
        let of = self.tick_s.map_or_else(String::new, |t| format!(" of {} ms", significant(1e3 * t, 6)));
        format!("{n} {name}{plural}{of}")
    }

    /// The gap and the point of the study in a line.
    pub fn heading(&self) -> String {
        let place = self.place();
        let at = if place.is_empty() { String::new() } else { format!(" · {place}") };
        format!("{} · n = {}{at}", self.title, self.lost())
    }

    /// The answer: that of the search where there is one, else which filler leaves least.
    pub fn answer(&self) -> Answer {
        match &self.trade {
            Some(trade) => trade.answer(),
            None => self.of_designs(),
        }
    }

    fn of_designs(&self) -> Answer {
        let known = self.ranked();
        let first = known.first().map(|(design, _)| *design);
        let level = first.and_then(|design| design.possible).map(|possible| possible.worst().level);
        let size = known.first().map(|(_, size)| *size);
        let limit = self.limit_arcsec;
        let headline = match (first, level, size) {
            (Some(best), Some(level), _) => headline(&best.name, level, &off(self.shift), limit),
            (Some(best), None, Some(rms)) => {
                begun(&format!("{}: {} rms residual", best.name, arcsec("", rms).text()))
            }
            _ => {
                let gain = |design: &Design| design.interpolation.whole().noise_gain();
                let least = self.designs.iter().min_by(|a, b| gain(a).total_cmp(&gain(b)));
                least.map_or_else(String::new, |least| {
                    begun(&format!("{}: least noise gain √Σw², {}", least.name, number(gain(least))))
                })
            }
        };
        let mut facts: Vec<Fact> =
            first.and_then(|best| Some(budget(best.robust_rms()?, best.noise_rms))).into_iter().collect();
        if limit.is_some() && level.is_none() {
            facts.push(Fact::caveat("the limit is on the 99.73 % residual, which `sagnac run` samples"));
        }
        facts.extend(level.map(|_| Fact::caveat(format!("at worst with {}", deviation(self.shift)))));
        facts.extend(self.first_values());
        facts.extend(self.unsampled.as_ref().map(|why| Fact::caveat(format!("there is no rms: {why}"))));
        Answer {
            kind: Kind::Choice,
            status: match (level, limit) {
                (Some(level), limit) => status(level, limit),
                (None, Some(_)) => Status::Inconclusive,
                (None, None) => Status::NoLimit,
            },
            headline,
            value: level.or(size).map(|value| arcsec(if level.is_some() { "p99_73" } else { "rms" }, value)),
            limit: limit.map(|limit| arcsec("p99_73", limit)),
            table: self.table(&known),
            facts,
            checks: vec![],
        }
    }

    /// The values at which the fillers are compared because none was asked for.
    fn first_values(&self) -> impl Iterator<Item = Fact> {
        self.unasked.iter().filter_map(|(key, count)| {
            let (_, value) = self.at.iter().find(|(swept, _)| swept.name == key.name)?;
            let value = shown(&value.quantity()?);
            Some(Fact::caveat(format!("{} {value} is the first of its {count} values", key.label)))
        })
    }

    /// A row for each filler.
    fn table(&self, known: &[(&Design, f64)]) -> AnswerTable {
        let is_known = |design: &Design| known.iter().any(|(other, _)| std::ptr::eq(*other, design));
        let others = self.designs.iter().filter(|design| !is_known(design));
        let all: Vec<&Design> = known.iter().map(|(design, _)| *design).chain(others).collect();
        let cell = |value: Option<f64>| match value.filter(|value| *value > 0.0) {
            Some(value) => AnswerCell::from(arcsec("", value)),
            None => "—".to_owned().into(),
        };
        let row = |design: &&Design| {
            let latency = match self.tick_s {
                Some(tick_s) => {
                    Reading::in_unit("latency", 1e3 * tick_s * f64::from(design.latency_ticks), "ms", None)
                }
                None => Reading::in_unit("latency", f64::from(design.latency_ticks), "ticks", None),
            };
            let cells = vec![
                cell(design.errors[0].rms),
                cell(design.possible.map(|possible| possible.own.level)),
                cell(design.possible.map(|possible| possible.worst().level)),
                number(design.interpolation.whole().noise_gain()).into(),
                latency.into(),
            ];
            Line { name: design.name.clone(), is_usable: true, cells }
        };
        let level = format!("99.73 %, {}", off(self.shift));
        let heads = ["filler", "rms", "99.73 %", &level, "√Σw²", "latency"];
        let table = table(heads.map(str::to_owned).into(), all.iter().map(row).collect()).without_blanks();
        AnswerTable { best: table.best.filter(|_| !known.is_empty()), ..table }
    }

    /// The fillers with the residual by which they compare, ″, the least first: the 99.73 % level with frequencies off, else the rms,
    /// as far as it is known.
    fn ranked(&self) -> Vec<(&Design, f64)> {
        let level = |design: &Design| design.possible.map(|possible| possible.worst().level);
        let size = |design: &Design| level(design).or(design.robust_rms());
        let mut known: Vec<(&Design, f64)> =
            self.designs.iter().filter_map(|design| Some((design, size(design)?))).collect();
        known.sort_by(|a, b| a.1.total_cmp(&b.1));
        known
    }

    /// When the correction of a filler comes, and the residual to expect, in ASCII.
    pub fn expected(&self, design: &Design) -> String {
        let ticks = design.latency_ticks;
        let plural = if ticks == 1 { "" } else { "s" };
        let latency_ms = self.tick_s.map(|tick_s| significant(1e3 * tick_s * f64::from(ticks), 4));
        let latency_ms = latency_ms.map_or_else(String::new, |latency_ms| format!(" ({latency_ms} ms)"));
        let number = |value: f64| significant(value, 5);
        let residual = match (design.judged.map(Judged::worst), design.errors[0].rms) {
            (Some(Size { rms, level }), _) => format!(
                "; residual {}″ rms, {}″ at 99.73 %, with {}",
                number(rms),
                number(level),
                deviation(self.shift)
            ),
            (None, Some(rms)) if rms > 0.0 => format!("; residual {}″ rms", number(rms)),
            _ => String::new(),
        };
        format!("latency {ticks} tick{plural}{latency_ms}{residual}")
    }
}

impl Design {
    /// The rms residual, ″: the largest with frequencies off, where it is known.
    pub fn robust_rms(&self) -> Option<f64> {
        self.possible.map(|possible| possible.worst().rms).or(self.errors[0].rms).filter(|rms| *rms > 0.0)
    }
}

impl Trade {
    fn answer(&self) -> Answer {
        let (chosen, limit) = (self.chosen, self.asked.limit_arcsec);
        let name = |one: Candidate| format!("{}+{} ticks", one.before, one.after);
        let least = self.candidates.iter().min_by(|a, b| a.level.total_cmp(&b.level));
        let mut facts = vec![budget(chosen.rms, chosen.noise_rms)];
        if let Some(&least) = least.filter(|least| least.level < chosen.level) {
            let (key, label) = ("switching.fit_ticks".to_owned(), "fit ticks".to_owned());
            let [from, to] = [chosen, least].map(|one| format!("{}+{}", one.before, one.after));
            let gain = 1.0 - least.level / chosen.level;
            let change = Alternative { key, label, from, to };
            facts.push(Fact::MostEffectiveChange { change, gain, interval: None });
        }
        facts.push(Fact::caveat(format!("at worst with {}", deviation(self.shift))));
        Answer {
            kind: Kind::Choice,
            status: status(chosen.level, limit),
            headline: headline(&name(chosen), chosen.level, &off(self.shift), limit),
            value: Some(arcsec("p99_73", chosen.level)),
            limit: limit.map(|limit| arcsec("p99_73", limit)),
            table: self.options(),
            facts,
            checks: vec![],
        }
    }

    /// A row for each number of ticks after the gap around the chosen one, with the best number before it.
    fn options(&self) -> AnswerTable {
        let all = self.rows();
        let place = all.iter().position(|one| one.after == self.chosen.after).unwrap_or(0);
        let first = place.saturating_sub(MAX_ROWS / 2).min(all.len().saturating_sub(MAX_ROWS));
        let row = |one: Candidate| -> Vec<AnswerCell> {
            let status = self.asked.limit_arcsec.map(|limit| status(one.level, Some(limit)).text());
            vec![
                format!("{} + {}", one.before, one.after).into(),
                Reading::in_unit("latency", 1e3 * self.latency_s(one), "ms", None).into(),
                arcsec("own_rms", one.own_rms).into(),
                arcsec("rms", one.rms).into(),
                arcsec("p99_73", one.level).into(),
                status.unwrap_or_default().into(),
            ]
        };
        let shown: Vec<Candidate> = all.iter().copied().skip(first).take(MAX_ROWS).collect();
        // The choice may read fewer ticks before the gap than those of the least error.
        let shown =
            shown.into_iter().map(|one| if one.after == self.chosen.after { self.chosen } else { one });
        let rms = format!("rms, {}", off(self.shift));
        let heads = ["ticks before + after", "latency", "rms as given", &rms, "99.73 %", "limit"];
        let omitted = all.len().saturating_sub(MAX_ROWS);
        AnswerTable { best: Some(place - first), omitted, ..AnswerTable::new(heads, shown.map(row)) }
    }
}

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    filler: &'a str,
    error: &'static str,
    /// The lost tick, or `sum`.
    row: String,
    tick: i32,
    numerator: i64,
    denominator: i64,
}

/// The columns in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("filler", Unit::NONE, "filler", |row| row.filler.into())
            .is_of(FILLERS, Role::Key, FILLER),
        Of::new("error", Unit::NONE, "error", |row| row.error.into())
            .is(Role::Key, "`extrapolation`: the weights deliver E_j while the gap is open; `residual`: they give I_j once the ticks after \
                it are known."),
        Of::new("row", Unit::NONE, "row", |row| row.row.as_str().into())
            .is(Role::Key, "The lost tick that the weights fill, from 1, or `sum` for all lost ticks together."),
        Of::new("tick", Unit::NONE, "tick", |row| Cell::Integer(row.tick.into()))
            .is(Role::Coordinate, "The valid tick that is weighted: up to 0 before the gap, from n+1 on after it."),
        Of::new("numerator", Unit::NONE, "numerator", |row| Cell::Integer(row.numerator))
            .is(Role::Estimate, "Numerator of the weight over `denominator`."),
        Of::new("denominator", Unit::NONE, "denominator", |row| Cell::Integer(row.denominator))
            .is(Role::Estimate, "Common denominator of a filler's weights."),
        // All digits of an f64.
        Of::new("weight", Unit::NONE, "weight", |row| Cell::Text((row.numerator as f64 / row.denominator as f64).to_string()))
            .is(Role::Estimate, "The weight as a number."),
    ]
}

/// A row of `fillers.csv`.
pub(crate) struct FillerRow<'a> {
    design: &'a Design,
    error: Error,
    rule: &'a Rule,
    closed: Closed,
}

impl FillerRow<'_> {
    /// A size of the residual off the given motion.
    fn shifted(&self, of: fn(Size) -> f64) -> Cell {
        self.design.judged.filter(|_| self.error == Error::Residual).map(|judged| of(judged.shifted)).into()
    }
}

/// The columns of `fillers.csv` in the order of the file.
#[rustfmt::skip]
pub(crate) fn filler_columns<'a>() -> Vec<ColumnOf<FillerRow<'a>>> {
    type Of<'a> = ColumnOf<FillerRow<'a>>;
    vec![
        Of::new("filler", Unit::NONE, "filler", |row| row.design.name.as_str().into())
            .is_of(FILLERS, Role::Key, FILLER),
        Of::new("error", Unit::NONE, "error", |row| row.error.name().into())
            .is(Role::Key, "`extrapolation` of the weights while the gap is open, or `residual` of those once the ticks after it are known."),
        Of::new("rms", Unit::ARCSEC, "rms error", |row| row.closed.rms.into())
            .is(Role::Error, "Root mean square error with noise in closed form, ″; blank where the motion has none."),
        Of::new("amplitude", Unit::ARCSEC, "amplitude", |row| row.closed.amplitude.into())
            .is(Role::Estimate, "Largest error over the phase of a single tone, without noise, ″."),
        Of::new("shifted_rms", Unit::ARCSEC, "rms residual off the motion", |row| row.shifted(|size| size.rms))
            .is(Role::Estimate, "The largest root mean square residual with all frequencies lower or higher, or within the tolerances of a specification, ″."),
        Of::new("shifted_p99_73", Unit::ARCSEC, "99.73 % residual off the motion", |row| row.shifted(|size| size.level))
            .is(Role::Estimate, "The largest 99.73 % level of the residual under the same changes, ″."),
        Of::new("noise_gain", Unit::NONE, "noise gain", |row| row.rule.whole().noise_gain().into())
            .is(Role::Estimate, "√Σw² of the weights of the whole gap."),
        Of::new("largest_gain", Unit::NONE, "largest gain", |row| row.rule.whole().largest_gain().into())
            .is(Role::Estimate, "Σ|w| of the weights of the whole gap."),
        Of::new("largest_input", Unit::NONE, "largest input", |row| Cell::Integer(row.rule.largest_input().into()))
            .is(Role::Count, "The largest integer |P| for which 64 bits suffice."),
        Of::new("latency_ticks", Unit::NONE, "latency, ticks", |row| Cell::Integer(row.design.latency_ticks.into()))
            .is(Role::Count, "Ticks from the end of the gap to the correction."),
        Of::new("exact", Unit::NONE, "exact", |row| (if row.rule.exact { "yes" } else { "no" }).into())
            .is(Role::Note, "Whether the fractions are the exact weights (`yes`), or the nearest ones over a power of two (`no`)."),
        Of::new("method", Unit::NONE, "method", |row| row.design.method.as_str().into())
            .is(Role::Note, "The method by which the filler gets its weights."),
    ]
}

impl Firmware {
    /// A row for each error of each filler.
    pub fn fillers(&self) -> Table {
        let of_rule = |design| move |(error, rule, closed)| FillerRow { design, error, rule, closed };
        let rows: Vec<FillerRow> =
            self.designs.iter().flat_map(|design| design.rules().map(of_rule(design))).collect();
        Table { columns: columns_of(&filler_columns(), &rows) }
    }

    /// A row for each weight, of each lost tick and of their sum.
    pub fn weights(&self) -> Table {
        let mut rows = Vec::new();
        for design in &self.designs {
            for (error, rule, _) in design.rules() {
                let mut weights = Vec::new();
                if rule.rows.len() == self.gap_ticks as usize {
                    let by_tick = (1..).zip(&rule.rows);
                    weights.extend(by_tick.map(|(j, row): (u32, _)| {
                        (j.to_string(), row.iter().map(|w| i64::from(*w)).collect::<Vec<_>>())
                    }));
                }
                weights.push(("sum".to_owned(), rule.whole().numerators));
                for (row, numerators) in weights {
                    rows.extend(rule.ticks.iter().zip(numerators).map(|(&tick, numerator)| Row {
                        filler: &design.name,
                        error: error.name(),
                        row: row.clone(),
                        tick,
                        numerator,
                        denominator: rule.denominator.into(),
                    }));
                }
            }
        }
        Table { columns: columns_of(&columns(), &rows) }
    }
}
