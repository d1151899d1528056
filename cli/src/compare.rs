//! `sagnac compare`.

use std::path::{Path, PathBuf};

use crate::arg_parsers;
use crate::failure::{Failure, in_options};
use crate::outcome::Outcome;
use crate::output::{Output, print_json};
use crate::reading::Reading;
use clap::Args;
use sagnac::analysis::batch::Batch;
use sagnac::analysis::compare::logs::{Analysis, RatioLimit, check};
use sagnac::analysis::log::{self, Asked};
use sagnac::analysis::page::{of_batch, of_comparison};
use sagnac::analysis::requirement::{Limit, LimitError};
use sagnac::key::docs::note;
use sagnac::progress::Silent;
use sagnac::record::log::Log;
use sagnac::record::log::read::Request;
use sagnac::store::folder::Folder;

const EXAMPLES: &str = "\
Examples:
  sagnac compare before.csv after.csv --data rate --unit deg/h --rate 100Hz
  sagnac compare log.csv log.csv --data rate --unit deg/s --rate 100Hz --column gx,gy
  sagnac compare before.csv after.csv --data rate --unit deg/h --rate 100Hz --max-ratio N=1.1
  sagnac compare gyro1.csv gyro2.csv gyro3.csv --unit deg/h --rate 100Hz --column gz \\
    --limit \"N=0.003 deg/sqrt(h)\"
  sagnac compare bench.csv --data rate --unit deg/h --rate 1Hz --column g01,g02,g03,g04

Two logs are tested for a difference. Three and more logs, or several columns of one, are a batch of
units: its median, the scatter between units, the next unit, and outliers. All logs are read with the
same options, as `sagnac allan` reads them; with time stamps their sampling rates may differ. If
--column names two columns for two logs, each log has its own, in the same order, and so it is with
units and rates.";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Two logs, or the logs of a batch of units
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
    #[command(flatten)]
    pub output: Output,
}

/// Compares two logs, or the units of a batch.
pub fn compare(options: &Options) -> Result<(), Failure> {
    match &options.files[..] {
        [a, b] => pair(options, [a, b]),
        _ if options.max_ratio.is_empty() => batch(options, "batch"),
        _ => Err(Failure::Usage(
            "--max-ratio is for two logs\nlimit the units of a batch by --limit".to_owned(),
        )),
    }
}

/// Compares two logs.
fn pair(options: &Options, files: [&PathBuf; 2]) -> Result<(), Failure> {
    let [first, second] = files;
    let failure = |error: LimitError| Failure::Usage(format!("--max-ratio: {error}"));
    // Before 0.3, a limit of two logs was a ratio.
    let is_ratio =
        |text: &&String| text.split_once('=').is_some_and(|(_, value)| value.trim().parse::<f64>().is_ok());
    for former in options.limit.iter().filter(is_ratio) {
        note!("{}", note(&format!("--limit {former}"), &format!("--max-ratio {former}")));
    }
    let limits = options.max_ratio.iter().chain(&options.limit).map(|text| RatioLimit::parse(text));
    let limits = limits.collect::<Result<Vec<RatioLimit>, _>>().map_err(failure)?;
    let fitting = options.reading.fitting();
    let terms = fitting.as_ref().map(|fitting| fitting.terms.all());
    check(&limits, terms).map_err(failure)?;
    let [a, b] = logs(options, files)?;
    let analysis = analysis(options, files, [&a, &b])?;
    let decision = analysis.decision(&limits);
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let folder = options.output.folder(format!("{}_vs_{}", stem(first), stem(second)));
    let page = of_comparison([&a, &b], &analysis, &decision);
    let [one, other] = &analysis.sides;
    let outcome = Outcome::new(format!("{} · {}", one.heading(), other.heading()), page);
    let results = Folder::open(&folder)?.reading([first.as_path(), second.as_path()]);
    outcome.save(&results, &["coefficients.csv", "limits.csv", "chart-1", "chart-2"])?;
    if options.output.json {
        return print_json(&outcome.document());
    }
    outcome.show(&options.output.printed, &folder)
}

/// Reads the logs.
fn logs(options: &Options, [first, second]: [&PathBuf; 2]) -> Result<[Log; 2], Failure> {
    let reading = &options.reading;
    let [a, b] = reading.requests_of_two()?;
    if a.columns.len() > 2 || a.units.len() > 2 {
        let list = if a.columns.len() > 2 {
            "--column names more than two columns"
        } else {
            "there are more than two units"
        };
        return Err(Failure::Usage(format!("{list}\ngive one for each log, as in --column gx,gy")));
    }
    let last = [a.columns.len(), a.units.len()].map(|count| count.saturating_sub(1));
    let log = |path: &Path, request: Request, [column, unit]: [usize; 2]| -> Result<Log, Failure> {
        let columns = request.columns.get(column).cloned().into_iter().collect();
        let units = request.units.get(unit).cloned().into_iter().collect();
        reading.read(path, &Request { columns, units, ..request })
    };
    Ok([log(first, a, [0; 2])?, log(second, b, last)?])
}

/// Compares the logs.
fn analysis(
    options: &Options,
    [first, second]: [&PathBuf; 2],
    [a, b]: [&Log; 2],
) -> Result<Analysis, Failure> {
    let (treatment, fitting) = (options.reading.treatment(), options.reading.fitting());
    let logs = [(first.as_path(), a), (second.as_path(), b)];
    Analysis::of(logs, &treatment, fitting.as_ref()).map_err(|error| Failure::Record(in_options(&error)))
}

/// Pools the logs of a batch; `name` is that of the results folder.
pub fn batch(options: &Options, name: &str) -> Result<(), Failure> {
    let limits = arg_parsers::of_units(&options.limit)?;
    arg_parsers::agree(&limits, &options.reading)?;
    let batch = analysis_of_batch(options, &limits)?;
    let decision = batch.decision(&limits);
    let folder = options.output.folder(name);
    let logs = match batch.logs.len() {
        1 => "a log".to_owned(),
        count => format!("{count} logs"),
    };
    let heading = format!("{} units of {logs}", batch.labels.len());
    let outcome = Outcome::new(heading, of_batch(&batch, &decision));
    let results = Folder::open(&folder)?.reading(options.files.iter().map(PathBuf::as_path));
    outcome.save(&results, &["limits.csv", "chart-1", "chart-2"])?;
    if options.output.json {
        return print_json(&outcome.document());
    }
    outcome.show(&options.output.printed, &folder)
}

/// Reads and analyses the logs one after the other, because each may fill the memory.
fn analysis_of_batch(options: &Options, limits: &[Limit]) -> Result<Batch, Failure> {
    let reading = &options.reading;
    let (request, treatment) = (reading.request()?, reading.treatment());
    let asked = Asked { fitting: reading.fitting(), simulated: Some(0), ..Asked::default() };
    let of = |path: &PathBuf| -> Result<log::Analysis, Failure> {
        let log = reading.read(path, &request)?;
        arg_parsers::apply(limits, &log)?;
        Ok(log::Analysis::of(&log, path, &treatment, &asked, &Silent)?)
    };
    Ok(Batch::of(options.files.iter().map(of).collect::<Result<_, _>>()?)?)
}
