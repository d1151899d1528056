//! coefficients.csv of a study of Allan curves, which shows how accurately each coefficient is recovered.

use rayon::prelude::*;

use crate::kinds::allan::columns::CoefficientRow;
use crate::kinds::allan::point::{Inputs as RecordInputs, Point as RecordPoint};
use crate::kinds::allan::run::{Estimates, Plan, of_point};
use crate::noise::Noise;
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::unit::Unit;
use sagnac_records::fit::choose::Terms;
use sagnac_records::fit::coefficient::{Fit, Verdict};
use sagnac_records::fit::covariance::Covariance;
use sagnac_records::fit::curve::Curve;
use sagnac_records::fit::fitter::{Errors, Fitter};
use sagnac_records::fit::quantity::Quantity;
use sagnac_theory::allan::estimator::Stride;
use sagnac_theory::allan::part::Part;
use sagnac_theory::allan::terms::Term;

/// The estimates of one coefficient over all records.
pub(crate) struct Found {
    /// Values from the records in which it is identified.
    values: Vec<f64>,
    /// Number of records with an interval, followed by that of records whose interval contains the truth.
    intervals: usize,
    covered: usize,
    /// Number of records that could be fitted, followed by that of all records.
    fitted: usize,
    records: usize,
}

impl Plan<'_> {
    /// A row for each coefficient fitted to the records of a point. `progress` receives numbers of fits as they
    /// complete.
    pub(crate) fn coefficients<'p>(
        &self,
        point: &'p RecordPoint,
        terms: &Terms,
        estimates: &Estimates,
        progress: &(dyn Fn(u64) + Sync),
    ) -> impl Iterator<Item = CoefficientRow<'p>> + use<'p> {
        let fits = self.fits(point, terms, estimates, progress);
        Quantity::all(terms.all()).into_iter().map(move |quantity| {
            let truth = truth(quantity, &point.inputs.noise);
            CoefficientRow { swept: &point.swept, quantity, truth, found: Found::of(&fits, quantity, truth) }
        })
    }

    /// Whether records are weighted by the covariance estimated from all of them. Overlapping estimates of a record are
    /// fitted as if it were the only one. Adjacent groups, however, scatter more than the closed form says, and for
    /// terms with a time or frequency the closed form takes a second per record.
    pub(crate) fn are_weighed_together(&self, terms: &Terms) -> bool {
        self.allan.estimator.stride == Stride::Cluster || have_shapes(terms)
    }

    /// The fit of each record, in order; `None` for records without a valid curve.
    pub(crate) fn fits(
        &self,
        point: &RecordPoint,
        terms: &Terms,
        estimates: &Estimates,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Vec<Option<Fit>> {
        let fitter = of_point(point, self.allan.estimator.difference)
            .and_then(|geometry| Some((Fitter::new(&geometry, terms).ok()?, geometry)));
        let Some((fitter, geometry)) = fitter else { return vec![None; estimates.count()] };
        let fitted = geometry.ms().len();
        let together = self.are_weighed_together(terms);
        let covariance = if together { covariance(point, &geometry, estimates) } else { None };
        let errors = if have_shapes(terms) { Errors::Known } else { Errors::OfModel };
        let fit = |record: &[f64]| {
            progress(1);
            match &covariance {
                Some(covariance) => fitter.fit(&record[..fitted], covariance, errors).ok(),
                None if together => None,
                None => fitter.fit_record(&record[..fitted]).ok(),
            }
        };
        estimates.records().map(fit).collect()
    }
}

/// Whether some terms have a time or frequency.
fn have_shapes(terms: &Terms) -> bool {
    terms.all().iter().any(|term| term.has_shape())
}

/// The covariance of the estimates of a point's records, estimated from the records together with the closed form for
/// overlapping estimates; `None` for too few records.
fn covariance(point: &RecordPoint, geometry: &Curve, estimates: &Estimates) -> Option<Covariance> {
    let RecordInputs { sample_s, noise, .. } = &point.inputs;
    let mut process = noise.process(*sample_s, point.inputs.samples());
    if noise.readout_lsb > 0.0 {
        process.parts.push(Part::quantization(noise.readout_lsb / libm::sqrt(12.0)));
    }
    let jumps = noise.switched(*sample_s).and_then(|switching| switching.jumps());
    process.parts.extend(jumps.map(|jumps| Part::angle_random_walk(jumps.angle_random_walk(*sample_s))));
    let model = Covariance::of_process(&process, geometry).ok()?;
    let fitted = geometry.ms().len();
    let rows: Vec<Vec<f64>> = estimates.records().map(|record| record[..fitted].to_vec()).collect();
    Covariance::of_realizations(&rows, &model).ok()
}

/// The true value of a quantity, in the unit of data sheets; absent for the shape of a term that the noise lacks.
fn truth(quantity: Quantity, noise: &Noise) -> Option<f64> {
    let (term, shape) = quantity.parts();
    let [size, of_shape] = noise.of(term);
    let value = match term {
        _ if shape.is_some() => of_shape,
        // A readout in whole pulses has an error of 1/√12 of a pulse.
        Term::Quantization => libm::hypot(size, noise.readout_lsb / libm::sqrt(12.0)),
        _ => size.abs(),
    };
    (shape.is_none() || value > 0.0).then_some(quantity.unit(Unit::Angular).0 * value)
}

impl Found {
    pub(crate) fn of(fits: &[Option<Fit>], quantity: Quantity, truth: Option<f64>) -> Found {
        let (factor, ..) = quantity.unit(Unit::Angular);
        let mut found = Found { values: vec![], intervals: 0, covered: 0, fitted: 0, records: fits.len() };
        for coefficient in fits.iter().flatten().filter_map(|fit| fit.coefficient(quantity.parts().0)) {
            found.fitted += 1;
            let (value, interval) = quantity.of(coefficient);
            if coefficient.verdict == Verdict::Identified {
                found.values.extend(value.map(|value| factor * value));
            }
            if let Some([low, high]) = interval.map(|ends| ends.map(|end| factor * end)) {
                found.intervals += 1;
                found.covered += usize::from(truth.is_some_and(|truth| low <= truth && truth <= high));
            }
        }
        found
    }

    pub(crate) fn mean(&self) -> Option<f64> {
        let count = self.values.len() as f64;
        (count > 0.0).then(|| self.values.iter().sum::<f64>() / count)
    }

    fn spread(&self, about: f64, by: f64) -> f64 {
        libm::sqrt(self.values.iter().map(|x| (x - about) * (x - about)).sum::<f64>() / by)
    }

    pub(crate) fn deviation(&self) -> Option<f64> {
        let count = self.values.len() as f64;
        self.mean().filter(|_| count > 1.0).map(|mean| self.spread(mean, count - 1.0))
    }

    pub(crate) fn rmse(&self, truth: Option<f64>) -> Option<f64> {
        let count = self.values.len() as f64;
        truth.filter(|_| count > 0.0).map(|truth| self.spread(truth, count))
    }

    pub(crate) fn relative_rmse(&self, truth: Option<f64>) -> Option<f64> {
        // If most records do not show the coefficient, those that do are the ones in which it came out too large.
        let is_mostly_shown = 2 * self.values.len() >= self.records;
        let truth = truth.filter(|truth| *truth > 0.0 && is_mostly_shown)?;
        Some(self.rmse(Some(truth))? / truth)
    }

    pub(crate) fn coverage(&self, truth: Option<f64>) -> Option<f64> {
        truth.and_then(|_| part(self.covered, self.intervals))
    }

    pub(crate) fn identified(&self) -> Option<f64> {
        part(self.values.len(), self.records)
    }

    pub(crate) fn records(&self) -> u64 {
        self.records as u64
    }

    pub(crate) fn verdict(&self, truth: Option<f64>) -> String {
        if self.records == 0 {
            return String::new();
        }
        let percent = |count: usize| significant(100.0 * count as f64 / self.records as f64, 3);
        let shown = percent(self.values.len());
        let verdict = match (self.values.len(), truth) {
            (0, Some(truth)) if truth > 0.0 => "not estimable from such a record".to_owned(),
            (0, _) => "absent, and found in no record".to_owned(),
            (_, Some(truth)) if truth > 0.0 => format!("detected in {shown} % of records"),
            _ => format!("absent, but found in {shown} % of records"),
        };
        match self.records - self.fitted {
            0 => verdict,
            failed => format!("{verdict}; no fit in {} %", percent(failed)),
        }
    }
}

fn part(of: usize, all: usize) -> Option<f64> {
    (all > 0).then(|| of as f64 / all as f64)
}
