//! `sagnac model`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::TypedValueParser;
use sagnac::analysis::model::search::MAX_STATES;
use sagnac::analysis::model::writers::{Writer, named};
use sagnac::analysis::model::{Aim, ModelRequest, Quantization};
use sagnac::use_cases::{ModelSource, model_noise};
use sagnac_base::quantity::Dimension;

use crate::allan::probability;
use crate::arg_parsers::{one_of, value_of};
use crate::failure::Failure;
use crate::output::{Output, print_documents};
use crate::reading::{Given, Reading, seconds};

const EXAMPLES: &str = "\
Examples:
  sagnac model noise.toml --from \"1 s\" --to \"10000 s\" --overbound
  sagnac model gyro.csv --data rate --unit deg/h --rate 100Hz --column gz --overbound
  sagnac model log.csv --data rate --unit rad/s --time stamp --time-unit ns --column gx,gy,gz \\
    --overbound --to \"4 s\" --write kalibr,openvins
  sagnac model gyro.csv --data rate --unit deg/h --rate 100Hz --column gz --overbound=repeat \\
    --filter-rate 50Hz --write all
  sagnac model noise.toml --from \"1 s\" --to \"1000 s\" --overbound --json

FILE is a log or a curve, which is read as by `sagnac allan`, or a noise.toml, whose name ends in .toml:
then the curve is that of its coefficients, with the intervals that `sagnac allan` wrote into it. The model is
white noise, a random walk and the fewest Gauss-Markov states, at most 3. Without --overbound its Allan
deviation lies within the 95 % band of the record, with --overbound nowhere below its upper end, and with
--overbound=repeat nowhere below the band that 95 % of further records of the same gyro and length have.";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    #[command(flatten)]
    given: Given,
    /// Recorded log, curve, or noise.toml
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Shortest averaging time that the model covers, as in "1 s" [default: the shortest of the log]
    #[arg(help_heading = "Model", long, value_name = "TIME", value_parser = seconds)]
    from: Option<f64>,
    /// Longest averaging time that the model covers, as in "10000 s" [default: a tenth of the log,
    /// or the next averaging time of its curve]
    #[arg(help_heading = "Model", long, value_name = "TIME", value_parser = seconds)]
    to: Option<f64>,
    /// Lie nowhere below the upper end of the band, instead of within it: of this record (band, also without a value), or of 95 % of
    /// further records of the same gyro and length, at all averaging times together (repeat)
    #[arg(help_heading = "Model", long, value_name = "WHAT", num_args = 0..=1, require_equals = true, default_missing_value = "band", value_parser = aims())]
    overbound: Option<Aim>,
    /// How far a bound may lie above, in percent, before a Markov state is added; also the band of a noise.toml without intervals
    #[arg(help_heading = "Model", long, value_name = "PERCENT", default_value = "20", value_parser = margin)]
    margin: f64,
    /// Number of Markov states, 0 to 3 [default: the fewest]
    #[arg(help_heading = "Model", long, value_name = "N", value_parser = states)]
    states: Option<usize>,
    /// What quantization is to the filter: measurement noise of the angle, or white noise of the rate
    #[arg(help_heading = "Model", long, value_name = "AS", default_value = "measurement", value_parser = quantization())]
    quantization: Quantization,
    /// Rate of the filter, for F, Q and R [default: that of the log]
    #[arg(help_heading = "Model", long, value_name = "RATE", value_parser = rate)]
    filter_rate: Option<f64>,
    /// Probability of the band
    #[arg(help_heading = "Model", long = "confidence", value_name = "P", default_value_t = 0.95, value_parser = probability)]
    band_confidence: f64,
    #[command(flatten)]
    output: Output,
    /// Also write files for tools: all, or one or more of kalibr, allan_variance_ros, openvins, matlab, navego, psins, gtsam_cpp,
    /// gtsam_python, pyins, kf_gins, px4, c, json, separated by commas
    #[arg(help_heading = "Output", long, value_name = "TOOLS", value_parser = named)]
    write: Option<std::vec::Vec<&'static Writer>>,
}

fn aims() -> impl TypedValueParser<Value = Aim> {
    one_of([("band", Aim::Bound), ("repeat", Aim::BoundRepeat)])
}

fn quantization() -> impl TypedValueParser<Value = Quantization> {
    one_of([("measurement", Quantization::Measurement), ("white", Quantization::White)])
}

fn margin(text: &str) -> Result<f64, String> {
    let percent: Option<f64> = text.trim_end_matches('%').trim().parse().ok();
    let percent = percent.filter(|percent| *percent > 0.0 && *percent <= 1000.0);
    percent.map(|percent| 0.01 * percent).ok_or_else(|| "not between 0 and 1000; write as in 20".to_owned())
}

fn states(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| *count <= MAX_STATES);
    count.ok_or_else(|| format!("expected 0 to {MAX_STATES}"))
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = value_of(text, Dimension::Frequency)?;
    if rate > 0.0 { Ok(rate) } else { Err("the rate is not positive".to_owned()) }
}

/// Finds the model of a log or of a noise.toml.
pub fn model(options: &Options) -> Result<(), Failure> {
    let (path, reading) = (&options.file, &options.reading);
    let request = ModelRequest {
        from_s: options.from,
        to_s: options.to,
        aim: options.overbound.unwrap_or(Aim::Describe),
        margin: options.margin,
        states: options.states,
        quantization: options.quantization,
        filter_hz: options.filter_rate,
        confidence: options.band_confidence,
        treatment: reading.treatment(),
        fitting: reading.fitting(),
        writers: options.write.clone().unwrap_or_default(),
    };
    let is_noise = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    // The options of logs mean nothing for a noise.toml.
    let curve = if is_noise { None } else { reading.curve(path, None)? };
    if curve.is_some() {
        options.given.check_curve(path)?;
    }
    let log = if is_noise || curve.is_some() { None } else { Some(reading.read(path, &reading.request()?)?) };
    let source = match (&curve, &log) {
        (Some(curve), _) => ModelSource::Curve(curve, path),
        (None, Some(log)) => ModelSource::Log(log, path),
        (None, None) => ModelSource::NoiseFile(path),
    };
    let outcome = model_noise(source, &request, &options.output.progress())?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let folder = options.output.folder(format!("{stem}_model"));
    let files: Vec<_> =
        outcome.files.iter().map(|(file, _)| folder.join(file).display().to_string()).collect();
    let places = (!files.is_empty()).then(|| format!("files for tools: {}", files.join(", ")));
    let document = options.output.finish(&outcome, &folder, [path.as_path()], places.as_slice())?;
    print_documents(document.as_slice(), 1)
}
