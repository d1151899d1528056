//! `sagnac filler`.

pub mod alone;
pub mod options;
pub mod text;

use sagnac::analysis::firmware::design::Firmware;
use sagnac::analysis::firmware::search::Trade;
use sagnac::analysis::page;
use sagnac::store::folder::Folder;
use sagnac::view::chart::picture::Picture;

use crate::charts::{write_figures, write_pictures};
use crate::failure::Failure;
pub use crate::filler::options::Options;
use crate::look;
use crate::output::{print_json, unwritten, write_or_remove, write_page, write_table};

/// Shows the weights of fillers at one point, and writes the files for firmware.
pub fn filler(options: &Options) -> Result<(), Failure> {
    let (study, firmware, folder) = options.firmware()?;
    let results = Folder::open(&folder)?;
    write_all(&firmware, &results, options.test_vectors)?;
    write_page(&results, &page::of_filler(&study, &firmware))?;
    if options.json {
        return print_json(&firmware.document());
    }
    options.printed.show(
        &text::heading(&firmware),
        &firmware.answer(),
        &[],
        || Picture::Curves(firmware.response()).text(look::of_output()),
        || Ok(text::of(&firmware)),
    )?;
    if !options.printed.quiet {
        say!("C header  {}", folder.join("sagnac_filler.h").display());
    }
    options.printed.whereabouts(&folder);
    Ok(())
}

fn write_all(firmware: &Firmware, folder: &Folder, test_vectors: Option<u32>) -> Result<(), Failure> {
    write_table(folder, "weights.csv", &firmware.weights())?;
    write_or_remove(folder, "trade.csv", firmware.trade.as_ref().map(Trade::table))?;
    folder.write("sagnac_filler.h", firmware.header().as_bytes())?;
    write_pictures(folder, "response", &Picture::Curves(firmware.response()))?;
    write_figures(folder, &[("trade".to_owned(), firmware.trade.as_ref().map(Trade::figure))])?;
    let name = "test_vectors.csv";
    let path = folder.path().join(name);
    if let Some(count) = test_vectors {
        let mut csv = Vec::new();
        firmware.write_vectors(&firmware.vectors(count as usize), &mut csv).map_err(unwritten(&path))?;
        folder.write(name, &csv)?;
    } else if folder.remove(name)? {
        // Existing vectors may belong to other weights.
        note!("removed {} of an earlier call; --test-vectors writes a new one", path.display());
    }
    Ok(())
}
