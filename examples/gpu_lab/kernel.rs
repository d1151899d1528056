//! Part `kernel`: time on the device alone, by variant, edit, rounds and number of workgroups.

use std::time::Instant;

use sagnac::device::{Cpu, Job};
use sagnac::tally::cover;
use sagnac_kernel::launch::MAX_STEPS;
use sagnac_kernel::moments::Moments;
use sagnac_kernel::shader::Variant;
use sagnac_kernel::width::Width;
use serde_json::json;

use crate::edits::{EDITS, Edit, ONE_PRODUCT, PLAIN, UNIFORM};
use crate::lab::{Kernel, Lab};
use crate::{Bench, Options, benches, emit};

/// Most trials whose sums are compared with the CPU's.
const COMPARED: u64 = 1 << 27;

/// Tallies of the first trials by the CPU.
pub fn reference(bench: &Bench, trials: u64) -> Vec<Moments> {
    let cpu = Cpu::new(Width::widest(), 0).expect("threads");
    let launch = &bench.launch;
    let jobs: Vec<Job> = cover(0..trials, 20).into_iter().map(|block| Job { launch, block }).collect();
    let mut total = vec![Moments::empty(bench.histogram); launch.sampled().estimates()];
    for part in cpu.tally(&jobs, bench.histogram, &|_| {}) {
        total.iter_mut().zip(&part).for_each(|(total, part)| total.merge(part));
    }
    total
}

/// Returns whether all sums that should be those of the CPU are.
pub fn kernel(options: &Options) -> bool {
    let lab = Lab::open(options);
    let all = benches();
    // Several waves of a large device, with 64 invocations a workgroup.
    let waves: u32 = if options.tiny { 16 } else { 1 << 15 };
    let mut all_same = true;
    let mut measure = |bench, variant, edit: &Edit, groups, rounds| {
        all_same &= measure(&lab, options.seconds, (bench, variant, edit), [groups, rounds]);
    };
    let variant = Variant { int64: lab.int64, checked: false, workgroup: 64 };
    let (paper, workgroups): (_, &[u32]) =
        if options.tiny { (&all[1..2], &[64]) } else { (&all[..2], &[32, 64, 128, 256]) };
    let filling = |workgroup: u32| (waves * 64 / workgroup).max(1);
    for bench in paper {
        for int64 in if lab.int64 { vec![true, false] } else { vec![false] } {
            for checked in [false, true] {
                for &workgroup in workgroups {
                    let variant = Variant { int64, checked, workgroup };
                    measure(bench, variant, &PLAIN, filling(workgroup), 64);
                }
            }
        }
        for edit in &EDITS {
            for &workgroup in workgroups.iter().filter(|&&workgroup| workgroup == 64) {
                measure(bench, Variant { workgroup, ..variant }, edit, filling(workgroup), 64);
            }
        }
        // The same trials in fewer and longer invocations.
        for rounds in [4, 16, 256, 1024] {
            measure(bench, variant, &PLAIN, (waves * 64 / rounds).max(1), rounds);
        }
    }
    // How many workgroups fill the device.
    for groups in [64, 132, 264, 528, 1056, 2112, 4224, 8448, 16896, 65536] {
        if groups <= 4 * waves {
            measure(&all[1], variant, &PLAIN, groups, 64);
        }
    }
    for bench in &all[2..] {
        let steps = bench.launch.steps();
        let rounds = (MAX_STEPS / steps).clamp(1, 64) as u32;
        let groups = if steps > 16 { (waves / 16).max(1) } else { waves };
        for edit in [PLAIN, ONE_PRODUCT, UNIFORM] {
            measure(bench, variant, &edit, groups, rounds);
        }
    }
    all_same
}

/// Measures one shader; `false` if its sums differ from the CPU's and should not.
fn measure(
    lab: &Lab,
    seconds: f64,
    (bench, variant, edit): (&Bench, Variant, &Edit),
    [groups, rounds]: [u32; 2],
) -> bool {
    let Variant { int64, checked, workgroup } = variant;
    if workgroup > lab.most_invocations {
        return true;
    }
    let (text, _) = bench.launch.shader(bench.histogram, variant);
    let Some(text) = (edit.apply)(&text, int64) else { return true };
    let started = Instant::now();
    let kernel = Kernel::new(lab, &text, bench, variant, [groups, rounds]);
    let compiled = started.elapsed().as_secs_f64();
    let trials = kernel.trials;
    let same = (edit.keeps_sums && trials * bench.launch.steps() <= COMPARED)
        .then(|| kernel.tallies() == reference(bench, trials));
    let best = kernel.best(seconds);
    let rate = trials as f64 / best;
    let Bench { name, launch, histogram } = bench;
    let verdict = same.map_or("", |same| if same { "same" } else { "DIFFERENT" });
    eprintln!(
        "{name:18} histogram {histogram:5} int64 {int64:5} checked {checked:5} workgroup {workgroup:4} groups {groups:7} \
         rounds {rounds:5} {:46} {:10.4} G trials/s {verdict}",
        edit.name,
        rate / 1e9
    );
    emit(&json!({
        "part": "kernel", "bench": name, "estimates": launch.sampled().estimates(), "steps": launch.steps(),
        "histogram": histogram, "int64": int64, "checked": checked, "workgroup": workgroup, "groups": groups,
        "rounds": rounds, "edit": edit.name, "same": same, "seconds": best, "trials_per_second": rate,
        "stamps": lab.has_stamps, "compile_seconds": compiled,
    }));
    same != Some(false)
}
