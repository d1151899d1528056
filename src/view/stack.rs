//! Several columns of a table as one, so that each is a curve.

use std::borrow::Cow;

use sagnac_base::table::{Cell, Column, Role, Table};
use sagnac_engine::chart::Chart;
use sagnac_report::chart::ChartError;

/// The column with the names of the stacked quantities.
pub const CURVE: &str = "curve";

/// Separator in labels between the common quantity and its parts.
const BETWEEN: &str = ": ";

/// The table of a chart; for a chart of several columns, a table in which these are stacked.
#[derive(Debug)]
pub struct Shown<'t> {
    /// Table, with a column that distinguishes the stacked ones.
    pub table: Cow<'t, Table>,
    /// Column of the estimates.
    pub estimate: String,
    /// The columns whose values distinguish curves.
    pub series: Vec<String>,
}

impl<'t> Shown<'t> {
    /// The part of a table that `chart` shows.
    ///
    /// # Errors
    /// A column to be stacked is missing, is listed twice or has another unit.
    pub fn new(table: &'t Table, chart: &Chart) -> Result<Shown<'t>, ChartError> {
        let series = chart.series().iter().map(|column| column.name.clone());
        let estimate = chart.estimate().name.clone();
        if chart.beside.is_empty() {
            return Ok(Shown { table: Cow::Borrowed(table), estimate, series: series.collect() });
        }
        let names: Vec<&str> = chart.columns().map(|column| column.name.as_str()).collect();
        let table = Cow::Owned(stacked(table, &names)?);
        Ok(Shown { table, estimate, series: std::iter::once(CURVE.to_owned()).chain(series).collect() })
    }

    /// Whether names stand side by side on the abscissa.
    pub fn is_named(&self, chart: &Chart) -> bool {
        let x = self.table.column(&chart.x.name);
        x.is_ok_and(|x| x.cells.any(|cell| matches!(cell, Cell::Text(_))))
    }

    /// Whether the chart is supplied with names side by side instead of written, as where no number is swept.
    pub fn is_supplied(&self, chart: &Chart) -> bool {
        chart.x.span.is_empty() && self.is_named(chart)
    }
}

/// The table with the columns `names` below one another, under the name of the first. All other columns are repeated
/// for each, closed forms stay with their columns, and [`CURVE`] distinguishes them by their labels. For labels such as
/// `drift: bound` and `drift: mean`, the first part becomes the label of the stacked column, otherwise their common
/// last word does.
///
/// # Errors
/// A name selects no single column, an existing column is in the way, or a column has another unit than the first.
pub(crate) fn stacked(table: &Table, names: &[&str]) -> Result<Table, ChartError> {
    let mut columns: Vec<&Column> = vec![];
    for name in names {
        let column = table.column(name)?;
        if columns.iter().any(|earlier| earlier.name == column.name) {
            return Err(ChartError::Twice { column: (*name).to_owned() });
        }
        if let Some(first) = columns.first().filter(|first| first.unit != column.unit) {
            let (column, unit) = ((*name).to_owned(), column.unit.symbol.to_owned());
            return Err(ChartError::OtherUnit { column, unit, beside: "curve", wanted: first.unit.symbol });
        }
        columns.push(column);
    }
    let Some(first) = columns.first() else { return Ok(table.clone()) };
    let shared = first.label.split_once(BETWEEN).map(|(shared, _)| shared);
    let shared = shared.filter(|shared| columns.iter().all(|column| part(column, shared).is_some()));
    let label =
        |column: &Column| shared.and_then(|shared| part(column, shared)).unwrap_or(&column.label).to_owned();
    let heading = shared.unwrap_or("value").to_owned();
    let quantity = shared.or_else(|| last_word(&columns)).unwrap_or("value").to_owned();
    let rows = table.rows();
    let law = |column: &Column| table.beside(column, Role::Theory);
    let is_stacked = |column: &&Column| {
        let is_law = |stacked: &&Column| law(stacked).is_some_and(|law| law.name == column.name);
        columns.iter().any(|stacked| stacked.name == column.name || is_law(stacked))
    };
    let repeat = |column: &Column| Column {
        cells: columns.iter().flat_map(|_| column.cells.iter().cloned()).collect(),
        band: column.band.as_ref().map(|band| band.repeat(columns.len())),
        band_of_mean: None,
        ..column.clone()
    };
    let mut all: Vec<Column> =
        table.columns.iter().filter(|column| !is_stacked(column)).map(repeat).collect();
    let names = columns.iter().flat_map(|column| vec![Cell::Text(label(column)); rows]).collect();
    let (name, label) = (CURVE.to_owned(), heading);
    all.push(Column { name, label, role: Role::Key, cells: names, ..Column::default() });
    let band = |column: &Column| (0..rows).map(|row| column.interval(row)).collect::<Vec<_>>();
    all.push(Column {
        label: quantity,
        cells: columns.iter().flat_map(|column| column.cells.iter().cloned()).collect(),
        band: Some(columns.iter().flat_map(|column| band(column)).collect()),
        band_of_mean: None,
        ..(*first).clone()
    });
    if columns.iter().any(|column| law(column).is_some()) {
        let cell = |column, row| law(column).map_or(Cell::Blank, |law| law.cells[row].clone());
        let cells = |column| (0..rows).map(move |row| cell(column, row));
        all.push(Column {
            name: format!("theory_{}", first.name),
            label: "closed form".to_owned(),
            unit: first.unit,
            role: Role::Theory,
            of: first.name.clone(),
            cells: columns.iter().copied().flat_map(cells).collect(),
            ..Column::default()
        });
    }
    Ok(Table { columns: all })
}

/// The common last word of the labels of all columns, such as `error` for `rms error` and `99.73 % error`.
fn last_word<'c>(columns: &[&'c Column]) -> Option<&'c str> {
    let words = |column: &&'c Column| column.label.rsplit_once(' ').map(|(_, last)| last);
    let first = words(columns.first()?)?;
    columns.iter().all(|column| words(column) == Some(first)).then_some(first)
}

/// The part of the quantity `shared` that a column stands for.
fn part<'c>(column: &'c Column, shared: &str) -> Option<&'c str> {
    column.label.strip_prefix(shared)?.strip_prefix(BETWEEN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_base::table::Unit;

    fn table() -> Table {
        let column = |name: &str, label: &str, unit, cells: [f64; 2]| Column {
            name: name.to_owned(),
            label: label.to_owned(),
            unit,
            cells: cells.map(Cell::Number).to_vec().into(),
            band: (name == "rms").then(|| vec![Some((1.0, 2.0)), None]),
            ..Column::default()
        };
        Table {
            columns: vec![
                column("run.duration", "run time", Unit::S, [1.0, 2.0]),
                column("bound", "drift: bound", Unit::ARCSEC_PER_S, [3.0, 4.0]),
                column("mean", "drift: mean", Unit::ARCSEC_PER_S, [5.0, 6.0]),
                column("rms", "rms", Unit::ARCSEC_PER_S, [7.0, 8.0]),
            ],
        }
    }

    fn texts(table: &Table, name: &str) -> Vec<String> {
        table.column(name).unwrap().cells.iter().map(Cell::text).collect()
    }

    #[test]
    fn each_column_is_a_curve_of_the_quantity_that_the_labels_share() {
        let stacked = stacked(&table(), &["bound", "mean_arcsec_per_s"]).unwrap();
        assert_eq!(stacked.column("bound").unwrap().title(), "drift, ″/s");
        assert_eq!(texts(&stacked, "bound"), ["3", "4", "5", "6"]);
        assert_eq!(texts(&stacked, CURVE), ["bound", "bound", "mean", "mean"]);
        assert_eq!(texts(&stacked, "duration"), ["1", "2", "1", "2"]);
        assert_eq!(texts(&stacked, "rms"), ["7", "8", "7", "8"]);
    }

    #[test]
    fn bands_stay_with_their_columns_and_labels_that_share_nothing_stay_whole() {
        let stacked = stacked(&table(), &["mean", "rms"]).unwrap();
        let column = stacked.column("mean").unwrap();
        assert_eq!(column.band.as_deref(), Some(&[None, None, Some((1.0, 2.0)), None][..]));
        assert_eq!((column.label.as_str(), texts(&stacked, CURVE)[2].as_str()), ("value", "rms"));
        assert_eq!(texts(&stacked, CURVE)[0], "drift: mean");
    }

    #[test]
    fn a_closed_form_is_that_of_its_own_column() {
        let mut table = table();
        let (role, of) = (Role::Theory, "mean".to_owned());
        let law = Column { name: "theory_mean".to_owned(), role, of, ..table.columns[2].clone() };
        table.columns.push(law);
        let stacked = stacked(&table, &["bound", "mean"]).unwrap();
        assert_eq!(texts(&stacked, "theory_bound"), ["", "", "5", "6"]);
        assert!(stacked.column("theory_mean").is_err());
    }

    #[test]
    fn another_unit_and_the_same_column_twice_are_refused() {
        let error = |names: &[&str]| stacked(&table(), names).unwrap_err().to_string();
        assert_eq!(error(&["bound", "duration"]), "`duration` is in s, a curve in ″/s cannot be drawn on it");
        assert_eq!(
            error(&["bound", "bound_arcsec_per_s"]),
            "`bound_arcsec_per_s` is listed twice among the columns of y"
        );
        assert!(error(&["bound", "none"]).contains("no column is called `none`"));
    }
}
