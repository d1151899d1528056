//! `sagnac device verify`.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use sagnac::device::Device;
use sagnac::device::select::{every_adapter, untested};
use sagnac::kernel::width::Width;
use sagnac::verify;
use sagnac::verify::identity::{HEADER, rows};

use crate::failure::Failure;
use crate::output::{print, unwritten};

/// Compares every kernel at every width of the CPU and on the device, or on all adapters.
pub fn verify(options: &crate::program::Verify) -> Result<(), Failure> {
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
    // Opened first, so that a file that cannot be written is reported before minutes of work.
    let report = match &options.report {
        Some(path) => Some((path, opened(path)?)),
        None => None,
    };
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
    if let Some((path, file)) = report {
        add(file, &rows(&devices, options.trials, &verdicts)).map_err(unwritten(path))?;
    }
    if identical { Ok(()) } else { Err(Failure::Different) }
}

/// Opens a report, or begins one.
fn opened(path: &Path) -> Result<File, Failure> {
    let file = File::options().read(true).append(true).create(true).open(path).map_err(unwritten(path))?;
    // What has no end could not be read before more is added.
    match file.metadata().map_err(unwritten(path))?.is_file() {
        true => Ok(file),
        false => Err(Failure::Usage(format!(
            "--report {} is not an ordinary file\nname a file, or one that does not exist yet",
            path.display()
        ))),
    }
}

/// Adds rows to a report; the header comes before the first ones.
fn add(mut file: File, rows: &str) -> io::Result<()> {
    let mut before = String::new();
    file.read_to_string(&mut before)?;
    let header = if before.contains(HEADER) { "" } else { HEADER };
    file.write_all(format!("{header}{rows}").as_bytes())
}
