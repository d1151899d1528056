//! Studies of navigation: weights against an independent simulation, sampled errors against closed forms, and refusals.

use std::f64::consts::PI;
use std::path::Path;

use sagnac::device::{Cpu, Work};
use sagnac::study::Study;
use sagnac::theory::allan::Term;
use sagnac::theory::navigation::{
    self, ARCSEC, EARTH_RATE, Error, GRAVITY, Leg, RADIUS, Task, Times, weights,
};
use sagnac::theory::quantile::Radial;
use sagnac_engine::kinds::navigation::lower::Lowered;
use sagnac_engine::kinds::navigation::verify::{lgk_400, loads, navigator, noise_of, shaped};
use sagnac_engine::kinds::navigation::{Noise, Solution, Switching};
use sagnac_kernel::width::Width;

use crate::devices::{adapters, is_turn, name, open, variants};

/// The rows of a file that `tests/data/navigation/simulate.py` wrote: the texts of the first columns, then the numbers.
fn rows(file: &str, texts: usize) -> Vec<(Vec<String>, Vec<f64>)> {
    let path = Path::new(crate::ROOT).join("tests/data/navigation").join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers = cells[texts..].iter().map(|cell| cell.parse().unwrap()).collect();
        (cells[..texts].iter().map(|cell| (*cell).to_owned()).collect(), numbers)
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn weights_give_the_errors_of_the_full_equations_to_a_ten_thousandth() {
    const SAMPLE: f64 = 2.0;
    let rows = rows("responses.csv", 5);
    assert_eq!(rows.len(), 18);
    for (start, numbers) in rows {
        let [latitude, speed, course, duration] = [0, 1, 2, 3].map(|at| start[at].parse::<f64>().unwrap());
        let gyro = ["north", "east", "down"].iter().position(|name| *name == start[4]).unwrap();
        let [a, b, c, f] = [0, 1, 2, 3].map(|at| numbers[at]);
        let course = course * PI / 180.0;
        let leg = Leg {
            earth_rate: EARTH_RATE,
            latitude: latitude * PI / 180.0,
            velocity: [speed * course.cos(), speed * course.sin()],
        };
        let samples = (duration / SAMPLE) as usize;
        let times = Times { sample_s: SAMPLE, alignment: 0, duration: samples, calibrates: false };
        let weights = &weights(&Task::Inertial(leg), &times)[gyro].of_errors;
        // 1 deg/h is 1 arcsec/s.
        let angle = |t: f64| {
            let sine = if f > 0.0 { c * (1.0 - (2.0 * PI * f * t).cos()) / (2.0 * PI * f) } else { 0.0 };
            a * t + b / 3600.0 * t * t / 2.0 + sine
        };
        let increment = |k: usize| angle((k + 1) as f64 * SAMPLE) - angle(k as f64 * SAMPLE);
        let found: Vec<f64> = weights
            .iter()
            .map(|weights| weights.iter().enumerate().map(|(k, weight)| weight * increment(k)).sum())
            .collect();
        let expected = &numbers[4..];
        // Small components are compared with the whole of their kind.
        for (kind, errors) in [("heading", 0..1), ("tilt", 1..3), ("velocity", 3..5), ("position", 5..7)] {
            let off = errors.clone().map(|e| found[e] - expected[e]).fold(0.0, f64::hypot);
            let size = errors.map(|e| expected[e]).fold(0.0, f64::hypot);
            assert!(off < 1e-4 * size, "{start:?}, {kind}: off by {off} of {size}");
        }
    }
}

fn rms(of: &Radial) -> f64 {
    of.mean_square().sqrt()
}

#[test]
fn closed_forms_are_the_rms_of_an_independent_simulation() {
    let rows = rows("noise.csv", 1);
    assert_eq!(rows.len(), 6);
    let mut largest = 0.0_f64;
    for (noise, numbers) in rows {
        let [size, shape, duration] = [0, 1, 2].map(|at| numbers[at]);
        let term = match noise[0].as_str() {
            "angle_random_walk" => Term::AngleRandomWalk,
            "rate_random_walk" => Term::RateRandomWalk,
            "markov" => Term::Markov,
            other => panic!("{other}"),
        };
        let noise = if shape > 0.0 { shaped(term, size, shape) } else { noise_of(&[(term, size)]) };
        let lowered = navigator(Solution::Inertial, noise, duration);
        for (error, found) in numbers[3..].chunks_exact(2).enumerate() {
            let z = (found[0] - rms(&lowered.distributions(&[error])[0])) / found[1];
            largest = largest.max(z.abs());
            assert!(z.abs() < 5.0, "{term:?}, {duration} s, error {error}: {z} standard errors");
        }
    }
    println!("largest deviation of 42: {largest:.2} standard errors");
}

/// wᵀCw of white noise with weights of one functional.
fn white(weights: &[f64], n: f64, sample_s: f64) -> f64 {
    let noise = navigation::Noise { white: n * sample_s.sqrt(), ..navigation::Noise::default() };
    noise.covariance(weights, weights)
}

#[test]
fn white_noise_has_the_variances_of_theory() {
    let (n, sample_s) = (0.0288, 1.0);
    let at_rest = Leg { earth_rate: 0.0, latitude: 0.8, velocity: [0.0; 2] };
    let omega = (GRAVITY / RADIUS).sqrt();
    for duration in [600, 3600, 5064, 20_000] {
        let times = Times { sample_s, alignment: 0, duration, calibrates: false };
        let t = duration as f64;
        let found = weights(&Task::Inertial(at_rest), &times);
        let (sine, double) = ((omega * t).sin() / omega, (2.0 * omega * t).sin() / (4.0 * omega));
        let position = (RADIUS * n * ARCSEC).powi(2) * (1.5 * t - 2.0 * sine + double);
        for (gyro, error) in [(0, 6), (1, 5)] {
            let variance = white(&found[gyro].of_errors[error], n, sample_s);
            assert!(
                (variance / position - 1.0).abs() < 1e-5,
                "position after {t} s: {variance}, not {position}"
            );
        }
        let heading = white(&weights(&Task::Heading, &times)[0].of_errors[0], n, sample_s);
        assert!((heading / (n * n * t) - 1.0).abs() < 1e-12);
    }
    let task = Task::Gyrocompass { earth_rate: EARTH_RATE, latitude: PI / 3.0 };
    let times = Times { sample_s, alignment: 600, duration: 0, calibrates: false };
    let found = white(&weights(&task, &times)[0].of_errors[0], n, sample_s).sqrt();
    let expected = n / (600_f64.sqrt() * EARTH_RATE * (PI / 3.0).cos());
    assert!((found / expected - 1.0).abs() < 1e-12);
    assert!((found - 32.0).abs() < 0.5, "LGV-1, 10 min, 60°: {found}");
}

/// Mean squares, m², of the error of the fix of an aircraft, along its track and across it, whose gyros alone give its
/// place because the vertical is known; the drift of each gyro is a Markov process.
///
/// These are the premises of arXiv:2202.09360 (Wheeler, Chamoun, Dangui, Digonnet) as its abstract states them. The gyro
/// across the track moves the fix along it by R per unit of angle; a rate error of the other two turns with the aircraft by
/// ω = V/R on the way to the fix, so that the fix moves across the track by R cos ωu or R sin ωu, u later.
fn fix_of_known_vertical(sigma: f64, correlation_s: f64, speed: f64, t: f64) -> [f64; 2] {
    let scale = 2.0 * (RADIUS * sigma * ARCSEC).powi(2);
    // ∫∫ cos ω(s − s′) e^(−|s − s′|/τ) is twice the real part of t/a − (1 − e^(−at))/a² with a = 1/τ − iω.
    [0.0, speed / RADIUS].map(|omega| {
        let (re, im) = (1.0 / correlation_s, -omega);
        let size = re * re + im * im;
        let decay = (-re * t).exp();
        let (one_re, one_im) = (1.0 - decay * (im * t).cos(), decay * (im * t).sin());
        let (square_re, square_im) = (re * re - im * im, 2.0 * re * im);
        let quotient = (one_re * square_re + one_im * square_im) / (size * size);
        scale * (t * re / size - quotient)
    })
}

/// A Schuler-tuned navigator swings about the fix of one that knows the vertical. Over whole Schuler periods the swings of a
/// drift that outlives them cancel, and those of white noise add half of its variance.
#[test]
fn long_flights_have_the_fix_of_gyros_that_know_the_vertical() {
    const SAMPLE: f64 = 10.0;
    const SPEED: f64 = 250.0;
    // 0.01 deg/h and 0.001 deg/√h, in ″/s and ″/√s.
    let (drift, white) = (0.01, 0.06);
    let schuler = 2.0 * PI * (RADIUS / GRAVITY).sqrt();
    // A great circle: east along the equator of an Earth that does not turn.
    let leg = Leg { earth_rate: 0.0, latitude: 0.0, velocity: [0.0, SPEED] };
    for (periods, correlation_s) in [(7, 36_000.0), (7, 360_000.0), (10, 72_000.0)] {
        let duration = (f64::from(periods) * schuler / SAMPLE).round() as usize;
        let t = duration as f64 * SAMPLE;
        let times = Times { sample_s: SAMPLE, alignment: 0, duration, calibrates: false };
        let gyros = weights(&Task::Inertial(leg), &times);
        let variance = |noise: &navigation::Noise, error: usize| {
            let of = |gyro: &Vec<f64>| noise.covariance(gyro, gyro);
            gyros.iter().map(|gyro| of(&gyro.of_errors[error])).sum::<f64>()
        };
        let markov = Some([drift * SAMPLE, SAMPLE / correlation_s]);
        let markov = navigation::Noise { markov, ..navigation::Noise::default() };
        let noise = navigation::Noise { white: white * SAMPLE.sqrt(), ..navigation::Noise::default() };
        let of_markov = fix_of_known_vertical(drift, correlation_s, SPEED, t);
        let of_white = (RADIUS * white * ARCSEC).powi(2) * t;
        let [along, across] = [Error::PositionEast, Error::PositionNorth]
            .map(|error| Task::Inertial(leg).errors().iter().position(|other| *other == error).unwrap());
        // Across the track the turning of the aircraft, 3 % of the Schuler frequency, adds to the swings.
        for (error, expected, room) in [(along, of_markov[0], 1e-3), (across, of_markov[1], 5e-3)] {
            let ratio = (variance(&markov, error) / expected).sqrt();
            assert!((ratio - 1.0).abs() < 3e-3, "drift, {t} s, error {error}: {ratio} of the closed form");
            let ratio = variance(&noise, error) / of_white;
            assert!((ratio - 1.5).abs() < room, "white noise, {t} s, error {error}: {ratio}, not 3/2");
        }
        // The angle about the axis across the track needs no vertical, so there is nothing to swing.
        let angle = &weights(&Task::Heading, &times)[0].of_errors[0];
        let metres = (RADIUS * ARCSEC).powi(2);
        let ratio = metres * markov.covariance(angle, angle) / of_markov[0];
        assert!((ratio - 1.0).abs() < 1e-6, "angle, {t} s: {ratio} of the closed form");
        assert!((metres * noise.covariance(angle, angle) / of_white - 1.0).abs() < 1e-12);
    }
    // With the drift that is often cited for RNP 10, which allows 10 nmi, 95 % of the flights of 10 h stay within
    // 1.96·60.04 nmi/deg·0.01 deg/h·10 h·√(2/e) along the track.
    let [along, across] =
        fix_of_known_vertical(drift, 36_000.0, SPEED, 36_000.0).map(|square| 1.96 * square.sqrt() / 1852.0);
    assert!((along - 10.09).abs() < 0.01 && (across - 9.47).abs() < 0.01, "{along} and {across} nmi");
}

/// Mean and root mean square of each error over some sampled navigators, with their standard errors.
fn sampled(lowered: &Lowered, trials: usize) -> Vec<[f64; 4]> {
    let cpu = Cpu::new(Width::widest(), 0).unwrap();
    let width = lowered.errors.len();
    let mut all = vec![0.0; trials * width];
    for gyro in &lowered.gyros {
        let sums = cpu.sums(&gyro.navigation, 7, trials, &|_| {});
        for (to, sums) in all.chunks_exact_mut(width).zip(sums.chunks_exact(width)) {
            to.iter_mut().zip(gyro.errors(sums)).for_each(|(to, error)| *to += error);
        }
    }
    let n = trials as f64;
    let of = |error: usize| {
        let values = || all.iter().skip(error).step_by(width);
        let mean = values().sum::<f64>() / n;
        let second = values().map(|x| x * x).sum::<f64>() / n;
        let fourth = values().map(|x| (x * x - second).powi(2)).sum::<f64>() / n;
        let rms = second.sqrt();
        [mean, ((second - mean * mean).max(0.0) / n).sqrt(), rms, (fourth / n).sqrt() / (2.0 * rms)]
    };
    (0..width).map(of).collect()
}

#[test]
fn sampled_errors_have_the_means_and_the_rms_of_their_closed_forms() {
    let white = [(Term::AngleRandomWalk, 0.0288)];
    let switching = Switching {
        interval_s: 40.0,
        magnetic: 14.0,
        warm_up_s: Some(300.0),
        initial_magnetic: 0.1,
        residual: 5.0,
        residual_noise: 1.0,
    };
    let mut switched = noise_of(&white);
    switched.switching = Some(switching);
    let table: Vec<(&str, Noise)> = vec![
        ("white", noise_of(&white)),
        ("quantization", noise_of(&[(Term::Quantization, 0.24)])),
        ("flicker", noise_of(&[(Term::BiasInstability, 0.00164)])),
        ("walk", noise_of(&[(Term::RateRandomWalk, 2e-5)])),
        ("Markov", shaped(Term::Markov, 0.002, 300.0)),
        ("sine", shaped(Term::Sine, 0.01, 0.001_3)),
        ("ramp beside white", noise_of(&[white[0], (Term::RateRamp, 1e-6)])),
        ("switches beside white", switched),
        ("LGK-400", lgk_400()),
    ];
    let mut largest = 0.0_f64;
    for (name, noise) in table {
        for solution in Solution::ALL {
            let lowered = navigator(solution, noise.clone(), 900.0);
            for (error, [mean, mean_se, rms_found, rms_se]) in sampled(&lowered, 2000).into_iter().enumerate()
            {
                let closed = lowered.distributions(&[error])[0];
                let room = lowered.rounding(error);
                let off = (mean - closed.mean[0]).abs() - room;
                assert!(
                    off < 5.0 * mean_se,
                    "{name}, {solution:?}, mean of error {error}: {off} of {mean_se}"
                );
                let off = (rms_found - rms(&closed)).abs() - room;
                largest = largest.max(off / rms_se);
                assert!(off < 5.0 * rms_se, "{name}, {solution:?}, rms of error {error}: {off} of {rms_se}");
            }
        }
    }
    println!("largest deviation of an rms: {largest:.2} standard errors");
}

/// More than the lanes of any width, and not a multiple of them.
const COUNT: usize = 37;

#[test]
fn navigators_are_the_same_in_every_width_and_shader() {
    let all = loads();
    assert!(all.len() == 4 && all.iter().all(|load| load.kernel() == "navigation"));
    for (place, load) in all.iter().enumerate() {
        let Work::Records(records) = &load.work else { panic!("{} makes no records", load.name) };
        let first = (1 << 32) - 20;
        let reference =
            [records.sums(Width::PORTABLE, first, 20), records.sums(Width::PORTABLE, first + 20, COUNT - 20)]
                .concat();
        assert_eq!(reference.len(), COUNT * records.values());
        for width in Width::available() {
            for threads in [1, 3] {
                let found = Cpu::new(width, threads).unwrap().sums(&**records, first, COUNT, &|_| {});
                assert!(found == reference, "{}: {}, {threads} threads", load.name, width.name());
            }
        }
        for adapter in adapters() {
            for variant in variants(&adapter).into_iter().filter(|variant| is_turn(*variant, place)) {
                let found = open(&adapter, variant).sums(&**records, first, COUNT, &|_| {}).unwrap();
                assert!(found == reference, "{}: {}", load.name, name(&adapter, variant));
            }
        }
    }
}

const BASE: &str = "title = \"T\"\nkind = \"navigation\"\n[navigation]\nduration = \"1 h\"\nlatitude = \"60 deg\"\n\
                    [noise]\nangle_random_walk = \"0.001 deg/sqrt(h)\"\n";

#[test]
fn bad_navigators_are_refused_by_name_with_what_is_accepted() {
    let replaced = |old: &str, new: &str| {
        assert!(BASE.contains(old), "{old}");
        BASE.replace(old, new)
    };
    let latitude = "latitude = \"60 deg\"\n";
    for (text, pieces) in [
        (
            replaced("latitude = \"60 deg\"\n", ""),
            ["a.toml:3", "navigation.latitude", "latitude = \"60 deg\""],
        ),
        (replaced("60 deg", "87 deg"), ["a.toml:5:12", "navigation.latitude", "-85 deg to 85 deg"]),
        (replaced("60 deg", "60 m"), ["a.toml:5:12", "navigation.latitude", "deg (°)"]),
        (
            replaced("1 h\"", "1 h\"\nsolution = \"heading\""),
            ["a.toml:6:12", "navigation.latitude has no effect", "leave it out"],
        ),
        (replaced("1 h\"", "1 h\"\nsolution = \"marine\""), ["a.toml:5:12", "marine", "gyrocompass"]),
        (
            replaced("1 h\"", "1 h\"\ncourse = \"90 deg\""),
            ["a.toml:5:10", "navigation.course has no effect", "speed = \"250 m/s\""],
        ),
        (
            replaced("1 h\"", "1 h\"\ncalibration = true"),
            ["a.toml:5:15", "without navigation.alignment", "10 min"],
        ),
        (
            replaced("1 h\"", "1 h\"\nsample = \"200 s\""),
            ["a.toml:5:10", "navigation.sample", "0.1 ms to 120 s"],
        ),
        (replaced("1 h\"", "100 h\"\nspeed = \"250 m/s\""), ["a.toml:5:9", "near a pole", "88 deg"]),
        (replaced("1 h\"", "1 h\"\ndraws = 8"), ["a.toml:5:9", "nothing to draw", "[[sensitivity]]"]),
        (
            replaced("1 h\"", "1 h\"\ndraws = 8")
                + "[[sensitivity]]\nkey = \"noise.angle_random_walk\"\ninterval = { value = \"0.0004 deg/sqrt(h)\", \
                   low = \"0.0003 deg/sqrt(h)\", high = \"0.0005 deg/sqrt(h)\" }\n",
            ["a.toml:10:7", "of another gyro", "sagnac allan"],
        ),
        (
            replaced("[noise]", "[noise]\nreadout_lsb = \"0.4 arcsec\""),
            ["a.toml:7:15", "noise.readout_lsb", "√12"],
        ),
        (
            replaced("angle_random_walk = \"0.001 deg/sqrt(h)\"\n", ""),
            ["a.toml:6", "[noise] is empty", "angle_random_walk"],
        ),
        (
            replaced("[noise]", "[noise]\nswitching = { interval = \"2 h\", residual = \"1 arcsec\" }"),
            ["a.toml:7", "noise.switching.interval", "within the record"],
        ),
        (format!("limit = \"1 s\"\n{BASE}"), ["a.toml:1:9", "limit", "nmi"]),
        (
            replaced(
                latitude,
                "latitude = \"60 deg\"\n[[sweep]]\nkey = \"navigation.solution\"\nlist = [\"heading\"]\n",
            ),
            ["a.toml:7:7", "cannot be swept", "navigation.duration"],
        ),
    ] {
        let report = match Study::parse("a.toml", &text) {
            Ok(_) => panic!("accepted although {pieces:?} was expected:\n{text}"),
            Err(error) => error.render(false, 400),
        };
        for piece in pieces {
            assert!(report.contains(piece), "`{piece}` is missing in\n{report}");
        }
    }
}
