//! Requirements on the noise of sensors: limits on coefficients, and the answer of records.
//!
//! ```text
//! text ─ Limit::parse ─▶ Limit ─┐
//! log, batch ─▶ Subject ────────┴─ Judged ─▶ Standing ─▶ Decision: Answer, judgements
//! ```
//!
//! A limit is met if the upper end of the 95 % interval of the coefficient is at most the limit. It is not met if the lower end is
//! above it. If the interval contains the limit, the record does not decide. A coefficient that is not identified has an
//! upper bound only, which meets the limit or does not decide. Coefficients of a fit that does not describe its curve decide
//! nothing.

mod answer;
mod check;

use sagnac_base::diagnostics::{choices, listed};
use sagnac_base::quantity::parse_in;
use sagnac_records::allan::{Deviation, Unit};
use sagnac_records::fit::{Quantity, Term};

pub use crate::analysis::requirement::answer::{Decision, decide};
pub(crate) use crate::analysis::requirement::answer::{status, value_or_bound};
pub(crate) use crate::analysis::requirement::check::columns;
pub use crate::analysis::requirement::check::{Judgement, Standing, Subject};

/// What a limit is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limited {
    /// The coefficient of a term.
    Coefficient(Term),
    /// The minimum of the first curve of rates up to an eighth of the record, which data sheets call in-run bias stability.
    Stability,
    /// The random walk N of the flat part of the density.
    Floor,
}

impl Limited {
    /// What a limit on a log can be on.
    pub const OF_LOG: [Limited; Term::ALL.len() + 2] = {
        let mut all = [Limited::Floor; Term::ALL.len() + 2];
        let mut place = 0;
        while place < Term::ALL.len() {
            all[place] = Limited::Coefficient(Term::ALL[place]);
            place += 1;
        }
        all[place] = Limited::Stability;
        all
    };

    /// What a limit on the units of a batch can be on.
    pub const OF_BATCH: &'static [Limited] = Limited::OF_LOG.split_at(Term::ALL.len() + 1).0;

    /// Name in limits and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Limited::Coefficient(term) => term.symbol(),
            Limited::Stability => "in_run_bias_stability",
            Limited::Floor => "floor",
        }
    }

    /// Name in sentences.
    pub(crate) fn told(self) -> &'static str {
        match self {
            Limited::Coefficient(Term::Markov) => "the Markov noise",
            Limited::Coefficient(Term::Sine) => "the sine",
            Limited::Coefficient(term) => term.symbol(),
            Limited::Stability => "the in-run bias stability",
            Limited::Floor => "N of the floor",
        }
    }

    /// Units in files and for the user, of records whose curves have this unit.
    pub(crate) fn unit(self, unit: Unit) -> (&'static str, &'static str) {
        let of_term = |term| {
            let (_, in_files, symbol) = Quantity::Coefficient(term).unit(unit);
            (in_files, symbol)
        };
        match self {
            Limited::Coefficient(term) => of_term(term),
            Limited::Floor => of_term(Term::AngleRandomWalk),
            Limited::Stability => (unit.in_files(Deviation::Oadev), unit.symbol(Deviation::Oadev)),
        }
    }

    /// Whether this is a name of it: that of tables, the usual abbreviation, or the key of studies and noise.toml, with or
    /// without spaces.
    fn is_called(self, name: &str) -> bool {
        let more = match self {
            Limited::Coefficient(Term::AngleRandomWalk) => "ARW",
            Limited::Coefficient(Term::RateRandomWalk) => "RRW",
            _ => "",
        };
        let key = match self {
            Limited::Coefficient(term) => term.row().key.trim_start_matches("noise."),
            _ => "",
        };
        let name = name.replace([' ', '-'], "_");
        [self.name(), more, key].iter().any(|known| known.eq_ignore_ascii_case(&name))
    }
}

/// A requirement on the noise of a sensor: the largest value that is accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// The quantity that is limited.
    pub of: Limited,
    /// Unit of the curves of the records to which it applies, which follows from the unit of the limit.
    pub unit: Unit,
    /// Largest accepted value, in the unit of tables, such as °/√h for N of gyros.
    pub value: f64,
}

/// Why a text is no limit, or limits do not fit the records.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}\n{help}")]
pub struct LimitError {
    /// The fault, for the user.
    pub message: String,
    /// What to write instead.
    pub help: String,
}

/// A name and a value with an equals sign between them.
///
/// # Errors
/// The sign is missing, or the name is not one of `known`.
pub(crate) fn named<'t>(
    text: &'t str,
    known: &[Limited],
    example: &str,
) -> Result<(Limited, &'t str), LimitError> {
    let (name, value) = text.split_once('=').ok_or_else(|| LimitError {
        message: format!("\"{text}\" has no `=` between a name and a value"),
        help: format!("write as in \"{example}\""),
    })?;
    let (name, value) = (name.trim(), value.trim());
    let found = known.iter().copied().find(|limited| limited.is_called(name));
    let found = found.ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|limited| limited.name()).collect();
        LimitError { message: format!("unknown limit `{name}`"), help: choices(name, &names) }
    })?;
    Ok((found, value))
}

impl Limit {
    /// Reads a limit such as `N=0.003 deg/sqrt(h)` on one of `known`; a plain number limits records of plain numbers.
    ///
    /// # Errors
    /// The text is no limit on one of `known`, or its unit does not fit.
    ///
    /// # Example
    /// ```
    /// use sagnac::allan::Unit;
    /// use sagnac::analysis::requirement::{Limit, Limited};
    ///
    /// let limit = Limit::parse("N = 0.2 mm/s/sqrt(h)", &Limited::OF_LOG)?;
    /// assert_eq!((limit.of.name(), limit.unit, limit.value), ("N", Unit::Acceleration, 0.0002));
    /// assert!(Limit::parse("N = 0.2 deg/h", &Limited::OF_LOG).is_err());
    /// # Ok::<(), sagnac::analysis::requirement::LimitError>(())
    /// ```
    pub fn parse(text: &str, known: &[Limited]) -> Result<Limit, LimitError> {
        let (of, value) = named(text, known, "N=0.003 deg/sqrt(h)")?;
        let [gyro, accelerometer] = [Unit::Angular, Unit::Acceleration].map(|unit| of.unit(unit).0);
        let wrong = |message: String| LimitError {
            message: format!("the limit on {}: {message}", of.name()),
            help: format!(
                "accepted: {gyro} for gyros, {accelerometer} for accelerometers, as in \"{}=0.1 {gyro}\", or other units of the \
                 same; a number alone for records of plain numbers",
                of.name()
            ),
        };
        let (value, unit) = match value.parse() {
            Ok(number) => (number, Unit::Plain),
            Err(_) => {
                let found =
                    parse_in(value, &[gyro, accelerometer]).map_err(|error| wrong(error.to_string()))?;
                (found.0, [Unit::Angular, Unit::Acceleration][found.1])
            }
        };
        match value > 0.0 && value.is_finite() {
            true => Ok(Limit { of, unit, value }),
            false => Err(wrong(format!("{value} is not a positive number"))),
        }
    }

    /// The limit as it can be written.
    pub(crate) fn text(&self) -> String {
        format!("{}={} {}", self.of.name(), self.value, self.of.unit(self.unit).0).trim_end().to_owned()
    }
}

/// Checks limits that were given together: each names something else, and `fitted` contains their terms; `None` stands
/// for no fit.
///
/// # Errors
/// Two limits are on the same, or the fit does not contain a term.
pub fn check(limits: &[Limit], fitted: Option<&[Term]>) -> Result<(), LimitError> {
    for (place, limit) in limits.iter().enumerate() {
        if let Some(first) =
            limits[..place].iter().find(|first| (first.of, first.unit) == (limit.of, limit.unit))
        {
            return Err(twice(&first.text(), &limit.text()));
        }
        let Limited::Coefficient(term) = limit.of else { continue };
        is_fitted(term, &limit.text(), fitted)?;
    }
    Ok(())
}

/// Two limits are on the same.
pub(crate) fn twice(first: &str, again: &str) -> LimitError {
    LimitError {
        message: format!("{first} and {again} limit the same"),
        help: "give each limit once".to_owned(),
    }
}

/// Checks that the fit contains a term; `None` stands for no fit.
pub(crate) fn is_fitted(term: Term, limit: &str, fitted: Option<&[Term]>) -> Result<(), LimitError> {
    let why = match fitted {
        None => "none are fitted".to_owned(),
        Some(terms) if !terms.contains(&term) => format!("{} is not fitted", term.symbol()),
        Some(_) => return Ok(()),
    };
    Err(LimitError {
        message: format!("the limit {limit} is on a coefficient, but {why}"),
        help: "fit this term too, or leave out the limit".to_owned(),
    })
}

/// Checks that there is a record for each limit.
///
/// # Errors
/// A limit has the unit of no record.
pub fn applies(limits: &[Limit], units: &[Unit]) -> Result<(), LimitError> {
    let Some(limit) = limits.iter().find(|limit| !units.contains(&limit.unit)) else { return Ok(()) };
    let mut accepted: Vec<&str> = Vec::new();
    for unit in units {
        let (in_files, _) = limit.of.unit(*unit);
        let named = if *unit == Unit::Plain { "no unit" } else { in_files };
        if !accepted.contains(&named) {
            accepted.push(named);
        }
    }
    Err(LimitError {
        message: format!("the limit {} is for {}, which no column has", limit.text(), limit.unit.content()),
        help: format!("give the limit on {} in {}", limit.of.name(), listed(&accepted)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_coefficient_takes_the_units_of_its_tables_and_others_of_the_same() {
        for of in Limited::OF_LOG {
            for unit in [Unit::Angular, Unit::Acceleration] {
                let (in_files, symbol) = of.unit(unit);
                for text in [in_files, symbol] {
                    let limit =
                        Limit::parse(&format!("{}=0.25 {text}", of.name()), &Limited::OF_LOG).unwrap();
                    assert_eq!((limit.of, limit.unit, limit.value), (of, unit, 0.25), "{text}");
                }
            }
        }
        for (text, unit, value) in [
            ("angle_random_walk = 0.18 arcsec/sqrt(s)", Unit::Angular, 0.003),
            ("n=0.05 deg/h/sqrt(Hz)", Unit::Angular, 0.05 / 60.0),
            ("B=20 mg", Unit::Acceleration, 20_000.0),
            ("K=1 arcsec/s/sqrt(s)", Unit::Angular, 60.0),
            ("Q=2.5", Unit::Plain, 2.5),
            ("in_run_bias_stability=0.01 °/h", Unit::Angular, 0.01),
            ("ARW=0.003 deg/sqrt(h)", Unit::Angular, 0.003),
            ("bias instability=2 deg/h", Unit::Angular, 2.0),
        ] {
            let limit = Limit::parse(text, &Limited::OF_LOG).unwrap();
            assert!(limit.unit == unit && (limit.value / value - 1.0).abs() < 1e-11, "{text}: {limit:?}");
        }
    }

    #[test]
    fn what_is_no_limit_is_named_with_what_is_accepted() {
        for (text, pieces) in [
            ("N", ["has no `=`", "N=0.003 deg/sqrt(h)"]),
            ("M=1 deg/h", ["unknown limit `M`", "accepted: Q, N, B, K, R, markov, sine, in_run"]),
            ("N=1 deg/h", ["is an angular rate", "deg/sqrt(h) for gyros, m/s/sqrt(h) for accelerometers"]),
            ("B=0 deg/h", ["0 is not a positive number", "deg/h for gyros"]),
            ("B=-1", ["-1 is not a positive number", "a number alone"]),
            ("B=nan", ["NaN is not a positive number", "deg/h"]),
            ("B=", ["does not begin with a number", "deg/h"]),
            ("B=1,5 deg/h", ["has a comma", "deg/h"]),
            ("markov_time=3 s", ["unknown limit `markov_time`", "did you mean `markov`?"]),
        ] {
            let error = Limit::parse(text, &Limited::OF_LOG).unwrap_err().to_string();
            for piece in pieces {
                assert!(error.contains(piece), "{text}: {piece} is missing in {error}");
            }
        }
        assert!(Limit::parse("floor=1 deg/sqrt(h)", Limited::OF_BATCH).is_err());
    }

    #[test]
    fn limits_that_do_not_fit_each_other_the_fit_or_the_records_are_refused() {
        let limits = |texts: &[&str]| -> Vec<Limit> {
            texts.iter().map(|text| Limit::parse(text, &Limited::OF_LOG).unwrap()).collect()
        };
        let fitted = Some(&[Term::AngleRandomWalk, Term::BiasInstability][..]);
        let both = limits(&["N=1 deg/sqrt(h)", "N=1 m/s/sqrt(h)"]);
        assert_eq!(check(&both, fitted), Ok(()));
        assert_eq!(applies(&both, &[Unit::Acceleration, Unit::Angular]), Ok(()));
        let refused = |error: Result<(), LimitError>, piece: &str| {
            let error = error.unwrap_err().to_string();
            assert!(error.contains(piece), "{piece} is missing in {error}");
        };
        refused(
            check(&limits(&["N=1 deg/sqrt(h)", "angle_random_walk=2 deg/sqrt(h)"]), fitted),
            "limit the same",
        );
        refused(check(&limits(&["K=1 deg/h/sqrt(h)"]), fitted), "K is not fitted");
        refused(check(&limits(&["N=1 deg/sqrt(h)"]), None), "none are fitted");
        assert_eq!(check(&limits(&["floor=1 deg/sqrt(h)"]), None), Ok(()));
        refused(applies(&both, &[Unit::Plain]), "is for angular rates");
        refused(applies(&both, &[Unit::Angular]), "give the limit on N in deg/sqrt(h)");
        refused(applies(&limits(&["N=1"]), &[Unit::Angular]), "is for plain numbers");
    }
}
