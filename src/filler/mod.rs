//! Fillers: ways to fill the gap, as a study names them.

pub mod keys;
pub mod read;
pub mod ticks;

use crate::theory::minimum_variance::Band;

/// The key of a study that lists its fillers.
pub const FILLERS: &str = "switching.fillers";

/// A way to fill the gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Filler {
    /// As tables and charts call it; unique in a study.
    pub name: String,
    /// Where its weights come from.
    pub method: Method,
}

/// How a filler weighs its ticks.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// The least-squares polynomial of order 0, 1 or 2.
    Polynomial(usize),
    /// The least variance for motion of a band, or for the study's own motion where none is given, and its noise.
    MinimumVariance(Option<Band>),
    /// Weights as given, in the order of the ticks; those of the extrapolation may be absent.
    Weights {
        /// For the gap as a whole, after it.
        residual: Vec<f64>,
        /// The same before it is closed.
        extrapolation: Option<Vec<f64>>,
    },
}

/// The ticks that a filler reads at a point, ascending.
#[derive(Debug, Clone, PartialEq)]
pub struct Fill {
    /// For the residual.
    pub fit_ticks: Vec<i32>,
    /// For the extrapolation: none after 0. Absent where the filler has none.
    pub extrapolation_ticks: Option<Vec<i32>>,
}

/// Names of the polynomials, by order.
pub const POLYNOMIALS: [&str; 3] = ["const", "linear", "quadratic"];

impl Filler {
    /// The polynomials of order 0, 1 and 2 under their own names.
    pub fn polynomials() -> Vec<Filler> {
        (0..POLYNOMIALS.len()).map(Filler::polynomial).collect()
    }

    /// The polynomial of an order up to 2 under its own name.
    pub fn polynomial(order: usize) -> Filler {
        Filler { name: POLYNOMIALS[order].to_owned(), method: Method::Polynomial(order) }
    }

    /// Fewest ticks that it can work with.
    pub(crate) fn least_ticks(&self) -> usize {
        match self.method {
            Method::Polynomial(order) => order + 1,
            Method::MinimumVariance(_) | Method::Weights { .. } => 1,
        }
    }
}
