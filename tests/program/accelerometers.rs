//! Accelerometers, and all axes of an IMU, as a user meets them.

use std::path::Path;

use serde_json::Value;

use crate::desk::{Desk, Row, number, row, rows_of, table, unwrapped};
use crate::logs::desk_with;
use crate::noise;

const LOG: &str = include_str!("../data/imu/log.csv");
const DEVIATIONS: &str = include_str!("../data/imu/deviations.csv");
const AXES: [&str; 6] = ["gx", "gy", "gz", "ax", "ay", "az"];
const G: f64 = 9.80665;

/// White noise of this standard deviation, one sample a line.
fn white(count: usize, sigma: f64, seed: u64) -> String {
    noise::white(count, sigma, seed).iter().map(|y| format!("{y}\n")).collect()
}

/// The row of a curve at the column and the τ of a point, of which it has the value.
fn same<'a>(curve: &'a [Row], point: &Row) -> &'a Row {
    let found = row(curve, &[("column", &point["column"]), ("m", &point["m"])]);
    assert!((number(found, "value") / number(point, "value") - 1.0).abs() < 1e-8, "{found:?}, not {point:?}");
    found
}

#[test]
fn six_axes_of_a_numpy_log_have_numpys_deviations_in_two_tables_and_two_charts() {
    let desk = desk_with("imu.csv", LOG);
    let ended = desk.full("allan imu.csv --data rate --bootstrap 0");
    let said = unwrapped(&ended.stderr);
    for piece in [
        "all columns whose units fit --data rate are read: gx, gy, gz, ax, ay, az",
        "ax, ay, az: no noise.toml: studies are of gyros",
    ] {
        assert!(said.contains(piece), "{piece} is missing in\n{said}");
    }
    assert!(!said.contains("may be in"), "{said}");
    let curve = desk.table("results/imu/curve.csv");
    let expected = table(DEVIATIONS);
    assert_eq!(expected.len(), 42);
    for point in &expected {
        assert_eq!(same(&curve, point)["unit"], point["unit"]);
    }
    for piece in [
        "overlapping Allan deviation, °/h, with 95 % intervals",
        "overlapping Allan deviation, µg, with 95 % intervals",
        "m/s/√h",
        "µg/√h",
        "≤",
    ] {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    for (chart, unit, [own, other]) in
        [("chart", "°/h", ["gy", "ay"]), ("chart-accelerometers", "µg", ["ay", "gy"])]
    {
        let svg = desk.read(&format!("results/imu/{chart}.svg"));
        assert!(svg.contains(unit) && svg.contains(&format!(">{own}<")), "{chart}");
        assert!(!svg.contains(&format!(">{other}<")), "{chart}");
    }
    assert!(
        desk.path("results/imu/noise_gx.toml").exists() && !desk.path("results/imu/noise_ax.toml").exists()
    );

    // A later run for gyros alone leaves no chart of accelerometers behind.
    desk.done("allan imu.csv --data rate --bootstrap 0 --column gx,gy --quiet");
    assert!(!desk.path("results/imu/chart-accelerometers.svg").exists());
    desk.done("allan imu.csv --data rate --bootstrap 0 --column ax,ay --quiet");
    assert!(desk.read("results/imu/chart.svg").contains("µg"));
}

#[test]
fn an_imu_of_ros_needs_no_columns() {
    let folder = Path::new(crate::ROOT).join("tests/data/formats");
    let desk = Desk::with("");
    let read = |words: &str| {
        desk.done(&format!("allan {words} --data rate --bootstrap 0 --quiet --out out"));
        desk.table("out/coefficients.csv")
    };
    let text = read(&format!("{}/imu.csv", folder.display()));
    let columns: Vec<&str> =
        AXES.into_iter().filter(|axis| text.iter().any(|row| row["column"] == *axis)).collect();
    assert_eq!(columns, AXES);
    for file in ["imu.mcap", "imu.bag", "imu_bag/"] {
        assert_eq!(read(&format!("{}/{file}", folder.display())), text, "{file}");
    }
}

#[test]
fn the_velocity_random_walk_of_100_ug_per_root_hertz_is_known() {
    // Two-sided density of (100 µg)²/Hz at 100 Hz.
    let desk = desk_with("acc.csv", white(40_000, 100e-6 * G * 10.0, 1));
    let ended = desk.done("allan acc.csv --data rate --unit m/s^2 --rate 100Hz --bootstrap 0");
    assert!(
        ended.stdout.contains("velocity random walk") && !ended.stdout.contains("angle"),
        "{}",
        ended.stdout
    );
    let found = desk.table("results/acc/coefficients.csv");
    let n = row(&found, &[("coefficient", "N")]);
    let expected = 100e-6 * G * 60.0;
    assert_eq!((n["unit"].as_str(), n["status"].as_str()), ("m/s/sqrt(h)", "estimated"));
    assert!(number(n, "lower") < expected && expected < number(n, "upper"), "{expected}: {n:?}");
    assert!((number(n, "value") / expected - 1.0).abs() < 0.02, "{expected}: {n:?}");
    let units: Vec<&str> = found.iter().map(|row| row["unit"].as_str()).collect();
    assert_eq!(units[..5], ["m/s", "m/s/sqrt(h)", "ug", "ug/sqrt(h)", "ug/h"]);
    // The deviation of white noise at 1 s is its density.
    let curve = desk.table("results/acc/curve.csv");
    assert!((number(row(&curve, &[("m", "128")]), "value") / 100.0 * 1.28_f64.sqrt() - 1.0).abs() < 0.1);
    let ended = desk.full("allan acc.csv --data rate --unit m/s^2 --rate 100Hz --bootstrap 0 --out psd");
    assert!(ended.stdout.contains("µg²/Hz") && ended.stdout.contains("m/s/√h"), "{}", ended.stdout);
    assert!(desk.read("psd/psd.svg").contains("density of the acceleration"));
    let white = desk.table("psd/white_noise.csv");
    assert!((number(&white[0], "n") / expected - 1.0).abs() < 0.05, "{white:?}");
}

#[test]
fn increments_and_pulses_of_velocity_are_the_same_as_accelerations() {
    let pulses: Vec<f64> =
        white(400, 30.0, 2).lines().map(|line| line.parse::<f64>().unwrap().round()).collect();
    let text = |factor: f64| pulses.iter().map(|pulse| format!("{}\n", factor * pulse)).collect::<String>();
    let desk = desk_with("pulses.csv", text(1.0));
    desk.write("velocities.csv", &text(0.1));
    desk.write("rates.csv", &text(0.01));
    let curves = [
        "pulses.csv --data increment --scale 0.1mm/s/pulse",
        "velocities.csv --data increment --unit mm/s",
        "rates.csv --data rate --unit m/s^2",
    ]
    .map(|words| {
        desk.done(&format!("allan {words} --rate 100Hz --bootstrap 0 --quiet --out out"));
        desk.table("out/curve.csv")
    });
    for (i, row) in curves[0].iter().enumerate() {
        for other in &curves[1..] {
            assert!((number(&other[i], "value") / number(row, "value") - 1.0).abs() < 1e-8, "{row:?}");
        }
    }
}

#[test]
fn units_are_one_for_all_columns_or_one_for_each() {
    let bare = LOG.replacen(" [deg/s]", "", 3).replacen(" [m/s^2]", "", 3);
    let desk = desk_with("imu.csv", bare);
    let words = "allan imu.csv --data rate --bootstrap 0 --column gx,ax";
    desk.done(&format!("{words} --unit deg/s,m/s^2"));
    let curve = desk.table("results/imu/curve.csv");
    for point in table(DEVIATIONS).iter().filter(|point| ["gx", "ax"].contains(&point["column"].as_str())) {
        same(&curve, point);
    }
    desk.fails(&format!("{words},ay --unit deg/s,m/s^2"), 3, &["2 units for 3 columns", "one for each"]);
    desk.fails("allan imu.csv --data rate", 3, &["the unit of `gx` is missing"]);
}

#[test]
fn gravity_in_another_unit_is_noted_and_rotation_is_not_compared_with_acceleration() {
    let desk = desk_with("imu.csv", LOG);
    let said = desk.done("allan imu.csv --data rate --bootstrap 0 --column ax,ay,az --unit g").stderr;
    assert!(unwrapped(&said).contains("columns ax, ay, az may be in m/s^2, not in g"), "{said}");
    let words = "compare imu.csv imu.csv --data rate";
    desk.fails(
        &format!("{words} --column gx,ax"),
        3,
        &["has angular rates", "has accelerations", "cannot be compared", "--column"],
    );
    desk.fails(words, 3, &["several columns of samples: gx, gy, gz, ax, ay, az", "--column gx"]);
    let ended = desk.done(&format!("{words} --column ax,az"));
    let said = unwrapped(&ended.stdout);
    assert!(said.contains(" noisier in N (") && said.contains("m/s/√h") && !said.contains('°'), "{said}");
}

#[test]
fn samples_have_the_same_bits_as_rates_and_as_accelerations() {
    let text = white(2000, 5.0, 3);
    let desk = desk_with("log.csv", &text);
    let document = |unit: &str| -> Value {
        let words = "allan log.csv --data rate --rate 10Hz --json --deviation oadev,mdev,ohdev,tdev";
        serde_json::from_str(&desk.done(&format!("{words} --unit {unit}")).stdout).unwrap()
    };
    let (rotation, acceleration) = (document("deg/h"), document("ug"));
    // All cells but the unit.
    let without_unit = |document: &Value, table: &str| -> Vec<Value> {
        let mut rows = rows_of(document, table).to_vec();
        rows.iter_mut().for_each(|row| row["unit"] = Value::Null);
        rows
    };
    for table in ["curve", "records"] {
        assert_eq!(without_unit(&rotation, table), without_unit(&acceleration, table));
    }
    let fit = |document: &Value| {
        let rows = rows_of(document, "coefficients").iter();
        rows.map(|row| ["fit_from_s", "fit_to_s"].map(|end| row[end].clone())).collect::<Vec<_>>()
    };
    assert_eq!(fit(&rotation), fit(&acceleration));
    // B is in the unit of the curve.
    let b =
        |document: &Value| ["lower", "upper"].map(|end| rows_of(document, "coefficients")[2][end].clone());
    assert_eq!(b(&rotation), b(&acceleration));
    assert_eq!(rows_of(&acceleration, "curve").last().unwrap()["unit"], "ug*s");
}
