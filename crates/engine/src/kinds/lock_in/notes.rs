//! Notes on a study of lock-in.

use crate::kinds::lock_in::Point;
use crate::kinds::lock_in::lower::theory::failing;
use sagnac_base::quantity::number::significant;
use sagnac_theory::lock_in::Premise;

/// Relative change of a sampling time that is said.
const SAID: f64 = 1e-9;

/// Notes on the points as they are read, each a sentence.
pub(crate) fn of(points: &[Point]) -> Vec<String> {
    premises(points).into_iter().chain(rounded(points)).collect()
}

/// Why some points have no closed form of the angle random walk.
fn premises(points: &[Point]) -> Vec<String> {
    let failing: Vec<Vec<Premise>> = points.iter().filter_map(failing).collect();
    let all = [Premise::Independent, Premise::Separate, Premise::SlowInput, Premise::Weak];
    let note = |premise: Premise| {
        let count = failing.iter().filter(|of_point| of_point.contains(&premise)).count();
        (count > 0).then(|| {
            let points = if points.len() == 1 {
                String::new()
            } else {
                format!(" at {count} of {} points", points.len())
            };
            format!("the angle random walk has no closed form{points}: {}", premise.failure())
        })
    };
    all.into_iter().filter_map(note).collect()
}

/// Sampling times that are rounded to whole periods of the dither.
fn rounded(points: &[Point]) -> Option<String> {
    let changed = points.iter().find(|point| {
        let asked = point.inputs.sample_s;
        asked.is_some_and(|asked| libm::fabs(asked / point.times.sample_s - 1.0) > SAID)
    })?;
    let asked = significant(changed.inputs.sample_s?, 6);
    Some(format!(
        "record.sample is rounded to whole periods of the dither: {asked} s to {} s",
        significant(changed.times.sample_s, 9)
    ))
}
