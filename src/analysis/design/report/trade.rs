//! What latency and memory cost: each filler at its best interval, and the choices that no other one beats, as tables and a chart.

use crate::analysis::design::candidates::milliseconds;
use crate::analysis::design::report::{called, ends, four_digits};
use crate::analysis::design::result::Choice;
use crate::analysis::design::{Cost, Design, Filler, Found, Measure, PapersRule, Variant};
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_engine::filler::{FILLERS, LISTED};
use sagnac_engine::key::sweep::Scale;
use sagnac_engine::kinds::gap_fill::columns::FILLER;
use sagnac_engine::kinds::plan::table as table_of;
use sagnac_report::chart::figure::{Axis, Entry, Figure, Grouping, Law, LawLine, Limit, Series, SeriesPoint};
use sagnac_report::chart::palette::of_names;

/// A filler at its best interval: a row of `pareto.csv` and `fillers.csv`.
pub(crate) struct Row<'a> {
    variant: &'a Variant,
    filler: &'a Filler,
    times: Found,
    as_good: bool,
}

impl Row<'_> {
    fn new<'a>(found: &Design, variant: &'a Variant, filler: &'a Filler) -> Row<'a> {
        let best = filler.best();
        Row { variant, filler, times: found.times_best(best), as_good: found.is_as_good(best) }
    }

    fn drift(&self) -> Found {
        self.filler.best().drift
    }

    fn of_cost<T: Into<Cell>>(&self, of: fn(Cost) -> T) -> Cell {
        self.filler.cost.map_or(Cell::Blank, |cost| of(cost).into())
    }

    fn of_rule(&self, of: fn(&PapersRule) -> f64) -> Cell {
        self.filler.papers_rule.as_ref().map(of).into()
    }
}

/// The columns of `pareto.csv` except the swept keys, in the order of the file.
#[rustfmt::skip]
pub(crate) fn pareto_columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("filler", Unit::NONE, "filler", |row| called(row.filler).into())
            .is_of(FILLERS, Role::Key, FILLER)
            .styled(LISTED),
        Of::new("latency", Unit::S, "latency", |row| row.of_cost(|cost| cost.latency_s))
            .is(Role::Coordinate, "Time from the end of the gap to the correction, s."),
        Of::new("memory", Unit::NONE, "memory, bytes", |row| row.of_cost(|cost| cost.memory.bytes()))
            .is(Role::Count, "Memory of the filler in firmware on a 32-bit processor, bytes: constants and state."),
        Of::new("constants", Unit::NONE, "constants, bytes", |row| row.of_cost(|cost| cost.memory.constants))
            .is(Role::Count, "Its part that holds ticks and weights, which may be in flash, bytes."),
        Of::new("interval", Unit::S, "switching interval", |row| Cell::Number(row.filler.best().interval_s))
            .is(Role::Coordinate, "Best switching interval, s."),
        Of::new("drift", Unit::DEG_PER_H, "drift", |row| Cell::Number(row.drift().value))
            .is(Role::Error, "The minimized drift there, °/h: the estimate that `--by` names.")
            .within(|row| row.drift().interval),
        Of::new("drift_lo", Unit::DEG_PER_H, "lower end", |row| ends(row.drift())[0].into())
            .is_of("drift", Role::Lower, "Lower end of the 95 % interval of `drift`, °/h."),
        Of::new("drift_hi", Unit::DEG_PER_H, "upper end", |row| ends(row.drift())[1].into())
            .is_of("drift", Role::Upper, "Upper end of the 95 % interval of `drift`, °/h."),
        Of::new("times_least", Unit::NONE, "times the least", |row| Cell::Number(row.times.value))
            .is(Role::Estimate, "Ratio of the drift to the least one, in runs with the same random numbers.")
            .within(|row| row.times.interval),
        Of::new("times_least_lo", Unit::NONE, "lower end", |row| ends(row.times)[0].into())
            .is_of("times_least", Role::Lower, "Lower end of the 95 % interval of `times_least`."),
        Of::new("times_least_hi", Unit::NONE, "upper end", |row| ends(row.times)[1].into())
            .is_of("times_least", Role::Upper, "Upper end of the 95 % interval of `times_least`."),
        Of::new("as_good", Unit::NONE, "as good", |row| (if row.as_good { "yes" } else { "no" }).into())
            .is(Role::Note, "Whether the drift does not differ significantly from the least one: `yes` or `no`."),
    ]
}

/// The columns of `fillers.csv` except the swept keys, in the order of the file.
#[rustfmt::skip]
pub(crate) fn filler_columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    let further = [
        Of::new("interval_lo", Unit::S, "lower end", |row| ends(row.filler.optimum)[0].into())
            .is_of("interval", Role::Lower, "Lower end of the 95 % interval of the best switching interval, s; blank where too few were tried around it."),
        Of::new("interval_hi", Unit::S, "upper end", |row| ends(row.filler.optimum)[1].into())
            .is_of("interval", Role::Upper, "Upper end of the 95 % interval of the best switching interval, s."),
        Of::new("angle", Unit::ARCSEC, "angle at the end", |row| Cell::Number(row.variant.angle(row.drift().value)))
            .is(Role::Estimate, "The drift times the run time, ″."),
        Of::new("duration", Unit::S, "run time", |row| Cell::Number(row.variant.duration_s))
            .is(Role::Estimate, "Run time, s."),
        Of::new("residual_rms", Unit::ARCSEC, "rms residual", |row| row.filler.residual_rms.into())
            .is(Role::Estimate, "Root mean square residual of a switch, ″; blank without fillers."),
        Of::new("residual_max", Unit::ARCSEC, "largest residual", |row| row.filler.residual_max.into())
            .is(Role::Estimate, "Bound on the residual of a switch, ″; blank where there is none."),
        Of::new("rule_interval", Unit::S, "interval of the paper's rule", |row| row.of_rule(|rule| rule.interval_s))
            .is(Role::Estimate, "Switching interval by the paper's rule, s; blank where the rule does not apply."),
        Of::new("rule_bound", Unit::DEG_PER_H, "bound of the paper's rule", |row| row.of_rule(|rule| rule.bound))
            .is(Role::Estimate, "Bound on the drift by the paper's rule, °/h."),
        Of::new("rule_drift", Unit::DEG_PER_H, "drift at the paper's interval", |row| row.of_rule(|rule| rule.tried.drift.value))
            .is(Role::Estimate, "Drift at the interval of the paper's rule, °/h: the estimate that `--by` names."),
    ];
    pareto_columns().into_iter().chain(further).collect()
}

/// The rows of `pareto.csv`.
fn rows(found: &Design) -> Vec<Row<'_>> {
    let front = found.pareto().into_iter();
    front.map(|choice| Row::new(found, choice.variant, choice.filler)).collect()
}

/// Each filler at its best interval, for each combination of swept values.
pub fn filler_table(found: &Design) -> Table {
    let mut rows = Vec::new();
    for variant in &found.variants {
        rows.extend(variant.fillers.iter().map(|filler| Row::new(found, variant, filler)));
    }
    table_of(&found.keys(), &filler_columns(), &rows, |row| &row.variant.swept)
}

/// The choices that no other one beats in drift, latency and memory. `None` where there is nothing to trade: no swept key
/// and no constraint, or no fillers.
pub fn pareto_table(found: &Design) -> Option<Table> {
    let rows = rows(found);
    let is_shown = found.trades() && !rows.is_empty();
    is_shown.then(|| table_of(&found.keys(), &pareto_columns(), &rows, |row| &row.variant.swept))
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
