//! Results folders as the tests about their safety look at them.
#![allow(dead_code, reason = "each test binary uses a part")]

use std::path::Path;

use sagnac::device::{Cpu, Device};
use sagnac::run::{Plan, RunError, Tables};
use sagnac::store::{FILE, Store};
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac_kernel::width::Width;
use tempfile::TempDir;

use crate::studies::{Silent, parsed};

/// Tallies of moments: points and fillers, blocks of several sizes.
pub const MOMENTS: &str = r#"title = "Tallies of moments"
kind = "gap-fill"
trials = 1000
[gyro]
tick = "5 ms"
tick_noise = { std = "1 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[switching]
gap_ticks = 3
fillers = ["const", "quadratic"]
[[sweep]]
key = "motion.frequency"
list = ["5 Hz", "10 Hz", "20 Hz"]
"#;

/// Tallies of rows: records with their curves and coefficients.
pub const ROWS: &str = r#"title = "Tallies of rows"
kind = "allan"
trials = 150
[record]
sample = "1 s"
length = "600 s"
[noise]
quantization = "0.11 arcsec"
angle_random_walk = "0.00048 deg/sqrt(h)"
bias_instability = "0.00164 deg/h"
[[sweep]]
key = "noise.angle_random_walk"
list = ["0.0005 deg/sqrt(h)", "0.001 deg/sqrt(h)"]
"#;

/// Both in one: runs and their trajectories.
pub const RUNS: &str = r#"title = "Runs"
kind = "switched-run"
trials = 500
[drift]
magnetic = "14 arcsec/s"
magnetic_spread = "1 arcsec/s"
residual_max = "10 arcsec"
[switching]
interval = "40 s"
[run]
duration = "10 min"
trajectories = 3
"#;

/// A folder of its own; in memory where that can be had, as a disk that is waited for takes most of the time.
pub fn folder() -> TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap()
}

pub fn study(text: &str, trials: u64, seed: u64) -> Study {
    let mut study = parsed("study.toml", text);
    (study.trials, study.seed) = (trials, seed);
    study
}

pub fn cpu(threads: usize) -> Device {
    Device::Cpu(Cpu::new(Width::widest(), threads).unwrap())
}

/// Samples what a folder lacks of a share.
pub fn sample(plan: &Plan, folder: &Path, device: &mut Device, share: Share) -> Result<(), RunError> {
    let mut store = Store::open(folder, &plan.identity())?;
    plan.run(&mut store, device, share, &Silent).map(drop)
}

/// The tables of a study as the bytes of their files.
pub fn csv(tables: &Tables) -> Vec<u8> {
    let mut bytes = Vec::new();
    let Tables { points, coefficients, trajectories } = tables;
    for table in std::iter::once(points).chain(coefficients).chain(trajectories) {
        table.write_csv(&mut bytes).unwrap();
    }
    bytes
}

/// Runs what is left of a study in a folder, and returns its tables.
pub fn finished(plan: &Plan, folder: &Path, device: &mut Device) -> Result<Vec<u8>, RunError> {
    let mut store = Store::open(folder, &plan.identity())?;
    plan.run(&mut store, device, Share::WHOLE, &Silent)?;
    Ok(csv(&plan.tables(&store, &Silent)?))
}

/// All rows of tallies of a folder, as text, in their order.
pub fn rows(folder: &Path) -> Vec<String> {
    let connection = rusqlite::Connection::open(folder.join(FILE)).unwrap();
    let sql = "SELECT hex(point), hex(estimate), first, log2, hex(digest), hex(sums), checksum FROM tally";
    let has_tables = connection.prepare("SELECT 1 FROM sqlite_schema").unwrap().exists([]).unwrap();
    if !has_tables {
        return vec![];
    }
    let mut statement = connection.prepare(sql).unwrap();
    let text = |row: &rusqlite::Row| -> rusqlite::Result<String> {
        let [point, estimate, digest, sums] = [0, 1, 4, 5].map(|column| row.get::<_, String>(column));
        let [first, log2, checksum] = [2, 3, 6].map(|column| row.get::<_, i64>(column));
        Ok(format!("{} {} {} {} {} {} {}", point?, estimate?, first?, log2?, digest?, sums?, checksum?))
    };
    let rows = statement.query_map([], text).unwrap();
    rows.map(Result::unwrap).collect()
}
