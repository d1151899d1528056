//! Reading `[allan]`: at which averaging times what is estimated, and what is fitted.

use std::ops::Range;

use toml::Spanned;

use crate::allan::tau::Taus;
use crate::fit::choose::Terms;
use crate::fit::term::Term;
use crate::key::file::allan::{AllanTable, EstimatorName, Overlap};
use crate::key::file::either::Either;
use crate::key::scalar::{self, Scalar};
use crate::quantity::units::Dimension;
use crate::source::diagnose::{Fault, choices};
use crate::source::place::Places;
use crate::theory::allan::estimator::{Difference, Estimator, Stride};

/// What is estimated of each record.
pub(crate) struct Estimate {
    pub(crate) taus: Taus,
    pub(crate) estimator: Estimator,
    pub(crate) terms: Option<Terms>,
}

/// Differences in an averaging time where not all are taken.
const PARTS: u64 = 64;

type List = Spanned<Either<Vec<Spanned<Scalar>>>>;

/// What `[allan]` says, and what is meant where it says nothing.
pub(crate) fn read(table: Option<&Spanned<AllanTable>>, places: &mut Places) -> Result<Estimate, Fault> {
    let default = AllanTable::default();
    let table = table.map_or(&default, Spanned::get_ref);
    if let Some(tau) = &table.tau {
        places.add("allan.tau", tau.span());
    }
    let estimator = estimator(table)?;
    let terms = table.fit.as_ref().map(|fit| terms(fit, estimator.difference)).transpose()?;
    Ok(Estimate { taus: table.tau.as_ref().map_or(Ok(Taus::Octave), taus)?, estimator, terms })
}

fn estimator(table: &AllanTable) -> Result<Estimator, Fault> {
    let overlap = table.overlap.as_ref().map_or(Overlap::Part64, |overlap| *overlap.get_ref());
    let stride = if overlap == Overlap::Full { Stride::Sample } else { Stride::Part(PARTS) };
    match table.estimator.as_ref().map(|name| *name.get_ref()) {
        None | Some(EstimatorName::Overlapping) => Ok(Estimator { stride, ..Estimator::OVERLAPPING }),
        Some(EstimatorName::Hadamard) => Ok(Estimator { stride, ..Estimator::HADAMARD }),
        Some(EstimatorName::NonOverlapping) => match &table.overlap {
            None => Ok(Estimator::NON_OVERLAPPING),
            Some(overlap) => {
                let message = "allan.overlap stands beside estimator = \"non-overlapping\"";
                let help = "leave one of them out";
                Err(Fault::new(overlap.span(), message, "nothing overlaps", help))
            }
        },
    }
}

fn taus(written: &List) -> Result<Taus, Fault> {
    const NAMES: [&str; 3] = ["octave", "decade10", "decade20"];
    match written.get_ref() {
        Either::One(Scalar::Text(name)) if NAMES.contains(&name.as_str()) => Ok(match name.as_str() {
            "octave" => Taus::Octave,
            "decade10" => Taus::Decade(10),
            _ => Taus::Decade(20),
        }),
        Either::One(other) => {
            let text = if let Scalar::Text(text) = other { text } else { "" };
            let message = format!("allan.tau = {other} is no list of averaging times");
            let help = format!("{}, or a list of times as in [\"1 s\", \"10 s\"]", choices(text, &NAMES));
            Err(Fault::new(written.span(), message, "not a list of times", help))
        }
        Either::Other(times) if times.is_empty() => {
            let help = "give one time or more, as in [\"1 s\", \"10 s\"]";
            Err(Fault::new(written.span(), "allan.tau is empty", "no times", help))
        }
        Either::Other(times) => {
            let mut seconds: Vec<f64> = Vec::new();
            for time in times {
                let tau = scalar::quantity("allan.tau", time, &[Dimension::Time])?;
                if tau.value <= 0.0 {
                    let message = format!("allan.tau lists {tau}");
                    return Err(Fault::new(time.span(), message, "not above 0", "give times above 0"));
                }
                if seconds.contains(&tau.value) {
                    let message = format!("allan.tau lists {tau} twice");
                    return Err(Fault::new(time.span(), message, "listed before", "leave it out here"));
                }
                seconds.push(tau.value);
            }
            Ok(Taus::Seconds(seconds))
        }
    }
}

fn terms(written: &List, difference: Difference) -> Result<Terms, Fault> {
    // A third difference does not see a ramp.
    let is_seen = |term: &Term| difference == Difference::Second || *term != Term::RateRamp;
    match written.get_ref() {
        Either::One(Scalar::Text(name)) if name == "auto" => {
            Ok(Terms::Auto(Term::MODEL.into_iter().filter(is_seen).collect()))
        }
        Either::One(other) => {
            let message = format!("allan.fit = {other} names no terms");
            Err(Fault::new(written.span(), message, "not auto and not a list", help("")))
        }
        Either::Other(names) if names.is_empty() => {
            Err(Fault::new(written.span(), "allan.fit is empty", "no terms", help("")))
        }
        Either::Other(names) => {
            let mut terms: Vec<Term> = Vec::new();
            for name in names {
                let term = term(name.get_ref(), name.span())?;
                if terms.contains(&term) {
                    let message = format!("allan.fit lists \"{}\" twice", term.symbol());
                    return Err(Fault::new(name.span(), message, "listed before", "leave it out here"));
                }
                if !is_seen(&term) {
                    let message = "allan.fit: the Hadamard variance does not see a rate ramp R";
                    let help = "leave R out, or take estimator = \"overlapping\"";
                    return Err(Fault::new(name.span(), message, "not in this variance", help));
                }
                terms.push(term);
            }
            Ok(Terms::Given(terms))
        }
    }
}

fn term(name: &Scalar, place: Range<usize>) -> Result<Term, Fault> {
    let text = if let Scalar::Text(text) = name { text } else { "" };
    Term::ALL
        .into_iter()
        .find(|term| term.symbol() == text)
        .ok_or_else(|| Fault::new(place, format!("allan.fit: {name} is no term"), "no term", help(text)))
}

fn help(text: &str) -> String {
    let names = Term::ALL.map(Term::symbol);
    format!("{}, or fit = \"auto\"", choices(text, &names))
}
