//! Work that devices are compared on.

use crate::kernel::launch::Launch;
use crate::kernel::recipe::Recipe;

/// A named load of a kernel; a kind of study gives loads that differ in everything its kernel distinguishes.
#[derive(Debug, Clone)]
pub struct Load {
    /// As a report names it.
    pub name: &'static str,
    /// What is computed.
    pub work: Work,
    /// Trials or samples that every device has to get right before it is used.
    pub self_test_units: Option<u64>,
}

/// What a load computes.
#[derive(Debug, Clone)]
pub enum Work {
    /// Trials of a launch.
    Trials(Launch),
    /// Synthetic records.
    Records(Recipe),
}

impl Load {
    /// Loads of launches, of which those named in `self_test` are in the self-test.
    pub fn of_launches(launches: Vec<(&'static str, Launch)>, self_test: &[&str]) -> Vec<Load> {
        let load = |(name, launch)| Load {
            name,
            work: Work::Trials(launch),
            self_test_units: self_test.contains(&name).then_some(5000),
        };
        launches.into_iter().map(load).collect()
    }

    /// The launch, where it is one.
    pub fn launch(&self) -> Option<&Launch> {
        match &self.work {
            Work::Trials(launch) => Some(launch),
            Work::Records(_) => None,
        }
    }

    /// The stem of the kernel that computes it.
    pub fn kernel(&self) -> &'static str {
        match &self.work {
            Work::Trials(launch) => launch.sampled.part().stem,
            Work::Records(recipe) => recipe.part().stem,
        }
    }
}
