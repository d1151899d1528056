//! Running a gap-fill study: trials that the store lacks are sampled batch by batch.

pub(crate) mod rows;
pub(crate) mod stop;

use std::time::Instant;

use crate::progress::Progress;
use crate::sampling::batches::{Work, held_by_all, lacking, sample};
use crate::sampling::plan;
use crate::sampling::plan::{Done, RunError};
use crate::sampling::tables::Tables;
use crate::sampling::worker::Worker;
use rayon::prelude::*;

use crate::filler::keys::Error;
use crate::filler::{Filler, Method};
use crate::kinds::gap_fill::GapFill;
use crate::kinds::gap_fill::lower::Lowered;
use crate::kinds::gap_fill::point::Point;
use crate::motion::Frequency;
use crate::source::diagnose::StudyError;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::store::index::Index;
use crate::study::Study;
use crate::tally::block::{Block, base_log2, row_log2};
use crate::tally::id::Id;
use crate::tally::share::Share;

/// A study whose points are all proven to fit.
#[derive(Debug)]
pub(crate) struct Plan<'a> {
    study: &'a Study,
    gap_fill: &'a GapFill,
    points: Vec<Lowered>,
}

/// Most trials of a replayed record, because the lower half of a trial's number determines its place.
const MOST_REPLAYED: u64 = 1 << 32;

/// log2 of the number of trials after which the stop rule first decides.
const FEWEST_LOG2: u32 = 10;

impl<'a> Plan<'a> {
    /// Lowers every point.
    ///
    /// # Errors
    /// A point cannot be represented; the error points at the key to change.
    pub(crate) fn new(study: &'a Study, gap_fill: &'a GapFill) -> Result<Plan<'a>, StudyError> {
        let lower = |point: &Point| {
            Lowered::new(point, &gap_fill.fillers, &gap_fill.errors, study.seed, study.streams)
                .map_err(|refusal| study.refused(&point.swept, &refusal))
        };
        // The first error in the order of the points is reported, whichever thread found it.
        let points: Vec<Result<Lowered, StudyError>> = gap_fill.points.par_iter().map(lower).collect();
        let points = points.into_iter().collect::<Result<_, _>>()?;
        let plan = Plan { study, gap_fill, points };
        if plan.replays() && study.trials > MOST_REPLAYED {
            let message = format!("{} trials of a record that is replayed over every place", study.trials);
            let help = format!("accepted: up to {MOST_REPLAYED} trials, or position = \"random\"");
            return Err(study.error_at(study.place_of("motion.profile"), message, help));
        }
        Ok(plan)
    }

    /// Whether the stop rule applies; it does not apply to a share.
    pub(crate) fn decides(&self, share: Share) -> bool {
        self.gap_fill.precision.is_some() && share.is_whole()
    }

    /// The number of trials of each point if no precision stops it.
    pub(crate) fn most_trials(&self) -> Vec<u64> {
        self.points.iter().map(|point| point.trials(self.study.trials)).collect()
    }

    /// The number of trials of each point after which the stop rule first decides; all where there is no rule.
    fn first_wanted(&self, share: Share) -> Vec<u64> {
        let mut wanted = self.most_trials();
        if self.decides(share) {
            // Before that many trials, a standard error is too inaccurate to decide on.
            wanted.iter_mut().for_each(|most| *most = (*most).min(1 << base_log2(*most).max(FEWEST_LOG2)));
        }
        wanted
    }

    /// Total trials of all launches of a share where each point has the trials of `trials`; those of a point with many
    /// fillers count more than once.
    fn launched_trials(&self, trials: &[u64], share: Share) -> u64 {
        let points = self.points.iter().zip(trials).enumerate();
        let of_point = |(turn, (point, &trials)): (usize, (&Lowered, &u64))| {
            let launches = launches(point).len() as u64;
            let trials = share.trials(trials, turn);
            launches * (trials.end - trials.start)
        };
        points.map(of_point).sum()
    }

    /// A note that fillers have different weights at each point, which firmware cannot have.
    fn designed_anew(&self) -> Option<String> {
        let is_free = |filler: &&Filler| filler.method == Method::MinimumVariance(None);
        let free: Vec<&str> =
            self.gap_fill.fillers.iter().filter(is_free).map(|filler| filler.name.as_str()).collect();
        let design = |key: &str| key.starts_with("motion.") || key.starts_with("gyro.");
        let sweeps = &self.study.sweeps;
        let varies = sweeps.iter().any(|sweep| sweep.values.len() > 1 && design(sweep.key.name));
        let tones = &self.gap_fill.inputs.motion.tones;
        let is_tuned = tones.iter().any(|tone| matches!(tone.frequency, Frequency::Fixed(_)));
        let how = match (varies, is_tuned) {
            (true, _) => {
                "separately for the motion and noise of each point, which is the best possible; firmware has one set of weights"
            }
            (false, true) => {
                "for exactly this frequency, which firmware does not know: it has one set of weights"
            }
            (false, false) => return None,
        };
        (!free.is_empty())
            .then(|| format!("{} without a band: designed {how}, designed for a band", free.join(", ")))
    }

    /// Notes on requested errors that a filler does not have, each a sentence.
    fn absent(&self) -> Vec<String> {
        let mut sentences = Vec::new();
        for (index, filler) in self.gap_fill.fillers.iter().enumerate() {
            let has = |error: Error| {
                let all =
                    |point: &Lowered| point.fillers[index].iter().any(|estimate| estimate.error == error);
                self.points.iter().all(all)
            };
            let lacks: Vec<&str> =
                self.gap_fill.errors.iter().filter(|error| !has(**error)).map(|error| error.name()).collect();
            if !lacks.is_empty() {
                let name = &filler.name;
                sentences
                    .push(format!("the weights of `{name}` do not give its errors: {}", lacks.join(", ")));
            }
        }
        sentences
    }

    /// The work that the store lacks of a share of the wanted trials.
    fn missing(&self, store: &Store, wanted: &[u64], share: Share) -> Result<Vec<Work>, StoreError> {
        let index = store.index()?;
        let mut all = Vec::new();
        for (turn, (point, &trials)) in self.points.iter().zip(wanted).enumerate() {
            let trials = share.trials(trials, turn);
            let most = point.trials(self.study.trials);
            // The stop rule evaluates only the first trials, and so needs rows that end with them.
            let log2 = if self.decides(share) { base_log2(most) } else { row_log2(most, 1) };
            let mut lacks = Vec::new();
            for estimates in &point.fillers {
                let addresses = estimates.iter().map(|estimate| &estimate.address);
                lacks.push(lacking(&index, addresses, trials.clone(), log2)?);
            }
            for (blocks, fillers) in grouped(point, lacks).into_iter().filter(|group| !group.0.is_empty()) {
                let addresses = point.launched(&fillers).map(|estimate| estimate.address).collect();
                all.push(Work { launch: point.launch(&fillers), addresses, blocks });
            }
        }
        Ok(all)
    }
}

impl plan::Plan for Plan<'_> {
    /// With a precision, a point stops after 1, 2, 4, … base blocks of trials, and at least 1024 trials, when all
    /// errors of all its fillers have the requested precision. The rule depends on the study only. The fillers of a
    /// point keep the same trials, so that they are compared on the same draws. A share does not know the others and
    /// takes all its trials.
    fn run(
        &self,
        store: &mut Store,
        worker: &mut Worker,
        share: Share,
        progress: &dyn Progress,
    ) -> Result<Done, RunError> {
        let mut wanted = self.first_wanted(share);
        let (started, mut trials) = (Instant::now(), 0);
        let stopped = loop {
            let missing = self.missing(store, &wanted, share)?;
            let left: u64 = missing.iter().map(Work::trials).sum();
            let all = self.launched_trials(&wanted, share).max(left);
            progress.start("trials", all - left, all);
            let sampled = sample(&missing, trials, store, worker, progress, started)?;
            trials += sampled;
            if sampled < left || !self.raise(&mut wanted, store, share)? {
                break sampled < left;
            }
        };
        Ok(Done { trials, seconds: started.elapsed().as_secs_f64(), stopped, degraded: vec![] })
    }

    fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        let mut wanted = self.first_wanted(share);
        loop {
            let work = self.missing(store, &wanted, share)?;
            let left = work.iter().map(Work::trials).sum();
            if left > 0 || !self.raise(&mut wanted, store, share)? {
                return Ok(left);
            }
        }
    }

    fn notes(&self, store: &Store) -> Result<Vec<String>, StoreError> {
        let mut notes = self.absent();
        notes.extend(self.designed_anew());
        let (imprecise, fillers) = self.imprecise(store)?;
        if imprecise > 0 {
            let trials = self.study.trials;
            notes.push(format!(
                "{imprecise} of {fillers} fillers at points have not reached the requested precision after {trials} trials"
            ));
        }
        Ok(notes)
    }

    fn ids(&self) -> Vec<Id> {
        self.points.iter().map(|point| point.id).collect()
    }

    fn tables(&self, store: Option<&Store>, _: &dyn Progress) -> Result<Tables, RunError> {
        Ok(Tables::of_points(match store {
            Some(store) => self.table(store)?,
            None => self.blank_table(),
        }))
    }

    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError> {
        // With a precision, `trials` is the upper limit, and so part of the rule.
        if self.gap_fill.precision.is_some() {
            return Ok(None);
        }
        let estimates = self.points.iter().flat_map(|point| &point.fillers).flatten();
        held_by_all(index, estimates.map(|estimate| &estimate.address))
    }

    fn all_trials(&self) -> u64 {
        self.most_trials().iter().sum()
    }

    fn surplus(&self) -> &'static str {
        if self.replays() { "whole replays of the record" } else { "the folder holds them already" }
    }
}

/// The fillers of a point, grouped into the launches that sample all of them together.
fn launches(point: &Lowered) -> Vec<Vec<usize>> {
    let groups = grouped(point, (0..point.fillers.len()).map(|_| Vec::new()));
    groups.into_iter().map(|(_, fillers)| fillers).collect()
}

/// Fillers of a point that lack the same blocks share a launch.
fn grouped(point: &Lowered, lacking: impl IntoIterator<Item = Vec<Block>>) -> Vec<(Vec<Block>, Vec<usize>)> {
    let mut groups: Vec<(Vec<Block>, Vec<usize>)> = Vec::new();
    for (filler, blocks) in lacking.into_iter().enumerate() {
        let joins = |group: &&mut (Vec<Block>, Vec<usize>)| {
            group.0 == blocks && group.1.len() < point.most_fillers(filler) && point.alike(group.1[0], filler)
        };
        match groups.iter_mut().find(joins) {
            Some(group) => group.1.push(filler),
            None => groups.push((blocks, vec![filler])),
        }
    }
    groups
}
