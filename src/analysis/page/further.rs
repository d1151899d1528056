//! Sections of analyses that are only made where they are asked for.

use crate::analysis::data_sheet;
use crate::analysis::dynamic::{self, Dynamic, words};
use crate::analysis::log::Analysis;
use crate::analysis::page::chart;
use crate::analysis::page::interval;
use crate::analysis::page::record::by_name;
use crate::analysis::temperature::tables::{Row, rows};
use crate::analysis::temperature::{self, Temperature, notes::notes};
use sagnac_base::quantity::number::significant;
use sagnac_report::answer::Answer;
use sagnac_report::chart::picture::Picture;
use sagnac_report::page::sections::{Block, Grid, Section};

/// The section on the dependence of a log on temperature, with its analyses before and after compensation.
pub fn of_temperature(found: &Temperature, [before, after]: [&Analysis; 2]) -> Section {
    let charts = temperature::figures::figures(found, [before, after]).into_iter();
    let charts = charts.map(|(stem, figure)| chart(&stem, Picture::Curves(figure)));
    let row = |(column, row): (&str, Row)| {
        let interval = row.interval.map(interval).unwrap_or_default();
        let value = row.value.map_or_else(|| "–".to_owned(), |value| significant(value, 4));
        let [_, unit] = row.unit;
        [column.to_owned(), row.name.to_owned(), value, interval, unit, row.verdict]
    };
    let of_column = |column| rows(column).into_iter().map(move |row| (&*column.name, row));
    let rows = found.columns.iter().flat_map(of_column).map(row);
    let head = ["column", "coefficient", "value", "95 % interval", "unit", "status"];
    let grids = [Grid::new(head, rows), compensated(found, [before, after])].into_iter();
    let grids = grids.filter(|grid| !grid.rows.is_empty()).map(Block::Grid);
    let range = found.columns.iter().filter_map(|column| {
        let [low, high] = column.found.as_ref().ok()?.averages.range_c.map(|end| significant(end, 4));
        Some((&*column.name, format!("{low} to {high} °C")))
    });
    let range = by_name(range.collect());
    let range = (!range.is_empty()).then(|| Block::Facts(vec![("Range", range)]));
    let notes = notes(found).into_iter().map(Block::Note);
    Section::new("temperature", "Temperature", charts.chain(grids).chain(range).chain(notes))
}

/// The coefficients of the noise before and after compensation, in the order before.
fn compensated(found: &Temperature, sides: [&Analysis; 2]) -> Grid {
    let of_column = |place: usize| {
        let [before, after] = sides.map(|side| side.columns[place].coefficients());
        let value = |rows: &[data_sheet::Row], name: &str| {
            let value = rows.iter().find(|row| row.name == name).and_then(|row| row.value);
            value.map_or_else(|| "–".to_owned(), |value| significant(value, 4))
        };
        let name = &*sides[0].columns[place].name;
        let rows = data_sheet::each_once(before.iter().chain(after)).into_iter().map(move |row| {
            let [before, after] = [before, after].map(|rows| value(rows, row.name));
            [name.to_owned(), row.name.to_owned(), before, after, row.symbol.to_owned()]
        });
        rows.collect::<Vec<_>>()
    };
    let known = (0..found.columns.len()).filter(|&place| found.columns[place].found.is_ok());
    let head = ["column", "noise", "before compensation", "after", "unit"];
    Grid::new(head, known.flat_map(of_column))
}

/// The section on navigators with the gyros of a log, beside another answer.
pub fn of_navigators(found: &Answer) -> Section {
    let headline = Block::Text(format!("{}.", found.headline));
    Section::new("navigators", "Navigators", [headline, Block::Options(found.table.clone())])
}

/// The section on the noise of a log over time.
pub fn of_dynamic(found: &Dynamic) -> Section {
    let said = found.columns.iter().map(|column| (&*column.name, words::sentence(column))).collect();
    let said = by_name(said).into_iter().map(Block::Text);
    let maps = dynamic::figures::figures(found).into_iter();
    let maps = maps.map(|(stem, map)| chart(&stem, Picture::Map(map)));
    Section::new("dynamic", "Over time", said.chain(maps))
}
