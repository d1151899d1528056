//! Whole files as loggers write them.

use super::*;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::record::log::measure::UnitCheck;
use crate::record::log::read::{Hints, Request, Timing};

const COUNT: usize = 40;

/// The samples in every file below.
fn sample(i: usize) -> f64 {
    (i * 7 % 16) as f64 - 7.5
}

fn request(columns: &[&str], timing: Timing) -> Request {
    let columns = columns.iter().map(|column| (*column).to_owned()).collect();
    let units = vec![Unit::parse("deg/h", Data::Rate).unwrap()];
    Request { columns, timing, data: Some(Data::Rate), units, temperature: None, hints: Hints::default() }
}

fn stamps(column: &str, unit: Option<&str>) -> Timing {
    Timing::Stamps { step_s: None, column: Some(column.to_owned()), unit: unit.map(str::to_owned) }
}

struct Desk(TempDir);

impl Desk {
    fn new() -> Desk {
        Desk(TempDir::new().unwrap())
    }

    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

fn refused(path: &Path, request: &Request) -> String {
    Log::read(path, request).unwrap_err().render(false, 200)
}

fn lines(line: impl Fn(usize) -> String) -> String {
    (0..COUNT).map(|i| line(i) + "\n").collect()
}

#[test]
fn text_of_every_layout_gives_the_same_samples() {
    let desk = Desk::new();
    let step = Timing::Step(0.01);
    let files = [
        (lines(|i| format!("{}", sample(i))), request(&[], step.clone())),
        (format!("gz\n{}", lines(|i| format!("{}", sample(i)))), request(&["gz"], step.clone())),
        (format!("# PHASE\n#\n{}", lines(|i| format!("  {:e}", sample(i)))), request(&["1"], step.clone())),
        (
            format!("t [ms];gz [rad/s];x\r\n{}", lines(|i| format!("{};{};oh\r", 10 * i, sample(i)))),
            request(&["gz"], stamps("t", None)),
        ),
        (
            format!("\u{feff}time_us\tgx\tgz\n{}", lines(|i| format!("{}\t1\t{}\t", 10_000 * i, sample(i)))),
            request(&["3"], stamps("time", None)),
        ),
        (
            format!(
                "% c\n\n{}",
                lines(|i| format!(" {:.3}   {}  7\n\n; c", 1e4 + 0.01 * i as f64, sample(i)))
            ),
            request(&["2"], stamps("1", Some("s"))),
        ),
        (
            format!("# t gz\n{}", lines(|i| format!("{} {}", 10_000_000 * i, sample(i)))),
            request(&[], stamps("t", Some("ns"))),
        ),
        (lines(|i| format!("\"{}\",\"{}\"", i, sample(i))), request(&["2"], step)),
    ];
    for (text, request) in files {
        let path = desk.write("g.csv", text.as_bytes());
        let log = Log::read(&path, &request).unwrap_or_else(|e| panic!("{text}\n{}", e.render(false, 100)));
        let samples: Vec<f64> = (0..COUNT).map(sample).collect();
        assert_eq!(log.channels[0].samples, samples, "{text}");
        assert!((log.step_s - 0.01).abs() < 1e-12, "{text}\n{}", log.step_s);
    }
}

#[test]
fn steps_that_no_sensor_has_are_refused() {
    let desk = Desk::new();
    let read = |second: &str, unit| {
        let path = desk.write("g.csv", format!("0,1\n{second},2\n").as_bytes());
        Log::read(&path, &request(&[], stamps("1", Some(unit))))
    };
    assert_eq!(read("1", "ns").unwrap().step_s, 1e-9);
    for (second, unit, piece) in
        [("5e-324", "ms", "0 s apart"), ("0.9", "ns", "9e-10 s"), ("1e99", "h", "3.6e102 s")]
    {
        let shown = read(second, unit).unwrap_err().render(false, 100);
        assert!(shown.contains(piece) && shown.contains("accepted: 1e-9 s to 1e9 s"), "{shown}");
    }
}

#[test]
fn several_columns_come_in_the_order_asked_for_and_gaps_are_nan() {
    let desk = Desk::new();
    let row = |i: usize| match i {
        5 => "5,NaN,1".to_owned(),
        6 => "6,,1".to_owned(),
        // Rows 10 to 12 are not written.
        10.. => format!("{},{},1", i + 3, sample(i)),
        _ => format!("{i},{},1", sample(i)),
    };
    let path = desk.write("g.csv", format!("t [s],gx,gy\n{}", lines(row)).as_bytes());
    let log = Log::read(&path, &request(&["gy", "gx"], stamps("t", None))).unwrap();
    assert_eq!((log.channels[0].name.as_str(), log.channels[1].name.as_str()), ("gy", "gx"));
    let missing = |at: usize| log.channels[at].view(log.data, log.step_s).missing();
    assert_eq!((log.samples(), missing(0), missing(1)), (COUNT + 3, 3, 5));
    assert!(log.channels[1].samples[10].is_nan() && log.channels[1].samples[13] == sample(10));
}

/// A .npy file with this type and shape, holding `numbers` as `bytes` writes them.
fn npy(descr: &str, fortran: bool, shape: &str, numbers: &[f64], bytes: impl Fn(f64) -> Vec<u8>) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': ({shape}), }}");
    let padded = format!("{header:<117}\n");
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((padded.len() as u16).to_le_bytes());
    file.extend(padded.as_bytes());
    file.extend(numbers.iter().flat_map(|number| bytes(*number)));
    file
}

#[test]
fn arrays_of_every_type_and_order_give_the_same_samples() {
    let desk = Desk::new();
    let twice = |i: usize| 2.0 * sample(i);
    let one: Vec<f64> = (0..COUNT).map(twice).collect();
    let rows: Vec<f64> = (0..COUNT).flat_map(|i| [i as f64, twice(i), 3.0]).collect();
    let columns: Vec<f64> = (0..COUNT).map(|i| i as f64).chain(one.clone()).chain([3.0; COUNT]).collect();
    type Bytes = fn(f64) -> Vec<u8>;
    let types: [(&str, Bytes); 8] = [
        ("<f8", |x| x.to_le_bytes().to_vec()),
        (">f8", |x| x.to_be_bytes().to_vec()),
        ("<f4", |x| (x as f32).to_le_bytes().to_vec()),
        ("<i2", |x| (x as i16).to_le_bytes().to_vec()),
        (">i4", |x| (x as i32).to_be_bytes().to_vec()),
        ("<i8", |x| (x as i64).to_le_bytes().to_vec()),
        ("|i1", |x| (x as i8).to_le_bytes().to_vec()),
        (">i2", |x| (x as i16).to_be_bytes().to_vec()),
    ];
    for (descr, bytes) in types {
        for (fortran, shape, numbers, column) in [
            (false, format!("{COUNT},"), &one, "1"),
            (false, format!("{COUNT}, 3"), &rows, "2"),
            (true, format!("{COUNT}, 3"), &columns, "2"),
        ] {
            let path = desk.write("a.npy", &npy(descr, fortran, &shape, numbers, bytes));
            let log = Log::read(&path, &request(&[column], Timing::Step(1.0)))
                .unwrap_or_else(|e| panic!("{descr} ({shape}): {}", e.render(false, 100)));
            assert_eq!(log.channels[0].samples, one, "{descr} ({shape})");
        }
    }
}

#[test]
fn arrays_that_are_no_records_are_refused_before_anything_is_allocated() {
    let desk = Desk::new();
    let le = |x: f64| x.to_le_bytes().to_vec();
    let table = [
        (npy("<f8", false, "1000000000000,", &[1.0], le), "promises 8000000000000 bytes"),
        (npy("<f8", true, "0, 4294967296", &[], le), "4294967296 columns, more than"),
        (npy("<f8", false, "99999999999999999999,", &[1.0], le), "header is damaged"),
        (npy("<f8", false, "4000000000000000000, 9", &[1.0], le), "more numbers than can be"),
        (npy("<c16", false, "4,", &[1.0; 8], le), "of type '<c16'"),
        (npy("<f8", false, "2, 2, 2", &[1.0; 8], le), "neither one dimension nor two"),
        (npy("<f8", false, "3,", &[1.0, f64::INFINITY, 1.0], le), "column 1 is infinite at row 2"),
        (b"\x93NUMPY\x01\x00\xff".to_vec(), "ends too early"),
        (b"\x93NUMPY\x01\x00\x04\x00{}  ".to_vec(), "header is damaged"),
    ];
    for (bytes, piece) in table {
        let said = refused(&desk.write("a.npy", &bytes), &request(&["1"], Timing::Step(1.0)));
        assert!(said.contains(piece), "{piece} is missing in\n{said}");
    }
}

#[test]
fn the_first_faults_of_a_long_file_are_told_with_their_lines_and_the_number_of_all() {
    let desk = Desk::new();
    // Several parts of 1 MiB, two of which have a fault, and the last two.
    let line = |i: usize| match i {
        100_000 | 400_000 | 600_001 => format!("{i},oops\n"),
        600_002 => format!("{i}\n"),
        _ => format!("{i},{}\n", sample(i)),
    };
    let text: String = (0..=600_002).map(line).collect();
    let path = desk.write("g.csv", text.as_bytes());
    let said = refused(&path, &request(&["2"], Timing::Step(1.0)));
    for piece in ["4 rows of", "g.csv:100001:8", "g.csv:400001:8", "g.csv:600002:8", "\"oops\", which is not"]
    {
        assert!(said.contains(piece), "{piece} is missing in\n{said}");
    }
    assert!(!said.contains("g.csv:600003"), "{said}");
    let good = text.replace("oops", "5").replace("600002\n", "599000,3\n");
    let said = refused(&desk.write("g.csv", good.as_bytes()), &request(&["2"], stamps("1", Some("s"))));
    for piece in ["g.csv:600003:1", "does not increase: 599000 after 600001"] {
        assert!(said.contains(piece), "{piece} is missing in\n{said}");
    }
}

#[test]
fn a_log_is_cut_from_its_start_and_checked_for_what_says_nothing() {
    let desk = Desk::new();
    let path = desk.write("g.csv", lines(|i| format!("{}", sample(i))).as_bytes());
    let read = || Log::read(&path, &request(&[], Timing::Step(0.5))).unwrap();
    let mut log = read();
    log.cut(1.0, Some(10.0)).unwrap();
    assert_eq!((log.samples(), log.start_s, log.channels[0].samples[0]), (18, 1.0, sample(2)));
    assert!(log.check(UnitCheck::On).is_ok());
    log.cut(2.0, None).unwrap();
    assert!(log.check(UnitCheck::On).unwrap_err().to_string().contains("14 samples, at least 16"));
    assert!(read().cut(20.0, None).unwrap_err().to_string().contains("it is 20 s long"));
    let mut log = read();
    log.channels[0].samples.fill(3.0);
    assert!(log.check(UnitCheck::On).unwrap_err().to_string().contains("all 40 samples are 3"));
}

#[test]
fn a_mean_rate_that_only_degrees_explain_is_noted_in_radians() {
    let desk = Desk::new();
    // The Earth's rate in °/s.
    let path = desk.write("g.csv", lines(|i| format!("{}", 15.0 / 3600.0 + 1e-5 * sample(i))).as_bytes());
    let check = |unit: &str, unit_check| {
        let units = vec![Unit::parse(unit, Data::Rate).unwrap()];
        let mut log = Log::read(&path, &Request { units, ..request(&[], Timing::Step(1.0)) }).unwrap();
        log.check(unit_check).unwrap();
        log.notes.concat()
    };
    assert_eq!(check("deg/s", UnitCheck::On), "");
    let said = check("rad/s", UnitCheck::On);
    for piece in ["may be in degrees, not in radians", "15 °/h", "`unit = deg/s`"] {
        assert!(said.contains(piece), "{piece} is missing in\n{said}");
    }
    assert_eq!(check("rad/s", UnitCheck::Off), "");
}

#[test]
fn the_order_of_a_date_is_that_in_which_all_rows_are_a_record() {
    let desk = Desk::new();
    // Hours from 16:00 on the first day; the 13th begins behind the rows from which the layout is found.
    let cases = [
        (3, 4, "{day:02}/{month:02}/2024", "day/month/year"),
        (3, 4, "{month:02}/{day:02}/2024", "month/day/year"),
        (11, 4, "{day:02}/{month:02}/2024", "day/month/year"),
        (11, 4, "{month:02}/{day:02}/2024", "month/day/year"),
        (25, 4, "{day}/{month}/2024", "day/month/year"),
    ];
    for (first, month, pattern, order) in cases {
        for sign in [" ", ","] {
            let date = |day: usize| {
                let pattern =
                    pattern.replace("{day:02}", &format!("{day:02}")).replace("{day}", &day.to_string());
                pattern.replace("{month:02}", &format!("{month:02}")).replace("{month}", &month.to_string())
            };
            let rows = lines(|i| {
                let hour = 16 + i;
                format!("{}{sign}{:02}:00:00,{}", date(first + hour / 24), hour % 24, sample(i))
            });
            let header = if sign == "," { "date,time,gz" } else { "time,gz" };
            let path = desk.write("g.csv", format!("{header}\n{rows}").as_bytes());
            let log = Log::read(&path, &request(&["gz"], stamps("time", None))).unwrap();
            assert_eq!((log.step_s, log.samples()), (3600.0, COUNT), "{first} {pattern}");
            let note = format!("dates with slashes are read as {order}");
            assert!(log.notes.contains(&note), "{first} {pattern}: {:?}", log.notes);
        }
    }
    let rows = lines(|i| format!("03/04/2024 10:00:{i:02},{}", sample(i)));
    let path = desk.write("day.csv", format!("time,gz\n{rows}").as_bytes());
    let log = Log::read(&path, &request(&["gz"], stamps("time", None))).unwrap();
    assert!(
        log.notes.contains(&"dates with slashes are read as month/day/year".to_owned()),
        "{:?}",
        log.notes
    );
}

#[test]
fn times_of_a_spreadsheet_are_days() {
    let desk = Desk::new();
    let timing = || Timing::Stamps { step_s: None, column: None, unit: None };
    let serial = |name: &str, step_s: f64| {
        let rows =
            lines(|i| format!("{:.10},{}", 45_291.500_011_574 + step_s * i as f64 / 86_400.0, sample(i)));
        desk.write("g.csv", format!("{name},gz\n{rows}").as_bytes())
    };
    for name in ["time", "Timestamp", "Date"] {
        let log = Log::read(&serial(name, 0.02), &request(&["gz"], timing())).unwrap();
        assert!((log.step_s / 0.02 - 1.0).abs() < 1e-3 && log.samples() == COUNT, "{} s", log.step_s);
        let note = format!("the time column `{name}` is taken for days, as spreadsheets count them");
        assert!(log.notes.contains(&note), "{:?}", log.notes);
    }
    // Steps of 0.02 in an unknown unit.
    let message = refused(&serial("time", 0.02 * 86_400.0), &request(&["gz"], timing()));
    assert!(message.contains("has no unit"), "{message}");
}

#[test]
fn columns_that_do_not_vary_are_not_proposed() {
    let desk = Desk::new();
    let rows = lines(|i| format!("{},7,{},{}", 0.01 * i as f64, i % 256, sample(i)));
    let path = desk.write("g.csv", format!("time [s],mode,packets,rot\n{rows}").as_bytes());
    let timing = Timing::Stamps { step_s: None, column: None, unit: None };
    let message = refused(&path, &request(&[], timing));
    assert!(message.contains("as in `column = rot`"), "{message}");
}

#[test]
fn units_are_read_as_loggers_spell_them() {
    for (text, zero) in [("degC", 0.0), ("° C", 0.0), ("K", -273.15), ("Celsius", 0.0)] {
        assert_eq!(Degree::parse(text).map(|degree| degree.zero), Some(zero), "{text}");
    }
    for (name, size) in [("temp_degC", 1.0), ("Temp F", 5.0 / 9.0), ("board_temp_K", 1.0)] {
        assert_eq!(Degree::at_the_end(name).map(|degree| degree.size), Some(size), "{name}");
    }
    for text in ["deg", "", "s", "temp"] {
        assert!(Degree::parse(text).is_none() && Degree::at_the_end(text).is_none(), "{text}");
    }
    let boiling = Degree::parse("°F").unwrap().celsius(vec![212.0, 32.0]);
    assert!((boiling[0] - 100.0).abs() < 1e-12 && boiling[1].abs() < 1e-12, "{boiling:?}");
}
