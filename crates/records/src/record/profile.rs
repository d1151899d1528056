//! Reading a recorded motion from the columns `time` and `rate` of a file. It has no gaps, and its times are evenly spaced.

use crate::record::Record;
use crate::record::error::RecordError;
use crate::record::recording::{Recording, Rules};
use crate::record::time::grid;
use sagnac_base::quantity::units::{Dimension, round_12};

/// Help with an example of a header.
const NAMES: &str = "name one column `time` and one `rate`, with their units, as in\ntime [s], rate [deg/s]";

/// Advice on missing numbers.
const MISSING: &str =
    "every row needs a finite number here: put it in, or cut the record and resample what is left";

/// The rules for at most `most` samples: steps count as equal within 1 %, and a record of a motion has no gaps.
fn rules(most: usize) -> Rules {
    let uneven = "resample it evenly first: every step must be within 1 % of the median step";
    Rules { most, missing: MISSING, jitter: 0.01, has_gaps: false, uneven }
}

/// Reads a record of at most `most` samples.
pub(crate) fn read(mut file: Recording, most: usize) -> Result<Record, RecordError> {
    if file.names().is_empty() {
        return Err(file.refuse(None, "the header is missing", "numbers instead of names", NAMES));
    }
    let (time, time_size) = column(&file, "time", Dimension::Time, "time [s]")?;
    let (rate, rate_size) = column(&file, "rate", Dimension::Rate, "rate [deg/s]")?;
    let rules = rules(most);
    let columns = file.read(&[time, rate], &rules)?;
    let times = finite(&file, time, "time", &columns[0], time_size)?;
    let rates = finite(&file, rate, "rate", &columns[1], rate_size)?;
    if rates.len() < 2 {
        let message = format!("a record needs at least 2 samples, this one has {}", rates.len());
        let help = "the step is the time from one sample to the next: add rows";
        return Err(file.refuse(None, &message, "its columns", help));
    }
    grid(&columns[0], time_size, &rules).map_err(|fault| file.refuse_row(fault.row, time, fault.words))?;
    let steps = rates.len() - 1;
    let step_s = round_12((times[steps] - times[0]) / steps as f64);
    file.check_step(step_s, Some(time))?;
    Ok(Record { step_s, rates })
}

/// The column with this name, and the size of its unit.
fn column(
    file: &Recording,
    name: &str,
    dimension: Dimension,
    example: &str,
) -> Result<(usize, f64), RecordError> {
    let column = file.find(name, Some(dimension)).map_err(|error| error.with_help(NAMES))?;
    let help = format!("accepted: {} in {}, for example `{example}`", dimension.name(), dimension.units());
    Ok((column, file.unit_size(column, None, dimension, &format!("the column `{name}`"), &help)?))
}

/// The numbers of a column in base units.
fn finite(
    file: &Recording,
    column: usize,
    name: &str,
    numbers: &[f64],
    size: f64,
) -> Result<Vec<f64>, RecordError> {
    let values: Vec<f64> = numbers.iter().map(|number| number * size).collect();
    let Some(row) = values.iter().position(|value| value.is_nan()) else { return Ok(values) };
    Err(file.refuse_row(
        row,
        column,
        [format!("the {name} is missing"), "missing".to_owned(), MISSING.to_owned()],
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::format::Origin;
    use crate::record::log::read::Hints;

    fn record(text: &str, most: usize) -> Result<Record, String> {
        let file = Recording::open("r.csv".to_owned(), Origin::Bytes(text.as_bytes()), &Hints::default());
        file.and_then(|file| read(file, most)).map_err(|error| error.render(false, 200))
    }

    #[test]
    fn a_record_is_read_whatever_its_order_units_and_surroundings() {
        let expected: [f64; 3] = [3600.0, -7200.0, 0.36];
        let texts = [
            "time [s],rate [deg/s]\n0,1\n0.002,-2\n0.004,1e-4\n",
            "time [ms], rate (arcsec/s)\n10, 3600\n12, -7200\n14, 0.36",
            "\u{feff}# base, \"x\n\nrate [°/s] ; id,temperature [K],rate_deg_per_s,time_ms\n9,,1,-2\n# half\n9,x,-2,0\n\n9,,+1e-4,2\n",
            "TIME [s],Rate [deg/s],\"a, b\"\r\n0,1,\"x, y\"\r\n0.002,-2,z\r\n0.004,0.0001,\r\n",
            "time [s],rate [deg/s],note\n0,1,a;b\n0.002,-2,\n0.004,1e-4,\n",
            "% base\nrate_s;time [s];rate [deg/s]\n7;0;1\n7;0.002;-2\n7;0.004;1e-4\n",
            "time [s],rate [deg/s]\n5000000000,1\n5000000000.002,-2\n5000000000.004,1e-4\n",
        ];
        for text in texts {
            let found = record(text, 3).unwrap_or_else(|error| panic!("{text}\n{error}"));
            assert!((found.step_s - 0.002).abs() < 1e-6, "{text}\n{}", found.step_s);
            assert_eq!(found.rates.len(), 3, "{text}");
            for (rate, expected) in found.rates.iter().zip(expected) {
                assert!((rate / expected - 1.0).abs() < 1e-15, "{text}\n{rate}, not {expected}");
            }
        }
    }

    #[test]
    fn what_is_no_record_is_shown_with_its_place_and_what_to_do() {
        let rows = |rows: &str| format!("time [s],rate [deg/s]\n{rows}");
        let names = "time [s], rate [deg/s]";
        let table = [
            (String::new(), "r.csv is empty", "", "below a header"),
            ("# only a comment\n".to_owned(), "r.csv has no samples", "", "below a header"),
            ("0,1\n1,2\n".to_owned(), "the header is missing", "r.csv:1:1", names),
            ("time [s],speed\n".to_owned(), "no column is called `rate`", "r.csv:1:1", names),
            ("rate_x [deg/s],time [s]\n".to_owned(), "no column is called `rate`", "r.csv:1:1", names),
            ("#\n\ntime [s],rate\n".to_owned(), "`rate` has no unit", "r.csv:3:10", "arcsec/s, deg/s"),
            ("time [s], rate [volts]\n".to_owned(), "`volts` is not a known unit", "r.csv:1:11", "deg/s"),
            ("time [deg],rate [deg/s]\n".to_owned(), "\"deg\" is an angle", "r.csv:1:1", "s, ms"),
            ("time [s],rate [deg]\n".to_owned(), "\"deg\" is an angle", "r.csv:1:10", "an angular rate in"),
            (
                "time [s],rate [deg/s],rate_deg_per_s\n".to_owned(),
                "columns 2 and 3 are both",
                "r.csv:1:1",
                names,
            ),
            (rows("0,1\n0.1,fast\n"), "\"fast\", which is not a number", "r.csv:3:5", "numbers"),
            (rows("0,1\n0.1,1\n0.2,\n"), "the rate is missing", "r.csv:4:5", "finite number"),
            (rows("0,1\n#\nNaN,1\n"), "the time is missing", "r.csv:4:1", "finite number"),
            (rows("0,1\n0.1,-inf\n"), "`rate [deg/s]` is infinite", "r.csv:3:5", "finite number"),
            (rows("0,1\n0.1, 1e308\n"), "1e308, beyond 1e100, here", "r.csv:3:6", "finite number"),
            (rows("0,1\n0.1\n"), "this row has 1 cell, the header has 2", "r.csv:3:1", "needs 2 cells"),
            (rows("0,1\n0,1,1,5\n"), "this row has 4 cells", "r.csv:3:1", "divided by commas"),
            (rows("0,1\r\n0.1,x\r\n").replace("]\n", "]\r\n"), "\"x\", which is no", "r.csv:3:5", "numbers"),
            (rows("0,1\n0.1,1\n0.1,1\n"), "does not increase: 0.1 after 0.1", "r.csv:4:1", "sort"),
            (rows("0,1\n0.1,1\n0.05,1\n"), "does not increase: 0.05 after 0.1", "r.csv:4:1", "sort"),
            (rows("0,1\n1,1\n2,1\n#\n4,1\n5,1\n"), "a step of 2 s, the median is 1 s", "r.csv:6:1", "evenly"),
            (rows("0,1\n100,1\n200,1\n301.1,1\n"), "a step of 101.1 s", "r.csv:5:1", "within 1 %"),
            (rows("0,1\n1e-300,2\n"), "1e-300 s apart", "r.csv:1:1", "accepted: 1e-9 s to 1e9 s"),
            (rows(""), "at least 2 samples, this one has 0", "r.csv:1:1", "add rows"),
            (rows("0,1\n"), "at least 2 samples, this one has 1", "r.csv:1:1", "add rows"),
            (rows("0,1\n1,1\n2,1\n3,1\n4,1\n5,1\n6,1\n"), "more than 6 rows", "r.csv", "cut it"),
        ];
        for (text, message, place, help) in table {
            let shown = record(&text, 6).unwrap_err();
            for piece in [message, place, help] {
                assert!(shown.contains(piece), "{piece} is missing for\n{text}\nin\n{shown}");
            }
        }
    }

    #[test]
    fn steps_within_one_percent_of_the_median_are_even() {
        let record = record("time [s],rate [deg/s]\n0,1\n100,1\n200.9,1\n300,1\n", 4).unwrap();
        assert_eq!(record.step_s, 100.0);
    }
}
