//! Named synthetic records that cover every distinction made by the kernel of records.

use std::sync::Arc;

use crate::device::{Work, Workload};
use crate::key::Unrepresentable;
use crate::kinds::allan::lower::{Asked, Records};
use sagnac_kernel::samples::Segments;
use sagnac_theory::allan::{Difference, Estimator, Part, Process, Stride};
use sagnac_theory::drift::{Magnetic, Switching};

/// Rate of the turning Earth, ″/s.
const EARTH_RATE: f64 = 15.041;

/// Records of a noise model on which identity is checked.
#[derive(Debug, Clone)]
pub struct NamedRecords {
    /// Name in reports.
    pub name: &'static str,
    /// Parts of the noise.
    pub parts: Vec<Part>,
    /// Angle of a pulse, ″; 0 where the readout is not quantized.
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

/// Quantization noise, angle random walk and bias instability of the LGK-400 of the Allan paper's table 2.
pub fn lgk_400() -> Vec<Part> {
    vec![
        Part::quantization(0.24),
        Part::angle_random_walk(0.00067 * 60.0),
        Part::bias_instability(0.00192, 24),
    ]
}

impl NamedRecords {
    /// Lowers records of samples of one second, with the rate of the turning Earth, at all octaves that fit.
    ///
    /// # Errors
    /// The records cannot be represented.
    pub fn lower(&self) -> Result<Records, Unrepresentable> {
        let octaves = (0..63).map(|octave| 1 << octave);
        let ms: Vec<u64> = octaves.take_while(|&m| self.estimator.terms(self.samples, m) > 0).collect();
        Records::new(&Asked {
            process: &Process { sample_s: 1.0, parts: self.parts.clone() },
            readout_lsb: self.readout_lsb,
            mean_rate: EARTH_RATE,
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

/// The loads on which the kernels are checked.
pub fn loads() -> Vec<Workload> {
    let load = |named: NamedRecords| Workload {
        name: named.name,
        work: Work::Records(Arc::new(named.lowered().recipe().clone())),
        self_test_units: (named.name == "everything").then_some(40 * named.samples),
    };
    // Segments from anywhere in a record.
    let starts = [[0; 4], [1 << 50, -(1 << 45), 1 << 40, -7], [-1, 1 << 33, -(1 << 44), 1 << 52]];
    let segments = |(name, of, has_angles): (&'static str, usize, bool)| {
        let recipe = named_records()[of].lowered().recipe().clone();
        Workload {
            name,
            work: Work::Records(Arc::new(Segments::new(&recipe, u64::from(u32::MAX), 3, 3, &starts, has_angles))),
            self_test_units: (name == "everything-segments").then_some(5000),
        }
    };
    let of = [
        ("lgk-400-segments", 1, true),
        ("everything-segments", 2, true),
        ("everything-switched-ends", 5, false),
    ];
    named_records().into_iter().map(load).chain(of.map(segments)).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::allan::lower::theory::PhysicalTheory;

    /// The largest difference from the closed form of the inputs, and the largest bound relative to its variance; `None`
    /// without a closed form.
    fn compare(named: &NamedRecords) -> Option<(f64, f64)> {
        let records = named.lowered();
        let physical = PhysicalTheory {
            process: Process { sample_s: 1.0, parts: named.parts.clone() },
            readout_lsb: named.readout_lsb,
            mean_rate: EARTH_RATE,
            switching: named.switching,
            samples: named.samples,
            estimator: named.estimator,
        };
        let mut all = None;
        for (at, m) in records.ms().iter().enumerate() {
            let theory = records.theory(at);
            let found = records.representation(at, &theory, &physical);
            let found = found.unwrap_or_else(|error| panic!("{}, m = {m}: {error}", named.name));
            let Some((found, variance)) = found.zip(theory.value) else { continue };
            let bound = theory.representation / variance;
            println!("{}, m = {m}: {found:.2e}, bound {bound:.2e}", named.name);
            let (most, loosest) = all.unwrap_or((0.0_f64, 0.0_f64));
            all = Some((most.max(found.abs()), loosest.max(bound)));
        }
        all
    }

    #[test]
    fn closed_forms_of_the_words_are_those_of_the_inputs_within_the_rounding_of_words() {
        for named in named_records() {
            // The noise has flicker.
            let blank = named.readout_lsb > 0.0;
            match compare(&named) {
                Some((most, loosest)) => {
                    assert!(!blank && most > 0.0 && loosest < 1e-3, "{}: {most}, bound {loosest}", named.name)
                }
                None => assert!(blank, "{} has no closed form", named.name),
            }
        }
    }

    #[test]
    fn every_part_of_the_noise_alone_has_the_closed_form_of_its_input() {
        let white = Part::angle_random_walk(0.04);
        let magnetic = Magnetic { amplitude: 0.0, time_s: 1.0, initial: 0.0 };
        let none = Switching { interval: 37, magnetic, residual: 0.0, residual_noise: 0.0 };
        let warming = Magnetic { amplitude: 0.7, time_s: 150.0, initial: 0.02 };
        let slow = Magnetic { amplitude: 0.7, time_s: 5e4, initial: 0.0 };
        let steady = Magnetic { initial: 0.7, ..magnetic };
        let switched = |magnetic| Some(Switching { magnetic, ..none });
        for (name, parts, readout_lsb, switching) in [
            ("quantization", vec![Part::quantization(0.24)], 0.0, None),
            ("white", vec![white], 0.0, None),
            ("flicker", vec![Part::bias_instability(0.00192, 24)], 0.0, None),
            ("walk", vec![Part::rate_random_walk(2e-4)], 0.0, None),
            ("Markov", vec![Part::markov(4e-4, 40.0)], 0.0, None),
            ("fast Markov", vec![Part::markov(4e-4, 0.3)], 0.0, None),
            ("sine", vec![Part::sine(0.02, 0.0137)], 0.0, None),
            ("ramp", vec![white, Part::rate_ramp(1e-5)], 0.0, None),
            ("warm-up", vec![white, Part::warm_up(0.03, 200.0)], 0.0, None),
            ("long warm-up", vec![white, Part::warm_up(3.0, 1e5)], 0.0, None),
            ("ramp and warm-ups", vec![white, Part::rate_ramp(1e-5), Part::warm_up(0.03, 200.0)], 0.0, None),
            ("sawtooth", vec![white], 0.0, switched(warming)),
            ("slow sawtooth", vec![white, Part::rate_ramp(1e-5)], 0.0, switched(slow)),
            ("steady sawtooth", vec![white, Part::warm_up(0.03, 200.0)], 0.0, switched(steady)),
            ("residual", vec![white], 0.0, Some(Switching { residual: 10.0, ..none })),
            ("noise of residuals", vec![white], 0.0, Some(Switching { residual_noise: 0.3, ..none })),
            ("pulses of white noise", vec![Part::angle_random_walk(0.4)], 0.83, None),
        ] {
            for estimator in [THINNED, Estimator::NON_OVERLAPPING, Estimator::HADAMARD] {
                let parts = parts.clone();
                let named = NamedRecords { name, parts, readout_lsb, switching, samples: 3000, estimator };
                let (_, loosest) = compare(&named).unwrap_or_else(|| panic!("{name} is blank"));
                // Where the differences of a sine are near 0, the rounding of its frequency is a large part of them.
                assert!(loosest < 5e-2, "{name}, {estimator:?}: bound {loosest}");
            }
        }
    }

    #[test]
    fn pulses_at_a_constant_rate_beat_as_those_of_the_input() {
        // With so little noise the beat of 15.041/0.83 pulses per sample is most of the variance.
        let parts = vec![Part::angle_random_walk(0.02)];
        let estimator = Estimator::OVERLAPPING;
        let named = NamedRecords {
            name: "pulses",
            parts,
            readout_lsb: 0.83,
            switching: None,
            samples: 700,
            estimator,
        };
        let (most, loosest) = compare(&named).unwrap();
        assert!(most < 1e-4 && loosest < 1e-2, "{most}, bound {loosest}");
        let parts = vec![Part::angle_random_walk(0.02)];
        let still = PhysicalTheory {
            process: Process { sample_s: 1.0, parts },
            readout_lsb: 0.83,
            mean_rate: 0.0,
            switching: None,
            samples: 700,
            estimator,
        };
        let found = named.lowered().theory(0).value.unwrap();
        let without = still.variance(1).unwrap().value;
        assert!((found / without - 1.0).abs() > 0.1, "{found}, {without} without a rate");
    }
}
