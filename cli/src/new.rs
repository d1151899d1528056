//! `sagnac new`: a study file as a starting point.

use std::io::ErrorKind;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use sagnac::kinds::KINDS;
use sagnac::store::folder::write_new;
use sagnac::study::Kind;

use crate::failure::Failure;
use crate::output::{print, unwritten};
use crate::words::one_of;

const EXAMPLES: &str = "\
Examples:
  sagnac new gap-fill
  sagnac new switched-run my_run.toml";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Kind of the study
    #[arg(value_name = "KIND", value_parser = kinds())]
    kind: &'static Kind,
    /// File to write [default: <KIND>.toml]
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
}

/// The kinds of studies as values of an argument.
fn kinds() -> impl TypedValueParser<Value = &'static Kind> {
    let named = |kind: &Kind| PossibleValue::new(kind.name).help(kind.subject.trim_end_matches('.'));
    one_of(KINDS.map(|kind| (named(kind), kind)))
}

/// Writes a commented study, unless the file exists.
pub fn new(options: &Options) -> Result<(), Failure> {
    let kind = options.kind.name;
    let path = options.file.clone().unwrap_or_else(|| PathBuf::from(format!("{kind}.toml")));
    let written = write_new(&path, |file| file.write_all(options.kind.template.as_bytes()));
    written.map_err(|source| match source.kind() {
        ErrorKind::AlreadyExists => Failure::Usage(format!(
            "{} already exists and was not changed\nname another file: sagnac new {kind} FILE",
            path.display()
        )),
        _ => unwritten(&path)(source),
    })?;
    let path = path.display();
    print(&format!("wrote {path}\nchange it, then run it: sagnac run {path} --plot"))
}
