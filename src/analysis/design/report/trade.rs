//! What latency and memory cost: the choices that no other one beats, as a table, a chart and sentences.

use serde_json::{Value, json};

use crate::analysis::design::constraints::milliseconds;
use crate::analysis::design::pareto::Choice;
use crate::analysis::design::report::json::swept;
use crate::analysis::design::report::variants::shown;
use crate::analysis::design::report::{called, ends, four_digits, three_digits};
use crate::analysis::design::{Design, Measure};
use crate::filler::FILLERS;
use crate::filler::closed::LISTED;
use crate::key::scale::Scale;
use crate::kinds::gap_fill::columns::FILLER;
use crate::kinds::table::table as table_of;
use crate::table::{Cell, ColumnOf, Role, Table, Unit};
use crate::view::chart::figure::{Axis, Entry, Figure, Grouping, Law, LawLine, Limit, Series, SeriesPoint};
use crate::view::chart::styles::of_names;
use crate::view::report::sections::Grid;

/// A row of `pareto.csv`.
pub(crate) struct Row<'a> {
    choice: Choice<'a>,
    times: [f64; 3],
    as_good: bool,
}

/// The columns of `pareto.csv` except the swept keys, in the order of the file.
#[rustfmt::skip]
pub(crate) fn pareto_columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("filler", Unit::NONE, "filler", |row| called(row.choice.filler).into())
            .is_of(FILLERS, Role::Key, FILLER)
            .styled(LISTED),
        Of::new("latency", Unit::S, "latency", |row| Cell::Number(row.choice.cost.latency_s))
            .is(Role::Coordinate, "Time from the end of the gap to the correction, s."),
        Of::new("memory", Unit::NONE, "memory, bytes", |row| row.choice.cost.memory.bytes().into())
            .is(Role::Count, "Memory of the filler in firmware on a 32-bit processor, bytes: constants and state."),
        Of::new("constants", Unit::NONE, "constants, bytes", |row| row.choice.cost.memory.constants.into())
            .is(Role::Count, "Its part that holds ticks and weights, which may be in flash, bytes."),
        Of::new("interval", Unit::S, "switching interval", |row| Cell::Number(row.choice.filler.best().interval_s))
            .is(Role::Coordinate, "Best switching interval, s."),
        Of::new("drift", Unit::DEG_PER_H, "drift", |row| Cell::Number(row.choice.drift().value))
            .is(Role::Error, "The minimized drift there, °/h: the estimate that `--by` names.")
            .within(|row| row.choice.drift().interval),
        Of::new("drift_lo", Unit::DEG_PER_H, "lower end", |row| ends(row.choice.drift())[0].into())
            .is_of("drift", Role::Lower, "Lower end of the 95 % interval of `drift`, °/h."),
        Of::new("drift_hi", Unit::DEG_PER_H, "upper end", |row| ends(row.choice.drift())[1].into())
            .is_of("drift", Role::Upper, "Upper end of the 95 % interval of `drift`, °/h."),
        Of::new("times_least", Unit::NONE, "times the least", |row| Cell::Number(row.times[0]))
            .is(Role::Estimate, "Ratio of the drift to the least one, in runs with the same random numbers.")
            .within(|row| Some((row.times[1], row.times[2]))),
        Of::new("times_least_lo", Unit::NONE, "lower end", |row| Cell::Number(row.times[1]))
            .is_of("times_least", Role::Lower, "Lower end of the 95 % interval of `times_least`."),
        Of::new("times_least_hi", Unit::NONE, "upper end", |row| Cell::Number(row.times[2]))
            .is_of("times_least", Role::Upper, "Upper end of the 95 % interval of `times_least`."),
        Of::new("as_good", Unit::NONE, "as good", |row| (if row.as_good { "yes" } else { "no" }).into())
            .is(Role::Note, "Whether the drift does not differ significantly from the least one: `yes` or `no`."),
    ]
}

/// The rows of `pareto.csv`.
fn rows(found: &Design) -> Vec<Row<'_>> {
    let row = |choice: Choice<'_>| {
        let best = choice.filler.best();
        let times = found.times_best(best);
        let (low, high) = times.interval.unwrap_or((times.value, times.value));
        (times.value, low, high, found.is_as_good(best))
    };
    let each = found.pareto().into_iter().map(|choice| (choice, row(choice)));
    each.map(|(choice, (value, low, high, as_good))| Row { choice, times: [value, low, high], as_good })
        .collect()
}

/// The choices that no other one beats in drift, latency and memory. `None` where there is nothing to trade: no swept key
/// and no constraint, or no fillers.
pub fn pareto_table(found: &Design) -> Option<Table> {
    let rows = rows(found);
    let is_shown = found.trades() && !rows.is_empty();
    is_shown.then(|| table_of(&found.keys(), &pareto_columns(), &rows, |row| &row.choice.variant.swept))
}

/// The same choices to read. `None` where there is no table of them.
pub(crate) fn by_choice(found: &Design) -> Option<Grid> {
    pareto_table(found)?;
    let keys = found.keys();
    let own = [
        "filler",
        "latency, ms",
        "memory, bytes",
        "best interval, s",
        found.measure.label(),
        "times the least",
    ];
    let head = keys.iter().map(|sweep| sweep.key.label).chain(own);
    let line = |row: Row| {
        let Row { choice, times, as_good } = row;
        let times = three_digits(times[0]);
        let is_best = std::ptr::eq(choice.filler, found.best());
        let own = [
            called(choice.filler).to_owned(),
            milliseconds(choice.cost.latency_s).trim_end_matches(" ms").to_owned(),
            choice.cost.memory.bytes().to_string(),
            four_digits(choice.filler.best().interval_s),
            format!("{} °/h", three_digits(choice.drift().value)),
            if as_good && !is_best { format!("{times}, as good") } else { times },
        ];
        choice.variant.swept.iter().map(|(_, value)| shown(value)).chain(own).collect::<Vec<_>>()
    };
    Some(Grid::new(head, rows(found).into_iter().map(line)))
}

/// Gives the choices that are not dominated as JSON.
pub(crate) fn pareto_json(found: &Design) -> Value {
    let one = |row: Row| {
        let Row { choice, times, as_good } = row;
        let [drift_lo, drift_hi] = ends(choice.drift());
        json!({
            "swept": swept(found, choice.variant),
            "filler": choice.filler.name,
            "interval_s": choice.filler.best().interval_s,
            "latency_s": choice.cost.latency_s,
            "memory_bytes": choice.cost.memory.bytes(),
            "constants_bytes": choice.cost.memory.constants,
            "drift": choice.drift().value,
            "drift_lo": drift_lo,
            "drift_hi": drift_hi,
            "times_least": times[0],
            "times_least_lo": times[1],
            "times_least_hi": times[2],
            "as_good": as_good,
        })
    };
    rows(found).into_iter().map(one).collect()
}

/// The limit of the study on the minimized drift of a run of this length, °/h; `None` where it has none on that estimate.
pub(crate) fn limit(found: &Design, duration_s: f64) -> Option<f64> {
    let required = found.study.requirement?;
    match (required.column, found.measure) {
        (column, measure) if column == measure.name() => Some(required.limit.value),
        // The same level as an angle.
        ("p99_73", Measure::DriftP9973) | ("rms", Measure::DriftRms) => {
            Some(required.limit.value / duration_s)
        }
        _ => None,
    }
}

/// The chart of the drift over the latency, with the front of the choices that no other one beats. `None` where
/// there is no table of them.
pub fn pareto_figure(found: &Design) -> Option<Figure> {
    pareto_table(found)?;
    let all = found.choices();
    let place = |choice: &Choice| (1e3 * choice.cost.latency_s, choice.drift().value);
    let mut names: Vec<&str> = Vec::new();
    for choice in &all {
        let name = called(choice.filler);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.sort_unstable();
    let sorted: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    let styles = of_names(LISTED, &sorted);
    let series = |(&style, name): (&usize, &&str)| {
        let own = all.iter().filter(|choice| called(choice.filler) == *name);
        let point = |choice: &Choice| {
            let (x, y) = place(choice);
            SeriesPoint { x, y, band: None, key: None }
        };
        Series { colour: style, dash: style, points: own.map(point).collect(), law: vec![] }
    };
    let mut series: Vec<Series> = styles.iter().zip(&names).map(series).collect();
    let front = stairs(all.iter().map(place).collect());
    let latency = found.constraints.latency_s.map(|latency_s| {
        let drifts = || all.iter().map(|choice| choice.drift().value);
        let [low, high] = [drifts().fold(f64::INFINITY, f64::min), drifts().fold(0.0, f64::max)];
        let x = 1e3 * latency_s;
        let line = LawLine { colours: vec![], points: vec![(x, low), (x, high)] };
        Law {
            label: format!("latency of at most {}", milliseconds(latency_s)),
            lines: vec![line],
            is_area: false,
        }
    });
    // A line of its own under the points, which are not joined then.
    series.insert(0, Series { colour: FRONT, dash: FRONT, points: vec![], law: front });
    let limit = limit(found, found.variant().duration_s);
    Some(Figure {
        title: found.study.title.clone(),
        subtitle: Some("each filler at its best interval, for all values of swept keys".to_owned()),
        x: Axis { scale: Scale::Linear, ..Axis::new("latency of the correction", "ms") },
        y: Axis::new(found.measure.label(), "°/h"),
        colours: Grouping {
            title: "filler".to_owned(),
            entries: styles.iter().zip(sorted).map(|(&style, name)| Entry { style, name }).collect(),
        },
        points: "best interval".to_owned(),
        lines: "least drift within a latency".to_owned(),
        series,
        laws: latency.into_iter().collect(),
        limit: limit.map(|value| Limit { value, label: format!("limit {} °/h", four_digits(value)) }),
        ..Figure::default()
    })
}

/// The least drift within each latency, as a line of steps from the soonest to the latest of these places.
fn stairs(mut places: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut line: Vec<(f64, f64)> = Vec::new();
    for &(x, y) in &places {
        match line.last() {
            Some(&(_, least)) if y >= least => {}
            Some(&(_, least)) => line.extend([(x, least), (x, y)]),
            None => line.push((x, y)),
        }
    }
    let end = places.last().zip(line.last()).map(|(last, least)| (last.0, least.1));
    line.into_iter().chain(end).collect()
}

/// Style of the line of the least drift, grey and solid, beyond those that fillers take.
const FRONT: usize = 54;
