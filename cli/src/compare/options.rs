//! Options of `sagnac compare`.

use std::path::PathBuf;

use clap::Args;

use crate::reading::Reading;

const EXAMPLES: &str = "\
Examples:
  sagnac compare before.csv after.csv --data rate --unit deg/h --rate 100Hz
  sagnac compare gyro1.csv gyro2.csv --data rate --unit rad/s --time stamp --time-unit ns \\
    --column gz
  sagnac compare log.csv log.csv --data rate --unit deg/s --rate 100Hz --column gx,gy

Both logs are read with the same options, as `sagnac allan` reads them. If --column names two
columns, the first is read from A and the second from B. If the logs have time stamps, their
sampling rates may differ; the curves are compared at the averaging times that both have.";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// First log
    #[arg(value_name = "A")]
    pub a: PathBuf,
    /// Second log, which is compared with the first
    #[arg(value_name = "B")]
    pub b: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
    /// Results folder [default: results/<A>_vs_<B>]
    #[arg(help_heading = "Output", long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the results as JSON
    #[arg(help_heading = "Output", long)]
    pub json: bool,
    /// Print only errors
    #[arg(help_heading = "Output", long, short)]
    pub quiet: bool,
}
