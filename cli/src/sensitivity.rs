//! `sagnac sensitivity`.

use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::analysis::page;
use sagnac::analysis::sensitivity::report;
use sagnac::analysis::sensitivity::{Request, Sensitivity, SensitivityError, sensitivity as find};
use sagnac::store::folder::Folder;
use sagnac::study::Study;
use sagnac::view::chart::picture::Picture;

use crate::charts::write_pictures;
use crate::failure::{Failure, in_options};
use crate::output::{Printed, print_json, write_page, write_table};
use crate::program::DeviceArg;
use crate::progress::{self, Shown};
use crate::terminal::headed_by;
use crate::{chart, kind, look, whole};

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
    /// Trials of each evaluation of a sampled answer [default: 4096, or more for few evaluations]
    #[arg(help_heading = "Sampling", long, short = 'n', value_name = "N", value_parser = whole::trials)]
    trials: Option<u64>,
    /// Seed, instead of the one in the study
    #[arg(help_heading = "Sampling", long, value_name = "S", value_parser = whole::seed)]
    seed: Option<u64>,
    /// Print the result as JSON
    #[arg(help_heading = "Output", long)]
    json: bool,
    #[command(flatten)]
    printed: Printed,
    #[command(flatten)]
    progress: progress::Options,
}

/// A number of samples.
fn samples(text: &str) -> Result<u64, String> {
    whole::whole(text, 1..=1 << 21)
}

/// Finds and prints what decides the answer.
pub fn sensitivity(options: &Options) -> Result<(), Failure> {
    let mut study = kind::study(&options.study)?;
    study.seed = options.seed.unwrap_or(study.seed);
    let mut device = options.device.select(!options.printed.quiet)?;
    let shown = Shown::new(options.progress.how(options.printed.quiet));
    let asked = Request {
        by: options.by.clone(),
        rows: options.rows.clone(),
        samples: options.samples,
        trials: options.trials,
    };
    let found = find(&study, &asked, &mut device, &shown).map_err(|error| failure(&study, error))?;
    shown.clear();
    let stem = options.study.file_stem().unwrap_or_default();
    let name = match &options.by {
        Some(_) => format!("sensitivity_{}", found.answer.name),
        None => "sensitivity".to_owned(),
    };
    let folder = options.out.clone().unwrap_or_else(|| Path::new("results").join(stem).join(name));
    let picture = write_all(&study, &found, &Folder::open(&folder)?)?;
    if options.json {
        return print_json(&report::json(&study, &found));
    }
    options.printed.show(
        &format!("{} · {}", study.title, report::effort(&found)),
        &found.answer(),
        &found.notes,
        || picture.text(look::of_output()),
        || {
            let (heading, lines) = report::by_input(&found);
            Ok(headed_by(heading, lines.into_iter()))
        },
    )?;
    options.printed.whereabouts(&folder);
    Ok(())
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

fn write_all(study: &Study, found: &Sensitivity, folder: &Folder) -> Result<Picture, Failure> {
    let table = report::table(found);
    write_table(folder, "sensitivity.csv", &table)?;
    let json = serde_json::to_vec_pretty(&report::json(study, found));
    folder.write("sensitivity.json", &json.map_err(|error| Failure::Picture(error.to_string()))?)?;
    let picture = Picture::Curves(report::figure(study, found));
    write_pictures(folder, "sensitivity", &picture)?;
    write_page(folder, &page::of_sensitivity(study, found, &table, picture.clone()))?;
    Ok(picture)
}
