//! `sagnac compare`.

use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::output::{Output, print_documents};
use crate::reading::{Given, Reading};
use clap::Args;
use sagnac::analysis::compare::Stated;
use sagnac::analysis::compare::logs::{Compared, RatioLimit};
use sagnac::analysis::requirement::{Limit, Limited};
use sagnac::record::curve_file::CurveFile;
use sagnac::record::log::Log;
use sagnac::record::log::read::Request;
use sagnac::use_cases::{
    BatchRequest, CompareRequest, LogError, compare_logs, compare_units, three_cornered_hat,
};
use sagnac_engine::key::docs::note;

const EXAMPLES: &str = "\
Examples:
  sagnac compare before.csv after.csv --data rate --unit deg/h --rate 100Hz
  sagnac compare log.csv log.csv --data rate --unit deg/s --rate 100Hz --column gx,gy
  sagnac compare before.csv after.csv --data rate --unit deg/h --rate 100Hz --max-ratio N=1.1
  sagnac compare gyro1.csv gyro2.csv gyro3.csv --unit deg/h --rate 100Hz --column gz \\
    --limit \"N=0.003 deg/sqrt(h)\"
  sagnac compare bench.csv --data rate --unit deg/h --rate 1Hz --column g01,g02,g03,g04
  sagnac compare gyro1.csv gyro2.csv gyro3.csv --unit deg/h --rate 100Hz --column gz --hat
  sagnac compare curve.csv gyro.csv --unit deg/h --rate 100Hz --column gz
  sagnac compare noise.toml gyro.csv --data rate --unit deg/h --rate 100Hz --column gz

Two logs are tested for a difference. A curve (a file with a column tau), or for one of them a noise
file with the numbers of a data sheet, may stand for a log. Three and more logs, or several columns of one, are a batch of
units: its median, the scatter between units, the next unit, and outliers. All logs are read with the
same options, as `sagnac allan` reads them; with time stamps their sampling rates may differ. If
--column names two columns for two logs, each log has its own, in the same order, and so it is with
units and rates.";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    #[command(flatten)]
    given: Given,
    /// Two logs, curves or a noise file; or the logs of a batch of units
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// Largest accepted ratio of a coefficient of two logs, second over first, as in N=1.1; may be repeated
    #[arg(long, value_name = "NAME=RATIO")]
    pub max_ratio: Vec<String>,
    /// Largest accepted value of each unit of a batch, as in "N=0.003 deg/sqrt(h)": of Q, N, B, K, R, markov, sine,
    /// in_run_bias_stability; may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub limit: Vec<String>,
    /// Noise of each of three units that ran together, without their common motion (three-cornered hat)
    #[arg(long, conflicts_with_all = ["limit", "max_ratio", "fit", "fit_from", "fit_to", "force", "detrend"])]
    hat: bool,
    #[command(flatten)]
    pub output: Output,
}

/// Compares two logs, or the units of a batch.
pub fn compare(options: &Options) -> Result<(), Failure> {
    match &options.files[..] {
        _ if options.hat => hat(options),
        [a, b] => pair(options, [a, b].map(PathBuf::as_path)),
        _ if options.max_ratio.is_empty() => batch(options, "batch"),
        _ => Err(Failure::Usage(
            "--max-ratio is for two logs\nlimit the units of a batch by --limit".to_owned(),
        )),
    }
}

/// A side that was read.
enum Read {
    Log(Log),
    Curve(CurveFile),
    Stated(Stated),
}

impl Read {
    fn compared(&self) -> Compared<'_> {
        match self {
            Read::Log(log) => Compared::Log(log),
            Read::Curve(curve) => Compared::Curve(curve),
            Read::Stated(stated) => Compared::Stated(stated),
        }
    }
}

/// Compares two logs, curves, or one of them with a noise file.
fn pair(options: &Options, files: [&Path; 2]) -> Result<(), Failure> {
    // Before 0.3, a limit of two logs was a ratio.
    let is_ratio =
        |text: &&String| text.split_once('=').is_some_and(|(_, value)| value.trim().parse::<f64>().is_ok());
    for former in options.limit.iter().filter(is_ratio) {
        note!("{}", note(&format!("--limit {former}"), &format!("--max-ratio {former}")));
    }
    let limits = options.max_ratio.iter().chain(&options.limit).map(|text| RatioLimit::parse(text));
    let limits = limits.collect::<Result<_, _>>().map_err(LogError::RatioLimit)?;
    let reading = &options.reading;
    let request = CompareRequest { treatment: reading.treatment(), fitting: reading.fitting(), limits };
    request.check()?;
    let sides = sides(reading, files)?;
    if !sides.iter().any(|side| matches!(side, Read::Log(_)))
        && let Some((path, _)) = files.iter().zip(&sides).find(|(_, side)| matches!(side, Read::Curve(_)))
    {
        options.given.check_curve(path)?;
    }
    let outcome = compare_logs([0, 1].map(|i| (files[i], sides[i].compared())), &request)?;
    let [first, second] = files.map(|path| path.file_stem().unwrap_or_default().to_string_lossy());
    let folder = options.output.folder(format!("{first}_vs_{second}"));
    print_documents(options.output.finish(&outcome, &folder, files, &[])?.as_slice(), 1)
}

/// Reads the files, of which each may have its column, unit and rate.
fn sides(reading: &Reading, files: [&Path; 2]) -> Result<[Read; 2], Failure> {
    let is_noise =
        files.map(|path| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")));
    let is_curve = [0, 1].map(|i| !is_noise[i] && reading.has_curve(files[i]));
    // Options of logs are those of the log beside a curve.
    let has_log = (0..2).any(|i| !is_noise[i] && !is_curve[i]);
    let requests = reading.requests_of_two()?;
    let [first, _] = &requests;
    if first.columns.len() > 2 || first.units.len() > 2 {
        let list = if first.columns.len() > 2 {
            "--column names more than two columns"
        } else {
            "there are more than two units"
        };
        return Err(Failure::Usage(format!("{list}\ngive one for each log, as in --column gx,gy")));
    }
    let log = |path: &Path, request: Request, place: usize| -> Result<Read, Failure> {
        let columns = request.columns.get(place).or(request.columns.last()).cloned().into_iter().collect();
        let units = request.units.get(place).or(request.units.last()).cloned().into_iter().collect();
        Ok(Read::Log(reading.read(path, &Request { columns, units, ..request })?))
    };
    let read = |place: usize, request: Request| match (is_noise[place], is_curve[place]) {
        (true, _) => Ok(Read::Stated(Stated::read(files[place])?)),
        (_, true) => Ok(Read::Curve(reading.curve_at(files[place], place, has_log)?)),
        _ => log(files[place], request, place),
    };
    let [of_first, of_second] = requests;
    Ok([read(0, of_first)?, read(1, of_second)?])
}

/// The first file that is a curve.
fn curve_among(options: &Options) -> Option<&Path> {
    options.files.iter().find(|path| options.reading.has_curve(path)).map(PathBuf::as_path)
}

/// Gives the noise of each of three units that ran together.
fn hat(options: &Options) -> Result<(), Failure> {
    let reading = &options.reading;
    if let Some(path) = curve_among(options) {
        options.given.check_curve(path)?;
    }
    let request = reading.request()?;
    let read = |path: &PathBuf| reading.read(path, &request);
    let logs: Vec<Log> = options.files.iter().map(read).collect::<Result<_, _>>()?;
    let logs: Vec<(&Path, &Log)> = options.files.iter().map(PathBuf::as_path).zip(&logs).collect();
    let outcome = three_cornered_hat(&logs, &reading.treatment())?;
    let inputs = options.files.iter().map(PathBuf::as_path);
    let folder = options.output.folder("hat");
    print_documents(options.output.finish(&outcome, &folder, inputs, &[])?.as_slice(), 1)
}

/// Pools the logs of a batch; `name` is that of the results folder.
pub fn batch(options: &Options, name: &str) -> Result<(), Failure> {
    let reading = &options.reading;
    if let Some(path) = curve_among(options) {
        let message = format!(
            "{} is a curve, and a batch is of logs\ncompare it with one log or curve",
            path.display()
        );
        return Err(Failure::Usage(message));
    }
    let limits = options.limit.iter().map(|text| Limit::parse(text, Limited::OF_BATCH));
    let limits = limits.collect::<Result<_, _>>().map_err(LogError::from)?;
    let batch = BatchRequest { fitting: reading.fitting(), limits };
    batch.check()?;
    let (request, treatment) = (reading.request()?, reading.treatment());
    // One after the other, because each may fill the memory.
    let analyze = |path: &PathBuf| -> Result<_, Failure> {
        Ok(batch.analyze(&reading.read(path, &request)?, path, &treatment)?)
    };
    let logs = options.files.iter().map(analyze).collect::<Result<_, _>>()?;
    let (outcome, folder) = (compare_units(logs, &batch)?, options.output.folder(name));
    let inputs = options.files.iter().map(PathBuf::as_path);
    print_documents(options.output.finish(&outcome, &folder, inputs, &[])?.as_slice(), 1)
}
