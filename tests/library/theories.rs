//! What is sampled is right: against closed forms and an independent sampler, and a row once written stays.

use std::collections::BTreeMap;
use std::path::Path;

use crate::reference::polynomial::polynomial;
use crate::studies::{
    ALL_FREQUENCIES, AT_20_HZ, Row, gap_fill, lowered, papers_point, rows, run, run_afresh, study,
};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::run::Plan;
use sagnac::store::{FILE, Store};
use sagnac::study::Study;
use sagnac::table::Table;
use sagnac::theory::gap::polynomial_weights;
use sagnac_engine::filler::Filler;
use sagnac_kernel::gap_fill::Shape;
use sagnac_kernel::normal::REACH;

#[test]
fn every_point_of_the_study_agrees_with_its_closed_form_within_5_standard_errors() {
    let study = study(&[]);
    let folder = tempfile::tempdir().unwrap();
    let table = run(&study, folder.path());
    assert_eq!(rows(&table).count(), 432);
    let mut largest: f64 = 0.0;
    for row in rows(&table) {
        let z = row.number("z");
        assert!(z.abs() < 5.0, "z = {z}: {}", row.place());
        assert_eq!(row.number("trials"), 1e6);
        largest = largest.max(z.abs());
    }
    println!("432 rows, the largest |z| is {largest:.2}");

    let plan = Plan::new(&study).unwrap();
    let store = Store::open(folder.path(), &plan.identity()).unwrap();
    for (index, point) in gap_fill(&study).points.iter().enumerate() {
        let lowered = lowered(&study, point);
        let total = |filler: usize| store.total(&lowered.fillers[filler][0].address).unwrap();
        assert_eq!(gap_fill(&study).fillers[..2], [Filler::polynomial(0), Filler::polynomial(1)]);
        assert_eq!(total(0), total(1), "residuals of const and linear differ at point {index}");
    }
}

#[test]
fn residual_amplitudes_at_the_papers_point_are_those_of_the_theory() {
    let table = run_afresh(&study(&[AT_20_HZ]));
    let sigma = 1.6 / 3.0;
    for row in rows(&table).filter(|row| row.text("error") == "residual") {
        let n = row.number("switching.gap_ticks") as usize;
        let (order, expected) = match row.text("filler").as_str() {
            "quadratic" => (2, [1.435, 8.189, 26.848][n - 1]),
            _ => (0, [26.026, 77.569, 154.511][n - 1]),
        };
        let (found, largest) = (row.number("theory_max"), row.number("max"));
        assert!((found - expected).abs() < 5e-4, "{found} instead of {expected}: {}", row.place());
        let ticks = [-1, 0, n as i32 + 1, n as i32 + 2];
        let gain = polynomial_weights(&ticks, order, n as u32).unwrap().largest_gain();
        let bound = found + REACH * sigma * gain;
        assert!(largest <= bound, "{largest} exceeds {bound}: {}", row.place());
    }
}

/// Weights of a polynomial on `ticks`, which are whole numbers.
fn weights(ticks: &[f64], order: i32, n: i32) -> Vec<f64> {
    polynomial(&ticks.iter().map(|&tick| tick as i32).collect::<Vec<_>>(), order, n)
}

/// A setting of the reference sampler and of the same study.
struct Setting {
    changes: Vec<(&'static str, &'static str)>,
    n: i32,
    /// Phase at the middle of the gap; drawn evenly where there is none.
    phase: Option<f64>,
    sigma: f64,
    fit_ticks: Vec<i32>,
    extrapolation_ticks: Vec<i32>,
}

/// rms and its standard error from the plain formulas: P_j = A_Ω T sinc(νT) sin(2πν(j − ½)T + φ) + σ z.
fn sampled(setting: &Setting, ticks: &[i32], order: i32, trials: usize, rng: &mut StdRng) -> (f64, f64) {
    let (tick_s, frequency, rate) = (0.005, 20.0, 12000.0);
    let turn = 2.0 * std::f64::consts::PI;
    let x = std::f64::consts::PI * frequency * tick_s;
    let amplitude = rate * tick_s * x.sin() / x;
    let places: Vec<f64> = ticks.iter().copied().map(f64::from).collect();
    let weights = weights(&places, order, setting.n);
    let middle = turn * frequency * tick_s * f64::from(setting.n) / 2.0;
    let (mut second, mut fourth) = (0.0, 0.0);
    for _ in 0..trials {
        let phase = setting.phase.map_or_else(|| turn * rng.random::<f64>(), |phase| phase - middle);
        let angle = |j: f64| amplitude * (turn * frequency * (j - 0.5) * tick_s + phase).sin();
        let filled: f64 = places
            .iter()
            .zip(&weights)
            .map(|(&j, w)| {
                let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
                w * (angle(j) + setting.sigma * radius * (turn * rng.random::<f64>()).cos())
            })
            .sum();
        let error = filled - (1..=setting.n).map(|j| angle(f64::from(j))).sum::<f64>();
        second += error * error;
        fourth += error.powi(4);
    }
    let count = trials as f64;
    let (second, fourth) = (second / count, fourth / count);
    (second.sqrt(), ((fourth - second * second) / count / (4.0 * second)).sqrt())
}

#[test]
fn an_independent_sampler_in_floating_point_agrees_within_5_standard_errors() {
    let settings = [
        Setting {
            changes: papers_point("200_000"),
            n: 3,
            phase: None,
            sigma: 1.6 / 3.0,
            fit_ticks: vec![-1, 0, 4, 5],
            extrapolation_ticks: vec![-3, -2, -1, 0],
        },
        Setting {
            changes: [
                &papers_point("200_000")[..],
                &[
                    ("# fit_ticks = [-1, 0, 4, 5] ", "fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"] #"),
                    ("# extrapolation_ticks = [-3, -2, -1, 0]", "extrapolation_ticks = [\"-6..0\"] #"),
                    ("three_sigma = \"1.6 arcsec\"", "angle_random_walk = \"1 deg/sqrt(h)\""),
                ],
            ]
            .concat(),
            n: 3,
            phase: None,
            // 1 °/√h is 60 ″/√s.
            sigma: 60.0 * 0.005_f64.sqrt(),
            fit_ticks: (-7..=0).chain(4..=5).collect(),
            extrapolation_ticks: (-6..=0).collect(),
        },
        Setting {
            changes: vec![
                AT_20_HZ,
                ("list = [1, 2, 3]", "list = [2]"),
                ("1_000_000", "200_000"),
                ("phase = \"uniform\"", "phase = \"extremum\""),
                ("three_sigma = \"1.6 arcsec\"", "std = \"3 arcsec\""),
                ("# fit_ticks = [-1, 0, 4, 5] ", "fit_ticks = [-3, 0, \"n+1\", \"n+2\", \"n+4\"] #"),
            ],
            n: 2,
            phase: Some(std::f64::consts::FRAC_PI_2),
            sigma: 3.0,
            fit_ticks: vec![-3, 0, 3, 4, 6],
            extrapolation_ticks: vec![-3, -2, -1, 0],
        },
    ];
    let mut rng = StdRng::seed_from_u64(20);
    for setting in &settings {
        let table = run_afresh(&study(&setting.changes));
        for row in rows(&table) {
            let order = ["const", "linear", "quadratic"].iter().position(|&name| name == row.text("filler"));
            let ticks = if row.text("error") == "residual" {
                &setting.fit_ticks
            } else {
                &setting.extrapolation_ticks
            };
            let (rms, se) = sampled(setting, ticks, order.unwrap() as i32, 200_000, &mut rng);
            let (found, own_se) = (row.number("rms"), row.number("rms_se"));
            let z = (found - rms) / se.hypot(own_se);
            assert!(z.abs() < 5.0, "rms {found} and {rms}, z = {z}: {}", row.place());
        }
    }
}

#[test]
fn the_reference_weights_are_those_of_the_theories_table() {
    let table: [(i32, i32, [f64; 4]); 4] = [
        (1, 2, [-1.0 / 6.0, 2.0 / 3.0, 2.0 / 3.0, -1.0 / 6.0]),
        (2, 2, [-0.5, 1.5, 1.5, -0.5]),
        (3, 2, [-1.0, 2.5, 2.5, -1.0]),
        (3, 1, [0.75; 4]),
    ];
    for (n, order, expected) in table {
        let n_ = f64::from(n);
        for (w, expected) in weights(&[-1.0, 0.0, n_ + 1.0, n_ + 2.0], order, n).iter().zip(expected) {
            assert!((w - expected).abs() < 1e-12, "n = {n}, order {order}: {w} instead of {expected}");
        }
    }
}

/// Error of a filler for the rate A_Ω sin(2πν(t − middle) + φ), from the angle's change over each tick.
fn error_of_motion(ticks: &[f64], order: i32, n: i32, frequency: f64, phase: f64) -> f64 {
    let (tick_s, rate) = (0.005, 12000.0);
    let turn = 2.0 * std::f64::consts::PI * frequency * tick_s;
    let angle = |time: f64| -rate / (turn / tick_s) * (turn * (time - 0.5 * f64::from(n)) + phase).cos();
    let tick = |j: f64| angle(j) - angle(j - 1.0);
    let filled: f64 = ticks.iter().zip(weights(ticks, order, n)).map(|(&j, w)| w * tick(j)).sum();
    filled - (angle(f64::from(n)) - angle(0.0))
}

/// Values that the closed form of E = a + s·z has at a fixed phase.
struct FixedPhase {
    phase: &'static str,
    sigma: f64,
    frequency: f64,
    n: i32,
}

impl FixedPhase {
    /// a and s of a row.
    fn expected(&self, row: &Row) -> (f64, f64) {
        let order = ["const", "linear", "quadratic"].iter().position(|&name| name == row.text("filler"));
        let (order, n) = (order.unwrap() as i32, f64::from(self.n));
        let residual = row.text("error") == "residual";
        let ticks = if residual { [-1.0, 0.0, n + 1.0, n + 2.0] } else { [-3.0, -2.0, -1.0, 0.0] };
        let phase = if self.phase == "extremum" { std::f64::consts::FRAC_PI_2 } else { 0.0 };
        let gain = weights(&ticks, order, self.n).iter().map(|w| w * w).sum::<f64>().sqrt();
        (error_of_motion(&ticks, order, self.n, self.frequency, phase), self.sigma * gain)
    }
}

/// Calls `check` with every row of studies at fixed phases: below and above the tick rate, where sinc(νT) is negative
/// between 200 and 400 Hz.
fn at_fixed_phases(check: impl Fn(&FixedPhase, &Row)) {
    for phase in ["extremum", "zero-crossing"] {
        for sigma in [0.5, 0.05] {
            let (phase_line, sigma_line) =
                (format!("phase = \"{phase}\""), format!("std = \"{sigma} arcsec\""));
            let table = run_afresh(&study(&[
                (
                    ALL_FREQUENCIES,
                    r#"list = ["3 Hz", "20 Hz", "47 Hz", "130 Hz", "230 Hz", "300 Hz", "450 Hz"]"#,
                ),
                ("list = [1, 2, 3]", "list = [1, 3]"),
                ("1_000_000", "200_000"),
                ("phase = \"uniform\"", &phase_line),
                ("three_sigma = \"1.6 arcsec\"", &sigma_line),
            ]));
            assert_eq!(rows(&table).count(), 7 * 2 * 3 * 2);
            for row in rows(&table) {
                let frequency = row.number("motion.frequency");
                let n = row.number("switching.gap_ticks") as i32;
                check(&FixedPhase { phase, sigma, frequency, n }, &row);
            }
        }
    }
}

#[test]
fn the_mean_at_a_fixed_phase_is_the_error_of_the_motion_with_its_sign() {
    at_fixed_phases(|at, row| {
        let (a, s) = at.expected(row);
        let (mean, trials) = (row.number("mean"), row.number("trials"));
        // The rounding of ticks adds up to less than 1e-3 ″, see the zero crossing without noise.
        let bound = 5.0 * s / trials.sqrt() + 1e-3;
        assert!((mean - a).abs() < bound, "mean {mean}, not {a} ± {bound}, {}: {}", at.phase, row.place());
    });
}

#[test]
fn at_a_fixed_phase_the_rms_and_its_standard_error_are_those_of_the_closed_form() {
    at_fixed_phases(|at, row| {
        let (a, s) = at.expected(row);
        // E = a + s·z: Var(E²) = 4a²s² + 2s⁴.
        let variance = 4.0 * a * a * s * s + 2.0 * s.powi(4);
        let expected = (variance / row.number("trials")).sqrt() / (2.0 * a.hypot(s));
        let (se, z) = (row.number("rms_se"), row.number("z"));
        // 200,000 trials give σ to 0.16 %, and the bins the rest to 0.4 %.
        assert!((se / expected - 1.0).abs() < 0.02, "se {se}, not {expected}, {}: {}", at.phase, row.place());
        assert!(z.abs() < 5.0, "z = {z}, {}: {}", at.phase, row.place());
    });
}

#[test]
fn a_constant_error_has_no_standard_error_left() {
    let table = run_afresh(&study(&[
        AT_20_HZ,
        ("1_000_000", "10_000"),
        ("phase = \"uniform\"", "phase = \"extremum\""),
        ("three_sigma = \"1.6 arcsec\"", "std = \"0 arcsec\""),
    ]));
    for row in rows(&table) {
        assert!(row.number("rms_se") == 0.0 && row.number("z").abs() <= 1.0, "{}", row.place());
    }
}

#[test]
fn an_error_below_the_resolution_is_blank() {
    let changes = [
        AT_20_HZ,
        ("1_000_000", "10_000"),
        ("phase = \"uniform\"", "phase = \"zero-crossing\""),
        ("three_sigma = \"1.6 arcsec\"", "std = \"0 arcsec\""),
    ];
    let study = study(&changes);
    let table = run_afresh(&study);
    let residuals: Vec<Row> = rows(&table).filter(|row| row.text("error") == "residual").collect();
    assert_eq!(residuals.len(), 9);
    let bounds = gap_fill(&study).points.iter().flat_map(|point| {
        let lowered = lowered(&study, point);
        lowered.fillers.into_iter().map(|estimates| estimates[0].theory.rounding)
    });
    // The gap is centred on the zero crossing of the rate, so nothing but rounding is left: nothing at all, or a blank row.
    let mut blank = 0;
    for (row, bound) in residuals.iter().zip(bounds) {
        assert!(row.maybe("rms").is_none_or(|rms| rms == 0.0), "{}", row.place());
        assert!(row.number("theory_rms") < 1e-9 && bound < 1e-3, "rounding of {bound}: {}", row.place());
        let estimates = ["mean", "rms", "rms_se", "max", "p99_73", "z"];
        blank += usize::from(estimates.iter().all(|name| row.maybe(name).is_none()));
    }
    assert!(blank >= 3, "{blank}");
}

/// The largest error in a gap has no closed form.
#[test]
fn errors_in_a_gap_below_the_resolution_are_blank_too() {
    let rms = |noise: &str| {
        let text = format!(
            "title = \"slow\"\nkind = \"gap-fill\"\ntrials = 10_000\n[gyro]\ntick = \"70 ms\"\n\
             tick_noise = {{ std = \"{noise} arcsec\" }}\n[motion]\n\
             gaussian = {{ rms = \"0.00166732 arcsec/s\", band = [\"0.000155 Hz\", \"0.00031 Hz\"] }}\n\
             [switching]\ngap_ticks = 2\nfillers = [\"linear\"]\nerrors = [\"in-gap\"]\n"
        );
        let table = run_afresh(&Study::parse("slow.toml", &text).unwrap());
        rows(&table).map(|row| row.maybe("rms")).collect::<Vec<_>>()
    };
    assert_eq!(rms("0"), [None]);
    assert!(rms("0.001").iter().all(|rms| rms.is_some_and(|rms| rms > 0.001)));
}

type TallyRows = BTreeMap<(Vec<u8>, Vec<u8>, i64, i64), (Vec<u8>, Vec<u8>, i64)>;

/// All rows of the table of tallies, byte for byte.
fn tallies(folder: &Path) -> TallyRows {
    let connection = rusqlite::Connection::open(folder.join(FILE)).unwrap();
    let mut statement =
        connection.prepare("SELECT point, estimate, first, log2, digest, sums, checksum FROM tally").unwrap();
    let rows = statement
        .query_map([], |row| {
            let key = (row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?);
            Ok((key, (row.get(4)?, row.get(5)?, row.get(6)?)))
        })
        .unwrap();
    rows.map(Result::unwrap).collect()
}

fn assert_kept(before: &TallyRows, after: &TallyRows, what: &str) {
    assert!(after.len() > before.len(), "{what}: {} rows, {} before", after.len(), before.len());
    for (key, value) in before {
        assert_eq!(after.get(key), Some(value), "{what}: row {key:?} changed");
    }
}

/// Runs one study and then another in its folder, and the other one alone: no row of the first may change, and the
/// second may not depend on what was there.
fn extend(first: &[(&str, &str)], second: &[(&str, &str)], what: &str) {
    let folder = tempfile::tempdir().unwrap();
    run(&study(first), folder.path());
    let before = tallies(folder.path());
    let extended = run(&study(second), folder.path());
    assert_kept(&before, &tallies(folder.path()), what);
    let alone = run_afresh(&study(second));
    let numbers = |table: &Table| -> Vec<String> { rows(table).map(|row| row.place()).collect() };
    assert_eq!(numbers(&extended), numbers(&alone), "{what}: the table depends on what was there before");
}

const THREE_FILLERS: &str = r#"fillers = ["const", "linear", "quadratic"]"#;

#[test]
fn adding_a_filler_changes_no_tally() {
    let base = papers_point("131_072");
    let with = |fillers| [&base[..], &[(THREE_FILLERS, fillers)]].concat();
    extend(
        &with(r#"fillers = ["linear"]"#),
        &with(r#"fillers = ["quadratic", "linear", "const"]"#),
        "a filler",
    );
}

#[test]
fn adding_a_filler_whose_sums_are_wide_changes_no_tally() {
    let ticks = ("# fit_ticks = [-1, 0, 4, 5] ", "fit_ticks = [\"-9..0\", \"n+1..n+6\"] #");
    let with = |fillers| [&papers_point("131_072")[..], &[ticks, (THREE_FILLERS, fillers)]].concat();
    let (first, second) = (with(r#"fillers = ["const"]"#), with(r#"fillers = ["const", "quadratic"]"#));
    let wide = |changes: &[(&str, &str)]| {
        let study = study(changes);
        let lowered = lowered(&study, &gap_fill(&study).points[0]);
        let launch = lowered.launch(&(0..gap_fill(&study).fillers.len()).collect::<Vec<_>>());
        launch.shape::<Shape>().is_some_and(|shape| shape.wide)
    };
    assert_eq!((wide(&first), wide(&second)), (false, true));
    extend(&first, &second, "a wide filler");
}

#[test]
fn adding_a_sweep_value_changes_no_tally() {
    let with = |list| vec![(ALL_FREQUENCIES, list), ("1_000_000", "65_536")];
    let two = with(r#"list = ["5 Hz", "20 Hz"]"#);
    extend(&two, &with(r#"list = ["1 Hz", "20 Hz", "7 Hz", "5 Hz"]"#), "a sweep value");
}

#[test]
fn more_trials_change_no_tally() {
    extend(&papers_point("100_003"), &papers_point("1_048_576"), "trials");
    extend(&papers_point("1"), &papers_point("3"), "trials");
}

#[test]
fn another_seed_gives_other_draws() {
    let rms = |seed| {
        let changes = [&papers_point("65_536")[..], &[("seed = 1", seed)]].concat();
        rows(&run_afresh(&study(&changes))).map(|row| row.text("rms")).collect::<Vec<_>>()
    };
    assert!(rms("seed = 1").iter().zip(rms("seed = 2")).all(|(one, other)| *one != other));
}
