//! Studies of lock-in as they are written: every key that can be swept, motion from a file, limits, and keys of other kinds.

use std::fmt::Write as _;

use sagnac::study::Study;
use sagnac_engine::kinds::{explain_key, explained_keys};

use crate::studies::{parsed, rows, run_afresh};

/// A gyro with every noise, without `[motion]`.
const GYRO: &str = r#"title = "A gyro with lock-in"
kind = "lock-in"
trials = 64
[gyro]
scale_factor = "2 arcsec/pulse"
[lock_in]
threshold = "180 arcsec/s"
beam_noise = "0.0001 deg/sqrt(h)"
[dither]
frequency = "400 Hz"
rate = "30 deg/s"
amplitude_noise = "3 %"
amplitude_walk = "0.01 %"
phase_noise = "0.1 deg"
[input]
rate = "37 arcsec/s"
[record]
sample = "2.5 ms"
length = "1 s"
"#;

const TONE: &str = "[motion]\namplitude = \"1000 arcsec/s\"\nfrequency = \"3 Hz\"\n";

/// Every key that can be swept, with two of its values.
const SWEEPS: [(&str, &str); 15] = [
    ("gyro.scale_factor", r#""2 arcsec/pulse", "2.5 arcsec/pulse""#),
    ("lock_in.threshold", r#""90 arcsec/s", "180 arcsec/s""#),
    ("lock_in.beam_noise", r#""0 deg/sqrt(h)", "0.0002 deg/sqrt(h)""#),
    ("lock_in.refinement", "0.5, 1"),
    ("dither.frequency", r#""270 Hz", "400 Hz""#),
    ("dither.rate", r#""30 deg/s", "60 deg/s""#),
    ("dither.amplitude_noise", r#"0, "3 %""#),
    ("dither.amplitude_walk", r#"0, "0.02 %""#),
    ("dither.phase_noise", r#""0 deg", "0.5 deg""#),
    ("input.rate", r#""0 arcsec/s", "-37 arcsec/s""#),
    ("input.ramp", r#""0 arcsec/s^2", "1 arcsec/s^2""#),
    ("record.sample", r#""2.5 ms", "5 ms""#),
    ("record.length", r#""0.5 s", "1 s""#),
    ("motion.amplitude", r#""1000 arcsec/s", "2000 arcsec/s""#),
    ("motion.frequency", r#""3 Hz", "7 Hz""#),
];

#[test]
fn every_key_that_can_be_swept_runs_and_changes_the_estimates() {
    let is_own =
        |key: &str| explain_key(key).is_some_and(|key| key.kinds.contains(&"lock-in") && key.swept.is_some());
    // Other kinds can sweep more of the motion.
    for key in explained_keys().filter(|key| is_own(key) && !key.starts_with("motion.")) {
        assert!(SWEEPS.iter().any(|(known, _)| *known == key), "{key} is not among the sweeps");
    }
    for (key, values) in SWEEPS {
        let text = format!("{GYRO}{TONE}[[sweep]]\nkey = \"{key}\"\nlist = [{values}]\n");
        let table = run_afresh(&parsed("s.toml", &text));
        let found: Vec<[f64; 2]> = rows(&table)
            .map(|row| ["angle_random_walk", "mean_rate"].map(|column| row.number(column)))
            .collect();
        assert!(
            found.len() == 2 && found.iter().flatten().all(|value| value.is_finite()),
            "{key}: {found:?}"
        );
        assert!(found[0] != found[1], "{key} changes nothing: {found:?}");
        if key == "lock_in.refinement" {
            // The same draws, and so nearly the same walk.
            assert!((found[0][0] / found[1][0] - 1.0).abs() < 1e-3, "{found:?}");
        }
    }
}

#[test]
fn a_recorded_profile_moves_the_gyro_as_the_same_motion_in_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let mut profile = "time [s],rate [arcsec/s]\n".to_owned();
    for k in 0..=1100 {
        let t = f64::from(k) * 1e-3;
        writeln!(profile, "{t},{}", 300.0 + 1000.0 * (std::f64::consts::TAU * 3.0 * t).sin()).unwrap();
    }
    std::fs::write(folder.path().join("base.csv"), profile).unwrap();
    let of_file =
        format!("{GYRO}[motion]\nprofile = {{ file = \"base.csv\", interpolation = \"linear\" }}\n");
    let of_tone = GYRO.replace("37 arcsec/s", "337 arcsec/s") + TONE;
    let name = folder.path().join("study.toml");
    let [by_file, by_tone] = [of_file, of_tone].map(|text| {
        let table = run_afresh(&parsed(name.to_str().unwrap(), &text));
        let row = rows(&table).next().unwrap();
        ["mean_rate", "mean_rate_se", "angle_random_walk", "angle_random_walk_se"]
            .map(|column| row.number(column))
    });
    for at in [0, 2] {
        let z = (by_file[at] - by_tone[at]) / by_file[at + 1].hypot(by_tone[at + 1]);
        assert!(z.abs() < 5.0, "{by_file:?} and {by_tone:?}");
    }
    // The motion has a part in the mean rate that is far beyond its standard error.
    assert!((by_file[0] - 37.0).abs() > 100.0 * by_file[1], "{by_file:?}");
    let short = GYRO.replace("length = \"1 s\"", "length = \"2 s\"");
    let short = parsed(
        name.to_str().unwrap(),
        &format!("{short}[motion]\nprofile = {{ file = \"base.csv\", interpolation = \"linear\" }}\n"),
    );
    let refused = sagnac::run::Plan::new(&short).err().unwrap().render(false, 100);
    assert!(refused.contains("the profile lasts"), "{refused}");
}

#[test]
fn limits_are_in_either_unit_and_keys_of_other_kinds_are_refused_by_name() {
    let chart = |limit: &str| {
        let sweep = "[[sweep]]\nkey = \"dither.rate\"\nlist = [\"30 deg/s\", \"60 deg/s\"]\n";
        let chart = "[[chart]]\nx = \"dither.rate\"\ny = \"angle_random_walk\"\nlimit";
        parsed("s.toml", &format!("{GYRO}{sweep}{chart} = \"{limit}\"\n")).charts[0].limit.unwrap()
    };
    let limits = ["0.003 deg/sqrt(h)", "0.18 arcsec/sqrt(s)"].map(chart);
    assert!((limits[0].value - 0.18).abs() < 1e-12 && limits[0].unit == limits[1].unit, "{limits:?}");
    assert_eq!(limits[0].text(), limits[1].text());
    let refused = |text: String| Study::parse("s.toml", &text).unwrap_err().render(false, 100);
    let noisy = GYRO.replace("[lock_in]", "tick_noise = \"1 arcsec\"\n[lock_in]");
    let said = refused(noisy);
    assert!(said.contains("gyro.tick_noise is not a key of a study of kind = \"lock-in\""), "{said}");
    let said = refused(format!("{GYRO}[drift]\nmagnetic = \"14 arcsec/s\"\n"));
    assert!(said.contains("[drift] is not a table of a study of kind = \"lock-in\""), "{said}");
}

/// A gyro whose lock-in is not small beside f_d q = 200 ″/s, so that zones are shifted and differ from their first order.
const STRONG: &str = r#"title = "Strong lock-in"
kind = "lock-in"
trials = 16
[gyro]
scale_factor = "2 arcsec/pulse"
[lock_in]
threshold = "180 arcsec/s"
[dither]
frequency = "100 Hz"
rate = "200 arcsec/s"
[record]
length = "2 s"
[[sweep]]
key = "input.rate"
linear = { from = "0 arcsec/s", to = "500 arcsec/s", points = 51 }
[[sweep]]
key = "dither.rate"
list = ["200 arcsec/s", "400 arcsec/s"]
"#;

/// Mean output rate of that gyro over 20 s after 2 s, ″/s, by the Runge–Kutta method of fourth order.
fn strong_output(rate: f64, dither: f64) -> f64 {
    use std::f64::consts::TAU;
    let slope = |t: f64, angle: f64| {
        rate + dither * (TAU * 100.0 * t).cos() + 180.0 * (std::f64::consts::PI * angle).sin()
    };
    let (h, settling, steps) = (1e-4, 20_000, 220_000);
    let (mut angle, mut settled) = (0.1, 0.0);
    for k in 0..steps {
        if k == settling {
            settled = angle;
        }
        let t = f64::from(k) * h;
        let a = slope(t, angle);
        let b = slope(t + 0.5 * h, angle + 0.5 * h * a);
        let c = slope(t + 0.5 * h, angle + 0.5 * h * b);
        let d = slope(t + h, angle + h * c);
        angle += h / 6.0 * (a + 2.0 * (b + c) + d);
    }
    (angle - settled) / (f64::from(steps - settling) * h)
}

#[test]
fn a_strong_lock_in_holds_the_output_in_zones_that_an_integrator_finds() {
    let table = run_afresh(&parsed("s.toml", STRONG));
    let (mut locked_elsewhere, mut in_closed_form) = (0, 0);
    for row in rows(&table) {
        let [rate, dither, mean, centre] =
            ["input.rate", "dither.rate", "mean_rate", "zone_centre"].map(|column| row.number(column));
        let exact = strong_output(rate, dither);
        // The phase settles within a beat of 2″ over the 2 s of a record.
        assert!((mean - exact).abs() < 1.0, "{rate}, {dither}: {mean} for {exact}");
        let zone = 200.0 * (exact / 200.0).round();
        // Just outside of a zone, where the output is still near its centre, the mean of a record does not tell.
        let is_locked = (exact - zone).abs() < 0.05;
        if !is_locked && (exact - zone).abs() < 0.15 * (rate - zone).abs() {
            continue;
        }
        let locked = row.maybe("locked");
        match rate == zone {
            true => assert_eq!(locked, None, "{rate}, {dither}"),
            false => assert_eq!(locked, Some(f64::from(u8::from(is_locked))), "{rate}, {dither}: {exact}"),
        }
        if is_locked {
            assert_eq!(centre, zone, "{rate}, {dither}");
            locked_elsewhere += usize::from((rate / 200.0).round() * 200.0 != zone);
        }
        if let Some(closed) = row.maybe("theory_mean_rate") {
            assert!((closed - exact).abs() < 0.05, "{rate}, {dither}: {closed} for {exact}");
            in_closed_form += 1;
        }
    }
    assert!(locked_elsewhere > 4 && in_closed_form > 4, "{locked_elsewhere} and {in_closed_form}");
}
