//! The loads whose rates `sagnac device bench` and the example `gpu_lab` measure.

use std::sync::Arc;

use crate::device::load::Work;
use crate::kinds::allan::verify::{NamedRecords, THINNED, lgk_400};
use crate::kinds::gap_fill::verify::configurations;
use crate::kinds::lock_in::verify::{checked, lowered};
use crate::kinds::navigation;
use crate::kinds::navigation::keys::Solution;
use crate::kinds::navigation::verify::navigator;
use crate::kinds::relock::inputs::Compensation;
use crate::kinds::relock::verify::{launches_of, relock};
use crate::kinds::switched_run::verify::hour_launches;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::shader::Variant;
use sagnac_theory::allan::estimator::Estimator;

/// A measured kernel.
pub struct Measured {
    /// The kernel.
    pub kernel: &'static str,
    /// Name of what is sampled.
    pub configuration: &'static str,
    /// What a rate counts: trials, runs, samples or steps.
    pub unit: &'static str,
    /// What is sampled.
    pub work: Work,
    /// Whether the tallies have histograms.
    pub histogram: bool,
    /// Integer operations of a trial, run, sample or step, with 64-bit products and with 16-bit ones: see `operations`.
    operations: [u32; 2],
}

impl Measured {
    /// Integer operations of 32 bits that a trial, run, sample or step needs in this variant of its shader. The example
    /// `gpu_lab` counts them and tests these numbers; docs/performance.md says which operations count.
    pub fn operations(&self, variant: Variant) -> u32 {
        self.operations[usize::from(!variant.int64)]
    }
}

/// Gap-fill configurations: those of `verify`, and whether they have a histogram as in studies.
const GAP_FILLS: [(&str, bool, [u32; 2]); 5] = [
    ("paper", false, [552, 1743]),
    ("paper", true, [630, 1821]),
    ("minimum-variance", false, [786, 2853]),
    ("eight-tones", false, [1479, 5985]),
    ("profile", false, [605, 1619]),
];

const RUN: [u32; 2] = [14_058, 46_641];

/// Those of [`Compensation::ALL`].
const RELOCKS: [[u32; 2]; 3] = [[398, 1587], [1208, 4933], [1834, 7195]];

/// Records of nine hours at 1 Hz, with differences spaced by a 64th of τ, and at every sample.
const RECORDS: [(&str, Estimator, [u32; 2]); 2] = [
    ("lgk-400, overlap m/64", THINNED, [266, 811]),
    ("lgk-400, full overlap", Estimator::OVERLAPPING, [319, 1008]),
];
const SAMPLES: u64 = 32_400;

/// Records of ten seconds of a dithered gyro.
const GYRO_SAMPLES: u64 = 4000;
const STEP: [u32; 2] = [30, 123];

/// The north gyro of a navigator over nine hours, with seven functionals.
const NAVIGATOR: [u32; 2] = [219, 741];

/// All measured loads.
pub fn measured() -> Vec<Measured> {
    let mut measured = Vec::new();
    let mut trials = |kernel, configuration, unit, launches: Vec<Launch>, histogram, operations| {
        let work = launches.into_iter().next().map(Work::Trials);
        measured.extend(work.map(|work| Measured {
            kernel,
            configuration,
            unit,
            work,
            histogram,
            operations,
        }));
    };
    let all = configurations();
    for (name, histogram, operations) in GAP_FILLS {
        let found = all.iter().find(|configuration| configuration.name == name);
        let launches = found.map(|configuration| configuration.launches()).unwrap_or_default();
        trials("gap_fill", name, "trials", launches, histogram, operations);
    }
    trials("switched_run", "one hour, MT = 40 s, 89 or 90 switches", "runs", hour_launches(), true, RUN);
    for (compensation, operations) in Compensation::ALL.into_iter().zip(RELOCKS) {
        let launches = launches_of(&relock(), compensation);
        trials("relock", compensation.name(), "trials", launches, false, operations);
    }
    for (configuration, estimator, operations) in RECORDS {
        let (parts, samples) = (lgk_400(), SAMPLES);
        let named = NamedRecords {
            name: configuration,
            parts,
            readout_lsb: 0.0,
            switching: None,
            samples,
            estimator,
        };
        let work = Work::Records(Arc::new(named.lowered().recipe().clone()));
        let (kernel, unit, histogram) = ("allan", "samples", false);
        measured.push(Measured { kernel, configuration, unit, work, histogram, operations });
    }
    let gyros = lowered(&checked(), 1, GYRO_SAMPLES, THINNED);
    measured.push(Measured {
        kernel: "lock_in",
        configuration: "400 Hz, 450 rad, amplitude noise",
        unit: "steps",
        work: Work::Records(gyros.shared()),
        histogram: false,
        operations: STEP,
    });
    let navigator = navigator(Solution::Inertial, navigation::verify::lgk_400(), SAMPLES as f64);
    measured.extend(navigator.gyros.into_iter().next().map(|gyro| Measured {
        kernel: "navigation",
        configuration: "lgk-400, inertial",
        unit: "samples",
        work: Work::Records(Arc::new(gyro.navigation)),
        histogram: false,
        operations: NAVIGATOR,
    }));
    measured
}
