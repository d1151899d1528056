//! Curves as files: averaging times with Allan deviations, as data sheets, papers and other tools give them.
//!
//! A curve has a header with a column of averaging times (`tau`, `taus`) and one of deviations (`adev`, `oadev`, `sigma`, `dev`), and
//! may have the ends of intervals, standard errors, or numbers of differences. Read are tables with commas, semicolons, tabs or
//! blanks, those that Stable32 writes, and the `curve.csv` of `sagnac allan`.

use std::io::Read;
use std::ops::Range;
use std::path::Path;

use crate::allan::{Deviation, Unit as Curves};
use crate::fit::uncertainty::WITHIN_95;
use crate::record::RecordError;
use crate::record::log::measure::{Data, Unit};
use crate::record::names::{Name, unit_of};
use sagnac_base::diagnostics::{Place, choices, decoded};
use sagnac_base::quantity::Dimension;
use sagnac_base::quantity::number::significant;
use sagnac_base::text_file::{open, read_bytes};

/// Bytes that no file of a curve has, and lines among which its header is.
const MAX_BYTES: u64 = 16 << 20;
const MAX_LINES: usize = 64;
/// Bytes among which the header is.
const HEAD: u64 = 64 << 10;
/// Names of times, which a log has and a curve has not.
const TIMES: [&str; 4] = ["time", "t", "timestamp", "stamp"];
/// Half the 95 % interval that points get of which nothing is known, in parts of their values.
const ASSUMED: f64 = 0.1;
/// Largest relative difference of an averaging time from a multiple of the sampling interval, as files round it.
const NEAREST: f64 = 1e-3;
/// Fewest points of a curve, and most, of which every two have a covariance.
const MIN_POINTS: usize = 3;
const MAX_POINTS: usize = 500;

const TAUS: [&str; 6] = ["tau", "taus", "τ", "averagingtime", "averagingtimes", "clustertime"];
const DEVIATIONS: [(&str, Deviation); 24] = [
    ("overlappingallandeviation", Deviation::Oadev),
    ("modifiedallandeviation", Deviation::Mdev),
    ("hadamarddeviation", Deviation::Hdev),
    ("allandeviation", Deviation::Adev),
    ("timedeviation", Deviation::Tdev),
    ("hadamardsig", Deviation::Hdev),
    ("deviation", Deviation::Adev),
    ("modsigma", Deviation::Mdev),
    ("sigmatau", Deviation::Adev),
    ("allandev", Deviation::Adev),
    ("ohdev", Deviation::Ohdev),
    ("oadev", Deviation::Oadev),
    ("madev", Deviation::Mdev),
    ("sigma", Deviation::Adev),
    ("value", Deviation::Adev),
    ("adev", Deviation::Adev),
    ("hdev", Deviation::Hdev),
    ("mdev", Deviation::Mdev),
    ("tdev", Deviation::Tdev),
    ("devs", Deviation::Adev),
    ("dev", Deviation::Adev),
    ("στ", Deviation::Adev),
    ("σ", Deviation::Adev),
    ("ad", Deviation::Adev),
];
const LOWER: [&str; 9] = ["lower", "low", "lo", "min", "lowerbound", "lowerlimit", "lb", "cilow", "cilower"];
const UPPER: [&str; 9] =
    ["upper", "high", "hi", "max", "upperbound", "upperlimit", "ub", "cihigh", "ciupper"];
const ERRORS: [&str; 10] =
    ["err", "errs", "error", "errors", "std", "stddev", "stderr", "standarderror", "uncertainty", "se"];
const COUNTS: [&str; 6] = ["n", "ns", "#", "count", "counts", "differences"];

/// A curve that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveFile {
    /// Name of the deviation in the file.
    pub name: String,
    /// The unit of the points.
    pub unit: Curves,
    /// The deviation, which is an Allan deviation.
    pub deviation: Deviation,
    /// The points by rising τ.
    pub points: Vec<CurvePoint>,
    /// Source of the errors of the points, as part of a sentence, such as `from the intervals of the file`.
    pub errors: String,
    /// Whether the errors are assumed, because the file states none.
    pub is_assumed: bool,
    /// The record of which these are the overlapping estimates, if it is known and no errors are given in its place.
    pub record: Option<Record>,
    /// What was inferred about the file, in a line each.
    pub notes: Vec<String>,
}

/// The record of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Sampling interval, s.
    pub step_s: f64,
    /// Number of rates.
    pub samples: u64,
}

impl Record {
    /// The averaging factor of an averaging time, s, if the record has differences of it.
    pub fn factor(&self, tau_s: f64) -> Option<u64> {
        let m = libm::round(tau_s / self.step_s);
        let is_near = libm::fabs(m * self.step_s / tau_s - 1.0) <= NEAREST;
        (is_near && m >= 1.0 && 2.0 * m <= self.samples as f64).then_some(m as u64)
    }

    /// Its length, s.
    pub fn length_s(&self) -> f64 {
        self.step_s * self.samples as f64
    }
}

/// A point of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Averaging time, s.
    pub tau_s: f64,
    /// Deviation in the unit of the curve.
    pub value: f64,
    /// Standard error of the deviation in parts of it.
    pub error: f64,
    /// The 95 % interval of the deviation.
    pub interval: [f64; 2],
}

/// How a file of a curve is to be read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CurveRequest {
    /// The column of the deviations, or in a `curve.csv` the column of its log; if absent, the only one.
    pub column: Option<String>,
    /// The unit of the deviations; if absent, that in the header.
    pub unit: Option<String>,
    /// The unit of the averaging times; if absent, that in the header, or s.
    pub time_unit: Option<String>,
    /// Probability of the intervals of a file that does not state it; if absent, 0.95.
    pub confidence: Option<f64>,
    /// The errors of the points, in place of those that the file states.
    pub errors: Option<Errors>,
    /// Sampling interval of the record whose length the errors have, s.
    pub step_s: Option<f64>,
}

/// The errors of points, as a user gives them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Errors {
    /// Half the 95 % interval of each deviation, in parts of it.
    Part(f64),
    /// The errors that a record of this length, s, would have.
    Record(f64),
}

/// Signs between cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Delimiter {
    Sign(char),
    /// Two and more blanks; names may contain one.
    Wide,
    Blank,
}

impl Delimiter {
    /// Signs between the cells of rows: any blanks, where names are divided by several.
    fn of_rows(self) -> Delimiter {
        if self == Delimiter::Wide { Delimiter::Blank } else { self }
    }
}

/// A line with its number from 1.
struct Line<'t> {
    number: usize,
    text: &'t str,
}

impl Line<'_> {
    /// The cells without blanks and quotes around them.
    fn cells(&self, delimiter: Delimiter) -> Vec<Range<usize>> {
        let mut cells = vec![];
        let (mut start, mut is_quoted) = (0, false);
        let is_blank = |at: usize| matches!(self.text.as_bytes().get(at), Some(b' ' | b'\t'));
        for (at, sign) in self.text.char_indices() {
            is_quoted ^= sign == '"';
            let ends = match delimiter {
                Delimiter::Sign(delimiter) => sign == delimiter,
                Delimiter::Blank => is_blank(at),
                Delimiter::Wide => is_blank(at) && (is_blank(at + 1) || at > 0 && is_blank(at - 1)),
            };
            if ends && !is_quoted {
                cells.push(start..at);
                start = at + sign.len_utf8();
            }
        }
        cells.push(start..self.text.len());
        let trimmed = |cell: Range<usize>| {
            let text = &self.text[cell.clone()];
            let inner = text.trim_matches([' ', '\t', '"', '\r']);
            let from = cell.start + (text.len() - text.trim_start_matches([' ', '\t', '"', '\r']).len());
            from.min(cell.end)..(from + inner.len()).min(cell.end)
        };
        let cells = cells.into_iter().map(trimmed);
        match delimiter {
            Delimiter::Sign(_) => cells.collect(),
            _ => cells.filter(|cell| !cell.is_empty()).collect(),
        }
    }
}

/// The header of a curve.
struct Header<'t> {
    line: Line<'t>,
    delimiter: Delimiter,
    names: Vec<Name>,
    cells: Vec<Range<usize>>,
    tau: usize,
}

impl<'t> Header<'t> {
    /// The header of a text, if it has one with a column of averaging times.
    fn find(text: &'t str) -> Option<Header<'t>> {
        text.lines().zip(1..).take(MAX_LINES).find_map(|(text, number)| {
            let shown = text.trim_start_matches(['\u{feff}', '#', '%', ' ', '\t']);
            let line = || Line { number, text: shown };
            let kinds = [
                Delimiter::Sign(';'),
                Delimiter::Sign('\t'),
                Delimiter::Sign(','),
                Delimiter::Wide,
                Delimiter::Blank,
            ];
            kinds.into_iter().find_map(|delimiter| {
                let cells = line().cells(delimiter);
                let names: Vec<Name> = cells.iter().map(|cell| Name::read(&shown[cell.clone()])).collect();
                let tau = names.iter().position(|name| TAUS.contains(&&*plain(&name.bare)))?;
                // In the header of a log of Stable32, `Tau` stands before a number.
                let is_number = |cell: &Range<usize>| shown[cell.clone()].parse::<f64>().is_ok();
                (names.len() > 1 && !cells.iter().any(is_number)).then(|| Header {
                    line: line(),
                    delimiter,
                    names,
                    cells,
                    tau,
                })
            })
        })
    }

    fn place(&self, file: &str, column: usize) -> Place {
        Place::new(file, self.line.number, self.line.text.as_bytes(), self.cells[column].clone())
    }

    /// The columns that `is` holds for.
    fn columns(&self, is: impl Fn(&str) -> bool) -> Vec<usize> {
        (0..self.names.len()).filter(|&i| i != self.tau && is(&plain(&self.names[i].bare))).collect()
    }

    /// The column beside the deviations called by one of these words, alone or with a name of a deviation.
    fn beside(&self, words: &[&str]) -> Option<usize> {
        let is = |name: &str| {
            let without = |(known, _): &(&str, Deviation)| {
                name.strip_prefix(known)
                    .or(name.strip_suffix(known))
                    .is_some_and(|rest| words.contains(&rest))
            };
            words.contains(&name) || DEVIATIONS.iter().any(without)
        };
        self.columns(is).first().copied()
    }
}

/// A name in small letters, without signs.
fn plain(name: &str) -> String {
    let name = name.trim();
    if name == "#" {
        return name.to_owned();
    }
    name.chars().filter(|sign| sign.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

fn deviation_of(name: &str) -> Option<Deviation> {
    let name = plain(name);
    let known = DEVIATIONS.iter().find(|(known, _)| *known == name).map(|(_, deviation)| *deviation);
    known.or_else(|| name.parse().ok())
}

impl CurveFile {
    /// Whether the file at `path` has a curve: a header with a column of averaging times, one of deviations, and none of times. Of
    /// what is no file, such as a pipe, which can be read only once, or cannot be read, this says no.
    pub fn is_one(path: &Path) -> bool {
        if !path.is_file() {
            return false;
        }
        let mut head = vec![];
        let read = open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
        read.is_ok() && CurveFile::is_in(&head)
    }

    /// Whether these bytes of a file have a curve; see [`CurveFile::is_one`].
    pub fn is_in(bytes: &[u8]) -> bool {
        let text = decoded(&bytes[..bytes.len().min(HEAD as usize)]);
        let is_curve = |header: Header| {
            let has = |is: &dyn Fn(&str) -> bool| !header.columns(is).is_empty();
            // Below a comment with such words are no averaging times; below a header may be a row of units.
            let delimiter = header.delimiter.of_rows();
            let is_row = |text: &str| {
                let line = Line { number: 0, text };
                let cell = line.cells(delimiter).get(header.tau).cloned();
                cell.is_some_and(|cell| number(&text[cell]).is_some())
            };
            text.lines().skip(header.line.number).take(3).any(is_row)
                && has(&|name| deviation_of(name).is_some())
                && !has(&|name| TIMES.contains(&name))
        };
        Header::find(&text).is_some_and(is_curve)
    }

    /// Reads the curve at `path`.
    ///
    /// # Errors
    /// The first fault found, with its place: no such column, no unit, a deviation that is no Allan deviation, a cell that is no
    /// number, an interval without its value, times that are not positive or occur twice, or too few points.
    pub fn read(path: &Path, request: &CurveRequest) -> Result<CurveFile, RecordError> {
        let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let bytes = read_bytes(path, MAX_BYTES)
            .map_err(|error| RecordError::unreadable(&path.display().to_string(), &error))?;
        CurveFile::parse(&file, &decoded(&bytes), request)
    }

    /// Reads the curve in a `text`; `file` is the name in messages.
    ///
    /// # Errors
    /// It fails where [`CurveFile::read`] does.
    ///
    /// # Example
    /// ```
    /// use sagnac_records::record::curve_file::{CurveFile, CurveRequest};
    ///
    /// let text = "tau [s], adev [deg/h], err\n1, 0.3, 0.01\n10, 0.1, 0.01\n100, 0.03, 0.01\n";
    /// let curve = CurveFile::parse("gyro.csv", text, &CurveRequest::default()).unwrap();
    /// assert_eq!((curve.points[1].tau_s, curve.points[1].value), (10.0, 0.1));
    /// ```
    pub fn parse(file: &str, text: &str, request: &CurveRequest) -> Result<CurveFile, RecordError> {
        let Some(header) = Header::find(text) else {
            let help = "name the columns, as in `tau [s], adev [deg/h]`";
            return Err(RecordError::new(
                format!("{file} is no curve: it has no column `tau`"),
                "",
                help,
                None,
            ));
        };
        Reader { file, text, header, request }.read()
    }
}

struct Reader<'t> {
    file: &'t str,
    text: &'t str,
    header: Header<'t>,
    request: &'t CurveRequest,
}

/// A row of numbers; those that are missing are NaN.
struct Row {
    tau_s: f64,
    value: f64,
    ends: [f64; 2],
    error: f64,
    count: f64,
    at: (usize, String),
}

impl Reader<'_> {
    fn read(&self) -> Result<CurveFile, RecordError> {
        let (header, request) = (&self.header, self.request);
        let own = self.own_columns();
        let value = if own.is_some() { self.named("value") } else { None };
        let value = value.map_or_else(|| self.value(), Ok)?;
        let mut lines = self.lines();
        let mut name = header.names[value].bare.clone();
        let mut deviation = self.deviation(value);
        let mut unit = request.unit.clone().or(header.names[value].unit.clone());
        if let Some(own) = &own {
            let chosen;
            (lines, name, deviation, chosen) = self.of_own(lines, own)?;
            unit = unit.or(Some(chosen).filter(|unit| !unit.is_empty())).or(Some("none".to_owned()));
        }
        if !matches!(deviation, Deviation::Adev | Deviation::Oadev) {
            let message = format!("`{name}` is a {}", deviation.title());
            let help = "a fit needs an Allan deviation, adev or oadev";
            return Err(RecordError::new(
                message,
                "no Allan deviation",
                help,
                self.header.place(self.file, value),
            ));
        }
        // A line below the header may have units.
        let mut tau_unit = request.time_unit.clone().or(header.names[header.tau].unit.clone());
        if let Some(cell) = lines.first().and_then(|line| self.cell(line, header.tau))
            && number(cell).is_none()
            && unit_of(cell.trim_matches(['[', ']', '(', ')']), &[Dimension::Time]).is_ok()
        {
            let line = lines.remove(0);
            let below = |column| {
                self.cell(&line, column).map(|cell| cell.trim_matches(['[', ']', '(', ')']).to_owned())
            };
            tau_unit = tau_unit.or(below(header.tau));
            unit = unit.or(below(value));
        }
        let unit = self.unit(unit, value)?;
        let tau_size = match &tau_unit {
            None => 1.0,
            Some(text) => {
                unit_of(text, &[Dimension::Time])
                    .map_err(|error| {
                        let message = format!("the unit of `{}`: {error}", header.names[header.tau].whole);
                        RecordError::new(
                            message,
                            "",
                            "accepted: s, ms, us, min, h",
                            header.place(self.file, header.tau),
                        )
                    })?
                    .0
            }
        };
        let columns = [
            Some(header.tau),
            Some(value),
            header.beside(&LOWER),
            header.beside(&UPPER),
            header.beside(&ERRORS).filter(|&column| column != value),
            header.beside(&COUNTS),
        ];
        let mut rows = lines.iter().map(|line| self.row(line, columns)).collect::<Result<Vec<Row>, _>>()?;
        for row in &mut rows {
            row.tau_s *= tau_size;
            row.value *= unit.factor;
            row.error *= unit.factor;
            row.ends = row.ends.map(|end| end * unit.factor);
        }
        let all = rows.len();
        rows.retain(|row| row.value > 0.0);
        let without_value = all - rows.len();
        self.check(&mut rows)?;
        let record = self.record(&rows)?;
        let (errors, source, is_assumed) = self.errors(&rows, record);
        let mut notes = vec![format!("read as a curve, not as a log: {} points of `{name}`", rows.len())];
        if without_value > 0 {
            notes.push(format!("{without_value} rows without a positive deviation are left out"));
        }
        if tau_unit.is_none() {
            notes.push("the averaging times are taken in s".to_owned());
        }
        if is_assumed {
            let advice = "others are given as in `curve_interval = 5%`, or by the length of the record, as in `curve_interval = 9h`";
            notes.push(format!("the errors of the points are assumed: {source}; {advice}"));
        } else {
            notes.push(format!("the errors of the points are {source}"));
        }
        if let Some(Record { step_s, samples }) = record {
            let step = significant(step_s, 4);
            notes.push(format!(
                "taken as overlapping estimates of one record of {samples} samples, one every {step} s"
            ));
        }
        let known = errors.iter().filter(|error| error.is_some()).count();
        if known < rows.len() {
            notes.push(format!("{} points without an interval are left out", rows.len() - known));
        }
        let point = |(row, error): (&Row, Option<f64>)| {
            let (error, stated) = (error?, row.ends[0] > 0.0 && !is_assumed && request.errors.is_none());
            let factor = libm::exp(WITHIN_95 * error);
            let interval = match stated && self.confidence() == 0.95 {
                true => row.ends,
                false => [row.value / factor, row.value * factor],
            };
            Some(CurvePoint { tau_s: row.tau_s, value: row.value, error, interval })
        };
        let points = rows.iter().zip(errors).filter_map(point).collect();
        let unit = unit.curves;
        Ok(CurveFile { name, unit, deviation, points, errors: source, is_assumed, record, notes })
    }

    /// The column with this name.
    fn named(&self, name: &str) -> Option<usize> {
        self.header.columns(|other| other == name).first().copied()
    }

    /// The columns of texts in a `curve.csv` of `sagnac allan`: column, deviation and unit.
    fn own_columns(&self) -> Option<[usize; 3]> {
        let at = |name: &str| self.header.names.iter().position(|other| other.whole == name);
        at("value")?;
        Some([at("column")?, at("deviation")?, at("unit")?])
    }

    /// The lines of one curve among those of a `curve.csv`, with its name, deviation and unit.
    fn of_own<'t>(
        &self,
        lines: Vec<Line<'t>>,
        [column, deviation, unit]: &[usize; 3],
    ) -> Result<(Vec<Line<'t>>, String, Deviation, String), RecordError> {
        let texts = |line: &Line, at: usize| self.cell(line, at).unwrap_or_default().to_owned();
        let mut names: Vec<String> = vec![];
        for line in &lines {
            let name = texts(line, *column);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let wanted = self.request.column.as_ref();
        let name = match (wanted, &names[..]) {
            (None, [only]) => only.clone(),
            (Some(wanted), _) if names.contains(wanted) => wanted.clone(),
            _ => return Err(self.several(&names)),
        };
        let is_of = |line: &Line, kind: Deviation| {
            texts(line, *column) == name && texts(line, *deviation) == kind.name()
        };
        let has = |kind: &Deviation| lines.iter().any(|line| is_of(line, *kind));
        let allan = [Deviation::Oadev, Deviation::Adev].into_iter();
        let kind = allan.chain(Deviation::ALL).find(has).unwrap_or(Deviation::Adev);
        let lines: Vec<Line> = lines.into_iter().filter(|line| is_of(line, kind)).collect();
        let unit = lines.first().map(|line| texts(line, *unit)).unwrap_or_default();
        Ok((lines, name, kind, unit))
    }

    fn several(&self, names: &[String]) -> RecordError {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        match &self.request.column {
            Some(wanted) => {
                let message = format!("no curve is called `{wanted}`");
                RecordError::new(message, "", choices(wanted, &names), None)
            }
            None => {
                let message = format!("{} has several curves: {}", self.file, names.join(", "));
                let help = format!("choose one, as in `column = {}`", names.first().unwrap_or(&""));
                RecordError::new(message, "", help, None)
            }
        }
    }

    /// The column of the deviations.
    fn value(&self) -> Result<usize, RecordError> {
        let header = &self.header;
        if let Some(word) = &self.request.column {
            let is_meant = |name: &Name| name.bare.eq_ignore_ascii_case(word) || name.whole == *word;
            let by_number = || word.parse::<usize>().ok()?.checked_sub(1).filter(|&i| i < header.names.len());
            let found = header.names.iter().position(is_meant).or_else(by_number);
            return found.ok_or_else(|| {
                self.several(&header.names.iter().map(|name| name.bare.clone()).collect::<Vec<_>>())
            });
        }
        let found = header.columns(|name| DEVIATIONS.iter().any(|(known, _)| *known == name));
        let usable = |column: &&usize| matches!(self.deviation(**column), Deviation::Adev | Deviation::Oadev);
        let allan: Vec<usize> = found.iter().filter(usable).copied().collect();
        match (&allan[..], &found[..]) {
            ([only], _) | ([], [only, ..]) => Ok(*only),
            ([], []) => {
                // A file of two columns has no other.
                let others: Vec<usize> = (0..header.names.len()).filter(|&i| i != header.tau).collect();
                if let [only] = others[..] {
                    return Ok(only);
                }
                Err(self.several(&others.iter().map(|&i| header.names[i].bare.clone()).collect::<Vec<_>>()))
            }
            (several, _) => {
                Err(self.several(&several.iter().map(|&i| header.names[i].bare.clone()).collect::<Vec<_>>()))
            }
        }
    }

    /// The deviation of a column by its name, or by what Stable32 states above.
    fn deviation(&self, column: usize) -> Deviation {
        let kind = self.stated("Sigma Type:").unwrap_or_default().to_lowercase();
        match deviation_of(&self.header.names[column].bare) {
            Some(Deviation::Adev) if kind.contains("hadamard") => Deviation::Hdev,
            Some(Deviation::Adev) if kind.starts_with("modified") => Deviation::Mdev,
            Some(Deviation::Adev) if kind.starts_with("overlapping") => Deviation::Oadev,
            Some(Deviation::Adev) if kind.starts_with("time") => Deviation::Tdev,
            Some(Deviation::Adev) if kind.contains("total") => Deviation::Totdev,
            Some(Deviation::Adev) if kind.starts_with("theo1") => Deviation::Theo1,
            Some(Deviation::Adev) if kind.starts_with("theoh") || kind.starts_with("theobr") => {
                Deviation::Theoh
            }
            Some(Deviation::Adev) if kind.starts_with("mtie") => Deviation::Mtie,
            found => found.unwrap_or(Deviation::Adev),
        }
    }

    /// The text behind some words above the header.
    fn stated(&self, words: &str) -> Option<&str> {
        let above = self.text.lines().take(self.header.line.number);
        above.into_iter().find_map(|line| Some(line.trim_start().strip_prefix(words)?.trim()))
    }

    /// Probability of the intervals of the file.
    fn confidence(&self) -> f64 {
        let stated = || {
            let text = self.stated("Confidence Factor")?.trim_start_matches([' ', '=']);
            text.parse().ok().filter(|p: &f64| *p > 0.0 && *p < 1.0)
        };
        stated().or(self.request.confidence).unwrap_or(0.95)
    }

    fn unit(&self, unit: Option<String>, value: usize) -> Result<Unit, RecordError> {
        let name = &self.header.names[value].whole;
        let refused = |message: String, label: &str, help: &str| {
            RecordError::new(message, label, help, self.header.place(self.file, value))
        };
        let help = "write it in the header, as in `adev [deg/h]`, or give it, as in `unit = deg/h`; `unit = none` for plain numbers";
        let unit =
            unit.ok_or_else(|| refused(format!("`{name}` has no unit"), "its unit is missing", help))?;
        Unit::parse(&unit, Data::Rate).map_err(|wrong| refused(wrong.message, "of this column", &wrong.help))
    }

    /// The lines below the header with something to read.
    fn lines(&self) -> Vec<Line<'_>> {
        let lines = self.text.lines().zip(1..).skip(self.header.line.number);
        let is_row =
            |line: &Line| !line.text.trim().is_empty() && !line.text.trim_start().starts_with(['#', '%']);
        lines.map(|(text, number)| Line { number, text }).filter(is_row).collect()
    }

    fn cells(&self, line: &Line) -> Vec<Range<usize>> {
        line.cells(self.header.delimiter.of_rows())
    }

    fn cell<'l>(&self, line: &Line<'l>, column: usize) -> Option<&'l str> {
        self.cells(line).get(column).map(|cell| &line.text[cell.clone()])
    }

    fn row(&self, line: &Line, columns: [Option<usize>; 6]) -> Result<Row, RecordError> {
        let cells = self.cells(line);
        let refused = |span: Range<usize>, message: String, label: &str, help: &str| {
            let place = Place::new(self.file, line.number, line.text.as_bytes(), span);
            RecordError::new(message, label, help, place)
        };
        let mut numbers = [f64::NAN; 6];
        for (found, column) in numbers.iter_mut().zip(columns) {
            let Some(column) = column else { continue };
            let Some(cell) = cells.get(column) else {
                let message =
                    format!("this row has {} cells, the header has {}", cells.len(), self.header.names.len());
                return Err(refused(
                    0..line.text.len(),
                    message,
                    "too short",
                    "give every row a cell for each column",
                ));
            };
            let text = &line.text[cell.clone()];
            if text.is_empty() || text.eq_ignore_ascii_case("nan") {
                continue;
            }
            *found = number(text).ok_or_else(|| {
                let message = format!("\"{text}\" is not a number");
                refused(
                    cell.clone(),
                    message,
                    "in this row",
                    "write numbers, and leave a cell empty where one is missing",
                )
            })?;
        }
        let [tau_s, value, lower, upper, error, count] = numbers;
        let tau = cells[self.header.tau].clone();
        if tau_s.is_nan() || tau_s <= 0.0 || tau_s.is_infinite() {
            return Err(refused(
                tau,
                "an averaging time is not positive".to_owned(),
                "here",
                "every point needs its τ",
            ));
        }
        if lower > 0.0 && upper > 0.0 && !(lower <= value && value <= upper) {
            let help =
                "lower and upper are the ends of an interval around the deviation, not distances from it";
            let cell = columns[1].map_or(0..0, |column| cells[column].clone());
            return Err(refused(
                cell,
                format!("{value} is outside its interval {lower} to {upper}"),
                "this value",
                help,
            ));
        }
        Ok(Row { tau_s, value, ends: [lower, upper], error, count, at: (line.number, line.text.to_owned()) })
    }

    /// Sorts the rows by τ, of which none may occur twice.
    fn check(&self, rows: &mut [Row]) -> Result<(), RecordError> {
        rows.sort_by(|a, b| a.tau_s.total_cmp(&b.tau_s));
        if let Some(pair) = rows.windows(2).find(|pair| pair[1].tau_s <= pair[0].tau_s * (1.0 + 1e-9)) {
            let (number, text) = &pair[1].at;
            let place = Place::new(self.file, *number, text.as_bytes(), 0..text.len());
            let message = format!("τ = {} s occurs twice", significant(pair[1].tau_s, 6));
            let help = "give each curve its column, or each point one row";
            return Err(RecordError::new(message, "this row", help, place));
        }
        if rows.len() < MIN_POINTS {
            let message =
                format!("{} has {} points, a fit needs at least {MIN_POINTS}", self.file, rows.len());
            return Err(RecordError::new(message, "", "add rows, each with τ and its deviation", None));
        }
        if rows.len() > MAX_POINTS {
            let message = format!("{} has {} points of a curve", self.file, rows.len());
            let help = format!("give up to {MAX_POINTS}, such as ten in a decade of τ");
            return Err(RecordError::new(message, "", help, None));
        }
        Ok(())
    }

    /// The record of the curve: of the length and the sampling interval that are given, or by the numbers of differences.
    fn record(&self, rows: &[Row]) -> Result<Option<Record>, RecordError> {
        let refused = |message: String, help: &str| Err(RecordError::new(message, "", help, None));
        let (step_s, length_s) = match (self.request.step_s, self.request.errors) {
            (Some(step_s), Some(Errors::Record(length_s))) => (step_s, length_s),
            (Some(_), _) => {
                let help = "give its length too, as in `curve_interval = 9h`; if the file is a log, rename its column of `tau`";
                let message = format!(
                    "{} is a curve: a rate is that of its record, whose length is missing",
                    self.file
                );
                return refused(message, help);
            }
            (None, None) => return Ok(record_of(rows)),
            (None, Some(_)) => return Ok(None),
        };
        let record = Record { step_s, samples: libm::round(length_s / step_s) as u64 };
        match rows.iter().find(|row| record.factor(row.tau_s).is_none()) {
            None => Ok(Some(record)),
            Some(row) => {
                let [tau, step, length] = [row.tau_s, step_s, length_s].map(|time_s| significant(time_s, 6));
                let (number, text) = &row.at;
                let place = Place::new(self.file, *number, text.as_bytes(), 0..text.len());
                let message =
                    format!("a record of {length} s with a sample every {step} s has no τ of {tau} s");
                let help = "τ is a multiple of the sampling interval, up to half the record: give the rate and length of the record";
                Err(RecordError::new(message, "this row", help, place))
            }
        }
    }

    /// The standard error of each point in parts of it, if it has one, their source, and whether they are assumed.
    fn errors(&self, rows: &[Row], record: Option<Record>) -> (Vec<Option<f64>>, String, bool) {
        let of_record = |length_s: f64| {
            // A variance from T/τ groups has a relative variance of about 2τ/T.
            let error = move |row: &Row| Some(libm::sqrt(0.5 * row.tau_s / length_s));
            rows.iter().map(error).collect::<Vec<_>>()
        };
        let shown = |length_s: f64| significant(length_s, 4);
        match self.request.errors {
            Some(Errors::Part(part)) => {
                let percent = significant(100.0 * part, 3);
                return (
                    vec![Some(part / WITHIN_95); rows.len()],
                    format!("95 % intervals of ±{percent} %, as given"),
                    false,
                );
            }
            Some(Errors::Record(length_s)) => {
                return (
                    of_record(length_s),
                    format!("those of a record of {} s, as given", shown(length_s)),
                    false,
                );
            }
            None => {}
        }
        let confidence = self.confidence();
        let side = crate::allan::distributions::normal_quantile(0.5 + 0.5 * confidence);
        let by_ends = |row: &Row| {
            let [lower, upper] = row.ends;
            (lower > 0.0 && upper > lower).then(|| 0.5 * libm::log(upper / lower) / side)
        };
        let by_error = |row: &Row| (row.error > 0.0).then(|| row.error / row.value);
        let percent = significant(100.0 * confidence, 3);
        let sources: [(Vec<Option<f64>>, String); 2] = [
            (
                rows.iter().map(by_ends).collect(),
                format!("from the intervals of the file, taken as {percent} %"),
            ),
            (rows.iter().map(by_error).collect(), "those of the file, taken as standard errors".to_owned()),
        ];
        for (errors, source) in sources {
            if errors.iter().flatten().count() >= MIN_POINTS {
                return (errors, source, false);
            }
        }
        match record.map(|record| record.length_s()).or_else(|| length_of(rows)) {
            Some(length_s) => {
                let source =
                    format!("those of a record of {} s, by the numbers of differences", shown(length_s));
                (of_record(length_s), source, record.is_none())
            }
            None => {
                let source = "95 % intervals of ±10 %";
                (vec![Some(ASSUMED / WITHIN_95); rows.len()], source.to_owned(), true)
            }
        }
    }
}

/// Length of the record of a curve by its numbers of differences, s, if those of adjacent groups fall as 1/τ.
fn length_of(rows: &[Row]) -> Option<f64> {
    let (first, last) = (rows.first()?, rows.last()?);
    let [start_s, end_s] = [first, last].map(|row| (row.count + 1.0) * row.tau_s);
    let is_one = first.count > last.count && last.count >= 1.0 && (0.5..2.0).contains(&(start_s / end_s));
    is_one.then_some(start_s)
}

/// The record of a curve by its numbers of differences, if those are the N + 1 − 2m of overlapping groups of m of N samples.
fn record_of(rows: &[Row]) -> Option<Record> {
    let (first, last) = (rows.first()?, rows.last()?);
    let step_s = 2.0 * (last.tau_s - first.tau_s) / (first.count - last.count);
    let samples = first.count + 2.0 * libm::round(first.tau_s / step_s) - 1.0;
    let record = Record { step_s: 2.0 * last.tau_s / (samples + 1.0 - last.count), samples: samples as u64 };
    let is_of = |row: &Row| {
        let m = record.factor(row.tau_s);
        m.is_some_and(|m| row.count + 2.0 * m as f64 == samples + 1.0)
    };
    rows.iter().all(is_of).then_some(record)
}

/// A number, with a point or a comma before its decimals.
fn number(text: &str) -> Option<f64> {
    text.parse().or_else(|_| text.replace(',', ".").parse()).ok().filter(|number: &f64| !number.is_infinite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(unit: &str) -> CurveRequest {
        CurveRequest {
            unit: Some(unit.to_owned()).filter(|unit| !unit.is_empty()),
            ..CurveRequest::default()
        }
    }

    fn read(text: &str, unit: &str) -> CurveFile {
        CurveFile::parse("c.csv", text, &request(unit))
            .unwrap_or_else(|error| panic!("{text}\n{}", error.render(false, 120)))
    }

    #[test]
    fn curves_are_read_as_other_tools_write_them() {
        // (text, unit that is given, first value, first error, whether errors are assumed)
        let table = [
            ("tau [s],adev [deg/h]\n1,0.3\n10,0.1\n100,0.03\n", "", 0.3, 0.051, true),
            (
                "tau_s;adev_deg_h;low;high\n1;0,3;0,27;0,33333\n10;0,1;0,09;0,11\n100;0,03;0,02;0,04\n",
                "",
                0.3,
                0.053_75,
                false,
            ),
            (
                "taus,devs,errs,ns\n1,1,0.01,9999\n2,0.7,0.01,9997\n4,0.5,0.01,9993\n",
                "deg/s",
                3600.0,
                0.01,
                false,
            ),
            ("# tau adev\n1 3\n10 1\n100 0.3\n", "deg/h", 3.0, 0.051, true),
            ("σ(τ) [°/h]\tτ [min]\n1\t1\n0.5\t2\n0.2\t4\n", "", 1.0, 0.051, true),
            ("tau,sigma\ns,deg/h\n100,0.3\n10,0.1\n1,1\n", "", 1.0, 0.051, true),
            ("tau,oadev,n\n1,1,9999\n10,0.3,9981\n100,0.1,9801\n", "deg/h", 1.0, 0.007_07, false),
            ("tau,adev,n\n1,1,9999\n10,0.3,999\n100,0.1,99\n", "deg/h", 1.0, 0.007_07, true),
        ];
        for (text, unit, value, error, is_assumed) in table {
            let curve = read(text, unit);
            let first = curve.points[0];
            assert!((first.value / value - 1.0).abs() < 1e-9, "{text}\n{first:?}");
            assert!((first.error / error - 1.0).abs() < 2e-2, "{text}\n{first:?}");
            assert_eq!(curve.is_assumed, is_assumed, "{text}");
        }
    }

    #[test]
    fn stable32_says_what_its_intervals_are() {
        let text = "STATISTICS FOR FILE: PHASE.DAT\n Sigma Type: Overlapping Allan\n Confidence Factor = 0.683\n\n\
                    \x20 AF        Tau         #    Alpha  Min Sigma      Sigma         Max Sigma\n\
                    \x20   1   1.0000e+00      998     0   2.8670e-01    2.9439e-01     3.0274e-01\n\
                    \x20   2   2.0000e+00      996     0   1.9726e-01    2.0297e-01     2.0922e-01\n\
                    \x20   4   4.0000e+00      992     0   1.3744e-01    1.4252e-01     1.4821e-01\n";
        let curve = read(text, "deg/h");
        assert_eq!((curve.deviation, curve.points[2].value), (Deviation::Oadev, 0.14252));
        assert_eq!(curve.record, Some(Record { step_s: 1.0, samples: 999 }));
        // A ratio of ends of 1.056 is two standard errors.
        assert!((curve.points[0].error / 0.0272 - 1.0).abs() < 0.01, "{:?}", curve.points[0]);
        let hadamard = text.replace("Overlapping Allan", "Hadamard");
        let error = CurveFile::parse("c.csv", &hadamard, &request("deg/h")).unwrap_err().render(false, 120);
        assert!(error.contains("Hadamard deviation"), "{error}");
    }

    #[test]
    fn the_record_of_a_curve_follows_from_its_counts_or_is_given() {
        // Times of 0.3 s, rounded; at the end a count that is off by one, and counts of adjacent groups.
        let text = |last: u32| format!("tau,oadev,n\n0.6,1,9997\n3,1,9981\n99.91,1,{last}\n");
        let record = read(&text(9335), "deg/h").record;
        assert!(record.is_some_and(|record| record.samples == 10_000 && (record.step_s - 0.3).abs() < 1e-4));
        assert_eq!(read(&text(9334), "deg/h").record, None);
        assert_eq!(read("tau,adev,n\n1,1,9999\n10,0.3,999\n100,0.1,99\n", "deg/h").record, None);
        let given = |text: &str, step_s, errors| {
            CurveFile::parse("c.csv", text, &CurveRequest { step_s, errors, ..request("deg/h") })
        };
        let plain = "tau,adev\n0.5,1\n10,0.3\n100,0.1\n";
        let found = given(plain, Some(0.1), Some(Errors::Record(1000.0))).unwrap();
        assert_eq!(found.record, Some(Record { step_s: 0.1, samples: 10_000 }));
        assert_eq!(found.record.and_then(|record| record.factor(0.5)), Some(5));
        let only_length = given(plain, None, Some(Errors::Record(1000.0))).unwrap();
        assert_eq!((only_length.record, only_length.is_assumed), (None, false));
        assert_eq!(given(&text(9335), None, Some(Errors::Part(0.1))).unwrap().record, None);
        for (step_s, errors, piece) in [
            (0.4, Some(Errors::Record(1000.0)), "has no τ of 0.5 s"),
            (0.1, Some(Errors::Record(150.0)), "has no τ of 100 s"),
            (0.1, None, "whose length is missing"),
            (0.1, Some(Errors::Part(0.1)), "whose length is missing"),
        ] {
            let error = given(plain, Some(step_s), errors).unwrap_err().render(false, 200);
            assert!(error.contains(piece), "{piece} is missing in {error}");
        }
    }

    #[test]
    fn a_curve_of_a_log_is_read_back() {
        let text = "column,deviation,m,tau_s,differences,alpha,lower,value,upper,unit\n\
                    gx,oadev,1,1,99,0,0.9,1,1.1,deg/h\ngx,oadev,2,2,97,0,0.6,0.7,0.8,deg/h\ngx,oadev,4,4,93,0,0.4,0.5,0.6,deg/h\n\
                    gx,mdev,1,1,99,0,0.9,1,1.1,deg/h\ngy,oadev,1,1,99,0,0.9,3,4.1,deg/h\n";
        let of = |column: &str| CurveRequest { column: Some(column.to_owned()), ..CurveRequest::default() };
        let curve = CurveFile::parse("curve.csv", text, &of("gx")).unwrap();
        assert_eq!(
            (curve.points.len(), curve.deviation, curve.points[0].interval),
            (3, Deviation::Oadev, [0.9, 1.1])
        );
        for (request, piece) in
            [(CurveRequest::default(), "several curves: gx, gy"), (of("gz"), "no curve is called `gz`")]
        {
            let error = CurveFile::parse("curve.csv", text, &request).unwrap_err().render(false, 120);
            assert!(error.contains(piece), "{error}");
        }
    }

    #[test]
    fn what_is_no_curve_is_shown_with_its_place_and_what_to_do() {
        let table = [
            ("time,gz\n1,2\n", "no column `tau`", "tau [s], adev"),
            ("tau,adev\n1,1\n2,1\n3,1\n", "`adev` has no unit", "c.csv:1:5"),
            ("tau,mdev [deg/h]\n1,1\n2,1\n3,1\n", "modified Allan deviation", "c.csv:1:5"),
            ("tau,adev [deg]\n1,1\n2,1\n3,1\n", "is an angle", "c.csv:1:5"),
            ("tau,adev [deg/h]\n1,1\n2,x\n3,1\n", "\"x\" is not a number", "c.csv:3:3"),
            ("tau,adev [deg/h]\n1,1\n-2,1\n3,1\n", "not positive", "c.csv:3:1"),
            ("tau,adev [deg/h]\n1,1\n1,2\n3,1\n", "occurs twice", "c.csv:3:1"),
            ("tau,adev [deg/h]\n1,1\n2,1\n", "has 2 points", "add rows"),
            ("tau,adev [deg/h]\n1\n2,1\n", "this row has 1 cells", "c.csv:2:1"),
            (
                "tau,adev [deg/h],lower,upper\n1,1,0.1,0.2\n2,1,1,1\n3,1,1,1\n",
                "outside its interval",
                "c.csv:2:3",
            ),
            ("tau [s],gx [deg/h],gy [deg/h]\n1,1,1\n", "several curves: gx, gy", "column = gx"),
        ];
        for (text, message, place) in table {
            let error =
                CurveFile::parse("c.csv", text, &CurveRequest::default()).unwrap_err().render(false, 200);
            assert!(error.contains(message) && error.contains(place), "{text}\n{error}");
        }
    }
}
