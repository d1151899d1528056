//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use sagnac::device::Device;
use sagnac::device::select::Selection;
use sagnac::quantity::visible::visible;
use sagnac::verify::select;

use crate::failure::{EXIT_CODES, Failure};

/// Monte Carlo studies for laser gyroscopes, with the same bits on every CPU and GPU.
#[derive(Debug, Parser)]
#[command(name = "sagnac", version, max_term_width = 110, after_long_help = after_help())]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    look: crate::look::Options,
}

const EXAMPLES: &str = "\
Examples:
  sagnac run studies/error_vs_dtnu.toml
  sagnac run my.toml --trials 100000000 --device gpu
  sagnac run my.toml --shard 2/4 --time-limit 8h
  sagnac merge results/my/shard-* --out results/my
  sagnac check results/my
  sagnac design studies/design_point.toml
  sagnac sensitivity studies/what_decides.toml
  sagnac filler quadratic --gap-ticks 3
  sagnac filler my.toml --at gap_ticks=3 --filler mv8+2 --test-vectors
  sagnac allan gyro.csv --data rate --unit deg/h --rate 100Hz --column gz
  sagnac psd gyro.csv --data rate --unit deg/h --rate 100Hz --column gz
  sagnac compare before.csv after.csv --data rate --unit deg/h --rate 100Hz
  sagnac lot bench.csv --data rate --unit deg/h --rate 1Hz --column g01,g02,g03,g04
  sagnac model gyro.csv --data rate --unit deg/h --rate 100Hz --column gz --bound
  sagnac new gap-fill first.toml
  sagnac explain motion.amplitude
  sagnac verify";

/// Examples and exit codes.
fn after_help() -> String {
    let codes = EXIT_CODES.iter().map(|(code, meaning)| format!("\n  {code:8}  {meaning}"));
    format!("{EXAMPLES}\n\nExit codes:{}", codes.collect::<String>())
}

/// Declares the commands, each with its options and the function that runs it.
macro_rules! commands {
    ($($(#[$meta:meta])* $Command:ident($Options:ty) = $run:expr;)+) => {
        #[derive(Debug, Subcommand)]
        enum Command {
            $($(#[$meta])* $Command($Options),)+
        }

        impl Command {
            fn run(&self) -> Result<(), Failure> {
                match self {
                    $(Command::$Command(options) => $run(options),)+
                }
            }
        }
    };
}

commands! {
    /// Run studies: sample what is missing, write the table and the charts
    ///
    /// Results are written to a folder. Repeating a command resumes the run; a larger --trials adds trials to it.
    Run(crate::run::Options) = crate::run::run;
    /// Merge results: shares of a study, or runs of several machines, in any order and any number of times
    Merge(crate::merge::Options) = crate::merge::merge;
    /// Check that results are intact, complete and match their tables
    Check(crate::check::Options) = crate::check::check;
    /// Rebuild report.html, or a gallery of several studies
    Report(crate::report::Options) = crate::report::report;
    /// Redraw existing results with other axes, estimates or limits
    Chart(crate::chart::Options) = crate::chart::chart;
    /// Recommend how often to switch and with which filler, with evidence
    Design(crate::design::Options) = crate::design::design;
    /// Find which uncertain input decides the answer of a study, and by how much
    Sensitivity(crate::sensitivity::Options) = crate::sensitivity::sensitivity;
    /// Compute the weights of fillers for firmware: table, response over frequency, C header, test vectors
    Filler(crate::filler::Options) = crate::filler::filler;
    /// Compute deviations of recorded logs: Allan, modified Allan, time, Hadamard, with intervals and noise types
    Allan(crate::allan::Options) = crate::allan::allan;
    /// Compute the power spectral density of a recorded log, with its lines and the white noise beside the Allan fit
    Psd(crate::psd::Options) = crate::psd::psd;
    /// Compare the noise of two recorded logs: coefficients, significance, and the record length needed
    Compare(crate::compare::Options) = crate::compare::compare;
    /// Pool the noise of several units of a lot: the value and spread of each coefficient, the next unit, the odd unit
    Lot(crate::lot::Options) = crate::lot::lot;
    /// Find the noise model that a navigation filter can use: white noise, random walk and the fewest Markov states, as a bound
    Model(crate::model::Options) = crate::model::model;
    /// List the devices that kernels can run on
    Devices(crate::devices::Options) = crate::devices::devices;
    /// Verify that every kernel gives the same bits on every device of this machine
    Verify(Verify) = crate::verify::verify;
    /// Write the shaders with their inputs and results, to check other shader compilers and drivers
    Shaders(crate::shaders::Options) = crate::shaders::shaders;
    /// Measure the throughput of the kernels
    ///
    /// A GPU's rates are also given by its own clock, without what the host adds, and as a part of its integer limit:
    /// the operations that the kernel needs, divided by those that the GPU does in independent chains.
    Bench(Bench) = crate::bench::bench;
    /// Print the JSON schema of study files, or of what a command prints with --json
    Schema(crate::schemas::Options) = crate::schemas::schema;
    /// Write a commented study as a starting point
    New(crate::new::Options) = crate::new::new;
    /// Explain a key of a study, a column of results, a term or an exit code
    Explain(crate::explain::Options) = crate::explain::explain;
    /// Print a script for the completion of commands and options in a shell
    Completions(crate::shells::Completions) = crate::shells::completions;
    /// Write manual pages
    Man(crate::shells::Man) = crate::shells::man;
}

/// The command line as clap describes it.
pub fn command() -> clap::Command {
    // The numbers of a noise.toml need no kind.
    Cli::command().mut_subcommand("model", |model| model.mut_arg("data", |data| data.required(false)))
}

const VERIFY_EXAMPLES: &str = "\
Examples:
  sagnac verify
  sagnac verify --device cpu --trials 100000
  sagnac verify --report identity.md";

#[derive(Debug, Args)]
#[command(after_long_help = VERIFY_EXAMPLES)]
pub struct Verify {
    /// Devices to verify: cpu, gpu, gpu:0, part of an adapter's name, its PCI address, several of these with commas, or
    /// all; see `sagnac devices` [default: all adapters]
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
    /// Work per kernel: total number of trials, samples or values over all its configurations
    #[arg(long, value_name = "N", default_value_t = 1 << 21, value_parser = verified)]
    pub trials: u64,
    /// File to which a row is added for each compared device, as a table in Markdown to send to the project
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
}

const BENCH_EXAMPLES: &str = "\
Examples:
  sagnac bench
  sagnac bench --device cpu --json";

#[derive(Debug, Args)]
#[command(after_long_help = BENCH_EXAMPLES)]
pub struct Bench {
    #[command(flatten)]
    pub device: DeviceArg,
    /// Print the figures as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct DeviceArg {
    /// Device to use: auto, cpu, gpu, a vector width of the CPU such as avx2, gpu:0, part of an adapter's name, or its
    /// PCI address; see `sagnac devices`. Several share the work: all, or a list such as cpu,gpu:0
    #[arg(help_heading = "Device", long = "device", value_name = "DEVICE", default_value = "auto")]
    name: String,
    /// Number of CPU threads [default: all logical cores]
    #[arg(help_heading = "Device", long, value_name = "N", value_parser = threads)]
    threads: Option<usize>,
}

impl DeviceArg {
    /// Selects the device, and says which one if `is_said`.
    ///
    /// # Errors
    /// There is no such device, or it does not work.
    pub fn select(&self, is_said: bool) -> Result<Device, Failure> {
        let Selection { device, reason, left_out } = select(&self.name, self.threads.unwrap_or(0))?;
        if is_said {
            say!("device: {}, {reason}", device.name());
            for sentence in left_out {
                note!("{sentence}");
            }
        }
        Ok(device)
    }
}

/// A number of units of work.
fn verified(text: &str) -> Result<u64, String> {
    crate::whole::whole(text, 1..=1 << 32)
}

/// A number of threads.
fn threads(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|threads| (1..=4096).contains(threads))
        .ok_or_else(|| "expected 1 to 4096".to_owned())
}

/// Whether an argument has characters that are not visible.
fn hides() -> bool {
    let mut arguments = std::env::args_os();
    arguments.any(|argument| matches!(visible(&argument.to_string_lossy()), std::borrow::Cow::Owned(_)))
}

/// The arguments, in which a negative quantity is one with the option before it. Alone, as in `--rate -5Hz`, it would be taken for an option.
fn joined(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut joined: Vec<OsString> = vec![];
    for argument in arguments {
        let is_negative = matches!(argument.as_encoded_bytes(), [b'-', b'0'..=b'9' | b'.', ..]);
        let is_open = |before: &&mut OsString| {
            let before = before.as_encoded_bytes();
            before.len() > 2 && before.starts_with(b"--") && !before.contains(&b'=')
        };
        match joined.last_mut().filter(|_| is_negative).filter(is_open) {
            Some(option) => {
                option.push("=");
                option.push(argument);
            }
            None => joined.push(argument),
        }
    }
    joined
}

/// Runs the program.
pub fn main() -> ExitCode {
    crate::output::outlive_limits();
    let arguments = joined(std::env::args_os());
    let color = crate::look::of_arguments(&arguments);
    let matches = command().color(color).try_get_matches_from(arguments);
    let cli = match matches.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        // An argument, such as a name of a file, stands in the message. Without styles, clap leaves out what commands a
        // terminal, and `say!` shows the rest.
        Err(error) if error.use_stderr() && hides() => {
            say!("{}", error.render());
            return ExitCode::from(2);
        }
        Err(error) if error.use_stderr() => error.exit(),
        // Help or the version.
        Err(text) => {
            return match crate::output::flushed(text.print()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(failure) => failure.report(),
            };
        }
    };
    crate::look::follow(&cli.look);
    match cli.command.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
