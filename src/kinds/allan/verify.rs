//! Named synthetic records that cover every distinction made by the kernel of records.

use std::sync::Arc;

use crate::device::load::{Load, Work};
use crate::key::refusal::Refusal;
use crate::kinds::allan::lower::{Asked, Records};
use crate::theory::allan::estimator::{Difference, Estimator, Stride};
use crate::theory::allan::part::Part;
use crate::theory::allan::process::Process;
use crate::theory::allan::switching::Switching;
use crate::theory::drift::magnetic::Magnetic;

/// Records of a noise model on which identity is checked.
#[derive(Debug, Clone)]
pub struct NamedRecords {
    /// Name in reports.
    pub name: &'static str,
    /// Parts of the noise.
    pub parts: Vec<Part>,
    /// Angle of a pulse, ″; 0 where the readout is not quantised.
    pub readout_lsb: f64,
    /// Switching, of a gyro that switches modes.
    pub switching: Option<Switching>,
    /// Samples of a record.
    pub samples: u64,
    /// Order and spacing of the differences.
    pub estimator: Estimator,
}

/// The estimator of studies, with every 64th part of τ.
pub const THINNED: Estimator = Estimator { difference: Difference::Second, stride: Stride::Part(64) };

/// Quantisation noise, angle random walk and bias instability of the LGK-400 of the Allan paper's table 2.
pub fn lgk_400() -> Vec<Part> {
    vec![
        Part::quantisation(0.24),
        Part::angle_random_walk(0.00067 * 60.0),
        Part::bias_instability(0.00192, 24),
    ]
}

impl NamedRecords {
    /// Lowers records of samples of one second, with the rate of the turning Earth, at all octaves that fit.
    ///
    /// # Errors
    /// The records cannot be represented.
    pub fn lower(&self) -> Result<Records, Refusal> {
        let octaves = (0..63).map(|octave| 1 << octave);
        let ms: Vec<u64> = octaves.take_while(|&m| self.estimator.terms(self.samples, m) > 0).collect();
        Records::new(&Asked {
            process: &Process { sample_s: 1.0, parts: self.parts.clone() },
            readout_lsb: self.readout_lsb,
            mean_rate: 15.041,
            switching: self.switching,
            samples: self.samples,
            estimator: self.estimator,
            ms: &ms,
            key: [0x5A67_6E61, 0x6300_0001],
        })
    }

    /// Lowers records that are known to fit.
    pub fn lowered(&self) -> Records {
        self.lower().unwrap_or_else(|error| panic!("{} does not lower: {error}", self.name))
    }
}

/// The loads on which the kernel is checked.
pub fn loads() -> Vec<Load> {
    let load = |named: NamedRecords| Load {
        name: named.name,
        work: Work::Records(Arc::new(named.lowered().recipe().clone())),
        self_test_units: (named.name == "everything").then_some(40 * named.samples),
    };
    named_records().into_iter().map(load).collect()
}

/// Records that cover every distinction made by the kernel.
pub fn named_records() -> Vec<NamedRecords> {
    let everything = || {
        let mut parts = lgk_400();
        parts.extend([
            Part::rate_random_walk(2e-4),
            Part::markov(4e-4, 40.0),
            Part::sine(0.02, 0.0137),
            Part::rate_ramp(1e-5),
            Part::warm_up(0.03, 200.0),
        ]);
        parts
    };
    let of = |name, parts, readout_lsb, samples, estimator| NamedRecords {
        name,
        parts,
        readout_lsb,
        switching: None,
        samples,
        estimator,
    };
    let (thinned, apart, hadamard) = (THINNED, Estimator::NON_OVERLAPPING, Estimator::HADAMARD);
    // Switches at arbitrary places within chunks, and several in one chunk.
    let switching = |interval| Switching {
        interval,
        magnetic: Magnetic { amplitude: 0.7, time_s: 150.0, initial: 0.02 },
        residual: 10.0,
        residual_noise: 0.3,
    };
    let switched = |name, parts, interval, readout_lsb| NamedRecords {
        switching: Some(switching(interval)),
        ..of(name, parts, readout_lsb, 700, thinned)
    };
    vec![
        of("white-noise", vec![Part::angle_random_walk(0.04)], 0.0, 2000, apart),
        of("lgk-400", lgk_400(), 0.0, 3000, thinned),
        of("everything", everything(), 0.83, 700, thinned),
        of("everything-hadamard", everything(), 0.83, 700, hadamard),
        switched("lgk-400-switched", lgk_400(), 37, 0.0),
        switched("everything-switched", everything(), 5, 0.83),
    ]
}
