//! `sagnac compare` of a batch of units.

use std::path::PathBuf;

use sagnac::analysis::batch::Batch;
use sagnac::analysis::log::{self, Asked};
use sagnac::analysis::page::of_batch;
use sagnac::analysis::requirement::Limit;
use sagnac::progress::Silent;
use sagnac::store::folder::Folder;

use crate::compare::Options;
use crate::failure::Failure;
use crate::limits;
use crate::outcome::Outcome;
use crate::output::print_json;

/// Pools the logs of a batch; `name` is that of the results folder.
pub fn batch(options: &Options, name: &str) -> Result<(), Failure> {
    let limits = limits::of_units(&options.limit)?;
    limits::agree(&limits, &options.reading)?;
    let batch = analysis(options, &limits)?;
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
fn analysis(options: &Options, limits: &[Limit]) -> Result<Batch, Failure> {
    let reading = &options.reading;
    let (request, treatment) = (reading.request()?, reading.treatment());
    let asked = Asked { fitting: reading.fitting(), simulated: Some(0), ..Asked::default() };
    let of = |path: &PathBuf| -> Result<log::Analysis, Failure> {
        let log = reading.read(path, &request)?;
        limits::apply(limits, &log)?;
        Ok(log::Analysis::of(&log, path, &treatment, &asked, &Silent)?)
    };
    Ok(Batch::of(options.files.iter().map(of).collect::<Result<_, _>>()?)?)
}
