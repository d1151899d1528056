//! Where results are from, so that they can be had again.

use sha2::{Digest, Sha256};

use crate::run::Plan;
use crate::store::error::StoreError;
use crate::store::{Provenance, Store};
use crate::study::Study;
use crate::study::kept::Input;
use crate::study::kind::Kind;

/// What was simulated, and by whom.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// The study as it was run, as TOML.
    pub study: String,
    /// The files that the study names.
    pub inputs: Vec<Named>,
    /// What it is about.
    pub kind: &'static Kind,
    /// Seed and trials at each point; none of closed forms.
    pub sampled: Option<(u64, u64)>,
    /// Whether points stop at a precision, so that the trials are the most there are.
    pub stops: bool,
    /// Trials that are missing of the whole.
    pub lacking: u64,
    /// How many points its sweeps make.
    pub points: usize,
    /// Whether trials count more than once, as estimates of a point that are not sampled together take their own.
    pub counts_again: bool,
    /// Who sampled how much.
    pub provenance: Vec<Provenance>,
    /// The kernels with their versions; empty of closed forms.
    pub kernels: String,
}

/// A file that a study names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// As the study calls it: `inputs/LGK-400.toml`.
    pub name: String,
    /// SHA-256 of its bytes, in hexadecimal figures.
    pub digest: String,
    /// What it says, where that is short.
    pub text: Option<String>,
}

/// Most bytes of a file that a page shows.
const SHORT: usize = 16 << 10;

impl Named {
    fn of(input: &Input) -> Named {
        let text = (input.text.len() <= SHORT).then(|| input.text.to_string());
        Named { name: input.name.clone(), digest: hexadecimal(input.text.as_bytes()), text }
    }
}

/// SHA-256.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Source {
    /// Of what a store holds of a study; `held` are the trials that [`Plan::held`] says, `lacking` those that are missing of the
    /// whole.
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
            stops: study.has_stop_rule(),
            lacking,
            points: study.sweeps.iter().map(|sweep| sweep.values.len()).product(),
            counts_again: plan.counts_again(provenance.iter().map(|by| by.trials).sum()),
            provenance,
            kind: study.kind(),
            kernels: identity.kernels,
        })
    }
}
