//! Output of `sagnac psd` for people where there are several columns: tables over the axes of a sensor.

use sagnac::allan::deviation::Deviation;
use sagnac::allan::unit::Unit;
use sagnac::analysis::data_sheet::Row;
use sagnac::analysis::log::Column;
use sagnac::analysis::spectrum::notes::method;
use sagnac::analysis::spectrum::{Analysis, Spectrum, White};
use sagnac::fit::quantity::Quantity;
use sagnac::quantity::number::significant;
use sagnac::spectrum::lines::FALSE_ALARM;
use sagnac::table::titled;
use sagnac::theory::allan::terms::Term;

use crate::psd::report::of_line;
use crate::terminal::{self, aligned, headed, number};

/// The lines and the white noise of all columns of a unit.
pub fn report(analysis: &Analysis, unit: Unit) -> String {
    let columns: Vec<(&Column, &Spectrum)> =
        analysis.columns().filter(|(column, _)| column.unit == unit).collect();
    let names: Vec<&str> = columns.iter().map(|(column, _)| column.name.as_str()).collect();
    let of = columns.first().map_or_else(String::new, |(_, spectrum)| method(spectrum));
    let heading = format!("\n{}: densities, {of}; psd.csv has them\n", names.join(", "));
    heading + &lines(&columns, unit) + &white(&names, &columns, unit)
}

/// The lines that were found.
fn lines(columns: &[(&Column, &Spectrum)], unit: Unit) -> String {
    let percent = significant(100.0 * FALSE_ALARM, 2);
    let amplitude = titled("amplitude", unit.symbol(Deviation::Oadev));
    let rows: Vec<Vec<String>> = columns
        .iter()
        .flat_map(|(column, spectrum)| spectrum.lines.iter().map(|line| (&column.name, line)))
        .map(|(name, line)| std::iter::once(name.clone()).chain(of_line(line)).collect())
        .collect();
    if rows.is_empty() {
        return format!("  no line; noise alone shows one in {percent} % of records of each column\n");
    }
    let table = headed(["", "f, Hz", &amplitude, "over floor", "p"], rows.into_iter());
    format!("  lines; noise alone shows one in {percent} % of records of each column\n{table}")
}

/// N by the floor beside N by the fit for each column.
fn white(names: &[&str], columns: &[(&Column, &Spectrum)], unit: Unit) -> String {
    let row = |name: &str, cell: &dyn Fn(&White) -> String| {
        terminal::row(name, "", columns, |(_, spectrum)| cell(&spectrum.white))
    };
    let floor = |white: &White, end: usize| number(white.floor.as_ref().map(|floor| floor.range_hz[end]), 3);
    let of = |row: &Option<Row>| number(row.as_ref().and_then(|row| row.value), 4);
    let table = [
        terminal::row("", "", names, |name| (*name).to_owned()),
        row("N of the floor", &|white| of(&white.from_floor)),
        row("N of the fit", &|white| of(&white.from_fit)),
        row("flat from, Hz", &|white| floor(white, 0)),
        row("to, Hz", &|white| floor(white, 1)),
        row("", &|white| white.verdict().to_owned()),
    ];
    let (_, _, symbol) = Quantity::Coefficient(Term::AngleRandomWalk).unit(unit);
    format!("  white noise N, {symbol}; white_noise.csv has the intervals\n{}", aligned(&table))
}
