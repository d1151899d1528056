//! The columns and units that are taken from a log without options, and the questions where they are not clear.

use crate::desk::{Desk, rows_of};
use crate::logs::{desk_with, noise};
use serde_json::Value;

/// A log of 600 rows below `header`.
fn log(header: &str, row: impl Fn(usize, f64) -> String) -> Desk {
    let rows = noise(600).enumerate().map(|(i, y)| row(i, 1e-3 * y) + "\n");
    desk_with("log.csv", format!("{header}\n{}", rows.collect::<String>()))
}

fn document(desk: &Desk, words: &str) -> Value {
    let ended = desk.done(&format!("allan log.csv {words} --fit none --json"));
    serde_json::from_str(&ended.stdout).unwrap()
}

/// The notes.
fn said(desk: &Desk, words: &str) -> String {
    desk.done(&format!("allan log.csv {words} --fit none")).stderr
}

/// The columns that are read, and the sampling rate.
fn read(desk: &Desk, words: &str) -> (Vec<String>, f64) {
    let document = document(desk, words);
    let records = rows_of(&document, "records");
    let names = records.iter().map(|record| record["column"].as_str().unwrap().to_owned()).collect();
    (names, 1.0 / records[0]["step_s"].as_f64().unwrap())
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
    let said = said(&desk, "--data rate");
    assert!(said.contains("left out, as the length of a vector: Absolute"), "{said}");
    assert_eq!(read(&desk, "--data rate --column Absolute").0, ["Absolute"]);
}

#[test]
fn the_unit_of_a_logger_is_taken_only_if_it_gives_the_rate_of_a_sensor() {
    type Stamp = fn(usize) -> String;
    let since_1970: Stamp = |i| format!("{:.3}", 1.7e9 + 0.005 * i as f64);
    let ms: Stamp = |i| (5 * i).to_string();
    let ms_since_1970: Stamp = |i| (1_700_000_000_000 + 5 * i).to_string();
    let seconds: Stamp = |i| format!("{:.3}", 0.005 * i as f64);
    for (header, stamp, unit) in [
        ("time,angular_velocity.x", ms, Some("ms")),
        ("stamp,angular_velocity.x", |i| (5000 * i).to_string(), Some("us")),
        ("timestamp,gyro_rad[0]", ms, Some("ms")),
        ("timestamp,gyro_rad[0]", seconds, Some("s")),
        ("time,angular_velocity.x", seconds, Some("s")),
        ("time,angular_velocity.x", since_1970, None),
        ("timestamp,gyro_rad[0]", ms_since_1970, None),
        ("timestamp,gyro_rad[0]", |i| (354_000 + 5000 * i).to_string(), None),
        ("time,angular_velocity.x", |i| (1_700_000_000_000_000_000 + 5_000_000 * i).to_string(), None),
    ] {
        let desk = log(header, |i, y| format!("{},{y}", stamp(i)));
        if let Some(unit) = unit {
            let pieces = ["not in the unit of this logger", &format!("--time-unit {unit} for 200 Hz")];
            desk.fails("allan log.csv --data rate", 3, &pieces);
        }
        let option = unit.map_or(String::new(), |unit| format!("--time-unit {unit}"));
        assert_rate(read(&desk, &format!("--data rate {option}")).1, 200.0, header);
    }
}

#[test]
fn a_stated_unit_that_contradicts_times_since_1970_is_refused_with_theirs() {
    for (header, first, step, unit) in [
        ("time [ns],gz [deg/s]", 1_700_000_000_000_000_usize, 10_000, "us"),
        ("time [us],gz [deg/s]", 1_700_000_000_000, 10, "ms"),
        ("time [ms],gz [deg/s]", 1_700_000_000_000_000, 10_000, "us"),
        ("time [s],gz [deg/s]", 1_700_000_000_000, 10, "ms"),
    ] {
        let desk = log(header, |i, y| format!("{},{y}", first + step * i));
        let pieces = [format!("{unit} since 1970: 100 Hz, not"), format!("--time-unit {unit}")];
        desk.fails("allan log.csv --data rate", 3, &pieces.each_ref().map(String::as_str));
        assert_rate(read(&desk, &format!("--data rate --time-unit {unit}")).1, 100.0, header);
    }
    let desk = log("time [ms],gz [deg/s]", |i, y| format!("{:.2},{y}", 1.7e9 + 0.01 * i as f64));
    desk.fails("allan log.csv --data rate", 3, &["s since 1970: 100 Hz, not 100000 Hz", "--time-unit s"]);
    // Twelve days after the start of a device.
    let desk = log("time [us],gz [deg/s]", |i, y| format!("{},{y}", 1_100_000_000_000_usize + 2500 * i));
    assert_rate(read(&desk, "--data rate").1, 400.0, "us since a start");
    let desk = log("time [us],gz [deg/s]", |i, y| format!("{},{y}", 1_100_000_000_000_usize + 1000 * i));
    desk.fails("allan log.csv --data rate", 3, &["1 Hz, not 1000 Hz", "or else its own unit"]);
    assert_rate(read(&desk, "--data rate --time-unit us").1, 1000.0, "a unit that is given");
}

#[test]
fn all_units_of_times_that_give_the_rate_of_a_sensor_are_proposed() {
    for (header, step, proposed) in [
        ("time,gz_dps", 1000, "--time-unit ms for 1 Hz or --time-unit us for 1000 Hz;"),
        ("time,gz_dps", 2, "--time-unit s for 0.5 Hz or --time-unit ms for 500 Hz;"),
        ("TimeUS,gz_dps", 1000, "as in --time-unit us for 1000 Hz;"),
    ] {
        let desk = log(header, |i, y| format!("{},{y}", 5000 + step * i));
        desk.fails("allan log.csv --data rate", 3, &["has no unit", proposed]);
    }
}

/// The first deviation of the first column.
fn first(desk: &Desk) -> f64 {
    rows_of(&document(desk, "--data increment"), "curve")[0]["value"].as_f64().unwrap()
}

#[test]
fn increments_are_scaled_only_by_the_span_over_which_they_were_summed() {
    let plain = first(&log("time [s],dx [arcsec]", |i, y| format!("{:.2},{y:.9}", 0.01 * i as f64)));
    for (header, span, factor, note) in [
        ("dx [arcsec],latency_ms", "0.1", 1.0, ""),
        ("dx [arcsec],temp_period [s]", "5", 1.0, ""),
        ("dx [arcsec],gyro_dt [ms]", "4", 1.0, ""),
        ("dx [arcsec],interval [ms]", "4", 1.0, ""),
        ("dx [arcsec],dt", "12000", 1.0, "`dt` has no unit of time that fits the sampling step of 0.01 s"),
        ("dx [arcsec],dt [ms]", "40", 1.0, "`dt [ms]` is longer than the sampling step of 0.01 s"),
        ("dx [arcsec],dt", "4", 2.5, "are those of 0.004 s, but 0.01 s apart"),
        ("dx [arcsec],delta_t [us]", "100", 100.0, "are those of 0.0001 s, but 0.01 s apart"),
        ("gyro_x [arcsec],gyro_interval [ms]", "5", 2.0, "are those of 0.005 s, but 0.01 s apart"),
    ] {
        let desk = log(&format!("time [s],{header}"), |i, y| format!("{:.2},{y:.9},{span}", 0.01 * i as f64));
        let ratio = first(&desk) / plain;
        assert!((ratio / factor - 1.0).abs() < 1e-9, "{header}: {ratio} times instead of {factor}");
        let said = said(&desk, "--data increment");
        assert!(said.contains(note), "{header}: {note} is missing in\n{said}");
        assert_eq!(said.contains("increments are"), !note.is_empty(), "{header}: {said}");
    }
}

#[test]
fn rows_of_several_sensors_in_turn_are_no_series() {
    // Of two sensors at 400 Hz, at the same times or 40 µs apart.
    for apart_us in [0, 40] {
        let desk = log("timestamp,TimeUS,I,GyrX", |i, y| {
            let us = 9_000_000 + 2500 * (i / 2) + apart_us * (i % 2);
            format!("{:.2},{us},{},{y}", 1.7e9 + 1e-6 * us as f64, i % 2)
        });
        for words in ["", "--rate 800Hz", "--duplicates keep"] {
            let pieces = ["the rows are in turn of 2 sensors: `I` is 0, 1", "a file of its own"];
            desk.fails(&format!("allan log.csv --data rate {words}"), 3, &pieces);
        }
        assert_rate(read(&desk, "--data rate --time none --rate 800Hz").1, 800.0, "without stamps");
    }
    // One sensor, and a number that counts rows.
    for id in [|_: usize| 3, |i| i % 256] {
        let desk = log("time [s],id,gz [dps]", |i, y| format!("{:.4},{},{y}", 0.0025 * i as f64, id(i)));
        assert_rate(read(&desk, "--data rate").1, 400.0, "one sensor");
    }
}

#[test]
fn all_columns_are_those_with_samples_of_such_data() {
    let header = "time [s],gx [dps],gy [dps],mx [uT],status,device_id,gz [dps],temp";
    let desk =
        log(header, |i, y| format!("{:.3},{y},{},{y},{},2490378,0,21.5", 0.005 * i as f64, 2.0 * y, i % 3));
    assert_eq!(read(&desk, "--data rate --column all").0, ["gx", "gy"]);
    let said = said(&desk, "--data rate --column all");
    for piece in ["of such data are left out: mx, status, device_id, temp", "equal ones, are left out: gz"] {
        assert!(said.contains(piece), "{piece} is missing in\n{said}");
    }
    let desk = log("time [s],temp", |i, y| format!("{:.3},{y}", 0.005 * i as f64));
    let pieces = ["no column seems to have samples", "1 time [s], 2 temp"];
    desk.fails("allan log.csv --data rate --column all", 3, &pieces);
    let desk = log("time [s],mx [uT],my [uT]", |i, y| format!("{:.3},{y},{y}", 0.005 * i as f64));
    desk.fails("allan log.csv --data rate --column all", 3, &["uT", "accepted"]);
}

#[test]
fn a_bias_in_a_stated_unit_is_no_reason_to_doubt_it() {
    // 20.6 and 862 °/h, the latter the Earth's rate if it is in degrees.
    for (header, bias, words, is_doubted) in [
        ("time [s],gz [rad/s]", 1e-4, "", false),
        ("time [s],gz_rad_s", 1e-4, "", false),
        ("time [s],gz", 1e-4, "--unit rad/s", false),
        ("time [s],gyro_rad", 1e-4, "", true),
        ("time [s],gyro_rad", 1e-4, "--unit rad/s", false),
        ("time [s],gz [rad/s]", 15.04 / 3600.0, "", true),
        ("time [s],gz [deg/s]", 15.04 / 3600.0, "", false),
    ] {
        let desk = log(header, |i, y| format!("{:.3},{:.9}", 0.005 * i as f64, bias + 1e-2 * y));
        let said = said(&desk, &format!("--data rate {words}"));
        assert_eq!(said.contains("may be in degrees"), is_doubted, "{header} {words}:\n{said}");
    }
    let desk = log("timestamp,gyro_rad[0]", |i, y| format!("{},{:.9}", 5000 * i, 1e-4 + 1e-2 * y));
    let said = said(&desk, "--data rate");
    assert!(!said.contains("may be in degrees"), "the unit of a known logger:\n{said}");
}

#[test]
fn a_rate_that_the_stamps_contradict_is_refused_with_theirs() {
    let at = |rate_hz: f64| {
        let rows = noise(600).enumerate().map(|(i, y)| format!("{:.4},{y},{y}\n", i as f64 / rate_hz));
        rows.fold("time [s],Gyroscope x [dps],b [dps]\n".to_owned(), |text, row| text + &row)
    };
    let desk = desk_with("log.csv", at(200.0));
    desk.write("slow.csv", &at(100.0).replace("Gyroscope x", "Drehrate"));
    let column = "--data rate --column 2";
    for rate in ["100Hz", "170Hz", "230Hz"] {
        let pieces = ["the stamps are 0.005 s apart", "--rate 200Hz", "--time none"];
        desk.fails(&format!("allan log.csv {column} --rate {rate}"), 3, &pieces);
        assert!(read(&desk, &format!("{column} --rate {rate} --time none")).1 > 90.0);
    }
    assert_rate(read(&desk, &format!("{column} --rate 190Hz")).1, 190.0, "a clock 5 % off");
    let pieces = ["slow.csv", "the stamps are 0.01 s apart", "--rate 100Hz"];
    desk.fails(&format!("compare log.csv slow.csv {column} --rate 200Hz"), 3, &pieces);
    desk.done(&format!("compare log.csv slow.csv {column} --rate 200Hz,100Hz"));
    desk.fails(&format!("allan log.csv {column} --rate 200Hz,100Hz"), 2, &["--rate has several values"]);
    let proposed = "as in --column \"Gyroscope x,Drehrate\"";
    desk.fails("compare log.csv slow.csv --data rate", 3, &["several columns", proposed]);
}

#[test]
fn loggers_are_read_without_options_or_asked_with_their_units() {
    type Row = fn(usize, f64) -> String;
    let logs: [(&str, Row, &[&str], f64); 4] = [
        (
            "PacketCounter,SampleTimeFine,Year,Month,Day,Second,Gyr_X,StatusWord",
            |i, y| format!("{i},{},2024,1,5,3,{y},7", 4_294_960_000 + 100 * i),
            &["Gyr_X"],
            100.0,
        ),
        (
            "TimeStartup,GpsTow,AngularRateX,AccelX",
            |i, y| format!("{},4.0,{y},{}", 1_000_000_000 + 5_000_000 * i, 9.8 + y),
            &["AngularRateX", "AccelX"],
            200.0,
        ),
        (
            "timestamp,TimeUS,I,SampleUS,GyrX",
            |i, y| format!("{},{},0,{},{y}", 1.7e9, 9_000_000 + 20_000 * (i / 8), 9_000_000 + 2500 * i),
            &["GyrX"],
            400.0,
        ),
        (
            "seconds_elapsed [s],gFx,wx",
            |i, y| format!("{:.3},{},{y}", 0.01 * i as f64, 0.1 + y),
            &["gFx", "wx"],
            100.0,
        ),
    ];
    for (header, row, names, rate_hz) in logs {
        let desk = log(header, row);
        let (found, rate) = read(&desk, "--data rate");
        assert_eq!(found, names, "{header}");
        assert_rate(rate, rate_hz, header);
    }
    let header = "timestamp,timestamp_sample,device_id,x,temperature,error_count,clip_counter[0]";
    let desk = log(header, |i, y| format!("{0},{0},2490378,{y},21.5,0,0", 354_000 + 2500 * i));
    let pieces = ["--column x:", "the unit of `x` is missing", "of PX4, a gyro has --unit rad/s"];
    desk.fails("allan log.csv --data rate", 3, &pieces);
    assert_rate(read(&desk, "--data rate --column x --unit rad/s").1, 400.0, header);
    let header = "time,seconds_elapsed,z,y,x";
    let desk = log(header, |i, y| {
        format!("{},{:.3},{y},{y},{y}", 1_700_000_000_000_000_000 + 5_000_000 * i, 0.005 * i as f64)
    });
    let pieces = ["--column z,y,x:", "of Sensor Logger, a gyro has --unit rad/s"];
    desk.fails("allan log.csv --data rate", 3, &pieces);
}

#[test]
fn headers_that_two_makers_share_are_told_apart_or_refused_with_both() {
    let header = "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Gyr_X";
    let of = |header: &str, step: usize| {
        log(header, |i, y| format!("{i},{},{y},{},{y}", 1_234_567 + step * i, 9.8 + y))
    };
    for (above, step, maker, unit, rate_hz) in [
        ("", 16_667, "Xsens DOT", "deg/s", 1e6 / 16_667.0),
        ("", 100, "Xsens MT Manager", "rad/s", 100.0),
        ("sep=,\nDeviceTag:,D422CD\nOutputRate:,120Hz\n\n", 8333, "Xsens DOT", "deg/s", 1e6 / 8333.0),
    ] {
        let desk = of(&format!("{above}{header}"), step);
        let said = said(&desk, "--data rate");
        assert!(said.contains(&format!("the header is that of {maker}")), "steps of {step}: {said}");
        assert!(said.contains(&format!("Gyr_X {unit}")), "steps of {step}: {said}");
        assert_rate(read(&desk, "--data rate").1, rate_hz, above);
    }
    let desk = of(header, 10_000);
    let pieces = [
        "that of Xsens MT Manager and of Xsens DOT, which differ in units",
        "--column Gyr_X",
        "--time-unit \"0.1 ms\" with --unit rad/s for Xsens MT Manager, which makes 1 Hz",
        "--time-unit us with --unit deg/s for Xsens DOT, which makes 100 Hz",
    ];
    desk.fails("allan log.csv --data rate", 3, &pieces);
    desk.fails("allan log.csv --data rate --rate 100Hz", 3, &pieces);
    assert_rate(read(&desk, "--data rate --column Gyr_X --time-unit us --unit deg/s").1, 100.0, header);
}

#[test]
fn all_that_a_file_without_a_header_leaves_open_is_one_question() {
    let desk = |first: fn(usize) -> String| {
        let rows = noise(600).enumerate().map(|(i, y)| format!("{},{y},{}\n", first(i), -y));
        desk_with("log.csv", rows.collect::<String>())
    };
    let even = desk(|i| format!("{:.3}", 0.01 * i as f64));
    let pieces = [
        "the file has no header: say what its 3 columns are",
        "--time 1 with --time-unit s for 100 Hz",
        "--column 2,3",
        "--unit UNIT",
        "deg/s",
    ];
    even.fails("allan log.csv --data rate", 3, &pieces);
    even.fails("allan log.csv --data rate --column 2,3", 3, &[pieces[0], pieces[1], pieces[3]]);
    let one = ["the time column `1` has no unit", "--time-unit s for 100 Hz"];
    even.fails("allan log.csv --data rate --column 2,3 --unit dps", 3, &one);
    for time in ["--time 1 --time-unit s", "--time-unit s", "--rate 100Hz"] {
        let (names, rate_hz) = read(&even, &format!("--data rate {time} --column 2,3 --unit dps"));
        assert_eq!(names, ["2", "3"], "{time}");
        assert_rate(rate_hz, 100.0, time);
    }
    let without = desk(|i| format!("{}", i * 37 % 11));
    let pieces = ["--rate HZ, the rate of your logger, --column 1,2,3, --unit UNIT"];
    without.fails("allan log.csv --data rate", 3, &pieces);
}

#[test]
fn seconds_and_nanoseconds_without_names_are_times_and_no_gyros() {
    let rows = noise(600).enumerate().map(|(i, y)| {
        let ns = 1_690_000_012_987_528_132_u64 + 5_000_000 * i as u64;
        format!("{},{},imu,0,1,{y},{}\n", ns / 1_000_000_000, ns % 1_000_000_000, 9.8 + y)
    });
    let desk = desk_with("log.csv", rows.collect::<String>());
    let pieces = ["--column 6,7, --unit UNIT", "the times are taken from columns 1 and 2"];
    desk.fails("allan log.csv --data rate", 3, &pieces);
    let (names, rate_hz) = read(&desk, "--data rate --column 6,7 --unit rad/s,m/s^2");
    assert_eq!(names, ["6", "7"]);
    assert_rate(rate_hz, 200.0, "seconds and nanoseconds");
}

#[test]
fn only_gyros_are_read_where_names_tell_them() {
    let row = |i: usize, y: f64| format!("{:.3},{y},{y},{},{}", 0.01 * i as f64, 9.8 + y, 7 * i);
    let desk = log("time [s],gx,gy,az,ticks", row);
    desk.fails("allan log.csv --data rate", 3, &["the unit of `gx` is missing"]);
    assert_eq!(read(&desk, "--data rate --unit deg/s").0, ["gx", "gy"]);
    let desk = log("time [s],p,q,r,ticks", row);
    let pieces = ["as in --column p,q,r: 1 time [s]", "give one unit for each, as in --unit rad/s,m/s^2"];
    desk.fails("allan log.csv --data rate", 3, &pieces);
}

#[test]
fn times_of_matlab_with_their_unit_are_read_and_other_texts_are_named() {
    let desk = log("Time,gx_dps", |i, y| format!("{} sec,{y}", i as f64 / 100.0));
    assert_rate(read(&desk, "--data rate").1, 100.0, "a timetable");
    let desk = log("Time,gx_dps", |i, y| format!("day {i},{y}"));
    let pieces = ["the time column `Time` holds text that is neither a number nor a time", "--rate HZ"];
    desk.fails("allan log.csv --data rate", 3, &pieces);
}

#[test]
fn a_measurement_of_labview_is_read_below_its_headers() {
    let header = "LabVIEW Measurement\t\nDecimal_Separator\t,\n***End_of_Header***\t\n\t\nChannels\t1\n\
                  ***End_of_Header***\nX_Value\tgz (deg/s)\tComment";
    let desk = log(header, |i, y| format!("{:.3}\t{y:.9}", 0.01 * i as f64).replace('.', ","));
    let (names, rate_hz) = read(&desk, "--data rate");
    assert_eq!(names, ["gz"]);
    assert_rate(rate_hz, 100.0, header);
    let said = said(&desk, "--data rate");
    assert!(said.contains("a measurement of LabVIEW, whose numbers begin in line 8"), "{said}");
}

#[test]
fn logs_of_kalibr_have_its_units() {
    let desk = log("timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z", |i, y| {
        let a = 9.8 + y;
        format!("{},{y},{y},{y},{a},{a},{a}", 1_385_030_208_736_666_462_u64 + 5_000_000 * i as u64)
    });
    let said = said(&desk, "--data rate");
    assert!(said.contains("that of Kalibr") && said.contains("alpha_z m/s^2"), "{said}");
    let (names, rate_hz) = read(&desk, "--data rate");
    assert_eq!(names, ["omega_x", "omega_y", "omega_z", "alpha_x", "alpha_y", "alpha_z"]);
    assert_rate(rate_hz, 200.0, "Kalibr");
}

#[test]
fn a_german_sheet_is_read_below_its_titles() {
    let header =
        "Messung Kreisel 3;;;\nDatum: 27.06.2024;;;\n\nZeit;Drehrate (°/h);Temperatur (°C);Bemerkung";
    let text = noise(600).enumerate().fold(format!("{header}\n"), |text, (i, y)| {
        let row = format!("{:02}:{:02}.{}00;{:.3};22.00;", i / 600, i / 10 % 60, i % 10, 60.0 + y);
        text + "27.06.2024 14:" + &row.replace('.', ",") + "\n"
    });
    let bytes = |text: &str| text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect::<Vec<u8>>();
    let desk = desk_with("log.csv", bytes(&text));
    let (found, rate_hz) = read(&desk, "--data rate");
    assert_eq!(found, ["Drehrate"]);
    assert_rate(rate_hz, 10.0, header);
    std::fs::write(desk.path("log.csv"), bytes(&text.replace("°/h", "°/y"))).unwrap();
    desk.fails("allan log.csv --data rate --column 2", 3, &["Drehrate (°/y);Temperatur (°C)"]);
}

#[test]
fn text_in_utf_16_is_to_be_saved_as_utf_8() {
    let text: Vec<u8> =
        "\u{feff}time [s],gz [dps]\n0,1\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    desk_with("log.csv", text).fails("allan log.csv --data rate", 3, &["text in UTF-16", "save it as UTF-8"]);
}

#[test]
fn numbers_of_columns_comments_among_rows_and_appended_recordings_are_no_samples() {
    let rows: String = noise(200).map(|y| format!("{y:.4},{:.4}\n", 0.5 * y)).collect();
    let indexed: String = rows.lines().enumerate().map(|(i, row)| format!("{i},{row}\n")).collect();
    let read = "--data rate --rate 1Hz --unit deg/h --fit none --column";
    for (text, column) in [(format!("0,1\n{rows}"), "1"), (format!(",0,1\n{indexed}"), "2")] {
        let desk = desk_with("log.csv", text);
        let ended = desk.done(&format!("allan log.csv {read} {column}"));
        assert!(ended.stdout.contains("log.csv: 200 samples"), "{}", ended.stdout);
        assert!(ended.stderr.contains("numbers of the columns"), "{}", ended.stderr);
    }
    let commented = rows.replacen('\n', "\n# 0.5,0.25\n", 3);
    let desk = desk_with("log.csv", commented);
    let ended = desk.done("allan log.csv --data rate --rate 1Hz --unit deg/h --fit none --column 1");
    assert!(ended.stderr.contains("3 lines among the rows are comments"), "{}", ended.stderr);
    let one = std::fs::read(format!("{}/tests/data/formats/imu.mcap", crate::ROOT)).unwrap();
    std::fs::write(desk.path("two.mcap"), [&one[..], &one].concat()).unwrap();
    desk.fails("allan two.mcap --data rate", 3, &["goes on behind the end of its recording"]);
}
