//! `sagnac compare`.

pub mod report;

use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::analysis::compare::decision::{RatioLimit, check};
use sagnac::analysis::compare::logs::Analysis;
use sagnac::analysis::compare::{figures, notes, tables};
use sagnac::analysis::page::of_comparison;
use sagnac::record::log::channel::Log;
use sagnac::record::log::read::Request;
use sagnac::store::folder::Folder;
use sagnac::view::chart::picture::Picture;

use crate::charts::write_pictures;
use crate::failure::{Failure, in_options};
use crate::output::{Output, print, print_json, whereabouts, write_or_remove, write_page, write_table};
use crate::reading::Reading;
use crate::results::print_decision;

const EXAMPLES: &str = "\
Examples:
  sagnac compare before.csv after.csv --data rate --unit deg/h --rate 100Hz
  sagnac compare gyro1.csv gyro2.csv --data rate --unit rad/s --time stamp --time-unit ns \\
    --column gz
  sagnac compare log.csv log.csv --data rate --unit deg/s --rate 100Hz --column gx,gy
  sagnac compare before.csv after.csv --data rate --unit deg/h --rate 100Hz --limit N=1.1

Both logs are read with the same options, as `sagnac allan` reads them. If --column names two
columns, the first is read from A and the second from B, and so it is with units and rates. If the
logs have time stamps, their sampling rates may differ; the curves are compared at the averaging
times that both have.";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// First log
    #[arg(value_name = "A")]
    a: PathBuf,
    /// Second log, which is compared with the first
    #[arg(value_name = "B")]
    b: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Largest accepted ratio of a coefficient, B over A, which the decision is held against, as in N=1.1: of Q, N, B, K, R, markov,
    /// sine; may be repeated. The coefficients of a log have limits in `sagnac allan`
    #[arg(long, value_name = "NAME=RATIO", value_parser = limit)]
    limit: Vec<RatioLimit>,
    #[command(flatten)]
    output: Output,
}

/// Reads a limit on a ratio.
fn limit(text: &str) -> Result<RatioLimit, String> {
    RatioLimit::parse(text).map_err(|error| error.to_string())
}

/// Compares two logs.
pub fn compare(options: &Options) -> Result<(), Failure> {
    let fitting = options.reading.fitting();
    let terms = fitting.as_ref().map(|fitting| fitting.terms.all());
    check(&options.limit, terms).map_err(|error| Failure::Usage(format!("--limit: {error}")))?;
    let [a, b] = logs(options)?;
    let analysis = analysis(options, [&a, &b])?;
    let decision = analysis.decision(&options.limit);
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let folder = options.output.folder(format!("{}_vs_{}", stem(&options.a), stem(&options.b)));
    let results = Folder::open(&folder)?.reading([options.a.as_path(), options.b.as_path()]);
    save(&analysis, &results)?;
    write_page(&results, &of_comparison([&a, &b], &analysis, &decision))?;
    if options.output.json {
        return print_json(&tables::document(&analysis, &decision));
    }
    if !options.output.quiet {
        notes::notes(&analysis).iter().for_each(|note| note!("{}", in_options(note)));
        print(&report::report(&analysis))?;
        print_decision(&decision)?;
        say!("{}", whereabouts(&folder));
    }
    Ok(())
}

/// Reads the logs.
fn logs(options: &Options) -> Result<[Log; 2], Failure> {
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
    Ok([log(&options.a, a, [0; 2])?, log(&options.b, b, last)?])
}

/// Compares the logs.
fn analysis(options: &Options, [a, b]: [&Log; 2]) -> Result<Analysis, Failure> {
    let (treatment, fitting) = (options.reading.treatment(), options.reading.fitting());
    let logs = [(options.a.as_path(), a), (options.b.as_path(), b)];
    Analysis::of(logs, &treatment, fitting.as_ref()).map_err(|error| Failure::Record(in_options(&error)))
}

/// Writes the tables and the charts. Without coefficients, those of an earlier run are removed.
fn save(analysis: &Analysis, folder: &Folder) -> Result<(), Failure> {
    write_table(folder, "compare.csv", &tables::ratios(analysis))?;
    let coefficients = analysis.rows.is_ok().then(|| tables::coefficients(analysis));
    write_or_remove(folder, "coefficients.csv", coefficients)?;
    write_pictures(folder, "chart-1", &Picture::Curves(figures::curves(analysis)))?;
    write_pictures(folder, "chart-2", &Picture::Curves(figures::ratio(analysis)))
}
