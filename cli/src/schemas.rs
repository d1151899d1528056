//! `sagnac schema`: the JSON schemas of study files and of the documents of `--json`.

use clap::Args;
use clap::builder::TypedValueParser;
use sagnac::kinds;

use crate::failure::Failure;
use crate::output::print;
use crate::words::one_of;

const EXAMPLES: &str = "\
Examples:
  sagnac schema > study.schema.json
  sagnac schema run";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Documents to describe: study files, or the output of a command with --json
    #[arg(value_name = "OF", value_parser = documents(), default_value = "study")]
    of: fn() -> String,
}

/// The documents with their schemas. All commands with results print documents of one form.
fn documents() -> impl TypedValueParser<Value = fn() -> String> {
    fn document() -> String {
        include_str!("../../schema/document.schema.json").to_owned()
    }
    one_of::<_, fn() -> String, 11>([
        ("study", kinds::schema),
        ("run", document),
        ("merge", document),
        ("design", document),
        ("sensitivity", document),
        ("filler", document),
        ("allan", document),
        ("compare", document),
        ("lot", document),
        ("model", document),
        ("bench", || include_str!("../../schema/bench.schema.json").to_owned()),
    ])
}

/// Prints a JSON schema.
pub fn schema(options: &Options) -> Result<(), Failure> {
    print(&(options.of)())
}
