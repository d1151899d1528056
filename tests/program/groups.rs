//! Runs on several devices, which give the rows of one.

use crate::desk::{Desk, STUDY};
use crate::stores::{MOMENTS, ROWS, RUNS, rows};

fn sorted_rows(desk: &Desk, folder: &str) -> Vec<String> {
    let mut rows = rows(&desk.path(folder));
    rows.sort();
    rows
}

#[test]
fn several_devices_give_the_files_and_rows_of_one() {
    for (text, trials) in [(MOMENTS, 60_000), (RUNS, 3000), (ROWS, 150)] {
        let desk = Desk::with(text);
        let run = |device: &str, out: &str| {
            desk.done(&format!("run study.toml --trials {trials} --device {device} --out {out}")).stderr
        };
        run("cpu", "cpu");
        for (devices, group) in [("cpu,gpu:0", "cpu-first"), ("gpu:0,cpu", "gpu-first")] {
            let said = run(devices, group);
            assert!(
                said.contains(" and ") && said.contains("CPU (") && said.contains(", as asked"),
                "{said}"
            );
            for file in ["points.csv", "resolved_study.toml"] {
                assert_eq!(desk.read(&format!("{group}/{file}")), desk.read(&format!("cpu/{file}")));
            }
            assert_eq!(sorted_rows(&desk, group), sorted_rows(&desk, "cpu"));
        }
    }
}

#[test]
fn a_run_on_several_devices_continues_on_one_and_the_reverse() {
    for (text, few, many) in [(MOMENTS, 5000, 60_000), (RUNS, 500, 3000), (ROWS, 40, 150)] {
        let desk = Desk::with(text);
        for (out, first, then) in [("a", "cpu", "cpu"), ("b", "cpu", "cpu,gpu:0"), ("c", "cpu,gpu:0", "cpu")]
        {
            desk.done(&format!("run study.toml --trials {few} --device {first} --out {out} --quiet"));
            desk.done(&format!("run study.toml --trials {many} --device {then} --out {out} --quiet"));
            assert_eq!(desk.read(&format!("{out}/points.csv")), desk.read("a/points.csv"), "{first}, {then}");
            assert_eq!(sorted_rows(&desk, out), sorted_rows(&desk, "a"), "{first}, then {then}");
        }
    }
}

#[test]
fn all_takes_the_cpu_and_leaves_out_a_software_rasterizer() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --trials 20000 --device cpu --out cpu");
    let said = desk.done("run study.toml --trials 20000 --device all --out all").stderr;
    assert!(said.starts_with("device: CPU ("), "{said}");
    for line in desk.done("devices").stdout.lines().filter(|line| line.contains("llvmpipe (")) {
        let (_, name) = line.split_once(": ").unwrap();
        assert!(said.contains(&format!("note: {name} is left out: it is a software rasterizer")), "{said}");
    }
    assert_eq!(desk.read("all/points.csv"), desk.read("cpu/points.csv"));
}

#[test]
fn a_list_with_an_unknown_device_or_one_named_twice_is_refused() {
    let desk = Desk::with(STUDY);
    let refused = |device: &str, pieces: &[&str]| {
        desk.fails(&format!("run study.toml --device {device}"), 2, pieces);
        assert_eq!(desk.names("."), ["study.toml"]);
    };
    refused("cpu,abacus", &["no device is called `abacus`", "auto, cpu, gpu, all", "gpu:0 = "]);
    refused("gpu:9", &["no device is called `gpu:9`", "gpu:0 = "]);
    refused("cpu,", &["no device is called ``"]);
    refused("cpu,portable", &["`portable` is the same device as `cpu`", "name each device once"]);
    refused("gpu:0,cpu,gpu:0", &["`gpu:0` is the same device as `gpu:0`"]);
    refused("cpu,all", &["`all` cannot stand in a list", "--device cpu,gpu:0"]);
}
