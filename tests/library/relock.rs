//! What is left of a relock is right: against closed forms, and against an independent sampler in f64.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::device::{Cpu, Job};
use sagnac::tally::{Estimates, cover};
use sagnac_engine::key::{Streams, Unrepresentable};
use sagnac_engine::kinds::relock::lower::{LoweredRelock, RelockEstimate};
use sagnac_engine::kinds::relock::verify::{named_relocks, relock};
use sagnac_engine::kinds::relock::{Compensation, FirstHalf, Relock, RelockInputs, RelockPoint};
use sagnac_kernel::width::Width;

const TRIALS: u64 = 1 << 20;

fn with(change: impl FnOnce(&mut Relock)) -> RelockInputs {
    let mut inputs = relock();
    change(&mut inputs.relock);
    inputs
}

/// A relock without any noise, counting or rounding, but with a spread miss.
fn clean(change: impl FnOnce(&mut Relock)) -> RelockInputs {
    with(|relock| {
        (relock.temperature_error, relock.adc_noise, relock.adc_step, relock.count_step) =
            (0.0, 0.0, 0.0, 0.0);
        change(relock);
    })
}

fn lowered(inputs: &RelockInputs) -> LoweredRelock {
    let point = RelockPoint { swept: vec![], inputs: inputs.clone() };
    LoweredRelock::new(&point, 7, Streams::Independent).unwrap()
}

/// Every estimate with what its trials come to.
fn sampled(lowered: &LoweredRelock) -> Vec<(&RelockEstimate, Estimates)> {
    let cpu = Cpu::new(Width::widest(), 0).unwrap();
    let mut all = Vec::new();
    for estimate in &lowered.estimates {
        let launch = lowered.launch(&[estimate]);
        let jobs: Vec<Job> =
            cover(0..TRIALS, 63).into_iter().map(|block| Job { launch: &launch, block }).collect();
        let tally = &cpu.tally(&jobs, true, &|_| {})[0][0];
        all.push((estimate, Estimates::new(tally, estimate.bin_base, lowered.fixed.lsb_arcsec).unwrap()));
    }
    all
}

/// One switch in f64: what is left of each tick, ″.
fn draw(inputs: &RelockInputs, compensation: Compensation, rng: &mut StdRng) -> Vec<f64> {
    let RelockInputs { tick_s, relock } = inputs;
    let half = 0.5 * tick_s / relock.loop_s;
    let miss = relock.miss
        + relock.half_wave_error * normal(rng)
        + relock.dac_step * (rng.random::<f64>() - 0.5)
        + relock.hysteresis * (2.0 * rng.random::<f64>() - 1.0);
    let wrong = relock.temperature_error * normal(rng);
    let periods = relock.bias_frequency_hz * tick_s;
    let arcsec = periods * relock.pulse_weight_arcsec;
    let sign = if relock.first_half == FirstHalf::Negative { 1.0 } else { -1.0 };
    let mut phase = rng.random::<f64>();
    let mut first_error = 0.0;
    let mut left = vec![];
    for i in 0..relock.ticks {
        // ∫Δλ² over each half, by half a tick.
        let start = miss * (-2.0 * f64::from(i) * half).exp();
        let squares = [0.0, 1.0].map(|k: f64| {
            let from = start * (-k * half).exp();
            from * from * (1.0 - (-2.0 * half).exp()) / (2.0 * half)
        });
        let lost = squares.map(|square| relock.curvature * square);
        let faked = 0.5 * arcsec * (lost[0] - lost[1]);
        let taken = match compensation {
            Compensation::None => 0.0,
            Compensation::Frequency => {
                let halves = lost.map(|lost| 0.5 * periods * (1.0 - lost));
                let top = phase + halves[0];
                let end = top - halves[1];
                let counted = if relock.count_step > 0.0 {
                    2.0 * top.floor() - phase.floor() - end.floor()
                } else {
                    halves[0] + halves[1]
                };
                phase = end;
                let error = counted - periods * (1.0 + wrong);
                if i == 0 {
                    first_error = error;
                    0.0
                } else if first_error < error && error < 0.0 {
                    let q = (error / first_error).powf(0.5 / f64::from(i));
                    -error * relock.pulse_weight_arcsec * (1.0 - q) / (1.0 + q)
                } else {
                    0.0
                }
            }
            Compensation::Detuning => {
                let means = [0.0, 1.0].map(|k: f64| {
                    let mean = start * (-k * half).exp() * (1.0 - (-half).exp()) / half;
                    let noisy = mean + relock.adc_noise * normal(rng);
                    let step = relock.adc_step;
                    if step > 0.0 { (noisy / step + 0.5).floor() * step } else { noisy }
                });
                let r = means[1] / means[0];
                let bias = arcsec * (1.0 + wrong);
                if r > 0.0 && r < 1.0 {
                    relock.curvature * bias * means[0] * means[0] * -r.ln() * (1.0 + r) * (1.0 + r) / 4.0
                } else {
                    0.0
                }
            }
        };
        left.push(sign * (faked - taken));
    }
    left
}

fn normal(rng: &mut StdRng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (core::f64::consts::TAU * v).cos()
}

#[test]
fn what_is_left_is_that_of_an_independent_sampler_within_5_standard_errors() {
    let cases = [
        ("all errors", with(|_| {})),
        ("positive half first", with(|relock| relock.first_half = FirstHalf::Positive)),
        ("slow loop, eight ticks", with(|relock| (relock.loop_s, relock.ticks) = (0.0315, 8))),
        ("fast loop", with(|relock| relock.loop_s = 0.0055)),
        ("much noise", with(|relock| (relock.adc_noise, relock.temperature_error) = (0.005, 0.003))),
        ("no miss but its errors", with(|relock| (relock.miss, relock.half_wave_error) = (0.0, 0.02))),
        ("coarse steps", with(|relock| (relock.adc_step, relock.dac_step) = (0.01, 0.03))),
        ("no counts", with(|relock| relock.count_step = 0.0)),
    ];
    const DRAWS: u32 = 400_000;
    let mut largest: f64 = 0.0;
    for (name, inputs) in cases {
        let lowered = lowered(&inputs);
        let found = sampled(&lowered);
        for compensation in Compensation::ALL {
            let mut rng = StdRng::seed_from_u64(11);
            let ticks = inputs.relock.ticks as usize;
            // Sums of powers, of each tick and of all together.
            let mut sums = vec![[0.0; 4]; ticks + 1];
            for _ in 0..DRAWS {
                let mut left = draw(&inputs, compensation, &mut rng);
                left.push(left.iter().sum());
                for (sums, x) in sums.iter_mut().zip(left) {
                    *sums = [sums[0] + x, sums[1] + x * x, sums[2] + x * x * x, sums[3] + x * x * x * x];
                }
            }
            let of = found.iter().filter(|(estimate, _)| estimate.compensation == compensation);
            for ((estimate, found), sums) in of.zip(&sums) {
                let [mean, square, _, fourth] = sums.map(|sum| sum / f64::from(DRAWS));
                let rms = square.sqrt();
                let of_mean = (square - mean * mean).sqrt();
                let mean_se = of_mean * (1.0 / f64::from(DRAWS) + 1.0 / TRIALS as f64).sqrt();
                let rms_se = (fourth - square * square).sqrt() / (2.0 * rms)
                    * (1.0 / f64::from(DRAWS) + 1.0 / TRIALS as f64).sqrt();
                let z = [(found.mean - mean) / mean_se, (found.rms - rms) / rms_se];
                let what = format!("{name}, {}, tick {:?}", compensation.name(), estimate.tick);
                assert!(z.iter().all(|z| z.abs() < 5.0), "{what}: {found:?}, not {mean}, {rms}: {z:?}");
                largest = largest.max(z[0].abs()).max(z[1].abs());
            }
        }
    }
    println!("the largest |z| is {largest:.2}");
}

#[test]
fn uncompensated_ticks_have_the_moments_of_the_miss() {
    for inputs in [with(|_| {}), with(|relock| (relock.miss, relock.half_wave_error) = (-0.03, 0.0))] {
        let lowered = lowered(&inputs);
        for (estimate, found) in sampled(&lowered) {
            let compensated = estimate.compensation == Compensation::Detuning
                || estimate.compensation == Compensation::Frequency && estimate.tick != Some(1);
            assert_eq!(estimate.theory.is_none(), compensated);
            let Some((mean, rms)) = estimate.theory else { continue };
            let mean_se = (found.rms * found.rms - found.mean * found.mean).sqrt() / (TRIALS as f64).sqrt();
            let z = [
                (found.mean - mean) / mean_se.hypot(estimate.rounding),
                (found.rms - rms) / found.rms_se.unwrap().hypot(estimate.rounding),
            ];
            assert!(z.iter().all(|z| z.abs() < 5.0), "{estimate:?}: {found:?}, {z:?}");
        }
    }
}

/// What exceeds its bound does not lower.
#[test]
fn words_have_the_closed_forms_of_the_inputs() {
    let exact = clean(|relock| (relock.temperature_error, relock.first_half) = (0.003, FirstHalf::Positive));
    let named = named_relocks().into_iter().map(|(name, _, inputs)| (name, inputs));
    let mut largest = 0.0_f64;
    for (name, inputs) in named.chain([("exact measurements", exact)]) {
        let lowered = lowered(&inputs);
        for estimate in &lowered.estimates {
            assert_eq!(estimate.representation.is_some(), estimate.theory.is_some(), "{name}: {estimate:?}");
            let (Some(found), Some((_, rms))) = (estimate.representation, estimate.theory) else { continue };
            // Half a unit of the initial detuning is below 2^-20 of it and half a unit of f0's error below 2^-35, and a tick's word is
            // within an eighth of an LSB.
            let ticks = if estimate.tick.is_some() { 1.0 } else { f64::from(inputs.relock.ticks) };
            let most = MAX_REPRESENTATION * rms + ticks * lowered.fixed.lsb_arcsec / 8.0;
            assert!(found.abs() * rms <= most, "{name}: {found:e}, {estimate:?}");
            largest = largest.max(found.abs());
        }
    }
    println!("largest representation {largest:.1e}");
    assert!(largest > 0.0);
}

/// Largest relative difference of the closed form of the words from that of the inputs, apart from the words of ticks.
const MAX_REPRESENTATION: f64 = 1e-6;

#[test]
fn exact_measurements_leave_nothing_but_rounding() {
    let mut largest = [0.0_f64; 2];
    for loop_s in [0.0025, 0.0055, 0.012, 0.0315, 0.2] {
        let inputs = clean(|relock| relock.loop_s = loop_s);
        let lowered = lowered(&inputs);
        let whole = sampled(&lowered).iter().map(|(_, found)| found.max).fold(0.0, f64::max);
        for (estimate, found) in sampled(&lowered) {
            match (estimate.compensation, estimate.tick) {
                (Compensation::Detuning, _) => {
                    assert!(found.max <= estimate.rounding, "{loop_s} s, {estimate:?}: {found:?}");
                    largest[0] = largest[0].max(found.max / whole);
                }
                (Compensation::Frequency, Some(2..)) => {
                    largest[1] = largest[1].max(found.max / whole);
                }
                _ => {}
            }
        }
    }
    println!("largest rest by the largest angle: detuning {:.1e}, frequency {:.1e}", largest[0], largest[1]);
    // The slowest loop fakes least beside what a compensation may come to, and so has the coarsest unit.
    assert!(largest.iter().all(|rest| *rest < 5e-5), "{largest:?}");
}

#[test]
fn a_wrong_f0_leaves_its_part_of_the_angle() {
    let inputs = clean(|relock| relock.temperature_error = 0.003);
    let lowered = lowered(&inputs);
    for (estimate, found) in sampled(&lowered) {
        if estimate.compensation != Compensation::Detuning {
            continue;
        }
        let (mean, rms) = estimate.theory.unwrap();
        let z = (found.rms - rms) / found.rms_se.unwrap().hypot(estimate.rounding);
        assert!(mean == 0.0 && z.abs() < 5.0, "{estimate:?}: {found:?}, z = {z}");
    }
}

#[test]
fn another_number_of_ticks_changes_no_tick() {
    let few = lowered(&with(|relock| relock.ticks = 2));
    let many = lowered(&with(|relock| relock.ticks = 8));
    assert_eq!(few.id, many.id);
    for estimate in few.estimates.iter().filter(|estimate| estimate.tick.is_some()) {
        let same = many.estimates.iter().find(|other| other.address.estimate == estimate.address.estimate);
        assert_eq!(same.unwrap().address, estimate.address);
    }
    let all = |lowered: &LoweredRelock| {
        let of = lowered.estimates.iter().filter(|estimate| estimate.tick.is_none());
        of.map(|estimate| estimate.address.estimate).collect::<Vec<_>>()
    };
    assert_ne!(all(&few), all(&many));
}

#[test]
fn relocks_that_make_no_sense_are_refused_by_name() {
    let error = |change: &dyn Fn(&mut Relock)| {
        let point = RelockPoint { swept: vec![], inputs: with(change) };
        LoweredRelock::new(&point, 7, Streams::Independent).unwrap_err()
    };
    let cases: [(&str, Unrepresentable); 9] = [
        ("relock.loop_time", error(&|relock| relock.loop_s = 0.6)),
        ("relock.loop_time", error(&|relock| relock.loop_s = 0.0001)),
        ("relock.curvature", error(&|relock| relock.curvature = 400.0)),
        ("relock.bias_frequency", error(&|relock| relock.bias_frequency_hz = 300.0)),
        ("relock.bias_frequency", error(&|relock| relock.bias_frequency_hz = 1e9)),
        ("relock.adc_step", error(&|relock| relock.adc_step = 1e-11)),
        ("relock.adc_noise", error(&|relock| relock.adc_noise = 1e-11)),
        ("relock.half_wave_error", error(&|relock| relock.half_wave_error = 1e-11)),
        (
            "relock.initial_detuning",
            error(&|relock| {
                (relock.miss, relock.half_wave_error, relock.dac_step, relock.hysteresis) =
                    (0.0, 0.0, 0.0, 0.0);
            }),
        ),
    ];
    for (key, error) in cases {
        assert_eq!(error.key, key, "{error}");
        assert!(error.to_string().contains(key), "{error}");
        assert!(!error.help.is_empty());
    }
}

/// The words of the kernel at the point that identity is checked on; a change of them needs a new version of the kernel.
#[test]
fn the_first_trials_are_golden() {
    let lowered = lowered(&relock());
    let mut sums = vec![];
    for estimate in lowered.estimates.iter().filter(|estimate| estimate.tick.is_none()) {
        let launch = lowered.launch(&[estimate]);
        let trials = sagnac_kernel::moments::Trials { first: 0, count: 4096, histogram: false };
        let tally = launch.tally(Width::PORTABLE, trials).remove(0);
        sums.push((tally.sum, tally.square));
    }
    assert_eq!(sums, GOLDEN);
}

const GOLDEN: [(i128, u128); 3] = [
    (6_704_849_207, 11_513_113_717_739_651),
    (3_945_689_181, 3_985_705_548_455_245),
    (1_057_336, 11_176_969_032_422),
];
