//! `sagnac compare`.

pub mod options;
pub mod report;

use std::path::{Path, PathBuf};

use sagnac::analysis::compare::logs::{Analysis, CompareError};
use sagnac::analysis::compare::{figures, tables};
use sagnac::record::log::channel::Log;
use sagnac::record::log::read::Request;
use sagnac::view::chart::picture::Picture;

use crate::charts::write_pictures;
pub use crate::compare::options::Options;
use crate::failure::Failure;
use crate::output::{print, print_json, write_table};

/// Compares two logs.
pub fn compare(options: &Options) -> Result<(), Failure> {
    let analysis = analysis(options)?;
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let default = || Path::new("results").join(format!("{}_vs_{}", stem(&options.a), stem(&options.b)));
    let folder: PathBuf = options.out.clone().unwrap_or_else(default);
    save(&analysis, &folder)?;
    if options.json {
        print_json(&tables::document(&analysis))
    } else if !options.quiet {
        crate::compare::report::notes(&analysis).iter().for_each(|note| say!("note: {note}"));
        print(&crate::compare::report::report(&analysis))?;
        say!("results are in {}", folder.display());
        Ok(())
    } else {
        Ok(())
    }
}

/// Reads and compares the logs.
fn analysis(options: &Options) -> Result<Analysis, Failure> {
    let reading = &options.reading;
    let (request, treatment, columns) = (reading.request()?, reading.treatment(), reading.columns());
    if columns.len() > 2 {
        let message = "--column names more than two columns\ngive one for each log, as in --column gx,gy";
        return Err(Failure::Usage(message.to_owned()));
    }
    let log = |path: &Path, column: Option<&String>| -> Result<Log, Failure> {
        let request = Request { columns: column.cloned().into_iter().collect(), ..request.clone() };
        Ok(treatment.read(path, &request)?)
    };
    let (a, b) = (log(&options.a, columns.first())?, log(&options.b, columns.last())?);
    let logs = [(options.a.as_path(), &a), (options.b.as_path(), &b)];
    Analysis::of(logs, &treatment, reading.terms().as_ref()).map_err(|error| match &error {
        CompareError::Units { .. } => Failure::Record(format!("{error} with --unit")),
        CompareError::NoCommonTime(_) => Failure::Record(error.to_string()),
    })
}

/// Writes the tables and the charts.
fn save(analysis: &Analysis, folder: &Path) -> Result<(), Failure> {
    write_table(&folder.join("compare.csv"), &tables::ratios(analysis))?;
    write_table(&folder.join("coefficients.csv"), &tables::coefficients(analysis))?;
    write_pictures(folder, "chart-1", &Picture::Curves(figures::curves(analysis)))?;
    write_pictures(folder, "chart-2", &Picture::Curves(figures::ratio(analysis)))
}
