//! The options of `sagnac filler`.

use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::analysis::firmware::alone::KINDS;
use sagnac::source::diagnose::StudyError;
use sagnac::study::Study;

use crate::failure::Failure;
use crate::filler::alone::Given;

/// Largest number of test vectors.
const MOST_VECTORS: i64 = 1_000_000;

const EXAMPLES: &str = "\
Examples:
  sagnac filler quadratic --gap-ticks 3
  sagnac filler my.toml --at gap_ticks=3 --filler mv8+2 --test-vectors
  sagnac filler minimum-variance --gap-ticks 3 --tick \"5 ms\" --fit-ticks=\"-7..0,n+1,n+2\" \\
    --band \"18 Hz,22 Hz\" --amplitude \"12000 arcsec/s\" --noise \"0.5 arcsec\"";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Study file, or without a study one or more of const, linear, quadratic and minimum-variance
    #[arg(required = true, value_name = "STUDY|FILLER")]
    what: Vec<String>,
    /// Value of a swept key that selects the point of the study, such as frequency="20 Hz"; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub at: Vec<String>,
    /// Only this filler of the study; may be repeated
    #[arg(long = "filler", value_name = "NAME")]
    pub fillers: Vec<String>,
    /// Output folder [default: results/<name of the study file, or of the filler>/filler]
    #[arg(help_heading = "Output", long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Also write test_vectors.csv with this many inputs for each filler and the expected outputs; 1000 if N is left
    /// out
    #[arg(help_heading = "Output", long, value_name = "N", num_args = 0..=1, default_missing_value = "1000",
          value_parser = clap::value_parser!(u32).range(1..=MOST_VECTORS))]
    pub test_vectors: Option<u32>,
    /// Print the weights as JSON
    #[arg(help_heading = "Output", long)]
    pub json: bool,
    #[command(flatten)]
    alone: Given,
}

/// Origin of the fillers.
pub enum Source {
    File(PathBuf),
    /// Kinds of fillers.
    Kinds(Vec<String>),
}

impl Options {
    /// The arguments before the options: a study file, or kinds of fillers.
    ///
    /// # Errors
    /// The arguments are neither, or an option does not apply to them.
    pub fn source(&self) -> Result<Source, Failure> {
        let unknown: Vec<&String> = self.what.iter().filter(|what| !KINDS.contains(&what.as_str())).collect();
        let given = self.alone.given();
        let usage = |message: String| Err(Failure::Usage(message));
        match (&unknown[..], given) {
            ([], _) if !self.at.is_empty() || !self.fillers.is_empty() => {
                usage("--at and --filler select from a study, but none is given\nleave them out".to_owned())
            }
            ([], _) => Ok(Source::Kinds(self.what.clone())),
            ([file], None) if self.what.len() == 1 => Ok(Source::File(PathBuf::from(file))),
            ([name, ..], Some(option)) => usage(format!(
                "{option} describes a filler without a study, but `{name}` is not a filler\naccepted: {}; a study says it in \
                 its file",
                KINDS.join(", ")
            )),
            ([name, ..], None) => usage(format!(
                "`{name}` is not a filler\naccepted: one study file, or one or more of {}",
                KINDS.join(", ")
            )),
        }
    }

    /// The study of a file, or one built from the options.
    ///
    /// # Errors
    /// The study is invalid; for a study built from the options this is an error of usage.
    pub fn study(&self, source: &Source) -> Result<Study, Failure> {
        match source {
            Source::File(file) => Ok(Study::read(file)?),
            Source::Kinds(kinds) => {
                let text = self.alone.study(kinds)?;
                Study::parse("options", &text).map_err(|error| self.failure(source, error))
            }
        }
    }

    /// The failure for an error in a study; for a study built from the options it is stated in their terms.
    pub fn failure(&self, source: &Source, error: StudyError) -> Failure {
        match source {
            Source::File(_) => error.into(),
            Source::Kinds(_) => self.alone.failure(&error),
        }
    }

    /// Whether the length of a tick is known; polynomials do not need it.
    pub fn has_tick(&self, source: &Source) -> bool {
        matches!(source, Source::File(_)) || self.alone.tick.is_some()
    }

    /// The output folder.
    pub fn folder(&self, source: &Source) -> PathBuf {
        let stem = match source {
            Source::File(file) => file.file_stem().map(PathBuf::from).unwrap_or_default(),
            Source::Kinds(kinds) => PathBuf::from(kinds.join("+")),
        };
        let default = || Path::new("results").join(stem).join("filler");
        self.out.clone().unwrap_or_else(default)
    }
}
