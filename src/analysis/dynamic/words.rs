//! Whether the noise of a column changes, as a sentence.

use crate::analysis::compare::words::duration;
use sagnac_base::quantity::number::{probability, significant, with_unit};
use sagnac_records::allan::Deviation;
use sagnac_records::fit::Quantity;
use sagnac_theory::allan::{Estimator, Process, Term};

use crate::analysis::dynamic::Column;
use crate::analysis::dynamic::change::{FALSE_ALARM, MIN_PART, MIN_PARTS, Octave, PARTS, clearest};

/// Part of the variance that white noise must have at a τ for a change there to be one of N.
const MOSTLY: f64 = 0.8;

/// The change of a column, or the step that would have been seen.
pub fn sentence(column: &Column) -> String {
    let tests = column.octaves.len();
    let Some(octave) = clearest(&column.octaves) else {
        return format!(
            "no test for a change, which takes {PARTS} parts of {MIN_PART} samples or more, {MIN_PARTS} of them neither missing nor constant"
        );
    };
    let counted = format!("{}, counting {tests} averaging times", probability(octave.p));
    if octave.p < FALSE_ALARM {
        let at = duration(column.skipped_s + octave.at_s);
        return format!("{} from {at} on ({counted})", change(column, octave));
    }
    let finest = column.octaves.iter().min_by(|a, b| a.visible.total_cmp(&b.visible)).unwrap_or(octave);
    let of = match white(column, finest) {
        Some(_) => "N".to_owned(),
        None => format!("σ({} s)", significant(finest.tau_s, 4)),
    };
    format!(
        "no change seen ({counted}): a step of {of} by {} % in the middle of the record would have been detected with 90 % power",
        significant(100.0 * finest.visible, 2)
    )
}

/// The values before and after a change: of N where it makes up most of the noise at that τ, else of the deviation.
fn change(column: &Column, octave: &Octave) -> String {
    match white(column, octave) {
        Some(n) => {
            let (factor, _, symbol) = Quantity::Coefficient(Term::AngleRandomWalk).unit(column.unit);
            let [before, after] = [octave.before, octave.after].map(|end| factor * n * end / octave.whole);
            format!("N changes: {} → {}", significant(before, 3), with_unit(after, 3, symbol))
        }
        None => {
            let (tau, before) = (significant(octave.tau_s, 4), significant(octave.before, 3));
            let after = with_unit(octave.after, 3, column.unit.symbol(Deviation::Oadev));
            format!("σ({tau} s) changes: {before} → {after}")
        }
    }
}

/// N of the record, if it makes up most of the noise at the τ of an octave.
fn white(column: &Column, octave: &Octave) -> Option<f64> {
    let model = column.model.as_ref()?;
    let part = model.parts.iter().find(|part| part.term == Term::AngleRandomWalk)?;
    let alone = Process { sample_s: model.sample_s, parts: vec![*part] };
    let variance =
        |process: &Process| process.expected(Estimator::OVERLAPPING, column.samples as u64, octave.m as u64);
    (variance(&alone)? > MOSTLY * variance(model)?).then(|| libm::sqrt(part.square()))
}
