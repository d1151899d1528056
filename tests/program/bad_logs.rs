//! Logs that `sagnac allan` refuses, and options that make no sense: what is said, and that nothing is left behind.

use crate::desk::Desk;
use crate::logs::{desk_with, log, rows};

const RATE: &str = "--data rate --unit deg/h --rate 1Hz";

/// Refused with this exit code and these pieces, and no results.
fn refused(desk: &Desk, words: &str, code: i32, pieces: &[&str]) {
    desk.fails(&format!("allan {words}"), code, pieces);
    assert!(!desk.path("results").exists(), "allan {words} left results");
}

#[test]
fn a_log_that_is_none_is_refused_with_its_place_and_what_to_do() {
    let good = log();
    let of = |row: &dyn Fn(usize, f64) -> String| rows(row).into_bytes();
    let number = |at: usize, other: &'static str| {
        of(&move |i, y| if i == at { other.to_owned() } else { y.to_string() })
    };
    let stamp =
        |at: usize, other: f64| of(&move |i, y| format!("{},{y}", if i == at { other } else { i as f64 }));
    let by_time = "--data rate --unit deg/h --time 1 --time-unit s";
    let table: Vec<(Vec<u8>, String, Vec<&str>)> = vec![
        (vec![], RATE.into(), vec!["log.csv is empty", "one line for each sample"]),
        (b"# nothing\n".to_vec(), RATE.into(), vec!["has no samples"]),
        (b"1.5\n".to_vec(), RATE.into(), vec!["log.csv:1:1", "has 1 sample, at least 16"]),
        (b"gz [deg/h]\n".to_vec(), RATE.into(), vec!["log.csv:1:1", "has 0 samples"]),
        (b"1\n2\n3\n".to_vec(), RATE.into(), vec!["has 3 samples, at least 16", "record longer"]),
        (
            of(&|i, y| if i == 7 { "1,2".into() } else { y.to_string() }),
            RATE.into(),
            vec!["log.csv:8:1", "this row has 2 cells, the first row has 1"],
        ),
        (
            of(&|i, y| if i == 7 { "1".into() } else { format!("{y},1") }),
            format!("{RATE} --column 1"),
            vec!["log.csv:8:1", "a cell is missing", "cut off"],
        ),
        (vec![0; 5000], RATE.into(), vec!["is binary"]),
        ([b"1\n2\n3", &[0; 5000][..]].concat(), RATE.into(), vec!["is binary", "--binary"]),
        (b"\x89HDF\r\n\x1a\n".to_vec(), RATE.into(), vec!["cannot be taken as HDF5"]),
        (b"PK\x03\x04abc".to_vec(), RATE.into(), vec!["cannot be taken as a .npz record"]),
        (
            number(9, "inf"),
            RATE.into(),
            vec!["log.csv:10:1", "column 1 is infinite", "NaN where a sample is missing"],
        ),
        (
            number(9, "-1e308"),
            RATE.into(),
            vec!["log.csv:10:1", "column 1 is -1e308, beyond 1e100, here", "NaN where a sample is missing"],
        ),
        (number(9, "1.2.3"), RATE.into(), vec!["log.csv:10:1", "\"1.2.3\", which is not a number"]),
        (
            of(&|i, y| if i == 99 { "99;1,5".into() } else { format!("{i};{y}") }),
            format!("{RATE} --column 2"),
            vec!["log.csv:100:4", "--decimal comma"],
        ),
        (
            good.clone().into(),
            format!("{RATE} --column gzz"),
            vec!["log.csv:1:1", "no column is called `gzz`", "did you mean `gz`", "time"],
        ),
        (good.clone().into(), format!("{RATE} --column 4"), vec!["there is no column 4", "3 gz [deg/s]"]),
        (
            good.clone().into(),
            RATE.into(),
            vec!["has 3 columns: select some of them", "2 gx [deg/s], 3 gz [deg/s]"],
        ),
        (good.clone().into(), format!("{RATE} --column gx,2"), vec!["requested twice"]),
        (
            good.clone().into(),
            "--data angle --rate 1Hz --column gx".into(),
            vec!["log.csv:1:11", "an angular rate", "--data rate"],
        ),
        (
            good.clone().into(),
            "--data rate --unit deg/h --time gx --column gz".into(),
            vec!["the unit of the time column `gx`", "accepted: s, ms"],
        ),
        (
            number(0, "1"),
            "--data rate --rate 1Hz".into(),
            vec!["log.csv:1:1", "the unit of column 1 is missing", "--unit none"],
        ),
        (of(&|_, _| "2.5".into()), RATE.into(), vec!["is constant: all 200 samples are 2.5"]),
        (of(&|_, _| "nan".into()), RATE.into(), vec!["has 0 samples"]),
        (
            stamp(9, 7.5),
            by_time.into(),
            vec!["log.csv:10:1", "does not increase: 7.5 after 8", "sort the rows"],
        ),
        (
            stamp(9, 8.0),
            by_time.into(),
            vec!["log.csv:10:1", "1 row has the time of the row before", "--duplicates first"],
        ),
        (
            stamp(9, 9.3),
            by_time.into(),
            vec!["log.csv:10:1", "a step of 1.3 s, the mean is 1 s", "--rate 1Hz"],
        ),
        (stamp(9, f64::NAN), by_time.into(), vec!["log.csv:10:1", "the time is missing"]),
        (
            stamp(199, 6.3e7),
            by_time.into(),
            vec!["log.csv:200:1", "most of the record is missing", "time stamp wrong"],
        ),
        (
            of(&|i, y| format!("{i},{y}")),
            "--data rate --unit deg/h --time 1".into(),
            vec!["the time column `1` has no unit", "--time-unit s"],
        ),
        (number(0, "1"), format!("{RATE} --skip 1h"), vec!["nothing of log.csv is left: it is 200 s long"]),
        (
            number(0, "1"),
            format!("{RATE} --tau 10,101"),
            vec!["τ = 101 s is too long for a record of 200 s", "τ ≤ 100 s"],
        ),
        (
            number(0, "1"),
            format!("{RATE} --tau 70 --deviation ohdev"),
            vec!["needs a record of 3 τ, here τ ≤ 66 s"],
        ),
        (number(0, "1"), format!("{RATE} --tau 0.2"), vec!["shorter than the sampling step of 1 s"]),
    ];
    for (bytes, words, pieces) in table {
        refused(&desk_with("log.csv", bytes), &format!("log.csv {words}"), 3, &pieces);
    }
    refused(&desk_with("log.csv", ""), &format!("other.csv {RATE}"), 3, &["cannot read other.csv"]);
}

#[test]
fn sparse_files_of_a_terabyte_are_refused_at_once() {
    for start in ["", "gz\n1\n2\n3\n", "\u{93}NUMPY"] {
        let desk = desk_with("log.csv", start);
        let file = std::fs::OpenOptions::new().write(true).open(desk.path("log.csv")).unwrap();
        if file.set_len(1 << 40).is_ok() {
            refused(&desk, &format!("log.csv {RATE}"), 3, &["log.csv"]);
        }
    }
}

#[test]
fn options_that_make_no_sense_are_told_with_what_does() {
    let desk = desk_with("log.csv", log());
    for (words, pieces) in [
        ("--data rate --unit deg/h --time none", vec!["--rate HZ"]),
        ("--data rate --rate 1Hz --binary f128", vec!["`f128` has no meaning", "f64 x7"]),
        ("--data speed --rate 1Hz", vec!["rate, increment, angle"]),
        ("--data rate --unit volts --rate 1Hz", vec!["`volts` is not a known unit", "deg/h, deg/s"]),
        ("--data rate --scale 0.5arcsec/pulse --rate 1Hz", vec!["--data increment"]),
        ("--data rate --unit deg/h --rate 100", vec!["its unit is missing", "--rate 100Hz"]),
        ("--data rate --unit deg/h --rate 0Hz", vec!["the rate is not positive"]),
        ("--data rate --rate 1Hz --tau tenth", vec!["octave, decade10, decade20 or all"]),
        ("--data rate --rate 100Hz --tau -1 --unit deg/h --column gx", vec!["is not a time"]),
        ("--data rate --rate 1Hz --deviation avar", vec!["`avar` is not a deviation", "oadev"]),
        ("--data rate --rate 1Hz --confidence 95", vec!["between 0 and 1"]),
        ("--data rate --rate 1Hz --skip 30", vec!["its unit is missing"]),
        ("log.csv --data rate --rate 1Hz", vec!["several files would write to"]),
        ("b.csv --out o --data rate --rate 1Hz", vec!["--out names one folder"]),
    ] {
        refused(&desk, &format!("log.csv {words}").replace("--tau -1", "--tau=-1"), 2, &pieces);
    }
}
