//! A device elsewhere, such as the GPU of a browser beside a page: it takes shaders with the words that they read, and gives the words
//! that they write.
//!
//! A page cannot wait for its GPU. So it runs the same batches twice: first with a [`Runner`] that notes the dispatches and answers
//! zeros, then, when the GPU has answered them, with one that gives these answers in their order.

use std::collections::HashSet;
use std::sync::Arc;

use crate::device::tile::{Part, Place, Tiler, add_results, grid, sums_of_records};
use crate::device::{Advance, GpuError, Job, Tallies};
use sagnac_kernel::curve::{RING_LANES, Recorded};
use sagnac_kernel::launch::{Launch, MAX_STEPS, Sampled};
use sagnac_kernel::map::Map;
use sagnac_kernel::moments::{BINS, Moments, PARTIAL_WORDS, Trials};
use sagnac_kernel::recipe::CHUNK;
use sagnac_kernel::record::SUM_WORDS;
use sagnac_kernel::shader::Variant;
use sagnac_kernel::width::Width;

/// 32-bit integers alone: browsers offer no others.
const VARIANT: Variant = Variant { int64: false, checked: false, workgroup: 64 };

/// Workgroups of a dispatch.
const GROUPS: u64 = 256;

/// Steps of the trials of a dispatch.
pub(crate) const STEPS: u64 = 1 << 24;

/// Records of a dispatch.
pub(crate) const RECORDS: u64 = 256;

/// Rounds of the loops of a dispatch of records, which must end before a browser stops it.
const ROUNDS: usize = 1 << 18;

/// Bytes of the largest buffer that every browser accepts.
const MAX_BYTES: usize = 128 << 20;

/// A dispatch: a shader with what it reads and writes, by the numbers of its bindings.
#[derive(Debug, Clone)]
pub struct Dispatch {
    /// WGSL.
    pub shader: String,
    /// Whether binding 0 is the table of normal numbers.
    pub has_normals: bool,
    /// Storage that is only read, with its words.
    pub inputs: Vec<(u32, Vec<u32>)>,
    /// Storage of zeros that is written and read again, with its number of words.
    pub scratch: Vec<(u32, usize)>,
    /// Storage of zeros whose words are the results, one after the other.
    pub outputs: Vec<(u32, usize)>,
    /// The passes of the dispatch, which run in order over the same storage.
    pub passes: Vec<Pass>,
}

/// A pass over the storage of a dispatch.
#[derive(Debug, Clone)]
pub struct Pass {
    /// The uniform words of binding 1; empty where there are none.
    pub uniform: Vec<u32>,
    /// Columns and rows of workgroups.
    pub grid: [u32; 2],
}

impl Dispatch {
    /// Number of words of the results.
    pub fn words(&self) -> usize {
        self.outputs.iter().map(|(_, words)| words).sum()
    }
}

/// A runner of dispatches, such as the GPU of a browser.
pub trait Runner: Send {
    /// Name of the device.
    fn name(&self) -> String;

    /// The words that a dispatch writes, of all its outputs one after the other; `None` where they are not known yet.
    ///
    /// # Errors
    /// The device fails; the sentence says how.
    fn run(&mut self, dispatch: Dispatch) -> Result<Option<Vec<u32>>, String>;
}

/// A device behind a [`Runner`].
pub struct Remote {
    runner: Box<dyn Runner>,
    /// Estimates, with and without histogram, and shaders of records whose first answer was compared with that of the processor.
    tested: HashSet<(Arc<dyn Sampled>, bool)>,
    tested_records: HashSet<String>,
}

impl Remote {
    /// The device of a runner.
    pub fn new(runner: Box<dyn Runner>) -> Remote {
        Remote { runner, tested: HashSet::new(), tested_records: HashSet::new() }
    }

    pub(crate) fn name(&self) -> String {
        self.runner.name()
    }

    fn run(&mut self, dispatch: Dispatch) -> Result<Option<Vec<u32>>, GpuError> {
        let words = dispatch.words();
        match self.runner.run(dispatch).map_err(GpuError::Refused)? {
            Some(found) if found.len() != words => {
                Err(GpuError::Refused(format!("it gave {} words instead of {words}", found.len())))
            }
            found => Ok(found),
        }
    }

    /// The results of a building block; zeros where they are not known yet.
    pub(crate) fn map(&mut self, map: &Map, items: &[u32]) -> Result<Vec<u32>, GpuError> {
        let count = items.len() / map.inputs;
        let (shader, has_normals) = map.shader(VARIANT);
        let words = count * map.outputs;
        let passes = vec![Pass { uniform: vec![], grid: [(count as u32).div_ceil(VARIANT.workgroup), 1] }];
        let (inputs, outputs) = (vec![(1, items.to_vec())], vec![(2, words)]);
        let found = self.run(Dispatch { shader, has_normals, inputs, scratch: vec![], outputs, passes })?;
        Ok(found.unwrap_or_else(|| vec![0; words]))
    }

    pub(crate) fn tally(
        &mut self,
        jobs: &[Job],
        histogram: bool,
        progress: Advance,
    ) -> Result<Tallies, GpuError> {
        let empty = |launch: &Launch| vec![Moments::empty(histogram); launch.sampled().estimates()];
        let mut results: Tallies = jobs.iter().map(|job| empty(job.launch)).collect();
        let mut rest = Tiler::new(jobs);
        loop {
            let parts = rest.take(STEPS);
            if parts.is_empty() {
                return Ok(results);
            }
            for part in &parts {
                self.test(part.launches[0], histogram)?;
                self.tally_part(part, histogram, &mut results)?;
                progress(part.trials());
            }
        }
    }

    /// Adds the tallies of a part to the results; `false` where they are not known yet.
    fn tally_part(
        &mut self,
        part: &Part,
        histogram: bool,
        results: &mut [Vec<Moments>],
    ) -> Result<bool, GpuError> {
        let place = Place::new(part, 0, histogram, part.trials_of_group(VARIANT.workgroup, GROUPS));
        let launch = part.launches[0];
        let estimates = launch.sampled().estimates();
        let (shader, has_normals) = launch.shader(histogram, VARIANT);
        let mut inputs = vec![(1, part.parameters()), (2, part.jobs(place.trials_of_group))];
        if launch.sampled().has_table() {
            inputs.push((5, part.tables.iter().flat_map(|table| table.iter().copied()).collect()));
        }
        let partials = estimates * PARTIAL_WORDS * place.groups as usize;
        let mut outputs = vec![(3, partials)];
        if histogram {
            outputs.push((4, estimates * BINS * part.pieces.len()));
        }
        let passes = vec![Pass { uniform: vec![], grid: grid(place.groups) }];
        let dispatch = Dispatch { shader, has_normals, inputs, scratch: vec![], outputs, passes };
        let Some(found) = self.run(dispatch)? else { return Ok(false) };
        let mut words = vec![0; place.end as usize / 4];
        let (sums, bins) = found.split_at(partials);
        words[..partials].copy_from_slice(sums);
        let from = place.histograms as usize / 4;
        words[from..from + bins.len()].copy_from_slice(bins);
        add_results(part, &place, &words, results);
        Ok(true)
    }

    /// Compares the first answer of a shader with that of the processor.
    fn test(&mut self, launch: &Launch, histogram: bool) -> Result<(), GpuError> {
        if !self.tested.insert((Arc::clone(launch.sampled()), histogram)) {
            return Ok(());
        }
        let count = (MAX_STEPS / launch.steps()).clamp(1, VARIANT.workgroup.into());
        let mut part = Part::default();
        part.push(launch, 0..count, 0);
        let mut found = [vec![Moments::empty(histogram); launch.sampled().estimates()]];
        let is_known = self.tally_part(&part, histogram, &mut found)?;
        let expected = || launch.tally(Width::widest(), Trials { first: 0, count, histogram });
        if is_known && found[0] != expected() { Err(GpuError::WrongBits) } else { Ok(()) }
    }

    pub(crate) fn sums(
        &mut self,
        recipe: &dyn Recorded,
        first: u64,
        count: usize,
        progress: Advance,
    ) -> Result<Vec<u128>, GpuError> {
        let bytes = 4 * recipe.curve().depth();
        let table = 4 * recipe.table().len();
        if let Some(most) = [bytes, table].into_iter().max().filter(|most| *most > MAX_BYTES) {
            return Err(GpuError::TooLong { bytes: most as u64, most: MAX_BYTES as u64 });
        }
        if self.tested_records.insert(recipe.shader(VARIANT).0) {
            // The shader does not depend on the length of the records.
            let short = recipe.shortened(2 * CHUNK as u32);
            if self.batch(&*short, 0, 2)?.is_some_and(|found| found != short.sums(Width::widest(), 0, 2)) {
                return Err(GpuError::WrongBits);
            }
        }
        let most = (MAX_BYTES / bytes.max(1)).clamp(1, RECORDS as usize);
        // Whole rows of the rings.
        let most = most - if most > RING_LANES { most % RING_LANES } else { 0 };
        let mut sums = Vec::with_capacity(count * recipe.values());
        let mut done = 0;
        while done < count {
            let at = first + done as u64;
            // The record numbers of a batch share one upper half.
            let to_half = (1 << 32) - (at & u64::from(u32::MAX));
            let lanes = (most.min(count - done) as u64).min(to_half) as usize;
            let found = self.batch(recipe, at, lanes)?;
            sums.extend(found.unwrap_or_else(|| vec![0; lanes * recipe.values()]));
            progress(lanes as u64);
            done += lanes;
        }
        Ok(sums)
    }

    /// The sums of `lanes` records, whose numbers share one upper half; `None` where they are not known yet.
    fn batch(
        &mut self,
        recipe: &dyn Recorded,
        first: u64,
        lanes: usize,
    ) -> Result<Option<Vec<u128>>, GpuError> {
        let (shader, has_normals) = recipe.shader(VARIANT);
        let curve = recipe.curve();
        let mut scratch = vec![(4, recipe.state_words() * lanes)];
        if curve.depth() > 0 {
            scratch.push((2, curve.ring_words(lanes)));
        }
        let inputs = if recipe.table().is_empty() { vec![] } else { vec![(5, recipe.table().to_vec())] };
        let chunks = curve.chunks();
        let of_pass = (ROUNDS / recipe.rounds().max(1)).max(1);
        let pass = |from: u32| {
            let to = chunks.min(from + of_pass as u32);
            let grid = [(lanes as u32).div_ceil(VARIANT.workgroup), 1];
            Pass { uniform: recipe.parameters(first, lanes as u32, [from, to]), grid }
        };
        let passes = (0..chunks).step_by(of_pass).map(pass).collect();
        let outputs = vec![(3, SUM_WORDS * recipe.values() * lanes)];
        let found = self.run(Dispatch { shader, has_normals, inputs, scratch, outputs, passes })?;
        Ok(found.map(|words| sums_of_records(&words, lanes, recipe.values())))
    }
}
