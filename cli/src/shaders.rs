//! `sagnac shaders`: the shaders as files, for a check of any stack of compilers and drivers.

use std::path::PathBuf;

use clap::Args;
use sagnac::store::folder::Folder;
use sagnac::verify::shaders::{DESCRIPTION, PAGE, files};

use crate::failure::Failure;
use crate::output::print;

const EXAMPLES: &str = "\
Examples:
  sagnac shaders shaders-of-sagnac";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Folder for the shaders, their description and the page
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Writes the shaders of all kernels with what is needed to check them without this program.
pub fn shaders(options: &Options) -> Result<(), Failure> {
    let folder = &options.folder;
    let written = Folder::open(folder)?;
    for (name, text) in files() {
        written.write(&name, text.as_bytes())?;
    }
    written.commit()?;
    print(&format!(
        "wrote the shaders and {}\nopen {} in a browser with WebGPU: it runs them and compares all words",
        folder.join(DESCRIPTION).display(),
        folder.join(PAGE).display()
    ))
}
