//! The origin of results, with which they can be reproduced.

use sha2::{Digest, Sha256};

use crate::key::sweep;
use crate::run::Plan;
use crate::store::error::StoreError;
use crate::store::{Provenance, Store};
use crate::study::Study;
use crate::study::kept::Input;
use crate::study::kind::Kind;
use crate::table::file::hexadecimal;

/// The simulation and its provenance.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// The study as it was run, as TOML.
    pub study: String,
    /// The files that the study names.
    pub inputs: Vec<Named>,
    /// Kind of the study.
    pub kind: &'static Kind,
    /// Seed and trials at each point; `None` for closed forms.
    pub sampled: Option<(u64, u64)>,
    /// Whether points stop at a precision, so that the trials are an upper limit.
    pub stops: bool,
    /// Number of missing trials.
    pub lacking: u64,
    /// Number of points of its sweeps.
    pub points: usize,
    /// Whether trials count more than once, because estimates of a point that are not sampled together take their own.
    pub counts_again: bool,
    /// Provenance: devices with their trials and times.
    pub provenance: Vec<Provenance>,
    /// Kernels with their versions; empty for closed forms.
    pub kernels: String,
}

/// A file that a study names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// Name in the study, such as `inputs/LGK-400.toml`.
    pub name: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub digest: String,
    /// Contents, where they are short.
    pub text: Option<String>,
}

/// Most bytes of a file that a page shows.
const SHORT: usize = 16 << 10;

impl Named {
    fn of(input: &Input) -> Named {
        let text = (input.text.len() <= SHORT).then(|| input.text.to_string());
        Named { name: input.name.clone(), digest: hexadecimal(&Sha256::digest(input.text.as_bytes())), text }
    }
}

impl Source {
    /// The source for the results of a study in a store; `held` is the result of [`Plan::held`], `lacking` the number
    /// of missing trials.
    ///
    /// # Errors
    /// The store cannot be read, or a row of it is damaged.
    pub fn of(
        study: &Study,
        plan: &Plan,
        store: &Store,
        held: u64,
        lacking: u64,
    ) -> Result<Source, StoreError> {
        let identity = plan.identity();
        let provenance = store.provenance()?;
        Ok(Source {
            study: study.resolved(held),
            inputs: study.inputs().into_iter().map(Named::of).collect(),
            sampled: plan.is_sampled().then_some((study.seed, held)),
            stops: study.precision.is_some(),
            lacking,
            points: sweep::count(&study.sweeps),
            counts_again: plan.counts_again(Provenance::trials_of(&provenance)),
            provenance,
            kind: study.kind(),
            kernels: identity.kernels,
        })
    }
}
