//! The coefficients of a log as small tables.

use crate::allan::Unit;
use crate::analysis::data_sheet::{Row, each_once};
use crate::analysis::log::{Analysis, Column};
use crate::analysis::page::longer;
use crate::analysis::page::record::by_name;
use crate::analysis::page::values::{interval, range, stability};
use crate::quantity::number::significant;
use crate::view::report::sections::{Block, Cell, Grid, Section};

pub(crate) fn section(noise: &Analysis) -> Section {
    let columns: Vec<&Column> =
        noise.columns.iter().filter(|column| !column.coefficients().is_empty()).collect();
    let is_there = |unit: &Unit| columns.iter().any(|column| column.unit == *unit);
    let grids = Unit::ALL.into_iter().filter(is_there).map(|unit| {
        let columns: Vec<&Column> = columns.iter().copied().filter(|column| column.unit == unit).collect();
        Block::Grid(if let [column] = columns[..] { of_one(column) } else { of_several(&columns) })
    });
    let of = |said: &dyn Fn(&Column) -> Option<String>| {
        by_name(noise.columns.iter().filter_map(|column| Some((&*column.name, said(column)?))).collect())
    };
    let facts = [
        ("Fit", of(&fit)),
        ("95 % intervals", of(&|column| Some(column.noise()?.intervals.words()))),
        ("In-run bias stability", of(&stability)),
        ("Record that would show B", by_name(longer::records(noise))),
    ];
    let facts: Vec<_> = facts.into_iter().filter(|(_, lines)| !lines.is_empty()).collect();
    let facts = (!facts.is_empty()).then_some(Block::Facts(facts));
    Section::new("coefficients", "Coefficients", grids.chain(facts))
}

/// A row for each coefficient.
fn of_one(column: &Column) -> Grid {
    let row = |row: &Row| {
        let interval = match (row.value, row.interval) {
            (Some(_), Some(ends)) => interval(ends),
            _ => bound(row),
        };
        let value = row.value.map_or_else(String::new, |value| significant(value, 4));
        [row.name.to_owned(), value, interval, row.symbol.to_owned(), row.verdict.to_owned()]
    };
    let head = ["coefficient", "value", "95 % interval", "unit", "status"];
    Grid::new(head, column.coefficients().iter().map(row))
}

/// A row for each coefficient, with a cell for each column.
fn of_several(columns: &[&Column]) -> Grid {
    let found = each_once(columns.iter().flat_map(|column| column.coefficients()));
    let row = |first: &&Row| {
        let cell = |column: &&Column| {
            let own = column.coefficients().iter().find(|row| row.name == first.name);
            own.map_or_else(Cell::default, cell)
        };
        let named = [first.name, first.symbol].map(Cell::from);
        named.into_iter().chain(columns.iter().map(cell)).collect::<Vec<_>>()
    };
    let head = ["coefficient", "unit"].into_iter().chain(columns.iter().map(|column| &*column.name));
    Grid::new(head, found.iter().map(row))
}

/// A value over its interval, or a bound over the verdict.
fn cell(row: &Row) -> Cell {
    match (row.value, row.interval) {
        (Some(value), Some(ends)) => Cell { text: significant(value, 4), below: interval(ends) },
        (Some(value), None) => significant(value, 4).into(),
        (None, _) => {
            // What the bound says already is left out.
            let verdict = row.verdict.split(',').next().unwrap_or_default();
            Cell { text: bound(row), below: verdict.to_owned() }
        }
    }
}

/// The upper end of the interval of a coefficient without a value.
fn bound(row: &Row) -> String {
    row.interval.map_or_else(|| "–".to_owned(), |[_, most]| format!("≤ {}", significant(most, 3)))
}

/// The range of a fit, and how well it describes the curve.
fn fit(column: &Column) -> Option<String> {
    let fit = &column.noise()?.fit;
    let p = fit.p_value().map_or_else(String::new, |p| format!(", p = {}", significant(p, 2)));
    let described = if fit.is_described() { "" } else { "; model rejected" };
    let freedom = fit.degrees_of_freedom;
    let chi_squared = significant(fit.chi_squared, 3);
    let range = range(fit);
    Some(format!("{range}, χ² = {chi_squared} of {freedom} degrees of freedom{p}{described}"))
}
