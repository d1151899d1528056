//! `sagnac psd`.

mod axes;
mod report;

use std::path::PathBuf;

use clap::Args;
use clap::builder::TypedValueParser;
use sagnac::allan::trend::Trend;
use sagnac::analysis::log::{self, Asked};
use sagnac::analysis::page::of_log;
use sagnac::analysis::requirement::Limit;
use sagnac::analysis::spectrum::{Analysis, densities, figures, notes, tables};
use sagnac::record::log::channel::Log;
use sagnac::spectrum::Welch;
use sagnac::store::folder::Folder;
use sagnac::table::Table;

use crate::allan::options::{probability, simulated};
use crate::charts::{plotted, write_figures};
use crate::failure::Failure;
use crate::limits;
use crate::output::{Output, print_json, write_or_remove, write_page};
use crate::reading::{Reading, seconds};
use crate::words::one_of;

const EXAMPLES: &str = "\
Examples:
  sagnac psd gyro.csv --data rate --unit deg/h --rate 100Hz --column gz
  sagnac psd log.csv --data rate --unit rad/s --time stamp --time-unit ns --column gx,gy,gz
  sagnac psd gyro.csv --data rate --unit deg/h --rate 100Hz --column gz --segment \"2 s\" --fit N,B
  sagnac psd gyro.csv --data rate --unit deg/h --rate 100Hz --column gz \\
    --limit \"floor=0.003 deg/sqrt(h)\"

The log is read as by `sagnac allan`, and no segment crosses a gap. Densities are one-sided: white
noise of the angle random walk N has 2N². The noise model of the Allan fit is drawn over them.";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Recorded log
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    segments: Segments,
    /// Number of simulated records from which the interval of the N of the fit is found; 0 uses closed forms [default:
    /// 1000, or 0 for more than 2 million samples of all columns]
    #[arg(long, value_name = "N", value_parser = simulated)]
    bootstrap: Option<usize>,
    /// Probability of the confidence intervals of densities and of the floor
    #[arg(long, value_name = "P", default_value_t = 0.95, value_parser = probability)]
    confidence: f64,
    /// Largest accepted value, which the decision is checked against, as in "N=0.003 deg/sqrt(h)": of Q, N, B, K, R, markov, sine of
    /// the fit, in_run_bias_stability, or of floor, the N of the spectrum; in the unit of gyros or of accelerometers; may be
    /// repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = limits::of_log)]
    limit: Vec<Limit>,
    #[command(flatten)]
    output: Output,
}

/// The segments of which spectra are made.
#[derive(Debug, Args)]
#[group(skip)]
pub struct Segments {
    /// Length of the segments of spectra, as in "100 s": longer ones resolve lower frequencies, shorter ones narrow the intervals
    /// [default: an eighth of the record, at most 16384 samples]
    #[arg(help_heading = "Spectrum", long, value_name = "TIME", value_parser = seconds)]
    segment: Option<f64>,
    /// What to remove from each segment: its mean (constant), or its straight line (linear)
    #[arg(help_heading = "Spectrum", long, value_name = "TREND", default_value = "constant", value_parser = trend())]
    segment_detrend: Trend,
}

impl Segments {
    /// The estimate of the densities of a log.
    pub fn welch(&self, log: &Log, confidence: f64) -> Welch {
        Welch {
            segment: self.segment.map(|length_s| libm::round(length_s / log.step_s) as usize),
            trend: self.segment_detrend,
            confidence,
        }
    }
}

/// Writes the tables and charts of the spectra, and removes those of an earlier run where there are none.
///
/// # Errors
/// The disk fails.
pub fn save(analysis: &Analysis, folder: &Folder) -> Result<(), Failure> {
    type Made = fn(&Analysis) -> Table;
    let all: [(&str, Made); 3] =
        [("psd.csv", tables::table), ("lines.csv", tables::lines), ("white_noise.csv", tables::white_noise)];
    for (name, table) in all {
        write_or_remove(folder, name, (!analysis.spectra.is_empty()).then(|| table(analysis)))?;
    }
    write_figures(folder, &figures::figures(analysis))
}

fn trend() -> impl TypedValueParser<Value = Trend> {
    one_of([("constant", Trend::None), ("linear", Trend::Linear)])
}

/// Computes the spectra of a log.
pub fn psd(options: &Options) -> Result<(), Failure> {
    limits::agree(&options.limit, &options.reading)?;
    let log = options.reading.read(&options.file, &options.reading.request()?)?;
    limits::apply(&options.limit, &log)?;
    let analysis = analysis(options, &log)?;
    let decision = analysis.decision(&options.limit);
    let folder = options.output.folder(options.file.file_stem().unwrap_or_default());
    let figures = figures::figures(&analysis);
    let results = Folder::open(&folder)?.reading([options.file.as_path()]);
    save(&analysis, &results)?;
    write_page(&results, &of_log(&log, &analysis, decision.answer.clone(), None, vec![]))?;
    if options.output.json {
        return print_json(&tables::document(&analysis, &decision));
    }
    let answer = &decision.answer;
    options.output.printed.show(
        &log::notes::heading(&analysis.noise),
        answer,
        &notes::notes(&analysis),
        || plotted(figures),
        || Ok(report::report(&analysis)),
    )?;
    options.output.whereabouts(&folder);
    Ok(())
}

/// Analyses the log. The densities come first, because they are quick and may fail.
fn analysis(options: &Options, log: &Log) -> Result<Analysis, Failure> {
    let treatment = options.reading.treatment();
    let welch = options.segments.welch(log, options.confidence);
    let densities = densities(log, &treatment, &welch)?;
    // The curve is on the page, as `sagnac allan` draws it.
    let asked = Asked {
        confidence: options.confidence,
        fitting: options.reading.fitting(),
        simulated: options.bootstrap,
        ..Asked::default()
    };
    let noise = log::Analysis::of(log, &options.file, &treatment, &asked, &options.output.progress())?;
    Ok(Analysis::of(noise, densities))
}
