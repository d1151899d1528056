//! `sagnac simulate`.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::TypedValueParser;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use sagnac::record::log::read::step_of;
use sagnac::record::write::Form;
use sagnac::run::write_inputs;
use sagnac::store::folder::{Folder, FolderError};
use sagnac::use_cases::{
    MotionText, Numbers, Sensitivity, SimulateError, SimulateRequest, Simulation, Warming,
};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::Dimension;
use sagnac_base::quantity::number::short;
use sagnac_base::text_file::{MAX_TOML, read_text};
use sagnac_engine::key::MAX_TRIALS;
use sagnac_engine::kinds::allan::lower::MAX_SAMPLES;

use crate::arg_parsers::{one_of, value_of, whole};
use crate::failure::{Failure, in_options};
use crate::output::print;
use crate::program::selected;
use crate::progress::{How, Shown};

const EXAMPLES: &str = "\
Examples:
  sagnac simulate noise.toml --rate 100Hz --length 1h
  sagnac simulate noise.toml --rate 1Hz --length 9h --records 20 --seed 3 --form npy --out lab
  sagnac simulate studies/record_length.toml --at length=4h --data increment
  sagnac simulate studies/smoke.toml --at gap_ticks=3 --length 60s --switch-every 1s --form h5
  sagnac simulate noise.toml --rate 1kHz --length 60s --motion my.toml --axes 3 --out moving";

/// The file of the study whose trials the records are.
const STUDY: &str = "simulated.toml";

/// Most records of a command, each a file.
const MAX_RECORDS: u64 = 100_000;

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// A noise file of `sagnac allan`, or a study of kind "allan", "gap-fill", "switched-run" or "lock-in"
    #[arg(value_name = "NOISE|STUDY")]
    input: PathBuf,
    /// Sampling rate or step, for a noise file
    #[arg(long, value_name = "RATE", value_parser = step_of)]
    rate: Option<f64>,
    /// Length, for a noise file, gap-fill, switched-run
    #[arg(long, value_name = "TIME", value_parser = length)]
    length: Option<f64>,
    /// Values of swept keys
    #[arg(long, value_name = "KEY=VALUE")]
    at: Vec<String>,
    /// Switching interval of gap-fill; lost samples are NaN, the truth goes on
    #[arg(long, value_name = "TIME", value_parser = length)]
    switch_every: Option<f64>,
    /// Number of records
    #[arg(long, value_name = "N", default_value = "1", value_parser = |text: &str| whole(text, 1..=MAX_RECORDS))]
    records: u64,
    /// First record; one of a seed is the same wherever it is made
    #[arg(long, value_name = "K", default_value = "0", value_parser = |text: &str| whole(text, 0..=MAX_TRIALS - MAX_RECORDS))]
    first: u64,
    /// Seed [default: that of the study, or 1]
    #[arg(long, value_name = "S", value_parser = |text: &str| whole(text, 0..=i64::MAX as u64))]
    seed: Option<u64>,
    /// Keys of [motion] of a study, about z of three axes unless as in x=FILE
    #[arg(help_heading = "Motion", long, value_name = "FILE")]
    motion: Vec<String>,
    /// Add columns of the true motion
    #[arg(help_heading = "Motion", long)]
    truth: bool,
    /// Axes, each with noise of its own
    #[arg(help_heading = "Motion", long, value_name = "N", default_value = "1", value_parser = one_of([("1", 1_usize), ("3", 3)]))]
    axes: usize,
    /// Angles by which an axis senses another, as in xy=10arcsec
    #[arg(help_heading = "Motion", long, value_name = "AXES=ANGLE", value_delimiter = ',', value_parser = Sensitivity::parse_misalignment)]
    misalignment: Vec<Sensitivity>,
    /// Errors of scale factors, as in x=10ppm
    #[arg(help_heading = "Motion", long, value_name = "AXIS=ERROR", value_delimiter = ',', value_parser = Sensitivity::parse_scale_factor)]
    scale_factor: Vec<Sensitivity>,
    /// Temperature from start to end, °C
    #[arg(help_heading = "Temperature", long, value_name = "FROM..TO", value_parser = ends(), requires = "temperature_coefficient", allow_hyphen_values = true)]
    temperature: Option<Ends>,
    /// Rate per kelvin above that at the start, "0.02 deg/h/K"
    #[arg(help_heading = "Temperature", long, value_name = "RATE", value_parser = Warming::parse_coefficient, requires = "temperature", allow_hyphen_values = true)]
    temperature_coefficient: Option<f64>,
    /// Rates in °/h, angles in ″ of each sample or from the start (angle), or pulses
    #[arg(long, value_name = "KIND", default_value = "rate", value_parser = numbers())]
    data: Numbers,
    /// Device that makes the noise, as for `sagnac run`
    #[arg(help_heading = "Device", long, value_name = "DEVICE", default_value = "cpu")]
    device: String,
    /// Form of files; h5 is HDF5, mcap ROS messages, raw 8-byte numbers
    #[arg(help_heading = "Output", long, value_name = "FORM", default_value = "csv", value_parser = form())]
    form: Form,
    /// Folder of the records [default: results/<name of the file>_records]
    #[arg(help_heading = "Output", long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print only errors
    #[arg(help_heading = "Output", long, short)]
    quiet: bool,
}

/// Two temperatures, °C.
#[derive(Debug, Clone, Copy)]
struct Ends([f64; 2]);

fn ends() -> impl TypedValueParser<Value = Ends> {
    |text: &str| Warming::parse_ends(text).map(Ends)
}

fn numbers() -> impl TypedValueParser<Value = Numbers> {
    one_of(Numbers::NAMED)
}

fn form() -> impl TypedValueParser<Value = Form> {
    one_of(Form::ALL.map(|form| (form.ending(), form)))
}

/// A positive time, s.
fn length(text: &str) -> Result<f64, String> {
    let seconds = value_of(text, Dimension::Time)?;
    if seconds > 0.0 { Ok(seconds) } else { Err("it is not positive".to_owned()) }
}

/// Writes records of noise, one file each, with the study whose trials they are.
pub fn simulate(options: &Options) -> Result<(), Failure> {
    let request = SimulateRequest {
        sample_s: options.rate,
        length_s: options.length,
        switch_every_s: options.switch_every,
        at: options.at.clone(),
        seed: options.seed,
        three_axes: options.axes == 3,
        motions: options
            .motion
            .iter()
            .map(|given| motion(given, options.axes == 3))
            .collect::<Result<_, _>>()?,
        sensitivities: [&options.misalignment[..], &options.scale_factor].concat(),
        warming: options
            .temperature
            .zip(options.temperature_coefficient)
            .map(|(Ends(ends), coefficient)| Warming { ends, coefficient }),
        has_truth: options.truth,
    };
    let simulation = Simulation::read(&options.input, &request)?;
    simulation.check(options.data, options.form)?;
    let is_said = !options.quiet && options.device != "cpu";
    let simulation = simulation.on(selected(&options.device, 0, is_said)?);
    let stem = options.input.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let default = || Path::new("results").join(format!("{stem}_records"));
    let path = options.out.clone().unwrap_or_else(default);
    let motions = request.motions.iter().map(|motion| Path::new(&motion.name));
    let folder = Folder::open(&path)?.reading(motions.chain([&*options.input]).chain(simulation.files()));
    let study = simulation.study();
    let place = match &options.at[..] {
        [] => String::new(),
        at => format!("# The records are those of the point with {}.\n", at.join(", ")),
    };
    let numbers = options.data.title();
    let truth: String = simulation.truth().lines().map(|line| format!("# {line}\n")).collect();
    let axes = if options.axes == 3 { " of three axes" } else { "" };
    let long = match simulation.samples() > MAX_SAMPLES {
        true => format!("# They have {} samples, more than those of a study.\n", simulation.samples()),
        false => String::new(),
    };
    let text =
        format!("# The records have {numbers}{axes}.\n{long}{place}{truth}{}", study.resolved(study.trials));
    // Records of other noise beside them would have another study.
    let known = path.join(STUDY);
    if known.exists() && read_text(&known, MAX_TOML).ok().as_deref() != Some(&text) {
        let path = path.display();
        return Err(Failure::Usage(format!(
            "{path} holds records of other noise, other numbers, or of another seed or point\ngive another folder with --out"
        )));
    }
    write_inputs(study, &folder)?;
    folder.write(STUDY, text.as_bytes())?;
    let progress = Shown::new(if options.quiet { How::None } else { How::Auto }).terse();
    progress.start("records", 0, options.records);
    let records = options.first..options.first + options.records;
    let written = records.into_par_iter().try_for_each(|number| {
        let name = format!("record_{number:05}.{}", options.form.ending());
        folder.write_by(&name, |to| simulation.write(number, options.data, options.form, to))?;
        for (table, text) in simulation.drawn(number) {
            folder.write(&format!("record_{number:05}_{table}.csv"), text.as_bytes())?;
        }
        progress.advance(1);
        Ok::<(), FolderError>(())
    });
    written.map_err(|error| match simulation.failure() {
        Some(failure) => Failure::from(failure.clone()),
        None => error.into(),
    })?;
    folder.commit()?;
    match options.quiet {
        true => Ok(()),
        false => print(&format!(
            "{} of {} samples at {} Hz\n{}records {}",
            match options.records {
                1 => "1 record".to_owned(),
                records => format!("{records} records"),
            },
            simulation.samples(),
            short(1.0 / simulation.sample_s()),
            if options.form == Form::Npy { hint(&simulation, options.data) } else { String::new() },
            path.display()
        )),
    }
}

/// A line with the options by which a command on logs reads an array without names.
fn hint(simulation: &Simulation, numbers: Numbers) -> String {
    let step_s = simulation.sample_s();
    let rate_hz = 1.0 / step_s;
    let rate = if rate_hz.fract() == 0.0 { format!("{rate_hz}Hz") } else { format!("{step_s}s") };
    let read = match numbers {
        Numbers::Rate => "--data rate --unit deg/h".to_owned(),
        Numbers::Increment => "--data increment --unit arcsec".to_owned(),
        Numbers::Angle => "--data angle --unit arcsec".to_owned(),
        Numbers::Pulses => format!("--data increment --scale \"{} arcsec/pulse\"", simulation.pulse_arcsec()),
    };
    format!("read them with --rate {rate} {read}\n")
}

/// Reads a motion, which is about an axis of three or, without one, about the last.
fn motion(given: &str, has_three: bool) -> Result<MotionText, Failure> {
    let named = ["x=", "y=", "z="].into_iter().position(|axis| given.starts_with(axis));
    let (axis, name) = match named {
        Some(axis) => (axis, &given[2..]),
        None => (if has_three { 2 } else { 0 }, given),
    };
    let text = read_text(Path::new(name), MAX_TOML)
        .map_err(|error| Failure::Usage(format!("cannot read the motion {name}: {error}")))?;
    Ok(MotionText { axis, name: name.to_owned(), text })
}

impl From<SimulateError> for Failure {
    fn from(error: SimulateError) -> Failure {
        match error {
            SimulateError::Study(error) => Failure::Study(error),
            SimulateError::Request(message) => Failure::Usage(in_options(&message)),
        }
    }
}
