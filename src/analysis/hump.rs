//! Whether the spectrum of a record has the quantisation noise that a fit to its Allan curve finds.
//!
//! At the octaves of τ, a line, a hump or its alias makes a curve fall as 1/τ, as quantisation noise does. Quantisation noise
//! has its highest density at half the sampling rate, and there a line or hump at lower frequencies adds nothing.

use crate::allan::Angles;
use crate::fit::Fit;
use crate::spectrum::{Density, Floor, Welch, lines};
use crate::theory::allan::{Process, Term};

/// Part of the density of the quantisation noise that the spectrum must have.
const PART: f64 = 0.5;

/// Whether the density of a record above a third of its sampling rate is, with its 95 % interval, below half of the quantisation
/// noise of a fit to its whole Allan curve. The density is a median, which lines there do not change.
pub(crate) fn is_hump(angles: &Angles, fit: &Fit) -> bool {
    let lacks = || {
        let density = Density::of(angles, &Welch::default()).ok()?;
        let places = density.segment / 3..density.segment.div_ceil(2) - 1;
        let points = &density.points[places.clone()];
        let rest = fit.process.parts.iter().copied().filter(|part| part.term != Term::Quantisation);
        let rest = Process { parts: rest.collect(), ..fit.process };
        let expected = |process: &Process| {
            let densities = points.iter().filter_map(|point| process.density(point.frequency_hz));
            densities.sum::<f64>() / points.len() as f64
        };
        let (with, without) = (expected(&fit.process), expected(&rest));
        let found = Floor::over(&density, &lines(&density), places)?;
        Some(found.interval.1 < without + PART * (with - without))
    };
    fit.tau_range[0] <= 1.01 * angles.step_s && lacks().unwrap_or(false)
}
