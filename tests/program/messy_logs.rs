//! Logs as loggers write them: what is inferred is said, what is doubtful is refused at once, and gaps stay gaps.

use std::process::Command;

use crate::desk::{Desk, PROGRAM, rows_of};
use crate::logs::{desk_with, noise};
use serde_json::Value;

/// Samples of 10 ms with the loss of 77 from number 200 on, as row number and value.
fn lossy() -> impl Iterator<Item = (usize, f64)> {
    noise(600).enumerate().filter(|(i, _)| !(200..277).contains(i))
}

fn log(header: &str, row: impl Fn(usize, f64) -> String) -> String {
    lossy().fold(format!("{header}\n"), |text, (i, y)| text + &row(i, y) + "\n")
}

/// The number of missing samples and of all, from the JSON of the first column.
fn missing(desk: &Desk, words: &str) -> (u64, u64, f64) {
    let ended = desk.done(&format!("allan {words} --json"));
    let document: Value = serde_json::from_str(&ended.stdout).unwrap();
    let record = &rows_of(&document, "records")[0];
    let of = |value: &Value| value.as_u64().unwrap();
    (of(&record["missing"]), of(&record["samples"]), record["step_s"].as_f64().unwrap())
}

#[test]
fn gaps_stay_gaps_however_the_times_are_given() {
    let late = |i: usize| if i.is_multiple_of(5) { 0.004 } else { 0.0 };
    let files = [
        (
            "t.csv",
            log("time [s],gz [deg/s]", |i, y| format!("{},{y}", 0.01 * i as f64)),
            vec!["", "--rate 100Hz"],
        ),
        (
            "late.csv",
            log("time [s],gz [deg/s]", |i, y| format!("{:.4},{y}", 0.01 * i as f64 + late(i))),
            vec!["--rate 100Hz"],
        ),
        ("bare.csv", log("", |i, y| format!("{},{y}", 10 * i)), vec!["--rate 100Hz --unit deg/s --column 2"]),
        (
            "n.csv",
            log("counter;gz [dps]", |i, y| format!("{i};{y}").replace('.', ",")),
            vec!["--rate 100Hz --column gz"],
        ),
        (
            "us.csv",
            log("micros_us;gz [deg/sec]", |i, y| format!("{};{y}", (4_290_000_000 + 10_000 * i) % (1 << 32))),
            vec!["--time micros", "--time micros --rate 100Hz"],
        ),
        (
            "ns.csv",
            log("stamp gz(°/s)", |i, y| format!("{} {y}", 1_700_000_000_000_000_000 + 10_000_000 * i)),
            vec!["", "--rate 100Hz"],
        ),
        (
            "zeit.csv",
            log("Zeit gz(°/s)", |i, y| format!("{} {y}", 1_700_000_000_000_000_000 + 10_000_000 * i)),
            vec!["", "--rate 100Hz --column gz"],
        ),
    ];
    for (name, text, options) in files {
        let desk = desk_with(name, text);
        for words in options {
            let (missing, samples, step_s) = missing(&desk, &format!("{name} --data rate {words}"));
            assert_eq!((missing, samples), (77, 600), "{name} {words}");
            assert!((step_s / 0.01 - 1.0).abs() < 1e-6, "{name} {words}: {step_s} s");
        }
        let spliced = "--data rate --rate 100Hz --time none --unit deg/s --column 2";
        assert_eq!(missing(&desk, &format!("{name} {spliced}")).0, 0, "{name} without its stamps");
    }
}

#[test]
fn all_problems_are_told_at_once_with_what_settles_them() {
    let late = |i: usize| if i.is_multiple_of(5) { 4_000_000 } else { 0 };
    let text = log("ticks;gx;gz", |i, y| {
        let time = 1_700_000_000_000_000_000_u64 + 10_000_000 * i as u64 + late(i);
        let doubled = if i == 300 { format!("\n{time};{y};0.5") } else { String::new() };
        format!("{time};{y};{}{doubled}", 2.0 * y).replace('.', ",")
    });
    let desk = desk_with("log.csv", text);
    let pieces = [
        "log.csv has 3 problems",
        "the unit of `gz` is missing",
        "--unit deg/h",
        "1 row has the time of the row before",
        "--duplicates first",
        "not evenly spaced",
        "--rate 100Hz",
    ];
    desk.fails("allan log.csv --data rate --column gz --time ticks", 3, &pieces);
    desk.fails("allan log.csv --data rate --column gz", 3, &pieces);
    let settled = "log.csv --data rate --column gz --time ticks --unit dps --duplicates first --rate 100Hz";
    assert_eq!(missing(&desk, settled), (77, 600, 0.01));
    let said = desk.done(&format!("allan {settled}")).stderr;
    for piece in
        ["commas are decimals", "ns since 1970", "missing (77)", "1 row has the time of the row before"]
    {
        assert!(said.contains(piece), "{piece} is missing in\n{said}");
    }
}

#[test]
fn a_column_of_dates_or_temperatures_is_not_taken_for_times() {
    let text = log("time,T [K],t [°C],gz [deg/s]", |i, y| {
        format!("day 47 at 10:{:02},{},20,{y}", i / 60, 300 - i % 3)
    });
    let desk = desk_with("log.csv", text);
    assert_eq!(missing(&desk, "log.csv --data rate --column gz --rate 100Hz"), (0, 523, 0.01));
    let said = desk.done("allan log.csv --data rate --column gz --rate 100Hz").stderr;
    desk.write("warm.csv", &log("temp,gz [deg/s]", |i, y| format!("{},{y}", 300.0 + 1e-6 * (i * i) as f64)));
    assert_eq!(missing(&desk, "warm.csv --data rate --column gz --rate 100Hz"), (0, 523, 0.01));
    assert!(said.contains("the time column `time` holds no numbers and is not used"), "{said}");
}

#[test]
fn rows_that_repeat_are_left_out_and_outliers_that_are_removed_count_as_missing() {
    let text = log("time [s],gz [deg/s]", |i, y| {
        let row = format!("{},{}", 0.01 * i as f64, if i == 400 { 99.0 } else { y });
        if i == 50 { format!("{row}\n{row}") } else { row }
    });
    let desk = desk_with("log.csv", text);
    assert_eq!(missing(&desk, "log.csv --data rate").0, 77);
    assert_eq!(missing(&desk, "log.csv --data rate --remove-outliers").0, 78);
    let said = desk.done("allan log.csv --data rate").stderr;
    assert!(said.contains("left out: 1 row that repeats the row before"), "{said}");
}

#[test]
fn a_doubtful_unit_is_noted_and_the_note_can_be_silenced() {
    let text: String = noise(200).map(|y| format!("{}\n", 0.0042 + 1e-4 * y)).collect();
    let desk = desk_with("log.csv", text);
    let words = "allan log.csv --data rate --unit rad/s --rate 1Hz";
    let said = desk.done(words).stderr;
    for piece in ["may be in degrees, not in radians", "give --unit deg/s"] {
        assert!(said.contains(piece), "{piece} is missing in\n{said}");
    }
    assert!(!desk.done(&format!("{words} --unit-check off")).stderr.contains("degrees"));
}

#[test]
fn a_header_of_stable32_gives_the_sampling_step() {
    let rows: String = noise(200).map(|y| format!("{:e}\n", 1e-9 * y)).collect();
    let header = "File: PHASE.DAT\nDate: 11/23/26 10:00:00\nType: Phase\nTau: 1.0000000e-01\n# Header End\n";
    let desk = desk_with("PHASE.DAT", format!("{header}{rows}"));
    assert_eq!(missing(&desk, "PHASE.DAT --data angle --unit none"), (0, 200, 0.1));
}

#[test]
fn what_a_header_of_stable32_contradicts_is_said() {
    let rows: String = noise(200).map(|y| format!("{:e}\n", 1e-9 * y)).collect();
    let desk = desk_with("PHASE.DAT", "");
    let write =
        |lines: &str| desk.write("PHASE.DAT", &format!("File: PHASE.DAT\n{lines}# Header End\n{rows}"));
    let words = "allan PHASE.DAT --data angle --unit none --rate 10Hz";
    write("Type: Phase\nPoints: 200\nTau: 1.0e-01\n");
    let said = desk.done(words).stderr;
    assert!(!said.contains("the header") && !said.contains("in the header"), "{said}");
    write("Type: Phase\nPoints: 250\nTau: 1.0e-01\n");
    desk.fails(words, 3, &["PHASE.DAT has 200 rows, but its header states 250 points", "PHASE.DAT:3:1"]);
    for (lines, piece) in [
        (
            "Type: Phase\nTau: 1.0e+00\n",
            "the header states steps of 1 s, but the samples are taken as 0.1 s apart",
        ),
        ("Type: Frequency\nTau: 0.1\n", "stands for `data = rate`, but the samples are taken as angle"),
    ] {
        write(lines);
        let said = crate::desk::unwrapped(&desk.done(words).stderr);
        assert!(
            said.contains(piece) || said.contains(&piece.replace("`data = rate`", "--data rate")),
            "{said}"
        );
    }
}

#[test]
fn names_and_units_say_whether_angles_are_increments() {
    let desk = Desk::with("");
    let mut theta = 0.0;
    let rows: Vec<[f64; 3]> = noise(600)
        .map(|rate| {
            theta += 0.01 * rate;
            [rate, 0.01 * rate, theta]
        })
        .collect();
    let of = |name: &str, column: usize| {
        let row = |(i, row): (usize, &[f64; 3])| format!("{},{}\n", 0.01 * i as f64, row[column]);
        desk.write(
            "log.csv",
            &format!("time [s],{name}\n{}", rows.iter().enumerate().map(row).collect::<String>()),
        );
        desk.sagnac("allan log.csv --bootstrap 0 --fit N --out out")
    };
    let n = |ended: &crate::desk::Ended| {
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let row = desk.table("out/coefficients.csv").remove(0);
        row["value"].parse::<f64>().unwrap()
    };
    let rates = of("gz [deg/s]", 0);
    assert!(!rates.stderr.contains("is read as"), "{}", rates.stderr);
    let expected = n(&rates);
    for (name, column, kind) in [
        ("delta_angle_z [deg]", 1, "increment"),
        ("dtheta [deg]", 1, "increment"),
        ("theta [deg]", 2, "angle"),
    ] {
        let ended = of(name, column);
        assert!(ended.stderr.contains(&format!("`{name}` is read as --data {kind}")), "{}", ended.stderr);
        // A record of angles has one increment less.
        assert!((n(&ended) / expected - 1.0).abs() < 0.01, "{name}");
    }
    for name in ["heading [deg]", "roll angle [deg]"] {
        let attitude = of(name, 2);
        assert!(attitude.code == 3 && attitude.stderr.contains("is an angle"), "{}", attitude.stderr);
    }
    // Beside gyros without a unit, another angle is not what is measured.
    let beside = |(i, row): (usize, &[f64; 3])| format!("{},{},{}\n", 0.01 * i as f64, row[2], row[0]);
    let text = rows.iter().enumerate().map(beside).collect::<String>();
    desk.write("log.csv", &format!("time [s],heater phase [deg],gyro_x\n{text}"));
    desk.fails("allan log.csv --bootstrap 0 --out out", 3, &["gyro_x"]);
}

#[test]
fn a_raw_binary_file_is_refused_without_its_bytes_and_read_by_its_layout() {
    let rows: Vec<(usize, f64)> = lossy().collect();
    let bytes: Vec<u8> =
        rows.iter().flat_map(|(i, y)| [0.01 * *i as f64, 7.0, *y].map(f64::to_be_bytes)).flatten().collect();
    let desk = desk_with("imu.bin", bytes);
    desk.fails("allan imu.bin --data rate --unit deg/s --rate 100Hz", 3, &["imu.bin is binary", "--binary"]);
    let mut program = Command::new(PROGRAM);
    program
        .current_dir(desk.path(""))
        .args("allan imu.bin --data rate --unit deg/s --time-unit s --binary".split(' '));
    let ended = program.arg("f64 x3, big, time 1, rate 3").output().unwrap();
    let said = String::from_utf8(ended.stderr).unwrap();
    assert!(said.contains("77 of 600 samples are missing"), "{said}");
}

/// Headers of loggers with a row each, and the columns and the sampling rate that are read.
#[test]
fn headers_of_loggers_are_read_without_options() {
    const ROS: &str =
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.angular_velocity.x";
    type Row = fn(usize, f64) -> String;
    let logs: [(&str, &str, Row, &str, f64); 13] = [
        (
            "PX4",
            "timestamp,gyro_rad[0],gyro_integral_dt",
            |i, y| format!("{},{y},4000", 31_354_000 + 4000 * i),
            "gyro[0]",
            250.0,
        ),
        (
            "ArduPilot",
            "timestamp,TimeUS,I,GyrX,AccX,T",
            |i, y| format!("{:.2},{},0,{y},9.8,41.5", 1.7e9 + 0.01 * i as f64, 9_000_000 + 2500 * i),
            "GyrX",
            400.0,
        ),
        (
            "EuRoC",
            "#timestamp [ns],w_RS_S_x [rad s^-1],a_RS_S_x [m s^-2]",
            |i, y| format!("{},{y},9.81", 1_403_636_579_758_555_392 + 5_000_000 * i),
            "w_RS_S_x",
            200.0,
        ),
        (
            "ROS",
            ROS,
            |i, y| {
                format!(
                    "{},{i},{},imu_link,{y}",
                    1_593_335_798_003_000_000 + 5_000_000 * i,
                    1_593_335_798_000_000_000 + 5_000_000 * i
                )
            },
            "field.angular_velocity.x",
            200.0,
        ),
        ("Arduino", "millis,gx_dps", |i, y| format!("{},{y}", 10 * i), "gx", 100.0),
        (
            "phyphox",
            "\"Time (s)\",\"Gyroscope x (rad/s)\"",
            |i, y| format!("{:E},{y:E}", 0.005 * i as f64),
            "Gyroscope x",
            200.0,
        ),
        (
            "AndroSensor",
            "GYROSCOPE X (rad/s);Time since start in ms ;YYYY-MO-DD HH-MI-SS_SSS",
            |i, y| {
                format!(
                    "{y};{};2024-01-05 10-{:02}-{:02}_{:03}",
                    6 + 10 * i,
                    i / 6000,
                    i / 100 % 60,
                    10 * i % 1000
                )
            },
            "GYROSCOPE X",
            100.0,
        ),
        (
            "ROS 2",
            "header.stamp.sec,header.stamp.nanosec,header.frame_id,angular_velocity.x",
            |i, y| {
                let ns = 1_700_000_000_987_000_000 + 5_000_000 * i;
                format!("{},{},imu,{y}", ns / 1_000_000_000, ns % 1_000_000_000)
            },
            "angular_velocity.x",
            200.0,
        ),
        (
            "gettimeofday",
            "tv_sec,tv_usec,gz_dps",
            |i, y| format!("{},{},{y}", 1_700_000_000 + i / 400, 2500 * (i % 400) + 7),
            "gz",
            400.0,
        ),
        (
            "a clock before its date",
            "time;date;gz [deg/s]",
            |i, y| {
                let (day, second) = (24 + (i + 8_639_800) / 8_640_000, (i / 100 + 86_398) % 86_400);
                let clock = [second / 3600, second / 60 % 60, second % 60].map(|part| format!("{part:02}"));
                format!("{}.{:02};2024-01-{day};{y}", clock.join(":"), i % 100)
            },
            "gz",
            100.0,
        ),
        (
            "spreadsheet",
            "Zeit [s];Drehrate Z [°/s];Temperatur [°C]",
            |i, y| format!("{:.3};{y};21,5", 0.005 * i as f64).replace('.', ","),
            "Drehrate Z",
            200.0,
        ),
        (
            "pandas",
            ",gx_rad_s",
            |i, y| format!("2024-01-05 10:{:02}:{:02}.{:02}0000,{y}", i / 6000, i / 100 % 60, i % 100),
            "gx",
            100.0,
        ),
        (
            "OpenLog",
            "rtcDate,rtcTime,aX,gX,imu_degC,output_Hz,",
            |i, y| {
                format!("01/05/2024,23:59:{:02}.{:02},{},{y},23.56,100.0,", 50 + i / 100, i % 100, 2.0 + y)
            },
            "aX",
            100.0,
        ),
    ];
    for (logger, header, row, name, rate_hz) in logs {
        let text = noise(600)
            .enumerate()
            .fold(format!("{header}\n"), |text, (i, y)| text + &row(i, 1e-3 * y) + "\n");
        // In Latin-1, as spreadsheets write it.
        let bytes: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
        let desk = Desk::with("");
        std::fs::write(desk.path("log.csv"), bytes).unwrap();
        let ended = desk.done("allan log.csv --data rate --json");
        let document: Value = serde_json::from_str(&ended.stdout).unwrap();
        let record = &rows_of(&document, "records")[0];
        assert_eq!(record["column"].as_str(), Some(name), "{logger}");
        let rate = 1.0 / record["step_s"].as_f64().unwrap();
        assert!((rate / rate_hz - 1.0).abs() < 1e-6, "{logger}: {rate} Hz");
        assert_eq!(record["missing"].as_u64(), Some(0), "{logger}");
    }
}

#[test]
fn a_clock_in_two_cells_of_whole_seconds_shows_the_mean_rate() {
    let text = noise(3600).enumerate().fold(String::new(), |text, (i, y)| {
        let second = i / 5;
        text + &format!("2018-04-25   23:{:02}:{:02} {y:.3}   {:.3}\n", 45 + second / 60, second % 60, -y)
    });
    let desk = desk_with("log.txt", text);
    let document = |words: &str| -> Value {
        serde_json::from_str(&desk.done(&format!("allan log.txt --data rate {words} --json")).stdout).unwrap()
    };
    desk.fails(
        "allan log.txt --data rate",
        3,
        &["the file has no header", "--column 3,4, --unit UNIT", "deg/s"],
    );
    for columns in ["3-4", "all", "3,4"] {
        let found = document(&format!("--unit deg/s --column {columns}"));
        let records = rows_of(&found, "records");
        let step_s = records[0]["step_s"].as_f64();
        assert_eq!(step_s.map(|step_s| libm::round(1e6 * step_s)), Some(2e5), "{columns}");
        assert_eq!(records.len(), 2);
    }
}

#[test]
fn bursts_are_refused_with_the_mean_rate_and_leave_no_gaps_with_it() {
    // Rows come in sevens, a millisecond apart.
    let text = noise(7000).enumerate().fold("time [s],gz [dps]\n".to_owned(), |text, (i, y)| {
        text + &format!("{:.3},{y}\n", 0.07 * (i / 7) as f64 + 0.001 * (i % 7) as f64)
    });
    let desk = desk_with("log.csv", text);
    desk.fails("allan log.csv --data rate", 3, &["not evenly spaced", "the mean is 0.01 s", "--rate 100Hz"]);
    assert_eq!(missing(&desk, "log.csv --data rate --rate 100Hz"), (0, 7000, 0.01));
    assert_eq!(missing(&desk, "log.csv --data rate --rate 10ms"), (0, 7000, 0.01));
}

#[test]
fn rounded_and_coarse_clocks_show_the_rate_of_their_samples_and_no_gaps() {
    type Stamp = fn(usize) -> String;
    let clocks: [(&str, usize, f64, Stamp); 4] = [
        ("ms beside 952 Hz", 5000, 952.0, |i| format!("{:.3}", i as f64 / 952.0)),
        ("10 ms beside 99.5 Hz", 5000, 99.5, |i| format!("{:.2}", i as f64 / 99.5)),
        ("whole seconds of 100 Hz", 1500, 100.0, |i| format!("{}", i / 100)),
        ("whole seconds of 200 Hz", 1000, 200.0, |i| format!("{}", i / 200)),
    ];
    for (clock, count, rate_hz, stamp) in clocks {
        let text = noise(count)
            .enumerate()
            .fold("time [s],gz [deg/s]\n".to_owned(), |text, (i, y)| text + &format!("{},{y}\n", stamp(i)));
        let desk = desk_with("log.csv", text);
        let keep = if clock.starts_with("whole") { " --duplicates keep" } else { "" };
        for words in [String::new(), format!(" --rate {rate_hz}Hz{keep}")] {
            let (missing, samples, step_s) = missing(&desk, &format!("log.csv --data rate{words}"));
            assert_eq!((missing, samples), (0, count as u64), "{clock}{words}");
            assert!((step_s * rate_hz - 1.0).abs() < 5e-4, "{clock}{words}: {} Hz", 1.0 / step_s);
        }
    }
}

#[test]
fn stamps_that_a_spreadsheet_has_rounded_are_refused_with_what_reads_the_log_without_them() {
    let text = noise(600).fold("#timestamp [ns],w_RS_S_x [rad s^-1]\n".to_owned(), |text, y| {
        text + &format!("1.40364E+18,{y}\n")
    });
    let desk = desk_with("log.csv", text);
    let pieces = ["`timestamp` has lost its digits: 599 of 600 rows", "--time none and --rate HZ"];
    desk.fails("allan log.csv --data rate", 3, &pieces);
    desk.fails("allan log.csv --data rate --rate 200Hz", 3, &["has lost its digits", "with --time none"]);
    assert_eq!(missing(&desk, "log.csv --data rate --rate 200Hz --time none"), (0, 600, 0.005));
}

#[test]
fn a_short_log_with_a_coarse_clock_says_what_its_few_times_do_not_tell() {
    let log = |count: usize, is_kept: &dyn Fn(usize) -> bool| {
        let rows = noise(count).enumerate().filter(|(i, _)| is_kept(*i));
        rows.fold("time [s],gz [deg/s]\n".to_owned(), |text, (i, y)| {
            text + &format!("{},{y}\n", 1_690_000_012 + i / 200)
        })
    };
    let desk = desk_with("log.csv", log(1000, &|_| true));
    let said = desk.done("allan log.csv --data rate").stderr;
    assert!(said.contains("only 5 different times, too few to tell whether samples are missing"), "{said}");
    // 2 % lost at random places of 30 s.
    let places: Vec<f64> = noise(6000).collect();
    let desk = desk_with("log.csv", log(6000, &|i| places[(i * 7 + 3) % 6000].abs() > 0.02));
    desk.fails(
        "allan log.csv --data rate",
        3,
        &["does not tell for sure which samples are missing", "as --rate HZ"],
    );
    desk.write("log.csv", &log(6000, &|_| true));
    let said = desk.done("allan log.csv --data rate").stderr;
    assert!(!said.contains("which samples are missing"), "{said}");
}

#[test]
fn counters_of_any_size_show_what_is_missing() {
    let lost = [200, 201, 600, 900, 1200, 1300];
    for (name, limit) in [("count", 256), ("PacketCounter", 65_536)] {
        let rows = noise(1506).enumerate().filter(|(i, _)| !lost.contains(i));
        let text = rows.fold(format!("{name},gz [dps]\n"), |text, (i, y)| {
            text + &format!("{},{y}\n", (i + 65_000) % limit)
        });
        let desk = desk_with("log.csv", text);
        assert_eq!(missing(&desk, "log.csv --data rate --column gz --rate 100Hz"), (6, 1506, 0.01), "{name}");
    }
}

#[test]
fn an_empty_time_is_missing_in_its_row_only() {
    let text = noise(600).enumerate().fold("time,gz [deg/s]\n".to_owned(), |text, (i, y)| match i {
        30 => text + &format!(",{y}\n"),
        _ => text + &format!("2024-01-05 10:00:{:02}.{:02},{y}\n", i / 100, i % 100),
    });
    desk_with("log.csv", text).fails("allan log.csv --data rate", 3, &["the time is missing", "log.csv:32"]);
}

#[test]
fn rests_of_seconds_are_added_or_refused_but_not_dropped() {
    let log = |row: &dyn Fn(usize) -> String| {
        noise(600)
            .enumerate()
            .fold("sec,ms,gz [dps]\n".to_owned(), |text, (i, y)| text + &format!("{},{y}\n", row(i)))
    };
    let carried =
        |i: usize| if i == 300 { "2,1000".to_owned() } else { format!("{},{}", i / 100, 10 * (i % 100)) };
    let whole = |i: usize| format!("{},{}", i / 100, 10 * i);
    for (name, row) in [("carried", &carried as &dyn Fn(usize) -> String), ("whole", &whole)] {
        let desk = desk_with("log.csv", log(row));
        assert_eq!(missing(&desk, "log.csv --data rate --column gz").1, 600, "{name}");
    }
    let falling = |i: usize| format!("{},{}", i / 100, 90_000 - 10 * i);
    desk_with("log.csv", log(&falling)).fails(
        "allan log.csv --data rate --column gz",
        3,
        &["no rests of the seconds"],
    );
}

#[test]
fn increments_over_a_part_of_each_step_are_those_of_the_whole_step() {
    let text = noise(600)
        .enumerate()
        .fold("timestamp,delta_angle[0],delta_angle_dt\n".to_owned(), |text, (i, y)| {
            text + &format!("{},{},4000\n", 354_000 + 500_000 * i, 4e-6 * y)
        });
    let desk = desk_with("log.csv", text);
    let ended = desk.done("allan log.csv --data increment --json");
    let document: Value = serde_json::from_str(&ended.stdout).unwrap();
    desk.write(
        "rate.csv",
        &noise(600).fold("gz [rad/s]\n".to_owned(), |text, y| text + &format!("{}\n", 1e-3 * y)),
    );
    let rate: Value =
        serde_json::from_str(&desk.done("allan rate.csv --data rate --rate 2Hz --json").stdout).unwrap();
    let first = |document: &Value| rows_of(document, "curve")[0]["value"].as_f64().unwrap();
    assert!((first(&document) / first(&rate) - 1.0).abs() < 1e-6);
    desk.write("gap.csv", &desk.read("log.csv").replacen(",4000\n", ",0\n", 3));
    assert_eq!(missing(&desk, "gap.csv --data increment").0, 3, "an increment over no time is none");
    let said = desk.done("allan log.csv --data increment").stderr;
    assert!(said.contains("0.004 s, but 0.5 s apart"), "{said}");
}
