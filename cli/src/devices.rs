//! `sagnac device`: the devices that kernels run on.

use clap::{Args, Subcommand};
use sagnac::device::gpu::adapter::{Adapter, unused_card};
use sagnac::kernel::width::Width;

use crate::bench::bench;
use crate::failure::Failure;
use crate::output::print;
use crate::program::{Bench, Verify};
use crate::verify::verify;

const EXAMPLES: &str = "\
Examples:
  sagnac device list";

const TASKS: &str = "\
Examples:
  sagnac device list
  sagnac device verify --device cpu
  sagnac device bench --device cpu";

#[derive(Debug, Args)]
#[command(after_long_help = TASKS)]
pub struct Command {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// List the devices that kernels can run on
    List(Options),
    /// Verify that every kernel gives the same bits on every device of this machine
    Verify(Verify),
    /// Measure the throughput of the kernels
    Bench(Bench),
}

/// Does what is asked for with the devices.
pub fn device(command: &Command) -> Result<(), Failure> {
    match &command.task {
        Task::List(options) => devices(options),
        Task::Verify(options) => verify(options),
        Task::Bench(options) => bench(options),
    }
}

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Former option: docs/reference/exit-codes.md has a section on GPUs that are not used
    #[arg(long, hide = true)]
    why: bool,
    /// Former option, which printed that as JSON
    #[arg(long, hide = true)]
    json: bool,
}

/// Lists the devices that can run kernels.
pub fn devices(options: &Options) -> Result<(), Failure> {
    if options.why || options.json {
        say!(
            "note: `--why` is gone: \"A GPU that is not used\" in docs/reference/exit-codes.md says what may be missing"
        );
    }
    let widths: Vec<&str> = Width::available().into_iter().map(Width::name).collect();
    print(&format!("cpu: {}", widths.join(", ")))?;
    let adapters = Adapter::all();
    for (at, adapter) in adapters.iter().enumerate() {
        print(&format!("gpu:{at}: {}\n     {}", adapter.name(), adapter.description()))?;
    }
    if adapters.is_empty() {
        say!("no GPU and no software rasterizer was found (Vulkan, Metal, DX12)");
    }
    if let Some(unused) = unused_card(&adapters) {
        say!("{unused}");
    }
    Ok(())
}
