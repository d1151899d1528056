//! The parts of the errors of a navigator.

use crate::kinds::navigation::point::{Inputs, Point};
use crate::noise::{Noise, Switching};
use crate::study::Part;
use sagnac_theory::allan::terms::Term;

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

/// What a point lacks of its noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lack {
    /// One of the terms.
    Term(Term),
    /// One of the other parts, by its place.
    Other(usize),
}

impl Lack {
    /// The noise without what is lacking.
    pub(crate) fn of(self, mut noise: Noise) -> Noise {
        match self {
            Lack::Term(term) => noise.without(term),
            Lack::Other(place) => {
                (OTHERS[place].off)(&mut noise);
                noise
            }
        }
    }
}

/// A point as it is, and without each other part and each term of its noise in turn. A point remembers what it lacks, because
/// swept and drawn coefficients are set anew for each set.
pub(crate) fn dissected(point: &Point) -> (Vec<&'static str>, Vec<Point>) {
    let noise = &point.inputs.noise;
    let others = OTHERS.iter().enumerate().map(|(place, part)| (part.name, Lack::Other(place)));
    let has = |term: &Term| noise.has(*term);
    let terms = Term::EVERY.into_iter().filter(has).map(|term| (term.row().name[1], Lack::Term(term)));
    let (mut names, mut points) = (vec![], vec![point.clone()]);
    for (name, lack) in others.chain(terms) {
        let without = lack.of(noise.clone());
        // An angle random walk by lock-in alone is the part above.
        if without != *noise {
            names.push(name);
            let inputs = Inputs { noise: without, ..point.inputs.clone() };
            points.push(Point { inputs, lack: Some(lack), ..point.clone() });
        }
    }
    (names, points)
}
