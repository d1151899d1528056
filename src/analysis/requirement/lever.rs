//! What to change next so that a record meets a limit, or decides it.

use crate::analysis::compare::length::expected;
use crate::analysis::compare::words::duration;
use crate::analysis::requirement::judged::{Judged, Shown, Standing};
use crate::analysis::requirement::limit::Limited;
use crate::analysis::requirement::subject::{Gap, Subject};
use crate::fit::{Quantity, Term, Terms};
use crate::quantity::number::{significant, with_unit};

/// Most sensors whose mean is proposed.
const MOST_SENSORS: f64 = 100.0;
/// How many times as long a record may be to be proposed.
const LONGEST: f64 = 1000.0;
/// How many times longer records are tried by their expected curve.
const LONGER: [f64; 4] = [2.0, 4.0, 16.0, 64.0];
/// Most samples of a tried record, for which there is flicker.
const MOST_SAMPLES: f64 = 6e7;

/// The step that follows from a judgement.
pub(crate) fn told(judged: &Judged) -> String {
    match (&judged.shown, judged.standing()) {
        (Err(gap), _) => of_gap(gap, judged.of()),
        (_, Standing::Met) => "Nothing has to change; every limit is met.".to_owned(),
        (Ok(Shown { value: Some(value), .. }), Standing::NotMet) => fall(judged, *value),
        (Ok(Shown { value: Some(value), ends }), _) => longer(judged, *value, *ends),
        (Ok(Shown { value: None, .. }), _) => format!(
            "A longer record lowers the upper bound of {}; by how much does not follow from this one.",
            judged.of().told()
        ),
    }
}

fn of_gap(gap: &Gap, of: Limited) -> String {
    match gap {
        Gap::Failed(_) | Gap::NoMinimum => "A record from which this can be determined.".to_owned(),
        Gap::NotAsked | Gap::NotFitted => format!("Fit {} too.", of.told()),
        Gap::NotDescribed => {
            "Fit other terms or another range of τ, or leave out the part of the record that they do not describe."
                .to_owned()
        }
        Gap::NoBound => format!("A longer record, which may show {} or bound it.", of.told()),
        Gap::NoFloor => "A longer record or shorter segments, whose density may show a flat range.".to_owned(),
    }
}

/// How far a value has to fall, and what makes it fall.
fn fall(judged: &Judged, value: f64) -> String {
    let (of, limit) = (judged.of(), judged.limit.value);
    let percent = format!("{} %", significant(100.0 * limit / value, 3));
    let told = format!("{} has to fall to {percent} of its value", of.told());
    // A limit in decimals may be off by a rounding.
    let sensors = libm::ceil(value / limit * (value / limit) * (1.0 - 1e-9));
    let is_noise = match of {
        Limited::Coefficient(term) => !matches!(term, Term::RateRamp | Term::Sine),
        Limited::Floor => true,
        // The minimum of a mean need not lie at the same τ.
        Limited::Stability => false,
    };
    let mean = match is_noise && sensors <= MOST_SENSORS {
        true => format!("; the mean of {sensors} such sensors with independent noise is that low"),
        false => String::new(),
    };
    let pulse = match of {
        Limited::Coefficient(Term::Quantisation) => {
            let (_, _, symbol) = Quantity::Coefficient(Term::Quantisation).unit(judged.limit.unit);
            let pulse = with_unit(libm::sqrt(12.0) * limit, 3, symbol);
            format!(
                "; if whole pulses cause it, a pulse of {pulse} meets the limit, as its Q is a pulse over √12"
            )
        }
        _ => String::new(),
    };
    crate::view::report::agreement::capitalised(&format!("{told}{mean}{pulse}."))
}

/// The length of a record that decides the limit if the value stays.
fn longer(judged: &Judged, value: f64, [low, high]: [f64; 2]) -> String {
    let (of, limit) = (judged.of(), judged.limit.value);
    let name = of.told();
    let length_s = judged.subject.length_s();
    match of {
        Limited::Coefficient(Term::Quantisation | Term::AngleRandomWalk) | Limited::Floor => {
            // The end of the interval on the side of the limit, and the limit, in logarithms of the value.
            let end = if value < limit { libm::log(high / value) } else { libm::log(value / low) };
            let times = end / libm::log(limit / value);
            match times * times {
                factor if factor <= LONGEST => format!(
                    "A record of {}, {} times as long, if {name} keeps its value: the interval of white noise narrows as 1/√T.",
                    duration(factor * length_s),
                    significant(factor, 2)
                ),
                _ => format!(
                    "{name} is so close to the limit that a record {LONGEST} times as long would not decide it, if the interval \
                     narrows as 1/√T."
                ),
            }
        }
        Limited::Coefficient(term) => {
            let tried =
                LONGER.into_iter().filter(|times| times * judged.subject.samples as f64 <= MOST_SAMPLES);
            let tried: Vec<f64> = tried.collect();
            let enough = tried.iter().find(|times| decides(judged.subject, term, limit, judged, **times));
            match (enough, tried.last()) {
                (Some(times), _) => format!(
                    "A record of {}, {times} times as long, if {name} keeps its value: by the expected curve of such a record.",
                    duration(times * length_s)
                ),
                (None, Some(longest)) => format!(
                    "If {name} keeps its value, even a record of {} does not decide it, by the expected curve of such a record.",
                    duration(longest * length_s)
                ),
                (None, None) => {
                    format!(
                        "A longer record narrows the interval of {name}; by how much does not follow from this one."
                    )
                }
            }
        }
        Limited::Stability => format!(
            "A longer record narrows the interval of {name}; by how much does not follow from this one, because the minimum may \
             move."
        ),
    }
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
