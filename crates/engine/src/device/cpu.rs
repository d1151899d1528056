//! The processor: kernels in as many lanes as it offers, on all its cores.

use core::ops::Range;

use rayon::prelude::*;

use crate::device::{Advance, Job, Tallies};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::moments::{Moments, Trials};
use sagnac_kernel::width::Width;

/// Steps that a thread takes at a time, which last some milliseconds.
const PIECE_STEPS: u64 = 1 << 16;

/// The cores of this machine, or some of them.
#[derive(Debug)]
pub struct Cpu {
    width: Width,
    /// Absent in WebAssembly, which has one thread.
    pool: Option<rayon::ThreadPool>,
}

impl Cpu {
    /// A processor that runs kernels in lanes of `width` on `threads` threads; 0 means one thread for each core.
    ///
    /// # Errors
    /// The system provides no threads.
    pub fn new(width: Width, threads: usize) -> Result<Cpu, rayon::ThreadPoolBuildError> {
        let pool = match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
            Err(_) if cfg!(target_family = "wasm") => None,
            built => Some(built?),
        };
        Ok(Cpu { width, pool })
    }

    /// The lanes of its kernels.
    pub fn width(&self) -> Width {
        self.width
    }

    /// Number of records made in parallel: one for each lane of each thread.
    pub fn records_at_once(&self) -> u64 {
        (self.width.lanes() * self.threads()) as u64
    }

    fn threads(&self) -> usize {
        self.pool.as_ref().map_or(1, rayon::ThreadPool::current_num_threads)
    }

    fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Name with lanes and threads.
    pub fn name(&self) -> String {
        format!("CPU ({}, {} threads)", self.width.name(), self.threads())
    }

    /// Tallies of each job, in order. `progress` receives numbers of trials as they complete.
    pub fn tally(&self, jobs: &[Job], histogram: bool, progress: Advance) -> Tallies {
        self.install(|| jobs.par_iter().map(|job| self.tally_job(job, histogram, progress)).collect())
    }

    /// Sums of the squared differences of some records: record by record, and within a record by the places of the
    /// curve. `progress` receives numbers of records as they complete.
    pub fn sums(&self, recipe: &dyn Recorded, first: u64, count: usize, progress: Advance) -> Vec<u128> {
        let lanes = recipe.lanes(self.width) as u64;
        let end = first + count as u64;
        // The record numbers of a group share one upper half.
        let half = ((first | u64::from(u32::MAX)) + 1).min(end);
        let starts = |range: Range<u64>| range.step_by(lanes as usize);
        let groups: Vec<u64> = starts(first..half).chain(starts(half..end)).collect();
        let group = |&at: &u64| {
            let count = lanes.min(if at < half { half } else { end } - at);
            let sums = recipe.sums(self.width, at, count as usize);
            progress(count);
            sums
        };
        self.install(|| groups.par_iter().flat_map_iter(group).collect())
    }

    fn tally_job(&self, job: &Job, histogram: bool, progress: Advance) -> Vec<Moments> {
        let Job { launch, block } = job;
        let empty = || vec![Moments::empty(histogram); launch.sampled().estimates()];
        // Pieces of an aligned block never straddle a multiple of 2^32, as the kernel requires.
        let most = (PIECE_STEPS / launch.steps().next_power_of_two()).max(64);
        (0..block.trials().div_ceil(most))
            .into_par_iter()
            .map(|piece| {
                let first = block.first + piece * most;
                let count = most.min(block.end() - first);
                let tallies = launch.tally(self.width, Trials { first, count, histogram });
                progress(count);
                tallies
            })
            .reduce(empty, |mut left, right| {
                for (tally, other) in left.iter_mut().zip(&right) {
                    tally.merge(other);
                }
                left
            })
    }
}
