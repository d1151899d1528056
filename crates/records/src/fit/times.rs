//! Intervals of correlation times by test inversion.
//!
//! The standard error of the logarithm of a correlation time grows with the time: the longer it is, the fewer of them has a record. A
//! time that comes out short therefore also claims to be precise, and ± 1.96 of its standard errors miss the truth above
//! them. The ends are instead the times whose own standard errors make the found one the quantile of 2.5 or 97.5 %, each with the
//! squares that fit best beside it.

use crate::fit::search::{Fitted, System, shape_range};
use crate::fit::uncertainty::{WITHIN_95, error_of_shape};
use crate::fit::{Fit, Fitter, found};
use sagnac_theory::allan::Term;

/// Most steps in search of an end, and the change of its logarithm that counts as none.
const STEPS: usize = 20;
const NEAR: f64 = 1e-5;

impl Fitter {
    /// The fit of [`Fitter::curve`] with this interval of its correlation time, which keeps its own where the standard error of other
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
            if let (Some(low), Some(high)) = (low, high) {
                shape.interval = [low, high];
            }
        }
        fit
    }

    /// The time on the side of `sign` of which that of the term at `place` is a quantile. Where no time up to `limit` is, the end is
    /// `limit`, or 1.96 of the standard errors of the found time if these reach farther.
    fn end_of_shape(&self, terms: &[Fitted], place: usize, sign: f64, limit: f64) -> Option<f64> {
        let shape = terms[place].shape;
        let at = |distance: f64| shape * libm::exp(sign * distance);
        let reach = |distance: f64| Some(WITHIN_95 * self.error_at(terms, place, at(distance))?);
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

    /// Standard error of the logarithm of a correlation time if it were `shape`.
    fn error_at(&self, terms: &[Fitted], place: usize, shape: f64) -> Option<f64> {
        let mut moved = terms.to_vec();
        moved[place].shape = shape;
        let (growth, covariance) = self.model(&self.complete(&moved), None).ok()?;
        let names: Vec<Term> = moved.iter().map(|fitted| fitted.term).collect();
        let shapes: Vec<f64> = moved.iter().map(|fitted| fitted.shape).collect();
        let best = System::new(self.curve(), &covariance, &self.basis).given(&names, &shapes).terms;
        let covariance = growth.covariance(&self.complete(&best)).ok()?;
        error_of_shape(&System::new(self.curve(), &covariance, &self.basis), &best, terms[place].term)
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
    fn the_ends_of_a_correlation_time_are_those_of_dense_matrices() {
        // tests/data/allan/markov_ends.py; the errors at 14 s give 7.83 and 25.03 s.
        let table =
            [(1.0, 8.0, [4.9083, 14.3553]), (1.0, 14.0, [8.3431, 30.0305]), (2.0, 10.0, [6.6791, 16.9409])];
        for (sigma, time_s, ends) in table {
            let markov = Part::markov(sigma * libm::sqrt(2.0 / time_s), time_s);
            let found =
                fit(vec![Part::angle_random_walk(1.0), markov], &[Term::AngleRandomWalk, Term::Markov]);
            let shape = found.coefficient(Term::Markov).unwrap().shape.unwrap();
            assert!((shape.value / time_s - 1.0).abs() < 1e-5, "{shape:?}");
            for (end, expected) in shape.interval.iter().zip(ends) {
                assert!((end / expected - 1.0).abs() < 1e-3, "{sigma}, {time_s} s: {shape:?}, {ends:?}");
            }
        }
    }
}
