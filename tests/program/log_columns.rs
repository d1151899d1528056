//! The columns and units that are taken from a log without options, and the questions where they are not clear.

use crate::desk::Desk;
use crate::logs::{desk_with, noise};
use serde_json::Value;

/// A log of 600 rows below `header`.
fn log(header: &str, row: impl Fn(usize, f64) -> String) -> Desk {
    let rows = noise(600).enumerate().map(|(i, y)| row(i, 1e-3 * y) + "\n");
    desk_with("log.csv", format!("{header}\n{}", rows.collect::<String>()))
}

/// The columns that are read, and the sampling rate.
fn read(desk: &Desk, words: &str) -> (Vec<String>, f64) {
    let ended = desk.done(&format!("allan log.csv {words} --json"));
    let document: Value = serde_json::from_str(&ended.stdout).unwrap();
    let columns = document["columns"].as_array().unwrap().iter();
    let names = columns.map(|column| column["column"].as_str().unwrap().to_owned()).collect();
    (names, 1.0 / document["step_s"].as_f64().unwrap())
}

/// Rates are equal within the digits of stamps.
fn assert_rate(rate_hz: f64, expected_hz: f64, header: &str) {
    assert!((rate_hz / expected_hz - 1.0).abs() < 1e-6, "{header}: {rate_hz} Hz, not {expected_hz} Hz");
}

#[test]
fn columns_of_attitude_place_and_status_are_no_gyros() {
    for (header, row, names) in [
        ("time_s,gz_dps,roll_deg,pitch_deg,yaw_deg,lat_deg", "{y},1.2,-0.3,{y},48.1", &["gz"][..]),
        ("time_s,gz_dps,temp_deg,status_g", "{y},25.{i},{i}", &["gz"]),
        ("time_s,gyro_rad[0],gyro_rad[1],heading_deg", "{y},-{y},{i}", &["gyro[0]", "gyro[1]"]),
        ("Time (s),Gyroscope x (rad/s),Absolute (rad/s)", "{y},1{y}", &["Gyroscope x"]),
        ("Time (s),Absolute (rad/s),status", "{y},0", &["Absolute"]),
    ] {
        let desk = log(header, |i, y| {
            let row = row.replace("{y}", &format!("{:.6}", y.abs())).replace("{i}", &i.to_string());
            format!("{:.3},{row}", 0.005 * i as f64)
        });
        let (found, rate_hz) = read(&desk, "--data rate");
        assert_eq!(found, names, "{header}");
        assert_rate(rate_hz, 200.0, header);
    }
    let desk = log("Time (s),Gyroscope x (rad/s),Absolute (rad/s)", |i, y| {
        format!("{:.3},{y},{}", 0.005 * i as f64, y.abs())
    });
    let said = desk.done("allan log.csv --data rate").stderr;
    assert!(said.contains("left out, as the length of a vector: Absolute"), "{said}");
    assert_eq!(read(&desk, "--data rate --column Absolute").0, ["Absolute"]);
}
