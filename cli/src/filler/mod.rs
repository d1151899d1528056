//! `sagnac filler`.

pub mod alone;
pub mod options;

use sagnac::analysis::page::of_filler;
use sagnac::store::folder::Folder;

use crate::failure::Failure;
pub use crate::filler::options::Options;
use crate::outcome::Outcome;
use crate::output::{print_json, unwritten};

/// The files of the command.
const NAMES: [&str; 7] =
    ["fillers.csv", "weights.csv", "trade.csv", "test_vectors.csv", "sagnac_filler.h", "response", "trade"];

/// Shows the weights of fillers at one point, and writes the files for firmware.
pub fn filler(options: &Options) -> Result<(), Failure> {
    let (study, firmware, folder) = options.firmware()?;
    let results = Folder::open(&folder)?;
    let mut outcome = Outcome::new(firmware.heading(), of_filler(&study, &firmware));
    let header = "sagnac_filler.h";
    outcome.files.push((header.to_owned(), firmware.header().into_bytes()));
    outcome.places.push(format!("C header  {}", folder.join(header).display()));
    if let Some(count) = options.test_vectors {
        let (mut csv, name) = (Vec::new(), "test_vectors.csv");
        let vectors = firmware.vectors(count as usize);
        firmware.write_vectors(&vectors, &mut csv).map_err(unwritten(&folder.join(name)))?;
        outcome.files.push((name.to_owned(), csv));
    }
    // Vectors of an earlier call are removed, because they may belong to other weights.
    outcome.save(&results, &NAMES)?;
    if options.json {
        return print_json(&outcome.document());
    }
    outcome.show(&options.printed, &folder)
}
