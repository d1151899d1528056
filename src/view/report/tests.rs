//! Tables for tests.

use crate::table::{Cell, Column, Role, Table, Unit};

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
