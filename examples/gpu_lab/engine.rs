//! Parts `engine`, `records` and `long`: the device as the program uses it.

use std::time::Instant;

use sagnac::device::Job;
use sagnac::device::gpu::{Adapter, Gpu};
use sagnac::tally::cover;
use sagnac::theory::allan::{Estimator, Part};
use sagnac_engine::kinds::allan::verify::{NamedRecords, THINNED, lgk_400};
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::Moments;
use serde_json::{Value, json};

use crate::{Options, benches, chosen, emit};

fn open(options: &Options) -> Gpu {
    let adapter = chosen(options, Adapter::all(), |adapter| (adapter.name(), adapter.is_software()));
    eprintln!("{}", adapter.name());
    Gpu::open(&adapter, adapter.variant()).expect("the adapter opens")
}

/// Seconds of the fastest of at least `least` runs, which take so long together.
fn best(least: usize, seconds: f64, mut run: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    let (begun, mut runs) = (Instant::now(), 0);
    while runs < least || begun.elapsed().as_secs_f64() < seconds {
        let started = Instant::now();
        run();
        best = best.min(started.elapsed().as_secs_f64());
        runs += 1;
    }
    best
}

pub fn engine(options: &Options) {
    let mut gpu = open(options);
    let launch = &benches()[0].launch;
    for histogram in [false, true] {
        for log2 in if options.tiny { 14..=16 } else { 14..=34 } {
            let blocks = cover(0..1 << log2, 26);
            let jobs: Vec<Job> = blocks.into_iter().map(|block| Job { launch, block }).collect();
            let seconds = best(3, options.seconds, || {
                gpu.tally(&jobs, histogram, &|_| {}).expect("tallied");
            });
            let rate = (1_u64 << log2) as f64 / seconds;
            eprintln!(
                "one point, 2^{log2} trials in one call, histogram {histogram:5}: {:10.3} ms, {:9.3} G trials/s",
                seconds * 1e3,
                rate / 1e9
            );
            emit(
                &json!({ "part": "engine", "what": "one point", "histogram": histogram, "log2": log2, "seconds": seconds,
                "trials_per_second": rate }),
            );
        }
    }
    let sweeps: &[(u32, u64)] = if options.tiny {
        &[(8, 20_000)]
    } else {
        &[(72, 1_000_000), (72, 100_000), (550, 50_000), (1000, 1000)]
    };
    for &(points, trials) in sweeps {
        sweep(&mut gpu, launch, points, trials);
    }
}

/// A sweep: launches that differ in their words alone, point by point or in turns as a run has them.
fn sweep(gpu: &mut Gpu, launch: &Launch, points: u32, trials: u64) {
    let point = |at| {
        let mut words = launch.words().to_vec();
        words[0] ^= at;
        launch.with_words(words).expect("another key has the same shape")
    };
    let launches: Vec<Launch> = (0..points).map(point).collect();
    let blocks = cover(0..trials, 18);
    let job = |launch, &block| Job { launch, block };
    let one_by_one =
        launches.iter().flat_map(|launch| blocks.iter().map(move |block| job(launch, block))).collect();
    let in_turns =
        blocks.iter().flat_map(|block| launches.iter().map(move |launch| job(launch, block))).collect();
    let orders: [(&str, Vec<Job>); 2] =
        [("point by point", one_by_one), ("interleaved, as a run has them", in_turns)];
    for (order, jobs) in orders {
        let seconds = best(4, 0.0, || {
            for batch in jobs.chunks(1024) {
                gpu.tally(batch, true, &|_| {}).expect("tallied");
            }
        });
        let rate = f64::from(points) * trials as f64 / seconds;
        eprintln!(
            "{points} points of {trials} trials, {order}: {:.3} ms, {:.3} G trials/s",
            seconds * 1e3,
            rate / 1e9
        );
        emit(
            &json!({ "part": "engine", "what": "points", "points": points, "trials": trials, "jobs": jobs.len(),
            "order": order, "seconds": seconds, "trials_per_second": rate }),
        );
    }
}

pub fn records(options: &Options) {
    let mut gpu = open(options);
    let white = vec![Part::angle_random_walk(0.04)];
    let all = [
        ("lgk-400, m/64", lgk_400(), 32_400, THINNED),
        ("lgk-400, full overlap", lgk_400(), 32_400, Estimator::OVERLAPPING),
        ("lgk-400, m/64, short", lgk_400(), 4096, THINNED),
        ("white, m/64", white, 32_400, THINNED),
    ];
    for (name, parts, samples, estimator) in all {
        let samples = if options.tiny { samples / 16 } else { samples };
        let lowered =
            NamedRecords { name, parts, readout_lsb: 0.0, switching: None, samples, estimator }.lowered();
        let recipe = lowered.recipe();
        let counts: &[usize] = if options.tiny { &[64] } else { &[64, 1024, 4096, 8192, 16_384, 65_536] };
        for &count in counts {
            let seconds = best(2, options.seconds, || {
                gpu.sums(recipe, 0, count, &|_| {}).expect("made");
            });
            let rate = count as f64 * samples as f64 / seconds;
            eprintln!(
                "{name:24} {samples:7} samples, {count:6} records, {:5} words of rings: {:10.2} ms, {:9.4} G samples/s",
                recipe.depth(),
                seconds * 1e3,
                rate / 1e9
            );
            emit(&json!({ "part": "records", "what": name, "samples": samples, "records": count,
                "ring_words": recipe.depth(), "places": recipe.places(), "seconds": seconds,
                "samples_per_second": rate }));
        }
    }
}

pub fn long(options: &Options) {
    let mut gpu = open(options);
    let launch = &benches()[0].launch;
    let trials: u64 = if options.tiny { 10_000_000 } else { 100_000_000_000 };
    let mut total = vec![Moments::empty(true); launch.sampled().estimates()];
    let started = Instant::now();
    for blocks in cover(0..trials, 26).chunks(128) {
        let jobs: Vec<Job> = blocks.iter().map(|&block| Job { launch, block }).collect();
        for part in gpu.tally(&jobs, true, &|_| {}).expect("tallied") {
            total.iter_mut().zip(&part).for_each(|(total, part)| total.merge(part));
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    let rate = trials as f64 / seconds;
    eprintln!("{trials} trials of one point with histogram: {seconds:.3} s, {:.3} G trials/s", rate / 1e9);
    let sums: Vec<Value> = total
        .iter()
        .map(|tally| {
            json!({ "count": tally.count, "sum": tally.sum.to_string(), "square": tally.square.to_string(),
            "least": tally.least, "greatest": tally.greatest })
        })
        .collect();
    emit(&json!({ "part": "long", "trials": trials, "seconds": seconds,
        "trials_per_second": rate, "sums": sums }));
}
