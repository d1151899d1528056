//! Control characters in what the program is given never reach a terminal. Each test puts the same hostile text, which
//! would set a title, clear the screen and turn the direction of writing, at another place.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::process::Command;

use crate::desk::{Desk, Ended, PROGRAM, STUDY, replaced, with};

/// The hostile text: `ESC ] 0 ; pwned BEL`, `ESC [ 2 J`, a C1 control sequence, DEL and a right-to-left override.
const HOSTILE: &str = "\u{1b}]0;pwned\u{7}\u{1b}[2J\u{9b}2J\u{7f}\u{202e}x";

/// The same in a basic string of TOML.
const IN_TOML: &str = r"\u001b]0;pwned\u0007\u001b[2J\u009b2J\u007f\u202ex";

/// Checks what a command said, and that the hostile text is in it as one can see it.
fn shows(ended: &Ended, words: &str) {
    harmless(ended, words);
    let all = format!("{}{}", ended.stdout, ended.stderr).replace("\n  │ ", "");
    assert!(all.contains("pwned"), "`sagnac {words}` does not show the text:\n{all}");
}

fn harmless(ended: &Ended, words: &str) {
    for (text, name) in [(&ended.stdout, "stdout"), (&ended.stderr, "stderr")] {
        let is_control = |sign: &char| sign.is_control() && !matches!(sign, '\n' | '\t');
        let is_turning = |sign: &char| matches!(sign, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        let found = text.chars().find(|sign| is_control(sign) || is_turning(sign));
        assert_eq!(found, None, "`sagnac {words}` on {name}: {text:?}");
    }
}

#[test]
fn titles_and_questions_are_shown_visibly() {
    let named = replaced("title = \"A study\"", &format!("title = \"{IN_TOML}\"\nquestion = \"{IN_TOML}\""));
    let desk = Desk::with(&named);
    let study = "--device cpu --trials 4096";
    for words in [
        format!("run study.toml --plot {study}"),
        "chart results/study --x filler --y rms --plot".to_owned(),
        format!("run study.toml --json {study}"),
        "filler results/study/resolved_study.toml".to_owned(),
        "merge results/study --out merged".to_owned(),
    ] {
        let ended = desk.sagnac(&words);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        shows(&ended, &words);
    }
    for words in ["check results/study", "report results/study", "run study.toml --color always --plot"] {
        let ended = desk.sagnac(words);
        let coloured = ended.stdout.replace("\u{1b}[0m", "");
        let without = (30..38).fold(coloured, |text, colour| text.replace(&format!("\u{1b}[{colour}m"), ""));
        harmless(&Ended { stdout: without, ..ended }, words);
    }
}

#[test]
fn faults_of_a_study_are_shown_visibly_with_the_caret_at_its_place() {
    for (text, code) in [
        (with(&format!("\"{IN_TOML}\" = 1")), 3),
        // Not valid in TOML, but a line that the message shows.
        (with(&format!("{HOSTILE} = 1")), 3),
        (replaced("\"quadratic\"", &format!("\"{IN_TOML}\"")), 3),
        (replaced("\"quadratic\"", &format!("{{ kind = \"minimum-variance\", name = \"{IN_TOML}\" }}")), 3),
        (replaced("\"20 Hz\"", &format!("\"{IN_TOML}\"")), 3),
        (format!("{STUDY}# {HOSTILE}\nframes = 1\n"), 3),
    ] {
        let desk = Desk::with(&text);
        let ended = desk.sagnac("run study.toml");
        assert_eq!(ended.code, code, "{}", ended.stderr);
        shows(&ended, "run study.toml");
        let coloured = desk.sagnac("run study.toml --color always").stderr;
        assert!(!coloured.contains("\u{1b}]") && !coloured.contains("\u{1b}[2J"), "{coloured:?}");
    }
    // The caret is below the word, not below what a terminal would have left of the line.
    let desk = Desk::with(&format!("{STUDY}note = \"{HOSTILE}\" oops\n"));
    let said = desk.sagnac("run study.toml").stderr;
    let lines: Vec<&str> = said.lines().collect();
    let line = lines.iter().position(|line| line.contains("pwned")).unwrap();
    let column = |line: &str, sign: &str| line.find(sign).map(|at| line[..at].chars().count());
    assert!(column(lines[line], "␛").is_some() && column(lines[line + 1], "▲").is_some(), "{said}");
}

#[test]
fn headers_of_logs_are_shown_visibly() {
    let rows: String = (0..200).map(|row| format!("{},{}\n", row, (row * 7919) % 101)).collect();
    let desk = Desk::with(STUDY);
    desk.write("log.csv", &format!("time [s],{HOSTILE} [deg/h]\n{rows}"));
    desk.write("bad.csv", &format!("time [s],rate [deg/h]\n{rows}200,{HOSTILE}\n"));
    desk.write("unit.csv", &format!("time [s],rate [{HOSTILE}]\n{rows}"));
    for words in [
        "allan log.csv --data rate",
        "allan log.csv --data rate",
        "allan log.csv --data rate --column nothing",
        "allan bad.csv --data rate",
        "allan unit.csv --data rate",
    ] {
        shows(&desk.sagnac(words), words);
    }
    harmless(&desk.sagnac("compare log.csv log.csv --data rate"), "compare log.csv log.csv --data rate");
    harmless(&desk.sagnac("allan log.csv --data rate --json"), "allan log.csv --data rate --json");
}

#[test]
fn names_of_files_are_shown_visibly() {
    let desk = Desk::with(STUDY);
    // A terminal takes the bytes of a file name too; this one is no UTF-8.
    for name in [HOSTILE.as_bytes().to_vec(), [b"a\x9b2J\xff".as_slice(), HOSTILE.as_bytes()].concat()] {
        let name = OsStr::from_bytes(&name);
        for (command, made) in
            [("run", false), ("run", true), ("check", false), ("report", false), ("allan", false)]
        {
            if made {
                std::fs::write(desk.path("x").with_file_name(name), STUDY).unwrap();
            }
            let mut program = Command::new(PROGRAM);
            program.current_dir(desk.0.path()).arg(command).arg(name);
            match command {
                "run" => program.args(["--device", "cpu", "--trials", "1000"]),
                "allan" => program.args(["--data", "rate"]),
                _ => &mut program,
            };
            let output = program.output().unwrap();
            let text = |bytes| String::from_utf8(bytes).unwrap();
            let code = output.status.code().unwrap();
            shows(&Ended { code, stdout: text(output.stdout), stderr: text(output.stderr) }, command);
        }
    }
}

#[test]
fn the_holder_of_a_lock_is_shown_visibly() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000";
    desk.done(run);
    desk.write("results/study/tallies.lock", &format!("4711\n{HOSTILE}\n1000000000\n"));
    let lock = std::fs::File::open(desk.path("results/study/tallies.lock")).unwrap();
    lock.lock().unwrap();
    let ended = desk.sagnac(run);
    assert_eq!(ended.code, 6, "{}", ended.stderr);
    shows(&ended, run);
}

#[test]
fn texts_of_a_database_are_shown_visibly() {
    for sql in [
        format!("UPDATE study SET value = '{HOSTILE}' WHERE key = 'program'"),
        format!("UPDATE study SET value = '{HOSTILE}' WHERE key = 'kind'"),
        format!("UPDATE study SET value = '{HOSTILE}' WHERE key = 'schema'"),
        format!("UPDATE study SET value = '{HOSTILE}' WHERE key = 'kernels'"),
        format!("UPDATE provenance SET device = '{HOSTILE}', program = '{HOSTILE}'"),
        format!("CREATE VIEW \"{HOSTILE}\" AS SELECT 1"),
    ] {
        let desk = Desk::with(STUDY);
        let run = "run study.toml --device cpu --trials 1000";
        desk.done(run);
        let store = rusqlite::Connection::open(desk.path("results/study/tallies.sqlite")).unwrap();
        store.execute(&sql, []).unwrap();
        drop(store);
        for words in [
            run,
            "check results/study",
            "chart results/study --x filler --y rms",
            "merge results/study --out m",
        ] {
            let ended = desk.sagnac(words);
            harmless(&ended, words);
        }
    }
}
