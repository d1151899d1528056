//! `sagnac device verify`.

use sagnac::device::Device;
use sagnac::device::select::{every_adapter, untested};
use sagnac::kernel::width::Width;
use sagnac::verify::{self, digest};

use crate::failure::Failure;
use crate::output::print;

/// Compares every kernel at every width of the CPU and on the device, or on all adapters.
pub fn verify(options: &crate::program::Verify) -> Result<(), Failure> {
    if options.report.is_some() {
        let gone = "--report is gone\nsend what `sagnac device list` and `sagnac device verify` print";
        return Err(Failure::Usage(gone.to_owned()));
    }
    let mut devices = match &options.device {
        Some(name) => untested(name)?.device.into_devices(),
        None => every_adapter()?,
    };
    let widths = Width::available().into_iter().map(|width| format!("CPU ({})", width.name()));
    let mut names: Vec<String> = widths.collect();
    names.extend(devices.iter().filter(|device| matches!(device, Device::Gpu(_))).map(Device::name));
    say!("comparing: {}", names.join(", "));
    if !devices.iter().any(|device| matches!(device, Device::Gpu(_))) {
        say!("no GPU adapter: only the CPU kernels were verified");
    }
    let mut verdicts = Vec::new();
    let mut printed = Ok(());
    let identical = verify::verify(&mut devices, options.trials, |verdict| {
        let line = if verdict.differences.is_empty() {
            format!("identical {} {:016x}", verdict.kernel, verdict.digest)
        } else {
            format!("DIFFERENT {} on {}", verdict.kernel, verdict.differences.join(", "))
        };
        if printed.is_ok() {
            printed = print(&line);
        }
        verdicts.push(verdict.clone());
    })?;
    printed?;
    print(&format!("digest of all kernels {:016x}", digest(&verdicts)))?;
    if identical { Ok(()) } else { Err(Failure::Different) }
}
