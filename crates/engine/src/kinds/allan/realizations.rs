//! Simulated records of a fit: its estimates in other records of the same gyro.

use crate::device::Cpu;
use crate::key::row::Refusal;
use crate::kinds::allan::lower::{Asked, Records};
use crate::tally::Id;
use sagnac_records::fit::coefficient::Fit;
use sagnac_records::fit::curve::Curve;
use sagnac_theory::allan::estimator::{Estimator, Stride};
use sagnac_theory::allan::part::Part;
use sagnac_theory::allan::process::Process;
use sagnac_theory::allan::terms::Term;

/// Least number of realizations with usable 2.5 % quantiles: the fifth value from each end.
pub const MIN_REALIZATIONS: usize = 200;

/// Differences of the angle are spaced by this part of τ, with almost no loss of precision.
const STRIDE: Stride = Stride::Part(64);

/// A term that adds less than this fraction to every point of the curve is omitted: its effect is invisible, and the
/// kernel refuses terms that are too small relative to the others.
const SEEN: f64 = 1e-6;

/// The curves of `count` simulated records of a fit, one per row. The records have the length and the averaging factors
/// of the fitted curve.
///
/// Every random number is determined by the fitted curve and the number of the record, so the same record has the same
/// realizations on every machine, and a larger count extends the same sequence. `progress` receives the number of
/// completed records.
///
/// # Errors
/// The fit cannot be represented in the kernel's fixed point: see [`Refusal`].
pub fn realizations(
    cpu: &Cpu,
    curve: &Curve,
    fit: &Fit,
    count: usize,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Vec<f64>>, Refusal> {
    let process = seen(&without_band_limit(&fit.process), curve);
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

/// The process with its angle random walk N and band limit L as Markov noise, which is white noise through a first-order
/// low-pass: r_k = a·r_{k−1} + … of the same density at rest and, beyond its memory, the same variance.
///
/// The sum of its rates lacks 2a/(1 − a²) samples of N²t0, where white noise and L lack e = 2L²/N²t0.
fn without_band_limit(process: &Process) -> Process {
    let square = |term: Term| process.parts.iter().find(|part| part.term == term).map(Part::square);
    let known = square(Term::BandLimit).zip(square(Term::AngleRandomWalk));
    let mut parts: Vec<Part> =
        process.parts.iter().filter(|part| part.term != Term::BandLimit).copied().collect();
    if let Some((limit, white)) = known {
        let t0 = process.sample_s;
        let e = 2.0 * limit / (white * t0);
        let a = (libm::sqrt(1.0 + e * e) - 1.0) / e;
        let time_s = -t0 / libm::log(a);
        let sigma = libm::sqrt(white / t0 * (1.0 - a) / (1.0 + a));
        parts.retain(|part| part.term != Term::AngleRandomWalk);
        parts.push(Part::markov(sigma * libm::sqrt(2.0 / time_s), time_s));
    }
    Process { sample_s: process.sample_s, parts }
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
