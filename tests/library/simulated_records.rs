//! Records sample by sample: the numbers whose variances the kernels sum up.

use sagnac_engine::device::Cpu;
use sagnac_engine::kinds::allan::lower::{Asked, Records};
use sagnac_kernel::width::Width;
use sagnac_theory::allan::{Estimator, Part, Process};

const SAMPLES: u64 = 5000;
const MS: [u64; 4] = [1, 7, 100, 1250];
const STEP_S: f64 = 0.5;

fn records(parts: Vec<Part>, readout_lsb: f64, mean_rate: f64) -> Records {
    Records::new(&Asked {
        process: &Process { sample_s: STEP_S, parts },
        readout_lsb,
        mean_rate,
        switching: None,
        samples: SAMPLES,
        estimator: Estimator::OVERLAPPING,
        ms: &MS,
        key: [3, 4],
    })
    .unwrap()
}

/// The overlapping Allan variance of angles, (″/s)².
fn variance(angles: &[f64], m: usize) -> f64 {
    let terms = angles.len() - 2 * m;
    let square = |k: usize| {
        let difference = angles[k + 2 * m] - 2.0 * angles[k + m] + angles[k];
        difference * difference
    };
    let tau_s = m as f64 * STEP_S;
    (0..terms).map(square).sum::<f64>() / (2.0 * tau_s * tau_s * terms as f64)
}

#[test]
fn a_record_has_the_variances_that_the_kernel_sums_up_whatever_its_noise() {
    let noises = [
        (vec![Part::angle_random_walk(0.04)], 0.0, 0.0),
        (
            vec![Part::quantization(0.3), Part::rate_random_walk(2e-4), Part::bias_instability(3e-3, 0)],
            0.0,
            15.0,
        ),
        (vec![Part::markov(0.01, 40.0), Part::rate_ramp(1e-6)], 0.0, -2.0),
        (vec![Part::angle_random_walk(0.04)], 0.7, 720_000.0),
        (vec![Part::angle_random_walk(0.04)], 0.7, -15.04),
    ];
    for (parts, readout_lsb, mean_rate) in noises {
        let records = records(parts.clone(), readout_lsb, mean_rate);
        for number in [0, 6, 1 << 40] {
            // Without the constant rate, beside which small differences would be lost.
            let constant = mean_rate * STEP_S;
            let mut angles = vec![0.0];
            for increment in records.increments(number) {
                angles.push(angles[angles.len() - 1] + (increment - constant));
            }
            assert_eq!(angles.len() as u64, SAMPLES + 1);
            let sums = Cpu::new(Width::widest(), 1).unwrap().sums(records.recipe(), number, 1, &|_| {});
            for (m, expected) in MS.into_iter().zip(records.variances(&sums)) {
                let found = variance(&angles, m as usize);
                assert!((found / expected - 1.0).abs() < 1e-6, "{parts:?} {number} {m}: {found} {expected}");
            }
            let rate = angles[SAMPLES as usize] / (SAMPLES as f64 * STEP_S);
            assert!(rate.abs() < 0.05, "{parts:?}: {rate}");
        }
    }
}
