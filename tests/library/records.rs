//! Synthetic records and their Allan sums: the same bits in every width, shader and division.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::devices::{adapters, open};
use sagnac::device::gpu::adapter::{Fault, Moment};
use sagnac::device::samples::SharedDevice;
use sagnac::device::{Cpu, Device, GpuError};
use sagnac::record::write::Form;
use sagnac::use_cases::{MotionText, Numbers, SimulateRequest, Simulation};
use sagnac_engine::kinds::allan::Allan;
use sagnac_engine::kinds::allan::lower::theory::LoweredCurve;
use sagnac_engine::kinds::allan::verify::{NamedRecords, THINNED, lgk_400, named_records};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::recipe::{Level, Recipe};
use sagnac_kernel::shader::Variant;
use sagnac_kernel::width::Width;

/// Octaves that a record of `samples` has room for; `overlap` differences in an averaging time, or all.
fn levels(samples: u32, order: u32, overlap: Option<u32>) -> Vec<Level> {
    let mut levels: Vec<Level> = Vec::new();
    for m in (0..31).map(|octave| 1 << octave).take_while(|m| order * m <= samples) {
        let stride = overlap.map_or(1, |overlap| (m / overlap).max(1));
        match levels.last_mut() {
            Some(level) if level.stride == stride => level.spans.push(m / stride),
            _ => levels.push(Level { stride, spans: vec![m / stride] }),
        }
    }
    levels
}

/// White noise, and nothing else.
fn white(samples: u32) -> Recipe {
    Recipe {
        key: [0x1234_5678, 0x9abc_def0],
        samples,
        white: 16 * 1000,
        rate_scale: 1 << 24,
        walk: 0,
        flicker: vec![],
        markov: None,
        sine: None,
        quantization: 0,
        pulse: None,
        switching: None,
        drift: Arc::new([]),
        order: 2,
        levels: levels(samples, 2, None),
    }
}

/// Records that differ in all that the kernel distinguishes.
fn recipes() -> Vec<(&'static str, Recipe)> {
    let drift = |samples: u32| (0..=samples).map(|k| k.wrapping_mul(k) / 7).collect();
    let everything = Recipe {
        walk: 16 * 40,
        flicker: vec![16 * 3000; 9],
        markov: Some([1 << 22, 4 * 500, 4 * 8000]),
        sine: Some([0x0123_4567, 4 * 5000]),
        quantization: 16 * 77,
        pulse: Some(5),
        switching: Some([63, 4 * 30_000, 16 * 900]),
        drift: drift(1000),
        ..white(1000)
    };
    let named = named_records().into_iter().map(|named| (named.name, named.lowered().recipe().clone()));
    let made = vec![
        ("white", white(5000)),
        ("one sample", white(2)),
        ("a whole chunk", white(63)),
        ("a chunk and one", white(64)),
        ("walk", Recipe { walk: 16 * 30, ..white(300) }),
        ("flicker of two octaves", Recipe { flicker: vec![16 * 3000; 1], ..white(300) }),
        ("flicker of short holds", Recipe { flicker: vec![16 * 3000; 5], ..white(700) }),
        ("flicker", Recipe { flicker: (1..=23).map(|o| 16 * (4000 - 100 * o)).collect(), ..white(9000) }),
        ("Markov", Recipe { markov: Some([1 << 29, 4 * 900, 4 * 1000]), ..white(300) }),
        ("sine", Recipe { sine: Some([0xfff0_0000, 4 * 30_000]), ..white(300) }),
        ("quantization", Recipe { white: 0, quantization: 16 * 500, ..white(300) }),
        ("pulses", Recipe { pulse: Some(12), ..white(300) }),
        ("drift", Recipe { drift: drift(300), ..white(300) }),
        ("switches", Recipe { switching: Some([40, 4 * 30_000, 16 * 900]), ..white(300) }),
        ("a switch after every sample", Recipe { switching: Some([1, 4 * 3000, 0]), ..white(300) }),
        ("switches with noise alone", Recipe { switching: Some([64, 0, 16 * 900]), ..white(1000) }),
        ("a switch after the record", Recipe { switching: Some([301, 4 * 3000, 0]), ..white(300) }),
        ("Hadamard", Recipe { order: 3, levels: levels(3000, 3, None), ..white(3000) }),
        ("some of the differences", Recipe { levels: levels(20_000, 2, Some(16)), ..white(20_000) }),
        ("without overlap", Recipe { levels: levels(2000, 2, Some(1)), ..white(2000) }),
        (
            "any averaging factors",
            Recipe {
                levels: vec![
                    Level { stride: 1, spans: vec![1, 3, 7, 100] },
                    Level { stride: 7, spans: vec![1, 30] },
                    Level { stride: 100, spans: vec![1, 5] },
                ],
                ..white(1500)
            },
        ),
        ("everything", everything.clone()),
        (
            "everything, Hadamard, from far on",
            Recipe { order: 3, levels: levels(1000, 3, Some(8)), ..everything },
        ),
    ];
    made.into_iter().chain(named).collect()
}

/// Records of each recipe: more than the lanes of any width, and not a multiple of them.
const COUNT: usize = 37;

#[test]
fn records_are_the_same_in_every_width_and_division() {
    for (name, recipe) in recipes() {
        for first in [0, (1 << 32) - 20] {
            let reference = recipe.sums(Width::PORTABLE, first, 20);
            let beyond = recipe.sums(Width::PORTABLE, first + 20, COUNT - 20);
            let reference = [reference, beyond].concat();
            assert_eq!(reference.len(), COUNT * recipe.places(), "{name}");
            for width in Width::available() {
                for threads in [1, 3] {
                    let cpu = Cpu::new(width, threads).unwrap();
                    let found = cpu.sums(&recipe, first, COUNT, &|_| {});
                    assert!(found == reference, "{name} from {first}: {}, {threads} threads", width.name());
                }
            }
        }
    }
}

#[test]
fn records_are_the_same_in_every_shader() {
    for adapter in adapters() {
        for int64 in [true, false] {
            for (checked, workgroup) in [(true, 64), (false, 32)] {
                if int64 && !adapter.has_int64() {
                    continue;
                }
                let mut gpu = open(&adapter, Variant { int64, checked, workgroup });
                for (name, recipe) in recipes() {
                    let first = (1 << 32) - 20;
                    let reference =
                        Cpu::new(Width::widest(), 0).unwrap().sums(&recipe, first, COUNT, &|_| {});
                    let found = gpu.sums(&recipe, first, COUNT, &|_| {}).unwrap();
                    assert!(
                        found == reference,
                        "{name}: {}, 64 bits {int64}, checked {checked}, workgroup {workgroup}",
                        gpu.name()
                    );
                }
            }
        }
    }
}

#[test]
fn a_record_of_many_dispatches_is_the_same() {
    let (name, samples) = ("lgk-400", 60_000);
    let switching = None;
    let named =
        NamedRecords { name, parts: lgk_400(), readout_lsb: 0.0, switching, samples, estimator: THINNED };
    let records = named.lowered();
    let recipe = records.recipe();
    let reference = Cpu::new(Width::widest(), 0).unwrap().sums(recipe, 5, 3, &|_| {});
    for adapter in adapters() {
        for int64 in [true, false] {
            if int64 && !adapter.has_int64() {
                continue;
            }
            let mut gpu = open(&adapter, Variant { int64, checked: false, workgroup: 64 });
            let found = gpu.sums(recipe, 5, 3, &|_| {}).unwrap();
            assert!(found == reference, "{}, 64 bits {int64}", gpu.name());
        }
    }
}

/// Every noise beside a readout of whole pulses.
const STUDY: &str = "title = \"Records\"
kind = \"allan\"
trials = 9
seed = 3

[record]
sample = \"0.01 s\"
length = \"20 s\"

[noise]
quantization = \"0.05 arcsec\"
readout_lsb = \"0.02 arcsec\"
angle_random_walk = \"0.01 deg/sqrt(h)\"
bias_instability = \"1 deg/h\"
rate_random_walk = \"20 deg/h/sqrt(h)\"
rate_ramp = \"100 deg/h/h\"
markov = { amplitude = \"2 deg/h\", time = \"3 s\" }
sine = { amplitude = \"1 deg/h\", frequency = \"0.7 Hz\" }

[allan]
overlap = \"full\"
tau = \"decade10\"
";

/// The sums of squared differences of a record whose samples are whole multiples of `lsb`.
fn sums_of(increments: impl Iterator<Item = f64>, lsb: f64, levels: &[Level]) -> Vec<u128> {
    let mut angles = vec![0_i64];
    for increment in increments {
        let whole = (increment / lsb).round();
        assert_eq!(whole * lsb, increment, "a sample is a whole number of LSB");
        angles.push(angles[angles.len() - 1] + whole as i64);
    }
    let square = |stride: usize, span: u32| {
        let kept: Vec<i64> = angles.iter().step_by(stride).copied().collect();
        let differences = kept.windows(2 * span as usize + 1);
        let second = |angles: &[i64]| angles[0] - 2 * angles[span as usize] + angles[2 * span as usize];
        differences.map(|angles| u128::from(second(angles).unsigned_abs()).pow(2)).sum()
    };
    let of_level = |level: &Level| -> Vec<u128> {
        level.spans.iter().map(|&span| square(level.stride as usize, span)).collect()
    };
    levels.iter().flat_map(of_level).collect()
}

#[test]
fn record_7_of_seed_3_is_the_samples_that_simulate_writes_on_every_device() {
    let simulation = Simulation::parse("study.toml", STUDY, &SimulateRequest::default()).unwrap();
    let study = simulation.study();
    let allan = study.asked::<Allan>().unwrap();
    let lowered = LoweredCurve::new(&allan.points[0], allan.estimator, study.seed, study.streams).unwrap();
    let (records, number) = (&lowered.records, 7);
    let (recipe, lsb) = (records.recipe(), records.lsb_arcsec());
    let expected = sums_of(simulation.numbers(number, 0, Numbers::Increment), lsb, &recipe.levels);
    assert_eq!(expected.len(), recipe.places());
    // By itself, and as one of several that a division of the trials makes.
    let divisions = [(7, 1), (0, 9), (5, 4), (6, 2)];
    let own = |all: Vec<u128>, first: u64| {
        let start = (number - first) as usize * expected.len();
        all[start..start + expected.len()].to_vec()
    };
    for width in Width::available() {
        let cpu = Cpu::new(width, 2).unwrap();
        for (first, count) in divisions {
            let found = own(cpu.sums(recipe, first, count, &|_| {}), first);
            assert!(found == expected, "{}, {count} from {first}", width.name());
        }
    }
    for adapter in adapters() {
        for int64 in [true, false].into_iter().filter(|int64| adapter.has_int64() || !int64) {
            let variant = Variant { int64, checked: int64, workgroup: 64 };
            let mut gpu = open(&adapter, variant);
            for (first, count) in divisions {
                let found = own(gpu.sums(recipe, first, count, &|_| {}).unwrap(), first);
                assert!(found == expected, "{}, {variant:?}, {count} from {first}", gpu.name());
            }
        }
    }
}

#[test]
fn angles_made_in_segments_are_those_made_one_after_the_other() {
    let blocks = [(1, 70), (3, 4096)];
    let check = |shared: SharedDevice, name: &str| {
        for (recipe_name, recipe) in recipes() {
            for ((chunks, segments), number) in blocks.into_iter().zip([(1 << 32) - 1, 1 << 40]) {
                let made = shared.clone().in_blocks(chunks, segments).angles(&recipe, number);
                let is_same = made.eq(recipe.unread().angles(number));
                assert_eq!(shared.failure(), None, "{name}");
                assert!(is_same, "{recipe_name}, record {number}: {name}, {segments} times {chunks} chunks");
            }
        }
    };
    let cpus = Width::available().into_iter().map(|width| Device::Cpu(Cpu::new(width, 2).unwrap()));
    cpus.for_each(|cpu| check(SharedDevice::new(cpu), "the processor"));
    for adapter in adapters() {
        for int64 in [true, false].into_iter().filter(|int64| adapter.has_int64() || !int64) {
            let gpu = open(&adapter, Variant { int64, checked: int64, workgroup: 64 });
            let name = format!("{}, 64 bits {int64}", gpu.name());
            check(SharedDevice::new(Device::Gpu(Box::new(gpu))), &name);
        }
    }
}

#[test]
fn a_device_makes_the_numbers_that_simulate_writes_without_one() {
    let switched = STUDY.replace("readout_lsb = \"0.02 arcsec\"\n", "")
        + "[noise.switching]\ninterval = \"0.63 s\"\nmagnetic = \"30 deg/h\"\nresidual = \"0.4 arcsec\"\n";
    let motion =
        || MotionText { axis: 2, name: "own.toml".to_owned(), text: "rate = \"200 deg/h\"".to_owned() };
    let request = SimulateRequest { three_axes: true, motions: vec![motion()], ..Default::default() };
    for (text, request) in
        [(STUDY, &SimulateRequest::default()), (STUDY, &request), (&switched, &SimulateRequest::default())]
    {
        let simulation = || Simulation::parse("study.toml", text, request).unwrap();
        for adapter in adapters() {
            let gpu = open(&adapter, Variant { int64: false, checked: false, workgroup: 64 });
            let made = simulation().on(Device::Gpu(Box::new(gpu)));
            for axis in 0..made.axes() {
                let expected: Vec<f64> = simulation().numbers(7, axis, Numbers::Increment).collect();
                let found: Vec<f64> = made.numbers(7, axis, Numbers::Increment).collect();
                assert!(
                    found == expected && found.len() == 2000,
                    "{}, axis {axis} of {text}",
                    adapter.name()
                );
            }
        }
    }
}

#[test]
fn a_device_that_is_lost_ends_the_record_with_an_error() {
    let adapter = &adapters()[0];
    let mut gpu = open(adapter, Variant { int64: false, checked: false, workgroup: 64 });
    let tiles = AtomicU64::new(0);
    gpu.inject(Arc::new(move |moment| {
        let is_fifth = matches!(moment, Moment::Tile(_)) && tiles.fetch_add(1, Ordering::Relaxed) == 4;
        is_fifth.then_some(Fault::LostBefore)
    }));
    let simulation = Simulation::parse("study.toml", STUDY, &SimulateRequest::default()).unwrap();
    let simulation = simulation.on(Device::Gpu(Box::new(gpu)));
    let error = simulation.write(7, Numbers::Rate, Form::Csv, &mut std::io::sink()).unwrap_err();
    assert!(error.to_string().contains("lost"), "{error}");
    assert!(matches!(simulation.failure(), Some(GpuError::Lost(_))));
}
