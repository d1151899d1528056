//! The files that each command writes, and what happens where others are in their places.
//!
//! 20 swaps while each command runs by themselves; `SAGNAC_SWAPS=1000 cargo test --release --test program written_files --
//! --nocapture` for as many as one likes.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use rand::rngs::SmallRng;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use serde_json::Value;

use crate::desk::{Desk, STUDY};
use crate::logs::noise;

/// The list of a folder.
const LIST: &str = "written_by_sagnac.jsonl";

/// Commands that write into a results folder, without it.
const COMMANDS: [&str; 12] = [
    "run study.toml --trials 256 --device cpu --out",
    "run swept.toml --trials 64 --device cpu --out",
    "merge done --out",
    "allan log.csv --data rate --column gz --temperature temp --compensate --dynamic 10s --bootstrap 0 --out",
    "allan log.csv --data rate --column gz --navigate 10s --fit N --bootstrap 0 --out",
    "compare log.csv log.csv --data rate --column gz,gx --out",
    "compare log.csv --data rate --column gz,gx --out",
    "model noise.toml --from 1s --to 1000s --overbound --filter-rate 100Hz --write all --out",
    "filler study.toml --test-vectors 4 --out",
    "filler study.toml --limit residual=400arcsec --out",
    "design run.toml --trials 32 --device cpu --out",
    "sensitivity uncertain.toml --samples 8 --trials 32 --where filler=const --device cpu --out",
];

/// A folder with studies, a log and results for these commands.
fn desk() -> Desk {
    let desk = Desk::with(STUDY);
    let swept = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n\
                 [[chart]]\nx = \"frequency\"\ny = \"rms\"\n[[chart]]\nx = \"frequency\"\ny = \"p99_73\"\n";
    let profile = "profile = { file = \"base.csv\" }";
    let recorded = STUDY.replace("amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"", profile);
    desk.write("swept.toml", &format!("{STUDY}{swept}"));
    desk.write("recorded.toml", &recorded);
    let shake = |i: usize| format!("{},{}\n", 0.005 * i as f64, 3600.0 * (0.3 * i as f64).sin());
    desk.write(
        "base.csv",
        &("time [s],rate [arcsec/s]\n".to_owned() + &(0..2000).map(shake).collect::<String>()),
    );
    desk.write("log.csv", &log(600));
    desk.write(
        "noise.toml",
        "angle_random_walk = \"0.003 deg/sqrt(h)\"\nrate_random_walk = \"0.01 deg/h/sqrt(h)\"\n",
    );
    let whole = fs::read_to_string(format!("{}/studies/design_point.toml", crate::ROOT)).unwrap();
    desk.write("run.toml", &whole);
    let uncertain = "[[sensitivity]]\nkey = \"gyro.tick_noise.std\"\nnormal = { mean = \"1 arcsec\", sd = \"0.1 arcsec\" }\n";
    desk.write("uncertain.toml", &format!("{STUDY}{uncertain}"));
    desk.done("run recorded.toml --trials 256 --device cpu --out done --quiet");
    desk
}

/// A log of so many samples.
fn log(samples: usize) -> String {
    let row =
        |(i, y): (usize, f64)| format!("{},{y},{},{}\n", 0.1 * i as f64, 0.5 * y, 20.0 + 1e-3 * i as f64);
    let rows: String = noise(samples).enumerate().map(row).collect();
    format!("time [s],gz [deg/h],gx [deg/h],temp [degC]\n{rows}")
}

/// The names in the list of a folder.
fn listed(folder: &Path) -> BTreeSet<String> {
    let list = fs::read_to_string(folder.join(LIST)).unwrap();
    let entries = list.lines().skip(1).filter(|line| !line.is_empty());
    let entries = entries.map(|line| serde_json::from_str::<Value>(line).unwrap());
    let whole = entries.filter(|entry| !entry["sha256"].is_null());
    whole.map(|entry| entry["name"].as_str().unwrap().to_owned()).collect()
}

/// Writes `text` to a path below a folder that is made.
fn place(path: &Path, text: &str) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

#[test]
fn every_command_lists_what_it_writes_and_leaves_no_other_file() {
    let desk = desk();
    for (at, command) in COMMANDS.iter().enumerate() {
        let name = format!("out{at}");
        desk.done(&format!("{command} {name}"));
        let folder = desk.path(&name);
        let mut found = BTreeSet::new();
        for entry in desk.names(&name) {
            match folder.join(&entry).is_dir() {
                true => found.extend(
                    desk.names(&format!("{name}/{entry}"))
                        .into_iter()
                        .map(|inner| format!("{entry}/{inner}")),
                ),
                false => drop(found.insert(entry)),
            }
        }
        let own = [LIST, "tallies.sqlite", "tallies.lock"];
        found.retain(|name| !own.contains(&name.as_str()));
        assert_eq!(listed(&folder), found, "{command}");
        // It can be given again.
        desk.done(&format!("{command} {name}"));
    }
}

#[test]
fn no_command_changes_a_file_of_somebody_else_whatever_its_name() {
    let desk = desk();
    let mut names = BTreeSet::from(
        [LIST, "tallies.sqlite", "tallies.lock", "chart-7.png", "letter.txt"].map(str::to_owned),
    );
    for (at, command) in COMMANDS.iter().enumerate() {
        desk.done(&format!("{command} out{at}"));
        names.extend(listed(&desk.path(&format!("out{at}"))));
    }
    for left_out in [&[][..], &[LIST], &[LIST, "tallies.sqlite", "tallies.lock"]] {
        let home = desk.path("home");
        let kept: Vec<&String> = names.iter().filter(|name| !left_out.contains(&name.as_str())).collect();
        assert!(kept.len() > 40, "{kept:?}");
        for name in &kept {
            place(&home.join(name), &format!("mine: {name}"));
        }
        for command in COMMANDS {
            let ended = desk.sagnac(&format!("{command} home"));
            assert_ne!(ended.code, 0, "{command}");
            for name in &kept {
                assert_eq!(
                    fs::read_to_string(home.join(name)).unwrap(),
                    format!("mine: {name}"),
                    "{command}"
                );
            }
        }
        fs::remove_dir_all(home).unwrap();
    }
}

#[test]
fn whatever_is_in_the_place_of_a_file_nothing_outside_changes() {
    let desk = desk();
    let victim = desk.path("victim");
    let kinds = ["link", "hard link", "folder", "pipe", "link to a folder"];
    // All write through one gate: those with inputs, pictures, tables, many files and texts.
    for at in [0, 2, 3, 7, 8] {
        let command = COMMANDS[at];
        desk.done(&format!("{command} out{at}"));
        let mut names: BTreeSet<String> =
            listed(&desk.path(&format!("out{at}"))).into_iter().take(12).collect();
        names.extend([LIST, "tallies.sqlite", "tallies.sqlite-wal", "tallies.lock"].map(str::to_owned));
        // Those of one command have the same way to the disk: each is tried as a link, and one as anything else.
        let odd = at % names.len();
        for (number, name) in names.iter().enumerate() {
            for kind in kinds.iter().take(if number == odd { kinds.len() } else { 1 }) {
                fs::create_dir_all(&victim).unwrap();
                fs::write(victim.join("file"), "mine").unwrap();
                let path = desk.path("home").join(name);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                match *kind {
                    "link" => symlink(victim.join("file"), &path).unwrap(),
                    "hard link" => fs::hard_link(victim.join("file"), &path).unwrap(),
                    "folder" => fs::create_dir(&path).unwrap(),
                    "pipe" => assert!(Command::new("mkfifo").arg(&path).status().unwrap().success()),
                    _ => {
                        fs::remove_dir_all(desk.path("home")).unwrap();
                        fs::create_dir(desk.path("home")).unwrap();
                        let first = name.split('/').next().unwrap();
                        symlink(&victim, desk.path("home").join(first)).unwrap();
                    }
                }
                desk.sagnac(&format!("{command} home"));
                assert_eq!(
                    fs::read_to_string(victim.join("file")).unwrap(),
                    "mine",
                    "{command}, {name} as a {kind}"
                );
                assert_eq!(desk.names("victim"), ["file"], "{command}, {name} as a {kind}");
                fs::remove_dir_all(desk.path("home")).unwrap();
                fs::remove_dir_all(&victim).unwrap();
            }
        }
    }
}

/// Everything in a folder and in those within it, files first.
fn all(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| if path.is_dir() { [all(&path), vec![path]].concat() } else { vec![path] })
        .collect()
}

/// A path with more at its end.
fn ending(path: &Path, end: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(end);
    name.into()
}

/// Puts links, pipes and folders in the places of what a command writes, each for a moment, until `is_done`.
fn swap(paths: &[PathBuf], victim: &Path, is_done: &AtomicBool, count: &AtomicUsize, random: &mut SmallRng) {
    while !is_done.load(Ordering::Relaxed) {
        let path = paths.choose(random).unwrap();
        let away = ending(path, ".away");
        let was_there = fs::rename(path, &away).is_ok();
        let swapped = match random.random_range(0..5) {
            0 => symlink(victim.join("file"), path).is_ok(),
            1 => symlink(victim, path).is_ok(),
            2 => fs::hard_link(victim.join("file"), path).is_ok(),
            3 => fs::create_dir(path).is_ok(),
            _ => Command::new("mkfifo").arg(path).stderr(Stdio::null()).status().unwrap().success(),
        };
        std::thread::sleep(Duration::from_micros(random.random_range(0..2000)));
        if swapped {
            count.fetch_add(1, Ordering::Relaxed);
            // The command may have put its own there meanwhile.
            let _ = fs::remove_file(path).or_else(|_| fs::remove_dir(path));
        }
        if was_there {
            let _ = fs::rename(&away, path);
        }
    }
}

#[test]
fn nothing_outside_changes_while_others_swap_what_a_command_writes() {
    let wanted: usize = std::env::var("SAGNAC_SWAPS").map_or(20, |text| text.parse().unwrap());
    let seed: u64 = std::env::var("SAGNAC_SEED").map_or(1, |text| text.parse().unwrap());
    let mut random = SmallRng::seed_from_u64(seed);
    let desk = desk();
    let victim = desk.path("victim");
    place(&victim.join("file"), "mine");
    for command in COMMANDS {
        let (home, count, mut ends) = (desk.path("home"), AtomicUsize::new(0), [0, 0]);
        while count.load(Ordering::Relaxed) < wanted {
            desk.done(&format!("{command} home"));
            fs::write(home.join("letter.txt"), "mine").unwrap();
            let found = all(&home).into_iter().filter(|path| path.file_name() != Some("letter.txt".as_ref()));
            let partial = |path: PathBuf| [ending(&path, ".sagnac_partial"), path];
            let journals = ["tallies.sqlite-wal", "tallies.sqlite-shm"].map(|name| home.join(name));
            let paths: Vec<PathBuf> = found.flat_map(partial).chain(journals).collect();
            let is_done = AtomicBool::new(false);
            std::thread::scope(|scope| {
                scope.spawn(|| swap(&paths, &victim, &is_done, &count, &mut random));
                let code = desk.sagnac(&format!("{command} home")).code;
                is_done.store(true, Ordering::Relaxed);
                assert!([0, 6].contains(&code), "{command}: {code}");
                ends[usize::from(code != 0)] += 1;
            });
            assert_eq!(fs::read_to_string(victim.join("file")).unwrap(), "mine", "{command}");
            assert_eq!(desk.names("victim"), ["file"], "{command}");
            assert_eq!(fs::read_to_string(home.join("letter.txt")).unwrap(), "mine", "{command}");
            fs::remove_dir_all(&home).unwrap();
        }
        println!("{command}: {count:?} swaps, {} runs that ended well, {} refused", ends[0], ends[1]);
    }
}

#[test]
fn a_received_folder_writes_nowhere_else_when_it_is_shown() {
    let desk = desk();
    place(&desk.path("victim/base.csv"), "mine");
    fs::remove_dir_all(desk.path("done/inputs")).unwrap();
    fs::copy(desk.path("base.csv"), desk.path("done/base.csv")).unwrap();
    symlink(desk.path("victim"), desk.path("done/inputs")).unwrap();
    let resolved = desk.read("done/resolved_study.toml").replace("inputs/base.csv", "base.csv");
    desk.write("done/resolved_study.toml", &resolved);
    for words in [
        "report done",
        "report .",
        "run done/resolved_study.toml --device cpu",
        "merge done --out done",
        "chart done",
    ] {
        desk.sagnac(words);
        assert_eq!(desk.read("victim/base.csv"), "mine", "{words}");
        assert_eq!(desk.names("victim"), ["base.csv"], "{words}");
    }
}

#[test]
fn inputs_are_never_outputs_and_files_that_a_user_names_are_new() {
    let desk = desk();
    desk.done("allan log.csv --data rate --column gz --bootstrap 0 --out a");
    let before = desk.read("a/psd.csv");
    desk.fails(
        "allan a/psd.csv --data rate --rate 1Hz --unit none --column 3 --time none --bootstrap 0 --out a",
        6,
        &["a/psd.csv is read by this command", "write to another folder"],
    );
    assert_eq!(desk.read("a/psd.csv"), before);
    desk.write("mine.csv", "mine");
    let words = "allan log.csv --data rate --column gz --bootstrap 0 --out b --record mine.csv";
    desk.fails(words, 2, &["mine.csv would replace a file", "another FILE"]);
    assert_eq!(desk.read("mine.csv"), "mine");
}

#[test]
fn a_folder_of_an_earlier_version_is_left_until_it_is_adopted() {
    let desk = desk();
    fs::remove_file(desk.path("done").join(LIST)).unwrap();
    desk.write("done/letter.txt", "mine");
    let before = desk.read("done/report.html");
    let again = "run recorded.toml --trials 512 --device cpu --out done";
    desk.fails(again, 6, &["of an earlier version", "sagnac check done --adopt"]);
    assert_eq!(desk.read("done/report.html"), before);
    let ended = desk.done("check done --adopt");
    assert!(ended.stdout.contains("took over") && ended.stdout.contains("report.html"), "{}", ended.stdout);
    assert!(!ended.stdout.contains("letter.txt"), "{}", ended.stdout);
    desk.done(again);
    assert_ne!(desk.read("done/report.html"), before);
    desk.fails("check . --adopt", 2, &["holds no results"]);
}

#[test]
fn two_commands_never_write_into_a_folder_at_once() {
    let desk = desk();
    desk.done("allan log.csv --data rate --column gz --bootstrap 0 --out al");
    let lock = fs::File::options().read(true).write(true).open(desk.path("al/tallies.lock")).unwrap();
    lock.lock().unwrap();
    for command in COMMANDS {
        let before = fs::read_dir(desk.path("al")).unwrap().count();
        desk.fails(&format!("{command} al"), 6, &["al is in use by"]);
        assert_eq!(fs::read_dir(desk.path("al")).unwrap().count(), before, "{command}");
    }
    desk.fails("check al --adopt", 6, &["al is in use by"]);
}

#[test]
fn a_refused_command_replaces_nothing() {
    let desk = desk();
    for (at, command) in COMMANDS.iter().enumerate().skip(3) {
        let name = format!("out{at}");
        desk.done(&format!("{command} {name}"));
        let names = listed(&desk.path(&name));
        // Without the others, whatever is written is seen.
        let refused = names.last().unwrap();
        for other in names.iter().filter(|other| *other != refused) {
            fs::remove_file(desk.path(&format!("{name}/{other}"))).unwrap();
        }
        fs::write(desk.path(&format!("{name}/{refused}")), "edited").unwrap();
        desk.fails(&format!("{command} {name}"), 6, &["is not as sagnac wrote it"]);
        let left: Vec<_> = all(&desk.path(&name)).into_iter().filter(|path| path.is_file()).collect();
        assert_eq!(left.len(), 3, "{command}: {left:?}");
    }
}

#[test]
fn a_run_that_is_refused_for_a_table_keeps_its_study_as_it_was() {
    let desk = desk();
    let noise = "title = \"A gyro\"\nkind = \"allan\"\ntrials = 16\n[record]\nsample = \"1 s\"\nlength = \"1 h\"\n[allan]\n\
                 tau = \"octave\"\nfit = \"auto\"\n[noise]\nangle_random_walk = \"0.001 deg/sqrt(h)\"\n";
    desk.write("gyro.toml", noise);
    desk.done("run gyro.toml --device cpu --out al");
    for name in ["resolved_study.toml", "points.csv", "coefficients.csv", "report.html", "chart.svg"] {
        let before = ["resolved_study.toml", name].map(|name| desk.read(&format!("al/{name}")));
        desk.write(&format!("al/{name}"), "edited");
        desk.fails(
            "run gyro.toml --trials 32 --device cpu --out al",
            6,
            &[name, "is not as sagnac wrote it", "move it"],
        );
        desk.write(&format!("al/{name}"), &before[1]);
        assert_eq!(desk.read("al/resolved_study.toml"), before[0], "{name}");
        desk.done("check al");
    }
}

#[test]
fn results_of_a_study_that_was_replaced_are_unfinished_until_they_are_written() {
    let desk = desk();
    let charted = desk.read("swept.toml").replace("\"p99_73\"", "\"max\"");
    desk.write("other.toml", &charted);
    desk.done("run swept.toml --trials 64 --device cpu --out out");
    // Room for the study, and not for the page.
    let script = format!(
        "ulimit -f 64; exec {} run other.toml --trials 64 --device cpu --out out",
        crate::desk::PROGRAM
    );
    let ended = Command::new("sh").args(["-c", &script]).current_dir(desk.path("")).output().unwrap();
    assert_eq!(ended.status.code(), Some(6), "{}", String::from_utf8_lossy(&ended.stderr));
    for command in ["chart out --name drawn", "report out --quiet"] {
        assert_eq!(desk.read("out/resolved_study.toml").matches("\"max\"").count(), 1);
        let ended = desk.sagnac("check out");
        assert!(ended.code == 4 && ended.stderr.contains("was interrupted"), "{}", ended.stderr);
        desk.done(command);
    }
    assert_eq!(desk.sagnac("check out").code, 4);
    desk.done("run other.toml --trials 64 --device cpu --out out");
    desk.done("check out");
    // A share writes no results, so none are missing.
    desk.done("run other.toml --trials 64 --device cpu --shard 1/2 --out half");
    desk.done("run swept.toml --trials 64 --device cpu --shard 1/2 --out half");
    desk.done("check half");
}

#[test]
fn what_is_no_longer_drawn_is_never_missing() {
    let desk = desk();
    let one = desk.read("swept.toml").replace("[[chart]]\nx = \"frequency\"\ny = \"p99_73\"\n", "");
    desk.write("one.toml", &one);
    let [two, one] =
        ["swept", "one"].map(|study| format!("run {study}.toml --trials 64 --device cpu --out out"));
    let path = |name: &str| desk.path("out").join(name);
    desk.done(&two);
    desk.done("chart out --name drawn");
    for name in ["drawn.svg", "chart-2.svg"] {
        fs::remove_file(path(name)).unwrap();
    }
    desk.write("out/chart-2.png", "edited");
    fs::remove_file(path("chart-1.png")).unwrap();
    fs::create_dir(path("chart-1.png")).unwrap();
    assert_eq!(desk.sagnac("check out").code, 5);
    desk.done(&one);
    desk.done("check out");
    assert_eq!(desk.read("out/chart-2.png"), "edited");
    assert!(path("chart-1.png").is_dir());
}

#[test]
fn a_run_whose_list_cannot_be_written_ends_with_an_error() {
    let desk = desk();
    fs::hard_link(desk.path("done").join(LIST), desk.path("other_name")).unwrap();
    let before = desk.read("done/report.html");
    let again = "run recorded.toml --trials 512 --device cpu --out done";
    desk.fails(again, 6, &["written_by_sagnac.jsonl is a hard link", "copy it in its place"]);
    assert_eq!(desk.read("done/report.html"), before);
}

#[test]
fn a_copy_of_hard_links_is_read_and_not_written() {
    let desk = desk();
    let copied =
        Command::new("cp").args(["-al", "done", "copy"]).current_dir(desk.path("")).status().unwrap();
    assert!(copied.success());
    desk.done("check done");
    desk.done("check copy");
    desk.done("merge copy --out merged");
    assert_eq!(desk.read("merged/points.csv"), desk.read("done/points.csv"));
    desk.fails("run recorded.toml --trials 512 --device cpu --out done", 6, &["hard link", "copy"]);
}

#[test]
fn a_resolved_study_alone_is_run_where_it_is() {
    let desk = desk();
    fs::create_dir(desk.path("n")).unwrap();
    desk.done("run study.toml --trials 256 --device cpu --out a");
    fs::copy(desk.path("a/resolved_study.toml"), desk.path("n/resolved_study.toml")).unwrap();
    desk.done("run n/resolved_study.toml --device cpu");
    assert_eq!(desk.read("n/points.csv"), desk.read("a/points.csv"));
    // What `check` says about a table works.
    let table = desk.read("a/points.csv").replace('\n', "\r\n");
    desk.write("a/points.csv", &table);
    let said = desk.sagnac("check a").stderr;
    assert!(said.contains("move it away, and run a/resolved_study.toml again"), "{said}");
    fs::rename(desk.path("a/points.csv"), desk.path("away.csv")).unwrap();
    desk.done("run a/resolved_study.toml --device cpu");
    desk.done("check a");
}

#[test]
fn a_folder_without_results_is_not_said_to_be_of_an_earlier_version() {
    let desk = desk();
    desk.done("man mn");
    desk.write("mn/sagnac.1", "edited");
    let ended = desk.sagnac("man mn");
    assert!(
        ended.code == 6 && ended.stderr.contains("move it") && !ended.stderr.contains("--adopt"),
        "{}",
        ended.stderr
    );
}

#[test]
fn a_gallery_is_a_page_and_makes_no_results_folder_of_its_own() {
    let desk = desk();
    for folder in ["res/a", "elsewhere/big"] {
        desk.done(&format!("run study.toml --trials 256 --device cpu --out {folder}"));
    }
    symlink(desk.path("elsewhere/big"), desk.path("res/big")).unwrap();
    for _ in 0..2 {
        desk.done("report res");
        assert_eq!(desk.names("res"), ["a", "big", "gallery.html"]);
        assert_eq!(desk.names("elsewhere"), ["big"]);
    }
    // Links in a folder with a gallery are the user's own.
    desk.done("run study.toml --trials 256 --device cpu --out res/big");
    fs::create_dir(desk.path("here")).unwrap();
    let card = desk.read("done/report.html");
    desk.write("gallery.html", "mine");
    desk.fails("report res/a done", 6, &["gallery.html is not as sagnac wrote it"]);
    // A page of results is no gallery, and none is among the files of results.
    fs::copy(desk.path("done/report.html"), desk.path("page.html")).unwrap();
    desk.fails("report res/a done --out page.html", 6, &["page.html is not as sagnac wrote it"]);
    for name in ["points.csv", "report.html", "new.html"] {
        let words = format!("report res/a done --out done/{name}");
        desk.fails(&words, 6, &[name, "among the files of a results folder", "--out FILE"]);
    }
    assert_eq!((desk.read("gallery.html"), desk.read("done/report.html")), ("mine".to_owned(), card));
    desk.done("check done");
    fs::remove_file(desk.path("gallery.html")).unwrap();
    symlink(desk.path("victim"), desk.path("gallery.html")).unwrap();
    desk.fails("report res/a done", 6, &["gallery.html is a link"]);
    assert!(!desk.path("victim").exists());
}

#[test]
fn columns_with_names_of_any_length_are_analysed() {
    let desk = desk();
    for length in [300, 70_000] {
        let name = "é".repeat(length / 2);
        let rows: String = desk.read("log.csv").lines().skip(1).map(|row| format!("{row}\n")).collect();
        desk.write("long.csv", &format!("time [s],{name}a [deg/h],{name}b [deg/h],temp [degC]\n{rows}"));
        desk.done("allan long.csv --data rate --column 2-3 --time 1 --bootstrap 0 --out long");
        let begun = format!("_{}.toml", "é".repeat(100));
        assert_eq!(desk.names("long").iter().filter(|name| name.ends_with(&begun)).count(), 2);
        desk.done("allan long.csv --data rate --column 2-3 --time 1 --bootstrap 0 --out spectra");
    }
}

#[test]
fn on_a_full_disk_no_half_of_a_file_is_left() {
    let desk = desk();
    let limited = |blocks: u32, words: &str| {
        let script = format!("ulimit -f {blocks}; exec {} {words}", crate::desk::PROGRAM);
        let ended = Command::new("sh").args(["-c", &script]).current_dir(desk.path("")).output().unwrap();
        assert_eq!(ended.status.code(), Some(6), "{words}: {}", String::from_utf8_lossy(&ended.stderr));
    };
    let before = desk.names("");
    limited(1, "new gap-fill new.toml");
    desk.write("log.csv", &log(2000));
    desk.done("allan log.csv --data rate --column gz --bootstrap 0 --out al");
    limited(100, "allan log.csv --data rate --column gz --bootstrap 0 --out al --record record.csv");
    desk.done("filler quadratic --gap-ticks 3 --out res/a");
    desk.done("filler quadratic --gap-ticks 2 --out res/b");
    limited(16, "report res/a res/b");
    fs::remove_dir_all(desk.path("al")).unwrap();
    assert_eq!(desk.names("res"), ["a", "b"]);
    fs::remove_dir_all(desk.path("res")).unwrap();
    assert_eq!(desk.names(""), before);
}

#[test]
fn files_that_were_adopted_are_never_removed() {
    let desk = desk();
    let allan = "allan log.csv --data rate --column gz,gx --bootstrap 0 --out al";
    desk.done(allan);
    fs::remove_file(desk.path("al").join(LIST)).unwrap();
    desk.write("al/noise_of_unit7.toml", "mine");
    desk.done("check al --adopt");
    desk.done(&allan.replace("gz,gx", "gz"));
    assert_eq!(desk.read("al/noise_of_unit7.toml"), "mine");
    // With a list, nothing is an earlier version's.
    desk.write("al/noise_x.toml", "mine");
    desk.write("al/curve.csv", "edited");
    assert!(desk.done("check al --adopt").stdout.contains("took over nothing"));
    desk.fails(allan, 6, &["curve.csv is not as sagnac wrote it", "move it"]);
}

#[test]
fn check_says_what_was_changed_and_what_it_cannot_check() {
    let desk = desk();
    desk.done("check done");
    let resolved = desk.read("done/resolved_study.toml");
    desk.write("done/resolved_study.toml", &resolved.replace("A study", "Another study"));
    let ended = desk.sagnac("check done");
    assert_eq!(ended.code, 5, "{}", ended.stderr);
    assert!(ended.stderr.contains("resolved_study.toml was changed"), "{}", ended.stderr);
    fs::remove_file(desk.path("done/resolved_study.toml")).unwrap();
    let ended = desk.sagnac("check done");
    assert_eq!(ended.code, 5, "{}", ended.stderr);
    assert!(ended.stderr.contains("resolved_study.toml is missing"), "{}", ended.stderr);
    desk.write("done/resolved_study.toml", &resolved);
    desk.done("check done");
    // An earlier version of a page, and one that was removed.
    let page = desk.read("done/report.html");
    desk.done("run recorded.toml --trials 512 --device cpu --out done");
    let newer = desk.read("done/report.html");
    desk.write("done/report.html", &page);
    let ended = desk.sagnac("check done");
    assert!(ended.code == 5 && ended.stderr.contains("report.html was changed"), "{}", ended.stderr);
    fs::remove_file(desk.path("done/report.html")).unwrap();
    let ended = desk.sagnac("check done");
    assert!(ended.code == 5 && ended.stderr.contains("report.html was removed"), "{}", ended.stderr);
    desk.write("done/report.html", &newer);
    desk.done("check done");
    fs::remove_file(desk.path("done").join(LIST)).unwrap();
    let ended = desk.done("check done");
    assert!(ended.stderr.contains("without a list"), "{}", ended.stderr);
    desk.done("chart done --x filler --y rms");
    let ended = desk.done("check done");
    assert!(ended.stderr.contains("its list lacks resolved_study.toml, report.html"), "{}", ended.stderr);
}

#[test]
fn a_changed_table_of_an_incomplete_folder_is_found() {
    let desk = desk();
    desk.done("run study.toml --trials 4096 --device cpu --shard 1/2 --out half");
    assert_eq!(desk.sagnac("merge half --out part").code, 4);
    assert_eq!(desk.sagnac("check part").code, 4);
    let table = desk.read("part/points.csv");
    desk.write("part/points.csv", &table.replace(",const,", ",Const,"));
    let ended = desk.sagnac("check part");
    assert!(ended.code == 5 && ended.stderr.contains("points.csv does not match"), "{}", ended.stderr);
}

#[test]
fn what_strangers_wrote_makes_no_message_without_end() {
    let desk = desk();
    fs::File::create(desk.path("done/tallies.lock")).unwrap().set_len(3 << 30).unwrap();
    let ended = desk.sagnac("check done");
    assert!(ended.code == 6 && ended.stderr.contains("is not a lock of sagnac"), "{}", ended.stderr);
    fs::remove_file(desk.path("done/tallies.lock")).unwrap();
    let name = "x".repeat(100_000);
    let list = desk.read(&format!("done/{LIST}"));
    desk.write(
        &format!("done/{LIST}"),
        &format!("{list}{{\"name\":\"{name}\",\"sha256\":\"00\",\"size\":1}}\n"),
    );
    assert!(desk.sagnac("check done").stderr.len() < 10_000);
    let said = desk.sagnac(&format!("check {}", &name[..100_000])).stderr;
    assert!(said.len() < 20_000, "{}", said.len());
}

#[test]
fn a_run_whose_database_or_folder_vanishes_ends_with_an_error() {
    for gone in ["out/tallies.sqlite", "out"] {
        let desk = desk();
        let mut run = Command::new(crate::desk::PROGRAM)
            .args([
                "run",
                "study.toml",
                "--trials",
                "1000000000000",
                "--device",
                "cpu",
                "--threads",
                "1",
                "--out",
                "out",
            ])
            .current_dir(desk.path(""))
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let waited = std::time::Instant::now();
        // The study is kept after the database is made, and before anything is sampled.
        while !desk.path("out/resolved_study.toml").exists() {
            assert!(waited.elapsed().as_secs() < 60);
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
        let path = desk.path(gone);
        if path.is_dir() {
            fs::remove_dir_all(path).unwrap()
        } else {
            fs::remove_file(path).unwrap()
        }
        let mut ended = None;
        while ended.is_none() && waited.elapsed().as_secs() < 100 {
            std::thread::sleep(std::time::Duration::from_millis(100));
            ended = run.try_wait().unwrap();
        }
        let _ = run.kill();
        let said = String::from_utf8(run.wait_with_output().unwrap().stderr).unwrap();
        assert_eq!(ended.and_then(|ended| ended.code()), Some(6), "{gone}: {said}");
        assert!(said.contains("was removed or replaced"), "{gone}: {said}");
    }
}
