//! `sagnac filler`.

pub mod alone;
pub mod options;
pub mod text;

use std::path::Path;

use sagnac::analysis::firmware::design::Firmware;
use sagnac::analysis::firmware::search::Trade;
use sagnac::analysis::page;
use sagnac::view::chart::picture::Picture;
use sagnac::view::report::FILE as REPORT;

use crate::charts::{write_figures, write_pictures};
use crate::failure::Failure;
pub use crate::filler::options::Options;
use crate::output::{
    make_folder, print, print_json, remove, unwritten, write, write_or_remove, write_page, write_table,
};

/// Shows the weights of fillers at one point, and writes the files for firmware.
pub fn filler(options: &Options) -> Result<(), Failure> {
    let (study, firmware, folder) = options.firmware()?;
    write_all(&firmware, &folder, options.test_vectors)?;
    write_page(&folder, &page::of_filler(&study, &firmware))?;
    if options.json {
        return print_json(&firmware.document());
    }
    print(&crate::filler::text::of(&firmware))?;
    let vectors = if options.test_vectors.is_some() { ", test vectors" } else { "" };
    say!(
        "weights, response{vectors} and C header are in {}; the page is {}",
        folder.display(),
        folder.join(REPORT).display()
    );
    Ok(())
}

fn write_all(firmware: &Firmware, folder: &Path, test_vectors: Option<u32>) -> Result<(), Failure> {
    make_folder(folder)?;
    write_table(&folder.join("weights.csv"), &firmware.weights())?;
    write_or_remove(&folder.join("trade.csv"), firmware.trade.as_ref().map(Trade::table))?;
    write(&folder.join("sagnac_filler.h"), firmware.header().as_bytes())?;
    write_pictures(folder, "response", &Picture::Curves(firmware.response()))?;
    write_figures(folder, &[("trade".to_owned(), firmware.trade.as_ref().map(Trade::figure))])?;
    let path = folder.join("test_vectors.csv");
    if let Some(count) = test_vectors {
        let mut csv = Vec::new();
        firmware.write_vectors(&firmware.vectors(count as usize), &mut csv).map_err(unwritten(&path))?;
        write(&path, &csv)?;
    } else if remove(&path)? {
        // Existing vectors may belong to other weights.
        note!("removed {} of an earlier call; --test-vectors writes a new one", path.display());
    }
    Ok(())
}
