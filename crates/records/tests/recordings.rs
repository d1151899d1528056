//! Recordings of other programs: their numbers are those that other readers give, and damaged ones are refused or give a log, within a
//! part of the memory and the time that a sound recording may take.
//!
//! The files are written by `tests/data/formats/make.py`; the expected numbers are those of pyulog, pymavlink, rosbags and pandas.

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac_records::allan::Trend;
use sagnac_records::allan::deviation::Deviation;
use sagnac_records::allan::sums::sums;
use sagnac_records::record::log::Log;
use sagnac_records::record::log::read::{Request, Timing};

/// What another reader gives for a column of a file: the number of samples, the times of the first and the last in the file, s, mean and
/// overlapping Allan deviation over 3 samples, all rows being one series, in rad/s.
struct Recording {
    file: &'static str,
    column: &'static str,
    samples: usize,
    length_s: f64,
    mean: f64,
    deviation: f64,
    /// Whether checksums cover all of its samples.
    is_checked: bool,
}

/// The first gyro in the files whose samples checksums cover.
const CHECKED: Recording = Recording {
    file: "",
    column: "gx",
    samples: 36,
    length_s: 0.21,
    mean: 0.010_036_812_517_734_186,
    deviation: 0.001_740_419_427_438_702_7,
    is_checked: true,
};

/// The topics of PX4 as ROS 2 records them, by their number; sensor_gyro has twice the rates.
const PX4: [Recording; 4] = [
    Recording {
        column: "/fmu/out/sensor_gyro.gx",
        mean: 0.020_073_625_084_478_408,
        deviation: 0.003_480_838_801_408_158,
        is_checked: false,
        ..CHECKED
    },
    Recording {
        column: "/fmu/out/sensor_combined.gx",
        mean: 0.010_036_812_542_239_204,
        deviation: 0.001_740_419_400_704_079,
        is_checked: false,
        ..CHECKED
    },
    Recording {
        column: "/fmu/out/vehicle_imu.gx",
        mean: 0.010_036_812_490_296_951,
        deviation: 0.001_740_419_462_831_476_3,
        is_checked: false,
        ..CHECKED
    },
    Recording {
        column: "/fmu/out/sensor_gyro_fifo.gx",
        length_s: 0.2099,
        mean: 0.010_036_805_530_215_057,
        deviation: 0.001_740_413_878_013_982_2,
        is_checked: false,
        ..CHECKED
    },
];

const RECORDINGS: &[Recording] = &[
    Recording {
        file: "imu.ulg",
        column: "sensor_gyro_1.gx",
        samples: 36,
        length_s: 0.21,
        mean: 0.020_073_625_084_478_408,
        deviation: 0.003_480_838_801_408_158_6,
        is_checked: false,
    },
    Recording {
        file: "imu_log.bin",
        column: "GYR_1.gx",
        samples: 36,
        length_s: 0.21,
        mean: 0.020_073_625_084_478_408,
        deviation: 0.003_480_838_801_408_158_6,
        is_checked: false,
    },
    Recording {
        file: "imu_fifo.ulg",
        column: "gx",
        samples: 36,
        // Before the first batch there is none that gives the spacing of its samples, which is the nominal one.
        length_s: 0.2099,
        mean: 0.010_036_805_530_215_057,
        deviation: 0.001_740_413_878_013_982_6,
        is_checked: false,
    },
    Recording {
        file: "imu_batches.bin",
        column: "gx",
        samples: 128,
        length_s: 0.635,
        mean: 0.010_060_416_666_666_665,
        deviation: 0.001_697_302_704_274_861_9,
        is_checked: false,
    },
    Recording {
        file: "imu.db3",
        column: "/twist.gx",
        samples: 36,
        length_s: 0.21,
        mean: 0.020_073_625_035_468_372,
        deviation: 0.003_480_838_854_877_405_4,
        is_checked: false,
    },
    Recording { file: "px4.db3", ..PX4[0] },
    Recording { file: "px4.db3", ..PX4[1] },
    Recording { file: "px4.db3", ..PX4[2] },
    Recording { file: "px4.db3", ..PX4[3] },
    Recording { file: "imu.csv.gz", ..CHECKED },
    #[cfg(feature = "parquet")]
    Recording { file: "imu.parquet", is_checked: false, ..CHECKED },
    #[cfg(feature = "parquet")]
    Recording { file: "imu_packed.parquet", is_checked: false, ..CHECKED },
    #[cfg(feature = "parquet")]
    Recording { file: "imu_lz4.parquet", is_checked: false, ..CHECKED },
    #[cfg(feature = "ros")]
    Recording { file: "imu_bz2.bag", ..CHECKED },
    #[cfg(feature = "ros")]
    Recording { file: "imu.mcap", ..CHECKED },
    #[cfg(feature = "ros")]
    Recording { file: "px4.mcap", is_checked: true, ..PX4[2] },
    #[cfg(feature = "ros")]
    Recording { file: "px4.mcap", is_checked: true, ..PX4[3] },
];

/// Damages of each file, the most bytes that are held while one is read, and the longest time.
const DAMAGES: usize = 500;
const MAX_BYTES: usize = 32 << 20;
const MAX_TIME: Duration = Duration::from_secs(5);

/// The tests take turns, because memory is counted for the whole program.
static TURN: Mutex<()> = Mutex::new(());

fn bytes_of(file: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/formats").join(file)).unwrap()
}

fn read(bytes: &[u8], columns: &[&str], timing: Timing) -> Result<Log, String> {
    let columns = columns.iter().map(|&column| column.to_owned()).collect();
    let request = Request { columns, timing, ..Request::default() };
    Log::read_bytes("log", bytes, &request).map_err(|error| error.render(false, 100))
}

#[test]
fn samples_are_those_of_other_readers() {
    let _turn = TURN.lock();
    for Recording { file, column, samples, length_s, mean, deviation, .. } in RECORDINGS {
        let bytes = bytes_of(file);
        let series = read(&bytes, &[column], Timing::Step(0.005)).unwrap();
        let channel = &series.channels[0];
        let found = channel.samples.iter().sum::<f64>() / channel.samples.len() as f64;
        assert_eq!(channel.samples.len(), *samples, "{file}");
        assert!((found - mean).abs() < 1e-12 * mean.abs(), "{file}: a mean of {found}");
        let angles = channel.view(series.data, series.step_s).angles(Trend::None);
        let sum = sums(&angles, Deviation::Oadev, &[3])[0];
        let unit = 3.0 * series.step_s * channel.unit.factor;
        let found = (sum.squares / (2 * sum.terms) as f64).sqrt() / unit;
        assert!((found - deviation).abs() < 1e-9 * deviation, "{file}: a deviation of {found}");
        let log = read(&bytes, &[column], Timing::default()).unwrap();
        let found = log.length_s() - log.step_s;
        assert!((found - length_s).abs() < 1e-6, "{file}: {found} s from the first sample to the last");
    }
}

#[cfg(feature = "parquet")]
#[test]
fn nulls_of_a_table_are_missing_samples_and_integers_are_read() {
    let _turn = TURN.lock();
    for file in ["imu.parquet", "imu_packed.parquet", "imu_lz4.parquet"] {
        let bytes = bytes_of(file);
        let log = read(&bytes, &["a"], Timing::Step(0.005)).unwrap();
        let known: Vec<f64> = log.channels[0].samples.iter().copied().filter(|x| x.is_finite()).collect();
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        assert!(known.len() == 28 && (mean + 0.051_592_404_730_447_246).abs() < 1e-15, "{file}: {mean}");
        let counts = read(&bytes, &["count"], Timing::default()).unwrap_err();
        assert!(counts.contains("the unit of `count` is missing"), "{counts}");
    }
    let packed = read(&bytes_of("brotli.parquet"), &["gx"], Timing::Step(0.005)).unwrap_err();
    assert!(packed.contains("packed by Brotli") && packed.contains("to_parquet"), "{packed}");
}

/// The samples of all channels as bits.
fn bits(log: &Log) -> Vec<u64> {
    log.channels.iter().flat_map(|channel| &channel.samples).map(|sample| sample.to_bits()).collect()
}

/// Alters bits, sets a range to one byte, cuts the file off, or repeats or removes a range.
fn damaged(sound: &[u8], case: usize, draws: &mut StdRng) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    // Half of them where headers are.
    let start =
        draws.random_range(0..if case.is_multiple_of(2) { 1024.min(sound.len()) } else { sound.len() });
    let end = sound.len().min(start + 1 + draws.random_range(0..64));
    match case % 5 {
        0 => (0..1 + draws.random_range(0..8))
            .for_each(|_| bytes[draws.random_range(0..sound.len())] ^= 1 << draws.random_range(0..8)),
        1 => bytes[start] ^= 1 << draws.random_range(0..8),
        2 => bytes[start..end].fill([0, 0xff][draws.random_range(0..2)]),
        3 => bytes.truncate(draws.random_range(0..sound.len())),
        _ if draws.random_range(0..2) == 0 => drop(bytes.drain(start..end)),
        _ => drop(bytes.splice(start..start, sound[start..end].to_vec())),
    }
    bytes
}

#[test]
fn damaged_recordings_are_refused_or_read_within_limits() {
    let _turn = TURN.lock();
    // A backtrace of what the reader of Parquet catches would take more memory than a recording.
    std::panic::set_hook(Box::new(|panic| eprintln!("{panic}")));
    for (seed, Recording { file, column, is_checked, .. }) in (1..).zip(RECORDINGS) {
        let sound = bytes_of(file);
        let expected = bits(&read(&sound, &[column], Timing::Step(0.005)).unwrap());
        let (mut draws, mut given) = (StdRng::seed_from_u64(seed), 0);
        for case in 0..DAMAGES {
            let bytes = damaged(&sound, case, &mut draws);
            let (started, before) = (Instant::now(), HELD.load(Relaxed));
            PEAK.store(before, Relaxed);
            for columns in [&[][..], &[*column]] {
                match read(&bytes, columns, Timing::Step(0.005)) {
                    Ok(log) => {
                        given += 1;
                        let is_same = columns.is_empty() || bits(&log) == expected;
                        assert!(!is_checked || is_same, "{file}, case {case}: other samples");
                        let samples = || log.channels.iter().flat_map(|channel| &channel.samples);
                        assert!(!samples().any(|sample| sample.is_infinite()), "{file}, case {case}");
                    }
                    Err(said) => assert!(said.contains("help"), "{file}, case {case}: {said}"),
                }
            }
            let (time, held) = (started.elapsed(), PEAK.load(Relaxed).saturating_sub(before));
            assert!(time < MAX_TIME && held < MAX_BYTES, "{file}, case {case}: {time:?}, {held} bytes");
        }
        println!("{file}: {given} of {} readings of damaged files gave a log", 2 * DAMAGES);
    }
}

/// Bytes held by the program, and at most since the last case began.
static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, which counts what is held.
struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// SAFETY: every call goes to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Relaxed) + layout.size();
        PEAK.fetch_max(held, Relaxed);
        // SAFETY: the caller keeps the same contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller keeps the same contract.
        unsafe { System.dealloc(old, layout) }
    }
}
