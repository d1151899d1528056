//! Whether the spectrum of a record has the quantization noise that a fit to its Allan curve finds.
//!
//! At the octaves of τ, a line, a hump or its alias makes a curve fall as 1/τ, as quantization noise does. Quantization noise
//! has its highest density at half the sampling rate, and there a line or hump at lower frequencies adds nothing. Only pulses
//! that are larger than the noise of a sample have quantization errors that depend on each other from sample to sample; their
//! density is another one, and Q is not tested.

use sagnac_records::allan::Angles;
use sagnac_records::events::Events;
use sagnac_records::fit::Fit;
use sagnac_records::spectrum::{Density, Floor, Welch, lines};
use sagnac_theory::allan::{Part, Process, Term};

/// Part of the density of the quantization noise that the spectrum must have.
const PART: f64 = 0.5;

/// Whether the density of a record above a third of its sampling rate is, with its 95 % interval, below half of that of the
/// quantization noise of a fit, beside the other noise. If the fit leaves out the shortest τ, where a filter may lower the other
/// noise, that counts as none. The density is a median, which lines do not change.
pub(crate) fn is_hump(events: &Events, fit: &Fit) -> bool {
    let angles: &Angles = &events.without;
    let lacks = || {
        let density = Density::of(angles, &Welch::default()).ok()?;
        let places = density.segment / 3..density.segment.div_ceil(2) - 1;
        let points = &density.points[places.clone()];
        let expected = |is_meant: fn(&Part) -> bool| {
            let parts = fit.process.parts.iter().copied().filter(is_meant).collect();
            let process = Process { parts, ..fit.process };
            let densities = points.iter().filter_map(|point| process.density(point.frequency_hz));
            densities.sum::<f64>() / points.len() as f64
        };
        let is_whole = fit.tau_range[0] <= 1.01 * angles.step_s;
        let other = if is_whole { expected(|part| part.term != Term::Quantization) } else { 0.0 };
        let found = Floor::over(&density, &lines(&density), places)?;
        Some(found.interval.1 < other + PART * expected(|part| part.term == Term::Quantization))
    };
    !events.is_coarse && lacks().unwrap_or(false)
}
