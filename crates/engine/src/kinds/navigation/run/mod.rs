//! Running a study of navigation: records that the store lacks are made batch by batch, and then become errors.

pub(crate) mod claim;
pub(crate) mod sizes;

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::prelude::*;

use crate::key::row::Refusal;
use crate::kinds::navigation::Navigation;
use crate::kinds::navigation::columns::{Quantity, Row, columns};
use crate::kinds::navigation::lower::physical_theory::PhysicalTheory;
use crate::kinds::navigation::lower::{Lowered, LoweredGyro};
use crate::kinds::navigation::run::claim::Claim;
use crate::kinds::navigation::run::sizes::Sizes;
use crate::kinds::plan::table;
use crate::sampling::batches::{Records, Wanted, held_by_all};
use crate::sampling::{self, Done, RunError, Tables, Worker};
use crate::store::error::StoreError;
use crate::store::{Index, Store};
use crate::study::Study;
use crate::tally::{Id, Share};
use sagnac_base::progress::Progress;
use sagnac_base::source::diagnose::StudyError;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::rows::Rows;
use sagnac_theory::navigation::radial::Radial;

/// A study of navigation whose points are all proven to fit.
#[derive(Debug)]
pub(crate) struct Plan<'a> {
    study: &'a Study,
    navigation: &'a Navigation,
    /// The records of each gyro of each set of coefficients of each point.
    records: Vec<Records>,
    /// Gyros and sets of a point.
    of_point: usize,
    /// The newest lowered point: the weights of its gyros are computed together.
    newest: Mutex<Option<(usize, Arc<Lowered>)>>,
    /// The closed forms of each point. They take longer than its tables, which decisions make for many parts of the trials.
    closed: Vec<OnceLock<Closed>>,
}

/// What the words of a point give in closed form.
#[derive(Debug, Clone)]
struct Closed {
    /// By quantity.
    sizes: Vec<Sizes>,
    /// The distributions of the first error, where a filter claims one.
    claimed: Vec<Radial>,
    representation: Option<f64>,
}

impl<'a> Plan<'a> {
    /// Lowers every point. `None` if `progress` asks to stop.
    pub(crate) fn new(
        study: &'a Study,
        navigation: &'a Navigation,
        progress: &dyn Progress,
    ) -> Result<Option<Plan<'a>>, StudyError> {
        let closed = navigation.points.iter().map(|_| OnceLock::new()).collect();
        let mut plan =
            Plan { study, navigation, records: vec![], of_point: 1, newest: Mutex::new(None), closed };
        progress.start("points", 0, navigation.points.len() as u64);
        let lower = |point: usize| {
            if progress.stops() {
                return None;
            }
            let records = plan.lowered(point).map(|lowered| {
                let of_gyro = |gyro: &LoweredGyro| Records {
                    address: gyro.address,
                    samples: gyro.navigation.recipe().samples.into(),
                    width: lowered.errors.len(),
                };
                lowered.gyros.iter().map(of_gyro).collect::<Vec<Records>>()
            });
            progress.advance(1);
            Some(records)
        };
        let all: Vec<Option<Result<Vec<Records>, Refusal>>> =
            (0..navigation.points.len()).into_par_iter().map(lower).collect();
        for (point, records) in navigation.points.iter().zip(all) {
            let Some(records) = records else { return Ok(None) };
            let records = records.map_err(|refusal| study.refused(&point.swept, &refusal))?;
            study.check_trials(records.iter().map(|records| records.width).sum(), "navigators")?;
            plan.of_point = records.len();
            plan.records.extend(records);
        }
        Ok(Some(plan))
    }

    fn lowered(&self, point: usize) -> Result<Lowered, Refusal> {
        Lowered::new(&self.navigation.points[point], self.navigation, self.study.seed, self.study.streams)
    }

    /// What makes the records of a gyro of a set of coefficients of a point.
    fn recipe(&self, place: usize) -> Result<Arc<dyn Recorded>, Refusal> {
        let (point, gyro) = (place / self.of_point, place % self.of_point);
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let lowered = match &*newest {
            Some((known, lowered)) if *known == point => Arc::clone(lowered),
            _ => Arc::new(self.lowered(point)?),
        };
        *newest = Some((point, Arc::clone(&lowered)));
        Ok(Arc::new(lowered.gyros[gyro].navigation.clone()))
    }

    /// Trials of each set of coefficients.
    fn of_set(&self) -> u64 {
        self.study.trials.div_ceil(self.navigation.draws)
    }

    fn wanted<T>(&self, then: impl FnOnce(Wanted) -> T) -> T {
        then(Wanted { trials: self.of_set(), points: &self.records, recipe: &|place| self.recipe(place) })
    }

    /// The row of a point.
    fn row(&self, point: usize, store: Option<&Store>) -> Result<Row<'a>, RunError> {
        let quantities = Quantity::of(self.navigation.solution);
        let of_point = &self.navigation.points[point];
        let Some(store) = store else {
            return Ok(Row { point: of_point, trials: 0, sizes: vec![], claim: None, representation: None });
        };
        let lowered = self.lowered(point)?;
        let errors = sampled(&lowered, store)?;
        let Closed { sizes, claimed, representation } = match self.closed[point].get() {
            Some(closed) => closed.clone(),
            None => {
                let closed = self.closed(point, &lowered)?;
                self.closed[point].get_or_init(|| closed).clone()
            }
        };
        let with_estimates = |(quantity, closed): (&Quantity, Sizes)| {
            let size =
                |errors: &[f64]| quantity.errors().iter().map(|error| errors[*error]).fold(0.0, libm::hypot);
            closed.with(errors.chunks_exact(lowered.errors.len()).map(size).collect())
        };
        let sizes: Vec<Sizes> = quantities.par_iter().zip(sizes).map(with_estimates).collect();
        let claim = |sigma| Claim::of(sigma, &sizes[0], &claimed, &errors);
        let claim = of_point.inputs.claimed().map(claim);
        let trials = (errors.len() / lowered.errors.len()) as u64;
        Ok(Row { point: of_point, trials, sizes, claim, representation })
    }

    fn closed(&self, point: usize, lowered: &Lowered) -> Result<Closed, Refusal> {
        let of_point = &self.navigation.points[point];
        let quantities = Quantity::of(self.navigation.solution);
        let size = |quantity: &Quantity| {
            let places = quantity.errors();
            let rounding = places.iter().map(|error| lowered.rounding(*error)).fold(0.0, libm::fmax);
            Sizes::closed(&lowered.distributions(places), rounding)
        };
        let sizes: Vec<Sizes> = quantities.par_iter().map(size).collect();
        // A filter keeps the heading, which is its only error.
        let claimed = of_point.inputs.claimed().map(|_| lowered.distributions(&[0])).unwrap_or_default();
        let physical = PhysicalTheory::new(of_point, self.navigation, self.study.seed);
        let of_quantity = |(quantity, sizes): (&Quantity, &Sizes)| {
            lowered.representation(quantity.errors(), sizes.closed_rms, &physical)
        };
        let found = quantities.iter().zip(&sizes).map(of_quantity).collect::<Result<Vec<_>, Refusal>>()?;
        let larger = |most: f64, one: f64| if one.abs() > most.abs() { one } else { most };
        Ok(Closed { sizes, claimed, representation: found.into_iter().flatten().reduce(larger) })
    }
}

/// The errors of all navigators that the store holds, one after the other: sums over the gyros of each.
fn sampled(lowered: &Lowered, store: &Store) -> Result<Vec<f64>, StoreError> {
    let width = lowered.errors.len();
    let mut all = Vec::new();
    for gyros in lowered.gyros.chunks(lowered.of_set) {
        let mut of_set: Option<Vec<f64>> = None;
        for gyro in gyros {
            let rows = store.rows(&gyro.address, width)?;
            let errors: Vec<f64> =
                rows.iter().flat_map(Rows::rows).flat_map(|sums| gyro.errors(sums)).collect();
            of_set = Some(match of_set {
                // A run that was cut short may have made fewer records of the last gyro.
                Some(sums) => sums.iter().zip(&errors).map(|(sum, error)| sum + error).collect(),
                None => errors,
            });
        }
        all.extend(of_set.unwrap_or_default());
    }
    Ok(all)
}

impl LoweredGyro {
    /// Its part of each error, ″, m/s or m, from the sums of a record as the kernel returns them.
    pub fn errors(&self, sums: &[u128]) -> impl Iterator<Item = f64> {
        sums.iter().zip(&self.units).map(|(&sum, unit)| self.navigation.signed(sum) as f64 * unit)
    }
}

impl sampling::Plan for Plan<'_> {
    fn run(
        &self,
        store: &mut Store,
        worker: &mut Worker,
        share: Share,
        progress: &dyn Progress,
    ) -> Result<Done, RunError> {
        let done = self.wanted(|wanted| wanted.sample(store, worker, share, progress))?;
        // A navigator has several gyros.
        let gyros = (self.of_point as u64 / self.navigation.draws).max(1);
        Ok(Done { trials: done.trials / gyros, ..done })
    }

    fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        self.wanted(|wanted| wanted.lacks(store, share))
    }

    fn tables(&self, store: Option<&Store>, _: &dyn Progress) -> Result<Tables, RunError> {
        let points = 0..self.navigation.points.len();
        let rows = points.map(|point| self.row(point, store)).collect::<Result<Vec<Row>, RunError>>()?;
        let columns = columns(self.navigation.solution, self.navigation.has_filter());
        let mut table = table(&self.study.sweeps, &columns, &rows, |row| &row.point.swept);
        let law = |law| rows.iter().map(|row| row.law(law)).collect();
        table.columns.extend(self.study.laws().into_iter().map(|drawn| drawn.about().with(law(drawn))));
        Ok(Tables::of_points(table))
    }

    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError> {
        let held = held_by_all(index, self.records.iter().map(|records| records.address))?;
        let asked = self.study.trials;
        Ok(held.map(|held| if held == self.of_set() { asked } else { held * self.navigation.draws }))
    }

    fn ids(&self) -> Vec<Id> {
        self.records.iter().map(|records| records.address.point).collect()
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        let names: Vec<&str> = self.navigation.uncertain.iter().map(|input| input.key.name).collect();
        let drawn = (!names.is_empty()).then(|| {
            format!(
                "the errors contain the uncertainty of {}: {} sets of values are drawn from their distributions, each for an \
                 equal part of the trials",
                sagnac_base::quantity::list::listed(&names),
                self.navigation.draws
            )
        });
        Ok(drawn.into_iter().collect())
    }

    fn all_trials(&self) -> u64 {
        u64::MAX
    }
}
