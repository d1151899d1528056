//! Notches of curves over the averaging time.
//!
//! A deterministic part of the angle, such as a sine or an alternating drift, cancels where the averaging time is an even
//! multiple of its period. The curve dips there to values that say nothing of its course, and whether a grid of averaging
//! times meets such a place is a coincidence.

use sagnac_base::table::{Column, Usual};

/// The part of both values beside it that a notch stays below.
const DEPTH: f64 = 0.5;

/// Power of the averaging time that is steeper than any course of σ(τ), whose slopes are ±1 at most.
const STEEP: f64 = 1.5;

/// The averaging times at which a curve of some has a notch. All curves leave them out, so that they are compared at the same
/// averaging times.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Notches {
    places: Vec<f64>,
}

impl Notches {
    /// The notches of curves of `y` over `x`, each with its rows by rising x. There are none over other abscissas than the
    /// averaging time.
    pub(crate) fn new<'r>(x: &Column, y: &Column, curves: impl Iterator<Item = &'r [usize]>) -> Notches {
        if x.usual != Some(Usual::Abscissa) {
            return Notches::default();
        }
        let at = |row: usize| [x.value(row), y.value(row).abs()];
        let is_notch = |three: &&[usize]| {
            let [before, here, after] = [three[0], three[1], three[2]].map(at);
            let is_below = |beside: [f64; 2]| {
                let step = libm::fabs(libm::log(beside[0] / here[0]));
                here[1] < beside[1] * DEPTH.min(libm::exp(-STEEP * step))
            };
            is_below(before) && is_below(after)
        };
        let places = curves.flat_map(|rows| rows.windows(3).filter(is_notch).map(|three| x.value(three[1])));
        Notches { places: places.collect() }
    }

    /// Whether there are any.
    pub(crate) fn are_any(&self) -> bool {
        !self.places.is_empty()
    }

    /// Whether a curve has a notch at this averaging time.
    pub(crate) fn are_at(&self, x: f64) -> bool {
        self.places.contains(&x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_base::table::Cell;

    /// The notches of curves over 1, 2, 4, … s.
    fn notches<const N: usize>(curves: &[[f64; N]], usual: Option<Usual>) -> Vec<f64> {
        let column = |cells: Vec<f64>| Column {
            usual,
            cells: cells.into_iter().map(Cell::Number).collect::<Vec<_>>().into(),
            ..Column::default()
        };
        let x = column(curves.iter().flat_map(|_| (0..N).map(|at| f64::from(1 << at))).collect());
        let rows: Vec<Vec<usize>> =
            (0..curves.len()).map(|curve| (curve * N..(curve + 1) * N).collect()).collect();
        Notches::new(&x, &column(curves.concat()), rows.iter().map(Vec::as_slice)).places
    }

    #[test]
    fn a_dip_that_no_slope_leads_to_is_a_notch_and_a_valley_is_none() {
        let time = Some(Usual::Abscissa);
        // At 1, 2, 4, … s, with slopes of ±1, a dip, and one at the last place but one.
        let valley = [8.0, 4.0, 2.0, 1.0, 2.0, 4.0, 8.0];
        assert_eq!(notches(&[valley], time), [0.0; 0]);
        let dips = [9.0, 8.0, 7.0, 0.1, 5.0, 1.0, 4.5];
        assert_eq!(notches(&[valley, dips], time), [8.0, 32.0]);
        assert_eq!(notches(&[dips], None), [0.0; 0]);
        // The ends of a curve are no notches.
        assert_eq!(notches(&[[0.1, 9.0, 8.0, 7.0, 0.1]], time), [0.0; 0]);
    }
}
