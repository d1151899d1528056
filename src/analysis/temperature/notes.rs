//! Notes on the dependence on temperature.

use crate::analysis::temperature::{Column, Temperature};
use sagnac_base::quantity::number::significant;

/// What was done with the temperature, and what limits the results of columns, in a line each.
pub fn notes(temperature: &Temperature) -> Vec<String> {
    let course = &temperature.course;
    let [missing, unknown] = temperature.missing;
    let smoothed = (course.half_window > 0).then(|| {
        format!(
            "the temperature is smoothed by straight lines over {} s, to the error of its sensor of {} K",
            significant((2 * course.half_window + 1) as f64 * temperature.step_s, 4),
            significant(course.error, 2)
        )
    });
    let gaps = (missing > 0).then(|| {
        format!(
            "{missing} samples have no temperature: {} lie in short gaps, which straight lines bridge, and {unknown} are left out",
            missing - unknown
        )
    });
    let of_columns = temperature.columns.iter().flat_map(of_column);
    smoothed.into_iter().chain(gaps).chain(of_columns).collect()
}

fn of_column(column: &Column) -> Vec<String> {
    let said = |note: String| format!("{}: {note}", column.name);
    match &column.found {
        Err(why) => vec![said(format!("no temperature coefficients, and no compensation: {why}"))],
        Ok(found) if found.model.is_robust => vec![said(format!(
            "white noise, flicker and random walk do not describe the residual of the temperature model (p = {}): the intervals of \
             its coefficients are robust ones, from the correlation of the residual",
            significant(found.model.p_value, 2)
        ))],
        Ok(_) => vec![],
    }
}
