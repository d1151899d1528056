//! Notes attached to the results of a study of Allan curves.

use crate::kinds::allan::point::Point;
use crate::noise::{self, Noise};
use sagnac_base::quantity::number::significant;
use sagnac_records::fit::choose::Terms;
use sagnac_theory::allan::terms::Term;

/// Relative rounding of an interval that needs no note.
const ROUNDED: f64 = 1e-9;
/// Most intervals whose rounding is listed.
const MAX_LISTED: usize = 3;
/// °/√h of 1 ″/√s.
const DEG_PER_SQRT_H: f64 = 1.0 / 60.0;

/// All notes, each a sentence; `terms` are the fitted ones.
pub(crate) fn of(terms: Option<&Terms>, points: &[Point]) -> Vec<String> {
    let unfitted = terms.and_then(|terms| unfitted(terms, points));
    let switching = terms.and_then(|_| switching(points));
    let gyros = points.iter().filter_map(|Point { inputs, .. }| Some((inputs.noise.lock_in?, inputs.rate)));
    rounded(points).into_iter().chain(noise::note(gyros)).chain(unfitted).chain(switching).collect()
}

/// Intervals between switches that are not whole numbers of samples.
fn rounded(points: &[Point]) -> Option<String> {
    let mut intervals: Vec<String> = Vec::new();
    for point in points {
        let sample_s = point.inputs.sample_s;
        let Some(asked) = point.inputs.noise.switching else { continue };
        let taken_s = asked.interval(sample_s) as f64 * sample_s;
        if (taken_s - asked.interval_s).abs() > ROUNDED * taken_s {
            let interval = format!("{} s as {} s", significant(asked.interval_s, 6), significant(taken_s, 6));
            if !intervals.contains(&interval) {
                intervals.push(interval);
            }
        }
    }
    let more = intervals.len().saturating_sub(MAX_LISTED);
    intervals.truncate(MAX_LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!intervals.is_empty()).then(|| {
        format!("noise.switching.interval is taken as whole samples: {}{more}", intervals.join(", "))
    })
}

/// The coefficients of a fit that absorb switching.
fn switching(points: &[Point]) -> Option<String> {
    let switched = || {
        points.iter().filter_map(|point| {
            Some((point.inputs.sample_s, point.inputs.noise.switched(point.inputs.sample_s)?))
        })
    };
    let walks = switched().filter_map(|(t0, switching)| Some(switching.jumps()?.angle_random_walk(t0)));
    let [least, most] = walks.fold([f64::INFINITY, 0.0_f64], |[least, most], n| [least.min(n), most.max(n)]);
    let residuals = (most > 0.0).then(|| {
        let [least, most] = [least, most].map(|n| significant(DEG_PER_SQRT_H * n, 3));
        let n = if least == most { most } else { format!("{least} to {most}") };
        format!("fill residuals as an angle random walk of {n} °/√h at averaging times above the interval")
    });
    let drift = switched().any(|(_, switching)| switching.drifts()).then(|| {
        "the alternating drift, highest at averaging times from half an interval to a whole one, as B and K, and at \
         intervals of some 10 samples as N"
            .to_owned()
    });
    let seen: Vec<String> = residuals.into_iter().chain(drift).collect();
    (!seen.is_empty()).then(|| {
        format!("no term of the fit models switching, other coefficients absorb it: {}", seen.join(", "))
    })
}

/// Parts of the noise that no fitted term covers.
fn unfitted(terms: &Terms, points: &[Point]) -> Option<String> {
    let has =
        |term: Term, noise: &Noise| noise.has(term) || term == Term::Quantization && noise.readout_lsb > 0.0;
    let is_unfitted = |term: &Term| {
        !terms.all().contains(term) && points.iter().any(|point| has(*term, &point.inputs.noise))
    };
    // The angle random walk comes first, as every gyro has one.
    let walk = [Term::AngleRandomWalk];
    let all = walk.into_iter().chain(Term::EVERY.into_iter().filter(|term| !walk.contains(term)));
    let found: Vec<String> = all.filter(is_unfitted).map(|term| term.row().name.concat()).collect();
    (!found.is_empty()).then(|| {
        format!("the noise has {}, which is not fitted: other coefficients absorb it", found.join(", "))
    })
}
