//! Simulated records of a fit: what its estimates would have been in other records of the same gyro.

use crate::device::cpu::Cpu;
use crate::fit::coefficient::Fit;
use crate::fit::curve::Curve;
use crate::key::refusal::Refusal;
use crate::kinds::allan::lower::{Asked, Records};
use crate::tally::id::Id;
use crate::theory::allan::estimator::{Estimator, Stride};
use crate::theory::allan::process::Process;

/// Fewest realisations whose 2.5 % quantiles are worth anything: the fifth of them from the end.
pub const LEAST_REALISATIONS: usize = 200;

/// Differences of the angle are taken this part of τ apart, which loses next to nothing of all of them.
const STRIDE: Stride = Stride::Part(64);

/// A term that adds less than this part to every point of the curve is left out: what it does cannot be seen, and the
/// kernel refuses what is too small beside the rest.
const SEEN: f64 = 1e-6;

/// The curves of `count` simulated records of a fit, one a row: records as long as that of the curve, at its averaging
/// factors.
///
/// Every random number is determined by the fitted curve and the number of the record, so that the same record has the
/// same realisations on every machine, and more of them go on from the first. `progress` hears of records as they are
/// done.
///
/// # Errors
/// A fit that cannot be represented in the kernel's fixed point: see [`Refusal`].
pub fn realisations(
    cpu: &Cpu,
    curve: &Curve,
    fit: &Fit,
    count: usize,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Vec<f64>>, Refusal> {
    let process = seen(&fit.process, curve);
    let records = Records::new(&Asked {
        process: &process,
        readout_lsb: 0.0,
        mean_rate: 0.0,
        switching: None,
        samples: curve.samples(),
        estimator: Estimator { difference: curve.difference(), stride: STRIDE },
        ms: curve.ms(),
        key: key(curve),
    })?;
    let sums = cpu.sums(records.recipe(), 0, count, progress);
    Ok(sums.chunks_exact(records.recipe().places()).map(|sums| records.variances(sums)).collect())
}

/// The parts of a process that a curve shows.
fn seen(process: &Process, curve: &Curve) -> Process {
    let estimator = Estimator { difference: curve.difference(), stride: Stride::Sample };
    let at = |process: &Process, m: u64| process.expected(estimator, curve.samples(), m).unwrap_or(0.0);
    let is_seen = |part: &&_| {
        let alone = Process { sample_s: process.sample_s, parts: vec![**part] };
        curve.ms().iter().any(|&m| at(&alone, m) > SEEN * at(process, m))
    };
    Process { sample_s: process.sample_s, parts: process.parts.iter().filter(is_seen).copied().collect() }
}

/// Of all that is known of the record.
fn key(curve: &Curve) -> [u32; 2] {
    let numbers = core::iter::once(curve.sample_s()).chain(curve.variances().iter().copied());
    let words = numbers.map(f64::to_bits).chain([curve.samples()]).chain(curve.ms().iter().copied());
    Id::of_words(words.flat_map(|word| [word as u32, (word >> 32) as u32])).key()
}
