//! Loads on which devices are compared.

use sagnac_kernel::launch::Launch;
use std::sync::Arc;

use sagnac_kernel::curve::Recorded;

/// A named load of a kernel. A kind of study provides loads that cover every distinction its kernel makes.
#[derive(Debug, Clone)]
pub struct Load {
    /// Name in reports.
    pub name: &'static str,
    /// The computation.
    pub work: Work,
    /// Number of trials or samples that every device must compute correctly before it is used.
    pub self_test_units: Option<u64>,
}

/// The computation of a load.
#[derive(Debug, Clone)]
pub enum Work {
    /// Trials of a launch.
    Trials(Launch),
    /// Synthetic records.
    Records(Arc<dyn Recorded>),
}

impl Load {
    /// Loads of launches; those named in `self_test` are part of the self-test.
    pub fn of_launches(launches: Vec<(&'static str, Launch)>, self_test: &[&str]) -> Vec<Load> {
        let load = |(name, launch)| Load {
            name,
            work: Work::Trials(launch),
            self_test_units: self_test.contains(&name).then_some(5000),
        };
        launches.into_iter().map(load).collect()
    }

    /// The launch, if the load has one.
    pub fn launch(&self) -> Option<&Launch> {
        match &self.work {
            Work::Trials(launch) => Some(launch),
            Work::Records(_) => None,
        }
    }

    /// The stem of the kernel that computes the load.
    pub fn kernel(&self) -> &'static str {
        match &self.work {
            Work::Trials(launch) => launch.sampled().part().stem,
            Work::Records(recipe) => recipe.part().stem,
        }
    }
}
