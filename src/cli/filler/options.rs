//! The options, and the study they make where none is given.

use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use miette::Diagnostic;
use sagnac::study::{POLYNOMIALS, Study};

use super::Failure;

/// Most test vectors.
const MOST_VECTORS: i64 = 1_000_000;

#[derive(Debug, Args)]
pub struct Options {
    /// Study file
    #[arg(value_name = "STUDY", required_unless_present = "gap_ticks")]
    pub file: Option<PathBuf>,
    /// Point of a study with sweeps: value of a swept key, such as frequency="20 Hz" [default: the first point]
    #[arg(long, value_name = "KEY=VALUE", requires = "file")]
    pub at: Vec<String>,
    /// Only this filler of the study; may be given again
    #[arg(long = "filler", value_name = "NAME", requires = "file")]
    pub fillers: Vec<String>,
    /// Folder of weights.csv, response.svg, response.png and sagnac_filler.h [default: results/<name of the study file>/filler]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Also write test_vectors.csv with this many inputs for each filler, and what it makes of them
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_VECTORS))]
    pub test_vectors: Option<u32>,
    /// Print the weights as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    polynomials: Polynomials,
}

/// Polynomials without a study.
#[derive(Debug, Args)]
#[command(next_help_heading = "Polynomials without a study")]
struct Polynomials {
    /// Lost ticks n
    #[arg(long, value_name = "N", conflicts_with = "file", requires = "tick")]
    gap_ticks: Option<u32>,
    /// Length of a tick, such as "5 ms"
    #[arg(long, value_name = "TIME", requires = "gap_ticks")]
    tick: Option<String>,
    /// Which one; may be given again [default: all]
    #[arg(long, value_name = "ORDER", requires = "gap_ticks", value_parser = PossibleValuesParser::new(POLYNOMIALS))]
    order: Vec<String>,
    /// Ticks that the residual is fitted to, such as "-7..0,n+1,n+2" [default: -1,0,n+1,n+2]
    #[arg(long, value_name = "TICKS", requires = "gap_ticks", allow_hyphen_values = true)]
    fit_ticks: Option<String>,
    /// Ticks that the extrapolation is fitted to [default: -3..0]
    #[arg(long, value_name = "TICKS", requires = "gap_ticks", allow_hyphen_values = true)]
    extrapolation_ticks: Option<String>,
}

impl Options {
    /// The study that the options name or make.
    ///
    /// # Errors
    /// Those of a study file; those of a study made of options are errors of usage.
    pub fn study(&self) -> Result<Study, Failure> {
        if let Some(file) = &self.file {
            return Ok(Study::read(file)?);
        }
        Study::parse("options", &self.polynomials.text()).map_err(|error| {
            let help = error.help().map_or_else(String::new, |help| format!("\n{help}"));
            Failure::Usage(format!("{error}{help}"))
        })
    }
}

impl Polynomials {
    /// A study of these polynomials in a base at rest: weights depend on no motion.
    fn text(&self) -> String {
        let quoted = |texts: &[&str]| {
            let each = texts.iter().map(|text| toml::Value::from(text.trim()).to_string());
            format!("[{}]", each.collect::<Vec<_>>().join(", "))
        };
        let orders: Vec<&str> = match &self.order[..] {
            [] => POLYNOMIALS.to_vec(),
            chosen => chosen.iter().map(String::as_str).collect(),
        };
        let n = self.gap_ticks.unwrap_or_default();
        let plural = if n == 1 { "" } else { "s" };
        let tick = toml::Value::from(self.tick.as_deref().unwrap_or_default());
        let mut text = format!(
            "title = \"Polynomials over {n} lost tick{plural}\"\nkind = \"gap-fill\"\n\
             [gyro]\ntick = {tick}\ntick_noise = {{ std = \"0 arcsec\" }}\n\
             [motion]\nrate = \"0 arcsec/s\"\n\
             [switching]\ngap_ticks = {n}\nfillers = {}\n",
            quoted(&orders)
        );
        for (key, list) in
            [("fit_ticks", &self.fit_ticks), ("extrapolation_ticks", &self.extrapolation_ticks)]
        {
            if let Some(list) = list {
                text += &format!("{key} = {}\n", quoted(&list.split(',').collect::<Vec<_>>()));
            }
        }
        text
    }
}
