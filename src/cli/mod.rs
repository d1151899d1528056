//! The command line.

/// A line on the standard error stream. Where that cannot be written, as to a full disk, there is nobody to tell, and what the program
/// does and its exit code stay the same.
macro_rules! say {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        $crate::cli::progress::aside(|| {
            let _ = writeln!(std::io::stderr(), $($words)*);
        });
    }};
}

mod allan;
mod bench;
mod chart;
mod charts;
mod check;
mod compare;
mod design;
mod devices;
mod explain;
mod failure;
mod filler;
mod folders;
mod look;
mod merge;
mod new;
mod one_point;
mod optima;
mod output;
mod progress;
mod reading;
mod report;
mod results;
mod run;
mod schemas;
mod shells;
mod terminal;
mod verify;
mod whole;

use std::process::ExitCode;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};

use failure::{EXIT_CODES, Failure};

/// Monte Carlo studies for laser gyroscopes, with the same bits on every CPU and GPU.
#[derive(Debug, Parser)]
#[command(name = "sagnac", version, max_term_width = 110, after_long_help = after_help())]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    look: look::Options,
}

const EXAMPLES: &str = "\
Examples:
  sagnac run studies/error_vs_dtnu.toml
  sagnac run my.toml --trials 100000000 --device gpu
  sagnac run my.toml --shard 2/4 --time-limit 8h
  sagnac merge results/my/shard-* --out results/my
  sagnac check results/my
  sagnac design studies/design_point.toml
  sagnac filler quadratic --gap-ticks 3
  sagnac filler my.toml --at gap_ticks=3 --filler mv8+2 --test-vectors
  sagnac allan gyro.csv --data rate --unit deg/h --rate 100Hz --column gz
  sagnac compare before.csv after.csv --data rate --unit deg/h --rate 100Hz
  sagnac new gap-fill first.toml
  sagnac explain motion.amplitude
  sagnac verify";

/// Examples and exit codes.
fn after_help() -> String {
    let codes = EXIT_CODES.iter().map(|(code, meaning)| format!("\n  {code:8}  {meaning}"));
    format!("{EXAMPLES}\n\nExit codes:{}", codes.collect::<String>())
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run studies: sample what is missing, write the table and the charts
    ///
    /// Results go to a folder. Running again resumes; a larger --trials continues.
    Run(run::Options),
    /// Put results together: shares of a study, runs of several machines; in any order, any number of times
    Merge(merge::Options),
    /// Look whether results are sound, complete and what the tables say
    Check(check::Options),
    /// Make report.html of results again, and of several studies a gallery
    Report(report::Options),
    /// Draw results that are there with other axes, estimates or limits
    Chart(chart::Options),
    /// How often to switch, and with which filler: the recommendation, with evidence
    Design(design::Options),
    /// The weights of fillers for firmware: table, response over frequency, C header, test vectors
    Filler(filler::Options),
    /// Deviations of recorded logs: Allan, modified Allan, time, Hadamard, with intervals and noise types
    Allan(allan::Options),
    /// Two recorded logs: is one noisier than the other, in what, how sure is that, and how long must they be to tell
    Compare(compare::Options),
    /// List the devices that kernels can run on
    #[command(after_long_help = "Examples:\n  sagnac devices")]
    Devices,
    /// Prove that every kernel gives the same bits on every device, here and now
    Verify(Verify),
    /// Measure the throughput of the kernels
    Bench(Bench),
    /// Print the JSON schema of study files, or of what a command prints with --json
    Schema(schemas::Options),
    /// Write a commented study to begin with
    New(new::Options),
    /// What a key of a study, a column of results or an exit code means
    Explain(explain::Options),
    /// Print a script that completes commands and options in a shell
    Completions(shells::Completions),
    /// Write manual pages
    Man(shells::Man),
}

const VERIFY_EXAMPLES: &str = "\
Examples:
  sagnac verify
  sagnac verify --device cpu --trials 100000";

#[derive(Debug, Args)]
#[command(after_long_help = VERIFY_EXAMPLES)]
struct Verify {
    /// cpu, gpu, part of an adapter's name, or its PCI address: see `sagnac devices` [default: all adapters]
    #[arg(long, value_name = "DEVICE")]
    device: Option<String>,
    /// Units of work in all for each kernel: trials or samples over its configurations, or numbers
    #[arg(long, value_name = "N", default_value_t = 1 << 21, value_parser = verified)]
    trials: u64,
}

const BENCH_EXAMPLES: &str = "\
Examples:
  sagnac bench
  sagnac bench --device cpu --json";

#[derive(Debug, Args)]
#[command(after_long_help = BENCH_EXAMPLES)]
struct Bench {
    #[command(flatten)]
    device: DeviceArg,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct DeviceArg {
    /// auto, cpu, gpu, a width of the CPU such as avx2, part of an adapter's name, or its PCI address: see `sagnac devices`
    #[arg(help_heading = "Device", long = "device", value_name = "DEVICE", default_value = "auto")]
    name: String,
    /// Threads of the CPU [default: as many as it runs at once]
    #[arg(help_heading = "Device", long, value_name = "N", value_parser = threads)]
    threads: Option<usize>,
}

/// A number of units of work.
fn verified(text: &str) -> Result<u64, String> {
    whole::whole(text, 1..=1 << 32)
}

/// A number of threads.
fn threads(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|threads| (1..=4096).contains(threads))
        .ok_or_else(|| "expected 1 to 4096".to_owned())
}

/// Runs the program.
pub fn main() -> ExitCode {
    output::outlive_limits();
    let color = look::of_arguments(std::env::args_os());
    let matches = Cli::command().color(color).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    look::follow(&cli.look);
    let result = match &cli.command {
        Command::Run(options) => run::run(options),
        Command::Merge(options) => merge::merge(options),
        Command::Check(options) => check::check(options),
        Command::Report(options) => report::report(options),
        Command::Chart(options) => chart::chart(options),
        Command::Design(options) => design::design(options),
        Command::Filler(options) => filler::filler(options),
        Command::Allan(options) => allan::allan(options),
        Command::Compare(options) => compare::compare(options),
        Command::Devices => devices::devices(),
        Command::Verify(options) => verify::verify(options),
        Command::Bench(options) => bench::bench(options),
        Command::Schema(options) => schemas::schema(options),
        Command::New(options) => new::new(options),
        Command::Explain(options) => explain::explain(options),
        Command::Completions(options) => shells::completions(options, Cli::command()),
        Command::Man(options) => shells::man(options, Cli::command()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
