//! What is sampled is right: against closed forms, an independent sampler and exact sums, and a row once written stays.

use std::collections::BTreeMap;
use std::path::Path;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::backend::cpu::{Cpu, Width};
use sagnac::backend::{Device, Job};
use sagnac::block::cover;
use sagnac::kernel::gap_fill::{Launch, Parameters};
use sagnac::kernel::moments::{LIMIT, Moments};
use sagnac::kernel::normal::{REACH, normal};
use sagnac::kernel::philox::{Address, Keys, Purpose, schedule};
use sagnac::kernel::sine::{QUARTER_TURN, sine};
use sagnac::kernel::word::Scalar;
use sagnac::lower::{LowerError, Lowered};
use sagnac::run::{Plan, Progress};
use sagnac::store::{FILE, Store};
use sagnac::study::{Amplitude, Filler, Streams, Study, TickNoise};
use sagnac::table::{Cell, Table};
use sagnac::theory::gap::polynomial_weights;
use sagnac::verify::Configuration;

struct Silent;

impl Progress for Silent {
    fn start(&self, _: u64, _: u64) {}
    fn advance(&self, _: u64) {}
    fn finish(&self) {}
}

fn committed() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/error_vs_dtnu.toml");
    std::fs::read_to_string(path).unwrap()
}

/// The committed study with some of its text replaced; each piece must be there.
fn study(changes: &[(&str, &str)]) -> Study {
    let mut text = committed();
    for (from, to) in changes {
        assert!(text.contains(from), "`{from}` is not in the study");
        text = text.replace(from, to);
    }
    Study::parse("study.toml", &text).unwrap_or_else(|error| panic!("{}", error.render(false, 100)))
}

const ALL_FREQUENCIES: &str = r#"log = { from = "2 Hz", to = "40 Hz", points = 24 }"#;
const AT_20_HZ: (&str, &str) = (ALL_FREQUENCIES, r#"list = ["20 Hz"]"#);

/// The paper's point at n = 3 alone.
fn papers_point(trials: &'static str) -> Vec<(&'static str, &'static str)> {
    vec![AT_20_HZ, ("list = [1, 2, 3]", "list = [3]"), ("1_000_000", trials)]
}

fn run(study: &Study, folder: &Path) -> Table {
    let plan = Plan::new(study).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
    let mut store = Store::open(folder, &plan.identity()).unwrap();
    let mut device = Device::Cpu(Cpu::new(Width::widest(), 0).unwrap());
    plan.run(&mut store, &mut device, &Silent).unwrap();
    plan.table(&store).unwrap()
}

fn run_afresh(study: &Study) -> Table {
    run(study, tempfile::tempdir().unwrap().path())
}

/// One row by the names of its columns.
struct Row<'a> {
    table: &'a Table,
    index: usize,
}

impl Row<'_> {
    fn cell(&self, name: &str) -> &Cell {
        let column = self.table.columns.iter().find(|column| column.name == name);
        &column.unwrap_or_else(|| panic!("no column {name}")).cells[self.index]
    }

    fn number(&self, name: &str) -> f64 {
        self.cell(name).number().unwrap_or_else(|| panic!("{name} is blank in {}", self.place()))
    }

    fn text(&self, name: &str) -> String {
        self.cell(name).text()
    }

    fn place(&self) -> String {
        let cells = self
            .table
            .columns
            .iter()
            .map(|column| format!("{} {}", column.name, column.cells[self.index].text()));
        cells.collect::<Vec<_>>().join(", ")
    }
}

fn rows(table: &Table) -> impl Iterator<Item = Row<'_>> {
    (0..table.columns[0].cells.len()).map(move |index| Row { table, index })
}

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
    for point in study.points() {
        let lowered = Lowered::new(point, &study.fillers, study.seed, study.streams).unwrap();
        let total = |filler: usize| store.total(&lowered.fillers[filler][0].address).unwrap();
        assert_eq!(study.fillers[..2], [Filler::Const, Filler::Linear]);
        assert_eq!(total(0), total(1), "residuals of const and linear differ at point {}", point.index);
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
        let (found, largest) = (row.number("oracle_max"), row.number("max"));
        assert!((found - expected).abs() < 5e-4, "{found} instead of {expected}: {}", row.place());
        let ticks = [-1, 0, n as i32 + 1, n as i32 + 2];
        let gain = polynomial_weights(&ticks, order, n as u32).unwrap().largest_gain();
        let bound = found + REACH * sigma * gain;
        assert!(largest <= bound, "{largest} exceeds {bound}: {}", row.place());
    }
}

/// Weights of the least-squares polynomial by Gram and Schmidt on the ticks: none of the program's arithmetic.
fn weights(ticks: &[f64], order: i32, n: i32) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let places: Vec<f64> = ticks.iter().copied().chain((1..=n).map(f64::from)).collect();
    let fitted = ticks.len();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for power in 0..=order {
        let mut own: Vec<f64> = places.iter().map(|x| x.powi(power)).collect();
        for other in &basis {
            let along = dot(&own[..fitted], &other[..fitted]);
            own.iter_mut().zip(other).for_each(|(own, other)| *own -= along * other);
        }
        let length = dot(&own[..fitted], &own[..fitted]).sqrt();
        own.iter_mut().for_each(|x| *x /= length);
        basis.push(own);
    }
    (0..fitted).map(|k| basis.iter().map(|q| q[k] * q[fitted..].iter().sum::<f64>()).sum()).collect()
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
fn the_reference_weights_are_those_of_the_theorys_table() {
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
fn a_gap_centred_on_the_zero_crossing_without_noise_leaves_only_rounding() {
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
    let bounds = study.points().iter().flat_map(|point| {
        let lowered = Lowered::new(point, &study.fillers, study.seed, study.streams).unwrap();
        lowered.fillers.into_iter().map(|[residual, _]| residual.oracle.rounding)
    });
    for (row, bound) in residuals.iter().zip(bounds) {
        let rms = row.number("rms");
        assert!(rms <= bound && bound < 1e-3, "rms {rms}, rounding at most {bound}: {}", row.place());
    }
}

type TallyRows = BTreeMap<(Vec<u8>, Vec<u8>, i64, i64), (Vec<u8>, Vec<u8>, i64)>;

/// All rows of the table of tallies, byte for byte.
fn tallies(folder: &Path) -> TallyRows {
    let connection = rusqlite::Connection::open(folder.join(FILE)).unwrap();
    let mut statement = connection
        .prepare("SELECT point, estimate, first, log2, digest, moments, checksum FROM tally")
        .unwrap();
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
        let lowered = Lowered::new(&study.points()[0], &study.fillers, study.seed, study.streams).unwrap();
        lowered.launch(&(0..study.fillers.len()).collect::<Vec<_>>()).shape.wide
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

fn keys(key: [u32; 2]) -> Keys {
    schedule(key.map(Scalar)).map(|key| key.map(|word| word.0))
}

/// The errors of a trial in 128 bits, from the parameters and the draws, with no step that could wrap.
fn exact_errors(launch: &Launch, trial: u64) -> Vec<i128> {
    let shape = launch.shape;
    let p = Parameters::of(&launch.words, shape);
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
        c.point.fit_ticks = (-9..=0).chain(4..=9).collect();
        c.point.extrapolation_ticks = vec![-12, -4, 0];
    };
    vec![
        Configuration::new("paper", |_| {}),
        Configuration::new("wide", wide),
        Configuration::new("largest motion and noise that a study accepts", |c| {
            c.point.inputs.amplitude = Amplitude::Rate(1e9);
            c.point.inputs.tick_noise = TickNoise::Std(1e6);
            wide(c);
        }),
        Configuration::new("noise alone", |c| {
            c.point.inputs.amplitude = Amplitude::Rate(0.0);
            wide(c);
        }),
        Configuration::new("long gap and distant ticks", |c| {
            c.point.inputs.gap_ticks = 10;
            c.point.fit_ticks = vec![-60, -1, 0, 11, 12, 70];
            c.point.extrapolation_ticks = vec![-63, -62, -61];
        }),
        // The largest shift, 26, of 60,000 random lists of ticks.
        Configuration::new("large weights", |c| {
            c.point.inputs.gap_ticks = 1;
            c.point.inputs.tick_noise = TickNoise::Std(1e6);
            c.point.inputs.amplitude = Amplitude::Rate(0.0);
            c.point.fit_ticks = vec![-51, -35, -26, -20, -9, -3];
            c.point.extrapolation_ticks = vec![-59, -55, -44, -38, -23, -22, -18];
        }),
    ]
}

#[test]
fn sums_are_those_of_128_bits_however_large_the_errors() {
    const TRIALS: u64 = 100_000;
    let mut nearest: f64 = 0.0;
    for configuration in demanding() {
        for launch in configuration.launches() {
            let mut expected = vec![Moments::empty(false); 2 * launch.shape.fillers];
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

fn lower(configuration: &Configuration) -> Result<Lowered, LowerError> {
    Lowered::new(&configuration.point, &configuration.fillers, 1, Streams::Independent)
}

#[test]
fn noise_that_the_arithmetic_would_lose_is_refused_by_name() {
    let tiny = Configuration::new("tiny noise", |c| c.point.inputs.tick_noise = TickNoise::Std(1e-9));
    let error = lower(&tiny).unwrap_err();
    assert!(matches!(error, LowerError::NoiseTooSmall { .. }), "{error}");
    assert!(error.to_string().starts_with(error.key()) && error.key() == "gyro.tick_noise", "{error}");

    let changes =
        [&papers_point("1")[..], &[("three_sigma = \"1.6 arcsec\"", "std = \"1e-9 arcsec\"")]].concat();
    let study = study(&changes);
    let shown = Plan::new(&study).unwrap_err().render(false, 120);
    assert!(shown.contains("study.toml:9") && shown.contains("gyro.tick_noise"), "{shown}");
}

#[test]
fn noise_below_the_finest_unit_is_not_blamed_on_a_motion_that_is_not_there() {
    let tiny = Configuration::new("tiny noise alone", |c| {
        c.point.inputs.amplitude = Amplitude::Rate(0.0);
        c.point.inputs.tick_noise = TickNoise::Std(1e-9);
    });
    let shown = lower(&tiny).unwrap_err().to_string();
    assert_eq!(
        shown,
        "gyro.tick_noise: 1e-9 ″ of noise per tick are too few units of 2^-24 ″, the finest unit of angle"
    );
}

#[test]
fn motion_that_the_arithmetic_would_lose_is_refused_by_name() {
    let motion = |rate, sigma| {
        Configuration::new("small motion", |c| {
            c.point.inputs.amplitude = Amplitude::Rate(rate);
            c.point.inputs.tick_noise = TickNoise::Std(sigma);
        })
    };
    for (rate, sigma, cause) in
        [(1e-2, 1.0, "a noise of 1 ″"), (1e-4, 0.0, "2^-24 ″"), (1e-9, 0.0, "2^-24 ″")]
    {
        let error = lower(&motion(rate, sigma)).unwrap_err();
        assert!(matches!(error, LowerError::MotionTooSmall { .. }), "{rate} ″/s beside {sigma} ″: {error}");
        let shown = error.to_string();
        assert!(shown.starts_with(error.key()) && shown.contains(cause), "{shown}");
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
                    c.point.inputs.gap_ticks = gap_ticks;
                    c.point.inputs.frequency_hz = frequency_hz.min(2000.0);
                    c.point.inputs.amplitude = Amplitude::Rate(rate);
                    c.point.inputs.tick_noise = TickNoise::Std(0.0);
                    let n = gap_ticks as i32;
                    c.point.fit_ticks = vec![-1, 0, n + 1, n + 2];
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
        assert_eq!(row.number("oracle_max"), 0.0, "{}", row.place());
    }
}

#[test]
fn ticks_that_determine_no_polynomial_are_refused_by_name() {
    let singular = Configuration::new("two ticks", |c| c.point.fit_ticks = vec![0, 4]);
    let error = lower(&singular).unwrap_err();
    assert_eq!(error, LowerError::Singular { filler: "quadratic", ticks: vec![0, 4] });
    assert!(error.to_string().starts_with(error.key()), "{error}");
}

#[test]
fn weights_beyond_64_bits_are_refused_by_name() {
    // A study accepts no tick so far off, and none of those it accepts comes near.
    let distant = Configuration::new("distant", |c| {
        c.point.inputs.gap_ticks = 1;
        c.point.extrapolation_ticks = vec![-1_000_002, -1_000_001, -1_000_000];
    });
    let error = lower(&distant).unwrap_err();
    assert!(
        matches!(error, LowerError::TooLarge { filler: "quadratic", error: "extrapolation", .. }),
        "{error}"
    );
    assert!(error.to_string().starts_with(error.key()), "{error}");
}
