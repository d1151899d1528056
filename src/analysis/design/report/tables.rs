//! The results of a design as a table and as a chart.

use core::slice;

use crate::analysis::design::answer::time;
use crate::analysis::design::report::{called, ends};
use crate::analysis::design::{Design, Filler, Measure, Tried, Variant};
use crate::view::from_table;
use sagnac_base::table::{Cell, Column, ColumnOf, Role, Table, Unit};
use sagnac_engine::chart::{Chart, Shows};
use sagnac_engine::filler::{FILLERS, LISTED};
use sagnac_engine::kinds::gap_fill::columns::FILLER;
use sagnac_engine::kinds::plan::table as table_of;
use sagnac_report::chart::figure::{Figure, Mark, Shape};
use sagnac_report::chart::notes::ChartError;

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
    for variant in variants {
        for filler in &variant.fillers {
            rows.extend(filler.tried.iter().map(|tried| Row { variant, filler, tried }));
        }
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
        label: time("interval", best.interval_s).text(),
    });
    Ok(figure)
}
