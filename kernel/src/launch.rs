//! What a device needs to sample the estimates of one point.

use std::sync::Arc;

use crate::moments::{FLUSH, Moments, Trials};
use crate::width::Width;
use crate::{gap_fill, relock, switched_run};

/// Which kernel samples, and what its launch has: what a shader is specialised for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sampled {
    /// Errors of gap fillers.
    GapFill(gap_fill::Shape),
    /// Angles of whole runs.
    SwitchedRun(switched_run::Shape),
    /// What is left of the ticks after a switch.
    Relock(relock::Shape),
}

impl Sampled {
    /// Number of estimates.
    pub fn estimates(&self) -> usize {
        match self {
            Sampled::GapFill(shape) => shape.estimates(),
            Sampled::SwitchedRun(shape) => shape.estimates(),
            Sampled::Relock(shape) => shape.estimates,
        }
    }

    /// Whether the kernel draws normal numbers, whose table is bound only then.
    pub fn has_normals(&self) -> bool {
        match self {
            Sampled::GapFill(_) | Sampled::Relock(_) => true,
            Sampled::SwitchedRun(shape) => shape.has_normals(),
        }
    }

    /// Whether the kernel reads the table.
    pub fn has_table(&self) -> bool {
        match self {
            Sampled::GapFill(shape) => shape.has_table(),
            Sampled::SwitchedRun(_) => true,
            Sampled::Relock(_) => false,
        }
    }
}

/// Most steps of an invocation.
pub const MOST_STEPS: u64 = 60_000;

/// Trials of one point: parameters in fixed point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Launch {
    /// Which kernel.
    pub sampled: Sampled,
    /// The parameters of the kernel, one after the other.
    pub words: Vec<u32>,
    /// What is too long for them; often empty.
    pub table: Arc<[u32]>,
}

impl Launch {
    /// Steps of one trial, each some tens of nanoseconds on one lane: what work is divided by.
    pub fn steps(&self) -> u64 {
        match self.sampled {
            Sampled::GapFill(_) => 1,
            Sampled::Relock(shape) => shape.ticks.ticks as u64,
            Sampled::SwitchedRun(shape) => {
                let relock = shape.relock.map_or(0, |relock| relock.ticks as u64);
                let intervals = switched_run::Parameters::of(&self.words, shape).intervals[0];
                u64::from(intervals) * (1 + relock)
            }
        }
    }

    /// Trials that one invocation of the shader adds up at most.
    pub fn most_rounds(&self) -> u64 {
        // Some drivers leave an invocation's loops after 65535 rounds.
        (MOST_STEPS / self.steps()).clamp(1, FLUSH)
    }

    /// Tallies of the estimates over some trials.
    pub fn tally(&self, width: Width, trials: Trials) -> Vec<Moments> {
        // What does not fill the lanes is done in one.
        let rest = trials.count % width.lanes() as u64;
        let count = trials.count - rest;
        let mut tallies = self.whole_lanes(width, Trials { count, ..trials });
        if rest > 0 {
            let last = Trials { first: trials.first + count, count: rest, ..trials };
            let last = self.whole_lanes(Width::PORTABLE, last);
            tallies.iter_mut().zip(&last).for_each(|(tally, last)| tally.merge(last));
        }
        tallies
    }

    fn whole_lanes(&self, width: Width, trials: Trials) -> Vec<Moments> {
        match self.sampled {
            Sampled::GapFill(shape) => width.run(gap_fill::Tally { launch: self, shape, trials }),
            Sampled::SwitchedRun(shape) => width.run(switched_run::Tally { launch: self, shape, trials }),
            Sampled::Relock(shape) => width.run(relock::Tally { launch: self, shape, trials }),
        }
    }
}
