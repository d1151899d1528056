//! Curves that run through rows of several curves.

use sagnac_base::table::{Cell, Column, Role, Table, grouped};
use sagnac_engine::chart::Chart;
use sagnac_report::chart::notes::ChartError;

/// Refuses curves along which more than one of the columns that distinguish rows varies, or whose abscissa is constant
/// while one of them varies.
///
/// # Errors
/// A column is missing, or a curve is refused; the error is for the first such curve.
pub(crate) fn check_curves(
    table: &Table,
    chart: &Chart,
    series: &[String],
    rows: &[usize],
) -> Result<(), ChartError> {
    let columns =
        |names: &[String]| names.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>();
    let (x, series, apart) = (table.column(&chart.x.name)?, columns(series)?, columns(&chart.apart)?);
    let texts = |row: usize| series.iter().map(|column| column.cells[row].text()).collect::<Vec<_>>();
    let curves = grouped(rows.iter().copied(), texts);
    // The key with which x varies; for an estimate that of the first coordinate.
    let coordinate = |column: &&Column| column.role == Role::Coordinate && !column.of.is_empty();
    let base = Some(x).filter(coordinate).or_else(|| table.columns.iter().find(coordinate));
    let base = base.map_or("", |column| column.of.as_str());
    let mixed = curves.iter().find_map(|(_, rows)| Some((rows[0], mixed(x, base, &apart, rows)?)));
    let Some((row, (column, values))) = mixed else { return Ok(()) };
    let names: Vec<String> = series.iter().map(|column| column.valued(&column.cells[row].text())).collect();
    let (curve, column) = (names.join(", "), column.name.clone());
    Err(ChartError::MixedCurve { curve, column, values: values.into() })
}

/// The other column that varies along the rows of one curve, with two of its values.
fn mixed<'t>(
    x: &Column,
    base: &str,
    apart: &[&'t Column],
    rows: &[usize],
) -> Option<(&'t Column, [String; 2])> {
    let differ = |column: &Column, a: usize, b: usize| column.cells[a] != column.cells[b];
    let found = |column: &'t Column, a: usize, b: usize| (column, [a, b].map(|row| column.cells[row].text()));
    let mut varying: Vec<(&Column, usize)> = apart
        .iter()
        .filter_map(|column| Some((*column, *rows.iter().find(|&&row| differ(column, rows[0], row))?)))
        .collect();
    let named = |name: &str| varying.iter().position(|(column, _)| column.name == name);
    let along = named(&x.name).or_else(|| named(base));
    let along = (!varying.is_empty()).then(|| varying.remove(along.unwrap_or(0)));
    if let Some((column, row)) = varying.first() {
        return Some(found(column, rows[0], *row));
    }
    // An x that is constant while another column varies; an estimate may be constant by chance.
    let (column, row) = along?;
    // A value that follows from the study is not constant by chance.
    let coordinate = x.role == Role::Coordinate || apart.iter().any(|column| column.name == x.name);
    let known = x.cells[rows[0]] != Cell::Blank;
    let still = coordinate && known && !rows.iter().any(|&row| differ(x, rows[0], row));
    still.then(|| found(column, rows[0], row))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_base::table::Unit;

    /// Frequencies 1 and 2, gaps 1 and 2, two fillers; Δt·ν is their product, which no two points share.
    fn table() -> Table {
        let mut cells: [Vec<Cell>; 5] = Default::default();
        for frequency in [1.0, 3.0] {
            for gap in [1_i64, 2] {
                for filler in ["const", "quad"] {
                    let row = [
                        Cell::Number(frequency),
                        Cell::Integer(gap),
                        Cell::Number(frequency * gap as f64),
                        Cell::Text(filler.to_owned()),
                        Cell::Blank,
                    ];
                    cells.iter_mut().zip(row).for_each(|(column, cell)| column.push(cell));
                }
            }
        }
        let names = ["motion.frequency", "switching.gap_ticks", "dt_nu", "filler", "rms"];
        let column = |(name, cells): (&str, Vec<Cell>)| Column {
            name: name.to_owned(),
            label: name.to_owned(),
            unit: Unit::NONE,
            cells: cells.into(),
            ..Column::default()
        };
        let mut columns: Vec<Column> = names.into_iter().zip(cells).map(column).collect();
        columns[2].role = Role::Coordinate;
        columns[2].of = names[0].to_owned();
        Table { columns }
    }

    /// The error of a chart over `x` with these series and rows; empty where it is drawn.
    fn said(x: &str, series: &[&str], filter: &[(&str, &str)]) -> String {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<String>>();
        let apart = names(&["motion.frequency", "switching.gap_ticks", "filler"]);
        let chart = Chart { x: x.into(), y: "rms".into(), apart, ..Chart::default() };
        let table = table();
        let rows = table.rows_where(filter).unwrap();
        check_curves(&table, &chart, &names(series), &rows)
            .map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn a_curve_runs_along_one_of_the_columns_that_tell_rows_apart() {
        for x in ["frequency", "dt_nu", "rms"] {
            assert_eq!(said(x, &["filler", "gap_ticks"], &[]), "");
            assert_eq!(said(x, &["filler"], &[("gap_ticks", "2")]), "");
        }
        assert_eq!(said("gap_ticks", &["frequency"], &[("filler", "quad")]), "");
    }

    #[test]
    fn a_curve_through_rows_of_several_is_refused_with_what_tells_them_apart() {
        let gaps =
            "one curve, that of filler = const, runs through rows that differ in switching.gap_ticks (1, 2)";
        for x in ["frequency", "dt_nu"] {
            assert_eq!(said(x, &["filler"], &[]), gaps, "{x}");
        }
        assert!(said("rms", &["filler"], &[]).contains("switching.gap_ticks"));
        assert!(said("gap_ticks", &["frequency"], &[]).contains("differ in filler (const, quad)"));
        let only = said("dt_nu", &[], &[("filler", "quad")]);
        assert!(only.starts_with("one curve runs through rows that differ in switching.gap_ticks"), "{only}");
    }

    #[test]
    fn an_abscissa_that_stands_still_is_refused() {
        let filter = [("frequency", "3"), ("gap_ticks", "1")];
        assert!(said("frequency", &["gap_ticks"], &filter).contains("differ in filler"));
        assert_eq!(said("rms", &["gap_ticks"], &filter), "", "estimates may be equal");
    }
}
