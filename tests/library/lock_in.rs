//! Lock-in and dither: the same bits everywhere, and the closed forms of theory.

use std::f64::consts::TAU;
use std::sync::Arc;

use sagnac::device::Cpu;
use sagnac::record::Record;
use sagnac::theory::allan::{Estimator, Stride};
use sagnac::theory::lock_in::mean_rate;
use sagnac_engine::kinds::lock_in::lower::Gyros;
use sagnac_engine::kinds::lock_in::verify::{checked, lowered, named_gyros};
use sagnac_engine::kinds::lock_in::{Dither, Inputs, Readout};
use sagnac_engine::motion::keys::{Design, Interpolation, Phase, Position};
use sagnac_engine::motion::{Motion, Profile, Tone};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::lock_in::LockIn;
use sagnac_kernel::shader::Variant;
use sagnac_kernel::width::Width;

use crate::devices::{adapters, open};

const THINNED: Estimator = Estimator { stride: Stride::Part(64), ..Estimator::OVERLAPPING };

/// Gyros: more than the lanes of any pair of words, and not a multiple of them.
const COUNT: usize = 37;

#[test]
fn gyros_are_the_same_in_every_width_and_division() {
    for (name, gyros) in named_gyros() {
        let recipe = gyros.recipe();
        for first in [0, (1 << 32) - 20] {
            let reference = recipe.sums(Width::PORTABLE, first, 20);
            let beyond = recipe.sums(Width::PORTABLE, first + 20, COUNT - 20);
            let reference = [reference, beyond].concat();
            assert_eq!(reference.len(), COUNT * recipe.values(), "{name}");
            for width in Width::available() {
                for threads in [1, 3] {
                    let found = Cpu::new(width, threads).unwrap().sums(recipe, first, COUNT, &|_| {});
                    assert!(found == reference, "{name} from {first}: {}, {threads} threads", width.name());
                }
            }
        }
    }
}

#[test]
fn gyros_are_the_same_in_every_shader() {
    for adapter in adapters() {
        for int64 in [true, false] {
            for (checked, workgroup) in [(true, 64), (false, 32)] {
                if int64 && !adapter.has_int64() {
                    continue;
                }
                let mut gpu = open(&adapter, Variant { int64, checked, workgroup });
                for (name, gyros) in named_gyros() {
                    let (recipe, first) = (gyros.recipe(), (1 << 32) - 20);
                    let reference = cpu().sums(recipe, first, COUNT, &|_| {});
                    let found = gpu.sums(recipe, first, COUNT, &|_| {}).unwrap();
                    assert!(found == reference, "{name}: {}, 64-bit products: {int64}", gpu.name());
                }
            }
        }
    }
}

#[test]
fn a_trace_has_the_angles_of_which_the_sums_are_made() {
    for (name, gyros) in named_gyros() {
        let recipe = gyros.recipe();
        let trace = recipe.trace(7);
        let values = recipe.sums(Width::widest(), 7, 1);
        let third = recipe.third as usize;
        let sum = |angles: &[i32]| angles.iter().map(|&angle| i64::from(angle)).sum::<i64>();
        let thirds = [sum(&trace.angles[..third]), sum(&trace.angles[trace.angles.len() - third..])];
        let found = [2, 1].map(|back| values[values.len() - back] as u64 as i64);
        assert_eq!(found, thirds, "{name}");
    }
}

fn cpu() -> Cpu {
    Cpu::new(Width::widest(), 0).unwrap()
}

/// Mean output rate over the first `count` gyros, ″/s, with its standard error.
fn rate(gyros: &Gyros, count: usize) -> [f64; 2] {
    let values = cpu().sums(gyros.recipe(), 0, count, &|_| {});
    let rates = values.chunks_exact(gyros.recipe().values()).map(|values| gyros.mean_rate(values));
    mean(&rates.collect::<Vec<_>>())
}

/// Angle random walk at the averaging time of 2^`octave` samples of `sample_s`, ″/√s, with its standard error.
fn walk(gyros: &Gyros, count: usize, octave: usize, sample_s: f64) -> [f64; 2] {
    let values = cpu().sums(gyros.recipe(), 0, count, &|_| {});
    let tau_s = sample_s * f64::from(1 << octave);
    let squares =
        values.chunks_exact(gyros.recipe().values()).map(|values| gyros.variances(values)[octave] * tau_s);
    let [square, se] = mean(&squares.collect::<Vec<_>>());
    [square.sqrt(), 0.5 * se / square.sqrt()]
}

fn mean(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0);
    [mean, (variance / count).sqrt()]
}

#[test]
fn without_dither_the_beat_is_a_hyperbola_with_a_dead_band() {
    for ratio in [-3.0, 0.0, 0.5, 0.9, 1.05, 1.2, 2.0, 10.0, 100.0] {
        let inputs = Inputs { dither: None, rate: 180.0 * ratio, ..checked() };
        let [found, _] = rate(&lowered(&inputs, 0, 4000, THINNED), 32);
        let error = (found - mean_rate(inputs.rate, 180.0)) / 180.0;
        assert!(error.abs() < 1e-5, "{ratio} Ω_L: off by {error:e} Ω_L");
    }
}

#[test]
fn zones_have_the_half_widths_of_bessel_functions() {
    let of = |k: i32, theta: f64| {
        let dither = Dither { frequency_hz: 4000.0, rate: theta * 8000.0, ..Dither::default() };
        let inputs = Inputs { threshold: 10.0, dither: Some(dither), ..checked() };
        let gyro = inputs.gyro().unwrap();
        let (centre, width) = (gyro.zone_centre(k), gyro.zone_half_width(k));
        let output = |rate: f64| rate_of(&Inputs { rate, ..inputs.clone() }) - centre;
        let inside = [-0.9, 0.5, 0.9].map(|part| output(centre + part * width) / width);
        assert!(inside.iter().all(|rate| rate.abs() < 1e-3), "zone {k} at {theta} rad: {inside:?} inside");
        let [below, above] = [-1.25, 1.25].map(|part| output(centre + part * width) / width);
        // Other zones shift the centre by about Ω_L²/(f_d q), by which both sides differ in opposite ways.
        let found = (1.25 * 1.25 - (0.5 * (above - below)).powi(2)).sqrt();
        assert!((found - 1.0).abs() < 2e-3, "zone {k} at {theta} rad: half width {found} of Ω_L|J_k(Θ)|");
    };
    let rate_of_all = [
        (0, 1.0),
        (0, 5.0),
        (0, 10.0),
        (1, 1.0),
        (1, 3.0),
        (-1, 5.0),
        (2, 3.0),
        (2, 10.0),
        (3, 5.0),
        (4, 8.0),
    ];
    rate_of_all.into_iter().for_each(|(k, theta)| of(k, theta));
}

/// Mean output rate of some gyros over 80 s.
fn rate_of(inputs: &Inputs) -> f64 {
    rate(&lowered(inputs, 32, 10_000, THINNED), 16)[0]
}

#[test]
fn randomized_dither_leaves_the_angle_random_walk_of_the_closed_form() {
    let with = |threshold: f64, rate: f64, dither_rate: f64, frequency_hz: f64, amplitude_noise: f64| {
        let dither = Dither { frequency_hz, rate: dither_rate, amplitude_noise, ..Dither::default() };
        Inputs { threshold, rate, dither: Some(dither), ..checked() }
    };
    let gyros = [
        with(180.0, 0.0, 360_000.0, 400.0, 0.02),
        with(180.0, 37.0, 360_000.0, 400.0, 0.02),
        with(180.0, 523.0, 360_000.0, 400.0, 0.02),
        with(60.0, 1000.0, 120_000.0, 270.0, 0.02),
        with(400.0, -300.0, 700_000.0, 400.0, 0.005),
    ];
    for inputs in gyros {
        let gyro = inputs.gyro().unwrap();
        let noise = inputs.dither.as_ref().unwrap().amplitude_noise;
        assert_eq!(gyro.failing_premises(noise, inputs.rate), []);
        let gyros = lowered(&inputs, 1, 4096, THINNED);
        let expected = gyro.angle_random_walk();
        for octave in [0, 3, 5] {
            let [found, se] = walk(&gyros, 64, octave, 1.0 / gyro.dither_frequency);
            let z = (found - expected) / se;
            assert!(
                z.abs() < 5.0 && se < 0.01 * found,
                "{inputs:?}, octave {octave}: {found} ± {se}, expected {expected}"
            );
        }
    }
}

#[test]
fn half_and_twice_the_steps_move_no_estimate_by_its_standard_error() {
    let with = |threshold: f64, rate: f64, change: fn(&mut Dither)| {
        let mut inputs = Inputs { threshold, rate, ..checked() };
        inputs.dither.as_mut().into_iter().for_each(change);
        inputs
    };
    let gyros = [
        ("checked", checked(), 128),
        ("no dither", Inputs { dither: None, rate: 250.0, beam_noise: 0.05, ..checked() }, 32),
        ("strong", with(700.0, -523.0, |_| ()), 64),
        (
            "large noise",
            with(20.0, 37.0, |dither| (dither.rate, dither.amplitude_noise) = (24_000.0, 0.1)),
            64,
        ),
        ("phase noise", with(180.0, 37.0, |dither| dither.phase_noise = 7200.0), 64),
        ("between zones", with(180.0, 523.0, |_| ()), 64),
        ("weak noise between zones", with(180.0, 400.0, |dither| dither.amplitude_noise = 0.007), 64),
        ("hardly any noise", with(180.0, 523.0, |dither| dither.amplitude_noise = 0.001), 64),
        (
            "walk",
            with(180.0, 37.0, |dither| (dither.amplitude_noise, dither.amplitude_walk) = (0.005, 0.002)),
            64,
        ),
    ];
    for (name, inputs, count) in gyros {
        let of = |refinement: f64| {
            estimates(&lowered(&Inputs { refinement, ..inputs.clone() }, 1, 2000, THINNED), count)
        };
        let whole = of(1.0);
        for refinement in [0.5, 2.0] {
            let moved: Vec<f64> = of(refinement)
                .iter()
                .zip(&whole)
                .map(|([found, _], [before, se])| (found - before) / se)
                .collect();
            println!("{name}, {refinement}: moved by {moved:.3?} standard errors");
            assert!(moved.iter().all(|moved| moved.abs() < 1.0), "{name}, {refinement}: {moved:?}");
        }
    }
}

/// The variance at each averaging time and the mean output rate of some gyros, each with its standard error.
fn estimates(gyros: &Gyros, count: usize) -> Vec<[f64; 2]> {
    let values = cpu().sums(gyros.recipe(), 0, count, &|_| {});
    let of_gyros: Vec<Vec<f64>> = values
        .chunks_exact(gyros.recipe().values())
        .map(|values| [gyros.variances(values), vec![gyros.mean_rate(values)]].concat())
        .collect();
    (0..of_gyros[0].len()).map(|at| mean(&of_gyros.iter().map(|gyro| gyro[at]).collect::<Vec<_>>())).collect()
}

#[test]
fn at_whole_periods_every_readout_has_the_angle_without_the_dither() {
    let of = |readout: Readout| {
        let mut inputs = checked();
        inputs.dither.as_mut().into_iter().for_each(|dither| {
            (dither.readout, dither.phase_noise, dither.rate) = (readout, 1800.0, 90_000.0)
        });
        lowered(&inputs, 3, 500, THINNED)
    };
    let stripped = of(Readout::Stripped);
    for readout in [Readout::Dithered, Readout::Demodulated] {
        let other = of(readout);
        // The same draws.
        let recipe = LockIn { key: stripped.recipe().key, ..other.recipe().clone() };
        // Only without the dither angles have what the integral has beyond the sum of steps.
        let sums = LockIn { end: 0, ..stripped.recipe().clone() };
        let angles = sums.trace(5).angles.into_iter().zip(recipe.trace(5).angles);
        let [fine, coarse] = [&stripped, &other].map(Gyros::lsb_arcsec);
        let apart = |(a, b): (i32, i32)| (f64::from(a) * fine - f64::from(b) * coarse).abs();
        let most = angles.map(apart).fold(0.0, f64::max);
        assert!(most <= 2.0 * coarse, "{readout:?}: {most} arcsec apart, and the unit is {coarse}");
        assert!(coarse < 1e-3 && stripped.recipe().trace(5).angles.iter().any(|angle| *angle != 0));
    }
}

#[test]
fn a_ramp_of_the_rate_has_the_angle_of_its_integral() {
    // Without lock-in that counts, the output less the input vanishes, and the mean rate is that in the middle of the record.
    let inputs = Inputs { threshold: 1e-3, ramp: 40.0, rate: -100.0, ..checked() };
    let [found, _] = rate(&lowered(&inputs, 1, 2000, THINNED), 16);
    assert!((found - 0.0).abs() < 1e-4, "{found}");
    // In the dead band of a gyro without dither the output stays at zero while the input passes through it.
    let inputs = Inputs { dither: None, ramp: 2.0, rate: -20.0, ..checked() };
    let [found, _] = rate(&lowered(&inputs, 0, 2000, THINNED), 16);
    assert!(found.abs() < 0.02, "{found}");
}

/// What exceeds its bound does not lower.
#[test]
fn words_have_the_closed_form_of_the_inputs() {
    let with = |threshold: f64, beam_noise: f64, dither: Dither| {
        let inputs = Inputs { threshold, beam_noise, dither: Some(dither), ..checked() };
        lowered(&inputs, 3, 2000, THINNED)
    };
    let dither = checked().dither.unwrap();
    let more = [
        ("weak", with(3e-3, 0.0, dither.clone())),
        ("beam", with(180.0, 0.01, dither.clone())),
        ("beam alone", with(0.02, 0.05, dither.clone())),
        ("fast", with(40.0, 0.002, Dither { frequency_hz: 777.0, rate: 300_000.0, ..dither.clone() })),
        ("walk", with(180.0, 0.0, Dither { amplitude_noise: 0.0, amplitude_walk: 0.01, ..dither })),
    ];
    let names = more.clone().map(|(name, _)| name);
    let (mut largest, mut count) = (0.0_f64, 0);
    for (name, gyros) in named_gyros().into_iter().chain(more) {
        let Some(found) = gyros.representation else {
            assert!(!names.contains(&name), "{name}");
            continue;
        };
        println!("{name}: {found:.1e}");
        // At most 3.3e-4 of the threshold with the least units of a step, and half of 2^−12 of the amplitude.
        assert!(found.abs() < 5e-4, "{name}: {found:e}");
        (largest, count) = (largest.max(found.abs()), count + 1);
    }
    assert!(largest > 0.0 && count > names.len(), "{largest:e} at {count} gyros");
}

/// Mean and standard deviation.
fn spread(values: &[f64]) -> [f64; 2] {
    let [mean, se] = mean(values);
    [mean, se * (values.len() as f64).sqrt()]
}

#[test]
fn half_cycles_have_the_noise_of_the_inputs() {
    let drawn = |change: fn(&mut Dither)| {
        let mut inputs = checked();
        // A small dither takes few steps.
        inputs.dither.as_mut().into_iter().for_each(|dither| {
            *dither = Dither { rate: 36_000.0, amplitude_noise: 0.0, ..dither.clone() };
            change(dither);
        });
        let gyros = lowered(&inputs, 1, 2000, THINNED);
        let recipe = gyros.recipe();
        // Amplitudes of the angle in ″, and phases in ″ of the dither's phase.
        let unit = inputs.scale_factor / libm::exp2(f64::from(recipe.amplitude_bits));
        let traces = (0..8).map(|number| recipe.trace(number));
        let of = |trace: sagnac_kernel::lock_in::Trace| {
            let amplitudes = trace.amplitudes.iter().map(|word| f64::from(word.unsigned_abs()) * unit);
            let phases = trace.phases.iter().map(|word| f64::from(*word) / 4_294_967_296.0 * 1_296_000.0);
            (amplitudes.collect::<Vec<_>>(), phases.collect::<Vec<_>>())
        };
        traces.map(of).unzip::<_, _, Vec<_>, Vec<_>>()
    };
    // Ω_D/ω_d.
    let amplitude = 36_000.0 / (TAU * 400.0);
    let near = |what: &str, values: &[f64], [mean, sigma]: [f64; 2]| {
        let [found_mean, found] = spread(values);
        let count = values.len() as f64;
        assert!(count > 30_000.0);
        let z = [(found_mean - mean) / sigma * count.sqrt(), (found / sigma - 1.0) * (2.0 * count).sqrt()];
        assert!(
            z.iter().all(|z| z.abs() < 5.0),
            "{what}: {found_mean} ± {found}, not {mean} ± {sigma}: {z:?}"
        );
    };
    let (amplitudes, _) = drawn(|dither| dither.amplitude_noise = 0.03);
    near("amplitude noise", &amplitudes.concat(), [amplitude, 0.03 * amplitude]);
    let (amplitudes, _) = drawn(|dither| dither.amplitude_walk = 0.001);
    let steps = amplitudes.iter().flat_map(|of| of.windows(2).map(|ends| ends[1] - ends[0]));
    near("amplitude walk", &steps.collect::<Vec<_>>(), [0.0, 0.001 * amplitude]);
    let (amplitudes, phases) = drawn(|dither| dither.phase_noise = 1800.0);
    near("phase noise", &phases.concat(), [0.0, 1800.0]);
    let off = amplitudes.concat().iter().map(|found| (found / amplitude - 1.0).abs()).fold(0.0, f64::max);
    assert!(off < 1e-6, "without noise amplitudes are off by {off:e}");
}

#[test]
fn noise_of_the_beam_alone_has_its_angle_random_walk() {
    let dither = checked().dither.map(|dither| Dither { rate: 36_000.0, ..dither });
    let inputs = Inputs { threshold: 0.02, beam_noise: 0.05, dither, ..checked() };
    let gyros = lowered(&inputs, 1, 4096, THINNED);
    for octave in [0, 3, 5] {
        let [found, se] = walk(&gyros, 64, octave, 0.0025);
        assert!((found - 0.05).abs() < 5.0 * se && se < 5e-4, "octave {octave}: {found} ± {se}");
    }
}

#[test]
fn a_ramp_beyond_the_threshold_has_the_output_of_the_hyperbola() {
    let (rate_0, ramp, threshold) = (200.0, 30.0, 180.0_f64);
    let inputs = Inputs { dither: None, rate: rate_0, ramp, ..checked() };
    let [found, _] = rate(&lowered(&inputs, 0, 2000, THINNED), 16);
    // ∫√(Ω² − Ω_L²) dt up to a sample every 10 ms.
    let angle = |sample: u32| {
        let x = rate_0 + ramp * 0.01 * f64::from(sample);
        let root = (x * x - threshold * threshold).sqrt();
        0.5 * (x * root - threshold * threshold * (x / threshold).acosh()) / ramp
    };
    let mean = |samples: std::ops::RangeInclusive<u32>| samples.map(angle).sum::<f64>() / 667.0;
    let expected = (mean(1334..=2000) - mean(0..=666)) / 13.34;
    assert!((found / expected - 1.0).abs() < 2e-4, "{found}, not {expected}");
}

/// Rate, ″/s, and angle, ″, at a time, s.
type RateAndAngle<'a> = &'a dyn Fn(f64) -> [f64; 2];

/// Ω in ψ̇ = K (Ω + Ω_L sin ψ) is followed by the lock-in, so that ψ rests at π + asin Ω/Ω_L.
#[test]
fn a_locked_gyro_turns_back_by_the_angle_of_its_motion() {
    let (amplitude, omega) = (100.0, TAU * 0.1);
    let tone = |phase: Phase| Motion::of_tone(Tone { phase, ..Tone::of_rate(amplitude, 0.1) });
    let rates = (0..=21_000).map(|i| amplitude * (omega * 0.001 * f64::from(i)).cos());
    let profile = Profile {
        file: "made up".to_owned(),
        record: Arc::new(Record { step_s: 0.001, rates: rates.collect() }),
        position: Position::Every,
        interpolation: Interpolation::Linear,
        design: Design::Whole,
    };
    let profile = Motion { profile: Some(profile), ..Motion::default() };
    let sine = |t: f64| [amplitude * (omega * t).cos(), amplitude / omega * (omega * t).sin()];
    let rise = |t: f64| [amplitude * (omega * t).sin(), amplitude / omega * (1.0 - (omega * t).cos())];
    let motions: [(&str, Motion, RateAndAngle); 4] = [
        ("extremum", tone(Phase::Extremum), &sine),
        ("recorded profile", profile, &sine),
        ("zero crossing", tone(Phase::ZeroCrossing), &rise),
        ("no phase", tone(Phase::Uniform), &rise),
    ];
    for (name, motion, of) in motions {
        let inputs = Inputs { dither: None, rate: 0.0, motion: Some(motion), ..checked() };
        let gyros = lowered(&inputs, 0, 2000, THINNED);
        let rest = |(sample, word): (usize, &i32)| {
            let [rate, angle] = of(0.01 * sample as f64);
            let phase = inputs.scale_factor / TAU * (rate / inputs.threshold).asin();
            f64::from(*word) * gyros.lsb_arcsec() + angle - phase
        };
        let trace = gyros.recipe().trace(3);
        // A gyro needs some milliseconds to lock.
        let rests: Vec<f64> = trace.angles.iter().enumerate().skip(10).map(rest).collect();
        let apart = rests.iter().map(|rest| (rest - rests[0]).abs()).fold(0.0, f64::max);
        assert!(apart < 0.01, "{name}: {apart} arcsec apart, of {}", amplitude / omega);
        // The mean input rate is that of the words.
        let [found, _] = rate(&gyros, 16);
        assert!(found.abs() < 0.03, "{name}: {found}");
    }
}
