//! Where results are from, so that they can be had again.

use sha2::{Digest, Sha256};

use crate::run::{Plan, Tables};
use crate::store::{Provenance, Store, StoreError};
use crate::study::Study;

/// What was simulated, and by whom.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// The study as it was run, as TOML.
    pub study: String,
    /// Its kind: `gap-fill`.
    pub kind: String,
    /// Seed and trials at each point; none of closed forms.
    pub sampled: Option<(u64, u64)>,
    /// Whether points stop at a precision, so that the trials are the most there are.
    pub stops: bool,
    /// Trials that are missing of the whole.
    pub lacking: u64,
    /// How many points its sweeps make.
    pub points: usize,
    /// Who sampled how much.
    pub provenance: Vec<Provenance>,
    /// The kernels with their versions; empty of closed forms.
    pub kernels: String,
    /// SHA-256 of points.csv, in hexadecimal figures.
    pub digest: String,
}

impl Source {
    /// Of what a store holds of a study; `tables` are those of the same store, `held` the trials that
    /// [`Plan::held`] says, `lacking` those that are missing of the whole.
    ///
    /// # Errors
    /// The store cannot be read, or a row of it is damaged.
    pub fn of(
        study: &Study,
        plan: &Plan,
        store: &Store,
        tables: &Tables,
        held: u64,
        lacking: u64,
    ) -> Result<Source, StoreError> {
        let identity = plan.identity();
        let mut points = Vec::new();
        // Memory takes whatever is written to it.
        let _ = tables.points.write_csv(&mut points);
        Ok(Source {
            study: study.resolved(held),
            sampled: plan.is_sampled().then_some((study.seed, held)),
            stops: study.has_stop_rule(),
            lacking,
            points: study.sweeps.iter().map(|sweep| sweep.values.len()).product(),
            provenance: store.provenance()?,
            digest: Sha256::digest(&points).iter().map(|byte| format!("{byte:02x}")).collect(),
            kind: identity.kind,
            kernels: identity.kernels,
        })
    }
}
