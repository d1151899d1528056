//! The parts of the errors of a navigator.

use crate::kinds::navigation::point::{Inputs, Point};
use crate::noise::{Noise, Switching};
use crate::study::part::{self, Part};
use crate::theory::allan::terms::Term;

/// The parts besides the terms of the noise.
static OTHERS: [Part<Noise>; 3] = [
    Part { name: "lock-in", off: |noise| noise.lock_in = None },
    Part {
        name: "magnetic drift of the modes",
        off: |noise| {
            switched(noise, |switching| Switching { magnetic: 0.0, initial_magnetic: 0.0, ..switching })
        },
    },
    Part {
        name: "fill residuals",
        off: |noise| {
            switched(noise, |switching| Switching { residual: 0.0, residual_noise: 0.0, ..switching })
        },
    },
];

/// Changes the switching, where there is some.
fn switched(noise: &mut Noise, change: impl Fn(Switching) -> Switching) {
    noise.switching = noise.switching.map(change);
}

/// A point as it is, and without each term of its noise and each other part in turn.
pub(crate) fn dissected(point: &Point) -> (Vec<&'static str>, Vec<Point>) {
    let noise = &point.inputs.noise;
    let (mut names, mut noises) = part::points(noise, &OTHERS);
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
