//! The command line.

use std::borrow::Cow;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use sagnac::device::Device;
use sagnac::device::select::Selection;
use sagnac::study::Study;
use sagnac::use_cases::Outcome;
use sagnac::verify::select;
use sagnac_base::diagnostics::visible;
use sagnac_engine::key::MAX_TRIALS;
use sagnac_engine::key::docs::{note, present};

use crate::arg_parsers::whole;
use crate::failure::{EXIT_CODES, Failure};
use crate::output::finish;
use crate::output::{Printed, print_documents};
use crate::progress::{self, How};

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
  sagnac allan gyro.csv --unit deg/h --rate 100Hz --column gz
  sagnac filler quadratic --gap-ticks 3";

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
    /// Run studies, and write the page with the answer
    ///
    /// Results are written to a folder. Repeating a command resumes the run; a larger --trials adds trials to it.
    Run(crate::run::Options) = crate::run::run;
    /// Find how often to switch and with which filler
    Design(crate::design::Options) = crate::design::design;
    /// Find which uncertain input drives the answer of a study
    Sensitivity(crate::sensitivity::Options) = crate::sensitivity::sensitivity;
    /// Compute gap fillers: weights, response, C header, test vectors
    Filler(crate::filler::Options) = crate::filler::filler;
    /// Analyze logs: Allan deviations, spectrum, noise coefficients
    Allan(crate::allan::Options) = crate::allan::allan;
    /// Compare two logs, or the units of a batch
    Compare(crate::compare::Options) = crate::compare::compare;
    /// Find the noise model of a log for a navigation filter
    Model(crate::model::Options) = crate::model::model;
    /// Write simulated records of a gyro
    Simulate(crate::simulate::Options) = crate::simulate::simulate;
    /// Convert a noise coefficient between units and conventions
    Convert(crate::convert::Options) = crate::convert::convert;
    /// Rebuild the page of results, redraw a chart, or make a gallery
    Report(crate::report::Options) = crate::report::report;
    /// Merge results: shares of a study, or runs of several machines
    Merge(crate::merge::Options) = crate::merge::merge;
    /// Check that results are intact, complete and match their tables
    Check(crate::check::Options) = crate::check::check;
    /// Write a commented study as a starting point
    New(crate::generate::New) = crate::generate::new;
    /// Explain a key of studies, a column, a term or an exit code
    Explain(crate::explain::Options) = crate::explain::explain;
    /// Print the JSON schema of studies, or of what --json prints
    Schema(crate::generate::Schema) = crate::generate::schema;
    /// List, verify or measure the devices that kernels run on
    Device(crate::device::Command) = crate::device::device;
    #[command(hide = true)]
    Chart(crate::report::Options) = |options| { renamed("chart", "report DIR --chart 1"); crate::report::chart(options) };
    #[command(hide = true)]
    Psd(crate::allan::Options) = |options| { renamed("psd", "allan"); crate::allan::allan(options) };
    #[command(hide = true)]
    Lot(crate::compare::Options) = |options| { renamed("lot", "compare"); crate::compare::batch(options, "lot") };
    #[command(hide = true)]
    Devices(crate::device::Options) = |options| { renamed("devices", "device list"); crate::device::devices(options) };
    #[command(hide = true)]
    Verify(Verify) = |options| { renamed("verify", "device verify"); crate::device::verify(options) };
    #[command(hide = true)]
    Bench(Bench) = |options| { renamed("bench", "device bench"); crate::device::bench(options) };
    #[command(hide = true)]
    Shaders(Former) = |_| Err(Failure::Usage("`sagnac shaders` is now `cargo run --example shaders -- DIR`".to_owned()));
    /// Print a script for the completion of commands and options in a shell
    #[command(hide = true)]
    Completions(crate::generate::Completions) = crate::generate::completions;
    /// Write manual pages
    #[command(hide = true)]
    Man(crate::generate::Man) = crate::generate::man;
}

/// The arguments of a former command.
#[derive(Debug, Args)]
struct Former {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _arguments: Vec<OsString>,
}

/// Notes that a command has another name now.
fn renamed(old: &str, new: &str) {
    if !is_quiet() {
        note!("{}", note(&format!("sagnac {old}"), &format!("sagnac {new}")));
    }
}

/// The option `--quiet` of the command line.
static QUIET: OnceLock<bool> = OnceLock::new();

/// Whether only errors are asked for.
fn is_quiet() -> bool {
    QUIET.get().is_some_and(|quiet| *quiet)
}

/// The commands as help lists them.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Simulate", &["run", "design", "sensitivity", "filler", "simulate"]),
    ("Analyze logs", &["allan", "compare", "model"]),
    ("Results", &["report", "merge", "check"]),
    ("Learn", &["new", "convert", "explain", "schema"]),
    ("Machine", &["device"]),
];

/// The commands in their groups, a line each.
fn grouped(command: &clap::Command) -> String {
    let line = |name: &&str| {
        let about = command.find_subcommand(name).and_then(clap::Command::get_about);
        format!("  {name:<12} {}\n", about.map(ToString::to_string).unwrap_or_default())
    };
    let group = |(title, names): &(&str, &[&str])| {
        format!("{title}:\n{}", names.iter().map(line).collect::<String>())
    };
    GROUPS.iter().map(group).collect::<Vec<_>>().join("\n")
}

/// The options that the short help of commands lists; `--help` has all.
const BRIEF: [&str; 21] = [
    "at",
    "by",
    "chart",
    "column",
    "device",
    "filler",
    "gap_ticks",
    "json",
    "latency",
    "limit",
    "max_ratio",
    "navigate",
    "out",
    "overbound",
    "quiet",
    "rate",
    "search",
    "table",
    "time",
    "trials",
    "unit",
];

/// The parts of the help of the program.
const HELP: &str = "\
{about-with-newline}
{usage-heading} {usage}

{before-help}Options:
{options}{after-help}";

/// The command line as clap describes it.
pub fn command() -> clap::Command {
    let command = Cli::command();
    let groups = grouped(&command);
    let names: Vec<String> = command.get_subcommands().map(|one| one.get_name().to_owned()).collect();
    let brief = |command: clap::Command| {
        command.mut_args(|arg| {
            let is_brief = arg.is_positional() || BRIEF.contains(&arg.get_id().as_str());
            if is_brief { arg } else { arg.hide_short_help(true) }
        })
    };
    let command = names.iter().fold(command, |command, name| command.mut_subcommand(name, brief));
    command.before_help(groups).help_template(HELP)
}

const VERIFY_EXAMPLES: &str = "\
Examples:
  sagnac device verify
  sagnac device verify --device cpu --trials 100000";

#[derive(Debug, Args)]
#[command(after_long_help = VERIFY_EXAMPLES)]
pub struct Verify {
    /// Devices: cpu, gpu, gpu:0, part of an adapter's name, its PCI address, several of these with commas, or all; see
    /// `sagnac device list` [default: all adapters]
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
    /// Work per kernel: trials, samples or values over all its configurations
    #[arg(long, value_name = "N", default_value_t = 1 << 21, value_parser = verified)]
    pub trials: u64,
    /// Former option, which wrote a row for each compared device
    #[arg(long, hide = true)]
    pub report: Option<PathBuf>,
}

const BENCH_EXAMPLES: &str = "\
Examples:
  sagnac device bench
  sagnac device bench --device cpu --json";

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
    /// Device: auto, cpu, gpu, a vector width of the CPU such as avx2, gpu:0, part of an adapter's name, or its
    /// PCI address; see `sagnac device list`. Several share the work: all, or a list such as cpu,gpu:0
    #[arg(help_heading = "Device", long, value_name = "DEVICE", default_value = "auto")]
    device: String,
    /// Number of CPU threads [default: all logical cores]
    #[arg(help_heading = "Device", long, short = 'j', value_name = "N", value_parser = threads)]
    threads: Option<usize>,
}

impl DeviceArg {
    /// Selects the device, and says which one if `is_said`.
    ///
    /// # Errors
    /// There is no such device, or it does not work.
    pub fn select(&self, is_said: bool) -> Result<Device, Failure> {
        selected(&self.device, self.threads.unwrap_or(0), is_said)
    }
}

/// The device called `wanted`, whose CPU uses `threads` threads, as [`DeviceArg::select`] gives it.
pub fn selected(wanted: &str, threads: usize, is_said: bool) -> Result<Device, Failure> {
    let Selection { device, reason, left_out } = select(wanted, threads)?;
    if is_said {
        say!("device: {}, {reason}", device.name());
        for sentence in left_out {
            note!("{sentence}");
        }
    }
    Ok(device)
}

/// The options of the commands that sample studies.
#[derive(Debug, Args)]
#[group(skip)]
pub struct Sampling {
    /// Trials at each point, of each candidate or of each evaluation [default: those of the study; of a sensitivity 4096,
    /// or more for few evaluations]
    #[arg(help_heading = "Sampling", long, short = 'n', value_name = "N", value_parser = trials)]
    pub trials: Option<u64>,
    /// Seed, instead of the study's
    #[arg(help_heading = "Sampling", long, value_name = "S", value_parser = seed)]
    seed: Option<u64>,
    /// Print the results as JSON: one object, or an array for several studies
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

/// A number of units of work.
fn verified(text: &str) -> Result<u64, String> {
    whole(text, 1..=1 << 32)
}

/// A number of threads.
fn threads(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|threads| (1..=4096).contains(threads))
        .ok_or_else(|| "expected 1 to 4096".to_owned())
}

/// Whether an argument has characters that are not visible.
fn hides(arguments: &[OsString]) -> bool {
    let hides = |argument: &OsString| matches!(visible(&argument.to_string_lossy()), Cow::Owned(_));
    arguments.iter().any(hides)
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

/// Options whose values are names of columns, or of what has a limit, by themselves or before an equals sign.
const OF_NAMES: [&str; 8] = ["--by", "--limit", "--of", "--series", "--where", "--x", "--y", "--z"];

/// The arguments with present names for the former ones, and a note on each.
fn replaced(arguments: Vec<OsString>) -> (Vec<OsString>, Vec<String>) {
    let mut notes = vec![];
    let mut take = |former: &str| match present(former) {
        Some(present) => {
            notes.push(note(former, &present));
            present
        }
        None => former.to_owned(),
    };
    let mut names = |value: &str| {
        let (list, rest) = value.find('=').map_or((value, ""), |at| value.split_at(at));
        list.split(',').map(&mut take).collect::<Vec<_>>().join(",") + rest
    };
    let mut before = String::new();
    let mut replaced = vec![];
    for argument in arguments {
        let present = argument.to_str().map(|text| match text.split_once('=') {
            _ if OF_NAMES.contains(&&*before) => names(text),
            Some((option, value)) if OF_NAMES.contains(&option) => format!("{option}={}", names(value)),
            Some((option, value)) if option.starts_with("--") => format!("{}={value}", names(option)),
            None if text.starts_with("--") => names(text),
            _ => text.to_owned(),
        });
        before = argument.to_string_lossy().into_owned();
        replaced.push(present.map_or(argument, OsString::from));
    }
    (replaced, notes)
}

/// Runs the program with its arguments, and returns the exit code.
pub fn main(arguments: impl Iterator<Item = OsString>) -> u8 {
    crate::output::outlive_limits();
    let (arguments, former) = replaced(joined(arguments));
    // There is only one command line.
    let _ = QUIET.set(arguments.iter().any(|argument| argument == "--quiet" || argument == "-q"));
    let hides = hides(&arguments);
    let color = crate::look::of_arguments(&arguments);
    let matches = command().color(color).try_get_matches_from(arguments);
    let cli = match matches.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            // An argument, such as a name of a file, stands in the message. Without styles, clap leaves out what commands a
            // terminal, and `say!` shows the rest.
            if hides {
                say!("{}", error.render());
            } else {
                // If the message cannot be written, the exit code still tells.
                let _ = error.print();
            }
            return 2;
        }
        // Help or the version.
        Err(text) => {
            return match crate::output::flushed(text.print()) {
                Ok(()) => 0,
                Err(failure) => failure.report(),
            };
        }
    };
    crate::look::follow(&cli.look);
    former.iter().filter(|_| !is_quiet()).for_each(|former| note!("{former}"));
    match cli.command.run() {
        Ok(()) => 0,
        Err(failure) => failure.report(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn former_options_and_columns_are_replaced_and_names_of_files_are_not() {
        for (former, present, count) in [
            ("sensitivity oracle_rms.toml --by oracle_rms", "sensitivity oracle_rms.toml --by theory_rms", 1),
            ("report r --y=rms,oracle_rms --where q95=law", "report r --y=rms,theory_rms --where p95=law", 2),
            ("model a.csv --bound=repeat --out law", "model a.csv --overbound=repeat --out law", 1),
        ] {
            let (found, notes) = replaced(former.split(' ').map(OsString::from).collect());
            assert_eq!(found.join(" ".as_ref()), OsString::from(present));
            assert_eq!(notes.len(), count, "{notes:?}");
        }
    }
}
