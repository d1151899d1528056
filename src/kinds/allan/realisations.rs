//! Simulated records of a fit: its estimates in other records of the same gyro.

use crate::device::cpu::Cpu;
use crate::fit::coefficient::Fit;
use crate::fit::curve::Curve;
use crate::key::refusal::Refusal;
use crate::kinds::allan::lower::{Asked, Records};
use crate::tally::id::Id;
use crate::theory::allan::estimator::{Estimator, Stride};
use crate::theory::allan::process::Process;

/// Least number of realisations with usable 2.5 % quantiles: the fifth value from each end.
pub const LEAST_REALISATIONS: usize = 200;

/// Differences of the angle are spaced by this part of τ, with almost no loss of precision.
const STRIDE: Stride = Stride::Part(64);

/// A term that adds less than this fraction to every point of the curve is omitted: its effect is invisible, and the
/// kernel refuses terms that are too small relative to the others.
const SEEN: f64 = 1e-6;

/// The curves of `count` simulated records of a fit, one per row. The records have the length and the averaging factors
/// of the fitted curve.
///
/// Every random number is determined by the fitted curve and the number of the record, so the same record has the same
/// realisations on every machine, and a larger count extends the same sequence. `progress` receives the number of
/// completed records.
///
/// # Errors
/// The fit cannot be represented in the kernel's fixed point: see [`Refusal`].
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

/// The parts of a process that have a visible effect on a curve.
fn seen(process: &Process, curve: &Curve) -> Process {
    let estimator = Estimator { difference: curve.difference(), stride: Stride::Sample };
    let at = |process: &Process, m: u64| process.expected(estimator, curve.samples(), m).unwrap_or(0.0);
    let is_seen = |part: &&_| {
        let alone = Process { sample_s: process.sample_s, parts: vec![**part] };
        curve.ms().iter().any(|&m| at(&alone, m) > SEEN * at(process, m))
    };
    Process { sample_s: process.sample_s, parts: process.parts.iter().filter(is_seen).copied().collect() }
}

/// The key of the random numbers, from all that is known of the record.
fn key(curve: &Curve) -> [u32; 2] {
    let numbers = core::iter::once(curve.sample_s()).chain(curve.variances().iter().copied());
    let words = numbers.map(f64::to_bits).chain([curve.samples()]).chain(curve.ms().iter().copied());
    Id::of_words(words.flat_map(|word| [word as u32, (word >> 32) as u32])).key()
}
