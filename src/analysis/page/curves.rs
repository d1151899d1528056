//! The deviations of a log as small tables.

use crate::allan::noise::LEAST_GROUPS;
use crate::allan::{Point, Unit};
use crate::analysis::log::{Analysis, Column, Curve};
use crate::analysis::page::values::interval;
use crate::quantity::number::significant;
use crate::table::titled;
use crate::view::report::sections::{Block, Cell, Grid};

/// A table for each deviation of each unit.
pub(crate) fn tables(noise: &Analysis) -> Vec<Block> {
    let of_unit = |unit: Unit| {
        let columns: Vec<&Column> = noise.of_unit(unit).collect();
        let count = columns.first().map_or(0, |column| column.curves.len());
        let of_deviation = |at: usize| {
            let curves: Vec<&Curve> = columns.iter().map(|column| &column.curves[at]).collect();
            let deviation = curves[0].deviation;
            let title = titled(deviation.title(), unit.symbol(deviation));
            let grid = match (&curves[..], &columns[..]) {
                ([curve], _) => of_one(curve, unit, &noise.percent()),
                (_, columns) => of_several(&curves, columns),
            };
            Block::More(format!("{title}, with {} intervals", noise.percent()), grid)
        };
        (0..count).map(of_deviation).collect::<Vec<_>>()
    };
    noise.units().flat_map(of_unit).collect()
}

/// A row for each averaging time of a curve.
fn of_one(curve: &Curve, unit: Unit, percent: &str) -> Grid {
    let row = |point: &Point| {
        let kind = point.noise.map_or_else(String::new, |noise| {
            let carried =
                if noise.carried { format!(", below {LEAST_GROUPS} averages") } else { String::new() };
            format!("{} (α = {}){carried}", noise.name(unit), noise.alpha)
        });
        let [tau, terms] = [significant(point.tau_s, 7), point.terms.to_string()];
        let value = point.value.map_or_else(String::new, |value| significant(value, 4));
        let ends = point.interval.map_or_else(String::new, |ends| interval(ends.into()));
        [tau, terms, value, ends, kind]
    };
    let ends = format!("{percent} interval");
    let head = ["τ, s", "number", curve.deviation.name(), &ends, "noise"];
    Grid::new(head, curve.points.iter().map(row))
}

/// A row for each averaging time, with a cell for each column.
fn of_several(curves: &[&Curve], columns: &[&Column]) -> Grid {
    let row = |at: usize| {
        let cell = |curve: &&Curve| {
            let point = &curve.points[at];
            let below = point.interval.map_or_else(String::new, |ends| interval(ends.into()));
            point.value.map_or_else(Cell::default, |value| Cell { text: significant(value, 4), below })
        };
        let tau = significant(curves[0].points[at].tau_s, 7).into();
        std::iter::once(tau).chain(curves.iter().map(cell)).collect::<Vec<_>>()
    };
    let head = std::iter::once("τ, s").chain(columns.iter().map(|column| &*column.name));
    Grid::new(head, (0..curves[0].points.len()).map(row))
}
