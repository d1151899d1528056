//! Output of `sagnac model` for people.

use sagnac::allan::deviation::Deviation;
use sagnac::analysis::model::search::Found;
use sagnac::analysis::model::target::Target;
use sagnac::analysis::model::{Aim, Analysis, Column, tables};
use sagnac::quantity::number::significant;
use sagnac::table::titled;

use crate::shown::{THIS, shown};
use crate::terminal::headed;

/// Most lines of a curve; of longer curves every second, third, … point is shown, and the last.
const MOST_LINES: usize = 24;

/// The coefficients of each column, and its curve beside the model.
pub fn report(analysis: &Analysis) -> String {
    let columns = analysis.columns.iter().map(|column| coefficients(column) + &curve(analysis, column));
    let shown = shown(THIS, &analysis.events());
    format!("{}\n{shown}{}", analysis.source.heading, columns.collect::<String>())
}

fn coefficients(column: &Column) -> String {
    let figures = tables::figures(column).into_iter().filter(|figure| figure.value > 0.0);
    let lines = figures
        .map(|figure| vec![figure.name, significant(figure.value, 4), figure.unit.to_owned(), String::new()]);
    let symbol = column.target.unit.symbol(Deviation::Oadev);
    let states = column.found.model.markov.iter().zip(1..).map(|(state, number)| {
        let time = format!("correlation time {} s", significant(state.time_s, 4));
        vec![format!("Markov state {number}"), significant(state.sigma, 4), symbol.to_owned(), time]
    });
    format!("\n{}: model\n{}", column.target.name, headed(["", "value", "", ""], lines.chain(states)))
}

fn curve(analysis: &Analysis, column: &Column) -> String {
    let Column { target, found } = column;
    let title = titled("Allan deviation", target.unit.symbol(Deviation::Oadev));
    let percent = |part: f64| format!("{:+.1} %", 100.0 * part);
    let step = target.points.len().div_ceil(MOST_LINES).max(1);
    let last = target.points.len().saturating_sub(1);
    let shown = (0..=last).filter(|i| i % step == 0 || *i == last);
    let line = |i: usize| {
        let point = &target.points[i];
        let model = found.model.deviation(point.tau_s);
        vec![
            significant(point.tau_s, 5),
            significant(point.value, 4),
            significant(ends(analysis, target, found)(i), 4),
            significant(model, 4),
            percent(model / point.value - 1.0),
            percent(model / ends(analysis, target, found)(i) - 1.0),
        ]
    };
    let heading = match analysis.asked.aim {
        Aim::BoundRepeat => ["τ, s", "record", "bound", "model", "above record", "above bound"],
        _ => ["τ, s", "record", "upper", "model", "above record", "above upper"],
    };
    let some = match step {
        1 => String::new(),
        _ => format!("  one in {step} of the {} times; model.csv has all of them\n", last + 1),
    };
    format!("{}: {title}\n{}{some}", target.name, headed(heading, shown.map(line)))
}

/// What the model is checked against: the upper end of the band, or what is bounded.
fn ends<'a>(analysis: &Analysis, target: &'a Target, found: &'a Found) -> impl Fn(usize) -> f64 + 'a {
    let is_bound = analysis.asked.aim != Aim::Describe;
    move |i| if is_bound { found.bounds[i] } else { target.points[i].upper }
}
