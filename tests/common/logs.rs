//! Small logs for black-box tests.
#![allow(dead_code, reason = "each test binary uses a part")]

use tempfile::TempDir;

use crate::desk::Desk;

/// A folder with one file.
pub fn desk_with(name: &str, bytes: impl AsRef<[u8]>) -> Desk {
    let desk = Desk(TempDir::new().unwrap());
    std::fs::write(desk.path(name), bytes).unwrap();
    desk
}

/// Deterministic numbers between −1 and 1.
pub fn noise(count: usize) -> impl Iterator<Item = f64> {
    let mut n: u64 = 1_234_567_890;
    (0..count).map(move |_| {
        n = 16807 * n % 2_147_483_647;
        2.0 * n as f64 / 2_147_483_647.0 - 1.0
    })
}

pub fn rows(row: impl Fn(usize, f64) -> String) -> String {
    noise(200).enumerate().map(|(i, y)| row(i, y) + "\n").collect()
}

/// `time [ms],gx [deg/s],gz [deg/s]`, 100 Hz.
pub fn log() -> String {
    format!(
        "time [ms],gx [deg/s],gz [deg/s]\n{}",
        rows(|i, y| format!("{},{},{}", 10 * i, y, 2.0 * y + 0.004))
    )
}
