//! `sagnac filler`.

use std::path::{Path, PathBuf};

use crate::arg_parsers::on;
use crate::failure::Failure;
use crate::output::finish;
use crate::output::{Printed, print_documents};
use crate::reading;
use clap::Args;
use sagnac::analysis::firmware::{
    Alone, Asked, ChoiceError, FillerRequest, FillerSource, KINDS, MINIMUM_VARIANCE, filler as find,
    in_properties,
};
use sagnac_base::quantity::{Dimension, parse};

/// Shows the weights of fillers at one point, and writes the files for firmware.
pub fn filler(options: &Options) -> Result<(), Failure> {
    let (request, stem) = options.request()?;
    let (_, found) = find(&request).map_err(|error| match (&request.source, error) {
        // Nobody knows the text of the study of properties.
        (FillerSource::Alone { .. }, ChoiceError::Study(error)) => {
            let option = |property: &str| format!("--{}", property.replace('_', "-"));
            Failure::Usage(in_properties(&error, option))
        }
        (_, error) => error.into(),
    })?;
    let usual = || Path::new("results").join(stem).join(&found.name);
    let folder = options.out.clone().unwrap_or_else(usual);
    let places = [format!("C header  {}", folder.join("sagnac_filler.h").display())];
    let document = finish(&found, &folder, [], &places, options.json, &options.printed)?;
    print_documents(document.as_slice(), 1)
}

/// Largest number of test vectors.
const MAX_VECTORS: i64 = 1_000_000;

const EXAMPLES: &str = "\
Examples:
  sagnac filler quadratic --gap-ticks 3
  sagnac filler my.toml --at gap_ticks=3 --filler mv8+2 --test-vectors
  sagnac filler my.toml --at gap_ticks=3 --limit \"residual=20 arcsec\" --latency \"40 ms\"
  sagnac filler minimum-variance --gap-ticks 3 --tick \"5 ms\" --fit-ticks=\"-7..0,n+1,n+2\" \\
    --band \"18 Hz,22 Hz\" --amplitude \"12000 arcsec/s\" --noise \"0.5 arcsec\"
  sagnac filler minimum-variance --gap-ticks 3 --tick \"5 ms\" --limit \"residual=8 arcsec\" \\
    --latency \"20 ms\" --band \"18 Hz,22 Hz\" --amplitude \"12000 arcsec/s\" --noise \"0.5 arcsec\"";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Study file, or without a study one or more of const, linear, quadratic and minimum-variance
    #[arg(required = true, value_name = "STUDY|FILLER")]
    what: Vec<String>,
    /// Value of a swept key that selects the point of the study, such as frequency="20 Hz"; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    at: Vec<String>,
    /// Only this filler of the study; may be repeated
    #[arg(long = "filler", value_name = "NAME")]
    fillers: Vec<String>,
    /// Output folder [default: results/<name of the study file, or of the filler>/filler]
    #[arg(help_heading = "Output", long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Also write test_vectors.csv with this many inputs for each filler and the expected outputs; 1000 if N is left
    /// out
    #[arg(help_heading = "Output", long, value_name = "N", num_args = 0..=1, default_missing_value = "1000",
          value_parser = clap::value_parser!(u32).range(1..=MAX_VECTORS))]
    test_vectors: Option<u32>,
    /// Print the weights as JSON
    #[arg(help_heading = "Output", long)]
    json: bool,
    #[command(flatten)]
    printed: Printed,
    #[command(flatten)]
    alone: Given,
}

impl Options {
    /// The request, and the name of the study file or of the fillers.
    ///
    /// # Errors
    /// An option does not apply or is missing, or the study cannot be read.
    fn request(&self) -> Result<(FillerRequest, PathBuf), Failure> {
        let vectors = self.test_vectors.map(|count| count as usize);
        let Some(file) = self.file()? else {
            let (kinds, properties) = (self.what.clone(), self.alone.properties(&self.what)?);
            let (source, search) = (FillerSource::Alone { kinds, properties }, self.alone.asked(&self.what)?);
            return Ok((FillerRequest { source, search, vectors }, self.what.join("+").into()));
        };
        let study = Box::new(reading::study(file)?);
        let search = self.alone.asked_of_study()?;
        if search.is_some() && !self.fillers.is_empty() {
            let message = "--limit and --latency search a filler of their own\nleave --filler out";
            return Err(Failure::Usage(message.to_owned()));
        }
        let source = FillerSource::Study { study, at: self.at.clone(), names: self.fillers.clone() };
        let stem = file.file_stem().map(PathBuf::from).unwrap_or_default();
        Ok((FillerRequest { source, search, vectors }, stem))
    }

    /// The study file; `None` where the arguments before the options are kinds of fillers.
    fn file(&self) -> Result<Option<&Path>, Failure> {
        let unknown: Vec<&String> = self.what.iter().filter(|what| !KINDS.contains(&what.as_str())).collect();
        let message = match (&unknown[..], self.alone.given()) {
            ([], _) if !self.at.is_empty() || !self.fillers.is_empty() => {
                "--at and --filler select from a study, but none is given\nleave them out".to_owned()
            }
            ([], _) => return Ok(None),
            ([_], None) if self.what.len() == 1 => return Ok(Some(Path::new(&self.what[0]))),
            ([name, ..], Some(option)) => format!(
                "{option} describes a filler without a study, but `{name}` is not a filler\naccepted: {}; a study says it in \
                 its file",
                KINDS.join(", ")
            ),
            ([name, ..], None) => format!(
                "`{name}` is not a filler\naccepted: one study file, or one or more of {}",
                KINDS.join(", ")
            ),
        };
        Err(Failure::Usage(message))
    }
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Without a study")]
struct Given {
    /// Number n of lost ticks
    #[arg(long, value_name = "N")]
    gap_ticks: Option<u32>,
    /// Length of a tick, such as "5 ms"; not needed for polynomials
    #[arg(long, value_name = "TIME")]
    tick: Option<String>,
    /// Ticks to which the residual is fitted, such as "-7..0,n+1,n+2" [default: -1,0,n+1,n+2]
    #[arg(long, value_name = "TICKS")]
    fit_ticks: Option<String>,
    /// Ticks to which the extrapolation is fitted [default: -3..0, or for minimum-variance the fit ticks up to 0]
    #[arg(long, value_name = "TICKS")]
    extrapolation_ticks: Option<String>,
    /// Frequency band of the vibration, such as "18 Hz,22 Hz", or a single frequency
    #[arg(long, value_name = "LOW,HIGH", requires_all = ["tick", "amplitude"])]
    band: Option<String>,
    /// Amplitude of the vibration as a rate or an angle, such as "12000 arcsec/s"
    #[arg(long, value_name = "RATE", requires = "band")]
    amplitude: Option<String>,
    /// Standard deviation of the noise of a tick, such as "0.5 arcsec"
    #[arg(long, value_name = "ANGLE")]
    noise: Option<String>,
    /// Search the fit ticks of minimum-variance: the first after the gap, and then the fewest, with which 99.73 % of
    /// residuals are at most this angle, as in "residual=8 arcsec", also if the frequencies are 5 % lower or higher; of a study for its motion, which may
    /// be recorded, and by default its own limit
    #[arg(long, value_name = "NAME=VALUE", conflicts_with = "fit_ticks")]
    limit: Option<String>,
    /// Search the fit ticks of minimum-variance among those that come at most this time after the gap, such as "20 ms"; also
    /// of a study [default: 16 ticks]
    #[arg(long, value_name = "TIME", conflicts_with = "fit_ticks")]
    latency: Option<String>,
}

/// An option that is a text.
struct TextOption<'a> {
    name: &'static str,
    value: &'a Option<String>,
    /// An example, if a minimum-variance filler needs the option.
    example: Option<&'static str>,
}

impl Given {
    fn texts(&self) -> [TextOption<'_>; 6] {
        let needed = |name, value, example| TextOption { name, value, example: Some(example) };
        let optional = |name, value| TextOption { name, value, example: None };
        [
            needed("--tick", &self.tick, "\"5 ms\""),
            optional("--fit-ticks", &self.fit_ticks),
            optional("--extrapolation-ticks", &self.extrapolation_ticks),
            needed("--band", &self.band, "\"18 Hz,22 Hz\""),
            needed("--amplitude", &self.amplitude, "\"12000 arcsec/s\""),
            needed("--noise", &self.noise, "\"0.5 arcsec\""),
        ]
    }

    /// The name of one option that is given, if any.
    fn given(&self) -> Option<&'static str> {
        let text = self.texts().into_iter().find(|text| text.value.is_some()).map(|text| text.name);
        self.gap_ticks.map(|_| "--gap-ticks").or(text)
    }

    /// What a search of the fit ticks of a study is asked for; `None` without a search.
    ///
    /// # Errors
    /// A text is not such a quantity.
    fn asked_of_study(&self) -> Result<Option<Asked>, Failure> {
        let value = |name: &str, text: &Option<String>, dimension| {
            text.as_ref().map(|text| at_least_0(name, text, dimension)).transpose()
        };
        let limit = self.limit.as_deref().map(|text| on(text, &["residual", "p99_73"])).transpose()?;
        let limit_arcsec = value("--limit", &limit.map(str::to_owned), Dimension::Angle)?;
        let latency_s = value("--latency", &self.latency, Dimension::Time)?;
        let is_asked = limit_arcsec.or(latency_s).is_some();
        Ok(is_asked.then_some(Asked { limit_arcsec, latency_s }))
    }

    /// What a search of the fit ticks of fillers without a study is asked for; `None` without a search.
    ///
    /// # Errors
    /// It is not a minimum-variance filler, the vibration is missing, or a text is not such a quantity.
    fn asked(&self, kinds: &[String]) -> Result<Option<Asked>, Failure> {
        let name = if self.limit.is_some() { "--limit" } else { "--latency" };
        if self.limit.is_none() && self.latency.is_none() {
            return Ok(None);
        }
        if self.band.is_none() {
            let message = format!(
                "{name} searches ticks for a vibration, but there is none\nadd --band, or give a study"
            );
            return Err(Failure::Usage(message));
        }
        if kinds != [MINIMUM_VARIANCE] {
            let message = format!(
                "{name} searches the ticks of one filler, `{MINIMUM_VARIANCE}`, not of `{}`\nleave it out",
                kinds.join(" ")
            );
            return Err(Failure::Usage(message));
        }
        self.asked_of_study()
    }

    /// The properties of fillers of these kinds.
    ///
    /// # Errors
    /// An option that the fillers require is missing.
    fn properties(&self, kinds: &[String]) -> Result<Alone, Failure> {
        let missing = |option: &str, example: &str, of: &str| {
            Failure::Usage(format!("{option} is missing: {of}\nadd for example {option} {example}"))
        };
        let gap_ticks =
            self.gap_ticks.ok_or_else(|| missing("--gap-ticks", "3", "the number of lost ticks"))?;
        if kinds.iter().any(|kind| kind == MINIMUM_VARIANCE) {
            let of = "a minimum-variance filler is designed for a given vibration and noise";
            for TextOption { name, value, example } in self.texts() {
                if let (None, Some(example)) = (value, example) {
                    return Err(missing(name, example, of));
                }
            }
        }
        Ok(Alone {
            gap_ticks,
            tick: self.tick.clone(),
            fit_ticks: self.fit_ticks.clone(),
            extrapolation_ticks: self.extrapolation_ticks.clone(),
            band: self.band.clone(),
            amplitude: self.amplitude.clone(),
            noise: self.noise.clone(),
        })
    }
}

/// The value of an option that is a quantity of at least 0.
///
/// # Errors
/// The text is not such a quantity.
pub fn at_least_0(name: &str, text: &str, dimension: Dimension) -> Result<f64, Failure> {
    let refused = |what: String| Failure::Usage(format!("{name} = {text}: {what}"));
    let value = parse(text, &[dimension]).map_err(|error| refused(error.to_string()))?.value;
    if value >= 0.0 { Ok(value) } else { Err(refused("it is below 0".to_owned())) }
}
