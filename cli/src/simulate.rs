//! `sagnac simulate`.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::TypedValueParser;
use sagnac::record::log::read::step_of;
use sagnac::run::write_inputs;
use sagnac::store::folder::Folder;
use sagnac::study::Study;
use sagnac::use_cases::{Form, Numbers, SimulateError, Simulation};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::short;
use sagnac_base::quantity::{Dimension, parse};
use sagnac_base::text_file::{MAX_TOML, read_text};
use sagnac_engine::key::MAX_TRIALS;

use crate::arg_parsers::{one_of, whole};
use crate::failure::{Failure, in_options};
use crate::output::print;
use crate::progress::{How, Shown};

const EXAMPLES: &str = "\
Examples:
  sagnac simulate noise.toml --rate 100Hz --length 1h
  sagnac simulate noise.toml --rate 1Hz --length 9h --records 20 --seed 3 --form npy --out lab
  sagnac simulate studies/record_length.toml --at length=4h --data increment";

/// The file of the study whose trials the records are.
const STUDY: &str = "simulated.toml";

/// Most records of a command, each a file.
const MAX_RECORDS: u64 = 100_000;

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// A noise file, as `sagnac allan` writes it, or a study of kind "allan"
    #[arg(value_name = "NOISE|STUDY")]
    input: PathBuf,
    /// Sampling rate or step, for a noise file
    #[arg(long, value_name = "RATE", value_parser = step_of)]
    rate: Option<f64>,
    /// Length, for a noise file
    #[arg(long, value_name = "TIME", value_parser = length)]
    length: Option<f64>,
    /// Values of swept keys, for a study with sweeps
    #[arg(long, value_name = "KEY=VALUE")]
    at: Vec<String>,
    /// Number of records
    #[arg(long, value_name = "N", default_value = "1", value_parser = |text: &str| whole(text, 1..=MAX_RECORDS))]
    records: u64,
    /// Number of the first record; a record of a seed is the same wherever it is made
    #[arg(long, value_name = "K", default_value = "0", value_parser = |text: &str| whole(text, 0..=MAX_TRIALS - MAX_RECORDS))]
    first: u64,
    /// Seed [default: that of the study, or 1]
    #[arg(long, value_name = "S", value_parser = |text: &str| whole(text, 0..=i64::MAX as u64))]
    seed: Option<u64>,
    /// Rates in °/h, or angles in ″: of each sample (increment), or from the start (angle)
    #[arg(long, value_name = "KIND", default_value = "rate", value_parser = numbers())]
    data: Numbers,
    /// Form of the files; raw has numbers of 8 bytes
    #[arg(help_heading = "Output", long, value_name = "FORM", default_value = "csv", value_parser = form())]
    form: Form,
    /// Folder of the records [default: results/<name of the file>_records]
    #[arg(help_heading = "Output", long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print only errors
    #[arg(help_heading = "Output", long, short)]
    quiet: bool,
}

fn numbers() -> impl TypedValueParser<Value = Numbers> {
    one_of([("rate", Numbers::Rate), ("increment", Numbers::Increment), ("angle", Numbers::Angle)])
}

fn form() -> impl TypedValueParser<Value = Form> {
    one_of([("csv", Form::Csv), ("npy", Form::Npy), ("raw", Form::Raw)])
}

/// A positive time, s.
fn length(text: &str) -> Result<f64, String> {
    let time = parse(text, &[Dimension::Time]).map_err(|error| error.to_string())?;
    if time.value > 0.0 { Ok(time.value) } else { Err("it is not positive".to_owned()) }
}

/// Writes records of noise, one file each, with the study whose trials they are.
pub fn simulate(options: &Options) -> Result<(), Failure> {
    let simulation = options.simulation()?;
    let stem = options.input.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let default = || Path::new("results").join(format!("{stem}_records"));
    let path = options.out.clone().unwrap_or_else(default);
    let folder = Folder::open(&path)?.reading([&*options.input]);
    let study = simulation.study();
    let place = match &options.at[..] {
        [] => String::new(),
        at => format!("# The records are those of the point with {}.\n", at.join(", ")),
    };
    let text = place + &study.resolved(study.trials);
    // Records of other noise beside them would have another study.
    let known = path.join(STUDY);
    if known.exists() && read_text(&known, MAX_TOML).ok().as_deref() != Some(&text) {
        let path = path.display();
        return Err(Failure::Usage(format!(
            "{path} holds records of other noise, or of another seed or point\ngive another folder with --out"
        )));
    }
    write_inputs(study, &folder)?;
    folder.write(STUDY, text.as_bytes())?;
    let progress = Shown::new(if options.quiet { How::None } else { How::Plain });
    progress.start("records", 0, options.records);
    for number in options.first..options.first + options.records {
        let name = format!("record_{number:05}.{}", options.form.ending());
        folder.write_by(&name, |to| simulation.write(number, options.data, options.form, to))?;
        progress.advance(1);
    }
    folder.commit()?;
    match options.quiet {
        true => Ok(()),
        false => print(&format!(
            "{} of {} samples at {} Hz\nrecords {}",
            match options.records {
                1 => "1 record".to_owned(),
                records => format!("{records} records"),
            },
            simulation.samples(),
            short(1.0 / simulation.sample_s()),
            path.display()
        )),
    }
}

impl Options {
    fn simulation(&self) -> Result<Simulation, Failure> {
        let refused = |error: SimulateError| match error {
            SimulateError::Study(error) => Failure::Study(error),
            SimulateError::Point(message) => Failure::Usage(in_options(&message)),
        };
        let text = read_text(&self.input, MAX_TOML)
            .map_err(|error| Failure::Usage(format!("cannot read {}: {error}", self.input.display())))?;
        // What is no TOML is refused with its place.
        let is_study = text.parse::<toml::Table>().map_or(true, |table| table.contains_key("kind"));
        if is_study {
            let mut study = Study::read(&self.input)?;
            if self.rate.or(self.length).is_some() {
                let message = "--rate and --length are for noise files; a study has `record.sample` and `record.length`";
                return Err(Failure::Usage(format!("{message}\nleave them out")));
            }
            study.seed = self.seed.unwrap_or(study.seed);
            return Simulation::of_study(&study, &self.at).map_err(refused);
        }
        let (Some(sample_s), Some(length_s)) = (self.rate, self.length) else {
            let message = "a noise file does not say how long its records are\ngive --rate and --length, as in --rate 100Hz --length 1h";
            return Err(Failure::Usage(message.to_owned()));
        };
        if !self.at.is_empty() {
            return Err(Failure::Usage(
                "--at selects from a study, but none is given\nleave it out".to_owned(),
            ));
        }
        let name = self.input.file_name().unwrap_or_default().to_string_lossy();
        Simulation::of_noise(&name, &text, sample_s, length_s, self.seed.unwrap_or(1)).map_err(refused)
    }
}
