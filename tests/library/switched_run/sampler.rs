//! Runs against a gyro in floating point that is stepped from switch to switch with other random numbers.

use std::f64::consts::TAU;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::texts::{DRIFT, numbers, study};

/// A standard normal number by Box and Muller.
fn normal(rng: &mut StdRng) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// |Angle| at the end and the largest of one run of about `t`; its end is anywhere in a cycle of two intervals unless it
/// is exact.
fn one_run(rng: &mut StdRng, interval: f64, about: f64, random_mode: bool, exact: bool) -> [f64; 2] {
    let t = if exact { about } else { about + interval * (2.0 * rng.random::<f64>() - 1.0) };
    let a = 14.0 + normal(rng);
    let nm = 0.05 + 0.01 * normal(rng);
    let mut sign = if random_mode && rng.random::<bool>() { -1.0 } else { 1.0 };
    let (mut angle, mut largest, mut from) = (0.0_f64, 0.0_f64, 0.0_f64);
    loop {
        let to = (from + interval).min(t);
        let warm = (to - from) - 3000.0 * ((-from / 3000.0_f64).exp() - (-to / 3000.0_f64).exp());
        let walk = 1.8 * (to - from).sqrt() * normal(rng);
        angle += sign * a * warm + nm * (to - from) + walk;
        if to >= t {
            // The non-magnetic drift acts for exactly the run time.
            angle += nm * (about - t);
            return [angle.abs(), largest.max(angle.abs())];
        }
        largest = largest.max(angle.abs());
        angle += 10.0 * (TAU * rng.random::<f64>()).sin();
        largest = largest.max(angle.abs());
        (sign, from) = (-sign, to);
    }
}

#[test]
fn the_largest_angle_and_the_levels_agree_with_an_independent_sampler() {
    let runs = 200_000;
    for (interval, t, mode, end) in [
        (40.0, 600.0, "positive", "exact"),
        (13.0, 300.0, "random", "exact"),
        (100.0, 777.0, "positive", "exact"),
        (40.0, 600.0, "positive", "any"),
        (47.0, 600.0, "random", "any"),
        (150.0, 400.0, "positive", "any"),
    ] {
        let drift = format!(
            "{DRIFT}magnetic_spread = \"1 arcsec/s\"\nnon_magnetic_spread = \"0.01 arcsec/s\"\n\
             angle_random_walk = \"0.03 deg/sqrt(h)\"\nresidual_max = \"10 arcsec\"\n"
        );
        let switching = format!("interval = \"{interval} s\"\nfirst_mode = \"{mode}\"\n");
        let rows = numbers(&study(
            runs,
            &drift,
            &switching,
            &format!("duration = \"{t} s\"\nend = \"{end}\"\n"),
            "",
        ));
        let mut rng = StdRng::seed_from_u64(5);
        let mut samples = [vec![], vec![]];
        for _ in 0..runs {
            let found = one_run(&mut rng, interval, t, mode == "random", end == "exact");
            samples.iter_mut().zip(found).for_each(|(to, angle)| to.push(angle));
        }
        for (row, sample) in rows.iter().zip(&mut samples) {
            let n = sample.len() as f64;
            let square = sample.iter().map(|x| x * x).sum::<f64>() / n;
            let fourth = sample.iter().map(|x| x.powi(4)).sum::<f64>() / n;
            let (rms, se) = (square.sqrt(), ((fourth - square * square) / n).sqrt() / (2.0 * square.sqrt()));
            let z = (row["rms"] - rms) / row["rms_se"].hypot(se);
            assert!(z.abs() < 5.0, "{interval} s: rms {} ″, not {rms} ″, z = {z}", row["rms"]);
            sample.sort_by(f64::total_cmp);
            // Order statistics five standard errors to either side.
            let spread = 5.0 * (n * 0.9973 * 0.0027).sqrt() * 2.0_f64.sqrt();
            let [low, high] =
                [-spread, spread].map(|by| sample[((n * 0.9973 + by) as usize).min(sample.len() - 1)]);
            let level = row["p99_73"];
            assert!(
                (low * 0.992..=high * 1.008).contains(&level),
                "{interval} s: {level} ″, not {low} to {high} ″"
            );
        }
    }
}
