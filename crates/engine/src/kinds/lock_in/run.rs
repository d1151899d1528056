//! Running a study of lock-in: gyros that the store lacks are made batch by batch.

use rayon::prelude::*;

use crate::key::row::Refusal;
use crate::kinds::allan::columns::{CoefficientRow, coefficient_columns};
use crate::kinds::allan::run::coefficients::Found;
use crate::kinds::allan::run::{check_fit, geometry};
use crate::kinds::lock_in::columns::{Row, columns};
use crate::kinds::lock_in::lower::Gyros;
use crate::kinds::lock_in::lower::theory::{self, Zone};
use crate::kinds::lock_in::point::Times;
use crate::kinds::lock_in::{LockInStudy, Point};
use crate::kinds::plan::table;
use crate::sampling::batches::{Records, Wanted, held_by_all};
use crate::sampling::{self, Done, RunError, Tables, Worker};
use crate::store::error::StoreError;
use crate::store::{Index, Store};
use crate::study::Study;
use crate::tally::{Id, Share};
use sagnac_base::progress::Progress;
use sagnac_base::source::diagnose::StudyError;
use sagnac_records::allan::unit::Unit;
use sagnac_records::fit::choose::Terms;
use sagnac_records::fit::coefficient::Fit;
use sagnac_records::fit::fitter::Fitter;
use sagnac_records::fit::quantity::Quantity;
use sagnac_theory::allan::terms::Term;

/// A study whose points are all proven to fit.
#[derive(Debug)]
pub(crate) struct Plan<'a> {
    study: &'a Study,
    subject: &'a LockInStudy,
    /// Gyros of each point.
    points: Vec<Gyros>,
    records: Vec<Records>,
}

/// A mean and its standard error, of which there is none for a single value.
type Estimate = (f64, Option<f64>);

impl<'a> Plan<'a> {
    /// Lowers every point. `None` if `progress` asks to stop.
    pub(crate) fn new(
        study: &'a Study,
        subject: &'a LockInStudy,
        progress: &dyn Progress,
    ) -> Result<Option<Plan<'a>>, StudyError> {
        progress.start("points", 0, subject.points.len() as u64);
        let (mut points, mut records) = (Vec::new(), Vec::new());
        for point in &subject.points {
            if progress.stops() {
                return Ok(None);
            }
            let lowered = Gyros::new(point, subject.estimator, study.seed, study.streams);
            let gyros = lowered.map_err(|refusal: Refusal| study.refused(&point.swept, &refusal))?;
            check_fit(subject.terms.as_ref(), &point.times.ms, point.times.samples)
                .map_err(|refusal| study.refused(&point.swept, &refusal))?;
            let samples = u64::from(gyros.recipe().samples);
            study.check_trials(gyros.width(), "gyros")?;
            records.push(Records { address: gyros.address, samples, width: gyros.width() });
            points.push(gyros);
            progress.advance(1);
        }
        Ok(Some(Plan { study, subject, points, records }))
    }

    fn wanted<T>(&self, with: impl FnOnce(&Wanted) -> T) -> T {
        let recipe = |place: usize| Ok(self.points[place].shared());
        with(&Wanted { trials: self.study.trials, points: &self.records, recipe: &recipe })
    }

    /// The rows of a point, one for each averaging time.
    fn rows<'p>(point: &'p Point, gyros: &Gyros, rates: &[f64], variances: &[Vec<f64>]) -> Vec<Row<'p>> {
        let (rate, theory) = (estimate(rates), theory::angle_random_walk(point));
        // A strong lock-in holds the output in a zone that is not the nearest to the input.
        let zone = rate.and_then(|(rate, _)| Zone::nearest(&point.inputs, rate));
        let row = |(at, &m): (usize, &u64)| {
            let of_gyros: Vec<f64> = variances.iter().map(|variances| variances[at]).collect();
            let tau_s = point.times.sample_s * m as f64;
            Row {
                point,
                m,
                trials: rates.len() as u64,
                variance: estimate(&of_gyros),
                rate,
                theory,
                rounding: theory.map_or(0.0, |walk| gyros.rounding(tau_s, walk)),
                theory_rate: theory::mean_output(point),
                zone,
                input_rate: gyros.input_rate,
                step_s: Some(gyros.step_s()),
                representation: gyros.representation,
            }
        };
        point.times.ms.iter().enumerate().map(row).collect()
    }

    /// The rows of the coefficients that are fitted to the curves of a point.
    fn coefficients<'p>(
        &self,
        point: &'p Point,
        terms: &Terms,
        variances: &[Vec<f64>],
    ) -> Vec<CoefficientRow<'p>> {
        let Times { sample_s, samples, ref ms, .. } = point.times;
        let curve = geometry(sample_s, samples, ms, self.subject.estimator.difference);
        let fitter = curve.and_then(|curve| Some((curve.ms().len(), Fitter::new(&curve, terms).ok()?)));
        let fit = |variances: &Vec<f64>| {
            let (fitted, fitter) = fitter.as_ref()?;
            fitter.fit_record(&variances[..*fitted]).ok()
        };
        let fits: Vec<Option<Fit>> = variances.par_iter().map(fit).collect();
        // Of the coefficients only N is known.
        let walk = theory::angle_random_walk(point);
        let row = |quantity: Quantity| {
            let of_walk = quantity.parts().0 == Term::AngleRandomWalk;
            let truth = walk.filter(|_| of_walk).map(|walk| quantity.unit(Unit::Angular).0 * walk);
            CoefficientRow { swept: &point.swept, quantity, truth, found: Found::of(&fits, quantity, truth) }
        };
        Quantity::all(terms.all()).into_iter().map(row).collect()
    }
}

/// The mean of some values with its standard error; `None` of none.
fn estimate(values: &[f64]) -> Option<Estimate> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    let se = (values.len() > 1).then(|| libm::sqrt(squares / (count - 1.0) / count));
    (!values.is_empty()).then_some((mean, se))
}

impl sampling::Plan for Plan<'_> {
    fn run(
        &self,
        store: &mut Store,
        worker: &mut Worker,
        share: Share,
        progress: &dyn Progress,
    ) -> Result<Done, RunError> {
        self.wanted(|wanted| wanted.sample(store, worker, share, progress))
    }

    fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        self.wanted(|wanted| wanted.lacks(store, share))
    }

    fn tables(&self, store: Option<&Store>, progress: &dyn Progress) -> Result<Tables, RunError> {
        progress.start("points", 0, self.points.len() as u64);
        let (mut rows, mut coefficients) = (Vec::new(), Vec::new());
        for ((point, gyros), Records { address, width, .. }) in
            self.subject.points.iter().zip(&self.points).zip(&self.records)
        {
            let held = store.map(|store| store.rows(address, *width)).transpose()?.unwrap_or_default();
            let values: Vec<u128> = held.into_iter().flat_map(|rows| rows.values).collect();
            let gyros_of = || values.chunks_exact(*width);
            let rates: Vec<f64> = gyros_of().map(|values| gyros.mean_rate(values)).collect();
            let variances: Vec<Vec<f64>> = gyros_of().map(|values| gyros.variances(values)).collect();
            rows.extend(Plan::rows(point, gyros, &rates, &variances));
            if let Some(terms) = &self.subject.terms {
                coefficients.extend(self.coefficients(point, terms, &variances));
            }
            progress.advance(1);
        }
        let sweeps = &self.study.sweeps;
        let points = table(sweeps, &columns(), &rows, |row| &row.point.swept);
        let fitted = || table(sweeps, &coefficient_columns(), &coefficients, |row| row.swept);
        let coefficients = self.subject.terms.as_ref().map(|_| fitted());
        Ok(Tables { coefficients, ..Tables::of_points(points) })
    }

    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError> {
        held_by_all(index, self.records.iter().map(|records| records.address))
    }

    fn ids(&self) -> Vec<Id> {
        self.records.iter().map(|records| records.address.point).collect()
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        Ok(vec![])
    }

    fn all_trials(&self) -> u64 {
        u64::MAX
    }

    fn steps_of_a_trial(&self) -> Option<u64> {
        let points = self.subject.points.iter().zip(&self.points);
        let steps =
            points.map(|(Point { times, .. }, gyros)| times.samples as f64 * times.sample_s / gyros.step_s());
        Some(steps.sum::<f64>() as u64)
    }
}
