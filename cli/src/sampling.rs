//! The options of the commands that sample studies.

use clap::Args;
use sagnac::key::MAX_TRIALS;
use sagnac::study::Study;

use crate::arg_parsers::whole;
use crate::output::Printed;
use crate::progress::{self, How};

#[derive(Debug, Args)]
#[group(skip)]
pub struct Sampling {
    /// Trials at each point, of each candidate or of each evaluation [default: those of the study; of a sensitivity 4096,
    /// or more for few evaluations]
    #[arg(help_heading = "Sampling", long, short = 'n', value_name = "N", value_parser = trials)]
    pub trials: Option<u64>,
    /// Seed, instead of the one in the study
    #[arg(help_heading = "Sampling", long, value_name = "S", value_parser = seed)]
    seed: Option<u64>,
    /// Print the results as JSON: one object, or an array of objects for several studies
    #[arg(help_heading = "Output", long)]
    pub json: bool,
    #[command(flatten)]
    pub printed: Printed,
    #[command(flatten)]
    progress: progress::Options,
}

impl Sampling {
    /// Gives a study the trials and the seed that are asked for.
    pub fn apply(&self, study: &mut Study) {
        study.trials = self.trials.unwrap_or(study.trials);
        study.seed = self.seed.unwrap_or(study.seed);
    }

    /// How progress is shown.
    pub fn how(&self) -> How {
        self.progress.how(self.printed.quiet)
    }
}

/// A number of trials.
fn trials(text: &str) -> Result<u64, String> {
    whole(text, 1..=MAX_TRIALS)
}

/// A seed.
fn seed(text: &str) -> Result<u64, String> {
    whole(text, 0..=i64::MAX.unsigned_abs())
}
