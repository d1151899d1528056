//! What `check.mjs` calls in WebAssembly: the identity of all kernels, and the table of a study.

use std::slice;

use sagnac_base::progress::Silent;
use sagnac_engine::device::{Cpu, Device};
use sagnac_engine::run::{Budget, Plan, Worker};
use sagnac_engine::store::{Provenance, Store};
use sagnac_engine::study::Study;
use sagnac_engine::tally::Share;
use sagnac_engine::verify;
use sagnac_kernel::width::Width;

/// Room for the text of a study.
#[unsafe(no_mangle)]
pub extern "C" fn reserve(length: usize) -> *mut u8 {
    vec![0_u8; length].leak().as_mut_ptr()
}

/// The digest of `verify` with `units` of work per kernel; 0 where two widths differ.
#[unsafe(no_mangle)]
pub extern "C" fn digest(units: u32) -> u64 {
    let mut verdicts = vec![];
    let identical = verify::verify(&mut [], units.into(), |verdict| verdicts.push(verdict.clone()));
    if identical.is_ok_and(|identical| identical) { verify::digest(&verdicts) } else { 0 }
}

/// The points of a study as CSV, or an error: the address in the upper half and the length in the lower one.
///
/// # Safety
/// `text` points to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn points(text: *const u8, length: usize, trials: u32) -> u64 {
    // SAFETY: the caller promises it.
    let text = unsafe { slice::from_raw_parts(text, length) };
    let csv = points_of(&String::from_utf8_lossy(text), trials.into()).unwrap_or_else(String::into_bytes);
    let csv = csv.leak();
    (csv.as_ptr() as u64) << 32 | csv.len() as u64
}

fn points_of(text: &str, trials: u64) -> Result<Vec<u8>, String> {
    let mut study = Study::parse("study.toml", text).map_err(|error| format!("{error:?}"))?;
    study.trials = trials;
    let plan = Plan::new(&study).map_err(|error| format!("{error:?}"))?;
    let mut store = Store::in_memory(&plan.identity());
    let cpu = Cpu::new(Width::PORTABLE, 1).map_err(|error| error.to_string())?;
    // A page takes the steps of a run by itself.
    let mut device = Device::Cpu(cpu);
    let mut worker = Worker::new(&mut device, &Silent);
    let mut steps = plan.steps(&store, Share::WHOLE).map_err(|error| error.to_string())?;
    let (budget, mut trials) = (Budget { steps: 1 << 20, records: 1 }, 0);
    loop {
        while let Some(batch) = steps.next(budget).map_err(|error| format!("{error:?}"))? {
            let results = batch.make(&mut worker, &|_| ()).map_err(|error| error.to_string())?;
            trials += batch.trials();
            let made = Provenance { device: "WebAssembly".to_owned(), trials, seconds: 0.0 };
            batch.put(results, &mut store, &made).map_err(|error| error.to_string())?;
        }
        if !steps.more(&store).map_err(|error| error.to_string())? {
            break;
        }
    }
    plan.keep(&mut store, Share::WHOLE).map_err(|error| error.to_string())?;
    let tables = plan.tables(&store, &Silent).map_err(|error| error.to_string())?;
    let mut csv = vec![];
    tables.points.write_csv(&mut csv).map_err(|error| error.to_string())?;
    Ok(csv)
}
