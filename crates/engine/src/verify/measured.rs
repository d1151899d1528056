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
}

/// Gap-fill configurations: those of `verify`, and whether they have a histogram as in studies.
const GAP_FILLS: [(&str, bool); 5] = [
    ("paper", false),
    ("paper", true),
    ("minimum-variance", false),
    ("eight-tones", false),
    ("profile", false),
];

/// Records of nine hours at 1 Hz, with differences spaced by a 64th of τ, and at every sample.
const RECORDS: [(&str, Estimator); 2] =
    [("lgk-400, overlap m/64", THINNED), ("lgk-400, full overlap", Estimator::OVERLAPPING)];
const SAMPLES: u64 = 32_400;

/// Records of ten seconds of a dithered gyro.
const GYRO_SAMPLES: u64 = 4000;

/// All measured loads.
pub fn measured() -> Vec<Measured> {
    let mut measured = Vec::new();
    let mut trials = |kernel, configuration, unit, launches: Vec<Launch>, histogram| {
        let work = launches.into_iter().next().map(Work::Trials);
        measured.extend(work.map(|work| Measured { kernel, configuration, unit, work, histogram }));
    };
    let all = configurations();
    for (name, histogram) in GAP_FILLS {
        let found = all.iter().find(|configuration| configuration.name == name);
        let launches = found.map(|configuration| configuration.launches()).unwrap_or_default();
        trials("gap_fill", name, "trials", launches, histogram);
    }
    trials("switched_run", "one hour, MT = 40 s, 89 or 90 switches", "runs", hour_launches(), true);
    for compensation in Compensation::ALL {
        let launches = launches_of(&relock(), compensation);
        trials("relock", compensation.name(), "trials", launches, false);
    }
    for (configuration, estimator) in RECORDS {
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
        measured.push(Measured { kernel, configuration, unit, work, histogram });
    }
    let gyros = lowered(&checked(), 1, GYRO_SAMPLES, THINNED);
    measured.push(Measured {
        kernel: "lock_in",
        configuration: "400 Hz, 450 rad, amplitude noise",
        unit: "steps",
        work: Work::Records(gyros.shared()),
        histogram: false,
    });
    // The north gyro, with seven functionals.
    let navigator = navigator(Solution::Inertial, navigation::verify::lgk_400(), SAMPLES as f64);
    measured.extend(navigator.gyros.into_iter().next().map(|gyro| Measured {
        kernel: "navigation",
        configuration: "lgk-400, inertial",
        unit: "samples",
        work: Work::Records(Arc::new(gyro.navigation)),
        histogram: false,
    }));
    measured
}
