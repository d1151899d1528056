//! The native part of the Python package `sagnac`: it maps arguments to library calls, and returns arrays and plain
//! objects. The functions for users, with their documentation, are written in Python, in `python/sagnac`. The program
//! `sagnac` is part of it.

mod analysis;
mod argument;
mod compute;
mod curve;
mod failure;
mod filler;
mod log;
mod program;
mod progress;
mod record;
mod run;
mod simulate;
mod table;
mod theory;

use pyo3::prelude::*;

/// The contents of the module.
#[pymodule]
fn _sagnac(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("version", env!("CARGO_PKG_VERSION"))?;
    module.add("colours", sagnac::report::chart::COLOURS.to_vec())?;
    module.add_function(wrap_pyfunction!(program::main, module)?)?;
    module.add_function(wrap_pyfunction!(run::run, module)?)?;
    module.add_function(wrap_pyfunction!(analysis::design, module)?)?;
    module.add_function(wrap_pyfunction!(analysis::sensitivity, module)?)?;
    module.add_function(wrap_pyfunction!(analysis::compare, module)?)?;
    module.add_function(wrap_pyfunction!(analysis::batch, module)?)?;
    module.add_function(wrap_pyfunction!(analysis::analyze, module)?)?;
    module.add_function(wrap_pyfunction!(analysis::model_of_record, module)?)?;
    module.add_function(wrap_pyfunction!(analysis::model_of_noise, module)?)?;
    module.add_function(wrap_pyfunction!(analysis::convert, module)?)?;
    module.add_function(wrap_pyfunction!(analysis::hat, module)?)?;
    module.add_class::<curve::Curve>()?;
    module.add_function(wrap_pyfunction!(curve::is_curve, module)?)?;
    module.add_function(wrap_pyfunction!(curve::read_curve, module)?)?;
    module.add_function(wrap_pyfunction!(curve::curve_of, module)?)?;
    module.add_function(wrap_pyfunction!(curve::analyze_curve, module)?)?;
    module.add_function(wrap_pyfunction!(curve::model_of_curve, module)?)?;
    module.add_class::<log::Log>()?;
    module.add_function(wrap_pyfunction!(log::read_log, module)?)?;
    module.add_function(wrap_pyfunction!(record::curves, module)?)?;
    module.add_function(wrap_pyfunction!(record::fit, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(filler::of_kinds, module)?)?;
    module.add_function(wrap_pyfunction!(filler::of_study, module)?)?;
    theory::add_to(module)
}
