//! What `sagnac allan` is asked for.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sagnac::allan::{Deviation, Taus, Trend};
use sagnac::fit::{LEAST_REALISATIONS, Term, Terms};
use sagnac::record::log::{Data, Request, Timing, Unit, UnitCheck};
use sagnac::study::{Dimension, parse_quantity};

use super::super::Failure;

/// Examples, after the options.
pub const EXAMPLES: &str = "\
Examples:
  sagnac allan gyro.csv --data rate --unit deg/h --rate 100Hz --column gz
  sagnac allan log.csv --data rate --unit rad/s --time stamp --time-unit ns --column gx,gy,gz
  sagnac allan pulses.npy --data increment --scale \"0.5 arcsec/pulse\" --rate 400Hz --skip \"30 min\"
  sagnac allan PHASE.DAT --data angle --unit none --rate 1Hz --deviation oadev,hdev --tau decade10

Files are text (CSV, TSV, semicolons or blanks between columns, a header or none, comments
behind # % ;), Stable32 .DAT, or NumPy .npy. Empty cells, NaN and missing time stamps are gaps:
terms that touch one are left out.";

/// Simulated records of a fit, unless told or their samples are more than that.
const USUAL_REALISATIONS: usize = 1000;
const MOST_SIMULATED: usize = 2_000_000_000;

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// Logs
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// What the numbers are: angular rate, angle turned in each sample, or angle (phase) since the start
    #[arg(long, value_name = "KIND")]
    data: Kind,
    /// Unit of the numbers, as in deg/h, deg/s, rad/s, arcsec; none for plain ones [default: that of the header]
    #[arg(long, value_name = "UNIT", conflicts_with = "scale")]
    unit: Option<String>,
    /// Size of a pulse, where the numbers count pulses
    #[arg(long, value_name = "SIZE/pulse")]
    scale: Option<String>,
    /// Sampling rate, as in 100Hz
    #[arg(long, value_name = "RATE", conflicts_with = "time")]
    rate: Option<String>,
    /// Column of time stamps, by name or number, in place of a rate
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Unit of the time stamps: s, ms, us, ns [default: that of the header]
    #[arg(long, value_name = "UNIT", requires = "time")]
    time_unit: Option<String>,
    /// Columns by name or number from 1, with commas between [default: the only one]
    #[arg(long, value_name = "COLUMNS", value_delimiter = ',')]
    column: Vec<String>,
    /// Averaging times: octave, decade10, decade20, all, or seconds with commas between
    #[arg(long, value_name = "TAUS", default_value = "octave", value_parser = taus)]
    pub tau: Taus,
    /// Which of adev, oadev, mdev, tdev, hdev, ohdev, with commas between
    #[arg(long, value_name = "NAMES", default_value = "oadev", value_delimiter = ',')]
    pub deviation: Vec<Deviation>,
    /// Coefficients to fit: auto (those of Q, N, B, K, R that the record supports), none, or a list of Q, N, B, K, R,
    /// markov, sine
    #[arg(long, value_name = "TERMS", default_value = "auto", value_parser = fit_terms)]
    fit: Fitted,
    /// Simulated records of the fit, from which the intervals of coefficients come; 0 takes them in closed form [default:
    /// 1000, of more than 2 million samples fewer, at least 200]
    #[arg(long, value_name = "N", value_parser = simulated)]
    bootstrap: Option<usize>,
    /// Probability of the intervals of deviations
    #[arg(long, value_name = "P", default_value_t = 0.95, value_parser = probability)]
    pub confidence: f64,
    /// Leave out the beginning, as in "30 min"
    #[arg(long, value_name = "TIME", default_value = "0 s", value_parser = seconds)]
    pub skip: f64,
    /// Leave out what is later than this after the start of the file
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    pub until: Option<f64>,
    /// Remove a straight line from the rate: with it goes the rate ramp R, and K comes out too low
    #[arg(long, value_name = "TREND", default_value = "none")]
    detrend: Detrend,
    /// Take outliers for gaps: samples more than 8 standard deviations from the median of their neighbours
    #[arg(long)]
    pub remove_outliers: bool,
    /// Refuse rates that look as if in another unit: see the README
    #[arg(long, value_name = "SWITCH", default_value = "on")]
    unit_check: Switch,
    /// Results folder [default: results/<name of the file>]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Also write the gyroscope part of an imu.yaml, as Kalibr reads it: noise density N and random walk K
    #[arg(long, value_name = "FILE.yaml")]
    pub kalibr: Option<PathBuf>,
    /// Print the results as JSON: one object, or with several files one array of them
    #[arg(long)]
    pub json: bool,
    /// Print only errors
    #[arg(long, short)]
    pub quiet: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Kind {
    Rate,
    Increment,
    Angle,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Detrend {
    None,
    Linear,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Switch {
    On,
    Off,
}

/// What `--fit` asks for.
#[derive(Debug, Clone, PartialEq)]
enum Fitted {
    None,
    Auto,
    Given(Vec<Term>),
}

fn fit_terms(text: &str) -> Result<Fitted, String> {
    let term = |name: &str| {
        let found = Term::ALL.into_iter().find(|term| term.symbol().eq_ignore_ascii_case(name.trim()));
        found.ok_or_else(|| {
            format!("`{}` is no term; accepted: auto, none, or some of Q,N,B,K,R,markov,sine", name.trim())
        })
    };
    match text {
        "none" => Ok(Fitted::None),
        "auto" => Ok(Fitted::Auto),
        list => list.split(',').map(term).collect::<Result<_, _>>().map(Fitted::Given),
    }
}

impl Options {
    /// The terms to fit, if any. A removed trend has taken the ramp with it.
    pub fn terms(&self) -> Option<Terms> {
        match &self.fit {
            Fitted::None => None,
            Fitted::Given(terms) => Some(Terms::Given(terms.clone())),
            Fitted::Auto => {
                let gone = |term: &Term| self.trend() == Trend::Linear && *term == Term::RateRamp;
                Some(Terms::Auto(Term::MODEL.into_iter().filter(|term| !gone(term)).collect()))
            }
        }
    }

    /// What is to be read of each file.
    ///
    /// # Errors
    /// A unit, scale or rate that is none, or no word on when the samples were taken.
    pub fn request(&self) -> Result<Request, Failure> {
        let data = match self.data {
            Kind::Rate => Data::Rate,
            Kind::Increment => Data::Increment,
            Kind::Angle => Data::Angle,
        };
        let unit = match (&self.unit, &self.scale) {
            (Some(unit), _) => Some(Unit::parse(unit, data)),
            (None, Some(scale)) => Some(Unit::parse_scale(scale, data)),
            (None, None) => None,
        };
        let unit =
            unit.transpose().map_err(|wrong| Failure::Usage(format!("{}\n{}", wrong.message, wrong.help)))?;
        let timing = match (&self.rate, &self.time) {
            (Some(rate), _) => Timing::Step(step(rate)?),
            (None, Some(column)) => Timing::Stamps { column: column.clone(), unit: self.time_unit.clone() },
            (None, None) => {
                let message = "it is not said when the samples were taken\ngive --rate 100Hz, or --time COLUMN for a \
                               column of time stamps";
                return Err(Failure::Usage(message.to_owned()));
            }
        };
        Ok(Request { columns: self.column.clone(), timing, data, unit })
    }

    /// How many records of so many samples are simulated for the intervals of coefficients.
    ///
    /// Unless told, no more than take some seconds: quantiles of fewer records are worth less, but still more than none.
    pub fn bootstrap(&self, samples: usize) -> usize {
        let usual = || (MOST_SIMULATED / samples.max(1)).clamp(LEAST_REALISATIONS, USUAL_REALISATIONS);
        self.bootstrap.unwrap_or_else(usual)
    }

    /// Whether people hear nothing but errors.
    pub fn is_silent(&self) -> bool {
        self.quiet || self.json
    }

    /// Whether what is asked for can be done.
    ///
    /// # Errors
    /// A file for Kalibr of what cannot be in one.
    pub fn check(&self, request: &Request) -> Result<(), Failure> {
        let wrong = |why: &str| Err(Failure::Usage(format!("--kalibr {why}")));
        match &self.kalibr {
            None => Ok(()),
            Some(_) if self.files.len() > 1 => wrong(
                "names one file, but there are several logs\ngive them one by one, each with its --kalibr FILE",
            ),
            Some(_) if self.fit == Fitted::None => wrong("needs coefficients\nleave out --fit none"),
            Some(_) if request.unit.as_ref().is_some_and(|unit| !unit.is_angular) => {
                wrong("needs rates or angles, not plain numbers\ngive their --unit, as in deg/s")
            }
            Some(_) => Ok(()),
        }
    }

    pub fn trend(&self) -> Trend {
        match self.detrend {
            Detrend::None => Trend::None,
            Detrend::Linear => Trend::Linear,
        }
    }

    pub fn unit_check(&self) -> UnitCheck {
        match self.unit_check {
            Switch::On => UnitCheck::On,
            Switch::Off => UnitCheck::Off,
        }
    }
}

/// From sample to sample at a rate, s.
fn step(rate: &str) -> Result<f64, Failure> {
    let wrong = |why: String| {
        Failure::Usage(format!("--rate {rate}: {why}\ngive samples per second, as in --rate 100Hz"))
    };
    let quantity = parse_quantity(rate, &[Dimension::Frequency]).map_err(|error| wrong(error.to_string()))?;
    if quantity.value > 0.0 {
        Ok(1.0 / quantity.value)
    } else {
        Err(wrong("the rate is not above 0".to_owned()))
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let quantity = parse_quantity(text, &[Dimension::Time])
        .map_err(|error| format!("{error}; write as in \"30 min\""))?;
    if quantity.value >= 0.0 {
        Ok(quantity.value)
    } else {
        Err("a time before the start of the file".to_owned())
    }
}

fn probability(text: &str) -> Result<f64, String> {
    let inside = |p: &f64| *p > 0.0 && *p < 1.0;
    text.parse().ok().filter(inside).ok_or_else(|| "not between 0 and 1; write as in 0.95".to_owned())
}

fn simulated(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|&count| count == 0 || count >= LEAST_REALISATIONS);
    count.ok_or_else(|| {
        format!("give 0, or at least {LEAST_REALISATIONS}: of fewer, 2.5 % are too few to tell an end by")
    })
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
