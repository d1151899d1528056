//! The files of `tests/data/formats`, which hold the same samples of an IMU.
#![allow(dead_code, reason = "each test binary uses a part")]

use std::path::{Path, PathBuf};

use sagnac::record::RecordError;
use sagnac::record::binary::Binary;
use sagnac::record::log::Log;
use sagnac::record::log::measure::{Data, Unit};
use sagnac::record::log::read::{Hints, Request, Timing};

/// A file of the same samples.
pub struct Sample {
    pub file: &'static str,
    /// Columns of the angular rates.
    pub columns: [&'static str; 3],
    /// Column of the times, and its unit, where they do not follow from the file.
    pub time: Option<(&'static str, &'static str)>,
    pub binary: Option<&'static str>,
    /// Whether checksums cover all of its numbers.
    pub is_checked: bool,
}

const fn sample(file: &'static str, columns: [&'static str; 3], is_checked: bool) -> Sample {
    Sample { file, columns, time: None, binary: None, is_checked }
}

const GYRO: [&str; 3] = ["gyro.1", "gyro.2", "gyro.3"];

pub const TEXT: Sample = sample("imu.csv", ["gx", "gy", "gz"], false);

pub const BINARIES: [Sample; 12] = [
    Sample { time: Some(("1", "s")), ..sample("imu.npy", ["2", "3", "4"], false) },
    sample("imu.npz", GYRO, true),
    sample("imu_packed.npz", GYRO, true),
    sample("imu.mat", ["imu.gyro.1", "imu.gyro.2", "imu.gyro.3"], false),
    sample("imu_packed.mat", GYRO, true),
    sample("imu.h5", ["imu/gyro.1", "imu/gyro.2", "imu/gyro.3"], false),
    sample("imu_packed.h5", GYRO, true),
    sample("imu_v73.mat", GYRO, false),
    sample("imu.mcap", ["gx", "gy", "gz"], true),
    sample("imu.bag", ["gx", "gy", "gz"], false),
    sample("imu_packed.bag", ["gx", "gy", "gz"], true),
    Sample {
        binary: Some("f64 x4, little, time_s 1, gx 2, gy 3, gz 4"),
        ..sample("imu.bin", ["gx", "gy", "gz"], false)
    },
];

impl Sample {
    pub fn path(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats").join(self.file)
    }

    /// Reads a file that is, or was, this one.
    pub fn read(&self, path: &Path) -> Result<Log, RecordError> {
        let timing = Timing::Stamps {
            step_s: None,
            column: self.time.map(|(column, _)| column.to_owned()),
            unit: self.time.map(|(_, unit)| unit.to_owned()),
        };
        let hints =
            Hints { binary: self.binary.map(|text| Binary::parse(text).unwrap()), ..Hints::default() };
        let columns = self.columns.map(str::to_owned).to_vec();
        let units = vec![Unit::parse("rad/s", Data::Rate).unwrap()];
        Log::read(path, &Request { columns, timing, data: Some(Data::Rate), units, temperature: None, hints })
    }
}

/// The samples of all channels as bits, in which missing ones are equal.
pub fn bits(log: &Log) -> Vec<Vec<u64>> {
    let bits = |sample: &f64| if sample.is_nan() { f64::NAN.to_bits() } else { sample.to_bits() };
    log.channels.iter().map(|channel| channel.samples.iter().map(bits).collect()).collect()
}
