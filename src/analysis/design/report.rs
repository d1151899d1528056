//! The output of a design: the recommendation in words, all results as a table, and both as JSON.

use crate::analysis::design::{Design, Filler, Found, Measure, PapersRule, Tried};
use crate::chart::{Chart, Shows};
use crate::filler::FILLERS;
use crate::filler::closed::LISTED;
use crate::kinds::gap_fill::columns::FILLER;
use crate::quantity::number::significant;
use crate::study::Study;
use crate::table::column::columns_of;
use crate::table::{Cell, Column, ColumnOf, Role, Table, Unit};
use crate::view::chart::figure::Figure;
use crate::view::chart::notes::ChartError;
use serde_json::{Value, json};

/// A row of `design.csv`.
pub(crate) struct Row<'a> {
    filler: &'a Filler,
    tried: &'a Tried,
    duration_s: f64,
}

type Of<'a> = ColumnOf<Row<'a>>;

/// The columns of `design.csv` before those of the measure.
#[rustfmt::skip]
fn first_columns<'a>() -> [Of<'a>; 3] {
    [
        Of::new("filler", Unit::NONE, "filler", |row| called(row.filler).into())
            .is_of(FILLERS, Role::Key, FILLER)
            .styled(LISTED),
        Of::new("interval", Unit::S, "switching interval", |row| Cell::Number(row.tried.interval_s))
            .is(Role::Coordinate, "Tried switching interval, s."),
        Of::new("switches", Unit::NONE, "switches", |row| row.tried.switches.into())
            .is(Role::Count, "Switches in a run with that interval."),
    ]
}

/// The columns of a measure.
fn measured<'a>(measure: Measure) -> [Of<'a>; 3] {
    macro_rules! columns {
        ($name:literal, $meaning:literal) => {{
            let lower = concat!("Lower end of the 95 % interval of `", $name, "`, °/h.");
            let upper = concat!("Upper end of the 95 % interval of `", $name, "`, °/h.");
            let [low, high] = [concat!($name, "_lo"), concat!($name, "_hi")];
            [
                Of::new($name, Unit::DEG_PER_H, measure.label(), |row| Cell::Number(row.tried.drift.value))
                    .is(Role::Error, $meaning)
                    .within(|row| row.tried.drift.interval),
                Of::new(low, Unit::DEG_PER_H, "lower end", |row| ends(row.tried.drift)[0].into()).is_of(
                    $name,
                    Role::Lower,
                    lower,
                ),
                Of::new(high, Unit::DEG_PER_H, "upper end", |row| ends(row.tried.drift)[1].into()).is_of(
                    $name,
                    Role::Upper,
                    upper,
                ),
            ]
        }};
    }
    match measure {
        Measure::DriftQ9973 => {
            columns!("drift_q9973", "Drift, °/h, which 99.73 % of runs with that interval stay below.")
        }
        Measure::DriftRms => {
            columns!("drift_rms", "Root mean square drift with that interval, °/h (measure `drift_rms`).")
        }
        Measure::LargestQ9973 => columns!(
            "largest_q9973",
            "99.73 % level of the largest angle of a run divided by its duration, °/h (measure `largest_q9973`)."
        ),
        Measure::LargestRms => columns!(
            "largest_rms",
            "Root mean square of the largest angle of a run divided by its duration, °/h (measure `largest_rms`)."
        ),
    }
}

/// The columns of `design.csv` by some measures, in the order of the file.
pub(crate) fn columns<'a>(measures: &[Measure]) -> Vec<Of<'a>> {
    let closed = Of::new("closed_form_rms", Unit::DEG_PER_H, "rms drift (closed form)", |row| {
        row.tried.closed_form.into()
    });
    let closed = closed.is(Role::Estimate, "Root mean square drift in closed form, °/h.");
    let angle = Of::new("angle", Unit::ARCSEC, "angle at the end", |row| {
        Cell::Number(row.tried.drift.value * row.duration_s)
    });
    let angle = angle.is(Role::Estimate, "The drift times the run time, ″.");
    let switched = Of::new("switched", Unit::DEG_PER_H, "without the non-magnetic drift", |row| {
        Cell::Number(row.tried.switched.value)
    });
    let switched = switched.is(
        Role::Estimate,
        "The drift without its non-magnetic part, °/h, by which the interval is chosen: no interval changes that part.",
    );
    let measured = measures.iter().flat_map(|measure| measured(*measure));
    first_columns().into_iter().chain(measured).chain([closed, angle, switched]).collect()
}

/// The table of all results, with a row for each filler and interval.
pub fn table(found: &Design) -> Table {
    let duration_s = found.duration_s;
    let of_filler = |filler| move |tried| Row { filler, tried, duration_s };
    let rows = found.fillers.iter().flat_map(|filler: &Filler| filler.tried.iter().map(of_filler(filler)));
    Table { columns: columns_of(&columns(&[found.measure]), &rows.collect::<Vec<Row>>()) }
}

/// Name of the filler in tables.
pub fn called(filler: &Filler) -> &str {
    filler.name.as_deref().unwrap_or("as given")
}

/// The recommendation in one line: interval and filler, with the drift as a rate and as an angle after the run.
pub fn headline(found: &Design) -> String {
    let (best, label) = (found.best(), found.measure.label());
    let filler = best.name.as_ref().map_or(String::new(), |name| format!(" with the {name} filler"));
    let (interval, drift) = (four_digits(best.best().interval_s), best.best().drift.value);
    let [rate, angle] = [drift, found.angle(drift)].map(three_digits);
    format!(
        "Switch every {interval} s{filler}: {label} {rate} °/h, {angle} arcsec after {}",
        duration(found.duration_s)
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

/// The chart of the drift over the interval for each filler.
///
/// # Errors
/// The values cannot be drawn.
pub fn figure(study: &Study, found: &Design, table: &Table) -> Result<Figure, ChartError> {
    fn name(column: Option<&Column>) -> &str {
        column.map_or("", |column| &column.name)
    }
    let filler = name(table.listed_by(FILLERS));
    let series = if found.fillers.len() > 1 { vec![filler.into()] } else { vec![] };
    let chart = Chart {
        title: study.title.clone(),
        subtitle: headline(found),
        x: name(table.of_role(Role::Coordinate)).into(),
        y: name(table.of_role(Role::Error)).into(),
        shows: Shows::Curves { series, laws: vec![] },
        apart: vec![filler.to_owned()],
        points: "Monte Carlo".to_owned(),
        bands: "95 % band".to_owned(),
        ..Chart::default()
    };
    Ok(Figure::from_table(table, &chart)?.0)
}

/// The headings and lines of a table of the fillers, each at its best interval.
pub fn by_filler(found: &Design) -> (Vec<String>, Vec<Vec<String>>) {
    let (label, angle) = (found.measure.label(), format!("″ after {}", duration(found.duration_s)));
    let heading =
        ["filler", "best interval, s", "95 % interval, s", "switches", label, &angle, "times the least"];
    let lines = found.fillers.iter().map(|filler| {
        let best = filler.best();
        let range = match filler.optimum.interval {
            Some((lo, hi)) => format!("{} to {}", four_digits(lo), four_digits(hi)),
            None if filler.is_at_edge() => "at the end of the range".to_owned(),
            None => "too few candidates near it".to_owned(),
        };
        vec![
            called(filler).to_owned(),
            four_digits(best.interval_s),
            range,
            best.switches.to_string(),
            format!("{} °/h", three_digits(best.drift.value)),
            three_digits(found.angle(best.drift.value)),
            three_digits(found.worse_by(filler).value),
        ]
    });
    (heading.map(str::to_owned).to_vec(), lines.collect())
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
    let others = found.fillers.iter().enumerate().filter(|(place, _)| *place != found.best);
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
    if found.non_magnetic != 0.0 {
        let [drift, switched] = [found.non_magnetic, best.best().switched.value].map(three_digits);
        sentences.push(format!(
            "The non-magnetic drift of {drift} °/h is part of it, which no interval changes: without it the drift would be \
             {switched} °/h."
        ));
    }
    sentences
}

/// The ends of the interval of a value.
fn ends(found: Found) -> [Option<f64>; 2] {
    found.interval.map_or([None; 2], |(low, high)| [Some(low), Some(high)])
}

/// The recommendation and all results.
pub fn json(study: &Study, found: &Design) -> Value {
    let best = found.best();
    let (drift, rule) = (best.best().drift, best.papers_rule.as_ref());
    let [interval_lo_s, interval_hi_s] = ends(best.optimum);
    let [drift_lo, drift_hi] = ends(drift);
    let tried = |tried: &Tried| {
        let [drift_lo, drift_hi] = ends(tried.drift);
        json!({
            "interval_s": tried.interval_s,
            "switches": tried.switches,
            "drift": tried.drift.value,
            "drift_lo": drift_lo,
            "drift_hi": drift_hi,
            "closed_form_rms": tried.closed_form,
            "angle_arcsec": found.angle(tried.drift.value),
            "switched": tried.switched.value,
        })
    };
    let filler = |filler: &Filler| {
        let [interval_lo_s, interval_hi_s] = ends(filler.optimum);
        json!({
            "filler": filler.name,
            "residual_rms_arcsec": filler.residual_rms,
            "residual_max_arcsec": filler.residual_max,
            "interval_s": filler.best().interval_s,
            "interval_lo_s": interval_lo_s,
            "interval_hi_s": interval_hi_s,
            "drift": filler.best().drift.value,
            "drift_by_paper_rule": filler.papers_rule.as_ref().map(|rule| rule.tried.drift.value),
            "tried": filler.tried.iter().map(tried).collect::<Vec<_>>(),
        })
    };
    json!({
        "title": study.title,
        "answer": format!("{}.", headline(found)),
        "estimate": found.measure.name(),
        "unit": "deg/h",
        "trials": found.trials,
        "seed": study.seed,
        "duration_s": found.duration_s,
        "interval_s": best.best().interval_s,
        "interval_lo_s": interval_lo_s,
        "interval_hi_s": interval_hi_s,
        "filler": best.name,
        "drift": drift.value,
        "drift_lo": drift_lo,
        "drift_hi": drift_hi,
        "angle_arcsec": found.angle(drift.value),
        "angle_lo_arcsec": drift_lo.map(|drift| found.angle(drift)),
        "angle_hi_arcsec": drift_hi.map(|drift| found.angle(drift)),
        "drift_by_paper_rule": rule.map(|rule| rule.tried.drift.value),
        "interval_by_paper_rule_s": rule.map(|rule| rule.interval_s),
        "bound_by_paper_rule": rule.map(|rule| rule.bound),
        "non_magnetic": found.non_magnetic,
        "notes": found.notes,
        "fillers": found.fillers.iter().map(filler).collect::<Vec<_>>(),
    })
}
