//! Division of jobs into tiles.

use crate::device::Job;
use crate::device::gpu::tile::Part;

/// Most pieces of a tile, which bounds the buffer of its histograms.
const MAX_PIECES: usize = 1024;

/// The remaining trials of some jobs, handed out tile by tile.
pub(crate) struct Rest<'a> {
    jobs: &'a [Job<'a>],
    job: usize,
    done: u64,
}

impl<'a> Rest<'a> {
    pub(crate) fn of(jobs: &'a [Job<'a>]) -> Rest<'a> {
        Rest { jobs, job: 0, done: 0 }
    }

    /// The next parts, of `steps` steps together or as many as are left, but at least one trial.
    pub(crate) fn take(&mut self, steps: u64) -> Vec<Part<'a>> {
        let mut parts: Vec<Part<'a>> = Vec::new();
        let (mut room, mut pieces) = (steps, 0);
        while room > 0 && pieces < MAX_PIECES && self.job < self.jobs.len() {
            let Job { launch, block } = self.jobs[self.job];
            let first = block.first + self.done;
            // The trial numbers of a piece share one upper half, so it ends where the lower half wraps; a bin holds no
            // more than half a word's worth of them.
            let to_half = ((1 << 32) - (first & u64::from(u32::MAX))).min(1 << 31);
            let steps = launch.steps();
            let count = (room / steps).max(1).min(block.trials() - self.done).min(to_half);
            let at = parts.iter().rposition(|part| part.takes(launch)).unwrap_or_else(|| {
                parts.push(Part::default());
                parts.len() - 1
            });
            parts[at].push(launch, first..first + count, self.job);
            pieces += 1;
            room = room.saturating_sub(count * steps);
            self.done += count;
            if self.done == block.trials() {
                (self.job, self.done) = (self.job + 1, 0);
            }
        }
        parts
    }
}
