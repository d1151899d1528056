//! Devices that fail in the middle of a run: out of memory, lost, gone, computing other bits. Whatever happens, all tables
//! and all rows of the store are, bit for bit, those of a run on the processor that nothing disturbed.

mod case;
mod group;
mod left;
mod script;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use crate::devices::{Coverage, adapters, jobs, open, reference, total};
use crate::studies::{ALL_FREQUENCIES, parsed, study};
use case::{AGAIN, Case, SMALLER, Subject};
use left::run;
use sagnac::device::gpu::Gpu;
use sagnac::device::gpu::adapter::{Fault, Faults, Moment, on_wait};
use sagnac::device::select::SelectError;
use sagnac::device::{Cpu, Device, GpuError};
use sagnac::study::Study;
use sagnac::tally::cover;
use sagnac::verify::{loads, trusted};
use sagnac_kernel::KERNELS;
use sagnac_kernel::width::Width;
use script::{PLACES, Place, Seen, scripted};

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
initial_detuning = 0.05
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
quantization = "0.11 arcsec"
angle_random_walk = "0.00048 deg/sqrt(h)"
bias_instability = "0.00164 deg/h"
[[sweep]]
key = "noise.bias_instability"
list = ["0.001 deg/h", "0.01 deg/h"]
"#;
    parsed("records.toml", text)
}

/// Steps of the first tile of a software rasterizer that was opened again after a loss.
const FIRST_TILE: u64 = 1 << 16;

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

/// What is said while a driver takes long.
static WAITS: Mutex<Vec<String>> = Mutex::new(vec![]);

#[test]
fn a_driver_that_never_compiles_a_shader_is_announced_and_leaves_the_run_to_the_processor() {
    on_wait(|sentence| WAITS.lock().unwrap().push(sentence.to_owned()));
    let mut coverage = Coverage::start();
    for study in [gaps(), records()] {
        Subject::new(study).survives_a_stuck_driver();
        coverage.comparisons += 1;
    }
    let name = adapters().remove(0).name();
    let said = format!("{name}: its driver still compiles a shader; after 5 minutes the device is given up");
    assert_eq!(*WAITS.lock().unwrap(), [said.clone(), said]);
    coverage.end("studies on a device whose driver is stuck");
}

#[test]
fn a_failed_batch_leaves_nothing_to_the_next() {
    let mut coverage = Coverage::start();
    let adapter = adapters().remove(0);
    // Of every kernel some.
    for load in KERNELS.iter().flat_map(|kernel| loads(kernel).into_iter().step_by(6)) {
        let (name, Some(launch)) = (load.name, load.launch()) else { continue };
        let blocks = cover(0..(1 << 12) + 5, 9);
        let expected = reference(launch, &blocks, true);
        let mut gpu = open(&adapter, adapter.variant());
        // In the second tile, while the first one is at work.
        let second = |fault: Fault| -> Faults {
            let tiles = AtomicU64::new(0);
            Arc::new(move |moment| {
                let is_second =
                    || matches!(moment, Moment::Tile(_)) && tiles.fetch_add(1, Ordering::Relaxed) == 1;
                is_second().then_some(fault)
            })
        };
        let tallied = |gpu: &mut Gpu| {
            gpu.set_tile(1200 * launch.steps());
            let parts = gpu.tally(&jobs(launch, &blocks), true, &|_| {});
            parts.map(|parts| total(launch, parts, true))
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
fn the_processor_takes_over_where_a_new_pipeline_answers_wrong() {
    let adapter = adapters().remove(0);
    for study in [gaps(), records()] {
        let reference = run(&study, &mut Device::Cpu(Cpu::new(Width::widest(), 0).unwrap()));
        let mut gpu = open(&adapter, adapter.variant());
        gpu.inject(Arc::new(|moment| (moment == Moment::Answer).then_some(Fault::WrongBits)));
        let mut device = Device::Gpu(Box::new(gpu));
        let left = run(&study, &mut device);
        assert!(matches!(device, Device::Cpu(_)), "{}", device.name());
        let [note] = &left.done.degraded[..] else { panic!("{:#?}", left.done.degraded) };
        assert!(note.contains("it computes other bits than the CPU"), "{note}");
        assert_eq!((left.rows, left.tables), (reference.rows, reference.tables));
    }
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
    let ends = (KERNELS[0].name, KERNELS[KERNELS.len() - 1].name);
    assert_eq!((kernels[0], kernels[2]), ends, "{kernels:?}");
}
