//! `sagnac allan` as a user meets it: logs good and bad, files, messages and exit codes.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

const PHASE: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/allan/PHASE.DAT"));

const RATE: &str = "--data rate --unit deg/h --rate 1Hz";

/// A folder of its own, and what the program does there.
struct Desk(TempDir);

/// How a command ended.
struct Ended {
    code: i32,
    stdout: String,
    stderr: String,
}

impl Desk {
    fn with(name: &str, bytes: impl AsRef<[u8]>) -> Desk {
        let desk = Desk(TempDir::new().unwrap());
        std::fs::write(desk.path(name), bytes).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Runs `sagnac allan` with `words` as its arguments; `_` stands for a blank in one.
    fn allan(&self, words: &str) -> Ended {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sagnac"));
        let words: Vec<String> = words.split_whitespace().map(|word| word.replace('_', " ")).collect();
        command.current_dir(self.0.path()).arg("allan").args(&words);
        let output = command.timeout(Duration::from_secs(60)).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let (stdout, stderr) = (text(output.stdout), text(output.stderr));
        assert!(!stderr.contains("panicked"), "{words:?} panicked:\n{stderr}");
        Ended { code: output.status.code().unwrap(), stdout, stderr }
    }

    fn done(&self, words: &str) -> Ended {
        let ended = self.allan(words);
        assert_eq!(ended.code, 0, "allan {words}\n{}", ended.stderr);
        ended
    }

    fn fails(&self, words: &str, code: i32, pieces: &[&str]) {
        let ended = self.allan(words);
        assert_eq!((ended.code, ended.stdout.as_str()), (code, ""), "allan {words}\n{}", ended.stderr);
        // Without the frame and the line breaks that a terminal's width gives.
        let said = ended.stderr.replace(['│', '×'], " ").split_whitespace().collect::<Vec<_>>().join(" ");
        for piece in pieces {
            assert!(said.contains(piece), "`{piece}` is missing after `allan {words}`:\n{}", ended.stderr);
        }
        assert!(!self.path("results").exists(), "allan {words} left results");
    }

    fn curve(&self, folder: &str) -> Vec<BTreeMap<String, String>> {
        let text = self.read(&format!("{folder}/curve.csv"));
        csv::Reader::from_reader(text.as_bytes()).deserialize().map(Result::unwrap).collect()
    }
}

/// Deterministic numbers between −1 and 1.
fn noise(count: usize) -> impl Iterator<Item = f64> {
    let mut n: u64 = 1_234_567_890;
    (0..count).map(move |_| {
        n = 16807 * n % 2_147_483_647;
        2.0 * n as f64 / 2_147_483_647.0 - 1.0
    })
}

fn rows(row: impl Fn(usize, f64) -> String) -> String {
    noise(200).enumerate().map(|(i, y)| row(i, y) + "\n").collect()
}

/// `time [ms],gx [deg/s],gz [deg/s]`, 100 Hz.
fn log() -> String {
    format!(
        "time [ms],gx [deg/s],gz [deg/s]\n{}",
        rows(|i, y| format!("{},{},{}", 10 * i, y, 2.0 * y + 0.004))
    )
}

#[test]
fn a_stable32_file_gives_stable32s_numbers_in_table_csv_json_and_pictures() {
    let desk = Desk::with("PHASE.DAT", PHASE);
    let words = "PHASE.DAT --data angle --unit none --rate 1Hz --deviation oadev,tdev --confidence 0.683";
    let ended = desk.done(words);
    for piece in ["1001 samples at 1 Hz", "0.10570", "68.3 % intervals", "time deviation", "in-run stability"]
    {
        assert!(
            ended.stdout.contains(piece.trim_end_matches('0')),
            "{piece} is missing in\n{}",
            ended.stdout
        );
    }
    let curve = desk.curve("results/PHASE");
    let row = curve.iter().find(|row| row["deviation"] == "oadev" && row["m"] == "8").unwrap();
    assert_eq!((row["terms"].as_str(), row["alpha"].as_str(), row["tau_s"].as_str()), ("985", "0", "8"));
    for (name, expected) in [("lower", 0.10038), ("value", 0.10570), ("upper", 0.11198)] {
        let found: f64 = row[name].parse().unwrap();
        assert!((found / expected - 1.0).abs() < 1e-3, "{name}: {found}, not {expected}");
    }
    assert!(curve.iter().filter(|row| row["m"] == "64").all(|row| row["alpha_from"] == "carried"));
    assert!(curve.iter().all(|row| row["treatment"] == "no trend removed" && row["unit"].is_empty()));
    for name in ["chart.svg", "chart.png", "chart-tdev.svg", "chart-tdev.png"] {
        assert!(desk.path("results/PHASE").join(name).exists(), "{name}");
    }
    let document: Value = serde_json::from_str(&desk.done(&format!("{words} --json")).stdout).unwrap();
    let point = &document["columns"][0]["curves"][0]["points"][3];
    assert_eq!((point["m"].as_u64(), point["terms"].as_u64()), (Some(8), Some(985)));
    // Without a time deviation its chart of before would be a lie.
    desk.done("PHASE.DAT --data angle --unit none --rate 1Hz --quiet");
    assert!(!desk.path("results/PHASE/chart-tdev.png").exists());
}

#[test]
fn the_header_of_the_csv_is_the_documented_one() {
    let desk = Desk::with("log.csv", log());
    desk.done("log.csv --data rate --time time --column gz --out out");
    let header = "column,deviation,m,tau_s,terms,alpha,lower,value,upper,unit,alpha_from,treatment";
    assert_eq!(desk.read("out/curve.csv").lines().next(), Some(header));
}

#[test]
fn axes_times_and_units_come_from_the_header_and_the_rate_is_in_degrees_per_hour() {
    let desk = Desk::with("log.csv", log());
    desk.done("log.csv --data rate --time time --column gx,gz --out out");
    let curve = desk.curve("out");
    let value = |column: &str, m: &str| -> f64 {
        let row = curve.iter().find(|row| row["column"] == column && row["m"] == m).unwrap();
        assert_eq!(row["unit"], "deg/h");
        row["value"].parse().unwrap()
    };
    assert!((value("gz", "4") / value("gx", "4") - 2.0).abs() < 1e-6);
    // Uniform noise in −1 … 1 °/s: 3600/√3 °/h.
    assert!((value("gx", "1") / (3600.0 / 3.0_f64.sqrt()) - 1.0).abs() < 0.2, "{}", value("gx", "1"));
    let svg = desk.read("out/chart.svg");
    for piece in [">gx<", ">gz<", "°/h", "95 % intervals", "log.csv: 200 samples at 100 Hz"] {
        assert!(svg.contains(piece), "{piece} is missing in the chart");
    }
}

#[test]
fn pulses_rates_and_angles_of_the_same_motion_give_the_same_curve() {
    let mut angle = 0.0;
    let increments: Vec<f64> = noise(200).map(|y| (10.0 * y).round()).collect();
    let text = |numbers: Vec<f64>| numbers.iter().map(|x| format!("{x}\n")).collect::<String>();
    let angles: Vec<f64> = std::iter::once(0.0)
        .chain(increments.iter().map(|y| {
            angle += 0.5 * y;
            angle
        }))
        .collect();
    let rates = increments.iter().map(|y| 50.0 * y).collect();
    let desk = Desk::with("pulses.csv", text(increments));
    std::fs::write(desk.path("angles.csv"), text(angles)).unwrap();
    std::fs::write(desk.path("rates.csv"), text(rates)).unwrap();
    let curves = [
        "pulses.csv --data increment --scale 0.5_arcsec/pulse",
        "angles.csv --data angle --unit arcsec",
        "rates.csv --data rate --unit arcsec/s",
    ]
    .map(|words| {
        desk.done(&format!("{words} --rate 100Hz --deviation oadev,ohdev,mdev --out out"));
        desk.curve("out")
    });
    for (i, row) in curves[0].iter().enumerate() {
        for other in &curves[1..] {
            assert_eq!((&row["m"], &row["terms"]), (&other[i]["m"], &other[i]["terms"]));
            let [a, b] = [row, &other[i]].map(|row| row["value"].parse::<f64>().unwrap());
            assert!((a / b - 1.0).abs() < 1e-8, "{} at m = {}: {a} and {b}", row["deviation"], row["m"]);
        }
    }
}

#[test]
fn gaps_outliers_and_what_was_done_are_said() {
    let text = rows(|i, y| match i {
        30 => format!("{i},nan"),
        60 => format!("{i},99"),
        // 5 rows are not written.
        100.. => format!("{},{y}", i + 5),
        _ => format!("{i},{y}"),
    });
    let desk = Desk::with("log.csv", format!("t [s],g [deg/h]\n{text}"));
    let kept = desk.done("log.csv --data rate --time t --skip 20_s --until 3_min --detrend linear");
    for piece in ["g: 6 of 160 samples are missing (3.8 %)", "1 outlier", "at 60 s: kept"] {
        assert!(kept.stderr.contains(piece), "{piece} is missing in\n{}", kept.stderr);
    }
    for piece in
        ["from 20 s; until 180 s", "linear trend was removed", "R is gone", "above τ = 16 s", "°/h per h"]
    {
        assert!(kept.stdout.contains(piece), "{piece} is missing in\n{}", kept.stdout);
    }
    let treatment = &desk.curve("results/log")[0]["treatment"];
    assert_eq!(treatment, "from 20 s; until 180 s; linear trend removed: no R, K too low");
    let removed = desk.done("log.csv --data rate --time t --remove-outliers");
    assert!(removed.stderr.contains("taken for gaps"), "{}", removed.stderr);
    let first =
        |ended: &Ended| ended.stdout.lines().nth(5).unwrap().split_whitespace().nth(2).unwrap().to_owned();
    let [kept, removed]: [f64; 2] = [kept, removed].map(|ended| first(&ended).parse().unwrap());
    assert!(kept > 5.0 && removed < 1.0, "{kept} with the outlier, {removed} without");
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
        ([b"1\n2\n3", &[0; 5000][..]].concat(), RATE.into(), vec!["zero byte"]),
        (b"\x89HDF\r\n\x1a\n".to_vec(), RATE.into(), vec!["is HDF5", ".npy"]),
        (b"PK\x03\x04abc".to_vec(), RATE.into(), vec!["ZIP archive (.npz"]),
        (
            number(9, "inf"),
            RATE.into(),
            vec!["log.csv:10:1", "column 1 is infinite", "NaN where a sample is missing"],
        ),
        (number(9, "1.2.3"), RATE.into(), vec!["log.csv:10:1", "\"1.2.3\", which is no number"]),
        (
            of(&|i, y| format!("{i};{y}").replace('.', ",")),
            format!("{RATE} --column 2"),
            vec!["decimals with a point"],
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
            vec!["has 3 columns, which of them?", "2 gx [deg/s], 3 gz [deg/s]"],
        ),
        (good.clone().into(), format!("{RATE} --column gx,2"), vec!["asked for twice"]),
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
        (stamp(9, 8.0), by_time.into(), vec!["log.csv:10:1", "does not increase"]),
        (
            stamp(9, 9.3),
            by_time.into(),
            vec!["log.csv:10:1", "a step of 1.3 s, the median is 1 s", "within 10 %", "--rate instead"],
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
            vec!["the time column `1` has no unit", "--time-unit ms"],
        ),
        (
            of(&|_, y| format!("{}", 0.0042 + 1e-4 * y)),
            "--data rate --unit rad/s --rate 1Hz".into(),
            vec!["degrees taken for radians", "--unit deg/s", "--unit-check off"],
        ),
        (number(0, "1"), format!("{RATE} --skip 1_h"), vec!["nothing of log.csv is left: it is 200 s long"]),
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
        Desk::with("log.csv", bytes).fails(&format!("log.csv {words}"), 3, &pieces);
    }
    Desk::with("log.csv", "").fails(&format!("other.csv {RATE}"), 3, &["cannot read other.csv"]);
}

#[test]
fn sparse_files_of_a_terabyte_are_refused_at_once() {
    for start in ["", "gz\n1\n2\n3\n", "\u{93}NUMPY"] {
        let desk = Desk::with("log.csv", start);
        let file = std::fs::OpenOptions::new().write(true).open(desk.path("log.csv")).unwrap();
        if file.set_len(1 << 40).is_ok() {
            desk.fails(&format!("log.csv {RATE}"), 3, &["log.csv"]);
        }
    }
}

#[test]
fn options_that_make_no_sense_are_told_with_what_does() {
    let desk = Desk::with("log.csv", log());
    for (words, pieces) in [
        ("--data rate --unit deg/h", vec!["--rate 100Hz, or --time COLUMN"]),
        ("--unit deg/h --rate 1Hz", vec!["--data"]),
        ("--data speed --rate 1Hz", vec!["rate, increment, angle"]),
        ("--data rate --unit dps --rate 1Hz", vec!["`dps` is not a known unit", "deg/h, deg/s"]),
        ("--data rate --scale 0.5_arcsec/pulse --rate 1Hz", vec!["--data increment"]),
        ("--data rate --unit deg/h --rate 100", vec!["its unit is missing", "--rate 100Hz"]),
        ("--data rate --unit deg/h --rate 0Hz", vec!["not above 0"]),
        ("--data rate --rate 1Hz --tau tenth", vec!["octave, decade10, decade20 or all"]),
        ("--data rate --rate 1Hz --tau -1 --unit deg/h --column gx", vec!["no time"]),
        ("--data rate --rate 1Hz --deviation avar", vec!["`avar` is no deviation", "oadev"]),
        ("--data rate --rate 1Hz --confidence 95", vec!["between 0 and 1"]),
        ("--data rate --rate 1Hz --skip 30", vec!["its unit is missing"]),
        ("log.csv --data rate --rate 1Hz", vec!["several files would write to"]),
        ("b.csv --out o --data rate --rate 1Hz", vec!["--out names one folder"]),
    ] {
        desk.fails(&format!("log.csv {words}").replace("--tau -1", "--tau=-1"), 2, &pieces);
    }
}

#[test]
fn the_help_has_examples_and_says_what_is_read() {
    let help = Desk::with("a", "").done("--help").stdout;
    for piece in ["Examples:", "--scale", "decade10", "comments behind", "Stable32"] {
        assert!(help.contains(piece), "{piece} is missing in\n{help}");
    }
}
