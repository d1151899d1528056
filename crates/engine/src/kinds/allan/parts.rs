//! The parts of the noise of a record.

use crate::kinds::allan::point::{Inputs, Point};
use crate::noise::Noise;
use crate::study::{self, Part};
use sagnac_theory::allan::terms::Term;

/// The parts besides the terms of the noise.
static OTHERS: [Part<Noise>; 3] = [
    Part { name: "lock-in", off: |noise| noise.lock_in = None },
    Part { name: "whole pulses of the readout", off: |noise| noise.readout_lsb = 0.0 },
    Part { name: "mode switches", off: |noise| noise.switching = None },
];

/// A point as it is, and without each term of its noise and each other part in turn.
pub(crate) fn dissected(point: &Point) -> (Vec<&'static str>, Vec<Point>) {
    let noise = &point.inputs.noise;
    let (mut names, mut noises) = study::points(noise, &OTHERS);
    for term in Term::EVERY.into_iter().filter(|term| noise.has(*term)) {
        let without = noise.without(term);
        // An angle random walk by lock-in alone is the part above.
        if without != *noise {
            names.push(term.row().name[1]);
            noises.push(without);
        }
    }
    let with = |noise| Point { inputs: Inputs { noise, ..point.inputs.clone() }, ..point.clone() };
    (names, noises.into_iter().map(with).collect())
}
