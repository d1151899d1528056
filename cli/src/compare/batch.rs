//! `sagnac compare` of a batch of units.

use std::path::PathBuf;

use sagnac::analysis::log::{self, Asked};
use sagnac::analysis::lot::answer::notes;
use sagnac::analysis::lot::{Lot, figures, tables};
use sagnac::analysis::page::of_lot;
use sagnac::analysis::requirement::Limit;
use sagnac::progress::Silent;
use sagnac::store::folder::Folder;
use sagnac::view::chart::picture::Picture;

use crate::charts::write_pictures;
use crate::compare::{Options, units};
use crate::failure::Failure;
use crate::limits;
use crate::look;
use crate::output::{print_json, write_page, write_table};

/// Pools the logs of a batch; `name` is that of the results folder.
pub fn batch(options: &Options, name: &str) -> Result<(), Failure> {
    let limits = limits::of_units(&options.limit)?;
    limits::agree(&limits, &options.reading)?;
    let lot = analysis(options, &limits)?;
    let decision = lot.decision(&limits);
    let folder = options.output.folder(name);
    let results = Folder::open(&folder)?.reading(options.files.iter().map(PathBuf::as_path));
    save(&lot, &results)?;
    write_page(&results, &of_lot(&lot, &decision))?;
    if options.output.json {
        return print_json(&tables::document(&lot, &decision));
    }
    let logs = match lot.logs.len() {
        1 => "a log".to_owned(),
        count => format!("{count} logs"),
    };
    let heading = format!("{} units of {logs}", lot.labels.len());
    options.output.printed.show(
        &heading,
        &decision.answer,
        &notes(&lot),
        || Picture::Curves(figures::curves(&lot)).text(look::of_output()),
        || Ok(units::report(&lot)),
    )?;
    options.output.whereabouts(&folder);
    Ok(())
}

/// Reads and analyses the logs one after the other, because each may fill the memory.
fn analysis(options: &Options, limits: &[Limit]) -> Result<Lot, Failure> {
    let reading = &options.reading;
    let (request, treatment) = (reading.request()?, reading.treatment());
    let asked = Asked { fitting: reading.fitting(), simulated: Some(0), ..Asked::default() };
    let of = |path: &PathBuf| -> Result<log::Analysis, Failure> {
        let log = reading.read(path, &request)?;
        limits::apply(limits, &log)?;
        Ok(log::Analysis::of(&log, path, &treatment, &asked, &Silent)?)
    };
    Ok(Lot::of(options.files.iter().map(of).collect::<Result<_, _>>()?)?)
}

/// Writes the tables and the charts.
fn save(lot: &Lot, folder: &Folder) -> Result<(), Failure> {
    write_table(folder, "units.csv", &tables::units(lot))?;
    write_table(folder, "batch.csv", &tables::lot(lot))?;
    write_pictures(folder, "chart-1", &Picture::Curves(figures::curves(lot)))?;
    let coefficients = figures::coefficients(lot).map(Picture::Curves);
    coefficients.iter().try_for_each(|figure| write_pictures(folder, "chart-2", figure))
}
