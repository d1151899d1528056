//! Sample trajectories: the angle of the first runs just before and just after their switches.
//!
//! They are few and made on the processor, whatever the device, because the bits are the same.

use crate::kinds;
use crate::kinds::switched_run::columns::{Moment, trajectory_columns};
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::kinds::switched_run::run::Plan;
use crate::store::error::StoreError;
use crate::store::{Row, Store};
use crate::tally::{Block, missing};
use sagnac_base::table::Table;
use sagnac_kernel::rows::Rows;
use sagnac_kernel::switched_run::trajectory;

/// Most switches that a trajectory shows; of more of them every second, third, … is shown.
pub(crate) const MAX_SHOWN: u64 = 500;

/// Offset of the angles in the store, which holds non-negative numbers.
const OFFSET: i64 = 1 << 31;

/// Number of trajectories that the store lacks.
pub(crate) fn lacks(plan: &Plan, store: &Store) -> Result<u64, StoreError> {
    let wanted = plan.subject.trajectories.min(plan.study.trials);
    let (index, mut lacking) = (store.index()?, 0);
    for (.., filled) in plan.filled() {
        let gaps = missing(index.blocks(&filled.trajectory)?, 0..wanted);
        lacking += gaps.iter().map(|gap| gap.end - gap.start).sum::<u64>();
    }
    Ok(lacking)
}

/// Makes the trajectories that the store lacks.
pub(crate) fn keep(plan: &Plan, store: &mut Store) -> Result<(), StoreError> {
    let wanted = plan.subject.trajectories.min(plan.study.trials);
    let index = store.index()?;
    for (point, _, filled) in plan.filled() {
        let held = index.blocks(&filled.trajectory)?;
        let (launch, shape) = filled.trajectories();
        let mut rows = Vec::new();
        for trial in missing(held, 0..wanted).into_iter().flatten() {
            let angles = trajectory(&launch, shape, trial);
            let shown = shown(point);
            let values: Vec<u128> =
                places(&shown).map(|place| (i64::from(angles[place]) + OFFSET) as u128).collect();
            let tally = Rows { width: values.len(), values };
            rows.push(Row { address: filled.trajectory, block: Block { first: trial, log2: 0 }, tally });
        }
        if !rows.is_empty() {
            store.insert(&rows, None)?;
        }
    }
    Ok(())
}

/// The table of the requested trajectories in the store; without a store, a row for each point, filler and run.
pub(crate) fn table(plan: &Plan, store: Option<&Store>) -> Result<Table, StoreError> {
    let mut moments = Vec::new();
    for (point, filler, filled) in plan.filled() {
        let runs = 1..=plan.subject.trajectories;
        let start = |run, angle| Moment { point, filler, run, time_s: 0.0, angle };
        let Some(store) = store else {
            moments.extend(runs.map(|run| start(run, None)));
            continue;
        };
        let shown = shown(point);
        let width = places(&shown).count();
        let held = store.rows(&filled.trajectory, width)?;
        let rows = held.iter().flat_map(|rows| rows.values.chunks_exact(width));
        for (run, values) in runs.zip(rows) {
            let lsb = filled.trajectory_unit_arcsec();
            moments.push(start(run, Some(0.0)));
            moments.extend(places(&shown).zip(values).map(|(place, value)| {
                let interval = (place / 2 + 1) as f64 * point.schedule.interval_s;
                let angle = (*value as i64 - OFFSET) as f64 * lsb;
                let time_s = interval.min(point.schedule.duration_s);
                Moment { point, filler, run, time_s, angle: Some(angle) }
            }));
        }
    }
    let columns = trajectory_columns(!plan.subject.fillers().is_empty());
    Ok(kinds::plan::table(&plan.study.sweeps, &columns, &moments, |moment| &moment.point.swept))
}

/// A note that not every switch is in the table.
pub(crate) fn thinned(plan: &Plan) -> Option<String> {
    let most = plan.subject.points.iter().map(RunPoint::switches).max()?;
    (plan.subject.trajectories > 0 && most > MAX_SHOWN).then(|| {
        format!(
            "trajectories of runs with more than {MAX_SHOWN} switches show only some of them, evenly spaced"
        )
    })
}

/// The switches shown, and then the end, as numbers of intervals from 0.
fn shown(point: &RunPoint) -> Vec<u64> {
    let switches = point.switches();
    let stride = switches.div_ceil(MAX_SHOWN).max(1);
    (0..switches).step_by(stride as usize).chain([switches]).collect()
}

/// The indices of those switches and of the end among the angles of a run, which has two for each switch and one for
/// the end.
fn places(shown: &[u64]) -> impl Iterator<Item = usize> {
    let last = shown.last().copied().unwrap_or(0);
    shown.iter().flat_map(move |&k| {
        let first = 2 * k as usize;
        first..if k == last { first + 1 } else { first + 2 }
    })
}
