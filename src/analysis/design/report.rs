//! The report of a design: the answer with the best interval and filler and what the others cost, tables, and charts with what latency
//! and memory cost.

use core::slice;

use crate::analysis::answer::reading_of_limit;
use crate::analysis::decision::Sheet;
use crate::analysis::design::candidates::milliseconds;
use crate::analysis::design::result::{fillers_of, time};
use crate::analysis::design::{Cost, Design, Filler, Found, Measure, PapersRule, Tried, Variant};
use crate::view::from_table;
use sagnac_base::diagnostics::listed;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::{Cell, Column, ColumnOf, Role, Table, Unit};
use sagnac_engine::chart::{Chart, Shows};
use sagnac_engine::filler::{FILLERS, LISTED};
use sagnac_engine::key::sweep::Scale;
use sagnac_engine::kinds::gap_fill::columns::FILLER;
use sagnac_engine::kinds::plan::table as table_of;
use sagnac_report::answer::reading::{joined, number, range};
use sagnac_report::answer::{Answer, AnswerCell, AnswerTable, Fact, Kind, Reading, Status};
use sagnac_report::chart::ChartError;
use sagnac_report::chart::figure::{
    Axis, Entry, Figure, Grouping, Law, Limit, Mark, Series, SeriesPoint, Shape,
};
use sagnac_report::chart::palette::of_names;

/// A time in the largest unit of which it has at least one.
pub(crate) fn duration(time_s: f64) -> String {
    let (unit, size) = match time_s {
        ..60.0 => ("s", 1.0),
        ..3600.0 => ("min", 60.0),
        _ => ("h", 3600.0),
    };
    format!("{} {unit}", four_digits(time_s / size))
}

fn four_digits(value: f64) -> String {
    significant(value, 4)
}

/// A row of `design.csv`.
pub(crate) struct Row<'a> {
    variant: &'a Variant,
    filler: &'a Filler,
    tried: &'a Tried,
}

type Of<'a> = ColumnOf<Row<'a>>;

/// The columns of `design.csv` before those of the measure.
#[rustfmt::skip]
fn first_columns<'a>() -> [Of<'a>; 3] {
    [
        Of::new("filler", Unit::NONE, "filler", |row| row.filler.called().into())
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
                Of::new(low, Unit::DEG_PER_H, "lower end", |row| row.tried.drift.ends()[0].into()).is_of(
                    $name,
                    Role::Lower,
                    lower,
                ),
                Of::new(high, Unit::DEG_PER_H, "upper end", |row| row.tried.drift.ends()[1].into()).is_of(
                    $name,
                    Role::Upper,
                    upper,
                ),
            ]
        }};
    }
    match measure {
        Measure::DriftP9973 => {
            columns!("drift_p99_73", "Drift, °/h, which 99.73 % of runs with that interval stay below.")
        }
        Measure::DriftRms => {
            columns!("drift_rms", "Root mean square drift with that interval, °/h (measure `drift_rms`).")
        }
        Measure::LargestP9973 => columns!(
            "largest_p99_73",
            "99.73 % level of the largest angle of a run divided by its duration, °/h (measure `largest_p99_73`)."
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
        Cell::Number(row.variant.angle(row.tried.drift.value))
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

/// The table of all results, with a row for each combination of swept keys, filler and interval.
pub fn table(found: &Design) -> Table {
    of_variants(found, &found.variants)
}

/// The results of some variants.
fn of_variants(found: &Design, variants: &[Variant]) -> Table {
    let mut rows = Vec::new();
    for (variant, filler) in fillers_of(variants) {
        rows.extend(filler.tried.iter().map(|tried| Row { variant, filler, tried }));
    }
    table_of(&found.keys(), &columns(&[found.measure]), &rows, |row| &row.variant.swept)
}

/// The chart of the drift over the interval for each filler, at the best values of swept keys.
///
/// # Errors
/// The values cannot be drawn.
pub fn figure(found: &Design) -> Result<Figure, ChartError> {
    let (variant, table) = (found.variant(), &of_variants(found, slice::from_ref(found.variant())));
    fn name(column: Option<&Column>) -> &str {
        column.map_or("", |column| &column.name)
    }
    let filler = name(table.listed_by(FILLERS));
    let series = if variant.fillers.len() > 1 { vec![filler.into()] } else { vec![] };
    let chart = Chart {
        title: found.study.title.clone(),
        subtitle: found.headline(),
        x: name(table.of_role(Role::Coordinate)).into(),
        y: name(table.of_role(Role::Error)).into(),
        shows: Shows::Curves { series, laws: vec![] },
        apart: vec![filler.to_owned()],
        points: "Monte Carlo".to_owned(),
        bands: "95 % band".to_owned(),
        ..Chart::default()
    };
    let mut figure = from_table::figure(table, &chart)?.0;
    let (filler, best) = (found.best(), found.best().best());
    let [from, to] = filler.flat();
    figure.marks.push(Mark {
        shape: Shape::Extremum,
        place: (best.interval_s, best.drift.value),
        range: Some((from, to)).filter(|_| from < to),
        label: best.interval().text(),
    });
    Ok(figure)
}

/// A filler at its best interval: a row of `pareto.csv` and `fillers.csv`.
pub(crate) struct Best<'a> {
    variant: &'a Variant,
    filler: &'a Filler,
    times: Found,
    as_good: bool,
}

impl Best<'_> {
    fn new<'a>(found: &Design, variant: &'a Variant, filler: &'a Filler) -> Best<'a> {
        let best = filler.best();
        Best { variant, filler, times: found.times_best(best), as_good: found.is_as_good(best) }
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
pub(crate) fn pareto_columns<'a>() -> Vec<ColumnOf<Best<'a>>> {
    type Of<'a> = ColumnOf<Best<'a>>;
    vec![
        Of::new("filler", Unit::NONE, "filler", |row| row.filler.called().into())
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
        Of::new("drift_lo", Unit::DEG_PER_H, "lower end", |row| row.drift().ends()[0].into())
            .is_of("drift", Role::Lower, "Lower end of the 95 % interval of `drift`, °/h."),
        Of::new("drift_hi", Unit::DEG_PER_H, "upper end", |row| row.drift().ends()[1].into())
            .is_of("drift", Role::Upper, "Upper end of the 95 % interval of `drift`, °/h."),
        Of::new("times_least", Unit::NONE, "times the least", |row| Cell::Number(row.times.value))
            .is(Role::Estimate, "Ratio of the drift to the least one, in runs with the same random numbers.")
            .within(|row| row.times.interval),
        Of::new("times_least_lo", Unit::NONE, "lower end", |row| row.times.ends()[0].into())
            .is_of("times_least", Role::Lower, "Lower end of the 95 % interval of `times_least`."),
        Of::new("times_least_hi", Unit::NONE, "upper end", |row| row.times.ends()[1].into())
            .is_of("times_least", Role::Upper, "Upper end of the 95 % interval of `times_least`."),
        Of::new("as_good", Unit::NONE, "as good", |row| (if row.as_good { "yes" } else { "no" }).into())
            .is(Role::Note, "Whether the drift does not differ significantly from the least one: `yes` or `no`."),
    ]
}

/// The columns of `fillers.csv` except the swept keys, in the order of the file.
#[rustfmt::skip]
pub(crate) fn filler_columns<'a>() -> Vec<ColumnOf<Best<'a>>> {
    type Of<'a> = ColumnOf<Best<'a>>;
    let further = [
        Of::new("interval_lo", Unit::S, "lower end", |row| row.filler.optimum.ends()[0].into())
            .is_of("interval", Role::Lower, "Lower end of the 95 % interval of the best switching interval, s; blank where too few were tried around it."),
        Of::new("interval_hi", Unit::S, "upper end", |row| row.filler.optimum.ends()[1].into())
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

/// The table of some fillers at their best intervals.
fn of_best<'d>(
    found: &Design,
    columns: &[ColumnOf<Best<'d>>],
    fillers: impl IntoIterator<Item = (&'d Variant, &'d Filler)>,
) -> Table {
    let rows = fillers.into_iter().map(|(variant, filler)| Best::new(found, variant, filler));
    table_of(&found.keys(), columns, &rows.collect::<Vec<_>>(), |row| &row.variant.swept)
}

/// Each filler at its best interval, for each combination of swept values.
pub(crate) fn filler_table(found: &Design) -> Table {
    of_best(found, &filler_columns(), found.fillers())
}

/// The choices that no other one beats in drift, latency and memory. `None` where there is nothing to trade: no swept key
/// and no constraint, or no fillers.
pub(crate) fn pareto_table(found: &Design) -> Option<Table> {
    let front = found.pareto();
    let is_shown = found.trades() && !front.is_empty();
    is_shown.then(|| of_best(found, &pareto_columns(), front))
}

/// The limit of the study on the minimized drift of a run of this length, °/h; `None` where it has none on that estimate.
fn limit(found: &Design, duration_s: f64) -> Option<f64> {
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
pub(crate) fn pareto_figure(found: &Design) -> Option<Figure> {
    pareto_table(found)?;
    let mut all: Vec<(&str, (f64, f64))> = Vec::new();
    for (_, filler) in found.fillers() {
        let place = |cost: Cost| (1e3 * cost.latency_s, filler.best().drift.value);
        all.extend(filler.cost.map(|cost| (filler.called(), place(cost))));
    }
    let mut names: Vec<String> = all.iter().map(|(name, _)| (*name).to_owned()).collect();
    names.sort_unstable();
    names.dedup();
    let styles = of_names(LISTED, &names);
    let series = |(&style, name): (&usize, &String)| {
        let own = all.iter().filter(|(own, _)| own == name);
        Series::of_points(style, own.map(|&(_, (x, y))| SeriesPoint::new(x, y)).collect())
    };
    let mut series: Vec<Series> = styles.iter().zip(&names).map(series).collect();
    let front = stairs(all.iter().map(|(_, place)| *place).collect());
    let latency = found.constraints.latency_s.map(|latency_s| {
        let drifts = || all.iter().map(|(_, (_, drift))| *drift);
        let [low, high] = [drifts().fold(f64::INFINITY, f64::min), drifts().fold(0.0, f64::max)];
        let x = 1e3 * latency_s;
        let label = format!("latency of at most {}", milliseconds(latency_s));
        Law::line(label, vec![(x, low), (x, high)])
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
            entries: styles.iter().zip(names).map(|(&style, name)| Entry { style, name }).collect(),
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

/// The excess over the least drift up to which an interval costs as much.
const FLAT: f64 = 0.04;

/// Most choices that a caveat names.
const MAX_NAMED: usize = 2;

fn reading(label: &str, found: Found) -> Reading {
    Reading::in_unit(
        label,
        found.value,
        Unit::DEG_PER_H.symbol,
        found.interval.map(|(low, high)| [low, high]),
    )
}

impl Filler {
    /// The intervals around the best one between which the drift is at most 4 % larger, by straight lines between those that were
    /// tried.
    pub(super) fn flat(&self) -> [f64; 2] {
        let most = (1.0 + FLAT) * self.best().drift.value;
        let edge = |tried: &mut dyn Iterator<Item = &Tried>| {
            let mut last = self.best();
            for next in tried {
                if next.drift.value > most {
                    let part = (most - last.drift.value) / (next.drift.value - last.drift.value);
                    return last.interval_s + part * (next.interval_s - last.interval_s);
                }
                last = next;
            }
            last.interval_s
        };
        let (before, after) = self.tried.split_at(self.best);
        [edge(&mut before.iter().rev()), edge(&mut after.iter().skip(1))]
    }

    fn flat_text(&self) -> String {
        let [from, to] = self.flat();
        match from == to {
            true => time("", from).text(),
            false => joined(&range(&number(from), &number(to)), "s"),
        }
    }
}

impl Design {
    /// The answer, with the facts of its `sheet`.
    pub fn answer(&self, sheet: Option<&Sheet>) -> Answer {
        let best = self.best().best();
        Answer {
            kind: Kind::Optimum,
            status: sheet.map_or(Status::NoLimit, Sheet::status),
            headline: self.headline(),
            value: Some(reading(self.measure.label(), best.drift)),
            limit: sheet.and_then(|sheet| sheet.limit).map(reading_of_limit),
            table: self.options(),
            facts: self.facts(sheet),
            checks: vec![],
        }
    }

    /// Interval and filler, with the drift.
    pub fn headline(&self) -> String {
        let best = self.best();
        let choice = self.named(self.variant(), best);
        let choice = if choice.is_empty() { choice } else { format!(" with {choice}") };
        let interval = best.best().interval().text();
        let drift = reading(self.measure.label(), best.best().drift).with_interval();
        format!("Switch every {interval}{choice}: {drift}")
    }

    /// A row for each filler with each combination of swept values, at its own best interval.
    fn options(&self) -> AnswerTable {
        let mut all: Vec<(&Variant, &Filler)> = self.fillers().collect();
        let is_best = |filler: &Filler| std::ptr::eq(filler, self.best());
        all.sort_by(|a, b| {
            let drift = |filler: &Filler| self.deciding(filler.best());
            is_best(b.1).cmp(&is_best(a.1)).then(drift(a.1).total_cmp(&drift(b.1)))
        });
        let name = |variant: &Variant, filler: &Filler| match self.named(variant, filler) {
            name if name.is_empty() => filler.called().to_owned(),
            name => name,
        };
        let row = |(variant, filler): &(&Variant, &Filler)| -> Vec<AnswerCell> {
            let best = filler.best();
            let end = if filler.is_at_edge() { " (end)" } else { "" };
            let interval = best.interval();
            vec![
                name(variant, filler).into(),
                AnswerCell::with_text(interval.text() + end, interval),
                filler.flat_text().into(),
                reading(self.measure.label(), best.drift).into(),
                Reading::in_unit("angle", variant.angle(best.drift.value), "″", None).into(),
                number(self.times_best(best).value).into(),
            ]
        };
        let alike = self.variants.iter().all(|variant| variant.duration_s == self.variant().duration_s);
        let after = if alike { duration(self.variant().duration_s) } else { "the run".to_owned() };
        let after = format!("after {after}");
        let heads = ["filler", "interval", "within 4 %", self.measure.label(), &after, "× best"];
        AnswerTable { best: Some(0), ..AnswerTable::new(heads, all.iter().map(row)) }
    }

    fn facts(&self, sheet: Option<&Sheet>) -> Vec<Fact> {
        let best = self.best();
        let label = self.measure.label();
        let mut facts = sheet.map(Sheet::facts).unwrap_or_default();
        if let Some((low, high)) = best.optimum.interval {
            let interval = Reading::in_unit("interval", best.best().interval_s, "s", Some([low, high]));
            facts.push(Fact::value("Best interval", interval, ""));
        }
        if let Some(cost) = best.cost.filter(|_| self.trades()) {
            facts.push(Fact::value("Latency", time("latency", cost.latency_s), ""));
            let bytes = Reading::in_unit("memory", cost.memory.bytes() as f64, "bytes", None);
            facts.push(Fact::value("Memory", bytes, ""));
        }
        if let Some(PapersRule { interval_s, tried, .. }) = &best.papers_rule {
            let drift = Reading { interval: None, ..reading(label, tried.drift) };
            let times = number(100.0 * (self.times_best(tried).value - 1.0));
            facts.push(Fact::value(
                "Paper's rule",
                drift,
                &format!("at {}, {times} % more", time("", *interval_s).text()),
            ));
        }
        if self.variant().non_magnetic != 0.0 {
            let switched = Reading { interval: None, ..reading(label, best.best().switched) };
            facts.push(Fact::value("From switching alone", switched, ""));
        }
        let alike: Vec<String> = self
            .fillers()
            .filter(|(_, filler)| !std::ptr::eq(*filler, best) && self.is_as_good(filler.best()))
            .map(|(variant, filler)| self.named(variant, filler))
            .collect();
        if !alike.is_empty() {
            let more = alike.len().saturating_sub(MAX_NAMED);
            let mut names: Vec<String> = alike.into_iter().take(MAX_NAMED).collect();
            names.extend((more > 0).then(|| format!("{more} more")));
            facts.push(Fact::caveat(format!("not distinguishable: {}", listed(&names))));
        }
        if best.is_at_edge() {
            facts.push(Fact::caveat("the best interval is an end of those tried"));
        }
        facts
    }
}
