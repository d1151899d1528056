//! The work of a dispatch: trials of launches, divided among workgroups, and what their results are added to.

use std::ops::Range;
use std::sync::Arc;

use crate::device::Job;
use sagnac_kernel::launch::{Launch, MAX_STEPS};
use sagnac_kernel::moments::{BINS, GROUPS_PER_ROW, Moments, PARTIAL_WORDS};
use sagnac_kernel::record::SUM_WORDS;

/// Words of the work of one workgroup.
pub(crate) const JOB_WORDS: usize = 5;

/// Ranges of trials of launches with the same shape, which form one dispatch.
#[derive(Debug, Clone, Default)]
pub(crate) struct Part<'a> {
    /// The launches, which the shader calls points.
    pub(crate) launches: Vec<&'a Launch>,
    /// Their tables, each once.
    pub(crate) tables: Vec<&'a Arc<[u32]>>,
    /// Their ranges, in the order of the results.
    pub(crate) pieces: Vec<Piece>,
}

/// Most words of tables that points bring to a dispatch of others.
const MAX_TABLE_WORDS: usize = 1 << 22;

/// A range of trials; its tallies are added to place `to` of the results.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    /// Index of its launch in the part.
    point: usize,
    trials: Range<u64>,
    pub(crate) to: usize,
}

impl<'a> Part<'a> {
    /// Whether trials of `launch` may join this part.
    pub(crate) fn takes(&self, launch: &Launch) -> bool {
        let words: usize = self.tables.iter().map(|table| table.len()).sum();
        let has_room =
            self.start_of(launch.table()).is_some() || words + launch.table().len() <= MAX_TABLE_WORDS;
        self.launches.first().is_some_and(|own| **own.sampled() == **launch.sampled()) && has_room
    }

    /// Adds trials of a launch that [`takes`](Part::takes) accepts, or the first ones.
    pub(crate) fn push(&mut self, launch: &'a Launch, trials: Range<u64>, to: usize) {
        let point = self.launches.iter().rposition(|&own| std::ptr::eq(own, launch)).unwrap_or_else(|| {
            self.launches.push(launch);
            if self.start_of(launch.table()).is_none() {
                self.tables.push(launch.table());
            }
            self.launches.len() - 1
        });
        self.pieces.push(Piece { point, trials, to });
    }

    /// Word of all tables at which this one starts, if it is one of them.
    fn start_of(&self, table: &Arc<[u32]>) -> Option<usize> {
        let at = self.tables.iter().position(|own| Arc::ptr_eq(own, table))?;
        Some(self.tables[..at].iter().map(|table| table.len()).sum())
    }

    /// Trials of all pieces.
    pub(crate) fn trials(&self) -> u64 {
        self.pieces.iter().map(Piece::count).sum()
    }

    /// Steps of all pieces.
    #[cfg(feature = "gpu")]
    pub(crate) fn steps(&self) -> u64 {
        self.pieces.iter().map(|piece| piece.count() * self.launches[piece.point].steps()).sum()
    }

    /// Number of trials of a workgroup: as many as give the device `groups` workgroups.
    pub(crate) fn trials_of_group(&self, workgroup: u32, groups: u64) -> u64 {
        let longest = self.launches.iter().map(|launch| launch.steps()).max().unwrap_or(1);
        let rounds = self.trials() / (groups * u64::from(workgroup));
        rounds.clamp(1, (MAX_STEPS / longest).max(1)) * u64::from(workgroup)
    }

    /// The work of each workgroup in the words that the shader reads, in the order of the partial sums: the halves of the first trial,
    /// the number of trials, the launch, and the place of the results.
    pub(crate) fn jobs(&self, trials_of_group: u64) -> Vec<u32> {
        let mut words = Vec::new();
        for (slot, piece) in self.pieces.iter().enumerate() {
            for first in piece.trials.clone().step_by(trials_of_group as usize) {
                let count = trials_of_group.min(piece.trials.end - first) as u32;
                let job: [u32; JOB_WORDS] =
                    [first as u32, (first >> 32) as u32, count, piece.point as u32, slot as u32];
                words.extend(job);
            }
        }
        words
    }

    /// The parameters of its launches.
    pub(crate) fn parameters(&self) -> Vec<u32> {
        let of = |launch: &&Launch| launch.parameters(self.start_of(launch.table()).unwrap_or(0) as u32);
        self.launches.iter().flat_map(of).collect()
    }
}

/// Columns and rows of a dispatch of some workgroups.
pub(crate) fn grid(groups: u32) -> [u32; 2] {
    [groups.min(GROUPS_PER_ROW), groups.div_ceil(GROUPS_PER_ROW)]
}

impl Piece {
    fn count(&self) -> u64 {
        self.trials.end - self.trials.start
    }

    /// Number of workgroups that share its trials, with `of_group` trials each.
    fn groups(&self, of_group: u64) -> u64 {
        self.count().div_ceil(of_group)
    }
}

/// Alignment of each part's partial sums and histograms in the buffer, in bytes.
const ALIGNMENT: u64 = 256;

/// Division of a part among workgroups, with the offsets of its results in the buffer of a tile, in bytes.
pub(crate) struct Place {
    pub(crate) trials_of_group: u64,
    pub(crate) groups: u32,
    pub(crate) partials: u64,
    pub(crate) histograms: u64,
    pub(crate) end: u64,
}

impl Place {
    pub(crate) fn new(part: &Part, from: u64, histogram: bool, trials_of_group: u64) -> Place {
        let estimates = part.launches[0].sampled().estimates() as u64;
        let groups = part.pieces.iter().map(|piece| piece.groups(trials_of_group)).sum::<u64>();
        let histogram_bytes = if histogram { 4 * estimates * (BINS * part.pieces.len()) as u64 } else { 0 };
        let histograms = (from + 4 * estimates * PARTIAL_WORDS as u64 * groups).next_multiple_of(ALIGNMENT);
        let end = (histograms + histogram_bytes).next_multiple_of(ALIGNMENT);
        Place { trials_of_group, groups: groups as u32, partials: from, histograms, end }
    }
}

/// Adds the words of a tile to the results of its part.
pub(crate) fn add_results(part: &Part, place: &Place, words: &[u32], results: &mut [Vec<Moments>]) {
    let estimates = part.launches[0].sampled().estimates();
    let mut partials = words[place.partials as usize / 4..].chunks_exact(estimates * PARTIAL_WORDS);
    let mut histograms = words[place.histograms as usize / 4..].chunks_exact(BINS);
    for piece in &part.pieces {
        let tallies = &mut results[piece.to];
        for group in partials.by_ref().take(piece.groups(place.trials_of_group) as usize) {
            for (tally, sums) in tallies.iter_mut().zip(group.chunks_exact(PARTIAL_WORDS)) {
                add_partial(tally, sums);
            }
        }
        for tally in tallies.iter_mut() {
            tally.count += piece.count();
            // Without a histogram a tally has no bins.
            if !tally.bins.is_empty() {
                for (bin, &count) in tally.bins.iter_mut().zip(histograms.next().into_iter().flatten()) {
                    *bin += u64::from(count);
                }
            }
        }
    }
}

fn add_partial(tally: &mut Moments, sums: &[u32]) {
    let word96 = |at: usize| -> u128 { (0..3).map(|i| u128::from(sums[at + i]) << (32 * i)).sum() };
    tally.sum += (word96(0) << 32) as i128 >> 32;
    tally.square += word96(3);
    tally.least = tally.least.min(sums[6] as i32);
    tally.greatest = tally.greatest.max(sums[7] as i32);
}

/// Most pieces of a tile, which bounds the buffer of its histograms.
const MAX_PIECES: usize = 1024;

/// The remaining trials of some jobs, handed out tile by tile.
pub(crate) struct Tiler<'a> {
    jobs: &'a [Job<'a>],
    job: usize,
    done: u64,
}

impl<'a> Tiler<'a> {
    pub(crate) fn new(jobs: &'a [Job<'a>]) -> Tiler<'a> {
        Tiler { jobs, job: 0, done: 0 }
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

/// The sums of `lanes` records, record by record, from the words of a dispatch.
pub(crate) fn sums_of_records(words: &[u32], lanes: usize, values: usize) -> Vec<u128> {
    let sum = |lane: usize, place: usize| -> u128 {
        let word = |word: usize| u128::from(words[(SUM_WORDS * place + word) * lanes + lane]) << (32 * word);
        (0..SUM_WORDS).map(word).sum()
    };
    (0..lanes).flat_map(|lane| (0..values).map(move |place| sum(lane, place))).collect()
}
