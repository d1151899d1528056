//! The rows of a record's file, and the samples in them.

use std::ops::Range;

use csv::{Reader, ReaderBuilder, StringRecord, Trim};

use crate::quantity::number::significant;
use crate::quantity::units::round_12;
use crate::record::header::{Column, Columns};
use crate::record::log::STEPS_HELP;
use crate::record::{Record, STEPS_S};
use crate::source::diagnose::Fault;

/// Largest relative deviation of a step from the median one.
const UNEVEN: f64 = 0.01;

/// Reads the `text` of a record of at most `most` samples.
pub(crate) fn read(text: &str, most: usize) -> Result<Record, Fault> {
    let mut rows = Rows::new(text);
    let Some(header) = rows.advance()? else {
        let help = "write a header and one row for each sample, as in\ntime [s], rate [deg/s]\n0.000, 1.25";
        return Err(Fault::new(0..0, "the record is empty", "no header", help));
    };
    let columns = Columns::read(&header)?;
    let time = columns.time.place(&header);
    let (mut times, mut rates) = (Vec::new(), Vec::new());
    while let Some(row) = rows.advance()? {
        if rates.len() == most {
            let message = format!("the record has more than {most} samples");
            return Err(Fault::new(
                row.span,
                message,
                "one too many",
                "cut it, or resample it with a longer step",
            ));
        }
        columns.check(&row)?;
        let (time, rate) = (columns.time.value(&row)?, columns.rate.value(&row)?);
        if let Some(&before) = times.last()
            && time <= before
        {
            return Err(not_increasing(before, time, columns.time.place(&row)));
        }
        times.push(time);
        rates.push(rate);
    }
    if rates.len() < 2 {
        let message = format!("a record needs at least 2 samples, this one has {}", rates.len());
        let help = "the step is the time from one sample to the next: add rows";
        return Err(Fault::new(text.len()..text.len(), message, "the end of the record", help));
    }
    check_steps(text, &columns.time, &times)?;
    let steps = rates.len() - 1;
    let step_s = round_12((times[steps] - times[0]) / steps as f64);
    if !STEPS_S.contains(&step_s) {
        let message = format!("the samples are {} s apart", significant(step_s, 6));
        return Err(Fault::new(time, message, "of this time", STEPS_HELP));
    }
    Ok(Record { step_s, rates })
}

fn not_increasing(before: f64, time: f64, place: Range<usize>) -> Fault {
    let [before, time] = [before, time].map(|x| significant(x, 12));
    let message = format!("the time does not increase: {time} s after {before} s");
    Fault::new(place, message, "not later than the row before", "sort the rows by time and remove doubles")
}

/// Refuses `times` that are not evenly spaced.
fn check_steps(text: &str, time: &Column, times: &[f64]) -> Result<(), Fault> {
    let mut sorted: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    let is_even = |pair: &[f64]| libm::fabs(pair[1] - pair[0] - median) <= UNEVEN * median;
    let Some(before) = times.windows(2).position(|pair| !is_even(pair)) else { return Ok(()) };
    // Places are not kept for millions of rows, so the row at fault is read again, after the header and the rows before
    // it.
    let mut rows = Rows::new(text);
    for _ in 0..before + 2 {
        rows.advance()?;
    }
    let place = rows.advance()?.map_or(0..0, |row| time.place(&row));
    let [step, median] = [times[before + 1] - times[before], median].map(|x| significant(x, 6));
    let message = format!(
        "the record is not evenly sampled: sample {} comes {step} s after the one before, the median step is {median} s",
        before + 2
    );
    let help = "resample it evenly first: every step must be within 1 % of the median step";
    Err(Fault::new(place, message, format!("a step of {step} s"), help))
}

/// One row as in the file.
#[derive(Debug)]
pub(crate) struct Row<'r> {
    pub(crate) cells: &'r StringRecord,
    /// Place of the row in the text, without the end of its line.
    pub(crate) span: Range<usize>,
    text: &'r str,
}

impl Row<'_> {
    /// The place of the cell at `index`, or the whole row if the cell is missing or a quote may hide a comma.
    pub(crate) fn cell(&self, index: usize) -> Range<usize> {
        let row = &self.text[self.span.clone()];
        let mut start = self.span.start;
        for (i, cell) in row.split(',').enumerate() {
            if i == index && !row.contains('"') {
                let lead = cell.len() - cell.trim_start().len();
                return start + lead..start + lead.max(cell.trim_end().len());
            }
            start += cell.len() + 1;
        }
        self.span.clone()
    }
}

/// The rows of a text, with the header first, and without comments and blank lines.
struct Rows<'t> {
    text: &'t str,
    reader: Reader<&'t [u8]>,
    cells: StringRecord,
}

impl<'t> Rows<'t> {
    fn new(text: &'t str) -> Rows<'t> {
        // Rows whose length differs from the header's are refused with their place, which the reader would not give.
        let mut form = ReaderBuilder::new();
        form.has_headers(false).flexible(true).comment(Some(b'#')).trim(Trim::All);
        Rows { text, reader: form.from_reader(text.as_bytes()), cells: StringRecord::new() }
    }

    /// The next row; `None` at the end.
    fn advance(&mut self) -> Result<Option<Row<'_>>, Fault> {
        let start = self.reader.position().byte() as usize;
        let there = self.reader.read_record(&mut self.cells);
        let end = (self.reader.position().byte() as usize).min(self.text.len());
        // The reader counts comments and blank lines before a row as part of it.
        let read = self.text.get(start..end).unwrap_or_default().trim_end();
        let span = start + read.rfind(['\n', '\r']).map_or(0, |line_end| line_end + 1)..start + read.len();
        match there {
            Ok(true) => Ok(Some(Row { cells: &self.cells, span, text: self.text })),
            Ok(false) => Ok(None),
            Err(error) => {
                let help = "a record is CSV: one line for each sample, cells separated by commas";
                Err(Fault::new(span, format!("the record is not valid CSV: {error}"), "here", help))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rendered(text: &str) -> String {
        Record::parse("r.csv", text).unwrap_err().render(false, 200)
    }

    #[test]
    fn a_record_is_read_whatever_its_order_units_and_surroundings() {
        let expected: [f64; 3] = [3600.0, -7200.0, 0.36];
        let texts = [
            "time [s],rate [deg/s]\n0,1\n0.002,-2\n0.004,1e-4\n",
            "time [ms], rate (arcsec/s)\n10, 3600\n12, -7200\n14, 0.36",
            "\u{feff}# base, \"x\n\nrate [°/s] ; id,temperature [K],rate_deg_per_s,time_ms\n9,,1,-2\n# half\n9,x,-2,0\n\n9,,+1e-4,2\n",
            "TIME [s],Rate [deg/s],\"a, b\"\r\n0,1,\"x\r\ny\"\r\n0.002,-2,z\r\n0.004,0.0001,\r\n",
            "time [s],rate [deg/s]\n5000000000,1\n5000000000.002,-2\n5000000000.004,1e-4\n",
        ];
        for text in texts {
            let found =
                Record::parse("r.csv", text).unwrap_or_else(|e| panic!("{text}\n{}", e.render(false, 110)));
            assert!((found.step_s - 0.002).abs() < 1e-6, "{text}\n{}", found.step_s);
            assert_eq!(found.rates.len(), 3, "{text}");
            for (rate, expected) in found.rates.iter().zip(expected) {
                assert!((rate / expected - 1.0).abs() < 1e-15, "{text}\n{rate}, not {expected}");
            }
        }
    }

    #[test]
    fn what_is_no_record_is_shown_with_its_place_and_what_to_do() {
        let head = "time [s],rate [deg/s]\n";
        let table = [
            ("", "the record is empty", "r.csv:1:1", "write a header"),
            ("# only a comment\n", "the record is empty", "r.csv:1:1", "write a header"),
            ("0,1\n1,2\n", "the header is missing", "r.csv:1:1", "time [s], rate [deg/s]"),
            (
                "time [s];rate [deg/s]\n0;1\n",
                "the header has only one column",
                "r.csv:1:1",
                "a comma between",
            ),
            (
                "time [s],speed [deg/s]\n",
                "no column is called `rate`; the columns are `time [s]`, `speed [deg/s]`",
                "r.csv:1:1",
                "rate [deg/s]",
            ),
            ("#\n\ntime [s],rate\n", "the column `rate` has no unit", "r.csv:3:10", "arcsec/s, deg/s"),
            ("time [s], rate [dps]\n", "`dps` is not a known unit", "r.csv:1:11", "arcsec/s, deg/s"),
            ("time [deg],rate [deg/s]\n", "\"deg\" is an angle", "r.csv:1:1", "s, ms"),
            ("time [s],rate [deg]\n", "\"deg\" is an angle", "r.csv:1:10", "an angular rate in"),
            (
                "time [s],rate [deg/s],rate_deg_per_s\n",
                "two columns are called `rate`",
                "r.csv:1:23",
                "rename",
            ),
            (
                &format!("{head}0,1\n0.1,fast\n"),
                "the rate \"fast\" is not a number",
                "r.csv:3:5",
                "finite number",
            ),
            (&format!("{head}0,1\n0.1,1\n0.2,\n"), "the rate is missing", "r.csv:4:5", "finite number"),
            (
                &format!("{head}0,1\n#\nNaN,1\n"),
                "the time \"NaN\" is not a finite number",
                "r.csv:4:1",
                "finite",
            ),
            (
                &format!("{head}0,1\n0.1,-inf\n"),
                "the rate \"-inf\" is not a finite number",
                "r.csv:3:5",
                "finite",
            ),
            (
                &format!("{head}0,1\n0.1, 1e308\n"),
                "the rate \"1e308\" is not a finite number",
                "r.csv:3:6",
                "finite",
            ),
            (
                &format!("{head}0,1\n0.1\n"),
                "this row has 1 cell, the header has 2",
                "r.csv:3:1",
                "one cell for each",
            ),
            (&format!("{head}0,1\n0,1,1,5\n"), "this row has 4 cells", "r.csv:3:1", "point for decimals"),
            (
                &format!("{head}0,1\n0.1,1\n0.1,1\n"),
                "does not increase: 0.1 s after 0.1 s",
                "r.csv:4:1",
                "sort",
            ),
            (
                &format!("{head}0,1\n0.1,1\n0.05,1\n"),
                "does not increase: 0.05 s after 0.1 s",
                "r.csv:4:1",
                "sort",
            ),
            (
                &format!("{head}0,1\n1,1\n2,1\n#\n4,1\n5,1\n"),
                "sample 4 comes 2 s after the one before, the median step is 1 s",
                "r.csv:6:1",
                "resample it evenly first",
            ),
            (
                &format!("{head}0,1\n100,1\n200,1\n301.1,1\n"),
                "sample 4 comes 101.1 s after",
                "r.csv:5:1",
                "within 1 %",
            ),
            (&format!("{head}0,1\n1e-300,2\n"), "1e-300 s apart", "r.csv:1:1", "accepted: 1e-9 s to 1e9 s"),
            (head, "at least 2 samples, this one has 0", "r.csv:", "add rows"),
            (&format!("{head}0,1\n"), "at least 2 samples, this one has 1", "r.csv:", "add rows"),
        ];
        for (text, message, place, help) in table {
            let shown = rendered(text);
            for piece in [message, place, help] {
                assert!(shown.contains(piece), "{piece} is missing for\n{text}\nin\n{shown}");
            }
        }
    }

    #[test]
    fn steps_within_one_percent_of_the_median_are_even() {
        let record = Record::parse("r.csv", "time [s],rate [deg/s]\n0,1\n100,1\n200.9,1\n300,1\n").unwrap();
        assert_eq!(record.step_s, 100.0);
    }

    #[test]
    fn a_sample_beyond_the_most_is_refused_at_its_row() {
        let text = "time [s],rate [deg/s]\n0,1\n1,1\n2,1\n3,1\n";
        assert_eq!(read(text, 4).unwrap().rates.len(), 4);
        let fault = read(text, 3).unwrap_err();
        assert_eq!(
            fault,
            Fault::new(
                34..37,
                "the record has more than 3 samples",
                "one too many",
                "cut it, or resample it with a longer step"
            )
        );
    }
}
