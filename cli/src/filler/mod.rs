//! `sagnac filler`.

pub mod alone;
pub mod options;
pub mod text;

use sagnac::kinds::gap_fill::GapFill;
use std::path::Path;

use sagnac::analysis::firmware::choice::{choose_fillers, choose_point};
use sagnac::analysis::firmware::design::Firmware;
use serde_json::{Value, json};

use crate::charts::write_pictures;
use crate::failure::Failure;
pub use crate::filler::options::Options;
use crate::output::{print, print_json, write};

/// Shows the weights of fillers at one point, and writes what firmware needs.
pub fn filler(options: &Options) -> Result<(), Failure> {
    let source = options.source()?;
    let study = options.study(&source)?;
    let failure = |error| options.failure(&source, error);
    let Some(gap_fill) = study.asked::<GapFill>() else {
        let message = format!(
            "a study of kind = \"{}\" has no fillers\ngive a study of kind = \"gap-fill\"",
            study.kind().name
        );
        return Err(Failure::Usage(message));
    };
    let fillers = choose_fillers(gap_fill, &options.fillers)?;
    let point = choose_point(&study, gap_fill, &options.at, &fillers)?;
    let mut firmware = Firmware::new(&study, point, &fillers).map_err(failure)?;
    if !options.has_tick(&source) {
        firmware.tick_s = None;
    }
    let folder = options.folder(&source);
    write_all(&firmware, &folder, options.test_vectors)?;
    if options.json {
        return print_json(&to_json(&firmware));
    }
    print(&crate::filler::text::of(&firmware))?;
    let vectors = if options.test_vectors.is_some() { ", test vectors" } else { "" };
    say!("weights, response{vectors} and C header are in {}", folder.display());
    Ok(())
}

fn write_all(firmware: &Firmware, folder: &Path, test_vectors: Option<u32>) -> Result<(), Failure> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| Failure::Write { path, source }
    };
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    let mut csv = Vec::new();
    let path = folder.join("weights.csv");
    firmware.write_weights(&mut csv).map_err(failed(&path))?;
    write(&path, &csv)?;
    write(&folder.join("sagnac_filler.h"), firmware.header().as_bytes())?;
    write_pictures(folder, "response", &firmware.response().svg())?;
    let path = folder.join("test_vectors.csv");
    if let Some(count) = test_vectors {
        let mut csv = Vec::new();
        firmware.write_vectors(&firmware.vectors(count as usize), &mut csv).map_err(failed(&path))?;
        write(&path, &csv)?;
    } else if path.exists() {
        // Those of an earlier call may be of other weights.
        std::fs::remove_file(&path).map_err(failed(&path))?;
        say!(
            "note: {} was of an earlier call and is removed; --test-vectors makes them anew",
            path.display()
        );
    }
    Ok(())
}

fn to_json(firmware: &Firmware) -> Value {
    let fillers: Vec<Value> = firmware
        .designs
        .iter()
        .map(|design| {
            let errors: Vec<Value> = design
                .rules()
                .map(|(error, rule, closed)| {
                    let whole = rule.whole();
                    json!({
                        "error": error.name(),
                        "ticks": rule.ticks,
                        "denominator": rule.denominator,
                        "exact": rule.exact,
                        "by_tick": (rule.rows.len() == firmware.gap_ticks as usize).then_some(&rule.rows),
                        "numerators": whole.numerators,
                        "weights": whole.values().collect::<Vec<_>>(),
                        "noise_gain": whole.noise_gain(),
                        "largest_gain": whole.largest_gain(),
                        "largest_input": rule.largest_input(),
                        "amplitude_arcsec": closed.amplitude,
                        "rms_arcsec": closed.rms,
                    })
                })
                .collect();
            json!({ "name": design.name, "method": design.method, "errors": errors })
        })
        .collect();
    let at: serde_json::Map<String, Value> =
        firmware.at.iter().map(|(key, value)| ((*key).to_owned(), json!(value.to_string()))).collect();
    json!({
        "title": firmware.title,
        "at": at,
        "tick_s": firmware.tick_s,
        "gap_ticks": firmware.gap_ticks,
        "fillers": fillers,
        "no_rms_because": firmware.unsampled,
    })
}
