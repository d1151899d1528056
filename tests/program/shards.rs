//! Shares of a study: however it is split and wherever its shares are sampled, the whole is the same to the last bit.

use crate::desk::{Desk, STUDY, replaced, with};
use crate::devices::{Coverage, adapters, open};
use crate::stores::{MOMENTS, ROWS, RUNS, cpu, csv, finished, folder, rows, sample, study};
use crate::studies::Silent;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use sagnac::device::Device;
use sagnac::run::Plan;
use sagnac::store::source::Source;
use sagnac::store::{FILE, Store};
use sagnac::tally::Share;

/// One, two and three threads of the CPU, and an adapter.
fn devices() -> Vec<Device> {
    let adapter = &adapters()[0];
    let gpu = open(adapter, adapter.variant());
    vec![cpu(1), cpu(2), cpu(3), Device::Gpu(Box::new(gpu))]
}

/// Samples a study in so many shares, share i on the device that `device` says, merges them in an order of `seed`, and returns the tables.
fn sharded(
    plan: &Plan,
    of: u64,
    devices: &mut [Device],
    device: impl Fn(u64) -> usize,
    seed: u64,
) -> Vec<u8> {
    let folders: Vec<_> = (0..of).map(|_| folder()).collect();
    let mut order: Vec<u64> = (0..of).collect();
    let mut random = rand::rngs::SmallRng::seed_from_u64(seed);
    order.shuffle(&mut random);
    for &index in &order {
        let share = Share::new(index + 1, of).unwrap();
        sample(plan, folders[index as usize].path(), &mut devices[device(index)], share).unwrap();
    }
    order.shuffle(&mut random);
    let out = folder();
    let mut store = Store::open(out.path(), &plan.identity()).unwrap();
    for (at, &index) in order.iter().enumerate() {
        assert!(
            at == 0 || plan.lacks(&store, Share::WHOLE).unwrap() > 0 || of > 32,
            "share {at} of {of} has nothing to add"
        );
        store.merge(&Source::open(folders[index as usize].path()).unwrap(), false).unwrap();
    }
    assert_eq!(plan.lacks(&store, Share::WHOLE).unwrap(), 0, "{of} shares are not the whole");
    drop(store);
    // With itself: a copy of all of it changes nothing.
    let (once, copy) = (rows(out.path()), folder());
    std::fs::copy(out.path().join(FILE), copy.path().join(FILE)).unwrap();
    let mut store = Store::open(out.path(), &plan.identity()).unwrap();
    let merged = store.merge(&Source::open(copy.path()).unwrap(), false).unwrap();
    assert_eq!((merged.added, merged.held), (0, once.len() as u64));
    drop(store);
    assert!(rows(out.path()) == once, "merging {of} shares with themselves changed rows");
    let store = Store::open(out.path(), &plan.identity()).unwrap();
    csv(&plan.tables(&store, &Silent).unwrap())
}

#[test]
fn any_split_on_any_devices_merges_to_the_same_tables() {
    let mut devices = devices();
    let mut coverage = Coverage::start();
    for (text, trials) in [(MOMENTS, 5000), (ROWS, 150), (RUNS, 500)] {
        let study = study(text, trials, 1);
        let plan = Plan::new(&study).unwrap();
        let whole = finished(&plan, folder().path(), &mut devices[0]).unwrap();
        let all = devices.len() as u64;
        for of in [1, 2, 7, 64] {
            // Each device alone, then all of them mixed.
            for alone in 0..all {
                let found = sharded(&plan, of, &mut devices, |_| alone as usize, of + alone);
                assert!(found == whole, "{}: {of} shares on device {alone}", study.title);
            }
            let found = sharded(&plan, of, &mut devices, |index| ((index + of) % all) as usize, of);
            assert!(found == whole, "{}: {of} shares mixed", study.title);
            coverage.comparisons += devices.len() + 1;
        }
    }
    coverage.end("splits");
}

#[test]
fn shares_of_several_splits_merge_too() {
    let study = study(MOMENTS, 1000, 1);
    let plan = Plan::new(&study).unwrap();
    let whole = finished(&plan, folder().path(), &mut cpu(1)).unwrap();
    let out = folder();
    // Overlapping, and more than is needed.
    for (number, of) in [(2, 3), (1, 2), (2, 2), (5, 7)] {
        sample(&plan, out.path(), &mut cpu(1), Share::new(number, of).unwrap()).unwrap();
    }
    assert!(finished(&plan, out.path(), &mut cpu(1)).unwrap() == whole);
    assert_eq!(Source::open(out.path()).unwrap().check().unwrap().faults.len(), 0);
}

#[test]
fn shards_are_run_merged_and_checked_as_a_user_would() {
    let desk = Desk::with(&with("[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]"));
    let run = "run study.toml --device cpu --trials 20000";
    desk.done(&format!("{run} --out whole"));
    for shard in 1..=3 {
        let ended = desk.done(&format!("{run} --shard {shard}/3 --threads 1"));
        assert!(ended.stderr.contains("1 thread"), "{}", ended.stderr);
        assert!(ended.stderr.contains(&format!("share {shard} of 3 is done")), "{}", ended.stderr);
        assert_eq!(ended.stdout, "");
    }
    let again = desk.done(&format!("{run} --shard 2/3"));
    assert!(!again.stderr.contains("trials done"), "nothing is left of a share: {}", again.stderr);
    let folders = "results/study/shard-1-of-3 results/study/shard-2-of-3 results/study/shard-3-of-3";
    let names = ["resolved_study.toml", "tallies.lock", "tallies.sqlite", "written_by_sagnac.jsonl"];
    assert_eq!(desk.names("results/study/shard-1-of-3"), names);
    let parts: Vec<&str> = folders.split(' ').collect();

    let ended = desk.sagnac(&format!("merge {} {} --out part", parts[2], parts[0]));
    assert_eq!(ended.code, 4, "{}", ended.stderr);
    assert!(ended.stderr.contains("part is incomplete: 1"), "{}", ended.stderr);
    assert!(ended.stderr.contains("share 2 of 3 is missing"), "{}", ended.stderr);
    assert_eq!(desk.sagnac("check part").code, 4);
    // Every point has a half of them; a study that goes on from there still asks for all.
    desk.done("run study.toml --device cpu --trials 2000 --shard 1/2 --out half");
    assert_eq!(desk.sagnac("merge half --out halves").code, 4);
    assert!(desk.read("halves/resolved_study.toml").contains("trials = 2000"));

    let ended = desk.done(&format!("merge {folders} {folders} --out results/study"));
    assert!(ended.stderr.contains("complete; results are in results/study"), "{}", ended.stderr);
    assert_eq!(desk.read("results/study/points.csv"), desk.read("whole/points.csv"));
    assert_eq!(desk.read("results/study/chart.svg"), desk.read("whole/chart.svg"));
    let once = rows(&desk.path("results/study"));
    // Again, and into itself.
    desk.done(&format!("merge results/study {} --out results/study", parts[1]));
    desk.done("merge results/study results/study --out twice");
    assert!(rows(&desk.path("results/study")) == once && rows(&desk.path("twice")) == once);
    assert_eq!(desk.read("twice/points.csv"), desk.read("whole/points.csv"));
    // What is missing can be sampled instead.
    desk.done("run part/resolved_study.toml --device cpu");
    assert_eq!(desk.read("part/points.csv"), desk.read("whole/points.csv"));

    let ended = desk.done("check whole results/study twice part");
    assert_eq!(ended.stdout.matches("complete, points.csv matches them").count(), 4, "{}", ended.stdout);
    let table = desk.read("whole/points.csv").replace("const", "cost");
    desk.write("whole/points.csv", &table);
    let ended = desk.sagnac("check whole");
    assert_eq!(ended.code, 5);
    assert!(ended.stderr.contains("whole/points.csv does not match the tallies"), "{}", ended.stderr);
}

#[test]
fn progress_counts_what_earlier_runs_did() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 10000 --shard 1/4 --out out");
    let ended = desk.done("run study.toml --device cpu --trials 10000 --out out");
    // A quarter, in whole 128ths.
    assert!(ended.stderr.contains("2432 of 10 thousand trials done"), "{}", ended.stderr);
}

#[test]
fn a_task_of_a_job_array_runs_its_share() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000 --shard slurm";
    let array = [
        ("SLURM_ARRAY_TASK_ID", "3"),
        ("SLURM_ARRAY_TASK_MIN", "1"),
        ("SLURM_ARRAY_TASK_MAX", "4"),
        ("SLURM_ARRAY_TASK_COUNT", "4"),
        ("SLURM_ARRAY_TASK_STEP", "1"),
    ];
    let ended = desk.sagnac_with(run, &array);
    assert!(
        ended.stderr.contains("share 3 of 4 is done and in results/study/shard-3-of-4"),
        "{}",
        ended.stderr
    );
    desk.fails(run, 2, &["SLURM_ARRAY_TASK_ID is not set", "--array=1-N"]);
    let ended = desk.done("check results/study/shard-3-of-4");
    assert!(ended.stdout.contains("share 3 of 4 complete"), "{}", ended.stdout);
}

#[test]
fn shares_that_make_no_sense_are_refused() {
    let desk = Desk::with(STUDY);
    for shard in ["0/4", "5/4", "4", "x", "1/0"] {
        desk.fails(&format!("run study.toml --shard {shard}"), 2, &["--shard", "share I of N", "slurm"]);
    }
    desk.write("precise.toml", &replaced("kind =", "precision = \"1 %\"\nkind ="));
    desk.fails(
        "run precise.toml --device cpu --shard 1/2",
        3,
        &["precise.toml:2", "does not know the trials of the others", "--trials N"],
    );
    // All are sampled then, in any split, though a run as a whole stops earlier.
    let shard = |shard: &str, out: &str| {
        desk.done(&format!("run precise.toml --device cpu --shard {shard} --trials 300000 --out {out}"));
    };
    shard("1/2", "a");
    shard("2/2", "b");
    shard("1/1", "whole");
    desk.fails(
        "merge b --out part --quiet",
        4,
        &["part is incomplete: 147 thousand", "share 1 of 2 is missing"],
    );
    desk.done("merge a b --out c");
    assert_eq!(desk.read("c/points.csv"), desk.read("whole/points.csv"));
    assert_eq!(desk.points("c").iter().map(|row| row["trials"].as_str()).collect::<Vec<_>>(), ["300000"; 4]);
    desk.done("run precise.toml --device cpu --trials 300000 --out stopped");
    assert_ne!(desk.points("stopped")[0]["trials"], "300000");
    assert!(desk.read("c/resolved_study.toml").contains("precision = \"none\""));
    desk.done("check a b c whole stopped");
    desk.write("table.toml", &format!("{STUDY}[precision]\nrms = \"1 %\"\n"));
    desk.fails("run table.toml --shard 1/2 --trials 1000", 3, &["table.toml:12", "write it as a value"]);
    for limit in ["soon", "5", "-1 s", "3 Hz"] {
        let output = std::process::Command::new(crate::desk::PROGRAM)
            .current_dir(desk.0.path())
            .args(["run", "study.toml", "--time-limit", limit])
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{limit}");
    }
}

#[test]
fn what_does_not_belong_together_is_not_merged() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 1000 --out a");
    desk.done("run study.toml --device cpu --trials 1000 --seed 2 --out b");
    desk.fails(
        "merge a b --out c",
        2,
        &["a/resolved_study.toml and b/resolved_study.toml are not the same: line 3", "--study FILE"],
    );
    desk.fails("merge a nowhere --out c", 2, &["nowhere/resolved_study.toml", "no such folder"]);
    std::fs::create_dir(desk.path("empty")).unwrap();
    desk.fails("merge a empty --out c --study study.toml", 2, &["empty has no results", "tallies.sqlite"]);
    desk.fails("check empty", 2, &["empty has no results"]);
    assert_eq!(desk.names("."), ["a", "b", "empty", "study.toml"], "something was left behind");
    desk.fails(
        "merge a b --out c --study study.toml --seed 1",
        3,
        &["b/tallies.sqlite holds", "another study (seed 2"],
    );
    assert_eq!(desk.names("."), ["a", "b", "empty", "study.toml"], "a refused merge left something behind");
    // Studies that differ in what they show alone can be merged under one of them.
    desk.write("more.toml", &with("[chart]\nx = \"dt_nu\"\ny = \"p99_73\""));
    desk.done("run more.toml --device cpu --trials 1000 --out d");
    desk.done("merge a d --out e --study more.toml --trials 1000");
    assert_eq!(desk.read("e/points.csv"), desk.read("d/points.csv"));
}
