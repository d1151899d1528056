//! The results of a fit for a term: its coefficient, and its time or frequency.

use crate::allan::Unit;
use crate::fit::Coefficient;
use sagnac_theory::allan::Term;
use sagnac_theory::allan::terms::Shape;

/// A number that a fit determines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Coefficient, in the unit of the [`Term`].
    Coefficient(Term),
    /// The correlation time of Markov noise, s, or the frequency of a sine, Hz.
    Shape(Term),
}

impl Quantity {
    /// The coefficients of some terms, each followed by its time or frequency.
    pub fn all(terms: &[Term]) -> Vec<Quantity> {
        let of_term = |&term: &Term| {
            let shape = term.has_shape().then_some(Quantity::Shape(term));
            [Some(Quantity::Coefficient(term)), shape].into_iter().flatten()
        };
        terms.iter().flat_map(of_term).collect()
    }

    /// The term, with the row of its shape if this is a shape.
    pub fn parts(self) -> (Term, Option<&'static Shape>) {
        match self {
            Quantity::Coefficient(term) => (term, None),
            Quantity::Shape(term) => (term, term.shape()),
        }
    }

    /// Name in tables of coefficients.
    pub fn name(self) -> &'static str {
        let (term, shape) = self.parts();
        shape.map_or(term.symbol(), |shape| shape.symbol)
    }

    /// Name for people, on the data sheet of a sensor whose curves have this unit.
    pub fn title(self, unit: Unit) -> &'static str {
        let (term, shape) = self.parts();
        match (shape, unit) {
            (Some(shape), _) => shape.title,
            (None, Unit::Acceleration) => term.row().title_of_acceleration.unwrap_or(term.row().title),
            (None, Unit::Angular | Unit::Plain) => term.row().title,
        }
    }

    /// Factor from ″ and s, or from µg and s, to the unit of data sheets, that unit in files, and its symbol. Plain numbers
    /// keep their unit, times a power of s.
    pub fn unit(self, unit: Unit) -> (f64, &'static str, &'static str) {
        let (term, shape) = self.parts();
        let (in_files, symbol) = term.row().plain;
        match (shape, unit) {
            (Some(shape), _) => (1.0, shape.unit, shape.unit),
            (None, Unit::Angular) => term.row().unit,
            (None, Unit::Acceleration) => term.row().unit_of_acceleration,
            (None, Unit::Plain) => (1.0, in_files, symbol),
        }
    }

    /// Value and interval of a fitted coefficient or its shape, in ″ and s.
    pub fn of(self, found: &Coefficient) -> (Option<f64>, Option<[f64; 2]>) {
        match self {
            Quantity::Coefficient(_) => (found.value, found.interval),
            Quantity::Shape(_) => {
                (found.shape.map(|shape| shape.value), found.shape.map(|shape| shape.interval))
            }
        }
    }
}
