//! Every example of every help text works.

use std::path::Path;
use std::process::Command;

use crate::desk::{Desk, PROGRAM};

/// The study `my.toml` of the examples.
const MY: &str = r#"title = "My study"
kind = "gap-fill"
trials = 64
[gyro]
tick = "5 ms"
tick_noise = { std = "1 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[switching]
gap_ticks = 3
fillers = ["const", { kind = "minimum-variance", name = "mv8+2", fit_ticks = ["-7..0", "n+1", "n+2"] }]
[[sweep]]
key = "switching.gap_ticks"
list = [2, 3]
"#;

/// A folder with what the examples name: studies, logs, and a share of results.
fn prepared() -> Desk {
    let desk = Desk::with("");
    desk.write("my.toml", MY);
    let studies = Path::new(crate::ROOT).join("studies");
    std::fs::create_dir_all(desk.path("studies/data/gyros")).unwrap();
    for name in [
        "error_vs_dtnu.toml",
        "smoke.toml",
        "design_point.toml",
        "what_decides.toml",
        "record_length.toml",
        "data/gyros/LGV-1.toml",
    ] {
        std::fs::copy(studies.join(name), desk.path(&format!("studies/{name}"))).unwrap();
    }
    // White noise by a small generator, in three columns with time stamps of 10 ms, and a temperature that rises.
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
    };
    for name in ["log.csv", "gyro.csv", "gyro1.csv", "gyro2.csv", "gyro3.csv", "bench.csv"] {
        let mut log =
            if name == "bench.csv" { "g01,g02,g03,g04,temp\n" } else { "stamp,gx,gy,gz,temp\n" }.to_owned();
        for at in 0..4000_u64 {
            let [x, y, z] = [noise(), noise(), noise()].map(|x| 1e-5 * x);
            let (stamp, temp) = (at * 10_000_000, 20.0 + 0.001 * at as f64);
            log += &format!("{stamp},{x:.6},{y:.6},{z:.6},{temp}\n");
        }
        desk.write(name, &log);
    }
    let single: String = (0..4000).map(|_| format!("{:.6}\n", 0.01 * noise())).collect();
    for name in ["before.csv", "after.csv", "PHASE.DAT"] {
        desk.write(name, &single);
    }
    std::fs::write(
        desk.path("pulses.npy"),
        npy(&(0..1_000_000_u32).map(|at| (at % 7) as i32).collect::<Vec<_>>()),
    )
    .unwrap();
    desk.write("curve.csv", "tau,adev\n1,0.3\n4,0.15\n16,0.075\n64,0.04\n256,0.02\n");
    desk.write(
        "noise.toml",
        "angle_random_walk = \"0.003 deg/sqrt(h)\"\nbias_instability = \"0.002 deg/h\"\n",
    );
    let recorded = Path::new(crate::ROOT).join("tests/data/formats/imu.mcap");
    std::fs::copy(recorded, desk.path("imu.mcap")).unwrap();
    std::fs::copy(Path::new(crate::ROOT).join("tests/data/imu/log.csv"), desk.path("imu.csv")).unwrap();
    desk.done("run my.toml --device cpu --shard 1/2");
    desk.done("run my.toml --device cpu --shard 2/2");
    desk
}

/// Whole numbers as NumPy keeps them.
fn npy(values: &[i32]) -> Vec<u8> {
    let header = format!("{{'descr': '<i4', 'fortran_order': False, 'shape': ({},), }}", values.len());
    let length = (header.len() + 1 + 10).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{header:width$}\n", width = length - 1).bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

fn help_of(command: Option<&str>) -> String {
    let output = Command::new(PROGRAM).args(command).arg("--help").output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

/// The names of all commands.
fn commands() -> Vec<String> {
    let help = help_of(None);
    let lines =
        help.lines().skip_while(|line| !line.starts_with("Usage:")).take_while(|line| *line != "Options:");
    let names = lines.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

fn examples(help: &str) -> Vec<String> {
    let lines =
        help.lines().skip_while(|line| *line != "Examples:").skip(1).take_while(|line| !line.is_empty());
    let lines: Vec<&str> = lines.map(str::trim).collect();
    // A line that goes on below ends as shells have it.
    lines.join("\n").replace("\\\n", "").lines().map(str::to_owned).collect()
}

/// The example with few trials, on the processor.
fn small(example: &str) -> String {
    let words: Vec<&str> = example.split_whitespace().collect();
    let samples = ["run", "design", "sensitivity"].contains(&words[1]) || example.contains(" verify");
    let mut words: Vec<String> = words.into_iter().map(str::to_owned).collect();
    for at in 0..words.len() {
        match words[at].as_str() {
            "--trials" => words[at + 1] = "64".to_owned(),
            "--device" => words[at + 1] = "cpu".to_owned(),
            _ => {}
        }
    }
    for (option, value) in [("--trials", "64"), ("--device", "cpu")] {
        if samples && !words.iter().any(|word| word == option) {
            words.extend([option.to_owned(), value.to_owned()]);
        }
    }
    words.join(" ")
}

#[test]
fn every_help_ends_with_examples_and_every_one_of_them_works() {
    let mut helps = vec![help_of(None)];
    for command in commands() {
        let help = help_of(Some(&command));
        assert!(!examples(&help).is_empty(), "the help of {command} has no examples");
        helps.push(help);
    }
    let desk = prepared();
    let folder = Path::new(PROGRAM).parent().unwrap();
    let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap_or_default());
    for example in helps.iter().flat_map(|help| examples(help)) {
        assert!(example.starts_with("sagnac "), "no example: {example}");
        // It measures for a minute.
        if example.starts_with("sagnac device bench") {
            continue;
        }
        let _ = std::fs::remove_file(desk.path("first.toml"));
        for made in ["gap-fill.toml", "my_run.toml"] {
            let _ = std::fs::remove_file(desk.path(made));
        }
        for folder in [".local/share/bash-completion/completions", ".config/fish/completions"] {
            std::fs::create_dir_all(desk.path(folder)).unwrap();
        }
        let mut command = Command::new("sh");
        command
            .args(["-c", &small(&example)])
            .env("PATH", &path)
            .env("HOME", desk.path(""))
            .current_dir(desk.path(""));
        let output = command.output().unwrap();
        let code = output.status.code().unwrap_or(-1);
        assert!(
            code == 0,
            "`{}` ended with {code}:\n{}",
            small(&example),
            String::from_utf8_lossy(&output.stderr)
        );
    }
}

#[test]
fn the_short_help_has_no_examples_and_options_are_grouped() {
    let short = Command::new(PROGRAM).args(["run", "-h"]).output().unwrap();
    let short = String::from_utf8(short.stdout).unwrap();
    assert!(!short.contains("Examples:"), "{short}");
    for heading in ["Sampling:", "Device:", "Output:"] {
        assert!(short.contains(&format!("\n{heading}\n")), "{heading} is missing in\n{short}");
    }
    assert!(short.lines().count() < help_of(Some("run")).lines().count());
}
