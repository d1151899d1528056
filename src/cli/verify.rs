//! `sagnac verify`.

use sagnac::backend::select;
use sagnac::verify;

use super::Failure;
use super::output::print;

/// Compares every kernel on every width of the CPU and on the device.
pub fn verify(options: &super::Verify) -> Result<(), Failure> {
    let mut selection = select(&options.device.name)?;
    eprintln!("device: {}, {}", selection.device.name(), selection.reason);
    let mut printed = Ok(());
    let identical = verify::verify(&mut selection.device, options.trials, |verdict| {
        let line = if verdict.differences.is_empty() {
            format!("identical {} {:016x}", verdict.kernel, verdict.digest)
        } else {
            format!("DIFFERENT {} on {}", verdict.kernel, verdict.differences.join(", "))
        };
        if printed.is_ok() {
            printed = print(&line);
        }
    })?;
    printed?;
    if identical { Ok(()) } else { Err(Failure::Different) }
}
