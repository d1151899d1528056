//! The report of a noise model: answer and charts.

use crate::analysis::log::figures::of_columns;
use crate::analysis::model::search::Tried;
use crate::analysis::model::state_space::si;
use crate::analysis::model::tables::lines;
use crate::analysis::model::target::{MAX_TAU_PART, NEAR};
use crate::analysis::model::{Aim, Analysis, Column, tables};
use sagnac_base::diagnostics::listed;
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::{Deviation, Unit};
use sagnac_report::answer::{Answer, AnswerCell, AnswerTable, Fact, Kind, MAX_ROWS, Reading};
use sagnac_report::chart::figure::{Axis, Figure, Law, LawLine, Part, Parts, Series, SeriesPoint};

impl Analysis {
    /// The confidence as a percentage, such as `95 %`.
    pub fn percent(&self) -> String {
        format!("{} %", significant(100.0 * self.request.confidence, 3))
    }

    /// The column whose bound lies farthest above.
    pub(crate) fn worst(&self) -> Option<&Column> {
        let excess = |column: &&Column| column.found.over_bound(&column.target)[0];
        self.columns.iter().max_by(|a, b| excess(a).total_cmp(&excess(b)))
    }

    /// The answer.
    pub fn answer(&self) -> Answer {
        let Some(worst) = self.worst() else { return Answer::default() };
        let (excess, _) = self.excess(worst);
        Answer {
            kind: Kind::Estimate,
            headline: self.headline(worst, &excess),
            value: Some(excess),
            table: match &self.columns[..] {
                [only] => parameters(only),
                columns => self.models(columns),
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
        // A curve of a model that its own terms describe differs by rounding alone.
        let excess = if excess.abs() < 1e-9 { 0.0 } else { excess };
        (Reading::in_unit("excess", 100.0 * excess, "%", None), tau_s)
    }

    fn headline(&self, column: &Column, excess: &Reading) -> String {
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
        let whose = if self.columns.len() > 1 { &column.target.name } else { "the record" };
        format!("{parts} {verb} {whose} to {}", excess.text())
    }

    /// A row for each of several columns.
    fn models(&self, columns: &[Column]) -> AnswerTable {
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
            let cells = [
                value("white noise"),
                value("random walk"),
                states.join("; ").into(),
                self.excess(column).0.into(),
            ];
            std::iter::once(column.target.name.clone().into()).chain(cells).collect()
        };
        let over = if self.request.aim == Aim::Describe { "above record" } else { "above bound" };
        let heads = ["column", "white noise N", "random walk K", "Gauss–Markov σ, T", over];
        let worst = self.worst().and_then(|worst| columns.iter().position(|one| std::ptr::eq(one, worst)));
        AnswerTable {
            best: worst.filter(|place| *place < MAX_ROWS),
            ..AnswerTable::new(heads, columns.iter().map(row))
        }
    }

    fn facts(&self, column: &Column) -> Vec<Fact> {
        let (excess, tau_s) = self.excess(column);
        let at = |tau_s: f64| format!("at τ = {} s", significant(tau_s, 3));
        let [from_s, to_s] = column.target.taus().map(|tau_s| significant(tau_s, 3));
        let what = match (self.request.aim, column.target.has_band) {
            (Aim::Describe, _) => "above the record".to_owned(),
            (Aim::BoundRepeat, _) => format!("above the {} band of further records", self.percent()),
            (Aim::Bound, true) => format!("above the {} band", self.percent()),
            (Aim::Bound, false) => "above the curve".to_owned(),
        };
        let value = |name: &str, value: Reading, at: String| Fact::Value { name: name.to_owned(), value, at };
        let mut facts =
            vec![value("Excess", excess, format!("at most {what}, {}; τ {from_s}–{to_s} s", at(tau_s)))];
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
        let reached = |tried: &Tried| Some((tried.states, tried.excess?));
        let tried: Vec<(usize, f64)> = column.found.tried.iter().filter_map(reached).collect();
        // One state less, which lies farther above.
        if let [.., (states, excess), (_, reached)] = tried[..]
            && self.request.states.is_none()
            && excess > reached
        {
            let reading = Reading::in_unit("excess", 100.0 * excess, "%", None);
            let name = format!("With {states} state{}", if states == 1 { "" } else { "s" });
            facts.push(value(&name, reading, "above".to_owned()));
        }
        let missed = tried.last().is_some_and(|(_, excess)| *excess > self.request.margin);
        if missed && self.request.states.is_none() && self.request.aim != Aim::Describe {
            let margin = significant(100.0 * self.request.margin, 3);
            facts.push(Fact::Caveat { text: format!("no number of states comes within {margin} %") });
        }
        facts
    }
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
        Aim::Bound => Some("the record, with its band"),
        Aim::BoundRepeat => Some("the noise of further records"),
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
        points: if is_bound && !has_band { "curve".to_owned() } else { "record".to_owned() },
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
