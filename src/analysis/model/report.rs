//! The report of a noise model: answer and charts.

use crate::analysis::log::figures::of_columns;
use crate::analysis::model::si;
use crate::analysis::model::tables::lines;
use crate::analysis::model::target::{MAX_TAU_PART, NEAR, Target, White};
use crate::analysis::model::{Aim, Analysis, Column, tables};
use sagnac_base::diagnostics::listed;
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::{Deviation, Unit};
use sagnac_records::fit::{Quantity, Term};
use sagnac_report::answer::{Answer, AnswerCell, AnswerTable, Fact, Kind, MAX_ROWS, Reading};
use sagnac_report::chart::figure::{Axis, Figure, Law, LawLine, Part, Parts, Series, SeriesPoint};

impl Analysis {
    /// The confidence as a percentage, such as `95 %`.
    pub fn percent(&self) -> String {
        format!("{} %", significant(100.0 * self.request.confidence, 3))
    }

    /// The column whose model lies farthest from what it describes, or farthest above what it bounds.
    fn worst(&self) -> Option<&Column> {
        let miss = |column: &&Column| self.miss(column).value.abs();
        self.columns.iter().max_by(|a, b| miss(a).total_cmp(&miss(b)))
    }

    /// The answer.
    pub fn answer(&self) -> Answer {
        let Some(worst) = self.worst() else { return Answer::default() };
        let miss = self.miss(worst);
        Answer {
            kind: Kind::Estimate,
            headline: self.headline(worst, &miss),
            value: Some(miss),
            table: match (&self.columns[..], &self.without[..]) {
                ([only], []) => parameters(only),
                (columns, _) => self.models(columns),
            },
            facts: self.facts(worst),
            ..Answer::default()
        }
    }

    /// How far the model lies above what it bounds, or above the record that it describes, at most, and at which τ, s.
    fn excess(&self, column: &Column) -> (Reading, f64) {
        let [excess, tau_s] = match self.request.aim {
            Aim::Describe => column.found.over_record(&column.target),
            Aim::Bound | Aim::BoundRepeat => column.found.over_bound(&column.target),
        };
        (percents("excess", excess), tau_s)
    }

    /// How far the model lies below the record that it describes, at most, and at which τ, s.
    fn shortfall(&self, column: &Column) -> (Reading, f64) {
        let [shortfall, tau_s] = column.found.below_record(&column.target);
        (percents("shortfall", shortfall), tau_s)
    }

    /// The farthest that a description lies from the record, negative below it, or that a bound lies above what it bounds.
    fn miss(&self, column: &Column) -> Reading {
        let (excess, _) = self.excess(column);
        let (shortfall, _) = self.shortfall(column);
        if self.request.aim != Aim::Describe {
            return excess;
        }
        let miss = if shortfall.value > excess.value { -shortfall.value } else { excess.value };
        Reading::in_unit("deviation", miss, "%", None)
    }

    fn headline(&self, column: &Column, miss: &Reading) -> String {
        let model = &column.found.model;
        let symbols = [("Q", model.quantization), ("N", model.white), ("K", model.walk)];
        let symbols: Vec<&str> =
            symbols.into_iter().filter(|(_, size)| *size > 0.0).map(|(symbol, _)| symbol).collect();
        let (parts, several) = match model.markov.len() {
            0 => (listed(&symbols), symbols.len() > 1),
            1 => ("1 Gauss–Markov state".to_owned(), false),
            states => (format!("{states} Gauss–Markov states"), true),
        };
        let verb = match (self.request.aim, several) {
            (Aim::Describe, true) => "describe",
            (Aim::Describe, false) => "describes",
            (_, true) => "bound",
            (_, false) => "bounds",
        };
        let whose = match self.columns.len() + self.without.len() {
            1 => format!("the {}", self.source.noun),
            _ => column.target.name.clone(),
        };
        let size = Reading { value: miss.value.abs(), ..miss.clone() }.text();
        let how = match (self.request.aim, miss.value) {
            (Aim::Describe, 0.0) => " exactly".to_owned(),
            (Aim::Describe, ..0.0) => format!(", up to {size} below"),
            (Aim::Describe, _) => format!(", up to {size} above"),
            (_, _) => format!(" to {size}"),
        };
        format!("{parts} {verb} {whose}{how}")
    }

    /// A row for each of several columns.
    fn models(&self, columns: &[Column]) -> AnswerTable {
        let is_described = self.request.aim == Aim::Describe;
        let row = |column: &Column| -> Vec<AnswerCell> {
            let values = shown(column);
            let value = |name: &str| {
                let found = values.iter().find(|(other, _)| other.starts_with(name));
                found.map_or_else(|| "0".to_owned().into(), |(_, reading)| AnswerCell::from(reading.clone()))
            };
            let states: Vec<String> = column
                .found
                .model
                .markov
                .iter()
                .map(|state| {
                    let symbol = column.target.unit.symbol(Deviation::Oadev);
                    format!(
                        "{}, {}",
                        Reading::in_unit("", state.sigma, symbol, None).text(),
                        Reading::in_unit("", state.time_s, "s", None).text()
                    )
                })
                .collect();
            let cells = [value("white noise"), value("random walk"), states.join("; ").into()];
            let below = is_described.then(|| self.shortfall(column).0.into());
            let last = below.into_iter().chain([self.excess(column).0.into()]);
            std::iter::once(column.target.name.clone().into()).chain(cells).chain(last).collect()
        };
        let mut heads =
            ["column", "white noise N", "random walk K", "Gauss–Markov σ, T"].map(str::to_owned).to_vec();
        match is_described {
            true => heads.extend(["below", "above"].map(|side| format!("{side} {}", self.source.noun))),
            false => heads.push("above bound".to_owned()),
        }
        let without = self.without.iter().map(|(name, _)| {
            let blank = (2..heads.len()).map(|_| "—".into());
            [name.clone().into(), "no model".into()].into_iter().chain(blank).collect::<Vec<AnswerCell>>()
        });
        let worst = self.worst().and_then(|worst| columns.iter().position(|one| std::ptr::eq(one, worst)));
        AnswerTable {
            best: worst.filter(|place| *place < MAX_ROWS),
            ..AnswerTable::new(heads.iter().map(String::as_str), columns.iter().map(row).chain(without))
        }
    }

    fn facts(&self, column: &Column) -> Vec<Fact> {
        let (excess, tau_s) = self.excess(column);
        let at = |tau_s: f64| format!("at τ = {} s", significant(tau_s, 3));
        let [from_s, to_s] = column.target.taus().map(|tau_s| significant(tau_s, 3));
        let what = match (self.request.aim, column.target.has_band) {
            (Aim::Describe, _) => format!("above the {}", self.source.noun),
            (Aim::BoundRepeat, _) => format!("above the {} band of further records", self.percent()),
            (Aim::Bound, true) => format!("above the {} band", self.percent()),
            (Aim::Bound, false) => "above the curve".to_owned(),
        };
        let value = |name: &str, value: Reading, at: String| Fact::Value { name: name.to_owned(), value, at };
        let mut facts =
            vec![value("Excess", excess, format!("at most {what}, {}; τ {from_s}–{to_s} s", at(tau_s)))];
        let (shortfall, tau_s) = self.shortfall(column);
        if self.request.aim == Aim::Describe && shortfall.value > 0.0 {
            let what = format!("at most below it, {}: a filter is overconfident", at(tau_s));
            facts.push(value("Shortfall", shortfall, what));
        }
        let last = column.target.points.last();
        if let Some((last, edf)) = last.and_then(|last| Some((last, last.edf?))) {
            let width = Reading::in_unit("width", last.upper / last.value, "", None);
            let freedom = significant(edf, 2);
            facts.push(value(
                "Band",
                width,
                format!("× the curve {}, {freedom} degrees of freedom", at(last.tau_s)),
            ));
        }
        let tried = &column.found.tried;
        // Fewer states, which lie farther above.
        let states = column.found.model.markov.len();
        let mut fewer = tried.iter().rev().filter(|tried| tried.states < states);
        if let Some((states, excess)) =
            fewer.find_map(|tried| Some((tried.states, tried.largest_excess_over_bound?)))
        {
            let reading = percents("excess", excess);
            let name = format!("With {states} state{}", if states == 1 { "" } else { "s" });
            facts.push(value(&name, reading, "above".to_owned()));
        }
        let nearest =
            tried.iter().filter_map(|tried| tried.excess_without_quantization).min_by(f64::total_cmp);
        if nearest.is_some_and(|nearest| nearest > self.request.margin) && self.request.states.is_none() {
            let margin = significant(100.0 * self.request.margin, 3);
            facts.push(Fact::caveat(format!("no number of states comes within {margin} %")));
        }
        facts.extend(self.columns.iter().filter_map(|column| self.other_white(column)).map(Fact::caveat));
        facts.extend(self.without.iter().map(|(name, why)| {
            let why = why.to_string();
            let why = why.lines().next().unwrap_or_default();
            Fact::caveat(why.strip_prefix("column ").map_or_else(|| format!("{name}: {why}"), str::to_owned))
        }));
        facts
    }

    /// Why N of a description is outside the interval of that of the record, if it is.
    fn other_white(&self, column: &Column) -> Option<String> {
        let Target { name, unit, white, .. } = &column.target;
        let White { interval, from_s, .. } = white.filter(|_| self.request.aim == Aim::Describe)?;
        let own = column.found.model.white;
        if interval[0] <= own && own <= interval[1] {
            return None;
        }
        let (factor, _, symbol) = Quantity::Coefficient(Term::AngleRandomWalk).unit(*unit);
        let [lower, upper] = interval.map(|end| significant(factor * end, 3));
        let is_later = from_s > 1.01 * column.target.taus()[0];
        let why = match is_later {
            true => format!("is that of τ from {} s on", significant(from_s, 3)),
            false => "is in no model within the band".to_owned(),
        };
        Some(format!("{name}: N of the fit, {lower}–{upper} {symbol}, {why}"))
    }
}

/// A part as a value in percent. A curve of a model that its own terms describe differs by rounding alone.
fn percents(quantity: &str, part: f64) -> Reading {
    Reading::in_unit(quantity, if part.abs() < 1e-9 { 0.0 } else { 100.0 * part }, "%", None)
}

/// The values of a model in the first of the units that people use.
fn shown(column: &Column) -> Vec<(String, Reading)> {
    let figures =
        tables::figures(column).into_iter().filter(|figure| !figure.name.is_empty() && figure.value > 0.0);
    figures
        .map(|figure| {
            let reading = Reading::in_unit(&figure.key, figure.value, figure.unit, None);
            (figure.name, reading)
        })
        .collect()
}

/// A row for each parameter of a model.
fn parameters(column: &Column) -> AnswerTable {
    let symbol = column.target.unit.symbol(Deviation::Oadev);
    let states = column.found.model.markov.iter().zip(1..).map(|(state, number)| {
        let time = Reading::in_unit("correlation_time_s", state.time_s, "s", None);
        let sigma = Reading::in_unit("sigma", state.sigma, symbol, None);
        vec![format!("Gauss–Markov state {number}").into(), sigma.into(), time.into()]
    });
    let values =
        shown(column).into_iter().map(|(name, reading)| vec![name.into(), reading.into(), "".into()]);
    AnswerTable::new(["parameter", "value", "correlation time"], values.chain(states))
}

/// Notes on what was read and on what the model leaves out.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    let quantized = analysis.columns.iter().filter_map(|column| {
        let [_, upper] = column.target.quantization?;
        let (angle, unit, factor) = match column.target.unit {
            Unit::Acceleration => ("velocity", "m/s", si(Unit::Acceleration)),
            _ => ("angle", "″", 1.0),
        };
        Some(format!(
            "{}: the quantization, up to {} {unit}, is measurement noise R of the {angle} and no part of the rate; `quantization = white` covers \
             it by white noise",
            column.target.name,
            significant(factor * upper, 3)
        ))
    });
    let widened = analysis.columns.iter().filter_map(|column| widened(column, analysis));
    let has_band = analysis.columns.iter().any(|column| column.target.has_band);
    let bounded = match analysis.request.aim {
        Aim::Describe => None,
        Aim::Bound => Some(format!("the {}, with its band", analysis.source.noun)),
        Aim::BoundRepeat => Some("the noise of further records".to_owned()),
    };
    let bound = bounded
        .filter(|_| has_band)
        .map(|bounded| format!("the model bounds {bounded}: its values are larger than the estimates"));
    bound.into_iter().chain(analysis.source.notes.iter().cloned()).chain(widened).chain(quantized).collect()
}

/// That a model covers longer averaging times than were asked for, because the curve has none there.
fn widened(column: &Column, analysis: &Analysis) -> Option<String> {
    let usual_s = column.target.length_s.map(|length_s| length_s / MAX_TAU_PART);
    let [_, to_s] = column.target.taus();
    let (asked_s, why) = match analysis.request.to_s {
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

/// Most points of a curve that are marked.
const MAX_POINTS: usize = 40;
/// Points of a line between two points of the curve.
const BETWEEN: u32 = 4;

/// The figures with the stems of their file names, one for each unit.
pub fn figures(analysis: &Analysis) -> Vec<(String, Figure)> {
    let first = analysis.columns.first().map(|column| column.target.unit);
    let further = Some(Unit::Acceleration).filter(|unit| first != Some(*unit));
    let of = |(unit, stem): (Option<Unit>, &str)| Some((stem.to_owned(), figure(analysis, unit?)?));
    [(first, "model"), (further, "model-accelerometers")].into_iter().filter_map(of).collect()
}

fn figure(analysis: &Analysis, unit: Unit) -> Option<Figure> {
    let all: Vec<&Column> = analysis.columns.iter().filter(|column| column.target.unit == unit).collect();
    let first = *all.first()?;
    let is_bound = analysis.request.aim != Aim::Describe;
    let bound = |(colour, column): (usize, &&Column)| LawLine {
        colours: vec![colour],
        points: column
            .target
            .points
            .iter()
            .zip(&column.found.bounds)
            .map(|(point, bound)| (point.tau_s, *bound))
            .collect(),
    };
    let laws = Law {
        label: "bounded: the band of another record".to_owned(),
        lines: all.iter().enumerate().map(bound).collect(),
        is_area: false,
    };
    let title = match (analysis.request.aim, unit) {
        (Aim::Describe, Unit::Acceleration) => "Acceleration noise for a filter",
        (Aim::Describe, _) => "Rate noise for a filter",
        (_, Unit::Acceleration) => "Acceleration noise for a filter, bounded",
        (_, _) => "Rate noise for a filter, bounded",
    };
    let has_band =
        all.iter().any(|column| column.target.points.iter().any(|point| point.lower < point.upper));
    Some(Figure {
        title: title.to_owned(),
        subtitle: Some(analysis.source.heading.clone()),
        x: Axis::new("averaging time τ", "s"),
        y: Axis::new("Allan deviation σ(τ)", unit.symbol(Deviation::Oadev)),
        colours: of_columns(all.iter().map(|column| column.target.name.clone())),
        points: if is_bound && !has_band { "curve" } else { analysis.source.noun }.to_owned(),
        bands: format!("{} intervals", analysis.percent()),
        lines: "model".to_owned(),
        series: all.iter().enumerate().map(|(colour, column)| series(colour, column)).collect(),
        laws: if analysis.request.aim == Aim::BoundRepeat { vec![laws] } else { vec![] },
        parts: if all.len() > 1 { Parts::default() } else { parts(first) },
        ..Figure::default()
    })
}

fn series(colour: usize, column: &Column) -> Series {
    let points = &column.target.points;
    let step = points.len().div_ceil(MAX_POINTS).max(1);
    let shown = points.iter().step_by(step).map(|point| SeriesPoint {
        x: point.tau_s,
        y: point.value,
        band: (point.lower < point.upper).then_some((point.lower, point.upper)),
        key: None,
    });
    let law = taus(column).into_iter().map(|tau_s| (tau_s, column.found.model.deviation(tau_s)));
    Series { colour, dash: 0, points: shown.collect(), law: law.collect() }
}

/// The times of the curve, and some between them.
fn taus(column: &Column) -> Vec<f64> {
    let points = &column.target.points;
    let between = |pair: &[crate::analysis::model::target::Point]| {
        let (from_s, ratio) = (pair[0].tau_s, pair[1].tau_s / pair[0].tau_s);
        (0..BETWEEN)
            .map(move |i| from_s * libm::pow(ratio, f64::from(i) / f64::from(BETWEEN)))
            .collect::<Vec<_>>()
    };
    points.windows(2).flat_map(between).chain(points.last().map(|point| point.tau_s)).collect()
}

fn parts(column: &Column) -> Parts {
    let lines = lines(column, &taus(column)).into_iter().enumerate();
    // The first colour is that of the curve.
    let lines = lines.map(|(place, (label, points))| Part { label, colour: 1 + place, points });
    Parts { title: "parts of the model".to_owned(), lines: lines.collect() }
}
