//! `sagnac devices`.

use clap::Args;
use sagnac::device::gpu::adapter::Adapter;
use sagnac::device::gpu::diagnosis::Finding;
use sagnac::kernel::width::Width;
use sagnac::verify::diagnose;
use serde_json::json;

use crate::failure::{Failure, in_options};
use crate::output::{print, print_json};

const EXAMPLES: &str = "\
Examples:
  sagnac devices
  sagnac devices --why";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Explain why each GPU can be used or not, and what to do: open and test all adapters, and look for missing
    /// drivers, libraries and permissions
    #[arg(long)]
    why: bool,
    /// Print the explanations as JSON
    #[arg(long, requires = "why")]
    json: bool,
}

/// Lists the devices that can run kernels, or explains which cannot.
pub fn devices(options: &Options) -> Result<(), Failure> {
    if options.why {
        return why(options.json);
    }
    let widths: Vec<&str> = Width::available().into_iter().map(Width::name).collect();
    print(&format!("cpu: {}", widths.join(", ")))?;
    let adapters = Adapter::all();
    for (at, adapter) in adapters.iter().enumerate() {
        print(&format!("gpu:{at}: {}\n     {}", adapter.name(), adapter.description()))?;
    }
    if adapters.is_empty() {
        say!(
            "no GPU and no software rasteriser was found (Vulkan, Metal, DX12); `sagnac devices --why` explains"
        );
    }
    Ok(())
}

fn why(as_json: bool) -> Result<(), Failure> {
    let findings =
        diagnose().into_iter().map(|Finding { found, remedy }| (in_options(&found), in_options(&remedy)));
    if as_json {
        let findings = findings.map(|(found, remedy)| json!({ "found": found, "remedy": remedy }));
        return print_json(&findings.collect::<Vec<_>>());
    }
    for (found, remedy) in findings {
        print(&format!("{found}\n     {remedy}"))?;
    }
    Ok(())
}
