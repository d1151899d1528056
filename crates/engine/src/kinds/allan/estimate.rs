//! Reading of `[allan]`: averaging times, estimator and fitted terms.

use crate::key::document::{Given, Table};
use crate::key::row::{Holds, unlimited};
use crate::kinds::allan::keys::{ESTIMATOR, EstimatorName, FIT, OVERLAP, Overlap, TAU};
use sagnac_base::quantity::units::Dimension;
use sagnac_base::source::diagnose::{Fault, choices};
use sagnac_records::allan::tau::Taus;
use sagnac_records::fit::choose::Terms;
use sagnac_theory::allan::estimator::{Difference, Estimator, Stride};
use sagnac_theory::allan::terms::Term;

/// The estimates made from each record.
pub(crate) struct Estimate {
    pub(crate) taus: Taus,
    pub(crate) estimator: Estimator,
    pub(crate) terms: Option<Terms>,
}

/// Differences within an averaging time where not all are used.
const PARTS: u64 = 64;

const TIMES: Holds = unlimited(&[Dimension::Time]);

/// Reads `[allan]`, with defaults for absent keys.
pub(crate) fn read(study: &Table) -> Result<Estimate, Fault> {
    let estimator = estimator(study)?;
    let terms = study.get(&FIT).map(|fit| terms(fit, estimator.difference)).transpose()?;
    Ok(Estimate { taus: study.get(&TAU).map_or(Ok(Taus::Octave), taus)?, estimator, terms })
}

fn estimator(study: &Table) -> Result<Estimator, Fault> {
    let overlap = study.get(&OVERLAP);
    let stride = match Overlap::of(overlap) {
        Overlap::Full => Stride::Sample,
        Overlap::Part64 => Stride::Part(PARTS),
    };
    match (EstimatorName::of(study.get(&ESTIMATOR)), overlap) {
        (EstimatorName::Overlapping, _) => Ok(Estimator { stride, ..Estimator::OVERLAPPING }),
        (EstimatorName::Hadamard, _) => Ok(Estimator { stride, ..Estimator::HADAMARD }),
        (EstimatorName::NonOverlapping, None) => Ok(Estimator::NON_OVERLAPPING),
        (EstimatorName::NonOverlapping, Some(overlap)) => {
            let message = "allan.overlap conflicts with estimator = \"non-overlapping\"";
            Err(overlap.fault(message, "nothing overlaps", "leave one of them out"))
        }
    }
}

fn taus(written: Given) -> Result<Taus, Fault> {
    const NAMED: [(&str, Taus); 3] =
        [("octave", Taus::Octave), ("decade10", Taus::Decade(10)), ("decade20", Taus::Decade(20))];
    if !written.is_list() {
        let (text, names) = (written.text(), NAMED.map(|(name, _)| name));
        let named = NAMED.into_iter().find(|(name, _)| *name == text);
        return named.map(|(_, taus)| taus).ok_or_else(|| {
            let message = format!("allan.tau = {written} is not a list of averaging times");
            let help = format!("{}, or a list of times as in [\"1 s\", \"10 s\"]", choices(text, &names));
            written.fault(message, "not a list of times", help)
        });
    }
    let tau = |time: Given| match time.read(&TIMES)? {
        tau if tau.value > 0.0 => Ok((tau.to_string(), tau.value)),
        tau => Err(time.fault(format!("allan.tau lists {tau}"), "not above 0", "give times above 0")),
    };
    let seconds = written.distinct(tau, "leave it out here")?;
    if seconds.is_empty() {
        let help = "give one time or more, as in [\"1 s\", \"10 s\"]";
        return Err(written.fault("allan.tau is empty", "no times", help));
    }
    Ok(Taus::Seconds(seconds))
}

fn terms(written: Given, difference: Difference) -> Result<Terms, Fault> {
    // Third differences cancel a ramp.
    let is_seen = |term: &Term| difference == Difference::Second || *term != Term::RateRamp;
    if !written.is_list() {
        if written.text() == "auto" {
            return Ok(Terms::Auto(Term::MODEL.into_iter().filter(is_seen).collect()));
        }
        let message = format!("allan.fit = {written} names no terms");
        return Err(written.fault(message, "not auto and not a list", help("")));
    }
    let term = |name: Given| match Term::ALL.into_iter().find(|term| term.symbol() == name.text()) {
        Some(term) if is_seen(&term) => Ok((name.to_string(), term)),
        Some(_) => {
            let message = "allan.fit: the Hadamard variance does not see a rate ramp R";
            let help = "leave R out, or take estimator = \"overlapping\"";
            Err(name.fault(message, "not in this variance", help))
        }
        None => Err(name.fault(format!("allan.fit: {name} is not a term"), "not a term", help(name.text()))),
    };
    let terms = written.distinct(term, "leave it out here")?;
    if terms.is_empty() {
        return Err(written.fault("allan.fit is empty", "no terms", help("")));
    }
    Ok(Terms::Given(terms))
}

fn help(text: &str) -> String {
    let names = Term::ALL.map(Term::symbol);
    format!("{}, or fit = \"auto\"", choices(text, &names))
}
