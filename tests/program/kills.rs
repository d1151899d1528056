//! kill −9 at any moment: what is resumed is what an undisturbed run gives, to the last bit.
//!
//! 20 kills by themselves; `SAGNAC_KILLS=200 cargo test --release --test program kills -- --nocapture` for as many as one likes.
#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::desk::{Desk, PROGRAM};
use crate::stores::{MOMENTS, ROWS, rows};
use rand::{RngExt, SeedableRng};
use sagnac::store::FILE;

/// Many points, so that much is written: transactions are on their way to the disk most of the time.
const POINTS: usize = 100;

fn studies() -> [(&'static str, String); 2] {
    let sweep = |key: &str, unit: &str| {
        let list: Vec<String> = (1..=POINTS).map(|i| format!("\"{i}e-2 {unit}\"")).collect();
        format!("[[sweep]]\nkey = \"{key}\"\nlist = [{}]\n", list.join(", "))
    };
    let swept = |text: &str, sweep: String| text.split("[[sweep]]").next().unwrap().to_owned() + &sweep;
    [
        (
            "moments",
            swept(MOMENTS, sweep("motion.frequency", "Hz")).replace("trials = 1000", "trials = 400_000"),
        ),
        (
            "rows",
            swept(ROWS, sweep("noise.angle_random_walk", "deg/sqrt(h)"))
                .replace("trials = 150", "trials = 3000"),
        ),
    ]
}

fn start(desk: &Desk, study: &str, folder: &str) -> Child {
    Command::new(PROGRAM)
        .current_dir(desk.0.path())
        .args(["run", &format!("{study}.toml"), "--device", "cpu", "--quiet", "--out", folder])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// What a kill left.
#[derive(Default)]
struct Count {
    kills: usize,
    /// Kills that left a transaction unfinished in the journal.
    torn: usize,
    /// Runs that ended before they could be killed, or had not come further than the one before.
    idle: usize,
    resumed: usize,
}

/// Kills a run some time after it has begun to write; whether it was still alive.
fn killed(child: &mut Child, folder: &Path, random: &mut rand::rngs::SmallRng) -> bool {
    let journal = folder.join(format!("{FILE}-wal"));
    let size = || journal.metadata().map_or(0, |file| file.len());
    let (started, before) = (Instant::now(), size());
    // Half of the kills come while the journal grows by rows, which is more than whose they are, half at any time after that.
    while size() <= before + (20 << 10) && child.try_wait().unwrap().is_none() {
        assert!(started.elapsed() < Duration::from_secs(60), "nothing was written");
        std::thread::sleep(Duration::from_micros(100));
    }
    let wait = if random.random() { random.random_range(0..300) } else { random.random_range(0..1_000_000) };
    std::thread::sleep(Duration::from_micros(wait));
    child.kill().unwrap();
    child.wait().unwrap().code().is_none()
}

/// Whether the journal ends within a transaction: its last frame of the present round is none that commits.
fn is_torn(folder: &Path) -> bool {
    let Ok(journal) = std::fs::read(folder.join(format!("{FILE}-wal"))) else { return false };
    let Some((header, frames)) = journal.split_at_checked(32) else { return false };
    let page = u32::from_be_bytes(header[8..12].try_into().unwrap()) as usize;
    let present =
        frames.chunks(24 + page).take_while(|frame| frame.len() > 24 && frame[8..16] == header[16..24]);
    present.last().is_some_and(|frame| frame.len() < 24 + page || frame[4..8] == [0; 4])
}

/// How many rows there are, without touching them.
fn rows_of_copy(folder: &Path) -> usize {
    let copy = crate::stores::folder();
    for file in [FILE.to_owned(), format!("{FILE}-wal")] {
        // A run that was killed early may have left no journal.
        let _ = std::fs::copy(folder.join(&file), copy.path().join(&file));
    }
    rows(copy.path()).len()
}

#[test]
fn killed_runs_resume_to_the_bits_of_one_that_was_not() {
    let wanted: usize = std::env::var("SAGNAC_KILLS").map_or(20, |text| text.parse().unwrap());
    let seed: u64 = std::env::var("SAGNAC_SEED").map_or(1, |text| text.parse().unwrap());
    let mut random = rand::rngs::SmallRng::seed_from_u64(seed);
    let started = Instant::now();
    for (study, text) in studies() {
        let desk = Desk::with("");
        desk.write(&format!("{study}.toml"), &text);
        assert!(start(&desk, study, "whole").wait().unwrap().success());
        let (whole, tables) = (rows(&desk.path("whole")), desk.read("whole/points.csv"));
        let mut count = Count::default();
        while count.kills < wanted / 2 {
            let folder = format!("killed-{}", count.resumed);
            let (path, mut held) = (desk.path(&folder), 0);
            loop {
                let mut child = start(&desk, study, &folder);
                if !killed(&mut child, &path, &mut random) {
                    count.idle += 1;
                    break;
                }
                let torn = is_torn(&path);
                // In a copy: looking takes the journal over, which is for the next run to do.
                let found = rows_of_copy(&path);
                assert!(found >= held, "rows were lost");
                if found > held && found < whole.len() {
                    count.kills += 1;
                    count.torn += usize::from(torn);
                } else {
                    count.idle += 1;
                }
                held = found;
                if count.kills >= wanted / 2 {
                    break;
                }
            }
            assert!(start(&desk, study, &folder).wait().unwrap().success());
            assert!(rows(&path) == whole, "{study}: other rows after {} kills", count.kills);
            assert!(desk.read(&format!("{folder}/points.csv")) == tables, "{study}: another table");
            count.resumed += 1;
            std::fs::remove_dir_all(path).unwrap();
        }
        let Count { kills, torn, idle, resumed } = count;
        println!(
            "{study}: {kills} kills of runs that had progressed, {torn} of them within a transaction, {idle} that came too \
             early or late do not count; {resumed} runs resumed to the same {} rows and table",
            whole.len()
        );
    }
    println!("seed {seed}, {:.1} s", started.elapsed().as_secs_f64());
}
