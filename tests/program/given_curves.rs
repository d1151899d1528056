//! `sagnac allan` and `sagnac model` on curves of other tools.

use crate::desk::Desk;

/// A record of white and flicker noise, by the program itself.
const NOISE: &str = "angle_random_walk = \"0.03 deg/sqrt(h)\"\nbias_instability = \"0.5 deg/h\"\n";

/// The row of a coefficient in `coefficients.csv`: value, lower and upper end.
fn coefficient(desk: &Desk, folder: &str, name: &str) -> [f64; 3] {
    let table = std::fs::read_to_string(desk.path(&format!("{folder}/coefficients.csv"))).unwrap();
    let row = table
        .lines()
        .find(|row| row.split(',').nth(1) == Some(name))
        .unwrap_or_else(|| panic!("{name}: {table}"));
    let cells: Vec<&str> = row.split(',').collect();
    [2, 3, 4].map(|at| cells[at].parse().unwrap_or(f64::NAN))
}

#[test]
fn a_curve_that_was_written_from_a_log_gives_its_coefficients_again() {
    let desk = Desk::with("");
    desk.write("noise.toml", NOISE);
    desk.done("simulate noise.toml --rate 1Hz --length 9h --out records");
    desk.done("allan records/record_00000.csv --bootstrap 0 --out log");
    let shown = desk.done("allan log/curve.csv --out curve").stdout;
    assert!(shown.contains("points of a curve") && shown.contains("N = 0.03"), "{shown}");
    for name in ["N", "B"] {
        let ([log, low, high], [curve, ..]) =
            (coefficient(&desk, "log", name), coefficient(&desk, "curve", name));
        assert!(
            (low..=high).contains(&curve),
            "{name}: {log} ({low} to {high}) of the log, {curve} of its curve"
        );
    }
    // The noise file of the curve serves other commands.
    desk.done("simulate curve/noise.toml --rate 1Hz --length 1h --out again");
    desk.done("model curve/noise.toml --from 1s --to 1000s --out model");
    let model = desk.done("model log/curve.csv --overbound --out bound").stdout;
    assert!(model.contains("white noise N"), "{model}");
}

#[test]
fn a_curve_of_closed_form_gives_its_noise_and_meets_limits() {
    let desk = Desk::with("");
    let row = |octave: u32| {
        let tau = f64::from(1 << octave);
        // N = 0.05 °/√h is 3 °/h at 1 s.
        format!("{tau},{}\n", (9.0 / tau + 0.04 + 1e-4 * tau / 3.0_f64).sqrt())
    };
    let rows: String = (0..14).map(row).collect();
    desk.write("curve.csv", &format!("tau [s],adev [deg/h]\n{rows}"));
    let shown = desk.done("allan curve.csv --curve-interval 5% --limit N=0.06deg/√h --out out").stdout;
    assert!(shown.contains("meets the 0.06 °/√h limit"), "{shown}");
    let near = |name: &str, expected: f64| {
        let [value, ..] = coefficient(&desk, "out", name);
        assert!((value / expected - 1.0).abs() < 1e-6, "{name}: {value}, not {expected}");
    };
    near("N", 0.05);
    near("B", 0.2 / 0.664_282_466_894_803_2);
    near("K", 0.01 * 60.0);
    assert!(!shown.contains("are assumed"), "{shown}");
    let shown = desk.done("allan curve.csv --out assumed").stdout;
    assert!(shown.contains("errors of the points are assumed"), "{shown}");
}

#[test]
fn what_a_curve_cannot_give_is_said() {
    let desk = Desk::with("");
    desk.write("curve.csv", "tau,adev\n1,0.3\n4,0.15\n16,0.075\n");
    for (command, code, piece) in [
        ("allan curve.csv", 3, "`adev` has no unit"),
        ("allan curve.csv --unit deg/h --dynamic", 2, "--dynamic needs a log"),
        ("compare curve.csv curve.csv --unit deg/h", 2, "is a curve"),
        ("allan curve.csv --unit deg/h --curve-interval 200%", 2, "not between 0 and 100 %"),
    ] {
        let refused = desk.sagnac(command);
        assert_eq!(refused.code, code, "{command}: {}", refused.stderr);
        assert!(refused.stderr.contains(piece), "{command}: {}", refused.stderr);
    }
    desk.write("steps.csv", "tau [s],adev [deg/h]\n1,1\n2,3\n4,1\n8,3\n16,1\n32,3\n64,1\n128,3\n256,1\n");
    let shown = desk.done("allan steps.csv --out steps").stdout;
    assert!(shown.contains("No noise model fits"), "{shown}");
}
