//! The output of a design: the recommendation in words, all results as a table, and both as JSON.

pub(crate) mod json;
pub(crate) mod tables;
pub(crate) mod trade;
pub(crate) mod variants;

pub use crate::analysis::design::report::json::json;
pub(crate) use crate::analysis::design::report::tables::columns;
pub use crate::analysis::design::report::tables::{figure, table};
pub(crate) use crate::analysis::design::report::trade::pareto_columns;
pub use crate::analysis::design::report::trade::{by_choice, pareto_figure, pareto_table};
pub use crate::analysis::design::report::variants::by_variant;

use crate::analysis::design::report::trade::trade;
use crate::analysis::design::report::variants::{cost_heads, costs, next_variant, told};
use crate::analysis::design::{Design, Filler, Found, PapersRule};
use crate::quantity::number::significant;

/// Name of the filler in tables.
pub fn called(filler: &Filler) -> &str {
    filler.name.as_deref().unwrap_or("as given")
}

/// The recommendation in one line: interval and filler, with the drift as a rate and as an angle after the run.
pub fn headline(found: &Design) -> String {
    let (variant, best, label) = (found.variant(), found.best(), found.measure.label());
    let filler = best.name.as_ref().map_or(String::new(), |name| format!(" with the {name} filler"));
    let values = told(found, variant).into_iter().map(|value| format!(", {value}")).collect::<String>();
    let (interval, drift) = (four_digits(best.best().interval_s), best.best().drift.value);
    let [rate, angle] = [drift, variant.angle(drift)].map(three_digits);
    format!(
        "Switch every {interval} s{filler}{values}: {label} {rate} °/h, {angle} arcsec after {}",
        duration(variant.duration_s)
    )
}

/// A time in the largest unit of which it has at least one.
pub fn duration(time_s: f64) -> String {
    let (unit, size) = match time_s {
        ..60.0 => ("s", 1.0),
        ..3600.0 => ("min", 60.0),
        _ => ("h", 3600.0),
    };
    format!("{} {unit}", four_digits(time_s / size))
}

fn three_digits(value: f64) -> String {
    significant(value, 3)
}

fn four_digits(value: f64) -> String {
    significant(value, 4)
}

/// The best interval of a filler with its uncertainty, in words.
fn range(filler: &Filler) -> String {
    match filler.optimum.interval {
        Some((lo, hi)) => format!("{} to {}", four_digits(lo), four_digits(hi)),
        None if filler.is_at_edge() => "at the end of the range".to_owned(),
        None => "too few candidates near it".to_owned(),
    }
}

/// The headings and lines of a table of the fillers, each at its best interval and at the best values of swept keys.
pub fn by_filler(found: &Design) -> (Vec<String>, Vec<Vec<String>>) {
    let variant = found.variant();
    let (label, angle) = (found.measure.label(), format!("″ after {}", duration(variant.duration_s)));
    let heading =
        ["filler", "best interval, s", "95 % interval, s", "switches", label, &angle, "times the least"];
    let lines = variant.fillers.iter().map(|filler| {
        let best = filler.best();
        let line = [
            called(filler).to_owned(),
            four_digits(best.interval_s),
            range(filler),
            best.switches.to_string(),
            format!("{} °/h", three_digits(best.drift.value)),
            three_digits(variant.angle(best.drift.value)),
            three_digits(found.worse_by(filler).value),
        ];
        line.into_iter().chain(costs(found, filler)).collect()
    });
    (heading.map(str::to_owned).into_iter().chain(cost_heads(found)).collect(), lines.collect())
}

/// The recommendation in sentences, with its evidence; the first is the headline.
pub fn recommendation(found: &Design) -> Vec<String> {
    let best = found.best();
    let mut sentences = vec![format!("{}.", headline(found))];
    if let Some((lo, hi)) = best.optimum.interval {
        let (lo, hi) = (four_digits(lo), four_digits(hi));
        sentences.push(format!("The best interval lies between {lo} s and {hi} s (95 %)."));
    } else if best.is_at_edge() {
        let edge =
            "It is the shortest or longest that was tried: try others, by a sweep over switching.interval.";
        sentences.push(edge.to_owned());
    }
    let variant = found.variant();
    let others = variant.fillers.iter().enumerate().filter(|(place, _)| *place != variant.best);
    let next = others.min_by(|a, b| a.1.best().drift.value.total_cmp(&b.1.best().drift.value));
    if let Some((_, next)) = next {
        let worse = found.worse_by(next);
        let (low, high) = worse.interval.unwrap_or((worse.value, worse.value));
        let (name, interval) = (called(next), four_digits(next.best().interval_s));
        let [times, from, to] = [worse.value, low, high].map(three_digits);
        sentences.push(match low > 1.0 {
            true => format!(
                "The next filler, {name}, leaves {times} times as much at its own best interval of {interval} s ({from} to {to})."
            ),
            false => format!("{name} does not differ significantly from it in these runs."),
        });
    }
    sentences.extend(next_variant(found));
    sentences.extend(trade(found));
    if let Some(PapersRule { interval_s, bound, tried }) = &best.papers_rule {
        let times = found.times_best(tried);
        let (low, high) = times.interval.unwrap_or((times.value, times.value));
        let [interval, tried_interval] = [*interval_s, tried.interval_s].map(four_digits);
        let [residual, bound, drift] = [best.residual_max, *bound, tried.drift.value].map(three_digits);
        let [times, from, to] = [times.value, low, high].map(three_digits);
        sentences.push(format!(
            "The paper's bound with δP_max = {residual} arcsec has its minimum at {interval} s, where it allows {bound} °/h; \
             switched every {tried_interval} s the gyro would drift by {drift} °/h, {times} times as much as at best \
             ({from} to {to})."
        ));
    }
    if variant.non_magnetic != 0.0 {
        let [drift, switched] = [variant.non_magnetic, best.best().switched.value].map(three_digits);
        sentences.push(format!(
            "The non-magnetic drift of {drift} °/h is part of it, which no interval changes: without it the drift would be \
             {switched} °/h."
        ));
    }
    sentences
}

/// The ends of the interval of a value.
pub(crate) fn ends(found: Found) -> [Option<f64>; 2] {
    found.interval.map_or([None; 2], |(low, high)| [Some(low), Some(high)])
}
