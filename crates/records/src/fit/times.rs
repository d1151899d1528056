//! Intervals of Markov noise by test inversion.
//!
//! The standard error of the logarithm of a correlation time grows with the time: the longer it is, the fewer of them has a record. A
//! time that comes out short therefore also claims to be precise, and ± 1.96 of its standard errors miss the truth above
//! them. The ends are instead the times whose own standard errors make the found one the quantile of 2.5 or 97.5 %, each with the
//! squares that fit best beside it.
//!
//! The longer the time, the larger and the less certain is the σ that fits best beside it, so that the interval of σ for the found time
//! misses the truth above it too. In logarithms, each end of σ is therefore the root of the sum of two squares from the found
//! value: the distance of the σ that fits best beside the end of the time, and the distance in the interval for the found time, scaled to
//! the standard error of σ beside a known time at that end (method of variance estimates recovery; Zou and Donner 2008).

use crate::fit::search::{Fitted, System, shape_range};
use crate::fit::uncertainty::{WITHIN_95, errors_of_shape};
use crate::fit::{Fit, Fitter, found};
use sagnac_theory::allan::Term;

/// Most steps in search of an end, and the change of its logarithm that counts as none.
const STEPS: usize = 20;
const NEAR: f64 = 1e-5;

impl Fitter {
    /// The fit of [`Fitter::curve`] with these intervals of its Markov noise, which keeps its own where the standard error of other
    /// times is not known.
    pub fn with_inverted_times(&self, mut fit: Fit) -> Fit {
        let terms = found(&fit);
        for coefficient in fit.coefficients.iter_mut().filter(|coefficient| coefficient.term == Term::Markov)
        {
            let place = terms.iter().position(|fitted| fitted.term == coefficient.term);
            let (Some(shape), Some(place)) = (&mut coefficient.shape, place) else { continue };
            let [least, most] = shape_range(self.curve(), coefficient.term);
            let low = self.end_of_shape(&terms, place, -1.0, least);
            let high = self.end_of_shape(&terms, place, 1.0, most);
            let (Some(low), Some(high)) = (low, high) else { continue };
            shape.interval = [low, high];
            let at = [low, shape.value, high].map(|time| self.errors_at(&terms, place, time));
            let [Some(first), Some(found), Some(last)] = at else { continue };
            let (Some(value), Some([least, most])) = (coefficient.value, coefficient.interval) else {
                continue;
            };
            let [first, last] = if first.0 < last.0 { [first, last] } else { [last, first] };
            // The logarithm of σ is half of that of its square.
            let factor = |end: f64, (square, [_, _, known]): (f64, [f64; 3])| {
                let own = libm::log(end / value) * known / found.1[1];
                libm::exp(libm::hypot(own, 0.5 * libm::log(square / found.0)))
            };
            coefficient.interval = Some([value / factor(least, first), value * factor(most, last)]);
        }
        fit
    }

    /// The time on the side of `sign` of which that of the term at `place` is a quantile. Where no time up to `limit` is, the end is
    /// `limit`, or 1.96 of the standard errors of the found time if these reach farther.
    fn end_of_shape(&self, terms: &[Fitted], place: usize, sign: f64, limit: f64) -> Option<f64> {
        let shape = terms[place].shape;
        let at = |distance: f64| shape * libm::exp(sign * distance);
        let reach = |distance: f64| Some(WITHIN_95 * self.errors_at(terms, place, at(distance))?.1[0]);
        let first = reach(0.0)?;
        let farthest = libm::fabs(libm::log(limit / shape)).max(first);
        // Secants of what the errors of a time reach beyond its distance.
        let (mut before, mut distance) = ((0.0, first), first);
        for _ in 0..STEPS {
            let beyond = reach(distance)? - distance;
            if libm::fabs(beyond) < NEAR || (beyond > 0.0 && distance == farthest) {
                break;
            }
            let slope = (beyond - before.1) / (distance - before.0);
            before = (distance, beyond);
            distance = if slope < 0.0 { (distance - beyond / slope).clamp(0.0, farthest) } else { farthest };
        }
        Some(at(distance))
    }

    /// The square that fits best if the time beside it is `shape`, with the standard errors of [`errors_of_shape`].
    fn errors_at(&self, terms: &[Fitted], place: usize, shape: f64) -> Option<(f64, [f64; 3])> {
        let mut moved = terms.to_vec();
        moved[place].shape = shape;
        let (growth, covariance) = self.model(&self.complete(&moved), None).ok()?;
        let names: Vec<Term> = moved.iter().map(|fitted| fitted.term).collect();
        let shapes: Vec<f64> = moved.iter().map(|fitted| fitted.shape).collect();
        let best = System::new(self.curve(), &covariance, &self.basis).given(&names, &shapes).terms;
        let covariance = growth.covariance(&self.complete(&best)).ok()?;
        let system = System::new(self.curve(), &covariance, &self.basis);
        Some((best[place].square, errors_of_shape(&system, &best, terms[place].term)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Curve, Terms};
    use sagnac_theory::allan::{Difference, Estimator, Part, Process};

    /// The curve of 512 samples of 2 s of the truth itself, whose fit is the truth.
    fn fit(parts: Vec<Part>, terms: &[Term]) -> Fit {
        let truth = Process { sample_s: 2.0, parts };
        let ms: Vec<u64> = (0..7).map(|octave| 1 << octave).collect();
        let at = |&m: &u64| truth.expected(Estimator::OVERLAPPING, 512, m).unwrap();
        let variances = ms.iter().map(at).collect();
        let curve = Curve::new(2.0, 512, Difference::Second, ms, variances).unwrap();
        let fitter = Fitter::new(&curve, &Terms::Given(terms.to_vec())).unwrap();
        fitter.with_inverted_times(fitter.fit_record(curve.variances()).unwrap())
    }

    #[test]
    fn the_ends_of_markov_noise_are_those_of_dense_matrices() {
        // tests/data/allan/markov_ends.py; the errors at 14 s give 7.83 and 25.03 s.
        let table = [
            (1.0, 8.0, [0.8695, 1.2184], [4.9083, 14.3553]),
            (1.0, 14.0, [0.8586, 1.3168], [8.3431, 30.0305]),
            (2.0, 10.0, [1.7690, 2.4488], [6.6791, 16.9409]),
        ];
        for (sigma, time_s, sizes, times) in table {
            let markov = Part::markov(sigma * libm::sqrt(2.0 / time_s), time_s);
            let fit = fit(vec![Part::angle_random_walk(1.0), markov], &[Term::AngleRandomWalk, Term::Markov]);
            let found = fit.coefficient(Term::Markov).unwrap();
            let shape = found.shape.unwrap();
            assert!((shape.value / time_s - 1.0).abs() < 1e-5, "{shape:?}");
            let ends = found.interval.unwrap().into_iter().chain(shape.interval);
            for (end, expected) in ends.zip(sizes.into_iter().chain(times)) {
                assert!((end / expected - 1.0).abs() < 1e-3, "{sigma}, {time_s} s: {end}, not {expected}");
            }
        }
    }
}
