//! Sentences on tables.

use crate::table::{Cell, Column, Role, Table, Unit};
use crate::view::report::sentences::best;

fn column(name: &str, unit: Unit, cells: Vec<Cell>) -> Column {
    Column { name: name.to_owned(), label: name.to_owned(), unit, cells: cells.into(), ..Column::default() }
}

/// Curves over the frequencies 1, 2, 4 Hz, with the values of an estimate.
pub(crate) fn table<const N: usize>(estimate: &str, curves: &[(&str, [f64; N])]) -> Table {
    let role = if estimate == "rms" { Role::Error } else { Role::Estimate };
    let names = curves.iter().flat_map(|(name, _)| vec![Cell::Text((*name).to_owned()); N]).collect();
    let xs = curves.iter().flat_map(|_| (0..N).map(|at| Cell::Number(f64::from(1 << at)))).collect();
    let values = curves.iter().flat_map(|(_, values)| values.map(|x| Cell::from(Some(x)))).collect();
    Table {
        columns: vec![
            column("filler", Unit::NONE, names),
            column("frequency", Unit::HZ, xs),
            Column { role, ..column(estimate, Unit::ARCSEC, values) },
        ],
    }
}

#[test]
fn what_is_least_is_told_of_errors_and_of_others_where_they_run() {
    let curves = [("a", [3.0, 2.0, 5.0]), ("b", [4.0, 4.0, 4.0])];
    let told = |estimate: &str| {
        let table = table(estimate, &curves);
        let [filler, frequency, estimate] = [0, 1, 2].map(|at| &table.columns[at]);
        best(&table, estimate, &[0, 1, 2, 3, 4, 5], &[filler, frequency]).unwrap().sentence()
    };
    assert_eq!(told("rms"), "The least rms is 2 arcsec: a, frequency 2 Hz.");
    let range = "The coverage95 runs from 2 arcsec (a, frequency 2 Hz) to 5 arcsec (a, frequency 4 Hz).";
    assert_eq!(told("coverage95"), range);
    let signed = table("rms", &[("a", [-3.0, 2.0, 5.0])]);
    let [_, frequency, rms] = [0, 1, 2].map(|at| &signed.columns[at]);
    assert!(best(&signed, rms, &[0, 1, 2], &[frequency]).unwrap().sentence().contains("from −3 arcsec"));
}
