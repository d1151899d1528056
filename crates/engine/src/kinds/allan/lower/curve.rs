//! A point of a study of Allan curves, ready to be sampled.

use crate::key::row::{Refusal, Streams};
use crate::kinds::allan::lower::{Asked, Records};
use crate::kinds::allan::point::{Inputs as RecordInputs, Point as RecordPoint};
use crate::kinds::plan::identity;
use crate::store::Address;
use crate::tally::Id;
use sagnac_theory::allan::estimator::{Difference, Estimator, Stride};

/// Records of one point, with the address of their sums.
#[derive(Debug, Clone, PartialEq)]
pub struct LoweredCurve {
    /// The noise in fixed point, with its closed forms.
    pub records: Records,
    /// Address of the sums of the records in the store.
    pub address: Address,
}

impl LoweredCurve {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The point cannot be represented; see [`Refusal`].
    pub fn new(
        point: &RecordPoint,
        estimator: Estimator,
        seed: u64,
        streams: Streams,
    ) -> Result<LoweredCurve, Refusal> {
        let inputs = &point.inputs;
        let (id, key) = identity("allan", seed, streams, &canonical(inputs));
        let samples = inputs.samples();
        let process = inputs.noise.process(inputs.sample_s, samples);
        let asked = Asked {
            process: &process,
            readout_lsb: inputs.noise.readout_lsb,
            mean_rate: inputs.rate,
            switching: inputs.noise.switched(inputs.sample_s),
            samples,
            estimator,
            ms: &point.ms,
            key,
        };
        let records = Records::new(&asked)?;
        let estimate = Id::of(&format!("estimate\n{}ms={:?}\n", named(estimator), point.ms));
        let address = Address { point: id, estimate, digest: records.digest() };
        Ok(LoweredCurve { records, address })
    }
}

/// An estimator in identities.
fn named(estimator: Estimator) -> String {
    let difference = match estimator.difference {
        Difference::Second => "second",
        Difference::Third => "third",
    };
    let stride = match estimator.stride {
        Stride::Sample => "1".to_owned(),
        Stride::Cluster => "m".to_owned(),
        Stride::Part(parts) => format!("m/{parts}"),
    };
    format!("difference={difference}\nstride={stride}\n")
}

/// The inputs that determine the draws.
fn canonical(inputs: &RecordInputs) -> String {
    let RecordInputs { sample_s, rate, noise, .. } = inputs;
    // A constant rate affects whole pulses only.
    let rate = if noise.readout_lsb > 0.0 { *rate } else { 0.0 };
    let (samples, noise) = (inputs.samples(), noise.canonical());
    format!("sample_s={sample_s:.11e}\nsamples={samples}\nrate={rate:.11e}\n{noise}")
}
