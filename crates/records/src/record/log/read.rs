//! Reading a file into a [`Log`].

use std::path::{Path, PathBuf};

use crate::record::binary::Binary;
use crate::record::column_file::{ColumnFile, Rules};
use crate::record::format::Origin;
use crate::record::layout::Decimal;
use crate::record::log::columns::{
    data_of, expanded, few, is_temperature, likely, name_of, several_groups, span_of, unnamed, wanted,
};
use crate::record::log::measure::{Data, Unit, expected};
use crate::record::log::timing::{Clock, found, is_time, spread};
use crate::record::log::{Channel, Log, MAX_SAMPLES, Thermometer};
use crate::record::names::{Name, unit_of};
use crate::record::timestamps::interleaved;
use crate::record::{Faults, RecordError};
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, accepted, parse};

/// Steps are within 10 % of whole multiples of the sampling step; longer ones are gaps.
pub(crate) const RULES: Rules = Rules {
    most: MAX_SAMPLES,
    missing: "leave the cell empty or write NaN where a sample is missing",
    jitter: 0.1,
    has_gaps: true,
    uneven: "resample the log, or give its rate as `rate = HZ` too",
};

/// Most columns of temperature that are read without being asked for.
const MAX_THERMOMETERS: usize = 4;

/// The columns of a log to read, and their interpretation. By default all of it is inferred from the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Request {
    /// Column names, numbers from 1 or ranges of numbers such as `2-4`, or `all`. If there are none, those of a binary layout, or the
    /// only column besides the time, or all columns whose units in the header are those of such data.
    pub columns: Vec<String>,
    /// Spacing of the samples.
    pub timing: Timing,
    /// Quantity of the samples; if absent, what the names and units of the columns say, else rates.
    pub data: Option<Data>,
    /// One unit for all columns, or one for each; if there are none, that in each column's header.
    pub units: Vec<Unit>,
    /// The column of a temperature to read with the samples, if any; it is never taken for the times.
    pub temperature: Option<Thermometer>,
    /// Properties of the file that the user states.
    pub hints: Hints,
}

/// Properties of a file that the user states, each in place of the one that would be inferred.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Hints {
    /// Sign before decimals in a text.
    pub decimal: Option<Decimal>,
    /// Treatment of rows with other numbers at the same time; if absent, they are refused.
    pub duplicates: Option<Duplicates>,
    /// Layout of a raw binary file.
    pub binary: Option<Binary>,
}

/// The treatment of rows that have the time of the row before, but other numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Duplicates {
    /// Only the first of them is a sample.
    First,
    /// Only the last of them is a sample.
    Last,
    /// Each is a sample, because the stamps are coarser than the sampling step, which must be given.
    Keep,
}

/// The times of the samples.
#[derive(Debug, Clone, PartialEq)]
pub enum Timing {
    /// A constant step, s. All rows are one series without gaps.
    Step(f64),
    /// The times in a column.
    Stamps {
        /// The sampling step, s: the stamps then only show where samples are missing. If absent, it follows from the stamps.
        step_s: Option<f64>,
        /// Name of the column, or its number from 1; if absent, a column that is called like a time. With a sampling step the
        /// file may have none.
        column: Option<String>,
        /// Unit of the times, such as `ms`; if absent, that in the header, or that of times since 1970.
        unit: Option<String>,
    },
}

impl Default for Timing {
    /// The stamps of the file.
    fn default() -> Timing {
        Timing::Stamps { step_s: None, column: None, unit: None }
    }
}

impl Timing {
    /// The times by the words of the user: a sampling step, a column or `none` for no stamps, and a unit.
    ///
    /// # Errors
    /// Stamps are to be ignored, and there is no step; the message says so.
    pub fn new(step_s: Option<f64>, column: Option<String>, unit: Option<String>) -> Result<Timing, String> {
        match (step_s, column.as_deref()) {
            (Some(step_s), Some("none")) => Ok(Timing::Step(step_s)),
            (None, Some("none")) => {
                let message = "`time = none` ignores time stamps, and the sampling rate is not given\ngive `rate = HZ`, that of \
                               your logger, too";
                Err(message.to_owned())
            }
            _ => Ok(Timing::Stamps { step_s, column, unit }),
        }
    }
}

/// The sampling interval, s, of a rate such as `100 Hz` or of the time between samples.
///
/// # Errors
/// The text is neither, or not positive.
pub fn step_of(rate: &str) -> Result<f64, String> {
    let wanted = [Dimension::Frequency, Dimension::Time];
    let found = parse(rate, &wanted).map_err(|error| format!("{error}; {}", accepted(&wanted)))?;
    match found.dimension {
        _ if found.value <= 0.0 => Err("the rate is not positive".to_owned()),
        Dimension::Time => Ok(found.value),
        _ => Ok(1.0 / found.value),
    }
}

impl Request {
    /// Quantity of the samples.
    pub(crate) fn data(&self) -> Data {
        self.data.unwrap_or(Data::Rate)
    }
}

impl Log {
    /// Reads the columns of the log at `path` that `request` selects.
    ///
    /// Text may be CSV, TSV, separated by semicolons or in columns with blanks between, with or without a header, with
    /// comments after `#`, `%` or `;`, and with decimal points or commas; a Stable32 .DAT is one such file. Arrays may be in
    /// NumPy, MATLAB and HDF5 files, messages of an IMU in MCAP files and ROS bags, samples in logs of PX4 and ArduPilot. Empty
    /// cells and NaN are missing samples, and so are those skipped by a step of several sampling steps. What was inferred is in
    /// [`Log::notes`].
    ///
    /// Without a given sampling step, it is the median step of the stamps, and all steps must be within 10 % of whole
    /// multiples of it. With one, stamps may be late by several steps.
    ///
    /// # Errors
    /// All faults that were found, each with its place if the file has lines, and with what settles it.
    ///
    /// # Example
    /// ```
    /// # use sagnac_records::record::log::Log;
    /// # use sagnac_records::record::log::read::{Hints, Request, Timing};
    /// # let folder = tempfile::tempdir()?;
    /// # let path = &folder.path().join("gyro.csv");
    /// std::fs::write(path, "time [ms],gz [deg/h]\n0,8.1\n10,8.3\n30,8.2\n")?;
    /// let timing = Timing::Stamps { step_s: None, column: Some("time".to_owned()), unit: None };
    /// let columns = vec!["gz".to_owned()];
    /// let (units, hints) = (vec![], Hints::default());
    /// let request = Request { columns, timing, data: None, units, temperature: None, hints };
    /// let log = Log::read(path, &request)?;
    /// assert_eq!((log.step_s, log.samples()), (0.01, 4));
    /// assert!(log.channels[0].samples[2].is_nan());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn read(path: &Path, request: &Request) -> Result<Log, RecordError> {
        Log::read_from(&path.display().to_string(), Origin::Path(path), request)
    }

    /// Reads the columns that `request` selects of a log in memory, whose file is called `name`, as [`read`](Log::read) does.
    ///
    /// # Errors
    /// All faults that were found, as those of [`read`](Log::read).
    pub fn read_bytes(name: &str, bytes: &[u8], request: &Request) -> Result<Log, RecordError> {
        Log::read_from(name, Origin::Bytes(bytes), request)
    }

    /// Reads the columns that `request` selects of a recording of ROS 2 in several files (.db3, .mcap), which follow each other in
    /// this order and are called `name`.
    ///
    /// # Errors
    /// A file is of another format, or faults as those of [`read`](Log::read) were found.
    pub fn read_parts(name: &str, files: &[PathBuf], request: &Request) -> Result<Log, RecordError> {
        Log::read_with(|| ColumnFile::open_parts(name, files), request)
    }

    fn read_from(name: &str, origin: Origin, request: &Request) -> Result<Log, RecordError> {
        Log::read_with(|| ColumnFile::open(name.to_owned(), origin.clone(), &request.hints), request)
    }

    fn read_with<'f>(
        open: impl Fn() -> Result<ColumnFile<'f>, RecordError>,
        request: &Request,
    ) -> Result<Log, RecordError> {
        // Columns of temperature that nobody asked for are no reason to refuse a log.
        Log::read_columns(open()?, request, true).or_else(|_| Log::read_columns(open()?, request, false))
    }

    fn read_columns(
        mut file: ColumnFile,
        request: &Request,
        has_thermometers: bool,
    ) -> Result<Log, RecordError> {
        let (mut faults, mut notes) = (Faults::default(), file.inferred());
        let named = request.hints.binary.iter().flat_map(|layout| layout.named(is_time)).collect::<Vec<_>>();
        let thermometer = request.temperature.as_ref();
        let taken = thermometer.and_then(|given| faults.take(file.find(&given.column, None)));
        let degree = thermometer.zip(taken).map(|(given, column)| given.degree(&file, column, &mut notes));
        let degree = degree.and_then(|degree| faults.take(degree));
        let is_time_open = matches!(&request.timing, Timing::Stamps { step_s: None, unit: None, .. });
        if let Some(rivals) = file.rivals().filter(|_| is_time_open || request.units.is_empty()) {
            return Err(file.refuse(None, &rivals.message, "this header", &rivals.help));
        }
        if let Some(question) = several_groups(&file, request) {
            return Err(question);
        }
        let words = expanded(&file, &request.columns);
        // Without a column, the sensor whose times count is not known either.
        if file.groups().len() > 1
            && let Some(error) = words.iter().find_map(|word| file.find(word, None).err())
        {
            return Err(error);
        }
        let inferred = if request.data.is_none() { data_of(&file, &words) } else { None };
        notes.extend(inferred.as_ref().map(|(_, note)| note.clone()));
        let data = inferred.map(|(data, _)| data).or(request.data);
        let request = &Request { data, ..request.clone() };
        let time = found(&file, &request.timing, &words, taken, &mut notes);
        let (time, is_sure) = faults.take(time).unwrap_or_default();
        let used = [time.map(|time| time.column), taken];
        if let Some(question) = unnamed(&file, request, used).filter(|_| named.is_empty()) {
            return Err(question);
        }
        let columns = wanted(&file, request, &words, &named, used, &mut notes)
            .and_then(|columns| few(&file, columns))
            .and_then(|columns| Ok((given(&file, &request.units, &columns)?, columns)));
        // Without a choice of columns, times and units are still examined by one that may be meant.
        let (units, columns) = faults.take(columns).unwrap_or_else(|| {
            let columns = if request.units.is_empty() { likely(&file, used) } else { vec![] };
            let is_refused = |column: &usize| channel(&file, *column, None, request.data()).is_err();
            let examined = columns.iter().copied().find(is_refused).or(columns.first().copied());
            (vec![], examined.into_iter().collect())
        });
        let given = |at: usize| units.get(at).copied().flatten();
        let is_open = |&at: &usize| {
            let stated = file.names().get(columns[at]).and_then(|name| name.unit_of(request.data()));
            given(at).is_none() && stated.is_none()
        };
        // One unit settles all columns without: the first of them asks for it.
        let first_open = (0..columns.len()).find(is_open);
        let read = (0..columns.len()).filter(|at| Some(*at) == first_open || !is_open(at));
        let channels = read.map(|at| channel(&file, columns[at], given(at), request.data()));
        let channels: Vec<Channel> = channels.filter_map(|channel| faults.take(channel)).collect();
        let all = time.iter().map(|time| time.column).chain(columns.iter().copied()).chain(taken);
        let all: Vec<usize> = all.collect();
        if let Some(&twice) = (1..all.len()).find_map(|i| all[..i].contains(&all[i]).then(|| &all[i])) {
            let message = if taken == Some(twice) {
                "the column of the temperature is requested as samples or times too"
            } else if time.is_some_and(|time| time.column == twice) {
                "the column of the time is requested as samples too"
            } else {
                "a column is requested twice"
            };
            faults.add(file.refuse(Some(twice), message, "this column", "name each column once"));
            return Err(faults.into_error(&file.file));
        }
        let is_other =
            |column: &usize| !all.contains(column) && file.names().get(*column).is_some_and(is_temperature);
        let others = if has_thermometers { 0..file.columns() } else { 0..0 };
        let others: Vec<usize> = others.filter(is_other).take(MAX_THERMOMETERS).collect();
        let span = columns.first().filter(|_| request.data() == Data::Increment);
        let span = span.and_then(|&column| span_of(&file, column)).filter(|span| !all.contains(span));
        let rest = time.and_then(|time| time.rest);
        let rest_column = rest.map(|rest| rest.column);
        let is_instance = |column: &usize| {
            let is_called = file.names().get(*column).is_some_and(Name::is_instance);
            is_called && time.is_some() && !all.contains(column) && file.sample(*column).is_some()
        };
        let instances: Vec<usize> = (0..file.columns()).filter(is_instance).collect();
        let read = [&all[..], &others, span.as_slice(), rest_column.as_slice(), &instances].concat();
        let Some(mut samples) = faults.take(file.read(&read, &RULES)) else {
            return Err(faults.into_error(&file.file));
        };
        notes.extend(file.found());
        let numbers = samples.split_off(samples.len() - instances.len());
        let rests = rest.and_then(|rest| Some((rest, samples.pop()?)));
        let mut stamps = time.map(|_| samples.remove(0));
        if let Some((((rest, rests), seconds), time)) = rests.zip(stamps.as_mut()).zip(time) {
            let times = rest.times(seconds, &rests).ok_or_else(|| rest.refused(&file, time.column));
            if let Some((times, what)) = faults.take(times) {
                notes.push(format!("{what} taken from {}", file.title(rest.column)));
                *seconds = times;
            }
        }
        let taking_turns = instances
            .iter()
            .zip(&numbers)
            .find_map(|(&column, numbers)| Some((column, interleaved(stamps.as_deref()?, numbers)?)));
        if let Some((column, sensors)) = taking_turns {
            faults.add(several_sensors(&file, column, &sensors));
            return Err(faults.into_error(&file.file));
        }
        let clock = Clock {
            step_s: request.timing.step_s(&file),
            time,
            is_sure,
            duplicates: request.hints.duplicates,
        };
        let spread = spread(&file, &clock, stamps, samples, &mut notes, &mut faults);
        let (step_s, mut samples) = spread.unwrap_or_default();
        if faults.is_empty() {
            faults.take(file.check_step(step_s, time.map(|time| time.column)));
        }
        if !faults.is_empty() {
            return Err(faults.into_error(&file.file));
        }
        if let Some(stated_s) = file.step_s().filter(|stated_s| (stated_s / step_s - 1.0).abs() > MAX_OFF) {
            let [stated, step] = [stated_s, step_s].map(|step_s| significant(step_s, 6));
            notes.push(format!(
                "the header states steps of {stated} s, but the samples are taken as {step} s apart"
            ));
        }
        if let Some(stated) = file.data().filter(|stated| *stated != request.data()) {
            let [stated, data] = [stated, request.data()].map(Data::name);
            notes.push(format!(
                "the type in the header stands for `data = {stated}`, but the samples are taken as {data}"
            ));
        }
        if let Some(column) = span {
            let spans = samples.pop().unwrap_or_default();
            let channels = 0..channels.len().min(samples.len());
            notes.extend(over_steps(&file, column, &spans, step_s, &mut samples[channels]));
        }
        // They were read behind the samples, so that gaps and duplicates are the same for them.
        let values = samples.split_off(samples.len().saturating_sub(others.len()));
        let thermometers = others.iter().map(|&column| name_of(&file, column)).zip(values).collect();
        let temperature = degree.and_then(|degree| Some(degree.celsius(samples.pop()?)));
        let temperature = taken.map(|column| name_of(&file, column)).zip(temperature);
        let channels = channels.into_iter().zip(samples);
        let mut channels: Vec<Channel> =
            channels.map(|(channel, samples)| Channel { samples, ..channel }).collect();
        // Of columns that nobody named, those of a part that was not measured are not missed.
        if words.is_empty() {
            notes.extend(without_samples(&mut channels));
        }
        Ok(Log {
            file: file.file,
            step_s,
            data: request.data(),
            start_s: 0.0,
            is_compensated: false,
            channels,
            temperature,
            thermometers,
            notes,
        })
    }
}

/// Largest relative deviation of the sampling step from that of the header without a note.
const MAX_OFF: f64 = 0.01;

/// The error for a log whose rows are in turn of several sensors, with their numbers in a column.
fn several_sensors(file: &ColumnFile, column: usize, sensors: &[f64]) -> RecordError {
    let (title, numbers) = (file.title(column), sensors.iter().map(f64::to_string).collect::<Vec<_>>());
    let message =
        format!("the rows are in turn of {} sensors: {title} is {}", sensors.len(), numbers.join(", "));
    let help = format!(
        "write the rows with one number in {title} to a file of its own, and read that; `time = none` takes all rows as one series"
    );
    file.refuse(Some(column), &message, "the number of the sensor", &help)
}

/// Makes increments over shorter times than the sampling step those of whole steps at the same rate, and says so.
fn over_steps(
    file: &ColumnFile,
    column: usize,
    spans: &[f64],
    step_s: f64,
    samples: &mut [Vec<f64>],
) -> Option<String> {
    let mut known: Vec<f64> = spans.iter().copied().filter(|span| *span > 0.0).collect();
    let middle = known.len().checked_sub(1)? / 2;
    let median = *known.select_nth_unstable_by(middle, f64::total_cmp).1;
    let unit = file.names()[column].unit.as_deref().and_then(|unit| unit_of(unit, &[Dimension::Time]).ok());
    let is_within_step = |unit_s: &f64| median * unit_s < (1.0 + NEAR_STEP) * step_s;
    let is_near_step = |unit_s: &f64| is_within_step(unit_s) && step_s < MAX_SPANS * median * unit_s;
    let unit_s = match unit {
        Some((unit_s, _)) => Some(unit_s).filter(is_within_step),
        None => [1.0, 1e-3, 1e-6, 1e-9].into_iter().find(is_near_step),
    };
    let (title, step) = (file.title(column), significant(step_s, 6));
    let Some(unit_s) = unit_s else {
        let fault = if unit.is_some() { "is longer than" } else { "has no unit of time that fits" };
        return Some(format!(
            "{title} {fault} the sampling step of {step} s: increments are taken for those of whole steps"
        ));
    };
    if (median * unit_s / step_s - 1.0).abs() < NEAR_STEP {
        return None;
    }
    for values in samples {
        for (value, &span) in values.iter_mut().zip(spans) {
            *value = if span > 0.0 { *value * step_s / (span * unit_s) } else { f64::NAN };
        }
    }
    let span = significant(median * unit_s, 6);
    Some(format!(
        "by {title}, increments are those of {span} s, but {step} s apart: each is taken for the rate of its whole step"
    ))
}

/// Difference of a span from the sampling step, as a part of it, that is none.
const NEAR_STEP: f64 = 0.01;

/// Most times that a span without a unit goes into the sampling step.
const MAX_SPANS: f64 = 10.0;

/// The given unit of each column, where units are given.
fn given<'a>(
    file: &ColumnFile,
    units: &'a [Unit],
    columns: &[usize],
) -> Result<Vec<Option<&'a Unit>>, RecordError> {
    match units {
        [] => Ok(vec![None; columns.len()]),
        [unit] => Ok(vec![Some(unit); columns.len()]),
        _ if units.len() == columns.len() => Ok(units.iter().map(Some).collect()),
        _ => {
            let message = format!("there are {} units for {} columns", units.len(), columns.len());
            let help = "give one unit for all columns, or one for each in the order of the columns";
            Err(file.refuse(None, &message, "these are the columns", help))
        }
    }
}

/// Removes channels without samples, or with equal ones, unless no others remain, and says which they are.
fn without_samples(channels: &mut Vec<Channel>) -> Option<String> {
    let has_samples = |channel: &Channel| {
        let mut known = channel.samples.iter().filter(|sample| !sample.is_nan());
        let first = known.next();
        known.any(|sample| Some(sample) != first)
    };
    let empty: Vec<&str> = channels
        .iter()
        .filter(|channel| !has_samples(channel))
        .map(|channel| channel.name.as_str())
        .collect();
    let note = format!("columns without samples, or with equal ones, are left out: {}", empty.join(", "));
    let is_some = !empty.is_empty() && empty.len() < channels.len();
    if is_some {
        channels.retain(has_samples);
    }
    is_some.then_some(note)
}

/// A channel for a column, with the `given` unit or that of its header, without its samples.
fn channel(
    file: &ColumnFile,
    column: usize,
    given: Option<&Unit>,
    data: Data,
) -> Result<Channel, RecordError> {
    let name = file.names().get(column);
    let unit_in_header = name.and_then(|name| name.unit_of(data));
    let unit = match (given, &unit_in_header) {
        (Some(unit), _) => unit.clone(),
        (None, Some(text)) => Unit::of_header(text, data)
            .map_err(|wrong| file.refuse(Some(column), &wrong.message, "no such unit", &wrong.help))?,
        (None, None) => {
            let message = format!("the unit of {} is missing", file.title(column));
            let proposed = name.and_then(|name| name.logger).filter(|_| data == Data::Rate).map(|logger| {
                format!("of {logger}, a gyro has `unit = rad/s` and an accelerometer `unit = m/s^2`; ")
            });
            let help = proposed.unwrap_or_default() + &expected(data);
            return Err(file.refuse(Some(column), &message, "no unit", &help));
        }
    };
    let is_unit_guessed = given.is_none() && name.is_some_and(|name| name.unit != unit_in_header);
    let shown = name.map(|name| name.bare.clone()).filter(|name| !name.is_empty());
    let name = shown.unwrap_or_else(|| (column + 1).to_string());
    let (place, field) = (file.place(Some(column)), file.field(column));
    Ok(Channel { name, unit, unit_in_header, is_unit_guessed, samples: vec![], place, field })
}
