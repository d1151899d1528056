//! Identity: every width, every thread count, every division of the trials and every variant of the shaders give the
//! bits of the portable kernel. `assert_eq!` on whole tallies; there is no tolerance anywhere in this file.
//!
//! Two lists drive it, [`KERNELS`] and the launches of each: a new kernel or configuration cannot be forgotten.

use crate::devices::{Coverage, adapters, is_turn, name, on_cpu, on_gpu, open, reference, variants};
use rayon::prelude::*;
use sagnac::device::{Cpu, Job};
use sagnac::tally::{Block, cover};
use sagnac_engine::kinds::gap_fill::inputs::TickNoise;
use sagnac_engine::kinds::gap_fill::verify::{Configuration, configurations};
use sagnac_engine::motion::keys::Phase;
use sagnac_kernel::gap_fill::Shape;
use sagnac_kernel::gap_fill::shape::Parameters;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::map::Map;
use sagnac_kernel::moments::{BINS, LIMIT, Moments};
use sagnac_kernel::philox::{self, philox, schedule};
use sagnac_kernel::width::Width;
use sagnac_kernel::word::Scalar;
use sagnac_kernel::{Form, KERNELS};

const TRIALS: u64 = 1 << 20;

/// The same trials in one block, in many, in many more than a tile holds, and in uneven parts from the last to the
/// first.
fn divisions(trials: u64) -> Vec<(&'static str, Vec<Block>)> {
    let cuts = [0, 1, trials / 13, trials / 2 - 7, trials / 2 + 1, trials];
    let ragged = cuts.windows(2).rev().flat_map(|cut| cover(cut[0]..cut[1], 17)).collect();
    vec![
        ("whole", cover(0..trials, 63)),
        ("split", cover(0..trials, 14)),
        ("fine", cover(0..trials, 9)),
        ("ragged", ragged),
    ]
}

/// Random123's `kat_vectors` for philox4x32, 10 rounds: counter and key, output.
const RANDOM123: [([u32; 6], [u32; 4]); 3] = [
    ([0; 6], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
    ([!0; 6], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
    (
        [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344, 0xa409_3822, 0x299f_31d0],
        [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
    ),
];

#[test]
fn words_are_those_of_random123_in_every_width_and_shader() {
    let mut coverage = Coverage::start();
    let Form::Map(map) = philox::FORM else { unreachable!("a building block") };
    let items = RANDOM123.map(|(input, _)| input).concat();
    let expected = RANDOM123.map(|(_, output)| output).concat();
    for width in Width::available() {
        assert_eq!((map.cpu)(width, &items), expected, "{}", width.name());
        coverage.comparisons += 1;
    }
    for adapter in adapters() {
        for variant in variants(&adapter) {
            let found = open(&adapter, variant).map(&map, &items).unwrap();
            assert_eq!(found, expected, "{}", name(&adapter, variant));
            coverage.comparisons += 1;
        }
    }
    coverage.end("Random123 vectors");
}

/// Words round every edge of the building blocks, then words of the generator: in all an odd number of items.
fn items(map: &Map) -> Vec<u32> {
    let mut words: Vec<u32> =
        (0..32).flat_map(|bit| [-1, 0, 1].map(|step| (1_u32 << bit).wrapping_add_signed(step))).collect();
    words.extend((0..4).flat_map(|turn: u32| [-1, 0, 1].map(|step| (turn << 30).wrapping_add_signed(step))));
    let count = (1 << 16) + 41;
    let counters = 0..(count * map.inputs as u32).div_ceil(4);
    let block = |counter| philox([counter, 7, 7, 7].map(Scalar), schedule([Scalar(3); 2])).map(|word| word.0);
    words.extend(counters.flat_map(block));
    words.truncate(count as usize * map.inputs);
    words
}

#[test]
fn building_blocks_are_the_same_in_every_width_and_shader() {
    let mut coverage = Coverage::start();
    let mut names = Vec::new();
    let adapters = adapters();
    for kernel in KERNELS {
        let Form::Map(map) = kernel.form else { continue };
        let items = items(&map);
        let reference = (map.cpu)(Width::PORTABLE, &items);
        for width in Width::available() {
            assert_eq!((map.cpu)(width, &items), reference, "{} in {}", kernel.name, width.name());
            coverage.comparisons += 1;
        }
        for adapter in &adapters {
            for variant in variants(adapter) {
                let found = open(adapter, variant).map(&map, &items).unwrap();
                assert_eq!(found, reference, "{} on {}", kernel.name, name(adapter, variant));
                coverage.comparisons += 1;
            }
        }
        names.push(kernel.name);
    }
    coverage.end(&format!("building blocks {names:?}, {} items each", (1 << 16) + 41));
}

/// The launches of all kernels that sample, by name.
fn launches() -> Vec<(&'static str, Launch)> {
    let loads = KERNELS.iter().flat_map(sagnac::verify::loads);
    loads.filter_map(|load| Some((load.name, load.launch()?.clone()))).collect()
}

/// Trials of a configuration: many for the paper's point, whose every case is gone through; of long ones as many as their
/// steps leave.
fn trials(configuration: &str, launch: &Launch) -> u64 {
    if configuration == "paper" {
        TRIALS
    } else {
        ((1 << 17) / launch.steps().next_power_of_two()).max(1 << 9)
    }
}

#[test]
fn every_configuration_is_the_same_on_any_width_threads_and_division() {
    let mut coverage = Coverage::start();
    for (configuration, launch) in &launches() {
        // The paper's point without the histogram too, and in a number of trials that no width divides.
        let paper = *configuration == "paper";
        let cases =
            [(trials(configuration, launch), true), (TRIALS, false), (1_000_003, true), (1_000_003, false)];
        for &(trials, histogram) in &cases[..if paper { 4 } else { 1 }] {
            let reference = reference(launch, &cover(0..trials, 63), histogram);
            for (w, width) in Width::available().into_iter().enumerate() {
                for (d, (division, blocks)) in divisions(trials).into_iter().enumerate() {
                    // The others in one number of threads for each division, another in each width.
                    let threads = if paper { 1..=3 } else { (w + d) % 3 + 1..=(w + d) % 3 + 1 };
                    for threads in threads {
                        let found = on_cpu(width, threads, launch, &blocks, histogram);
                        let width = width.name();
                        assert_eq!(
                            found, reference,
                            "{configuration} in {width}, {threads} threads, {division}, {trials} trials"
                        );
                        coverage.comparisons += 1;
                    }
                }
            }
        }
    }
    coverage.end(&format!("{} launches: widths × threads × divisions", launches().len()));
}

#[test]
fn every_configuration_is_the_same_on_any_shader_tile_and_division() {
    let mut coverage = Coverage::start();
    let launches = launches();
    let expected =
        |trials: u64, histogram: bool, launch: &Launch| reference(launch, &cover(0..trials, 63), histogram);
    let references: Vec<Vec<Moments>> =
        launches.iter().map(|(name, launch)| expected(trials(name, launch), true, launch)).collect();
    let without_histogram = expected(TRIALS, false, &launches[0].1);
    for adapter in adapters() {
        let variants = variants(&adapter);
        let compared = variants.par_iter().enumerate().map(|(v, &variant)| {
            let (mut gpu, mut comparisons) = (open(&adapter, variant), 0);
            for (l, ((configuration, launch), reference)) in launches.iter().zip(&references).enumerate() {
                let paper = *configuration == "paper";
                if !paper && !is_turn(variant, l) {
                    continue;
                }
                let trials = trials(configuration, launch);
                let tiles = [trials / 3 + 1, 40_001, 2 * trials, trials];
                let cases: Vec<_> = divisions(trials).into_iter().zip(tiles).collect();
                // The others in one division for each variant, another in the next configuration.
                let chosen = if paper { 0..4 } else { (v + l) % 4..(v + l) % 4 + 1 };
                for ((division, blocks), tile) in &cases[chosen] {
                    for histogram in [true, false] {
                        if !histogram && !paper {
                            continue;
                        }
                        gpu.set_tile(*tile);
                        let found = on_gpu(&mut gpu, launch, blocks, histogram);
                        let reference = if histogram { reference } else { &without_histogram };
                        let name = name(&adapter, variant);
                        assert_eq!(
                            &found, reference,
                            "{configuration} on {name}, {division}, tiles of {tile} at first"
                        );
                        comparisons += 1;
                    }
                }
            }
            comparisons
        });
        coverage.comparisons += compared.sum::<usize>();
    }
    coverage.end(&format!("{} launches: shader variants × tiles and divisions", launches.len()));
}

/// A launch of the paper's point at its extremum without noise, whose every error is near ±[`LIMIT`]: the truth alone,
/// times a scale that brings it there.
fn at_the_limit(sign: i32) -> (Launch, i64) {
    let launch = Configuration::new("at the limit", |c| {
        c.tone().phase = Phase::Extremum;
        c.inputs.tick_noise = TickNoise::Std(0.0);
    })
    .launches()
    .remove(0);
    let shape: Shape = launch.shape().expect("of gap filling");
    let p = Parameters::new(launch.words(), shape);
    // sine(¼ turn) = 2^30.
    let truth = ((i64::from(p.gap_sin[0] as i32) << 30) + (1 << 31)) >> 32;
    let scale = ((LIMIT - 1) / truth) as i32 * sign;
    let none = vec![0; p.residual_weight.len().max(p.extrapolation_weight.len())];
    let scales = vec![scale as u32; shape.fillers];
    let words = Parameters {
        residual_weight: &none[..p.residual_weight.len()],
        extrapolation_weight: &none[..p.extrapolation_weight.len()],
        residual_scale: &scales,
        extrapolation_scale: &scales,
        ..p
    }
    .words();
    (launch.with_words(words).expect("the same shape"), -truth * i64::from(scale))
}

#[test]
fn sums_of_the_largest_errors_are_exact_in_every_width_and_shader() {
    let mut coverage = Coverage::start();
    for sign in [1, -1] {
        let (launch, error) = at_the_limit(sign);
        assert!(error.abs() > LIMIT - LIMIT / 64, "{error} is near the limit of {LIMIT}");
        let bins = {
            let mut bins = vec![0; BINS];
            bins[BINS - 1] = TRIALS;
            bins
        };
        let expected = Moments {
            count: TRIALS,
            sum: i128::from(error) * i128::from(TRIALS),
            square: (i128::from(error) * i128::from(error)) as u128 * u128::from(TRIALS),
            least: error as i32,
            greatest: error as i32,
            bins,
        };
        let strip = |tallies: Vec<Moments>| -> Vec<Moments> {
            // Which bin is the last depends on where the histogram starts; all trials are in one.
            tallies
                .into_iter()
                .map(|mut tally| {
                    tally.bins.sort_unstable();
                    tally
                })
                .collect()
        };
        let expected = vec![expected; launch.sampled().estimates()];
        let blocks = cover(0..TRIALS, 63);
        for width in Width::available() {
            assert_eq!(strip(on_cpu(width, 0, &launch, &blocks, true)), expected, "{}", width.name());
            coverage.comparisons += 1;
        }
        for adapter in adapters() {
            for variant in variants(&adapter) {
                let found = on_gpu(&mut open(&adapter, variant), &launch, &blocks, true);
                assert_eq!(strip(found), expected, "{}", name(&adapter, variant));
                coverage.comparisons += 1;
            }
        }
    }
    coverage.end("errors of ±2^29: Σ, Σ² and extremes against 128 bits, 2^20 trials");
}

#[test]
fn tiles_from_one_trial_to_all_give_the_same() {
    let mut coverage = Coverage::start();
    let launch = &configurations()[0].launches()[0];
    let blocks = cover(5..30_011, 13);
    let reference = reference(launch, &blocks, true);
    for adapter in adapters() {
        let mut gpu = open(&adapter, adapter.variant());
        for tile in [1, 2, 63, 64, 65, 4095, 4096, 4097, 30_006, 1 << 28] {
            gpu.set_tile(tile);
            let found = on_gpu(&mut gpu, launch, &blocks, true);
            assert_eq!(found, reference, "{}, tiles of {tile} at first", adapter.name());
            coverage.comparisons += 1;
        }
    }
    coverage.end("paper: tiles of 1 … 2^28 trials at first, 30,006 trials");
}

#[test]
fn jobs_of_many_launches_in_one_call_do_not_mix() {
    let mut coverage = Coverage::start();
    let launches: Vec<Launch> = launches().into_iter().map(|named| named.1).collect();
    let blocks = cover(3..20_000, 13);
    // Launch by launch within each block, so that neighbours differ.
    let mixed: Vec<Job> =
        blocks.iter().flat_map(|&block| launches.iter().map(move |launch| Job { launch, block })).collect();
    let expected: Vec<Vec<Moments>> =
        mixed.iter().map(|job| reference(job.launch, &[job.block], true)).collect();
    for width in Width::available() {
        assert_eq!(Cpu::new(width, 2).unwrap().tally(&mixed, true, &|_| {}), expected, "{}", width.name());
        coverage.comparisons += mixed.len();
    }
    for adapter in adapters() {
        let mut gpu = open(&adapter, adapter.variant());
        gpu.set_tile(70_000);
        assert_eq!(gpu.tally(&mixed, true, &|_| {}).unwrap(), expected, "{}", adapter.name());
        coverage.comparisons += mixed.len();
    }
    coverage.end("many launches in one call");
}

#[test]
fn one_hundred_million_trials_of_the_papers_point_are_the_same() {
    let mut coverage = Coverage::start();
    let launch = &configurations()[0].launches()[0];
    let blocks = cover(0..100_000_000, 21);
    let width = Width::widest();
    let reference = on_cpu(width, 0, launch, &blocks, false);
    for adapter in adapters() {
        let found = on_gpu(&mut open(&adapter, adapter.variant()), launch, &blocks, false);
        assert_eq!(found, reference, "{} and {}", adapter.name(), width.name());
        coverage.comparisons += 1;
    }
    assert!(reference.iter().all(|tally| tally.count == 100_000_000));
    coverage.end(&format!("paper: 1e8 trials, {} and every adapter", width.name()));
}
