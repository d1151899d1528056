//! `sagnac convert`.

use clap::Args;
use sagnac::use_cases;

use crate::failure::Failure;
use crate::output::print;

const EXAMPLES: &str = "\
Examples:
  sagnac convert \"0.0135 deg/s/sqrt(Hz)\"
  sagnac convert 0.81deg/√h
  sagnac convert 0.05 deg/h
  sagnac convert 4 mdps/rtHz
  sagnac convert 120 ug/√Hz";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// A noise density, random walk, bias instability, quantization or power density with its unit, of gyros or accelerometers
    #[arg(required = true, value_name = "VALUE", allow_negative_numbers = true)]
    value: Vec<String>,
}

/// Prints a coefficient in the units and conventions of data sheets.
pub fn convert(options: &Options) -> Result<(), Failure> {
    let text = options.value.join(" ");
    let found = use_cases::convert(&text).map_err(|error| {
        let example = "give a number with its unit, as in \"0.0135 deg/s/sqrt(Hz)\" or \"0.05 deg/h\"";
        Failure::Usage(format!("{error}\n{example}"))
    })?;
    let width = found.rows.iter().map(|row| row.convention.chars().count()).max().unwrap_or(0);
    let mut lines = vec![format!("{} = {}", found.quantity, text)];
    let mut before = "";
    for row in &found.rows {
        let name = if row.convention == before { "" } else { row.convention };
        lines.push(format!("  {name:width$}  {}", row.text()));
        before = row.convention;
    }
    if !found.lines.is_empty() {
        lines.push("in a noise file, one of".to_owned());
        lines.extend(found.lines.iter().map(|line| format!("  {line}")));
    }
    print(&lines.join("\n"))
}
