//! What makes a record meet a limit, or decide it.

use crate::analysis::compare::length::expected;
use crate::analysis::compare::words::duration;
use crate::analysis::requirement::judged::{Judged, Standing};
use crate::analysis::requirement::limit::Limited;
use crate::analysis::requirement::subject::Subject;
use sagnac_base::quantity::number::with_unit;
use sagnac_records::fit::{Quantity, Term, Terms};
use sagnac_report::answer::{Alternative, Fact};

/// Most sensors whose mean is proposed.
const MAX_SENSORS: f64 = 100.0;
/// How many times as long a record may be to be proposed.
const MAX_FACTOR: f64 = 1000.0;
/// How many times longer records are tried by their expected curve.
const LONGER: [f64; 4] = [2.0, 4.0, 16.0, 64.0];
/// Most samples of a tried record, for which there is flicker.
const MAX_SAMPLES: f64 = 6e7;

fn alternative(key: &str, label: &str, from: String, to: String) -> Alternative {
    Alternative { key: key.to_owned(), label: label.to_owned(), from, to }
}

/// Sensors whose mean is within the limit, and the pulse of a quantizing readout that is.
pub(super) fn to_meet(judged: &Judged, value: f64) -> Option<Fact> {
    let limit = judged.limit.value;
    // A limit in decimals may be off by a rounding.
    let sensors = libm::ceil(value / limit * (value / limit) * (1.0 - 1e-9));
    let is_noise = match judged.of() {
        Limited::Coefficient(term) => !matches!(term, Term::RateRamp | Term::Sine),
        Limited::Floor => true,
        // The minimum of a mean need not lie at the same τ.
        Limited::Stability => false,
    };
    let mean = (is_noise && sensors <= MAX_SENSORS)
        .then(|| alternative("sensors", "sensors averaged", "1".to_owned(), sensors.to_string()));
    let pulse = (judged.of() == Limited::Coefficient(Term::Quantization)).then(|| {
        let (_, _, symbol) = Quantity::Coefficient(Term::Quantization).unit(judged.limit.unit);
        let pulse = |q: f64| with_unit(libm::sqrt(12.0) * q, 3, symbol);
        alternative("readout_lsb", "pulse", pulse(value), pulse(limit))
    });
    let alternatives: Vec<Alternative> = mean.into_iter().chain(pulse).collect();
    (!alternatives.is_empty()).then_some(Fact::ChangeToMeet { alternatives })
}

/// The length of a record that decides the limit if the value stays.
pub(super) fn to_decide(judged: &Judged, value: f64, [low, high]: [f64; 2]) -> Option<Fact> {
    let limit = judged.limit.value;
    let factor = match judged.of() {
        Limited::Coefficient(Term::Quantization | Term::AngleRandomWalk) | Limited::Floor => {
            // The interval of white noise narrows as 1/√T: its end on the side of the limit, and the limit, in logarithms of the
            // value.
            let end = if value < limit { libm::log(high / value) } else { libm::log(value / low) };
            let times = end / libm::log(limit / value);
            Some(times * times).filter(|factor| *factor <= MAX_FACTOR)
        }
        Limited::Coefficient(term) => LONGER
            .into_iter()
            .filter(|times| times * judged.subject.samples as f64 <= MAX_SAMPLES)
            .find(|times| decides(judged.subject, term, limit, judged, *times)),
        // The minimum of a longer record may move.
        Limited::Stability => None,
    }?;
    let length_s = judged.subject.length_s();
    let record = alternative("length", "record", duration(length_s), duration(factor * length_s));
    Some(Fact::ChangeToDecide { alternatives: vec![record] })
}

/// Whether the interval of the mean curve of records that are so many times as long does not contain the limit.
fn decides(subject: &Subject, term: Term, limit: f64, judged: &Judged, times: f64) -> bool {
    let Ok(fit) = subject.fit() else { return false };
    let terms = Terms::Auto(fit.coefficients.iter().map(|found| found.term).collect());
    let samples = (times * subject.samples as f64) as u64;
    let longer = expected(&fit.process, samples, subject.spread.over(times), fit.tau_range[0], &terms);
    let (factor, _, _) = Quantity::Coefficient(term).unit(judged.limit.unit);
    let found = longer.as_ref().and_then(|fit| fit.coefficient(term)).filter(|found| found.value.is_some());
    let ends = found.and_then(|found| found.interval).map(|ends| ends.map(|end| factor * end / limit));
    ends.is_some_and(|ends| Standing::of(ends) != Standing::Open)
}
