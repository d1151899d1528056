//! `sagnac allan`, `sagnac model` and `sagnac compare` on curves of other tools.

use std::collections::BTreeMap;

use crate::desk::{Desk, number};

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

/// Curves whose record is known have the coefficients of that record, and its intervals in closed form.
#[test]
fn the_curve_of_a_known_record_gives_the_coefficients_of_its_log() {
    let desk = Desk::with("");
    desk.write("noise.toml", NOISE);
    desk.done("simulate noise.toml --rate 2Hz --length 9h --out records");
    desk.done("allan records/record_00000.csv --bootstrap 0 --out log");
    // Beside the whole curve, one without numbers of differences, and one with ten τ in a decade.
    let rows = desk.table("log/curve.csv");
    let row = |row: &BTreeMap<String, String>| format!("{},{}\n", row["tau_s"], row["value"]);
    let plain: String = rows.iter().map(row).collect();
    desk.write("plain.csv", &format!("tau [s],oadev [deg/h]\n{plain}"));
    desk.done("allan records/record_00000.csv --bootstrap 0 --tau decade10 --out decade");
    for (command, tolerance) in [
        ("log/curve.csv", 1e-6),
        ("plain.csv --curve-interval 9h --rate 2Hz", 1e-6),
        ("decade/curve.csv", 0.1),
    ] {
        let shown = desk.full(&format!("allan {command} --out again"));
        let said = shown.stdout + &shown.stderr;
        assert!(said.contains("one record of 64800 samples") && !said.contains("independent"), "{said}");
        for name in ["N", "B", "K"] {
            let (log, again) = (coefficient(&desk, "log", name), coefficient(&desk, "again", name));
            for (log, again) in log.into_iter().zip(again) {
                let is_same = log.is_nan() && again.is_nan() || (again - log).abs() <= tolerance * log.abs();
                assert!(is_same, "{command}: {name} is {again}, that of the log {log}");
            }
        }
    }
    // Without its rate, the points are independent.
    let shown = desk.full("allan plain.csv --curve-interval 9h --out length");
    assert!((shown.stdout + &shown.stderr).contains("independent"));
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
        ("allan curve.csv --unit deg/h --skip 30min", 2, "--fit-from and --fit-to"),
        ("allan curve.csv --unit deg/h --tau 1,10", 2, "--tau needs a log"),
        ("allan curve.csv --unit deg/h --segment 10s", 2, "--segment needs a log"),
        ("allan curve.csv --unit deg/h --column adev,low", 2, "--column has several values"),
        ("allan curve.csv --unit deg/h --rate 1Hz", 3, "whose length is missing"),
        ("allan curve.csv --unit deg/h --rate 1Hz,2Hz", 2, "--rate has several values"),
        ("allan curve.csv --unit deg/h --rate 1Hz --curve-interval 20s", 3, "has no τ of 16 s"),
        ("allan curve.csv --unit deg/h --data rate", 2, "--data needs a log"),
        ("model curve.csv --unit deg/h --time tau", 2, "--time needs a log"),
        ("compare curve.csv curve.csv --unit deg/h --data rate", 2, "--data needs a log"),
        ("model curve.csv --unit deg/h --remove-events", 2, "--remove-events needs a log"),
        ("model curve.csv --unit deg/h --confidence 0.9", 2, "--confidence needs a log"),
        ("compare curve.csv curve.csv --unit deg/h --temperature t", 2, "--temperature needs a log"),
        ("compare curve.csv curve.csv curve.csv --unit deg/h --hat", 2, "--hat needs a log"),
        ("compare curve.csv curve.csv curve.csv --unit deg/h", 2, "a batch is of logs"),
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

/// A curve in closed form of white noise of this many °/√h, and flicker noise of 0.2 °/h.
fn closed_form(n: f64) -> String {
    let row = |octave: u32| {
        let tau = f64::from(1 << octave);
        format!("{tau},{}\n", (3600.0 * n * n / tau + 0.04_f64).sqrt())
    };
    let rows: String = (0..12).map(row).collect();
    format!("tau [s],adev [deg/h]\n{rows}")
}

#[test]
fn two_curves_are_compared_by_the_coefficients_of_their_points() {
    let desk = Desk::with("");
    desk.write("a.csv", &closed_form(0.05));
    desk.write("b.csv", &closed_form(0.06));
    let shown = desk.done("compare a.csv b.csv --curve-interval 5% --out out").stdout;
    assert!(shown.contains("b is 20 % noisier in N") && shown.contains("independent"), "{shown}");
    let rows = desk.table("out/coefficients.csv");
    let n = &rows[0];
    assert_eq!((n["coefficient"].as_str(), n["status"].as_str()), ("N", "b higher"));
    assert!((number(n, "ratio") - 1.2).abs() < 1e-6, "{n:?}");
    assert!(number(n, "ratio_lower") > 1.1 && number(n, "ratio_upper") < 1.3, "{n:?}");
    // What follows from samples is blank, and no table of records is there.
    assert_eq!((n["length_needed_s"].as_str(), n["length_beyond_s"].as_str()), ("", ""));
    assert!(!desk.path("out/records.csv").exists());
    let ratios = desk.table("out/compare.csv");
    assert_eq!((ratios.len(), ratios[0]["m_a"].as_str(), ratios[0]["status"].as_str()), (12, "", "b higher"));
    let said = desk.full("compare a.csv b.csv --curve-interval 5% --out full");
    let said = said.stdout + &said.stderr;
    assert!(said.contains("follow from samples and are left out"), "{said}");
    desk.done("compare a.csv b.csv --curve-interval 5% --max-ratio N=1.5 --out limited");
    assert!(desk.done("compare a.csv a.csv --out same").stdout.contains("one record"));
}

#[test]
fn a_log_and_its_own_curve_are_consistent() {
    let desk = Desk::with("");
    desk.write("noise.toml", NOISE);
    desk.done("simulate noise.toml --rate 1Hz --length 9h --out records");
    desk.done("allan records/record_00000.csv --bootstrap 0 --out log");
    for (files, place) in
        [("log/curve.csv records/record_00000.csv", "m_b"), ("records/record_00000.csv log/curve.csv", "m_a")]
    {
        desk.done(&format!("compare {files} --out {place}"));
        let rows = desk.table(&format!("{place}/coefficients.csv"));
        let n = rows.iter().find(|row| row["coefficient"] == "N").unwrap();
        assert_eq!(n["status"], "consistent", "{n:?}");
        assert!((number(n, "ratio") - 1.0).abs() < 0.02, "{n:?}");
        let ratios = desk.table(&format!("{place}/compare.csv"));
        assert!((number(&ratios[3], "ratio") - 1.0).abs() < 1e-6, "{ratios:?}");
        assert_eq!(ratios[3][place], "8");
        assert_eq!(desk.table(&format!("{place}/records.csv")).len(), 1);
    }
}

#[test]
fn stated_numbers_stand_for_a_data_sheet() {
    let desk = Desk::with("");
    desk.write("curve.csv", &closed_form(0.05));
    desk.write(
        "sheet.toml",
        "angle_random_walk = \"0.04 deg/sqrt(h)\"\nrate_random_walk = \"1 deg/h/sqrt(h)\"\n",
    );
    desk.done("compare sheet.toml curve.csv --curve-interval 5% --out out");
    let rows = desk.table("out/coefficients.csv");
    let row = |name: &str| rows.iter().find(|row| row["coefficient"] == name).unwrap();
    assert_eq!(row("N")["status"], "curve higher");
    assert!((number(row("N"), "ratio") - 1.25).abs() < 1e-5, "{rows:?}");
    // The sheet states no B, and the curve shows no K.
    assert_eq!((row("B")["status"].as_str(), row("B")["a"].as_str()), ("not compared", ""));
    assert_eq!(row("K")["status"], "curve lower");
    let limit =
        desk.done("compare sheet.toml curve.csv --curve-interval 5% --max-ratio N=1.4 --out met").stdout;
    assert!(limit.contains("meets the limit 1.4"), "{limit}");
    for (command, piece) in [
        ("compare sheet.toml sheet.toml", "nothing is estimated"),
        ("compare sheet.toml curve.csv --fit none", "--fit auto"),
    ] {
        let refused = desk.sagnac(command);
        assert_eq!(refused.code, 2, "{command}: {}", refused.stderr);
        assert!(refused.stderr.contains(piece), "{command}: {}", refused.stderr);
    }
}
