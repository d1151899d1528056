//! Which point of a study, and which of its fillers.

use sagnac::study::{Filler, Point, Study, parse_quantity};
use sagnac::table::{Column, ColumnError, Table};

use super::Failure;

/// The first point whose swept keys have the values that are asked for, each as `key=value`.
///
/// Keys may lack what stands before their last dot, and values their unit, which is then the base unit.
///
/// # Errors
/// A key that is not swept, or a value that it does not take.
pub fn point<'s>(study: &'s Study, at: &[String]) -> Result<&'s Point, Failure> {
    let usage = |message: String| Failure::Usage(message);
    if let (Some(first), true) = (at.first(), study.sweeps.is_empty()) {
        return Err(usage(format!("--at {first}: the study has one point\nleave --at out")));
    }
    let column = |(place, sweep): (usize, &sagnac::study::Sweep)| Column {
        name: sweep.key.name.to_owned(),
        label: sweep.key.label.to_owned(),
        unit: sweep.values[0].dimension.unit(),
        cells: study.points().iter().map(|point| point.swept[place].1.cell()).collect(),
        band: None,
    };
    let table = Table { columns: study.sweeps.iter().enumerate().map(column).collect() };
    let mut filter = Vec::new();
    for asked in at {
        let refused = |error: ColumnError| {
            let message = match error {
                ColumnError::Unknown { name, .. } => {
                    let swept: Vec<&str> = study.sweeps.iter().map(|sweep| sweep.key.name).collect();
                    format!("the study does not sweep `{name}`; it sweeps {}", swept.join(", "))
                }
                ColumnError::NoRow { column, value, known } => {
                    format!("no point has {column} = {value}; there are {}", known.join(", "))
                }
                error @ ColumnError::Ambiguous { .. } => error.to_string(),
            };
            usage(format!("--at {asked}: {message}"))
        };
        let Some((key, value)) = asked.split_once('=') else {
            return Err(usage(format!("--at {asked}: give a key and a value, such as frequency=\"20 Hz\"")));
        };
        let column = table.column(key.trim()).map_err(refused)?;
        let sweep = study.sweeps.iter().find(|sweep| sweep.key.name == column.name);
        let dimension = sweep.map(|sweep| sweep.values[0].dimension);
        let quantity = dimension.and_then(|dimension| parse_quantity(value, &[dimension]).ok());
        let value = quantity.map_or_else(|| value.trim().to_owned(), |quantity| quantity.cell().text());
        filter.push((column.name.clone(), value));
        table.rows_where(&filter).map_err(refused)?;
    }
    let rows = table.rows_where(&filter).unwrap_or_default();
    // Without sweeps the table has no rows, and the study one point.
    Ok(&study.points()[rows.first().copied().unwrap_or(0)])
}

/// The fillers of these names, in the order of the study; all of them where none is named.
///
/// # Errors
/// A name that no filler has.
pub fn fillers(study: &Study, names: &[String]) -> Result<Vec<Filler>, Failure> {
    if let Some(unknown) = names.iter().find(|name| study.fillers.iter().all(|filler| filler.name != **name))
    {
        let known: Vec<&str> = study.fillers.iter().map(|filler| filler.name.as_str()).collect();
        return Err(Failure::Usage(format!(
            "--filler {unknown}: the study has no such filler; it has {}",
            known.join(", ")
        )));
    }
    let wanted = |filler: &&Filler| names.is_empty() || names.contains(&filler.name);
    Ok(study.fillers.iter().filter(wanted).cloned().collect())
}
