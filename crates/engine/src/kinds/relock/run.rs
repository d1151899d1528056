//! Running a relock study: launches for what the store lacks, and the table of what it holds.

use crate::kinds::plan::{Lacking, Launched, PointsPlan, Tabulated, table};
use crate::kinds::relock::RelockStudy;
use crate::kinds::relock::columns::{Row, columns};
use crate::kinds::relock::inputs::{Compensation, Relock};
use crate::kinds::relock::lower::{LoweredRelock, RelockEstimate};
use crate::sampling::batches::{Work, estimates};
use crate::sampling::{Found, RunError, Tables};
use crate::store::error::StoreError;
use crate::store::{Address, Store};
use crate::tally::Id;
use sagnac_base::quantity::number::significant;
use sagnac_kernel::moments::MAX_ESTIMATES;

impl Launched for LoweredRelock {
    fn id(&self) -> Id {
        self.id
    }

    fn addresses(&self) -> Vec<Address> {
        self.estimates.iter().map(|estimate| estimate.address).collect()
    }

    fn launches(&self) -> usize {
        Compensation::ALL.into_iter().flat_map(|compensation| self.launched(compensation)).count()
    }

    fn work(&self, lacking: Lacking) -> Result<Vec<Work<'_>>, StoreError> {
        let work = |estimates: Vec<&RelockEstimate>| {
            let launch = self.launch(&estimates);
            let addresses: Vec<Address> = estimates.iter().map(|estimate| estimate.address).collect();
            let steps = launch.steps();
            let blocks = lacking(&addresses, steps)?;
            Ok(Work::new(steps, move || Ok((launch.clone(), addresses.clone())), blocks))
        };
        Compensation::ALL.into_iter().flat_map(|compensation| self.launched(compensation)).map(work).collect()
    }
}

impl LoweredRelock {
    /// The estimates of each launch of a compensation, as many as a launch can have.
    pub(crate) fn launched(&self, compensation: Compensation) -> Vec<Vec<&RelockEstimate>> {
        let of = self.estimates.iter().filter(|estimate| estimate.compensation == compensation);
        of.collect::<Vec<_>>().chunks(MAX_ESTIMATES).map(<[_]>::to_vec).collect()
    }
}

impl Tabulated for PointsPlan<'_, RelockStudy, LoweredRelock> {
    /// The table has a column for each law that a chart draws.
    fn tables(&self, store: Option<&Store>) -> Result<Tables, RunError> {
        let mut rows = Vec::new();
        for (point, lowered) in self.subject.points.iter().zip(&self.points) {
            let unit_arcsec = lowered.fixed.lsb_arcsec;
            let row = |estimate| Row { point, estimate, unit_arcsec, found: Found::default() };
            rows.extend(lowered.estimates.iter().map(row));
        }
        let found = estimates(store, &rows, |Row { estimate, unit_arcsec, .. }| {
            (estimate.address, estimate.bin_base, *unit_arcsec)
        })?;
        rows.iter_mut().zip(found).for_each(|(row, found)| row.found = found);
        let mut table = table(&self.study.sweeps, &columns(), &rows, |row| &row.point.swept);
        let law = || rows.iter().map(|row| row.published().into()).collect();
        table.columns.extend(self.study.laws().into_iter().map(|drawn| drawn.about().with(law())));
        Ok(Tables::of_points(table))
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        let relocks = self.subject.points.iter().map(|point| (&point.inputs.relock, point.inputs.tick_s));
        Ok(late(relocks).into_iter().collect())
    }
}

/// A note that ticks after the last one followed would still count, for some relocks with their ticks in s.
pub(crate) fn late<'a>(relocks: impl Iterator<Item = (&'a Relock, f64)>) -> Option<String> {
    let slow = |(relock, tick_s): &(&Relock, f64)| relock.loop_s / tick_s;
    let (relock, tick_s) = relocks.max_by(|a, b| slow(a).total_cmp(&slow(b)))?;
    let (late, ticks) = (relock.late(tick_s), relock.ticks);
    let (percent, arcsec) = (libm::round(100.0 * late), significant(late * relock.whole_angle(tick_s), 2));
    (late >= LATE).then(|| {
        format!(
            "up to {percent} % of the apparent angle, {arcsec}″ per switch, comes after tick {ticks}: it is in \
             none of the errors and adds to them, unless more ticks are followed (relock.ticks)"
        )
    })
}

/// Fraction of the angle after the last tick from which on a note is given.
const LATE: f64 = 0.01;
