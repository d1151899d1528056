//! Sampling of the runs of one candidate, in parts.

use crate::analysis::jackknife::PARTS;
use sagnac_base::progress::Progress;
use sagnac_engine::device::{GpuError, Job};
use sagnac_engine::kinds::switched_run::lower::FilledRun;
use sagnac_engine::sampling::Worker;
use sagnac_engine::tally::Block;
use sagnac_kernel::moments::Moments;

/// The number of trials, at least `asked`, for which all parts have the same power of two.
pub(crate) fn trials(asked: u64) -> u64 {
    asked.div_ceil(PARTS).max(32).next_power_of_two() * PARTS
}

/// The tallies of the angle at the end and of the largest angle, for each part.
pub(crate) fn parts(
    filled: &FilledRun,
    switches: u64,
    trials: u64,
    worker: &mut Worker,
    progress: &dyn Progress,
) -> Result<Vec<[Moments; 2]>, GpuError> {
    let of_part = trials / PARTS;
    let log2 = of_part.ilog2();
    let launches = filled.launches();
    let Some((launch, _)) = launches.first() else { return Ok(vec![]) };
    let block = |part: u64| Block { first: part * of_part, log2 };
    let jobs: Vec<Job> = (0..PARTS).map(|part| Job { launch, block: block(part) }).collect();
    let results = worker.tally(&jobs, &|trials| progress.advance(trials * switches))?;
    let of_part = |tallies: Vec<Moments>| {
        let mut tallies = tallies.into_iter();
        [0, 1].map(|_| tallies.next().unwrap_or_else(|| Moments::empty(true)))
    };
    Ok(results.into_iter().map(of_part).collect())
}
