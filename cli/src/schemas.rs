//! `sagnac schema`: the JSON schemas of study files and of the documents of `--json`.

use clap::Args;
use clap::builder::TypedValueParser;
use sagnac::kinds::keys;

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

/// The documents with their schemas.
fn documents() -> impl TypedValueParser<Value = fn() -> String> {
    macro_rules! shipped {
        ($name:literal) => {
            || include_str!(concat!("../../schema/", $name, ".schema.json")).to_owned()
        };
    }
    one_of::<_, fn() -> String, 11>([
        ("study", keys::schema),
        ("run", shipped!("run")),
        ("merge", shipped!("run")),
        ("design", shipped!("design")),
        ("sensitivity", shipped!("sensitivity")),
        ("filler", shipped!("filler")),
        ("allan", shipped!("allan")),
        ("compare", shipped!("compare")),
        ("lot", shipped!("lot")),
        ("model", shipped!("model")),
        ("bench", shipped!("bench")),
    ])
}

/// Prints a JSON schema.
pub fn schema(options: &Options) -> Result<(), Failure> {
    print(&(options.of)())
}
