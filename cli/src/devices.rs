//! `sagnac devices`.

use clap::Args;
use sagnac::device::gpu::adapter::Adapter;
use sagnac::kernel::width::Width;

use crate::failure::Failure;
use crate::output::print;

/// The command has no options of its own.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  sagnac devices")]
pub struct Options;

/// Lists the devices that can run kernels.
pub fn devices(_: &Options) -> Result<(), Failure> {
    let widths: Vec<&str> = Width::available().into_iter().map(Width::name).collect();
    print(&format!("cpu: {}", widths.join(", ")))?;
    let adapters = Adapter::all();
    for (at, adapter) in adapters.iter().enumerate() {
        print(&format!("gpu:{at}: {}\n     {}", adapter.name(), adapter.description()))?;
    }
    if adapters.is_empty() {
        say!("no GPU and no software rasteriser was found (Vulkan, Metal, DX12)");
    }
    Ok(())
}
