//! Options for reading recorded logs, common to all commands on logs.

use clap::Args;
use clap::builder::TypedValueParser;
use sagnac::allan::trend::Trend;
use sagnac::analysis::log::Treatment;
use sagnac::fit::choose::Terms;
use sagnac::fit::range::Fitting;
use sagnac::quantity::units::{Dimension, parse as parse_quantity};
use sagnac::record::log::check::UnitCheck;
use sagnac::record::log::measure::{Data, Unit};
use sagnac::record::log::read::{Request, Timing};
use sagnac::theory::allan::terms::Term;

use crate::failure::{Failure, in_options};
use crate::words::one_of;

#[derive(Debug, Args)]
pub struct Reading {
    /// Kind of the numbers: angular rate, angle turned in each sample, or angle (phase) since the start
    #[arg(help_heading = "Reading the log", long, value_name = "KIND", value_parser = data())]
    data: Data,
    /// Unit of the numbers, as in deg/h, deg/s, rad/s, arcsec; none for plain numbers [default: that of the header]
    #[arg(help_heading = "Reading the log", long, value_name = "UNIT", conflicts_with = "scale")]
    unit: Option<String>,
    /// Size of a pulse, if the numbers count pulses
    #[arg(help_heading = "Reading the log", long, value_name = "SIZE/pulse")]
    scale: Option<String>,
    /// Sampling rate, as in 100Hz
    #[arg(help_heading = "Reading the log", long, value_name = "RATE", conflicts_with = "time")]
    rate: Option<String>,
    /// Column of time stamps, by name or number, instead of a rate
    #[arg(help_heading = "Reading the log", long, value_name = "COLUMN")]
    time: Option<String>,
    /// Unit of the time stamps: s, ms, us, ns [default: that of the header]
    #[arg(help_heading = "Reading the log", long, value_name = "UNIT", requires = "time")]
    time_unit: Option<String>,
    /// Columns by name or number from 1, separated by commas [default: the only one]
    #[arg(help_heading = "Reading the log", long, value_name = "COLUMNS", value_delimiter = ',')]
    column: Vec<String>,
    /// Omit the beginning, as in "30 min"
    #[arg(long, value_name = "TIME", default_value = "0 s", value_parser = seconds)]
    skip: f64,
    /// Omit everything later than this time after the start of the file
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    until: Option<f64>,
    /// Remove a straight line from the rate; this also removes the rate ramp R and makes K too low
    #[arg(help_heading = "Reading the log", long, value_name = "TREND", default_value = "none", value_parser = trend())]
    detrend: Trend,
    /// Treat outliers as gaps: samples more than 8 standard deviations from the median of their neighbours
    #[arg(long)]
    remove_outliers: bool,
    /// Whether to refuse rates that seem to be in another unit; see docs/reference.md
    #[arg(help_heading = "Reading the log", long, value_name = "SWITCH", default_value = "on", value_parser = unit_check())]
    unit_check: UnitCheck,
    /// Coefficients to fit: auto (those of Q, N, B, K, R that the record supports), none, or a list of Q, N, B, K, R,
    /// markov, sine
    #[arg(help_heading = "Reading the log", long, value_name = "TERMS", default_value = "auto", value_parser = fit_terms)]
    fit: Fitted,
    /// Shortest averaging time of the fit, as in "0.5 s" [default: the shortest from which the terms describe the curve]
    #[arg(help_heading = "Reading the log", long, value_name = "TIME", value_parser = seconds)]
    fit_from: Option<f64>,
    /// Longest averaging time of the fit [default: an eighth of the record]
    #[arg(help_heading = "Reading the log", long, value_name = "TIME", value_parser = seconds)]
    fit_to: Option<f64>,
    /// Take the coefficients of the best fit even where it does not describe the curve
    #[arg(help_heading = "Reading the log", long)]
    force: bool,
}

/// Value of `--fit`.
#[derive(Debug, Clone, PartialEq)]
enum Fitted {
    None,
    Auto,
    Given(Vec<Term>),
}

fn data() -> impl TypedValueParser<Value = Data> {
    one_of(Data::ALL.map(|data| (data.name(), data)))
}

fn trend() -> impl TypedValueParser<Value = Trend> {
    one_of([("none", Trend::None), ("linear", Trend::Linear)])
}

fn unit_check() -> impl TypedValueParser<Value = UnitCheck> {
    one_of([("on", UnitCheck::On), ("off", UnitCheck::Off)])
}

fn fit_terms(text: &str) -> Result<Fitted, String> {
    let term = |name: &str| {
        let found = Term::ALL.into_iter().find(|term| term.symbol().eq_ignore_ascii_case(name.trim()));
        found.ok_or_else(|| {
            let known = Term::ALL.map(Term::symbol).join(",");
            format!("`{}` is not a term; accepted: auto, none, or some of {known}", name.trim())
        })
    };
    match text {
        "none" => Ok(Fitted::None),
        "auto" => Ok(Fitted::Auto),
        list => list.split(',').map(term).collect::<Result<_, _>>().map(Fitted::Given),
    }
}

impl Reading {
    /// The fit, if any. A removed trend includes the ramp.
    pub fn fitting(&self) -> Option<Fitting> {
        let terms = match &self.fit {
            Fitted::None => return None,
            Fitted::Given(terms) => Terms::Given(terms.clone()),
            Fitted::Auto => Terms::of_model(self.detrend),
        };
        Some(Fitting { terms, from_s: self.fit_from, to_s: self.fit_to, is_forced: self.force })
    }

    /// The names of the columns, as they were given.
    pub fn columns(&self) -> &[String] {
        &self.column
    }

    /// The request for each file.
    ///
    /// # Errors
    /// A unit, scale or rate is invalid, or the times of the samples are not given.
    pub fn request(&self) -> Result<Request, Failure> {
        let data = self.data;
        let unit = match (&self.unit, &self.scale) {
            (Some(unit), _) => Some(Unit::parse(unit, data)),
            (None, Some(scale)) => Some(Unit::parse_scale(scale, data)),
            (None, None) => None,
        };
        let unit = unit
            .transpose()
            .map_err(|wrong| Failure::Usage(in_options(&format!("{}\n{}", wrong.message, wrong.help))))?;
        let timing = match (&self.rate, &self.time) {
            (Some(rate), _) => Timing::Step(step(rate)?),
            (None, Some(column)) => Timing::Stamps { column: column.clone(), unit: self.time_unit.clone() },
            (None, None) => {
                let message = "the times of the samples are not given\ngive --rate 100Hz, or --time COLUMN for a \
                               column of time stamps";
                return Err(Failure::Usage(message.to_owned()));
            }
        };
        Ok(Request { columns: self.column.clone(), timing, data, unit })
    }

    /// The treatment of each log before its analysis.
    pub fn treatment(&self) -> Treatment {
        Treatment {
            skip_s: self.skip,
            until_s: self.until,
            trend: self.detrend,
            outliers_removed: self.remove_outliers,
            unit_check: self.unit_check,
        }
    }
}

/// The sampling interval for a rate, s.
fn step(rate: &str) -> Result<f64, Failure> {
    let wrong = |why: String| {
        Failure::Usage(format!("--rate {rate}: {why}\ngive samples per second, as in --rate 100Hz"))
    };
    let quantity = parse_quantity(rate, &[Dimension::Frequency]).map_err(|error| wrong(error.to_string()))?;
    if quantity.value > 0.0 {
        Ok(1.0 / quantity.value)
    } else {
        Err(wrong("the rate is not positive".to_owned()))
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
