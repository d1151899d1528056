//! The options of `sagnac filler`.

use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::analysis::firmware::design::Firmware;
use sagnac::analysis::firmware::standalone::KINDS;
use sagnac::study::Study;

use crate::failure::Failure;
use crate::filler::alone::Given;
use crate::kind;
use crate::output::Printed;

/// Largest number of test vectors.
const MAX_VECTORS: i64 = 1_000_000;

const EXAMPLES: &str = "\
Examples:
  sagnac filler quadratic --gap-ticks 3
  sagnac filler my.toml --at gap_ticks=3 --filler mv8+2 --test-vectors
  sagnac filler my.toml --at gap_ticks=3 --limit \"residual=20 arcsec\" --latency \"40 ms\"
  sagnac filler minimum-variance --gap-ticks 3 --tick \"5 ms\" --fit-ticks=\"-7..0,n+1,n+2\" \\
    --band \"18 Hz,22 Hz\" --amplitude \"12000 arcsec/s\" --noise \"0.5 arcsec\"
  sagnac filler minimum-variance --gap-ticks 3 --tick \"5 ms\" --limit \"residual=8 arcsec\" \\
    --latency \"20 ms\" --band \"18 Hz,22 Hz\" --amplitude \"12000 arcsec/s\" --noise \"0.5 arcsec\"";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Study file, or without a study one or more of const, linear, quadratic and minimum-variance
    #[arg(required = true, value_name = "STUDY|FILLER")]
    what: Vec<String>,
    /// Value of a swept key that selects the point of the study, such as frequency="20 Hz"; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    at: Vec<String>,
    /// Only this filler of the study; may be repeated
    #[arg(long = "filler", value_name = "NAME")]
    fillers: Vec<String>,
    /// Output folder [default: results/<name of the study file, or of the filler>/filler]
    #[arg(help_heading = "Output", long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Also write test_vectors.csv with this many inputs for each filler and the expected outputs; 1000 if N is left
    /// out
    #[arg(help_heading = "Output", long, value_name = "N", num_args = 0..=1, default_missing_value = "1000",
          value_parser = clap::value_parser!(u32).range(1..=MAX_VECTORS))]
    pub test_vectors: Option<u32>,
    /// Print the weights as JSON
    #[arg(help_heading = "Output", long)]
    pub json: bool,
    #[command(flatten)]
    pub printed: Printed,
    #[command(flatten)]
    alone: Given,
}

impl Options {
    /// The study, the requested fillers at one of its points, and their output folder.
    ///
    /// # Errors
    /// An option does not apply, or the study is invalid; for a study built from the options this is an error of usage.
    pub fn firmware(&self) -> Result<(Study, Firmware, PathBuf), Failure> {
        let file = self.file()?;
        let (study, firmware) = match file {
            Some(file) => self.of_study(kind::study(file)?)?,
            None => self.alone.firmware(&self.what)?,
        };
        Ok((study, firmware, self.folder(file)))
    }

    /// The fillers of a study, or the one that is searched for it.
    fn of_study(&self, study: Study) -> Result<(Study, Firmware), Failure> {
        let Some(asked) = self.alone.asked_of_study()? else {
            let firmware = Firmware::choose(&study, &self.at, &self.fillers)?;
            return Ok((study, firmware));
        };
        if !self.fillers.is_empty() {
            let message = "--limit and --latency search a filler of their own\nleave --filler out";
            return Err(Failure::Usage(message.to_owned()));
        }
        Ok(Firmware::searched(&study, &self.at, asked)?)
    }

    /// The output folder.
    fn folder(&self, file: Option<&Path>) -> PathBuf {
        let stem = match file {
            Some(file) => file.file_stem().map(PathBuf::from).unwrap_or_default(),
            None => PathBuf::from(self.what.join("+")),
        };
        self.out.clone().unwrap_or_else(|| Path::new("results").join(stem).join("filler"))
    }

    /// The study file; `None` where the arguments before the options are kinds of fillers.
    fn file(&self) -> Result<Option<&Path>, Failure> {
        let unknown: Vec<&String> = self.what.iter().filter(|what| !KINDS.contains(&what.as_str())).collect();
        let message = match (&unknown[..], self.alone.given()) {
            ([], _) if !self.at.is_empty() || !self.fillers.is_empty() => {
                "--at and --filler select from a study, but none is given\nleave them out".to_owned()
            }
            ([], _) => return Ok(None),
            ([_], None) if self.what.len() == 1 => return Ok(Some(Path::new(&self.what[0]))),
            ([name, ..], Some(option)) => format!(
                "{option} describes a filler without a study, but `{name}` is not a filler\naccepted: {}; a study says it in \
                 its file",
                KINDS.join(", ")
            ),
            ([name, ..], None) => format!(
                "`{name}` is not a filler\naccepted: one study file, or one or more of {}",
                KINDS.join(", ")
            ),
        };
        Err(Failure::Usage(message))
    }
}
