//! The options of the commands that sample studies.

use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::key::MAX_TRIALS;
use sagnac::outcome::Outcome;
use sagnac::study::Study;

use crate::arg_parsers::whole;
use crate::failure::Failure;
use crate::outcome::finish;
use crate::output::{Printed, print_documents};
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
        self.apply_seed(study);
    }

    /// Gives a study the seed that is asked for.
    pub fn apply_seed(&self, study: &mut Study) {
        study.seed = self.seed.unwrap_or(study.seed);
    }

    /// The folder of results: by default the one called `name` among those of a study.
    pub fn folder(&self, out: Option<&Path>, study: &Path, name: &str) -> PathBuf {
        let of_study = || Path::new("results").join(study.file_stem().unwrap_or_default());
        out.map_or_else(|| of_study().join(name), Path::to_owned)
    }

    /// Writes results into a folder, and prints them.
    ///
    /// # Errors
    /// A file cannot be written, or the output.
    pub fn finish(&self, outcome: &Outcome, folder: &Path) -> Result<(), Failure> {
        let document = finish(outcome, folder, [], &[], self.json, &self.printed)?;
        print_documents(document.as_slice(), 1)
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
