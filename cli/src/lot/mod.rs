//! `sagnac lot`.

pub mod report;

use std::path::PathBuf;

use clap::Args;
use sagnac::analysis::log::{self, Asked};
use sagnac::analysis::lot::words::notes;
use sagnac::analysis::lot::{Lot, figures, tables};
use sagnac::analysis::page::of_lot;
use sagnac::analysis::requirement::Limit;
use sagnac::progress::Silent;
use sagnac::store::folder::Folder;
use sagnac::view::chart::picture::Picture;

use crate::charts::write_pictures;
use crate::failure::{Failure, in_options};
use crate::limits;
use crate::output::{Output, print, print_json, whereabouts, write_page, write_table};
use crate::reading::Reading;
use crate::results::print_decision;

const EXAMPLES: &str = "\
Examples:
  sagnac lot gyro1.csv gyro2.csv gyro3.csv --data rate --unit deg/h --rate 100Hz --column gz
  sagnac lot bench.csv --data rate --unit deg/h --rate 1Hz --column g01,g02,g03,g04
  sagnac lot gyro1.csv gyro2.csv gyro3.csv --data rate --unit deg/h --rate 100Hz --column gz \\
    --limit \"N=0.003 deg/sqrt(h)\"

Every column of every log is a unit of the lot. All logs are read with the same options, as
`sagnac allan` reads them; with time stamps their sampling rates may differ.";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Recorded logs, whose columns are the units of the lot
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Largest accepted value of every unit, which the decision is held against, as in "N=0.003 deg/sqrt(h)": of Q, N, B, K, R,
    /// markov, sine, in_run_stability; in the unit of gyros or of accelerometers; may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = limits::of_lot)]
    limit: Vec<Limit>,
    #[command(flatten)]
    output: Output,
}

/// Pools the logs of a lot.
pub fn lot(options: &Options) -> Result<(), Failure> {
    limits::agree(&options.limit, &options.reading)?;
    let lot = analysis(options)?;
    let decision = lot.decision(&options.limit);
    let folder = options.output.folder("lot");
    let results = Folder::open(&folder)?.reading(options.files.iter().map(PathBuf::as_path));
    save(&lot, &results)?;
    write_page(&results, &of_lot(&lot, &decision))?;
    if options.output.json {
        return print_json(&tables::document(&lot, &decision));
    }
    if !options.output.quiet {
        notes(&lot).iter().for_each(|note| note!("{}", in_options(note)));
        print(&report::report(&lot))?;
        print_decision(&decision)?;
        say!("{}", whereabouts(&folder));
    }
    Ok(())
}

/// Reads and analyses the logs one after the other, because each may fill the memory.
fn analysis(options: &Options) -> Result<Lot, Failure> {
    let reading = &options.reading;
    let (request, treatment) = (reading.request()?, reading.treatment());
    let asked = Asked { fitting: reading.fitting(), simulated: Some(0), ..Asked::default() };
    let of = |path: &PathBuf| -> Result<log::Analysis, Failure> {
        let log = reading.read(path, &request)?;
        limits::apply(&options.limit, &log)?;
        Ok(log::Analysis::of(&log, path, &treatment, &asked, &Silent)?)
    };
    Ok(Lot::of(options.files.iter().map(of).collect::<Result<_, _>>()?)?)
}

/// Writes the tables and the charts.
fn save(lot: &Lot, folder: &Folder) -> Result<(), Failure> {
    write_table(folder, "units.csv", &tables::units(lot))?;
    write_table(folder, "lot.csv", &tables::lot(lot))?;
    write_pictures(folder, "chart-1", &Picture::Curves(figures::curves(lot)))?;
    let coefficients = figures::coefficients(lot).map(Picture::Curves);
    coefficients.iter().try_for_each(|figure| write_pictures(folder, "chart-2", figure))
}
