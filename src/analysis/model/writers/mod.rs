//! Files for the tools of others, each a row with its convention and the parts of a model that the tool has.
//!
//! A tool without random walk or with fewer Markov states gets a model of what it has whose curve is nowhere below that of the whole
//! model between the two times. Its deviation at τ = 1 s stays within 1 %, because white noise is known best; what grows is the random walk, or the
//! single Markov state.

mod estimators;
mod programs;

use crate::analysis::log::report::one_line;
use crate::analysis::model::search::{Allowed, MAX_STATES, PER_DECADE, Problem, times};
use crate::analysis::model::{Aim, Analysis, Column, Model, ModelError};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::Unit;

/// A tool with the file that it reads.
#[derive(Debug)]
pub struct Writer {
    /// Name in lists.
    pub name: &'static str,
    /// Name of the file.
    pub file: &'static str,
    /// The tool for the user.
    pub tool: &'static str,
    /// Which densities its numbers are, in which units.
    pub convention: &'static str,
    /// The parts of a model that it has.
    takes: Takes,
    /// The text, given the sensors and the lines of the heading.
    text: fn(&Sheet) -> String,
}

/// The parts of a model that a tool has.
#[derive(Debug, Clone, Copy)]
struct Takes {
    walk: bool,
    states: usize,
    /// Whether all sensors share one correlation time.
    shares_time: bool,
}

impl Takes {
    const WALK: Takes = Takes { walk: true, states: 0, shares_time: false };
    const STATE: Takes = Takes { walk: false, states: 1, shares_time: false };
    const ALL: Takes = Takes { walk: true, states: MAX_STATES, shares_time: false };
}

/// Every writer, in the order of lists.
pub static WRITERS: [&Writer; 13] = [
    &estimators::KALIBR,
    &estimators::ALLAN_VARIANCE_ROS,
    &estimators::OPENVINS,
    &programs::MATLAB,
    &programs::NAVEGO,
    &programs::PSINS,
    &estimators::GTSAM_CPP,
    &estimators::GTSAM_PYTHON,
    &programs::PYINS,
    &programs::KF_GINS,
    &estimators::PX4,
    &programs::C_HEADER,
    &programs::JSON,
];

/// The sensors of a file, with the lines of its heading.
struct Sheet<'a> {
    analysis: &'a Analysis,
    gyros: Vec<Axis<'a>>,
    accelerometers: Vec<Axis<'a>>,
    heading: Vec<String>,
}

/// A sensor with the model that the tool can have.
struct Axis<'a> {
    column: &'a Column,
    model: Model,
}

/// The text of the file of each writer, with its name.
pub fn texts(analysis: &Analysis, writers: &[&'static Writer]) -> Vec<(&'static str, String)> {
    writers.iter().map(|writer| (writer.file, writer.of(analysis))).collect()
}

/// The writers with these names, `all` for all.
///
/// # Errors
/// A name is not known.
pub fn named(names: &str) -> Result<Vec<&'static Writer>, String> {
    if names == "all" {
        return Ok(WRITERS.to_vec());
    }
    let one = |name: &str| {
        let known = || WRITERS.map(|writer| writer.name).join(", ");
        let found = WRITERS.into_iter().find(|writer| writer.name == name.trim());
        found
            .ok_or_else(|| format!("`{}` is not known; accepted: all, or a list of {}", name.trim(), known()))
    };
    names.split(',').map(one).collect()
}

impl Writer {
    fn of(&self, analysis: &Analysis) -> String {
        let mut heading = vec![
            format!("Noise for {}, from sagnac model of {}.", self.tool, one_line(&analysis.source.heading)),
            format!("Convention: {}.", self.convention),
        ];
        let mut shared = None;
        let mut sensors = |unit: Unit| -> Vec<Axis> {
            let mut axes = Vec::new();
            for column in analysis.columns.iter().filter(|column| column.target.unit == unit) {
                let model = reduced(column, self.takes, shared);
                if self.takes.shares_time {
                    shared = shared.or(model.markov.first().map(|state| state.time_s));
                }
                heading.push(format!(
                    "{}: {}",
                    one_line(&column.target.name),
                    said(column, &model, analysis)
                ));
                axes.push(Axis { column, model });
            }
            axes
        };
        let (gyros, accelerometers) = (sensors(Unit::Angular), sensors(Unit::Acceleration));
        let without = |(name, _): &(String, ModelError)| {
            format!("{}: no model was found; the file says nothing of it.", one_line(name))
        };
        heading.extend(analysis.without.iter().map(without));
        (self.text)(&Sheet { analysis, gyros, accelerometers, heading })
    }
}

/// What the model of a sensor does, with what a tool lacks.
fn said(column: &Column, model: &Model, analysis: &Analysis) -> String {
    let all = bounded(column, analysis);
    match raised(column, model) {
        None => all,
        Some(times) => format!(
            "this tool lacks parts of the model that was found; what it has is raised until it is nowhere below that model, and is up to {} \
             times as large. Of the model that was found: {all}",
            significant(times, 3)
        ),
    }
}

/// How many times as large as the model of a column the `model` for a tool is at most; `None` where it is the same.
fn raised(column: &Column, model: &Model) -> Option<f64> {
    let ratio = |tau_s: f64| model.deviation(tau_s) / column.found.model.deviation(tau_s);
    (*model != column.found.model)
        .then(|| grid(column.target.taus()).into_iter().map(ratio).fold(1.0, f64::max))
}

/// The least ratio of a tool's model to the one found that a note tells.
const TOLD: f64 = 1.2;

/// Notes on files for tools that lack parts of the models.
pub fn notes(analysis: &Analysis, writers: &[&'static Writer]) -> Vec<String> {
    let note = |writer: &&'static Writer| {
        let times =
            analysis.columns.iter().filter_map(|column| raised(column, &reduced(column, writer.takes, None)));
        let times = times.fold(1.0, f64::max);
        (times > TOLD).then(|| {
            format!(
                "{} is up to {} times as large as the model: {} lacks its Gauss–Markov states; `states = 0` fits N and K alone",
                writer.file,
                significant(times, 2),
                writer.tool
            )
        })
    };
    writers.iter().filter_map(note).collect()
}

/// Times between two, closer than those of correlation.
fn grid([from_s, to_s]: [f64; 2]) -> Vec<f64> {
    let count = libm::ceil(4.0 * PER_DECADE * libm::log10(to_s / from_s)).max(1.0);
    (0..=count as u32).map(|i| from_s * libm::pow(to_s / from_s, f64::from(i) / count)).collect()
}

/// The model of a column with the parts that a tool has.
fn reduced(column: &Column, takes: Takes, time_s: Option<f64>) -> Model {
    /// How far the deviation at 1 s may move.
    const AT_1_S: f64 = 0.006;
    let whole = &column.found.model;
    let fits = whole.markov.len() <= takes.states && (takes.walk || whole.walk == 0.0);
    if fits && (time_s.is_none() || whole.markov.iter().all(|state| Some(state.time_s) == time_s)) {
        return whole.clone();
    }
    let of_rate = Model { quantization: 0.0, ..whole.clone() };
    let [from_s, to_s] = column.target.taus();
    let mut taus = grid([from_s, to_s]);
    let mut least: Vec<f64> = taus.iter().map(|&tau_s| of_rate.variance(tau_s)).collect();
    let mut most = vec![f64::INFINITY; taus.len()];
    let at_1_s = of_rate.variance(1.0);
    taus.push(1.0);
    least.push(at_1_s * (1.0 - AT_1_S) * (1.0 - AT_1_S));
    most.push(at_1_s * (1.0 + AT_1_S) * (1.0 + AT_1_S));
    let scale: Vec<f64> = taus.iter().map(|&tau_s| of_rate.variance(tau_s)).collect();
    let free = Problem { taus, goal: scale.clone(), scale, least, most, white: None };
    let times = time_s.map_or_else(|| times([from_s, 10.0 * to_s], None), |time_s| vec![time_s]);
    let allowed = Allowed { walk: takes.walk, states: takes.states, times: &times };
    let open = || Problem { most: vec![f64::INFINITY; free.taus.len()], ..free.clone() };
    let found = free.best(allowed).or_else(|| open().best(allowed)).unwrap_or(of_rate);
    Model { quantization: whole.quantization, ..found }
}

impl Sheet<'_> {
    /// The heading as comments that begin with `start`.
    fn comments(&self, start: &str) -> String {
        self.heading.iter().map(|line| format!("{start} {line}\n")).collect()
    }

    /// Rate of the filter, or of the record.
    fn rate_hz(&self) -> Option<f64> {
        self.analysis.filter_hz()
    }
}

/// Values of three axes: those of three sensors, or the largest of all for each.
fn three(axes: &[Axis], value: impl Fn(&Model) -> f64) -> [f64; 3] {
    match axes {
        [x, y, z] => [x, y, z].map(|axis| value(&axis.model)),
        _ => [largest(axes, value); 3],
    }
}

fn largest(axes: &[Axis], value: impl Fn(&Model) -> f64) -> f64 {
    axes.iter().map(|axis| value(&axis.model)).fold(0.0, f64::max)
}

/// Standard deviation of the only Markov state; 0 without one.
fn sigma(model: &Model) -> f64 {
    model.markov.first().map_or(0.0, |state| state.sigma)
}

/// Correlation time of the only Markov state; of a model without one 1 s, because tools divide by it.
fn time_s(model: &Model) -> f64 {
    model.markov.first().map_or(1.0, |state| state.time_s)
}

/// Six digits in a form that YAML 1.1 accepts as a number: with a point, and with a sign in the exponent.
fn number(value: f64) -> String {
    let text = format!("{value:.5e}");
    match text.split_once('e') {
        Some((mantissa, exponent)) if !exponent.starts_with('-') => format!("{mantissa}e+{exponent}"),
        _ => text,
    }
}

/// A number that is written without an exponent where it is short enough.
fn plain_number(value: f64) -> String {
    match significant(value, 9) {
        long if long.contains('e') => number(value),
        text if text.contains('.') => text,
        text => format!("{text}.0"),
    }
}

/// Numbers separated by `between`.
fn list(values: [f64; 3], between: &str) -> String {
    values.map(number).join(between)
}

/// What the model of a column does.
fn bounded(column: &Column, analysis: &Analysis) -> String {
    let [from_s, to_s] = column.target.taus().map(|tau_s| significant(tau_s, 4));
    let range = format!("from τ = {from_s} s to {to_s} s");
    match (analysis.request.aim, column.target.has_band) {
        (Aim::Describe, _) => {
            format!("The Allan deviation lies within the band of the {} {range}.", analysis.source.noun)
        }
        (Aim::Bound, true) => format!(
            "The Allan deviation is nowhere below the upper end of the {} band {range}.",
            analysis.percent()
        ),
        (Aim::Bound, false) => format!("The Allan deviation is nowhere below the curve {range}."),
        (Aim::BoundRepeat, _) => format!(
            "The Allan deviation is nowhere below the upper end of the band of {} of records like this one {range}.",
            analysis.percent()
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_such_to_yaml_1_1() {
        assert_eq!([2e-6, 3.0, 1.234_567_8e12].map(number), ["2.00000e-6", "3.00000e+0", "1.23457e+12"]);
        assert_eq!([200.0, 0.5, 1e-7].map(plain_number), ["200.0", "0.5", "1.00000e-7"]);
    }
}
