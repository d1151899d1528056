//! `sagnac design`.

pub mod report;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use sagnac::analysis::design::{Design, DesignError, Measure, design as find};
use sagnac::device::select::{Selection, select};
use sagnac::study::Study;
use sagnac::table::Table;
use sagnac::view::chart::figure::Figure;
use sagnac::view::chart::scale::Scale;
use sagnac::view::chart::spec::Spec;

use crate::charts::write_pictures;
use crate::failure::Failure;
use crate::output::{print, print_json, write};
use crate::program::DeviceArg;
use crate::progress::{self, Shown};
use crate::{look, whole};
use sagnac::quantity::number::short;

const EXAMPLES: &str = "\
Examples:
  sagnac design studies/design_point.toml
  sagnac design studies/design_point.toml --by drift_rms --trials 10000 --plot";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Study of kind = "switched-run": its intervals are tried, or without a sweep over them such as suit the run
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// What is to be least
    #[arg(long, value_enum, value_name = "ESTIMATE", default_value = "drift_q9973")]
    by: By,
    #[command(flatten)]
    device: DeviceArg,
    /// Folder of what is written [default: results/<name of the study file>/design; by others than drift_q9973 design_<estimate>]
    #[arg(help_heading = "Output", long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Runs of each candidate, in place of the study's; rounded up to 32 times a power of two
    #[arg(help_heading = "Sampling", long, value_name = "N", value_parser = whole::trials, allow_negative_numbers = true)]
    trials: Option<u64>,
    /// Seed, in place of the study's
    #[arg(help_heading = "Sampling", long, value_name = "S", value_parser = whole::seed, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Print the recommendation as JSON
    #[arg(help_heading = "Output", long)]
    json: bool,
    /// Also draw the drift over the interval as text
    #[arg(help_heading = "Output", long, conflicts_with_all = ["json", "quiet"])]
    plot: bool,
    #[command(flatten)]
    progress: progress::Options,
    /// Print only errors and the recommendation
    #[arg(help_heading = "Output", long, short)]
    quiet: bool,
}

/// As options call what is to be least.
#[derive(Debug, Clone, Copy, ValueEnum)]
#[value(rename_all = "snake_case")]
enum By {
    /// The drift that 99.73 % of runs stay below
    #[value(name = "drift_q9973")]
    DriftQ9973,
    /// The rms drift
    DriftRms,
    /// The largest angle over the run time, that 99.73 % of runs stay below
    #[value(name = "largest_q9973")]
    LargestQ9973,
    /// The rms of the largest angle over the run time
    LargestRms,
}

impl By {
    /// Where results go: another estimate takes nothing away.
    fn folder(self) -> String {
        match self.measure() {
            Measure::DriftQ9973 => "design".to_owned(),
            other => format!("design_{}", other.name()),
        }
    }

    fn measure(self) -> Measure {
        match self {
            By::DriftQ9973 => Measure::DriftQ9973,
            By::DriftRms => Measure::DriftRms,
            By::LargestQ9973 => Measure::LargestQ9973,
            By::LargestRms => Measure::LargestRms,
        }
    }
}

/// Finds the best interval and filler, and says so.
pub fn design(options: &Options) -> Result<(), Failure> {
    let mut study = Study::read(&options.study)?;
    study.trials = options.trials.unwrap_or(study.trials);
    study.seed = options.seed.unwrap_or(study.seed);
    let Selection { mut device, reason } = select(&options.device.name, options.device.threads.unwrap_or(0))?;
    if !options.quiet {
        say!("device: {}, {reason}", device.name());
    }
    let shown = Shown::new(options.progress.how(options.quiet));
    let found =
        find(&study, options.by.measure(), &mut device, &shown).map_err(|error| failure(&study, error))?;
    shown.clear();
    let stem = options.study.file_stem().unwrap_or_default();
    let folder =
        options.out.clone().unwrap_or_else(|| Path::new("results").join(stem).join(options.by.folder()));
    let table = crate::design::report::table(&found);
    let figure = write_all(&study, &found, &table, &folder)?;
    if options.json {
        return print_json(&crate::design::report::json(&study, &found));
    }
    if !options.quiet {
        for note in &found.notes {
            say!("note: {note}");
        }
        if options.plot {
            print(&format!("{}\n", figure.text(look::of_output())))?;
        }
        print(&crate::design::report::summary(&found, &table))?;
    }
    print(&crate::design::report::recommendation(&found))?;
    if !options.quiet {
        say!(
            "{} runs at each interval; table and chart are in {}",
            short(found.trials as f64),
            folder.display()
        );
    }
    Ok(())
}

/// An error of the design at the place in the study that caused it.
fn failure(study: &Study, error: DesignError) -> Failure {
    let at =
        |key: &str, help: &str| Failure::Study(study.error_at(study.place_of(key), error.to_string(), help));
    match &error {
        DesignError::Kind { .. } => at("kind", "give a study of kind = \"switched-run\""),
        DesignError::Swept { key } => at(key, "give one value, or make a study of each"),
        DesignError::Nothing => at("drift", "give drift.magnetic, and fillers or drift.residual_max"),
        DesignError::NoCandidate { .. } => {
            at("run.duration", "lengthen the run, or sweep switching.interval")
        }
        DesignError::TooFew { .. } => at("trials", "take more: 100_000 are usual"),
        DesignError::Lower(lower) => at(lower.key(), lower.help()),
        DesignError::Gpu(error) => Failure::Gpu(error.clone()),
    }
}

fn write_all(study: &Study, found: &Design, table: &Table, folder: &Path) -> Result<Figure, Failure> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| Failure::Write { path, source }
    };
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    let (path, mut csv) = (folder.join("design.csv"), Vec::new());
    table.write_csv(&mut csv).map_err(failed(&path))?;
    write(&path, &csv)?;
    let json = serde_json::to_vec_pretty(&crate::design::report::json(study, found));
    write(&folder.join("design.json"), &json.map_err(|error| Failure::Picture(error.to_string()))?)?;
    let spec = Spec {
        title: study.title.clone(),
        subtitle: Some(crate::design::report::headline(found)),
        x: "interval".to_owned(),
        y: found.measure.name().to_owned(),
        x_scale: Scale::Log,
        y_scale: Scale::Log,
        series: if found.fillers.len() > 1 { vec!["filler".to_owned()] } else { vec![] },
        apart: vec!["filler".to_owned()],
        filter: vec![],
        limit: None,
        laws: vec![],
        points: "Monte Carlo".to_owned(),
        bands: "95 % band".to_owned(),
    };
    let (figure, _) =
        Figure::from_table(table, &spec).map_err(|error| Failure::Picture(error.to_string()))?;
    write_pictures(folder, "design", &figure.svg())?;
    Ok(figure)
}
