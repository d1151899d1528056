//! The program as a user meets it: commands, files, messages and exit codes.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command as Process, Stdio};
use std::time::{Duration, Instant};

use crate::desk::{
    Desk, HEADER, PROGRAM, SHIPPED, STUDY, replaced, swept_chart, unwrapped, with, with_motion,
};
use assert_cmd::Command;

#[test]
fn a_bad_study_among_good_ones_stops_all_before_the_first_starts() {
    let desk = Desk::with(STUDY);
    desk.write("bad.toml", &replaced("20 Hz", "20"));
    desk.fails("run study.toml bad.toml --device cpu", 3, &["[bad.toml:8:13]"]);
    assert_eq!(desk.names("."), ["bad.toml", "study.toml"]);
}

#[test]
fn wrong_usage_ends_with_2_and_leaves_nothing() {
    let desk = Desk::with(STUDY);
    desk.write("other.toml", STUDY);
    desk.fails(
        "run study.toml other.toml --device cpu --out all",
        2,
        &["--out names one folder", "without --out"],
    );
    desk.fails("run study.toml --device abacus", 2, &["no device is called `abacus`", "auto, cpu, gpu"]);
    assert!(
        desk.done("run study.toml --device portable --trials 10 --out p").stderr.contains("CPU (portable")
    );
    std::fs::remove_dir_all(desk.path("p")).unwrap();
    desk.fails("run study.toml --device=", 2, &["no device is called ``", "auto, cpu, gpu"]);
    desk.fails("run study.toml --device cpu --trials 0", 2, &["--trials", "1..=1099511627776"]);
    desk.fails("run study.toml --device cpu --trials many", 2, &["--trials", "1_000_000 or 1e6"]);
    desk.fails("run study.toml --device cpu --trials 1.5", 2, &["--trials", "not whole"]);
    desk.done("run study.toml --device cpu --trials 1e1 --seed 1_0 --out p");
    std::fs::remove_dir_all(desk.path("p")).unwrap();
    desk.fails("run study.toml --device cpu --seed=-1", 2, &["--seed"]);
    desk.fails("run --device cpu", 2, &["<STUDY>"]);
    desk.fails("verify --device abacus", 2, &["no device is called `abacus`"]);
    desk.fails("walk", 2, &["walk"]);
    assert_eq!(desk.names("."), ["other.toml", "study.toml"]);
}

#[test]
fn two_studies_never_share_a_default_folder() {
    let desk = Desk::with(STUDY);
    std::fs::create_dir(desk.path("more")).unwrap();
    desk.write("more/study.toml", &replaced("20 Hz", "10 Hz"));
    desk.fails("run study.toml more/study.toml --device cpu", 2, &["results/study", "study.toml", "--out"]);
    assert_eq!(desk.names("."), ["more", "study.toml"]);
}

#[test]
fn a_folder_of_another_study_is_left_as_it_is() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 1000 --seed 1 --out kept");
    let points = desk.read("kept/points.csv");
    desk.fails(
        "run study.toml --device cpu --trials 1000 --seed 2 --out kept",
        3,
        &["kept", "another study", "seed 1", "--out"],
    );
    assert_eq!(desk.read("kept/points.csv"), points);
    desk.done("run study.toml --device cpu --trials 1000 --seed 1 --out kept");
}

#[test]
fn a_folder_that_cannot_be_written_is_a_storage_failure() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000 --out";
    let pieces = ["cannot use the results folder", "--out DIR"];
    desk.fails(&format!("{run} study.toml/results"), 6, &pieces);
    desk.fails(&format!("{run} study.toml"), 6, &pieces);
    if cfg!(target_os = "linux") {
        desk.fails(&format!("{run} /proc/sagnac"), 6, &["cannot use the results folder /proc/sagnac"]);
    }
    assert_eq!(desk.names("."), ["study.toml"]);
}

#[test]
fn a_folder_in_use_is_a_storage_failure_that_says_so() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000";
    desk.done(run);
    let holder = rusqlite::Connection::open(desk.path("results/study/tallies.sqlite")).unwrap();
    holder.execute_batch("PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE;").unwrap();
    desk.fails(run, 6, &["results/study/tallies.sqlite is in use", "--out DIR"]);
    drop(holder);
    assert!(desk.done(run).stderr.contains("nothing was left to sample"));
}

#[test]
fn a_damaged_database_is_a_storage_failure() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000";
    desk.done(run);
    let path = desk.path("results/study/tallies.sqlite");
    let sound = std::fs::read(&path).unwrap();
    let points = desk.read("results/study/points.csv");
    let all_bad = vec![0x5a; sound.len()];
    let later_pages_bad = [&sound[..4096], &all_bad[4096..]].concat();
    for bytes in [b"not a database, only some text\n".to_vec(), all_bad, later_pages_bad] {
        std::fs::write(&path, bytes).unwrap();
        desk.fails(run, 6, &["results/study/tallies.sqlite"]);
        assert_eq!(desk.read("results/study/points.csv"), points);
    }
    std::fs::write(&path, sound).unwrap();
    desk.done(run);
}

#[test]
fn a_damaged_row_is_found_by_its_checksum() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000";
    desk.done(run);
    let store = rusqlite::Connection::open(desk.path("results/study/tallies.sqlite")).unwrap();
    let changed = store.execute("UPDATE tally SET checksum = checksum + 1 WHERE first = 0", []).unwrap();
    assert_eq!(changed, 4, "each of 4 estimates has one block that begins with the first trial");
    drop(store);
    desk.fails(run, 6, &["results/study/tallies.sqlite", "damaged", "checksum"]);
}

#[test]
fn a_run_writes_the_table_the_chart_and_the_study() {
    let desk = Desk::with(SHIPPED);
    let ended = desk.done("run study.toml --device cpu --trials 1000");
    assert!(ended.stdout.starts_with("Residual error of the gap fillers"), "{}", ended.stdout);
    assert!(ended.stderr.contains("results are in results/study"), "{}", ended.stderr);
    let charts = ["chart-1", "chart-2", "chart-3"].map(|stem| [format!("{stem}.png"), format!("{stem}.svg")]);
    let files = ["points.csv", "report.html", "resolved_study.toml", "tallies.lock", "tallies.sqlite"]
        .map(str::to_owned);
    assert_eq!(desk.names("results/study"), [charts.concat(), files.into()].concat());
    let table = desk.read("results/study/points.csv");
    let laws = "law_taylor_extremum_arcsec,law_taylor_zero_crossing_arcsec";
    let header = format!("motion.frequency_hz,switching.gap_ticks,{HEADER},{laws}");
    assert_eq!(table.lines().next(), Some(header.as_str()));
    assert_eq!(desk.points("results/study").len(), 24 * 3 * 3 * 2);
    let png = std::fs::read(desk.path("results/study/chart-1.png")).unwrap();
    assert_eq!(&png[..16], b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    assert!(png.ends_with(b"IEND\xaeB`\x82"));
    let svg = desk.read("results/study/chart-1.svg");
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
}

#[test]
fn the_resolved_study_repeats_the_run_without_options() {
    let shipped = "trials = 1_000_000";
    let written = SHIPPED.replace(shipped, "trials = 1_000_000 # many");
    assert_ne!(written, SHIPPED);
    let neither = SHIPPED.replace("seed = 1\n", "").replace(&format!("{shipped}\n"), "");
    let inserted = neither.replace("\"gap-fill\"\n", "\"gap-fill\"\nseed = 7\ntrials = 1000\n");
    let replaced = written.replace("seed = 1\n", "seed = 7\n").replace("1_000_000 #", "1000 #");
    for (text, expected) in [(&written, &replaced), (&neither, &inserted)] {
        let desk = Desk::with(text);
        desk.done("run study.toml --device cpu --trials 1000 --seed 7");
        let table = desk.read("results/study/points.csv");
        assert_eq!(desk.read("results/study/resolved_study.toml"), *expected);
        desk.done("run results/study/resolved_study.toml --device cpu --out fresh");
        assert_eq!(desk.read("fresh/points.csv"), table);
        let again = desk.done("run results/study/resolved_study.toml --device cpu --out results/study");
        assert!(again.stderr.contains("nothing was left to sample"), "{}", again.stderr);
        assert_eq!(desk.read("results/study/points.csv"), table);
        assert_eq!(desk.read("results/study/resolved_study.toml"), *expected);
    }
}

#[test]
fn a_study_without_sweeps_has_no_swept_columns_and_its_fillers_side_by_side() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 1000");
    assert_eq!(desk.read("results/study/points.csv").lines().next(), Some(HEADER));
    assert_eq!(
        desk.names("results/study"),
        [
            "chart.png",
            "chart.svg",
            "points.csv",
            "report.html",
            "resolved_study.toml",
            "tallies.lock",
            "tallies.sqlite"
        ]
    );
    let chart = desk.read("results/study/chart.svg");
    for label in ["const", "quadratic", "rms error", "99.73 % error"] {
        assert!(chart.contains(&format!(">{label}<")), "{label}");
    }
    let rows = desk.points("results/study");
    let names: Vec<(&str, &str)> =
        rows.iter().map(|row| (row["filler"].as_str(), row["error"].as_str())).collect();
    let (residual, extrapolation) = ("residual", "extrapolation");
    assert_eq!(
        names,
        [
            ("const", residual),
            ("const", extrapolation),
            ("quadratic", residual),
            ("quadratic", extrapolation)
        ]
    );
}

#[test]
fn what_is_not_known_is_blank_and_not_zero() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 1");
    for row in desk.points("results/study") {
        for blank in ["rms_se_arcsec", "q9973_hi_arcsec", "z"] {
            assert_eq!(row[blank], "", "{blank} of {row:?}");
        }
        for known in ["trials", "dt_nu", "mean_arcsec", "rms_arcsec", "max_arcsec", "oracle_rms_arcsec"] {
            let value: f64 = row[known].parse().unwrap_or_else(|_| panic!("{known} of {row:?}"));
            assert!(value.is_finite(), "{known} of {row:?}");
        }
    }
}

#[test]
fn a_sweep_without_a_chart_gets_one_and_several_charts_are_numbered() {
    let sweep = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"10 Hz\"]\n";
    let desk = Desk::with(&with(sweep));
    desk.done("run study.toml --device cpu --trials 1000");
    let default = [
        "chart.png",
        "chart.svg",
        "points.csv",
        "report.html",
        "resolved_study.toml",
        "tallies.lock",
        "tallies.sqlite",
    ];
    assert_eq!(desk.names("results/study"), default);
    let charts = "[[chart]]\nx = \"dt_nu\"\ny = \"rms\"\n[[chart]]\nx = \"frequency\"\ny = \"max\"\n";
    desk.write("two.toml", &with(&format!("{sweep}{charts}")));
    desk.done("run two.toml --device cpu --trials 1000");
    assert_eq!(desk.names("results/two")[..4], ["chart-1.png", "chart-1.svg", "chart-2.png", "chart-2.svg"]);
}

#[test]
fn maps_are_drawn_with_their_limit_and_what_they_show_is_told() {
    let axes = "x = \"frequency\"\ny = \"amplitude\"\nz = \"q9973\"\nlimit = \"20 arcsec\"\n";
    let heat = format!("kind = \"heat-map\"\n{axes}where = {{ filler = \"const\" }}\n");
    let winners = format!("kind = \"winner-map\"\n{axes}");
    let text =
        swept_chart(&format!("{heat}[[chart]]\n{winners}")).replace("[chart]\nkind", "[[chart]]\nkind");
    let desk = Desk::with(&text.replace("\"const\", \"quadratic\"", "\"const\", \"linear\", \"quadratic\""));
    let ended = desk.done("run study.toml --device cpu --trials 10000");
    for piece in [
        "chart-1: 3 of the 4 cells are within the limit.",
        "chart-2: 3 of the 4 cells are within the limit; the same in every cell: const = linear.",
    ] {
        assert!(ended.stderr.contains(piece), "{}", ended.stderr);
    }
    assert_eq!(
        desk.names("results/study")[..4],
        ["chart-1.png", "chart-1.svg", "chart-2.png", "chart-2.svg"]
    );
    let heat = desk.read("results/study/chart-1.svg");
    for piece in ["vibration amplitude, ″/s", "99.73 % error, ″", "within: 75 % of cells", "filler = const"]
    {
        assert!(heat.contains(piece), "{piece} is missing in\n{heat}");
    }
    let winners = desk.read("results/study/chart-2.svg");
    for piece in ["const = linear: 50 % of cells", "quadratic: 50 % of cells", "even the least is over"] {
        assert!(winners.contains(piece), "{piece} is missing in\n{winners}");
    }
    assert!(!ended.stdout.contains("against the limit"), "a map has no verdict:\n{}", ended.stdout);
}

#[test]
fn a_law_is_a_column_of_the_table_and_a_line_of_the_chart_that_asks_for_it() {
    let chart = "[chart]\nx = \"frequency\"\ny = \"q9973\"\nlaws = [\"taylor-extremum\", \"noise\"]\n";
    let sweep = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n";
    let desk = Desk::with(&with(&format!("{sweep}{chart}")));
    desk.done("run study.toml --device cpu --trials 1000");
    let header = format!("motion.frequency_hz,{HEADER},law_taylor_extremum_arcsec,law_noise_arcsec");
    assert_eq!(desk.read("results/study/points.csv").lines().next(), Some(header.as_str()));
    let rows = desk.points("results/study");
    let shown = |at: usize| {
        let number = |name: &str| rows[at][name].parse().map_or(String::new(), |x: f64| format!("{x:.2}"));
        (rows[at]["filler"].as_str(), number("law_taylor_extremum_arcsec"), number("law_noise_arcsec"))
    };
    // Of the second frequency, Δt·ν = 0.2, σ = 1 ″ and n = 3.
    assert_eq!(shown(4), ("const", "47.37".to_owned(), "4.50".to_owned()));
    assert_eq!(shown(6), ("quadratic", "6.23".to_owned(), String::new()));
    let svg = desk.read("results/study/chart.svg");
    for piece in
        ["Taylor term of one tick at an", "extremum, as published, Z(20)", "3σ noise of const by Z(18),"]
    {
        assert!(svg.contains(piece), "{piece} is missing in\n{svg}");
    }
    desk.write("study.toml", &with(&format!("{sweep}{}", chart.replace("laws", "# laws"))));
    desk.done("run study.toml --device cpu --trials 1000");
    let header = format!("motion.frequency_hz,{HEADER}");
    assert_eq!(desk.read("results/study/points.csv").lines().next(), Some(header.as_str()));
}

#[test]
fn charts_that_are_no_longer_asked_for_are_removed_and_nothing_else() {
    let sweep = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"10 Hz\"]\n";
    let chart = "[[chart]]\nx = \"dt_nu\"\ny = \"rms\"\n";
    let desk = Desk::with(&with(sweep));
    let own = ["chart-02.svg", "chart-0.png", "chart-3.txt", "chart-a.svg", "my-chart.svg"];
    let run = |charts: usize| {
        desk.write("study.toml", &with(&format!("{sweep}{}", chart.repeat(charts))));
        desk.done("run study.toml --device cpu --trials 1000 --quiet");
        for name in own {
            desk.write(&format!("results/study/{name}"), "mine");
        }
        let names = desk.names("results/study");
        names
            .into_iter()
            .filter(|name| name.starts_with("chart") && !own.contains(&name.as_str()))
            .collect::<Vec<_>>()
    };
    assert_eq!(run(1), ["chart.png", "chart.svg"]);
    assert_eq!(run(2), ["chart-1.png", "chart-1.svg", "chart-2.png", "chart-2.svg"]);
    assert_eq!(run(1), ["chart.png", "chart.svg"]);
    for name in own {
        assert_eq!(desk.read(&format!("results/study/{name}")), "mine");
    }
    // Of closed forms with nothing to draw none is left.
    run(2);
    desk.write(
        "study.toml",
        "title = \"none\"\nkind = \"suspension\"\n[suspension]\ngyro = \"LGK-400\"\nfrequency = \"20 Hz\"\n",
    );
    desk.done("run study.toml --out none --quiet");
    assert!(!desk.names("none").iter().any(|name| name.starts_with("chart")));
}

/// Lines of the table on the standard output, split into cells.
fn cells(stdout: &str) -> Vec<Vec<&str>> {
    let lines = stdout.lines().skip_while(|line| !line.contains(", by ")).skip(1);
    let table = lines.take_while(|line| !line.is_empty());
    table.map(|line| line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect()).collect()
}

#[test]
fn the_printed_table_has_a_line_for_every_value_of_every_sweep() {
    let sweep = |key: &str, list: &str| format!("[[sweep]]\nkey = \"{key}\"\nlist = {list}\n");
    let near = sweep("motion.frequency", r#"["20.001 Hz", "20.002 Hz", "25 Hz"]"#);
    let desk = Desk::with(&with(&near));
    let said = desk.done("run study.toml --device cpu --trials 1000").stdout;
    let firsts: Vec<&str> = cells(&said)[1..].iter().map(|line| line[0]).collect();
    assert_eq!(firsts, ["20.001", "20.002", "25"], "{said}");

    let gaps = sweep("switching.gap_ticks", "[1, 2]");
    let rates = sweep("motion.amplitude", r#"["10 arcsec/s", "20 arcsec/s"]"#);
    desk.write("three.toml", &with(&format!("{near}{gaps}{rates}")));
    let said = desk.done("run three.toml --device cpu --trials 1000").stdout;
    let lines = cells(&said);
    assert_eq!(lines.len(), 1 + 3 * 2, "{said}");
    assert_eq!(lines[0][..2], ["vibration frequency, Hz", "vibration amplitude, ″/s"], "{said}");
    let points = desk.points("results/three");
    for line in &lines[1..] {
        let wanted: Vec<f64> = points
            .iter()
            .filter(|row| row["motion.frequency_hz"] == line[0] && row["error"] == "residual")
            .filter(|row| row["motion.amplitude_arcsec_per_s"] == line[1])
            .map(|row| row["rms_arcsec"].parse().unwrap())
            .collect();
        let shown: Vec<f64> = line[2..].iter().map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(shown.len(), wanted.len(), "{said}");
        for (shown, wanted) in shown.iter().zip(&wanted) {
            assert!((shown / wanted - 1.0).abs() < 1e-3, "{shown}, {wanted}:\n{said}");
        }
    }

    desk.write(
        "both.toml",
        &with(&format!("{gaps}[chart]\nx = \"gap_ticks\"\ny = \"rms\"\nseries = [\"filler\", \"error\"]\nwhere = {{ gap_ticks = 2 }}")),
    );
    let said = desk.done("run both.toml --device cpu --trials 1000").stdout;
    assert_eq!(cells(&said)[1].len(), 1 + 4, "residual and extrapolation of two fillers:\n{said}");
}

#[test]
fn a_thinned_table_shows_all_values_of_the_faster_sweeps() {
    let study = with(
        "[[sweep]]\nkey = \"motion.frequency\"\nlinear = { from = \"1 Hz\", to = \"50 Hz\", points = 50 }\n\
         [[sweep]]\nkey = \"motion.amplitude\"\nlist = [\"10 arcsec/s\", \"20 arcsec/s\"]\n\
         [chart]\nkind = \"winner-map\"\nx = \"frequency\"\ny = \"amplitude\"\nz = \"rms\"",
    );
    let said = Desk::with(&study).done("run study.toml --device cpu --trials 1").stdout;
    let lines = cells(&said);
    assert!(said.contains("(one line in 3)") && lines.len() == 1 + 34, "{said}");
    for rate in ["10", "20"] {
        assert_eq!(lines.iter().filter(|line| line[1] == rate).count(), 17, "{said}");
    }
}

#[test]
fn json_has_the_numbers_of_the_table() {
    let desk = Desk::with(SHIPPED);
    let ended = desk.done("run study.toml --device cpu --trials 1000 --json");
    let json: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!((json["trials"].as_u64(), json["seed"].as_u64()), (Some(1000), Some(1)));
    assert_eq!(json["sampled_trials"].as_u64(), Some(72_000));
    assert_eq!(json["verdicts"][0]["limit_arcsec"].as_f64(), Some(10.0));
    let rows = desk.points("results/study");
    let points = json["points"].as_array().unwrap();
    assert_eq!(points.len(), rows.len());
    for (point, row) in points.iter().zip(&rows) {
        assert_eq!(point.as_object().unwrap().len(), row.len());
        for (column, text) in row {
            match &point[column] {
                serde_json::Value::Null => assert_eq!(text, "", "{column}"),
                serde_json::Value::String(string) => assert_eq!(text, string, "{column}"),
                number => {
                    let (number, written) = (number.as_f64().unwrap(), text.parse::<f64>().unwrap());
                    assert!((number - written).abs() <= 1e-8 * number.abs(), "{column}: {number}, {written}");
                }
            }
        }
    }
}

#[test]
fn several_studies_print_one_json_document() {
    let desk = Desk::with(STUDY);
    desk.write("other.toml", &replaced("A study", "Another"));
    let ended = desk.done("run study.toml other.toml --device cpu --trials 1000 --json");
    let json: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let titles: Vec<&str> =
        json.as_array().unwrap().iter().map(|one| one["title"].as_str().unwrap()).collect();
    assert_eq!(titles, ["A study", "Another"]);
}

/// Ends a command whose standard output goes to `stdout`.
fn printed_to(desk: &Desk, words: &str, stdout: impl Into<Stdio>) -> (Option<i32>, String) {
    let mut command = Process::new(PROGRAM);
    command.current_dir(desk.0.path()).args(words.split_whitespace()).stdout(stdout);
    let output = command.stderr(Stdio::piped()).spawn().unwrap().wait_with_output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn output_that_is_lost_is_a_failure_and_a_reader_that_left_is_none() {
    let desk = Desk::with(STUDY);
    let commands =
        ["schema", "run study.toml --device cpu --trials 1000 --json", "verify --device cpu --trials 64"];
    for words in commands {
        if cfg!(target_os = "linux") {
            let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
            let (code, said) = printed_to(&desk, words, full);
            assert_eq!(code, Some(6), "{words}: {said}");
            assert!(said.contains("cannot write to the standard output"), "{words}: {said}");
        }
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let (code, said) = printed_to(&desk, words, writer);
        assert_eq!((code, said.contains("error:")), (Some(0), false), "{words}: {said}");
    }
}

#[test]
fn help_lists_only_exit_codes_that_exist() {
    let help = unwrapped(&Desk::with(STUDY).done("--help").stdout);
    assert!(help.contains("3 invalid study") && help.contains("5 a check failed"), "{help}");
    assert!(!help.contains("resumable"), "{help}");
}

/// Time from the start of a run to its first line of progress.
fn time_to_progress(desk: &Desk, out: &str) -> Duration {
    let started = Instant::now();
    let mut child = Process::new(PROGRAM)
        .current_dir(desk.0.path())
        .args(["run", "study.toml", "--device", "cpu", "--trials", "1000000000", "--out", out])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let seen = lines.into_iter().any(|line| line.contains("trials done"));
    let elapsed = started.elapsed();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(seen, "the run ended without progress");
    elapsed
}

#[test]
fn progress_is_seen_within_100_ms() {
    let desk = Desk::with(SHIPPED);
    // Other programs can only make it longer: one start of twenty within the time is enough.
    let mut starts = (0..20).map(|start| time_to_progress(&desk, &format!("out-{start}")));
    assert!(starts.any(|time| time < Duration::from_millis(100)));
}

#[test]
fn a_quiet_run_prints_nothing() {
    let desk = Desk::with(STUDY);
    let ended = desk.done("run study.toml --device cpu --trials 1000 --quiet");
    assert_eq!((ended.stdout.as_str(), ended.stderr.as_str()), ("", ""));
    assert!(desk.path("results/study/points.csv").exists());
}

#[test]
fn schema_prints_the_committed_one_and_devices_lists_the_cpu() {
    let desk = Desk::with(STUDY);
    let committed = include_str!("../../schema/study.schema.json");
    assert_eq!(desk.done("schema").stdout.trim_end(), committed.trim_end());
    let devices = desk.done("devices").stdout;
    assert!(devices.starts_with("cpu: portable"), "{devices}");
}

#[test]
fn verify_prints_a_digest_for_each_kernel_and_the_same_ones_again() {
    let desk = Desk::with(STUDY);
    let first = desk.done("verify --device cpu --trials 4096").stdout;
    let kernels: Vec<&str> = first
        .lines()
        .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
            ["identical", kernel, digest] => {
                let hex = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
                assert!(digest.len() == 16 && digest.chars().all(hex), "{line}");
                kernel
            }
            _ => panic!("{line}"),
        })
        .collect();
    let all = ["philox", "normal", "sine", "power", "gap_fill", "switched_run", "relock", "allan"];
    assert_eq!(kernels, all);
    assert_eq!(desk.done("verify --device cpu --trials 4096").stdout, first);
}

#[test]
fn a_second_run_samples_nothing_and_changes_nothing() {
    let desk = Desk::with(SHIPPED);
    desk.done("run study.toml --device cpu --trials 1000");
    let files =
        ["points.csv", "chart-1.svg", "resolved_study.toml"].map(|name| format!("results/study/{name}"));
    let before = files.each_ref().map(|name| desk.read(name));
    let ended = desk.done("run study.toml --device cpu --trials 1000");
    assert!(ended.stderr.contains("nothing was left to sample"), "{}", ended.stderr);
    assert_eq!(files.each_ref().map(|name| desk.read(name)), before);
}

#[test]
fn more_trials_later_are_the_same_as_all_at_once() {
    let desk = Desk::with(SHIPPED);
    for trials in [1, 1000, 20_000] {
        desk.done(&format!("run study.toml --device cpu --quiet --trials {trials} --out grown"));
    }
    desk.done("run study.toml --device cpu --quiet --trials 20000 --out fresh");
    assert_eq!(desk.read("grown/points.csv"), desk.read("fresh/points.csv"));
    assert_eq!(desk.read("grown/chart-1.svg"), desk.read("fresh/chart-1.svg"));
}

#[test]
fn a_filler_or_a_sweep_value_added_later_is_the_same_as_from_the_start() {
    let sweep = |list: &str| format!("[[sweep]]\nkey = \"motion.frequency\"\nlist = [{list}]\n");
    let (few, all) = (sweep("\"5 Hz\", \"20 Hz\""), sweep("\"5 Hz\", \"10 Hz\", \"20 Hz\""));
    let fillers =
        |text: &str| text.replace("\"const\", \"quadratic\"", "\"const\", \"linear\", \"quadratic\"");
    let desk = Desk::with(&with(&few));
    desk.write("filler.toml", &fillers(&with(&few)));
    desk.write("all.toml", &fillers(&with(&all)));
    for study in ["study", "filler", "all"] {
        desk.done(&format!("run {study}.toml --device cpu --quiet --trials 5000 --out grown"));
    }
    desk.done("run all.toml --device cpu --quiet --trials 5000 --out fresh");
    assert_eq!(desk.read("grown/points.csv"), desk.read("fresh/points.csv"));
}

#[test]
fn a_point_no_longer_asked_for_is_kept_but_not_shown() {
    let sweep = |list: &str| with(&format!("[[sweep]]\nkey = \"motion.frequency\"\nlist = [{list}]"));
    let desk = Desk::with(&sweep("\"5 Hz\", \"20 Hz\""));
    desk.done("run study.toml --device cpu --trials 1000");
    desk.write("study.toml", &sweep("\"5 Hz\""));
    let ended = desk.done("run study.toml --device cpu --trials 1000");
    assert!(ended.stderr.contains("note: 1 point of earlier runs is kept"), "{}", ended.stderr);
    assert_eq!(desk.points("results/study").len(), 4);
}

/// 12 points; the trials are asked for on the command line.
fn long_study() -> String {
    let sweeps = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"4 Hz\", \"8 Hz\", \"12 Hz\", \"16 Hz\"]\n\
                  [[sweep]]\nkey = \"switching.gap_ticks\"\nlist = [1, 2, 3]\n";
    with(sweeps)
}

const LONG_TRIALS: u64 = 10_000_000;

/// Bytes of the database with its log.
fn stored(folder: &Path) -> u64 {
    let size = |name: &str| std::fs::metadata(folder.join(name)).map_or(0, |file| file.len());
    size("tallies.sqlite") + size("tallies.sqlite-wal")
}

/// Device and trials of each run that left something.
fn provenance(folder: &Path) -> Vec<(String, u64)> {
    let store = rusqlite::Connection::open(folder.join("tallies.sqlite")).unwrap();
    let mut statement = store.prepare("SELECT device, trials FROM provenance").unwrap();
    let rows = statement.query_map([], |row| Ok((row.get(0)?, row.get::<_, i64>(1)? as u64))).unwrap();
    rows.map(Result::unwrap).collect()
}

/// Starts a run and kills it once its database has grown by `bytes`.
fn killed(desk: &Desk, words: &str, folder: &str, bytes: u64) {
    let mut child = Process::new(PROGRAM)
        .current_dir(desk.0.path())
        .args(words.split_whitespace())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let (folder, started) = (desk.path(folder), Instant::now());
    while stored(&folder) < bytes {
        assert!(started.elapsed() < Duration::from_secs(60), "no {bytes} bytes were stored");
        assert!(child.try_wait().unwrap().is_none(), "the run ended before {bytes} bytes were stored");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(child.try_wait().unwrap().is_none(), "the run ended before it was killed");
    child.kill().unwrap();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), None, "the run ended by itself");
    assert!(!folder.join("points.csv").exists(), "the run had finished its table");
}

#[test]
fn a_killed_run_resumes_to_the_same_table() {
    let desk = Desk::with(&long_study());
    let run = format!("run study.toml --device cpu --trials {LONG_TRIALS} --json --out");
    desk.done(&format!("{run} whole"));
    let (whole, all) = (desk.read("whole/points.csv"), 12 * LONG_TRIALS);
    for (index, kib) in [150, 500, 1500].into_iter().enumerate() {
        let folder = format!("killed-{index}");
        killed(&desk, &format!("{run} {folder}"), &folder, kib << 10);
        let before = provenance(&desk.path(&folder));
        let resumed = desk.done(&format!("{run} {folder}"));
        let json: serde_json::Value = serde_json::from_str(&resumed.stdout).unwrap();
        let sampled = json["sampled_trials"].as_u64().unwrap();
        assert!(
            (1..all).contains(&sampled),
            "{kib} KiB: {sampled} of {all} trials were sampled after the kill"
        );
        assert!(desk.read(&format!("{folder}/points.csv")) == whole, "{kib} KiB: another table");
        let after = provenance(&desk.path(&folder));
        assert_eq!((before.len(), after.len()), (1, 2), "{kib} KiB: a row for each run");
        assert!(before[0].0.starts_with("CPU"), "{kib} KiB: {before:?}");
        assert_eq!(before[0].1 + sampled, all, "{kib} KiB: the killed run is noted with what it has left");
    }
}

#[test]
fn one_thread_gives_the_same_table() {
    let desk = Desk::with(&long_study());
    desk.done("run study.toml --device cpu --quiet --trials 100000 --out all");
    let ended = desk
        .sagnac_with("run study.toml --device cpu --trials 100000 --out one", &[("RAYON_NUM_THREADS", "1")]);
    assert!(ended.stderr.contains("1 thread"), "{}", ended.stderr);
    assert_eq!(desk.read("all/points.csv"), desk.read("one/points.csv"));
}

#[test]
fn an_adapter_gives_the_same_table() {
    let desk = Desk::with(SHIPPED);
    let devices = desk.done("devices").stdout;
    let adapters: Vec<&str> = devices.lines().filter_map(|line| line.strip_prefix("gpu: ")).collect();
    // The software rasteriser where it is: the same program on every machine.
    let software = adapters.iter().find(|name| name.contains("llvmpipe"));
    let adapter = software.or(adapters.first()).unwrap_or_else(|| {
        panic!(
            "no adapter to compare with the CPU: run ./test, which installs a Vulkan software rasteriser (llvmpipe), \
             then this test again"
        )
    });
    desk.done("run study.toml --device cpu --quiet --trials 20000 --out cpu");
    let words = ["run", "study.toml", "--trials", "20000", "--out", "gpu", "--device", adapter];
    let output = Command::new(PROGRAM).current_dir(desk.0.path()).args(words).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains(&format!("device: {adapter}")), "{said}");
    assert_eq!(desk.read("cpu/points.csv"), desk.read("gpu/points.csv"));
    assert_eq!(desk.read("cpu/chart-1.svg"), desk.read("gpu/chart-1.svg"));
}

#[test]
fn the_resolved_study_of_a_record_repeats_the_run_from_where_it_lies() {
    let record = "profile = { file = \"data/record.csv\", position = \"every\" }";
    let desk = Desk::with(&with_motion(record));
    std::fs::create_dir(desk.path("data")).unwrap();
    let samples: String = (0..400).map(|i| format!("{}, {}\n", 5 * i, i % 7)).collect();
    desk.write("data/record.csv", &format!("time [ms], rate [deg/s]\n{samples}"));
    let ended = desk.done("run study.toml --device cpu --trials 300");
    assert!(ended.stderr.contains("538 trials per point instead of 300: whole replays"), "{}", ended.stderr);
    let table = desk.read("results/study/points.csv");
    let again = desk.done("run results/study/resolved_study.toml --device cpu");
    assert!(again.stderr.contains("nothing was left to sample"), "{}", again.stderr);
    assert!(!again.stderr.contains("whole replays"), "{}", again.stderr);
    desk.done("run results/study/resolved_study.toml --device cpu --out afresh");
    assert_eq!(
        [desk.read("results/study/points.csv"), desk.read("afresh/points.csv")],
        [table.clone(), table]
    );
}

#[test]
fn fewer_trials_than_are_held_are_told_and_the_resolved_study_has_those_held() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 5000");
    let ended = desk.done("run study.toml --device cpu --trials 1000");
    assert!(ended.stderr.contains("5000 trials per point instead of 1000"), "{}", ended.stderr);
    assert!(desk.read("results/study/resolved_study.toml").contains("trials = 5000"));
}
