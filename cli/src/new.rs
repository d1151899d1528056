//! `sagnac new`: a study file to begin with.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::failure::Failure;
use crate::output::print;

const EXAMPLES: &str = "\
Examples:
  sagnac new gap-fill
  sagnac new switched-run my_run.toml";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// What is to be studied
    #[arg(value_name = "KIND", value_enum)]
    kind: Template,
    /// Where it is written [default: <KIND>.toml]
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Template {
    /// The error of the angle when the ticks lost at a mode switch are filled in
    GapFill,
    /// The Allan curve of a gyro that you describe, and how well its coefficients are found again
    Allan,
    /// What the perimeter loop fakes after a mode switch, and what compensations leave of it
    Relock,
    /// Bound and drift of a gyro that switches modes, in closed form
    DriftBudget,
    /// The response of an elastic suspension to vibration, in closed form
    Suspension,
    /// Whole runs of a gyro that switches modes
    SwitchedRun,
}

impl Template {
    fn text(self) -> &'static str {
        match self {
            Template::GapFill => include_str!("new/gap-fill.toml"),
            Template::Allan => include_str!("new/allan.toml"),
            Template::Relock => include_str!("new/relock.toml"),
            Template::DriftBudget => include_str!("new/drift-budget.toml"),
            Template::Suspension => include_str!("new/suspension.toml"),
            Template::SwitchedRun => include_str!("new/switched-run.toml"),
        }
    }
}

/// Writes a commented study, where no file is yet.
pub fn new(options: &Options) -> Result<(), Failure> {
    let kind = options.kind.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
    let path = options.file.clone().unwrap_or_else(|| PathBuf::from(format!("{kind}.toml")));
    let made = OpenOptions::new().write(true).create_new(true).open(&path);
    let written = made.and_then(|mut file| file.write_all(options.kind.text().as_bytes()));
    written.map_err(|source| match source.kind() {
        ErrorKind::AlreadyExists => Failure::Usage(format!(
            "{} is there already and stays as it is\nname another file: sagnac new {kind} FILE",
            path.display()
        )),
        _ => Failure::Write { path: path.clone(), source },
    })?;
    let path = path.display();
    print(&format!("wrote {path}\nchange it, then run it: sagnac run {path} --plot"))
}
