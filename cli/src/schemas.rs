//! `sagnac schema`: the JSON schemas of study files and of the documents of `--json`.

use clap::{Args, ValueEnum};
use sagnac::kinds::keys;

use crate::failure::Failure;
use crate::output::print;

const EXAMPLES: &str = "\
Examples:
  sagnac schema > study.schema.json
  sagnac schema run";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Documents to describe: study files, or the output of a command with --json
    #[arg(value_name = "OF", value_enum, default_value = "study")]
    of: Document,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Document {
    Study,
    Run,
    Merge,
    Design,
    Filler,
    Allan,
    Compare,
    Bench,
}

/// Prints a JSON schema.
pub fn schema(options: &Options) -> Result<(), Failure> {
    match options.of {
        Document::Study => print(&keys::schema()),
        Document::Run | Document::Merge => print(include_str!("../../schema/run.schema.json")),
        Document::Design => print(include_str!("../../schema/design.schema.json")),
        Document::Filler => print(include_str!("../../schema/filler.schema.json")),
        Document::Allan => print(include_str!("../../schema/allan.schema.json")),
        Document::Compare => print(include_str!("../../schema/compare.schema.json")),
        Document::Bench => print(include_str!("../../schema/bench.schema.json")),
    }
}
