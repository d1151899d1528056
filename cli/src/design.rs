//! `sagnac design`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use sagnac::analysis::design::filler_search::band;
use sagnac::analysis::design::{Constraints, DesignError, DesignRequest, Measure, Search, design as find};
use sagnac_base::quantity::Dimension;

use crate::arg_parsers::one_of;
use crate::failure::Failure;
use crate::filler::at_least_0;
use crate::output::spell;
use crate::program::{DeviceArg, Sampling};
use crate::progress::Shown;
use crate::{arg_parsers, reading};

const EXAMPLES: &str = "\
Examples:
  sagnac design studies/design_point.toml
  sagnac design studies/design_point.toml --by drift_rms --trials 10000 --plot
  sagnac design studies/design_point.toml --trials 10000 --search --latency \"20 ms\" --memory 600";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Study of kind = "switched-run". The candidates are its swept intervals; without such a sweep they are intervals
    /// that suit the run. Other swept keys are choices too: each combination of their values is tried
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// Estimate to minimize
    #[arg(long, value_parser = measures(), value_name = "ESTIMATE", default_value = "drift_p99_73")]
    by: Measure,
    /// Longest time from the end of the gap to the correction, such as "10 ms": fillers that read later ticks are left out
    #[arg(long, value_name = "TIME")]
    latency: Option<String>,
    /// Largest memory of a filler in firmware, its constants and its state on a 32-bit processor: larger fillers are left
    /// out
    #[arg(long, value_name = "BYTES", value_parser = memory)]
    memory: Option<u64>,
    /// Also try a handful of minimum-variance fillers that meet these constraints: of all numbers of ticks before and after
    /// the gap those that are worth their latency and memory
    #[arg(long)]
    search: bool,
    /// Frequency band of the vibration for which searched fillers are designed, such as "18 Hz,22 Hz" [default: that of
    /// the study's motion, with 5 % on either side]
    #[arg(long, value_name = "LOW,HIGH", requires = "search")]
    band: Option<String>,
    #[command(flatten)]
    device: DeviceArg,
    /// Output folder [default: design in results/<name of the study file>, or design_<estimate> for another --by than
    /// drift_p99_73]
    #[arg(help_heading = "Output", long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    sampling: Sampling,
}

impl Options {
    /// What the design is asked for.
    fn request(&self) -> Result<DesignRequest, Failure> {
        let latency_s = self.latency.as_deref().map(|text| at_least_0("--latency", text, Dimension::Time));
        let constraints = Constraints { latency_s: latency_s.transpose()?, memory_bytes: self.memory };
        let refused = |text: &str, why: String| Failure::Usage(format!("--band = {text}: {why}"));
        let band = self.band.as_deref().map(|text| band(text).map_err(|why| refused(text, why)));
        let band = band.transpose()?;
        Ok(DesignRequest { measure: self.by, constraints, search: self.search.then_some(Search { band }) })
    }
}

/// A number of bytes.
fn memory(text: &str) -> Result<u64, String> {
    arg_parsers::whole(text, 0..=1 << 32)
}

/// The measures, as options list them.
fn measures() -> impl TypedValueParser<Value = Measure> {
    let named =
        |measure: Measure| PossibleValue::new(measure.name()).help(measure.meaning().trim_end_matches('.'));
    one_of(Measure::ALL.map(|measure| (named(measure), measure)))
}

/// Finds and prints the best interval and filler.
pub fn design(options: &Options) -> Result<(), Failure> {
    let mut study = reading::study(&options.study)?;
    options.sampling.apply(&mut study);
    let request = options.request()?;
    let mut device = options.device.select(!options.sampling.printed.quiet)?;
    let shown = Shown::new(options.sampling.how());
    let mut found =
        find(&study, &request, &mut device, &shown).map_err(|error| match error.in_study(&study) {
            Ok(error) => Failure::Study(error),
            Err(DesignError::Decision(error)) => error.into(),
            Err(DesignError::Gpu(error)) => Failure::Gpu(error),
            Err(error) => Failure::Picture(error.to_string()),
        })?;
    shown.clear();
    let folder = options.sampling.folder(options.out.as_deref(), &options.study, &found.name);
    found.add_json("design.json", &spell);
    options.sampling.finish(&found, &folder)
}
