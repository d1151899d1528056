//! Running a study of Allan curves: records that the store lacks are made batch by batch.

pub(crate) mod coefficients;
pub(crate) mod curves;
pub(crate) mod estimates;

use std::sync::Arc;

use crate::key::row::Refusal;
use crate::kinds::allan::Allan;
use crate::kinds::allan::columns::{coefficient_columns, columns};
use crate::kinds::allan::lower::curve::LoweredCurve;
use crate::kinds::allan::lower::physical_theory::PhysicalTheory;
use crate::kinds::allan::point::Point as RecordPoint;
use crate::kinds::allan::run::estimates::Estimates;
use crate::kinds::plan::table;
use crate::sampling::batches::{Records, Wanted, held_by_all};
use crate::sampling::{self, Done, RunError, Tables, Worker};
use crate::store::error::StoreError;
use crate::store::{Index, Store};
use crate::study::Study;
use crate::tally::{Id, Share};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::significant;
use sagnac_base::source::diagnose::StudyError;
use sagnac_records::fit::choose::Terms;
use sagnac_records::fit::curve::Curve;
use sagnac_theory::allan::estimator::{Difference, Estimator};

/// Inverse of the longest averaging time of the fit relative to the record; beyond it, intervals of K come out too
/// short.
const MAX_FITTED: u64 = 8;

/// Relative deviation that needs no note.
const NEGLIGIBLE: f64 = 1e-4;

/// Most bytes of angles that a thread keeps for the records that it makes side by side.
const MAX_BYTES: usize = 1 << 30;

/// Most lanes of a thread.
const LANES: usize = 16;

/// A study of Allan curves whose points are all proven to fit.
#[derive(Debug)]
pub(crate) struct Plan<'a> {
    study: &'a Study,
    allan: &'a Allan,
    /// The records of each point. Words are recomputed whenever they are needed, because drift takes 4 bytes per sample.
    records: Vec<Records>,
    /// Largest relative deviation of the records due to the kernel's arithmetic, and its τ, s.
    off: (f64, f64),
}

impl<'a> Plan<'a> {
    /// Lowers every point, one after the other, because one may take as much memory as its record. `None` if `progress`
    /// asks to stop.
    pub(crate) fn new(
        study: &'a Study,
        allan: &'a Allan,
        progress: &dyn Progress,
    ) -> Result<Option<Plan<'a>>, StudyError> {
        let mut plan = Plan { study, allan, records: vec![], off: (0.0, 0.0) };
        progress.start("points", 0, allan.points.len() as u64);
        for point in &allan.points {
            if progress.stops() {
                return Ok(None);
            }
            plan.push(point).map_err(|refusal| study.refused(&point.swept, &refusal))?;
            study.check_trials(plan.records.last().map_or(0, |records| records.width), "records")?;
            progress.advance(1);
        }
        Ok(Some(plan))
    }

    /// Lowers a point and adds it.
    fn push(&mut self, point: &RecordPoint) -> Result<(), Refusal> {
        let lowered = self.lowered(point)?;
        let recipe = lowered.records.recipe();
        check_memory(point, 4 * LANES * recipe.depth())?;
        check_fit(self.allan.terms.as_ref(), &point.ms, point.inputs.samples())?;
        let off = off(point, &lowered, self.allan.estimator)?;
        if off.0 > self.off.0 {
            self.off = off;
        }
        let (samples, width) = (recipe.samples.into(), recipe.places());
        self.records.push(Records { address: lowered.address, samples, width });
        Ok(())
    }

    fn lowered(&self, point: &RecordPoint) -> Result<LoweredCurve, Refusal> {
        LoweredCurve::new(point, self.allan.estimator, self.study.seed, self.study.streams)
    }

    /// Does something with the records that the study wants.
    fn wanted<T>(&self, with: impl FnOnce(&Wanted) -> T) -> T {
        let recipe = |place: usize| {
            let lowered = self.lowered(&self.allan.points[place])?;
            Ok(Arc::new(lowered.records.recipe().clone()) as _)
        };
        with(&Wanted { trials: self.study.trials, points: &self.records, recipe: &recipe })
    }
}

/// Refuses a fit to fewer points than parameters.
pub(crate) fn check_fit(terms: Option<&Terms>, ms: &[u64], samples: u64) -> Result<(), Refusal> {
    let Some(terms) = terms else { return Ok(()) };
    let points = ms.iter().filter(|&&m| is_fitted(m, samples)).count();
    let parameters = terms.fewest_parameters();
    if points >= parameters {
        return Ok(());
    }
    let message = format!(
        "there are {points} averaging times up to an eighth of the record, too few for {parameters} parameters"
    );
    let help = "take more averaging times, as of tau = \"decade10\", a longer record, or fewer terms";
    Err(Refusal { key: "allan.tau", message, help })
}

/// Refuses records that take too much memory side by side.
fn check_memory(point: &RecordPoint, bytes: usize) -> Result<(), Refusal> {
    if bytes <= MAX_BYTES {
        return Ok(());
    }
    let (samples, mib) = (point.inputs.samples(), bytes >> 20);
    let message =
        format!("records of {samples} samples need {mib} MiB on each thread for the longest averaging times");
    let help = "take overlap = \"m/64\" and tau = \"octave\" or \"decade10\", shorter averaging times, or a shorter record";
    Err(Refusal { key: "allan", message, help })
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
        let unit = if self.allan.terms.is_some() { "fits" } else { "records" };
        // Number of records in the tables, each with a fit where terms are fitted.
        progress.start(unit, 0, self.study.trials * self.records.len() as u64);
        let (mut curves, mut coefficients) = (Vec::new(), Vec::new());
        // Only one point is in memory at a time.
        for (point, Records { address, width, .. }) in self.allan.points.iter().zip(&self.records) {
            let lowered = store.map(|_| self.lowered(point)).transpose()?;
            let estimates = match store.zip(lowered.as_ref()) {
                Some((store, LoweredCurve { records, .. })) => {
                    Estimates::of(store.rows(address, *width)?, |sums| records.variances(sums))
                }
                None => Estimates::default(),
            };
            curves.extend(self.curve(point, lowered.as_ref(), &estimates)?);
            match &self.allan.terms {
                Some(terms) => {
                    let advance = |fits| progress.advance(fits);
                    coefficients.extend(self.coefficients(point, terms, &estimates, &advance));
                }
                None => progress.advance(self.study.trials),
            }
        }
        let sweeps = &self.study.sweeps;
        let mut points = table(sweeps, &columns(), &curves, |row| &row.point.swept);
        if self.allan.estimator.difference == Difference::Third {
            for column in &mut points.columns {
                column.label = column.label.replace("Allan", "Hadamard");
            }
        }
        let fitted = || table(sweeps, &coefficient_columns(), &coefficients, |row| row.swept);
        let coefficients = self.allan.terms.as_ref().map(|_| fitted());
        Ok(Tables { coefficients, ..Tables::of_points(points) })
    }

    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError> {
        held_by_all(index, self.records.iter().map(|records| records.address))
    }

    fn ids(&self) -> Vec<Id> {
        self.records.iter().map(|records| records.address.point).collect()
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        let rounded = (self.off.0 > NEGLIGIBLE).then(|| {
            format!(
                "in 32-bit arithmetic the curve of the records is off by up to {} %, at τ = {} s: what is small beside the rest \
                 of so long a record has few units; a coefficient known to better than that is not covered",
                significant(100.0 * self.off.0, 2),
                significant(self.off.1, 6)
            )
        });
        let Some(terms) = &self.allan.terms else { return Ok(rounded.into_iter().collect()) };
        let longer = |point: &RecordPoint| point.ms.iter().any(|&m| !is_fitted(m, point.inputs.samples()));
        let shortened =
            self.allan.points.iter().any(longer).then(|| {
                "coefficients are fitted to averaging times up to an eighth of the record".to_owned()
            });
        let together = self.are_weighed_together(terms).then(|| {
            "records are weighed by the covariance that all of them show together, which a single one does not know"
                .to_owned()
        });
        Ok(rounded.into_iter().chain(shortened).chain(together).collect())
    }

    fn all_trials(&self) -> u64 {
        u64::MAX
    }
}

/// Part of the samples of a record that is spent on differences of drift when a point is lowered.
const PART_CHECKED: u64 = 16;

/// Largest relative difference between the deviation of a point's records and that of its inputs, and its τ, s. The closed
/// forms of records with drift sum their differences: here only the longest averaging times that add little to the lowering
/// are checked, and all of them in the tables.
///
/// # Errors
/// A difference exceeds what the rounding of words explains.
fn off(point: &RecordPoint, lowered: &LoweredCurve, estimator: Estimator) -> Result<(f64, f64), Refusal> {
    let physical = PhysicalTheory::of(point, estimator);
    let records = &lowered.records;
    let drifts = !records.recipe().drift.is_empty();
    let mut left = if drifts { physical.samples / PART_CHECKED } else { u64::MAX };
    let mut most = (0.0, 0.0);
    for (at, &m) in point.ms.iter().enumerate().rev() {
        if drifts {
            let Some(rest) = left.checked_sub(records.terms()[at]) else { continue };
            left = rest;
        }
        if let Some(found) = records.representation(at, &records.theory(at), &physical)? {
            let off = (libm::sqrt(1.0 + found) - 1.0).abs();
            if off >= most.0 {
                most = (off, point.inputs.sample_s * m as f64);
            }
        }
    }
    Ok(most)
}

/// Whether a fit includes this averaging factor.
fn is_fitted(m: u64, samples: u64) -> bool {
    MAX_FITTED * m <= samples
}

/// The averaging factors of a fit at a point, without estimates.
fn of_point(point: &RecordPoint, difference: Difference) -> Option<Curve> {
    geometry(point.inputs.sample_s, point.inputs.samples(), &point.ms, difference)
}

/// The averaging factors of a fit, without estimates.
pub(crate) fn geometry(sample_s: f64, samples: u64, ms: &[u64], difference: Difference) -> Option<Curve> {
    let ms: Vec<u64> = ms.iter().copied().filter(|&m| is_fitted(m, samples)).collect();
    let nothing = vec![1.0; ms.len()];
    Curve::new(sample_s, samples, difference, ms, nothing).ok()
}
