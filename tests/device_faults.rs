//! Devices that fail in the middle of a run: out of memory, lost, gone, computing other bits. Whatever happens, all tables
//! and all rows of the store are, bit for bit, those of a run on the processor that nothing disturbed.

mod devices;
mod studies;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use devices::{Coverage, adapters, jobs, open, reference, total};
use rusqlite::types::Value;
use sagnac::backend::cpu::{Cpu, Width};
use sagnac::backend::gpu::{Adapter, Fault, Faults, Gpu, GpuError, Moment};
use sagnac::backend::{Device, SelectError, trusted};
use sagnac::block::cover;
use sagnac::kernel::KERNELS;
use sagnac::run::{Done, Plan, Progress, Tables};
use sagnac::store::Store;
use sagnac::study::Study;
use sagnac::verify::launches;
use studies::{ALL_FREQUENCIES, parsed, study};

/// What a device is about to do, and what it has met before.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    /// Of how much work; `None` where it is about to be opened again.
    tile: Option<u64>,
    /// Work of all tiles before.
    before: u64,
    /// How often it was opened again.
    opened: usize,
    /// Faults that have happened.
    taken: usize,
}

/// Whether a fault happens, and which.
type Script = Box<dyn FnMut(Seen) -> Option<Fault> + Send>;

fn scripted(script: Script) -> (Faults, Arc<Mutex<Seen>>) {
    let seen = Arc::new(Mutex::new(Seen::default()));
    let (kept, script) = (Arc::clone(&seen), Mutex::new(script));
    let faults = move |moment: Moment| {
        let (mut seen, mut script) = (kept.lock().unwrap(), script.lock().unwrap());
        seen.tile = match moment {
            Moment::Tile(work) => Some(work),
            Moment::Opening => None,
        };
        let fault = script(*seen);
        seen.taken += usize::from(fault.is_some());
        match seen.tile {
            Some(work) => seen.before += work,
            None => seen.opened += 1,
        }
        fault
    };
    (Arc::new(faults), seen)
}

/// A tile of a run.
#[derive(Debug, Clone, Copy)]
enum Place {
    First,
    Middle,
    Last,
}

const PLACES: [Place; 3] = [Place::First, Place::Middle, Place::Last];

impl Place {
    /// Whether it is the next tile of a run of so much work, before anything has failed.
    fn is_next(self, seen: Seen, work: u64) -> bool {
        let end = seen.before + seen.tile.unwrap_or(0);
        match self {
            Place::First => true,
            Place::Middle => end > work / 2,
            Place::Last => end >= work,
        }
    }
}

/// What a run tells as it goes on.
#[derive(Default)]
struct Heard {
    done: AtomicU64,
    total: AtomicU64,
    notes: Mutex<Vec<String>>,
}

impl Progress for Heard {
    fn start(&self, _: &'static str, done: u64, total: u64) {
        self.done.store(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }
    fn advance(&self, more: u64) {
        self.done.fetch_add(more, Ordering::Relaxed);
    }
    fn note(&self, sentence: &str) {
        self.notes.lock().unwrap().push(sentence.to_owned());
    }
    fn finish(&self) {}
}

/// All that a run leaves.
struct Left {
    tables: Tables,
    /// All tallies, by point, estimate and first trial.
    rows: Vec<Vec<Value>>,
    devices: Vec<String>,
    done: Done,
}

fn run(study: &Study, device: &mut Device) -> Left {
    let folder = tempfile::tempdir().unwrap();
    let plan = Plan::new(study).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
    let heard = Heard::default();
    let mut store = Store::open(folder.path(), &plan.identity()).unwrap();
    let done = plan.run(&mut store, device, &heard).unwrap();
    let tables = plan.tables(&store, &Heard::default()).unwrap();
    drop(store);
    let told = heard.done.load(Ordering::Relaxed);
    assert_eq!(told, heard.total.load(Ordering::Relaxed), "progress after {:?}", done.degraded);
    let mut notes = heard.notes.into_inner().unwrap();
    notes.sort();
    notes.dedup();
    let mut degraded = done.degraded.clone();
    degraded.sort();
    assert_eq!(notes, degraded, "what is said at once is said at the end, once");
    let rows = selected(folder.path(), "SELECT * FROM tally ORDER BY point, estimate, first, log2");
    let devices = selected(folder.path(), "SELECT device FROM provenance");
    let devices = devices.iter().map(|row| format!("{:?}", row[0])).collect();
    Left { tables, rows, devices, done }
}

fn selected(folder: &Path, sql: &str) -> Vec<Vec<Value>> {
    let database = rusqlite::Connection::open(folder.join(sagnac::store::FILE)).unwrap();
    let mut statement = database.prepare(sql).unwrap();
    let columns = statement.column_count();
    let rows = statement.query_map([], |row| (0..columns).map(|column| row.get(column)).collect()).unwrap();
    rows.map(Result::unwrap).collect()
}

/// What is done to a device, and what is said of it then.
struct Case {
    name: String,
    script: Script,
    /// How often it fails at least.
    faults: usize,
    said: Vec<&'static str>,
    /// Whether the processor ends the run.
    on_cpu: bool,
}

const SMALLER: &str = "is out of memory: it goes on with smaller tiles";
const AGAIN: &str = "was lost: Destroyed; it was opened again, passed its self-test and goes on";

/// A study with what an undisturbed run leaves.
struct Subject {
    study: Study,
    adapter: Adapter,
    /// On the processor.
    reference: Left,
    /// Of all tiles together.
    work: u64,
    first_tile: u64,
}

impl Subject {
    fn new(study: Study) -> Subject {
        let adapter = adapters().remove(0);
        let reference = run(&study, &mut Device::Cpu(Cpu::new(Width::widest(), 0).unwrap()));
        let tiles = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&tiles);
        let (faults, _) = scripted(Box::new(move |seen| {
            kept.lock().unwrap().extend(seen.tile);
            None
        }));
        let left = run(&study, &mut Subject::device(&adapter, faults));
        assert_eq!(left.rows, reference.rows, "without any fault");
        let tiles = tiles.lock().unwrap();
        assert!(tiles.len() >= 6, "{tiles:?} are too few tiles to have a middle");
        Subject { study, adapter, reference, work: tiles.iter().sum(), first_tile: tiles[0] }
    }

    fn device(adapter: &Adapter, faults: Faults) -> Device {
        let mut gpu = open(adapter, adapter.variant());
        gpu.set_tile(1 << 15);
        gpu.inject(faults);
        Device::Gpu(Box::new(gpu))
    }

    fn survives(&self, case: Case) {
        let Case { name, script, faults: fewest, said, on_cpu } = case;
        let (faults, seen) = scripted(script);
        let mut device = Subject::device(&self.adapter, faults);
        let left = run(&self.study, &mut device);
        let seen = *seen.lock().unwrap();
        assert!(seen.taken >= fewest, "{name}: {} faults", seen.taken);
        let notes = &left.done.degraded;
        assert_eq!(notes.len(), said.len(), "{name}: {notes:#?}");
        for (note, said) in notes.iter().zip(said) {
            assert!(note.contains(said), "{name}: {note}");
            assert!(note.contains(&self.adapter.name()), "{name}: {note}");
        }
        assert_eq!(matches!(device, Device::Cpu(_)), on_cpu, "{name}: {}", device.name());
        for named in &left.devices {
            assert!(named.contains(&self.adapter.name()), "{name}: {named}");
            assert_eq!(named.contains("and CPU"), on_cpu, "{name}: {named}");
        }
        assert_eq!(left.rows, self.reference.rows, "{name}");
        assert_eq!(left.tables, self.reference.tables, "{name}");
        assert_eq!(left.done.trials, self.reference.done.trials, "{name}");
    }

    /// This fault alone.
    fn once(&self, place: Place, fault: Fault, said: &'static str) -> Case {
        let work = self.work;
        let script = move |seen: Seen| (seen.taken == 0 && place.is_next(seen, work)).then_some(fault);
        let name = format!("{fault:?} once, {place:?} tile");
        Case { name, script: Box::new(script), faults: 1, said: vec![said], on_cpu: false }
    }

    /// From this tile on memory is never enough.
    fn out_of_memory_for_ever(&self, place: Place) -> Case {
        let work = self.work;
        let is_short = move |seen: Seen| seen.taken > 0 || place.is_next(seen, work);
        Case {
            name: format!("out of memory for ever from the {place:?} tile on"),
            script: Box::new(move |seen| is_short(seen).then_some(Fault::OutOfMemory)),
            faults: 2,
            said: vec![SMALLER, "the device is out of memory; from here on CPU"],
            on_cpu: true,
        }
    }

    /// Lost, and then not to be had again.
    fn gone(&self, place: Place) -> Case {
        let work = self.work;
        let fails = move |seen: Seen| seen.tile.is_none() || place.is_next(seen, work);
        Case {
            name: format!("gone in the {place:?} tile"),
            script: Box::new(move |seen| fails(seen).then_some(Fault::LostAfter)),
            faults: 2,
            said: vec!["cannot open the device: LostAfter, as a test wants it; from here on CPU"],
            on_cpu: true,
        }
    }

    /// Lost, and again in the first tile after it was opened and tested.
    fn lost_twice_in_a_batch(&self, first_tile_again: u64) -> Case {
        let script = move |seen: Seen| match (seen.taken, seen.opened) {
            (0, _) => Some(Fault::LostAfter),
            (1, 1) => (seen.tile == Some(first_tile_again)).then_some(Fault::LostBefore),
            _ => None,
        };
        Case {
            name: "lost twice in a batch".to_owned(),
            script: Box::new(script),
            faults: 2,
            said: vec![AGAIN, "the device was lost: Destroyed; from here on CPU"],
            on_cpu: true,
        }
    }

    /// Lost in a tile, and then in every tile that it gets.
    fn lost_for_ever(&self, place: Place) -> Case {
        let work = self.work;
        let fails = move |seen: Seen| seen.tile.is_some() && (seen.taken > 0 || place.is_next(seen, work));
        Case {
            name: format!("lost for ever from the {place:?} tile on"),
            script: Box::new(move |seen| fails(seen).then_some(Fault::LostBefore)),
            faults: 2,
            said: vec!["cannot be used: the device was lost: Destroyed; from here on CPU"],
            on_cpu: true,
        }
    }

    /// Lost, and computing other bits after that.
    fn wrong_after_a_loss(&self, place: Place) -> Case {
        let work = self.work;
        let script = move |seen: Seen| match seen.opened {
            0 => place.is_next(seen, work).then_some(Fault::LostAfter).filter(|_| seen.tile.is_some()),
            _ => Some(Fault::WrongBits),
        };
        Case {
            name: format!("wrong after a loss in the {place:?} tile"),
            script: Box::new(script),
            faults: 2,
            said: vec!["computes other bits than the CPU in philox: it is not used"],
            on_cpu: true,
        }
    }
}

/// Four points, some tiles each.
fn gaps() -> Study {
    study(&[
        (ALL_FREQUENCIES, r#"list = ["5 Hz", "20 Hz"]"#),
        ("list = [1, 2, 3]", "list = [1, 3]"),
        ("1_000_000", "400_000"),
    ])
}

fn runs() -> Study {
    let text = r#"title = "Runs"
kind = "switched-run"
trials = 20_000
[gyro]
tick = "5 ms"
tick_noise = { three_sigma = "1.6 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[switching]
interval = "40 s"
gap_ticks = 3
fillers = ["const", "quadratic"]
[relock]
miss = 0.05
loop_time = "12 ms"
bias_frequency = "80 kHz"
pulse_weight = "2.6 arcsec"
curvature = 40
[run]
duration = "10 min"
"#;
    parsed("runs.toml", text)
}

/// Records of two gyros; their number is such that no tile of the self-test is as large as a first one.
fn records() -> Study {
    let text = r#"title = "Gyros at rest"
kind = "allan"
trials = 211
[record]
sample = "1 s"
length = "2000 s"
[noise]
quantisation = "0.11 arcsec"
angle_random_walk = "0.00048 deg/sqrt(h)"
bias_instability = "0.00164 deg/h"
[[sweep]]
key = "noise.bias_instability"
list = ["0.001 deg/h", "0.01 deg/h"]
"#;
    parsed("records.toml", text)
}

/// Steps of the first tile of a device that was just opened.
const FIRST_TILE: u64 = 1 << 18;

#[test]
fn gap_fill_is_the_same_whatever_happens_to_the_device() {
    let subject = Subject::new(gaps());
    let mut coverage = Coverage::start();
    let mut survives = |case| {
        subject.survives(case);
        coverage.comparisons += 1;
    };
    for place in PLACES {
        survives(subject.once(place, Fault::OutOfMemory, SMALLER));
        survives(subject.out_of_memory_for_ever(place));
        survives(subject.once(place, Fault::LostAfter, AGAIN));
        survives(subject.gone(place));
        survives(subject.lost_for_ever(place));
        survives(subject.wrong_after_a_loss(place));
    }
    survives(subject.once(Place::Middle, Fault::LostBefore, AGAIN));
    survives(subject.lost_twice_in_a_batch(FIRST_TILE));
    // Only the least tiles fit, before and after a loss.
    let work = subject.work;
    let script = move |seen: Seen| match seen.tile {
        Some(steps) if seen.opened == 0 && steps > 1 << 14 => Some(Fault::OutOfMemory),
        Some(_) if seen.opened == 0 && seen.before > work / 3 => Some(Fault::LostAfter),
        Some(steps) => {
            // The last trial of a tile may reach over its end.
            assert!(steps < 2 << 14, "a tile of {steps} steps after memory was too short for it");
            None
        }
        None => None,
    };
    survives(Case {
        name: "too large tiles, then a loss".to_owned(),
        script: Box::new(script),
        faults: 2,
        said: vec![SMALLER, AGAIN],
        on_cpu: false,
    });
    coverage.end("gap filling on a device that fails");
}

#[test]
fn whole_runs_are_the_same_whatever_happens_to_the_device() {
    let subject = Subject::new(runs());
    let mut coverage = Coverage::start();
    let mut survives = |case| {
        subject.survives(case);
        coverage.comparisons += 1;
    };
    for place in PLACES {
        survives(subject.once(place, Fault::OutOfMemory, SMALLER));
        survives(subject.gone(place));
    }
    survives(subject.once(Place::Last, Fault::LostAfter, AGAIN));
    coverage.end("whole runs on a device that fails");
}

#[test]
fn records_are_the_same_whatever_happens_to_the_device() {
    let subject = Subject::new(records());
    let mut coverage = Coverage::start();
    let mut survives = |case| {
        subject.survives(case);
        coverage.comparisons += 1;
    };
    for place in PLACES {
        survives(subject.once(place, Fault::OutOfMemory, SMALLER));
        survives(subject.out_of_memory_for_ever(place));
        survives(subject.gone(place));
        survives(subject.lost_for_ever(place));
        survives(subject.wrong_after_a_loss(place));
    }
    survives(subject.once(Place::Middle, Fault::LostAfter, AGAIN));
    survives(subject.once(Place::Last, Fault::LostBefore, AGAIN));
    survives(subject.lost_twice_in_a_batch(subject.first_tile));
    coverage.end("records on a device that fails");
}

#[test]
fn a_failed_batch_leaves_nothing_to_the_next() {
    let mut coverage = Coverage::start();
    let adapter = adapters().remove(0);
    // Of every kernel some.
    for (name, launch) in KERNELS.iter().flat_map(|kernel| launches(kernel).into_iter().step_by(6)) {
        let blocks = cover(0..(1 << 12) + 5, 9);
        let expected = reference(&launch, &blocks, true);
        let mut gpu = open(&adapter, adapter.variant());
        // In the second tile, while the first one is at work.
        let second = |fault: Fault| -> Faults {
            let tiles = AtomicU64::new(0);
            Arc::new(move |_| (tiles.fetch_add(1, Ordering::Relaxed) == 1).then_some(fault))
        };
        let tallied = |gpu: &mut Gpu| {
            gpu.set_tile(1200 * launch.steps());
            let parts = gpu.tally(&jobs(&launch, &blocks), true, &|_| {});
            parts.map(|parts| total(&launch, parts, true))
        };
        gpu.inject(second(Fault::OutOfMemory));
        assert_eq!(tallied(&mut gpu), Err(GpuError::OutOfMemory), "{name}");
        assert_eq!(tallied(&mut gpu).as_ref(), Ok(&expected), "{name} after memory was too short");
        for fault in [Fault::LostBefore, Fault::LostAfter] {
            let mut gpu = open(&adapter, adapter.variant());
            gpu.inject(second(fault));
            for _ in 0..2 {
                let found = tallied(&mut gpu);
                assert!(matches!(found, Err(GpuError::Lost(_))), "{name}, {fault:?}: {:?}", found.is_ok());
            }
        }
        coverage.comparisons += 3;
    }
    coverage.end("batches after a failed one");
}

#[test]
fn one_wrong_bit_in_any_kernel_fails_the_self_test() {
    let adapter = adapters().remove(0);
    let work = {
        let mut gpu = open(&adapter, adapter.variant());
        let (faults, seen) = scripted(Box::new(|_| None));
        gpu.inject(faults);
        assert!(trusted(gpu).is_ok());
        seen.lock().unwrap().before
    };
    let mut kernels = Vec::new();
    for place in PLACES {
        let (faults, seen) = scripted(Box::new(move |seen| {
            (seen.taken == 0 && place.is_next(seen, work)).then_some(Fault::WrongBits)
        }));
        let mut gpu = open(&adapter, adapter.variant());
        gpu.inject(faults);
        match trusted(gpu) {
            Err(SelectError::Untrusted { name, kernel }) => {
                assert_eq!(name, adapter.name());
                kernels.push(kernel);
            }
            Err(error) => panic!("{place:?} tile: {error}"),
            Ok(_) => panic!("{place:?} tile: a wrong bit was not found"),
        }
        assert_eq!(seen.lock().unwrap().taken, 1, "{place:?} tile");
    }
    assert_eq!((kernels[0], kernels[2]), ("philox", "allan"), "{kernels:?}");
}
