//! Studies of Allan curves: the record, its noise and its estimates.

pub mod columns;
pub(crate) mod estimate;
pub mod keys;
pub(crate) mod kind;
pub mod lower;
pub(crate) mod notes;
pub(crate) mod parts;
pub(crate) mod point;
pub mod realizations;
pub(crate) mod run;
pub mod verify;

pub use crate::kinds::allan::point::{Inputs, Point};

use crate::key::row::{Key, Reading};
use crate::key::sweep;
use crate::noise::{self, FILE, Noise, WrittenNoise, swept_files};
use sagnac_base::source::diagnose::Wrong;
use sagnac_records::fit::choose::Terms;
use sagnac_theory::allan::estimator::Estimator;
use sagnac_theory::allan::terms::Term;

/// The part of a study that is specific to Allan curves.
#[derive(Debug, Clone)]
pub struct Allan {
    /// Order and spacing of the differences.
    pub estimator: Estimator,
    /// The terms fitted to each record, if any.
    pub terms: Option<Terms>,
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<Point>,
}

/// Every key of this kind.
pub(crate) fn keys() -> Vec<&'static Key> {
    [keys::KEYS, keys::CURVE_KEYS, noise::KEYS].concat()
}

/// The keys that can be swept.
pub(crate) fn sweepable() -> Vec<&'static Key> {
    sweep::keys(&keys::SETTINGS).chain(sweep::keys(&noise::SETTINGS)).chain([&FILE]).collect()
}

/// Reads the part of a study that belongs to this kind.
pub(crate) fn read(reading: &mut Reading) -> Result<Allan, Wrong> {
    let mut inputs = Inputs { sample_s: 0.0, length_s: 0.0, rate: 0.0, noise: Noise::default() };
    reading.set(&mut inputs, &keys::SETTINGS)?;
    let WrittenNoise { noise, written } = noise::read(reading)?;
    reading.note(&[&keys::ALLAN, &keys::TAU]);
    let estimate = estimate::read(&reading.table)?;
    let files = swept_files(reading, &written)?;
    let base = point::Base {
        inputs: Inputs { noise, ..inputs },
        files,
        places: &reading.places,
        sweeps: reading.sweeps,
        estimate: &estimate,
    };
    base.check_sweeps()?;
    noise::check_switching(base.noises(), &reading.places, reading.sweeps)?;
    let points = base.points()?;
    let terms = estimate.terms.map(|terms| with_shapes(terms, &points));
    reading.notes.extend(notes::of(terms.as_ref(), &points));
    Ok(Allan { estimator: estimate.estimator, terms, points })
}

/// Lets a fit that chooses its terms choose Markov noise and a sine where the noise has them.
fn with_shapes(terms: Terms, points: &[Point]) -> Terms {
    let Terms::Auto(mut terms) = terms else { return terms };
    let is_there = |term: &Term| points.iter().any(|point| point.inputs.noise.has(*term));
    terms.extend(Term::ALL.into_iter().filter(|term| term.has_shape() && is_there(term)));
    Terms::Auto(terms)
}
