//! Tables as columns of arrays.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyList;
use sagnac::table::{Cell, Column, Table};

/// The columns of a table: header, label, symbol of the unit, values.
pub fn columns<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyList>> {
    let column = |column: &Column| {
        (column.header(), column.label.as_str(), column.unit.symbol, values(py, column)?).into_pyobject(py)
    };
    PyList::new(py, table.columns.iter().map(column).collect::<PyResult<Vec<_>>>()?)
}

/// An integer array if all cells are integers, a list of texts with None for blanks if some are texts, else an array of
/// floats with NaN for blanks.
fn values<'py>(py: Python<'py>, column: &Column) -> PyResult<Bound<'py, PyAny>> {
    let cells = &column.cells;
    if cells.any(|cell| matches!(cell, Cell::Text(_))) {
        let texts = cells.iter().map(|cell| match cell {
            Cell::Blank => None,
            cell => Some(cell.text()),
        });
        return Ok(PyList::new(py, texts.collect::<Vec<_>>())?.into_any());
    }
    let whole = cells.iter().map(|cell| match cell {
        Cell::Integer(integer) => Some(*integer),
        _ => None,
    });
    if let Some(integers) = whole.collect::<Option<Vec<i64>>>().filter(|all| !all.is_empty()) {
        return Ok(PyArray1::from_vec(py, integers).into_any());
    }
    let numbers = cells.iter().map(|cell| cell.number().unwrap_or(f64::NAN));
    Ok(PyArray1::from_vec(py, numbers.collect()).into_any())
}
