//! The data of a page for its script, as compressed JSON.

use crate::chart::axis::{Range, Scale, edges as cell_edges};
use std::borrow::Cow;
use std::io::{self, Write};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use serde_json::ser::Formatter;
use serde_json::value::RawValue;

use crate::chart::figure::{Axis, Figure};
use crate::chart::map::{Estimate, Words};
use crate::chart::palette::Looks;
use crate::chart::ticks::{Ladder, superscript};
use crate::chart::{Drawn, Picture};
use sagnac_base::quantity::number::significant;
use sagnac_base::table::{Cell, Column, Role, Table, titled};

/// Number of significant digits, as in files.
const DIGITS: usize = 9;

/// Most cells of a table in a page, which keep it below 1.5 MB and fast to draw.
const MAX_CELLS: usize = 80_000;

/// Whole numbers below this are shown in full.
const MAX_WHOLE: f64 = 1e15;

/// Most points of all curves of a page.
const MAX_POINTS: usize = 20_000;

#[derive(Serialize)]
struct Data<'t> {
    looks: Looks,
    charts: Vec<Chart>,
    tables: Vec<Listed<'t>>,
}

#[derive(Serialize)]
struct Chart {
    stem: String,
    picture: Box<RawValue>,
    axes: Axes,
    /// The legend of a map.
    words: Option<Words>,
}

/// The part of a table in a page.
#[derive(Serialize)]
pub struct Listed<'t> {
    pub file: &'t str,
    /// Number of rows of the whole table.
    pub rows: usize,
    pub all_columns: usize,
    /// Number of rows in the page.
    shown: usize,
    columns: Vec<Listing<'t>>,
}

/// Rows that a table shows at first, also on paper and without scripts.
const FIRST_ROWS: usize = 25;

#[derive(Serialize)]
struct Listing<'t> {
    header: String,
    title: String,
    /// The number of units in which people read it in one of its cells.
    factor: f64,
    /// Its meaning.
    about: &'t str,
    /// Whether it holds text.
    text: bool,
    /// Whether it distinguishes rows.
    tells: bool,
    /// Cells; a single one if all are equal.
    cells: Box<RawValue>,
    /// The first cells as people read them.
    #[serde(skip)]
    first: Vec<String>,
}

impl Listed<'_> {
    /// The headings of the columns, and their classes.
    pub fn headings(&self) -> impl Iterator<Item = (&str, Option<&'static str>)> {
        self.columns.iter().map(|column| (column.title.as_str(), column.class()))
    }

    /// The first rows, each cell with its class.
    pub fn first_rows(&self) -> impl Iterator<Item = Vec<(&str, Option<&'static str>)>> {
        let rows = self.columns.first().map_or(0, |column| column.first.len());
        (0..rows).map(|row| self.columns.iter().map(|column| (&*column.first[row], column.class())).collect())
    }

    /// How many of the rows the page shows at first.
    pub fn counted(&self) -> String {
        match self.shown {
            shown if shown > FIRST_ROWS => format!("{FIRST_ROWS} of {shown} rows"),
            1 => "1 row".to_owned(),
            shown => format!("{shown} rows"),
        }
    }

    /// The part of the table that the page omits, if any.
    pub fn left_out(&self) -> Option<String> {
        let (rows, columns) = (self.shown, self.columns.len());
        let first = || format!("the first {rows} of {} rows", self.rows);
        let charted = || format!("the {columns} columns that charts show, of {}", self.all_columns);
        let parts = [(rows < self.rows).then(first), (columns < self.all_columns).then(charted)];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        let part = parts.join(" and ");
        (!part.is_empty()).then(|| format!("The page has {part}; all are in {}.", self.file))
    }
}

impl Listing<'_> {
    fn class(&self) -> Option<&'static str> {
        self.text.then_some("text")
    }
}

/// The data of a page, with the parts of the report that it contains.
pub struct Packed<'t> {
    pub text: String,
    pub tables: Vec<Listed<'t>>,
    /// Thinning factor of the points of curves.
    pub thinned: usize,
}

/// The data of the charts that a page has; tables have the columns of `all` charts first.
pub fn data<'t>(charts: &[&Drawn], all: &[&Drawn], tables: &[(&'t str, &'t Table)]) -> Packed<'t> {
    let points = charts.iter().map(|drawn| match &drawn.picture {
        Picture::Curves(figure) => figure.all_points().count(),
        Picture::Map(_) => 0,
    });
    let thinned = points.sum::<usize>().div_ceil(MAX_POINTS).max(1);
    let packed_charts = charts.iter().map(|drawn| Chart {
        stem: drawn.stem.clone(),
        picture: json(&one_in(thinned, &drawn.picture)),
        axes: Axes::new(&drawn.picture),
        words: match &drawn.picture {
            Picture::Curves(_) => None,
            Picture::Map(map) => Some(map.words()),
        },
    });
    let tables: Vec<Listed> = tables.iter().map(|(file, table)| listed(file, table, all)).collect();
    let data = Data { looks: Looks::new(), charts: packed_charts.collect(), tables };
    Packed { text: packed(json(&data).get().as_bytes()), tables: data.tables, thinned }
}

/// A picture with only every `step`-th point of its curves and laws.
pub fn one_in(step: usize, picture: &Picture) -> Cow<'_, Picture> {
    let Picture::Curves(figure) = picture else { return Cow::Borrowed(picture) };
    if step == 1 {
        return Cow::Borrowed(picture);
    }
    let mut figure = figure.clone();
    for series in &mut figure.series {
        series.points = thin(&series.points, step, |point| point.y);
        series.law = thin(&series.law, step, |point| point.1);
    }
    let lines = figure.laws.iter_mut().filter(|law| !law.is_area);
    for line in lines.flat_map(|law| &mut law.lines) {
        line.points = thin(&line.points, step, |point| point.1);
    }
    Cow::Owned(Picture::Curves(figure))
}

/// The first item, every `step`-th one, the last, and those without a value, where a line is interrupted.
fn thin<T: Copy>(items: &[T], step: usize, value: impl Fn(&T) -> f64) -> Vec<T> {
    let last = items.len().saturating_sub(1);
    let kept =
        |(at, item): (usize, &T)| (at % step == 0 || at == last || value(item).is_nan()).then_some(*item);
    items.iter().enumerate().filter_map(kept).collect()
}

fn listed<'t>(file: &'t str, table: &'t Table, charts: &[&Drawn]) -> Listed<'t> {
    // A column without values, such as Δt·ν of a motion with many frequencies, only takes room.
    let known = |column: &&Column| column.cells.any(|cell| *cell != Cell::Blank);
    let all: Vec<&Column> = table.columns.iter().filter(known).collect();
    let small = table.rows() * all.len() <= MAX_CELLS;
    let columns: Vec<&Column> =
        all.iter().copied().filter(|column| small || is_charted(column, table, charts)).collect();
    // What distinguishes the rows is first, and beside it what charts show.
    let mut columns = columns;
    columns.sort_by_key(|column| (!tells(column), !is_charted(column, table, charts)));
    let rows = table.rows().min(MAX_CELLS / columns.len().max(1));
    let in_units = table.read();
    let listing = |column: &&'t Column| {
        let cells: Vec<&Cell> = column.cells.iter().take(rows).collect();
        let one = cells.len() > 1 && cells.iter().all(|cell| *cell == cells[0]);
        Listing {
            header: column.header(),
            title: title(column, &in_units),
            factor: column.written.map_or(1.0, |written| written.factor),
            about: &column.meaning,
            text: column.cells.any(|cell| matches!(cell, Cell::Text(_))),
            tells: tells(column),
            cells: json(if one { &cells[..1] } else { &cells[..] }),
            first: column.read().cells.iter().take(rows.min(FIRST_ROWS)).map(read).collect(),
        }
    };
    Listed {
        file,
        rows: table.rows(),
        all_columns: all.len(),
        shown: rows,
        columns: columns.iter().map(listing).collect(),
    }
}

/// A cell as people read it: a name as it is, a whole number in full, and others with four digits.
fn read(cell: &Cell) -> String {
    let Some(number) = cell.number() else { return cell.text() };
    if number.fract() == 0.0 && number.abs() < MAX_WHOLE {
        // Plus 0, because −0 has a sign.
        return format!("{:.0}", number + 0.0).replace('-', "−");
    }
    let text = significant(number, 4);
    match text.split_once('e') {
        Some((figures, exponent)) => {
            let exponent = exponent.parse().map_or_else(|_| exponent.to_owned(), superscript);
            format!("{}·10{exponent}", figures.replace('-', "−"))
        }
        None => text.replace('-', "−"),
    }
}

/// The heading of a column, which is unique in its table of columns in the units in which people read them.
fn title(column: &Column, table: &Table) -> String {
    let column = table.columns.iter().find(|own| own.name == column.name).unwrap_or(column);
    let first = table.columns.iter().find(|other| other.title() == column.title());
    match first.is_some_and(|other| other.name != column.name) {
        // As for the name of a tick and its number.
        true => titled(&column.name.replace('_', " "), column.unit.symbol),
        false => column.title(),
    }
}

/// Whether a column distinguishes rows: swept keys and texts.
fn tells(column: &Column) -> bool {
    column.role == Role::Key || column.cells.any(|cell| matches!(cell, Cell::Text(_)))
}

/// Whether a column distinguishes rows, or a chart shows it or its interval.
fn is_charted(column: &Column, table: &Table, charts: &[&Drawn]) -> bool {
    let shown = |label: &String| table.columns.iter().find(|other| other.label == *label);
    let belongs = |to: &Column| {
        let bounds = matches!(column.role, Role::Lower | Role::Upper | Role::StandardError);
        column.name == to.name || (bounds && column.of == to.name)
    };
    let labels = charts.iter().flat_map(|drawn| match &drawn.picture {
        Picture::Curves(figure) => [&figure.x.label, &figure.y.label],
        Picture::Map(map) => [&map.z.label, &map.z.label],
    });
    tells(column) || labels.filter_map(shown).any(belongs)
}

/// The axes of a picture.
#[derive(Serialize)]
struct Axes {
    x: Either<Ladder>,
    y: Either<Ladder>,
    /// Axis z of a map.
    z: Option<Either<Ladder>>,
    /// The edges of the cells of a map along x and y, where they can be shown.
    edges: Option<[Either<Vec<f64>>; 2]>,
}

/// Data for a logarithmic and for a linear axis.
#[derive(Serialize)]
struct Either<T> {
    log: T,
    linear: T,
}

impl<T> Either<T> {
    fn of(of: impl Fn(Scale) -> T) -> Either<T> {
        Either { log: of(Scale::Log), linear: of(Scale::Linear) }
    }
}

impl Axes {
    fn new(picture: &Picture) -> Axes {
        match picture {
            Picture::Curves(figure) => of_curves(figure),
            Picture::Map(map) => {
                let interval = |(value, band): &Estimate| {
                    let (low, high) = band.unwrap_or((*value, *value));
                    [*value, low, high]
                };
                let known = map.layers.iter().flat_map(|layer| &layer.values).flatten();
                let limit = map.limit.iter().map(|limit| limit.value);
                let zs: Vec<f64> = known.flat_map(interval).chain(limit).collect();
                Axes {
                    x: ladders(&map.x, &map.columns),
                    y: ladders(&map.y, &map.rows),
                    z: Some(ladders(&map.z, &zs)),
                    edges: Some([edges(&map.columns), edges(&map.rows)]),
                }
            }
        }
    }
}

fn of_curves(figure: &Figure) -> Axes {
    let laws = || figure.series.iter().flat_map(|series| &series.law).copied().chain(figure.law_places());
    let bands = figure.all_points().filter_map(|point| point.band).flat_map(|(low, high)| [low, high]);
    let limit = figure.limit.iter().map(|limit| limit.value);
    let xs: Vec<f64> = figure.all_points().map(|point| point.x).chain(laws().map(|place| place.0)).collect();
    let ys = figure.all_points().map(|point| point.y).chain(laws().map(|place| place.1));
    let ys: Vec<f64> = ys.chain(bands).chain(limit).collect();
    Axes { x: ladders(&figure.x, &xs), y: ladders(&figure.y, &ys), z: None, edges: None }
}

fn ladders(axis: &Axis, values: &[f64]) -> Either<Ladder> {
    Either::of(|scale| axis.ladder(Range::around(scale, values.iter().copied())))
}

fn edges(values: &[f64]) -> Either<Vec<f64>> {
    Either::of(|scale| {
        let shown: Vec<f64> = values.iter().copied().filter(|value| scale.shows(*value)).collect();
        let Range { low, high, .. } = Range::around(scale, []);
        if shown.is_empty() { vec![low, high] } else { cell_edges(scale, &shown) }
    })
}

/// Numbers as files show them.
struct Rounded;

impl Formatter for Rounded {
    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        writer.write_all(significant(value, DIGITS).as_bytes())
    }
}

/// A value as JSON. Numbers that are not finite become null.
fn json(value: &(impl Serialize + ?Sized)) -> Box<RawValue> {
    let mut text = Vec::new();
    let mut serializer = serde_json::Serializer::with_formatter(&mut text, Rounded);
    // Writing to memory cannot fail, and all names are valid text.
    let written = value.serialize(&mut serializer).ok();
    let text =
        written.and_then(|()| String::from_utf8(text).ok()).and_then(|text| RawValue::from_string(text).ok());
    text.unwrap_or_default()
}

/// Compressed by gzip, as text.
fn packed(text: &[u8]) -> String {
    // The highest level takes three times as long for a third of a percent.
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    let packed = encoder.write_all(text).and_then(|()| encoder.finish());
    BASE64_STANDARD.encode(packed.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_without_scripts_keep_names_and_whole_numbers() {
        let cells = [
            Cell::Text("LGK-400".to_owned()),
            Cell::Integer(2_097_152),
            Cell::Number(500_624.0),
            Cell::Number(-0.0),
            Cell::Number(-2.512_345_6),
            Cell::Number(7.799_6e-7),
            Cell::Blank,
        ];
        assert_eq!(
            cells.each_ref().map(read),
            ["LGK-400", "2097152", "500624", "0", "−2.512", "7.8·10⁻⁷", ""]
        );
    }

    #[test]
    fn thinned_curves_keep_their_ends_and_interruptions() {
        let kept = thin(&[0.0, 1.0, f64::NAN, 3.0, 4.0, 5.0], 3, |y| *y);
        assert_eq!(format!("{kept:?}"), "[0.0, NaN, 3.0, 5.0]");
    }
}
