//! `sagnac allan`.

use std::path::{Path, PathBuf};

use crate::arg_parsers::{self, one_of};
use crate::failure::Failure;
use crate::output::{Output, print_documents, save, write_new};
use crate::reading::{Given, Reading, seconds};
use clap::Args;
use clap::builder::TypedValueParser;
use sagnac::allan::angles::Trend;
use sagnac::allan::deviation::{Deviation, Taus};
use sagnac::analysis::log::{NoiseRequest, Suppose};
use sagnac::analysis::navigators::NavigatorRequest;
use sagnac::analysis::requirement::Limit;
use sagnac::progress::Silent;
use sagnac::record::log::Log;
use sagnac::record::log::measure::Data;
use sagnac::report::page::FILE as REPORT;
use sagnac::use_cases::{self, AllanRequest};
use sagnac_base::quantity::{Dimension, Quantity, parse};
use sagnac_engine::kinds::allan::run::MIN_REALIZATIONS;

/// Analyses the logs one after the other.
pub fn allan(options: &Options) -> Result<(), Failure> {
    let request = options.reading.request()?;
    options.check()?;
    let allan = options.request()?;
    let folders = folders(options)?;
    let mut documents: Vec<String> = Vec::new();
    let mut earlier = vec![];
    for (path, folder) in options.files.iter().zip(&folders) {
        if let Some(curve) = options.reading.curve(path, Some(options.confidence))? {
            options.given.check_curve(path)?;
            let fitting = allan.noise.fitting.as_ref();
            let outcome = use_cases::fit_curve(curve, path, fitting, &allan.limits)?;
            documents.extend(options.output.finish(&outcome, folder, [path.as_path()], &[])?);
            continue;
        }
        let mut log = options.reading.read_as_recorded(path, &request)?;
        options.check_record(&log)?;
        if let Some(first) = allan.first(&log) {
            save_first(options, log.clone(), path, folder, &first, &mut earlier.clone())?;
        }
        let outcome = use_cases::allan(&mut log, path, &allan, &mut earlier, &options.output.progress())?;
        let mut places = vec![];
        if let Some(path) = &options.record {
            write_new(path, |file| allan.treatment.applied(log).write_csv(file))?;
            places.push(format!("the record as it is analysed is {}", path.display()));
        }
        documents.extend(options.output.finish(&outcome, folder, [path.as_path()], &places)?);
    }
    print_documents(&documents, options.files.len())
}

/// Writes the first page of a log, and prints its headline as a note.
fn save_first(
    options: &Options,
    mut log: Log,
    path: &Path,
    folder: &Path,
    request: &AllanRequest,
    earlier: &mut Vec<(u64, String)>,
) -> Result<(), Failure> {
    let mut first = use_cases::allan(&mut log, path, request, earlier, &Silent)?;
    first.page.notes.insert(0, format!("{FIRST}; the page is written again with them"));
    save(&first, folder, [path])?;
    if !options.output.json && !options.output.printed.quiet {
        let report = folder.join(REPORT);
        note!("{}: {FIRST}; {} has the rest", first.page.answer.headline, report.display());
    }
    Ok(())
}

/// The note that a first page is not complete.
const FIRST: &str = "intervals of coefficients from simulated records, and navigators, follow";

/// The results folder of each file.
fn folders(options: &Options) -> Result<Vec<PathBuf>, Failure> {
    if options.output.out.is_some() && options.files.len() > 1 {
        let message =
            "--out names one folder, but there are several files\ngive them one by one, or leave out --out";
        return Err(Failure::Usage(message.to_owned()));
    }
    let mut folders: Vec<PathBuf> = Vec::new();
    for path in &options.files {
        let folder = options.output.folder(path.file_stem().unwrap_or_default());
        if folders.contains(&folder) {
            let message = format!(
                "several files would write to {}, the last one {}\ngive them one by one, each with its --out DIR",
                folder.display(),
                path.display()
            );
            return Err(Failure::Usage(message));
        }
        folders.push(folder);
    }
    Ok(folders)
}

/// Examples, shown after the options.
pub const EXAMPLES: &str = "\
Examples:
  sagnac allan gyro.csv --data rate --unit deg/h --rate 100Hz --column gz
  sagnac allan log.csv --data rate --unit rad/s --time stamp --time-unit ns --column gx,gy,gz
  sagnac allan pulses.npy --data increment --scale \"0.5 arcsec/pulse\" --rate 400Hz --skip \"30 min\"
  sagnac allan gyro.csv --data rate --unit deg/h --rate 100Hz --column gz --dynamic \"10 s\"
  sagnac allan gyro.csv --data rate --unit deg/h --rate 100Hz --column gz \\
    --navigate \"1 h\" --position-limit \"0.5 nmi\"
  sagnac allan log.csv --data rate --unit rad/s --time-unit ns --column gz --temperature temp
  sagnac allan log.csv --data rate --unit rad/s --time-unit ns --column gz --temperature temp \\
    --compensate --remove-outliers --record compensated.csv
  sagnac allan imu.mcap --data rate
  sagnac allan imu.csv --data rate --time time --column gx,gy,gz,ax,ay,az \\
    --unit deg/s,deg/s,deg/s,g,g,g
  sagnac allan PHASE.DAT --data angle --unit none --rate 1Hz --deviation oadev,hdev --tau decade10
  sagnac allan gyro.csv --data rate --unit deg/h --rate 100Hz --column gz \\
    --limit \"N=0.003 deg/sqrt(h)\" --limit \"in_run_bias_stability=0.01 deg/h\"
  sagnac allan curve.csv --unit deg/h --curve-interval 10%

A file with a column tau is a curve, such as tau,adev of a paper, Stable32 or allantools: it is fitted
as it is. Files are text (CSV, TSV, semicolons or blanks between columns, decimal points or commas, a
header or none, comments behind # % ;), Stable32 .DAT, NumPy .npy and .npz, MATLAB .mat, HDF5,
MCAP and ROS bags with sensor_msgs/Imu, PX4 .ulg, ArduPilot .bin, or raw binary with --binary, all
of them also as .gz. Empty cells, NaN and missing time stamps are gaps, with --rate too. The
deviations omit every difference that touches a gap.
Units tell gyros from accelerometers; without --column all columns whose units fit are read.
--json prints an object, or an array of objects for several files.";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    #[command(flatten)]
    given: Given,
    /// Logs, or curves
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// Averaging times: octave, decade10, decade20, all, or seconds separated by commas
    #[arg(long, value_name = "TAUS", default_value = "octave", value_parser = taus)]
    pub tau: Taus,
    /// Deviations: one or more of adev, oadev, mdev, tdev, hdev, ohdev, totdev, mtotdev, theo1, theoh, pdev, mtie, separated by commas
    #[arg(long, value_name = "NAMES", default_value = "oadev", value_delimiter = ',')]
    pub deviation: Vec<Deviation>,
    /// Number of simulated records from which the intervals of the coefficients are found; 0 uses closed forms
    /// [default: 1000, or 0 for more than 2 million samples of all columns]
    #[arg(long, value_name = "N", value_parser = simulated)]
    bootstrap: Option<usize>,
    /// Probability of the confidence intervals of deviations
    #[arg(long, value_name = "P", default_value_t = 0.95, value_parser = probability)]
    pub confidence: f64,
    /// Noise that these intervals suppose: that of the whole record, or that of each averaging time as in Stable32
    #[arg(long, value_name = "NOISE", default_value = "record", value_parser = suppose())]
    pub intervals: Suppose,
    /// Also give the Allan deviation over time, in windows of this length that overlap by half, as in "10 min", and whether the
    /// noise changes [default of WINDOW: a sixteenth of the record]
    #[arg(long, value_name = "WINDOW", num_args = 0..=1, value_parser = seconds)]
    pub dynamic: Option<Option<f64>>,
    /// Also give the position error that 95 % of navigators with three such gyros stay within after this time, as in "1 h": aligned
    /// and calibrated for 10 min at a latitude of 60°, then at rest. Writes navigation.toml, the study behind it
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    pub navigate: Option<f64>,
    /// Largest accepted position error of these navigators, which the decision is checked against, as in "0.5 nmi"
    #[arg(long, value_name = "DISTANCE", requires = "navigate", value_parser = distance)]
    pub position_limit: Option<Quantity>,
    /// Largest accepted value, which the decision is checked against, as in "N=0.003 deg/sqrt(h)": of Q, N, B, K, R, markov, sine,
    /// in_run_bias_stability, or of floor, the N of the spectrum; in the unit of gyros or of accelerometers; may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = arg_parsers::of_log)]
    pub limit: Vec<Limit>,
    #[command(flatten)]
    pub segments: Segments,
    /// Leave out the spectrum
    #[arg(help_heading = "Spectrum", long)]
    pub no_psd: bool,
    #[command(flatten)]
    pub output: Output,
    /// Former option, which wrote an imu.yaml
    #[arg(long, hide = true)]
    kalibr: Option<PathBuf>,
    /// Also write the record as it is analysed, with outliers and events removed and the temperature compensated where that is asked
    /// for, as CSV that is read again with --data alone
    #[arg(help_heading = "Output", long, value_name = "FILE.csv")]
    pub record: Option<PathBuf>,
}

impl Options {
    /// The request for each log.
    ///
    /// # Errors
    /// The limits do not fit the fit, or there is no fit where one is needed.
    pub fn request(&self) -> Result<AllanRequest, Failure> {
        let Segments { segment: length_s, segment_detrend: trend } = self.segments;
        let limit = self.position_limit;
        let request = AllanRequest {
            treatment: self.reading.treatment(),
            noise: NoiseRequest {
                taus: self.tau.clone(),
                deviations: self.deviation.clone(),
                confidence: self.confidence,
                intervals: self.intervals,
                fitting: self.reading.fitting(),
                simulated: self.bootstrap,
                simulator: None,
            },
            segments: (!self.no_psd).then_some(use_cases::Segments { length_s, trend, is_required: false }),
            effects: self.reading.temperature_terms.clone(),
            is_compensated: self.reading.compensate,
            window_s: self.dynamic,
            navigators: self.navigate.map(|duration_s| NavigatorRequest { duration_s, limit }),
            limits: self.limit.clone(),
        };
        request.check()?;
        Ok(request)
    }

    /// Checks that the options agree with each other.
    ///
    /// # Errors
    /// Results of several logs do not fit into one file, or the record cannot be written.
    pub fn check(&self) -> Result<(), Failure> {
        if self.kalibr.is_some() {
            let gone = "--kalibr is gone\n`sagnac model LOG --write kalibr` writes the file";
            return Err(Failure::Usage(gone.to_owned()));
        }
        if self.record.is_some() && self.files.len() > 1 {
            let message = "--record names one file, but there are several logs\ngive them one by one, each with its --record FILE";
            return Err(Failure::Usage(message.to_owned()));
        }
        if let Some(path) = self.record.as_ref().filter(|path| path.exists()) {
            let message = format!("--record {} would replace a file\ngive another FILE", path.display());
            return Err(Failure::Usage(message));
        }
        Ok(())
    }

    /// Checks that the record can be written.
    pub fn check_record(&self, log: &Log) -> Result<(), Failure> {
        if self.record.is_none() {
            return Ok(());
        }
        let treatment = self.reading.treatment();
        if log.data == Data::Angle && (treatment.outliers_removed || treatment.events_removed) {
            let message = "--record cannot write angles of which increments are missing\nleave out --remove-outliers and --remove-events";
            return Err(Failure::Usage(message.to_owned()));
        }
        Ok(())
    }
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
    #[arg(
        help_heading = "Spectrum",
        long,
        value_name = "TREND",
        default_value = "constant",
        value_parser = trend()
    )]
    segment_detrend: Trend,
}

fn trend() -> impl TypedValueParser<Value = Trend> {
    one_of([("constant", Trend::None), ("linear", Trend::Linear)])
}

fn suppose() -> impl TypedValueParser<Value = Suppose> {
    one_of([("record", Suppose::Record), ("stable32", Suppose::Stable32)])
}

pub(crate) fn probability(text: &str) -> Result<f64, String> {
    let inside = |p: &f64| *p > 0.0 && *p < 1.0;
    text.parse().ok().filter(inside).ok_or_else(|| "not between 0 and 1; write as in 0.95".to_owned())
}

/// Most simulated records.
const MAX_REALIZATIONS: usize = 100_000;

pub(crate) fn simulated(text: &str) -> Result<usize, String> {
    let is_accepted = |count: &usize| *count == 0 || (MIN_REALIZATIONS..=MAX_REALIZATIONS).contains(count);
    text.parse().ok().filter(is_accepted).ok_or_else(|| {
        format!(
            "give 0, or {MIN_REALIZATIONS} to {MAX_REALIZATIONS}: fewer do not resolve the 2.5 % quantiles, and more change no \
             digit of them"
        )
    })
}

fn distance(text: &str) -> Result<Quantity, String> {
    let found = parse(text, &[Dimension::Distance])
        .map_err(|error| format!("{error}; write a distance, as in \"0.5 nmi\""))?;
    if found.value > 0.0 { Ok(found) } else { Err("the distance is not positive".to_owned()) }
}

fn taus(text: &str) -> Result<Taus, String> {
    match text {
        "octave" => Ok(Taus::Octave),
        "decade10" => Ok(Taus::Decade(10)),
        "decade20" => Ok(Taus::Decade(20)),
        "all" => Ok(Taus::All),
        list => {
            let seconds: Result<Vec<f64>, _> = list.split(',').map(|tau| tau.trim().parse()).collect();
            let wrong = "not octave, decade10, decade20 or all, nor seconds as in 1,10,100";
            seconds.map(Taus::Seconds).map_err(|_| wrong.to_owned())
        }
    }
}
