//! Fillers: the ways to fill the gap.

pub mod closed;
pub mod keys;
pub(crate) mod read;
pub mod specification;
pub mod ticks;

use std::sync::Arc;

use crate::filler::closed::{CLOSED, Closed};
use crate::filler::specification::Specification;
use sagnac_theory::minimum_variance::Band;

/// The key of a study that lists its fillers.
pub const FILLERS: &str = "switching.fillers";

/// A way to fill the gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Filler {
    /// Name in tables and charts, unique in a study.
    pub name: String,
    /// Method that gives its weights.
    pub method: Method,
}

/// The method by which a filler weights its ticks.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// Exact weights that follow from the ticks and the gap.
    Closed(&'static Closed),
    /// The least variance for the study's noise and for a motion.
    MinimumVariance(Target),
    /// Given weights, in the order of the ticks.
    Weights {
        /// Weights for the gap as a whole, after it.
        residual: Vec<f64>,
        /// Weights for the gap as a whole, before it is closed; may be absent.
        extrapolation: Option<Vec<f64>>,
    },
}

/// The motion for which a filler of least variance is designed.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// The motion of the point itself.
    Own,
    /// The rms rate of the point, spread evenly over a band.
    Band(Band),
    /// The specification of the study.
    Specification(Arc<Specification>),
}

impl Target {
    /// The target of a filler with a band, or without one in a study that may have a specification.
    pub fn of(band: Option<Band>, specification: Option<&Arc<Specification>>) -> Target {
        match (band, specification) {
            (Some(band), _) => Target::Band(band),
            (None, Some(specification)) => Target::Specification(specification.clone()),
            (None, None) => Target::Own,
        }
    }
}

/// The ticks that a filler reads at a point, ascending.
#[derive(Debug, Clone, PartialEq)]
pub struct Fill {
    /// Ticks of the residual.
    pub fit_ticks: Vec<i32>,
    /// Ticks of the extrapolation, none after 0; absent where the filler has none.
    pub extrapolation_ticks: Option<Vec<i32>>,
}

impl Filler {
    /// A filler with exact weights under its standard name.
    pub fn closed(closed: &'static Closed) -> Filler {
        Filler { name: closed.name.to_owned(), method: Method::Closed(closed) }
    }

    /// The polynomials of order 0, 1 and 2 under their standard names.
    pub fn polynomials() -> Vec<Filler> {
        CLOSED.iter().filter(|closed| closed.order.is_some()).map(Filler::closed).collect()
    }

    /// The polynomial of an order up to 2 under its standard name.
    pub fn polynomial(order: usize) -> Filler {
        Filler::polynomials().swap_remove(order)
    }

    /// Fewest ticks with which the filler works.
    pub(crate) fn least_ticks(&self) -> usize {
        match self.method {
            Method::Closed(closed) => closed.least_ticks,
            Method::MinimumVariance(_) | Method::Weights { .. } => 1,
        }
    }
}
