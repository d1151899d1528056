//! Folders, studies, logs and databases from strangers: inputs without an end, rows without measure, results that are not whole.

use std::process::Command;
use std::time::{Duration, Instant};

use rusqlite::Connection;

use crate::desk::{Desk, Ended, PROGRAM, STUDY, replaced, with, with_motion};

const SWEPT: &str = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n[chart]\nx = \"frequency\"\ny = \"rms\"\n\
                     series = [\"filler\"]\n";

const READ: &str = "--data rate --unit deg/h --rate 1Hz";

/// Longer than any refusal takes, and shorter than the 120 s after which a command is ended.
const AT_ONCE: Duration = Duration::from_secs(20);

/// Ends with one of these codes, at once, and says every piece.
fn refused(desk: &Desk, words: &str, codes: &[i32], pieces: &[&str]) {
    let started = Instant::now();
    let Ended { code, stdout, stderr } = desk.sagnac(words);
    let took = started.elapsed();
    assert!(codes.contains(&code), "`sagnac {words}` ended with {code}:\n{stdout}{stderr}");
    assert!(took < AT_ONCE, "`sagnac {words}` took {took:?}");
    let said = crate::desk::unwrapped(&stderr);
    for piece in pieces {
        assert!(
            said.contains(piece) || stdout.contains(piece),
            "`{piece}` is missing after `sagnac {words}`:\n{stdout}{stderr}"
        );
    }
}

/// Puts a pipe in the place of a file.
fn pipe(desk: &Desk, name: &str) {
    // There may be nothing in its place.
    let _ = std::fs::remove_file(desk.path(name));
    assert!(Command::new("mkfifo").arg(desk.path(name)).status().unwrap().success());
}

#[test]
fn charts_and_pages_of_incomplete_results_say_so_on_every_output() {
    let desk = Desk::with(&with(SWEPT));
    desk.done("run study.toml --trials 4096 --device cpu --shard 1/2");
    let half = "results/study/shard-1-of-2";
    let note = format!("note: {half}: the run is incomplete: 4096 trials are missing");
    for (words, file) in [("--quiet", "redrawn.svg"), ("--name loud", "loud.svg")] {
        let ended = desk.done(&format!("chart {half} {words}"));
        assert!(ended.stderr.contains(&note), "chart {words}: {}", ended.stderr);
        let picture = desk.read(&format!("{half}/{file}"));
        assert!(picture.contains("Incomplete, 4096 trials are missing."), "chart {words}: {picture}");
    }
    assert!(desk.done(&format!("report {half} --quiet")).stderr.contains(&note));
    assert!(desk.read(&format!("{half}/report.html")).contains("Incomplete, 4096 trials are missing."));
    // A whole one says nothing of the kind.
    desk.done("run study.toml --trials 4096 --device cpu");
    for words in ["chart results/study --quiet", "report results/study --quiet"] {
        assert_eq!(desk.done(words).stderr, "", "{words}");
    }
    for file in ["redrawn.svg", "report.html"] {
        assert!(!desk.read(&format!("results/study/{file}")).contains("ncomplete,"), "{file}");
    }
}

#[test]
fn pipes_devices_and_folders_in_the_place_of_inputs_are_refused_at_once() {
    const WHAT: &str = "a pipe, a device or a socket";
    let desk = Desk::with(&with_motion("profile = { file = \"record.csv\" }"));
    pipe(&desk, "pipe");
    for input in ["pipe", "/dev/zero", "/dev/random"] {
        refused(&desk, &format!("run {input}"), &[3], &[WHAT]);
        refused(&desk, &format!("allan {input} {READ}"), &[3], &[WHAT]);
        refused(&desk, &format!("allan {input} {READ}"), &[3], &[WHAT]);
        refused(&desk, &format!("compare {input} {input} {READ}"), &[3], &[WHAT]);
        refused(&desk, &format!("sensitivity {input} --by theory_rms"), &[3], &[WHAT]);
        refused(&desk, &format!("filler {input} --at gap_ticks=3"), &[3], &[WHAT]);
        refused(&desk, &format!("design {input}"), &[3], &[WHAT]);
    }
    refused(&desk, "run .", &[3], &["is a folder"]);
    refused(&desk, &format!("allan . {READ}"), &[3], &["is a folder without a recording"]);
    pipe(&desk, "record.csv");
    refused(&desk, "run study.toml", &[3], &[WHAT]);
    let noise = "title = \"Noise\"\nkind = \"allan\"\ntrials = 8\n[record]\nsample = \"1 s\"\nlength = \"1 h\"\n[allan]\ntau = \"octave\"\n\
                 [noise]\nfile = \"pipe\"\n";
    desk.write("noise.toml", noise);
    refused(&desk, "run noise.toml", &[3], &[WHAT]);
    desk.write("long.toml", &format!("{STUDY}# {}", "x".repeat(5 << 20)));
    refused(&desk, "run long.toml", &[3], &["longer than 4 MiB"]);
}

#[test]
fn pipes_and_links_in_a_received_folder_are_refused_at_once() {
    let desk = Desk::with(&with(SWEPT));
    let run = "run study.toml --trials 1000 --device cpu";
    let commands = [
        "chart results/study",
        "report results/study",
        "check results/study",
        "merge results/study --out merged --study study.toml --trials 1000",
        run,
    ];
    for name in ["tallies.sqlite", "tallies.sqlite-wal", "tallies.sqlite-journal", "tallies.lock"] {
        for is_link in [false, true] {
            desk.done(run);
            match is_link {
                false => pipe(&desk, &format!("results/study/{name}")),
                true => {
                    desk.write("victim", "mine");
                    let path = desk.path(&format!("results/study/{name}"));
                    // There may be nothing in its place.
                    let _ = std::fs::remove_file(&path);
                    std::os::unix::fs::symlink(desk.path("victim"), path).unwrap();
                }
            }
            for words in commands {
                refused(&desk, words, &[6], &[&format!("{name} is a")]);
            }
            if is_link {
                assert_eq!(desk.read("victim"), "mine", "{name}");
            }
            std::fs::remove_dir_all(desk.path("results")).unwrap();
        }
    }
    desk.done(run);
    pipe(&desk, "results/study/points.csv");
    refused(&desk, "check results/study", &[5], &["a pipe, a device or a socket"]);
    // A pipe is no study: the folder has none.
    pipe(&desk, "results/study/resolved_study.toml");
    refused(&desk, "chart results/study", &[2], &["has no resolved_study.toml"]);
    refused(&desk, "merge results/study --out merged", &[2], &["a pipe, a device or a socket"]);
    refused(&desk, "report results/study", &[2], &["resolved_study.toml"]);
    pipe(&desk, "results/study/card.json");
    refused(&desk, "report results/study", &[2], &["card.json"]);
}

#[test]
fn what_a_shell_opens_for_the_program_is_read() {
    let desk = Desk::with(STUDY);
    desk.write("log.csv", &(0..200).map(|row| format!("{}\n", (row * 7919) % 101)).collect::<String>());
    for words in [
        format!("{PROGRAM} allan <(cat log.csv) {READ} --out a"),
        format!("cat log.csv | {PROGRAM} allan /dev/stdin {READ} --out b"),
        format!("{PROGRAM} run /dev/stdin --device cpu --trials 64 --out c < study.toml"),
        format!("{PROGRAM} run <(cat study.toml) --device cpu --trials 64 --out d"),
    ] {
        let output = Command::new("bash").args(["-c", &words]).current_dir(desk.path(".")).output().unwrap();
        assert!(output.status.success(), "{words}\n{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn a_database_that_computes_without_end_or_holds_rows_without_measure_is_refused_at_once() {
    let endless = "AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT";
    let tally = format!(
        "DROP TABLE tally; CREATE VIEW tally {endless} x'00' AS point, x'00' AS estimate, i AS first, 0 AS log2, x'00' AS digest, \
         x'00' AS sums, 0 AS checksum FROM n"
    );
    let run = "run study.toml --trials 1000 --device cpu";
    for (sql, piece) in [
        (
            format!("DROP TABLE study; CREATE VIEW study {endless} 'a' AS key, i AS value FROM n"),
            "it holds the view",
        ),
        (tally.clone(), "it holds the view"),
        // Salvage reads altered tables, but no view behind one.
        (format!("CREATE TABLE aaa (x); {tally}"), "it holds the view"),
        (
            "CREATE TABLE aaa (x); CREATE TRIGGER t BEFORE INSERT ON tally BEGIN SELECT 1; END".to_owned(),
            "the trigger",
        ),
        // 270 MiB: above the limit, and written in a second.
        ("UPDATE tally SET sums = zeroblob(283115520) WHERE first = 0".to_owned(), "longer than any"),
        ("UPDATE study SET value = zeroblob(283115520) WHERE key = 'program'".to_owned(), "longer than any"),
    ] {
        let desk = Desk(crate::stores::folder());
        desk.write("study.toml", STUDY);
        desk.done(run);
        Connection::open(desk.path("results/study/tallies.sqlite")).unwrap().execute_batch(&sql).unwrap();
        for words in [
            "chart results/study --x filler --y rms",
            "report results/study",
            "check results/study",
            "merge results/study --out merged",
            run,
        ] {
            refused(&desk, words, &[5, 6], &[piece]);
        }
        if piece != "longer than any" {
            refused(&desk, "merge --salvage results/study --out merged", &[6], &[piece]);
        }
    }
}

#[test]
fn a_header_beyond_the_first_mebibyte_is_refused_and_one_within_it_is_read() {
    let log = |columns: usize, before: &str| {
        let names: Vec<String> = (0..columns).map(|column| format!("column{column:06}")).collect();
        let row = |line: usize| -> String {
            let cells: Vec<String> =
                (0..columns).map(|column| ((column + line * line) % 7).to_string()).collect();
            cells.join(",") + "\n"
        };
        format!("{before}{}\n{}", names.join(","), (0..20).map(row).collect::<String>())
    };
    let desk = Desk::with(STUDY);
    let read = format!("{READ} --column column000003");
    let message = ["has no complete header and no complete row in its first 1 MiB", "keep the header"];
    for (columns, before) in [(90_000, String::new()), (2, format!("# {}\n", "x".repeat(2 << 20)))] {
        desk.write("log.csv", &log(columns, &before));
        refused(&desk, &format!("allan log.csv {read}"), &[3], &message);
    }
    // The last line of the head is cut within its cells, which are not counted.
    desk.write("log.csv", &log(70_000, ""));
    desk.done(&format!("allan log.csv {read} --out a"));
}

#[test]
fn arguments_that_are_refused_are_shown_visibly() {
    let hostile = "\u{1b}]0;pwned\u{7}\u{9b}2J\u{7f}\u{202e}x";
    let desk = Desk::with(STUDY);
    for arguments in [
        vec!["run".to_owned(), "study.toml".to_owned(), format!("--{hostile}")],
        vec!["run".to_owned(), "study.toml".to_owned(), "--trials".to_owned(), hostile.to_owned()],
        vec![hostile.to_owned()],
    ] {
        for color in ["always", "never"] {
            let mut program = Command::new(PROGRAM);
            program.current_dir(desk.path(".")).args(&arguments).args(["--color", color]);
            let output = program.output().unwrap();
            assert_eq!(output.status.code(), Some(2), "{arguments:?}");
            let said = String::from_utf8(output.stderr).unwrap();
            let found = said.chars().find(|sign| (sign.is_control() && *sign != '\n') || *sign == '\u{202e}');
            assert_eq!(found, None, "{arguments:?}: {said:?}");
        }
    }
}

#[test]
fn names_that_spreadsheets_take_for_formulas_are_guarded_in_every_table_and_still_match() {
    let fillers = "{ kind = \"minimum-variance\", name = \"=cmd|' /C calc'!A0\", fit_ticks = 8, extrapolation_ticks = 2 }";
    let desk = Desk::with(&replaced("\"quadratic\"", fillers));
    let ended = desk.sagnac("run study.toml --trials 1000 --device cpu");
    if ended.code == 0 {
        let table = desk.read("results/study/points.csv");
        assert!(table.contains(",'=cmd|") && !table.contains(",=cmd"), "{table}");
        desk.done("check results/study");
    } else {
        assert_eq!(ended.code, 3, "{}", ended.stderr);
    }
    let rows: String = (0..200).map(|row| format!("{row},{}\n", (row * 7919) % 101)).collect();
    desk.write("log.csv", &format!("time [s],=cmd|calc!A0 [deg/h]\n{rows}"));
    desk.done("allan log.csv --data rate --out a");
    for name in desk.names("a").iter().filter(|name| name.ends_with(".csv")) {
        let text = desk.read(&format!("a/{name}"));
        for cell in csv::ReaderBuilder::new()
            .flexible(true)
            .from_reader(text.as_bytes())
            .records()
            .flat_map(|row| row.unwrap().iter().map(str::to_owned).collect::<Vec<_>>())
        {
            let is_formula = cell.starts_with(['=', '+', '-', '@']) && cell.parse::<f64>().is_err();
            assert!(!is_formula, "{name}: {cell}");
        }
    }
    assert!(desk.read("a/curve.csv").contains("'=cmd"), "{}", desk.read("a/curve.csv"));
}

#[test]
fn what_would_take_more_than_a_gibibyte_is_refused_before_it_does() {
    let desk = Desk::with("");
    let linear = |key: &str, to: &str, points: u32| {
        format!(
            "[[sweep]]\nkey = \"{key}\"\nlinear = {{ from = \"1 {to}\", to = \"50 {to}\", points = {points} }}\n"
        )
    };
    let sweeps = linear("motion.frequency", "Hz", 10_000) + &linear("motion.amplitude", "arcsec/s", 10);
    let errors = "\"quadratic\"]\nerrors = [\"residual\", \"extrapolation\", \"in-gap\"";
    let names = |count: usize| -> String {
        (0..count).map(|filler| format!(", {{ kind = \"const\", name = \"f{filler}\" }}")).collect()
    };
    let fillers = |count: usize| replaced("\"quadratic\"]", &format!("\"quadratic\"{}]", names(count)));
    let runs = "title = \"t\"\nkind = \"switched-run\"\n[drift]\nnon_magnetic = \"0.05 arcsec/s\"\n[switching]\ninterval = \"1 s\"\n\
                [run]\nduration = \"5 h\"\n";
    let curves = |trials: u64| {
        format!(
            "title = \"t\"\nkind = \"allan\"\ntrials = {trials}\n[record]\nsample = \"1 s\"\nlength = \"64 s\"\n\
             [noise]\nangle_random_walk = \"0.01 deg/sqrt(h)\"\n[allan]\ntau = \"decade10\"\n"
        )
    };
    for (text, pieces) in [
        (
            replaced("\"quadratic\"]", &format!("\"quadratic\"{}]\n{}", names(8), &errors[13..]))
                + "]\n"
                + &sweeps,
            ["the points of this study and their tables take", "MiB of memory"],
        ),
        (
            format!("{runs}trajectories = 1000\n{}", linear("drift.non_magnetic", "arcsec/s", 20)),
            ["the points of this study and their tables take", "fewer fillers, times or trajectories"],
        ),
        (
            format!("{runs}{}", linear("drift.non_magnetic", "arcsec/s", 1000)),
            ["the points of this study and their tables take", "sweep fewer values"],
        ),
        (curves(1 << 24), ["16777216 records of a point", "take 1 GiB of memory"]),
        (fillers(1000), ["switching.fillers lists 1002 fillers", "accepted: up to 1000"]),
    ] {
        desk.write("study.toml", &text);
        refused(&desk, "run study.toml --device cpu", &[3], &pieces);
    }
    let started = Instant::now();
    desk.write("study.toml", &fillers(400));
    desk.done("run study.toml --trials 8 --device cpu");
    assert!(started.elapsed() < AT_ONCE, "400 fillers took {:?}", started.elapsed());
    let names: Vec<String> = (0..1001).map(|column| format!("g{column} [deg/h]")).collect();
    let row = vec!["1"; names.len()].join(",") + "\n";
    desk.write("log.csv", &format!("{}\n{}", names.join(","), row.repeat(20)));
    let pieces = ["1001 columns of samples, more than 1000", "--column 2-100"];
    refused(&desk, "allan log.csv --data rate --rate 1Hz", &[3], &pieces);
    let row = ["1"; 900].join(",") + "\n1" + &",2".repeat(899) + "\n";
    desk.write("log.csv", &row.repeat(1200));
    let pieces = ["at most 2000000 samples of all columns together, the log has 2157600", "decade20"];
    refused(&desk, "allan log.csv --data rate --unit deg/h --rate 1Hz --column all --tau all", &[3], &pieces);
}
