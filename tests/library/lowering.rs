//! What is lowered fits: sums are exact however large the errors, and what cannot be represented is refused by name.

use crate::studies::{papers_point, rows, run_afresh, study};
use sagnac::device::{Cpu, Job};
use sagnac::run::Plan;
use sagnac::tally::cover;
use sagnac::theory::minimum_variance::Band;
use sagnac_engine::filler::{Filler, Method, Target};
use sagnac_engine::key::Unrepresentable;
use sagnac_engine::kinds::gap_fill::inputs::TickNoise;
use sagnac_engine::kinds::gap_fill::lower::Lowered;
use sagnac_engine::kinds::gap_fill::verify::Configuration;
use sagnac_engine::motion::{Motion, Tone};
use sagnac_kernel::gap_fill::Shape;
use sagnac_kernel::gap_fill::shape::Parameters;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::{LIMIT, Moments};
use sagnac_kernel::normal::normal;
use sagnac_kernel::philox::{Address, Keys, Purpose, schedule};
use sagnac_kernel::sine::{QUARTER_TURN, sine};
use sagnac_kernel::width::Width;
use sagnac_kernel::word::Scalar;

fn keys(key: [u32; 2]) -> Keys {
    schedule(key.map(Scalar)).map(|key| key.map(|word| word.0))
}

/// The errors of a trial in 128 bits, from the parameters and the draws, with no step that could wrap.
fn exact_errors(launch: &Launch, trial: u64) -> Vec<i128> {
    let shape: Shape = launch.shape().expect("of gap filling");
    let p = Parameters::new(launch.words(), shape);
    let signed = |word: u32| i128::from(word as i32);
    let address =
        Address { low: Scalar(trial as u32), high: (trial >> 32) as u32, keys: keys([p.key[0], p.key[1]]) };
    let draw = |purpose, block, lane: usize| address.draw(purpose, block)[lane];
    let phase = p.phase[0].wrapping_add(draw(Purpose::NoiseAfterAndPhase, 0, 2).0 & p.phase_spread[0]);
    let (sin, cos) =
        (signed(sine(Scalar(phase)).0), signed(sine(Scalar(phase.wrapping_add(QUARTER_TURN))).0));
    let angle = |at_sin: u32, at_cos: u32| sin * signed(at_sin) + cos * signed(at_cos) + (1 << 31);
    let noise = |word: Scalar| signed(normal(word).0) * i128::from(p.sigma[0]);
    let truth = angle(p.gap_sin[0], 0) >> 32;
    let before: Vec<i128> = (0..shape.before)
        .map(|k| {
            angle(p.side_sin[k], p.side_cos[k].wrapping_neg())
                + noise(draw(Purpose::NoiseBefore, k / 4, k % 4))
        })
        .collect();
    let after: Vec<i128> = (0..shape.after)
        .map(|k| angle(p.side_sin[k], p.side_cos[k]) + noise(draw(Purpose::NoiseAfterAndPhase, k / 2, k % 2)))
        .collect();
    for tick in before.iter().chain(&after) {
        assert!(i64::try_from(*tick).is_ok(), "a tick of {tick} wraps");
    }
    let weighted = |ticks: &[&[i128]], weights: &[u32], scale: u32| -> i128 {
        let filled: i128 =
            ticks.concat().iter().zip(weights).map(|(tick, &w)| (tick >> 32) * signed(w)).sum();
        filled - truth * signed(scale)
    };
    let used = shape.residual_before + shape.after;
    let residual = (0..shape.fillers).map(|f| {
        let ticks = [&before[..shape.residual_before], &after[..]];
        weighted(&ticks, &p.residual_weight[f * used..][..used], p.residual_scale[f])
    });
    let used = shape.extrapolation_before;
    let extrapolation = (0..shape.fillers).map(|f| {
        weighted(&[&before[..used]], &p.extrapolation_weight[f * used..][..used], p.extrapolation_scale[f])
    });
    let sums = residual.chain(extrapolation);
    sums.enumerate()
        .map(|(e, sum)| match p.shift.get(e) {
            None => sum,
            Some(&shift) => (sum + ((1 << shift) >> 1)) >> shift,
        })
        .collect()
}

/// A configuration whose errors come near [`LIMIT`], or have large weights.
fn demanding() -> Vec<Configuration> {
    let wide = |c: &mut Configuration| {
        c.fit_ticks = (-9..=0).chain(4..=9).collect();
        c.extrapolation_ticks = vec![-12, -4, 0];
    };
    vec![
        Configuration::new("paper", |_| {}),
        Configuration::new("wide", wide),
        Configuration::new("largest motion and noise that a study accepts", |c| {
            c.inputs.motion = Motion::of_tone(Tone::of_rate(1e9, 20.0));
            c.inputs.tick_noise = TickNoise::Std(1e6);
            wide(c);
        }),
        Configuration::new("noise alone", |c| {
            c.inputs.motion = Motion::of_tone(Tone::of_rate(0.0, 20.0));
            wide(c);
        }),
        Configuration::new("long gap and distant ticks", |c| {
            c.inputs.gap_ticks = 10;
            c.fit_ticks = vec![-60, -1, 0, 11, 12, 70];
            c.extrapolation_ticks = vec![-63, -62, -61];
        }),
        // The largest shift, 26, of 60,000 random lists of ticks.
        Configuration::new("large weights", |c| {
            c.inputs.gap_ticks = 1;
            c.inputs.tick_noise = TickNoise::Std(1e6);
            c.inputs.motion = Motion::of_tone(Tone::of_rate(0.0, 20.0));
            c.fit_ticks = vec![-51, -35, -26, -20, -9, -3];
            c.extrapolation_ticks = vec![-59, -55, -44, -38, -23, -22, -18];
        }),
    ]
}

#[test]
fn sums_are_those_of_128_bits_however_large_the_errors() {
    const TRIALS: u64 = 100_000;
    let mut nearest: f64 = 0.0;
    for configuration in demanding() {
        for launch in configuration.launches() {
            let mut expected = vec![Moments::empty(false); launch.sampled().estimates()];
            for trial in 0..TRIALS {
                for (tally, error) in expected.iter_mut().zip(exact_errors(&launch, trial)) {
                    assert!(
                        error.abs() < i128::from(LIMIT),
                        "{}: {error} is beyond the limit",
                        configuration.name
                    );
                    tally.count += 1;
                    tally.sum += error;
                    tally.square += (error * error) as u128;
                    tally.least = tally.least.min(error as i32);
                    tally.greatest = tally.greatest.max(error as i32);
                    nearest = nearest.max(error.abs() as f64 / LIMIT as f64);
                }
            }
            for width in Width::available() {
                let blocks = cover(0..TRIALS, 12);
                let jobs: Vec<Job> = blocks.iter().map(|&block| Job { launch: &launch, block }).collect();
                let mut found = vec![Moments::empty(false); expected.len()];
                for part in Cpu::new(width, 0).unwrap().tally(&jobs, false, &|_| {}) {
                    found.iter_mut().zip(&part).for_each(|(tally, part)| tally.merge(part));
                }
                assert_eq!(found, expected, "{} in {}", configuration.name, width.name());
            }
        }
    }
    println!("the largest error seen is {nearest:.3} of the limit");
    assert!(nearest > 0.5, "none of the configurations came near the limit: {nearest}");
}

fn lower(configuration: &Configuration) -> Result<Lowered, Unrepresentable> {
    configuration.lower()
}

#[test]
fn noise_that_the_arithmetic_would_lose_is_refused_by_name() {
    let tiny = Configuration::new("tiny noise", |c| c.inputs.tick_noise = TickNoise::Std(1e-9));
    let error = lower(&tiny).unwrap_err();
    assert!(error.to_string().contains("of noise per tick"), "{error}");
    assert!(error.to_string().starts_with(error.key) && error.key == "gyro.tick_noise", "{error}");

    let changes =
        [&papers_point("1")[..], &[("three_sigma = \"1.6 arcsec\"", "std = \"1e-9 arcsec\"")]].concat();
    let study = study(&changes);
    let shown = Plan::new(&study).unwrap_err().render(false, 120);
    assert!(shown.contains("study.toml:9") && shown.contains("gyro.tick_noise"), "{shown}");
}

#[test]
fn noise_below_the_finest_unit_is_not_blamed_on_a_motion_that_is_not_there() {
    let tiny = Configuration::new("tiny noise alone", |c| {
        c.inputs.motion = Motion::of_tone(Tone::of_rate(0.0, 20.0));
        c.inputs.tick_noise = TickNoise::Std(1e-9);
    });
    let shown = lower(&tiny).unwrap_err().to_string();
    assert_eq!(
        shown,
        "gyro.tick_noise: 1e-9″ of noise per tick are too few units of 2^-24″, the finest unit of angle"
    );
}

#[test]
fn motion_that_the_arithmetic_would_lose_is_refused_by_name() {
    let motion = |rate, sigma| {
        Configuration::new("small motion", |c| {
            c.inputs.motion = Motion::of_tone(Tone::of_rate(rate, 20.0));
            c.inputs.tick_noise = TickNoise::Std(sigma);
        })
    };
    for (rate, sigma, cause) in
        [(1e-2, 1.0, "beside motion and noise of up to 6."), (1e-4, 0.0, "2^-24″"), (1e-9, 0.0, "2^-24″")]
    {
        let error = lower(&motion(rate, sigma)).unwrap_err();
        assert!(error.to_string().contains("of motion per tick"), "{rate} ″/s beside {sigma} ″: {error}");
        let shown = error.to_string();
        assert!(shown.starts_with(error.key) && shown.contains(cause), "{shown}");
    }
    for (rate, sigma) in [(10.0, 1.0), (1e-1, 0.0), (0.0, 1.0), (0.0, 0.0)] {
        lower(&motion(rate, sigma)).unwrap_or_else(|error| panic!("{rate} ″/s beside {sigma} ″: {error}"));
    }

    let changes = [&papers_point("1")[..], &[("12000 arcsec/s", "0.01 arcsec/s")]].concat();
    let study = study(&changes);
    let shown = Plan::new(&study).unwrap_err().render(false, 120);
    assert!(shown.contains("study.toml:12") && shown.contains("motion.amplitude"), "{shown}");
}

#[test]
fn no_gap_is_too_long_for_motion_without_noise() {
    for gap_ticks in [1, 16, 48, 64] {
        for k in 1..=200 {
            let frequency_hz = 10.1 * f64::from(k);
            // Two amplitudes to meet a power of two from either side.
            for rate in [12000.0, 17000.0] {
                let long = Configuration::new("long gap", |c| {
                    c.inputs.gap_ticks = gap_ticks;
                    c.inputs.motion = Motion::of_tone(Tone::of_rate(rate, frequency_hz.min(2000.0)));
                    c.inputs.tick_noise = TickNoise::Std(0.0);
                    let n = gap_ticks as i32;
                    c.fit_ticks = vec![-1, 0, n + 1, n + 2];
                });
                lower(&long).unwrap_or_else(|error| panic!("n = {gap_ticks}, {frequency_hz} Hz: {error}"));
            }
        }
    }
}

#[test]
fn a_vibration_of_whole_turns_in_a_tick_leaves_no_motion() {
    let changes = [&papers_point("1")[..], &[("20 Hz\"]", "200 Hz\", \"600 Hz\"]")]].concat();
    for row in rows(&run_afresh(&study(&changes))) {
        assert_eq!(row.number("theory_max"), 0.0, "{}", row.place());
    }
}

#[test]
fn ticks_that_determine_no_polynomial_are_refused_by_name() {
    let singular = Configuration::new("two ticks", |c| c.fit_ticks = vec![0, 4]);
    let error = lower(&singular).unwrap_err();
    let said = error.to_string();
    assert!(said.contains("`quadratic` does not determine its polynomial from ticks [0, 4]"), "{said}");
    assert!(error.to_string().starts_with(error.key), "{error}");
}

#[test]
fn weights_beyond_64_bits_are_refused_by_name() {
    // A study accepts no tick so far off, and none of those it accepts comes near.
    let distant = Configuration::new("distant", |c| {
        c.inputs.gap_ticks = 1;
        c.extrapolation_ticks = vec![-1_000_002, -1_000_001, -1_000_000];
    });
    let error = lower(&distant).unwrap_err();
    assert!(error.to_string().contains("the extrapolation of `quadratic`"), "{error}");
    assert!(error.to_string().starts_with(error.key), "{error}");
}

/// A filler for a band is designed with the rate of the motion, of which ticks of whole turns leave nothing.
#[test]
fn weights_that_only_the_rate_tells_apart_have_tallies_of_their_own() {
    let band = Band { low_hz: 70.0, high_hz: 90.0 };
    let filler = Filler { name: "mv".to_owned(), method: Method::MinimumVariance(Target::Band(band)) };
    let [slow, fast] = [100.0, 12000.0].map(|rate| {
        let configuration = Configuration::new("whole turns", |own| {
            *own.tone() = Tone::of_rate(rate, 400.0);
            own.fillers = vec![filler.clone()];
        });
        configuration.lowered()
    });
    assert_eq!(slow.id, fast.id);
    let [slow, fast] = [slow, fast].map(|lowered| lowered.fillers[0][0].clone());
    assert_ne!(slow.rows, fast.rows);
    assert_ne!(slow.address.estimate, fast.address.estimate);
}
