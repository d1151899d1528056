//! `sagnac sensitivity`.

use std::path::PathBuf;

use clap::Args;
use sagnac::analysis::sensitivity::{SensitivityError, SensitivityRequest, sensitivity as find};
use sagnac::study::Study;

use crate::failure::{Failure, in_options};
use crate::output::spell;
use crate::program::{DeviceArg, Sampling};
use crate::progress::Shown;
use crate::{arg_parsers, chart, reading};

const EXAMPLES: &str = "\
Examples:
  sagnac sensitivity studies/what_decides.toml
  sagnac sensitivity studies/what_decides.toml --by theory_rms --plot
  sagnac sensitivity studies/what_decides.toml --by rms --trials 10000";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Study with uncertain inputs, each a [[sensitivity]] with a range or a distribution
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// Column of points.csv whose value is the answer; one in closed form, such as theory_rms, needs no sampling
    /// [default: the answer by which the study is judged]
    #[arg(long, value_name = "COLUMN")]
    by: Option<String>,
    /// Only rows with this value, as in filler=const; may be repeated
    #[arg(long = "where", value_name = "COLUMN=VALUE", value_parser = chart::row)]
    rows: Vec<(String, String)>,
    #[command(flatten)]
    device: DeviceArg,
    /// Output folder [default: sensitivity in results/<name of the study file>, or sensitivity_<column> with --by]
    #[arg(help_heading = "Output", long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Samples, each with two evaluations and one more for each input; rounded up to 32 times a power of two [default:
    /// 8192 in closed form, else 2048]
    #[arg(help_heading = "Sampling", long, value_name = "N", value_parser = samples)]
    samples: Option<u64>,
    #[command(flatten)]
    sampling: Sampling,
}

/// A number of samples.
fn samples(text: &str) -> Result<u64, String> {
    arg_parsers::whole(text, 1..=1 << 21)
}

/// Finds and prints what decides the answer.
pub fn sensitivity(options: &Options) -> Result<(), Failure> {
    let mut study = reading::study(&options.study)?;
    // The trials are those of an evaluation, not of the study.
    options.sampling.apply_seed(&mut study);
    let mut device = options.device.select(!options.sampling.printed.quiet)?;
    let shown = Shown::new(options.sampling.how());
    let request = SensitivityRequest {
        by: options.by.clone(),
        rows: options.rows.clone(),
        samples: options.samples,
        trials: options.sampling.trials,
    };
    let mut found = find(&study, &request, &mut device, &shown).map_err(|error| failure(&study, error))?;
    shown.clear();
    let folder = options.sampling.folder(options.out.as_deref(), &options.study, &found.name);
    found.add_json("sensitivity.json", &spell);
    options.sampling.finish(&found, &folder)
}

/// An error at the place in the study that caused it.
fn failure(study: &Study, error: SensitivityError) -> Failure {
    match error.in_study(study) {
        Ok(error) => Failure::Study(error),
        Err(SensitivityError::Run(error)) => error.into(),
        Err(error @ (SensitivityError::Column(_) | SensitivityError::SeveralRows(_))) => {
            Failure::Usage(in_options(&error))
        }
        Err(error) => Failure::Record(in_options(&error)),
    }
}
