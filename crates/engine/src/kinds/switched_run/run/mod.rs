//! Running a study of whole runs: missing trials are sampled, and the first runs are kept as trajectories.

pub(crate) mod trajectories;

use crate::drift::End;
use crate::kinds::plan::{Lacking, Launched, PointsPlan, Tabulated, table};
use crate::kinds::switched_run::SwitchedRun;
use crate::kinds::switched_run::columns::{Row, columns};
use crate::kinds::switched_run::lower::{FilledRun, LoweredRun};
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::sampling::batches::{Work, estimates};
use crate::sampling::{Found, RunError, Tables};
use crate::store::error::StoreError;
use crate::store::{Address, Store};
use crate::tally::{Id, Share};
use sagnac_kernel::moments::MAX_ESTIMATES;

/// The plan of a study of whole runs.
pub(crate) type Plan<'a> = PointsPlan<'a, SwitchedRun, LoweredRun>;

impl Launched for LoweredRun {
    fn id(&self) -> Id {
        self.id
    }

    fn addresses(&self) -> Vec<Address> {
        let estimates = self.fillers.iter().flat_map(|filled| &filled.estimates);
        estimates.map(|estimate| estimate.address).collect()
    }

    fn launches(&self) -> usize {
        self.fillers.iter().map(|filled| filled.estimates.len().div_ceil(MAX_ESTIMATES)).sum()
    }

    fn work(&self, lacking: Lacking) -> Result<Vec<Work<'_>>, StoreError> {
        let mut all = Vec::new();
        for filled in &self.fillers {
            for (launch, places) in filled.launches() {
                let addresses: Vec<_> = places.iter().map(|&place| filled.estimates[place].address).collect();
                let steps = launch.steps();
                let blocks = lacking(&addresses, steps)?;
                all.push(Work::new(steps, move || Ok((launch.clone(), addresses.clone())), blocks));
            }
        }
        Ok(all)
    }
}

impl Plan<'_> {
    /// A note that some runs of a sweep over the interval end exactly with an interval that no other cancels.
    fn uneven(&self) -> Option<String> {
        let is_even = |point: &&RunPoint| {
            let pairs = 0.5 * point.schedule.duration_s / point.schedule.interval_s;
            point.schedule.end != End::Exact || (pairs - libm::round(pairs)).abs() <= 1e-9 * pairs
        };
        let points = &self.subject.points;
        let uneven = points.len() - points.iter().filter(is_even).count();
        let swept = self.study.sweeps.iter().any(|sweep| sweep.key.name == "switching.interval");
        (swept && uneven > 0).then(|| {
            format!(
                "{uneven} of {} points have an odd or fractional number of intervals: nothing cancels the magnetic drift of the last, which \
                 can count for more than the interval; run.end = \"any\" averages over the end",
                points.len()
            )
        })
    }

    /// The runs of every point and filler, with the name of the filler, in the order of the tables.
    fn filled(&self) -> impl Iterator<Item = (&RunPoint, Option<&str>, &FilledRun)> {
        let points = self.subject.points.iter().zip(&self.points);
        points.flat_map(|(point, lowered)| {
            let names = self.subject.fillers().iter().map(|filler| Some(filler.name.as_str()));
            let fillers = names.chain(std::iter::repeat(None)).zip(&lowered.fillers);
            fillers.map(move |(filler, filled)| (point, filler, filled))
        })
    }
}

impl Tabulated for Plan<'_> {
    fn tables(&self, store: Option<&Store>) -> Result<Tables, RunError> {
        let keeps = self.subject.trajectories > 0;
        let trajectories = keeps.then(|| trajectories::table(self, store)).transpose()?;
        let mut rows = Vec::new();
        for (point, filler, filled) in self.filled() {
            let row = |estimate| Row { point, filler, filled, estimate, found: Found::default() };
            rows.extend(filled.estimates.iter().map(row));
        }
        let found = estimates(store, &rows, |Row { estimate, .. }| {
            (estimate.address, estimate.bin_base, estimate.unit_arcsec)
        })?;
        rows.iter_mut().zip(found).for_each(|(row, found)| row.found = found);
        let columns = columns(!self.subject.fillers().is_empty());
        let points = table(&self.study.sweeps, &columns, &rows, |row| &row.point.swept);
        Ok(Tables { trajectories, ..Tables::of_points(points) })
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        Ok(late(self.subject).into_iter().chain(trajectories::thinned(self)).chain(self.uneven()).collect())
    }

    fn keep(&self, store: &mut Store, share: Share) -> Result<(), RunError> {
        if makes_trajectories(share) {
            trajectories::keep(self, store)?;
        }
        Ok(())
    }

    fn lacks_kept(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        if makes_trajectories(share) { trajectories::lacks(self, store) } else { Ok(0) }
    }
}

/// Whether a share makes the trajectories. They are few, so the first share makes them all.
fn makes_trajectories(share: Share) -> bool {
    share.number() == 1
}

/// A note that ticks of the relock after the last one followed would still count.
pub fn late(runs: &SwitchedRun) -> Option<String> {
    let relocks = runs.points.iter().filter_map(|point| {
        let (relocking, fill) = point.relock.as_ref().zip(point.fill.as_ref())?;
        Some((&relocking.relock, fill.inputs.tick_s))
    });
    crate::kinds::relock::run::late(relocks)
}
