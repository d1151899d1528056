//! Options for reading recorded logs, common to all commands on logs, and those of them that a curve does not have.

use std::path::Path;

use crate::arg_parsers::{list_of, one_of, value_of};
use crate::failure::{Failure, in_options};
use crate::reading;
use clap::builder::TypedValueParser;
use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, Error, FromArgMatches, Id};
use sagnac::allan::angles::Trend;
use sagnac::analysis::log::{ENDINGS, Treatment};
use sagnac::analysis::temperature::{Effects, Temperature};
use sagnac::fit::selection::{Fitting, Terms};
use sagnac::record::binary::Binary;
use sagnac::record::curve_file::{CurveFile, CurveRequest, Errors};
use sagnac::record::layout::Decimal;
use sagnac::record::log::measure::{Data, Unit, UnitCheck, UnitMismatch};
use sagnac::record::log::read::{Duplicates, Hints, Request, Timing, step_of};
use sagnac::record::log::{Log, Thermometer};
use sagnac::study::Study;
use sagnac::theory::allan::terms::Term;
use sagnac_base::diagnostics::StudyError;
use sagnac_base::quantity::Dimension;

#[derive(Debug, Args)]
pub struct Reading {
    /// Kind of the numbers: rate or acceleration, angle or velocity gained in each sample (increment), or angle (phase) or velocity
    /// since the start
    #[arg(help_heading = "Reading the log", long, value_name = "KIND", value_parser = data())]
    data: Option<Data>,
    /// Unit of the numbers, as in deg/h, deg/s, rad/s, arcsec, m/s^2, g, mg; none for plain numbers; one for all columns, or
    /// one for each, separated by commas [default: that of the header]
    #[arg(
        help_heading = "Reading the log",
        long,
        value_name = "UNITS",
        value_delimiter = ',',
        conflicts_with = "scale"
    )]
    unit: Vec<String>,
    /// Size of a pulse, if the numbers count pulses; one for all columns, or one for each
    #[arg(help_heading = "Reading the log", long, value_name = "SIZES/pulse", value_delimiter = ',')]
    scale: Vec<String>,
    /// Sampling rate or step, as in 100Hz or "300 s"; time stamps then only show where samples are missing, and may be late
    #[arg(help_heading = "Reading the log", long, value_name = "RATE", value_delimiter = ',')]
    rate: Vec<String>,
    /// Column of time stamps, by name or number; none ignores stamps [default: a column called time, stamp or t]
    #[arg(help_heading = "Reading the log", long, value_name = "COLUMN")]
    time: Option<String>,
    /// Unit of the time stamps: s, ms, us, ns [default: that of the header, or of times since 1970]
    #[arg(help_heading = "Reading the log", long, value_name = "UNIT")]
    time_unit: Option<String>,
    /// Rows with the time of the row before, but other numbers: use the first or the last of them, or keep each as a sample
    #[arg(help_heading = "Reading the log", long, value_name = "WHICH", value_parser = duplicates())]
    duplicates: Option<Duplicates>,
    /// Sign before decimals in a text [default: found from the first lines]
    #[arg(help_heading = "Reading the log", long, value_name = "SIGN", value_parser = decimal())]
    decimal: Option<Decimal>,
    /// Layout of a raw binary file, as in "f64 x7, little, time 1, rate 3": types of the columns, order of bytes, names
    #[arg(help_heading = "Reading the log", long, value_name = "LAYOUT", value_parser = Binary::parse)]
    binary: Option<Binary>,
    /// Columns by name or number from 1, separated by commas, as in gx,gz or 2-4; all [default: the only one, or all whose units fit
    /// --data]
    #[arg(help_heading = "Reading the log", long, value_name = "COLUMNS", value_delimiter = ',')]
    column: Vec<String>,
    /// Omit the beginning, as in "30 min"
    #[arg(long, value_name = "TIME", default_value = "0 s", value_parser = seconds)]
    skip: f64,
    /// Omit everything later than this time after the start of the file
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    until: Option<f64>,
    /// Remove a straight line from the rate or acceleration; this also removes the ramp R and makes K too low
    #[arg(help_heading = "Reading the log", long, value_name = "TREND", default_value = "none", value_parser = trend())]
    detrend: Trend,
    /// Treat outliers as gaps: samples more than 8 standard deviations from the median of their neighbours
    #[arg(long)]
    remove_outliers: bool,
    /// Remove what the record holds besides noise, as it is listed: noise bursts, spikes, steps, slow sines, warm-ups, the effect of
    /// temperature, lines of the spectrum
    #[arg(long)]
    remove_events: bool,
    /// Whether to note rates and accelerations that seem to be in another unit; see docs/reference/log-formats.md
    #[arg(help_heading = "Reading the log", long, value_name = "SWITCH", default_value = "on", value_parser = unit_check())]
    unit_check: UnitCheck,
    /// Coefficients to fit: auto (those of Q, N, B, K, R that the record supports), none, or a list of Q, N, B, K, R,
    /// markov, sine
    #[arg(help_heading = "Reading the log", long, value_name = "TERMS", default_value = "auto", value_parser = fit_terms)]
    fit: Fitted,
    /// Shortest averaging time of the fit, as in "0.5 s" [default: the shortest from which the terms describe the curve]
    #[arg(help_heading = "Reading the log", long, value_name = "TIME", value_parser = seconds)]
    fit_from: Option<f64>,
    /// Longest averaging time of the fit [default: an eighth of the record]
    #[arg(help_heading = "Reading the log", long, value_name = "TIME", value_parser = seconds)]
    fit_to: Option<f64>,
    /// Take the coefficients of the best fit even where it does not describe the curve; their verdict stays *model rejected*
    #[arg(help_heading = "Reading the log", long)]
    force: bool,
    /// 95 % interval of points of a curve, as in 10%, or length of its record, as in "9 h" with --rate [default: the file's]
    #[arg(help_heading = "Reading the log", long, value_name = "PERCENT|TIME", value_parser = errors)]
    curve_interval: Option<Errors>,
    /// Column of a temperature, by name or number, on which the rate depends: `sagnac allan` reports the dependence, other commands
    /// need --compensate with it
    #[arg(help_heading = "Temperature", long, value_name = "COLUMN")]
    temperature: Option<String>,
    /// Unit of the temperature: °C (degC, C), K, °F (degF, F) [default: that of the header, or °C]
    #[arg(help_heading = "Temperature", long, value_name = "UNIT", requires = "temperature")]
    temperature_unit: Option<String>,
    /// Terms of the dependence: auto (T, and those of the others that the record needs), or a list of T, T2, dT, warm-up, aging
    #[arg(help_heading = "Temperature", long, value_name = "TERMS", default_value = "auto", requires = "temperature", value_parser = Effects::parse)]
    pub temperature_terms: Effects,
    /// Compute all results from the record without the fitted dependence; a column without one stays as it is, and a note says why
    #[arg(help_heading = "Temperature", long, requires = "temperature")]
    pub compensate: bool,
}

/// Value of `--fit`.
#[derive(Debug, Clone, PartialEq)]
enum Fitted {
    None,
    Auto,
    Given(Vec<Term>),
}

fn data() -> impl TypedValueParser<Value = Data> {
    one_of(Data::ALL.map(|data| (data.name(), data)))
}

fn duplicates() -> impl TypedValueParser<Value = Duplicates> {
    one_of([("first", Duplicates::First), ("last", Duplicates::Last), ("keep", Duplicates::Keep)])
}

fn decimal() -> impl TypedValueParser<Value = Decimal> {
    one_of([("point", Decimal::Point), ("comma", Decimal::Comma)])
}

fn trend() -> impl TypedValueParser<Value = Trend> {
    one_of([("none", Trend::None), ("linear", Trend::Linear)])
}

fn unit_check() -> impl TypedValueParser<Value = UnitCheck> {
    one_of([("on", UnitCheck::On), ("off", UnitCheck::Off)])
}

/// Errors of the points of a curve: half an interval, or the length of a record.
fn errors(text: &str) -> Result<Errors, String> {
    if let Some(percent) = text.trim().strip_suffix('%') {
        let percent: Option<f64> = percent.trim().parse().ok();
        let percent = percent.filter(|percent| *percent > 0.0 && *percent <= 100.0);
        return percent
            .map(|percent| Errors::Part(0.01 * percent))
            .ok_or_else(|| "not between 0 and 100 %".to_owned());
    }
    let length_s = seconds(text).map_err(|error| format!("{error}; write as in 10% or \"9 h\""))?;
    if length_s > 0.0 { Ok(Errors::Record(length_s)) } else { Err("the record has no length".to_owned()) }
}

fn fit_terms(text: &str) -> Result<Fitted, String> {
    match text {
        "none" => Ok(Fitted::None),
        "auto" => Ok(Fitted::Auto),
        list => list_of(list, &Term::ALL, Term::symbol, "auto, none").map(Fitted::Given),
    }
}

impl Reading {
    /// The fit, if any. A removed trend includes the ramp.
    pub fn fitting(&self) -> Option<Fitting> {
        let terms = match &self.fit {
            Fitted::None => return None,
            Fitted::Given(terms) => Terms::Given(terms.clone()),
            Fitted::Auto => Terms::of_model(self.detrend),
        };
        Some(Fitting { terms, from_s: self.fit_from, to_s: self.fit_to, is_forced: self.force })
    }

    /// The request for each file.
    ///
    /// # Errors
    /// The kind of the numbers is missing, a unit, scale or rate is invalid, there are several rates, or stamps are ignored without a rate.
    pub fn request(&self) -> Result<Request, Failure> {
        match &self.rate[..] {
            [] => self.request_at(None),
            [rate] => self.request_at(Some(rate)),
            _ => Err(Failure::Usage("--rate has several values\ngive one, for all logs".to_owned())),
        }
    }

    /// The requests for two files, which may have a rate each.
    ///
    /// # Errors
    /// The errors are those of [`Reading::request`], but only more than two rates are too many.
    pub fn requests_of_two(&self) -> Result<[Request; 2], Failure> {
        match &self.rate[..] {
            [a, b] => Ok([self.request_at(Some(a))?, self.request_at(Some(b))?]),
            _ => self.request().map(|request| [request.clone(), request]),
        }
    }

    /// The failure for a unit that does not fit; of an angle without its kind, that this is missing.
    fn refused_unit(&self, wrong: &UnitMismatch) -> Failure {
        let is_angle = |unit: &&String| Unit::of_header(unit, Data::Increment).is_ok();
        match self.unit.iter().chain(&self.scale).find(is_angle).filter(|_| self.data.is_none()) {
            Some(unit) => Failure::Usage(format!(
                "\"{unit}\" is a unit of angles or velocities\nadd --data increment, if each number is what one sample gained, or \
                 --data angle"
            )),
            None => Failure::Usage(in_options(&format!("{}\n{}", wrong.message, wrong.help))),
        }
    }

    /// The request for a file with this rate.
    fn request_at(&self, rate: Option<&String>) -> Result<Request, Failure> {
        // A unit that is given is that of a rate unless the kind is given too.
        let is_open = self.unit.is_empty() && self.scale.is_empty();
        let data = self.data.unwrap_or(Data::Rate);
        // Only one of the two lists can be given.
        let units = self.unit.iter().map(|unit| Unit::parse(unit, data));
        let scales = self.scale.iter().map(|scale| Unit::parse_scale(scale, data));
        let units = units
            .chain(scales)
            .collect::<Result<Vec<Unit>, _>>()
            .map_err(|wrong| self.refused_unit(&wrong))?;
        let step_s = rate.map(|rate| step(rate)).transpose()?;
        let timing = Timing::new(step_s, self.time.clone(), self.time_unit.clone())
            .map_err(|message| Failure::Usage(in_options(&message)))?;
        let (decimal, duplicates, binary) = (self.decimal, self.duplicates, self.binary.clone());
        let hints = Hints { decimal, duplicates, binary };
        let unit = self.temperature_unit.clone();
        let temperature = self.temperature.clone().map(|column| Thermometer { column, unit });
        let data = self.data.or((!is_open).then_some(data));
        Ok(Request { columns: self.column.clone(), timing, data, units, temperature, hints })
    }

    /// The treatment of each log before its analysis.
    pub fn treatment(&self) -> Treatment {
        Treatment {
            skip_s: self.skip,
            until_s: self.until,
            trend: self.detrend,
            outliers_removed: self.remove_outliers,
            events_removed: self.remove_events,
            unit_check: self.unit_check,
            is_compensated: false,
        }
    }

    /// Reads a log for its analysis, without its dependence on the temperature if that is to be compensated.
    ///
    /// # Errors
    /// The log is refused, or a temperature is given that is not to be compensated.
    pub fn read(&self, path: &Path, request: &Request) -> Result<Log, Failure> {
        if self.temperature.is_some() && !self.compensate {
            let message = "--temperature without --compensate changes no result of this command\ngive --compensate too, or see \
                           the dependence with sagnac allan";
            return Err(Failure::Usage(message.to_owned()));
        }
        let mut log = self.read_as_recorded(path, request)?;
        let temperature = Temperature::noted(&mut log, &self.treatment(), &self.temperature_terms);
        Ok(match temperature {
            Some(temperature) => temperature.compensated(&log),
            None => log,
        })
    }

    /// Whether a file is a curve: by its content, unless that is given as binary.
    pub fn has_curve(&self, path: &Path) -> bool {
        self.binary.is_none() && CurveFile::is_one(path)
    }

    /// Reads the curve at `path`, if the file is one. Its intervals have this probability if the file does not state it.
    ///
    /// # Errors
    /// The curve is refused.
    pub fn curve(&self, path: &Path, confidence: Option<f64>) -> Result<Option<CurveFile>, Failure> {
        if !self.has_curve(path) {
            return Ok(None);
        }
        let lists = [("--column", &self.column), ("--unit", &self.unit), ("--rate", &self.rate)];
        if let Some((list, _)) = lists.iter().find(|(_, values)| values.len() > 1) {
            let message = format!("{list} has several values, and {} is one curve\ngive one", path.display());
            return Err(Failure::Usage(message));
        }
        self.curve_with(path, confidence, lists.map(|(_, values)| values.first())).map(Some)
    }

    /// Reads the curve at `path`, which stands at this place of two sides. A single column or rate is that of a log beside it, and so is
    /// a single unit unless the curve has none.
    ///
    /// # Errors
    /// The curve is refused.
    pub fn curve_at(&self, path: &Path, place: usize, is_beside_log: bool) -> Result<CurveFile, Failure> {
        let of = |list: &Vec<String>| list.get(place).or(list.last()).cloned();
        let own = |list: &Vec<String>| of(list).filter(|_| !is_beside_log || list.len() > 1);
        let [column, unit, rate] = [&self.column, &self.unit, &self.rate].map(own);
        let with =
            |unit: Option<&String>| self.curve_with(path, None, [column.as_ref(), unit, rate.as_ref()]);
        with(unit.as_ref()).or_else(|_| with(of(&self.unit).as_ref()))
    }

    fn curve_with(
        &self,
        path: &Path,
        confidence: Option<f64>,
        [column, unit, rate]: [Option<&String>; 3],
    ) -> Result<CurveFile, Failure> {
        let request = CurveRequest {
            column: column.cloned(),
            unit: unit.cloned(),
            time_unit: self.time_unit.clone(),
            confidence,
            errors: self.curve_interval,
            step_s: rate.map(|rate| step(rate)).transpose()?,
        };
        Ok(CurveFile::read(path, &request)?)
    }

    /// Reads a log as it was recorded.
    ///
    /// # Errors
    /// The log is refused.
    pub fn read_as_recorded(&self, path: &Path, request: &Request) -> Result<Log, Failure> {
        reading::log(path)?;
        Ok(self.treatment().read(path, request)?)
    }
}

/// The sampling interval for a rate, s.
fn step(rate: &str) -> Result<f64, Failure> {
    let wrong = |why: String| {
        Failure::Usage(format!(
            "--rate {rate}: {why}\ngive samples per second, as in --rate 100Hz, or the time between them"
        ))
    };
    step_of(rate).map_err(wrong)
}

pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let seconds = value_of(text, Dimension::Time)?;
    if seconds >= 0.0 { Ok(seconds) } else { Err("a time before the start of the file".to_owned()) }
}

/// The ending of the name of a file, in lower case.
fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// Reads a study.
///
/// # Errors
/// The file is a recorded log by its name, cannot be read, or is no valid study.
pub fn study(path: &Path) -> Result<Study, Failure> {
    if ENDINGS.contains(&ending(path).as_str()) {
        let path = path.display();
        let message = format!("{path} is a log, not a study\nanalyze it with `sagnac allan {path}`");
        return Err(Failure::Usage(message));
    }
    Study::read(path).map_err(|error: StudyError| error.into())
}

/// Checks that a file is not a study by its name.
///
/// # Errors
/// It is one.
pub fn log(path: &Path) -> Result<(), Failure> {
    if ending(path) == "toml" {
        let path = path.display();
        let message = format!(
            "{path} is a study or a noise file, not a log\nrun a study with `sagnac run {path}`; a noise file is for sagnac model and simulate"
        );
        return Err(Failure::Usage(message));
    }
    Ok(())
}

const RANGE: &str = "set the range of the fit by --fit-from and --fit-to";
const LEAVE_OUT: &str = "leave it out";

/// The options that need a log, by their names with underscores, with what to do for a curve.
const OF_LOGS: [(&str, &str); 28] = [
    ("bootstrap", LEAVE_OUT),
    ("compensate", LEAVE_OUT),
    (
        "data",
        "a curve is of deviations of the rate, whose unit is given by --unit; if the file is a log, rename its column of `tau`",
    ),
    ("decimal", LEAVE_OUT),
    ("detrend", "give the terms of the fit without R, as in --fit Q,N,B,K"),
    ("deviation", "choose the column of an Allan deviation by --column"),
    ("duplicates", LEAVE_OUT),
    ("dynamic", LEAVE_OUT),
    ("hat", "give logs of three units"),
    ("intervals", "give the errors of the points by --curve-interval"),
    ("navigate", LEAVE_OUT),
    ("no_psd", LEAVE_OUT),
    ("position_limit", LEAVE_OUT),
    ("record", LEAVE_OUT),
    ("remove_events", LEAVE_OUT),
    ("remove_outliers", LEAVE_OUT),
    ("scale", "give the unit of the deviations by --unit"),
    ("segment", LEAVE_OUT),
    ("segment_detrend", LEAVE_OUT),
    ("skip", RANGE),
    ("tau", RANGE),
    ("temperature", LEAVE_OUT),
    ("temperature_terms", LEAVE_OUT),
    ("temperature_unit", LEAVE_OUT),
    (
        "time",
        "its averaging times are its column of `tau`, whose unit is given by --time-unit; if the file is a log, rename that column",
    ),
    ("unit_check", LEAVE_OUT),
    ("until", RANGE),
    // Of `model`; that of `allan` is the probability of intervals in a file that does not state it.
    ("band_confidence", "its band is that of the 95 % intervals of its points: leave it out"),
];

/// The options on the command line; a struct of options has it first, because others take theirs away.
#[derive(Debug, Clone, Default)]
pub struct Given(Vec<String>);

impl Given {
    /// Checks that no option needs a log where there is only a curve at `path`.
    ///
    /// # Errors
    /// One does, and the message names it and says what to do.
    pub fn check_curve(&self, path: &Path) -> Result<(), Failure> {
        let is_given = |(name, _): &&(&str, &str)| self.0.iter().any(|given| given == name);
        let Some((name, advice)) = OF_LOGS.iter().find(is_given) else { return Ok(()) };
        let option = name.trim_start_matches("band_").replace('_', "-");
        let message = format!("--{option} needs a log, and {} is a curve\n{advice}", path.display());
        Err(Failure::Usage(message))
    }
}

impl FromArgMatches for Given {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Given, Error> {
        let is_given = |id: &&Id| matches.value_source(id.as_str()) == Some(ValueSource::CommandLine);
        Ok(Given(matches.ids().filter(is_given).map(ToString::to_string).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Given::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for Given {
    fn augment_args(command: Command) -> Command {
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        command
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The options that a curve has, and the one that makes its file a log.
    const OF_CURVES: [&str; 29] = [
        "binary",
        "column",
        "confidence",
        "curve_interval",
        "files",
        "file",
        "fit",
        "fit_from",
        "fit_to",
        "filter_rate",
        "force",
        "from",
        "json",
        "kalibr",
        "limit",
        "margin",
        "max_ratio",
        "out",
        "overbound",
        "quantization",
        "quiet",
        "rate",
        "states",
        "time_unit",
        "to",
        "unit",
        "verbose",
        "write",
        "table",
    ];

    #[test]
    fn every_option_of_logs_is_of_curves_too_or_refused() {
        let command = crate::program::command();
        for name in ["allan", "compare", "model"] {
            let command = command.find_subcommand(name).unwrap();
            for argument in command.get_arguments() {
                let id = argument.get_id().as_str();
                let is_output = argument.get_help_heading() == Some("Output") && id != "record";
                let is_refused = OF_LOGS.iter().any(|(other, _)| *other == id);
                let is_known = OF_CURVES.contains(&id) || is_output;
                assert!(
                    is_refused != is_known,
                    "{name}: {id} is refused of a curve: {is_refused}, and known: {is_known}"
                );
            }
        }
    }
}
